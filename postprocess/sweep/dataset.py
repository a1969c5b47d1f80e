"""Datasets of sweeps: what they hold for every point, and how they are opened.

The dimensions before all others are the swept keys, march.speed as march_speed. Names are kept as
numbers with their meanings beside them (CF conventions), so that a point is written in place;
`open_sweep` turns them into text.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.fields.fields import Array

SWEEP_NAME = "sweep.nc"
"""The dataset's file in the folder of a sweep."""

MISSING, DONE, FAILED = 0, 1, 2
"""`state` of a point."""

FORMAT = 2
"""Of what is kept of a point. Sweeps of format 1 have nothing of the late motion, see
`late_motion`; they can be read, but not resumed."""

_WHIRLS = ("unknown", "none", "backward", "forward")

FLAGS: Mapping[str, tuple[str, ...]] = {
    "state": ("missing", "done", "failed"),
    "regime": ("unknown", "divergent", "no-contact", "damped", "sustained"),
    "end_reason": ("unknown", "completed", "divergent"),
    "whirl_rotating": _WHIRLS,
    "whirl_static": _WHIRLS,
    "scenario": ("unknown", "at-rest", "standard", "inverted", "unsteady"),
}
"""Meanings of the numbers of variables that name something, from 0 on."""

WINDOW_SHARE = 0.5
"""Share of the shortest march, at whose end spectra and mean energies are taken of each one; the
transient is before. Of a march that ends early it is at most that share of what there is."""


class PointVariable(NamedTuple):
    """A variable that has a value, or an array of them, for every point."""

    dimensions: tuple[str, ...]  #: beside the swept keys
    kind: str  #: dtype
    units: str
    long_name: str


LINE, GROUP, SAMPLE, SECTION = "mode", "energy_group", "sample", "section"
_GROUPS, _SAMPLES, _SECTIONS = (GROUP,), (SAMPLE,), (SECTION,)

SECTIONS = 64
"""Points of a Poincaré map, and local maxima, kept of a march at most: the last ones."""

VARIABLES: Mapping[str, PointVariable] = {
    "regime": PointVariable((), "i1", "1", "regime of the motion, see `criterion`"),
    "end_reason": PointVariable((), "i1", "1", "why the march ended"),
    "end_time": PointVariable((), "f8", "s", "time of the last record"),
    "steps": PointVariable((), "i8", "1", "steps done"),
    "rotation_speed": PointVariable((), "f8", "rad/s", "speed of rotation"),
    "reference_frequency": PointVariable(
        (), "f8", "rad/s", "lowest frequency of the bladed disk with a free centre"
    ),
    "growth_rate": PointVariable(
        (),
        "f8",
        "1/s",
        "growth of the amplitude over the last third, or over the last windows of a march that"
        " ended early at its displacement limit; NaN: not to be judged",
    ),
    "growth_error": PointVariable((), "f8", "1/s", "one standard error of growth_rate"),
    "shaft_radius_max": PointVariable((), "f8", "m", "largest displacement of the shaft's centre"),
    "shaft_radius_final": PointVariable((), "f8", "m", "displacement of the centre at the end"),
    "strain_energy_max": PointVariable(
        (), "f8", "J", "largest strain energy of bladed disk and shaft springs"
    ),
    "contact_share": PointVariable(
        ("blade",), "f8", "1", "share of all steps with contact, of each blade"
    ),
    "smallest_clearance": PointVariable((), "f8", "m", "smallest clearance at rest"),
    "late_radius": PointVariable(
        (), "f8", "m", "displacement of the centre, root mean square over the last third"
    ),
    "whirl_rotating": PointVariable((), "i1", "1", "whirl over the last third, rotating frame"),
    "whirl_static": PointVariable((), "i1", "1", "whirl over the last third, static frame"),
    "whirl_frequency": PointVariable(
        (), "f8", "Hz", "of the whirl over the last third, rotating frame; forward is positive"
    ),
    "whirl_scatter": PointVariable(
        (), "f8", "Hz", "standard deviation of whirl_frequency over spans of the last third"
    ),
    "scenario": PointVariable((), "i1", "1", "contact scenario over the last third"),
    "shaft_lead": PointVariable(
        (), "f8", "rad", "angle of the shaft less that of contact, mean over the last third"
    ),
    "lead_steadiness": PointVariable(
        (), "f8", "1", "length of the mean direction of shaft_lead: 1 where it is constant"
    ),
    "late_contact_share": PointVariable(
        ("blade",), "f8", "1", "share of the steps of the last third with contact, of each blade"
    ),
    "section_x": PointVariable(
        _SECTIONS, "f4", "m", "x of the centre whenever blade 0 lies on +x, in the last third"
    ),
    "section_y": PointVariable(
        _SECTIONS, "f4", "m", "y of the centre whenever blade 0 lies on +x, in the last third"
    ),
    "radius_peak": PointVariable(
        _SECTIONS, "f4", "m", "local maxima of the displacement of the centre, in the last third"
    ),
    "gap_violation_max": PointVariable((), "f8", "m", "deepest penetration"),
    "energy_residual": PointVariable((), "f8", "1", "of the energy ledger, over its largest term"),
    "complementarity_residual": PointVariable(
        (), "f8", "1", "largest over the steps, over the gap's scale"
    ),
    "dt_over_critical": PointVariable((), "f8", "1", "time step over the critical one"),
    "window_start": PointVariable((), "f8", "s", "start of the window of spectrum and means"),
    "spectrum": PointVariable(
        ("frequency",),
        "f8",
        "m",
        "magnitude of the complex spectrum of x and y of the shaft's centre, rotating frame;"
        " Hann window, a circle of radius r has r; forward is positive",
    ),
    "mode_frequency": PointVariable(
        (LINE,), "f8", "Hz", "lowest frequency of modes that move with the shaft, own frame"
    ),
    "energy_mean": PointVariable(
        _GROUPS, "f8", "J", "strain energy of a group of rotor modes, mean over the window"
    ),
    "energy_max": PointVariable(
        _GROUPS, "f8", "J", "strain energy of a group of rotor modes, largest over the march"
    ),
    "history_time": PointVariable(_SAMPLES, "f8", "s", "time at which a sample's span begins"),
    "orbit_x": PointVariable(_SAMPLES, "f4", "m", "x of the centre at the start, rotating frame"),
    "orbit_y": PointVariable(_SAMPLES, "f4", "m", "y of the centre at the start, rotating frame"),
    "radius_history": PointVariable(_SAMPLES, "f4", "m", "largest displacement of the centre"),
    "energy_history": PointVariable(
        (SAMPLE, GROUP), "f4", "J", "strain energy of a group of rotor modes, mean over the span"
    ),
}
"""What a sweep holds of every point beside its state."""

MODE_LINES: Mapping[str, tuple[str, str | None]] = {
    "suspension": ("rotor", "suspension"),
    "1F k=1": ("rotor", "1F"),
    "2F k=1": ("rotor", "2F"),
    "casing k=1": ("casing", None),
}
"""Modes of one nodal diameter, which the shaft moves with: body, and family unless any will do."""


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Sizes of what is kept of each point, the same for all points of a sweep."""

    frequency: Array  #: of the spectra [Hz], whole multiples of 1 / window, (frequencies,)
    samples: int  #: of the decimated histories
    nodal_diameters: int  #: of the first blade family, 0 to this less one
    blades: int

    @property
    def window(self) -> float:
        """Time at the end of each march that spectra and mean energies are over [s]."""
        return float(1.0 / (self.frequency[1] - self.frequency[0]))

    @property
    def groups(self) -> tuple[str, ...]:
        """Groups of rotor modes that strain energies are given for."""
        return ("suspension", *(f"1F k={k}" for k in range(self.nodal_diameters)), "rest")

    @property
    def sizes(self) -> dict[str, int]:
        """Length of each dimension beside the swept keys."""
        return {
            "frequency": len(self.frequency),
            SAMPLE: self.samples,
            GROUP: len(self.groups),
            LINE: len(MODE_LINES),
            SECTION: SECTIONS,
            "blade": self.blades,
        }

    def shape(self, name: str) -> tuple[int, ...]:
        """Shape of a variable at one point."""
        return tuple(self.sizes[dimension] for dimension in VARIABLES[name].dimensions)

    @property
    def bytes_per_point(self) -> int:
        """What a point takes in the dataset [bytes]."""
        sizes = (
            np.dtype(variable.kind).itemsize * int(np.prod(self.shape(name), dtype=np.int64))
            for name, variable in VARIABLES.items()
        )
        return 1 + sum(sizes)


def flag(variable: str, meaning: str) -> int:
    """The number that stands for a name."""
    return FLAGS[variable].index(meaning)


class SweepError(UserError):
    """A path holds no sweep of bladewhirl."""


def open_sweep(path: str | Path) -> xr.Dataset:
    """Open the dataset of a sweep, or of the folder that holds it; arrays are read when used.

    Variables of `FLAGS` are text. What is read is not kept, so that going through the histories of
    many points takes the memory of one. Close it, or use ``with``.

    Raises:
        SweepError: nothing there, or not a sweep.
    """
    path = Path(path)
    file = path / SWEEP_NAME if path.is_dir() else path
    if not file.is_file():
        raise SweepError(f"{file}: expected a sweep (or its folder), found no such file")
    try:
        dataset = xr.open_dataset(file, engine="h5netcdf", decode_times=False, cache=False)
    except (OSError, ValueError, KeyError) as error:
        raise SweepError(f"{file}: expected a sweep, could not read it: {error}") from None
    if "over" not in dataset.attrs or "state" not in dataset:
        dataset.close()
        raise SweepError(f"{file}: expected a sweep of bladewhirl, it has no state of its points")
    named = {
        name: (dataset[name].dims, np.array(meanings)[dataset[name].values])
        for name, meanings in FLAGS.items()
        if name in dataset
    }
    opened = dataset.assign(named)
    opened.set_close(dataset.close)
    return opened


def swept(dataset: xr.Dataset) -> list[str]:
    """Dimensions of the swept keys, in order."""
    return [str(dimension) for dimension in dataset["state"].dims]


def point_slices(dataset: xr.Dataset, along: str) -> Sequence[dict[str, int]]:
    """Positions of all other swept keys: one line of points along a key for each."""
    others = [name for name in swept(dataset) if name != along]
    shape = [dataset.sizes[name] for name in others]
    return [dict(zip(others, map(int, index), strict=True)) for index in np.ndindex(*shape)]
