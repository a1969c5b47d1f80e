"""The `[shaft]` and `[rotation]` tables of a case."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field, StrictBool

from bladewhirl.models.inputs.fields import DampingOrZero, Stiffness, StiffnessOrZero, quantity
from bladewhirl.models.inputs.table import ReplacedKeys, Table
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
