"""Mesh files by their suffix: .vtu, .msh, .inp."""

from __future__ import annotations

from errno import ENOENT
from os import PathLike, strerror
from pathlib import Path

from bladewhirl.files import replacing
from bladewhirl.meshes.files.abaqus_reader import POINT_MASSES, SECTION, read_inp
from bladewhirl.meshes.files.abaqus_writer import write_inp
from bladewhirl.meshes.files.gmsh import read_msh, write_msh
from bladewhirl.meshes.files.groups import GroupedLines, MeshFileError
from bladewhirl.meshes.files.vtu import read_vtu, write_vtu

READERS = {".vtu": read_vtu, ".msh": read_msh, ".inp": read_inp}
WRITERS = {".vtu": write_vtu, ".msh": write_msh, ".inp": write_inp}

MOST_BYTES = 100_000_000
"""Largest file that is read."""

MOST_LINES = 100_000
"""Largest mesh file that is read."""


def read_line_mesh(path: str | PathLike[str]) -> GroupedLines:
    """Read a mesh of straight lines with its groups.

    Args:
        path: Gmsh's .msh with physical groups, .vtu, or Abaqus's .inp.

    Raises:
        MeshFileError: no such file or suffix, or what is in it is no mesh of straight lines in a
            plane; completes "expected ...".
    """
    file = Path(path)
    if file.exists() and not file.is_file():
        raise MeshFileError("a regular file")
    if file.exists() and file.stat().st_size > MOST_BYTES:
        raise MeshFileError(f"a file of at most {MOST_BYTES / 1e6:.0f} MB")
    mesh = READERS[_known_suffix(file)](file)
    if len(mesh.lines) > MOST_LINES:
        raise MeshFileError(f"at most {MOST_LINES} lines; it has {len(mesh.lines)}")
    if not (mesh.lines.min() >= 0 and mesh.lines.max() < len(mesh.points)):
        raise MeshFileError("all nodes of the lines; some nodes are not defined")
    return mesh


def write_line_mesh(path: str | PathLike[str], mesh: GroupedLines) -> None:
    """Write a mesh of straight lines with its groups and the data that the format supports.

    Args:
        path: .vtu (complete), .msh (physical groups) or .inp (sets, sections, masses).
        mesh: to write.

    Raises:
        MeshFileError: another suffix, or names that the format does not hold.
        OSError: the file can't be written.
    """
    file = Path(path)
    write = WRITERS[_known_suffix(file)]
    if not file.parent.is_dir():
        raise FileNotFoundError(ENOENT, strerror(ENOENT), str(file))
    with replacing(file) as draft:
        write(draft, mesh)


def left_out(path: str | PathLike[str], mesh: GroupedLines) -> list[str]:
    """Return the names of the data that the format of a file does not support."""
    if _known_suffix(Path(path)) != ".inp":
        return []
    stored = (*SECTION, *POINT_MASSES.values())
    return [name for name in (*mesh.node_data, *mesh.line_data) if name not in stored]


def _known_suffix(path: Path) -> str:
    suffix = path.suffix.lower()
    if suffix not in READERS:
        raise MeshFileError(f"a mesh file, {', '.join(READERS)}")
    return suffix
