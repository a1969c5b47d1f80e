"""The `[bladed_disk.superelement]` table of a case: a file with the matrices of a blade."""

import os
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import model_validator

from bladewhirl.meshes.plane import rotate
from bladewhirl.models.case.joint import Joint
from bladewhirl.models.inputs import fields
from bladewhirl.models.inputs.rules import Inconsistency
from bladewhirl.models.inputs.table import Table, path_of, value_at
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError

SOURCE = "bladed_disk.superelement"  #: key of the table

CLEARANCE = 1e-3
"""Default clearance, divided by the largest radius of a contact node."""

SPEED = 0.25
"""Default speed, divided by the lowest frequency: engine order 4 meets this frequency at rest."""

STEPS, REVOLUTIONS = 4096, 20
"""Default number of time steps in a revolution, and of revolutions."""


class SuperelementTable(Table):
    """A file with mass, stiffness and contact nodes of a blade, a sector or a wheel, in place of
    beams."""

    file: Annotated[str, fields.file_path('the path of a file such as "blade.npz"')]
    """Path of a .npz or .mat file, relative to the case file."""
    copies: Annotated[int, fields.count(1)] = 1
    """Number of blades or sectors; by default the number in the file, if it has one.
    kind = "blade": blades at equal angles; "sector": sectors of the wheel; "wheel": blades of the
    wheel, whose contact nodes are listed blade by blade, or 1 if its blades are not to be
    distinguished."""
    kind: Literal["blade", "sector", "wheel"] = "blade"
    """"blade": clamped at the root; "sector": a sector of a wheel, with left_dofs and right_dofs;
    "wheel": a bladed disk, which shaft.stiffness supports at its centre if the file has
    centre_dofs. By default "sector" for a file with left_dofs, "wheel" for one with centre_dofs,
    hub_dofs or a number of blades."""
    angle: fields.Angle = 0.0
    """Angle by which the structure in the file is turned about the axis [rad]."""

    @property
    def part(self) -> Superelement:
        """The superelement in the file, with one of the contact nodes at each place. A hub does not
        tilt, see `with_hub`: that of a wheel is its centre, that of sectors is held.

        Raises:
            SuperelementError: the file is not a superelement.
        """
        return _without_tilt(self.kind, self.copies, self.file, *self.stamp)

    @property
    def with_hub(self) -> Superelement:
        """The superelement with the hub of the file."""
        return _single(self.kind, self.copies, self.file, *self.stamp)

    def joint_nodes(self, joint: Joint) -> tuple[list[int], list[int]]:
        """Return the contact nodes of a blade on the left and the right side of a joint.

        Raises:
            ValueError: the file has no such nodes; the message completes "expected ...".
            SuperelementError: the file is not a superelement.
        """
        part = self.part
        nodes = part.contacts // (self.copies if self.kind == "wheel" else 1)
        if joint.left:
            if self.left_out:
                raise ValueError(
                    "a file with joint_left and joint_right, as contact nodes at the place of"
                    " others are left out and the numbers change"
                )
            left, right = list(joint.left), list(joint.right)
            if max(left + right) >= nodes:
                raise ValueError(f"contact nodes of a blade, from 0 to {nodes - 1}")
        elif part.joint_left is None or part.joint_right is None:
            raise ValueError("numbers of contact nodes, or a file with joint_left and joint_right")
        else:
            left, right = part.joint_left.tolist(), part.joint_right.tolist()
        own, other = part.contact_position[left], part.contact_position[right]
        pitch = 2.0 * np.pi / self.copies
        apart = np.linalg.norm(rotate(own, pitch) - other, axis=1)
        room = np.sin(0.5 * pitch) * part.contact_radius[right]
        if far := [n for n in range(len(left)) if apart[n] > room[n]]:
            raise ValueError(
                f"nodes on the clockwise side of a blade: node {left[far[0]]} of the next blade is"
                f" {apart[far[0]]:.3g} m from node {right[far[0]]} of the right side"
            )
        return left, right

    @property
    def left_out(self) -> int:
        """Number of contact nodes of the file that are at the place of others."""
        return _cached(self.file, *self.stamp).contacts - self.part.contacts

    @property
    def stamp(self) -> tuple[int, int]:
        """Time of change [ns] and size [bytes] of the file."""
        return stamp_of(self.file)

    @model_validator(mode="before")
    @classmethod
    def _of_the_file(cls, given: Any) -> Any:
        """Take the kind and the number of sectors from the file unless they are given."""
        path = given.get("file") if isinstance(given, Mapping) else None
        part = part_of(path) if isinstance(path, str | os.PathLike) else None
        if part is None:
            return given
        own: dict[str, Any] = {"copies": part.sectors} if part.sectors else {}
        if part.left_dofs is not None:
            own["kind"] = "sector"
        elif part.centre_dofs is not None or part.hub_dofs is not None or part.sectors:
            own["kind"] = "wheel"
        return own | dict(given)

    def inconsistencies(self) -> Iterator[Inconsistency]:
        """Yield errors for an unreadable file, and for a file that does not fit its kind."""
        try:
            _ = self.part
        except SuperelementError as error:
            prefix = f"{self.file}: "
            for line in error.args:
                text = str(line).removeprefix(prefix)
                yield Inconsistency("file", f"a superelement: {text}")
        else:
            yield from super().inconsistencies()


def part_of(file: str | os.PathLike[str]) -> Superelement | None:
    """Return the superelement in a file; None if it cannot be read."""
    path = os.fspath(file)
    if "\0" in path:
        return None
    path = os.path.abspath(path)
    try:
        return _cached(path, *stamp_of(path))
    except SuperelementError:
        return None


def with_defaults(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a case with the defaults of clearance and march for a superelement,
    which follow from its radius and its lowest frequency; those of beams are the paper's."""
    file = value_at(tables, (*path_of(SOURCE), "file"))
    march, casing = tables.get("march", {}), tables.get("casing", {})
    if not isinstance(file, str | os.PathLike) or "\0" in os.fspath(file):
        return dict(tables)
    own: dict[str, Any] = {}
    if isinstance(march, Mapping) and tables.get("shaft_line") is None:
        varies = march.keys() & {"speed_table", "run_up"}
        usual = {} if varies else {"speed": SPEED}
        stands = value_at(march, ("speed",)) in (0, "0", "0 rpm", "0 Hz", "0 rad/s")
        if not march.keys() & {"time_step", "steps_per_revolution"} and not stands:
            usual["steps_per_revolution"] = STEPS
        if not march.keys() & {"duration", "revolutions", "drive"} and not (varies or stands):
            usual["revolutions"] = REVOLUTIONS
        own["march"] = usual | dict(march)
    if isinstance(casing, Mapping) and "clearance" not in casing:
        part = part_of(file)
        if part is not None:  # else the table of the superelement yields it
            radius = float(part.contact_radius.max())
            own["casing"] = {"clearance": CLEARANCE * radius} | dict(casing)
    return dict(tables) | own


def own_defaults(tables: Mapping[str, Any]) -> Mapping[str, set[str]]:
    """Return the keys of a case whose defaults `with_defaults` replaces, by the name of the table;
    none without a superelement."""
    if value_at(tables, path_of(SOURCE)) is None:
        return {}
    march = {"speed", "time_step", "duration"} if tables.get("shaft_line") is None else set[str]()
    return {"march": march, "casing": {"clearance"}}


def stamp_of(file: str) -> tuple[int, int]:
    """Return time of change [ns] and size [bytes] of a file; zeros if it cannot be read."""
    try:
        status = os.stat(file)
    except OSError:
        return 0, 0
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=4)
def _cached(file: str, modified: int, size: int) -> Superelement:
    """Read a file once for all stages of a sweep. The other arguments, time of change [ns] and size
    [bytes] of the file, make sure that a changed file is read again."""
    from bladewhirl.models.superelements.file import read_superelement  # loads scipy.io

    return read_superelement(file)


@lru_cache(maxsize=4)
def _single(kind: str, copies: int, *file: Any) -> Superelement:
    """Return the superelement in a file with one of the contact nodes at each place."""
    from bladewhirl.models.superelements.contacts import with_single_contacts  # loads scipy.spatial

    return with_single_contacts(_cached(*file), kind, copies)


@lru_cache(maxsize=4)
def _without_tilt(*file: Any) -> Superelement:
    """Return the superelement of `_single`, whose hub does not tilt."""
    from bladewhirl.models.superelements.hub import without_tilt  # loads scipy.sparse.linalg

    return without_tilt(_single(*file))
