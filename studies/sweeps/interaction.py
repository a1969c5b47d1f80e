"""Interaction map of a superelement: contact and vibration at many speeds of rotation."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.units import speed_of
from bladewhirl.models.stage.boundary_problem import BoundaryProblem
from bladewhirl.models.stage.superelement_stage import SuperelementStage, superelement_stage
from bladewhirl.postprocess.superelement.interaction import point_of_map
from bladewhirl.solvers.march.boundary import BoundaryMarch

RECORDS = 64
"""Number of records in a revolution."""

VARIABLES = {
    "contact_impulse": ("N s", "normal impulse of all nodes per revolution, in the second half"),
    "contact_force_max": ("N", "largest normal force on a node, mean between two records"),
    "contact_share": ("1", "largest share of time in contact of a node, in the second half"),
    "radial": ("m", "largest radial displacement of a node in the second half"),
    "tangential": ("m", "largest tangential displacement of a node in the second half"),
    "axial": ("m", "largest axial displacement of a node in the second half"),
    "turns": ("1", "revolutions until the end"),
    "unsolved_steps": ("1", "steps whose forces did not converge"),
}
"""Variables of each speed, with units and meanings; "second half" is that of the revolutions."""


def interaction_map(
    case: Case,
    speeds: Sequence[float | str],
    *,
    turns: int = 50,
    steps_per_turn: int | None = None,
    node: int = 0,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """March a superelement at many speeds, each from rest.

    Args:
        case: case with a superelement in a rigid wall; its speed and duration are not used.
        speeds: multiples of the lowest natural frequency, or texts such as "3000 rpm".
        turns: number of revolutions at each speed.
        steps_per_turn: number of time steps in a revolution; by default that of march.time_step,
            rounded so that there are 64 records in a revolution.
        node: contact node whose tangential displacement gives the spectrum.
        workers: number of threads; all processors by default.
        progress: called with the numbers of finished and of all speeds.

    Returns:
        Dataset over `speed` [rad/s]: the variables of `VARIABLES` and `divergent`; over (speed,
        line): `amplitude` [m], the spectrum in the second half of the revolutions, at `frequency`
        [Hz]. The attribute `natural_frequencies` lists the natural frequencies without contact
        [Hz].

    Raises:
        UserError: the case has no superelement, a speed is zero or invalid, or a time step is too
            long for the model.
        CaseError: the case cannot be marched.
    """
    if case.bladed_disk.superelement is None:
        raise UserError("bladed_disk.superelement: expected a superelement for an interaction map")
    if not len(speeds):
        raise UserError("interaction map: expected at least one speed")
    if turns < 2:
        raise UserError(f"interaction map: expected at least 2 revolutions, not {turns}")
    stage = superelement_stage(case)
    problem, reference = stage.problem, stage.reference_frequency
    if not 0 <= node < stage.part.contacts:
        raise UserError(f"node {node}: expected a contact node from 0 to {stage.part.contacts - 1}")
    omegas = [_omega(speed, reference) for speed in speeds]
    steps = [_steps(stage, problem, omega, steps_per_turn) for omega in omegas]

    def march(number: int) -> dict[str, Any]:
        omega, every = omegas[number], steps[number] // RECORDS
        dt = 2.0 * np.pi / abs(omega) / steps[number]
        scheme = BoundaryMarch(stage.problem_at(omega), dt, every)
        state, chunk, end = scheme.advance(scheme.init(), turns * steps[number] + 1)
        reduced = point_of_map(chunk, omega, RECORDS, node)
        unsolved = state.statistics.lcp_failures
        return reduced | {"unsolved_steps": unsolved, "divergent": end is not None}

    rows: list[dict[str, Any]] = []
    with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
        for row in pool.map(march, range(len(omegas))):
            rows.append(row)
            if progress is not None:
                progress(len(rows), len(omegas))
    return _dataset(stage, np.array(omegas), turns, rows, node)


def _omega(speed: float | str, reference: float) -> float:
    omega = speed_of(speed, "speeds").rad_per_s(reference)
    if omega == 0.0:
        raise UserError("speeds: expected speeds other than 0")
    return omega


def _steps(
    stage: SuperelementStage, problem: BoundaryProblem, omega: float, given: int | None
) -> int:
    """Return the number of steps in a revolution, a multiple of `RECORDS`.

    Raises:
        UserError: the time step is not below the critical one.
    """
    turn = 2.0 * np.pi / abs(omega)
    requested = turn / stage.case.march.time_step if given is None else float(given)
    steps = RECORDS * max(1, int(np.ceil(requested / RECORDS - 1e-9)))
    limit = problem.critical_time_step
    if not turn / steps < limit:
        raise UserError(
            f"{omega * 30.0 / np.pi:.6g} rpm: expected more than {turn / limit:.0f} steps in a"
            f" revolution, the critical time step is {limit:.4g} s"
        )
    return steps


def _dataset(
    stage: SuperelementStage, omegas: Any, turns: int, rows: list[dict[str, Any]], node: int
) -> xr.Dataset:
    lines = max(len(row["frequency"]) for row in rows)

    def padded(name: str) -> Any:
        return np.array(
            [np.pad(r[name], (0, lines - len(r[name])), constant_values=np.nan) for r in rows]
        )

    spectra = {
        "amplitude": (("speed", "line"), padded("amplitude"), {"units": "m"}),
        "frequency": (("speed", "line"), padded("frequency"), {"units": "Hz"}),
    }
    numbers = {
        name: ("speed", np.array([row[name] for row in rows]), {"units": unit, "long_name": text})
        for name, (unit, text) in VARIABLES.items()
    }
    divergent = {"divergent": ("speed", np.array([row["divergent"] for row in rows]))}
    return xr.Dataset(
        numbers | spectra | divergent,
        coords={"speed": ("speed", omegas, {"units": "rad/s"})},
        attrs={
            "title": "interaction map",
            "case_title": stage.case.title,
            "reference_frequency": stage.reference_frequency,
            "natural_frequencies": stage.reduced.frequency / (2.0 * np.pi),
            "turns": turns,
            "node": node,
        },
    )
