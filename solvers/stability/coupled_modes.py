"""Coupled modes in time: the four steps of Section 3.3.2.

1. eigenvectors of the autonomous system at one speed and spring stiffness (`coupled_modes`),
2. the response y of one eigenvector in time,
3. the coordinates u = exp(Omega t J) y, from the frame of Eq. (16) back to the axes of the bodies,
4. the motion of shaft, tips and casing from u and the mode shapes (`coupled_motion`).

The direction of travel is measured from the displacement fields. A radial field with nodal
diameter k, Re(C exp(-i k theta)), has its crest at theta = arg(C) / k, so the wave travels forward,
in the sense of rotation, if arg(C) grows.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.coupling.springs import CouplingModes


@dataclass(frozen=True, kw_only=True)
class CoupledMode:
    """Mode of the autonomous system: y = Re(shape exp(eigenvalue t))."""

    modes: CouplingModes  #: all coupled modes; `shape` is zero for other nodal diameters
    speed: float  #: Omega [rad/s]
    nodal_diameter: int  #: nodal diameter k of the mode
    eigenvalue: complex  #: eigenvalue [1/s]
    shape: ComplexArray  #: shape of y, whose largest entry is one, (modes.size,)


@dataclass(frozen=True, kw_only=True)
class RadialShapes:
    """Displacement of shaft, tips and casing for unit coordinates u [kg^-1/2]."""

    centre: FloatArray  #: x and y of the centre node, rotating axes, (2, size)
    tips: FloatArray  #: radial displacement of each tip, (tips, size)
    tip_angle: FloatArray  #: angle of equally spaced tips, rotating frame [rad], (tips,)
    casing: FloatArray  #: radial displacement of points on the casing, (points, size)
    casing_angle: FloatArray  #: angle of these equally spaced points, static frame [rad], (points,)


@dataclass(frozen=True, kw_only=True)
class CoupledMotion:
    """Coupled mode in time, scaled so that tip and casing touch at the last instant."""

    time: FloatArray  #: instants [s], (times,)
    nodal_diameter: int  #: k of the motion
    speed: float  #: Omega [rad/s]
    displacement: FloatArray  #: coordinates u [kg^1/2 m], (times, size)
    velocity: FloatArray  #: du/dt [kg^1/2 m/s], (times, size)
    shaft: FloatArray  #: centre in rotating axes [m], (times, 2)
    rotor_wave: ComplexArray  #: C of the tips' radial field, rotating frame [m], (times,)
    casing_wave: ComplexArray  #: C of the casing's radial field, static frame [m], (times,)

    @property
    def shaft_static(self) -> FloatArray:
        """Centre in static axes [m], (times, 2)."""
        turned = _complex(self.shaft) * np.exp(1j * self.speed * self.time)
        return np.stack([turned.real, turned.imag], axis=-1)

    @property
    def stretch(self) -> ComplexArray:
        """C of casing minus rotor in the static frame [m], (times,): the change of clearance."""
        turn = np.exp(1j * self.nodal_diameter * self.speed * self.time)
        return np.asarray(self.casing_wave - self.rotor_wave * turn)

    @property
    def smallest_clearance_angle(self) -> FloatArray:
        """Angle of the smallest clearance in the static frame [rad], (times,), unwrapped.

        A wave with k nodal diameters has k such angles, of which one is returned.
        """
        return np.unwrap(np.angle(-self.stretch)) / max(self.nodal_diameter, 1)

    @property
    def rotor_wave_speed(self) -> float:
        """Speed of the wave crest on the rotor in the rotating frame, forward positive [rad/s]."""
        return self._crest_speed(self.rotor_wave)

    @property
    def casing_wave_speed(self) -> float:
        """Speed of the wave crest on the casing in the static frame, forward positive [rad/s]."""
        return self._crest_speed(self.casing_wave)

    @property
    def whirl_speed(self) -> float:
        """Whirl speed of the shaft in the rotating frame for k = 1, forward positive [rad/s]."""
        return phase_rate(self.time, _complex(self.shaft))

    @property
    def whirl_speed_static(self) -> float:
        """Whirl speed of the shaft in the static frame for k = 1, forward positive [rad/s]."""
        return phase_rate(self.time, _complex(self.shaft_static))

    @property
    def shaft_lead(self) -> FloatArray:
        """Angle of the shaft displacement minus angle of the smallest clearance [rad], (times,).

        The angle is in (-pi, pi] and needs k = 1. Zero is the paper's standard contact scenario, pi
        its inverted contact scenario.
        """
        return np.angle(-_complex(self.shaft_static) / self.stretch)

    def _crest_speed(self, wave: ComplexArray) -> float:
        return phase_rate(self.time, wave) / max(self.nodal_diameter, 1)


def coupled_modes(modes: CouplingModes, *, speed: float, kappa: float) -> list[CoupledMode]:
    """Compute the modes of the autonomous system, the fastest growing first.

    Of each conjugate pair only one mode is returned.

    Args:
        modes: the modes to couple.
        speed: Omega [rad/s].
        kappa: spring stiffness [N/m].
    """
    result = []
    for k in modes.harmonics:
        chosen = np.flatnonzero(modes.nodal_diameter == k)
        part = modes.take(chosen)
        coordinates = np.flatnonzero(np.isin(modes.entry, chosen))
        values, vectors = np.linalg.eig(part.equations.state_matrix(speed, kappa))
        for i in np.flatnonzero(values.imag >= 0.0):
            shape = np.zeros(modes.size, dtype=np.complex128)
            vector = vectors[: part.size, i]
            shape[coordinates] = vector / vector[np.argmax(np.abs(vector))]
            result.append(
                CoupledMode(
                    modes=modes,
                    speed=speed,
                    nodal_diameter=k,
                    eigenvalue=complex(values[i]),
                    shape=shape,
                )
            )
    return sorted(result, key=lambda mode: (-mode.eigenvalue.real, mode.eigenvalue.imag))


def modal_response(mode: CoupledMode, time: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Compute the coordinates u of a coupled mode in time, and du/dt (steps 2 and 3).

    Args:
        mode: the mode.
        time: instants [s], (times,).

    Returns:
        u and du/dt without scaling, each (times, size).
    """
    y = np.exp(np.multiply.outer(time, mode.eigenvalue))[:, None] * mode.shape
    rate = (mode.eigenvalue * y).real
    return mode.modes.equations.in_body_axes(y.real, rate, speed=mode.speed, time=time)


def coupled_motion(
    mode: CoupledMode, *, time: FloatArray, shapes: RadialShapes, clearance: float
) -> CoupledMotion:
    """Compute the motion of shaft, tips and casing in a coupled mode (steps 2 to 4).

    Args:
        mode: the mode.
        time: instants [s], (times,).
        shapes: displacements of shaft, tips and casing for unit coordinates.
        clearance: clearance at rest [m]; the motion is scaled to close it at the last instant.

    Raises:
        ValueError: the mode does not change the clearance.
    """
    u, velocity = modal_response(mode, time)
    k = mode.nodal_diameter
    rotor = wave_coefficient(u @ shapes.tips.T, shapes.tip_angle, k)
    casing = wave_coefficient(u @ shapes.casing.T, shapes.casing_angle, k)
    motion = CoupledMotion(
        time=time,
        nodal_diameter=k,
        speed=mode.speed,
        displacement=u,
        velocity=velocity,
        shaft=u @ shapes.centre.T,
        rotor_wave=rotor,
        casing_wave=casing,
    )
    last = float(np.abs(motion.stretch[-1]))
    if last <= 1e-12 * (np.abs(rotor[-1]) + np.abs(casing[-1])):
        raise ValueError(f"the mode at {mode.eigenvalue:.6g} 1/s does not change the clearance")
    scale = clearance / last
    moving = ("displacement", "velocity", "shaft", "rotor_wave", "casing_wave")
    return replace(motion, **{name: scale * getattr(motion, name) for name in moving})


def wave_coefficient(field: FloatArray, angle: FloatArray, k: int) -> ComplexArray:
    """Return C of the part Re(C exp(-i k theta)) of a field at equally spaced angles.

    Args:
        field: values of the field, (..., angles).
        angle: theta [rad], (angles,).
        k: nodal diameter, up to half the number of angles.

    Returns:
        C, (...); real for k = 0. If k is half the number of angles, C is a real number times
        exp(i k angle[0]).
    """
    count = len(angle)
    single = k == 0 or 2 * k == count
    return np.asarray(field @ np.exp(1j * k * angle) * ((1.0 if single else 2.0) / count))


def phase_rate(time: FloatArray, phasor: NDArray[np.complex128]) -> float:
    """Return the mean rate of a phasor's phase [rad/s], by least squares."""
    return float(np.polyfit(time - time.mean(), np.unwrap(np.angle(phasor)), 1)[0])


def _complex(vectors: FloatArray) -> ComplexArray:
    return np.asarray(vectors[..., 0] + 1j * vectors[..., 1])
