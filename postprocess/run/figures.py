"""All figures of a run by name, each with the data behind it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.fields import ViewError
from bladewhirl.postprocess.fields.windows import late_part, select_window
from bladewhirl.postprocess.run.blade_contact import (
    contact_classes,
    contact_maps,
    plot_contact_classes,
    plot_forces,
    plot_gaps,
)
from bladewhirl.postprocess.run.contact_side import contact_phase, plot_contact_phase
from bladewhirl.postprocess.run.energies import plot_energy, strain_energies
from bladewhirl.postprocess.run.family_energies import (
    cyclic_energies,
    family_energies,
    mean_energies,
    plot_family_energies,
)
from bladewhirl.postprocess.run.growth import amplitude_growth, plot_growth
from bladewhirl.postprocess.run.orbits import Frame, plot_orbit, shaft_orbit
from bladewhirl.postprocess.run.poincare import plot_state_space, poincare_map, state_space
from bladewhirl.postprocess.run.spectra import (
    around_lines,
    modal_lines,
    plot_spectrogram,
    plot_spectrum,
    shaft_spectrogram,
    shaft_spectrum,
)
from bladewhirl.postprocess.run.stresses import plot_stress, stress_history
from bladewhirl.postprocess.run.whirl import plot_whirl_history, whirl_history

Drawn = tuple[Figure, xr.Dataset]


class RunFigures:
    """Draws the figures of a run, or of a window of its time.

    A spectrum, the classes of contact and the contact scenario tell of a motion after its onset:
    without a window they are of the last third of the time.
    """

    def __init__(
        self, dataset: xr.Dataset, start: float | None = None, end: float | None = None
    ) -> None:
        """Look at [start, end] [s], by default the whole run.

        Raises:
            ViewError: the window is not in order, or holds fewer than two records.
        """
        self._result = select_window(dataset, start, end)
        self._orbit = shaft_orbit(self._result)
        self._is_whole = start is None and end is None

    def draw(self, name: str) -> Drawn:
        """One of `FIGURES`, with its data.

        Raises:
            ViewError: there is no such figure, or it can't be had, such as a Poincaré map of a
                rotor at rest.
        """
        if name not in FIGURES:
            raise ViewError(f"figure {name!r}: expected one of {', '.join(FIGURES)}")
        return FIGURES[name](self)

    def _after_onset(self, dataset: xr.Dataset) -> xr.Dataset:
        return late_part(dataset) if self._is_whole else dataset

    def _draw_orbit(self) -> Drawn:
        return plot_orbit(self._orbit), self._orbit

    def _draw_whirl(self) -> Drawn:
        whirls = whirl_history(self._orbit)
        return plot_whirl_history(whirls), whirls

    def _draw_spectrum(self, frame: Frame) -> Drawn:
        lines = modal_lines(self._result, frame)
        spectrum = around_lines(shaft_spectrum(self._after_onset(self._orbit), frame), lines)
        return plot_spectrum(spectrum, lines), spectrum.assign(modal_line=lines)

    def _draw_spectrogram(self, frame: Frame) -> Drawn:
        lines = modal_lines(self._result, frame)
        spectrogram = around_lines(shaft_spectrogram(self._orbit, frame), lines)
        return plot_spectrogram(spectrogram, lines), spectrogram.assign(modal_line=lines)

    def _draw_energy(self) -> Drawn:
        energies = strain_energies(self._result)
        return plot_energy(energies), energies

    def _draw_families(self, analyse: Callable[[xr.Dataset], xr.Dataset]) -> Drawn:
        energies = mean_energies(analyse(self._result))
        return plot_family_energies(energies), energies

    def _draw_state_space(self) -> Drawn:
        states, sections = state_space(self._orbit), poincare_map(self._orbit)
        renamed = {"time": "revolution", "place": "section_place", "velocity": "section_velocity"}
        figure = plot_state_space(states, sections)
        return figure, states.merge(sections.rename(renamed))

    def _draw_gaps(self) -> Drawn:
        maps = contact_maps(self._result)
        return plot_gaps(maps), maps

    def _draw_forces(self) -> Drawn:
        maps = contact_maps(self._result)
        return plot_forces(maps), maps

    def _draw_contact_classes(self) -> Drawn:
        classes = contact_classes(self._after_onset(self._result))
        return plot_contact_classes(classes), classes

    def _draw_contact_phase(self) -> Drawn:
        since = float(self._after_onset(self._result)["time"][0])
        phases = contact_phase(self._result, self._orbit, since=since)
        return plot_contact_phase(phases), phases

    def _draw_regime(self) -> Drawn:
        growth = amplitude_growth(self._result)
        return plot_growth(growth), growth

    def _draw_stress(self) -> Drawn:
        history = stress_history(self._result)
        return plot_stress(history), history


FIGURES: Mapping[str, Callable[[RunFigures], Drawn]] = {
    "orbit": RunFigures._draw_orbit,
    "whirl": RunFigures._draw_whirl,
    "spectrum": lambda run: run._draw_spectrum("rotating"),
    "spectrum-static": lambda run: run._draw_spectrum("static"),
    "spectrogram": lambda run: run._draw_spectrogram("rotating"),
    "spectrogram-static": lambda run: run._draw_spectrogram("static"),
    "state-space": RunFigures._draw_state_space,
    "energy": RunFigures._draw_energy,
    "energy-families": lambda run: run._draw_families(family_energies),
    "energy-cyclic": lambda run: run._draw_families(cyclic_energies),
    "gaps": RunFigures._draw_gaps,
    "forces": RunFigures._draw_forces,
    "contact-classes": RunFigures._draw_contact_classes,
    "contact-phase": RunFigures._draw_contact_phase,
    "stress": RunFigures._draw_stress,
    "regime": RunFigures._draw_regime,
}
"""The figures of a run."""
