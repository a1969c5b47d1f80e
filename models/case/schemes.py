"""Registry of the time integration schemes."""

from typing import TYPE_CHECKING, Literal

SCHEMES = {
    "central-difference": "bladewhirl.solvers.march.central_difference:CentralDifference",
    "moreau-jean": "bladewhirl.solvers.march.dense:MoreauJean",
    "penalty": "bladewhirl.solvers.march.dense:Penalty",
}
"""Module and class of each scheme, by its name in cases. The arguments of the class are a problem,
the time step [s] and the number of steps between records, see `solvers.march.march.Scheme`."""

if TYPE_CHECKING:
    SchemeName = str
else:
    SchemeName = Literal[tuple(SCHEMES)]
