"""Compute, from finite element models and modes, the arrays that describe a stage in a result.

The class of these arrays is in `stage_arrays`, so that solvers can import it without
finite elements.
"""

from typing import Any

import numpy as np

from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.casing import ALONG, OUTWARD, CasingModel
from bladewhirl.models.modal.labels import LabelledModes
from bladewhirl.models.modal.modes import Modes
from bladewhirl.models.modal.stage_arrays import StageArrays
from bladewhirl.models.rotation.at_speed import tip_recess

DRAWN = (
    *("thickness", "width", "young_modulus"),
    *("thickness_change", "width_change", "young_modulus_change"),
)
"""Properties of lines in a result; a result contains only the first three for a casing."""


def stage_arrays(
    case: Case,
    disk: BladedDiskModel,
    disk_modes: Modes,
    disk_family: tuple[str, ...],
    **wall: Any,
) -> StageArrays:
    """Return the arrays of a stage with given modes of bladed disk and casing.

    Args:
        case: case of the stage.
        disk: the bladed disk at the speed of the case.
        disk_modes: modes of the full or the reduced bladed disk, with fields on the free DoF.
        disk_family: family of each mode of the bladed disk, (rotor modes,).
        wall: arrays of the wall by name: `casing_arrays` of a flexible casing, `wall_angle` and
            `clearance`.
    """
    model, mesh, shaft, tips = disk.model, disk.mesh, case.shaft, disk.mesh.node_sets["tips"]
    shape, centre = disk.cartesian(disk_modes.shapes), int(mesh.node_sets["centre"][0])
    return StageArrays(
        rotor_frequency=disk_modes.frequency,
        rotor_backward_frequency=disk_modes.frequency,
        rotor_forward_frequency=disk_modes.frequency,
        rotor_nodal_diameter=disk_modes.nodal_diameter,
        rotor_family=disk_family,
        rotor_spring_share=disk_modes.spring_share,
        rotor_point=mesh.points,
        rotor_line=mesh.lines,
        **{f"rotor_{name}": getattr(disk.properties, name) for name in DRAWN},
        rotor_part=tuple(mesh.line_parts),
        rotor_shape=shape,
        rotor_link=np.column_stack([model.links.led, model.links.leader]),
        rotor_spring=np.column_stack([model.springs.node, model.springs.other]),
        mass_node=model.masses.node,
        point_mass=model.masses.mass,
        tip_node=tips,
        blade=np.arange(len(tips)),
        node=np.zeros(len(tips), dtype=np.int64),
        contact_radius=np.linalg.norm(mesh.points[tips], axis=1),
        axial_position=np.zeros(len(tips)),
        tip_angle=disk.tip_angles,
        tip_recess=tip_recess(case, disk),
        tip_growth=disk.growth(),
        centre_node=centre,
        centre_shape=shape[centre, :2],
        shaft_frame=shaft.frame,
        shaft_stiffness=np.zeros(2) if shaft.clamped else np.array(shaft.springs),
        shaft_damping=np.zeros(2) if shaft.clamped else np.array(shaft.dampings),
        **wall,
    )


def casing_arrays(casing: CasingModel, modes: LabelledModes) -> dict[str, Any]:
    """Return the arrays of a flexible casing in a result, by name.

    Args:
        casing: the casing.
        modes: its modes.
    """
    supports = casing.supports
    stiffness = np.array([np.diag(each.stiffness) for each in supports]).reshape(-1, 3)
    damping = np.array([(each.dampers**2).sum(axis=0) for each in supports]).reshape(-1, 3)
    return {
        "casing_frequency": modes.frequency,
        "casing_nodal_diameter": modes.nodal_diameter,
        "casing_family": modes.family,
        "casing_angle": casing.mesh.angles,
        **{f"casing_{name}": getattr(casing.properties, name) for name in DRAWN[:3]},
        "casing_curvature": casing.curvature,
        "casing_shape": casing.nodal(modes.fields(np.arange(modes.count))),
        "casing_foundation": casing.foundation,
        "support_kind": np.array([each.kind for each in supports], dtype=np.str_),
        "support_angle": np.array([each.angle for each in supports], dtype=np.float64),
        "support_reach": np.array([each.reach for each in supports], dtype=float).reshape(-1, 2),
        "support_radial_stiffness": stiffness[:, OUTWARD],
        "support_tangential_stiffness": stiffness[:, ALONG],
        "support_radial_damping": damping[:, OUTWARD],
        "support_tangential_damping": damping[:, ALONG],
    }
