"""Linear stability of the coupled stage, at a point or as a chart, and the divergent motion."""

from contextlib import suppress
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.units import ascending, speed_of
from bladewhirl.models.stage.modal import Modelled, full_models
from bladewhirl.postprocess.modal.motion import radial_shapes, shown_clearance
from bladewhirl.solvers.stability.coupled_modes import (
    CoupledMode,
    CoupledMotion,
    coupled_modes,
    coupled_motion,
)
from bladewhirl.solvers.stability.floquet import coupled_floquet
from bladewhirl.solvers.stability.growth import Progress, is_unstable
from bladewhirl.solvers.stability.scenario import motion_scenario
from bladewhirl.studies.modal.coupled_system import EvenSystem, System, couple
from bladewhirl.studies.modal.stability_chart import GROWTH, MULTIPLES, STIFFNESS, stability_chart
from bladewhirl.studies.runs.columns import quantity

SPEEDS, KAPPAS = np.linspace(0.6, 3.0, 601), np.linspace(0.0, 1000.0, 251)
"""Default speeds (multiples of the reference frequency) and stiffnesses [N/m] of a chart."""

ASCENDING = "one or more numbers of zero or more, ascending"

NEEDS = (
    "its springs of stiffness kappa join the wall to one tip of each blade, which moves in the"
    " plane of the ring; blades with several contact nodes have no such tip"
)
"""Reason why the stability of a superelement is not computed."""

RECORDS_PER_TURN = 48
"""Number of records in a turn of the rotor: twice as many as a smooth animation needs."""

GROWTHS = 2.5
"""Logarithm of the ratio of last to first amplitude in the shown motion, unless the number of turns
is limited by `FEWEST_TURNS` or `MOST_TURNS`."""

FEWEST_TURNS, MOST_TURNS = 3, 40
"""Smallest and largest number of turns of the rotor in the shown motion."""


def stability(
    case_or_stage: Modelled,
    *,
    speed: float | str | ArrayLike = SPEEDS,
    kappa: float | ArrayLike = KAPPAS,
    modes: str = "six",
    damped: bool = False,
    with_pi: bool = True,
    physical: bool = False,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Compute growth rates of bladed disk and casing, coupled by springs of stiffness kappa.

    A single speed and a single stiffness give one point: growth rate, eigenvalues, the fastest
    growing mode and its contact scenario. Arrays give a chart: the growth rate on a grid and, where
    each mode has one nodal diameter, the borders of unstable zones and the coincidence speeds.

    Args:
        case_or_stage: a case, or its stage from `build_stage`.
        speed: speeds in multiples of the reference frequency, or one speed as text such as "2500
            rpm".
        kappa: stiffness of the springs [N/m].
        modes: "six" as in the paper, "all", or names such as "casing:1,1F:1,suspension".
        damped: whether the damping of the case is included.
        with_pi: whether the factor pi of Eq. (8) is kept.
        physical: whether modes have physical amplitudes; otherwise all amplitudes are equal.
        progress: called with the numbers of finished points and of all points.

    Raises:
        UserError: as for `couple`, or the speed is invalid.
    """
    chart = not (isinstance(speed, str) or np.ndim(speed) == 0) or np.ndim(kappa) > 0
    system = couple(
        full_models(case_or_stage, "stability", NEEDS),
        modes=modes,
        damped=damped,
        with_pi=with_pi,
        physical=physical,
        chart=chart,
    )
    if chart:
        speeds, kappas = (
            np.array(ascending(f"stability: {name}", np.atleast_1d(each), ASCENDING, 0.0))
            for name, each in (("speed", speed), ("kappa", kappa))
        )
        return stability_chart(system, speeds * system.reference, kappas, progress)
    omega = speed_of(speed, f"stability: speed {speed!r}").rad_per_s(system.reference)
    return stability_point(system, omega, float(kappa))  # type: ignore[arg-type]  # not an array


def stability_point(system: System, omega: float, kappa: float) -> xr.Dataset:
    """Compute growth rate, eigenvalues, fastest growing mode and contact scenario at a speed omega
    [rad/s] and a spring stiffness kappa [N/m].

    If each mode has one nodal diameter, growth_rate_floquet is the growth rate from the monodromy
    matrix of the periodic system, an independent check of the autonomous form. It is missing at
    rest, where there is no period, and near rest, where the period is too long to be integrated.

    Raises:
        UserError: the Floquet exponents cannot be computed.
    """
    try:
        spectrum = system.spectrum(omega, kappa)
    except ArithmeticError as error:
        raise UserError(f"stability: speed {omega / system.reference:.6g} ω₁: {error}") from None
    growth, variables = spectrum[0].real, {}
    if isinstance(system, EvenSystem):
        growth = system.growth(np.array([omega]), np.array([kappa]))[0, 0]
        variables = _even_point(system, omega, kappa)
    return xr.Dataset(
        {
            "growth_rate": ((), growth, GROWTH),
            "unstable": ((), bool(is_unstable(growth, omega))),
            "real": quantity("eigenvalue", spectrum.real, "1/s", "growth rate"),
            "imaginary": quantity("eigenvalue", spectrum.imag, "rad/s", "frequency"),
        },
        coords={
            "speed": ((), omega / system.reference, MULTIPLES),
            "speed_rad_per_s": quantity((), omega, "rad/s", "speed of rotation"),
            "kappa": ((), kappa, STIFFNESS),
        },
        attrs={"title": "stability at a point", **system.attributes()},
    ).assign(variables)


def _even_point(system: EvenSystem, omega: float, kappa: float) -> dict[str, Any]:
    """Return the variables of a point that exist only if each mode has one nodal diameter."""
    variables: dict[str, Any] = {}
    modes = system.modes
    with suppress(ArithmeticError):  # ZeroDivisionError at rest
        turns = coupled_floquet(modes, speed=omega, kappa=kappa)
        growth = max(float(turn.growth) for turn in turns)
        variables["growth_rate_floquet"] = ((), growth, GROWTH | {"method": "monodromy matrix"})
    mode = fastest_mode(system, omega, kappa)
    size = [float(np.abs(mode.shape[modes.entry == i]).max()) for i in range(modes.entries)]
    name = "size of each mode in the fastest growing motion"
    variables["entry"] = ("entry", list(modes.name))
    variables["mode"] = quantity("entry", size, "1", name)
    if "growth_rate_floquet" in variables and is_unstable(mode.eigenvalue.real, omega):
        motion = divergent_motion(system.of_diameter(mode.nodal_diameter), omega, kappa)
        variables |= motion_measures(motion)
        if motion.nodal_diameter == 1:
            scenario = motion_scenario(
                shaft=motion.shaft_static, clearance_angle=motion.smallest_clearance_angle
            )
            variables["scenario"] = ((), scenario.kind, {"long_name": "contact scenario"})
    return variables


def fastest_mode(system: EvenSystem, omega: float, kappa: float) -> CoupledMode:
    """Return the fastest growing coupled mode at a point."""
    return coupled_modes(system.modes, speed=omega, kappa=kappa)[0]


def divergent_motion(system: EvenSystem, omega: float, kappa: float) -> CoupledMotion:
    """Compute the motion of the fastest growing coupled mode, until the clearance is closed."""
    mode = fastest_mode(system, omega, kappa)
    turn = 2.0 * np.pi / abs(mode.speed)
    turns = float(np.clip(GROWTHS / mode.eigenvalue.real / turn, FEWEST_TURNS, MOST_TURNS))
    records = np.arange(round(turns * RECORDS_PER_TURN) + 1, dtype=np.float64)
    return coupled_motion(
        mode,
        time=turn / RECORDS_PER_TURN * records,
        shapes=radial_shapes(system.stage),
        clearance=shown_clearance(system.stage.modal),
    )


def motion_measures(motion: CoupledMotion) -> dict[str, Any]:
    """Return measures of the motion of a coupled mode as variables; forward speeds are positive."""
    speed = {"units": "rad/s"}
    measures: dict[str, Any] = {
        "nodal_diameter": quantity((), motion.nodal_diameter, "1"),
        "rotor_wave_speed": ((), motion.rotor_wave_speed, speed | {"frame": "rotating"}),
        "casing_wave_speed": ((), motion.casing_wave_speed, speed | {"frame": "static"}),
    }
    if motion.nodal_diameter == 1:
        lead = float(np.degrees(motion.shaft_lead[-1]))
        measures |= {
            "whirl_speed_rotating": ((), motion.whirl_speed, speed),
            "whirl_speed_static": ((), motion.whirl_speed_static, speed),
            "shaft_lead_degrees": quantity((), lead, "degrees"),
        }
    return measures


def motion_dataset(motion: CoupledMotion, *, reference: float) -> xr.Dataset:
    """Return phases and amplitudes of the motion of a coupled mode; `reference` is the frequency by
    which speeds are normalised [rad/s]."""
    moves = motion.nodal_diameter == 1  # only waves with k = 1 move the shaft
    missing = np.full(len(motion.time), np.nan)
    static = motion.shaft_static
    phase = np.unwrap(np.arctan2(static[:, 1], static[:, 0])) if moves else missing
    place = motion.smallest_clearance_angle
    return xr.Dataset(
        data_vars={
            "shaft_phase": quantity("time", phase, "rad"),
            "smallest_clearance_phase": quantity("time", place, "rad"),
            "shaft_lead": quantity("time", motion.shaft_lead if moves else missing, "rad"),
            "rotor_amplitude": quantity("time", np.abs(motion.rotor_wave), "m"),
            "casing_amplitude": quantity("time", np.abs(motion.casing_wave), "m"),
        },
        coords={"time": quantity("time", motion.time, "s")},
        attrs={
            "title": "coupled mode in time, static frame",
            "nodal_diameter": motion.nodal_diameter,
            "speed": motion.speed,
            "reference_frequency": reference,
            "rotor_wave_speed": motion.rotor_wave_speed,  # rad/s, forward positive
            "casing_wave_speed": motion.casing_wave_speed,
        },
    )
