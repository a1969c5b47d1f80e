"""Growth of a motion, and of its ripple, by exponentials fitted to amplitudes in equal windows.

Growth must be distinguished from ripple, beating, noise, the onset of a load, and a motion that
approaches a limit cycle. The amplitude is the root of the strain energy of the bladed disk with its
shaft springs, averaged over equal windows: averaging smooths the ripple, and the strain energy also
exists with a clamped shaft. A small ripple that grows about a large steady displacement hardly
changes this amplitude, so the ripple, the motion about the mean position of each window, is
examined as well.
"""

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.fields.result import PORTION

CERTAINTY = 2.0  #: a growth rate is significant if it exceeds this many standard errors
#: growth slows if its rate in the second half of the fitted windows, plus `CERTAINTY` standard
#: errors, is below this fraction of the rate in the first half
STEADINESS = 0.75
#: growth is significant if the last amplitude is at least this many times the largest amplitude
#: before the last third
RISE = 1.1
MOST_WINDOWS, FEWEST_WINDOWS = 12, 8  #: largest and smallest number of windows in the last third
FEWEST_LAST = 5  #: smallest number of fitted windows after an early end at the displacement limit
#: smallest number of windows in each half of the fitted windows; halves of few windows overlap
FEWEST_IN_HALF = 3
WINDOW_RECORDS = 3  #: smallest number of records in a window
RIGID = 1e-6  #: a mode below this fraction of the highest frequency is regarded as a rigid mode
#: growth of the ripple is significant if its last amplitude is at least this many times its largest
#: amplitude in the middle third
RIPPLE_RISE = 1.5
#: a ripple below this fraction of the amplitude of the motion, in the last window, does not count
#: as growing
RIPPLE_SHARE = 0.01
ABOUT_MEAN = "motion about its mean position"  #: name of the ripple in texts for users
RIPPLE_PERIODS = 2.0  #: shortest window for a mean position [periods of the slowest wave]


@dataclass(frozen=True, kw_only=True)
class Windows:
    """Amplitude in equal windows of time; growth is fitted to the last windows."""

    begin: Array  #: start of each window [s], (window,)
    length: float  #: length of a window [s]
    amplitude: Array  #: root of the mean strain energy in each window [J^0.5], (window,)
    late: int  #: first window that growth is fitted to
    is_third: bool  #: true if the fitted windows are the last third of the time

    @property
    def span(self) -> str:
        """Time interval of the fit, in words."""
        begin, end = self.begin[self.late], self.begin[-1] + self.length
        return "the last third" if self.is_third else f"{begin:.3g} to {end:.3g} s"


@dataclass(frozen=True, kw_only=True)
class Growth:
    """Exponential growth of the amplitude over the last windows of a run."""

    rate: float  #: slope of the logarithm of the amplitude; negative in decay [1/s]
    error: float  #: standard error of `rate`, see `fit_growth` [1/s]
    #: true if the rate is clearly less in the second half of the fitted windows than in the first
    slows: bool
    #: last amplitude divided by the largest before the fitted windows; inf if no window is before
    rise: float
    residual: float  #: root mean square misfit of the logarithm of the amplitude: 0.1 is about 10 %
    end_rate: float  #: growth rate fitted to the last five windows only [1/s]
    end_error: float  #: standard error of `end_rate` [1/s]
    span: str  #: time interval of the fit, in words
    least_rise: float = RISE  #: smallest significant `rise`
    share: float = 1.0  #: amplitude of a ripple divided by that of the motion, in the last window

    @property
    def text(self) -> str:
        """Growth rate ± `CERTAINTY` standard errors, as text."""
        return rate_text(self.rate, self.error)

    @property
    def goes_on(self) -> bool:
        """True if growth is significant and not slowing."""
        grows = self.rate > CERTAINTY * self.error and not self.slows
        return grows and self.share >= RIPPLE_SHARE

    @property
    def is_significant(self) -> bool:
        """True if growth continues and the amplitude exceeds its earlier maximum."""
        return self.goes_on and self.rise >= self.least_rise

    @property
    def sentence(self) -> str:
        """Text with the growth rate, the rate at the end of the run, the misfit and the rise."""
        slowing = ", slowing" if self.slows else ""
        risen = f", amplitude at the end {self.rise:.3g} times the largest before"
        return (
            f"{self.text} 1/s ({CERTAINTY:g} standard errors) over {self.span}, at the end"
            f" {rate_text(self.end_rate, self.end_error)} 1/s, misfit of the exponential"
            f" {100 * np.expm1(self.residual):.2g} %{slowing}"
            f"{risen if np.isfinite(self.rise) else ''}"
        )


def windowed_amplitude(time: Array, strain_energy: Array, shortest_window: float) -> Windows | None:
    """Return the root of the mean strain energy in equal windows; None if growth cannot be judged.

    Growth cannot be judged if the stage is at rest, if the energy overflows, if the last third of
    the time has fewer than eight windows, or if some window has fewer than three records.

    Args:
        time: times of the records [s], (time,), ascending.
        strain_energy: strain energy at the records [J], (time,).
        shortest_window: shortest length of a window over which the ripple averages out [s].
    """
    third = (time[-1] - time[0]) / 3
    fitting = [third / shortest_window, len(time) / (3 * (WINDOW_RECORDS + 1)), MOST_WINDOWS]
    windows = int(min(fitting))
    if windows < FEWEST_WINDOWS:
        return None
    length = third / windows
    edges = time[0] + length * np.arange(3 * windows)
    return _averaged(time, strain_energy, edges, length, fitted=windows, is_third=True)


def growth_windows(dataset: xr.Dataset, strain_energy: Array) -> Windows | None:
    """Return windows of the motion, for the fit of growth; None if growth cannot be judged.

    Usually these are the windows of `windowed_amplitude`. A march that ended at its displacement
    limit is often too short for such windows, although its motion grows fast. Windows of the
    shortest length are then used, and growth is fitted to the last eight windows since the load
    ended, or to all windows since then if there are only five to seven. With fewer than five
    windows since the load ended, growth is fitted to the last five to eight windows of the run.

    `strain_energy` is the energy of bladed disk and shaft springs at each record [J], (time,).
    """
    time, shortest = dataset.variables["time"].values, longest_half_period(dataset)
    windows = windowed_amplitude(time, strain_energy, shortest)
    if windows is not None or dataset.attrs.get("end_reason") != "divergent" or len(time) < 2:
        return windows
    length = max(shortest, (WINDOW_RECORDS + 1) * float(np.median(np.diff(time))))
    available = int((time[-1] - time[0]) / length)
    working = np.flatnonzero(np.diff(dataset["external_work"].values))  # records with load
    load_end = time[working[-1] + 1] if len(working) else time[0]
    since_load = int((time[-1] - load_end) / length)
    fitted = min(since_load if since_load >= FEWEST_LAST else available, FEWEST_WINDOWS)
    if fitted < FEWEST_LAST:
        return None
    edges = time[-1] - length * np.arange(available, 0, -1)
    return _averaged(time, strain_energy, edges, length, fitted=fitted, is_third=False)


def ripple_windows(dataset: xr.Dataset, strain_energy: Array) -> Windows | None:
    """Return windows of the ripple, the motion about its mean position; None if there is none.

    The windows cover the last two thirds of the time; half of them lie in the last third. Each
    window is at least two periods of the slowest wave of the rotor long, so that a mean position
    can be computed. `strain_energy` is the same as for `growth_windows`.
    """
    time = dataset.variables["time"].values
    slower = np.abs(_wave_frequencies(dataset)).min(axis=0)
    shortest = 2 * RIPPLE_PERIODS * _half_period(slower)
    motion = windowed_amplitude(time, strain_energy, shortest)
    if motion is None:
        return None
    first = np.append(np.searchsorted(time, motion.begin - 1e-9 * motion.length), len(time))
    weights = 0.5 * dataset.variables["rotor_frequency"].values ** 2
    middle = motion.late // 2
    energy = np.empty(len(motion.begin) - middle)
    history = dataset.variables["rotor_displacement"]
    for number, (begin, end) in enumerate(zip(first[middle:-1], first[middle + 1 :], strict=True)):
        parts = (slice(at, min(at + PORTION, end)) for at in range(begin, end, PORTION))
        total = sum(history[part].values.sum(axis=0) for part in parts)
        mean = np.asarray(total) / (end - begin)
        energy[number] = motion.amplitude[middle + number] ** 2 - weights @ mean**2
    if not energy.min() > np.finfo(np.float64).eps * motion.amplitude.max() ** 2:
        return None  # the ripple is only rounding
    return replace(
        motion, begin=motion.begin[middle:], amplitude=np.sqrt(energy), late=motion.late - middle
    )


def fit_ripple(ripple: Windows, motion: Windows) -> Growth:
    """Fit the growth of the ripple from `ripple_windows`; `motion` are the windows of the total
    motion of the same run, from `growth_windows`."""
    share = ripple.amplitude[-1] / motion.amplitude[-1]
    return replace(fit_growth(ripple), least_rise=RIPPLE_RISE, share=float(share))


def fit_growth(windows: Windows) -> Growth:
    """Fit an exponential to the last windows of a history from `growth_windows`.

    The standard error is computed for a straight line fitted to the logarithms of the amplitudes.
    The misfits of neighbouring windows are not independent. If r is the correlation of a misfit
    with the next misfit, n windows count as n (1 - r) / (1 + r) independent windows, so the error
    is larger by sqrt((1 + r) / (1 - r)); a negative r is replaced by zero. This follows Santer et
    al., J. Geophys. Res. 105, 2000, without subtracting the degrees of freedom of the line. With so
    few windows r is usually underestimated: the fitted rate of an amplitude without trend exceeds
    two errors in 7 % of series of 12 independent windows, in 14 % of series of 5 independent
    windows, and in 20 % of series of 12 windows whose true correlation is 0.5. To judge slowing,
    the errors of the rates in both halves of the windows are not corrected, because half of the
    windows are too few to estimate r.
    """
    before, last = windows.amplitude[: windows.late], np.log(windows.amplitude[windows.late :])
    rate, error, factor = _fitted_slope(last, windows.length)
    end_rate, end_error, end_factor = _fitted_slope(last[-FEWEST_LAST:], windows.length)
    line = rate * windows.length * (np.arange(len(last)) - (len(last) - 1) / 2)
    half = max(len(last) // 2, FEWEST_IN_HALF)
    early, _, _ = _fitted_slope(last[:half], windows.length)
    late, late_error, _ = _fitted_slope(last[-half:], windows.length)
    return Growth(
        rate=rate,
        error=error * factor,
        slows=early > 0 and late + CERTAINTY * late_error < STEADINESS * early,
        rise=float(np.exp(last[-1]) / before.max()) if before.any() else float("inf"),
        residual=float(np.std(last - line)),
        end_rate=end_rate,
        end_error=end_error * end_factor,
        span=windows.span,
    )


def rate_text(rate: float, error: float) -> str:
    """Return a growth rate ± `CERTAINTY` standard errors [1/s] as text; a dash if the rate is not
    finite."""
    return f"{rate:.3g} ± {CERTAINTY * error:.2g}" if np.isfinite(rate) else "–"


def longest_half_period(dataset: xr.Dataset) -> float:
    """Return half a period of the lowest elastic rotor mode [s]; infinite if all modes are rigid.

    In half a period the strain energy of the mode rises and falls once. With Coriolis forces the
    strain energy of a pair of modes rises and falls in 2 pi divided by the sum of the frequencies
    of its two waves. Rigid modes have no strain energy and are ignored.
    """
    return _half_period(np.abs(np.mean(_wave_frequencies(dataset), axis=0)))


def _wave_frequencies(dataset: xr.Dataset) -> list[Array]:
    """Return the frequencies of the backward and forward wave of each rotor mode [rad/s]."""
    stage = dataset.variables
    return [stage[f"rotor_{way}_frequency"].values for way in ("backward", "forward")]


def _half_period(frequency: Array) -> float:
    """Return half a period of the lowest elastic frequency [s]; infinite if there is none."""
    elastic = frequency[frequency > RIGID * frequency.max()]
    return float(np.pi / elastic.min()) if len(elastic) else float("inf")


def _fitted_slope(values: Array, step: float) -> tuple[float, float, float]:
    """Fit a straight line to equally spaced values; return slope, standard error, and a factor.

    The standard error of the slope is computed as if the misfits were independent. Multiplied by
    the factor it is corrected for correlated misfits, see `fit_growth`.
    """
    position = step * (np.arange(len(values)) - (len(values) - 1) / 2)
    spread = position @ position
    slope = position @ values / spread
    misfit = values - values.mean() - slope * position
    square = float(misfit @ misfit)
    correlation = max(0.0, float(misfit[:-1] @ misfit[1:]) / square) if square > 0 else 0.0
    factor = np.sqrt((1 + correlation) / (1 - correlation))
    return float(slope), float(np.sqrt(square / (len(values) - 2) / spread)), float(factor)


def _averaged(
    time: Array, strain_energy: Array, edges: Array, length: float, *, fitted: int, is_third: bool
) -> Windows | None:
    """Return windows that begin at `edges`; the last window ends at the last record. Return None if
    some window has too few records, or a fitted window has no finite positive energy."""
    first = np.searchsorted(time, edges - 1e-9 * length)
    counts = np.diff(first, append=len(time))
    if counts.min() < WINDOW_RECORDS:
        return None
    mean = np.add.reduceat(strain_energy, first) / counts
    late = len(edges) - fitted
    if not (mean[late:].min() > 0 and np.isfinite(mean[late:]).all()):
        return None
    return Windows(
        begin=edges, length=length, amplitude=np.sqrt(mean), late=late, is_third=is_third
    )
