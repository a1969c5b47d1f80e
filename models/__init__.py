"""Cases, finite elements and reduction: what there is before anything moves."""

from bladewhirl.models.case import Case
from bladewhirl.models.case_check import case_from
from bladewhirl.models.case_file import dumps_case, read_case, with_values
from bladewhirl.models.faults import CaseError, Fault, UserError
from bladewhirl.models.quantity import Speed
from bladewhirl.models.sections import Section
from bladewhirl.models.sketch import Sketch

__all__ = [
    "Case",
    "CaseError",
    "Fault",
    "Section",
    "Sketch",
    "Speed",
    "UserError",
    "case_from",
    "dumps_case",
    "read_case",
    "with_values",
]
