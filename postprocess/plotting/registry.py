"""The figures of a run and of a sweep: their names, words, and the functions that make them.

A new figure is a function that computes its dataset, one that draws it, and an entry here: the
command line, its help, reports and `bladewhirl.plot` then have it. Functions are named, not
imported, so that this module loads the standard library alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pkgutil import resolve_name
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

ROOM = "bladewhirl.postprocess."


@dataclass(frozen=True, kw_only=True)
class FigureKind:
    """A figure by name."""

    name: str
    title: str
    about: str  #: what it shows, in one line
    reading: str = ""  #: how to read it: units, signs, what to look for
    section: str = ""  #: of a report that has it
    wide: bool = False  #: across a report, not half of it
    data: str  #: "module:function" in postprocess that computes its dataset
    plot: str  #: "module:function" in postprocess that draws it from its dataset
    options: Mapping[str, str] = field(default_factory=dict)  #: further arguments of `data`

    @property
    def caption(self) -> str:
        """The words with it in a report."""
        return f"{self.about}. {self.reading}".strip()

    def draw(self, *source: object) -> tuple[Figure, xr.Dataset]:
        """The figure and the data behind it.

        Args:
            source: arguments of the function that computes its dataset.

        Raises:
            ViewError: it can't be had, such as a Poincaré map of a rotor at rest.
        """
        data = resolve_name(ROOM + self.data)(*source, **self.options)
        return resolve_name(ROOM + self.plot)(data), data


def _by_name(kinds: Iterable[FigureKind]) -> Mapping[str, FigureKind]:
    return {kind.name: kind for kind in kinds}


RUN_FIGURES = _by_name(
    [
        FigureKind(
            name="orbit",
            title="Orbit of the shaft",
            about="Path of the shaft's centre [mm] as seen from the rotor and by an observer at "
            "rest",
            reading="Pale: the whole run, black: the last turn. Titles give direction and "
            "frequency of the whirl over the last third. Look for a path that leaves the dashed "
            "clearance, or keeps growing.",
            section="shaft",
            data="run.figures:orbit",
            plot="run.orbits:plot_orbit",
        ),
        FigureKind(
            name="whirl",
            title="Whirl over time",
            about="Mean frequency [Hz] and direction of the whirl over time, in both frames",
            reading="Forward is upwards; the frames differ by the speed; filled marks go round "
            "clearly. Below, the orbit's radius [mm]. Look for a change of direction, and for a "
            "radius that does not settle.",
            section="shaft",
            data="run.figures:whirl",
            plot="run.whirl:plot_whirl_history",
        ),
        FigureKind(
            name="spectrum",
            title="Spectrum, rotating frame",
            about="Amplitude of the shaft [mm] over frequency [Hz], forward and backward, with "
            "lines of modes, rotating frame",
            reading="Over the last third, as the rotor sees it, forward to the right. Broken: "
            "modes of one nodal diameter, which move the shaft; a peak on such a line is that "
            "mode.",
            section="frequencies",
            data="run.figures:spectrum",
            plot="run.spectra:plot_spectrum",
            options={"frame": "rotating"},
        ),
        FigureKind(
            name="spectrum-static",
            title="Spectrum, static frame",
            about="The same for an observer at rest",
            reading="It is what sensors on the casing would see. The dotted line is the speed.",
            section="frequencies",
            data="run.figures:spectrum",
            plot="run.spectra:plot_spectrum",
            options={"frame": "static"},
        ),
        FigureKind(
            name="spectrogram",
            title="Spectrogram, rotating frame",
            about="The spectrum slice by slice over time, rotating frame",
            reading="Look for frequencies that appear with contact, and for lines that drift "
            "towards a mode.",
            section="frequencies",
            data="run.figures:spectrogram",
            plot="run.spectra:plot_spectrogram",
            options={"frame": "rotating"},
        ),
        FigureKind(
            name="spectrogram-static",
            title="Spectrogram, static frame",
            about="The same for an observer at rest",
            section="frequencies",
            data="run.figures:spectrogram",
            plot="run.spectra:plot_spectrogram",
            options={"frame": "static"},
        ),
        FigureKind(
            name="state-space",
            title="State space and Poincaré map",
            about="Velocity [m/s] over place [mm] of the shaft along x, static frame, and the "
            "same once a revolution",
            reading="One point: periodic with the speed; a closed curve: two frequencies; a "
            "cloud: chaotic.",
            section="shaft",
            data="run.figures:states",
            plot="run.poincare:plot_state_space",
        ),
        FigureKind(
            name="energy",
            title="Strain energy of suspension and first family",
            about="Strain energy [J] of bladed disk and shaft springs by group of modes over time",
            reading="Averaged; the logarithmic scale makes exponential growth a straight line.",
            section="energy",
            data="run.figures:energy",
            plot="run.energies:plot_energy",
        ),
        FigureKind(
            name="energy-families",
            title="Strain energy by family and nodal diameter",
            about="Strain energy [J] by family of modes, and by nodal diameter k",
            reading="k = 1 moves the shaft; energy that spreads to other k tells of contact with "
            "few blades.",
            section="energy",
            data="run.figures:energy_of_families",
            plot="run.family_energies:plot_family_energies",
        ),
        FigureKind(
            name="energy-cyclic",
            title="Strain energy by family and nodal diameter, from the field",
            about="The same from a transform of the field over the sectors",
            data="run.figures:energy_of_sectors",
            plot="run.family_energies:plot_family_energies",
        ),
        FigureKind(
            name="gaps",
            title="Gaps over blade and time",
            about="Smallest gap [mm] between each blade and the casing in each span of time",
            reading="Contact has a colour of its own. Slanted bands are contact that travels "
            "round.",
            section="contact",
            data="run.figures:contact",
            plot="run.blade_contact:plot_gaps",
        ),
        FigureKind(
            name="forces",
            title="Contact forces over blade and time",
            about="Mean normal force [N] on each blade in each span of time",
            reading="White is no contact.",
            section="contact",
            data="run.figures:contact",
            plot="run.blade_contact:plot_forces",
        ),
        FigureKind(
            name="contact-classes",
            title="Share of the time in contact",
            about="Share of the time steps of the last third [%] in which each blade touches",
            reading="Permanent contact is from 99 %, a free blade never touches.",
            section="contact",
            data="run.figures:classes",
            plot="run.blade_contact:plot_contact_classes",
        ),
        FigureKind(
            name="contact-phase",
            title="Shaft against smallest clearance",
            about="Static angle [°] of the shaft's displacement and of the smallest clearance, "
            "and their difference",
            reading="Near 0° contact is where the shaft leans (standard scenario, friction drives "
            "backward whirl), near 180° opposite (inverted, forward). The title is of the last "
            "third.",
            section="contact",
            data="run.figures:phases",
            plot="run.contact_side:plot_contact_phase",
        ),
        FigureKind(
            name="stress",
            title="Stress",
            about="Largest stress by beam theory [MPa] of blades, disk and casing over time, and "
            "the extremes of every blade",
            section="energy",
            wide=True,
            data="run.figures:stress",
            plot="run.stresses:plot_stress",
        ),
        FigureKind(
            name="regime",
            title="Amplitude, and its growth",
            about="Root of the mean strain energy of bladed disk and shaft springs in equal "
            "windows [J^½], and the exponential fitted to it",
            reading="The fit is over the last third, or over the last windows where the march "
            "ended early at its displacement limit: its rate [1/s], ± two standard errors, is "
            "what tells growth from ripple. Level: sustained; rising beyond the band: divergent.",
            section="verdict",
            data="run.figures:growth",
            plot="run.growth:plot_growth",
        ),
    ]
)
"""Figures of a run. `data` takes a `run.figures.RunFigures`."""

SWEEP_FIGURES = _by_name(
    [
        FigureKind(
            name="frequency-map",
            title="Frequency map, to print",
            about="Amplitude of the shaft [mm] over the swept key and frequency, rotating frame",
            reading="Forward is upwards; dotted: engine orders, broken: modes of one nodal "
            "diameter.",
            section="frequencies",
            wide=True,
            data="sweep.frequency_map:frequency_map",
            plot="sweep.frequency_map:plot_frequency_map",
        ),
        FigureKind(
            name="shaft-radius",
            title="Displacement of the shaft",
            about="Largest and final displacement of the shaft's centre [mm] over the swept key",
            reading="Peaks are critical speeds; a divergent point was ended, and would have gone "
            "further.",
            section="motion",
            wide=True,
            data="sweep.quantities:shaft_radius",
            plot="sweep.shaft:plot_shaft_radius",
        ),
        FigureKind(
            name="regimes",
            title="Regimes and growth rates",
            about="Regime of every point, and growth rate of its amplitude [1/s] ± two standard "
            "errors",
            reading="Rates are of the last third, or of the last windows where a march ended "
            "early at its displacement limit. Look for where the rate crosses zero.",
            section="regimes",
            wide=True,
            data="sweep.quantities:regimes",
            plot="sweep.regimes:plot_regimes",
        ),
        FigureKind(
            name="whirl",
            title="Whirl",
            about="Direction and frequency [Hz] of the shaft's whirl over the last third of each "
            "march, in both frames, with its scatter",
            reading="Look for where forward turns to backward.",
            section="motion",
            wide=True,
            data="sweep.quantities:whirls",
            plot="sweep.shaft:plot_whirls",
        ),
        FigureKind(
            name="contact-phase",
            title="Shaft against contact",
            about="By how much the shaft leads the contact [°] over the last third",
            reading="Near 0° standard, near 180° inverted scenario. Points at which nothing "
            "touches have no mark.",
            section="motion",
            wide=True,
            data="sweep.quantities:contact_sides",
            plot="sweep.shaft:plot_contact_sides",
        ),
        FigureKind(
            name="contact-classes",
            title="Blades in contact",
            about="Share of the time [%] that each blade is in contact over the last third, and "
            "how many blades are in permanent or intermittent contact, or free",
            section="motion",
            wide=True,
            data="sweep.blades:blade_contacts",
            plot="sweep.blades:plot_blade_contacts",
        ),
        FigureKind(
            name="energy-families",
            title="Strain energy by family and nodal diameter",
            about="Mean strain energy [J] of groups of rotor modes late in each march",
            reading="Look for the group that takes over where the regime changes.",
            section="motion",
            wide=True,
            data="sweep.energies:point_energies",
            plot="sweep.energies:plot_point_energies",
        ),
        FigureKind(
            name="bifurcation",
            title="Bifurcation diagram",
            about="Places of the shaft once a revolution, and local maxima of its displacement "
            "[mm], of the late motion",
            reading="One branch: periodic; a smear: quasi-periodic or chaotic.",
            section="motion",
            wide=True,
            data="sweep.bifurcation:bifurcation",
            plot="sweep.bifurcation:plot_bifurcation",
        ),
        FigureKind(
            name="maps",
            title="Maps over two keys",
            about="Regime, largest displacement [mm] and growth rate [1/s] over the swept keys",
            reading="Crossed out: growth rates within two standard errors of zero.",
            section="motion",
            wide=True,
            data="sweep.maps:sweep_maps",
            plot="sweep.maps:plot_sweep_maps",
        ),
    ]
)
"""Figures of a sweep. `data` takes the dataset and the swept key to go along."""


def captions(kinds: Mapping[str, FigureKind]) -> list[str]:
    """A line for each figure: its name and what it shows."""
    return [f"{name}: {kind.about}." for name, kind in kinds.items()]
