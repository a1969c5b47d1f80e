"""Borders of the unstable zones by root finding (Fig. 11).

Without damping every real eigenvalue mu of `CoupledEquations.whirl_matrix` has a signature, the
sign of sum_i nu_i |X_i|^2 - i Omega X^H G X, where X is the eigenvector and nu_i the frequency of
entry i in the axes of its body. Two eigenvalues of opposite signature become complex, hence
unstable, when they meet; two eigenvalues of equal signature avoid each other. As the speed grows,
casing waves of positive signature pass below rotor waves of negative signature. Such an exchange
begins where the two waves meet and ends where they part; the speeds between are an unstable zone.
`exchanges` counts the exchanges begun and ended at a speed. Root finding locates every speed at
which a count changes by one, so that even the narrowest zone is found. With rotation effects two
waves may meet and part repeatedly, so the counts may also decrease; neighbouring speeds are then
searched for increases and decreases.

With damping, and for nodal diameters with a single mode, zones follow instead from the sign of the
growth rate at a series of speeds, which is denser inside the zones that are unstable without
damping.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.optimize.elementwise import find_root

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.coupling.equations import CoupledEquations
from bladewhirl.models.coupling.springs import CouplingModes
from bladewhirl.solvers.stability.growth import UNSTABLE_GROWTH, growth_rate

SAMPLES = 400
"""Number of speeds in the first sampling of the sign of the growth."""

INSIDE = 9
"""Number of speeds that are added to the samples inside each zone that is unstable without
damping."""


@dataclass(frozen=True, kw_only=True)
class UnstableZones:
    """Intervals of unstable speeds, one row for each zone at each spring stiffness.

    Intervals are cut off at the limits of the searched range. Entries are those of `CouplingModes`.
    """

    kappa: FloatArray  #: spring stiffness [N/m], (rows,)
    lower: FloatArray  #: speed at which the zone begins [rad/s], (rows,)
    upper: FloatArray  #: speed at which the zone ends [rad/s], (rows,)
    growth: FloatArray  #: growth rate in the middle of the zone [1/s], (rows,)
    casing: IntArray  #: number of the casing entry that moves most in the growing mode, (rows,)
    rotor: IntArray  #: number of the rotor entry that moves most in the growing mode, (rows,)


def unstable_zones(
    modes: CouplingModes, *, kappas: FloatArray, low: float, high: float
) -> UnstableZones:
    """Find every interval of unstable speeds at each spring stiffness.

    Args:
        modes: the coupled modes.
        kappas: spring stiffnesses [N/m], (n,); a stiffness of zero has no zones and gives no row.
        low: lowest speed [rad/s].
        high: highest speed [rad/s].

    Returns:
        rows sorted by nodal diameter, stiffness, speed.
    """
    kappas = np.asarray(kappas, dtype=np.float64)
    kappas = kappas[kappas > 0.0]
    zones: list[UnstableZones] = []
    for k in modes.harmonics if kappas.size else ():
        chosen = np.flatnonzero((modes.nodal_diameter == k) & (modes.amplitude != 0.0))
        bodies = np.unique(modes.on_casing[chosen])
        if k == 0 or len(bodies) < 2:
            continue  # positive definite in one frame: stable at every speed
        part = modes.take(chosen)
        row, lower, upper = _intervals(part, kappas, low, high)
        middle = 0.5 * (lower + upper)
        growth, leading = _growing_mode(part, middle, kappas[row])
        casing, rotor = (
            chosen[np.argmax(np.where(part.on_casing == body, leading, -1.0), axis=-1)]
            for body in (True, False)
        )
        zones.append(
            UnstableZones(
                kappa=kappas[row],
                lower=lower,
                upper=upper,
                growth=growth,
                casing=casing,
                rotor=rotor,
            )
        )
    none, numbers = np.zeros(0), np.zeros(0, dtype=np.int64)
    empty = UnstableZones(
        kappa=none, lower=none, upper=none, growth=none, casing=numbers, rotor=numbers
    )
    parts = [vars(part) for part in (empty, *zones)]
    return UnstableZones(**{name: np.concatenate([p[name] for p in parts]) for name in vars(empty)})


def exchanges(
    block: CoupledEquations, speed: FloatArray, kappa: FloatArray
) -> tuple[IntArray, IntArray]:
    """Count the meetings begun and ended between waves of positive and of negative signature.

    Args:
        block: undamped pairs of one nodal diameter, all with amplitudes other than zero.
        speed: Omega [rad/s], (n,).
        kappa: spring stiffness [N/m], positive, (n,).

    Returns:
        exchanges begun and ended, each (n,); the difference counts the growing waves.
    """
    matrix = block.whirl_matrix(speed, kappa)
    n = matrix.shape[-1] // 2
    mu, states = np.linalg.eig(matrix)
    fields = states[..., :n, :]
    moved = mu.real[..., None, :] * fields - 0.5 * matrix[..., n:, n:] @ fields
    signature = np.sum(fields.conj() * moved, axis=-2).real
    growing = mu.imag != 0.0  # counted with its conjugate as one positive and one negative wave
    positive = np.where(growing, mu.imag > 0.0, signature > 0.0)
    opposite = positive[:, :, None] & ~positive[:, None, :]
    above, below = mu.real[:, None, :], mu.real[:, :, None]
    ended = np.sum(opposite & (below < above), axis=(1, 2))
    return ended + np.sum(growing & positive, axis=-1), ended


def _intervals(
    modes: CouplingModes, kappas: FloatArray, low: float, high: float
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return, for each unstable zone of one nodal diameter, the index of its stiffness, its lower
    speed and its upper speed."""
    undamped = replace(modes, damping_ratio=np.zeros(modes.entries)).equations
    middle = np.array(0.5 * (low + high)), np.array(kappas[0])
    if undamped.pairs and np.isrealobj(undamped.whirl_matrix(*middle)):
        ladder = _ladder(undamped, kappas, low, high)
        if not np.any(modes.damping_ratio):
            return ladder
    else:
        ladder = (np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros(0))
    row, lower, upper = ladder
    inside = np.linspace(lower, upper, INSIDE + 2)

    def excess(speed: FloatArray, kappa: float | FloatArray) -> FloatArray:
        growth = growth_rate(modes, speed=speed, kappa=kappa)
        return growth - UNSTABLE_GROWTH * np.abs(speed)

    line = [
        np.unique(np.append(np.linspace(low, high, SAMPLES), inside[:, row == i]))
        for i in range(len(kappas))
    ]
    owner = np.repeat(np.arange(len(kappas)), [len(speeds) for speeds in line])
    speeds = np.concatenate(line)
    growing = excess(speeds, kappas[owner]) > 0.0
    left, right = growing[:-1], growing[1:]
    part = np.flatnonzero((left | right) & (owner[:-1] == owner[1:]))
    edge, changes = np.zeros(len(speeds)), part[left[part] != right[part]]
    edge[changes] = _border(excess, speeds[changes], speeds[changes + 1], kappas[owner[changes]])
    starts = np.where(left, speeds[:-1], edge[:-1])[part]
    ends = np.where(right, speeds[1:], edge[:-1])[part]
    return _merged(owner[part], starts, ends)


def _ladder(
    block: CoupledEquations, kappas: FloatArray, low: float, high: float
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the zones that are unstable without damping. They follow from the counts of exchanges
    at both ends of the range of speeds or, if the counts can decrease, at `SAMPLES` speeds."""
    edges = np.linspace(low, high, 2 if block.structure.stiffness_speed is None else SAMPLES)
    speeds, stiff = np.meshgrid(edges, kappas)
    begun, ended = (
        count.reshape(speeds.shape) for count in exchanges(block, speeds.ravel(), stiff.ravel())
    )
    rows, starts, ends = [np.zeros(0, dtype=np.int64)], [np.zeros(0)], [np.zeros(0)]
    for sense, first, last in (
        (1.0, slice(None, -1), slice(1, None)),
        (-1.0, slice(1, None), slice(None, -1)),
    ):
        row, place = np.nonzero(ended[:, first] < begun[:, last])
        bottom, top = ended[:, first][row, place], begun[:, last][row, place]
        part = np.repeat(np.arange(len(row)), top - bottom)
        rung = np.concatenate(
            [np.zeros(0), *(np.arange(a, b) for a, b in zip(bottom, top, strict=True))]
        )

        def climbed(
            along: FloatArray, kappa: FloatArray, step: FloatArray, which: int, sense: float = sense
        ) -> FloatArray:
            return exchanges(block, sense * along, kappa)[which] - step

        near, far = (sense * edges[side][place[part]] for side in (first, last))
        borders = [
            sense * _border(partial(climbed, which=which), near, far, kappas[row[part]], rung + 0.5)
            for which in (0, 1)
        ]
        rows.append(row[part])
        starts.append(np.minimum(*borders))
        ends.append(np.maximum(*borders))
    return _merged(np.concatenate(rows), np.concatenate(starts), np.concatenate(ends))


def _merged(
    row: IntArray, lower: FloatArray, upper: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the intervals of each row, ascending, joined if they touch or overlap."""
    merged: list[tuple[int, float, float]] = []
    for i in np.lexsort((lower, row)):
        here = int(row[i]), float(lower[i]), float(upper[i])
        if merged and merged[-1][0] == here[0] and merged[-1][2] >= here[1]:
            here = here[0], merged[-1][1], max(merged.pop()[2], here[2])
        merged.append(here)
    table = np.array(merged).reshape(-1, 3)
    return table[:, 0].astype(np.int64), table[:, 1], table[:, 2]


def _border(
    excess: Callable[..., FloatArray],
    low: float | FloatArray,
    high: float | FloatArray,
    *arguments: float | FloatArray,
) -> FloatArray:
    """Return the speeds at which a function of speed and arguments changes its sign, (n,).

    If the function is positive at both ends, the lower end is returned; if negative, the upper end.
    """
    root = find_root(excess, (low, high), args=arguments)
    end = np.where(np.asarray(root.f_bracket[0]) > 0.0, low, high)
    return np.asarray(np.where(root.success, root.x, end))


def _growing_mode(
    modes: CouplingModes, speed: FloatArray, kappa: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the growth rate of the fastest growing mode, (n,), and the squared amplitude of each
    entry in this mode, (n, entries)."""
    values, vectors = np.linalg.eig(modes.equations.state_matrix(speed, kappa))
    growing = np.argmax(values.real, axis=-1)
    shape = np.take_along_axis(vectors, growing[:, None, None], axis=-1)[:, : modes.size, 0]
    size = np.zeros((len(speed), modes.entries))
    np.add.at(size.T, modes.entry, np.abs(shape.T) ** 2)
    return values.real.max(axis=-1), size
