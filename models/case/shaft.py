"""The `[shaft]` and `[rotation]` tables of a case."""

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import Field, StrictBool

from bladewhirl.models.inputs.fields import DampingOrZero, Stiffness, StiffnessOrZero, quantity
from bladewhirl.models.inputs.table import Inconsistency, ReplacedKeys, Table
from bladewhirl.models.structure.rotating import Effects


class Rotation(Table):
    """Forces on the bladed disk due to its rotation; the paper leaves them out."""

    effects: Effects = "none"
    """"none", as in the paper; "centrifugal": tension in blades and disk with its geometric
    stiffness, spin softening and static growth of the tips; "full": Coriolis forces as well. The
    effects are those at march.speed. A superelement has the stiffness of its file, and the Coriolis
    forces of its matrix gyroscopic, which "full" requires."""
    clearance: Literal["hot", "cold"] = "hot"
    """State in which casing.clearance is measured: "hot", at march.speed; "cold", at rest: the
    static growth of the tips at march.speed is then subtracted. The growth is computed only with
    rotation.effects = "centrifugal" or "full", so "cold" needs one of these."""

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield an error for a cold clearance (measured at rest) without rotation effects."""
        if self.effects == "none" and self.clearance == "cold":
            expected = (
                '"hot", or rotation.effects = "centrifugal" or "full": only then do tips grow'
            )
            yield Inconsistency("clearance", expected, ("effects",))


class Shaft(ReplacedKeys):
    """Shaft: two springs that carry the centre of the disk; the centre node has no rotation."""

    replacements: ClassVar = {"suspension_frequency": ("stiffness",)}

    stiffness: Stiffness = 3.4e7
    """Stiffness of each spring [N/m] (paper, Section 2.1); only of the spring along x if
    stiffness_y is given."""
    stiffness_y: Stiffness | None = Field(default=None, examples=["2e7"])
    """Stiffness of the spring along y [N/m], if different from that along x."""
    suspension_frequency: Annotated[float, quantity("Hz")] | None = Field(
        default=None, examples=["300 Hz"]
    )
    """Required natural frequency of the suspension modes at rest, before modal reduction [Hz], in
    place of shaft.stiffness; bladewhirl show prints the resulting stiffness of both springs.
    Frequencies near the first bending family of the blades cannot be reached; an error message then
    states the nearest possible frequencies."""
    frame: Literal["rotating", "static"] = "rotating"
    """Frame in which unequal springs are fixed: "rotating", in the bladed disk, like a shaft that
    is not round, with constant matrices; "static", in space, like unequal bearings. In rotating
    axes a static stiffness varies twice per revolution about the mean of both springs; modes are
    computed with the mean, critical speeds and Campbell diagrams with both springs. With
    rotation.effects = "full" the response is that of a symmetric rotor on unequal bearings. Without
    Coriolis and centrifugal terms the variation excites the suspension
    at speeds near its frequency, which is an artefact."""
    damping: DampingOrZero = 0.0
    """Damping parallel to each spring [N s/m]; only to the spring along x if damping_y is given.
    Dampers respond to contact one step late, an error of first order in march.time_step; with
    rotation.effects = "full" they respond within the step."""
    damping_y: DampingOrZero | None = Field(default=None, examples=["1e3"])
    """Damping along y [N s/m], if different from that along x."""
    damping_frame: Literal["rotating", "static"] = "rotating"
    """Frame of the dampers: "rotating", internal damping, which acts on the velocity in rotating
    axes and destabilises forward whirl above its critical speed; "static", bearing damping, which
    acts on the velocity in static axes (v + Omega z x u for the displacement u and the velocity v
    in rotating axes) and stabilises forward whirl. "static" needs equal dampers and
    rotation.effects = "full"."""
    fuse_force: Annotated[float, quantity("N")] | None = Field(default=None, examples=['"50 kN"'])
    """Force in the springs at which the support fuses [N]: from this instant on the springs have
    the stiffness shaft.fused_stiffness. Dampers stay. Needs a bladed disk of beams."""
    fused_stiffness: StiffnessOrZero | None = Field(default=None, examples=['"2 MN/m"'])
    """Stiffness of each spring after the support has fused [N/m]."""
    clamped: StrictBool = False
    """Fix the centre instead of supporting it by springs."""

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield errors for unequal dampers in the static frame, and for springs specified twice."""
        if self.suspension_frequency is not None:
            given = [name for name in ("stiffness_y", "clamped") if getattr(self, name)]
            if "stiffness" in self.model_fields_set:
                given.insert(0, "stiffness")
            if given:
                expected = f"not allowed together with shaft.{given[0]}; remove one of them"
                yield Inconsistency("suspension_frequency", expected, tuple(given))
        fuse = self.fuse_force, self.fused_stiffness
        if None in fuse and fuse != (None, None):
            key = "fuse_force" if self.fuse_force is None else "fused_stiffness"
            other = {"fuse_force": "fused_stiffness", "fused_stiffness": "fuse_force"}[key]
            yield Inconsistency(key, f"a value with shaft.{other}", (other,))
        if self.fuse_force is not None and self.clamped:
            expected = "springs, shaft.clamped = false; a clamped centre has no force to fuse at"
            yield Inconsistency("fuse_force", expected, ("clamped",))
        if self.fuse_force is not None and self.anisotropy:
            expected = 'equal springs or shaft.frame = "rotating" with shaft.fuse_force'
            yield Inconsistency("stiffness_y", expected, ("fuse_force",))
        if self.damping_frame == "static" and len(set(self.dampings)) > 1:
            expected = 'the value of shaft.damping, or shaft.damping_frame = "rotating"'
            yield Inconsistency("damping_y", expected, ("damping", "damping_frame"))

    @property
    def stiffnesses(self) -> tuple[float, float]:
        """Constant part of the stiffness along x and y of the rotating axes [N/m]."""
        along_x, along_y = self.springs
        if self.frame == "rotating":
            return along_x, along_y
        mean = 0.5 * (along_x + along_y)
        return mean, mean

    @property
    def anisotropy(self) -> float:
        """Half the difference of the stiffnesses along static x and y [N/m]; 0 for springs in the
        rotating frame."""
        along_x, along_y = self.springs
        return 0.0 if self.frame == "rotating" else 0.5 * (along_x - along_y)

    @property
    def springs(self) -> tuple[float, float]:
        """Stiffness along x and y of the frame in which the springs are fixed [N/m]."""
        return self.stiffness, self.stiffness if self.stiffness_y is None else self.stiffness_y

    @property
    def dampings(self) -> tuple[float, float]:
        """Damping along x and y [N s/m]."""
        return self.damping, self.damping if self.damping_y is None else self.damping_y
