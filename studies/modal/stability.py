"""Linear stability of the coupled stage: a chart over speed and stiffness, or one point."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.units import Speed
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.models.stage.stage import Stage
from bladewhirl.solvers.stability.floquet import coupled_floquet
from bladewhirl.solvers.stability.growth import Progress, is_unstable
from bladewhirl.solvers.stability.scenario import motion_scenario
from bladewhirl.studies.modal.coupled_mode import divergent_motion, fastest_mode, motion_measures
from bladewhirl.studies.modal.coupled_system import EvenSystem, System, couple
from bladewhirl.studies.modal.modes import full_stage
from bladewhirl.studies.modal.stability_chart import GROWTH, MULTIPLES, STIFFNESS, stability_chart

SPEEDS, KAPPAS = np.linspace(0.6, 3.0, 600), np.linspace(0.0, 1000.0, 300)
"""Speeds in multiples of the reference frequency and stiffnesses [N/m] of a chart."""


def stability(
    case_or_stage: Case | Stage | ModalStage,
    *,
    speed: float | str | ArrayLike = SPEEDS,
    kappa: float | ArrayLike = KAPPAS,
    modes: str = "six",
    damped: bool = False,
    with_pi: bool = True,
    physical: bool = False,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Growth of bladed disk and casing coupled by springs of stiffness kappa, for small motions.

    Numbers for both speed and stiffness give one point: growth rate, eigenvalues, the fastest
    growing mode and its contact scenario. Arrays give a chart: the growth rate on a grid and, where
    each mode has one nodal diameter, the borders of unstable zones and the coincidence speeds.

    Args:
        case_or_stage: a case, or what `build_stage` or `modal_stage` made of it.
        speed: in multiples of the reference frequency, or one as text such as "2500 rpm".
        kappa: stiffness of the springs [N/m].
        modes: "six" as in the paper, "all", or names such as "casing:1,1F:1,suspension".
        damped: with the case's damping.
        with_pi: keep the factor pi of Eq. (8).
        physical: with the modes' own amplitudes instead of one for each.
        progress: called with the points done and the points in all.

    Raises:
        UserError: see `couple`; a speed that is none.
    """
    chart = not (isinstance(speed, str) or np.ndim(speed) == 0) or np.ndim(kappa) > 0
    system = couple(
        full_stage(case_or_stage),
        modes=modes,
        damped=damped,
        with_pi=with_pi,
        physical=physical,
        chart=chart,
    )
    if chart:
        speeds, kappas = np.atleast_1d(np.asarray(speed, float)), np.atleast_1d(kappa)
        return stability_chart(system, speeds * system.reference, kappas, progress)
    omega = given_speed(speed).rad_per_s(system.reference)  # type: ignore[arg-type] # not an array
    return stability_point(system, omega, float(kappa))  # type: ignore[arg-type]


def given_speed(given: float | str) -> Speed:
    """A speed as a number or as text; text may hold a number, as on the command line.

    Raises:
        UserError: it is none.
    """
    with suppress(ValueError):
        given = float(given)
    try:
        return Speed(given)
    except ValueError as error:
        raise UserError(
            f"--speed {given}: expected multiples of the reference frequency, or text in rpm, Hz or"
            f" rad/s ({error})"
        ) from None


def stability_point(system: System, omega: float, kappa: float) -> xr.Dataset:
    """Growth rate, eigenvalues, fastest growing mode and its scenario at a point.

    Where each mode has one nodal diameter, next to the growth rate of the autonomous form stands
    that of the monodromy matrix of the periodic system, which knows nothing of that form (absent
    at rest, which has no period, and so near to it that a period can't be integrated over).

    Args:
        system: the coupled modes.
        omega: speed [rad/s].
        kappa: spring stiffness [N/m].

    Raises:
        UserError: speed or stiffness are out of reach.
    """
    system.check_reach(omega, kappa)
    try:
        spectrum = system.spectrum(omega, kappa)
    except ArithmeticError as error:
        raise UserError(f"stability: speed {omega / system.reference:.6g} ω₁: {error}") from None
    growth, own = spectrum[0].real, {}
    if isinstance(system, EvenSystem):
        growth = system.growth(np.array([omega]), np.array([kappa]))[0, 0]
        own = _even_point(system, omega, kappa)
    return xr.Dataset(
        {
            "growth_rate": ((), growth, GROWTH),
            "unstable": ((), bool(is_unstable(growth, omega))),
            "real": ("eigenvalue", spectrum.real, {"units": "1/s", "long_name": "growth rate"}),
            "imaginary": (
                "eigenvalue",
                spectrum.imag,
                {"units": "rad/s", "long_name": "frequency"},
            ),
        },
        coords={
            "speed": ((), omega / system.reference, MULTIPLES),
            "speed_rad_per_s": ((), omega, {"units": "rad/s", "long_name": "speed of rotation"}),
            "kappa": ((), kappa, STIFFNESS),
        },
        attrs={"title": "stability at a point", **system.attributes()},
    ).assign(own)


def _even_point(system: EvenSystem, omega: float, kappa: float) -> dict[str, Any]:
    """Variables of a point that only modes of one nodal diameter each have."""
    found: dict[str, Any] = {}
    modes = system.modes
    with suppress(ArithmeticError):  # ZeroDivisionError at rest
        turns = coupled_floquet(modes, speed=omega, kappa=kappa, with_pi=system.with_pi)
        growth = max(float(turn.growth) for turn in turns.values())
        found["growth_rate_floquet"] = ((), growth, GROWTH | {"method": "monodromy matrix"})
    mode = fastest_mode(system, omega, kappa)
    size = [float(np.abs(mode.shape[modes.entry == i]).max()) for i in range(modes.entries)]
    found["mode"] = xr.DataArray(
        size,
        {"entry": list(modes.name)},
        attrs={
            "units": "1",
            "long_name": "size of each mode in the fastest growing motion",
        },
    )
    if "growth_rate_floquet" in found and is_unstable(mode.eigenvalue.real, omega):
        motion = divergent_motion(system.of_diameter(mode.nodal_diameter), omega, kappa)
        found |= {name: ((), *value) for name, value in motion_measures(motion).items()}
        if motion.nodal_diameter == 1:
            scenario = motion_scenario(
                shaft=motion.shaft_static, clearance_angle=motion.smallest_clearance_angle
            )
            found["scenario"] = ((), scenario.kind, {"long_name": "contact scenario"})
    return found
