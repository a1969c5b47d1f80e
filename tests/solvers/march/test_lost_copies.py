"""Loss of blades that are copies of a superelement: others move as if they had never been."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rod_blade

import bladewhirl as bw
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Start
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.checkpoint import state_arrays, state_from
from bladewhirl.solvers.march.march import Chunk, KernelState
from bladewhirl.solvers.march.sudden_changes import SuddenChanges, make_scheme
from bladewhirl.studies.runs.prepare import prepare, problem_of
from bladewhirl.studies.verification.bodies import ledger_residual

LOST_AT, END, DT = 0.01, 0.02, 2e-6
MODES = 15


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("rods") / "rods.npz"
    bw.write_superelement(path, rod_blade.blade())
    return path


def tables(file: Path, **changes: Any) -> dict[str, Any]:
    loss = {"blade": 1, "time": LOST_AT}
    return rod_blade.tables(file, blade_loss=loss, march__duration=END, **changes)


def marched(given: ContactProblem, every: int = 20) -> Chunk:
    scheme = make_scheme(given, DT, every)
    return scheme.advance(scheme.init(), round(END / DT) + 1)[1]


@pytest.mark.parametrize("boundary", ["massless", "consistent"])
@pytest.mark.parametrize("varies", [False, True])
def test_other_blades_in_a_rigid_wall_do_not_notice(
    file: Path, boundary: str, *, varies: bool
) -> None:
    given = tables(file)
    if boundary == "consistent":
        given["reduction"] = {"boundary": boundary}
    if varies:
        given["march"].pop("speed")
        given["march"]["speed_table"] = [["0 s", "5500 rpm"], ["0.02 s", "6500 rpm"]]
    problem = prepare(bw.case_from(given)).problem
    with_loss, without = marched(problem), marched(replace(problem, loss=None))
    modes = len(problem.rotor.frequency) // 3
    own = np.arange(3 * modes) // modes == 1
    scale = np.abs(without.rotor_displacement).max()
    np.testing.assert_allclose(
        with_loss.rotor_displacement[:, ~own],
        without.rotor_displacement[:, ~own],
        atol=1e-11 * scale,
    )
    lost, nodes = with_loss.time > LOST_AT, np.arange(9) // 3 == 1
    assert without.contact_impulse[lost][:, nodes].any()
    assert with_loss.contact_impulse[lost][:, ~nodes].any()
    assert not with_loss.contact_impulse[lost][:, nodes].any()
    assert not with_loss.rotor_displacement[lost][:, own].any()
    assert not with_loss.contact_displacement[lost][:, nodes].any()
    # The blade is 50 mm long, the clearance 0.3 mm, less the depth of a lobe.
    assert with_loss.gap[lost][:, nodes].min() == pytest.approx(0.05, rel=0.01)
    assert ledger_residual(with_loss) < 1e-10


def test_the_energy_of_the_lost_blade_leaves_as_work(file: Path) -> None:
    given = tables(file, reduction={"boundary": "consistent"}, march__time_step=DT / 10.0)
    problem = prepare(bw.case_from(given)).problem
    short = round(10.0 * LOST_AT / DT)
    scheme = make_scheme(problem, DT / 10.0, 10_000)
    state = scheme.advance(scheme.init(), short)[0]
    after = scheme.advance(state, 3, 1)[1]
    scheme = make_scheme(replace(problem, loss=None), DT / 10.0, 10_000)
    before = scheme.advance(scheme.init(), short)[0]
    whole = scheme.advance(before, 3, 1)[1]
    modes = len(problem.rotor.frequency) // 3
    own = slice(modes, 2 * modes)
    moved, rate = whole.rotor_displacement[0, own], whole.rotor_velocity[0, own]
    energy = 0.5 * float((rate**2).sum() + (problem.rotor.frequency[own] ** 2 * moved**2).sum())
    assert energy > 1e-3
    assert whole.external_work[0] - after.external_work[0] == pytest.approx(energy, rel=1e-2)
    assert whole.energy[0] - after.energy[0] == pytest.approx(energy, rel=1e-2)


def test_blades_in_a_flexible_casing_go_on_as_a_stage_of_fewer_copies(file: Path) -> None:
    ring = {
        "type": "ring",
        "clearance": "0.3 mm",
        "elements": 30,
        "support": "20 N/mm2",
        "wall": {"width": "60 mm", "thickness": "6 mm"},
    }
    given = tables(file, casing=ring, reduction={"boundary": "consistent"})
    given["march"]["time_step"], given["march"]["record_step"] = DT / 4.0, 4e-5
    given["excitation"] = {
        "type": "casing-distortion",
        "nodal_diameter": 2,
        "modal_force": 3000.0,
        "duration": 1.0,
    }
    stage = build_stage(bw.case_from(given))
    problem, dt = problem_of(stage), DT / 4.0
    assert problem.loss is not None
    scheme = SuddenChanges(problem, dt, 80)
    at_loss, before, _ = scheme.advance(scheme.init(), round(LOST_AT / dt))
    after = scheme.advance(at_loss, round((END - LOST_AT) / dt))[1]
    assert before.contact_steps.any()
    rotor = problem.rotor
    modes = len(rotor.frequency) // 3
    kept = np.arange(3 * modes) // modes != 1
    nodes = np.arange(9) // 3 != 1
    fewer = replace(
        rotor,
        frequency=rotor.frequency[kept],
        damping_ratio=rotor.damping_ratio[kept],
        centre=rotor.centre[:, kept],
        tip_angle=rotor.tip_angle[nodes],
        tip_recess=rotor.tip_recess[nodes],
        column=rotor.column[kept],
        dampers=rotor.dampers[:, kept],
        copies=2,
    )
    loads = tuple(replace(load, rotor=load.rotor[kept]) for load in problem.loads)
    still = np.zeros(kept.sum())
    start = Start.of_rotor(still, still, len(problem.casing.frequency))
    two = replace(problem, rotor=fewer, loads=loads, start=start, loss=None)
    other = CentralDifference(two, dt, 80)
    state = other.begin(at_loss.step, start, two.rotation_at(LOST_AT))
    whole = at_loss.arrays["whole"]
    at = KernelState(step=at_loss.step, arrays=whole)
    phase = CentralDifference(replace(problem, loss=None), dt, 80)
    rows = [phase.displacements(at, row) for row in (0, 1)]
    arrays = dict(state.arrays)
    for place, name in enumerate(("rotor", "casing")):
        moved = [each[place][kept] if name == "rotor" else each[place] for each in rows]
        slots = np.array([*moved, np.zeros_like(moved[0])])
        arrays[name] = other._arrangements[place].pack(slots)
    arrays["until"] = arrays["until"] - 1.0
    alone = other.advance(replace(state, arrays=arrays), round((END - LOST_AT) / dt))[1]
    assert alone.contact_steps.any()
    for name in ("casing_displacement", "contact_impulse", "rotor_displacement"):
        one, two_blades = getattr(after, name)[1:], getattr(alone, name)[1:]
        if name == "rotor_displacement":
            one = one[:, kept]
        elif name == "contact_impulse":
            one = one[:, nodes]
        np.testing.assert_allclose(one, two_blades, atol=1e-9 * np.abs(one).max())


def test_a_resumed_march_is_the_same(file: Path) -> None:
    problem = prepare(bw.case_from(tables(file))).problem
    scheme, last = make_scheme(problem, DT, 20), round(END / DT)
    whole = scheme.advance(scheme.init(), last)[0]
    for stop in (4990, 5000, 5001, 7777):
        half = scheme.advance(scheme.init(), stop)[0]
        other = make_scheme(problem, DT, 20)
        rest = other.advance(state_from(other.init(), state_arrays(half)), last - stop)[0]
        for name in ("rotor", "work", "force"):
            np.testing.assert_array_equal(
                rest.arrays["lost"][name], whole.arrays["lost"][name], err_msg=name
            )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"blade_loss": {"blade": 3, "time": 0.01}}, "blade_loss.blade = 3: expected blades from"),
        (
            {"blade_loss": {"blade": 1, "time": 0.01, "from": 0.4}},
            "blade_loss.from = 0.4: expected 0 with bladed_disk.superelement",
        ),
        ({"blade_loss": {"blade": 1, "time": 1e-7}}, "blade_loss.time = 1e-7: expected a time"),
    ],
)
def test_what_cannot_be_lost_is_refused(file: Path, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(CaseError) as error:
        prepare(bw.case_from(tables(file) | changes))
    assert message in str(error.value)


def test_blades_of_a_wheel_cannot_be_taken_out(file: Path) -> None:
    given = tables(file)
    given["bladed_disk"] = {"superelement": {"file": str(file), "kind": "wheel", "copies": 3}}
    with pytest.raises(CaseError, match=r"blade_loss\.blade.*a wheel is reduced as one body"):
        bw.case_from(given)
