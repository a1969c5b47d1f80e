"""Arrays of a superelement in a result: sufficient to draw and measure every motion."""

from dataclasses import dataclass

from bladewhirl.meshes.line_mesh import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class SuperelementArrays:
    """Modes, contact nodes, points and wall; contact nodes of all copies, copy by copy."""

    modal_frequency: FloatArray  #: natural frequency [rad/s], (copies, modes)
    blade: IntArray  #: blade of each contact node, (contact nodes,)
    node: IntArray  #: number of each contact node on its blade, (contact nodes,)
    contact_angle: FloatArray  #: angle from +x at t = 0 [rad], (contact nodes,)
    contact_radius: FloatArray  #: [m], (contact nodes,)
    contact_axial: FloatArray  #: axial position [m], (contact nodes,)
    contact_recess: FloatArray
    """Distance of each contact node inside the radius from which the clearance is measured [m],
    (contact nodes,)."""
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
