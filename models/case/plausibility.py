"""Values of a case that are allowed and yet hardly meant: numbers in another unit, mostly."""

from __future__ import annotations

from collections.abc import Iterator

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import Imbalance
from bladewhirl.models.inputs.errors import Fault

MODULI = (1e9, 1e12)
"""Young's moduli of what stages are made of [Pa]: from plastics to diamond."""

DENSITIES = (500.0, 25e3)
"""Densities of the same [kg/m3]: from wood to osmium."""

TIP_RADII = (0.01, 10.0)
"""Tip radii of bladed disks [m]: from model turbines to ship fans."""

CLEARANCES = (1e-6, 0.1)
"""Clearance over the tip radius: below it is rounding, beyond it a tip hardly finds the casing."""

MOST = {
    "contact.friction": (2.0, "dry friction of metals is below 1.5"),
    "damping.ratio": (0.5, "a mode of ratio 1 does not vibrate"),
}
"""Numbers without dimension that are hardly exceeded, and why."""

STIFFEST = 1e13
"""Stiffness of a spring that no part of a stage has [N/m]: a block of steel of 1 m has 2e11."""

WAYS = ("radial", "tangential")  #: of the springs under a casing

LONGEST = 100.0
"""Length of a strut over the tip radius that none has."""


def unusual_values(case: Case) -> Iterator[Fault]:
    """Values out of the range that machines have; each fault says what is expected instead."""
    yield from _materials(case)
    drawn = case.sketch is None and case.bladed_disk.mesh is None
    radius = case.tip_radius
    low, high = TIP_RADII
    if drawn and not low <= radius <= high:
        yield _fault("bladed_disk.tip_radius", radius, f"{low:g} to {high:g} m", "500 mm")
    sections = {"casing.wall": case.casing.wall}
    if drawn:
        sections |= {"bladed_disk.blade": case.bladed_disk.blade}
        sections |= {"bladed_disk.disk": case.bladed_disk.disk}
    struts = {f"casing.struts[{row}]": strut for row, strut in enumerate(case.casing.struts)}
    for key, section in (sections | struts).items():
        for name in ("width", "thickness"):
            size = getattr(section, name)
            if size > radius:
                expected = f"at most the tip radius, {radius:g} m"
                yield _fault(f"{key}.{name}", size, expected, "10 mm")
    for key, strut in struts.items():
        if strut.length > LONGEST * radius:
            expected = f"at most {LONGEST:g} tip radii, {LONGEST * radius:g} m"
            yield _fault(f"{key}.length", strut.length, expected, "300 mm")
    clearance, (least, most) = case.casing.clearance, CLEARANCES
    if 0.0 < clearance < least * radius:
        expected = f"0, or at least a millionth of the tip radius, {least * radius:g} m"
        yield _fault("casing.clearance", clearance, expected, "1 mm")
    if clearance > most * radius:
        expected = f"at most a tenth of the tip radius, {most * radius:g} m"
        yield _fault("casing.clearance", clearance, expected, "1 mm")
    yield from _beyond_reason(case)


def _beyond_reason(case: Case) -> Iterator[Fault]:
    """Friction, damping and springs that no stage has."""
    for key, (most, why) in MOST.items():
        table, name = key.split(".")
        value = getattr(getattr(case, table), name)
        if value > most:
            yield Fault(key=key, value=value, expected=f"at most {most:g} ({why})")
    springs = {
        "coupling.stiffness": case.coupling.stiffness,
        "contact.penalty_stiffness": case.contact.penalty_stiffness,
        "shaft.stiffness": case.shaft.stiffness,
    }
    for row, spring in enumerate(case.casing.springs):
        springs |= {f"casing.springs[{row}].{way}": getattr(spring, way) for way in WAYS}
    for key, stiffness in springs.items():
        if stiffness is not None and stiffness > STIFFEST:
            yield _fault(key, stiffness, f"at most {STIFFEST:g} N/m", "34 MN/m")


def case_hints(case: Case) -> tuple[str, ...]:
    """Values of a case that were perhaps not meant so, one line each."""
    unusual = (f"{fault.key} = {fault.value!r}: {fault.expected}" for fault in unusual_values(case))
    return (*(f"unusual {line}" for line in unusual), *_ramp(case))


def _ramp(case: Case) -> Iterator[str]:
    load, duration = case.excitation, case.march.duration
    if isinstance(load, Imbalance) and 0.0 < duration < load.ramp:
        yield (
            f"excitation.ramp = {load.ramp!r} s outlasts march.duration = {duration!r} s: the load"
            " never reaches its full size"
        )


def _materials(case: Case) -> Iterator[Fault]:
    named = {f"material.named[{row}]": material for row, material in enumerate(case.material.named)}
    for key, material in {"material": case.material, **named}.items():
        for name, (low, high), unit, example in (
            ("young_modulus", MODULI, "Pa", "210 GPa"),
            ("density", DENSITIES, "kg/m3", "7.8 g/cm3"),
        ):
            value = getattr(material, name)
            if not low <= value <= high:
                expected = f"{low:g} to {high:g} {unit} for a solid"
                yield _fault(f"{key}.{name}", value, expected, example)


def _fault(key: str, value: float, expected: str, example: str) -> Fault:
    return Fault(key=key, value=value, expected=f'{expected} (text carries its unit, "{example}")')
