"""Arrays of a stage in a result: sufficient to draw and measure its motion."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bladewhirl.meshes.line_mesh import FloatArray, IntArray, absent


@dataclass(frozen=True, kw_only=True)
class StageArrays:
    """Modes, geometry and shapes of both bodies; the rotor is in its rotating axes, at angle 0.

    Modes and contact nodes of separate blades are listed blade by blade. Arrays that a stage does
    not have are empty, and other values are None.
    """

    rotor_frequency: FloatArray  #: natural frequency [rad/s], (rotor modes,)
    rotor_backward_frequency: FloatArray = (
        absent()
    )  #: frequency of the backward wave [rad/s], (rotor modes,)
    rotor_forward_frequency: FloatArray = (
        absent()
    )  #: forward wave [rad/s]; negative past its critical speed
    rotor_nodal_diameter: IntArray = absent()  #: dominant nodal diameter, (rotor modes,)
    rotor_family: tuple[str, ...] = ()  #: "1F", "2F", ..., "suspension", (rotor modes,)
    rotor_spring_share: FloatArray = (
        absent()
    )  #: share of strain energy in the shaft springs, (rotor modes,)
    casing_frequency: FloatArray = absent()  #: natural frequency [rad/s], (casing modes,)
    casing_nodal_diameter: IntArray = absent()  #: dominant nodal diameter, (casing modes,)
    casing_family: tuple[str, ...] = ()  #: "1F", ..., "rigid", (casing modes,)
    rotor_point: FloatArray = absent()  #: undeformed nodes [m], (rotor nodes, 2)
    rotor_line: IntArray = absent()  #: end nodes of each line, (rotor lines, 2)
    rotor_thickness: FloatArray = (
        absent()
    )  #: thickness at the middle of each line [m], (rotor lines,)
    rotor_width: FloatArray = absent()  #: width at the middle of each line [m], (rotor lines,)
    rotor_young_modulus: FloatArray = (
        absent()
    )  #: modulus at the middle of each line [Pa], (rotor lines,)
    rotor_thickness_change: FloatArray = (
        absent()
    )  #: change from first to second end [m], (rotor lines,)
    rotor_width_change: FloatArray = absent()
    """Change from first to second end [m], (rotor lines,)."""
    rotor_young_modulus_change: FloatArray = (
        absent()
    )  #: change from first to second end [Pa], (rotor lines,)
    rotor_part: tuple[str, ...] = ()  #: name of the line set of each line, (rotor lines,)
    rotor_shape: FloatArray = (
        absent()
    )  #: x, y [kg^-1/2], rotation [kg^-1/2/m], (rotor nodes, 3, rotor modes)
    rotor_link: IntArray = absent()  #: led node and leader of each rigid link, (rotor links, 2)
    rotor_spring: IntArray = (
        absent()
    )  #: end nodes of each spring, -1 for the frame, (rotor springs, 2)
    mass_node: IntArray = absent()  #: node of each point mass, (masses,)
    point_mass: FloatArray = absent()  #: mass of each point mass [kg], (masses,)
    tip_node: IntArray = absent()  #: node of each blade tip, (blades,)
    blade: IntArray  #: blade of each contact node, (contact nodes,)
    node: IntArray  #: number of each contact node on its blade, (contact nodes,)
    tip_angle: FloatArray  #: angle of each contact node from +x [rad], (contact nodes,)
    contact_radius: FloatArray  #: radius of each contact node [m], (contact nodes,)
    axial_position: FloatArray  #: axial position of each contact node [m], (contact nodes,)
    tip_recess: FloatArray
    """Reference radius of the clearance minus radius of each contact node [m], (contact nodes,)."""
    tip_growth: FloatArray = absent()  #: static growth of each tip at speed [m], (blades,)
    centre_node: int | None = None
    centre_shape: FloatArray = absent()  #: x and y of the centre [kg^-1/2], (2, rotor modes)
    contact_shape: FloatArray = absent()
    """Radial, tangential and axial displacement of each contact node for unit modal coordinates of
    its copy [kg^-1/2], (contact nodes, 3, modes of a copy)."""
    gauge_shape: FloatArray = absent()
    """Strain of each gauge for unit modal coordinates of a copy [kg^-1/2/m], (gauges, modes of a
    copy), listed blade by blade."""
    gauge_by_force: FloatArray = absent()
    """Strain by unit contact forces on the same copy, without their part in the modes [1/N],
    (copies, distances, gauges of a sector, contact nodes of a sector, 3), see `stress_by_force`."""
    point_number: IntArray = absent()  #: number of each point in its file, (points,)
    stress_shape: FloatArray = absent()
    """Stress at each point for unit modal coordinates of a copy as stiff as the file [Pa
    kg^-1/2/m], (points, 6, modes of a copy): xx, yy, zz, xy, yz and zx in axes that turn with the
    copy, or with the sector."""
    sector_stress_shape: FloatArray = absent()
    """`stress_shape` at the points of the first of equal sectors, in place of it, (points of a
    sector, 6, modes)."""
    stress_by_force: FloatArray = absent()
    """Stress by unit contact forces without their part in the modes [Pa/N], (distances, points of a
    sector, 6, contact nodes of a sector, 3): by radial, tangential and axial forces on the sector
    that is a number of sectors behind. Blades and whole wheels are one sector each."""
    steady_stress: FloatArray = absent()
    """Stress by steady rotation [Pa], (points, 6)."""
    copy_stiffness: FloatArray = absent()
    """Stiffness of each copy divided by that of the file, (copies,)."""
    point_young_modulus: FloatArray = absent()  #: Young's modulus at each point [Pa], (points,)
    point_poisson_ratio: FloatArray = absent()  #: Poisson's ratio at each point, (points,)
    copy_angle: FloatArray = (
        absent()
    )  #: angle of each copy relative to the first one [rad], (copies,)
    point: FloatArray = absent()  #: undeformed points of the first copy [m], (points, 3)
    point_shape: FloatArray = absent()
    """Displacement of each point for unit modal coordinates [kg^-1/2], (points, 3, modes)."""
    sector_point_shape: FloatArray = absent()
    """`point_shape` of the points of the first of equal sectors, in place of it, (points of a
    sector, 3, modes)."""
    mode_wave: IntArray = absent()
    """Nodal diameter of each mode of equal sectors, negative for the sine wave of a pair,
    (modes,)."""
    mode_partner: IntArray = absent()
    """Other mode of the pair, or the single mode itself, of equal sectors, (modes,)."""
    triangle: IntArray = absent()  #: points of each surface triangle, (triangles, 3)
    shaft_frame: str | None = None  #: frame of the shaft's springs, "rotating" or "static"
    shaft_stiffness: FloatArray = absent()  #: stiffness along x and y of `shaft_frame` [N/m], (2,)
    shaft_damping: FloatArray = absent()  #: damping along x and y of rotating axes [N s/m], (2,)
    casing_angle: FloatArray = absent()  #: angle of each node from +x [rad], (casing nodes,)
    casing_thickness: FloatArray = (
        absent()
    )  #: thickness of the element after each node [m], (casing nodes,)
    casing_width: FloatArray = absent()
    """Width of the element after each node [m], (casing nodes,)."""
    casing_young_modulus: FloatArray = absent()  #: modulus after each node [Pa], (casing nodes,)
    casing_curvature: str | None = (
        None  #: bending strain of the wall, "exact" or "shallow" (see `forms`)
    )
    casing_shape: FloatArray = (
        absent()
    )  #: w, dw/ds, u, du/ds of modes, (casing nodes, 4, casing modes)
    casing_foundation: float | None = None  #: uniform elastic support [N/m2]
    support_kind: NDArray[np.str_] = absent()  #: "spring" or "strut", (supports,)
    support_angle: FloatArray = absent()
    """Angle of the foot on the wall from +x [rad], (supports,)."""
    support_reach: FloatArray = (
        absent()
    )  #: vector from foot to ground, static axes [m], (supports, 2)
    support_radial_stiffness: FloatArray = (
        absent()
    )  #: radial stiffness at the foot [N/m], (supports,)
    support_tangential_stiffness: FloatArray = (
        absent()
    )  #: stiffness along the wall [N/m], (supports,)
    support_radial_damping: FloatArray = absent()
    """Radial damping at the foot [N s/m], (supports,)."""
    support_tangential_damping: FloatArray = absent()
    """Damping along the wall [N s/m], (supports,)."""
    modes_speed: float | None = None
    """Speed to which the modes belong [rad/s]; None at constant speed."""
    sudden_changes: int | None = None
    """Number of sudden changes of the rotor that can occur; None without them."""
    critical_speed: FloatArray = absent()
    """Lowest critical speeds [rad/s], ascending, (critical speeds,); absent at constant speed."""
    critical_whirl: NDArray[np.str_] = absent()
    """Whirl at each critical speed: "forward", "backward" or "elliptic", (critical speeds,)."""
    rotor_inertia: float | None = None
    """Moment of inertia of all that turns [kg m2]; None at constant speed, or if it is not
    known."""
    drive_torque: float | None = None
    """Torque of the drive of a free speed [N m]; None if the speed is prescribed."""
    drive_loss: float | None = None
    """Torque of losses of a free speed by speed [N m s]; None if the speed is prescribed."""
    shaft_position: FloatArray = (
        absent()
    )  #: position of each node of a shaft line [m], (shaft nodes,)
    shaft_radius: FloatArray = absent()  #: its outer radius there [m], (shaft nodes,)
    wheel_origin: float | None = None
    """Position along a shaft line of the plane z = 0 of its wheel [m]; None without a wheel."""
    bearing_name: tuple[str, ...] = ()  #: name of each bearing of a shaft line, (bearings,)
    bearing_node: IntArray = absent()  #: its node of the shaft, (bearings,)
    joint_name: tuple[str, ...] = ()  #: name of the joint of each pair of nodes, (pairs,)
    joint_blade: IntArray = absent()  #: blade of each pair, whose next blade it touches, (pairs,)
    joint_end: IntArray = absent()
    """Contact nodes of each pair: on the next blade and on the blade, or a node and -1 for a
    damper, (pairs, 2)."""
    damper_blade: IntArray = absent()  #: blade before each damper, (dampers,)
    joint_gap: FloatArray = absent()  #: gap of each pair without displacements [m], (pairs,)
    joint_axes: FloatArray = absent()
    """Normal and two tangents of each pair: radial, tangential, axial, (pairs, 3, 3)."""
    wheel: IntArray = absent()
    """Wheel of each contact node, if several wheels of a shaft line have a wall, (contact nodes,):
    0 for the first, 1 ... for the further ones in the order of the case."""
    casing_wheel: IntArray = absent()
    """Wheel inside each casing node, if several have a flexible ring, (casing nodes,)."""
    ring_radius: FloatArray = absent()
    """Radius of the ring of each casing node then [m], (casing nodes,)."""
    wall_wheel: IntArray = absent()  #: wheel inside each value of `clearance` then, (angles,)
    support_wheel: IntArray = absent()  #: wheel inside the ring of each support then, (supports,)
    further_centre_shape: FloatArray = absent()
    """`centre_shape` of each further wheel of a shaft line, (further wheels, 2, rotor modes)."""
    further_point: FloatArray = absent()
    """`point` of all further wheels, in the axes of the first [m], (further points, 3)."""
    further_point_shape: FloatArray = absent()
    """`point_shape` there [kg^-1/2], (further points, 3, rotor modes)."""
    further_point_wheel: IntArray = absent()
    """Wheel of each of these points, 1 ... as in `wheel`, (further points,)."""
    further_triangle: IntArray = absent()  #: points of each triangle, (further triangles, 3)
    wall_angle: FloatArray  #: angle of each value of `clearance` from +x [rad], (angles,)
    clearance: FloatArray  #: clearance at rest [m], (angles,)

    @property
    def stored(self) -> Mapping[str, NDArray[Any]]:
        """Arrays that the stage has, by name."""
        given = {name: value for name, value in vars(self).items() if value is not None}
        return {name: values for name in given if (values := np.asarray(given[name])).size}
