"""The `[[joint]]` tables of a case: friction joints between neighbouring blades."""

import math
import re
from numbers import Real
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field

from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.table import ReplacedKeys, Table

SMALLEST_PART = 1e-3
"""Smallest tangential component of a unit normal."""

FLATTEST, STEEPEST = math.radians(1.0), math.radians(89.0)
"""Smallest and largest angle of the normal of a face of a damper from the tangential direction
[rad]."""

_NAME = fields.text(
    re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,59}"),
    "up to 60 letters, digits, hyphens and underscores that begin with a letter",
)
_NODES = 'the number of a contact node, such as "left = [1]", or a list of them'


def _nodes(value: Any) -> tuple[Any, ...]:
    value = value.tolist() if hasattr(value, "tolist") else value
    items = value if isinstance(value, list | tuple) else [value]
    counted = fields.count(0)
    return tuple(fields.converted(counted, item) for item in fields.listed(items, _NODES, 0))


def _vector(value: Any) -> tuple[float, float, float]:
    items = fields.listed(value, "three numbers [radial, tangential, axial]")
    if len(items) != 3 or not all(
        isinstance(x, Real) and not isinstance(x, bool) and math.isfinite(x) for x in items
    ):
        raise fields.expectation("three numbers [radial, tangential, axial]")
    length = math.hypot(*items)
    if not fields.SMALLEST < length < 1.0 / fields.SMALLEST:
        raise fields.expectation("three numbers [radial, tangential, axial], not all zero")
    r, t, z = (float(x / length) for x in items)
    return r, t, z


class Wedge(Table):
    """A damper between neighbouring blades: a point mass that the centrifugal force presses against
    both, as a body below two platforms."""

    angle: fields.Angle = math.radians(45.0)
    """Angle of the normal of both faces from the tangential towards the radial direction [rad]."""
    mass: Annotated[float, fields.quantity("kg", "positive")] | None = Field(
        default=None, examples=['"20 g"']
    )
    """Mass of the damper [kg]. Give mass or force."""
    force: Annotated[float, fields.quantity("N", "positive")] | None = Field(
        default=None, examples=['"500 N"']
    )
    """Centrifugal force on the damper [N], in place of mass, which follows from it, the speed and
    the radius."""
    radius: fields.Length | None = Field(default=None, examples=['"0.3 m"'])
    """Radius of its centre of mass [m]; by default that of the contact nodes."""
    axial: Literal["held", "free"] = "held"
    """"held": the damper does not move along the axis; "free": friction alone holds it, and it can
    walk."""


class Joint(ReplacedKeys):
    """Contact with friction between each blade and its next neighbour, counter-clockwise."""

    replacements: ClassVar = {"normal": ("angle",)}

    name: Annotated[str, _NAME] = "joint"
    """Name of the joint, by which results and keys such as joint.NAME.preload refer to it."""
    between: Literal["neighbours"] = "neighbours"
    """What the joint connects: each blade with the next one, counter-clockwise."""
    left: Annotated[tuple[int, ...], BeforeValidator(_nodes)] = ()
    """Contact nodes on the clockwise side of a blade, by their numbers in the superelement file; by
    default joint_left of the file. Of a wheel, they are numbers among the nodes of a blade."""
    right: Annotated[tuple[int, ...], BeforeValidator(_nodes)] = ()
    """Contact nodes on the counter-clockwise side of a blade, each of which touches the node of
    `left` at the same place of the list on the next blade; by default joint_right of the file."""
    ring: Annotated[int, fields.count(0)] | None = Field(default=None, examples=["0"])
    """Of beams: the row of bladed_disk.shrouds that this joint cuts halfway between all blades, so
    that the ends of its parts touch each other; by default the first one. Each part has half of the
    elements of the row, rounded up."""
    angle: fields.Angle = 0.0
    """Angle of the normal of the joint from the tangential towards the axial direction [rad]."""
    normal: Annotated[tuple[float, float, float], BeforeValidator(_vector)] | None = Field(
        default=None, examples=[[0.0, 1.0, 0.5]]
    )
    """Normal of the joint, from a blade to the next: radial, tangential and axial component at the
    joint, of any length, in place of angle."""
    friction: fields.NumberOrZero = 0.3
    """Coulomb friction coefficient."""
    gap: fields.LengthOrZero | None = Field(default=None, examples=['"0.05 mm"'])
    """Gap at rest [m]. Give one of gap, overclosure and preload; without them, the joint just
    touches."""
    overclosure: fields.LengthOrZero | None = Field(default=None, examples=['"0.05 mm"'])
    """Overlap of the unloaded surfaces at rest [m], which presses the joint."""
    preload: Annotated[float, fields.quantity("N", "not negative")] | None = Field(
        default=None, examples=['"300 N"']
    )
    """Normal force of the joint at rest [N], the sum of its nodes. It is converted to an
    overclosure by the static compliance of blades that all move alike, without friction."""
    opening_by_speed: bool = False
    """Whether the centrifugal load of the file opens or closes the joint by its static
    displacements, of blades that all move alike; gap, overclosure and preload are those at rest."""
    kind: Literal["shroud", "wedge"] = "shroud"
    """"shroud": surfaces of the blades touch each other; "wedge": a damper touches both of them."""
    wedge: Wedge | None = Field(default=None, examples=['{ angle = "45 deg", mass = "20 g" }'])
    """The damper of kind "wedge"."""

    @property
    def direction(self) -> tuple[float, float, float]:
        """Unit normal: radial, tangential and axial component."""
        return self.normal or (0.0, math.cos(self.angle), math.sin(self.angle))

    @property
    def cut_ring(self) -> int:
        """Row of bladed_disk.shrouds that the joint of beams cuts."""
        return self.ring or 0

    @property
    def pressing(self) -> list[str]:
        """Given keys among those of which a joint has one."""
        return [key for key in ("gap", "overclosure", "preload") if getattr(self, key) is not None]

    @property
    def of_surfaces(self) -> list[str]:
        """Given keys that a damper does not have."""
        given = {
            "normal": self.normal,
            "angle": self.angle,
            "opening_by_speed": self.opening_by_speed,
        }
        return [*self.pressing, *(key for key, value in given.items() if value)]


JointRows = Annotated[
    tuple[Joint, ...],
    fields.rows('{ name = "shroud", left = [1], right = [2], preload = "300 N" }'),
]
