"""Fields and continuations of bulk data of Nastran, and coordinate systems of nodes."""

from pathlib import Path

import numpy as np
import pytest

from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.files.nastran_entries import entries
from bladewhirl.meshes.files.volumes import VolumeMesh, read_volume_mesh

WHOLE = [("CHEXA", ["2", "1", *map(str, range(11, 19))])]


def read(text: str) -> list[tuple[str, list[str]]]:
    return [(one.name, one.fields) for one in entries(f"BEGIN BULK\n{text}\nENDDATA\n")]


@pytest.mark.parametrize(
    "text",
    [
        "CHEXA,2,1,11,12,13,14,15,16,+A\n+A,17,18",
        "chexa , 2 , 1 , 11 , 12 , 13 , 14 , 15 , 16 ,\n, 17 , 18",
        "CHEXA\t2\t1\t11\t12\t13\t14\t15\t16\n\t17\t18",
        "CHEXA   2       1       11      12      13      14      15      16      +A\n"
        "$ a comment, and a blank line\n\n"
        "+A      17      18 $ another",
        "CHEXA*,2,1,11,12\n*,13,14,15,16\n*,17,18",
        "CHEXA*  2               1               11              12\n"
        "*       13              14              15              16\n+       17      18",
        "CHEXA   2       1       11      12      13      14      15      16\n"
        "*       17              18",
        "CHEXA,2,1,11,12,13,14,15,16\n,17,18\r\nENDDATA\nCONM2,9,11,,1.",
        "  CHEXA,2,1,11,12,13,14,15,16\n,17,18\n\x1a",
    ],
)
def test_all_ways_to_write_an_entry(text: str) -> None:
    assert read(text) == WHOLE


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("GRID,1,,0.,0.,0.\n=,*(1),=,*(.1),==", r"without repetition .*\(line 3\)"),
        ("CHEXA,2,1,11,12,13,14,15,16,17,18", r"at most 8 fields .*\(line 2\)"),
        ("SPC1,1,123,1,2,3,4,5,6,7,8,9,10", "at most 8 fields"),
        ("GRID*,1,,0.,0.,5.", "at most 4 fields"),
        ("CHEXA,2,1,11,12,13,14,15,16,+A\n+B,17,18", r"continuations after the line .*\(line 3\)"),
        ("+,17,18", "continuations after the line they continue"),
        ("GRID 1 0 0. 0. 0.", "the name of an entry in 8 columns .* got 'GRID 1 0'"),
    ],
)
def test_entries_that_would_be_read_in_part_are_refused(text: str, reason: str) -> None:
    with pytest.raises(MeshFileError, match=reason):
        read(text)


def test_numbers_are_named_with_field_and_line() -> None:
    (entry,) = entries("$\nGRID,1,,1.5-3,-2.D+1,abc,1.5\n")
    assert (entry.real(2), entry.real(3), entry.whole(1, 7)) == (1.5e-3, -20.0, 7)
    with pytest.raises(MeshFileError, match=r"a number in field 6 of GRID \(line 2\), got 'ABC'"):
        entry.real(4)
    with pytest.raises(MeshFileError, match=r"a whole number in field 7 of GRID .* got '1\.5'"):
        entry.whole(5)


def tetra(folder: Path, nodes: str, more: str) -> VolumeMesh:
    (folder / "a.bdf").write_text(f"BEGIN BULK\n{nodes}CTETRA,1,1,1,2,3,4\n{more}ENDDATA\n")
    return read_volume_mesh(folder / "a.bdf")


SYSTEMS = {
    "CORD2R": ("1.,2.,3.", "2.,2.,3.", "1.,3.,3.", "1.,2.,4."),
    "CORD2C": ("0.,90.,0.", "1.,0.,0.", "1.,90.,0.", "0.,0.,1."),
    "CORD2S": ("0.,0.,0.", "1.,90.,0.", "1.,90.,90.", "1.,0.,0."),
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_nodes_in_other_coordinates_are_at_their_places(tmp_path: Path, name: str) -> None:
    """The system 5 has its origin at (1, 0, 0) of 6, which is turned by 90 degrees about z."""
    nodes = "".join(f"GRID,{n},5,{xyz}\n" for n, xyz in enumerate(SYSTEMS[name], 1))
    more = f"{name},5,6,1.,0.,0.,1.,0.,1.\n,2.,0.,0.\nCORD2R,6,,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\n"
    local = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    shift = np.array([1.0, 2, 3]) if name == "CORD2R" else np.zeros(3)
    x, y, z = (local + shift + [1.0, 0.0, 0.0]).T
    points = tetra(tmp_path, nodes, more).points
    assert points == pytest.approx(np.column_stack([-y, x, z]), abs=1e-12)


def test_systems_of_nodes_and_the_default_of_grdset(tmp_path: Path) -> None:
    nodes = "GRDSET,,9\nGRID,1,0,1.,0.,0.\nGRID,2,0,1.,0.,1.\nGRID,3,0,1.,1.,0.\nGRID,4,,2.,0.,3.\n"
    points = tetra(tmp_path, nodes, "CORD1C,8,1,2,3,9,1,2,3\n").points
    assert points[3] == pytest.approx([1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("more", "reason"),
    [
        ("", "a coordinate system 5 of the types .*; there is none"),
        ("CORD2R,5,5,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n", "not defined by themselves; 5 is"),
        ("CORD1R,5,1,2,9\n", "all nodes of the coordinate systems; node 9 is not defined"),
        ("CORD2R,5,,0.,0.,0.,0.,0.,1.\n,0.,0.,2.\n", "three points that are not in a line"),
        ("CORD1R,5,1,2,3\nCORD1R,5,1,2,3\n", "each coordinate system once; 5 is there twice"),
    ],
)
def test_coordinate_systems_that_are_not_valid(tmp_path: Path, more: str, reason: str) -> None:
    nodes = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,5,0.,0.,1.\n"
    with pytest.raises(MeshFileError, match=reason):
        tetra(tmp_path, nodes, more)


def test_the_modulus_that_a_mat1_leaves_out_follows_from_the_others(tmp_path: Path) -> None:
    nodes = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n"
    (section,) = tetra(tmp_path, nodes, "PSOLID,1,3,,BUBBLE\nMAT1,3,,8.+10,.25,7800.\n").sections
    expected = {"young_modulus": 2e11, "poisson_ratio": 0.25, "density": 7800.0}
    assert dict(section.properties) == pytest.approx(expected)
