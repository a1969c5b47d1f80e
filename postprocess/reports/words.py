"""The words with the figures of a run's report, section by section, in the order shown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class FigureWords:
    """What stands with a figure."""

    title: str
    caption: str  #: what it shows, in which units, and what to look for
    wide: bool = False  #: across the page, not half of it


REGIME: Mapping[str, FigureWords] = {
    "regime": FigureWords(
        title="Amplitude, and its growth",
        caption="Root of the mean strain energy of bladed disk and shaft springs in equal windows "
        "[J^½], and the exponential fitted to its last third, or to its last windows where the "
        "march ended early at its displacement limit: its rate [1/s], ± two standard errors, is "
        "what tells growth from ripple. Level: sustained; rising beyond the band: divergent.",
    )
}

SHAFT: Mapping[str, FigureWords] = {
    "orbit": FigureWords(
        title="Orbit of the shaft",
        caption="Path of the shaft's centre [mm] as seen from the rotor (left) and by an observer "
        "at rest (right); pale: the whole run, black: the last turn. Titles give direction and "
        "frequency of the whirl over the last third. Look for a path that leaves the dashed "
        "clearance, or keeps growing.",
    ),
    "whirl": FigureWords(
        title="Whirl over time",
        caption="Mean whirl frequency [Hz], forward upwards, in both frames, which differ by the "
        "speed; filled marks go round clearly. Below, the orbit's radius [mm]. Look for a change "
        "of direction, and for a radius that does not settle.",
    ),
    "state-space": FigureWords(
        title="State space and Poincaré map",
        caption="Velocity [m/s] over place [mm] of the shaft along x, static frame, and the same "
        "once a revolution. One point: periodic with the speed; a closed curve: two frequencies; "
        "a cloud: chaotic.",
    ),
}

FREQUENCIES: Mapping[str, FigureWords] = {
    "spectrum": FigureWords(
        title="Spectrum, rotating frame",
        caption="Amplitude of the shaft [mm] over frequency [Hz], forward to the right, over the "
        "last third, as the rotor sees it. Broken: modes of one nodal diameter, which move the "
        "shaft; a peak on such a line is that mode.",
    ),
    "spectrum-static": FigureWords(
        title="Spectrum, static frame",
        caption="The same for an observer at rest: what sensors on the casing would see. The "
        "dotted line is the speed.",
    ),
    "spectrogram": FigureWords(
        title="Spectrogram, rotating frame",
        caption="The spectrum slice by slice over time. Look for frequencies that appear with "
        "contact, and for lines that drift towards a mode.",
    ),
    "spectrogram-static": FigureWords(
        title="Spectrogram, static frame",
        caption="The same for an observer at rest.",
    ),
}

CONTACT: Mapping[str, FigureWords] = {
    "gaps": FigureWords(
        title="Gaps over blade and time",
        caption="Smallest gap [mm] between each blade and the casing in each span of time; "
        "contact has a colour of its own. Slanted bands are contact that travels round.",
    ),
    "forces": FigureWords(
        title="Contact forces over blade and time",
        caption="Mean normal force [N] on each blade in each span of time; white is no contact.",
    ),
    "contact-classes": FigureWords(
        title="Share of the time in contact",
        caption="Share of the time steps of the last third [%] in which each blade touches: "
        "permanent from 99 %, free where it never does.",
    ),
    "contact-phase": FigureWords(
        title="Shaft against smallest clearance",
        caption="Static angle [°] of the shaft's displacement and of the smallest clearance, and "
        "their difference. Near 0° contact is where the shaft leans (standard scenario, friction "
        "drives backward whirl), near 180° opposite (inverted, forward). The title is of the last "
        "third.",
    ),
}

ENERGIES: Mapping[str, FigureWords] = {
    "energy": FigureWords(
        title="Strain energy of suspension and first family",
        caption="Strain energy [J] of bladed disk and shaft springs by group of modes over time, "
        "averaged; the logarithmic scale makes exponential growth a straight line.",
    ),
    "energy-families": FigureWords(
        title="Strain energy by family and nodal diameter",
        caption="Above by family of modes, below by nodal diameter k [J]. k = 1 moves the shaft; "
        "energy that spreads to other k tells of contact with few blades.",
    ),
    "stress": FigureWords(
        title="Stress",
        caption="Largest stress by beam theory [MPa] over time, and the extremes of every blade "
        "over the run.",
        wide=True,
    ),
}

MAPS = "maps"
"""Figure of a sweep over two keys or more."""

SWEEP: Mapping[str, FigureWords] = {
    "regimes": FigureWords(
        title="Regimes and growth rates",
        caption="Above, the regime of every point; below, the growth rate of its amplitude [1/s] "
        "± two standard errors, over the last third, or over its last windows where a march "
        "ended early at its displacement limit. Look for where the rate crosses zero.",
        wide=True,
    ),
    "frequency-map": FigureWords(
        title="Frequency map, to print",
        caption="Amplitude of the shaft [mm] over the swept key and frequency, rotating frame, "
        "forward upwards, with engine orders (dotted) and modes of one nodal diameter (broken).",
        wide=True,
    ),
    "shaft-radius": FigureWords(
        title="Displacement of the shaft",
        caption="Largest and final displacement of the shaft's centre [mm] over the swept key. "
        "Peaks are critical speeds; a divergent point was ended, and would have gone further.",
        wide=True,
    ),
    "whirl": FigureWords(
        title="Whirl",
        caption="Direction and frequency [Hz] of the shaft's whirl over the last third of each "
        "march, in both frames, with its scatter. Look for where forward turns to backward.",
        wide=True,
    ),
    "contact-phase": FigureWords(
        title="Shaft against contact",
        caption="By how much the shaft leads the contact [°] over the last third: near 0° "
        "standard, near 180° inverted scenario. Points at which nothing touches have no mark.",
        wide=True,
    ),
    "contact-classes": FigureWords(
        title="Blades in contact",
        caption="Share of the time [%] that each blade is in contact over the last third, and how "
        "many blades are in permanent or intermittent contact, or free.",
        wide=True,
    ),
    "energy-families": FigureWords(
        title="Strain energy by family and nodal diameter",
        caption="Mean strain energy [J] of groups of rotor modes late in each march. Look for the "
        "group that takes over where the regime changes.",
        wide=True,
    ),
    "bifurcation": FigureWords(
        title="Bifurcation diagram",
        caption="Places of the shaft once a revolution, and local maxima of its displacement [mm], "
        "of the late motion. One branch: periodic; a smear: quasi-periodic or chaotic.",
        wide=True,
    ),
    MAPS: FigureWords(
        title="Maps over two keys",
        caption="Regime, largest displacement [mm] and growth rate [1/s] over the swept keys. "
        "Crossed out: growth rates within two standard errors of zero.",
        wide=True,
    ),
}
"""Of all figures of a sweep."""
