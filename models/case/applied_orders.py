"""Orders of the wall and of engine orders, which excite the bladed disk."""

from collections.abc import Iterable

from bladewhirl.models.case.casing import Casing
from bladewhirl.models.case.excitation import EngineOrder, Excitation


def applied_orders(casing: Casing, loads: Iterable[Excitation]) -> dict[int, str]:
    """Return the orders of the wall and of loads with their sources, ascending."""
    found = dict[int, list[str]]()
    closure = () if casing.closure is None else casing.closure.lobes
    for lobe in (*casing.clearance_profile.lobes, *closure):
        if lobe.amplitude:
            found.setdefault(lobe.lobes, []).append("wall")
    for load in loads:
        if isinstance(load, EngineOrder):
            for order in load.order:
                found.setdefault(order, []).append("engine order")
    return {order: ", ".join(dict.fromkeys(found[order])) for order in sorted(found) if order}
