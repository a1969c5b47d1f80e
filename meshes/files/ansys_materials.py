"""Materials of .cdb files of Ansys: MP and MPDATA."""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator

from bladewhirl.meshes.files.abaqus_solids import Section
from bladewhirl.meshes.files.ansys_text import Command, real_in, whole_in
from bladewhirl.meshes.files.groups import constant

MATERIAL = "MAT"  #: start of the name of the group of the elements with a material

CONSTANTS = {
    "EX": "young_modulus",
    "NUXY": "poisson_ratio",
    "PRXY": "poisson_ratio",
    "DENS": "density",
}
DIRECTIONAL = ("EY", "EZ", "GXY", "GYZ", "GXZ", "NUYZ", "NUXZ", "PRYZ", "PRXZ")
"""Constants of orthotropic materials."""

ELASTIC = ("ELAS", "ANEL")
"""First four letters of tables of TB that replace the constants."""

PLASTIC = ("BISO", "MISO", "BKIN", "MKIN", "KINH", "NLIS", "PLAS", "CHAB", "CREE", "RATE", "EXPE")
"""First four letters of tables of TB that say nothing about small motions."""


class Material(Section):
    """Material of the elements with one number."""

    __slots__ = ()

    def missing(self, key: str) -> str:
        if self.unread:
            return f"material {self.material} {self.unread}"
        label = {"density": "DENS", "young_modulus": "EX", "poisson_ratio": "PRXY or NUXY"}[key]
        return f"material {self.material} of the file lacks {label}"


def materials_of(commands: list[Command], groups: Iterable[str]) -> Iterator[Material]:
    """Yield the materials of groups of elements, from MPDATA, MP and TB.

    Args:
        commands: commands of the file.
        groups: names of the groups, which end with the number of the material.

    Raises:
        MeshFileError: a constant is not a number, or not one of a solid.
    """
    values = defaultdict[str, dict[str, float]](dict)
    unread = dict[str, str]()
    for command, given, row, line in commands:
        if command == "TB" and given[1:] and given[0][:4] in ELASTIC:
            unread[given[1] or "1"] = f"has TB,{given[0]}, which is not read"
        if command not in ("MP", "MPDATA"):
            continue
        blocked = command == "MPDATA" and re.fullmatch(r"R\d.*", given[0] if given else "")
        label, material, *numbers = (*given[2 if blocked else 0 :], "", "")
        if command == "MPDATA":  # the place of the first number in the table of temperatures
            place, *numbers = (*numbers, "")
            numbers = numbers if whole_in(place or "1", line) == 1 else ["", *numbers]
        material = material or "1"  # the default of Ansys
        if label in DIRECTIONAL:
            unread[material] = f"has {label}, which is not read"
        elif label in CONSTANTS and any(numbers):
            if any(number and real_in(number, line) for number in numbers[1:]):
                unread[material] = f"has {label} for several temperatures, which is not read"
            elif numbers[0]:
                key, where = CONSTANTS[label], f" ({command},{label}, line {row + 1})"
                values[material][key] = constant(key, real_in(numbers[0], line), where)
    for group in groups:
        material = group.removeprefix(MATERIAL)
        isotropic = not unread.get(material)
        yield Material(
            group, material, values[material] if isotropic else {}, unread.get(material, "")
        )
