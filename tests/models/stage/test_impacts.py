"""Impacts and rubs with exact answers: what `bladewhirl verify` leaves of their marches."""

from __future__ import annotations

import numpy as np
import pytest
from contact_cases import ledger_residual

from bladewhirl.studies.verification.contact import (
    BARS,
    OSCILLATORS,
    bouncing_bar,
    collision,
    coulomb_pad,
    oscillator,
)


@pytest.mark.parametrize("name", BARS)
def test_bars_meet_in_time_without_overlap(name: str) -> None:
    met = collision(name)
    chunk = met.chunk
    touching = chunk.contact_impulse[:, 0] > 0.0
    assert chunk.time[touching][0] == pytest.approx(met.known["start"], abs=2.0 * met.dt)
    assert np.abs(chunk.gap[touching]).max() < 1e-12
    assert ledger_residual(chunk) < 1e-10


def test_first_contact_of_a_bouncing_bar() -> None:
    """From 1 to 5/3 s, the force rising as t: its centre is at 49/36 s."""
    chunk = bouncing_bar()
    dt, first = chunk.time[1], chunk.time < 8.0 / 3.0
    impulse = chunk.contact_impulse[first, 0]
    assert chunk.time[first][impulse > 0.0][0] == pytest.approx(1.0, abs=2.0 * dt)
    centre = np.average(chunk.time[first], weights=impulse)
    assert centre == pytest.approx(49.0 / 36.0, abs=1e-3)


@pytest.mark.parametrize("name", OSCILLATORS)
def test_releases_of_an_oscillator_from_its_stop(name: str) -> None:
    """Each within two steps of its exact time.

    A contact that the impact ends has no release of its own: the mass leaves at once.
    """
    case, chunk = oscillator(name)
    impulse, dt = chunk.contact_impulse[:, 0], chunk.time[1]
    touching = np.r_[False, impulse > 1e-12 * impulse.max(), False]
    edges = np.flatnonzero(touching[1:] != touching[:-1])
    times = np.append(chunk.time, np.inf)
    begins, ends = times[edges[::2]], times[edges[1::2]]
    exact = [e["time"] for e in case["events"] if e["event"] == "release" and e["time"] < 1.2]
    lasting = np.isfinite(ends) & (ends - begins > 10.0 * dt)
    np.testing.assert_allclose(ends[lasting], exact, atol=2.0 * dt)
    assert np.abs(chunk.gap[impulse > 0.0]).max() < 1e-12
    assert ledger_residual(chunk) < 1e-8


def test_oscillator_at_rest_on_its_stop() -> None:
    case, chunk = oscillator("C1")
    force = chunk.contact_impulse[-1, 0] / chunk.time[1]
    assert force == pytest.approx(case["resting_force"], rel=1e-6)
    assert chunk.rotor_displacement[-1, 0] == pytest.approx(case["gap"], rel=1e-12)
    assert chunk.contacts[-1] == 1


def test_coulomb_pad_carries_its_weight() -> None:
    chunk, dt = coulomb_pad()
    np.testing.assert_allclose(chunk.contact_impulse[2:-1], 10.0 * dt, rtol=1e-9)
    assert ledger_residual(chunk) < 1e-9
