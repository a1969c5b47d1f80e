"""Plausible sizes of materials, and the units in which implausible values probably are."""

MATERIAL = {
    "young_modulus": (1e9, 1e12, "Pa for a solid"),
    "density": (500.0, 25e3, "kg/m3 for a solid"),
}
"""Smallest and largest plausible value of each quantity, and its unit with a remark."""

SLIPS = {
    "Pa": ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa, or MPa where GPa was meant")),
    "kg/m3": ((1e3, "g/cm3"), (1e12, "t/mm3"), (1e9, "kg/mm3"), (1e-3, "g/m3")),
    "m": ((1e-3, "mm"), (1e3, "m, where mm was written")),
}
"""Factors to SI units, and units that are mistaken for SI units, by SI unit."""


def fault_of(value: float, least: float, most: float, unit: str) -> str:
    """Return the plausible values, with the probable unit of the given one, as a text that
    completes "expected ..."; an empty text if the value is plausible.

    `unit` is the SI unit, which a remark may follow.
    """
    if least <= value <= most:
        return ""
    limits = f"at most {most:g}" if least == 0.0 else f"{least:g} to {most:g}"
    slips = SLIPS.get(unit.split(" ")[0].rstrip(","), ())
    likely = [name for factor, name in slips if max(least, 1e-9) <= value * factor <= most]
    return f"{limits} {unit}" + (f"; perhaps {value:g} is in {likely[0]}" if likely else "")
