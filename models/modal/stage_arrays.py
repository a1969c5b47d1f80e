"""Arrays of a stage in a result: sufficient to draw and measure every motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class StageArrays:
    """Modes, geometry and shapes of both bodies; the rotor in its rotating axes at angle 0."""

    rotor_frequency: FloatArray  #: [rad/s], (rotor modes,)
    rotor_backward_frequency: FloatArray  #: of the wave, with Coriolis forces [rad/s], likewise
    rotor_forward_frequency: FloatArray  #: the same forward; negative past its critical speed
    rotor_nodal_diameter: IntArray  #: (rotor modes,)
    rotor_family: tuple[str, ...]  #: "1F", "2F", ..., "suspension", (rotor modes,)
    rotor_spring_share: FloatArray  #: share of strain energy in the shaft springs, (rotor modes,)
    casing_frequency: FloatArray  #: [rad/s], (casing modes,)
    casing_nodal_diameter: IntArray  #: (casing modes,)
    casing_family: tuple[str, ...]  #: "1F", ..., "rigid", (casing modes,)
    rotor_point: FloatArray  #: undeformed nodes [m], (rotor nodes, 2)
    rotor_line: IntArray  #: end nodes of each line, (rotor lines, 2)
    rotor_thickness: FloatArray  #: in the plane, at the middle of each [m], (rotor lines,)
    rotor_width: FloatArray  #: out of the plane, likewise [m], (rotor lines,)
    rotor_young_modulus: FloatArray  #: likewise [Pa], (rotor lines,)
    rotor_thickness_change: FloatArray  #: from the first to the second end [m], (rotor lines,)
    rotor_width_change: FloatArray  #: likewise [m], (rotor lines,)
    rotor_young_modulus_change: FloatArray  #: likewise [Pa], (rotor lines,)
    rotor_part: tuple[str, ...]  #: set that each line belongs to, (rotor lines,)
    rotor_shape: FloatArray  #: x, y [kg^-1/2], rotation [kg^-1/2/m], (rotor nodes, 3, rotor modes)
    rotor_link: IntArray  #: node that a rigid arm leads, and its leader, (rotor links, 2)
    rotor_spring: IntArray  #: nodes of each spring, the second -1 for the frame, (rotor springs, 2)
    mass_node: IntArray  #: node of each point mass, (masses,)
    point_mass: FloatArray  #: [kg], (masses,)
    tip_node: IntArray  #: (blades,)
    tip_angle: FloatArray  #: from +x [rad], (blades,)
    tip_recess: FloatArray  #: radius that the clearance counts from less theirs [m], (blades,)
    tip_growth: FloatArray  #: static, at speed [m], (blades,)
    centre_node: int
    shaft_frame: str  #: frame of the shaft's springs, "rotating" or "static"
    shaft_stiffness: (
        FloatArray  #: their stiffness along its x and y, empty for a clamped centre [N/m], (2,)
    )
    shaft_damping: FloatArray  #: of dampers along the rotating x and y, likewise [N s/m], (2,)
    casing_angle: FloatArray  #: of each node from +x [rad], (casing nodes,)
    casing_thickness: FloatArray  #: of element i, from node i to the next [m], (casing nodes,)
    casing_width: FloatArray  #: of the same, out of the plane [m], (casing nodes,)
    casing_young_modulus: FloatArray  #: of the same [Pa], (casing nodes,)
    casing_curvature: str  #: bending strain of the wall, "exact" or "shallow" (see `elements`)
    casing_shape: FloatArray  #: w, dw/ds, u, du/ds, (casing nodes, 4, casing modes)
    casing_foundation: float  #: uniform elastic support [N/m2]
    support_kind: NDArray[np.str_]  #: "spring" or "strut", (supports,)
    support_angle: FloatArray  #: of its foot on the wall from +x [rad], (supports,)
    support_reach: FloatArray  #: from foot to ground, 0 of springs, static axes [m], (supports, 2)
    support_radial_stiffness: FloatArray  #: at the foot [N/m], (supports,)
    support_tangential_stiffness: FloatArray  #: the same along the wall
    support_radial_damping: FloatArray  #: at the foot [N s/m], (supports,)
    support_tangential_damping: FloatArray  #: the same along the wall
    clearance: FloatArray  #: at each casing node [m], (casing nodes,)
