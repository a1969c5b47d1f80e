"""Cases with joints: keys, refusals, and the command periodic."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer
from joint_cases import tables

import bladewhirl as bw
from bladewhirl.models.case.file import loads
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.matrices import Matrices
from bladewhirl.solvers.periodic import joint_search
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.joints import JointMotion
from bladewhirl.studies.joints.dataset import dataset
from bladewhirl.studies.joints.motions import alike, found_at, rubbing_wheel
from bladewhirl.studies.runs.run import resume


def case(folder: Path, **joint: Any) -> bw.Case:
    own = tables(folder, **joint) | {"reduction": {"free_interface_modes": 8}}
    if "kind" in joint:
        del own["joint"][0]["angle"]
    return bw.case_from(own)


@pytest.mark.parametrize(
    ("joint", "key"),
    [
        ({"left": [1], "right": [1]}, "joint[0].right"),
        ({"left": [0, 2], "right": [1]}, "joint[0].right"),
        ({"left": [0], "right": [9]}, "joint[0].left"),
        ({"left": [1], "right": [0]}, "joint[0].left"),
        ({"angle": "90 deg"}, "joint[0].angle"),
        ({"normal": [1.0, 0.0, 0.0]}, "joint[0].normal"),
        ({"normal": [1.0, 0.0]}, "joint[0].normal"),
        ({"friction": -0.1}, "joint[0].friction"),
        ({"gap": "1 mm", "preload": "1 N"}, "joint[0].preload"),
        ({"name": "0"}, "joint[0].name"),
        ({"kind": "wedge"}, "joint[0].wedge"),
        ({"wedge": {"mass": "1 g"}}, "joint[0].wedge"),
        ({"kind": "wedge", "wedge": {}}, "joint[0].wedge.mass"),
        ({"kind": "wedge", "wedge": {"mass": "1 g", "angle": "90 deg"}}, "joint[0].wedge.angle"),
        ({"kind": "wedge", "wedge": {"mass": "1 g"}, "preload": "1 N"}, "joint[0].preload"),
    ],
)
def test_a_joint_that_cannot_be_is_refused(tmp_path: Path, joint: Any, key: str) -> None:
    with pytest.raises(bw.CaseError) as refused:
        case(tmp_path, **joint)
    assert refused.value.faults[0].key == key


def test_beams_and_nodes_with_mass_have_no_joints(tmp_path: Path) -> None:
    with pytest.raises(bw.CaseError, match="superelement"):
        bw.case_from({"joint": [{"left": 0, "right": 1}]})
    own = tables(tmp_path) | {"reduction": {"boundary": "consistent"}}
    with pytest.raises(bw.CaseError, match="massless"):
        bw.case_from(own)


def test_a_name_selects_a_joint_and_a_file_keeps_it(tmp_path: Path) -> None:
    given = bw.with_values(case(tmp_path, preload="5 N"), {"joint.shroud.preload": "7 N"})
    assert given.joint[0].preload == 7.0
    again = loads(dumps_case(given))
    assert again.joint == given.joint


def test_a_run_has_joints_and_goes_on_to_the_last_bit(tmp_path: Path) -> None:
    own_tables = tables(tmp_path, preload="3 N") | {
        "reduction": {"free_interface_modes": 8},
        "damping": {"ratio": 0.1},
        "march": {"speed": "3000 rpm", "time_step": "20 us", "duration": "40 ms"},
    }
    given = bw.case_from(own_tables)
    whole = bw.run(given, tmp_path / "whole", frames=0)
    own = whole.summary.joints["shroud"]
    assert own["largest_normal_force"] > 3.0
    assert own["share_open"] + own["share_stuck"] + own["share_slipping"] == pytest.approx(1.0)
    assert whole.summary.work["joints"] == pytest.approx(-own["work"])
    assert whole.summary.energy_residual < 1e-8
    bw.run(bw.with_values(given, {"march.duration": 0.02}), tmp_path / "part", frames=0)
    resume(tmp_path / "part", ["march.duration=0.04"], frames=0)
    results = [bw.open_result(tmp_path / name / "result.nc") for name in ("whole", "part")]
    for name in ("joint_force", "joint_work", "joint_steps", "rotor_displacement"):
        one, other = (result[name].values for result in results)
        assert np.array_equal(one, other)


def test_a_sweep_over_the_preload_has_draws_of_mistuned_blades(tmp_path: Path) -> None:
    own = tables(tmp_path, preload="3 N") | {
        "reduction": {"free_interface_modes": 8},
        "damping": {"ratio": 0.1},
        "march": {"speed": "3000 rpm", "time_step": "20 us", "duration": "20 ms"},
    }
    own["bladed_disk"]["mistuning"] = {"stiffness_spread": 0.01}
    over: dict[str, Any] = {
        "joint.shroud.preload": ["0.3 N", "30 N"],
        "bladed_disk.mistuning.seed": [1, 2],
    }
    bw.run_sweep(bw.case_from(own), over, tmp_path / "sweep", workers=1)
    with bw.open_sweep(tmp_path / "sweep") as data:
        assert (data["energy_residual"] < 1e-8).all()
        slipping = data["joint_slipping"].transpose("joint_shroud_preload", ...).values
        assert slipping[0].min() > slipping[1].max() == 0.0
        assert (data["joint_force_max"][1] > 30.0).all()
        apart = np.ptp(data["blade_amplitude"].values[0, 0])
        assert apart > 1e-3 * data["blade_amplitude"].values.max()


def test_joints_open_and_slip_in_a_run_up(tmp_path: Path) -> None:
    own = tables(tmp_path) | {"reduction": {"free_interface_modes": 8}}
    own["excitation"]["amplitude"] = 20.0
    own["march"] = {
        "run_up": {"from": "3000 rpm", "to": "4500 rpm", "start": 0.0, "end": 0.1},
        "duration": 0.1,
    }
    run = bw.run(bw.case_from(own), tmp_path / "run", frames=0)
    with run.open() as data:
        assert (data["joint_steps"].values.sum(axis=(0, 1)) > 0)[[0, 2]].all()
    assert run.summary.energy_residual < 1e-8


def test_the_command_lists_points_and_joints(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(dumps_case(case(tmp_path, preload="10 N")))
    document = json.loads(
        answer("periodic", file, "--speeds", "7000 rpm,9000 rpm", "--json").stdout
    )
    (one, other) = document["solutions"]
    assert np.shape(one["point_amplitude"]) == (1, 3)
    assert one["joints"]["shroud"]["share_open"] == 0.0
    assert one["joints"]["shroud"]["largest_normal_force"] > 10.0
    assert other["speed_rpm"] == pytest.approx(9000.0)
    answer("periodic", file, "--speeds", "7000 rpm", "-o", tmp_path / "out")
    assert (tmp_path / "out" / "periodic.png").exists()


def near_a_wall(folder: Path, **joint: Any) -> bw.Case:
    """Blades in an oval wall that closes to 1 um above the tips, and 1 um beyond them twice."""
    own = tables(folder, **joint) | {"reduction": {"free_interface_modes": 8}}
    own["damping"] = {"ratio": 0.1}
    own["casing"] |= {
        "clearance": "2.001 mm",
        "clearance_lobes": [{"lobes": 2, "amplitude": "2 um"}],
        "closure": {"amount": "2 mm", "time_constant": "1 ms"},
    }
    return bw.case_from(own)


def test_joints_rub_on_a_wall_that_the_tips_reach(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(dumps_case(near_a_wall(tmp_path, preload="100 N")))
    (row,) = json.loads(answer("periodic", file, "--json").stdout)["solutions"]
    assert row["wall"]["impulse_per_revolution"] > 0.0
    assert 0.0 < row["wall"]["share_open"] < 1.0
    assert row["wall"]["drive_work"] > row["wall"]["friction_heat"] > 0.0
    assert [*row["joints"]] == ["shroud"]
    assert row["largest_normal_force"] == row["joints"]["shroud"]["largest_normal_force"]


@pytest.mark.slow
def test_one_blade_of_a_wheel_rubs_as_one_alone() -> None:
    given = bw.case_from(
        {
            "bladed_disk": {"superelement": {"file": "examples/twisted_blade.npz"}},
            "reduction": {"free_interface_modes": 20},
            "damping": {"ratio": 0.01},
            "casing": {
                "type": "rigid",
                "clearance": "0.25 mm",
                "clearance_lobes": [{"lobes": 2, "amplitude": "0.27 mm"}],
            },
            "contact": {"friction": 0.05},
            "march": {"speed": "7000 rpm", "time_step": "1 us"},
        }
    )
    alone = bw.periodic(given).isel(speed=0)
    stage = build_stage(given)
    one = found_at(stage, contact_problem(stage, steps=False), "7000 rpm")
    together = dataset(given, alike([one]), 1.0).isel(speed=0)
    impulse = float(together["impulse_per_revolution"])
    assert impulse == pytest.approx(float(alone["impulse_per_revolution"]), rel=1e-4)
    moved = alone["amplitude"].sel(order=2).values
    assert together["point_amplitude"].values == pytest.approx(moved, rel=3e-4)
    largest = -float(alone["contact_force"].sel(direction="radial").min())
    assert float(together["largest_normal_force"][0]) == pytest.approx(largest, rel=3e-3)
    multiplier = float(np.abs(alone["multipliers"][0]))
    assert float(together["largest_multiplier"]) == pytest.approx(multiplier, abs=5e-3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"casing.type": "ring", "casing.support": "1e6 N/m2"}, "flexible casing"),
        ({"contact.tip_rotation": True}, "contact.tip_rotation"),
        ({"casing.clearance_lobes": [], "excitation.order": 0}, "the wall is round"),
    ],
)
def test_a_rub_that_does_not_follow_from_one_blade_is_refused(
    tmp_path: Path, changes: dict[str, Any], message: str
) -> None:
    given = bw.with_values(near_a_wall(tmp_path, preload="100 N"), changes)
    stage = build_stage(given)
    assert isinstance(stage, Matrices)
    with pytest.raises(bw.UserError, match=message):
        rubbing_wheel(stage, contact_problem(stage, steps=False))


@pytest.mark.parametrize(
    ("key", "start", "stop"),
    [
        pytest.param("joint.shroud.preload", "10 N", "40 N", marks=pytest.mark.slow),
        ("joint.shroud.friction", 0.2, 0.4),
        pytest.param("excitation.amplitude", "1 N", "4 N", marks=pytest.mark.slow),
        ("march.speed", "7000 rpm", "7200 rpm"),
    ],
)
def test_a_branch_ends_with_the_motion_at_its_end(
    tmp_path: Path, key: str, start: float | str, stop: float | str
) -> None:
    own = bw.with_values(case(tmp_path, preload="10 N"), {"march.speed": "7000 rpm"})
    data = bw.branch(own, key, start, stop, points=5)
    assert data.attrs["ended"].startswith("reaches")
    last = data.isel(place=-1)["point_amplitude"].values
    alone = bw.periodic(bw.with_values(own, {key: stop})).isel(speed=0)["point_amplitude"].values
    assert last == pytest.approx(alone, rel=1e-3)
    assert (data["heading"].values == 1.0).all()


def test_the_command_follows_a_branch(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(dumps_case(case(tmp_path, preload="10 N")))
    over = ["--over", "joint.shroud.preload=100 N:50 N", "--points", "2"]
    shown = answer("periodic", file, *over, "-o", tmp_path / "out", "--json").stdout
    document = json.loads(shown)
    amplitudes = [row["amplitude"] for row in document["points"]]
    assert document["smallest_amplitude"]["amplitude"] == min(amplitudes)
    assert document["folds"] == []
    assert document["points"][-1]["parameter"] == pytest.approx(50.0)
    assert (tmp_path / "out" / "branch.png").exists()


def test_branches_of_joints_begin_at_rest(tmp_path: Path) -> None:
    with pytest.raises(bw.UserError, match="one motion for all blades: expected no blade"):
        bw.branch(case(tmp_path), "march.speed", "5000 rpm", "6000 rpm", periods=2)


def test_linear_limits_stand_beside_the_amplitudes(tmp_path: Path) -> None:
    stuck = bw.periodic(case(tmp_path, preload="1 kN", friction=1e4), speeds=["7000 rpm"])
    amplitude = np.linalg.norm(stuck["point_amplitude"].values, axis=-1)
    assert amplitude[0] == pytest.approx(stuck["linear_limit"].sel(limit="stuck").values[0])
    assert bool(stuck["stable"].all())


def test_a_motion_without_comparison_has_no_change_and_a_hint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missed(*_: Any, anew: bool) -> JointMotion:
        raise NotConverged("none")

    monkeypatch.setattr(joint_search, "_refined", missed)
    file = tmp_path / "case.toml"
    file.write_text(dumps_case(case(tmp_path, preload="10 N")))
    shown = answer("periodic", file, "--json")
    assert "Infinity" not in shown.stdout
    assert json.loads(shown.stdout)["solutions"][0]["change"] is None
    assert "1 of 1 motions were found with one number of harmonics alone" in shown.stderr
    assert "change by more than" not in shown.stderr


@pytest.mark.parametrize("command", ["modes", "campbell"])
def test_modes_and_campbell_say_that_joints_do_not_act(tmp_path: Path, command: str) -> None:
    file = tmp_path / "case.toml"
    for given in (case(tmp_path), bw.with_values(case(tmp_path), {"joint": []})):
        file.write_text(dumps_case(given))
        shown = answer(command, file, "--json").stderr
        assert ("are those of blades without joints" in shown) == bool(given.joint)


def test_periodic_has_the_walk_of_dampers_that_are_free(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    wedge = {"mass": "20 g", "axial": "free"}
    file.write_text(dumps_case(case(tmp_path, kind="wedge", wedge=wedge)))
    (row,) = json.loads(answer("periodic", file, "--json").stdout)["solutions"]
    assert row["amplitude"] == pytest.approx(row["linear_limits"]["stuck"][0], rel=1e-6)
    assert abs(row["joints"]["shroud"]["walk"]) < 1e-12
    assert row["stable"]


def test_a_wheel_at_rest_has_no_period(tmp_path: Path) -> None:
    with pytest.raises(bw.UserError, match="expected a speed"):
        bw.periodic(case(tmp_path), speeds=["0 rpm"])


def test_response_has_the_linear_limits_beside_each_other(tmp_path: Path) -> None:
    file, folder = tmp_path / "case.toml", tmp_path / "response"
    file.write_text(dumps_case(case(tmp_path)))
    over = ("--speeds", "3000 rpm:4400 rpm:350 rpm")
    found = json.loads(answer("response", file, *over, "--json").stdout)["limits"]
    assert [*found] == ["free", "closed without friction", "stuck"]
    free, closed, stuck = (each["peaks"][0] for each in found.values())
    assert {free["place"], closed["place"], stuck["place"]} == {"peak"}
    assert stuck["rpm"] > free["rpm"] > closed["rpm"]
    assert "stuck" in answer("response", file, *over, "-o", folder).stdout
    assert (folder / "response.png").exists()


def test_show_and_campbell_tell_joints_from_tips(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(dumps_case(case(tmp_path, preload="3 N")), encoding="utf-8")
    nodes = json.loads(answer("show", file, "--json").stdout)["derived"]["contact_nodes"]
    assert [node["joint"] for node in nodes] == ["shroud", "shroud", None]
    shown = answer("show", file).stdout
    assert shown.index("Contact nodes of a copy") < shown.index("Ends of joints of a copy")
    words = ("--operating", "1 rpm:2 rpm", "-o", tmp_path / "found")
    printed = answer("campbell", file, *words)
    assert "No speeds to avoid, for blades without joints, to 20%" in printed.stdout
    assert "modes are those of blades without joints" in printed.stderr
