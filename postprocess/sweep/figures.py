"""All figures of a sweep by name, each with the data behind it; histories are not read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import xarray as xr

from bladewhirl.postprocess.fields.fields import ViewError
from bladewhirl.postprocess.plotting.style import save_figure
from bladewhirl.postprocess.run.figures import Drawn
from bladewhirl.postprocess.sweep.bifurcation import bifurcation, plot_bifurcation
from bladewhirl.postprocess.sweep.blades import blade_contacts, plot_blade_contacts
from bladewhirl.postprocess.sweep.dataset import open_sweep
from bladewhirl.postprocess.sweep.energies import plot_point_energies, point_energies
from bladewhirl.postprocess.sweep.frequency_map import frequency_map, plot_frequency_map
from bladewhirl.postprocess.sweep.maps import plot_sweep_maps, sweep_maps
from bladewhirl.postprocess.sweep.quantities import (
    contact_sides,
    main_key,
    regimes,
    shaft_radius,
    whirls,
)
from bladewhirl.postprocess.sweep.regimes import plot_regimes
from bladewhirl.postprocess.sweep.shaft import plot_contact_sides, plot_shaft_radius, plot_whirls


class SweepFigures:
    """Draws the figures of a sweep, along the speed if it is swept, else along the first key."""

    def __init__(self, dataset: xr.Dataset) -> None:
        """Look at a dataset from `open_sweep`, which must stay open."""
        self._sweep, self._key = dataset, main_key(dataset)

    def draw(self, name: str) -> Drawn:
        """One of `SWEEP_FIGURES`, with its data.

        Raises:
            KeyError: there is no such figure.
            ViewError: it can't be had, such as one of a sweep without a point that is done.
        """
        return SWEEP_FIGURES[name](self)

    def _draw_frequency_map(self) -> Drawn:
        maps = frequency_map(self._sweep, self._key)
        return plot_frequency_map(maps), maps

    def _draw_shaft_radius(self) -> Drawn:
        radius = shaft_radius(self._sweep, self._key)
        return plot_shaft_radius(radius), radius

    def _draw_regimes(self) -> Drawn:
        found = regimes(self._sweep, self._key)
        return plot_regimes(found), found

    def _draw_whirl(self) -> Drawn:
        found = whirls(self._sweep, self._key)
        return plot_whirls(found), found

    def _draw_contact_phase(self) -> Drawn:
        found = contact_sides(self._sweep, self._key)
        return plot_contact_sides(found), found

    def _draw_contact_classes(self) -> Drawn:
        found = blade_contacts(self._sweep, self._key)
        return plot_blade_contacts(found), found

    def _draw_energy_families(self) -> Drawn:
        found = point_energies(self._sweep, self._key)
        return plot_point_energies(found), found

    def _draw_bifurcation(self) -> Drawn:
        found = bifurcation(self._sweep, self._key)
        return plot_bifurcation(found), found

    def _draw_maps(self) -> Drawn:
        maps = sweep_maps(self._sweep, self._key)
        return plot_sweep_maps(maps), maps


SWEEP_FIGURES: Mapping[str, Callable[[SweepFigures], Drawn]] = {
    "frequency-map": SweepFigures._draw_frequency_map,
    "shaft-radius": SweepFigures._draw_shaft_radius,
    "regimes": SweepFigures._draw_regimes,
    "whirl": SweepFigures._draw_whirl,
    "contact-phase": SweepFigures._draw_contact_phase,
    "contact-classes": SweepFigures._draw_contact_classes,
    "energy-families": SweepFigures._draw_energy_families,
    "bifurcation": SweepFigures._draw_bifurcation,
    "maps": SweepFigures._draw_maps,
}
"""The figures of a sweep."""

LEFT_BY_A_SWEEP = ("frequency-map", "shaft-radius", "regimes")
"""Figures that a sweep leaves in its folder."""


def leave_figures(directory: Path) -> dict[str, str]:
    """Write `LEFT_BY_A_SWEEP` into the folder of a sweep, as PNG and PDF with their data.

    Returns:
        why each figure that could not be drawn is not there.
    """
    left_out = {}
    with open_sweep(directory) as dataset:
        figures = SweepFigures(dataset)
        for name in LEFT_BY_A_SWEEP:
            try:
                figure, data = figures.draw(name)
            except ViewError as error:
                left_out[name] = str(error)
            else:
                save_figure(figure, directory / name, data)
    return left_out
