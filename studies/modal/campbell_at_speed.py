"""What a Campbell diagram shows of a bladed disk that feels that it turns.

Its frequencies bend over the speed, waves backward and forward stand apart, and a wave that stands
still in the rotating frame makes a critical speed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.models.elements.cyclic import nodal_diameters
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.models.modal.labels import LabelledModes
from bladewhirl.models.rotation.at_speed import TurningDisk
from bladewhirl.models.rotation.growth import speed_of_growth
from bladewhirl.models.rotation.waves import REAL, Waves, waves
from bladewhirl.solvers.stability.coincidence import Coincidences

LINE_SPEEDS = 61
"""Speeds along a branch."""

HERTZ = {"units": "Hz"}


def disk_waves(stage: ModalStage, turning: TurningDisk) -> dict[int, Waves]:
    """Waves of each nodal diameter of the bladed disk.

    Raises:
        UserError: its sectors differ.
    """
    structure = turning.matrices.structure
    if not structure.is_cyclic or structure.layout is None:
        raise UserError(
            "campbell: expected equal sectors on equal shaft springs with rotation effects, so that"
            " waves of one nodal diameter stand apart"
        )
    effects, sectors = stage.case.rotation.effects, structure.layout.sectors
    return {k: waves(turning.matrices, k, effects) for k in nodal_diameters(sectors)}


def names_of(modes: LabelledModes) -> dict[int, list[str]]:
    """Families by nodal diameter, the lowest first, a pair given once."""
    one = modes.one_a_pair()
    return {
        int(k): [modes.family[i] for i in one[modes.nodal_diameter[one] == k]]
        for k in np.unique(modes.nodal_diameter[one])
    }


def meetings(
    found: Mapping[int, Waves],
    rotor: LabelledModes,
    casing: LabelledModes,
    names: Mapping[int, list[str]],
    highest: float,
) -> tuple[Coincidences, FloatArray]:
    """Coincidences at speed, and the frequency of the bladed disk's wave at each [rad/s].

    Args:
        found: waves by nodal diameter.
        rotor: modes of the bladed disk that are looked at, a pair given once.
        casing: those of the casing.
        names: families by nodal diameter.
        highest: speed [rad/s].
    """
    rows = []
    for mode in np.flatnonzero(casing.nodal_diameter > 0).tolist():
        k, frequency = int(casing.nodal_diameter[mode]), float(casing.frequency[mode])
        for speed in found[k].meeting(frequency, highest) if k in found else ():
            rank, _ = found[k].rank(float(speed), k * float(speed) - frequency)
            own = (rotor.nodal_diameter == k) & [name == names[k][rank] for name in rotor.family]
            rows += [(float(speed), int(i), mode, k, frequency) for i in np.flatnonzero(own)]
    rows.sort()
    table = np.array(rows).reshape(-1, 5)
    whole = table[:, 1:4].astype(np.int64)
    met = Coincidences(
        speed=table[:, 0], rotor=whole[:, 0], casing=whole[:, 1], nodal_diameter=whole[:, 2]
    )
    return met, met.nodal_diameter * met.speed - table[:, 4]


def at_speed(
    stage: ModalStage,
    turning: TurningDisk,
    found: Mapping[int, Waves],
    names: Mapping[int, list[str]],
    chosen: set[str],
    speeds: tuple[float, float],
) -> xr.Dataset:
    """Branches, critical speeds, engine orders and growth.

    Over `branch` and `line_speed` (normalised): branch_frequency in the rotating frame [Hz],
    positive backward; over `critical` and `engine_order` the speeds at which a branch has no
    frequency there, or k times that of rotation. Over `line_speed` the growth of the tips [m], the
    largest of all.

    Args:
        stage: with the case and what frequencies are relative to.
        turning: its bladed disk.
        found: waves by nodal diameter.
        names: families by nodal diameter, lowest first.
        chosen: families that are told of.
        speeds: of the diagrams, normalised.
    """
    reference = stage.reference_frequency
    line = np.linspace(*speeds, LINE_SPEEDS)
    all_of = {
        k: np.array([own.frequencies(omega) for omega in line * reference])
        for k, own in found.items()
    }
    frequency, rates, branches = [], [], []
    for k, own in found.items():
        size = len(own.mass)
        for rank, name in enumerate(names[k]):
            if name in chosen:
                for way, place in (("backward", size - 1 - rank), ("forward", size + rank)):
                    frequency.append(all_of[k][:, place].real)
                    rates.append(np.abs(all_of[k][:, place].imag))
                    branches.append((k, name, way))
    growth = [turning.growth_at(omega).max() if omega else 0.0 for omega in line * reference]
    room = stage.case.casing.clearance_profile.smallest + turning.disk.model.tip_recess
    growing = [np.abs(each.imag).max(axis=1) > REAL * line * reference for each in all_of.values()]
    first = _first_meeting(found, line * reference, np.any(growing, axis=0))
    return xr.Dataset(
        {
            "branch_frequency": (
                ("branch", "line_speed"),
                np.array(frequency) / (2.0 * np.pi),
                HERTZ | {"long_name": "frequency in the rotating frame, positive backward"},
            ),
            "branch_growth": (
                ("branch", "line_speed"),
                np.where(np.array(rates) > REAL * line * reference, rates, 0.0),
                {"units": "1/s", "long_name": "growth without damping, of waves that have met"},
            ),
            "tip_growth": ("line_speed", growth, {"units": "m", "long_name": "growth of the tips"}),
            **_speeds("critical", found, names, chosen, speeds[1] * reference, reference),
            **_speeds("engine_order", found, names, chosen, speeds[1] * reference, reference),
        },
        coords={
            "line_speed": ("line_speed", line, {"units": "1", "long_name": "normalised speed"}),
            "branch_nodal_diameter": ("branch", [k for k, _, _ in branches]),
            "branch_family": ("branch", np.array([name for _, name, _ in branches], dtype=object)),
            "branch_direction": ("branch", np.array([way for *_, way in branches], dtype=object)),
        },
        attrs={
            "waves_meet": first / reference,
            "clearance_gone": speed_of_growth(turning.disk, turning.matrices, room) / reference,
            "rotation_effects": stage.case.rotation.effects,
        },
    )


def _first_meeting(found: Mapping[int, Waves], line: FloatArray, growing: BoolArray) -> float:
    """Lowest speed from which on two waves of the bladed disk are one, and grow [rad/s].

    Args:
        found: waves by nodal diameter.
        line: speeds [rad/s].
        growing: at which of them one grows.

    Returns:
        to 1e-6 of itself; nan where none grows.
    """

    def met(omega: float) -> bool:
        return any(
            np.abs(own.frequencies(omega).imag).max() > REAL * omega for own in found.values()
        )

    if not growing.any():
        return float("nan")
    after = int(growing.argmax())
    if after == 0:
        return float(line[0])
    low, high = line[after - 1 : after + 1].tolist()
    while high - low > 1e-6 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if met(middle) else (middle, high)
    return float(high)


def _speeds(
    kind: str,
    found: Mapping[int, Waves],
    names: Mapping[int, list[str]],
    chosen: set[str],
    highest: float,
    reference: float,
) -> dict[str, tuple[Any, ...]]:
    """Critical speeds, or those of engine orders, ascending, with whose they are."""
    words = {"critical": "critical speed", "engine_order": "speed met by the engine order k"}
    rows = sorted(_rows(kind, found, names, chosen, highest))
    speed = np.array([row[0] for row in rows])
    share = {"units": "1", "long_name": "share of the strain energy in the shaft springs"}
    return {
        f"{kind}_speed": (
            kind,
            speed / reference,
            {"units": "1", "long_name": f"normalised {words[kind]}"},
        ),
        f"{kind}_rpm": (kind, speed * 30.0 / np.pi, {"units": "rpm", "long_name": words[kind]}),
        f"{kind}_nodal_diameter": (kind, [row[1] for row in rows]),
        f"{kind}_family": (kind, np.array([row[2] for row in rows], dtype=object)),
        f"{kind}_spring_share": (kind, np.array([row[3] for row in rows]), share),
    }


def _rows(
    kind: str,
    found: Mapping[int, Waves],
    names: Mapping[int, list[str]],
    chosen: set[str],
    highest: float,
) -> Iterator[tuple[float, int, str, float]]:
    for k, own in found.items():
        if kind == "engine_order" and k == 0:
            continue
        order = 0 if kind == "critical" else k
        for speed, share in zip(*map(np.ndarray.tolist, own.synchronous(order)), strict=True):
            if speed > highest:
                break
            rank, _ = own.rank(speed, order * speed)
            if names[k][rank] in chosen:
                yield speed, k, names[k][rank], share
