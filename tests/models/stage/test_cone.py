"""Conical walls under contact nodes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from solid_meshes import STEEL, cantilever

import bladewhirl as bw
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.build import steady_problem
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.superelements.superelement import Superelement
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

DEGREES = np.pi / 180.0


def block(folder: Path, stiffness: float = 1e6) -> str:
    """A rigid node of 1 kg on equal springs, at a radius of 0.3 m."""
    part = Superelement(
        mass=np.eye(3),
        stiffness=stiffness * np.eye(3),
        contact_position=np.array([[0.3, 0.0, 0.05]]),
        contact_dofs=np.array([[0, 1, 2]]),
    )
    file = folder / "block.npz"
    bw.write_superelement(file, part)
    return str(file)


def case(file: str, **tables: Any) -> bw.Case:
    casing = {"type": "rigid", "clearance": "1 mm"} | tables.pop("casing", {})
    given = {
        "bladed_disk": {"superelement": {"file": file, "copies": 1}},
        "casing": casing,
        "reduction": {"boundary": "consistent"},
        "shaft": {"clamped": True},
        "march": {"speed": "100 rad/s", "time_step": "1 us", "duration": "1 ms"},
    }
    return bw.case_from(given | tables)


@pytest.mark.parametrize("slope", [3.0, -20.0])
def test_a_node_that_slides_along_the_axis_meets_the_wall_by_the_sine(
    slope: float, tmp_path: Path
) -> None:
    """A node pushed along the axis by s towards the smaller radius penetrates the wall by s sin
    slope."""
    given = case(block(tmp_path), casing={"clearance": "1 mm", "slope": f"{slope} deg"})
    problem = steady_problem(build_matrices(given))
    b, moved = slope * DEGREES, -np.sign(slope) * 0.4e-3
    normal = problem.rotor.tip_radial @ np.linalg.pinv(
        build_matrices(given).reduced.contact
    )  # of displacements along e_r, e_theta and e_z
    assert normal[0] == pytest.approx([np.cos(b), 0.0, -np.sin(b)], abs=1e-12)
    gap = problem.initial_gap()[0] - normal[0] @ [0.0, 0.0, moved]
    assert gap == pytest.approx(np.cos(b) * 1e-3 - 0.4e-3 * np.sin(abs(b)), rel=1e-12)


@pytest.mark.parametrize("slope", [-3.0, 3.0])
def test_the_force_of_a_cone_is_normal_to_it(slope: float, tmp_path: Path) -> None:
    """The wall closes slowly onto the node; without friction the force is along e_n, and the
    static displacements are the force over the stiffness."""
    given = case(
        block(tmp_path, 1e8),
        casing={
            "clearance": "0.1 mm",
            "slope": f"{slope} deg",
            "closure": {"table": [[0, 0], ["20 ms", "0.3 mm"]]},
        },
        contact={"friction": 0.0},
        damping={"ratio": 0.2, "boundary_ratio": 0.2},
        march={"speed": "100 rad/s", "time_step": "1 us", "duration": "30 ms"},
    )
    result = march_in_memory(prepare(given))[0]
    force = result["contact_force"].values[-1, 0]
    moved = result["contact_displacement"].values[-1, 0]
    b = slope * DEGREES
    assert force == pytest.approx(force[0] / np.cos(b) * np.array([np.cos(b), 0, -np.sin(b)]))
    assert moved == pytest.approx(force / 1e8, rel=1e-3, abs=1e-9)
    assert moved[0] - np.tan(b) * moved[2] == pytest.approx(-0.2e-3, rel=1e-6)


def test_without_a_slope_the_march_is_that_of_a_cylinder(tmp_path: Path) -> None:
    part = bw.mesh3d(cantilever("hexahedron20", (3, 1, 1)), **STEEL, contacts=3)
    bw.write_superelement(tmp_path / "blade.npz", part)
    histories: list[Any] = []
    walls: tuple[dict[str, Any], ...] = ({}, {"slope": 0}, {"slope": 1e-11}, {"slope": "2 deg"})
    for casing in walls:
        lobes = {"clearance": "50 um", "clearance_lobes": [{"lobes": 2, "amplitude": "55 um"}]}
        given = case(
            str(tmp_path / "blade.npz"),
            casing=lobes | casing,
            reduction={"free_interface_modes": 8},
            march={"speed": "1000 rad/s", "time_step": "0.2 us", "duration": "5 ms"},
        )
        result = march_in_memory(prepare(given))[0]
        histories.append(result["contact_displacement"].values)
    size = np.abs(histories[0]).max()
    assert np.array_equal(histories[0], histories[1])
    assert np.abs(histories[2] - histories[0]).max() < 1e-6 * size
    assert np.abs(histories[3] - histories[0]).max() > 1e-3 * size


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"slope": "31 deg"}, "casing.slope = .31 deg.: expected from -30 to 30 deg"),
        ({"slope": "nan"}, "casing.slope"),
    ],
)
def test_a_slope_is_limited(tables: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=message):
        case(block(tmp_path), casing=tables)


STRAIGHT = [["-20 mm", "0.3 m"], ["20 mm", f"{0.3 + 0.04 * np.tan(4 * DEGREES)} m"]]


def rubbing(folder: Path, **casing: Any) -> bw.Case:
    """Two blades in an oval wall that closes."""
    part = bw.mesh3d(cantilever("hexahedron20", (3, 1, 1)), **STEEL, contacts=3)
    bw.write_superelement(folder / "blade.npz", part)
    wall = {
        "clearance": "50 um",
        "clearance_lobes": [{"lobes": 2, "amplitude": "30 um"}],
        "closure": {
            "table": [[0, 0], ["1 ms", "35 um"]],
            "lobes": [{"lobes": 2, "amplitude": "5 um"}],
        },
    }
    return case(
        str(folder / "blade.npz"),
        bladed_disk={"superelement": {"file": str(folder / "blade.npz"), "copies": 2}},
        casing=wall | casing,
        reduction={"free_interface_modes": 8},
        march={"speed": "1000 rad/s", "time_step": "0.2 us", "duration": "5 ms"},
    )


@pytest.mark.parametrize(
    "coating",
    [{}, {"coating": {"thickness": "20 um", "young_modulus": "100 MPa", "yield_stress": "2 MPa"}}],
)
def test_a_straight_contour_is_a_cone(coating: dict[str, Any], tmp_path: Path) -> None:
    """The slope of the nodes instead of that of the wall, with lobes, a closure and a coating."""
    cone, contour = (
        march_in_memory(prepare(rubbing(tmp_path, **coating, **wall)))[0]
        for wall in ({"slope": "4 deg"}, {"contour": STRAIGHT})
    )
    assert cone["contact_impulse"].values.max() > 0.0
    for name in ("contact_force", "contact_displacement", "gap"):
        size = np.abs(cone[name].values).max()
        assert contour[name].values == pytest.approx(cone[name].values, abs=1e-7 * size)


@pytest.mark.slow
def test_periodic_contact_under_a_straight_contour_is_that_of_a_cone(tmp_path: Path) -> None:
    cone, contour = (
        bw.periodic(rubbing(tmp_path, **wall), speeds=["1000 rad/s"])
        for wall in ({"slope": "4 deg"}, {"contour": STRAIGHT})
    )
    expected = cone["impulse_per_revolution"].values
    assert expected > 0.0
    assert contour["impulse_per_revolution"].values == pytest.approx(expected, rel=1e-8)


def test_a_node_has_the_slope_of_its_place(tmp_path: Path) -> None:
    """Between two equal intervals with slopes a and b, the derivative of the monotone cubic
    is 2 a b / (a + b), F. N. Fritsch and J. Butland (1984)."""
    rows = [["0 mm", "0.3 m"], ["50 mm", "0.303 m"], ["100 mm", "0.312 m"]]
    problem = steady_problem(build_matrices(case(block(tmp_path), casing={"contour": rows})))
    b = np.arctan(2 * 0.06 * 0.18 / (0.06 + 0.18))
    assert problem.slope == pytest.approx([b], rel=1e-12)
    assert problem.initial_gap() == pytest.approx([1e-3 * np.cos(b)], rel=1e-12)


@pytest.mark.parametrize(
    ("wall", "message"),
    [
        ({"contour": STRAIGHT, "slope": "2 deg"}, "either a slope or a contour"),
        ({"contour": STRAIGHT, "type": "ring"}, "casing.type = .ring., which has one slope"),
        ({"contour": STRAIGHT[:1]}, "two rows or more"),
        ({"contour": STRAIGHT[::-1]}, "in ascending order"),
        ({"contour": [[0, 0.3], [0.1, 0.4]]}, "from -30 to 30 deg between them"),
        ({"contour": [[0, 0.3], [0.04, 0.31]]}, "rows from 0.05 m to 0.05 m at least"),
    ],
)
def test_a_contour_covers_the_nodes(wall: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=message):
        _ = steady_problem(build_matrices(case(block(tmp_path), casing=wall)))


@pytest.mark.parametrize("key", ["slope", "contour"])
def test_beams_have_no_cone(key: str) -> None:
    with pytest.raises(CaseError, match="tips of beams do not move along the axis"):
        bw.case_from({"casing": {"type": "rigid", key: "2 deg" if key == "slope" else STRAIGHT}})
