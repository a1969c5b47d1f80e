"""A tuned stage by the cyclic path and by the dense one: symmetry is found, and only saves time."""

from functools import cache
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la

import bladewhirl.models.elements.structure as structures
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.check import case_from
from bladewhirl.models.coupling.stage_modes import stage_modes
from bladewhirl.models.coupling.stage_waves import coupled_waves
from bladewhirl.models.modal.full_stage import ModalStage, modal_stage
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.stage import Stage, build_stage
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.stability.growth import growth_rate
from bladewhirl.solvers.stability.zones import unstable_zones

SAME = 1e-9


def case(blades: int = 8) -> Case:
    """A small stage with curved, shrouded blades, pressed by a load at its centre."""
    return case_from(
        {
            "bladed_disk": {
                "blades": blades,
                "elements_per_blade": 4,
                "centre_line": [{"span": 1.0, "angle": "8 deg"}],
                "shrouds": [{"radius": 0.3, "width": 0.02, "thickness": 0.005}],
                "tip_mass": "20 g",
            },
            "casing": {"elements": 24},
            "reduction": {"fixed_interface_modes": 3 * blades},
            "excitation": {"type": "imbalance", "clearance_speed": 0.5, "ramp": 0.0},
            "initial": {"tip_velocity": [[2.0 + 0.1 * blade, -0.5] for blade in range(blades)]},
            "march": {"speed": 1.1},
        }
    )


@cache
def stages(blades: int = 8) -> tuple[Stage, Stage]:
    """By the cyclic path, and by the dense one."""
    cyclic = build_stage(case(blades))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(structures.Structure, "is_cyclic", False)
        dense = build_stage(case(blades))
    return cyclic, dense


@cache
def modal_stages(blades: int = 8) -> tuple[ModalStage, ModalStage]:
    """The same of the full models; the casing keeps its symmetry, which stability asks for."""
    cyclic = modal_stage(case(blades))
    with pytest.MonkeyPatch.context() as patch:
        actual: Any = structures.Structure.__dict__["is_cyclic"]
        patch.setattr(
            structures.Structure,
            "is_cyclic",
            property(lambda self: self.layout.sectors == 24 and actual.func(self)),
        )
        dense = modal_stage(case(blades))
    return cyclic, dense


def test_the_paths_are_two() -> None:
    cyclic, dense = stages()
    assert cyclic.symmetry["bladed_disk"] == "8 equal sectors: cyclic path"
    assert cyclic.reduction.modes.is_cyclic
    assert not dense.reduction.modes.is_cyclic
    assert not dense.casing_modes.is_cyclic


def test_frequencies_and_families() -> None:
    cyclic, dense = stages()
    for one, other in (
        (cyclic.reduction.modes, dense.reduction.modes),
        (cyclic.casing_modes, dense.casing_modes),
    ):
        highest = one.frequency.max()
        # A rigid motion's frequency is the root of a rounding error.
        np.testing.assert_allclose(one.frequency, other.frequency, rtol=SAME, atol=1e-7 * highest)
        moving = one.frequency > 1e-3 * highest
        np.testing.assert_allclose(one.frequency[moving], other.frequency[moving], rtol=SAME)
    for family in ("suspension", "1F", "2F", "3F"):
        assert cyclic.disk_family.count(family) == dense.disk_family.count(family) > 0
    assert cyclic.reference_frequency == pytest.approx(dense.reference_frequency, rel=SAME)
    full, flat = cyclic.disk_frequencies, dense.disk_frequencies[-1]
    for k, values in full.items():
        for value in values[values < flat[-1] * (1.0 - SAME)]:
            assert abs(flat - value).min() <= SAME * value, k


@pytest.mark.parametrize("damping", [0.0, 0.005])
@pytest.mark.parametrize("blades", [8, 7])
def test_growth_rates(damping: float, blades: int) -> None:
    """Amid the unstable zones, and away from them."""
    cyclic, dense = modal_stages(blades)
    one = stage_modes(cyclic, damping_ratio=damping)
    other = coupled_waves(dense, modes="all", damped=damping > 0.0, physical=True)
    assert other.turning is not None
    assert one.modes.size == len(other.frequency)
    kappa = 5e4
    undamped = stage_modes(cyclic, damping_ratio=0.0).modes
    ends = np.array([0.5, 3.0]) * cyclic.reference_frequency
    zones = unstable_zones(undamped, kappas=np.array([kappa]), low=ends[0], high=ends[1])
    speeds = np.append(0.5 * (zones.lower + zones.upper), ends)
    expected = growth_rate(one.modes, speed=speeds, kappa=kappa)
    assert np.count_nonzero(growth_rate(undamped, speed=speeds, kappa=kappa) > 0.1) > 1
    for speed, growth in zip(speeds.tolist(), expected.tolist(), strict=True):
        actual = la.eigvals(other.state_matrix(speed, kappa)).real.max()
        assert actual == pytest.approx(growth, abs=SAME * speed)


def test_single_steps() -> None:
    """Ten steps from the same start, tips in the casing from the first on."""
    actual = []
    for stage in stages():
        problem = contact_problem(stage)
        scheme = CentralDifference(problem, 2e-6, 1)
        assert scheme.cyclic == (stage is stages()[0],) * 2
        _, chunk, _ = scheme.advance(scheme.init(), 700)
        tips = stage.rotor.tip_radial @ chunk.rotor_displacement.T
        wall = stage.reduced_casing.nodal[:, 0] @ chunk.casing_displacement.T
        actual.append((tips, wall, chunk.contact_impulse, chunk.gap))
    assert np.count_nonzero(actual[0][2]) > 5
    for one, other in zip(*actual, strict=True):
        np.testing.assert_allclose(one, other, atol=SAME * abs(one).max())
