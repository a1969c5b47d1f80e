"""The figures of a run by name, see `plotting.registry`, and the data behind each."""

from __future__ import annotations

from functools import cached_property

import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.energy.families import family_energies, mean_energies
from bladewhirl.postprocess.energy.growth import amplitude_growth
from bladewhirl.postprocess.energy.strain import strain_energies
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.windows import late_part, select_window, window_label
from bladewhirl.postprocess.plotting.registry import RUN_FIGURES
from bladewhirl.postprocess.run.blade_contact import contact_classes, contact_maps
from bladewhirl.postprocess.run.casing_contact import casing_contact, with_last_turns
from bladewhirl.postprocess.run.contact_side import contact_phase
from bladewhirl.postprocess.run.stresses import stress_history
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.shaft.poincare import state_space
from bladewhirl.postprocess.shaft.spectra import (
    modal_lines,
    shaft_spectrogram,
    shaft_spectrum,
    with_lines,
)
from bladewhirl.postprocess.shaft.whirl import Frame
from bladewhirl.postprocess.shaft.whirl_history import PERIODS, whirl_history

AT_REST = {"gaps"}
"""Figures that a stage in which nothing moves has, too."""


FORCE_COLUMNS = 200
"""Spans of time in which forces are drawn: a contact is as wide as a line."""


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
        self.result = select_window(dataset, start, end)
        self._is_whole = start is None and end is None

    @cached_property
    def orbit(self) -> xr.Dataset:
        """Motion of the shaft."""
        return shaft_orbit(self.result)

    @cached_property
    def energies(self) -> xr.Dataset:
        """Strain energy over time by groups of modes."""
        return strain_energies(self.result)

    @cached_property
    def contact(self) -> xr.Dataset:
        """Gaps and contact forces over blade and time."""
        return contact_maps(self.result)

    @cached_property
    def stresses(self) -> xr.Dataset:
        """Stresses and strains of every member over time."""
        return stress_history(self.result)

    def after_onset(self, dataset: xr.Dataset) -> xr.Dataset:
        """The last third of a whole run, all of a window."""
        return late_part(dataset) if self._is_whole else dataset

    def draw(self, name: str) -> tuple[Figure, xr.Dataset]:
        """One of `RUN_FIGURES`, with its data.

        Raises:
            ViewError: there is no such figure, or it can't be had, such as an orbit of a stage
                at rest.
        """
        if name not in RUN_FIGURES:
            raise ViewError(f"figure {name!r}: expected one of {', '.join(RUN_FIGURES)}")
        if name not in AT_REST and not self.result["energy"].any():
            raise ViewError(f"nothing moves from {window_label(self.result)}")
        return RUN_FIGURES[name].draw(self)


def orbit(run: RunFigures) -> xr.Dataset:
    """From `orbits.shaft_orbit`."""
    return run.orbit


def whirl(run: RunFigures) -> xr.Dataset:
    """From `whirl_history.whirl_history`."""
    found = whirl_history(run.orbit)
    if found.sizes["time"] < 2:
        raise ViewError(
            f"the whirl over time needs spans of {PERIODS:g} periods of ω₁, two or more;"
            f" the window is {1e3 * found.attrs['span']:.3g} ms long"
        )
    return found


def spectrum(run: RunFigures, frame: Frame) -> xr.Dataset:
    """From `spectra.shaft_spectrum`, after the onset, with lines of modes."""
    late = shaft_spectrum(run.after_onset(run.orbit), frame)
    return with_lines(late, modal_lines(run.result, frame))


def spectrogram(run: RunFigures, frame: Frame) -> xr.Dataset:
    """From `spectra.shaft_spectrogram`, with lines of modes."""
    return with_lines(shaft_spectrogram(run.orbit, frame), modal_lines(run.result, frame))


def states(run: RunFigures) -> xr.Dataset:
    """From `poincare.state_space`."""
    return state_space(run.orbit)


def energy(run: RunFigures) -> xr.Dataset:
    """From `strain.strain_energies`."""
    return run.energies


def energy_of_families(run: RunFigures) -> xr.Dataset:
    """From `families.family_energies`, means over spans of time."""
    return mean_energies(family_energies(run.result))


def contact(run: RunFigures) -> xr.Dataset:
    """From `blade_contact.contact_maps`."""
    return run.contact


def forces(run: RunFigures) -> xr.Dataset:
    """The same in spans so long that they are seen, where there are any."""
    return contact_maps(_touching(run).result, FORCE_COLUMNS)


def contact_on_casing(run: RunFigures) -> xr.Dataset:
    """From `casing_contact.casing_contact`, and of the last revolutions."""
    return with_last_turns(casing_contact(_touching(run).result), run.result)


def classes(run: RunFigures) -> xr.Dataset:
    """From `blade_contact.contact_classes`, after the onset."""
    return contact_classes(_touching(run).after_onset(run.result))


def phases(run: RunFigures) -> xr.Dataset:
    """From `contact_side.contact_phase`; the scenario is that after the onset."""
    since = float(run.after_onset(run.result)["time"][0])
    return contact_phase(run.result, run.orbit, since=since)


def stress(run: RunFigures) -> xr.Dataset:
    """From `stresses.stress_history`."""
    return run.stresses


def growth(run: RunFigures) -> xr.Dataset:
    """From `growth.amplitude_growth`."""
    return amplitude_growth(run.result, run.energies)


def _touching(run: RunFigures) -> RunFigures:
    """The same figures, of a motion in which a tip touches.

    Raises:
        ViewError: none does.
    """
    if not run.result["contact_steps"].isel(time=slice(1, None)).any():
        raise ViewError(f"no tip touches from {window_label(run.result)}")
    return run
