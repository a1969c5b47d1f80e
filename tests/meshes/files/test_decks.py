"""Meshes of solids in files of Ansys, Nastran and Code_Aster, written and read by other libraries.

Frequencies are those of the mesh from which the files were written.
"""

from pathlib import Path
from time import process_time
from typing import Any

import h5py
import mapdl_archive
import meshlane
import numpy as np
import pytest
from pyyeti.nastran import bulk
from written_decks import GROUPS, WRITERS, ansys, code_aster, nastran, rounded

import bladewhirl as bw
from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.files.volumes import VolumeMesh, read_volume_mesh
from bladewhirl.meshes.files.vtu import _without_text
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.superelements.frequencies import lowest_frequencies

STEEL = {"young_modulus": 2.1e11, "poisson_ratio": 0.3, "density": 7800.0}
KINDS = ("tetra", "tetra10", "wedge", "wedge15", "hexahedron", "hexahedron20")


def hertz(mesh: Any, **options: Any) -> Any:
    part = bw.mesh3d(mesh, mass_quadrature="full", **options)
    return lowest_frequencies(part.mass, part.stiffness, 4)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("suffix", WRITERS)
def test_decks_have_the_frequencies_of_their_mesh(tmp_path: Path, suffix: str, kind: str) -> None:
    mesh = rounded(kind)
    WRITERS[suffix](tmp_path / "blade", mesh)
    file = tmp_path / f"blade{suffix}"
    materials = STEEL if suffix == ".med" else {}
    found = hertz(file, **materials, **GROUPS.get(suffix, {}))
    assert found == pytest.approx(hertz(mesh, **STEEL), rel=1e-6)


def fields(form: str, name: str, *values: object) -> str:
    """Return an entry of bulk data in free, small or large fields."""
    words = list(map(str, values))
    if form == "free":
        rows = [words[at : at + 8] for at in range(0, len(words), 8)]
        return name + "," + "\n,".join(",".join(row) for row in rows) + "\n"
    width, each = (8, 8) if form == "small" else (16, 4)
    rows = [words[at : at + each] for at in range(0, len(words), each)]
    mark = "*" if form == "large" else ""
    lines = ["".join(f"{word:<{width}}" for word in row) for row in rows]
    return f"{name + mark:<8}" + f"\n{mark or '+':<8}".join(lines) + "\n"


@pytest.mark.parametrize("form", ["free", "small", "large"])
def test_all_formats_of_fields_are_read(tmp_path: Path, form: str) -> None:
    mesh = rounded("hexahedron20")
    upright = [*range(12), 16, 17, 18, 19, 12, 13, 14, 15]  # Nastran lists them before upper edges
    text = "BEGIN BULK\n"
    for number, point in enumerate(mesh.points.round(4).tolist(), 1):
        text += fields(form, "GRID", number, "", *point)
    for number, nodes in enumerate((mesh.cells[0].data[:, upright] + 1).tolist(), 1):
        text += fields(form, "CHEXA", number, 1, *nodes)
    (tmp_path / "blade.bdf").write_text(text + "ENDDATA\n")
    volumes = read_volume_mesh(tmp_path / "blade.bdf")
    ((name, found),) = volumes.blocks
    assert name == "C3D20"
    assert np.array_equal(volumes.rows[found], mesh.cells[0].data)
    assert volumes.points == pytest.approx(mesh.points[volumes.rows], abs=1e-4)


def test_other_libraries_find_the_same_mesh(tmp_path: Path) -> None:
    mesh = rounded("hexahedron20")
    ansys(tmp_path / "blade", mesh)
    volumes = read_volume_mesh(tmp_path / "blade.cdb")
    archive = mapdl_archive.Archive(str(tmp_path / "blade.cdb"), parse_vtk=False)
    assert volumes.points == pytest.approx(archive.nodes[volumes.rows])
    assert len(volumes.blocks[0][1]) == archive.n_elem
    tip = archive.node_components["tip"] - 1
    assert volumes.rows[volumes.groups["tip"]].tolist() == tip.tolist()
    nastran(tmp_path / "blade", mesh)
    same = meshlane.nastran.read(str(tmp_path / "blade.bdf"))
    volumes = read_volume_mesh(tmp_path / "blade.bdf")
    assert volumes.rows[volumes.blocks[0][1]].tolist() == same.cells[0].data.tolist()
    assert len(bulk.rdcards(str(tmp_path / "blade.bdf"), "GRID")) == len(volumes.points)


BRICK = """/PREP7
ET,1,{element}
KEYOPT,1,2,{option}
ET,2,154
*SET,unused,3
NBLOCK,6,SOLID,     8,     8
(3i9,6e21.13e3)
        1        0        0
        2        0        0 1.0000000000000E+000
        3        0        0 1.0000000000000E+000 1.0000000000000E+000
        4        0        0 0.0000000000000E+000 1.0000000000000E+000
        5        0        0 0.0000000000000E+000 0.0000000000000E+000 1.0000000000000E+000
        6        0        0 1.0000000000000E+000 0.0000000000000E+000 1.0000000000000E+000
        7        0        0 1.0000000000000E+000 1.0000000000000E+000 1.0000000000000E+000
        8        0        0 0.0000000000000E+000 1.0000000000000E+000 1.0000000000000E+000
N,R5.3,LOC,       -1,
EBLOCK,19,SOLID,     3,     3
(19i9)
{rows}
       -1
MP,EX,1,2E11
MP,NUXY,1,0.25
MP,DENS,1,7000
MPDATA,R5.0, 1,EX  ,       2, 1,  1000000.    ,
{more}
CMBLOCK,BOTTOM,NODE,       2
(8i10)
         1        -4
CMBLOCK,TOP,NODE,       2
(8i10)
         5        -8
"""


def row(material: int, kind: int, number: int, *nodes: int) -> str:
    numbers = (material, kind, 1, 1, 0, 0, 0, 0, len(nodes), 0, number, *nodes)
    return "".join(f"{one:9d}" for one in numbers)


def brick(folder: Path, *rows: str, element: int = 185, option: int = 2, more: str = "") -> Path:
    file = folder / "brick.cdb"
    text = BRICK.format(rows="\n".join(rows), element=element, option=option, more=more)
    file.write_text(text)
    return file


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ("/INPUT,../secret,txt", "a file without /INPUT, .*line"),
        ("*do,i,1,1e12\n*enddo", "a file without \\*DO,"),
        ("A=1 $ ngen,9,100,ALL", "a file without NGEN,"),
        ("NBLOCK,6,SOLID\n(3i9,6e21.13e3)\n   9  0  0 1_0.0", "a number, got '1_0.0' .*line"),
        ("MP,EX,3,-1", r"a positive Young's modulus, got -1 \(MP,EX, line \d+\)"),
        ("MP,PRXY,3,0.5", "a Poisson's ratio from 0 to less than 0.5, got 0.5"),
    ],
)
def test_faults_of_ansys_are_named_with_their_line(
    tmp_path: Path, more: str, expected: str
) -> None:
    with pytest.raises(MeshFileError, match=expected):
        read_volume_mesh(brick(tmp_path, WEDGES[0], more=more))


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("2.1+11", "-2.1+11", r"a positive Young's modulus, got -2.1e\+11 \(MAT1 7\)"),
        ("7800.", "7_8.", r"a number, got '7_8\.'"),
        ("7800.", "\u0667.", r"a number, got '\u0667\.'"),
    ],
)
def test_faults_of_nastran_are_named(tmp_path: Path, old: str, new: str, expected: str) -> None:
    nastran(tmp_path / "blade", rounded("hexahedron", (1, 1, 1)))
    file = tmp_path / "blade.bdf"
    file.write_text(file.read_text().replace(old, new))
    with pytest.raises(MeshFileError, match=expected):
        read_volume_mesh(file)


WEDGES = (row(1, 1, 10, 1, 2, 3, 3, 5, 6, 7, 7), row(2, 1, 11, 1, 3, 4, 4, 5, 7, 8, 8))
SURFACE = row(1, 2, 12, 1, 2, 3, 4)


def test_degenerate_elements_materials_and_components_of_ansys(tmp_path: Path) -> None:
    volumes = read_volume_mesh(brick(tmp_path, *WEDGES, SURFACE))
    assert not volumes.ignored
    ((name, cells),) = volumes.blocks
    assert name == "C3D6"
    assert cells.tolist() == [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]
    assert volumes.groups["BOTTOM"].tolist() == [0, 1, 2, 3]
    assert {key: one.tolist() for key, one in volumes.cell_groups.items()} == {
        "MAT1": [0],
        "MAT2": [1],
    }
    steel = {"young_modulus": 2e11, "poisson_ratio": 0.25, "density": 7000.0}
    assert [dict(one.properties) for one in volumes.sections] == [steel, {"young_modulus": 1e6}]
    with pytest.raises(CaseError, match="material 2 of the file lacks PRXY or NUXY"):
        bw.mesh3d(brick(tmp_path, *WEDGES), clamped="BOTTOM", contact="TOP")


@pytest.mark.parametrize(
    ("option", "element"), [(0, "C3D8"), (1, "C3D8R"), (2, "C3D8I"), (3, "C3D8I")]
)
def test_the_integration_of_solid185_is_that_of_its_keyopt(
    tmp_path: Path, option: int, element: str
) -> None:
    file = brick(tmp_path, row(1, 1, 10, *range(1, 9)), option=option)
    assert read_volume_mesh(file).blocks[0][0] == element


def test_the_integration_of_solid186_is_that_of_its_keyopt(tmp_path: Path) -> None:
    mesh = rounded("hexahedron20")
    ansys(tmp_path / "full", mesh)
    text = (tmp_path / "full.cdb").read_text()
    (tmp_path / "reduced.cdb").write_text(text.replace("KEYOPT,1,2,1\n", ""))
    (tmp_path / "block.cdb").write_text(
        text.replace("KEYOPT,1,2,1\n", "").replace(
            "ET,1,186\n", f"ETBLOCK,        1,        1\n(2i9,19a9)\n{1:9d}{186:9d}{0:9d}{1:9d}\n"
        )
    )
    for name, element in (("full", "C3D20"), ("reduced", "C3D20R"), ("block", "C3D20")):
        assert read_volume_mesh(tmp_path / f"{name}.cdb").blocks[0][0] == element


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"element": 181}, "SOLID185, SOLID186, SOLID187; found elements 181"),
        ({"option": 7}, r"one known KEYOPT\(2\)"),
        ({"more": "MP,EX,1,2E1 1"}, "a number in 'MP,EX,1,2E1 1', got '2E1 1'"),
        ({"more": "EBLOCK,19,SOLID,COMPACT,1\n(19i9)\n       -1"}, "EBLOCK in its long form"),
    ],
)
def test_decks_of_ansys_that_are_not_read(
    tmp_path: Path, change: dict[str, Any], expected: str
) -> None:
    with pytest.raises(MeshFileError, match=expected):
        read_volume_mesh(brick(tmp_path, row(1, 1, 10, *range(1, 9)), **change))


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ("MP,EY,1,2E10", "material 1 has EY, which is not read"),
        ("MPDATA,R5.0, 2,EX  ,1, 1, 2E11, 1E11", "has EX for several temperatures"),
    ],
)
def test_other_materials_of_ansys_are_refused_by_name(
    tmp_path: Path, lines: str, expected: str
) -> None:
    file = brick(tmp_path, row(1, 1, 10, *range(1, 9)), more=lines)
    with pytest.raises(CaseError, match=expected):
        bw.mesh3d(file, clamped="BOTTOM", contact="TOP")


NODES = """SOL 103
SET 4 = 5,
 6 THRU 8
SET 5 = ALL
BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID    3               1.0     1.0     0.0
GRID*                  4                             0.0             1.0
*                    0.0
GRID,5,,0.,0.,1.
GRID,6,,1.,0.,.1+1
GRID,7,,1.,1.,1.
GRID,8,,0.,1.,1.
"""
SOLID = """CHEXA*                 2               1               1               2
*                      3               4               5               6
*                      7               8
PSOLID,1,1
MAT1    1       2.1+11  8.+10           7800.
SPC1,5,123,1,THRU,4
SPC1,6,3,5,6
SPC,7,8,123456,,7,12
"""


def bulk_data(folder: Path, text: str) -> VolumeMesh:
    (folder / "brick.nas").write_text(f"{NODES}{text}ENDDATA\n")
    return read_volume_mesh(folder / "brick.nas")


def test_sets_and_materials_of_bulk_data(tmp_path: Path) -> None:
    volumes = bulk_data(tmp_path, SOLID)
    assert volumes.blocks[0][1].tolist() == [[0, 1, 2, 3, 4, 5, 6, 7]]
    groups = {name: nodes.tolist() for name, nodes in volumes.groups.items()}
    assert groups == {
        "SPC 5": [0, 1, 2, 3],
        "SPC 7": [7],
        "SET 4": [4, 5, 6, 7],
        "PSOLID 1": [*range(8)],
    }
    (section,) = volumes.sections
    expected = {"young_modulus": 2.1e11, "poisson_ratio": 0.3125, "density": 7800.0}
    assert dict(section.properties) == pytest.approx(expected)


def test_a_set_of_other_things_than_nodes_is_named(tmp_path: Path) -> None:
    volumes = bulk_data(tmp_path, SOLID + "SET1,77,SKIN,1\n")
    assert "SET1 77 with SKIN" in volumes.ignored
    assert "SET 77" not in volumes.groups


def test_what_connects_nodes_is_named(tmp_path: Path) -> None:
    volumes = bulk_data(tmp_path, SOLID + "RBE2,7,1,123,2,3\n")
    assert volumes.ignored == (
        "1 RBE2",
        "SPC 6 of single displacements of 2 nodes",
        "SPC 7 of single displacements of 1 nodes",
    )
    file = brick(tmp_path, row(1, 1, 10, *range(1, 9)), more="CE,1,0,1,UX,1,2,UX,-1")
    file.write_text(file.read_text().replace("ET,2,154", "ET,2,174"))
    assert read_volume_mesh(file).ignored == ("1 CE",)
    text = file.read_text().replace("       -1\nMP", f"{SURFACE}\n       -1\nMP")
    file.write_text(text)
    assert read_volume_mesh(file).ignored == (
        "1 elements CONTA174",
        "1 CE",
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("GRID,9,4,0.,0.,0.\n", "a coordinate system 4 of the types CORD1R, .*; there is none"),
        ("INCLUDE 'more.bdf'\n", r"without INCLUDE \(line 23\)"),
        ("CPYRAM,3,1,1,2,3,4,5\n", "found CPYRAM"),
        ("CTETRA,3,1,1,2,3,5,6\n", "4 or 10 nodes of each CTETRA; element 3"),
        ("CTETRA,3,1,1,2,3,99\n", "node 99 of element 3 is not defined"),
        ("CQUAD4,3,1,1,2,3,4\n", "there are none"),
    ],
)
def test_bulk_data_that_is_not_read(tmp_path: Path, text: str, expected: str) -> None:
    with pytest.raises(MeshFileError, match=expected):
        bulk_data(tmp_path, text if "CQUAD" in text else SOLID + text)


def test_other_materials_of_bulk_data_are_refused_by_name(tmp_path: Path) -> None:
    text = SOLID.replace("MAT1    1       2.1+11  8.+10           7800.", "MAT9,1,2.1+11")
    bulk_data(tmp_path, text)
    with pytest.raises(CaseError, match="material 1 of PSOLID 1 is MAT9, which is not read"):
        bw.mesh3d(tmp_path / "brick.nas", clamped="SPC 5", contact="SET 4")


def test_cylindrical_coordinates_of_code_aster_are_refused(tmp_path: Path) -> None:
    code_aster(tmp_path / "a", rounded("hexahedron", (1, 1, 1)))
    with h5py.File(tmp_path / "a.med", "r+") as file:
        file["ENS_MAA/mesh"].attrs["REP"] = 1
    with pytest.raises(MeshFileError, match="file in Cartesian coordinates"):
        read_volume_mesh(tmp_path / "a.med")


@pytest.mark.parametrize("suffix", [".cdb", ".bdf", ".med"])
@pytest.mark.parametrize("content", [b"", b"\x00\xff" * 50, b"BEGIN BULK\nGRID,x\n", b"EBLOCK,1"])
def test_damaged_decks_end_in_one_line(tmp_path: Path, suffix: str, content: bytes) -> None:
    file = tmp_path / f"deck{suffix}"
    file.write_bytes(content)
    with pytest.raises(MeshFileError):
        read_volume_mesh(file)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.vtu", "<VTKFile>" + "<DataArray " * 100_000),
        ("a.vtu", "<VTKFile>" + '<DataArray type="String">' * 100_000),
        ("a.bdf", "\n" * 100_000),
        ("a.inp", "*NODE,\n" + "a,\n" * 100_000 + "b\n"),
    ],
)
def test_the_time_for_repeated_text_is_proportional(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    start = process_time()
    with pytest.raises(MeshFileError):
        read_volume_mesh(tmp_path / name)
    assert process_time() - start < 3.0


def test_text_of_vtk_is_left_out() -> None:
    kept = b"<PointData><DataArray type='Float64'>1</DataArray>"
    text = b"<Array type='String' /><DataArray name='a' type=\"String\">b</DataArray>"
    assert b"".join(_without_text(kept + text + kept + text)) == kept + kept
