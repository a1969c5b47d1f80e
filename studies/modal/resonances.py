"""Speeds at which the wall and engine orders excite the bladed disk, for free and for held tips.

A wave of force with r lobes at rest in space, Re exp(i r (Omega t + theta)), meets nodal diameter k
with r = n N + k (a backward wave) or r = n N - k (a forward wave) on N blades, at w = r Omega. In a
rub the tips touch for a part of each turn, and the resonance lies between that with free tips and
that with held tips.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.modal.touching import held
from bladewhirl.models.structure.waves import Waves
from bladewhirl.studies.modal.campbell_at_speed import names_at
from bladewhirl.studies.runs.columns import Column, quantity

COLUMNS = (
    Column("order", "order", "d"),
    Column("source", "source"),
    Column("family", "family"),
    Column("k", "k", "d", variable="nodal_diameter"),
    Column("direction", "wave"),
    Column("free_rpm", "free tips [rpm]", ".1f"),
    Column("held_rpm", "held tips [rpm]", ".1f"),
    Column("margin", "margin [%]", ".1f", 100.0),
)
"""Columns of resonances; the last only with an operating range."""


def met_wave(order: int, blades: int) -> tuple[int, int]:
    """Return the nodal diameter that an order excites on a number of blades, and the sign of the
    frequency of its wave: 1 if it travels backward, -1 if it travels forward."""
    rest = order % blades
    return (rest, 1) if 2 * rest <= blades else (blades - rest, -1)


def resonances(
    model: ModalModel,
    waves: Mapping[int, Waves],
    names: Mapping[int, list[str]],
    chosen: set[str],
    orders: Mapping[int, str],
    speeds: tuple[float, float],
    operating: tuple[float, float],
) -> xr.Dataset:
    """Compute the speeds at which orders excite waves, with free and with held tips.

    Args:
        model: bladed disk with equal sectors.
        waves: waves of each nodal diameter.
        names: families of each nodal diameter at rest, the lowest first.
        chosen: families to include.
        orders: sources of each order.
        speeds: lowest and highest speed [rad/s].
        operating: ends of the operating range [rad/s]; nan if it is not known.

    Returns:
        over `resonance`, by margin and then by speed: resonance_order, resonance_source,
        resonance_nodal_diameter, resonance_direction, resonance_family (at rest); resonance_free
        and resonance_held, normalised speeds (nan if there is none), with `..._rpm`; and
        resonance_margin, the distance of the band between both from the operating range, divided by
        the nearer end of the range.
    """
    tips, blades = model.disk.tips, model.case.bladed_disk.count
    rows: list[dict[str, Any]] = []
    for order, source in orders.items():
        k, sign = met_wave(order, blades)
        if k not in waves:
            continue
        touching = _by_family(held(waves[k], tips[k]), names[k], sign * order)
        for family, free in _by_family(waves[k], names[k], sign * order).items():
            high = touching.get(family, np.nan)
            if family in chosen and free <= speeds[1] and not high < speeds[0]:
                rows.append(
                    {
                        "order": order,
                        "source": source,
                        "nodal_diameter": k,
                        "direction": "backward" if sign > 0 else "forward",
                        "family": family,
                        "free": free,
                        "held": high,
                        "margin": margin(free, high, operating),
                    }
                )
    rows.sort(key=lambda row: (np.nan_to_num(row["margin"]), row["free"]))

    def of(key: str) -> Any:
        return np.array([row[key] for row in rows])

    reference, along = model.reference_frequency, "resonance"
    numbers = {"order": np.int64, "nodal_diameter": np.int64}
    return xr.Dataset(
        {
            f"resonance_{end}{unit}": quantity(
                along, of(end).astype(float) * scale, units, f"speed of resonance with {end} tips"
            )
            for end in ("free", "held")
            for unit, scale, units in (("", 1.0 / reference, "1"), ("_rpm", 30.0 / np.pi, "rpm"))
        }
        | {"resonance_margin": quantity(along, of("margin").astype(float), "1", "margin")}
        | {
            f"resonance_{key}": (along, of(key).astype(numbers.get(key, object)))
            for key in ("order", "source", "nodal_diameter", "direction", "family")
        }
    )


def margin(free: float, touching: float, operating: Sequence[float]) -> float:
    """Return the distance of the band between two speeds from an operating range, divided by the
    nearer end of the range; zero if they overlap, nan if the range is not known."""
    low, high = operating
    if np.isnan(low):
        return float("nan")
    ends = [free, free if np.isnan(touching) else touching]
    if max(ends) < low:
        return (low - max(ends)) / low
    return max(0.0, (min(ends) - high) / high)


def _by_family(wave: Waves, names: list[str], order: int) -> dict[str, float]:
    """Return the lowest speed [rad/s] at which a wave of each family at rest has w = order *
    speed."""
    found: dict[str, float] = {}
    for speed in wave.synchronous(order)[0].tolist():
        found.setdefault(names_at(wave, names, speed, order * speed)[1], speed)
    return found
