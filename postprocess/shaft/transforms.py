"""Complex spectra of the shaft's position x + i y, which separate forward and backward motion.

The transform of exp(i omega t) has one line at omega, which is positive for counter-clockwise
motion. A circular motion of radius r has the amplitude r at one frequency. A straight vibration of
amplitude a has the amplitude a / 2 at two frequencies of opposite sign.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.postprocess.fields.kinematics import Array, ViewError
from bladewhirl.postprocess.fields.windows import evenly_spaced

Frame = Literal["rotating", "static"]
Complex = NDArray[np.complex128]

FEWEST_RECORDS = 16  #: smallest number of records for a spectrum
MOST_LINES = 3  #: largest number of lines that are reported
LEAST_SHARE = 0.02  #: a weaker line, by its share of the total power, is not reported
KEPT_TRANSFORMS = 4  #: number of zoomed transforms that are kept; marches of equal length share one
LOBE = 2  #: half width of a line under the Hann window, in multiples of the resolution


@dataclass(frozen=True, kw_only=True)
class SpectralLine:
    """A line of the two-sided spectrum of an orbit."""

    frequency: float  #: [Hz], forward positive
    share: float  #: share of the mean square of the displacement


def phasor(orbit: xr.Dataset, frame: Frame) -> Complex:
    """Return x + i y of the shaft, or x - i y if the rotor turns clockwise, so that forward motion
    has positive frequencies."""
    x, y = orbit.variables[frame].values.T
    return np.asarray(x + (-1j if orbit.attrs["speed"] < 0 else 1j) * y)


def spectrum(
    motion: Complex, step: float, window: Array, *, padding: int = 1, frequency: Array | None = None
) -> tuple[Array, Complex]:
    """Return frequencies [Hz] and complex amplitudes of motions, whose last axis is time.

    Args:
        motion: equally spaced samples, (..., samples).
        step: time between samples [s].
        window: weights of the samples, (samples,); amplitudes are divided by their sum.
        padding: factor by which the motion is lengthened with zeros.
        frequency: equally spaced frequencies, ascending, within 1 / (2 step) of zero [Hz]; the
            frequencies of the padded transform when None.

    Returns:
        Ascending frequencies (frequencies,), and amplitudes in the unit of the motion, (...,
        frequencies).
    """
    weighted = motion * (window / window.sum())
    if frequency is None:
        length = padding * len(window)
        amplitude = np.fft.fftshift(np.fft.fft(weighted, length), axes=-1)
        return np.fft.fftshift(np.fft.fftfreq(length, step)), amplitude
    # The transform begins at zero: shift the lowest frequency to zero.
    weighted *= np.exp(-2j * np.pi * frequency[0] * step * np.arange(len(window)))
    width = float(frequency[-1] - frequency[0])
    return frequency, _zoomed(len(window), width, len(frequency), 1.0 / step)(weighted)


@lru_cache(maxsize=KEPT_TRANSFORMS)
def _zoomed(samples: int, width: float, lines: int, rate: float) -> Callable[[Complex], Complex]:
    """Return the transform of `samples` values, taken at a rate [Hz], to `lines` frequencies from
    zero to `width` [Hz]."""
    from scipy.signal import ZoomFFT  # slow to import, and needed by sweeps only

    return ZoomFFT(samples, [0.0, width], m=lines, fs=rate, endpoint=True)  # type: ignore[no-any-return]


def strongest_lines(orbit: xr.Dataset, frame: Frame) -> tuple[SpectralLine, ...]:
    """Return up to three of the strongest lines of the two-sided spectrum of an orbit from
    `orbits.shaft_orbit`; no lines for a short motion.

    The spectrum is computed with a Hann window. The power of a line is the power within the width
    of the line around a peak; its share in the total power is the share of the line, and its centre
    is the frequency of the line. The frequencies in the two frames differ by the speed, the shares
    are equal.
    """
    try:
        even, step = evenly_spaced(orbit, FEWEST_RECORDS)
    except ViewError:
        return ()
    motion = phasor(even, frame)
    # Positive frequencies come first, so that of two equal lines the forward line is the first.
    frequency, amplitude = map(np.fft.ifftshift, spectrum(motion, step, np.hanning(len(motion))))
    power = np.abs(amplitude) ** 2
    total = float(power.sum())
    lines: list[SpectralLine] = []
    while total > 0 and len(lines) < MOST_LINES:
        around = (int(power.argmax()) + np.arange(-LOBE, LOBE + 1)) % len(power)
        share = float(power[around].sum() / total)
        if share < LEAST_SHARE:
            break
        offset = np.arange(-LOBE, LOBE + 1) @ power[around] / power[around].sum()
        centre = frequency[around[LOBE]] + offset / (len(motion) * step)
        lines.append(SpectralLine(frequency=float(centre), share=share))
        power[around] = 0.0
    return tuple(lines)
