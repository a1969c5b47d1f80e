"""Marches that start on periodic motions."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from command_line import answer
from periodic_cases import case
from places import ROOT
from sweep_work import in_process

import bladewhirl as bw
from bladewhirl.models.stage.build import build_stage
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.search import periodic_motion
from bladewhirl.studies.periodic import initial_states
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory
from bladewhirl.studies.sweeps.starts import begun

WIDE = {"casing.closure": None, "casing.clearance": "0.25 mm"}
LARGE = {"march.speed": "7200 rpm", "march.duration": "0.03 s"}
SMALL = {"march.speed": "7500 rpm", "march.duration": "0.03 s"}
TURNED = {"harmonics": [{"lobes": 2, "amplitude": "0.27 mm", "phase": "75 deg"}]}
RING = {
    "casing.type": "ring",
    "casing.support": "20 N/mm2",
    "casing.wall": {"width": "60 mm", "thickness": "8 mm"},
    "bladed_disk.superelement.copies": 2,
    "damping.ratio": 0.05,
}


def marched(own: bw.Case) -> tuple[float, xr.Dataset]:
    """Return the impulse per revolution of the periodic motion of a case, and a march from it."""
    stage = build_stage(own)
    found = initial_states.start_of(stage)
    assert found is not None
    start, impulse = found
    prepared = prepare(stage, lambda problem, timing: (begun(problem, start), timing))
    return impulse, march_in_memory(prepared)[0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "tolerance"),
    [
        pytest.param(LARGE | {"casing.profile": TURNED}, 5e-4, id="contact at the start"),
        pytest.param(SMALL | {"bladed_disk.superelement.copies": 2}, 5e-4, id="blades"),
        pytest.param(RING | {"march.duration": "0.03 s"}, 1e-2, id="flexible ring"),
    ],
)
def test_each_revolution_has_the_impulse_of_the_periodic_motion(
    changes: dict[str, Any], tolerance: float
) -> None:
    own = case(**changes)
    impulse, result = marched(own)
    turns = result["time"].values * result.attrs["speed"] / (2.0 * np.pi)
    total = np.cumsum(result["contact_impulse"].values.sum(axis=1))
    each = np.diff(np.interp(np.arange(int(turns[-1]) + 1), turns, total))
    assert each == pytest.approx(impulse, rel=tolerance)


@pytest.mark.slow
def test_contact_of_an_imbalance_stays_constant() -> None:
    own = bw.with_values(
        bw.read_case(ROOT / "examples" / "imbalance.toml"), {"march.duration": 0.05}
    )
    _, result = marched(own)
    radius = np.hypot(*(result["centre_shape"].values @ result["rotor_displacement"].values.T))
    assert radius == pytest.approx(radius[0], rel=2e-4)
    assert bw.periodic(own)["centre"].values[0] == pytest.approx(
        result["centre_shape"].values @ result["rotor_displacement"].values[0]
    )


@pytest.mark.slow
def test_a_sweep_starts_on_the_large_motion(tmp_path: Path) -> None:
    """At 7450 rpm there are two stable motions; marches from rest come to the small one."""
    file = tmp_path / "case.toml"
    file.write_text(bw.dumps_case(case(**WIDE, **{"march.duration": "0.1 s"})))
    found = {}
    for start in ("periodic", "rest"):
        speeds = "march.speed=7200 rpm,7450 rpm,7600 rpm"
        answer("sweep", file, "--over", speeds, "--start", start, "-o", tmp_path / start)
        with bw.open_sweep(tmp_path / start) as sweep:
            found[start] = sweep["impulse_per_revolution"].values
            if start == "periodic":
                assert sweep["start"].values.tolist() == ["periodic"] * 3
                assert found[start] == pytest.approx(sweep["start_impulse"].values, rel=1e-3)
    assert found["periodic"][1] > 80.0
    assert found["rest"][1] < 5.0
    assert (tmp_path / "periodic" / "branches" / "0" / "branch.nc").exists()


@pytest.mark.slow
def test_where_no_motion_is_found_the_march_starts_at_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The point says so; the other one starts on the motion of the search, as it has no branch."""

    def fails_in_the_narrow_wall(blade: Any) -> Any:
        if blade.clearance[:, 0].min() < 7e-5:
            raise NotConverged("")
        return periodic_motion(blade)

    monkeypatch.setattr(initial_states, "periodic_motion", fails_in_the_narrow_wall)
    monkeypatch.setattr(initial_states, "branch", pytest.fail)
    monkeypatch.setattr(initial_states, "follow", lambda *_: None)
    own = case(**{**WIDE, "march.speed": "7500 rpm", "march.duration": "0.02 s"})
    with in_process():
        clearances: Any = {"casing.clearance": ["0.32 mm", "0.38 mm"]}
        bw.run_sweep(own, clearances, tmp_path / "s", start="periodic")
    with bw.open_sweep(tmp_path / "s") as sweep:
        assert sweep["start"].values.tolist() == ["rest", "periodic"]
        assert np.isnan(sweep["start_impulse"].values[0])
        assert sweep["start_impulse"].values[1] == 0.0  # the motion of the search has no contact
        assert "start" in sweep.attrs["start_rule"]
    bw.report(tmp_path / "s", tmp_path / "report.html")
    assert "1 of 2 marches start on a periodic motion" in (tmp_path / "report.html").read_text()
