"""The coupled modes of a finite element stage, and the growth they give."""

from functools import cache

import numpy as np
import pytest

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.shaft import Shaft
from bladewhirl.models.coupling.stage_modes import StageModes, stage_modes
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.solvers.stability.zones import unstable_zones


@cache
def stage(damping_ratio: float = 0.0, clamped: bool = False) -> StageModes:
    """The default case: paper's stage with a soft casing support and thicker disk beams."""
    modal = modal_model(Case(shaft=Shaft(clamped=clamped)))
    return stage_modes(modal, damping_ratio=damping_ratio)


def reference() -> float:
    return stage().modal.reference_frequency


def test_six_modes_are_the_papers() -> None:
    six = stage().six_modes()
    assert six.modes.name == ("casing k=1", "1F k=1", "suspension")
    assert six.modes.size == 6
    assert six.modes.frequency / reference() == pytest.approx([0.055, 1.0, 2.527], abs=5e-4)


def test_physical_amplitudes() -> None:
    """Of casing, 1F and suspension: 0.202, 0.011 and 0.105 kg^-1/2; a ring moves by sqrt(1/m)."""
    casing, first, suspension = stage().six_modes().modes.amplitude
    ring_mass = 7800.0 * 0.1 * 0.01 * 2.0 * np.pi * 0.501
    assert casing == pytest.approx(np.sqrt(1.0 / ring_mass), rel=1e-3)
    assert [first, suspension] == pytest.approx([0.011, 0.105], rel=2e-2)


def test_amplitudes_are_those_of_the_fields_everywhere() -> None:
    """Cosine and sine of a pair give the tips a cos k theta and a sin k theta, with one a."""
    modes = stage().modes
    disk, casing = stage().modal.beams, stage().modal.casing
    disk_modes, casing_modes = stage().modal.disk_modes, stage().modal.casing_modes
    assert modes.entries > 50
    for i, number in enumerate(stage().number):
        k = modes.nodal_diameter[i]
        numbers = np.array([number, number + 1])
        if modes.on_casing[i]:
            field = casing.nodal(casing_modes.fields(numbers))[:, 0]
            angle, frequency = casing.mesh.angles, casing_modes.frequency
        else:
            field = disk_modes.fields(numbers)[disk.tip_radial]
            angle, frequency = disk.tip_angles, disk_modes.frequency
        assert modes.frequency[i] == frequency[number]
        a = modes.amplitude[i]
        assert field[:, 0] == pytest.approx(a * np.cos(k * angle), abs=1e-6 * abs(a))
        if modes.paired[i]:
            assert field[:, 1] == pytest.approx(a * np.sin(k * angle), abs=1e-6 * abs(a))


@pytest.mark.slow
def test_all_modes_have_zones_at_their_own_coincidence_speeds() -> None:
    """Beyond the paper: a chart of all nodal diameters. Six modes hide those of k = 2 and more."""
    whole = stage().with_unit_amplitudes().modes
    unit = reference()
    zones = unstable_zones(whole, kappas=np.array([1e-3]), low=0.6 * unit, high=1.6 * unit)
    names = [whole.name[casing] for casing in zones.casing]
    actual = dict(zip(names, zones.lower / unit, strict=True))
    assert actual == pytest.approx(
        {
            "casing k=1": 1.0550,
            "casing k=2": 0.8319,
            "casing k=3": 0.9402,
            "casing k=4": 1.1161,
            "casing k=5": 1.3172,
            "casing k=6": 1.5306,
        },
        abs=1e-4,
    )


def test_physical_amplitudes_weaken_the_coupling() -> None:
    """By amplitudes 0.202 and 0.011 for zone A at the same stiffness."""
    unit = reference()
    widths = []
    for system in (stage().six_modes(), stage().six_modes().with_unit_amplitudes()):
        zones = unstable_zones(
            system.modes, kappas=np.array([1e-2]), low=0.9 * unit, high=1.2 * unit
        )
        widths.append(zones.upper[0] - zones.lower[0])
    casing, first, _ = stage().six_modes().modes.amplitude
    assert widths[0] / widths[1] == pytest.approx(casing * first, rel=1e-2)


def test_clamped_centre_has_no_suspension_modes() -> None:
    with pytest.raises(ValueError, match="the stage has no pair of suspension modes"):
        stage(clamped=True).six_modes()
