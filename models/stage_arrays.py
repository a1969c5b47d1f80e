"""A stage as a result describes it: arrays alone, enough to draw and to measure every motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.bladed_disk import BladedDisk
from bladewhirl.models.casing import Casing
from bladewhirl.models.modes import Modes


@dataclass(frozen=True, kw_only=True)
class StageArrays:
    """Modes, geometry and shapes of both bodies; the rotor in its rotating axes at angle 0."""

    rotor_frequency: FloatArray  #: [rad/s], (rotor modes,)
    rotor_nodal_diameter: IntArray  #: (rotor modes,)
    rotor_family: tuple[str, ...]  #: "1F", "2F", ..., "suspension", (rotor modes,)
    rotor_spring_share: FloatArray  #: share of strain energy in the shaft springs, (rotor modes,)
    casing_frequency: FloatArray  #: [rad/s], (casing modes,)
    casing_nodal_diameter: IntArray  #: (casing modes,)
    casing_family: tuple[str, ...]  #: "1F", ..., "rigid", (casing modes,)
    rotor_point: FloatArray  #: undeformed nodes [m], (rotor nodes, 2)
    rotor_line: IntArray  #: end nodes of each line, (rotor lines, 2)
    rotor_thickness: FloatArray  #: in the plane [m], (rotor lines,)
    rotor_part: tuple[str, ...]  #: set that each line belongs to, (rotor lines,)
    rotor_shape: FloatArray  #: x, y [kg^-1/2], rotation [kg^-1/2/m], (rotor nodes, 3, rotor modes)
    tip_node: IntArray  #: (blades,)
    tip_angle: FloatArray  #: from +x [rad], (blades,)
    centre_node: int
    casing_angle: FloatArray  #: of each node from +x [rad], (casing nodes,)
    casing_thickness: FloatArray  #: of element i, from node i to the next [m], (casing nodes,)
    casing_shape: FloatArray  #: w, dw/ds, u, du/ds, (casing nodes, 4, casing modes)
    clearance: FloatArray  #: at each casing node [m], (casing nodes,)


def stage_arrays(
    disk: BladedDisk,
    disk_modes: Modes,
    disk_family: tuple[str, ...],
    casing: Casing,
    casing_modes: Modes,
    casing_family: tuple[str, ...],
    *,
    clearance: FloatArray,
) -> StageArrays:
    """Describe two bodies by some of their modes.

    Args:
        disk: the bladed disk.
        disk_modes: of it, full or reduced, with fields on its free degrees of freedom.
        disk_family: of each of them, (rotor modes,).
        casing: the casing.
        casing_modes: of it.
        casing_family: of each of them, (casing modes,).
        clearance: at each casing node [m], (casing nodes,).
    """
    mesh = disk.mesh
    return StageArrays(
        rotor_frequency=disk_modes.frequency,
        rotor_nodal_diameter=disk_modes.nodal_diameter,
        rotor_family=disk_family,
        rotor_spring_share=disk_modes.spring_share,
        casing_frequency=casing_modes.frequency,
        casing_nodal_diameter=casing_modes.nodal_diameter,
        casing_family=casing_family,
        rotor_point=mesh.points,
        rotor_line=mesh.lines,
        rotor_thickness=disk.properties.thickness,
        rotor_part=tuple(mesh.line_parts),
        rotor_shape=disk.cartesian(disk_modes.shapes),
        tip_node=mesh.node_sets["tips"],
        tip_angle=disk.tip_angles,
        centre_node=int(mesh.node_sets["centre"][0]),
        casing_angle=casing.mesh.angles,
        casing_thickness=np.full(casing.mesh.elements, casing.section.thickness),
        casing_shape=casing.nodal(casing_modes.shapes),
        clearance=clearance,
    )
