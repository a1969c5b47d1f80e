"""Arrays of a stage or a superelement in a result: sufficient to draw and measure its motion."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class StageArrays:
    """Modes, geometry and shapes of both bodies; the rotor is in its rotating axes, at angle 0."""

    rotor_frequency: FloatArray  #: natural frequency [rad/s], (rotor modes,)
    rotor_backward_frequency: FloatArray  #: frequency of the backward wave [rad/s], (rotor modes,)
    rotor_forward_frequency: FloatArray  #: forward wave [rad/s]; negative past its critical speed
    rotor_nodal_diameter: IntArray  #: dominant nodal diameter, (rotor modes,)
    rotor_family: tuple[str, ...]  #: "1F", "2F", ..., "suspension", (rotor modes,)
    rotor_spring_share: FloatArray  #: share of strain energy in the shaft springs, (rotor modes,)
    casing_frequency: FloatArray  #: natural frequency [rad/s], (casing modes,)
    casing_nodal_diameter: IntArray  #: dominant nodal diameter, (casing modes,)
    casing_family: tuple[str, ...]  #: "1F", ..., "rigid", (casing modes,)
    rotor_point: FloatArray  #: undeformed nodes [m], (rotor nodes, 2)
    rotor_line: IntArray  #: end nodes of each line, (rotor lines, 2)
    rotor_thickness: FloatArray  #: thickness at the middle of each line [m], (rotor lines,)
    rotor_width: FloatArray  #: width at the middle of each line [m], (rotor lines,)
    rotor_young_modulus: FloatArray  #: modulus at the middle of each line [Pa], (rotor lines,)
    rotor_thickness_change: FloatArray  #: change from first to second end [m], (rotor lines,)
    rotor_width_change: FloatArray  #: change from first to second end [m], (rotor lines,)
    rotor_young_modulus_change: FloatArray  #: change from first to second end [Pa], (rotor lines,)
    rotor_part: tuple[str, ...]  #: name of the line set of each line, (rotor lines,)
    rotor_shape: FloatArray  #: x, y [kg^-1/2], rotation [kg^-1/2/m], (rotor nodes, 3, rotor modes)
    rotor_link: IntArray  #: led node and leader of each rigid link, (rotor links, 2)
    rotor_spring: IntArray  #: end nodes of each spring, -1 for the frame, (rotor springs, 2)
    mass_node: IntArray  #: node of each point mass, (masses,)
    point_mass: FloatArray  #: mass of each point mass [kg], (masses,)
    tip_node: IntArray  #: node of each blade tip, (blades,)
    tip_angle: FloatArray  #: angle of each tip from +x [rad], (blades,)
    tip_recess: FloatArray  #: reference radius of the clearance minus tip radius [m], (blades,)
    tip_growth: FloatArray  #: static growth of each tip at speed [m], (blades,)
    centre_node: int
    shaft_frame: str  #: frame of the shaft's springs, "rotating" or "static"
    shaft_stiffness: FloatArray  #: stiffness along x and y of `shaft_frame` [N/m], (2,)
    shaft_damping: FloatArray  #: damping along x and y of rotating axes [N s/m], (2,)
    casing_angle: FloatArray  #: angle of each node from +x [rad], (casing nodes,)
    casing_thickness: FloatArray  #: thickness of the element after each node [m], (casing nodes,)
    casing_width: FloatArray  #: width of the element after each node [m], (casing nodes,)
    casing_young_modulus: FloatArray  #: modulus after each node [Pa], (casing nodes,)
    casing_curvature: str  #: bending strain of the wall, "exact" or "shallow" (see `forms`)
    casing_shape: FloatArray  #: w, dw/ds, u, du/ds of modes, (casing nodes, 4, casing modes)
    casing_foundation: float  #: uniform elastic support [N/m2]
    support_kind: NDArray[np.str_]  #: "spring" or "strut", (supports,)
    support_angle: FloatArray  #: angle of the foot on the wall from +x [rad], (supports,)
    support_reach: FloatArray  #: vector from foot to ground, static axes [m], (supports, 2)
    support_radial_stiffness: FloatArray  #: radial stiffness at the foot [N/m], (supports,)
    support_tangential_stiffness: FloatArray  #: stiffness along the wall [N/m], (supports,)
    support_radial_damping: FloatArray  #: radial damping at the foot [N s/m], (supports,)
    support_tangential_damping: FloatArray  #: damping along the wall [N s/m], (supports,)
    clearance: FloatArray  #: clearance at each casing node [m], (casing nodes,)


@dataclass(frozen=True, kw_only=True)
class SuperelementArrays:
    """Modes, contact nodes, points and wall. The contact nodes of all copies are listed copy by
    copy."""

    modal_frequency: FloatArray  #: natural frequency [rad/s], (copies, modes)
    blade: IntArray  #: blade of each contact node, (contact nodes,)
    node: IntArray  #: number of each contact node on its blade, (contact nodes,)
    contact_angle: FloatArray  #: angle from +x at t = 0 [rad], (contact nodes,)
    contact_radius: FloatArray  #: [m], (contact nodes,)
    contact_axial: FloatArray  #: axial position [m], (contact nodes,)
    contact_recess: FloatArray
    """Distance by which each contact node lies inside the radius from which the clearance is
    measured [m], (contact nodes,)."""
    copy_angle: FloatArray  #: angle of each copy relative to the first one [rad], (copies,)
    point: FloatArray  #: undeformed points of the first copy [m], (points, 3)
    point_shape: FloatArray
    """Displacement of each point for unit modal coordinates [kg^-1/2], (points, 3, modes)."""
    triangle: IntArray  #: points of each surface triangle, (triangles, 3)
    wall_angle: FloatArray  #: angles of `clearance` [rad], (wall angles,)
    clearance: FloatArray  #: clearance at rest [m], (wall angles,)
    casing_frequency: FloatArray
    """Natural frequency of each mode of a flexible casing [rad/s], (casing modes,). The arrays of
    the casing are empty for a rigid wall."""
    casing_nodal_diameter: IntArray  #: nodal diameter of each casing mode, (casing modes,)
    casing_angle: FloatArray  #: angle of each casing node from +x [rad], (casing nodes,)
    casing_thickness: FloatArray  #: thickness of the element after each node [m], (casing nodes,)
    casing_width: FloatArray  #: width of the element after each node [m], (casing nodes,)
    casing_shape: FloatArray  #: w, dw/ds, u, du/ds of modes, (casing nodes, 4, casing modes)


Arrays = StageArrays | SuperelementArrays
"""Arrays of a stage in a result."""
