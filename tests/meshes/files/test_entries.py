"""Every entry of a deck is used, harmless, or named."""

import re
from pathlib import Path
from typing import Any

import pytest
from solid_meshes import cantilever, deck_text
from written_decks import ansys, nastran, rounded

import bladewhirl as bw
from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.files.volumes import VolumeMesh, read_volume_mesh
from bladewhirl.models.inputs.errors import CaseError, Hint
from bladewhirl.models.superelements.frequencies import lowest_frequencies

BOXES = (2, 1, 1)
MATERIAL = """*MATERIAL, NAME=steel
*ELASTIC
2.1e11, 0.3
*DENSITY
7800
*SOLID SECTION, ELSET=all, MATERIAL=steel
"""


def bulk(folder: Path, *changes: tuple[str, str], more: str = "", suffix: str = ".bdf") -> Path:
    """Write a blade for Nastran, of which SPC 1 holds the root."""
    nastran(folder / "blade", rounded("hexahedron20", BOXES))
    text = (folder / "blade.bdf").read_text().replace("ENDDATA", f"{more}ENDDATA")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = (folder / "blade").with_suffix(suffix)
    path.write_text(text)
    return path


def root_nodes() -> list[int]:
    return [int(node) + 1 for node in rounded("hexahedron20", BOXES).point_sets["root"]]


def first(path: Path, **given: Any) -> float:
    part = bw.mesh3d(path, **{"contact": "x = 0.3"} | given)
    return float(lowest_frequencies(part.mass, part.stiffness, 1)[0])


def held(mesh: VolumeMesh) -> list[int]:
    return mesh.groups[mesh.held].tolist() if mesh.held else []


def without_spc(text: str) -> str:
    return "".join(line for line in text.splitlines(keepends=True) if not line.startswith("SPC1"))


@pytest.mark.parametrize(
    "entries",
    [
        lambda nodes: "".join(f"SPC1,1,12,{n}\nSPC1,1,3,{n}\n" for n in nodes),
        lambda nodes: "SPCADD,9,7,8\n" + "".join(f"SPC1,{7 + n % 2},123,{n}\n" for n in nodes),
        lambda nodes: "".join(f"SPC,4,{n},123,0.\n" for n in nodes),
    ],
    ids=["split", "spcadd", "spc"],
)
def test_constraints_of_nastran_are_united_by_node(tmp_path: Path, entries: Any) -> None:
    expected = held(read_volume_mesh(bulk(tmp_path)))
    assert len(expected) == len(root_nodes())
    path = bulk(tmp_path)
    text = without_spc(path.read_text()).replace("ENDDATA", f"{entries(root_nodes())}ENDDATA")
    path.write_text(text)
    mesh = read_volume_mesh(path)
    assert held(mesh) == expected
    assert mesh.ignored == ()


def test_permanent_constraints_of_nodes_count(tmp_path: Path) -> None:
    path = bulk(tmp_path)
    lines = without_spc(path.read_text()).splitlines()
    nodes, points = root_nodes(), rounded("hexahedron20", BOXES).points
    kept = [line for line in lines if not line.startswith("GRID")]
    grid = [
        f"GRID,{n},,{x:.8g},{y:.8g},{z:.8g},,{'123456' if n in nodes else ''}"
        for n, (x, y, z) in enumerate(points.tolist(), 1)
    ]
    head = next(n for n, line in enumerate(kept) if "BEGIN" in line) + 1
    path.write_text("\n".join([*kept[:head], *grid, *kept[head:]]) + "\n")
    mesh = read_volume_mesh(path)
    assert mesh.held == "PS"
    assert len(held(mesh)) == len(nodes)


def test_the_factor_of_masses_is_applied(tmp_path: Path) -> None:
    plain = first(bulk(tmp_path), clamped="SPC 1")
    weighted = first(bulk(tmp_path, more="PARAM,WTMASS,0.25\n"), clamped="SPC 1")
    assert weighted == pytest.approx(2.0 * plain, rel=1e-9)
    with pytest.raises(CaseError, match="a positive PARAM,WTMASS, got -1"):
        first(bulk(tmp_path, more="PARAM,WTMASS,-1.\n"), clamped="SPC 1")


def test_a_density_of_zero_is_none(tmp_path: Path) -> None:
    path = bulk(tmp_path, ("7800.", "0.0"))
    with pytest.raises(CaseError, match=r"density: expected a value for .* no MAT1 7 with RHO"):
        first(path, clamped="SPC 1")
    expected = first(bulk(tmp_path), clamped="SPC 1")
    path = bulk(tmp_path, ("7800.", "0.0"))
    assert first(path, clamped="SPC 1", density=7800.0) == pytest.approx(expected)


@pytest.mark.parametrize("suffix", [".dat", ".DAT", ".inp"])
def test_decks_are_recognised_by_their_text(tmp_path: Path, suffix: str) -> None:
    assert held(read_volume_mesh(bulk(tmp_path, suffix=suffix)))
    ansys(tmp_path / "a", rounded("hexahedron20", BOXES))
    (tmp_path / f"a{suffix}").write_text((tmp_path / "a.cdb").read_text())
    assert read_volume_mesh(tmp_path / f"a{suffix}").blocks[0][0] == "C3D20"
    text = deck_text(cantilever("hexahedron20", BOXES), "C3D20R")
    (tmp_path / f"b{suffix}").write_text(f"** a comment\n{text}")
    assert read_volume_mesh(tmp_path / f"b{suffix}").blocks[0][0] == "C3D20R"


def test_other_entries_of_nastran_are_named_with_their_number(tmp_path: Path) -> None:
    more = "CMASS2,77,50.,5,1\nRBAR,79,5,20\nRBAR,80,5,21\nPELAS,9,1.+7\nEIGRL,1,,,5\nCORD2R,7\n"
    mesh = read_volume_mesh(bulk(tmp_path, more=f"{more}SPC1,1,3,20\nNOVELTY,1\n"))
    single = "SPC 1 of single displacements of 1 nodes"
    assert mesh.ignored == ("1 CMASS2", "1 NOVELTY", "2 RBAR", single)
    with pytest.warns(Hint, match="1 CMASS2, 2 RBAR of blade.bdf are not read"):
        first(bulk(tmp_path, more=more), clamped="SPC 1")


@pytest.mark.parametrize(
    ("changes", "more", "note"),
    [
        ((), "MAT1,9,1.,,.3,1.,1.-5,20.,0.05\n", "the damping GE of 1 MAT1"),
        ((), "PSOLID,9,1,,2,,1\n", "the integration of 1 PSOLID"),
        ((), "PARAM,G,.02\n", "PARAM G"),
        ((), "PARAM,COUPMASS,-1\n", "PARAM COUPMASS = -1, a lumped mass,"),
        ((), "MAT1,9,2.1+11,4.+10,.3,1.\n", "G of 1 MAT1, which is not E / (2 (1 + NU)),"),
        ((), "TABDMP1,7,CRIT\n,0.,.02,9.,.02,ENDT\n", "1 TABDMP1"),
        ((), "SPC1,1,123,99999\n", "SPC 1 of 1 nodes that are not defined"),
        ((("SPC = 1", "SPC = 4"),), "", "SPC = 4, for which there are no entries,"),
    ],
)
def test_fields_of_nastran_that_are_not_read_are_named(
    tmp_path: Path, changes: Any, more: str, note: str
) -> None:
    given = bulk(tmp_path, ("BEGIN BULK", "SPC = 1\nBEGIN BULK"), more=more)
    for old, new in changes:
        given.write_text(given.read_text().replace(old, new))
    assert read_volume_mesh(given).ignored == (note,)


@pytest.mark.parametrize(
    ("more", "reason"),
    [
        ("GRID,20,,9.,9.,9.\n", "each GRID once; GRID 20 is there twice"),
        ("CTETRA,1,1,1,2,3,20\n", "each element once; element 1 is there twice"),
        ("PSOLID,9,1,,,,,PFLUID\n", "elements of solids; PSOLID 9 is a fluid"),
        ("PARAM,WTMASS,abc\n", r"a number in field 3 of PARAM \(line \d+\), got 'ABC'"),
        ("MAT1,7,1.+11,,.3,5000.\n", "each MAT1 once; MAT1 7 is there twice"),
        ("PSOLID,3,7\n", "each PSOLID once; PSOLID 3 is there twice"),
        ("BEGIN SUPER=1\n", "one section BEGIN BULK, got BEGIN SUPER=1"),
    ],
)
def test_contradictions_of_nastran_are_refused(tmp_path: Path, more: str, reason: str) -> None:
    with pytest.raises(MeshFileError, match=reason):
        read_volume_mesh(bulk(tmp_path, more=more))


def test_comments_behind_sets_are_none_of_their_members(tmp_path: Path) -> None:
    more = "SET 5 = 1, 2 $ PROP_34\nBEGIN BULK\nSET3,6,GRID,3,THRU,5\nSET3,7,ELEM,1"
    groups = read_volume_mesh(bulk(tmp_path, ("BEGIN BULK", more))).groups
    assert groups["SET 5"].tolist() == [0, 1]
    assert groups["SET 6"].tolist() == [2, 3, 4]
    assert "SET 7" not in groups


def test_ranges_of_sets_have_exceptions(tmp_path: Path) -> None:
    more = "SET 5 = 1 THRU 9 EXCEPT 3 THRU 5, 20\nBEGIN BULK"
    mesh = read_volume_mesh(bulk(tmp_path, ("BEGIN BULK", more)))
    assert mesh.groups["SET 5"].tolist() == [0, 1, 5, 6, 7, 8, 19]


def cdb(folder: Path, *changes: tuple[str, str], more: str = "") -> Path:
    ansys(folder / "blade", rounded("hexahedron20", BOXES))
    path = folder / "blade.cdb"
    text = path.read_text().replace("KEYOPT", f"{more}KEYOPT", 1)
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return path


@pytest.mark.parametrize("command", ["KEYO", "KEYOP", "keyopt"])
def test_commands_of_ansys_are_known_by_four_letters(tmp_path: Path, command: str) -> None:
    path = cdb(tmp_path, ("KEYOPT,", f"{command},"))
    assert read_volume_mesh(path).blocks[0][0] == "C3D20"


def test_parameters_of_ansys_are_replaced_by_their_values(tmp_path: Path) -> None:
    given = (("ET,1,186", "*SET,CID,1\nfull = 1 ! integration\nET,CID,186"),)
    path = cdb(tmp_path, *given, ("KEYOPT,1,2,1", "KEYOPT,CID,2,FULL"))
    assert read_volume_mesh(path).blocks[0][0] == "C3D20"
    with pytest.raises(MeshFileError, match="a number in 'KEYOPT,1,2,FULLY', got 'FULLY'"):
        read_volume_mesh(cdb(tmp_path, ("KEYOPT,1,2,1", "KEYOPT,1,2,FULLY")))


def test_options_of_elements_of_ansys_may_stand_in_their_type(tmp_path: Path) -> None:
    path = cdb(tmp_path, ("ET,1,186", "ET,1,SOLID186,,1"), ("KEYOPT,1,2,1\n", ""))
    assert read_volume_mesh(path).blocks[0][0] == "C3D20"


def test_options_and_damping_of_ansys_are_named(tmp_path: Path) -> None:
    more = "KEYOPT,1,3,1\nKEYOPT,1,6,1\nMP,DAMP,1,.1\nC*** a comment, D,1\n"
    more += "*IF,_CDRDOFF,EQ,1,THEN\n_CDRDOFF=\n*ELSE\nNUMOFF,NODE,20\n*ENDIF\n"  # of CDWRITE
    layers = "KEYOPT(3) = 1 of SOLID186 (layers)"
    mixed = "KEYOPT(6) = 1 of SOLID186 (mixed displacements and pressure)"
    assert read_volume_mesh(cdb(tmp_path, more=more)).ignored == ("1 MP,DAMP", layers, mixed)


@pytest.mark.parametrize(
    ("more", "reason"),
    [
        ("*IF,A,EQ,1,THEN\nMP,DENS,1,1\n*ENDIF\n", "without MP that depends on a condition"),
        ("EDELE,1\n", "a file without EDELE, with all nodes and elements listed"),
    ],
)
def test_commands_of_ansys_that_change_the_mesh_are_refused(
    tmp_path: Path, more: str, reason: str
) -> None:
    with pytest.raises(MeshFileError, match=reason):
        read_volume_mesh(cdb(tmp_path, more=more))


def test_held_nodes_and_other_commands_of_ansys(tmp_path: Path) -> None:
    more = "D,1,ALL,0.\nD,2,UX,0.,,4,2,UY,UZ\nD,5,UX\nD,6,UY,0.1\nCERIG,1,2\nTB,SDAMP,1\nACEL,1\n"
    mesh = read_volume_mesh(cdb(tmp_path, more=more))
    assert held(mesh) == [0, 1, 3]
    notes = ("D of single displacements of 1 nodes", "1 D of motions or selected nodes")
    assert mesh.ignored == ("1 CERIG", "1 TB,SDAMP", *notes)


MECHANICAL = """/com,*********** Elements for Body 1 ***********
/wb,elem,start
*set,tid,3
et,tid,{kind}
eblock,10,,,2
(15i9)
      900        3        3        3        0        1        2        3        4
      901        3        3        3        0        1        2        3        4
-1
  alphad,0.0 $ /go
toffst,273.15
/post1
set,list
prnsol,u
/prep7
"""


@pytest.mark.parametrize(
    ("more", "notes"),
    [
        (MECHANICAL.format(kind=154), ()),
        (MECHANICAL.format(kind=174), ("2 elements CONTA174",)),
        (MECHANICAL.format(kind=181), ("2 elements 181",)),
        (MECHANICAL.replace("\net,tid", "\ntype,tid"), ("2 elements of an unknown type",)),
        ("N,R5.1,LOC,       -1,\nEN,R5.5,ATTR,       -1,\nDOF,DELETE\nKUSE,0\n", ()),
        ("TB,BISO,1,1,2\nTBDATA,1,2e8,1e9\nETCONTROL,SET\nLUMPM,0\nCYCLIC\nNROTAT,ALL\n", ()),
        ("TB,ANEL,1,1,21\n", ("1 TB,ANEL",)),
        ("LUMPM,ON\nBETAD,1e-6\nCM,hub,NODE\n", ("1 BETAD", "1 CM", "1 LUMPM")),
        ("CE,R5.0,DEFI,2,1,0.\nCE,R5.0,NODE,5,UX,1.\nCP,1,UX,5,6\n", ("1 CE", "1 CP")),
        ("D,5,UX,%TAB%\n", ("1 D of motions or selected nodes",)),
        ("NSEL,S,LOC,X,0\nD,ALL,ALL\n", ("1 D of motions or selected nodes",)),
    ],
)
def test_commands_of_ansys_are_harmless_or_named(
    tmp_path: Path, more: str, notes: tuple[str, ...]
) -> None:
    mesh = read_volume_mesh(cdb(tmp_path, more=more))
    assert mesh.ignored == notes
    assert not mesh.held


STIFF = f"(7g16.9)\n{3:9d}{6:9d}{'0.':>48}{5.0:16}"


@pytest.mark.parametrize("real", ["R,3,,,,5.\n", f"RLBLOCK,1,3,6,7\n(2i9,6g16.9)\n{STIFF}\n"])
def test_loaded_surfaces_of_ansys_with_a_stiffness_are_named(tmp_path: Path, real: str) -> None:
    mesh = read_volume_mesh(cdb(tmp_path, more=MECHANICAL.format(kind=154) + real))
    assert mesh.ignored == ("2 elements SURF154 with a stiffness or a mass",)


@pytest.mark.parametrize(
    "more", ["D,root,ALL\n", "CMSEL,S,ROOT\nD,ALL,UX\nD,ALL,UY\nD,ALL,UZ\nNSEL,ALL\n"]
)
def test_nodes_of_components_that_ansys_holds(tmp_path: Path, more: str) -> None:
    mesh = read_volume_mesh(cdb(tmp_path, more=more))
    assert held(mesh) == mesh.groups["root"].tolist()
    assert mesh.ignored == ()


def test_a_property_of_ansys_in_its_short_form_is_read(tmp_path: Path) -> None:
    more = "MPTEMP,,,,,,,,\nMPDATA,EX,1,,1e11,\n"
    (section,) = read_volume_mesh(cdb(tmp_path, more=more)).sections
    assert section.properties["young_modulus"] == 1e11
    (section,) = read_volume_mesh(cdb(tmp_path, more="MPDATA,EX,1,2,1e11,\n")).sections
    assert section.unread == "has EX for several temperatures, which is not read"


@pytest.mark.parametrize(
    ("pattern", "new", "reason"),
    [
        (
            r"(?s)\nEBLOCK.*?\n *-1",
            "\nE,1,2,3,4,5,6,7,8",
            "solids in NBLOCK and EBLOCK, as CDWRITE",
        ),
        (r"(?s)(\nNBLOCK.*?\n)(?=N,)", r"\1\1", "each node once; node 1 is there twice"),
        (r"(?s)(\nEBLOCK.*?-1\n)", r"\1\1", "each element once; element 1 is there twice"),
        (r"\n +32 +0 .*", "", r"node 32 of element \d is not defined"),
        (r"2.0000000000000E-01", "2.0000000000x00E-01", "numbers as coordinates of a node"),
        (r"(?s)(\nEBLOCK.*)\n.*?\n *-1\n", r"\1\n", r"all 20 nodes of element \d"),
        (
            r"(?s)(\nEBLOCK.*\n.*?) *\d+\n( *-1\n)",
            r"\1        0\n\2",
            "all mid-side nodes; element 2",
        ),
    ],
)
def test_blocks_of_ansys_that_are_not_complete_are_refused(
    tmp_path: Path, pattern: str, new: str, reason: str
) -> None:
    path = cdb(tmp_path)
    text, count = re.subn(pattern, new, path.read_text(), count=1)
    assert count
    path.write_text(text)
    with pytest.raises(MeshFileError, match=reason):
        read_volume_mesh(path)


def test_an_element_that_is_there_twice_is_named(tmp_path: Path) -> None:
    nodes = (cantilever("hexahedron20", BOXES).cells[0].data[0] + 1).tolist()
    rows = f"900, {str(nodes[:9])[1:-1]},\n{str(nodes[9:])[1:-1]}\n"
    mesh = read_volume_mesh(abaqus(tmp_path, f"*ELEMENT, TYPE=C3D20\n{rows}"))
    assert mesh.ignored == ("1 elements with the nodes of others",)


@pytest.mark.parametrize(("old", "new"), [("186", "95"), ("186", "187")])
def test_former_elements_of_ansys_are_refused_by_name(tmp_path: Path, old: str, new: str) -> None:
    path = cdb(tmp_path, (f"ET,1,{old}", f"ET,1,{new}"))
    if new == "95":
        with pytest.raises(MeshFileError, match="elements 95, for which SOLID186 stands"):
            read_volume_mesh(path)


def abaqus(folder: Path, more: str) -> Path:
    path = folder / "blade.inp"
    path.write_text(deck_text(cantilever("hexahedron20", BOXES), "C3D20") + MATERIAL + more)
    return path


@pytest.mark.parametrize("rows", ["root, 1, 3", "root, 1, 1\nroot, 2, 3, 0.", "ROOT, ENCASTRE"])
def test_boundary_conditions_of_abaqus_are_a_group(tmp_path: Path, rows: str) -> None:
    mesh = read_volume_mesh(abaqus(tmp_path, f"*STEP\n*BOUNDARY\n{rows}\n*END STEP\n"))
    assert held(mesh) == mesh.groups["root"].tolist()
    assert mesh.ignored == ()


def test_other_keywords_of_abaqus_are_named(tmp_path: Path) -> None:
    more = "*BOUNDARY\nroot, 1, 3\n1, 2, 2, 0.1\ntip, 3\n*DAMPING, ALPHA=1\n*NOVELTY\n"
    more += "*CLOAD\n1, 1, 5\n"
    mesh = read_volume_mesh(abaqus(tmp_path, more))
    tips = len(mesh.groups["tip"])
    assert mesh.ignored == (
        *("1 *BOUNDARY of motions", "1 *DAMPING", "1 *NOVELTY"),
        f"*BOUNDARY of single displacements of {tips} nodes",
    )


@pytest.mark.parametrize(
    ("more", "note"),
    [
        ("*HEAT TRANSFER\n*FILM\n1, F1, 20, 5\n*BOUNDARY\ntip, 11, 11, 293.\n", None),
        ("*ORIENTATION, NAME=O\n1, 0, 0, 0, 1, 0\n*NODEFILE\nU\n*ENDSTEP\n", None),
        ("*INITIAL CONDITIONS, TYPE=TEMPERATURE\nroot, 20\n", None),
        ("*SECTION CONTROLS, NAME=E, HOURGLASS=ENHANCED\n", None),  # elements without such modes
        ("*CONNECTOR BEHAVIOR, NAME=c\n", None),
        ("*ELEMENT, TYPE=T3D2, ELSET=edges\n900, 1, 2\n", None),  # as Gmsh writes edges
        (
            "*ELEMENT, TYPE=SFM3D4, ELSET=s\n900, 1, 2, 3, 4\n*SURFACE SECTION, ELSET=s\n",
            None,
        ),
        ("*EQUATION\n2\n1,1,1.,2,1,-1.\n*EQUATION\n2\n1,2,1.,2,2,-1.\n", "2 *EQUATION"),
        ("*INITIAL CONDITIONS, TYPE=STRESS\nall, 1e8\n", "1 *INITIAL CONDITIONS, TYPE=STRESS"),
        ("*MODAL DAMPING\n1, 10, .02\n", "1 *MODAL DAMPING"),
        ("*BOUNDARY, USER\ntip, 1, 3\n", "1 *BOUNDARY, USER"),
        ("*BOUNDARY, SUBMODEL, STEP=1\ntip, 1, 3\n", "1 *BOUNDARY, SUBMODEL"),
        ("*ELEMENT, TYPE=COH3D8, ELSET=c\n900, 1,2,3,4,5,6,7,8\n", "1 elements COH3D8"),
        (
            "*ELEMENT, TYPE=T3D2, ELSET=b\n900, 1, 2\n*SOLID SECTION, ELSET=b, MATERIAL=steel\n",
            "1 elements T3D2",
        ),
        (
            "*ELEMENT, TYPE=SFM3D4, ELSET=s\n900, 1,2,3,4\n*SURFACE SECTION, ELSET=s, DENSITY=1.\n",
            "1 elements SFM3D4",
        ),
    ],
)
def test_what_changes_the_motion_is_named_with_its_number(
    tmp_path: Path, more: str, note: str | None
) -> None:
    mesh = read_volume_mesh(abaqus(tmp_path, more))
    assert mesh.ignored == (() if note is None else (note,))
    assert not held(mesh)


@pytest.mark.parametrize(
    "keyword", ["*HOURGLASS STIFFNESS\n5.\n", "*SECTION CONTROLS, HOURGLASS=E\n"]
)
def test_the_stiffness_of_hourglass_modes_is_named(tmp_path: Path, keyword: str) -> None:
    path = abaqus(tmp_path, keyword)
    path.write_text(deck_text(cantilever("hexahedron", BOXES), "C3D8R") + MATERIAL + keyword)
    assert read_volume_mesh(path).ignored == (f"1 {keyword.partition(',')[0].splitlines()[0]}",)


BODY = "*NODE, NSET=both\n900, .2, 0., 0.\n901, .2, 0., 0.\n*NSET, NSET=at\n900\n"
COUPLING = f"{BODY}*COUPLING, CONSTRAINT NAME=C, REF NODE=at, SURFACE=root\n*KINEMATIC\n"


@pytest.mark.parametrize(
    ("more", "notes"),
    [
        (f"{COUPLING}*BOUNDARY\nat, 1, 6\n", ()),
        (f"{COUPLING}*BOUNDARY\nat, ENCASTRE\n", ()),
        (
            f"{BODY}*RIGID BODY, NSET=root, REFNODE=900, ROTNODE=901\n*BOUNDARY\nboth, 1, 3\n",
            (),
        ),
        (
            f"{COUPLING}*BOUNDARY\nat, PINNED\n",
            ("1 *COUPLING with a reference node that is held in part",),
        ),
        (
            f"{COUPLING.replace('KINEMATIC', 'DISTRIBUTING')}*BOUNDARY\nat, 1, 6\n",
            ("1 *DISTRIBUTING with a reference node that is held",),
        ),
        (f"{COUPLING.replace('KINEMATIC', 'DISTRIBUTING')}*CLOAD\nat, 1, 1.\n", ()),
    ],
)
def test_a_held_reference_node_holds_its_rigid_body(
    tmp_path: Path, more: str, notes: tuple[str, ...]
) -> None:
    mesh = read_volume_mesh(abaqus(tmp_path, more))
    assert mesh.ignored == notes
    assert held(mesh) == ([] if notes or "CLOAD" in more else mesh.groups["root"].tolist())


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (
            "*SOLID SECTION, ELSET=all, MATERIAL=steel",
            "*SOLIDSECTION, ELSET = all, MATERIAL = steel",
        ),
        ("\n", "\r\n"),
        ("*SOLID SECTION", "** \x1a\n*SOLID SECTION"),
    ],
)
def test_blanks_and_ends_of_lines_of_abaqus_do_not_matter(
    tmp_path: Path, old: str, new: str
) -> None:
    path = abaqus(tmp_path, '*BOUNDARY\n"root", 1, 3\n')
    path.write_bytes((path.read_text().replace(old, new) + "\x1a").encode())
    mesh = read_volume_mesh(path)
    assert mesh.ignored == ()
    assert held(mesh) == mesh.groups["root"].tolist()
    assert len(mesh.sections[0].properties) == 3


@pytest.mark.parametrize("kind", ["T3D2", "B31"])
def test_sections_of_other_elements_than_solids_are_no_materials(tmp_path: Path, kind: str) -> None:
    bar = f"*ELEMENT, TYPE={kind}, ELSET=b\n900, 1, 2\n*SOLID SECTION, ELSET=b, MATERIAL=steel\n"
    with pytest.warns(Hint, match=f"1 elements {kind} of blade.inp are not read"):
        first(abaqus(tmp_path, bar), clamped="root")
    with pytest.raises(MeshFileError, match="a set none with elements, which a"):
        read_volume_mesh(abaqus(tmp_path, "*SOLID SECTION, ELSET=none, MATERIAL=steel\n"))


def test_names_in_quotes_may_have_commas(tmp_path: Path) -> None:
    named = '*NSET, NSET="root, outer"\n1, 2\n*NSET, NSET=both\n"root, outer", 3\n'
    groups = read_volume_mesh(abaqus(tmp_path, named)).groups
    assert groups["root, outer"].tolist() == [0, 1]
    assert groups["both"].tolist() == [0, 1, 2]


def test_materials_of_abaqus_that_depend_on_fields_are_refused(tmp_path: Path) -> None:
    path = abaqus(tmp_path, "")
    path.write_text(path.read_text().replace("*ELASTIC", "*ELASTIC, DEPENDENCIES=1"))
    with pytest.raises(CaseError, match=r"has \*ELASTIC, DEPENDENCIES, which is not read"):
        first(path, clamped="root")
    path = abaqus(tmp_path, "*SOLID SECTION, ELSET=tip, COMPOSITE\n.1, 3, steel\n")
    with pytest.raises(MeshFileError, match="of one MATERIAL, without COMPOSITE"):
        read_volume_mesh(path)


def test_held_nodes_that_are_not_clamped_are_named(tmp_path: Path) -> None:
    path = abaqus(tmp_path, "*BOUNDARY\nroot, 1, 3\n")
    assert first(path, clamped="*BOUNDARY") == pytest.approx(first(path, clamped="root"))
    with pytest.warns(Hint, match=r"\d+ nodes that \*BOUNDARY of blade.inp holds are not clamped"):
        bw.mesh3d(path, clamped="x = 0.2 and y < -0.0129", contact="x = 0.3")


@pytest.mark.parametrize(
    ("row", "expected"),
    [("9, 1, -4", [0, 4, 8]), ("5, 5", [4]), ("1, 9, 4,", [0, 4, 8]), ("1, 8, 4", None)],
)
def test_ranges_of_abaqus_reach_their_last_number(
    tmp_path: Path, row: str, expected: list[int] | None
) -> None:
    path = abaqus(tmp_path, f"*NSET, NSET=chosen, GENERATE\n{row}\n")
    if expected is None:
        with pytest.raises(MeshFileError, match=r"ranges whose step leads .* got 1, 8, 4"):
            read_volume_mesh(path)
    else:
        assert read_volume_mesh(path).groups["chosen"].tolist() == expected


@pytest.mark.parametrize("keyword", ["*ELEMENT, TYPE=C3D20", "*ELEMENT, TYPE=MASS"])
def test_blank_fields_of_an_element_of_abaqus_are_refused(tmp_path: Path, keyword: str) -> None:
    """Left out, they would move the following nodes, and those of the next element, forward."""
    nodes = ", ".join(map(str, range(1, 20)))
    with pytest.raises(MeshFileError, match=r"a number in every field, got 900, , 1.*ELEMENT"):
        read_volume_mesh(abaqus(tmp_path, f"{keyword}\n900, , {nodes}, 20, 21\n"))


def test_a_blank_field_of_a_material_of_abaqus_keeps_its_place(tmp_path: Path) -> None:
    path = abaqus(tmp_path, "")
    path.write_text(path.read_text().replace("2.1e11, 0.3", ", 0.3"))
    (section,) = read_volume_mesh(path).sections
    assert section.properties == {"poisson_ratio": 0.3, "density": 7800.0}


def test_boundary_conditions_of_abaqus_that_would_hold_nothing_are_refused(tmp_path: Path) -> None:
    with pytest.raises(MeshFileError, match="degrees of freedom from low to high, got 3, 1"):
        read_volume_mesh(abaqus(tmp_path, "*BOUNDARY\nroot, 3, 1\n"))


def test_boundary_conditions_of_abaqus_that_free_nodes_are_named(tmp_path: Path) -> None:
    held_first, again = "*BOUNDARY\nroot, 1, 3\n", "*STEP\n*BOUNDARY, OP=NEW\nroot, 1, 3\n"
    other = "*STEP\n*BOUNDARY, OP=NEW\ntip, 1, 3\n*BOUNDARY, OP=NEW\n1, 1, 3\n*END STEP\n"
    mesh = read_volume_mesh(abaqus(tmp_path, held_first + other))
    assert mesh.ignored == ("1 *BOUNDARY, OP=NEW, which frees nodes held before it",)
    assert held(mesh) == sorted({0, *mesh.groups["tip"].tolist()})
    for steps in (again, held_first + again, again + again):
        mesh = read_volume_mesh(abaqus(tmp_path, steps))
        assert mesh.ignored == ()
        assert held(mesh) == mesh.groups["root"].tolist()


def test_ranges_of_any_length_take_no_time(tmp_path: Path) -> None:
    mesh = read_volume_mesh(abaqus(tmp_path, "*BOUNDARY\nroot, 1, 999999999999999\n"))
    assert held(mesh) == mesh.groups["root"].tolist()
    with pytest.raises(MeshFileError, match="ranges of at most 5000000 nodes, got 1 to 99999999"):
        read_volume_mesh(cdb(tmp_path, more="D,1,ALL,,,99999999\n"))


def test_grdset_holds_nodes_without_constraints_of_their_own(tmp_path: Path) -> None:
    mesh = read_volume_mesh(bulk(tmp_path, more="GRDSET,,,,,,,123\n"))
    assert len(held(mesh)) == len(mesh.points)


def test_a_property_of_ansys_without_material_belongs_to_the_first(tmp_path: Path) -> None:
    path = cdb(tmp_path, more="MP,DENS,,9000\n")
    given = [section.properties["density"] for section in read_volume_mesh(path).sections]
    assert given == [9000.0]


def test_messages_are_not_those_of_code(tmp_path: Path) -> None:
    for text in ("GRID,1\nCHEXA,1\n", "GRID,1,,0.\nSPC1\n", "SPCADD\nGRID,1\nSET1\n", "GRID,x\n"):
        (tmp_path / "a.bdf").write_text(f"BEGIN BULK\n{text}ENDDATA\n")
        with pytest.raises(MeshFileError) as caught:
            read_volume_mesh(tmp_path / "a.bdf")
        for inner in ("KeyError", "IndexError", "ValueError", "invalid literal", "unpack"):
            assert inner not in str(caught.value)
