"""Figures of runs, sweeps and modes: functions that take data and return a matplotlib Figure.

    import bladewhirl as bw

    with bw.open_result("runs/rub") as result:
        figure = bw.plot.orbit(result, start=0.2)
        bw.save_figure(figure, "orbit")

Most take a result of `bw.open_result`, or a sweep of `bw.open_sweep` where their docstring says so,
and the window of a run [s]. Their names are those of `bladewhirl plot`, with _ for -. `campbell`,
`veering` and `shaft_veering` take what `bw.campbell` and `bw.veering` return.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, Protocol

from bladewhirl.postprocess.plotting.registry import RUN_FIGURES, SWEEP_FIGURES

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = [
    "bifurcation",
    "campbell",
    "contact_angle",
    "contact_classes",
    "contact_phase",
    "energy",
    "energy_families",
    "forces",
    "frequency_map",
    "gaps",
    "maps",
    "orbit",
    "regime",
    "regimes",
    "shaft_radius",
    "shaft_veering",
    "spectrogram",
    "spectrogram_static",
    "spectrum",
    "spectrum_static",
    "state_space",
    "stress",
    "veering",
    "whirl",
]


class Plot(Protocol):
    """A function that draws a figure of a run or a sweep."""

    def __call__(
        self, dataset: xr.Dataset, start: float | None = None, end: float | None = None
    ) -> Figure:
        """Draw it, of a run within [start, end] [s]."""


def _plot(name: str) -> Plot:
    """The function that draws a figure of the registry, with the words of its captions."""

    def draw(dataset: xr.Dataset, start: float | None = None, end: float | None = None) -> Figure:
        from bladewhirl.postprocess.fields.kinematics import ViewError
        from bladewhirl.postprocess.run.figures import RunFigures
        from bladewhirl.postprocess.sweep.figures import SweepFigures

        if "state" not in dataset:
            return RunFigures(dataset, start, end).draw(name)[0]
        if start is not None or end is not None:
            raise ViewError("expected no start and end with a sweep")
        return SweepFigures(dataset).draw(name)[0]

    kinds = {"a run": RUN_FIGURES, "a sweep": SWEEP_FIGURES}
    draw.__doc__ = "\n\n".join(
        f"Of {source}: {registry[name].caption}"
        for source, registry in kinds.items()
        if name in registry
    )
    draw.__name__ = draw.__qualname__ = name.replace("-", "_")
    return draw


bifurcation = _plot("bifurcation")
contact_angle = _plot("contact-angle")
contact_classes = _plot("contact-classes")
contact_phase = _plot("contact-phase")
energy = _plot("energy")
energy_families = _plot("energy-families")
forces = _plot("forces")
frequency_map = _plot("frequency-map")
gaps = _plot("gaps")
maps = _plot("maps")
orbit = _plot("orbit")
regime = _plot("regime")
regimes = _plot("regimes")
shaft_radius = _plot("shaft-radius")
spectrogram = _plot("spectrogram")
spectrogram_static = _plot("spectrogram-static")
spectrum = _plot("spectrum")
spectrum_static = _plot("spectrum-static")
state_space = _plot("state-space")
stress = _plot("stress")
whirl = _plot("whirl")


def campbell(found: xr.Dataset, frame: Literal["rotating", "static"] = "rotating") -> Figure:
    """Campbell diagram, in rotating axes or as seen from the casing, of `bw.campbell(case)`."""
    from bladewhirl.postprocess.modal.campbell import plot_campbell

    return plot_campbell(found, frame)


def veering(found: xr.Dataset, families: int | None = None) -> Figure:
    """Frequencies over nodal diameter with both centres, of `bw.veering(case)`: the first
    families, or all that it has.
    """
    from bladewhirl.postprocess.modal.veering import plot_families

    return plot_families(found, families)


def shaft_veering(found: xr.Dataset) -> Figure:
    """Modes with one nodal diameter over the stiffness of the shaft, of `bw.veering(case)`."""
    from bladewhirl.postprocess.modal.veering import plot_shaft_veering

    return plot_shaft_veering(found)
