"""Errors of contact in the time step that the documentation states, without and with dampers."""

import re
from dataclasses import replace

import numpy as np
import pytest
from contact_cases import problem, run, run_reference, small_casing, small_rotor
from places import ROOT

from bladewhirl.models.case.case import Case
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Load

ERRATA = " ".join((ROOT / "docs" / "errata.md").read_text(encoding="utf-8").split())

GAP, END = 1e-3, 0.006
BLADE, CASING = 1.0, 20.0  # kg
DAMPERS = {"mounts": 3e3, "strong": 6e4}  # N s/m


def pushed(damping: float) -> ContactProblem:
    """A blade of 1 kg at 1 m/s, 1 mm from a casing of 20 kg on a spring and a damper."""
    nodal = np.zeros((4, 4, 1))
    nodal[:, 0] = 1.0 / np.sqrt(CASING)
    dampers = np.array([[np.sqrt(damping / CASING)]])
    casing = small_casing(np.array([2.0 * np.pi * 40.0]), GAP, nodal=nodal, dampers=dampers)
    rotor = small_rotor(
        np.array([2.0 * np.pi * 60.0]), tip_radial=np.full((1, 1), 1.0 / np.sqrt(BLADE))
    )
    return problem(rotor, casing, start={"rotor_velocity": np.array([np.sqrt(BLADE)])})


def difference(damping: float, dt: float) -> float:
    """Largest difference of the blade from a march whose dampers feel contact at once, over the
    gap."""
    given, steps = pushed(damping), round(END / dt)
    exact = run_reference(given, dt, steps, dampers_feel_contact=True)
    assert exact.contact_impulse.any()
    apart = run(given, dt, steps)[1].rotor_displacement - exact.rotor_displacement
    return float(np.abs(apart).max() / GAP)


def impulse(dt: float) -> float:
    """Of the blade pressed against the casing by 10 kN, without dampers [N s]."""
    load = Load(rotor=np.array([1e4 / np.sqrt(BLADE)]), casing=np.zeros(1))
    _, chunk, _ = run(replace(pushed(0.0), loads=(load,)), dt, round(END / dt))
    return float(chunk.contact_impulse.sum())


def test_contact_without_dampers_is_of_the_first_order_as_the_document_states() -> None:
    *coarse, finest = (impulse(dt) for dt in (1e-6, 5e-7, 2.5e-7, 1.25e-7))
    short = 1.0 - np.array(coarse) / finest
    np.testing.assert_allclose(short / short[-1], [7.0, 3.0, 1.0], rtol=0.01)
    stated = re.search(r"by (\S+), (\S+) and (\S+) of the latter", ERRATA)
    assert stated
    np.testing.assert_allclose(short, [float(each) for each in stated.groups()], rtol=0.03)


@pytest.mark.slow
def test_the_error_that_the_document_states() -> None:
    stated = re.findall(r"(\S+) of the gap for dampers of (\d+) kN s/m", ERRATA)
    assert [1e3 * float(each) for _, each in stated] == [*DAMPERS.values()]
    value, damping = stated[-1]
    actual = difference(1e3 * float(damping), Case().march.time_step)
    assert actual == pytest.approx(float(value), rel=0.06)
