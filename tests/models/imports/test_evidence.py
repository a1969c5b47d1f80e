"""Evidence in matrices that their rows belong to the nodes of the table."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io as sio
import scipy.sparse as sp
from solid_meshes import bladed_sector, cantilever

from bladewhirl.models.imports.importing import imported
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.superelements.superelement import Superelement, SuperelementError

STEEL: dict[str, Any] = {"young_modulus": "210 GPa", "poisson_ratio": 0.3, "density": 7800.0}
BY_AXIS, BY_NODE = "by axis", "by node"


def hints(
    folder: Path,
    mesh: Any,
    part: Superelement,
    *,
    order: str = BY_NODE,
    rows: bool = False,
    nodes: Any = None,
    **choice: Any,
) -> tuple[str, ...]:
    """Write matrices and a table of the nodes that have rows; return the hints of their import.

    Args:
        folder: folder of the files.
        mesh: mesh of the part.
        part: matrices.
        order: order of the rows of the matrices.
        rows: whether the table claims that the rows are x, y and z node by node.
        nodes: nodes in the order of the table; those that have rows by default.
        choice: arguments of the import.
    """
    free = np.setdiff1d(np.arange(len(mesh.points)), mesh.point_sets["root"])
    shown = np.arange(len(mesh.points)) if part.size == mesh.points.size else free
    place = np.arange(part.size)
    if order == BY_AXIS:
        place = place.reshape(-1, 3).T.ravel()
    for name, matrix in (("k", part.stiffness), ("m", part.mass)):
        sio.mmwrite(folder / f"{name}.mtx", sp.coo_array(sp.csr_array(matrix)[place][:, place]))
    lines = ["node,x,y,z,group" + ",row_x,row_y,row_z" * rows]
    for number, node in enumerate(shown if nodes is None else nodes):
        x, y, z = mesh.points[node]
        group = next((name for name, inside in mesh.point_sets.items() if node in inside), "")
        mine = "".join(f",{3 * number + axis}" for axis in (1, 2, 3)) * rows
        lines.append(f"{node},{x},{y},{z},{group}{mine}")
    (folder / "nodes.csv").write_text("\n".join(lines))
    files: dict[str, Any] = {"mass": folder / "m.mtx", "nodes": folder / "nodes.csv"}
    return imported(folder / "k.mtx", contact="tip", **files, **choice)[1].hints


MESHES = {
    "tetra": cantilever("tetra", (2, 1, 1)),
    "hexahedron20": cantilever("hexahedron20", (3, 2, 1)),
    "sector": bladed_sector("hexahedron"),
}


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@pytest.mark.parametrize("rows", [True, False])
@pytest.mark.parametrize("clamped", [None, "root"])
def test_rows_in_the_order_x_y_z_of_all_nodes_are_refused(
    tmp_path: Path, mesh: Any, rows: bool, clamped: str | None
) -> None:
    """The nodes to clamp are still in the matrices, or their program has left them out."""
    part = mesh3d(mesh, **STEEL, clamped=clamped)
    choice: dict[str, Any] = {} if clamped else {"clamped": "root"}
    assert hints(tmp_path, mesh, part, rows=rows, **choice) == ()
    with pytest.raises(SuperelementError, match="are x of all nodes, then y, then z: write their"):
        hints(tmp_path, mesh, part, rows=rows, order=BY_AXIS, **choice)


def test_nodes_in_another_order_than_the_matrices_are_named(tmp_path: Path) -> None:
    mesh = MESHES["hexahedron20"]
    part = mesh3d(mesh, **STEEL, clamped=None)
    shuffled = np.random.default_rng(0).permutation(len(mesh.points))
    found = hints(tmp_path, mesh, part, nodes=shuffled, clamped="root")
    assert [one for one in found if one.startswith("K times a rotation is not zero")]


def test_supported_matrices_and_rigid_modes_of_a_clamped_part_are_named(tmp_path: Path) -> None:
    mesh = MESHES["tetra"]
    part = mesh3d(mesh, **STEEL, clamped=None)
    corner = np.zeros(part.size)
    corner[-3:] = 1e9
    supported = Superelement(
        mass=part.mass,
        stiffness=sp.csr_array(part.stiffness + sp.diags_array(corner)),
        contact_position=part.contact_position,
        contact_dofs=part.contact_dofs,
    )
    [found] = hints(tmp_path, mesh, supported, clamped="root")
    assert found.startswith("K times a translation is not zero")
    mesh.point_sets["hinge"] = mesh.point_sets["root"][:1]
    mesh.point_sets["root"] = mesh.point_sets["root"][1:]
    [found] = hints(tmp_path, mesh, part, clamped=str(mesh.point_sets["hinge"][0]))
    assert found.startswith("unusual 3 rigid modes of a clamped part: expected none")


def test_masses_that_differ_by_direction_are_named(tmp_path: Path) -> None:
    mesh = cantilever("tetra", (2, 1, 1))
    part = mesh3d(mesh, **STEEL, clamped=None)
    slides = np.arange(part.size) % 3 == 0
    slides &= np.isin(np.arange(part.size) // 3, mesh.point_sets["root"])
    kept = np.flatnonzero(~slides)
    for name, matrix in (("k", part.stiffness), ("m", part.mass)):
        sio.mmwrite(tmp_path / f"{name}.mtx", sp.coo_array(sp.csr_array(matrix)[kept][:, kept]))
    row = np.where(slides, 0, np.cumsum(~slides)).reshape(-1, 3)
    lines = ["node,x,y,z,row_x,row_y,row_z,group"]
    for node, place in enumerate(mesh.points):
        group = "tip" if node in mesh.point_sets["tip"] else ""
        lines.append(",".join(map(str, [node, *place, *row[node], group])))
    (tmp_path / "nodes.csv").write_text("\n".join(lines))
    files: dict[str, Any] = {"mass": tmp_path / "m.mtx", "nodes": tmp_path / "nodes.csv"}
    [found] = imported(tmp_path / "k.mtx", contact="tip", **files)[1].hints
    assert found.startswith("unusual masses along x, y and z = 0.")
