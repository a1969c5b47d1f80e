"""Superelements of blades and sectors from meshes of solids, by `bladewhirl.mesh3d`."""

import json
import warnings
from dataclasses import replace
from os import PathLike
from typing import Any, Literal, get_args

import meshio
import numpy as np
import scipy.sparse as sp
from numpy.linalg import LinAlgError

from bladewhirl.meshes.coincident import COINCIDENT
from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.files.volumes import VolumeMesh, merged, read_volume_mesh, without_cells
from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.inputs.errors import Hint
from bladewhirl.models.inputs.progress import report
from bladewhirl.models.inputs.units import RAD_PER_S, finite, rotation, to_si
from bladewhirl.models.solids.assembly import Measure, Solid, stiffness_by_rotation
from bladewhirl.models.solids.elements import ELEMENTS
from bladewhirl.models.solids.groups import (
    AXES,
    clamped_on_both,
    contact_nodes,
    free_faces,
    group_nodes,
    invalid,
    matching_faces,
    sector_faces,
)
from bladewhirl.models.solids.joint_nodes import joint_pairs
from bladewhirl.models.solids.materials import Given, materials_of
from bladewhirl.models.solids.rigid import free_bodies, free_displacements
from bladewhirl.models.solids.sectors import find_bounds, find_sector
from bladewhirl.models.solids.stress import nodal_stress
from bladewhirl.models.solids.surface import surface_triangles
from bladewhirl.models.solids.wheels import blade_by_blade, goes_round, wheel_of_sector
from bladewhirl.models.superelements.cyclic import transformation
from bladewhirl.models.superelements.hub import (
    check_hub,
    hub_freed,
    in_whole,
    tied_rows,
    with_tie,
)
from bladewhirl.models.superelements.superelement import FIXED, HUB, Superelement

MOST_NODES = 100_000
"""Largest number of nodes. A factor of the stiffness of a larger mesh takes too much memory."""

CORIOLIS = np.array([[0.0, -2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
"""Acceleration 2 e_z x v of a velocity v at 1 rad/s, as a matrix."""


ROOT = "root"  #: group of the nodes that do not move, by default

QUADRATURES = {None: None, "full": False, "reduced": True}


def mesh3d(
    mesh: meshio.Mesh | str | PathLike[str],
    *,
    young_modulus: Given = None,
    poisson_ratio: Given = None,
    density: Given = None,
    clamped: str | None = ROOT,
    hub: str | None = None,
    hub_at: float | str | None = None,
    contact: str = "tip",
    contacts: int | None = None,
    joint_left: str | None = None,
    joint_right: str | None = None,
    joint_nodes: int | None = None,
    blade: str | None = None,
    lost: str | None = None,
    left: str | None = None,
    right: str | None = None,
    copies: int | None = None,
    length_unit: str = "m",
    mass_unit: str | None = None,
    axis: str = "z",
    speed: float | str = 0.0,
    mass_quadrature: Literal["full", "reduced"] | None = None,
    merge: float | str | None = None,
    stiffening: Measure | None = "prestress",
    coriolis: bool = False,
    stress: bool = True,
    outside_files: bool = False,
    name: str = "",
    unit: None = None,
) -> Superelement:
    """Make a superelement of a blade or a sector from a mesh of tetrahedra, wedges or hexahedra.

    The material is isotropic and linearly elastic, the mass is consistent. The nodes of a
    ``*COUPLING`` with ``*KINEMATIC``, a ``*KINEMATIC COUPLING`` or a ``*RIGID BODY`` of an .inp
    file move as a rigid body, or are clamped if their reference node belongs to `clamped`.

    Elements have the shape that all their nodes describe. Those of an .inp file are C3D4, C3D6,
    C3D8, C3D8I, C3D8R, C3D10, C3D15, C3D20 and C3D20R, with the functions and the quadrature of
    CalculiX; other files name no elements and have the fully integrated one of their cells, such as
    C3D20 for hexahedra of 20 nodes. `source` of the superelement lists them. A hint tells that
    elements of first order are too stiff in bending. C3D8I has incompatible modes, which are
    further coordinates. C3D8R has the stiffness against hourglass modes of Flanagan and Belytschko
    (1981); cells must be parallelepipeds, because programs differ for other shapes.

    The stiffness for small motions about the structure that rotates with a speed Omega, in a
    rotating frame, is K_u + K_s - Omega^2 M_xy = K + Omega^2 K1 + Omega^4 K2. K_u is the elastic
    stiffness of the statically deformed solid, K_s the geometric stiffness due to its stress, and
    M_xy the mass in the plane of rotation. The static displacement u follows from K u = Omega^2
    M_xy X with the positions X of the nodes and the stiffness K at rest. The superelement has K and
    the matrices `stiffness_speed`, K1, and `stiffness_speed4`, K2.

    Args:
        mesh: mesh of meshio, or path of a .msh file of Gmsh with physical groups, a .vtu file,
            an .inp file of Abaqus or CalculiX with sets of nodes or elements, a .cdb file of Ansys,
            bulk data of Nastran (.bdf, .nas), or a .med file of Code_Aster. The mesh must be at its
            true position relative to the axis of rotation.
        young_modulus: Young's modulus [Pa], or text such as "210 GPa", of the cells to which an
            .inp file gives no material in a solid section; or a dictionary from names of groups to
            such values, which replace those of the file.
        poisson_ratio: Poisson's ratio, from 0 to less than 0.5, in the same way.
        density: density [kg/m3], or text such as "7.8 g/cm3", in the same way.
        clamped: group of the nodes that do not move, or a condition on their position such as
            "r < 210 mm", "x = 0.2", "0 < x < 5 mm and z > 0" or "angle = -15", in the axes of the
            mesh, with the distance r from the axis of rotation and the angle about it [degrees].
            None for a free part. Their partners on the
            other face of a sector are clamped too.
        hub: group, or a condition as for `clamped`, of the nodes of the bore or of a flange that
            are tied to a hub, in place of clamped ones: six displacements by which a wheel, or the
            sectors of a wheel, move and tilt with a [shaft_line]. It implies `coriolis`; the matrix
            of the tie, by which the reaction of the bore resists a tilt, is part of
            `stiffness_speed`.
        hub_at: position of the hub along the axis of rotation [m], or text such as "12 mm"; by
            default the mean one of the tied nodes.
        contact: group of the contact nodes, a condition as for `clamped`, or "outermost": those
            within 1 % of the extent in radius of the largest radius. Nodes of a sector that are
            also nodes of the next sector are left out.
        contacts: number of contact nodes, of each blade with `copies`, evenly spaced along the
            chord of the group and in the middle of its thickness; all nodes of the group by
            default.
        joint_left, joint_right: groups, or conditions as for `clamped`, of the surfaces on the
            clockwise and the counter-clockwise side of a blade, such as those of shrouds, that
            touch those of its neighbours in a [[joint]]; both or none. Nodes that are nearest to
            each other after a turn by one pitch become pairs of further contact nodes.
        joint_nodes: number of these pairs, far from each other; all by default.
        blade: group, or a condition as for `clamped`, of the nodes of the blade of a sector, or of
            the blades of a wheel. Elements all of whose nodes belong to it are those whose Young's
            modulus the mistuning of a case changes (`blade_stiffness`).
        lost: group, or a condition as for `clamped`, of the nodes of blades that a wheel with a
            hub has lost, in one piece or of sectors; a group of a sector is that of the first one.
            Elements all of whose nodes belong to it are left out; the superelement has the
            coordinates of the whole wheel, of sectors one sector after another, of which those of
            lost nodes have no mass and no stiffness, for `[blade_loss]` of a wheel on a shaft line.
        left, right: groups, or conditions as for `clamped`, of the clockwise and of the
            counter-clockwise face of a sector; their nodes match after a rotation by one pitch.
            Both or none are given; with `copies` alone, faces that match are found.
        copies: number of sectors in the wheel; required with left and right. Number of blades of a
            wheel in one piece, whose contact nodes are then listed blade by blade.
        length_unit: unit of length of the mesh, such as "mm".
        mass_unit: unit of mass of the materials of an .inp file, such as "t" for N, mm and s;
            required if the unit of length is not m.
        axis: axis of rotation of the mesh, "x", "y" or "z". The axis of the superelement is z:
            axes x, y and z of the mesh become z, x and y, or y, z and x.
        speed: speed of rotation [rad/s], or text such as "12000 rpm", if the superelement is to
            have only the stiffness at this speed.
        mass_quadrature: "full", exact for cells with plane faces and evenly spaced nodes, or
            "reduced", with the quadrature points of the stiffness. By default it is reduced for
            C3D20R and, but for one percent, C3D8R, and full for other elements. CalculiX uses the
            reduced mass, which gives higher frequencies for coarse meshes of tetrahedra.
        merge: distance up to which nodes become one node [m], or text such as "1 um"; by default
            1e-5 of the size of the mesh. 0 keeps coincident nodes apart. A hint tells how many
            nodes were merged.
        stiffening: measure of strain: "prestress", as in a linear static step with a following
            perturbation step of CalculiX; "stress" leaves out the change of the elastic stiffness,
            K_u = K and K2 = 0; None, or a free part, for a superelement at rest only.
        coriolis: true to add the matrix of the Coriolis forces 2 M e_z x v, for the velocity v and
            a speed of 1 rad/s.
        stress: true to add the recovery of the stress at the points of the surface, extrapolated
            from the quadrature points and averaged over the elements of one material (where
            materials meet, of the stiffest), with the material of each point and the centrifugal
            forces. False saves memory and time for large meshes.
        outside_files: whether files that an .inp file names in ``*INCLUDE`` and ``INPUT=`` may be
            outside its folder.
        name: name of the superelement; by default that of the file.
        unit: former name of `length_unit`, not allowed.

    Returns:
        the superelement, with sparse matrices on the displacements of the nodes that are not
        clamped, in ascending order of the nodes of the mesh, incompatible modes and motions of
        rigid bodies, and with its surface for pictures.

    Raises:
        CaseError: an argument is invalid, the file cannot be read, a group is missing, nodes of the
            faces do not match, or contact nodes are clamped.
    """
    if unit is not None:
        raise invalid("unit", unit, f"length_unit = {unit!r}, the name of this argument")
    omega = _speed(speed)
    if mass_quadrature not in QUADRATURES:
        raise invalid("mass_quadrature", mass_quadrature, '"full" or "reduced"')
    if stiffening not in (None, *get_args(Measure)):
        raise invalid("stiffening", stiffening, '"prestress", "stress" or None')
    report("reading the mesh")
    volumes, notes = _merged(_scaled(mesh, length_unit, axis, outside_files), merge)
    if stiff := [name for name, _ in volumes.blocks if ELEMENTS[name].first_order]:
        names = " and ".join(stiff)
        expected = "expected elements of second order, or C3D8I in place of C3D8"
        text = f"elements {names} of first order are too stiff in bending: {expected}"
        warnings.warn(text, Hint, stacklevel=2)
    if hub is not None:
        if clamped not in (None, ROOT):
            raise invalid("clamped", clamped, "none with hub, which holds the wheel")
        if omega != 0.0:
            raise invalid("speed", speed, "0 with hub: a shaft line needs stiffness_speed")
    every, remaining = volumes, np.arange(len(volumes.points))
    if lost is not None:
        if hub is None:
            raise invalid("lost", lost, "none without hub, which holds the wheel")
        groups, cut = volumes.groups, _cut_faces(volumes, left, right, copies, axis)
        if cut is not None:
            volumes, numbers = wheel_of_sector(volumes, *cut)
            groups = {name: numbers[0, nodes] for name, nodes in groups.items()}
            left, right, copies = None, None, None
        gone = group_nodes(replace(volumes, groups=groups), "lost", lost, axis)
        every, (volumes, remaining) = volumes, without_cells(volumes, gone)
    key, group = ("clamped", clamped) if hub is None else ("hub", hub)
    fixed = np.zeros(0, int) if group is None else group_nodes(volumes, key, group, axis)
    tips = group_nodes(volumes, "contact", contact, axis)
    faces: dict[str, IntArray] = {}
    first, second, blades = fixed[:0], fixed[:0], None
    if copies is not None and left is None and right is None:
        sides = sector_faces("", "", copies)
        if (sector := find_sector(volumes, copies)) is not None:
            first, second = sector.left, sector.right
            if note := sector.partly(volumes.points):
                warnings.warn(note, Hint, stacklevel=2)
        elif goes_round(volumes.points):
            sides, blades = None, blade_by_blade(volumes.points, tips, copies)
            if blades is None:
                expected = f"a number of blades: after 1/{copies} of a turn about {axis} contact"
                raise invalid("copies", copies, f"{expected} nodes do not lie on others")
        else:
            expected = f"left and right: no cut faces match after 1/{copies} of a turn about {axis}"
            if (bounds := find_bounds(volumes)) is not None:
                expected += f"; {bounds.missed(volumes.points, 'm')}"
            raise invalid("copies", copies, expected)
    elif (sides := sector_faces(left, right, copies)) is not None:
        first = group_nodes(volumes, "left", sides[0], axis)
        second = group_nodes(volumes, "right", sides[1], axis)
    if sides is not None:
        first, second = matching_faces(volumes.points, first, second, sides[2])
        fixed, note = clamped_on_both(first, second, fixed)
        if note:
            warnings.warn(note.removeprefix(", "), Hint, stacklevel=2)
        notes += note
        faces = free_faces(first, second, fixed)
    if blades is None:
        touching = contact_nodes(volumes.points, tips, contacts, fixed, sides)
    else:
        own = contact_nodes(volumes.points, blades[0], contacts, np.intersect1d(fixed, tips))
        touching = blades[:, (own[:, None] == blades[0]).argmax(axis=1)].ravel()
    joined: dict[str, IntArray] = {}
    if joint_left is not None and joint_right is not None:
        if blades is not None:
            raise invalid("joint_left", joint_left, "a blade or a sector, not a wheel in one piece")
        pair = [
            np.setdiff1d(group_nodes(volumes, key, given, axis), np.r_[fixed, first, second])
            for key, given in (("joint_left", joint_left), ("joint_right", joint_right))
        ]
        pair = [*joint_pairs(volumes.points, pair[0], pair[1], copies, joint_nodes)]
        touching = touching[~np.isin(touching, pair)]
        joined = {
            key: len(touching) + n * len(pair[0]) + np.arange(len(pair[0]))
            for n, key in enumerate(("joint_left", "joint_right"))
        }
        touching = np.concatenate([touching, *pair])
    elif (joint_left, joint_right) != (None, None):
        raise invalid("joint_left", joint_left, "joint_left and joint_right together, or neither")
    if loose := len(np.setdiff1d(volumes.groups.get(volumes.held, fixed[:0]), fixed)):
        text = f"{loose} nodes that {volumes.held} of {volumes.name} holds are not clamped"
        warnings.warn(f"{text}: clamped = {volumes.held!r} holds them", Hint, stacklevel=2)
    bodies = free_bodies(volumes, fixed, {"contact": touching, "left": first, "right": second})
    if volumes.ignored:
        text = f"{', '.join(volumes.ignored)} of {volumes.name} are not read: expected solids only"
        text += "; bladewhirl import reads the matrices of CalculiX, which contain them"
        warnings.warn(text, Hint, stacklevel=2)
    report("matrices of the elements")
    given = {"young_modulus": young_modulus, "poisson_ratio": poisson_ratio, "density": density}
    materials = materials_of(volumes, given, length_unit, mass_unit)
    try:
        solid = Solid(volumes, materials)
    except MeshFileError as error:
        raise invalid("mesh", volumes.name, str(error)) from None
    centre = None if hub is None else _hub_position(solid.points[fixed], hub_at)
    dofs, select = free_displacements(solid.size, solid.points, fixed, bodies, centre)
    mass = solid.mass(reduced=QUADRATURES[mass_quadrature])
    shown, triangles = surface_triangles(volumes)
    load, nodes = np.zeros((solid.size, 3)), slice(len(solid.points))  # not incompatible modes
    load[nodes, :2] = mass[nodes, nodes] @ solid.points[:, :2]
    recovered: dict[str, Any] = {}
    if stress:
        report("recovery of stress")
        rows, *constants = nodal_stress(solid, shown, materials)
        recovered = {
            "stress_recovery": sp.csr_array(rows @ select),
            **dict(zip(("young_modulus", "poisson_ratio"), constants, strict=True)),
        }
    content: dict[str, Any] = {
        **recovered,
        "centrifugal_load": select.T @ load.ravel(),
        "euler_load": select.T @ (load @ CORIOLIS).ravel() / 2.0,
        "mass": sp.csr_array(select.T @ sp.kron(mass, np.eye(3), format="csr") @ select),
        "gyroscopic": (
            sp.csr_array(select.T @ sp.kron(mass, CORIOLIS, format="csr") @ select)
            if coriolis or hub is not None
            else None
        ),
        "contact_position": volumes.points[touching],
        "contact_dofs": dofs[touching],
        **joined,
        "points": volumes.points[shown],
        "triangles": triangles,
        "recovery": sp.csr_array(select[(3 * shown[:, None] + np.arange(3)).ravel()]),
        "name": name or volumes.name,
        "source": f"mesh3d: {volumes.name}, {_elements(volumes)}{notes}, axis {axis}, {materials}"
        + (f", stiffness at speed: {stiffening}" if stiffening and len(fixed) else ""),
        **{key: dofs[nodes] for key, nodes in faces.items()},
        "sectors": copies,
        "mesh_axis": axis,
        "group_places": json.dumps(_places(volumes)),
        "whole_mass": float(mass[nodes, nodes].sum()),
        "hub_dofs": None if hub is None else select.shape[1] - HUB + np.arange(HUB),
        "hub_position": centre,
    }
    stiffness = solid.stiffness()
    if blade is not None:
        chosen = solid.within(group_nodes(volumes, "blade", blade, axis))
        if not chosen.any():
            raise invalid("blade", blade, "all nodes of at least one element")
        content["blade_stiffness"] = sp.csr_array(select.T @ solid.stiffness(chosen) @ select)
    part = Superelement(stiffness=sp.csr_array(select.T @ stiffness @ select), speed=0.0, **content)
    number, size = np.arange(part.size), part.size
    if lost is not None:
        if bodies or solid.size > len(solid.points):
            raise invalid("lost", lost, "none with rigid bodies or elements of incompatible modes")
        tied = group_nodes(every, key, str(group), axis)
        place, free = free_displacements(len(every.points), every.points, tied, [], centre)
        place, size = place[remaining], free.shape[1]
        number = np.concatenate([place[place != FIXED], size - HUB + np.arange(HUB)])
    if omega != 0.0 and not (len(fixed) and stiffening and not bodies):
        expected = "0, or clamped nodes (a free part does not resist rotation) and a stiffening"
        expected += ", without rigid bodies" if bodies else ""
        raise invalid("speed", speed, expected)
    if stiffening is None or not len(fixed):
        return in_whole(part, number, size)
    if bodies:
        text = "the stiffness at speed is left out: it is not computed for solids with rigid bodies"
        warnings.warn(text, Hint, stacklevel=2)
        return part
    report("stiffness at speed")
    held = hub_freed(part)
    tie = select[:, : held.size]
    tie = tie if sides is None else tie @ transformation(held, sides[2], 0)
    try:
        *changes, reaction = stiffness_by_rotation(solid, stiffness, mass, tie, stiffening)
    except LinAlgError:  # the stiffness is singular
        if omega != 0.0:
            expected = "0, or a part without motions that meet no stiffness"
            raise invalid("speed", speed, expected) from None
        text = "the stiffness at speed is left out: the part has motions without stiffness"
        warnings.warn(text, Hint, stacklevel=2)
        return part
    squared, fourth = (
        None if change is None else sp.csr_array(select.T @ change @ select) for change in changes
    )
    part = replace(part, stiffness_speed=squared, stiffness_speed4=fourth)
    if centre is not None:
        part = replace(part, **with_tie(part, reaction[fixed], solid.points[fixed] - centre))
        everywhere = np.zeros((3 * solid.size, HUB))
        everywhere[: solid.points.size] = tied_rows(solid.points - centre)
        motions = select.T @ everywhere
        motions[part.hub_dofs] = np.eye(HUB)
        check_hub(part, motions)
    if omega == 0.0:
        return in_whole(part, number, size)
    return replace(part.at(omega), stiffness_speed=None, stiffness_speed4=None)


def _cut_faces(
    volumes: VolumeMesh, left: str | None, right: str | None, copies: int | None, axis: str
) -> tuple[IntArray, IntArray, int] | None:
    """Return the nodes of the cut faces of a sector in the same order, and the number of sectors;
    None for a wheel in one piece, of which no copies are given."""
    if copies is not None and left is None and right is None:
        if (found := find_sector(volumes, copies)) is None:
            raise invalid("copies", copies, "none with lost, or those of a sector")
        return *matching_faces(volumes.points, found.left, found.right, copies), copies
    if (sides := sector_faces(left, right, copies)) is None:
        return None
    faces = zip(("left", "right"), sides[:2], strict=True)
    first, second = (group_nodes(volumes, key, name, axis) for key, name in faces)
    return *matching_faces(volumes.points, first, second, sides[2]), sides[2]


def _hub_position(tied: FloatArray, given: float | str | None) -> FloatArray:
    """Return the position of the hub of tied nodes, (n, 3), on the axis [m], (3,)."""
    try:
        height = to_si(given, "m") if isinstance(given, str) else finite(given or 0.0)
    except (TypeError, ValueError) as error:
        raise invalid("hub_at", given, f'a position such as "12 mm" ({error})') from None
    return np.array([0.0, 0.0, tied[:, 2].mean() if given is None else height])


def _elements(mesh: VolumeMesh) -> str:
    """Return the number of the elements of each name."""
    return ", ".join(f"{len(cells)} elements {name}" for name, cells in mesh.blocks)


def _speed(value: float | str) -> float:
    try:
        return rotation(value, RAD_PER_S) if isinstance(value, str) else finite(value)
    except (TypeError, ValueError) as error:
        expected = f'a number in rad/s, or text such as "12000 rpm" ({error})'
        raise invalid("speed", value, expected) from None


def _merged(mesh: VolumeMesh, given: float | str | None) -> tuple[VolumeMesh, str]:
    """Return a mesh with coincident nodes merged, and a note of their number for `source`."""
    try:
        distance = to_si(given, "m") if isinstance(given, str) else finite(given or 0.0)
        if distance < 0.0:
            raise ValueError("it is negative")
    except (TypeError, ValueError) as error:
        raise invalid("merge", given, f'a distance such as "1 um" ({error})') from None
    if given is None:
        distance = COINCIDENT * float(np.ptp(mesh.points, axis=0).max())
    try:
        made = merged(mesh, distance)
    except MeshFileError as error:
        raise invalid("merge", given, str(error)) from None
    if made is mesh:
        return mesh, ""
    number = len(mesh.points) - len(made.points)
    note = f"{number} nodes merged with others within {distance:.3g} m"
    warnings.warn(f"{note}: merge = 0 keeps them apart", Hint, stacklevel=3)
    return made, f", {note}"


def _scaled(mesh: Any, unit: str, axis: str, outside: bool) -> VolumeMesh:
    """Return a mesh with lengths in metres and the axis of rotation z."""
    try:
        scale = to_si(f"1 {unit}", "m")
    except ValueError as error:
        raise invalid("length_unit", unit, f'a unit of length such as "mm" ({error})') from None
    if axis not in AXES:
        raise invalid("axis", axis, '"x", "y" or "z"')
    try:
        volumes = read_volume_mesh(mesh, outside=outside)
    except MeshFileError as error:
        shown = None if isinstance(mesh, meshio.Mesh) else str(mesh)
        raise invalid("mesh", shown, str(error)) from None
    if len(volumes.points) > MOST_NODES:
        expected = f"at most {MOST_NODES} nodes; the mesh has {len(volumes.points)}"
        raise invalid("mesh", volumes.name, expected)
    return replace(volumes, points=scale * volumes.points[:, AXES[axis]])


def _places(mesh: VolumeMesh) -> dict[str, list[float]]:
    """Return the position of the node of each group that is nearest to their mean [m]."""
    places = {}
    for name, nodes in mesh.groups.items():
        if len(nodes):
            points = mesh.points[nodes]
            distance = np.linalg.norm(points - points.mean(axis=0), axis=1)
            places[name] = points[distance.argmin()].tolist()
    return places
