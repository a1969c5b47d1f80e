"""The tables of a case, and what follows from them."""

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import Field, SerializationInfo, StrictStr, model_validator

from bladewhirl.models.case.analysis import Contact, Coupling, Damping, Initial, March, Reduction
from bladewhirl.models.case.blade_loss import BladeLoss
from bladewhirl.models.case.bladed_disk import BladedDisk
from bladewhirl.models.case.casing import Casing
from bladewhirl.models.case.excitation import Excitation, ExcitationTable, NoExcitation
from bladewhirl.models.case.gauge_positions import with_gauge_points
from bladewhirl.models.case.joint import JointRows
from bladewhirl.models.case.sensors import SensorRows
from bladewhirl.models.case.shaft import Rotation, Shaft
from bladewhirl.models.case.shaft_line import Gravity, ShaftLine
from bladewhirl.models.case.sketch import SketchTable
from bladewhirl.models.case.superelement import SuperelementTable, own_defaults, with_defaults
from bladewhirl.models.inputs.table import ReplacedKeys
from bladewhirl.models.sections.rectangular import Material


class Tables(ReplacedKeys):
    """The tables of a case."""

    replacements: ClassVar = {"sketch": ("bladed_disk",)}

    title: StrictStr = "Fan stage"
    """Title, free text."""
    material: Material = Material()
    bladed_disk: BladedDisk = BladedDisk()
    shaft: Shaft = Shaft()
    rotation: Rotation = Rotation()
    casing: Casing = Casing()
    reduction: Reduction = Reduction()
    damping: Damping = Damping()
    contact: Contact = Contact()
    excitation: ExcitationTable = NoExcitation()
    """One table [excitation], or several tables [[excitation]] whose loads act together."""
    initial: Initial = Initial()
    sketch: SketchTable | None = Field(
        default=None, examples=["{ sectors = 22, nodes = [...], members = [...], sets = [...] }"]
    )
    """A bladed disk drawn in Python, in place of [bladed_disk]."""
    shaft_line: ShaftLine | None = Field(
        default=None, examples=["{ segments = [...], disks = [...], bearings = [...] }"]
    )
    """A flexible shaft with disks and bearings, in place of [bladed_disk] and [shaft]."""
    gravity: Gravity | None = Field(default=None, examples=["{ acceleration = [0.0, -9.81] }"])
    """Gravity on a shaft line."""
    coupling: Coupling = Coupling()
    march: March = March()
    blade_loss: BladeLoss | None = Field(
        default=None, examples=['{ blade = 0, time = "1 s", from = 0.0 }']
    )
    """Blades that break off during the march; needs equal blades of beams without shrouds."""
    sensor: SensorRows = ()
    """Sensors, whose signals a run writes to sensors.nc and NAME.csv, each a table [[sensor]]."""

    joint: JointRows = ()
    """Friction joints between neighbouring blades, of a superelement or of beams with shrouds, each
    a table [[joint]]."""

    @model_validator(mode="before")
    @classmethod
    def _of_superelement(cls, given: Any) -> Any:
        return with_gauge_points(with_defaults(given)) if isinstance(given, Mapping) else given

    def replaced(self, tables: dict[str, Any], info: SerializationInfo) -> dict[str, Any]:
        """Return the keys to write; without defaults, also those that a superelement replaces."""
        tables = super().replaced(tables, info)
        if info.exclude_defaults:
            chosen = {*(info.include or type(self).model_fields)} - {*(info.exclude or ())}
            for name, keys in own_defaults(tables).items():
                if name in chosen:
                    own = getattr(self, name).model_dump(include=keys)
                    tables[name] = own | tables.get(name, {})
        return tables

    @property
    def superelement(self) -> SuperelementTable | None:
        """The table bladed_disk.superelement."""
        return self.bladed_disk.superelement

    @property
    def excitations(self) -> Mapping[str, Excitation]:
        """Excitations by dotted key: "excitation", or "excitation.0", "excitation.1", ... if there
        is a list of them."""
        loads = self.excitation
        if isinstance(loads, tuple):
            return {f"excitation.{row}": load for row, load in enumerate(loads)}
        return {"excitation": loads}

    def key_of(self, load: Excitation) -> str:
        """Return the dotted key of one of the `excitations`."""
        return next(key for key, each in self.excitations.items() if each == load)

    @property
    def blades(self) -> int:
        """Number of blades."""
        if self.sketch is not None:
            return self.sketch.tips
        return self.bladed_disk.count

    @property
    def blades_at_walls(self) -> int:
        """Number of blades that can touch a wall, on a shaft line those of all wheels."""
        further = () if self.shaft_line is None else self.shaft_line.walls.values()
        return self.blades + sum(wheel.superelement.copies for wheel in further)

    @property
    def tip_radius(self) -> float:
        """Tip radius from which the clearance is measured [m]."""
        if self.sketch is not None:
            return self.sketch.radius
        return self.casing.radius or self.bladed_disk.radius
