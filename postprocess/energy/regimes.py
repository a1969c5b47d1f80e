"""Regime of a run: divergent, no contact, damped or sustained.

A divergent run reaches the displacement limit, or its motion or ripple grows significantly, see
`growth_rates`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bladewhirl.postprocess.energy.growth_rates import (
    ABOUT_MEAN,
    CERTAINTY,
    RIPPLE_RISE,
    RIPPLE_SHARE,
    RISE,
    STEADINESS,
    Growth,
    fit_growth,
    fit_ripple,
    growth_windows,
    ripple_windows,
)
from bladewhirl.postprocess.energy.works import leading_source
from bladewhirl.postprocess.fields.kinematics import Array, smallest_clearance

RegimeName = Literal["divergent", "no-contact", "damped", "sustained"]

#: growth without contact is divergent if a tip closes at least this fraction of its clearance
CLOSING = 0.01

#: a ripple above this fraction of the amplitude is not described separately: it is the whole motion
MOST_RIPPLE = 0.9

#: remark on a sustained motion whose amplitude, or motion about its mean position, grows
GROWS_SO_FAR = "the {} grows, but ends below {:g} times its earlier value: extend the march"
CRITERION: Mapping[RegimeName, str] = {
    "divergent": "the march ended at its displacement limit, or over the last third of the time "
    "the amplitude (root of the mean strain energy of bladed disk and shaft springs in equal "
    f"windows) grows by more than {CERTAINTY:g} standard errors of the fitted rate (corrected for "
    "the correlation of neighbouring windows), without "
    f"slowing (rate of the second half, plus {CERTAINTY:g} standard errors, at least "
    f"{STEADINESS:g} times the rate of the first), ends at {RISE:g} times the amplitude of any "
    f"earlier window or more, and the motion takes up at least {CLOSING:.0%} of the clearance; or "
    f"the {ABOUT_MEAN} (the mean of each window of at least two periods) grows in the same way, to "
    f"at least {RIPPLE_RISE:g} times its value in the middle third and at least {RIPPLE_SHARE:.0%} "
    "of the amplitude",
    "no-contact": "no tip ever touched",
    "damped": "no contact in the last tenth of the time",
    "sustained": "every other run",
}
"""Criteria of the regimes; the first that applies is the regime."""

CRITERION_TEXT = "; ".join(
    [*(f"{name}: {rule}" for name, rule in CRITERION.items()), "the first that applies is taken"]
)


@dataclass(frozen=True, kw_only=True)
class Regime:
    """Regime of a run, with its reason."""

    name: RegimeName
    reason: str  #: reason for the regime, with numbers
    growth: Growth | None  #: growth of the amplitude; None if the run is too short, or at rest
    #: growth of the motion about its mean position; None if it cannot be separated
    ripple: Growth | None


def classify(dataset: xr.Dataset, strain_energy: Array) -> Regime:
    """Classify a run by `CRITERION`; `strain_energy` is the energy of bladed disk and shaft springs
    at each record [J], (time,)."""
    windows = growth_windows(dataset, strain_energy)
    around = ripple_windows(dataset, strain_energy) if windows and windows.is_third else None
    source, clearance = leading_source(dataset), smallest_clearance(dataset)
    time = dataset.variables["time"].values
    touched: NDArray[np.bool_] = np.any(dataset.variables["contact_steps"].values > 0, axis=1)
    growth = fit_growth(windows) if windows else None
    ripple = fit_ripple(around, windows) if around and windows else None
    grown = _growth_text(growth, ripple)

    def regime(name: RegimeName, reason: str) -> Regime:
        reasons = [reason] if name == "no-contact" else [reason, source]
        text = "; ".join(filter(None, reasons))
        return Regime(name=name, reason=text, growth=growth, ripple=ripple)

    if dataset.attrs.get("end_reason") == "divergent":
        message = dataset.attrs.get("end_message") or "the march ended at its displacement limit"
        what = str(message).partition("; ")[0]  # the rest says what to do about it
        return regime("divergent", f"{what}; {grown}" if growth else what)
    grows = any(one is not None and one.is_significant for one in (growth, ripple))
    if grows and (touched.any() or float(dataset["gap"].min()) <= (1 - CLOSING) * clearance):
        return regime("divergent", grown)
    if not touched.any():
        return regime("no-contact", "; ".join(["no tip touched", *([grown] if grows else [])]))
    last = float(time[touched][-1])
    if last <= time[0] + 0.9 * (time[-1] - time[0]):
        return regime("damped", f"last contact recorded at {last:.6g} s; {grown}")
    so_far = [
        GROWS_SO_FAR.format(what, one.least_rise)
        for what, one in (("amplitude", growth), (ABOUT_MEAN, ripple))
        if one is not None and one.goes_on
    ]
    return regime("sustained", "; ".join([f"contact up to {last:.6g} s", *so_far, grown]))


def regime_title(name: RegimeName, *, judged: bool) -> str:
    """Return a regime for people: contact in a run that is too short to judge growth is not yet
    sustained."""
    return "contact up to the end" if name == "sustained" and not judged else name


def _growth_text(growth: Growth | None, ripple: Growth | None) -> str:
    if growth is None:
        return "growth cannot be judged: at rest, or too few records or periods"
    whole = f"growth rate of the amplitude {growth.sentence}"
    if ripple is None or ripple.share > MOST_RIPPLE:
        return whole
    size = f"{ripple.share:.2g} of the amplitude"
    part = f"growth rate of the {ABOUT_MEAN}, {size}, {ripple.sentence}"
    return f"{part}; {whole}" if ripple.is_significant else f"{whole}; {part}"
