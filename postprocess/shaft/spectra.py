"""Spectrum and spectrogram of the shaft, with lines at the frequencies of modes.

The paper's Figs 15 and 17a are spectra of the displacement along x. The spectra of this module are
computed from x + i y and separate forward from backward motion, see `transforms`. Frequencies are
positive for forward motion, in the sense of rotation. The side lobes of the Blackman-Harris window
are below the smallest amplitude drawn.
"""

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.lib.stride_tricks import sliding_window_view

from bladewhirl.postprocess.energy.strain import FIRST_FAMILY, SUSPENSION
from bladewhirl.postprocess.fields.kinematics import Array, IntArray, ViewError
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.fields.rotation import speed_at
from bladewhirl.postprocess.fields.windows import evenly_spaced, window_label
from bladewhirl.postprocess.plotting.axes import draw_decades
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.shaft.orbits import MILLI, shaft_orbit
from bladewhirl.postprocess.shaft.transforms import FEWEST_RECORDS, Complex, Frame, phasor, spectrum

SHARE, PERIODS, MOST = 1.0 / 5.0, 5.0, 0.5
"""Length of a slice of the spectrogram: the longer of `SHARE` times the time window and `PERIODS`
periods of the reference frequency, but at most `MOST` times the time window."""

SLICES = 120  #: approximate number of slices of a spectrogram
PADDING, SLICE_PADDING = 4, 2
"""Factors by which the complete motion, and a slice of the spectrogram, are lengthened with zeros
before the transform, for smooth curves."""

COARSEST = 0.45  #: coarsest frequency resolution of a figure, divided by the reference frequency
DECADES = 4.0  #: number of decades that are drawn below the largest amplitude
MARGIN = 1.12  #: highest frequency drawn, divided by the highest frequency of a line of a mode
#: names of modes in the legend with their nodal diameter
WITH_K = {"1F": "1F, k = 1", "casing": "casing, k = 1"}
ORDER = "Ω"  #: label of the line of the speed
LINE_COLOURS: Mapping[str, str] = {
    FIRST_FAMILY: COLOURS["k = 1"],
    SUSPENSION: COLOURS["suspension"],
    "casing": COLOURS["casing"],
    ORDER: COLOURS["rest"],
}

LINE_DASHES: Mapping[str, Any] = {
    FIRST_FAMILY: (0, (3, 2)),
    SUSPENSION: (0, (8, 3)),
    "casing": (0, (6, 2, 1.2, 2)),
    ORDER: ":",
}
"""Styles of lines that can be distinguished without colour."""


def modal_lines(dataset: xr.Dataset, frame: Frame, times: Array | None = None) -> xr.DataArray:
    """Return the speed, and the frequencies of modes that can move the shaft [rad/s], in the frame
    of the observer.

    These modes have one nodal diameter: first family and suspension of the bladed disk, and the
    lowest mode of the casing, each as a forward and a backward wave, as far as the stage has
    families of modes and a flexible casing. The frequencies of a wave in
    the two frames differ by the speed. A further line, "Ω", is the frequency of a stationary load
    in the rotating frame, or of a load that turns with the rotor in the static frame.

    The modes of the rotor are those at the last speed; lines over `times` [s] leave them out.

    Returns:
        Frequencies (line,), or (line, time) at the speeds of the times, forward positive. The
        coordinate `mode` (line,) contains the names "1F", "suspension", "casing" and "Ω".
    """
    speed = np.asarray(dataset.attrs["speed"] if times is None else speed_at(dataset, times))
    speed, still = np.abs(speed), 0.0 * speed
    rotor_shift, casing_shift = (still, -speed) if frame == "rotating" else (speed, still)
    names, values = [ORDER], [rotor_shift + casing_shift]
    waves = [dataset[f"rotor_{way}_frequency"].values for way in ("backward", "forward")]
    family, diameter = dataset["rotor_family"].values, dataset["rotor_nodal_diameter"].values
    for name in (FIRST_FAMILY, SUSPENSION):
        modes = (family == name) & (diameter == 1)
        if modes.any() and times is None:
            backward, forward = (frequency[modes].min() for frequency in waves)
            names += [name] * 2
            values += [rotor_shift - backward, rotor_shift + forward]
    if has(dataset, "casing"):
        wall = dataset["casing_frequency"].values[dataset["casing_nodal_diameter"].values == 1]
        names += ["casing"] * 2
        values += [casing_shift - wall.min(), casing_shift + wall.min()]
    return xr.DataArray(
        np.array(values),
        dims=["line", "time"][: 1 + speed.ndim],
        coords={"mode": ("line", names)},
        attrs={"units": "rad/s"},
    )


def shaft_spectrum(
    result: xr.Dataset,
    frame: Frame = "rotating",
    *,
    start: float | None = None,
    end: float | None = None,
) -> xr.Dataset:
    """Compute the amplitude of the shaft against frequency, by a single transform of all records.

    Args:
        result: result of a run, or its orbit from `orbits.shaft_orbit`.
        frame: frame of the observer.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        Dataset of `amplitude` (frequency,) [m]; `frequency` [rad/s] is ascending, and positive for
        forward motion. The attribute `resolution` is the frequency resolution [rad/s].

    Raises:
        ViewError: there are too few records, or the records are not equally spaced.

    Example:
        ``shaft_spectrum(result, "static", start=2.0)["amplitude"].plot()``
    """
    even, step = evenly_spaced(shaft_orbit(result, start=start, end=end), FEWEST_RECORDS)
    records = even.sizes["time"]
    window = blackman_harris(records)
    frequency, amplitude = spectrum(phasor(even, frame), step, window, padding=PADDING)
    return labelled(
        even,
        "spectrum of the shaft",
        {"amplitude": ("frequency", np.abs(amplitude), "m")},
        {"frequency": 2 * np.pi * frequency},
        frame=frame,
        resolution=2 * np.pi / (records * step),
        window=window_label(even),
    )


def shaft_spectrogram(
    result: xr.Dataset,
    frame: Frame = "rotating",
    length: float | None = None,
    *,
    start: float | None = None,
    end: float | None = None,
) -> xr.Dataset:
    """Compute the amplitude of the shaft against frequency and time (the paper's Fig. 17a).

    Args:
        result: result of a run, or its orbit from `orbits.shaft_orbit`.
        frame: frame of the observer.
        length: length of a slice [s]. When None, the longer of a fifth of the time and five periods
            of the reference frequency, but not more than half of the time.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        Dataset of `amplitude` (frequency, time) [m]; `frequency` [rad/s] is ascending, and positive
        for forward motion; `time` [s] is the middle of each slice.

    Raises:
        ViewError: there are too few records, or the records are not equally spaced.
    """
    even, step = evenly_spaced(shaft_orbit(result, start=start, end=end), FEWEST_RECORDS)
    period = 2 * np.pi / even.attrs["reference_frequency"]
    frequency, amplitude, first, size = slices(phasor(even, frame), step, period, length)
    return labelled(
        even,
        "spectrogram of the shaft",
        {"amplitude": (("frequency", "time"), np.abs(amplitude).T, "m")},
        {"frequency": 2 * np.pi * frequency, "time": even["time"].values[first] + size * step / 2},
        frame=frame,
        resolution=2 * np.pi / (size * step),
        slice=size * step,
    )


def slices(
    motion: Complex, step: float, period: float, length: float | None = None
) -> tuple[Array, Complex, IntArray, int]:
    """Return the spectra of overlapping slices of a motion.

    Args:
        motion: equally spaced samples, (samples,).
        step: time between samples [s].
        period: period of the reference frequency [s].
        length: length of a slice [s]; by the rule of `shaft_spectrogram` when None.

    Returns:
        Ascending frequencies [Hz], (frequencies,); amplitudes in the unit of the motion, (slices,
        frequencies); the first sample of each slice, (slices,); the number of samples in a slice.
    """
    samples = len(motion)
    if length is None:
        length = min(max(SHARE * samples * step, PERIODS * period), MOST * samples * step)
    size = int(np.clip(round(length / step), FEWEST_RECORDS // 2, samples))
    first = np.arange(0, samples - size + 1, max((samples - size) // SLICES, 1))
    pieces = sliding_window_view(motion, size)[first]
    frequency, amplitude = spectrum(pieces, step, blackman_harris(size), padding=SLICE_PADDING)
    return frequency, amplitude, first, size


def with_lines(spectrum: xr.Dataset, lines: xr.DataArray) -> xr.Dataset:
    """Return the drawn frequency range of a spectrum or spectrogram, with the frequencies from
    `modal_lines` in the same frame added as the variable `modal_line` (line,).

    Raises:
        ViewError: the time window is too short: the resolution is coarser than `COARSEST`.
    """
    edge = MARGIN * float(np.abs(lines).max())
    resolution = spectrum.attrs["resolution"]
    needed = COARSEST * spectrum.attrs["reference_frequency"]
    if resolution > needed:
        raise ViewError(
            f"a window of {2e3 * np.pi / resolution:.3g} ms resolves only"
            f" {_hertz(resolution):.3g} Hz; a spectrum needs {_hertz(needed):.3g} Hz,"
            f" that is, a window of {2e3 * np.pi / needed:.3g} ms"
        )
    return spectrum.sel(frequency=slice(-edge, edge)).assign(modal_line=lines)


@styled
def plot_spectrum(spectrum: xr.Dataset) -> Figure:
    """Draw the amplitude of the shaft against frequency from `shaft_spectrum`, with lines at the
    frequencies of modes from `with_lines`."""
    figure = new_figure(height=0.06)
    axes = figure.add_subplot()
    amplitude = MILLI * spectrum["amplitude"].values
    top = amplitude.max() or 1.0  # 1 mm if nothing moves
    floor = top * 10**-DECADES
    axes.plot(
        _hertz(spectrum["frequency"].values),
        np.maximum(amplitude, floor),
        color=COLOURS["rotor"],
        linewidth=0.8,
    )
    axes.set_yscale("log")
    axes.set_ylim(max(floor, 0.5 * float(amplitude.min())), 2 * top)
    about = f"{spectrum.attrs['window']}, {_resolution(spectrum)}"
    axes.set(xlabel=f"frequency [Hz]   ← backward  forward →\n{about}", ylabel="amplitude [mm]")
    low, high = _hertz(spectrum["frequency"].values[[0, -1]])
    if low < high:
        axes.set_xlim(low, high)
    _draw_lines(axes, spectrum["modal_line"], axes.axvline)
    head(figure, spectrum, f"{spectrum.attrs['frame']} frame")
    figure.legend(loc="outside lower center", ncols=2, handlelength=2.6)
    return figure


@styled
def plot_spectrogram(spectrogram: xr.Dataset) -> Figure:
    """Draw the amplitude of the shaft against frequency and time from `shaft_spectrogram`, with
    lines at the frequencies of modes from `with_lines`."""
    figure = new_figure(height=0.07)
    axes = figure.add_subplot()
    amplitude = MILLI * spectrogram["amplitude"].values
    top = amplitude.max() or 1.0
    hertz, scale = _hertz(spectrogram["frequency"].values), (top, DECADES)
    draw_decades(axes, spectrogram["time"], hertz, amplitude, scale, label="amplitude [mm]")
    time_axis(axes)
    lines = spectrogram["modal_line"]
    draw: Any = partial(axes.axhline, xmin=0.0, xmax=0.15)
    if "time" in lines.dims:
        draw = partial(axes.plot, spectrogram["time"].values)
    _draw_lines(axes, lines, draw)
    axes.set_ylabel("frequency [Hz]\n← backward  forward →")
    about = f"slices of {1e3 * spectrogram.attrs['slice']:.3g} ms, {_resolution(spectrogram)}"
    axes.set_xlabel(f"{axes.get_xlabel()}\n{about}")
    head(figure, spectrogram, f"{spectrogram.attrs['frame']} frame")
    figure.legend(loc="outside lower center", ncols=2, handlelength=2.6)
    return figure


def _resolution(spectrum: xr.Dataset) -> str:
    return f"resolution {_hertz(spectrum.attrs['resolution']):.3g} Hz"


def _draw_lines(axes: Axes, lines: xr.DataArray, draw: Any) -> None:
    """Draw the lines of modes and speed; the two lines of a mode have one entry in the legend."""
    named: set[str] = set()
    for value, mode in zip(lines.values, lines["mode"].values, strict=True):
        name = (
            f"−{mode}"
            if mode == ORDER and np.all(value < 0.0)
            else WITH_K.get(str(mode), str(mode))
        )
        draw(
            _hertz(value),
            color=LINE_COLOURS[mode],
            linestyle=LINE_DASHES[mode],
            linewidth=1.6 if mode == ORDER else 0.9,
            label=f"_{name}" if mode in named else name,
        )
        named.add(str(mode))


def _hertz(frequency: Array | float) -> Array:
    return np.asarray(frequency) / (2 * np.pi)


def blackman_harris(records: int) -> Array:
    """Return the weights of the Blackman-Harris window, (records,)."""
    from scipy.signal.windows import blackmanharris  # slow to import

    return np.asarray(blackmanharris(records, sym=False))
