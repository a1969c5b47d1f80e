"""Engine-order forces: their places and directions, damped responses, refusals; `verify forced`
compares responses with the march and with closed forms."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from command_line import answer
from exported_stages import Kind, beams, exported
from solid_meshes import SECTORS, STEEL, TIE, bladed_sector

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.engine_order import unit_forces
from bladewhirl.models.stage.forced import forced
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.superelements.mistuned import mistuned_wheel
from bladewhirl.models.superelements.superelement import dense
from bladewhirl.models.superelements.wheel import whole_wheel
from bladewhirl.postprocess.modal.response import amplitude, drawn_amplitudes, plot_response
from bladewhirl.studies.modal.response import engine_orders, report

BLADES = 7
MISTUNED = [1.0, 1.03, 0.98, 1.01, 0.97, 1.02, 0.99]
AMPLITUDE = 2.0  # N


def case(
    order: int | list[int] = 2, *, effects: str = "none", tuned: bool = True, **load: Any
) -> bw.Case:
    blades = {"blades": BLADES, "elements_per_blade": 3}
    mistuning: Any = {} if tuned else {"mistuning": {"stiffness": MISTUNED}}
    return bw.case_from(
        {
            "bladed_disk": blades | mistuning,
            "casing": {"clearance": "50 mm"},
            "damping": {"ratio": 0.2},
            "rotation": {"effects": effects},
            "excitation": {"type": "engine-order", "order": order, "amplitude": AMPLITUDE, **load},
            "march": {"speed": 0.9, "time_step": "4 us"},
        }
    )


def test_rpm_are_turns_in_a_minute() -> None:
    """The reference frequency in turns per second, times sixty."""
    data = bw.response(case(), speeds=[0.25, 0.5])
    turns = 60.0 * data.attrs["reference_frequency_hz"]
    assert data["rpm"].values == pytest.approx([0.25 * turns, 0.5 * turns])
    at = bw.response(case(), speeds=["1234 rpm"])
    assert float(at["rpm"][0]) == pytest.approx(1234.0)


def test_the_response_is_that_of_the_full_model() -> None:
    """With all fixed-interface modes the reduction is a change of coordinates."""
    load: dict[str, Any] = {
        "position": 0.4,
        "direction": "30 deg",
        "phase": 0.3,
        "factors": [2.0, *[0.5] * 6],
    }
    own = case(3, tuned=False, **load)
    stage = build_beams(own)
    structure, disk = stage.disk.structure, stage.disk
    squares, fields = la.eigh(structure.stiffness.toarray(), structure.mass.toarray())
    w = 3.0 * stage.speed
    assert isinstance(own.excitation, EngineOrder)
    factors = np.array(load["factors"]) * np.exp(1j * (3.0 * disk.tip_angles + 0.3))
    force = AMPLITUDE * factors @ unit_forces(own, disk, own.excitation)
    dynamic = squares - w**2 + 2j * 0.2 * np.sqrt(squares) * w
    expected = fields @ ((fields.T @ force) / dynamic)
    data = bw.response(stage).isel(speed=0)
    np.testing.assert_allclose(data["tip_tangential"], expected[disk.tip_tangential], rtol=1e-6)
    np.testing.assert_allclose(data["tip_radial"], expected[disk.tip_radial], rtol=1e-6)
    np.testing.assert_allclose(data["centre"], expected[disk.centre], rtol=1e-6)


def test_excitations_of_a_list_add_up() -> None:
    """Motion is linear without contact; other excitations have other frequencies."""
    one, other = case([2, 3]).excitation, case(3, position=0.5, phase=0.4).excitation
    both = bw.response(bw.with_values(case(), {"excitation": [one, {"type": "imbalance"}, other]}))
    alone = [bw.response(bw.with_values(case(), {"excitation": each})) for each in (one, other)]
    assert both["order"].values.tolist() == [2, 3]
    for name in ("tip_tangential", "tip_radial", "centre"):
        apart = [alone[0][name].sel(order=2), alone[0][name].sel(order=3) + alone[1][name]]
        np.testing.assert_allclose(both[name], apart, rtol=1e-12)


def radial_work(own: bw.Case, field: FloatArray) -> FloatArray:
    stage = build_beams(own)
    assert isinstance(own.excitation, EngineOrder)
    return np.asarray(unit_forces(own, stage.disk, own.excitation) @ field)


@pytest.mark.slow
def test_forces_along_a_blade_have_their_resultant_and_their_place() -> None:
    stage = build_beams(case())
    disk = stage.disk
    radii = np.linalg.norm(disk.mesh.points, axis=1)
    root, tip = radii[disk.mesh.node_sets["roots"]].min(), radii[disk.model.tips].max()
    spin = np.zeros(disk.structure.size)  # a rotation of all blades about the axis
    dofs = disk.structure.node_dofs
    moving = dofs[:, 1] >= 0
    spin[dofs[moving, 1]] = radii[moving]
    spin[dofs[moving, 2]] = 1.0
    for share in (0.0, 0.37, 0.5, 1.0):
        expected = root + share * (tip - root)
        np.testing.assert_allclose(radial_work(case(position=share), spin), expected, rtol=1e-9)
    length, middle = 0.6 * (tip - root), root + 0.5 * (tip - root)
    spread = radial_work(case(position=[0.2, 0.8]), spin)
    np.testing.assert_allclose(spread, length * middle, rtol=1e-9)
    np.testing.assert_allclose(radial_work(case(direction="radial"), spin), 0.0, atol=1e-12)
    by_set = unit_forces(own := case(position="tips"), disk, own.excitation)  # type: ignore[arg-type]
    at_tip = unit_forces(own := case(), disk, own.excitation)  # type: ignore[arg-type]
    np.testing.assert_array_equal(by_set, at_tip)


def test_the_command_writes_a_document_and_a_figure(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(case([2, 3])), encoding="utf-8")
    document = json.loads(answer("response", file, "--json", "--speeds", "0.5:0.9:0.2").stdout)
    data = bw.response(case([2, 3]), speeds=[0.5, 0.7, 0.9])
    real, imaginary = np.moveaxis(np.array(document["tip_tangential"]), -1, 0)
    np.testing.assert_allclose(real + 1j * imaginary, data["tip_tangential"], rtol=1e-9)
    assert [row["nodal_diameter"] for row in document["largest"]] == [2, 3]
    assert len(plot_response(data).axes) == 4


@pytest.mark.parametrize(
    ("load", "expected"),
    [
        ({"position": "nowhere"}, "a node set with one node on each of the 7 blades"),
        ({"position": "centre"}, "centre has 1 nodes"),
        ({"order": 0, "phase": [0.0] * BLADES}, "one number with the engine order 0"),
        ({"factors": [1.0]}, "7 numbers, one for each blade, not 1"),
        ({"position": [0.8, 0.2]}, "two such numbers"),
        ({"order": [2, 2]}, "a list of different ones"),
        ({"amplitude": "2 N/m"}, "a number of zero or more in N"),
        ({"direction": "up"}, '"tangential", "radial" or an angle'),
    ],
)
def test_what_does_not_fit_is_refused(load: dict[str, Any], expected: str) -> None:
    with pytest.raises(bw.CaseError, match=expected.replace("[", r"\[")):
        bw.response(case(**load))


def test_springs_have_no_response() -> None:
    with pytest.raises(bw.UserError, match="springs between bladed disk and casing"):
        bw.response(bw.with_values(case(), {"coupling.stiffness": 1e5}))


def test_a_response_needs_a_speed_at_which_the_bladed_disk_is_stable() -> None:
    with pytest.raises(bw.UserError, match=r"response: speeds \[\]: expected at least one speed"):
        bw.response(case(), speeds=[])
    softened = build_beams(case(effects="centrifugal"))
    with pytest.raises(bw.CaseError, match=r"march.speed = 5.0: expected less than .* critical"):
        bw.response(softened, speeds=[0.5, 5.0])
    turning = build_beams(case(effects="full"))
    with pytest.raises(bw.CaseError, match=r"a speed, unlike 1000\.0, at which blades are stable"):
        bw.response(turning, speeds=[0.5, 1e3])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "effects", "tuned"),
    [
        ("wheel", "none", True),
        ("wheel", "full", False),
        ("sector", "none", True),
        ("blade", "none", False),
    ],
)
def test_a_superelement_responds_as_its_beams(
    tmp_path: Path, kind: Kind, effects: str, *, tuned: bool
) -> None:
    """Mistuned blades of a wheel are in its matrices, those of blades in the case. At speed
    beams take the damping at rest from their modes, and a superelement from all of its modes."""
    load = {"type": "engine-order", "order": [2, 3], "amplitude": 10.0, "phase": 0.4}
    mistuning: dict[str, Any] = {} if tuned else {"mistuning": {"stiffness": MISTUNED[:5]}}
    disk: dict[str, Any] = {"blades": 5, "elements_per_blade": 2}
    disk |= {"disk_kind": "rigid"} if kind == "blade" else {}
    common: dict[str, Any] = {"excitation": load, "rotation": {"effects": effects}}
    modes = {"blade": 2, "wheel": 35 if effects == "full" else 10, "sector": 10}[kind]
    if effects == "full":
        common["reduction"] = {"fixed_interface_modes": modes}
    own = beams(kind, bladed_disk=disk | mistuning, **common)
    of_part = beams(kind, bladed_disk=disk, **common) if kind == "blade" else own
    same = {"boundary": "consistent", "fixed_interface_modes": modes}
    nodes = exported(
        of_part,
        kind,
        tmp_path,
        reduction=same,
        damping={"boundary_ratio": own.damping.ratio},
        excitation=load,
    )
    if kind == "blade":
        nodes = bw.with_values(nodes, {f"bladed_disk.{key}": mistuning[key] for key in mistuning})
    speeds = ["1300 rpm", "600 rpm", "1000 rpm"]  # do not ascend: no peaks are sought
    first, second = (bw.response(each, speeds=speeds) for each in (own, nodes))
    size = np.abs(first["tip_tangential"].values).max()
    for name in ("tip_tangential", "tip_radial", *(("centre",) if kind == "wheel" else ())):
        same_to = 1e-8 if effects == "full" else 1e-9  # two roots of a stiffness of many decades
        assert second[name].values == pytest.approx(first[name].values, abs=same_to * size)
    assert ("centre" in second) == (kind == "wheel")
    assert np.ptp(np.abs(second["tip_tangential"].values)) > 0.1 * size
    if kind == "sector":
        (tmp_path / "case.toml").write_text(bw.dumps_case(nodes), encoding="utf-8")
        shown = answer("response", tmp_path / "case.toml", "--speeds", "0.2:0.4:0.1", "--json")
        assert "centre" not in json.loads(shown.stdout)


@pytest.mark.parametrize(
    ("effects", "tuned"), [("none", True), pytest.param("full", False, marks=pytest.mark.slow)]
)
def test_peaks_are_found_between_speeds(effects: str, tuned: bool) -> None:
    """A grid of a hundred half-power widths; the true peak by a scan around it."""
    own = bw.with_values(case(effects=effects, tuned=tuned), {"damping.ratio": 5e-4})
    coarse = bw.response(own, speeds=[0.4, 0.45, 0.5, 0.55, 0.6])
    rows = report(coarse).document["peaks"]
    speeds = [row["speed"] for row in rows]
    assert rows == sorted(rows, key=lambda row: -row["amplitude"])
    assert len(rows) >= (1 if tuned else 3)
    assert amplitude(coarse).max() < 0.1 * rows[0]["amplitude"]
    near = np.linspace(0.9995 * speeds[0], 1.0005 * speeds[0], 51)
    fine = float(amplitude(bw.response(own, speeds=near.tolist())).max())
    assert fine <= rows[0]["amplitude"] * (1.0 + 1e-12)
    assert fine == pytest.approx(rows[0]["amplitude"], rel=2e-3)
    drawn = drawn_amplitudes(coarse)["amplitude"].isel(order=0).max("blade")
    assert float(drawn.max()) == pytest.approx(rows[0]["amplitude"])


@pytest.mark.parametrize("effects", ["none", pytest.param("full", marks=pytest.mark.slow)])
def test_a_mistuned_sector_responds_as_its_wheel(effects: str, tmp_path: Path) -> None:
    """The direct solution of the assembled wheel is that of stiffness, mass, Coriolis forces and
    modal damping. Without the residual flexibility the error would be 3e-3."""
    part = mesh3d(
        bladed_sector("hexahedron"),
        **STEEL,
        **TIE,
        contacts=2,
        blade="r > 0.0899",
        coriolis=effects == "full",
    )
    bw.write_superelement(tmp_path / "part.npz", part)
    factors = 1.0 + 0.02 * np.random.default_rng(3).standard_normal(SECTORS)
    table = {"file": str(tmp_path / "part.npz"), "kind": "sector", "copies": SECTORS}
    zeta, omega, order = 2e-3, 6370.0, 3
    own = bw.case_from(
        {
            "bladed_disk": {"superelement": table, "mistuning": {"stiffness": factors.tolist()}},
            "casing": {"type": "rigid"},
            "shaft": {"clamped": True},
            "damping": {"ratio": zeta},
            "excitation": {"type": "engine-order", "order": order, "amplitude": AMPLITUDE},
            "rotation": {"effects": effects},
            "reduction": {"free_interface_modes": 20 if effects == "full" else 10},
        }
    )
    found = bw.response(own, speeds=[f"{omega} rad/s"]).isel(speed=0)
    wheel = mistuned_wheel(whole_wheel(part, SECTORS), factors)
    turning = wheel.at(omega) if effects == "full" else wheel
    stiffness, mass = dense(turning.stiffness), dense(wheel.mass)
    squares, shapes = la.eigh(dense(wheel.stiffness), mass)
    weighted = mass @ shapes
    skew = omega * dense(turning.gyroscopic) if effects == "full" else 0.0
    damping = (weighted * (2.0 * zeta * np.sqrt(squares))) @ weighted.T + skew
    w = order * omega
    rows = wheel.contact_rows.toarray()
    nodes = rows.reshape(SECTORS, -1, 3, rows.shape[1])
    middle = np.angle(np.exp(1j * wheel.contact_angle).reshape(SECTORS, -1).mean(axis=1))
    force = AMPLITUDE * np.exp(1j * order * middle) @ nodes[:, :, 1].mean(axis=1)
    answer = np.linalg.solve(stiffness - w**2 * mass + 1j * w * damping, force)
    expected = nodes[:, :, 1].mean(axis=1) @ answer
    largest = np.abs(expected).max()
    assert found["tip_tangential"].values == pytest.approx(expected, abs=1e-4 * largest)


def test_equal_sectors_are_reduced_in_the_nodal_diameters_of_the_forces_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An order above the number of sectors drives the nodal diameter that is left of it; forces of
    unequal blades drive all of them. The response is that of all nodal diameters."""
    part = mesh3d(bladed_sector("hexahedron"), **STEEL, **TIE, contacts=1, coriolis=True)
    bw.write_superelement(file := tmp_path / "part.npz", part)
    load = {"type": "engine-order", "order": [0, SECTORS + 1], "amplitude": AMPLITUDE}
    case = bw.case_from(
        {
            "bladed_disk": {"superelement": {"file": str(file), "copies": SECTORS}},
            "casing": {"type": "rigid"},
            "excitation": load,
            "rotation": {"effects": "full"},
            "reduction": {"free_interface_modes": 2},
        }
    )
    orders, asked = engine_orders(case), list[object]()

    def of_all(stage: Matrices, diameters: object) -> Matrices:
        asked.append(diameters)
        return stage

    monkeypatch.setattr(Matrices, "of_diameters", of_all)
    stage = build_stage(case)
    every = bw.response(stage, speeds=["1000 rad/s"])
    next(forced(stage, [orders[0].model_copy(update={"factors": (2.0,) * SECTORS})], [1000.0]))
    monkeypatch.undo()
    assert asked == [{0, 1}]
    some = bw.response(stage, speeds=["1000 rad/s"])
    for name in ("tip_tangential", "tip_radial"):
        largest = np.abs(every[name].values).max()
        assert some[name].values == pytest.approx(every[name].values, abs=1e-9 * largest)
    few = next(forced(stage, orders, [1000.0])).rotor
    assert few.tip_radial.shape[1] == 2 * 3  # k = 0, and both waves of k = 1
