"""Figures of a run by name, see `plotting.registry`, and their datasets."""

from functools import cached_property

import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.energy.strain import strain_energies
from bladewhirl.postprocess.fields.by_blade import blade_count
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.rotation import varies
from bladewhirl.postprocess.fields.windows import late_part, select_window, window_label
from bladewhirl.postprocess.plotting.figures import Figures
from bladewhirl.postprocess.plotting.registry import RUN_FIGURES
from bladewhirl.postprocess.run.blade_contact import contact_classes, contact_maps
from bladewhirl.postprocess.run.contact_side import contact_phase
from bladewhirl.postprocess.run.run_up import amplitude_over_speed, excited_critical_speeds
from bladewhirl.postprocess.run.sensor_figures import sensor_spectra
from bladewhirl.postprocess.run.sensors import sensors_of, signals
from bladewhirl.postprocess.run.stresses import stress_history
from bladewhirl.postprocess.run.waterfall import shaft_waterfall, tip_waterfall
from bladewhirl.postprocess.shaft import spectra
from bladewhirl.postprocess.shaft.crossings import critical_orbits
from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.shaft.transforms import Frame
from bladewhirl.postprocess.shaft.whirl_history import PERIODS, whirl_history

FEWEST_SPANS = 4  #: smallest number of time spans in the figure of the whirl over time
AT_REST = {"gaps"}  #: names of figures that are also available for a stage at rest


class RunFigures(Figures):
    """Figures of a run, or of a time window of a run, and their datasets.

    Spectrum, contact classes and contact scenario are computed for the time window or, without a
    window, for the last third of the run.

    Args:
        dataset: a result.
        start, end: limits of the time window [s]; start and end of the run when None.

    Raises:
        ViewError: the window ends before it starts, or has fewer than two records.
    """

    def __init__(
        self, dataset: xr.Dataset, start: float | None = None, end: float | None = None
    ) -> None:
        self.result = select_window(dataset, start, end)
        super().__init__(RUN_FIGURES, self.result)
        self._is_run = start is None and end is None

    def draw(self, name: str) -> tuple[Figure, xr.Dataset]:
        """Draw a figure, see `Figures.draw`; most figures need a motion."""
        if name in self.kinds and name not in AT_REST and not self.moves:
            raise ViewError(f"no motion in the time window from {window_label(self.result)}")
        return super().draw(name)

    @property
    def moves(self) -> bool:
        """True if the stage moves in the time window."""
        return bool(self.result["energy"].any())

    @cached_property
    def orbit(self) -> xr.Dataset:
        """Orbit of the shaft."""
        return shaft_orbit(self.result)

    @property
    def run_up(self) -> xr.Dataset:
        """Displacement of the shaft, or of the tips, and contact force over the speed."""
        return amplitude_over_speed(self.result, self._orbit_of_shaft)

    @property
    def waterfall(self) -> xr.Dataset:
        """Waterfall of the shaft, or of a tip, over the speed."""
        orbit, critical = self._orbit_of_shaft, excited_critical_speeds(self.result)
        data = tip_waterfall(self.result) if orbit is None else shaft_waterfall(orbit)
        return data.assign(critical_speed=("critical", critical, {"units": "rad/s"}))

    @property
    def _orbit_of_shaft(self) -> xr.Dataset | None:
        return self.orbit if has(self.result, "centre") else None

    @property
    def critical_orbits(self) -> xr.Dataset:
        """Orbits of the shaft at critical speeds."""
        return critical_orbits(self.result, self.orbit)

    @property
    def whirl(self) -> xr.Dataset:
        """Whirl over time."""
        whirls = whirl_history(self.orbit)
        if whirls.sizes["time"] < FEWEST_SPANS:
            raise ViewError(
                f"the whirl over time needs {FEWEST_SPANS} spans of {PERIODS:g} periods of ω₁;"
                f" a span is {1e3 * whirls.attrs['span']:.3g} ms"
            )
        return whirls

    def spectrum(self, frame: Frame) -> xr.Dataset:
        """Spectrum of the shaft in the last third or the time window, with frequencies of modes."""
        spectrum = spectra.shaft_spectrum(self._late(self.orbit), frame)
        return spectra.with_lines(spectrum, spectra.modal_lines(self.result, frame))

    def spectrogram(self, frame: Frame) -> xr.Dataset:
        """Spectrogram of the shaft, with frequencies of modes, or with lines that follow the
        speed."""
        spectrogram = spectra.shaft_spectrogram(self.orbit, frame)
        times = spectrogram["time"].values if varies(self.result) else None
        return spectra.with_lines(spectrogram, spectra.modal_lines(self.result, frame, times))

    @cached_property
    def energies(self) -> xr.Dataset:
        """Strain energy over time by groups of modes."""
        return strain_energies(self.result)

    @cached_property
    def stresses(self) -> xr.Dataset:
        """Stresses and strains of every member over time."""
        return stress_history(self.result)

    @cached_property
    def contact(self) -> xr.Dataset:
        """Gaps and contact forces of all blades over time."""
        return contact_maps(self.result)

    @property
    def classes(self) -> xr.Dataset:
        """Contact classes of the blades in the last third or the time window."""
        if blade_count(self.result) == 1:
            raise ViewError("contact classes compare blades, and there is one; see figure gaps")
        return contact_classes(self._late(self.with_contact))

    @property
    def phases(self) -> xr.Dataset:
        """Directions of shaft and contact, and the scenario in the last third or time window."""
        since = float(self._late(self.result)["time"][0])
        return contact_phase(self.with_contact, self.orbit, since=since)

    @cached_property
    def sensors(self) -> xr.Dataset:
        """Signals of the sensors of the case."""
        return signals(self.result, sensors_of(self.result))

    @property
    def sensor_spectra(self) -> xr.Dataset:
        """Amplitudes of the signals against frequency in the last third or the time window."""
        late = self._late(self.result)
        return sensor_spectra(signals(late, sensors_of(late)), self.result)

    def _late(self, dataset: xr.Dataset) -> xr.Dataset:
        return late_part(dataset) if self._is_run else dataset

    @property
    def known_stresses(self) -> xr.Dataset | None:
        """Stresses of every member over time; None if the stage has no stresses."""
        return self.stresses if "stress" in self.kinds else None

    @property
    def with_contact(self) -> xr.Dataset:
        """The result, if a blade tip touches the casing."""
        if not self.result["contact_steps"].isel(time=slice(1, None)).any():
            window = window_label(self.result)
            raise ViewError(f"no blade tip touches the casing in the time window from {window}")
        return self.result
