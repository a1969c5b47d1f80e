"""Materials of bulk data of Nastran: MAT1 of the properties PSOLID."""

from collections.abc import Iterator, Mapping

from bladewhirl.meshes.files.abaqus_solids import Section
from bladewhirl.meshes.files.groups import MeshFileError, constant
from bladewhirl.meshes.files.nastran_entries import Entry

OTHER_MATERIALS = ("MAT2", "MAT9", "MAT10", "MAT11")

CONSISTENT = 1e-2
"""Largest difference of G from E / (2 (1 + NU)) in a MAT1 with all three, as a fraction."""

Cards = Mapping[str, list[Entry]]
"""All entries by their name; none for other names."""


class Material(Section):
    """Material of the elements of one property."""

    __slots__ = ()

    def missing(self, key: str) -> str:
        if self.unread:
            return f"material {self.material} of {self.group} is {self.unread}, which is not read"
        if not self.material:
            return f"{self.group} is not defined"
        field = {"density": "RHO", "young_modulus": "E", "poisson_ratio": "NU"}[key]
        return f"{self.group} has no MAT1 {self.material} with {field}"


def _isotropic(row: Entry) -> tuple[float | None, float | None, float | None]:
    """Return E, G and NU of a MAT1, of which the one that is blank follows from the others."""
    young, shear, ratio = (row.real(n) if row.text(n) else None for n in (1, 2, 3))
    if ratio is None and young and shear:
        ratio = young / (2.0 * shear) - 1.0
    if young is None and shear is not None and ratio is not None:
        young = 2.0 * (1.0 + ratio) * shear
    return young, shear, ratio


def is_consistent(row: Entry) -> bool:
    """Return whether G of a MAT1 that gives all three is E / (2 (1 + NU))."""
    young, shear, ratio = _isotropic(row)
    if young is None or ratio is None or shear is None:
        return True
    return abs(2.0 * (1.0 + ratio) * shear - young) <= CONSISTENT * abs(young)


def materials_of(cards: Cards, used: list[str]) -> Iterator[Material]:
    """Yield the material of each property of the elements.

    Args:
        cards: all entries by name.
        used: groups of the elements by property, such as ``PSOLID 1``.

    Raises:
        MeshFileError: a constant is not valid, or PARAM WTMASS is not positive.
    """
    properties = {f"PSOLID {row.whole(0)}": row.whole(1) for row in cards["PSOLID"]}
    isotropic = {row.whole(0): row for row in cards["MAT1"]}
    others = {row.whole(0): name for name in OTHER_MATERIALS for row in cards[name]}
    weights = [row for row in cards["PARAM"] if row.text(0) == "WTMASS"]
    weight = weights[0].real(1) if weights else 1.0
    if not weight > 0.0:
        raise MeshFileError(f"a positive PARAM,WTMASS, got {weight:g}")
    for name in used:
        number = properties.get(name, 0)
        row = isotropic.get(number, Entry("MAT1", [], 0))
        young, _, ratio = _isotropic(row)
        by_key = {"young_modulus": young, "poisson_ratio": ratio, "density": row.real(4, 0.0)}
        values = {
            key: constant(key, value, f" (MAT1 {number})")
            for key, value in by_key.items()
            if value is not None and (key != "density" or value)
        }
        if "density" in values:
            values["density"] *= weight
        yield Material(name, str(number or ""), values, others.get(number, ""))
