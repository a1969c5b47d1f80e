"""Growth rates, zones and tracked branches, against closed forms, scans and the real system."""

from dataclasses import replace

import numpy as np
import pytest
from coupled_system import CASING, FIRST, SUSPENSION, UNIT, six_modes
from long_cases import slow_except

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.coupling.springs import CouplingModes
from bladewhirl.solvers.stability.growth import (
    coincidence_speeds,
    eigenvalues,
    growth_rate,
    is_unstable,
    rotor_waves,
    track,
)
from bladewhirl.solvers.stability.zones import unstable_zones


def random_pairs(seed: int) -> CouplingModes:
    """One to three casing and rotor pairs of k = 2."""
    rng = np.random.default_rng(seed)
    casing, rotor = rng.integers(1, 4, 2)
    count = int(casing + rotor)
    return CouplingModes(
        name=("pair",) * count,
        on_casing=np.arange(count) < casing,
        nodal_diameter=np.full(count, 2),
        frequency=rng.uniform(0.05, 5.0, count),
        amplitude=rng.uniform(0.1, 1.5, count),
        damping_ratio=np.zeros(count),
        paired=np.ones(count, dtype=bool),
    )


@pytest.mark.parametrize("damping_ratio", [0.0, 0.02])
def test_half_size_spectrum_is_that_of_equation_21(damping_ratio: float) -> None:
    modes = six_modes(damping_ratio)
    for speed, kappa in ((0.8, 100.0), (1.17, 500.0), (2.7, 900.0)):
        full = np.linalg.eigvals(modes.equations.state_matrix(speed * UNIT, kappa))
        ours = eigenvalues(modes, speed=speed * UNIT, kappa=kappa)
        distance = np.abs(full[:, None] - ours)
        assert distance.min(axis=0) == pytest.approx(0.0, abs=1e-9 * UNIT)
        assert distance.min(axis=1) == pytest.approx(0.0, abs=1e-9 * UNIT)


def turning_pairs(damping_ratio: float, *, mirrored: bool) -> CouplingModes:
    """Two casing pairs of k = 2 and one of k = 3, three rotor pairs of k = 2 that turn."""
    drawn = np.random.default_rng(7).normal(scale=0.05, size=(2, 6, 6))
    whole = drawn[0] * (not mirrored) + 1j * drawn[1]
    whole[:3] = whole[:, :3] = 0.0
    coriolis, softening = (
        np.kron(matrix.real, np.eye(2)) + np.kron(matrix.imag, [[0.0, -1.0], [1.0, 0.0]])
        for matrix in (whole - whole.conj().T, 1j * whole - 1j * whole.conj().T)
    )
    return CouplingModes(
        name=("casing",) * 3 + ("rotor",) * 3,
        on_casing=np.arange(6) < 3,
        nodal_diameter=np.array([2, 2, 3, 2, 2, 2]),
        frequency=np.array([0.4, 1.7, 0.9, 2.2, 1.0, 3.1]),
        amplitude=np.array([0.5, 0.4, 0.6, 0.3, 0.8, -0.5]),
        damping_ratio=np.full(6, damping_ratio),
        paired=np.ones(6, dtype=bool),
        gyroscopic=2.0 * coriolis,
        stiffness_speed=softening,
    )


@pytest.mark.parametrize("mirrored", [True, False])
@pytest.mark.parametrize("damping_ratio", [0.0, 0.02])
def test_rotors_that_turn_have_the_same_spectrum_at_half_the_size(
    damping_ratio: float, mirrored: bool
) -> None:
    modes = turning_pairs(damping_ratio, mirrored=mirrored)
    point = modes.harmonic(2).equations.whirl_matrix(0.7, 0.3)
    assert np.isrealobj(point) is (mirrored and not damping_ratio)
    for speed in (0.7, -1.9):
        full = np.linalg.eigvals(modes.equations.state_matrix(speed, 0.3))
        distance = np.abs(full[:, None] - eigenvalues(modes, speed=speed, kappa=0.3))
        assert distance.min(axis=0) == pytest.approx(0.0, abs=1e-9)
        assert distance.min(axis=1) == pytest.approx(0.0, abs=1e-9)
        alone = modes.take([3, 4, 5])
        rates = map(alone.over_entries, (alone.gyroscopic, alone.stiffness_speed))
        turning, softening = rates
        waves = rotor_waves(alone, speed)
        assert len(np.unique(np.round(waves, 6))) == 6
        for nu in waves:
            drag = speed * turning + np.diag(alone.damping_rate)
            held = np.diag(alone.frequency**2 - nu**2) + speed**2 * softening
            assert np.linalg.svd(held + 1j * nu * drag)[1].min() < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("mirrored", [True, False])
def test_waves_of_a_rotor_that_turns_meet_the_casing_s_where_a_scan_says(mirrored: bool) -> None:
    modes = turning_pairs(0.0, mirrored=mirrored)
    actual = coincidence_speeds(modes)
    rotor, speeds = np.arange(3, 6), np.linspace(1e-3, 8.0, 2001)
    waves = [np.sort(rotor_waves(modes.take(rotor), speed).real) for speed in speeds]
    expected = {}
    for casing in (0, 1):
        ahead = np.array(waves) - (modes.frequency[casing] - 2.0 * speeds)[:, None]
        for behind, mode in enumerate(rotor[np.argsort(modes.frequency[rotor])]):
            met = np.flatnonzero(np.diff(np.sign(ahead[:, 2 - behind])))
            if met.size:
                expected[casing, int(mode)] = speeds[met[0]]
    assert len(expected) == 6
    assert actual == pytest.approx(expected, abs=8e-3)


def test_no_springs_no_growth() -> None:
    speeds = np.linspace(0.6, 3.0, 400) * UNIT
    assert not is_unstable(growth_rate(six_modes(), speed=speeds, kappa=0.0), speeds).any()
    damped = growth_rate(six_modes(0.01), speed=speeds, kappa=0.0)
    assert damped == pytest.approx(-0.01 * CASING, rel=1e-6)


def test_zones_start_at_the_coincidence_speeds_and_widen() -> None:
    """Claim 10; the shift of claim 13 upwards."""
    modes = six_modes()
    kappas = np.array([1e-6, 10.0, 100.0, 500.0, 1000.0])
    zones = unstable_zones(modes, kappas=kappas, low=0.6 * UNIT, high=3.0 * UNIT)
    coincidence = coincidence_speeds(modes)
    expected = {(0, 1): CASING + FIRST, (0, 2): CASING + SUSPENSION}
    assert coincidence == pytest.approx(expected, rel=1e-12)
    for rotor in (1, 2):
        zone = zones.rotor == rotor
        assert zones.kappa[zone].tolist() == kappas.tolist()
        assert zones.lower[zone][0] == pytest.approx(coincidence[0, rotor], rel=1e-8)
        assert np.all(np.diff(zones.upper[zone] - zones.lower[zone]) > 0.0)
        assert np.all(np.diff(zones.lower[zone]) > 0.0)


def test_co_rotating_combinations_give_no_instability() -> None:
    """k Omega = |w_c - w_r| and the crossings of waves of one body stay stable (claim 14)."""
    modes = replace(six_modes(), frequency=np.array([1.5, 1.0, 2.6]))
    speeds = np.concatenate([np.linspace(c - 0.1, c + 0.1, 401) for c in (0.5, 1.1, 0.8)])
    assert np.all(growth_rate(modes, speed=speeds, kappa=0.02 / np.pi) == 0.0)
    zones = unstable_zones(modes, kappas=np.array([1e-8]), low=0.0, high=10.0)
    assert zones.lower == pytest.approx([2.5, 4.1], rel=1e-6)


def test_printed_sign_of_equation_18_gives_no_instability() -> None:
    """With the gyroscopic block of q5, q6 as printed zones A and B are not there (erratum)."""
    modes, kappa = six_modes(), 500.0
    unstable = {True: 0, False: 0}
    for speed in np.linspace(0.6, 3.0, 97) * UNIT:
        gyroscopic, stiffness = modes.equations.autonomous(speed, kappa)
        printed = gyroscopic.copy()
        printed[:2, :2] *= -1.0  # the casing's coordinates stand first here
        for as_printed, matrix in ((True, printed), (False, gyroscopic)):
            state = np.block([[np.zeros((6, 6)), np.eye(6)], [-stiffness, -matrix]])
            growth = np.linalg.eigvals(state).real.max()
            unstable[as_printed] += bool(is_unstable(growth, speed))
    assert unstable[True] == 0
    assert unstable[False] >= 5


@pytest.mark.parametrize("seed", slow_except(range(30), *range(8)))
def test_zones_hold_exactly_the_unstable_points_of_a_scan(seed: int) -> None:
    modes, kappa = random_pairs(seed), 10.0 ** np.random.default_rng(seed).uniform(-2.0, 1.5)
    speeds = np.linspace(0.01, 6.0, 400)
    zones = unstable_zones(modes, kappas=np.array([kappa]), low=speeds[0], high=speeds[-1])
    inside = np.any((speeds >= zones.lower[:, None]) & (speeds <= zones.upper[:, None]), axis=0)
    scanned = is_unstable(growth_rate(modes, speed=speeds, kappa=kappa), speeds)
    assert inside.tolist() == scanned.tolist()


@pytest.mark.parametrize("damping_ratio", [0.0, 0.005])
def test_borders_part_growth_from_stability(damping_ratio: float) -> None:
    modes = six_modes(damping_ratio)
    zones = unstable_zones(modes, kappas=np.array([50.0, 700.0]), low=0.6 * UNIT, high=3.0 * UNIT)
    assert zones.kappa.tolist() == [50.0, 50.0, 700.0, 700.0]
    gap = 1e-7 * UNIT
    for border, outwards in ((zones.lower, -1.0), (zones.upper, 1.0)):
        for side, unstable in ((outwards, False), (-outwards, True)):
            speed = border + side * gap
            growth = growth_rate(modes, speed=speed, kappa=zones.kappa)
            assert is_unstable(growth, speed).tolist() == [unstable] * 4


@pytest.mark.parametrize("damping_ratio", [0.0, 0.002])
def test_zones_are_cut_at_the_ends_of_the_range(damping_ratio: float) -> None:
    low, high = 1.17 * UNIT, 2.7 * UNIT
    kappas = np.array([0.0, 490.0, 500.0])
    zones = unstable_zones(six_modes(damping_ratio), kappas=kappas, low=low, high=high)
    assert zones.kappa.tolist() == [490.0, 490.0, 500.0, 500.0]
    assert zones.lower[[0, 2]].tolist() == [low, low]
    assert zones.upper[[1, 3]].tolist() == [high, high]
    assert np.all(zones.upper[[0, 2]] < zones.lower[[1, 3]])


def test_zones_where_a_single_mode_meets_a_pair() -> None:
    """k = N/2: the zone starts at the coincidence too, found by sampling."""
    modes = replace(
        six_modes().take([0, 1]),
        nodal_diameter=np.array([4, 4]),
        frequency=np.array([1.0, 1.4]),
        paired=np.array([True, False]),
    )
    zones = unstable_zones(modes, kappas=np.array([0.02]), low=0.3, high=0.9)
    assert zones.lower < 0.62 < zones.upper
    speeds = np.linspace(0.3, 0.9, 301)
    inside = (speeds > zones.lower) & (speeds < zones.upper)
    scanned = is_unstable(growth_rate(modes, speed=speeds, kappa=0.02), speeds)
    assert inside.tolist() == scanned.tolist()


def test_modes_of_one_body_or_of_k_0_have_no_zones() -> None:
    rotor_only = six_modes().take([1, 2])
    breathing = replace(
        six_modes(), nodal_diameter=np.zeros(3, dtype=np.int64), paired=np.zeros(3, dtype=bool)
    )
    for modes in (rotor_only, breathing):
        zones = unstable_zones(modes, kappas=np.array([500.0]), low=1.0, high=1000.0)
        assert zones.kappa.size == 0


def test_growth_on_a_grid_reports_progress() -> None:
    speeds, kappas = np.linspace(0.6, 3.0, 90) * UNIT, np.linspace(0.0, 1000.0, 100)
    calls: list[tuple[int, int]] = []
    growth = growth_rate(
        six_modes(),
        speed=speeds,
        kappa=kappas[:, None],
        progress=lambda done, of: calls.append((done, of)),
    )
    assert growth.shape == (100, 90)
    assert growth[40, 33] == growth_rate(six_modes(), speed=speeds[33], kappa=kappas[40])
    assert calls[-1] == (9000, 9000)
    assert len(calls) > 1
    unstable = is_unstable(growth, speeds)
    assert not unstable[0].any()
    assert unstable[-1].any()


def test_growth_adds_nothing_across_nodal_diameters() -> None:
    first = six_modes()
    frequencies = first.frequency, 1.9 * first.frequency
    second = replace(first, nodal_diameter=np.full(3, 2), frequency=frequencies[1])
    both = replace(
        first.take([0, 1, 2, 0, 1, 2]),
        nodal_diameter=np.repeat([1, 2], 3),
        frequency=np.append(*frequencies),
    )
    speeds = np.linspace(0.6, 3.0, 200) * UNIT
    parts = [growth_rate(modes, speed=speeds, kappa=800.0) for modes in (first, second)]
    assert growth_rate(both, speed=speeds, kappa=800.0) == pytest.approx(np.maximum(*parts))


def test_branches_that_cross_keep_their_direction() -> None:
    x = np.linspace(-1.0, 1.0, 41)
    exact = np.stack([1j * x, -1j * x, 0.3 + 1j * x**2, 2.0 - 1j * x], axis=-1)
    rng = np.random.default_rng(3)
    shuffled = np.array([rng.permutation(row) for row in exact])
    shuffled[0] = exact[0]
    assert track(x, shuffled) == pytest.approx(exact, abs=1e-14)


def test_straight_branches_are_followed_across_uneven_steps() -> None:
    x = np.array([0.0, 0.01, 1.0, 1.02, 3.0, 3.01, 3.03, 10.0])
    exact = 1j * (np.outer(x, [-2.0, -1.0, 0.5, 3.0]) + np.array([0.3, 1.0, -1.0, 0.2]))
    rng = np.random.default_rng(5)
    shuffled = np.array([exact[0], *(rng.permutation(row) for row in exact[1:])])
    assert track(x, shuffled) == pytest.approx(exact, abs=1e-12)


def test_tracked_spectrum_is_continuous_and_complete() -> None:
    speeds = np.linspace(0.6, 3.0, 2401) * UNIT
    spectra = eigenvalues(six_modes(), speed=speeds, kappa=500.0)
    branches = track(speeds, spectra)
    assert np.sort_complex(branches[1200]) == pytest.approx(np.sort_complex(spectra[1200]))
    largest: FloatArray = np.abs(np.diff(branches, axis=0)).max(axis=1)
    assert largest.max() < 0.02 * UNIT  # untracked, sorted spectra jump by the unit
