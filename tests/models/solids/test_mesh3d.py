"""Superelements from meshes of solids, against CalculiX and closed forms."""

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import pyvista
from long_cases import slow_except
from places import ROOT
from solid_meshes import (
    CALCULIX,
    SECTORS,
    STEEL,
    TIE,
    bladed_sector,
    cantilever,
    deck,
    deck_text,
    half_cantilever,
    joined,
    wheel_frequencies,
)

from bladewhirl.meshes.cells import CELL_TYPES
from bladewhirl.meshes.files.abaqus_faces import SOLIDS
from bladewhirl.meshes.files.volumes import read_volume_mesh
from bladewhirl.models.inputs.errors import CaseError, Hint
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.solids.surface import evenly_along_chord
from bladewhirl.models.superelements.frequencies import lowest_frequencies
from bladewhirl.models.superelements.superelement import SuperelementError

BLADE = ROOT / "tests" / "data" / "solids" / "blade.msh"
"""A blade in mm; blade.py made the file with Gmsh."""


@pytest.mark.parametrize("element", SOLIDS)
def test_frequencies_of_a_blade_are_those_of_calculix(element: str, tmp_path: Path) -> None:
    path = deck(tmp_path, cantilever(SOLIDS[element]), element)
    part = mesh3d(path, **STEEL, mass_quadrature="reduced")
    actual = lowest_frequencies(part.mass, part.stiffness, 10)
    assert actual == pytest.approx(CALCULIX["blade"][element], rel=1e-6)


@pytest.mark.parametrize("element", SOLIDS)
def test_frequencies_of_a_rotating_blade_are_those_of_calculix(
    element: str, tmp_path: Path
) -> None:
    speed, path = CALCULIX["speed"], deck(tmp_path, cantilever(SOLIDS[element]), element)
    part = mesh3d(path, **STEEL, mass_quadrature="reduced", speed=speed)
    actual = lowest_frequencies(part.mass, part.stiffness, 10)
    assert actual == pytest.approx(CALCULIX["rotating blade"][element], rel=1e-6)


def test_wedges_among_hexahedra_are_those_of_calculix(tmp_path: Path) -> None:
    halves = (("wedge15", False), ("hexahedron20", True))
    mesh = joined(*(half_cantilever(kind, outer=outer) for kind, outer in halves))
    path = tmp_path / "deck.inp"
    path.write_text(deck_text(mesh, "C3D15", "C3D20R"))
    part = mesh3d(path, **STEEL, mass_quadrature="reduced")
    actual = lowest_frequencies(part.mass, part.stiffness, 10)
    assert actual == pytest.approx(CALCULIX["wedges and hexahedra"], rel=1e-6)
    assert "12 elements C3D15, 6 elements C3D20R" in part.source
    assert part.points is not None
    assert part.triangles is not None
    corners = part.points[part.triangles]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2.0
    volume = np.einsum("ti,ti", areas, corners[:, 0]) / 3.0
    assert volume == pytest.approx(0.1 * 0.03 * 0.005)


@pytest.mark.parametrize("element", sorted(SOLIDS.keys() - {"C3D8R"}))
@pytest.mark.parametrize("speed", slow_except([0.0, CALCULIX["speed"]], CALCULIX["speed"]))
def test_frequencies_of_a_wheel_about_x_are_those_of_calculix(
    element: str, speed: float, tmp_path: Path
) -> None:
    mesh = bladed_sector(SOLIDS[element])
    mesh.points = mesh.points[:, [2, 0, 1]]
    path = deck(tmp_path, mesh, element)
    part = mesh3d(path, **STEEL, **TIE, mass_quadrature="reduced", speed=speed, axis="x")
    expected = np.array(CALCULIX["rotating sector" if speed else "sector"][element])
    actual = wheel_frequencies(part, SECTORS, 10)
    assert actual == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("kind", CELL_TYPES)
def test_solids_resist_no_rigid_motion_and_have_the_energy_of_uniform_strain(kind: str) -> None:
    noise = np.random.default_rng(0)
    mesh = cantilever(kind, (2, 1, 1))
    mesh.points += 2e-4 * noise.standard_normal(mesh.points.shape)
    part = mesh3d(mesh, **STEEL, clamped=None)
    x = mesh.points
    rigid = [np.cross(axis, x).ravel() for axis in np.eye(3)]
    assert np.array(rigid) @ part.stiffness == pytest.approx(0.0, abs=1e-12 * 2.1e11)
    gradient = noise.standard_normal((3, 3))
    moved, strain = (x @ gradient.T).ravel(), 0.5 * (gradient + gradient.T)
    shear, lame = 2.1e11 / 2.6, 2.1e11 * 0.3 / (1.3 * 0.4)
    density = 2.0 * shear * (strain**2).sum() + lame * np.trace(strain) ** 2
    along = np.tile([1.0, 0.0, 0.0], len(x))
    volume = along @ mesh3d(mesh, **STEEL, clamped=None).mass @ along / 7800.0
    close = {"tetra10": 1e-3, "wedge15": 1e-3}.get(kind, 1e-12)  # few points for a curved cell
    assert moved @ part.stiffness @ moved == pytest.approx(volume * density, rel=close)


def test_elements_of_reduced_integration_have_the_mass_of_calculix(tmp_path: Path) -> None:
    """The quadrature of the mass is by default that of the name."""
    for element, close in (("C3D8R", 2e-2), ("C3D20R", 1e-6), ("C3D20", 1e-6)):
        part = mesh3d(deck(tmp_path, cantilever(SOLIDS[element]), element), **STEEL)
        actual = lowest_frequencies(part.mass, part.stiffness, 10)
        assert actual == pytest.approx(CALCULIX["blade"][element], rel=close)
        assert abs(actual / CALCULIX["blade"]["C3D8"][:10] - 1.0).max() > 0.1


@pytest.mark.parametrize(
    ("element", "expected"),
    [
        ("C3D8R", "parallelepipeds as elements C3D8R; 9 of 9 are distorted"),
        ("C3D8H", "found 9 of type C3D8H; write C3D8 or C3D8I or C3D8R if that is what you mean"),
    ],
)
def test_elements_that_would_be_another_element_are_refused(
    element: str, expected: str, tmp_path: Path
) -> None:
    with pytest.raises(CaseError) as caught:
        mesh3d(deck(tmp_path, bladed_sector("hexahedron"), element), **STEEL)
    assert expected in str(caught.value)


def split(mesh: meshio.Mesh) -> meshio.Mesh:
    """Return a mesh in which each cell has nodes of its own at the places of those of others, up to
    a rounding error."""
    cells = mesh.cells[0].data
    points = mesh.points[cells.ravel()]
    points += 1e-9 * np.random.default_rng(0).standard_normal(points.shape)
    own = np.arange(cells.size).reshape(cells.shape)
    sets = {name: np.flatnonzero(np.isin(cells, m)) for name, m in mesh.point_sets.items()}
    return meshio.Mesh(points, [(mesh.cells[0].type, own)], point_sets=sets)


def test_coincident_nodes_are_merged_or_kept_apart_on_request() -> None:
    mesh = cantilever("hexahedron20", (3, 2, 1))
    parted = split(mesh)
    number = len(parted.points) - len(mesh.points)
    expected = mesh3d(mesh, **STEEL)
    note = f"{number} nodes merged with others within 1e-06 m"
    with pytest.warns(Hint, match=f"{note}: merge = 0 keeps them apart"):
        part = mesh3d(parted, **STEEL)
    assert note in part.source
    assert part.size == expected.size
    assert part.contacts == expected.contacts
    assert lowest_frequencies(part.mass, part.stiffness, 6) == pytest.approx(
        lowest_frequencies(expected.mass, expected.stiffness, 6), rel=1e-5
    )
    assert mesh3d(parted, **STEEL, merge=0).size == 3 * (
        len(parted.points) - len(parted.point_sets["root"])
    )
    with pytest.warns(Hint, match="within 2e-09 m"):
        some = mesh3d(parted, **STEEL, merge="2 nm")
    assert expected.size < some.size < mesh3d(parted, **STEEL, merge=0).size
    with pytest.raises(CaseError, match='merge = "-1 mm": expected a distance'):
        mesh3d(parted, **STEEL, merge="-1 mm")


@pytest.mark.parametrize("side", ["left", "right"])
def test_partners_of_clamped_nodes_are_clamped(side: str) -> None:
    """Nodes of one face are left out of the clamped set, as in a deck with a cyclic tie."""
    mesh = bladed_sector("hexahedron20")
    expected = mesh3d(mesh, **STEEL, **TIE)
    face = np.intersect1d(mesh.point_sets["root"], mesh.point_sets[side])
    mesh.point_sets["root"] = np.setdiff1d(mesh.point_sets["root"], face)
    note = f"{len(face)} nodes clamped like their partners on the other face"
    with pytest.warns(Hint, match=note):
        part = mesh3d(mesh, **STEEL, **TIE)
    assert note in part.source
    assert str(part.left_dofs) == str(expected.left_dofs)
    assert abs(part.stiffness - expected.stiffness).max() == 0.0
    mesh.point_sets["tip"] = np.append(mesh.point_sets["tip"], face)
    with pytest.raises(CaseError, match=r"contact: expected nodes that are not clamped; 3 of"):
        mesh3d(mesh, **STEEL, **TIE)


def test_cells_that_lie_on_others_are_refused() -> None:
    mesh = cantilever("tetra")
    cells, count = mesh.cells[0].data, len(mesh.points)
    twice = meshio.Mesh(
        np.concatenate([mesh.points, mesh.points]),
        [("tetra", np.concatenate([cells, cells + count]))],
        point_sets=mesh.point_sets,
    )
    with pytest.raises(CaseError, match=r"72 of 144 elements C3D4 lie on others"):
        mesh3d(twice, **STEEL)


def test_any_number_of_nodes_at_one_place_is_merged() -> None:
    """The number of compared pairs would be 50 million; cells without volume are refused."""
    mesh = cantilever("tetra")
    points = np.concatenate([mesh.points, np.full((10_002, 3), 0.25)])
    cells = np.concatenate(
        [mesh.cells[0].data, len(mesh.points) + np.arange(10_000).reshape(-1, 4)]
    )
    crowd = meshio.Mesh(points, [("tetra", cells)], point_sets=mesh.point_sets)
    with pytest.raises(CaseError, match=r"of 2572 elements C3D4 lie on others"):
        mesh3d(crowd, **STEEL)


DATA = ROOT / "tests" / "data" / "solids"

TWO = (DATA / "two_materials.inp").read_text()


def frequency_of(folder: Path, text: str, **given: Any) -> float:
    (folder / "deck.inp").write_text(text)
    part = mesh3d(folder / "deck.inp", **given)
    return float(lowest_frequencies(part.mass, part.stiffness, 1)[0])


def test_materials_of_sections_are_those_of_calculix(tmp_path: Path) -> None:
    expected = CALCULIX["two materials"]
    assert frequency_of(tmp_path, TWO) == pytest.approx(expected, rel=1e-6)
    by_set = {"young_modulus": {"Outer": "10 GPa"}}  # the square of the first frequency is between
    raised = frequency_of(tmp_path, TWO, **by_set)
    assert 1.01 * expected < raised < np.sqrt(10.0) * expected
    one = {"young_modulus": 4 * 1.1e11, "poisson_ratio": 0.3, "density": 4400.0}
    with pytest.warns(Hint, match=r"young_modulus = 440000000000.0 is only for cells without"):
        assert frequency_of(tmp_path, TWO, **one) == pytest.approx(expected, rel=1e-6)
    bare = TWO[: TWO.index("*MATERIAL")]
    double = frequency_of(tmp_path, bare, **one)
    titanium = frequency_of(tmp_path, bare, **one | {"young_modulus": 1.1e11})
    assert double == pytest.approx(2.0 * titanium, rel=1e-9)


def test_materials_of_a_deck_in_mm_need_the_unit_of_mass(tmp_path: Path) -> None:
    head, tail = TWO.split("*NODE, NSET=all\n")[1].split("*ELEMENT", 1)
    rows = [[float(value) for value in line.split(",")] for line in head.splitlines()]
    nodes = "".join(f"{n:.0f}, {1e3 * x}, {1e3 * y}, {1e3 * z}\n" for n, x, y, z in rows)
    text = f"*NODE\n{nodes}*ELEMENT{tail}".replace("4400", "4.4e-9").replace("\n200\n", "\n2e-10\n")
    text = text.replace("1.1e11", "1.1e5").replace("1e9", "1e3")
    expected = pytest.approx(CALCULIX["two materials"], rel=1e-6)
    assert frequency_of(tmp_path, text, length_unit="mm", mass_unit="t") == expected
    with pytest.raises(CaseError, match="mass_unit: expected the unit of mass"):
        frequency_of(tmp_path, text, length_unit="mm")


@pytest.mark.parametrize(
    ("old", "new", "given", "expected"),
    [
        ("*DENSITY\n200\n", "", {}, "a value for 4 of 8 cells; material foam .* lacks \\*DENSITY"),
        (
            *(
                "*ELASTIC\n1e9, 0.3",
                "*ELASTIC, TYPE=ORTHO\n1e9, 1e9, 1e9, 1e9, 1e9, 1e9, 1e9, 1e9\n1e9",
            ),
            {},
            "young_modulus: .* has \\*ELASTIC, TYPE=ORTHO, which is not read",
        ),
        ("1e9, 0.3", "1e9, 0.3, 20\n9e8, 0.3, 200", {}, "\\*ELASTIC for several temperatures"),
        ("NAME=foam", "NAME=sponge", {}, "\\*MATERIAL, NAME=foam, which a \\*SOLID SECTION names"),
        (
            "",
            "",
            {"density": {"rim": 9.0}},
            'density = "rim": expected a group of cells of deck.inp: blade, inner',
        ),
    ],
)
def test_materials_that_are_not_read_are_named(
    old: str, new: str, given: Any, expected: str, tmp_path: Path
) -> None:
    with pytest.raises(CaseError, match=expected):
        frequency_of(tmp_path, TWO.replace(old, new), **given)


def test_elements_of_first_order_are_called_too_stiff() -> None:
    with pytest.warns(Hint, match="elements C3D8 of first order are too stiff in bending"):
        mesh3d(cantilever("hexahedron", (2, 1, 1)), **STEEL)


def test_a_body_at_rest_in_the_static_frame_needs_no_force() -> None:
    """In axes that turn at 1 rad/s it moves as q(t) with q' = -e_z x q and q'' = -q."""
    part = mesh3d(cantilever("tetra", (2, 1, 1)), **STEEL, clamped=None, coriolis=True)
    resting = np.tile([0.3, -0.8, 0.0], part.size // 3)
    moving = -np.tile([0.8, 0.3, 0.0], part.size // 3)
    assert part.gyroscopic is not None
    force = part.mass @ -resting + part.gyroscopic @ moving - part.mass @ resting  # centrifugal
    assert force == pytest.approx(0.0, abs=1e-15)


def test_the_surface_is_closed_and_recovered() -> None:
    for kind in CELL_TYPES:
        part = mesh3d(bladed_sector(kind), **STEEL)
        assert part.points is not None
        assert part.triangles is not None
        corners = part.points[part.triangles]
        areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2.0
        assert areas.sum(axis=0) == pytest.approx(0.0, abs=1e-15)
        assert np.einsum("ti,ti", areas, corners[:, 0]) > 0.0  # normals point outward
    assert part.recovery is not None
    tip = part.recovery @ np.eye(part.size)[part.contact_dofs[0, 1]]
    assert np.count_nonzero(tip) == 1
    assert part.points is not None
    assert part.points[tip.argmax() // 3] == pytest.approx(part.contact_position[0])


def test_chosen_contact_nodes_are_spread_along_the_chord() -> None:
    part = mesh3d(cantilever("tetra10"), **STEEL, contacts=5)
    steps = np.linalg.norm(np.diff(part.contact_position, axis=0), axis=1)
    assert steps == pytest.approx(0.03 / 4)


@pytest.mark.parametrize("kind", ["tetra10", "hexahedron"])
def test_chosen_contact_nodes_are_numbered_along_the_axis(kind: str) -> None:
    """The order of the nodes in the group does not matter, as in a table of an import."""
    part = mesh3d(cantilever(kind), **STEEL)
    axial = part.contact_position[:, 2]
    nodes = np.arange(part.contacts)
    first = evenly_along_chord(part.contact_position, nodes, 3)
    assert np.all(np.diff(axial[first]) > 0.0)
    for seed in range(5):
        shuffled = np.random.default_rng(seed).permutation(nodes)
        chosen = evenly_along_chord(part.contact_position, shuffled, 3)
        assert np.all(np.diff(axial[chosen]) > 0.0)
    assert evenly_along_chord(part.contact_position, nodes[:1], 1).tolist() == [0]


def test_units_axes_and_files_give_the_same_blade(tmp_path: Path) -> None:
    mesh = cantilever("tetra10")
    part = mesh3d(mesh, **STEEL, speed="100 rad/s")
    turned = meshio.Mesh(1e3 * mesh.points[:, [2, 0, 1]], mesh.cells)
    for name, nodes in mesh.point_sets.items():
        turned.point_data[name] = np.isin(np.arange(len(mesh.points)), nodes).astype(np.int64)
    turned.field_data["TimeValue"] = np.array([0.0])  # as ParaView writes
    turned.write(tmp_path / "blade.vtu")
    again = mesh3d(tmp_path / "blade.vtu", **STEEL, length_unit="mm", axis="x", speed=100.0)
    assert again.contact_position == pytest.approx(part.contact_position)
    assert abs(again.stiffness - part.stiffness).max() < 1e-9 * abs(part.stiffness).max()
    assert abs(again.mass - part.mass).max() < 1e-12 * abs(part.mass).max()


def test_a_mesh_of_gmsh_and_one_of_calculix_are_read(tmp_path: Path) -> None:
    gmsh = mesh3d(BLADE, **STEEL, length_unit="mm")
    whole = mesh3d(BLADE, **STEEL, length_unit="mm", clamped=None)
    along = np.tile([1.0, 0.0, 0.0], whole.size // 3)
    assert along @ whole.mass @ along == pytest.approx(7800.0 * 0.1 * 0.03 * 0.005)
    first = lowest_frequencies(gmsh.mass, gmsh.stiffness, 1)
    beam = 1.8751**2 / (2.0 * np.pi * 0.1**2) * 0.005 * np.sqrt(2.1e11 / (12.0 * 7800.0))
    assert first == pytest.approx(beam, rel=0.05)  # a plate of 30 mm is stiffer than a beam
    mesh = meshio.read(BLADE)
    cells = mesh.cells_dict["tetra10"]
    lines = ["*NODE"]
    lines += [f"{n}, {x!r}, {y!r}, {z!r}" for n, (x, y, z) in enumerate(mesh.points.tolist(), 11)]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=Volume")
    for number, row in enumerate((cells + 11).tolist(), 1):
        lines += [", ".join(map(str, [number, *row[:6]])) + ",", ", ".join(map(str, row[6:]))]
    for name, place in (("Nroot", 200.0), ("Ntip", 300.0)):
        chosen = np.flatnonzero(abs(mesh.points[:, 0] - place) < 1e-9) + 11
        lines += [f"*NSET, NSET={name}", *(f"{node}," for node in chosen)]
    (tmp_path / "blade.inp").write_text("\n".join(lines))
    part = mesh3d(
        tmp_path / "blade.inp", **STEEL, length_unit="mm", clamped="NROOT", contact="NTIP"
    )
    assert part.size == gmsh.size
    assert lowest_frequencies(part.mass, part.stiffness, 1) == pytest.approx(first)


def test_groups_of_gmsh_without_a_name_have_their_number(tmp_path: Path) -> None:
    """A physical group without a name, in both versions, as Gmsh writes it."""
    mesh = cantilever("hexahedron", (2, 1, 1))
    faces = mesh.cells[0].data[[0, 1]][:, [[0, 3, 7, 4], [1, 2, 6, 5]]][[0, 1], [0, 1]]
    cells = [("hexahedron", mesh.cells[0].data), ("quad", faces)]
    tags = [np.array([7, 7]), np.array([2, 3])]
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    numbered = meshio.Mesh(mesh.points, cells, cell_data=data)
    numbered.field_data["tip"] = np.array([3, 2])
    numbered.write(tmp_path / "blade.msh", file_format="gmsh22")
    expected = mesh3d(mesh, **STEEL)
    part = mesh3d(tmp_path / "blade.msh", **STEEL, clamped="surface 2")
    assert abs(part.stiffness - expected.stiffness).max() < 1e-12 * abs(expected.stiffness).max()
    assert np.array_equal(part.contact_dofs, expected.contact_dofs)
    del numbered.field_data["tip"]
    numbered.write(tmp_path / "blade.msh", file_format="gmsh22")
    with pytest.raises(CaseError, match=r"of blade\.msh: surface 2, surface 3, volume 7; or"):
        mesh3d(tmp_path / "blade.msh", **STEEL, clamped="surface 7")


def test_groups_of_gmsh_4_without_a_name_have_their_number(tmp_path: Path) -> None:
    head, rest = BLADE.read_text().split("$PhysicalNames\n")
    (tmp_path / "blade.msh").write_text(head + rest.split("$EndPhysicalNames\n")[1])
    expected, named = read_volume_mesh(tmp_path / "blade.msh"), read_volume_mesh(BLADE)
    for name, same in (("surface 1", "root"), ("surface 2", "tip")):
        assert np.array_equal(expected.groups[name], named.groups[same])


@pytest.mark.parametrize("binary", [True, False])
def test_files_of_pyvista_with_text_and_truth_values_are_read(tmp_path: Path, binary: bool) -> None:
    mesh = cantilever("hexahedron", (3, 1, 1))
    cells = mesh.cells[0].data
    grid = pyvista.UnstructuredGrid(
        np.column_stack([np.full(len(cells), 8), cells]).ravel(),
        np.full(len(cells), 12),
        mesh.points,
    )
    for name, nodes in mesh.point_sets.items():
        grid.point_data[name] = np.isin(np.arange(len(mesh.points)), nodes)
    grid.point_data["label"] = np.array(["a", "<b/>"])[np.arange(len(mesh.points)) % 2]
    grid.point_data["number"] = np.arange(len(mesh.points))
    grid.cell_data["inner"] = np.array([True, False, False])
    grid.field_data["note"] = ["a longer text", "another"]
    grid.save(tmp_path / "blade.vtu", binary=binary)
    volumes = read_volume_mesh(tmp_path / "blade.vtu")
    assert set(volumes.groups) == {"root", "tip", "inner"}
    assert volumes.cell_groups["inner"].tolist() == [0]
    part, expected = mesh3d(tmp_path / "blade.vtu", **STEEL), mesh3d(mesh, **STEEL)
    assert abs(part.stiffness - expected.stiffness).max() < 1e-9 * abs(expected.stiffness).max()
    assert np.array_equal(part.contact_dofs, expected.contact_dofs)


def test_long_lists_of_groups_are_cut() -> None:
    mesh = cantilever("tetra", (2, 1, 1))
    mesh.point_sets |= {f"set {n:03}": np.array([n % 9]) for n in range(100)}
    with pytest.raises(CaseError, match=r"root, set 000, .*set 018 and 82 more; or"):
        mesh3d(mesh, **STEEL, contact="top")


def _without(kind: str) -> meshio.Mesh:
    mesh = cantilever("tetra")
    return meshio.Mesh(mesh.points, [(kind, mesh.cells[0].data[:, :3])])


def _turned_inside_out() -> meshio.Mesh:
    mesh = cantilever("hexahedron")
    cells = mesh.cells[0].data
    cells[0, [0, 1]] = cells[0, [1, 0]]
    return mesh


@pytest.mark.parametrize(
    ("mesh", "changed", "expected"),
    [
        (cantilever("tetra"), {"contact": "top"}, "a group of nodes of the mesh: root, tip"),
        (cantilever("tetra"), {"contact": "root"}, "nodes that are not clamped; 6 of 6 are"),
        (cantilever("tetra"), {"contacts": 7}, "contacts = 7: expected a whole number from 1 to 6"),
        (cantilever("tetra"), {"poisson_ratio": 0.5}, "from 0 to less than 0.5"),
        (cantilever("tetra"), {"length_unit": "kg"}, "a unit of length"),
        (cantilever("tetra"), {"unit": "mm"}, "length_unit = 'mm', the name of this argument"),
        (cantilever("tetra"), {"speed": "3 Pa"}, 'text such as "12000 rpm"'),
        (cantilever("tetra"), {"left": "root"}, "left, right and copies together"),
        (cantilever("tetra"), {"clamped": None, "speed": 9.0}, "does not resist rotation"),
        (bladed_sector("tetra"), TIE | {"copies": 11}, "are there 11 copies?"),
        (
            bladed_sector("tetra"),
            TIE | {"left": "right", "right": "left"},
            "left and right are interchanged",
        ),
        (
            bladed_sector("tetra"),
            TIE | {"left": "tip"},
            "left face; 4 on the left and 6",
        ),
        (_without("triangle"), {}, "cells of the types tetra, tetra10, wedge, wedge15, hexahedron"),
        (_turned_inside_out(), {}, "1 of 12 are, such as that around (0.208333, "),
        ("missing.msh", {}, "missing.msh"),
        ("blade.xyz", {}, "a mesh file, .vtu, .msh, .inp"),
        ("blade.k", {}, "not a deck of LS-DYNA; convert it"),
    ],
)
def test_what_cannot_be_right_is_refused(mesh: Any, changed: Any, expected: str) -> None:
    with pytest.raises(CaseError) as caught:
        mesh3d(mesh, **STEEL | changed)
    assert expected in str(caught.value)


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({"young_modulus": 210.0}, "unusual young_modulus = 210.0: .* perhaps 210 is in GPa"),
        ({"young_modulus": 210e3}, "perhaps 210000 is in MPa"),
        ({"density": 7.8}, "unusual density = 7.8: .* perhaps 7.8 is in g/cm3"),
        ({"density": "7.8e-9 kg/m3"}, "perhaps 7.8e-09 is in t/mm3"),
    ],
)
def test_implausible_materials_are_named(changed: dict[str, Any], expected: str) -> None:
    with pytest.warns(Hint, match=expected):
        mesh3d(cantilever("tetra", (2, 1, 1)), **STEEL | changed)


def test_metres_called_millimetres_are_named() -> None:
    with pytest.raises(SuperelementError, match=r"perhaps 0\.0003[0-9]* is in m, where mm was"):
        mesh3d(cantilever("tetra", (2, 1, 1)), **STEEL, length_unit="mm")
