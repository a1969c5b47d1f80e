"""Superelements from matrices of CalculiX, Matrix Market and MATLAB."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import scipy.io as sio
import scipy.sparse as sp
from faults import fault
from places import ROOT
from solid_meshes import SECTORS, bladed_sector, cantilever

from bladewhirl.models.imports.importing import import_superelement, imported
from bladewhirl.models.imports.inspection import inspect, negative_eigenvalues
from bladewhirl.models.inputs.errors import Hint
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.superelements.superelement import FIXED, Superelement, SuperelementError

DATA = ROOT / "tests" / "data" / "solids"
"""matrices.inp is the cantilever of tetrahedra with 2 x 1 x 1 boxes, rotating; see calculix.py."""

STEEL: dict[str, Any] = {"young_modulus": "210 GPa", "poisson_ratio": 0.3, "density": 7800.0}
TIP: dict[str, Any] = {"contact": "tip"}


def blade() -> Superelement:
    return mesh3d(cantilever("tetra", (2, 1, 1)), **STEEL, mass_quadrature="reduced")


@pytest.fixture
def tables(tmp_path: Path) -> Path:
    """Write the blade in N, mm, t and s as Matrix Market, .mat and two tables of nodes."""
    mesh, part = cantilever("tetra", (2, 1, 1)), blade()
    for name, matrix in (("k", part.stiffness), ("m", part.mass)):
        sio.mmwrite(tmp_path / f"{name}.mtx", 1e-3 * sp.coo_array(matrix))
    model = {"M": 1e-3 * part.mass, "K": 1e-3 * part.stiffness, "n": 24.0}
    sio.savemat(tmp_path / "a.mat", {"model": model, "alpha": 1.0})
    free = [["node,x,y,z,group"], ["node,x,y,z,row_x,row_y,row_z,group"]]
    row = 0
    for number, (x, y, z) in enumerate(1e3 * mesh.points, 101):
        held = number - 101 in mesh.point_sets["root"]
        group = "tip blade" if number - 101 in mesh.point_sets["tip"] else "blade"
        if not held:
            free[0].append(f"{number},{x},{y},{z},{group}")
        rows = "0,0," if held else f"{row + 1},{row + 2},{row + 3}"
        free[1].append(f"{number},{x},{y},{z},{rows},{group}")
        row += 3 * (not held)
    for name, lines in zip(("order", "rows"), free, strict=True):
        (tmp_path / f"{name}.csv").write_text("\n".join(lines))
    return tmp_path


def test_matrices_of_calculix_are_those_of_mesh3d_at_speed() -> None:
    speed = json.loads((DATA / "calculix.json").read_text())["speed"]
    mesh = cantilever("tetra", (2, 1, 1))
    expected = mesh3d(mesh, **STEEL, mass_quadrature="reduced", speed=speed)
    part, actual, total = imported(DATA / "matrices.inp", **TIP)
    for mine, theirs in ((expected.mass, part.mass), (expected.stiffness, part.stiffness)):
        assert abs(mine - theirs).max() < 1e-10 * abs(mine).max()
    assert part.contact_position == pytest.approx(expected.contact_position, abs=1e-12)
    assert np.array_equal(part.contact_dofs, expected.contact_dofs)
    assert actual.rigid_modes == 0
    assert total == pytest.approx([expected.mass.sum() / 3.0] * 3)
    assert part.points is not None
    assert part.triangles is not None
    assert len(part.triangles) == 2 * (4 * 2 + 2)  # two on each face of a box outside


@pytest.mark.parametrize("nodes", ["order", "rows"])
@pytest.mark.parametrize("files", [("k.mtx", "m.mtx"), ("a.mat", None)])
def test_matrices_with_a_table_of_nodes_are_converted(
    tables: Path, nodes: str, files: tuple[str, str | None]
) -> None:
    mass = None if files[1] is None else tables / files[1]
    units: dict[str, Any] = {"length_unit": "mm", "mass_unit": "t"}
    part = import_superelement(
        tables / files[0], mass=mass, nodes=tables / f"{nodes}.csv", **TIP, **units
    )
    expected = blade()
    assert abs(part.stiffness - expected.stiffness).max() < 1e-12 * abs(expected.stiffness).max()
    assert abs(part.mass - expected.mass).max() < 1e-12 * abs(expected.mass).max()
    assert part.contact_position == pytest.approx(expected.contact_position)
    assert np.array_equal(part.contact_dofs, expected.contact_dofs)


@pytest.mark.parametrize("head", [True, False])
def test_empty_rows_are_left_out_and_one_triangle_is_enough(tables: Path, head: bool) -> None:
    """Six rows for each node of a solid, as of Nastran; those of its rotations are empty."""
    expected = blade()
    spread = sp.kron(sp.eye_array(expected.size // 3), np.eye(3, 6), format="csr")
    for name in ("stiffness", "mass"):
        whole = spread.T @ getattr(expected, name) @ spread
        triangle = sp.coo_array(sp.triu(whole))
        if head:
            sio.mmwrite(tables / f"{name}.mtx", triangle, symmetry="general")
        else:
            entries = zip(triangle.row + 1, triangle.col + 1, triangle.data, strict=True)
            text = "".join(f"{i} {j} {value:.17g}\n" for i, j, value in entries)
            (tables / f"{name}.mtx").write_text(text)
    lines = (tables / "rows.csv").read_text().splitlines()
    table = [lines[0]]
    for number, *place, x, y, z, group in (line.split(",") for line in lines[1:]):
        rows = [
            str(2 * int(row) - (int(row) - 1) % 3 - 1) if int(row or 0) else "" for row in (x, y, z)
        ]
        table.append(",".join([number, *(str(1e-3 * float(v)) for v in place), *rows, group]))
    (tables / "six.csv").write_text("\n".join(table))
    files: dict[str, Any] = {"mass": tables / "mass.mtx", "nodes": tables / "six.csv"}
    part = import_superelement(tables / "stiffness.mtx", **files, **TIP)
    lost = expected.size if head else expected.size - 3  # without a head, the last are unknown
    assert part.source == f"stiffness.mtx and mass.mtx, without {lost} empty rows"
    assert part.name == "stiffness.mtx and mass.mtx"
    assert abs(part.stiffness - expected.stiffness).max() < 1e-12 * abs(expected.stiffness).max()
    assert abs(part.mass - expected.mass).max() < 1e-12 * abs(expected.mass).max()
    assert np.array_equal(part.contact_dofs, expected.contact_dofs)


def test_nodes_are_chosen_by_position_and_included_files_are_read(tables: Path) -> None:
    units: dict[str, Any] = {"nodes": tables / "rows.csv", "length_unit": "mm", "mass_unit": "t"}
    expected = import_superelement(tables / "a.mat", **TIP, **units)
    part = import_superelement(tables / "a.mat", contact="r > 299.9 mm", **units)
    assert np.array_equal(part.contact_dofs, expected.contact_dofs)
    with pytest.raises(SuperelementError, match=r"contact r > 1 kg: expected .* is \[mass\]"):
        import_superelement(tables / "a.mat", contact="r > 1 kg", **units)
    folder = tables / "deck"
    folder.mkdir()
    for file in DATA.glob("matrices.*"):
        shutil.copy(file, folder)
    shutil.move(folder / "matrices.inp", tables / "all.inc")
    (folder / "matrices.inp").write_text("*INCLUDE, INPUT=../all.inc\n")
    part = import_superelement(folder / "matrices.inp", contact="outermost", outside_files=True)
    expected = import_superelement(DATA / "matrices.inp", **TIP)
    assert np.array_equal(part.contact_dofs, expected.contact_dofs)
    assert part.triangles is not None
    with pytest.raises(SuperelementError, match=r"not \.\./all\.inc; outside_files = True"):
        import_superelement(folder / "matrices.inp", **TIP)


def test_axes_and_node_numbers(tables: Path) -> None:
    """An axis x of the program becomes z; x, y and z displacements go along."""
    part = import_superelement(
        tables / "a.mat",
        nodes=tables / "rows.csv",
        contact="112,109",
        length_unit="mm",
        mass_unit="t",
        axis="x",
    )
    expected = blade()
    chosen = [3, 0]
    turned = expected.contact_position[chosen][:, [1, 2, 0]]
    assert part.contact_position == pytest.approx(turned)
    assert np.array_equal(part.contact_dofs, expected.contact_dofs[chosen][:, [1, 2, 0]])


def test_nodes_are_clamped_that_the_program_left_free(tmp_path: Path) -> None:
    mesh, free = cantilever("tetra", (2, 1, 1)), "node,x,y,z"
    part = mesh3d(mesh, **STEEL, mass_quadrature="reduced", clamped=None)
    for name, matrix in (("k", part.stiffness), ("m", part.mass)):
        entries = sp.coo_array(sp.tril(matrix))  # as of Abaqus: row, column and value
        lines = zip(entries.row + 1, entries.col + 1, entries.data, strict=True)
        (tmp_path / f"{name}.mtx").write_text("".join(f"{i}, {j}, {v:.17g}\n" for i, j, v in lines))
    rows = [f"{node + 1},{x},{y},{z}" for node, (x, y, z) in enumerate(mesh.points)]
    (tmp_path / "nodes.csv").write_text("\n".join([free, *rows]))
    numbers = {key: ",".join(map(str, nodes + 1)) for key, nodes in mesh.point_sets.items()}
    again = import_superelement(
        tmp_path / "k.mtx",
        mass=tmp_path / "m.mtx",
        nodes=tmp_path / "nodes.csv",
        contact=numbers["tip"],
        clamped=numbers["root"],
    )
    expected = blade()
    assert abs(again.stiffness - expected.stiffness).max() < 1e-12 * abs(expected.stiffness).max()
    assert abs(again.mass - expected.mass).max() < 1e-12 * abs(expected.mass).max()
    assert np.array_equal(again.contact_dofs, expected.contact_dofs)


def test_a_matlab_file_may_state_all_itself(tmp_path: Path) -> None:
    part = blade()
    content = {"contact_position": part.contact_position, "contact_dofs": part.contact_dofs}
    sio.savemat(tmp_path / "a.mat", {"M": part.mass, "K": part.stiffness, **content})
    again = import_superelement(tmp_path / "a.mat", name="rotor 37")
    assert again.name == "rotor 37"
    assert np.array_equal(again.contact_dofs, part.contact_dofs)
    assert abs(again.stiffness - part.stiffness).max() == 0.0


def test_faces_of_an_imported_sector_are_matched(tmp_path: Path) -> None:
    mesh = bladed_sector("hexahedron")
    tie: dict[str, Any] = {"left": "left", "right": "right", "copies": SECTORS}
    part = mesh3d(mesh, **STEEL, **tie)
    sio.savemat(tmp_path / "a.mat", {"M": part.mass, "K": part.stiffness})
    lines, row = ["node,x,y,z,row_x,row_y,row_z,group"], 0
    for node, (x, y, z) in enumerate(mesh.points):
        groups = [name for name, nodes in mesh.point_sets.items() if node in nodes]
        rows = "0,0,0" if "root" in groups else f"{row + 1},{row + 2},{row + 3}"
        row += 3 * ("root" not in groups)
        lines.append(f"{node},{x},{y},{z},{rows},{' '.join(groups)}")
    (tmp_path / "nodes.csv").write_text("\n".join(lines))
    again = import_superelement(tmp_path / "a.mat", nodes=tmp_path / "nodes.csv", **TIP, **tie)
    for mine, theirs in ((again.left_dofs, part.left_dofs), (again.right_dofs, part.right_dofs)):
        assert mine is not None
        assert theirs is not None
        assert np.array_equal(mine, theirs)
        assert FIXED not in mine


def test_partners_of_fixed_nodes_are_clamped(tmp_path: Path) -> None:
    """The program has fixed the root but for the nodes of one face, which depend on the other."""
    mesh = bladed_sector("hexahedron")
    tie: dict[str, Any] = {"left": "left", "right": "right", "copies": SECTORS}
    expected = mesh3d(mesh, **STEEL, **tie)
    face = np.intersect1d(mesh.point_sets["root"], mesh.point_sets["right"])
    root = np.setdiff1d(mesh.point_sets["root"], face)
    part = mesh3d(replace_sets(mesh, root=root), **STEEL, clamped="root")
    sio.savemat(tmp_path / "a.mat", {"M": part.mass, "K": part.stiffness})
    lines, row = ["node,x,y,z,row_x,row_y,row_z,group"], 0
    for node, (x, y, z) in enumerate(mesh.points):
        groups = [name for name, nodes in mesh.point_sets.items() if node in nodes]
        rows = "0,0,0" if node in root else f"{row + 1},{row + 2},{row + 3}"
        row += 3 * (node not in root)
        lines.append(f"{node},{x},{y},{z},{rows},{' '.join(groups)}")
    (tmp_path / "nodes.csv").write_text("\n".join(lines))
    again = import_superelement(tmp_path / "a.mat", nodes=tmp_path / "nodes.csv", **TIP, **tie)
    note = f"{len(face)} nodes clamped like their partners on the other face"
    assert again.source == f"a.mat, {note}"
    assert str(again.left_dofs) == str(expected.left_dofs)
    assert str(again.right_dofs) == str(expected.right_dofs)
    assert np.array_equal(again.contact_dofs, expected.contact_dofs)
    assert abs(again.stiffness - expected.stiffness).max() == 0.0


def replace_sets(mesh: meshio.Mesh, **sets: Any) -> meshio.Mesh:
    return meshio.Mesh(mesh.points, mesh.cells, point_sets=mesh.point_sets | sets)


def test_negative_eigenvalues_are_counted() -> None:
    noise = np.random.default_rng(0).standard_normal((40, 40))
    for values in (np.ones(40), np.repeat([1.0, -0.5], [37, 3]), np.repeat([1.0, 0.0], [34, 6])):
        basis = np.linalg.qr(noise)[0]
        matrix = basis @ (values[:, None] * basis.T)
        matrix = 0.5 * (matrix + matrix.T)
        assert (matrix.diagonal() > 0.0).all()
        for given in (matrix, sp.csr_array(matrix)):
            assert negative_eigenvalues(given) == np.count_nonzero(values < 0.0)


def test_rigid_modes_are_counted_and_left_out() -> None:
    part = mesh3d(cantilever("tetra10", (2, 1, 1)), **STEEL, clamped=None)
    actual = inspect(part)
    assert actual.rigid_modes == 6
    assert actual.frequencies[0] > 1000.0
    assert len(actual.frequencies) == 10


@pytest.mark.parametrize(
    ("mass", "stiffness", "expected"),
    [
        (1e-12, 1.0, "perhaps the density is in t/mm3 beside lengths in m"),
        (1.0, 1e6, "perhaps Young's modulus is in Pa beside lengths in mm"),
        (1.0, 1e-11, "perhaps Young's modulus is in GPa beside lengths in m"),
        (1e9, 1.0, "perhaps lengths are in mm beside Young's modulus in Pa"),
        (1e-20, 1.0, "got 4.078e[+]13 Hz$"),
    ],
)
def test_inconsistent_units_are_named(mass: float, stiffness: float, expected: str) -> None:
    part = blade()
    scaled = replace(part, mass=mass * part.mass, stiffness=stiffness * part.stiffness)
    with pytest.raises(SuperelementError, match="expected a first frequency from 1 Hz to 50 kHz"):
        inspect(scaled)
    with pytest.raises(SuperelementError, match=expected):
        inspect(scaled)


def test_indefinite_and_unstable_matrices_are_refused() -> None:
    part = blade()
    signs = sp.lil_array(part.mass)
    signs[0, 3] = signs[3, 0] = 3.0 * signs[0, 0]
    with pytest.raises(SuperelementError, match=r"mass: expected no negative .* has 1"):
        inspect(replace(part, mass=sp.csr_array(signs)))
    soft = part.stiffness - (2.0 * np.pi * 5000.0) ** 2 * part.mass
    with pytest.raises(SuperelementError, match=r"stiffness: expected (no neg|a stable)"):
        inspect(replace(part, stiffness=soft))


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("matrices.inp", {"contact": "top"}), "a group of matrices.inp of CalculiX: all, every"),
        (("matrices.inp", {"contact": "root"}), "nodes that are not clamped; 4 of 4 are"),
        (("matrices.inp", {"contact": "3,99"}), "has no node 99"),
        (("matrices.inp", {}), "expected contact nodes"),
        (("matrices.inp", {**TIP, "mass": "m.mtx"}), "mass and nodes are not allowed"),
        (("matrices.inp", {**TIP, "axis": "r"}), "axis r: expected x, y or z"),
        (("matrices.inp", {**TIP, "length_unit": "km"}), "got 300.3 m; give the units"),
        (("matrices.inp", {**TIP, "mass_unit": "m"}), "a unit of mass such as"),
        (("k.mtx", TIP), "expected a table of nodes"),
        (("k.mtx", {**TIP, "nodes": "rows.csv"}), "expected the mass too"),
        (("k.mtx", {**TIP, "nodes": "short.csv", "mass": "m.mtx"}), "are not the displacements"),
        (("k.mtx", {**TIP, "nodes": "rows.csv", "mass": "no.mtx"}), "expected a readable file"),
        (("a.mat", {}), "contact_position, contact_dofs"),
        (("empty.mat", {**TIP, "nodes": "rows.csv"}), "expected matrices K and M"),
        (("missing.inp", TIP), "missing.sti, missing.mas, missing.dof in the same folder"),
        (("a.mat", {**TIP, "nodes": "long.csv"}), "line 2: node: expected a whole number"),
        (
            ("a.mat", {**TIP, "nodes": "low.csv"}),
            "line 2: node: expected a whole",
        ),
        (("a.mat", {**TIP, "nodes": "far.csv"}), "line 2: x: expected a finite number"),
        (("long.inp", TIP), "a whole number, got '9999"),
        (("matrices.inp", {"contact": "9" * 5000}), "9999 ... 9999"),
    ],
)
def test_what_cannot_be_right_is_refused(
    tables: Path, words: tuple[str, dict[str, str]], expected: str
) -> None:
    for file in DATA.glob("matrices.*"):
        shutil.copy(file, tables)
    shutil.copy(DATA / "matrices.inp", tables / "missing.inp")
    sio.savemat(tables / "empty.mat", {"a": 1.0})
    (tables / "short.csv").write_text("node,x,y,z\n1,0,0,0\n")
    number = "9" * 30
    (tables / "long.csv").write_text(f"node,x,y,z\n{number},0,0,0\n")
    (tables / "far.csv").write_text("node,x,y,z\n1,1e40,0,0\n")
    (tables / "low.csv").write_text("node,x,y,z\n1_0,0,0,0\n")
    (tables / "long.inp").write_text(f"*NODE\n{number}, 0, 0, 0\n")
    name, choice = words
    files: Any = {key: tables / value for key, value in choice.items() if key in ("mass", "nodes")}
    with pytest.raises(SuperelementError) as caught:
        import_superelement(tables / name, **{**choice, **files})
    assert expected in str(caught.value)
    assert len(caught.value.lines) == 1


@pytest.mark.parametrize("text", ["1.99999999999999999999999999", "x.1", "1.1.1", "1"])
def test_displacements_of_calculix_are_whole_numbers(tables: Path, text: str) -> None:
    for file in DATA.glob("matrices.*"):
        shutil.copy(file, tables)
    (tables / "matrices.dof").write_text(text)
    assert "lines of node and direction" in fault(
        import_superelement, tables / "matrices.inp", **TIP
    )


def test_a_damping_matrix_that_feeds_energy_is_refused() -> None:
    part = blade()
    signs = sp.lil_array(part.mass)
    signs[0, 3] = signs[3, 0] = 3.0 * signs[0, 0]
    with pytest.raises(SuperelementError, match=r"damping: expected no negative .* has 1"):
        inspect(replace(part, damping=sp.csr_array(signs)))


@pytest.mark.parametrize(("factor", "unit"), [(1e-3, "g/cm3"), (1e3, "")])
def test_a_mass_too_small_for_the_nodes_is_named(tables: Path, factor: float, unit: str) -> None:
    """The stiffness is scaled too, so that the frequencies are plausible."""
    part = blade()
    sio.savemat(tables / "a.mat", {"M": factor * part.mass, "K": factor * part.stiffness})
    table = (tables / "rows.csv").read_text().splitlines()
    lines = [table[0]]
    for line in table[1:]:
        number, *place = line.split(",")[:4]
        metres = [str(1e-3 * float(value)) for value in place]
        lines.append(",".join([number, *metres, *line.split(",")[4:]]))
    (tables / "metres.csv").write_text("\n".join(lines))
    found = imported(tables / "a.mat", nodes=tables / "metres.csv", **TIP)[1].hints
    assert len(found) == bool(unit)
    if unit:
        assert f"is in {unit}" in found[0]
        with pytest.warns(Hint, match="unusual mass = .* kg in the hull of the nodes"):
            import_superelement(tables / "a.mat", nodes=tables / "metres.csv", **TIP)
