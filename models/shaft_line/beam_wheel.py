"""A wheel of beams on a shaft line.

Beams move in the plane of rotation, with the hub along x and y and about z. Out of this plane the
wheel moves with its hub as a rigid body: along z, and in tilt about x and y, with the moments of
inertia of beams of their width.
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.elements.bladed_disk import (
    COMPONENTS,
    ROTATION,
    BeamMatrices,
    assemble_bladed_disk,
)
from bladewhirl.models.elements.build import case_beam_model
from bladewhirl.models.elements.export import to_cartesian, wheel_superelement
from bladewhirl.models.geometry.beam_model import BeamModel
from bladewhirl.models.inputs.errors import Fault
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.models.shaft_line.hub_waves import UNEQUAL_BLADES
from bladewhirl.models.superelements.hub import WAVES, inner_dofs, rigid_body
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError

SPRINGS = Fault(
    expected="a disk of beams or a rigid one, whose rotation about its axis strains nothing;"
    " springs between its nodes keep their directions"
)

OUT_OF_PLANE = [2, 3, 4]  #: displacements of the hub along z and about x and y


class BeamWheel(NamedTuple):
    """A wheel of beams with a hub at its centre."""

    part: Superelement
    bases: dict[int, sp.csc_array]
    """Fields of nodal diameter 0 and 1 on the coordinates that are not those of the hub."""


def beam_wheel(case: Case) -> BeamWheel:
    """Return the bladed disk of beams of a case as a wheel.

    Raises:
        CaseError: parts do not fit together, or tips reach into the casing.
        SuperelementError: the blades differ, or springs connect nodes.
    """
    model = case_beam_model(case)
    if model.springs.node.size:
        raise SuperelementError(SPRINGS)
    held = case.shaft.stiffnesses[0]
    disk = assemble_bladed_disk(
        model, shaft_stiffness=held, clamped=False, torsion_stiffness=held * model.tip_radius**2
    )
    flat = wheel_superelement(replace(disk, structure=rotation_matrices(disk)), case.title)
    rigid = rigid_mass(model)
    forms = {"mass": rigid, "stiffness": 0.0 * rigid} | rigid_body(rigid)
    blocks = {name: form[np.ix_(OUT_OF_PLANE, OUT_OF_PLANE)] for name, form in forms.items()}
    x, y = disk.mesh.points.T
    moved = np.zeros((len(x), 3, len(OUT_OF_PLANE)))
    moved[:, 2] = np.column_stack([np.ones(len(x)), y, -x])
    own = flat.size + np.arange(len(OUT_OF_PLANE))
    about_z = disk.structure.node_dofs[model.centre, ROTATION]
    layout = disk.structure.layout
    if layout is None or not layout.is_symmetry_of(disk.structure.mass, disk.structure.stiffness):
        raise SuperelementError(UNEQUAL_BLADES)
    turn, fields = to_cartesian(disk, disk.model.tips).T, layout.sector_dofs.shape[1]
    loads: dict[str, Any] = {
        name: np.append(load, np.zeros(len(own)))
        for name, load in flat.given(("centrifugal_load", "euler_load")).items()
    }
    part = replace(
        flat,
        **{
            name: sp.csr_array(sp.block_diag([form, blocks[name]]))
            for name, form in flat.given(tuple(blocks)).items()
        },
        **loads,
        recovery=sp.csr_array(sp.hstack([flat.recovery, moved.reshape(3 * len(x), -1)])),
        centre_dofs=None,
        hub_dofs=np.array([*disk.centre, *own, about_z]),
        hub_position=np.zeros(3),
        sectors=len(model.tips),
    )
    inner = inner_dofs(part)
    bases = {k: sp.csc_array((turn @ layout.basis(k))[inner, :fields]) for k in WAVES}
    return BeamWheel(part, bases)


def rigid_mass(model: BeamModel) -> FloatArray:
    """Return the mass matrix of a bladed disk of beams on the rigid motions with its centre, (6,
    6); beams have their width along z, and no extent in the plane beside their axis."""
    beams, mesh, masses = BeamMatrices(model), model.mesh, model.masses
    first, last = (mesh.points[ends][:, None] for ends in mesh.lines.T)
    share = beams.assembler.points[:, None]
    x, y = np.moveaxis((1.0 - share) * first + share * last, 2, 0)
    z_square = beams.sections.width**2 / 12.0
    along = np.zeros(beams.assembler.node_dofs.size)  # all nodes move by 1 along one axis
    along.reshape(-1, COMPONENTS)[:, :ROTATION] = np.stack(
        [np.cos(mesh.node_axes), -np.sin(mesh.node_axes)], axis=1
    )
    at_x, at_y = mesh.points[masses.node].T
    one = np.ones_like(x)

    def moment(of_beams: FloatArray, of_points: FloatArray) -> float:
        return float(along @ (beams.mass(of_beams) @ along) + masses.mass @ of_points)

    total = moment(one, np.ones_like(at_x))
    of_x, of_y = moment(x, at_x), moment(y, at_y)
    xx, xy, yy = moment(x * x, at_x**2), moment(x * y, at_x * at_y), moment(y * y, at_y**2)
    zz = moment(z_square, 0.0 * at_x)
    spin = float(masses.inertia.sum())
    lever = np.array([[0.0, 0.0, of_y], [0.0, 0.0, -of_x], [-of_y, of_x, 0.0]])
    rotary = np.array([[yy + zz, -xy, 0.0], [-xy, xx + zz, 0.0], [0.0, 0.0, xx + yy + spin]])
    return np.block([[total * np.eye(3), lever.T], [lever, rotary]])
