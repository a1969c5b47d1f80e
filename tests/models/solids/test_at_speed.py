"""One file of a blade or a sector at every speed of rotation."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io as sio
from command_line import answer
from numpy.testing import assert_array_equal
from solid_meshes import CALCULIX, STEEL, TIE, bladed_sector, cantilever, deck

import bladewhirl as bw
from bladewhirl.models.case.plausibility import linear_hints
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.stage import superelement_structure as stage_of_superelement
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.models.superelements import kept_reduction, nodal_blocks, wheel
from bladewhirl.models.superelements.condensed import FURTHER_MODES
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError
from bladewhirl.postprocess.fields.result import completed, described

SPEED = CALCULIX["speed"]


def case(folder: Path, part: Superelement, kind: str, **tables: Any) -> bw.Case:
    """A case with the part in a rigid wall."""
    bw.write_superelement(folder / "part.npz", part)
    copies = TIE["copies"] if kind == "sector" else 1
    table = {"file": str(folder / "part.npz"), "kind": kind, "copies": copies}
    given = {"bladed_disk": {"superelement": table}, "casing": {"type": "rigid"}}
    given |= {"shaft": {"clamped": True}, "march": {"speed": f"{SPEED} rad/s"}}
    return bw.case_from(given | tables)


@pytest.mark.slow
def test_modes_of_a_sector_at_speed_are_those_of_calculix(tmp_path: Path) -> None:
    path = deck(tmp_path, bladed_sector("hexahedron"), "C3D8I")
    part = mesh3d(path, **STEEL, **TIE, mass_quadrature="reduced")
    for effects, name in (("none", "sector"), ("centrifugal", "rotating sector")):
        found = bw.modes(case(tmp_path, part, "sector", rotation={"effects": effects}))
        disk = found.sel(mode=found["body"] == "bladed-disk")
        expected = np.array(CALCULIX[name]["C3D8I"])
        for k, of_calculix in enumerate(expected):
            ours = np.sort(disk["frequency"].values[disk["nodal_diameter"].values == k])
            waves = 2 if 0 < k < TIE["copies"] / 2 else 1
            assert ours[::waves][:3] == pytest.approx(of_calculix[:3], rel=1e-6)


def test_stress_alone_leaves_out_the_change_of_the_elastic_stiffness() -> None:
    mesh = cantilever("hexahedron20")
    whole, stress = (mesh3d(mesh, **STEEL, stiffening=each) for each in ("prestress", "stress"))
    assert stress.stiffness_speed4 is None
    assert whole.stiffness_speed is not None
    assert stress.stiffness_speed is not None
    difference = abs(whole.stiffness_speed - stress.stiffness_speed).max()
    assert 1e-3 < difference / abs(stress.stiffness_speed).max() < 1e3
    assert "stiffness at speed: stress" in stress.source


@pytest.mark.parametrize("speeds", [(500.0,), (500.0, 1000.0), (-500.0, "9000 rpm")])
def test_stiffnesses_at_speeds_are_fitted(speeds: tuple[Any, ...], tmp_path: Path) -> None:
    """Of a blade from its matrices at rest and at one or two speeds: with one of them, the fourth
    power of the speed is left out."""
    mesh = cantilever("hexahedron20", (2, 1, 1))
    part = mesh3d(mesh, **STEEL, stiffening="stress" if len(speeds) == 1 else "prestress")
    contact = part.contact_position
    lines = [
        ",".join(map(str, (n + 1, *contact[n], *(part.contact_dofs[n] + 1))))
        for n in range(len(contact))
    ]
    (tmp_path / "nodes.csv").write_text("\n".join(["node,x,y,z,row_x,row_y,row_z", *lines]))
    sio.mmwrite(tmp_path / "k0.mtx", part.stiffness)
    sio.mmwrite(tmp_path / "m.mtx", part.mass)
    at = {}
    for number, speed in enumerate(speeds):
        omega = 300.0 * np.pi if isinstance(speed, str) else speed
        sio.mmwrite(tmp_path / f"k{number + 1}.mtx", part.at(omega).stiffness)
        at[speed] = tmp_path / f"k{number + 1}.mtx"
    given: dict[str, Any] = {"mass": tmp_path / "m.mtx", "nodes": tmp_path / "nodes.csv"}
    nodes = ",".join(str(n + 1) for n in range(len(contact)))
    again = bw.import_superelement(tmp_path / "k0.mtx", at=at, contact=nodes, **given)
    for omega in (0.0, 700.0):
        expected = part.at(omega).stiffness
        found = again.at(omega).stiffness
        assert abs(found - expected).max() < 1e-9 * abs(expected).max()
    with pytest.raises(SuperelementError, match="differ from each other"):
        bw.import_superelement(
            tmp_path / "k0.mtx", at={0.0: tmp_path / "m.mtx"}, contact=nodes, **given
        )
    alone = bw.import_superelement(tmp_path / "k0.mtx", speed="9000 rpm", contact=nodes, **given)
    assert alone.speed == pytest.approx(300.0 * np.pi)


def test_a_stiffness_of_another_speed_is_mentioned(tmp_path: Path) -> None:
    mesh = cantilever("tetra", (2, 1, 1))
    fixed = mesh3d(mesh, **STEEL, speed="3000 rpm")
    given = case(tmp_path, fixed, "blade", march={"speed": "6000 rpm"})
    (hint,) = linear_hints(given)
    assert "that at 3000 rpm, 0.5 times this speed" in hint
    assert not [*linear_hints(bw.with_values(given, {"march.speed": "3000 rpm"}))]
    at_rest = case(tmp_path, mesh3d(mesh, **STEEL, stiffening=None), "blade")
    (hint,) = linear_hints(at_rest)
    assert "is that at rest" in hint
    with_change = case(tmp_path, mesh3d(mesh, **STEEL), "blade")
    (hint,) = linear_hints(with_change)
    assert "not used" in hint
    assert not [*linear_hints(bw.with_values(with_change, {"rotation.effects": "centrifugal"}))]


@pytest.mark.slow
@pytest.mark.parametrize("effects", ["centrifugal", "full"])
def test_a_large_blade_is_condensed_for_all_speeds(effects: str, tmp_path: Path) -> None:
    """With the frequencies, flexibilities and Coriolis forces that it has at each speed."""
    mesh = cantilever("hexahedron20", (6, 2, 1))
    part = mesh3d(mesh, **STEEL, contacts=3, coriolis=True)
    given = case(tmp_path, part, "blade", rotation={"effects": effects})
    given = bw.with_values(given, {"reduction.free_interface_modes": 12})
    for speed in ("300 rad/s", "700 rad/s", "1024 rad/s"):
        at_speed = bw.with_values(given, {"march.speed": speed})
        exact = build_matrices(at_speed).reduced
        stage = build_matrices(at_speed, condensed_from=10)
        found = stage.reduced
        assert stage.table.part.size > 2 * stage.part.size
        assert found.frequency[:10] == pytest.approx(exact.frequency[:10], rel=1e-9)
        size = abs(exact.compliance).max()
        assert found.compliance == pytest.approx(exact.compliance, abs=1e-6 * size)
        flexible = [
            (each.contact / each.frequency**2) @ each.contact.T + each.compliance
            for each in (found, exact)
        ]
        assert flexible[0] == pytest.approx(flexible[1], rel=1e-9, abs=1e-9 * flexible[1].max())
        points = [np.linalg.norm(each.points, axis=0)[:6] for each in (found, exact)]
        assert points[0] == pytest.approx(points[1], rel=1e-7)
        if effects == "full":
            matrices = found.gyroscopic, exact.gyroscopic
            forces = [np.linalg.eigvals(each).imag for each in matrices if each is not None]
            assert np.sort(forces[0]) == pytest.approx(np.sort(forces[1]), abs=1e-6)


def test_a_condensed_blade_is_kept_beside_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = mesh3d(cantilever("hexahedron", (6, 2, 1)), **STEEL, contacts=3)
    given = case(tmp_path, part, "blade", rotation={"effects": "centrifugal"})
    given = bw.with_values(given, {"reduction.free_interface_modes": 6})
    monkeypatch.setattr(kept_reduction, "LARGE", 0)
    made = list[Matrices]()
    for _ in range(2):
        monkeypatch.setattr(stage_of_superelement, "_small", {})
        monkeypatch.setattr(kept_reduction, "_remembered", {})
        made.append(build_matrices(given, condensed_from=10))
        monkeypatch.setattr(stage_of_superelement, "condensed", None)  # needed once
    assert made[0].part.size < part.size
    for name in ("frequency", "contact", "compliance", "points"):
        assert_array_equal(*(getattr(stage.reduced, name) for stage in made))


def test_the_shapes_of_all_sectors_follow_from_those_of_the_first(tmp_path: Path) -> None:
    part = mesh3d(bladed_sector("hexahedron"), **STEEL, **TIE, contacts=2)
    stage = build_matrices(case(tmp_path, part, "sector", reduction={"free_interface_modes": 4}))
    arrays, modes = stage.shown_arrays, stage.reduced.size
    result = completed(described(arrays.stored))
    assert stage.reduced.stress is not None
    for name, rows in (("point", stage.reduced.points), ("stress", stage.reduced.stress.modes)):
        expected = rows.reshape(stage.part.point_count, -1, modes)
        shape = result[f"{name}_shape"]
        close = 1e-14 * abs(expected).max()
        assert shape[40].values == pytest.approx(expected[40], abs=close)
        assert shape[3::50, 1].values == pytest.approx(expected[3::50, 1], abs=close)
        assert shape.values == pytest.approx(expected, abs=close)
        assert TIE["copies"] * arrays.stored[f"sector_{name}_shape"].size == shape.size
        assert f"{name}_shape" not in arrays.stored


def test_the_error_of_a_sector_does_not_depend_on_the_order_of_its_modes(tmp_path: Path) -> None:
    """They are listed by nodal diameter, and compared with the lowest of the wheel."""
    part = mesh3d(bladed_sector("hexahedron"), **STEEL, **TIE, contacts=2, coriolis=True)
    stage = build_matrices(case(tmp_path, part, "sector", rotation={"effects": "full"}))
    assert (np.diff(stage.reduced.frequency) < 0.0).any()
    assert stage.own_properties["frequency_error"] < 1e-6


def test_the_reference_frequency_takes_few_modes_and_no_static_displacements(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = mesh3d(bladed_sector("hexahedron"), **STEEL, **TIE, contacts=2)
    reduced = list[tuple[int, bool]]()
    compute = nodal_blocks.sector_blocks

    def counted(part: Superelement, sectors: int, count: int, *given: Any, **options: Any) -> Any:
        reduced.append((count, options["static"]))
        return compute(part, sectors, count, *given, **options)

    monkeypatch.setattr(wheel, "sector_blocks", counted)
    modes = {"reduction": {"free_interface_modes": 6}}
    stages = [
        build_matrices(case(tmp_path, part, "sector", rotation={"effects": effects}, **modes))
        for effects in ("centrifugal", "none")
    ]
    assert reduced == [(4, False), (6 + FURTHER_MODES, True), (6, True)]
    turning, still = (stage.reference_frequency for stage in stages)
    assert turning == pytest.approx(still, rel=1e-9)


@pytest.mark.slow
def test_the_error_of_a_condensed_sector_is_known(tmp_path: Path) -> None:
    """It is that of modes at other speeds: with rotation, and large if one of them is changed."""
    part = mesh3d(bladed_sector("hexahedron"), **STEEL, **TIE)
    small = {"reduction": {"free_interface_modes": 5}}
    turning = case(tmp_path, part, "sector", rotation={"effects": "centrifugal"}, **small)
    stage = build_matrices(turning)
    found = stage.own_properties["frequency_error"]
    assert found is not None
    assert found < 1e-9
    shifted = replace(stage.reduced, stiffness=1.001**2 * stage.reduced.stiffness)
    again = replace(stage, reduced=shifted).own_properties
    assert again["frequency_error"] == pytest.approx(1e-3, rel=1e-4)
    small_stage = build_matrices(case(tmp_path, part, "sector", **small))
    assert small_stage.own_properties["frequency_error"] is None
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(turning), encoding="utf-8")
    assert "error of the lowest frequencies at this speed" in answer("show", file).output
