"""Arrays of a body (rotor or casing) in modal coordinates."""

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.solvers.kernel.structs import Struct, aligned, lib, padded
from bladewhirl.solvers.packing.arrangement import Arrangement


def pack_body(
    frequency: FloatArray,
    damping_ratio: FloatArray,
    loads: list[FloatArray],
    arrangement: Arrangement,
    dt: float,
    *,
    coupled: bool = False,
) -> Struct:
    """Return the coefficients of the recurrence in time of the modes of a body.

    Args:
        frequency: frequency of each mode [rad/s], (modes,); negative if its square is negative.
        damping_ratio: damping ratio of each mode, (modes,).
        loads: modal forces of each load pattern, (modes,) each.
        arrangement: arrangement of the modes.
        dt: time step [s].
        coupled: true if the matrix A = M/dt^2 + D/(2 dt) couples the modes.
    """
    inverse = scheme_inverse(frequency, damping_ratio, dt)
    stiffness, size = frequency * np.abs(frequency), np.abs(frequency)
    decay = damping_ratio * size / dt
    if coupled:
        inverse, decay = np.ones_like(inverse), np.full_like(decay, -1.0 / dt**2)
    load = arrangement.pack(np.reshape(loads, (len(loads), len(frequency))))
    return Struct(
        "Body",
        a=arrangement.pack(inverse * (2.0 / dt**2 - stiffness)),
        b=arrangement.pack(inverse * (decay - 1.0 / dt**2)),
        c=arrangement.pack(inverse),
        stiffness=arrangement.pack(stiffness),
        damping=arrangement.pack(2.0 * damping_ratio * size),
        load=load,
        loaded=_registers_in_use(load),
    )


def scheme_inverse(frequency: FloatArray, damping_ratio: FloatArray, dt: float) -> FloatArray:
    """Return the inverse of A = M/dt^2 + D/(2 dt) for each mode [s2], (modes,)."""
    return np.asarray(1.0 / (1.0 / dt**2 + damping_ratio * np.abs(frequency) / dt))


def by_sliding(pressed: FloatArray, dragged: FloatArray, friction: float) -> FloatArray:
    """Return the response to a normal force with friction for sliding directions -1, 0 and 1."""
    return np.array([pressed + s * friction * dragged for s in (-1.0, 0.0, 1.0)])


def by_column(shape: FloatArray, arrangement: Arrangement) -> FloatArray:
    """Transpose a shape (points, columns) to (used columns, padded points)."""
    used = arrangement.half + arrangement.parts * arrangement.used
    out = aligned((used, padded(len(shape))))
    out[:, : len(shape)] = shape[:, :used].T
    return out


def lengthened(values: FloatArray) -> FloatArray:
    """Return a vector padded with zeros to whole registers."""
    out = aligned(padded(len(values)))
    out[: len(values)] = values
    return out


def _registers_in_use(patterns: FloatArray) -> IntArray:
    """Return where each load pattern is not zero: the first entry of each group of LANES entries
    with a nonzero number, padded with -1, (patterns, groups)."""
    used = [lib.LANES * np.flatnonzero(p.reshape(-1, lib.LANES).any(axis=1)) for p in patterns]
    places = np.full((len(patterns), max(map(len, used), default=0) + 1), -1)
    for row, place in zip(places, used, strict=True):
        row[: len(place)] = place
    return places
