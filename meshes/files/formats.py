"""Format of a mesh file by its suffix and its text, and messages for formats that are not read."""

import re
from collections.abc import Iterable
from pathlib import Path

from bladewhirl.meshes.files.abaqus_text import head_of, is_abaqus_text

ABAQUS, VTK = ".inp", ".vtu"

OTHERS = {
    ".cdb": "a deck of Ansys",
    ".dat": "a deck of Ansys or Nastran",
    ".bdf": "a deck of Nastran",
    ".nas": "a deck of Nastran",
    ".fem": "a deck of OptiStruct",
    ".med": "a mesh of Code_Aster",
    ".mail": "a mesh of Code_Aster",
    ".unv": "a universal file",
    ".k": "a deck of LS-DYNA",
    ".vtk": "a legacy file of VTK",
    ".stl": "a surface, which Gmsh can mesh",
    ".step": "a geometry, which Gmsh can mesh",
    ".stp": "a geometry, which Gmsh can mesh",
}
"""Suffixes of other files, and what they contain."""


BY_TEXT = {
    ".bdf": re.compile(r"(SOL[ \t]+\w|CEND|BEGIN[ \t]+BULK|GRID[ \t,*]|GRDSET|NASTRAN )", re.I),
    ".cdb": re.compile(r"(/PREP7|/COM|/BATCH|/TITLE|NBLOCK|ETBLOCK|ET,|\*SET,)", re.I),
}
"""Start of a line near the head of a deck of Nastran, and of Ansys."""


def format_of(path: Path) -> str:
    """Return the suffix of the format of a file: that of its name, or `ABAQUS` if its text is; for
    .dat and .inp, which decks of several programs have, that of its text."""
    suffix = path.suffix.lower()
    if suffix in (VTK, ".k"):  # LS-DYNA has keywords, too
        return suffix
    head = head_of(path)
    if is_abaqus_text(head):
        return ABAQUS
    if suffix in (".dat", ABAQUS):
        found = (kind for line in head for kind, of in BY_TEXT.items() if of.match(line))
        return next(found, suffix)
    return suffix


def unreadable(path: Path, formats: Iterable[str]) -> str:
    """Return what is expected in place of a file with another suffix than those that are read."""
    listed = ", ".join(formats)
    kind = OTHERS.get(path.suffix.lower())
    if kind is None:
        return f"a mesh file, {listed}"
    return (
        f"a mesh file, {listed}, not {kind}; convert it, such as with meshio or Gmsh, or write"
        " its matrices in Matrix Market for bladewhirl import"
    )
