"""Studies of a shaft line as the commands `modes`, `campbell`, `critical-speeds`, `response` and
`stability` print and draw them."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.shaft_line.line import line_model
from bladewhirl.studies.modal.study import Figures, Study
from bladewhirl.studies.shaft_line import critical_speeds as speeds_of
from bladewhirl.studies.shaft_line import modes as modes_of
from bladewhirl.studies.shaft_line import orders as orders_of
from bladewhirl.studies.shaft_line import stability as stability_of
from bladewhirl.studies.shaft_line import unbalance as unbalance_of

POINTS = 101  #: number of speeds of a Campbell diagram

Values = Callable[[float], FloatArray]
"""Function that returns speeds as multiples of a reference frequency [rad/s]."""


def modes(case: Case, *, count: int) -> Study:
    """Return the modes at the speed of the case."""
    return modes_of.report(modes_of.line_modes(case, count=count))


def critical_speeds(case: Case, *, branches: int) -> Study:
    """Return the critical speeds of modes that are `branches` pairs at rest."""
    computed = speeds_of.line_critical_speeds(case, count=2 * branches)
    return speeds_of.critical_report(computed)


def campbell(case: Case, *, speeds: Values, families: int) -> Study:
    """Return the Campbell diagram between two speeds, of modes that are `families` pairs at
    rest."""
    reference = line_model(case).reference_frequency
    first, last = speeds(reference) * reference
    omegas = np.linspace(first, last, POINTS)
    diagram = speeds_of.line_campbell(case, speeds=omegas, count=2 * families)
    critical = speeds_of.line_critical_speeds(case, count=2 * families)
    return speeds_of.campbell_report(diagram, critical)


def stability(case: Case, *, speeds: Values) -> Study:
    """Return the growth rate at many speeds, and the speeds at which growth begins or ends."""
    reference = line_model(case).reference_frequency
    omegas = speeds(reference) * reference
    return stability_of.report(stability_of.line_stability(case, speeds=omegas))


def response(case: Case, *, speeds: Values) -> Study:
    """Return the response to the unbalances and to the engine orders of the case at many speeds."""
    table = case.shaft_line
    assert table is not None
    reference = line_model(case).reference_frequency
    omegas = speeds(reference) * reference
    found = []
    if any(isinstance(load, EngineOrder) for load in case.excitations.values()):
        found.append(orders_of.report(orders_of.line_order_response(case, speeds=omegas)))
    if table.unbalance or not found:
        critical = speeds_of.line_critical_speeds(case)
        computed = unbalance_of.line_response(case, speeds=omegas)
        found.insert(0, unbalance_of.report(computed, critical))
    return joined(found)


def joined(studies: list[Study]) -> Study:
    """Return studies of one command as one."""
    first = studies[0]
    drawn = [study.figures for study in studies if study.figures is not None]

    def figures() -> Figures:
        return {name: figure for each in drawn for name, figure in each().items()}

    return replace(
        first,
        document={key: value for study in studies for key, value in study.document.items()},
        tables=[each for study in studies for each in study.tables],
        figures=figures,
    )
