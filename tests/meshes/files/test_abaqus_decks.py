"""Decks of Abaqus and CalculiX as programs write them: files, parts, surfaces, couplings."""

from pathlib import Path
from time import process_time
from typing import Any

import meshio
import numpy as np
import pytest
from solid_meshes import cantilever, deck_text

from bladewhirl.meshes.cells import CELL_TYPES
from bladewhirl.meshes.files import abaqus_mesh
from bladewhirl.meshes.files.abaqus_faces import FACES, SOLIDS
from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.files.volumes import VolumeMesh, read_volume_mesh
from bladewhirl.models.inputs.errors import CaseError, Hint
from bladewhirl.models.solids.blade import mesh3d

STEEL: dict[str, Any] = {"young_modulus": "210 GPa", "poisson_ratio": 0.3, "density": 7800.0}

MESH = cantilever("hexahedron20", (2, 1, 1))
TEXT = deck_text(MESH, "C3D20")
NODES, REST = TEXT[: TEXT.index("*ELEMENT")], TEXT[TEXT.index("*ELEMENT") :]
DATA = NODES.partition("\n")[2]  # lines of data only


def read(folder: Path, text: str, name: str = "deck.inp", **given: Any) -> VolumeMesh:
    (folder / name).write_text(text)
    return read_volume_mesh(folder / name, **given)


def assert_same(mesh: VolumeMesh) -> None:
    """Assert that a mesh is `MESH`."""
    assert mesh.points == pytest.approx(MESH.points, abs=1e-12)
    assert np.array_equal(mesh.blocks[0][1], MESH.cells[0].data)
    for name, nodes in MESH.point_sets.items():
        assert np.array_equal(mesh.groups[name], nodes)


@pytest.mark.parametrize(
    ("name", "text", "more"),
    [
        ("deck.inp", f"*INCLUDE, INPUT=parts/nodes.inc\n{REST}", {"parts/nodes.inc": NODES}),
        ("deck.inp", f"*Include,\n input = nodes.inc\n{REST}", {"nodes.inc": NODES}),
        ("deck.inp", f'*NODE, INPUT="parts\\nodes.txt"\n{REST}', {"parts/nodes.txt": DATA}),
        ("deck.inp", f"*NODE\n*INCLUDE, INPUT=nodes.txt\n{REST}", {"nodes.txt": DATA}),
        (
            "deck.inp",
            f"*INCLUDE, INPUT=parts/a.inc\n{REST}",
            {"parts/a.inc": "*INCLUDE, INPUT=b.inc\n", "parts/b.inc": NODES},
        ),
        ("deck.inp", "*INCLUDE, INPUT=a\n", {"a": "*INCLUDE, INPUT=b\n", "b": TEXT}),
        ("all.msh", TEXT, {}),
        ("all.txt", f"\n** written by cgx\n{TEXT}", {}),
        ("deck.inp", f"\ufeff{TEXT}", {}),
        ("deck.inp", f"made by hand\n1, 2\n{TEXT}", {}),
        ("deck.inp", TEXT.replace("*", "\t *").replace("\n", " \n "), {}),
        ("deck.inp", TEXT.replace("0.2000000000000", "2.d-1").replace(" 0.", " .0D1,", 0), {}),
        ("deck.inp", f"{TEXT}*AMPLITUDE, INPUT=missing.txt\n", {}),
    ],
)
def test_natural_decks_are_read(tmp_path: Path, name: str, text: str, more: dict[str, str]) -> None:
    for file, content in more.items():
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_text(content)
    assert_same(read(tmp_path, text, name))


def test_files_outside_the_folder_are_read_on_request(tmp_path: Path) -> None:
    (tmp_path / "nodes.inc").write_text(NODES)
    folder = tmp_path / "deck"
    folder.mkdir()
    text = f"*INCLUDE, INPUT=../nodes.inc\n{REST}"
    with pytest.raises(MeshFileError, match=r"not \.\./nodes\.inc; outside_files = True"):
        read(folder, text)
    assert_same(read(folder, text, outside=True))
    assert mesh3d(folder / "deck.inp", **STEEL, outside_files=True).contacts == 8
    (folder / "link.inc").symlink_to(tmp_path / "nodes.inc")
    with pytest.raises(MeshFileError, match=r"not link\.inc"):
        read(folder, text.replace("../nodes", "link"))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("*INCLUDE, INPUT=deck.inp\n", "files that do not include themselves; deck.inp does"),
        ("*INCLUDE, INPUT=missing.inc\n", "a readable file missing.inc for INPUT="),
        ("*INCLUDE, INPUT=.\n", "a readable file"),
        ("*INCLUDE, INPUT=\0\n", "a readable file"),
        ("*INCLUDE, INPUT=twice\n" * 1001, "at most 1000 files"),
        ("*INCLUDE, INPUT=0.inc\n", "at most 20 files that include one another .*of 19.inc"),
        ("** a deck\n*INCLUDE\n", r"\*INCLUDE with INPUT= \(\*INCLUDE, line 2 of deck.inp\)"),
        ("hello\n", "with keywords such as"),
        ("*NODE,", "the last line ends with a comma"),
    ],
)
def test_files_that_cannot_be_included_are_named(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "twice").write_text("** nothing\n")
    for number in range(30):
        (tmp_path / f"{number}.inc").write_text(f"*INCLUDE, INPUT={number + 1}.inc\n")
    with pytest.raises(MeshFileError, match=expected):
        read(tmp_path, text)


SETS = REST[REST.index("*NSET") :]
PART = f"*PART, NAME=Blade\n{NODES}{REST}*SOLID SECTION, ELSET=all, MATERIAL=steel\n*END PART\n"
MATERIAL = "*MATERIAL, NAME=steel\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7800\n"


def assembly(*lines: str) -> str:
    return "\n".join([f"{PART}*ASSEMBLY, NAME=A", *lines, "*END ASSEMBLY", MATERIAL])


INSTANCE = "*INSTANCE, NAME=B-1, PART=blade\n*END INSTANCE"


@pytest.mark.parametrize(
    "text",
    [
        PART + MATERIAL,
        assembly(INSTANCE),
        assembly(INSTANCE, "*NODE", "1, 0.5, 0, 0", "*NSET, NSET=reference", "1"),
        f"*PART, NAME=B\n*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=B-1, PART=B\n{NODES}"
        f"{REST[: REST.index('*NSET')]}*SOLID SECTION, ELSET=all, MATERIAL=steel\n*END INSTANCE\n"
        + SETS.replace("*NSET,", "*NSET, INSTANCE=b-1,")
        + f"*END ASSEMBLY\n{MATERIAL}",
    ],
)
def test_a_part_is_read_with_its_sets_and_materials(tmp_path: Path, text: str) -> None:
    mesh = read(tmp_path, text)
    assert_same(mesh)
    assert [section.group for section in mesh.sections] == ["all"]
    part = mesh3d(tmp_path / "deck.inp")
    expected = mesh3d(MESH, **STEEL)
    assert abs(part.stiffness - expected.stiffness).max() < 1e-9 * abs(expected.stiffness).max()


def test_instances_are_moved_and_turned(tmp_path: Path) -> None:
    """The second one is moved along y, then turned by a right angle about an axis along z."""
    text = assembly(
        INSTANCE,
        "*INSTANCE, NAME=B-2, PART=BLADE",
        "0., 1., 0.",
        "0., 1., 0., 0., 1., 2., 90.",
        "*END INSTANCE",
        "*NSET, NSET=chosen, INSTANCE=B-2",
        "1, root",
        "*NSET, NSET=pair",
        "B-1.1, B-2.tip",
        "*NSET, NSET=tip, INSTANCE=B-1, GENERATE",
        "1, 2, 1",
    )
    mesh = read(tmp_path, text)
    x, y, z = MESH.points.T
    second = np.stack([-y, 1.0 + x, z], axis=1)
    count = len(MESH.points)
    assert mesh.points[:count] == pytest.approx(MESH.points, abs=1e-12)
    assert mesh.points[count:] == pytest.approx(second, abs=1e-12)
    assert np.array_equal(mesh.blocks[0][1][2:], MESH.cells[0].data + count)
    root, tip = MESH.point_sets["root"], MESH.point_sets["tip"]
    expected = {
        "B-1.root": root,
        "B-2.root": root + count,
        "root": [*root, *(root + count)],
        "chosen": np.union1d([count], root + count),
        "pair": np.union1d([0], tip + count),
        "tip": [0, 1],  # the assembly has a set of this name
        "B-2.tip": tip + count,
    }
    for name, nodes in expected.items():
        assert np.array_equal(mesh.groups[name], nodes)
    assert [section.group for section in mesh.sections] == ["B-1.all", "B-2.all"]
    assert len(mesh.cell_groups["B-2.all"]) == 2


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (PART + PART.replace("Blade", "Disk"), "an \\*INSTANCE of each \\*PART .*; BLADE and DISK"),
        (assembly(INSTANCE, INSTANCE), "\\*INSTANCE, NAME=B-1 is defined twice"),
        (assembly("*INSTANCE, NAME=B-1\n*END INSTANCE"), "\\*INSTANCE with PART="),
        (assembly("*NSET, NSET=a, INSTANCE=B-7\n1"), "sets that consist of .*'B-7.1' is neither"),
        (
            assembly("*INSTANCE, NAME=b, PART=blade\n1, x\n*END INSTANCE"),
            "a number, got 'x' \\(\\*END INSTANCE, line",
        ),
    ],
)
def test_assemblies_that_are_not_whole_are_refused(
    tmp_path: Path, text: str, expected: str
) -> None:
    with pytest.raises(MeshFileError, match=expected):
        read(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (TEXT.replace("1, 0.2", "1, 0_0.2"), r"a number, got '0_0\.20+' \(\*NODE, line 1 of deck"),
        (TEXT.replace("\n1, ", "\n\u0661, ", 1), "a whole number, got '\u0661' .*NODE, line 1"),
        (TEXT + "*NSET, NSET=a\n1, 2\n99999,\n", "set a; node 99999 is not defined"),
        (TEXT + "*ELSET, ELSET=b\n7777,\n", "set b; element 7777 is not defined"),
        (PART.replace("*END", "*NSET, NSET=a\n99\n*END"), "set a; node 99 is not defined"),
        (TEXT + "*NSET, NSET=a, GENERATE\n10, 1, 1\n", "ranges .*, got 10, 1, 1 .*NSET, line"),
        (TEXT + "*NSET, NSET=a, GENERATE\n1, 9, -1\n", "ranges .*, got 1, 9, -1"),
        (TEXT + MATERIAL + MATERIAL, r"each material once; steel .* \(\*MATERIAL, line"),
        (
            f"{TEXT}{MATERIAL}" + "*SOLID SECTION, ELSET=ALL, MATERIAL=steel\n" * 2,
            r"one section for each set; all has two \(\*SOLID SECTION, line",
        ),
        (
            f"{MATERIAL.replace('2.1e11', '-2.1e11')}{TEXT}",
            r"a positive Young's modulus, got -2.1e\+11 \(\*ELASTIC, line 2 of deck.inp\)",
        ),
        (MATERIAL.replace("0.3", "0.5"), "a Poisson's ratio from 0 to less than 0.5, got 0.5"),
        (MATERIAL.replace("7800", "0"), r"a positive density, got 0 \(\*DENSITY, line 4"),
        (MATERIAL.replace("7800", "nan"), "a positive density, got nan"),
        (
            MATERIAL + "*ELASTIC\n1e11, 0.3\n",
            r"one \*ELASTIC of each material; .* \(\*ELASTIC, line",
        ),
        (MATERIAL + "*DENSITY\n7900\n", r"one \*DENSITY of each material"),
        (TEXT + "*RIGID BODY, NSET=root, REF NODE=998\n", "a reference node .*; .*BODY has 998"),
        (assembly("*INSTANCE, NAME=c, PART=NOWHERE\n*END INSTANCE"), "a \\*PART, NAME=NOWHERE"),
        (assembly("*INSTANCE, NAME=c, PART=blade"), "\\*END INSTANCE after .*, line"),
    ],
)
def test_faults_of_a_deck_are_named_with_their_place(
    tmp_path: Path, text: str, expected: str
) -> None:
    with pytest.raises(MeshFileError, match=expected):
        read(tmp_path, text)


def test_ranges_of_a_set_may_have_gaps(tmp_path: Path) -> None:
    mesh = read(tmp_path, f"{TEXT}*NSET, NSET=a, GENERATE\n1, 99999\n")
    assert len(mesh.groups["a"]) == len(MESH.points)


MANY = "*NSET, NSET=every, GENERATE\n1, 1000000\n"


@pytest.mark.parametrize(
    "text",
    [
        "".join(f"*NSET, NSET=a{n}, GENERATE\n1, 999999\n" for n in range(200)),
        MANY + "*NSET, NSET=a\n" + "every\n" * 100_000,
        MANY + "*COUPLING, REF NODE=1, SURFACE=every\n" * 1000,
        f"*PART, NAME=p\n{MANY}*END PART\n"
        + "".join(f"*INSTANCE, NAME=i{n}, PART=p\n*END INSTANCE\n" for n in range(1000)),
    ],
)
def test_what_short_decks_multiply_is_limited(
    tmp_path: Path, text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(abaqus_mesh, "MOST_MEMBERS", 1_100_000)
    with pytest.raises(MeshFileError, match=r"at most 1100000 members .*line"):
        read(tmp_path, text)


def test_the_time_for_instances_and_continued_lines_is_proportional(tmp_path: Path) -> None:
    """With a quadratic part each of them takes a minute."""
    text = assembly(*(f"*INSTANCE, NAME=B-{n}, PART=blade\n*END INSTANCE" for n in range(300)))
    start = process_time()
    mesh = read(tmp_path, text)
    assert len(mesh.groups["B-299.tip"]) == len(MESH.point_sets["tip"])
    assert len(mesh.points) == 300 * len(MESH.points)
    assert process_time() - start < 2.0


PLANES = {
    4: ([0, 0, 1, 0], [0, 1, 0, 0], [1, 1, 1, 1], [1, 0, 0, 0]),
    6: ([0, 0, 1, 0], [0, 0, 1, 1], [0, 1, 0, 0], [1, 1, 0, 1], [1, 0, 0, 0]),
    8: ([0, 0, 1, 0], [0, 0, 1, 1], [0, 1, 0, 0], [1, 0, 0, 1], [0, 1, 0, 1], [1, 0, 0, 0]),
}
"""Planes a x + b y + c z = d of the faces S1, S2 and so on of the reference cells."""


@pytest.mark.parametrize("element", SOLIDS)
def test_surfaces_of_faces_are_groups_of_nodes(tmp_path: Path, element: str) -> None:
    cell = CELL_TYPES[SOLIDS[element]]
    reference, number = cell.reference, len(cell.corners)
    mesh = meshio.Mesh(reference, [(SOLIDS[element], np.arange(len(reference))[None])])
    text = deck_text(mesh, element)
    for face in range(1, len(FACES[number]) + 1):
        text += f"*SURFACE, NAME=number{face}, TYPE=ELEMENT\n1, S{face}\n"
        text += f"*SURFACE, NAME=set{face}\nall, s{face}\n"
    made = read(tmp_path, f"{text}*SURFACE, NAME=free\nall,\n*SURFACE, NAME=skin\nall, SPOS\n")
    for face, (a, b, c, d) in enumerate(PLANES[number], 1):
        on_face = np.flatnonzero(abs(reference @ [a, b, c] - d) < 1e-12)
        assert np.array_equal(made.groups[f"number{face}"], on_face)
        assert np.array_equal(made.groups[f"set{face}"], on_face)
    assert np.array_equal(made.groups["free"], np.arange(len(reference)))


def test_surfaces_of_unknown_sets_are_no_groups(tmp_path: Path) -> None:
    mesh = read(tmp_path, f"{TEXT}*SURFACE, NAME=face\n1, S4\nlater, S4\n")
    assert "face" not in mesh.groups


def test_an_element_between_others_has_no_free_face(tmp_path: Path) -> None:
    text = deck_text(cantilever("hexahedron", (3, 3, 3)), "C3D8")
    sets = "*ELSET, ELSET=inner\n14\n*ELSET, ELSET=corner\n1\n"
    mesh = read(tmp_path, f"{text}{sets}*SURFACE, NAME=a\ninner\n*SURFACE, NAME=b\ncorner\n")
    assert len(mesh.groups["a"]) == 0
    assert len(mesh.groups["b"]) == 7


COUPLED = "*NODE\n1000, 0.2, 0, 0\n*NSET, NSET=held\n1000\n"


@pytest.mark.parametrize(
    "coupling",
    [
        "*SURFACE, NAME=face\n1, S6\n*COUPLING, REF NODE=1000, SURFACE=face\n*KINEMATIC\n1, 3\n",
        "*RIGID BODY, NSET=root, REF NODE=held\n",
        "*KINEMATIC COUPLING, REF NODE=1000\nroot, 1, 3\n",
    ],
)
def test_to_a_reference_node_belong_the_nodes_coupled_to_it(tmp_path: Path, coupling: str) -> None:
    text = f"{TEXT}{COUPLED}{coupling}"
    mesh = read(tmp_path, text)
    assert np.array_equal(mesh.groups["held"], MESH.point_sets["root"])
    expected = mesh3d(MESH, **STEEL)
    part = mesh3d(tmp_path / "deck.inp", **STEEL, clamped="held")
    assert abs(part.stiffness - expected.stiffness).max() < 1e-9 * abs(expected.stiffness).max()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            f"{COUPLED}*KINEMATIC COUPLING, REF NODE=1000\ntip, 1, 1\n",
            "\\*KINEMATIC COUPLING of some displacements of deck.inp are not",
        ),
        (
            "*EQUATION\n2\n1, 1, 1., 2, 1, -1.\n*MPC\nBEAM, 1, 2\n",
            "1 \\*EQUATION, 1 \\*MPC of deck.inp",
        ),
        (
            "*PART, NAME=p\n*END PART\n*INSTANCE, NAME=I-1, PART=p\n*NODE\n7, 0, 0, 0\n"
            "*END INSTANCE\n*ELEMENT, TYPE=CONN3D2\n99, I-1.7, 3\n",
            "1 elements CONN3D2 of deck.inp are not read",
        ),
        ("*ELEMENT, TYPE=MASS, ELSET=weight\n99, 3\n", "1 elements MASS of deck.inp are not read"),
    ],
)
def test_what_connects_nodes_and_is_not_read_is_named(
    tmp_path: Path, text: str, expected: str
) -> None:
    (tmp_path / "deck.inp").write_text(TEXT + text)
    with pytest.warns(Hint, match=expected):
        mesh3d(tmp_path / "deck.inp", **STEEL)


def test_couplings_that_leave_nodes_free_and_cyclic_ties_need_no_hint(tmp_path: Path) -> None:
    text = f"{TEXT}{COUPLED}*SURFACE, NAME=face, TYPE=NODE\ntip\n"
    text += "*COUPLING, REF NODE=1000, SURFACE=face\n*DISTRIBUTING\n1, 3\n"
    text += "*TIE, NAME=t, CYCLIC SYMMETRY\nface, face\n"
    assert not read(tmp_path, text).ignored


def test_a_deck_of_shells_is_refused_with_what_can_be_read(tmp_path: Path) -> None:
    (tmp_path / "shell.inp").write_text("*NODE\n1, 0, 0\n*ELEMENT, TYPE=S4\n1, 1, 1, 1, 1\n")
    with pytest.raises(CaseError, match="found 1 of type S4: shells and beams are not read"):
        mesh3d(tmp_path / "shell.inp", **STEEL)
