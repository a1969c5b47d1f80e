"""Reading and writing of mesh files by their suffix: .vtu, .msh, .inp."""

from errno import ENOENT
from os import PathLike, strerror
from pathlib import Path

from bladewhirl.files import replacing
from bladewhirl.meshes.files.abaqus_lines import POINT_MASSES, SECTION, read_inp
from bladewhirl.meshes.files.abaqus_writer import write_inp
from bladewhirl.meshes.files.formats import format_of, unreadable
from bladewhirl.meshes.files.gmsh import read_msh, write_msh
from bladewhirl.meshes.files.groups import GroupedLines, MeshFileError
from bladewhirl.meshes.files.vtu import read_vtu, write_vtu

READERS = {".vtu": read_vtu, ".msh": read_msh, ".inp": read_inp}
WRITERS = {".vtu": write_vtu, ".msh": write_msh, ".inp": write_inp}

MOST_LINES = 100_000  #: largest number of lines in a mesh that is read


def read_line_mesh(path: str | PathLike[str]) -> GroupedLines:
    """Read a mesh of straight lines with its groups.

    Args:
        path: path of a .msh file of Gmsh with physical groups, a .vtu file or an .inp file of
            Abaqus.

    Raises:
        MeshFileError: the file does not exist, has another suffix, or does not contain a mesh of
            straight lines in a plane; the text completes "expected ...".
    """
    file = Path(path)
    if file.exists() and not file.is_file():
        raise MeshFileError("a regular file")
    kind = format_of(file)
    if kind not in READERS:
        raise MeshFileError(unreadable(file, READERS))
    mesh = READERS[kind](file)
    if len(mesh.lines) > MOST_LINES:
        raise MeshFileError(f"at most {MOST_LINES} lines; the mesh has {len(mesh.lines)}")
    if not (mesh.lines.min() >= 0 and mesh.lines.max() < len(mesh.points)):
        raise MeshFileError("all nodes of the lines; some nodes are not defined")
    return mesh


def write_line_mesh(path: str | PathLike[str], mesh: GroupedLines) -> None:
    """Write a mesh of straight lines with its groups and the data that the format supports.

    Args:
        path: path of the file. A .vtu file contains everything, a .msh file has groups and data as
            physical groups, an .inp file has sets, sections and masses.
        mesh: mesh to write.

    Raises:
        MeshFileError: the suffix is unknown, or the format does not allow a name.
        OSError: the file cannot be written.
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
