"""The `[casing.coating]` table of a case: an abradable coating on the inner face of the casing."""

from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.wall_profile import WallPoints, with_points_of_file
from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.table import Table
from bladewhirl.models.sections.wall import TURN, LobeRows

Stress = Annotated[float, fields.quantity("Pa", "not negative")]
Point = tuple[fields.Angle, fields.LengthOrZero]

Points = Annotated[tuple[Point, ...], fields.rows('[angle, recess], as in ["90 deg", "0.1 mm"]')]


class WornTrack(WallPoints):
    """Removed depth in one track of a coating, for a superelement."""

    axial: Annotated[float, fields.quantity("m", "any")]
    """Axial position of the track [m]."""
    points: Points
    """Points of the worn surface, rows as in casing.coating.profile.points."""


class WornProfile(WallPoints):
    """Depth to which a coating is worn before the march."""

    points: Points = ()
    """Points of a worn surface, rows of [angle, recess]: angle from the x axis [rad] and removed
    depth [m], with linear interpolation around the casing. With a superelement they apply to all
    tracks. file = "wear.csv" reads the points from a file whose first line is
    "angle [deg],recess [mm]", with any units; a run with a coating writes such a file."""
    tracks: Annotated[
        tuple[WornTrack, ...],
        fields.rows('{ axial = "5 mm", points = [["90 deg", "0.1 mm"], ...] }'),
    ] = ()
    """Points of each track, in place of points, for a superelement. file = "wear.csv" reads them
    from a file whose first line is "angle [deg],recess at -5 mm [mm],recess at 5 mm [mm]", with
    the axial positions of the contact nodes; a run of a superelement writes such a file."""
    lobes: LobeRows = ()
    """Waves that are added to the removed depth. Each varies around the casing from 0 to its
    amplitude: amplitude (1 + cos(lobes (angle - phase))) / 2."""

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, values: Any) -> Any:
        return with_points_of_file(values, "recess", tracked=True)

    @property
    def axial(self) -> FloatArray:
        """Axial position of each of the tracks [m], ascending, (tracks,)."""
        return np.sort([track.axial for track in self.tracks])

    @property
    def deepest(self) -> float:
        """Largest removed depth [m]."""
        return float(self.recess(np.linspace(0.0, TURN, 7200)).max())

    def recess(self, angle: FloatArray) -> FloatArray:
        """Return the removed depth [m] at angles [rad], in the shape of the angles; if there
        are tracks, in the shape (tracks, *angle.shape) and the order of `axial`."""
        total = np.zeros(angle.shape)
        if self.points:
            total = _interpolated(self.points, angle)
        elif self.tracks:
            ordered = sorted(self.tracks, key=lambda track: track.axial)
            total = np.array([_interpolated(track.points, angle) for track in ordered])
        for wave in self.lobes:
            total += wave.amplitude * (1.0 + np.cos(wave.lobes * (angle - wave.phase))) / 2.0
        return np.asarray(total)


def _interpolated(points: tuple[Point, ...], angle: FloatArray) -> FloatArray:
    places, depths = np.array(points).T
    return np.asarray(np.interp(angle, places, depths, period=TURN))


class Coating(Table):
    """An abradable coating of elastic-plastic rods; plastic strain stands for removed material."""

    thickness: fields.Length
    """Thickness [m]. The clearance is measured to the coating before it is worn."""
    young_modulus: fields.Modulus
    """Young's modulus in radial compression [Pa]. Values of real coatings differ by orders of
    magnitude and have to be measured; the example with 1 GPa, a yield stress of 10 MPa and a
    hardening of 50 MPa is a placeholder."""
    yield_stress: Stress
    """Stress above which material is removed [Pa]."""
    hardening: Stress | None = None
    """Increase of the yield stress per plastic strain [Pa]; zero by default."""
    tangent_modulus: Stress | None = None
    """Slope of the stress-strain curve above the yield stress [Pa], in place of hardening."""
    elements: Annotated[int, fields.count(8)] | None = None
    """Number of rods around the casing; by default the smallest multiple of the number of blades at
    which a rod is shorter than a quarter of the footprint. With another number, blades meet their
    rods at different places. With a superelement, each track has this number of rods; a track is
    the strip at one axial position of contact nodes."""
    width: fields.Length | None = None
    """Size out of the plane [m]; the width of casing.wall by default. With a superelement the
    widths of several tracks follow from the distances between them; together they are the distance
    of the outermost contact nodes."""
    footprint: fields.Length | None = None
    """Arc that a tip, or a contact node of a superelement, covers [m]; by default the thickness of
    the blade at its tip; with a superelement the mean thickness of the surface at the tip along the
    arc, or, without a surface or with several nodes in a track, the distance of the nodes."""
    friction: fields.NumberOrZero | None = None
    """Friction coefficient at the coated wall; contact.friction by default."""
    limit: Annotated[float, fields.number("positive")] = 0.9
    """Largest fraction of the thickness that can be removed. A tip beyond this depth touches the
    metal of the casing."""
    profile: WornProfile | None = Field(default=None, examples=['{ file = "wear.csv" }'])
    """Worn surface at the start: { file = "wear.csv" }, { points = [["0 deg", "0.1 mm"], ...] } or
    { lobes = [{ lobes = 3, amplitude = "0.1 mm" }] }; by default the coating is new."""

    @property
    def slope(self) -> float:
        """Increase of the yield stress per plastic strain [Pa]."""
        elastic, tangent = self.young_modulus, self.tangent_modulus
        if tangent is None:
            return self.hardening or 0.0
        return elastic * tangent / (elastic - tangent)
