"""Modal studies of superelements: stages of beams give the same results as superelements."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
import xarray as xr
from command_line import answer, refusal
from exported_stages import BLADES, Kind, beams, exported
from rod_blade import blade, tables
from solid_meshes import SECTORS, STEEL, TIE, bladed_sector, cantilever

import bladewhirl as bw
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.models.structure.eigenproblems import gyroscopic_frequencies
from bladewhirl.models.superelements import nodal_blocks
from bladewhirl.models.superelements.cyclic import transformation
from bladewhirl.models.superelements.superelement import dense
from bladewhirl.models.superelements.wheel import whole_wheel
from bladewhirl.studies.modal.modes import document, mode_lists

LABELS = ("family", "nodal_diameter", "family_at_rest", "direction", "direction_static", "pattern")


def of(modes: xr.Dataset, body: str, centre: str, count: int) -> xr.Dataset:
    """Return the lowest modes of a body, without the index."""
    rows = (modes["body"].values == body) & (modes["centre"].values == centre)
    return modes.isel(mode=rows).isel(mode=slice(count)).reset_index("mode")


@pytest.mark.parametrize("effects", ["none", "centrifugal", "full"])
def test_modes_of_a_wheel_are_those_of_its_beams(tmp_path: Path, effects: str) -> None:
    case = beams(rotation={"effects": effects})
    wheel = exported(case, "wheel", tmp_path)
    first, second = bw.modes(case), bw.modes(wheel, count=30)
    for body, centre in (("bladed-disk", "free"), ("bladed-disk", "clamped"), ("casing", "")):
        one, other = of(first, body, centre, 29), of(second, body, centre, 29)
        assert other["frequency"].values == pytest.approx(one["frequency"].values, rel=1e-9)
        assert other["spring_share"].values == pytest.approx(one["spring_share"].values, abs=1e-9)
        for name in LABELS:
            assert other[name].values.tolist() == one[name].values.tolist()
    assert second.attrs["centre"] == "free"
    assert second.attrs["rotation_effects"] == effects


@pytest.mark.parametrize("kind", ["sector", "blade"])
def test_modes_of_a_part_are_those_of_its_beams(tmp_path: Path, kind: Kind) -> None:
    case = beams(kind)
    first, second = bw.modes(case), bw.modes(exported(case, kind, tmp_path), count=8)
    assert second.attrs["centre"] == "clamped"
    other = of(second, "bladed-disk", "clamped", 8)
    if kind == "sector":
        one = of(first, "bladed-disk", "clamped", 8)
        assert other["frequency"].values == pytest.approx(one["frequency"].values, rel=1e-9)
        for name in LABELS:
            assert other[name].values.tolist() == one[name].values.tolist()
    else:  # separate blades have the same frequency with every nodal diameter
        one = first.sel(body="bladed-disk", centre="clamped", nodal_diameter=0)
        assert other["family"].values.tolist() == [f"{n}F" for n in range(1, 7)]
        assert set(other["nodal_diameter"].values.tolist()) == {-1}
        assert other["frequency"].values == pytest.approx(one["frequency"].values[:6], rel=1e-9)


def test_as_many_modes_are_listed_as_are_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A pair is one row; the first trial has too few modes of each nodal diameter."""
    monkeypatch.setattr("bladewhirl.models.stage.matrix_disk.FEWEST", 1)
    case = exported(beams("sector"), "sector", tmp_path)
    some, every = (mode_lists(modal_model(case, count=count)) for count in (18, 60))
    assert len(some.values["number"]) < len(every.values["number"])
    lists = [document(each, 9)["bladed_disk"] for each in (some, every)]
    assert lists[0] == lists[1]
    assert len({(mode["family"], mode["nodal_diameter"]) for mode in lists[0]}) == 9


@pytest.mark.parametrize("effects", ["none", "full"])
def test_waves_with_coriolis_forces_need_few_modes(effects: str, tmp_path: Path) -> None:
    """Compared with the quadratic eigenproblem of all coordinates of a sector at the speed."""
    part = bw.mesh3d(bladed_sector("hexahedron"), **STEEL, **TIE, contacts=2, coriolis=True)
    bw.write_superelement(file := tmp_path / "part.npz", part)
    table = {"file": str(file), "kind": "sector", "copies": SECTORS}
    speed, k = 1500.0, 2
    case = bw.case_from(
        {
            "bladed_disk": {"superelement": table},
            "casing": {"type": "rigid"},
            "rotation": {"effects": effects},
            "march": {"speed": f"{speed} rad/s"},
        }
    )
    model = modal_model(case, count=3)
    block, tie = model.waves[k], transformation(part, SECTORS, k)
    assert block.size < 60  # 109 modes at each of three speeds before
    turned = part if effects == "none" else part.at(speed, "full")
    names = ("mass", "stiffness", "gyroscopic")
    mass, stiffness, gyroscopic = (m.toarray() for m in turned.projected(tie, names).values())
    exact = gyroscopic_frequencies(mass, stiffness, speed * gyroscopic)
    found = block.frequencies(speed)
    for sign in (1.0, -1.0):  # backward and forward waves
        both = [np.sort(sign * each[sign * each.real > 0.0].real)[:3] for each in (found, exact)]
        assert both[0] == pytest.approx(both[1], rel=1e-6)
    apart = abs(both[1] / np.sort(exact[exact.real > 0.0].real)[:3] - 1.0).max()
    assert apart > 1e-4  # the forces have an effect


@pytest.mark.parametrize("effects", ["none", "full"])
def test_modes_of_one_blade_with_coriolis_forces_have_families_and_no_diameters(
    effects: str, tmp_path: Path
) -> None:
    part = bw.mesh3d(cantilever("hexahedron"), **STEEL, contacts=2, coriolis=True)
    bw.write_superelement(file := tmp_path / "part.npz", part)
    table = {"file": str(file), "kind": "blade", "copies": 1}
    values = {"bladed_disk": {"superelement": table}, "casing": {"type": "rigid"}}
    case = bw.case_from(values | {"rotation": {"effects": effects}})
    rows = document(mode_lists(modal_model(case, count=3)), 3)["bladed_disk"]
    assert [row["family"] for row in rows] == ["1F", "2F", "3F"]
    assert {row["nodal_diameter"] for row in rows} == {-1}


@pytest.mark.slow
def test_the_blades_of_a_wheel_are_known_only_by_their_number(tmp_path: Path) -> None:
    """Without copies a mode has no nodal diameter; if blades differ, it has a dominant one."""
    case = beams()
    part = bw.build_stage(case).to_superelement()
    disk = {"blades": BLADES, "elements_per_blade": 2}
    mistuning = {"stiffness": [1.0, 1.04, 1.0, 0.98, 1.0]}
    uneven = beams(bladed_disk=disk | {"mistuning": mistuning})
    first = of(bw.modes(uneven), "bladed-disk", "free", 12)
    different = exported(uneven, "wheel", tmp_path)
    second = of(bw.modes(different, count=12), "bladed-disk", "free", 12)
    assert second["frequency"].values == pytest.approx(first["frequency"].values, rel=1e-9)
    pure = first["purity"].values > 0.8
    assert pure.any()
    assert (second["nodal_diameter"].values == first["nodal_diameter"].values)[pure].all()
    assert set(second["family"].values) == {""}
    turning = beams(bladed_disk=disk | {"mistuning": mistuning}, rotation={"effects": "full"})
    with pytest.raises(bw.UserError, match="expected equal sectors"):
        bw.critical_speeds(exported(turning, "wheel", tmp_path))
    # The blades may be listed in any order.
    mixed = [2, 0, 3, 1, 4]
    part = replace(
        part,
        contact_position=part.contact_position[mixed],
        contact_dofs=part.contact_dofs[mixed],
        strain_recovery=np.ones((1, part.size)),
    )
    bw.write_superelement(tmp_path / "wheel.npz", part)
    both = [bw.modes(each, count=12) for each in (case, different)]
    tuned, same = (of(each, "bladed-disk", "free", 12) for each in both)
    for name in LABELS:
        assert same[name].values.tolist() == tuned[name].values.tolist()
    unknown = bw.with_values(different, {"bladed_disk.superelement.copies": 1})
    assert set(
        of(bw.modes(unknown, count=6), "bladed-disk", "free", 6)["nodal_diameter"].values
    ) == {-1}


@pytest.mark.slow
@pytest.mark.parametrize("effects", ["none", "full"])
def test_the_campbell_diagram_of_a_wheel_is_that_of_its_beams(tmp_path: Path, effects: str) -> None:
    case = beams(rotation={"effects": effects})
    speeds = ("0 rpm", "40000 rpm")
    first = bw.campbell(case, families=2, speeds=speeds)
    second = bw.campbell(exported(case, "wheel", tmp_path), families=2, speeds=speeds)
    assert first.sizes["coincidence"] > 0
    assert set(first) - set(second) == ({"tip_growth"} if effects == "full" else set())
    for name in second:
        one, other = first[name].values, second[name].values
        if one.dtype.kind == "f":
            size = np.abs(one).max(initial=0.0)
            assert other == pytest.approx(one, rel=1e-8, abs=max(1e-9 * size, 1e-12))
        else:
            assert other.tolist() == one.tolist()


def test_separate_blades_meet_the_casing_with_every_nodal_diameter(tmp_path: Path) -> None:
    case = beams("blade")
    first = bw.campbell(case, families=2)
    second = bw.campbell(exported(case, "blade", tmp_path), families=2)
    assert second.sizes["coincidence"] == first.sizes["coincidence"]
    assert second["speed"].values == pytest.approx(first["speed"].values, rel=1e-9)
    assert "no stiffness_speed" in second.attrs["hints"]


@pytest.mark.parametrize("speed", ["3000 rpm", 0.1])
def test_listed_modes_of_a_sector_take_no_static_solution(
    tmp_path: Path, speed: str | float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All modes of each nodal diameter, which have static displacements besides, are the same."""
    part = bw.mesh3d(bladed_sector("hexahedron"), **STEEL, **TIE, contacts=2)
    bw.write_superelement(file := tmp_path / "sector.npz", part)
    table = {"file": str(file), "kind": "sector", "copies": SECTORS}
    case = bw.case_from(
        {
            "bladed_disk": {"superelement": table},
            "casing": {"type": "rigid"},
            "rotation": {"effects": "centrifugal"},
            "march": {"speed": speed},
        }
    )
    every = bw.modes(case)["frequency"].values

    def refused(*_: object, **__: object) -> None:
        raise AssertionError

    monkeypatch.setattr("bladewhirl.models.superelements.solver.Pencil.static", refused)
    np.testing.assert_allclose(bw.modes(case, count=9)["frequency"].values[:9], every[:9], 1e-8)


def test_coriolis_forces_split_the_waves_of_a_sector(tmp_path: Path) -> None:
    """Over the speed, as in `modes` at one speed; a rigid wall has no modes."""
    part = blade(levels=3)
    faces: Any = {"left_dofs": np.array([[0, 1, 2]]), "right_dofs": np.array([[3, 4, 5]])}
    turn = np.kron(np.eye(part.size // 3), [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    gyroscopic = 2.0 * np.asarray(part.mass) @ turn
    bw.write_superelement(
        file := tmp_path / "part.npz", replace(part, gyroscopic=gyroscopic, **faces)
    )
    table = {"file": str(file), "copies": 4, "kind": "sector"}
    case = bw.case_from(
        tables(file, bladed_disk={"superelement": table}, reduction={"free_interface_modes": 12})
    )
    reference = build_matrices(case).reference_frequency
    diagram = bw.campbell(case, families=3, speeds=(0.0, case.march.speed.multiple(reference)))
    assert diagram.sizes["coincidence"] == 0
    modes = of(bw.modes(case, count=12), "bladed-disk", "clamped", 12)
    assert set(modes["body"].values) == {"bladed-disk"}
    last = diagram.isel(line_speed=-1)
    for way in ("backward", "forward"):
        (listed,) = modes["frequency"].values[
            (modes["nodal_diameter"].values == 1)
            & (modes["family"].values == "1F")
            & (modes["direction"].values == way)
        ]
        branch = last.isel(
            branch=(last["branch_nodal_diameter"].values == 1)
            & (last["branch_family"].values == "1F")
            & (last["branch_direction"].values == way)
        )
        assert abs(branch["branch_frequency"].item()) == pytest.approx(listed, rel=1e-9)
    # The march has the same frequencies: those of its modes with their Coriolis forces.
    reduced, omega = build_matrices(case).reduced, build_matrices(case).speed
    assert reduced.gyroscopic is not None
    size = len(reduced.frequency)
    top = np.hstack([-omega * reduced.gyroscopic, -np.diag(reduced.frequency**2)])
    w = np.linalg.eigvals(np.vstack([top, np.eye(size, 2 * size)])).imag
    of_march = np.sort(w[w > 0.0])[:12] / (2.0 * np.pi)
    assert modes["frequency"].values == pytest.approx(of_march, rel=1e-3)
    assert np.diff(of_march).max() > 1e-3 * of_march[0]


@pytest.mark.slow
@pytest.mark.parametrize("bearings", [{}, {"stiffness_y": 1.4e7, "frame": "static"}])
def test_critical_speeds_of_a_wheel_are_those_of_its_beams(
    tmp_path: Path, bearings: dict[str, Any]
) -> None:
    case = beams(rotation={"effects": "full"}, shaft={"stiffness": 2e7, **bearings})
    wheel, springs = exported(case, "wheel", tmp_path), np.geomspace(1e5, 1e9, 5)
    first, second = (bw.critical_speeds(each, stiffnesses=springs) for each in (case, wheel))
    assert first["critical_speed"].notnull().all()
    for name in ("critical_speed", "spring_share"):
        assert second[name].values == pytest.approx(first[name].values, rel=1e-8, abs=1e-10)
    (tmp_path / "case.toml").write_text(bw.dumps_case(wheel), encoding="utf-8")
    rows = json.loads(answer("critical-speeds", tmp_path / "case.toml", "--json").stdout)
    assert rows["critical_speeds"][0]["direction"] == ("elliptic" if bearings else "forward")
    changed = ("critical-speeds", tmp_path / "case.toml", "--set", "rotation.effects=centrifugal")
    assert "no whirl is stationary in rotating axes" in refusal(*changed)


def test_a_wheel_is_marched_with_its_stiffness_at_speed(tmp_path: Path) -> None:
    """All frequencies of the reduced stage at speed are those of the reduced beams."""
    march = {"speed": "2000 rpm", "time_step": 1e-6}
    case = beams(rotation={"effects": "full"}, march=march)
    same = {"boundary": "consistent", "fixed_interface_modes": 10}
    wheel = build_matrices(exported(case, "wheel", tmp_path, reduction=same))
    stage = bw.build_stage(case)
    assert wheel.reference_frequency == pytest.approx(stage.reference_frequency, rel=1e-3)
    assert wheel.reduced.frequency == pytest.approx(stage.rotor.frequency, rel=1e-9)
    assert wheel.reduced.gyroscopic is not None
    forces = np.linalg.eigvals(wheel.speed * wheel.reduced.gyroscopic).imag
    assert stage.rotor.by_velocity is not None
    skew = 0.5 * (stage.rotor.by_velocity - stage.rotor.by_velocity.T)
    expected = np.linalg.eigvals(skew).imag
    assert np.sort(forces) == pytest.approx(np.sort(expected), abs=1e-8 * expected.max())
    assert wheel.reduced.frequency[0] != pytest.approx(
        bw.build_stage(beams()).rotor.frequency[0], rel=1e-3
    )
    too_fast = bw.with_values(wheel.case, {"march.speed": 3.0})
    assert build_matrices(too_fast).reduced.squares[0] < 0.0  # above the first critical speed


@pytest.mark.slow
def test_a_large_wheel_is_reduced_to_modes_that_suit_all_shaft_springs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = beams(rotation={"effects": "full"})
    wheel, springs = exported(case, "wheel", tmp_path), np.geomspace(1e5, 1e9, 5)
    exact = bw.critical_speeds(wheel, stiffnesses=springs, branches=1)
    monkeypatch.setattr(nodal_blocks, "ALL", 10)
    monkeypatch.setattr("bladewhirl.models.stage.matrix_disk.COUPLED", 0)
    modal = modal_model(wheel, families=4)
    assert modal.waves[1].size < 10
    reduced = bw.critical_speeds(modal, stiffnesses=springs, branches=1)
    forward = [each.critical_speed.sel(direction="forward").values for each in (exact, reduced)]
    assert forward[1] == pytest.approx(forward[0], rel=0.02)


@pytest.mark.parametrize("kind", ["blade", "sector"])
def test_matrices_at_speed_act_alike_in_modes_and_in_the_march(tmp_path: Path, kind: str) -> None:
    """Both are compared with the quadratic eigenproblem of all coordinates at the speed."""
    part = blade(levels=3)
    random = np.random.default_rng(3)
    half = random.standard_normal(part.mass.shape)
    skew, change = 2e-3 * (half - half.T), 0.05 * (half + half.T)
    faces: Any = {}
    if kind == "sector":
        faces = {"left_dofs": np.array([[0, 1, 2]]), "right_dofs": np.array([[3, 4, 5]])}
    part = replace(part, gyroscopic=skew, stiffness_speed=change, **faces)
    bw.write_superelement(file := tmp_path / "part.npz", part)
    table = {"file": str(file), "copies": 4, "kind": kind}
    case = bw.case_from(
        tables(
            file,
            bladed_disk={"superelement": table},
            reduction={"boundary": "consistent"},
            rotation={"effects": "full"},
        )
    )
    stage = build_matrices(case)
    whole = whole_wheel(part, 4) if kind == "sector" else part
    stiffness = dense(whole.stiffness) + stage.speed**2 * dense(whole.stiffness_speed)
    coriolis = stage.speed * dense(whole.gyroscopic)
    exact = gyroscopic_frequencies(dense(whole.mass), stiffness, coriolis)
    lowest = np.sort(exact.real[exact.real > 0.0])[:8]
    squares = la.eigh(dense(whole.stiffness), dense(whole.mass), eigvals_only=True)
    at_rest = np.sqrt(squares[:8])
    assert np.abs(lowest / at_rest - 1.0).max() > 1e-2
    modes = bw.modes(case, count=8).sel(body="bladed-disk")
    assert 2.0 * np.pi * modes["frequency"].values == pytest.approx(lowest, rel=1e-6)
    rotor = stage.rotor
    assert rotor.by_velocity is not None
    forces = 0.5 * (rotor.by_velocity - rotor.by_velocity.T)
    modal = np.diag(rotor.by_copy(rotor.stiffness)[0])
    of_march = gyroscopic_frequencies(np.eye(len(modal)), modal, forces).real
    assert np.sort(of_march[of_march > 0.0])[:8] == pytest.approx(lowest, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("effects", ["none", "full"])
def test_veering_of_a_wheel_is_that_of_its_beams(tmp_path: Path, effects: str) -> None:
    case, springs = beams(rotation={"effects": effects}), np.geomspace(1e5, 1e9, 5)
    wheel = exported(case, "wheel", tmp_path)
    first, second = (bw.veering(each, families=2, stiffnesses=springs) for each in (case, wheel))
    for name in first.data_vars:
        one, other = first[name].values, second[name].values
        if one.dtype.kind == "f":
            assert other == pytest.approx(one, rel=1e-8, abs=1e-9)
        else:
            assert other.tolist() == one.tolist()
