"""The case: the immutable contents of a case file, in SI units.

Make a case by keyword, ``Case(march=March(speed=1.2))``, or read one with `read_case`. Defaults are
values of the paper, or choices where the paper gives no value; the description of each key states
its source. Numbers are in SI units; text includes a unit, "1 mm". New kinds of geometry are added
as optional tables.
"""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from bladewhirl.models.case.check import faults_of
from bladewhirl.models.case.excitation import (
    CasingDistortion,
    EngineOrder,
    Harmonic,
    Imbalance,
)
from bladewhirl.models.case.sensors import sensor_faults
from bladewhirl.models.case.shaft_line import line_faults
from bladewhirl.models.case.superelement_rules import superelement_faults
from bladewhirl.models.case.tables import Tables
from bladewhirl.models.inputs.errors import CaseError, shown
from bladewhirl.models.inputs.table import Inconsistency


class Case(Tables):
    """A bladed disk on its shaft, a casing, a load and a speed; by default the paper's fan stage.

    Raises:
        CaseError: the case is invalid; the error lists all faults, as for a case file. The classes
            of the other tables, such as ``Shaft(stiffness=...)``, raise pydantic's
            ``ValidationError``.
    """

    if not TYPE_CHECKING:  # type checkers see the keys

        def __init__(self, **tables: Any) -> None:
            try:
                super().__init__(**tables)
            except ValidationError as error:
                raise CaseError(faults_of(error, tables)) from None

    def __repr__(self) -> str:
        """Return the title, and a line for each table with the keys that differ from defaults."""
        changed = self.model_dump(exclude_defaults=True, exclude_none=True)
        loads = [
            {"type": load.type, **load.model_dump(exclude_defaults=True, exclude_none=True)}
            for load in self.excitations.values()
        ]
        changed["excitation"] = loads if isinstance(self.excitation, tuple) else loads[0]
        rows = [f"{name:<13}{shown(table)}" for name, table in changed.items() if name != "title"]
        return "\n  ".join([f'Case "{self.title}", other keys at their defaults', *rows])

    def __str__(self) -> str:
        """Return the text of `__repr__`."""
        return repr(self)

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield contradictions between values of different tables."""
        yield from line_faults(self)
        elements = self.casing.elements
        for key, load in self.excitations.items():
            if isinstance(load, CasingDistortion) and 2 * load.nodal_diameter > elements:
                expected = f"at most half of casing.elements = {elements}"
                yield Inconsistency(f"{key}.nodal_diameter", expected, ("casing.elements",))
            if self.shaft.clamped and isinstance(load, Imbalance | Harmonic):
                expected = "a load that is not at the centre, or shaft.clamped = false"
                yield Inconsistency(f"{key}.type", expected, ("shaft.clamped",))
            if isinstance(load, EngineOrder | Imbalance):
                yield from load.faults(key, self.blades)
        for key in ("centre_velocity", "centre_displacement"):
            if self.shaft.clamped and any(getattr(self.initial, key)):
                expected = "zero, or shaft.clamped = false"
                yield Inconsistency(f"initial.{key}", expected, ("shaft.clamped",))
        for key in ("tip_velocity", "tip_displacement"):
            rows = getattr(self.initial, key)
            if rows is not None and len(rows) != self.blades:
                expected = f"{self.blades} rows, one for each blade, not {len(rows)}"
                others = ("bladed_disk.blades", "bladed_disk.mesh.tips", "sketch")
                yield Inconsistency(f"initial.{key}", expected, others)
        if self.march.varies and self.rotation.effects == "centrifugal":
            expected = '"none" or "full" with a speed that varies'
            yield Inconsistency("rotation.effects", expected, ("march.speed_table", "march.run_up"))
        if self.march.drive is not None:
            yield from self._drive_faults()
        if self.casing.coating is not None:
            if not self.casing.coating.thickness < self.tip_radius:
                expected = f"less than the radius of the tips, {self.tip_radius:.6g} m"
                yield Inconsistency("casing.coating.thickness", expected)
            if not (self.casing.coating.footprint or 0.0) < self.tip_radius:
                expected = f"less than the radius of the tips, {self.tip_radius:.6g} m"
                yield Inconsistency("casing.coating.footprint", expected)
        yield from self._unknown_materials()
        yield from sensor_faults(self.sensor, self.blades)
        if self.shaft.damping_frame == "static" and self.rotation.effects != "full":
            expected = '"rotating", or rotation.effects = "full" (Coriolis forces)'
            yield Inconsistency("shaft.damping_frame", expected, ("rotation.effects",))
        yield from superelement_faults(self)
        yield from self._loss_faults()
        if self.sketch is not None:
            for name in self.bladed_disk.given():
                expected = "not allowed together with [sketch]; remove this key"
                yield Inconsistency(f"bladed_disk.{name}", expected, ("sketch",))

    @property
    def wall_friction(self) -> float:
        """Friction coefficient at the wall, which is that of the coating if it has its own."""
        coating = self.casing.coating
        own = None if coating is None else coating.friction
        return self.contact.friction if own is None else own

    def _drive_faults(self) -> Iterator[Inconsistency]:
        """Yield what a free speed does not allow: forces whose torque is not known."""
        shaft, closure = self.shaft, self.casing.closure
        for key, allowed, expected in (
            ("contact.sliding", self.contact.sliding != "full", '"permanent" or "signed"'),
            ("contact.foreshortening", not self.contact.foreshortening, "false"),
            ("casing.coating", self.casing.coating is None, "no coating"),
            ("casing.closure.lobes", closure is None or not closure.lobes, "no lobes"),
            ("coupling.stiffness", self.coupling.stiffness == 0.0, "0"),
            ("shaft.stiffness_y", shaft.clamped or not shaft.anisotropy, "equal springs"),
        ):
            if not allowed:
                expected = f"{expected} with march.drive"
                yield Inconsistency(key, expected, ("march.drive",))
        for key, load in self.excitations.items():
            if isinstance(load, Harmonic | EngineOrder):
                expected = '"imbalance", "casing-distortion" or "none" with march.drive'
                yield Inconsistency(f"{key}.type", expected, ("march.drive",))
            elif isinstance(load, Imbalance) and load.ramp > 0.0:
                expected = "0 with march.drive, whose momentum contains the imbalance"
                yield Inconsistency(f"{key}.ramp", expected, ("march.drive",))

    def _loss_faults(self) -> Iterator[Inconsistency]:
        """Yield what the loss of a blade and a support that fuses do not allow."""
        loss, march, disk = self.blade_loss, self.march, self.bladed_disk
        if self.shaft.fuse_force is not None and self.coupling.stiffness:
            expected = "0 with shaft.fuse_force"
            yield Inconsistency("coupling.stiffness", expected, ("shaft.fuse_force",))
        if loss is None:
            return
        if max(loss.blade) >= self.blades:
            expected = f"blades from 0 to {self.blades - 1}"
            yield Inconsistency("blade_loss.blade", expected, ("bladed_disk.blades",))
        if march.revolutions is None and not loss.time < march.duration:
            expected = f"a time before the end of the march, march.duration = {march.duration:g} s"
            yield Inconsistency("blade_loss.time", expected, ("march.duration",))
        for key, allowed, expected in (
            ("bladed_disk.mistuning", not disk.mistuning.is_given(self.blades), "equal blades"),
            ("bladed_disk.shrouds", not disk.shrouds, "blades without shrouds, packets included,"),
            ("coupling.stiffness", self.coupling.stiffness == 0.0, "0"),
        ):
            if not allowed:
                yield Inconsistency(key, f"{expected} with [blade_loss]", ("blade_loss.blade",))

    def _unknown_materials(self) -> Iterator[Inconsistency]:
        disk = self.bladed_disk
        known = ", ".join(f'"{one.name}"' for one in self.material.named) or "none"
        for key, sections in (
            ("bladed_disk.blade", [disk.blade]),
            ("bladed_disk.disk", [disk.disk]),
            ("bladed_disk.taper", disk.taper),
            ("bladed_disk.shrouds", disk.shrouds),
            ("bladed_disk.disk_rings", disk.disk_rings),
            ("bladed_disk.mesh.sections", disk.mesh.sections.values() if disk.mesh else ()),
            ("casing.wall", [self.casing.wall]),
            ("casing.struts", self.casing.struts),
        ):
            for section in sections:
                try:
                    self.material.find(section.material)
                except KeyError:
                    expected = f'materials of material.named ({known}), not "{section.material}"'
                    yield Inconsistency(key, expected, ("material.named",))
                    break

    def in_seconds(self, reference: float) -> "Case":
        """Return the case with the steps and the duration of its march in seconds; `reference` is
        the frequency of which speeds are multiples [rad/s]."""
        march = self.march.in_seconds(self.march.speed.rad_per_s(reference))
        return self if march is self.march else self.model_copy(update={"march": march})


def case_from(tables: Mapping[str, Any]) -> Case:
    """Make a case from nested tables, as a case file contains them.

    Raises:
        CaseError: the case is invalid; the error lists all faults. Contradictions between values
            are reported only if each value is valid by itself.
    """
    return Case(**tables)
