"""Mesh files: what Gmsh writes is read whole, what is written comes back, the rest is refused."""

import os
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from places import DATA

from bladewhirl.meshes.files.groups import GroupedLines, MeshFileError
from bladewhirl.meshes.files.registry import WRITERS, read_line_mesh, write_line_mesh
from bladewhirl.meshes.line_mesh import FloatArray, IntArray

FROM_GMSH = DATA / "meshes"

Span = tuple[tuple[float, float], ...]


def places(mesh: GroupedLines, group: str) -> set[tuple[float, float]]:
    """Where the nodes of a group are, to the nine digits that Gmsh puts nodes on curves with."""
    return {tuple(np.round(point, 6).tolist()) for point in mesh.points[mesh.node_groups[group]]}


def spans(mesh: GroupedLines, lines: IntArray) -> list[Span]:
    """Lines as pairs of points, in one order whatever the numbering."""
    ends = np.sort(mesh.lines[lines], axis=1)
    actual = [tuple(map(tuple, mesh.points[pair].tolist())) for pair in ends]
    return sorted((min(a, b), max(a, b)) for a, b in actual)


@pytest.mark.parametrize(
    "name", ["gmsh_4.1.msh", "gmsh_4.1_binary.msh", "gmsh_2.2.msh", "gmsh.inp"]
)
def test_what_gmsh_writes_is_read(name: str) -> None:
    mesh = read_line_mesh(FROM_GMSH / name)
    assert (len(mesh.points), len(mesh.lines)) == (7, 7)
    assert places(mesh, "tips") == {(100.0, 0.0), (0.0, 100.0)}
    assert places(mesh, "hub") == {(0.0, 0.0)}
    everything = "all_of_it" if name.endswith("inp") else "all of it"  # a set's name has no spaces
    assert {k: len(mesh.line_groups[k]) for k in ("blades", "rim", everything)} == {
        "blades": 4,
        "rim": 3,
        everything: 7,
    }
    rim = mesh.points[mesh.lines[mesh.line_groups["rim"]]]
    np.testing.assert_allclose(np.linalg.norm(rim, axis=-1), 100.0, rtol=1e-9)
    chord = 200.0 * np.sin(np.pi / 12.0)
    np.testing.assert_allclose(np.linalg.norm(rim[:, 1] - rim[:, 0], axis=1), chord, rtol=1e-8)


@pytest.mark.parametrize("name", ["gmsh_curved.msh", "gmsh_curved.inp"])
def test_curved_lines_are_refused(name: str) -> None:
    with pytest.raises(MeshFileError, match=r"^straight two-node lines, found \d curved cells"):
        read_line_mesh(FROM_GMSH / name)


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("line3", "1 curved cells of type line3"),
        ("triangle", "lines only, found 1 cells of type tr"),
    ],
)
def test_other_cells_of_vtk_are_refused(tmp_path: Path, kind: str, message: str) -> None:
    points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.1, 0.0]]
    path = tmp_path / "a.vtu"
    meshio.vtu.write(path, meshio.Mesh(points, [("line", [[0, 1]]), (kind, [[0, 1, 2]])]))
    with pytest.raises(MeshFileError, match=message):
        read_line_mesh(path)


NAMES = st.sampled_from(["tips", "hub", "blade roots", "rim_1"])


@st.composite
def meshes(draw: st.DrawFn) -> GroupedLines:
    """Lines between any nodes, with overlapping groups and with data on some of both."""
    nodes = draw(st.integers(3, 9))
    coordinate = st.floats(-1e3, 1e3, allow_subnormal=False)
    points = draw(
        st.lists(st.tuples(coordinate, coordinate), min_size=nodes, max_size=nodes, unique=True)
    )
    node = st.integers(0, nodes - 1)
    pairs = st.tuples(node, node).filter(lambda ends: ends[0] < ends[1])
    lines = sorted(draw(st.sets(pairs, min_size=2, max_size=12)))
    # Every node is on a line, or a mesher would not have written it.
    lines += [(n, (n + 1) % nodes) for n in range(nodes) if n not in np.ravel(lines)]

    def groups(size: int, prefix: str) -> dict[str, IntArray]:
        members = st.sets(st.integers(0, size - 1), min_size=1).map(sorted)
        actual = draw(st.dictionaries(NAMES, members, max_size=3))
        return {f"{prefix} {name}": np.array(numbers) for name, numbers in actual.items()}

    def data(size: int, *names: str) -> dict[str, FloatArray]:
        value = st.sampled_from([0.1, 2.1e11, 1.0 / 3.0, 7800.0])
        values = st.lists(value, min_size=size, max_size=size)
        return {name: np.array(draw(values)) for name in names}

    return GroupedLines(
        points=np.array(points),
        lines=np.array(lines),
        node_groups=groups(nodes, "node"),
        line_groups=groups(len(lines), "line"),
        node_data=data(nodes, "mass", "inertia"),
        line_data=data(len(lines), "width", "thickness", "young_modulus", "density"),
    )


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@pytest.mark.parametrize("suffix", [*WRITERS])
@given(mesh=meshes())
@pytest.mark.slow
def test_what_is_written_is_read_again(tmp_path: Path, suffix: str, mesh: GroupedLines) -> None:
    path = tmp_path / f"mesh{suffix}"
    write_line_mesh(path, mesh)
    again = read_line_mesh(path)
    every = np.arange(len(mesh.lines))
    assert spans(again, every) == spans(mesh, every)
    assert set(again.node_groups) == set(mesh.node_groups)
    assert set(again.line_groups) - {"lines"} == set(mesh.line_groups)
    for name, nodes in mesh.node_groups.items():
        actual = again.points[again.node_groups[name]].tolist()
        assert sorted(actual) == sorted(mesh.points[nodes].tolist())
    for name, lines in mesh.line_groups.items():
        assert spans(again, again.line_groups[name]) == spans(mesh, lines)
    order, same = (np.lexsort(m.points.T) for m in (mesh, again))
    assert set(again.node_data) == set(mesh.node_data)
    for name, values in mesh.node_data.items():
        assert again.node_data[name][same].tolist() == values[order].tolist()
    assert set(again.line_data) == set(mesh.line_data)
    for name, values in mesh.line_data.items():
        for value in np.unique(values):
            chosen = np.flatnonzero(again.line_data[name] == value)
            assert spans(again, chosen) == spans(mesh, np.flatnonzero(values == value))


def written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


INP = "*NODE\n1, 0, 0\n2, 1, 0\n3, 2, 0\n"


def test_a_file_of_abaqus_with_what_meshio_loses(tmp_path: Path) -> None:
    """Two blocks of nodes, sets across blocks of elements, a beam type, a section, a mass."""
    text = """*HEADING
*NODE, NSET=left
1, 0., 0.
2, 1.
*NODE
30, 2., 0., 0.
*ELEMENT, TYPE=B21
1, 1, 2
*ELEMENT, TYPE=B23, ELSET=outer
2, 2, 30
*ELEMENT, TYPE=MASS, ELSET=weights
3, 30
*ELSET, ELSET=all, GENERATE
1, 2, 1
*NSET, NSET=both
left, 30
*MATERIAL, NAME=Steel
*ELASTIC
2.1e11, 0.3
*DENSITY
7800.
*BEAM SECTION, ELSET=all, MATERIAL=STEEL, SECTION=RECT
0.1, 0.01
0., 0., -1.
*MASS, ELSET=weights
0.25
*STEP
"""
    mesh = read_line_mesh(written(tmp_path / "a.inp", text))
    assert mesh.points.tolist() == [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]
    assert mesh.lines.tolist() == [[0, 1], [1, 2]]
    assert {k: v.tolist() for k, v in mesh.node_groups.items()} == {
        "left": [0, 1],
        "both": [0, 1, 2],
    }
    groups = {k: v.tolist() for k, v in mesh.line_groups.items()}
    assert groups == {"outer": [1], "all": [0, 1], "weights": []}
    assert {k: v.tolist() for k, v in mesh.line_data.items()} == {
        "width": [0.1, 0.1],
        "thickness": [0.01, 0.01],
        "young_modulus": [2.1e11, 2.1e11],
        "density": [7800.0, 7800.0],
    }
    assert mesh.node_data["mass"].tolist() == [0.0, 0.0, 0.25]


BEAM = "*NODE\n1, 0, 0\n2, 1, 0\n*ELEMENT, TYPE=B21, ELSET=all\n1, 1, 2\n"
MATERIAL = "*MATERIAL, NAME=titan\n*ELASTIC\n114e9, 0.3\n"
SECTION = "*BEAM SECTION, ELSET=all, MATERIAL=TITAN, SECTION=RECT\n0.1, 0.01\n"


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("a.msh", "", r"a \.msh file that meshio can read"),
        ("a.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 2", "that meshio can read"),
        ("a.msh", "$MeshFormat\n4 0 8\n$EndMeshFormat\n", r"of version 4\.1 or 2\.2 .*, not 4$"),
        ("a.vtu", "<VTKFile", r"a \.vtu file that meshio can read"),
        ("a.inp", "", r"an \.inp file, with keywords"),
        ("a.inp", "*NODE\n1, x\n", r"a number, got 'x' \(\*NODE, line 1 of a.inp"),
        ("a.inp", "*NODE\n1, nan, 0\n2, 1, 0\n*ELEMENT, TYPE=B21\n1, 1, 2\n", "finite coordinates"),
        ("a.inp", INP + "*ELEMENT, TYPE=B22\n1, 1, 2, 3\n", "found 1 curved cells of type B22"),
        ("a.inp", INP + "*ELEMENT, TYPE=B21\n1, 1, 4\n", "node 4 is not defined"),
        ("a.inp", INP + "1, 5, 5\n", "each node at most once; node number 1 is defined twice"),
        ("a.inp", BEAM + SECTION, r"\*MATERIAL, NAME=TITAN, which a \*BEAM SECTION names"),
        ("a.inp", BEAM + MATERIAL + SECTION, r"\*DENSITY under \*MATERIAL, NAME=TITAN"),
        ("a.inp", INP + "*NGEN\n1, 3, 1\n", r"without \*NGEN"),
        ("a.inp", "*NODE\n1, 0, 0\n2, 1, 0, 1\n*ELEMENT, TYPE=B21\n1, 1, 2\n", "in one plane"),
    ],
)
def test_what_is_no_mesh_of_lines_is_said_in_one_line(
    tmp_path: Path, name: str, text: str, expected: str
) -> None:
    with pytest.raises(MeshFileError, match=expected) as error:
        read_line_mesh(written(tmp_path / name, text))
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize("suffix", [*WRITERS])
def test_a_file_that_is_not_there(tmp_path: Path, suffix: str) -> None:
    with pytest.raises(MeshFileError, match=r"^a readable file \(No such file or directory\)$"):
        read_line_mesh(tmp_path / f"none{suffix}")


@pytest.mark.parametrize("suffix", [*WRITERS])
def test_what_never_ends_is_not_read(tmp_path: Path, suffix: str) -> None:
    pipe, endless = tmp_path / f"pipe{suffix}", tmp_path / f"zero{suffix}"
    os.mkfifo(pipe)
    endless.symlink_to("/dev/zero")
    for path in (pipe, endless):
        with pytest.raises(MeshFileError, match=r"^a regular file$"):
            read_line_mesh(path)


def test_two_groups_of_one_name_are_refused(tmp_path: Path) -> None:
    text = (FROM_GMSH / "gmsh_4.1.msh").read_text().replace('"hub"', '"rim"')
    with pytest.raises(MeshFileError, match="points and curves share the name 'rim'"):
        read_line_mesh(written(tmp_path / "a.msh", text))


@pytest.mark.parametrize(
    ("suffix", "groups", "expected"),
    [
        (".msh", {"node_groups": {"a": [0]}, "line_groups": {"a": [0]}}, "both have 'a'"),
        (".msh", {"line_groups": {"a=1": [0]}}, "not 'a=1'"),
        (".msh", {"line_groups": {'"': [0]}}, "not '\"'"),
        (".inp", {"line_groups": {"Öl": [0]}}, "not 'Öl'"),
        (".inp", {"line_groups": {"section-1": [0]}}, "not 'section-1'"),
    ],
)
def test_names_that_a_format_does_not_hold(
    tmp_path: Path, suffix: str, groups: dict[str, dict[str, list[int]]], expected: str
) -> None:
    frozen: dict[str, Any] = {
        kind: {k: np.array(v) for k, v in named.items()} for kind, named in groups.items()
    }
    mesh = GroupedLines(
        points=np.array([[0.0, 0.0], [1.0, 0.0]]), lines=np.array([[0, 1]]), **frozen
    )
    with pytest.raises(MeshFileError, match=expected):
        write_line_mesh(tmp_path / f"a{suffix}", mesh)
    assert not [*tmp_path.iterdir()]
