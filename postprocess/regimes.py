"""What kind of motion a run ends in: divergent, no contact, damped or sustained.

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

from bladewhirl.postprocess.fields import Array

RegimeName = Literal["divergent", "no-contact", "damped", "sustained"]

CERTAINTY = 2.0  #: standard errors that a growth rate must be away from zero
STEADINESS = 0.75  #: least ratio of the growth rates in the second and first half of the third
RISE = 1.1  #: least ratio of the last amplitude to the largest before the last third
CLOSING = 0.01  #: least share of the clearance that a motion called divergent has taken up
MOST_WINDOWS, FEWEST_WINDOWS = 12, 8  #: windows in the last third
WINDOW_RECORDS = 3  #: fewest records in a window
RIGID = 1e-6  #: a mode below this share of the highest frequency is rigid to rounding

CRITERION = (
    "divergent: the march ended at its displacement limit, or over the last third of the time "
    "the amplitude (root of the mean strain energy of bladed disk and shaft springs in equal "
    f"windows) grows by more than {CERTAINTY:g} standard errors of the fitted rate, without "
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
    """The amplitude in equal windows of time, three thirds with as many windows each."""

    begin: Array  #: of each window [s], (window,)
    length: float  #: of a window [s]
    amplitude: Array  #: root of the mean strain energy in it [J^0.5], (window,)
    late: int  #: first window of the last third


@dataclass(frozen=True, kw_only=True)
class Growth:
    """Exponential growth of the amplitude over the last third of a run."""

    rate: float  #: fitted to the logarithm of the amplitude; negative in decay [1/s]
    error: float  #: standard error of that rate [1/s]
    slows: bool  #: the second half of the third grows clearly less than the first
    rise: float  #: amplitude of the last window over the largest before the last third

    @property
    def is_significant(self) -> bool:
        """Whether it is growth beyond doubt that shows no sign of ending."""
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
    growth = measure_growth(time, strain_energy, longest_half_period(dataset))
    grown = _growth_text(growth)

    def regime(name: RegimeName, reason: str) -> Regime:
        return Regime(name=name, reason=reason, growth=growth)

    if dataset.attrs.get("end_reason") == "divergent":
        message = dataset.attrs.get("end_message") or "the march ended at its displacement limit"
        return regime("divergent", str(message))
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

    That is a history at rest, one with fewer than eight windows in its last third, or one with
    fewer than three records in some window.

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
    first = np.searchsorted(time, edges - 1e-9 * length)
    counts = np.diff(first, append=len(time))
    if counts.min() < WINDOW_RECORDS:
        return None
    mean = np.add.reduceat(strain_energy, first) / counts
    if mean[2 * windows :].min() <= 0:
        return None
    return Windows(begin=edges, length=length, amplitude=np.sqrt(mean), late=2 * windows)


def measure_growth(time: Array, strain_energy: Array, shortest_window: float) -> Growth | None:
    """Fit the growth over the last third of a history; None where it cannot be judged.

    Args:
        time: as `windowed_amplitude` takes it, and so the others.
        strain_energy: see there.
        shortest_window: see there.
    """
    found = windowed_amplitude(time, strain_energy, shortest_window)
    if found is None:
        return None
    before, last = found.amplitude[: found.late], np.log(found.amplitude[found.late :])
    rate, error = _fitted_slope(last, found.length)
    half = len(last) // 2
    early, _ = _fitted_slope(last[:half], found.length)
    late, late_error = _fitted_slope(last[-half:], found.length)
    return Growth(
        rate=rate,
        error=error,
        slows=early > 0 and late + CERTAINTY * late_error < STEADINESS * early,
        rise=float(np.exp(last[-1]) / before.max()) if before.any() else float("inf"),
    )


def longest_half_period(dataset: xr.Dataset) -> float:
    """Half a period of the lowest rotor mode [s], in which a strain energy rises and falls.

    Rigid modes hold none and don't count; infinite where there are no others.
    """
    frequency = dataset["rotor_frequency"].values
    elastic = frequency[frequency > RIGID * frequency.max()]
    return float(np.pi / elastic.min()) if len(elastic) else float("inf")


def _fitted_slope(values: Array, step: float) -> tuple[float, float]:
    """Slope of a straight line through equally spaced values, and its standard error."""
    place = step * (np.arange(len(values)) - (len(values) - 1) / 2)
    spread = place @ place
    slope = place @ values / spread
    misfit = values - values.mean() - slope * place
    return float(slope), float(np.sqrt(misfit @ misfit / (len(values) - 2) / spread))


def _has_closed(dataset: xr.Dataset, touched: NDArray[np.bool_]) -> bool:
    """Whether a tip has come nearer to the casing by a share of the clearance that matters."""
    clearance = float(dataset["clearance"].min())
    return bool(touched.any()) or float(dataset["gap"].min()) <= (1 - CLOSING) * clearance


def _growth_text(growth: Growth | None) -> str:
    if growth is None:
        return "whether the motion grows can't be judged: at rest, or too few records or periods"
    slowing = ", slowing" if growth.slows else ""
    return (
        f"growth rate of the amplitude {growth.rate:.3g} ± {growth.error:.2g} 1/s over the last "
        f"third{slowing}, its last window {growth.rise:.3g} times the largest before"
    )
