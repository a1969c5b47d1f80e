"""Stability at one point of a stage that no frame holds still, by the monodromy matrix."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import typer

from bladewhirl.models.coupling.periodic import UnevenSystem, uneven_system
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.solvers.stability.floquet import floquet
from bladewhirl.studies.modal.stability_point import given_speed, point_facts, print_point


def stands_still(modal: ModalStage, *, damped: bool) -> bool:
    """Whether some frame holds the coupled stage still, that of the bladed disk or another.

    The casing must look the same from everywhere, shaft springs that stand still must be equal, and
    damping must be shared out by modes.

    Args:
        modal: finite element models with their modes.
        damped: whether dampers count.
    """
    return not list(_uneven(modal, damped=damped))


def _uneven(modal: ModalStage, *, damped: bool) -> Iterator[str]:
    """What no frame holds still, in words; see `stands_still`."""
    shaft, casing = modal.case.shaft, modal.casing
    if not casing.structure.is_cyclic:
        yield "the casing is not the same all round"
    if shaft.anisotropy != 0.0 and not shaft.clamped:
        yield "the shaft springs that stand still differ"
    if damped and (casing.dampers.shape[0] or (any(shaft.dampings) and not shaft.clamped)):
        yield "with --damped there are dampers"


def refuse_chart(modal: ModalStage, *, damped: bool) -> None:
    """Say why there is no chart, and how to get a point.

    Raises:
        UserError: no frame holds the stage still.
    """
    found = ", ".join(_uneven(modal, damped=damped))
    if found:
        options = "--speed and --kappa" if _is_cyclic(modal) else "--speed, --kappa and --physical"
        raise UserError(
            f"stability: expected a stage that some frame holds still, for a chart; here {found}:"
            f" {options} give one point"
        )


def _is_cyclic(modal: ModalStage) -> bool:
    return modal.disk.structure.is_cyclic and modal.casing.structure.is_cyclic


def look_at_uneven_point(
    modal: ModalStage,
    *,
    chosen: str,
    damped: bool,
    physical: bool,
    with_pi: bool,
    speed: str,
    kappa: float,
    as_json: bool,
) -> None:
    """Report growth rate and spectrum at a point.

    Args:
        modal: finite element models with their modes.
        chosen: see `uneven_system`.
        damped: with the damping of the case.
        physical: with the modes' own amplitudes.
        with_pi: keep the factor pi of Eq. (8).
        speed: as the user gave it.
        kappa: spring stiffness [N/m].
        as_json: print one JSON document instead of a table.

    Raises:
        UserError: modes that the stage does not have, or one amplitude for modes that have more
            than one nodal diameter.
    """
    if not _is_cyclic(modal) and not physical:
        raise UserError(
            "stability: expected --physical on a stage without cyclic symmetry: one amplitude for"
            " every mode has a meaning only if each mode has one nodal diameter"
        )
    try:
        system = uneven_system(modal, modes=chosen, damped=damped, physical=physical)
    except ValueError as error:
        raise UserError(f"--modes {chosen}: {error}") from None
    reference = modal.reference_frequency
    omega = given_speed(speed).rad_per_s(reference)
    spectrum = exponents(system, speed=omega, kappa=kappa, with_pi=with_pi)
    growth = float(spectrum.real.max())
    point = point_facts(spectrum, growth, omega=omega, kappa=kappa, reference=reference) | {
        "modes": list(dict.fromkeys(system.name)),
        "damped": damped,
        "pi": with_pi,
        "amplitude": "physical" if physical else "paper",
        "reference_frequency": reference,
    }
    if as_json:
        typer.echo(json.dumps(point, indent=2))
    else:
        print_point(point)


def exponents(
    system: UnevenSystem, *, speed: float, kappa: float, with_pi: bool = True
) -> np.ndarray[Any, np.dtype[np.complex128]]:
    """Floquet exponents of a turn, the fastest growing first; at rest eigenvalues, (2 modes,).

    Args:
        system: the coupled modes.
        speed: Omega [rad/s].
        kappa: spring stiffness [N/m].
        with_pi: keep the factor pi of Eq. (8).
    """
    if speed == 0.0:
        size = len(system.frequency)
        still = system.stiffness(np.zeros(1), kappa, with_pi=with_pi)[0]
        state = np.block([[np.zeros((size, size)), np.eye(size)], [-still, -system.damping]])
        found = np.linalg.eigvals(state)
    else:
        found = floquet(
            lambda times: system.stiffness(speed * times, kappa, with_pi=with_pi),
            period=2.0 * np.pi / abs(speed),
            damping=system.damping,
        ).exponents
    return np.asarray(np.sort_complex(found)[::-1], dtype=np.complex128)
