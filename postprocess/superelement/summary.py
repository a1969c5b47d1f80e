"""Summary and regime of the run of a superelement, and its reduction to the data of a sweep."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.energy.growth_rates import RIGID, windowed_amplitude
from bladewhirl.postprocess.energy.regimes import Regime, RegimeName, classify_windows
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.result import portions
from bladewhirl.postprocess.fields.windows import late_part
from bladewhirl.postprocess.run.summary import MarchQuality, common_figures
from bladewhirl.postprocess.run.summary_table import steps_text
from bladewhirl.postprocess.run.wear import lobes_text
from bladewhirl.postprocess.superelement.motion import DIRECTIONS, check_superelement
from bladewhirl.postprocess.superelement.ring import is_flexible, ring_displacement
from bladewhirl.postprocess.sweep.dataset import NATURAL, WINDOW_SHARE, Layout
from bladewhirl.postprocess.sweep.digest import (
    Digest,
    coded,
    magnitudes,
    padded,
    span_starts,
    wear_numbers,
)

TANGENTIAL = DIRECTIONS.index("tangential")

LATE = 10
"""The impulse per revolution is averaged over up to this many complete revolutions at the end."""

DIGESTED = (
    "regime end_reason end_time steps unsolved_steps growth_rate impulse_per_revolution"
    " casing_displacement_max energy_residual complementarity_residual dt_over_critical"
).split()
"""Fields of a summary that a sweep stores under the same name."""


@dataclass(frozen=True, kw_only=True)
class NodeSummary(MarchQuality):
    """Key figures of the run of a superelement."""

    end_reason: str  #: "completed", "divergent" or "interrupted"
    end_time: float  #: time of the last record [s]
    revolutions: float  #: number of revolutions
    regime: RegimeName
    regime_criterion: str  #: criterion of the regimes, and the reason for the regime of this run
    growth_rate: float | None
    """Growth rate of the amplitude [1/s], see `node_regime`; None if growth cannot be
    judged."""
    growth_rate_error: float | None  #: standard error of `growth_rate` [1/s]
    contact_impulse: float  #: sum of the normal impulses on all nodes [N s]
    contact_impulse_by_blade: list[float]  #: sum for each blade [N s]
    impulse_per_revolution: float | None
    """Normal impulse on all nodes per revolution [N s], averaged over at most ten complete
    revolutions at the end; None without a complete revolution."""
    contact_force_max: dict[str, float]
    """Largest normal force between two records: "force" [N], "blade", "node", "time" [s]."""
    contact_share: list[float]  #: share of the time steps in contact, for each contact node
    contact_displacement_max: dict[str, float]
    """Largest displacement of a contact node in each direction [m]."""
    casing_displacement_max: float | None
    """Largest radial displacement of a node of a flexible casing [m]; None for a rigid wall."""
    gap_min: float  #: smallest gap at any step [m]
    work: dict[str, float]  #: works of "load", "normal", "friction", "damping" [J]
    energy_final: float  #: energy at the end [J]

    def rows(self) -> dict[str, str]:
        """Return the rows of the summary, with rounded values in convenient units."""
        force, moved = self.contact_force_max, self.contact_displacement_max
        touched = sum(share > 0.0 for share in self.contact_share)
        per_turn = self.impulse_per_revolution
        return {
            "regime": self.regime,
            "because": self.regime_criterion.rpartition("Here: ")[2],
            "end time": f"{self.end_time:.6g} s, {self.end_reason}, {self.revolutions:.4g} turns",
            "contact nodes that touched": f"{touched} of {len(self.contact_share)}",
            "normal impulse": f"{self.contact_impulse:.6g} N s; per revolution at the end "
            + ("unknown" if per_turn is None else f"{per_turn:.6g} N s"),
            "contact force, largest": f"{handy(force['force'], 'N', 4)}, blade {force['blade']:g},"
            f" node {force['node']:g} at {handy(force['time'], 's', 4)}"
            if force["force"]
            else "none",
            "contact node displacement, largest": ", ".join(
                f"{name} {handy(value, 'm', 4)}" for name, value in moved.items()
            ),
            **(
                {}
                if self.casing_displacement_max is None
                else {"casing displacement, largest": handy(self.casing_displacement_max, "m", 4)}
            ),
            **({"removed from the coating": _wear_text(self.wear)} if self.wear else {}),
            "work of": ", ".join(f"{name} {value:.4g} J" for name, value in self.work.items()),
            "energy at the end": f"{self.energy_final:.4g} J",
            "energy residual": f"{self.energy_residual:.3g}",
            "complementarity residual": f"{self.complementarity_residual:.3g}"
            f" ({self.unsolved_steps} steps unsolved)",
            "time step / critical": f"{self.dt_over_critical:.3g}",
            "steps": steps_text(self),
            "wall time": f"{self.wall_time:.3g} s ({self.us_per_step:.3g} µs a step)",
        }


def summarise_nodes(dataset: xr.Dataset, march_report: Mapping[str, float]) -> NodeSummary:
    """Compute the summary of the result of a superelement.

    Args:
        dataset: result of a superelement.
        march_report: quality measures of the march, see `postprocess.run.summary.summarise`.
    """
    check_superelement(dataset)
    time, impulse = dataset["time"].values, dataset["contact_impulse"].values
    speed, blade = abs(float(dataset.attrs["speed"])), dataset["blade"].values
    spacing = np.diff(time, prepend=-np.inf)
    force = impulse / spacing[:, None]
    record, node = np.unravel_index(int(force.argmax()), force.shape)
    moved = np.abs(dataset["contact_displacement"].values).max(axis=(0, 1))
    names = {"load": "external", "normal": "normal", "friction": "friction", "damping": "damping"}
    turns = speed * float(time[-1]) / (2.0 * np.pi)
    ring = [
        np.abs(ring_displacement(dataset, np.arange(s.start, s.stop))[:, :, 0]).max()
        for s in (portions(dataset) if is_flexible(dataset) else ())
    ]
    return NodeSummary(
        **common_figures(dataset, node_regime(dataset), march_report),
        revolutions=turns,
        contact_impulse_by_blade=np.bincount(blade, impulse.sum(axis=0)).tolist(),
        impulse_per_revolution=_late_impulse(time, impulse.sum(axis=1), speed),
        contact_force_max={
            "force": float(force[record, node]),
            "blade": int(blade[node]),
            "node": int(dataset["node"].values[node]),
            "time": float(time[record]),
        },
        contact_displacement_max=dict(zip(DIRECTIONS, moved.tolist(), strict=True)),
        casing_displacement_max=float(np.max(ring)) if ring else None,
        gap_min=float(dataset["gap"].values[1:].min(initial=np.inf))
        if len(time) > 1
        else float(dataset["clearance"].min()),
        work={
            name: float(dataset[f"{key}_work"][-1]) * (-1.0 if name == "damping" else 1.0)
            for name, key in names.items()
        },
        energy_final=float(dataset["energy"][-1]),
    )


def node_regime(dataset: xr.Dataset) -> Regime:
    """Classify the run of a superelement by `CRITERION`.

    The amplitude is the root of the mean energy in equal windows of time. A window is at least one
    revolution and at least half a period of the lowest elastic mode long. The energy is the strain
    and kinetic energy of all copies and of a flexible casing.
    """
    frequency = dataset["modal_frequency"].values
    elastic = frequency[frequency > RIGID * frequency.max()]
    speed = abs(float(dataset.attrs["speed"]))
    shortest = max(np.pi / elastic.min(), 2.0 * np.pi / speed if speed else 0.0)
    windows = windowed_amplitude(dataset["time"].values, dataset["energy"].values, shortest)
    return classify_windows(dataset, windows, clearance=smallest_node_clearance(dataset))


def smallest_node_clearance(dataset: xr.Dataset) -> float:
    """Return the smallest clearance plus the smallest distance by which a contact node lies inside
    the radius from which the clearance is measured [m]."""
    return float(dataset["clearance"].values.min() + dataset["contact_recess"].values.min())


def _wear_text(wear: Mapping[str, Any]) -> str:
    volume, dissipated = 1e9 * wear["wear_volume"], wear["wear_dissipated"]
    metal = wear["metal_time"]
    touched = "not touched" if metal is None else f"touched at {handy(metal, 's', 4)}"
    return (
        f"{volume:.4g} mm³, at most {100.0 * wear['wear_strain_max']:.3g} % of its thickness,"
        f" {handy(dissipated, 'J', 4)}; {lobes_text(wear)}; metal {touched}"
    )


def _late_impulse(time: np.ndarray[Any, Any], total: Any, speed: float) -> float | None:
    """Return the impulse per revolution [N s], averaged over at most `LATE` complete revolutions at
    the end; None without a complete revolution."""
    turn = 2.0 * np.pi / speed if speed else np.inf
    whole = int(min(LATE, np.floor(time[-1] / turn + 1e-9)))
    if whole < 1:
        return None
    sums = np.interp([time[-1] - whole * turn, time[-1]], time, np.cumsum(total))
    return float((sums[1] - sums[0]) / whole)


def node_digest(dataset: xr.Dataset, report: Mapping[str, float], layout: Layout) -> Digest:
    """Reduce the result of a superelement to the data of a sweep.

    Args:
        dataset: the result.
        report: quality measures of the march, as for `summarise_nodes`.
        layout: sizes of the arrays; elements without a value are NaN.
    """
    summary, late = summarise_nodes(dataset, report), late_part(dataset)
    time, energy = dataset["time"].values, dataset["energy"].values
    step = float(dataset.attrs["record_step"])
    first = len(time) - max(1, round(min(layout.window, WINDOW_SHARE * np.ptp(time)) / step))
    starts = span_starts(len(time), layout.samples)
    counts = np.diff(starts, append=len(time))
    moved = dataset["contact_displacement"].values
    radial = np.abs(moved[:, :, 0]).max(axis=1)
    late_steps = np.ptp(late["time"].values) / float(dataset.attrs["time_step"])
    share = late["contact_steps"].values[1:].sum(axis=0) / max(late_steps, 1.0)
    blade = dataset["blade"].values
    natural = dataset["modal_frequency"].values[0] / (2.0 * np.pi)  # of the first copy
    swing = moved[first:, :, TANGENTIAL]
    swing = swing[:, int(np.abs(swing).max(axis=0).argmax())]  # of the node that moves most
    spectrum = 2.0 * magnitudes(swing.astype(complex), step, layout.frequency)
    values = {
        **{name: _number(getattr(summary, name)) for name in DIGESTED},
        "rotation_speed": dataset.attrs["speed"],
        "reference_frequency": dataset.attrs["reference_frequency"],
        "growth_error": _number(summary.growth_rate_error),
        "smallest_clearance": smallest_node_clearance(dataset),
        "contact_force_max": summary.contact_force_max["force"],
        "contact_share": padded(_by_blade(blade, np.array(summary.contact_share)), layout.blades),
        "late_contact_share": padded(_by_blade(blade, share), layout.blades),
        "displacement_max": max(summary.contact_displacement_max.values()),
        "late_displacement": np.abs(late["contact_displacement"].values).max(axis=(0, 1)),
        **wear_numbers(dataset),
        "gap_violation_max": max(0.0, -summary.gap_min),
        "window_start": time[first],
        "natural_frequency": padded(np.sort(natural)[:NATURAL], NATURAL),
        "spectrum": np.where(layout.frequency == 0.0, 0.5 * spectrum, spectrum),
        "energy_max": energy.max(),
        "history_time": padded(time[starts], layout.samples),
        "radial_history": padded(np.maximum.reduceat(radial, starts), layout.samples),
        "energy_history": padded(np.add.reduceat(energy, starts) / counts, layout.samples),
    }
    return coded(values, layout)


def _number(value: Any) -> Any:
    return np.nan if value is None else value


def _by_blade(blade: IntArray, share: Array) -> Array:
    """Return for each blade the largest share of time in contact among its contact nodes."""
    largest = np.zeros(int(blade.max()) + 1)
    np.maximum.at(largest, blade, share)
    return largest
