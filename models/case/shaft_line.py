"""The `[shaft_line]` and `[gravity]` tables of a case: a flexible shaft with disks and bearings."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, StrictStr

from bladewhirl.models.case.casing import OF_ANGLES, Casing
from bladewhirl.models.case.superelement import SuperelementTable
from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.table import Table

Coordinate = Annotated[float, fields.quantity("m", "any")]
Pair = tuple[float, float]
Matrix2 = tuple[Pair, Pair]


def _matrix(unit: str) -> BeforeValidator:
    """Return a validator of 2 x 2 matrices, or of one number for equal and uncoupled axes."""
    entry = fields.quantity(unit, "any")
    phrase = f"one number in {unit}, or two rows of two numbers, [[xx, xy], [yx, yy]]"

    def validate(value: Any) -> Matrix2:
        if not isinstance(value, list | tuple):
            number = fields.converted(entry, value)
            return (number, 0.0), (0.0, number)
        rows = [
            fields.listed(row, phrase, least=2) for row in fields.listed(value, phrase, least=2)
        ]
        if [len(row) for row in rows] != [2, 2]:
            raise fields.expectation(phrase)
        (xx, xy), (yx, yy) = ([fields.converted(entry, each) for each in row] for row in rows)
        return (xx, xy), (yx, yy)

    return BeforeValidator(validate)


StiffnessMatrix = Annotated[Matrix2, _matrix("N/m")]
DampingMatrix = Annotated[Matrix2, _matrix("N s/m")]
TiltMatrix = Annotated[Matrix2, _matrix("N m")]
NONE: Matrix2 = ((0.0, 0.0), (0.0, 0.0))


class Segment(Table):
    """A round segment of the shaft, with a constant or a linearly varying diameter."""

    length: fields.Length
    """Length [m]."""
    outer_diameter: fields.Length
    """Outer diameter, at the left end [m]."""
    end_outer_diameter: fields.Length | None = Field(default=None, examples=['"40 mm"'])
    """Outer diameter at the right end [m], if different."""
    inner_diameter: fields.LengthOrZero = 0.0
    """Diameter of the bore [m]."""
    elements: Annotated[int, fields.count(1)] = 2
    """Number of elements. More nodes are added where disks, bearings and unbalances are."""
    material: StrictStr | None = None
    """Name in material.named; the material of the case by default."""
    shear_coefficient: Annotated[float, fields.number("positive")] | None = Field(
        default=None, examples=["0.886"]
    )
    """Share of the area that carries shear; by default that of Cowper (1966) for the diameters at
    the middle of the segment and poisson_ratio."""
    poisson_ratio: Annotated[float, fields.number("not negative")] = 0.3
    """Poisson's ratio, from which the shear modulus E / (2 + 2 nu) follows."""


class RigidDisk(Table):
    """A rigid disk on the shaft, which tilts with it."""

    position: Coordinate
    """Position along z [m]."""
    mass: Annotated[float, fields.quantity("kg")]
    """Mass [kg]."""
    polar_inertia: fields.Inertia
    """Moment of inertia about the axis of the shaft [kg m2]."""
    diametral_inertia: fields.Inertia
    """Moment of inertia about a diameter through the centre of mass [kg m2]."""
    offset: Coordinate = 0.0
    """Position of the centre of mass along z, relative to `position` [m]."""


class BearingSupport(Table):
    """A mass between a bearing and the ground, on springs and dampers of its own."""

    mass: Annotated[float, fields.quantity("kg")]
    """Mass [kg]."""
    stiffness: StiffnessMatrix
    """Stiffness to the ground along x and y [N/m], one number or [[kxx, kxy], [kyx, kyy]]."""
    damping: DampingMatrix = NONE
    """Damping to the ground along x and y [N s/m], as stiffness."""


class Bearing(Table):
    """A bearing: springs and dampers in static axes, between the shaft and ground or support."""

    name: StrictStr = ""
    """Name in tables and figures; by default the number of the bearing."""
    position: Coordinate
    """Position along z [m]."""
    stiffness: StiffnessMatrix
    """Stiffness along x and y [N/m]: one number, or [[kxx, kxy], [kyx, kyy]] with the forces
    -kxx x - kxy y along x; kxy - kyx > 0 drives forward whirl."""
    damping: DampingMatrix = NONE
    """Damping along x and y [N s/m], as stiffness."""
    tilt_stiffness: TiltMatrix = NONE
    """Stiffness against the slopes of the shaft in the planes of x and y [N m], as stiffness."""
    support: BearingSupport | None = Field(
        default=None, examples=['{ mass = "20 kg", stiffness = "50 MN/m" }']
    )
    """Mass between bearing and ground: { mass = "20 kg", stiffness = "50 MN/m", damping = 0 }."""


class Unbalance(Table):
    """An unbalance in one plane of the shaft."""

    position: Coordinate
    """Position along z [m]."""
    unbalance: Annotated[float, fields.quantity("kg m", "not negative")] = 0.0
    """Mass times its distance from the axis [kg m]."""
    phase: fields.Angle = 0.0
    """Angle of the mass from the x axis of the shaft [rad]."""
    couple: fields.Inertia = 0.0
    """Product of inertia: sum of mass, distance from the axis and position along z relative to
    `position` [kg m2]; a disk that is mounted askew by the angle a has (I_t - I_p) a."""
    couple_phase: fields.Angle = 0.0
    """Angle of the couple from the x axis of the shaft [rad]."""


class Wheel(Table):
    """A bladed wheel on the shaft, whose hub moves and tilts with it."""

    position: Coordinate
    """Position of its hub along z [m]."""
    unknowns: Literal["two", "four", "six"] = "six"
    """Displacements of the hub that follow the shaft: "two", x and y; "four", also the tilt; "six",
    also z and the rotation about z."""
    damping_ratio: fields.NumberOrZero = 0.0
    """Damping ratio of the modes that the wheel has with a fixed hub at rest. As a damping that
    turns with the wheel it destabilises forward whirl above its critical speed."""


class WheelWall(Casing):
    """The wall around a further wheel, with the elements, the curvature and the rotation of
    [casing]."""

    clearance: fields.LengthOrZero
    """As casing.clearance [m]; it must be given."""
    type: Literal["ring", "rigid"] = "rigid"
    """As casing.type, which must be the same."""

    @property
    def not_its_own(self) -> list[str]:
        """Keys that only [casing] has."""
        names = ("elements", "curvature", "rotation", "contour", *OF_ANGLES)
        return [name for name in names if getattr(self, name) != Casing.model_fields[name].default]

    def beside(self, casing: Casing) -> Casing:
        """Return this wall with what it has of [casing]."""
        shared = ("elements", "curvature", "rotation")
        return self.model_copy(update={name: getattr(casing, name) for name in shared})


class FurtherWheel(Wheel):
    """A wheel of a superelement of its own."""

    superelement: SuperelementTable
    """File of the wheel, with hub_dofs: { file = "second.npz" }."""
    casing: WheelWall | None = Field(default=None, examples=['{ clearance = "1 mm" }'])
    """Wall that its blades touch in a march, with the friction of [contact]; without it they touch
    nothing. A rigid one is { clearance = "1 mm", radius = "0.25 m", slope = "5 deg" }, a flexible
    ring { type = "ring", clearance = "1 mm", wall = { width = "40 mm", thickness = "5 mm" } }, with
    further keys of [casing]: support, springs, struts, thickness_lobes ..."""


class AxialSpring(Table):
    """A spring between the shaft and the ground along z."""

    position: Coordinate
    """Position along z [m]."""
    stiffness: fields.Stiffness
    """Stiffness [N/m]."""


class ShaftLine(Table):
    """A flexible shaft along z with rigid disks, bearings, supports and unbalances, in place of
    [shaft], with the wheel of [bladed_disk] or without. It has modes, critical speeds, a Campbell
    diagram, the response to unbalances, sag and a march in time, in which the wheel can rub."""

    segments: Annotated[
        tuple[Segment, ...],
        fields.rows('{ length = "200 mm", outer_diameter = "50 mm", elements = 2 }'),
    ]
    """Segments from the left end, rows of { length = "200 mm", outer_diameter = "50 mm",
    inner_diameter = 0, elements = 2, material = "steel", shear_coefficient = 0.886 }; a diameter
    that varies has end_outer_diameter."""
    start: Coordinate = 0.0
    """Position of the left end along z [m]."""
    disks: Annotated[
        tuple[RigidDisk, ...],
        fields.rows(
            '{ position = "0.5 m", mass = "20 kg", polar_inertia = "0.3 kg m2",'
            ' diametral_inertia = "0.16 kg m2" }'
        ),
    ] = ()
    """Rigid disks, rows of { position = "0.5 m", mass = "20 kg", polar_inertia = "0.3 kg m2",
    diametral_inertia = "0.16 kg m2", offset = 0 }."""
    bearings: Annotated[
        tuple[Bearing, ...],
        fields.rows('{ position = "1 m", stiffness = "10 MN/m", damping = "1 kN s/m" }'),
    ]
    """Bearings, rows of { name = "rear", position = "1 m", stiffness = "10 MN/m", damping = "1 kN
    s/m" } in static axes; unequal ones have stiffness = [[kxx, kxy], [kyx, kyy]]; support = {
    mass = "20 kg", stiffness = "50 MN/m" } is a mass between bearing and ground."""
    wheel: Wheel | None = Field(default=None, examples=['{ position = "1.5 m" }'])
    """Wheel of [bladed_disk], of a superelement whose file has hub_dofs, or of equal beams, which
    tilts as a rigid disk: { position = "1.5 m", unknowns = "six", damping_ratio = 0 }."""
    wheels: Annotated[
        tuple[FurtherWheel, ...],
        fields.rows('{ position = "0.3 m", superelement = { file = "second.npz" } }'),
    ] = ()
    """Further wheels, rows of { position = "0.3 m", unknowns = "six", superelement = { file =
    "second.npz" }, casing = { clearance = "1 mm" } }."""
    axial: AxialSpring | None = Field(
        default=None, examples=['{ position = 0, stiffness = "10 MN/m" }']
    )
    """Spring along z, { position = 0, stiffness = "10 MN/m" }, of a line with a wheel of six
    unknowns; without it the line is held along z at drive_position."""
    drive_position: Coordinate | None = Field(default=None, examples=['"0 m"'])
    """Position at which the drive turns the line at the speed of the case, so that no torsion moves
    it [m]; by default the left end."""
    unbalance: Annotated[
        tuple[Unbalance, ...], fields.rows('{ position = "0.5 m", unbalance = "100 g mm" }')
    ] = ()
    """Unbalances, rows of { position = "0.5 m", unbalance = "100 g mm", phase = "30 deg" }."""
    loss_time: fields.TimeOrZero = 0.0
    """Internal damping of the shaft, with the stress E (strain + loss_time d strain / dt) [s]. It
    acts in rotating axes, and destabilises forward whirl above its critical speed."""
    modes: Annotated[int, fields.count(2)] = 20
    """Number of modes of the line in each plane that a march keeps: static shapes of forces of the
    bearings, and the lowest modes without bearings at rest and at the speed. With a wheel,
    reduction.free_interface_modes is the number of modes of the whole rotor."""

    @property
    def end(self) -> float:
        """Position of the right end along z [m]."""
        return self.start + sum(segment.length for segment in self.segments)

    @property
    def off_the_shaft(self) -> list[str]:
        """Keys of the positions that are not on the shaft."""
        return [
            f"{key}.{number}.position"
            for key in ("disks", "bearings", "unbalance", "wheels")
            for number, row in enumerate(getattr(self, key))
            if not self._carries(row.position)
        ] + [key for key, place in self._single.items() if not self._carries(place)]

    def _carries(self, position: float) -> bool:
        slack = 1e-9 * (self.end - self.start)
        return self.start - slack <= position <= self.end + slack

    @property
    def _single(self) -> dict[str, float]:
        """Positions of wheel, axial spring and drive that are given [m], by key."""
        given = {
            "wheel.position": None if self.wheel is None else self.wheel.position,
            "axial.position": None if self.axial is None else self.axial.position,
            "drive_position": self.drive_position,
        }
        return {key: place for key, place in given.items() if place is not None}

    @property
    def positions(self) -> tuple[float, ...]:
        """Positions of disks, bearings, unbalances, wheels, axial spring and drive [m]."""
        rows: tuple[RigidDisk | Bearing | Unbalance | Wheel, ...]
        rows = (*self.disks, *self.bearings, *self.unbalance, *self.wheels)
        return (*(each.position for each in rows), *self._single.values())

    @property
    def every_wheel(self) -> tuple[Wheel, ...]:
        """Wheels of solids, first that of [bladed_disk]."""
        return self.wheels if self.wheel is None else (self.wheel, *self.wheels)

    @property
    def walls(self) -> dict[str, FurtherWheel]:
        """Further wheels with a wall, by the keys of their walls."""
        rows = enumerate(self.wheels)
        return {f"wheels.{n}.casing": row for n, row in rows if row.casing is not None}

    @property
    def walled(self) -> list[int]:
        """Numbers of the wheels that can have a wall: 0 for the first, 1 ... for the rows of
        `wheels` with one."""
        return [0, *(n for n, row in enumerate(self.wheels, start=1) if row.casing is not None)]

    @property
    def doubled(self) -> list[str]:
        """Keys of the positions of wheels at the place of an earlier one."""
        slack, places = 1e-9 * (self.end - self.start), [one.position for one in self.every_wheel]
        first = len(places) - len(self.wheels)
        return [
            f"wheels.{row}.position"
            for row, wheel in enumerate(self.wheels)
            if any(abs(wheel.position - other) <= slack for other in places[: first + row])
        ]

    @property
    def supports(self) -> int:
        """Number of supports."""
        return sum(each.support is not None for each in self.bearings)

    def named(self) -> tuple[str, ...]:
        """Return the names of the bearings; those without a name have their number, from 1."""
        return tuple(each.name or str(n) for n, each in enumerate(self.bearings, start=1))


USED = ("title", "material", "shaft_line", "gravity", "march")
"""Tables of a case with a shaft line."""

WITH_WHEEL = (
    *USED,
    "bladed_disk",
    "casing",
    "contact",
    "damping",
    "reduction",
    "blade_loss",
    "sensor",
)
"""Tables of a case with a shaft line and the wheel of [bladed_disk]."""


def beside_line(case: Table) -> list[str]:
    """Return the tables and keys that have no effect in a case with a shaft line; excitations on
    blades and casing have one with a wheel."""
    given = {
        name: value
        for name, field in type(case).model_fields.items()
        if (value := getattr(case, name)) != field.default
    }
    if "shaft_line" not in given:
        return []
    used, disk = set(USED), dict[str, Any]()
    loads = given.get("excitation", ())
    kinds = {one.type for one in (loads if isinstance(loads, tuple) else [loads])}
    felt = {"harmonic", "imbalance"}  # the latter is refused with another key in its place
    if given["shaft_line"].wheel is not None:
        used |= {*WITH_WHEEL, "sketch"}
        felt |= {"engine-order", "casing-distortion"}
        if "bladed_disk" in given:
            disk = given["bladed_disk"].model_dump(exclude_defaults=True)
    if kinds <= felt:
        used.add("excitation")
    beside = [f"bladed_disk.{name}" for name in disk if name != "superelement"]
    return [
        *(name for name in given if name not in used),
        *(beside if "superelement" in disk else []),
    ]


class Gravity(Table):
    """Gravity on a shaft line."""

    acceleration: tuple[
        Annotated[float, fields.quantity("m/s2", "any")],
        Annotated[float, fields.quantity("m/s2", "any")],
    ] = (0.0, -9.81)
    """Acceleration along x and y of static axes [m/s2]."""
    start: Literal["sag", "unbent"] = "sag"
    """State in which a march starts: "sag", the static state under gravity, or "unbent"."""
