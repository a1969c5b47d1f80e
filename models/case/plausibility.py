"""Warnings about valid but implausible input, usually a wrong unit."""

import math
from collections.abc import Iterator

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import Harmonic, Imbalance
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.inputs.plausible import MATERIAL, fault_of

Bound = tuple[str, float, float, float, str]
"""Key, value, smallest and largest plausible value, and unit with a remark for the warning."""

STIFFEST = 1e13
"""Largest plausible stiffness of a spring [N/m]; a cube of steel of 1 m has 2e11 N/m."""

MOST_UNBALANCE = 1e3  #: largest plausible unbalance [kg m]

IN_TIP_RADII = {"width": 1.0, "thickness": 1.0, "length": 100.0}
"""Largest plausible dimensions of a beam, divided by the tip radius."""

FEWEST_STEPS = 10  #: plausible smallest number of time steps in a period of a force

SAME_SPEED = 1e-3
"""Largest difference between the speed of a stiffness and that of the case, divided by the latter,
that is not mentioned."""

RPM = math.pi / 30.0  #: [rad/s]

CLEARANCES = (1e-6, 0.1)
"""Smallest and largest plausible clearance, divided by the tip radius; zero is also allowed."""


def _bounds(case: Case) -> Iterator[Bound]:
    beams: dict[str, object] = {"casing.wall": case.casing.wall}
    radius = case.tip_radius
    if case.sketch is None and case.bladed_disk.mesh is None:
        yield "bladed_disk.tip_radius", radius, 0.01, 10.0, "m"
        beams["bladed_disk.blade"] = case.bladed_disk.blade
        beams["bladed_disk.disk"] = case.bladed_disk.disk
    beams |= {f"casing.struts[{row}]": strut for row, strut in enumerate(case.casing.struts)}
    for key, beam in beams.items():
        for name, factor in IN_TIP_RADII.items():
            if (size := getattr(beam, name, None)) is not None:
                yield f"{key}.{name}", size, 0.0, factor * radius, "m for this tip radius"
    if case.casing.clearance > 0.0:
        least, most = (share * radius for share in CLEARANCES)
        yield "casing.clearance", case.casing.clearance, least, most, "m, or 0, for this tip radius"
    springs = {
        "coupling.stiffness": case.coupling.stiffness,
        "shaft.stiffness": case.shaft.stiffness,
    }
    for row, spring in enumerate(case.casing.springs):
        springs[f"casing.springs[{row}].radial"] = spring.radial
        springs[f"casing.springs[{row}].tangential"] = spring.tangential
    for key, stiffness in springs.items():
        yield key, stiffness or 0.0, 0.0, STIFFEST, "N/m"
    for key, load in case.excitations.items():
        yield (
            f"{key}.unbalance",
            getattr(load, "unbalance", None) or 0.0,
            0.0,
            MOST_UNBALANCE,
            "kg m",
        )
    yield "contact.friction", case.contact.friction, 0.0, 2.0, "for dry metals"
    yield "damping.ratio", case.damping.ratio, 0.0, 0.5, "for modes that vibrate"


def unusual_values(case: Case) -> Iterator[Fault]:
    """Yield a fault for each value outside the range of real machines, materials first."""
    materials: dict[str, object] = {"material": case.material}
    materials |= {f"material.named[{row}]": named for row, named in enumerate(case.material.named)}
    arcs = enumerate(case.casing.stiffened_arcs)
    materials |= {f"casing.stiffened_arcs[{row}]": arc for row, arc in arcs}
    bounds = (
        (f"{key}.{name}", value, *limits)
        for key, material in materials.items()
        for name, limits in MATERIAL.items()
        if (value := getattr(material, name)) is not None
    )
    for key, value, least, most, unit in (*bounds, *_bounds(case)):
        if expected := fault_of(value, least, most, unit):
            yield Fault(key=key, value=value, expected=expected)


def probable_cause(case: Case) -> str:
    """Return the first implausible value of a case as the end of a message; empty if there is
    none."""
    fault = next(unusual_values(case), None)
    return "" if fault is None else f"; the cause may be {fault}"


def case_hints(case: Case) -> tuple[str, ...]:
    """Return warnings for a case, one line each."""
    hints = [
        f"unusual {fault.key} = {fault.value!r}: expected {fault.expected};"
        ' a value may be text with a unit, such as "10 mm"'
        for fault in unusual_values(case)
    ]
    duration = 0.0 if case.march.revolutions else case.march.duration
    for key, load in case.excitations.items():
        if isinstance(load, Imbalance) and 0.0 < duration < load.ramp < math.inf:
            hints.append(
                f"{key}.ramp = {load.ramp!r} s exceeds march.duration = {duration!r} s: the load"
                " does not reach its full size"
            )
        if isinstance(load, Harmonic) and not case.march.steps_per_revolution:
            steps = 1.0 / (load.frequency * case.march.time_step)
            if steps < FEWEST_STEPS:
                hints.append(
                    f"{key}.frequency = {load.frequency!r} Hz: a period has {steps:.2g} time steps"
                    f" of {case.march.time_step!r} s, which do not describe the force"
                )
    run_up = case.march.run_up
    if run_up is not None and 0.0 < duration <= run_up.start:
        hints.append(
            f"march.run_up.start = {run_up.start!r} s: the change of the speed begins after the end"
            f" of the march, march.duration = {duration!r} s"
        )
    return (*hints, *stiffness_hints(case))


def linear_hints(case: Case) -> Iterator[str]:
    """Yield warnings about modes: joints do not act, or those of the stiffness."""
    if case.joint:
        yield (
            "joints act in marches, in bladewhirl periodic and, as joints that are free, closed"
            " without friction or stuck, in bladewhirl response: modes are those of blades without"
            " joints"
        )
    yield from stiffness_hints(case)


def stiffness_hints(case: Case) -> Iterator[str]:
    """Yield a warning if the stiffness of a superelement is not that at the speed of the case."""
    table, speed = case.bladed_disk.superelement, case.march.speed
    if table is None or case.effects != "none" or not speed.value:
        return
    own = table.part.speed
    if table.part.stiffness_speed is not None:
        yield (
            "the matrix stiffness_speed of the superelement is not used with"
            ' rotation.effects = "none": the stiffness is that at rest at every speed'
        )
    elif own is not None and not (own and speed.kind == "normalised"):
        ratio = abs(own / speed.value)
        if abs(ratio - 1.0) > SAME_SPEED:
            at = f"at {abs(own) / RPM:.6g} rpm, {ratio:.3g} times this speed" if own else "at rest"
            yield (
                f"march.speed = {speed}: the stiffness of the superelement is that {at}; a file"
                " with stiffness_speed has the stiffness at every speed"
            )


def speed_hint(case: Case, speed: float) -> str:
    """Return which speed [rad/s] studies at one speed use if the speed of a case varies; an empty
    text at a constant speed."""
    march = case.march
    if not march.varies:
        return ""
    key = "speed_table" if march.speed_table is not None else "run_up"
    which = f"the fastest speed of march.{key}"
    if march.drive is not None:
        which = "march.speed, at which the free speed starts"
    rpm = speed / RPM
    return f"the speed varies; values at one speed are those at {rpm:.6g} rpm, {which}"
