"""The kind of motion that a run ends in: divergent, no contact, damped or sustained.

Divergence is the delicate one. A run may reach the displacement limit; short of that, growth must
be told from ripple, from beating, from noise, from the onset of a load, and from a motion on its
way to a limit cycle. The amplitude is the root of the strain energy of the bladed disk with its
shaft springs, averaged over equal windows: that smooths ripple and works with a clamped shaft too.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.postprocess.fields.fields import Array

RegimeName = Literal["divergent", "no-contact", "damped", "sustained"]

CERTAINTY = 2.0  #: standard errors that a growth rate must be away from zero
STEADINESS = 0.75  #: least ratio of the growth rates in the second and first half of the third
RISE = 1.1  #: least ratio of the last amplitude to the largest before the last third
CLOSING = 0.01  #: least share of the clearance that a motion called divergent has taken up
MOST_WINDOWS, FEWEST_WINDOWS = 12, 8  #: windows in the last third
FEWEST_LAST = 5  #: windows that growth is fitted to where the march ended at its limit
FEWEST_IN_HALF = 3  #: windows of a half of them; the halves share some where there are so few
WINDOW_RECORDS = 3  #: fewest records in a window
RIGID = 1e-6  #: a mode below this share of the highest frequency is rigid to rounding

CRITERION = (
    "divergent: the march ended at its displacement limit, or over the last third of the time "
    "the amplitude (root of the mean strain energy of bladed disk and shaft springs in equal "
    f"windows) grows by more than {CERTAINTY:g} standard errors of the fitted rate (corrected for "
    "the correlation of neighbouring windows), without "
    f"slowing (rate of the second half, plus {CERTAINTY:g} standard errors, at least "
    f"{STEADINESS:g} of that of the first), ends at {RISE:g} times or more of any window before, "
    f"and takes up at least {CLOSING:.0%} of the clearance; "
    "no-contact: no tip ever touched; "
    "damped: no contact in the last tenth of the time; "
    "sustained: the rest; "
    "the first that applies"
)
"""The criterion in words, as it is written with every regime."""


@dataclass(frozen=True, kw_only=True)
class Windows:
    """The amplitude in equal windows of time, the last of them being those growth is fitted to."""

    begin: Array  #: of each window [s], (window,)
    length: float  #: of a window [s]
    amplitude: Array  #: root of the mean strain energy in it [J^0.5], (window,)
    late: int  #: first window that growth is fitted to
    is_third: bool  #: these are the last third of the time

    @property
    def span(self) -> str:
        """The time that growth is fitted over, in words."""
        begin, end = self.begin[self.late], self.begin[-1] + self.length
        return "the last third" if self.is_third else f"{begin:.3g} to {end:.3g} s"


@dataclass(frozen=True, kw_only=True)
class Growth:
    """Exponential growth of the amplitude over the last windows of a run."""

    rate: float  #: fitted to the logarithm of the amplitude; negative in decay [1/s]
    error: float  #: standard error of that rate, see `fit_growth` [1/s]
    slows: bool  #: the second half of these windows grows clearly less than the first
    rise: float  #: amplitude of the last window over the largest before; inf where none was
    span: str  #: the time that it is fitted over, in words

    @property
    def text(self) -> str:
        """The rate and `CERTAINTY` standard errors of it, in words."""
        return rate_text(self.rate, self.error)

    @property
    def is_significant(self) -> bool:
        """Whether it is more than its uncertainty and shows no sign of ending."""
        return self.rate > CERTAINTY * self.error and not self.slows and self.rise >= RISE


@dataclass(frozen=True, kw_only=True)
class Regime:
    """The regime of a run, and why."""

    name: RegimeName
    reason: str  #: what decided it, with numbers
    growth: Growth | None  #: None where the run is too short, or at rest
    criterion: str = CRITERION


def classify(dataset: xr.Dataset, strain_energy: Array) -> Regime:
    """Tell the regime of a run by `CRITERION`.

    Args:
        dataset: a result.
        strain_energy: of the bladed disk with its shaft springs at each record [J], (time,).
    """
    time = dataset["time"].values
    touched: NDArray[np.bool_] = np.any(dataset["contact_steps"].values > 0, axis=1)
    windows = growth_windows(dataset, strain_energy)
    growth = fit_growth(windows) if windows else None
    grown = _growth_text(growth)

    def regime(name: RegimeName, reason: str) -> Regime:
        return Regime(name=name, reason=reason, growth=growth)

    if dataset.attrs.get("end_reason") == "divergent":
        message = dataset.attrs.get("end_message") or "the march ended at its displacement limit"
        what = str(message).partition("; ")[0]  # the rest says what to do about it
        return regime("divergent", f"{what}; {grown}" if growth else what)
    if growth is not None and growth.is_significant and _has_closed(dataset, touched):
        return regime("divergent", grown)
    if not touched.any():
        return regime("no-contact", f"no tip touched; {grown}")
    last = float(time[touched][-1])
    if last <= time[0] + 0.9 * (time[-1] - time[0]):
        return regime("damped", f"last contact recorded at {last:.6g} s; {grown}")
    return regime("sustained", f"contact up to {last:.6g} s; {grown}")


def windowed_amplitude(time: Array, strain_energy: Array, shortest_window: float) -> Windows | None:
    """Root of the mean strain energy in equal windows; None where growth cannot be judged by it.

    That is a history at rest or beyond all numbers, one with fewer than eight windows in its last
    third, or one with fewer than three records in some window.

    Args:
        time: of the records [s], (time,), ascending.
        strain_energy: at the records [J], (time,).
        shortest_window: that averages the ripple away [s].
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
    """The windows that the growth of a run is fitted to; None where it cannot be judged.

    They are those of `windowed_amplitude`. A march that ended at its displacement limit is often
    too short for them, and grows fastest: there they are the last ones of the shortest length,
    eight, or those since the load ended if these are at least five and no more. Under a load that
    lasts, or too soon after it, they are eight, or at least five, wherever they begin.

    Args:
        dataset: a result.
        strain_energy: of the bladed disk with its shaft springs at each record [J], (time,).
    """
    time, shortest = dataset["time"].values, longest_half_period(dataset)
    found = windowed_amplitude(time, strain_energy, shortest)
    if found is not None or dataset.attrs.get("end_reason") != "divergent" or len(time) < 2:
        return found
    length = max(shortest, (WINDOW_RECORDS + 1) * float(np.median(np.diff(time))))
    room = int((time[-1] - time[0]) / length)
    since_load = int((time[-1] - load_end(dataset)) / length)
    fitted = min(since_load if since_load >= FEWEST_LAST else room, FEWEST_WINDOWS)
    if fitted < FEWEST_LAST:
        return None
    edges = time[-1] - length * np.arange(room, 0, -1)
    return _averaged(time, strain_energy, edges, length, fitted=fitted, is_third=False)


def fit_growth(windows: Windows) -> Growth:
    """Fit an exponential to the last windows of a history.

    The standard error is that of a straight line fitted to the logarithms of the amplitudes.
    Neighbouring windows don't miss the line independently: with the correlation r of a misfit
    with the next one, n windows count as n (1 - r) / (1 + r), so the error is larger by
    sqrt((1 + r) / (1 - r)); a negative r counts as none. That is after Santer et al., J. Geophys.
    Res. 105, 2000, without their loss of freedom by the line. Of so few windows r comes out too
    small rather than too large: an amplitude without trend is beyond two errors in 7 % of series
    of 12 independent windows, 14 % of 5, and in 20 % of 12 whose true correlation is 0.5. Of half
    of the windows r says nothing, so whether the growth slows is told by errors without it.

    Args:
        windows: of the history.
    """
    before, last = windows.amplitude[: windows.late], np.log(windows.amplitude[windows.late :])
    rate, error, factor = _fitted_slope(last, windows.length)
    half = max(len(last) // 2, FEWEST_IN_HALF)
    early, _, _ = _fitted_slope(last[:half], windows.length)
    late, late_error, _ = _fitted_slope(last[-half:], windows.length)
    return Growth(
        rate=rate,
        error=error * factor,
        slows=early > 0 and late + CERTAINTY * late_error < STEADINESS * early,
        rise=float(np.exp(last[-1]) / before.max()) if before.any() else float("inf"),
        span=windows.span,
    )


def rate_text(rate: float, error: float) -> str:
    """A growth rate and `CERTAINTY` standard errors of it, in words; a dash where there is none.

    Args:
        rate: [1/s]
        error: its standard error [1/s].
    """
    return f"{rate:.3g} ± {CERTAINTY * error:.2g}" if np.isfinite(rate) else "–"


def load_end(dataset: xr.Dataset) -> float:
    """Time from which on the load does no more work [s]; the first record where it does none."""
    time, work = dataset["time"].values, dataset["external_work"].values
    working = np.flatnonzero(np.diff(work))
    return float(time[working[-1] + 1] if len(working) else time[0])


def longest_half_period(dataset: xr.Dataset) -> float:
    """Half a period of the lowest rotor mode [s], in which a strain energy rises and falls.

    Rigid modes hold none and don't count; infinite where there are no others.
    """
    frequency = dataset["rotor_frequency"].values
    elastic = frequency[frequency > RIGID * frequency.max()]
    return float(np.pi / elastic.min()) if len(elastic) else float("inf")


def _fitted_slope(values: Array, step: float) -> tuple[float, float, float]:
    """Slope of a straight line through equally spaced values, and its standard error.

    The error takes the misfits of the values as independent; the third number is what it has to be
    multiplied by for their correlation, see `fit_growth`.
    """
    place = step * (np.arange(len(values)) - (len(values) - 1) / 2)
    spread = place @ place
    slope = place @ values / spread
    misfit = values - values.mean() - slope * place
    square = float(misfit @ misfit)
    correlation = max(0.0, float(misfit[:-1] @ misfit[1:]) / square) if square > 0 else 0.0
    factor = np.sqrt((1 + correlation) / (1 - correlation))
    return float(slope), float(np.sqrt(square / (len(values) - 2) / spread)), float(factor)


def _averaged(
    time: Array,
    strain_energy: Array,
    edges: Array,
    length: float,
    *,
    fitted: int,
    is_third: bool,
) -> Windows | None:
    """The windows that begin at `edges`, the last reaching to the end."""
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


def _has_closed(dataset: xr.Dataset, touched: NDArray[np.bool_]) -> bool:
    """Whether a tip has come nearer to the casing by a share of the clearance that matters."""
    clearance = float(dataset["clearance"].min())
    return bool(touched.any()) or float(dataset["gap"].min()) <= (1 - CLOSING) * clearance


def _growth_text(growth: Growth | None) -> str:
    if growth is None:
        return "whether the motion grows can't be judged: at rest, or too few records or periods"
    slowing = ", slowing" if growth.slows else ""
    risen = f", its last window {growth.rise:.3g} times the largest before"
    return (
        f"growth rate of the amplitude {growth.text} 1/s ({CERTAINTY:g} standard errors) over "
        f"{growth.span}{slowing}{risen if np.isfinite(growth.rise) else ''}"
    )
