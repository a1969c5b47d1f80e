"""Campbell diagram of a bladed disk with rotation effects.

The frequencies depend on the speed and on the direction of the waves. A speed at which a wave has
zero frequency in the rotating frame is a critical speed.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.progress import tracked
from bladewhirl.models.modal.labels import LabelledModes, families_at_speed
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.structure.waves import REAL, Waves
from bladewhirl.solvers.stability.coincidence import Coincidences
from bladewhirl.studies.runs.columns import quantity

LINE_SPEEDS = 61  #: number of speeds at which the frequencies of a branch are computed


def refuse_unequal_bearings(name: str, case: Case, *, allowed: str | None = None) -> None:
    """Raise a UserError if stationary shaft springs differ, unless the effects are `allowed`."""
    shaft, effects = case.shaft, case.rotation.effects
    if shaft.anisotropy and not shaft.clamped and effects != allowed:
        or_full = ', or rotation.effects = "full"' if allowed else ""
        raise UserError(
            f"{name}: expected equal shaft springs (shaft.stiffness_y is not shaft.stiffness, and"
            f' shaft.frame = "static"){or_full}'
        )


def names_at(disk: Waves, names: list[str], omega: float, frequency: float) -> tuple[str, str]:
    """Return the family of the branch nearest to a frequency at the speed omega, and the family of
    this branch at rest.

    `names` are the families of one nodal diameter at rest, the lowest first. The frequency is
    positive for a backward wave; speed and frequency are in rad/s.
    """
    rank, backward = disk.rank(omega, frequency)
    return branch_names(disk, names, omega, backward)[rank], names[rank]


def branch_names(disk: Waves, names: list[str], omega: float, backward: bool) -> list[str]:
    """Return the families of all backward, or of all forward branches at the speed omega [rad/s];
    `names` are the families of the branches at rest."""
    if "suspension" not in names:
        return names
    shares, size = disk.spring_shares(omega), len(disk.mass)
    return families_at_speed(names, shares[:size][::-1] if backward else shares[size:])


def meetings(
    disk: Mapping[int, Waves],
    rotor: LabelledModes,
    casing: LabelledModes,
    names: Mapping[int, list[str]],
    highest: float,
) -> tuple[Coincidences, FloatArray, list[str]]:
    """Compute coincidences with rotation effects up to the speed `highest` [rad/s]; return also the
    frequencies [rad/s] and the families of the coincident waves of the bladed disk.

    `disk` has the waves of the bladed disk for each nodal diameter, and `names` the names of their
    families at rest; `rotor` has one mode of each pair.
    """
    rows: list[tuple[float, int, int, int, float, str]] = []
    at_rest = rotor.at_rest or rotor.family
    for mode in np.flatnonzero(casing.nodal_diameter > 0).tolist():
        k, frequency = int(casing.nodal_diameter[mode]), float(casing.frequency[mode])
        for speed in disk[k].meeting(frequency, highest) if k in disk else ():
            w = k * float(speed) - frequency
            family, before = names_at(disk[k], names[k], float(speed), w)
            same = (rotor.nodal_diameter == k) & [name == before for name in at_rest]
            met_here = np.flatnonzero(same).tolist()
            rows += [(float(speed), i, mode, k, frequency, family) for i in met_here]
    rows.sort()
    table = np.array([row[:5] for row in rows]).reshape(-1, 5)
    numbers = table[:, 1:4].astype(np.int64)
    met = Coincidences(
        speed=table[:, 0], rotor=numbers[:, 0], casing=numbers[:, 1], nodal_diameter=numbers[:, 2]
    )
    return met, met.nodal_diameter * met.speed - table[:, 4], [row[5] for row in rows]


def dataset_at_speed(
    stage: ModalModel,
    disk: Mapping[int, Waves],
    names: Mapping[int, list[str]],
    chosen: set[str],
    speeds: tuple[float, float],
) -> xr.Dataset:
    """Compute branches, critical speeds, engine orders and growth at normalised speeds, see
    `campbell`.

    `disk` has the waves of the bladed disk for each nodal diameter, and `names` the names of their
    families at rest, the lowest first. Only branches of the chosen families are included.
    """
    reference = stage.reference_frequency
    line = np.linspace(*speeds, LINE_SPEEDS)
    omegas = line * reference
    spectra = {
        k: np.array([w.frequencies(omega) for omega in omegas])
        for k, w in tracked("frequencies over the speed", disk.items())
    }
    branches = [
        (k, branch_names(waves_of_k, names[k], omegas[0], way == "backward")[rank], name, way, w)
        for k, waves_of_k in disk.items()
        for size in [len(waves_of_k.mass)]
        for rank, name in enumerate(names[k])
        if name in chosen
        for way, w in (
            ("backward", spectra[k][:, size - 1 - rank]),
            ("forward", spectra[k][:, size + rank]),
        )
    ]
    diameters, families, at_rest, directions, frequencies = zip(*branches, strict=True)
    rates = np.abs(np.array(frequencies).imag)
    growth = stage.disk.growth(omegas)
    of_tips = {}
    if growth is not None:
        of_tips = {"tip_growth": quantity("line_speed", growth, "m", "growth of the tips")}
    growing = [np.abs(s.imag).max(axis=1) > REAL * omegas for s in spectra.values()]
    first = _first_meeting(disk, omegas, np.any(growing, axis=0))
    plane, hertz = ("branch", "line_speed"), np.array(frequencies).real / (2.0 * np.pi)
    merged = np.where(rates > REAL * omegas, rates, 0.0)
    positive_backward = "frequency in the rotating frame, positive backward"
    of_merged = "growth rate of merged waves without damping"
    return xr.Dataset(
        {
            "branch_frequency": quantity(plane, hertz, "Hz", positive_backward),
            "branch_growth": quantity(plane, merged, "1/s", of_merged),
            **of_tips,
            **_speeds("critical", disk, names, chosen, omegas[-1], reference),
            **_speeds("engine_order", disk, names, chosen, omegas[-1], reference),
        },
        coords={
            "line_speed": quantity("line_speed", line, "1", "normalised speed"),
            "branch_nodal_diameter": ("branch", list(diameters)),
            "branch_family": ("branch", np.array(families, dtype=object)),
            "branch_family_at_rest": ("branch", np.array(at_rest, dtype=object)),
            "branch_direction": ("branch", np.array(directions, dtype=object)),
        },
        attrs={
            "waves_meet": first / reference,
            "clearance_gone": stage.disk.clearance_gone / reference,
            "rotation_effects": stage.effects,
        },
    )


def _first_meeting(disk: Mapping[int, Waves], line: FloatArray, growing: BoolArray) -> float:
    """Return the lowest speed at which two waves of the bladed disk merge, so that one of them
    grows [rad/s], with a relative accuracy of 1e-6; nan if no wave grows.

    `growing` contains for each speed of `line` [rad/s] whether a wave grows.
    """

    def merged(omega: float) -> bool:
        return any(np.abs(w.frequencies(omega).imag).max() > REAL * omega for w in disk.values())

    if not growing.any():
        return float("nan")
    after = int(growing.argmax())
    if after == 0:
        return float(line[0])
    low, high = line[after - 1 : after + 1].tolist()
    while high - low > 1e-6 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if merged(middle) else (middle, high)
    return float(high)


def _speeds(
    kind: str,
    disk: Mapping[int, Waves],
    names: Mapping[int, list[str]],
    chosen: set[str],
    highest: float,
    reference: float,
) -> dict[str, tuple[Any, ...]]:
    """Return critical speeds, or speeds of engine orders, ascending, with nodal diameter and
    family."""
    orders = {k: 0 if kind == "critical" else k for k in disk if k or kind == "critical"}
    rows = sorted(
        (speed, k, *names_at(disk[k], names[k], speed, order * speed), share)
        for k, order in orders.items()
        for speed, share in zip(*map(np.ndarray.tolist, disk[k].synchronous(order)), strict=True)
        if speed <= highest
    )
    rows = [row for row in rows if row[3] in chosen]
    speeds = np.array([row[0] for row in rows])
    name = {
        "critical": "critical speed",
        "engine_order": "speed at which the frequency is k times the rotation frequency",
    }[kind]
    share_name = "share of the strain energy in the shaft springs"
    return {
        f"{kind}_speed": quantity(kind, speeds / reference, "1", f"normalised {name}"),
        f"{kind}_rpm": quantity(kind, speeds * 30.0 / np.pi, "rpm", name),
        f"{kind}_nodal_diameter": (kind, [row[1] for row in rows]),
        f"{kind}_family": (kind, np.array([row[2] for row in rows], dtype=object)),
        f"{kind}_family_at_rest": (kind, np.array([row[3] for row in rows], dtype=object)),
        f"{kind}_spring_share": quantity(kind, np.array([row[4] for row in rows]), "1", share_name),
    }
