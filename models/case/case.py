"""The case: the immutable contents of a case file, in SI units.

Make a case by keyword, ``Case(march=March(speed=1.2))``, or read one with `read_case`. Defaults are
values of the paper, or choices where the paper gives no value; the description of each key states
its source. Numbers are in SI units; text includes a unit, "1 mm". New kinds of geometry are added
as optional tables.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from bladewhirl.models.case.casing import OF_ANGLES
from bladewhirl.models.case.check import UNKNOWN_KEY, faults_of
from bladewhirl.models.case.joint_faults import joint_faults, ring_faults
from bladewhirl.models.case.sensors import sensor_faults
from bladewhirl.models.case.shaft_line import beside_line
from bladewhirl.models.case.superelement import SOURCE
from bladewhirl.models.case.tables import Tables
from bladewhirl.models.inputs.errors import CaseError, Fault, shown
from bladewhirl.models.inputs.rules import Inconsistency, broken
from bladewhirl.models.inputs.table import path_of, value_at
from bladewhirl.models.structure.rotating import Effects


class Case(Tables):
    """A bladed disk on its shaft, a casing, a load and a speed; by default the paper's fan stage.

    Raises:
        CaseError: the case is invalid; the error lists all faults, as for a case file. The classes
            of the other tables, such as ``Shaft(stiffness=...)``, raise pydantic's
            ``ValidationError``.
    """

    if not TYPE_CHECKING:  # type checkers see the keys

        def __init__(self, **tables: Any) -> None:
            if faults := _unknown_keys(tables):
                raise CaseError(faults)
            try:
                super().__init__(**tables)
            except ValidationError as error:
                raise CaseError(faults_of(error, tables)) from None

    def __repr__(self) -> str:
        """Return the title, and a line for each table with the keys that differ from defaults."""
        changed = self.model_dump(exclude_defaults=True, exclude_none=True)
        rows = [f"{name:<13}{shown(table)}" for name, table in changed.items() if name != "title"]
        return "\n  ".join([f'Case "{self.title}", other keys at their defaults', *rows])

    def __str__(self) -> str:
        """Return the text of `__repr__`."""
        return repr(self)

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield contradictions between values of different tables."""
        for key, load in self.excitations.items():
            for fault in broken("Excitation", load, self):
                yield fault._replace(key=f"{key}.{fault.key}")
        yield from super().inconsistencies()
        yield from sensor_faults(self.sensor, self.blades)
        if self.superelement is None:
            yield from broken("Case of beams", self)
            if self.joint and self.sketch is None and self.bladed_disk.shrouds:
                yield from ring_faults(self.joint, self.bladed_disk)
                yield from broken("Case of beams with joints", self)
        else:
            yield from joint_faults(self.joint, self.superelement)
            yield from broken("Case of a superelement", self.superelement, self)

    @property
    def has_wheel(self) -> bool:
        """Whether the case has a table with the wheel of a shaft line."""
        return not self.model_fields_set.isdisjoint({"bladed_disk", "sketch"})

    @property
    def effects(self) -> Effects:
        """Effects of the rotation on the bladed disk; on a shaft line, where it tilts, all."""
        return self.rotation.effects if self.shaft_line is None else "full"

    @property
    def without_effect(self) -> list[str]:
        """Tables and keys that have no effect beside a shaft line."""
        return beside_line(self)

    @property
    def beside_walls(self) -> list[str]:
        """Keys that further wheels of a shaft line with walls of their own do not allow."""
        walls = {} if self.shaft_line is None else self.shaft_line.walls
        if not walls:
            return []
        turned = [key for key, wheel in walls.items() if wheel.superelement.angle]
        return [
            *(f"casing.{name}" for name in OF_ANGLES if getattr(self.casing, name)),
            *(f"shaft_line.{key.removesuffix('casing')}superelement.angle" for key in turned),
        ]

    @property
    def unlike_walls(self) -> list[str]:
        """Keys of the types of further walls that differ from that of the first."""
        walls = {} if self.shaft_line is None else self.shaft_line.walls
        kinds = {key: row.casing.type for key, row in walls.items() if row.casing is not None}
        return [f"shaft_line.{key}.type" for key, kind in kinds.items() if kind != self.casing.type]

    @property
    def unknown_materials(self) -> dict[str, str]:
        """Materials that are not in the case, by the keys of the sections that name them."""
        disk, named = self.bladed_disk, {None, *(one.name for one in self.material.named)}
        sections: dict[str, Iterable[Any]] = {
            "bladed_disk.blade": [disk.blade],
            "bladed_disk.disk": [disk.disk],
            "bladed_disk.taper": disk.taper,
            "bladed_disk.shrouds": disk.shrouds,
            "bladed_disk.disk_rings": disk.disk_rings,
            "bladed_disk.mesh.sections": disk.mesh.sections.values() if disk.mesh else (),
            "casing.wall": [self.casing.wall],
            "casing.struts": self.casing.struts,
            "shaft_line.segments": self.shaft_line.segments if self.shaft_line else (),
        }
        for key, row in (self.shaft_line.walls if self.shaft_line else {}).items():
            wall = row.casing
            assert wall is not None
            sections[f"shaft_line.{key}.wall"] = [wall.wall]
            sections[f"shaft_line.{key}.struts"] = wall.struts
        unknown = {
            key: [one.material for one in among if one.material not in named]
            for key, among in sections.items()
        }
        return {key: names[0] for key, names in unknown.items() if names}

    @property
    def known_materials(self) -> str:
        """Names in material.named."""
        return ", ".join(f'"{one.name}"' for one in self.material.named) or "none"

    @property
    def of_blades(self) -> list[str]:
        """Keys of motions, loads and springs of single blades."""
        moved = self.initial.model_dump(exclude_defaults=True)
        loads = self.excitations.items()
        return [
            *(f"initial.{key}" for key, value in moved.items() if value),
            *(f'{key}.type = "{load.type}"' for key, load in loads if load.acts_on == "blades"),
            *["coupling.stiffness"] * bool(self.coupling.stiffness),
        ]

    @property
    def wall_friction(self) -> float:
        """Friction coefficient at the wall, which is that of the coating if it has its own."""
        coating = self.casing.coating
        own = None if coating is None else coating.friction
        return self.contact.friction if own is None else own

    def in_seconds(self, reference: float) -> "Case":
        """Return the case with the steps and the duration of its march in seconds; `reference` is
        the frequency of which speeds are multiples [rad/s]."""
        march = self.march.in_seconds(self.march.speed.rad_per_s(reference))
        return self if march is self.march else self.model_copy(update={"march": march})


def _unknown_keys(tables: Mapping[str, Any]) -> list[Fault]:
    """Return the unknown keys of a case with a superelement, whose file would take long to read."""
    table = value_at(tables, path_of(SOURCE))
    if not isinstance(table, Mapping):
        return []
    named = {key: value for key, value in table.items() if key != "file"}
    disk = {**tables["bladed_disk"], "superelement": named}
    try:
        Tables.model_validate({**tables, "bladed_disk": disk})
    except ValidationError as error:
        return faults_of(error, tables, only=UNKNOWN_KEY)
    return []


def case_from(tables: Mapping[str, Any]) -> Case:
    """Make a case from nested tables, as a case file contains them.

    Raises:
        CaseError: the case is invalid; the error lists all faults. Contradictions between values
            are reported only if each value is valid by itself.
    """
    return Case(**tables)
