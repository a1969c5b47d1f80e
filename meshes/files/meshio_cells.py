"""Handling of errors and of lines in meshes that are read with meshio, for all its formats."""

import io
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from meshio._mesh import topological_dimension
from numpy.typing import NDArray

from bladewhirl.files import reason_of
from bladewhirl.meshes.files.groups import MeshFileError, OtherCellsError

# meshio 5.3 reads and writes wedges with 15 nodes, but has forgotten their dimension.
topological_dimension.setdefault("wedge15", 3)

LINE, POINT = "line", "vertex"


@contextmanager
def readable(path: Path, library: str = "meshio") -> Iterator[None]:
    """Turn every error and warning of the readers of a library into a `MeshFileError`.

    The readers check little. On a damaged file the readers raise exceptions of any type, cause a
    warning of numpy about incomplete text, or print a note to standard error.

    Raises:
        MeshFileError: the file cannot be read; the text contains the reason.
    """
    notes = io.StringIO()
    try:
        with warnings.catch_warnings(), redirect_stderr(notes):
            warnings.simplefilter("error")
            yield
    except MeshFileError:
        raise
    except OSError as error:
        raise MeshFileError(f"a readable file ({error.strerror or error})") from None
    except Exception as error:
        reason = f" ({own})" if (own := reason_of(error)) else ""
        raise MeshFileError(f"a {path.suffix} file that {library} can read{reason}") from None
    if notes.getvalue():
        reason = " ".join(notes.getvalue().split())
        raise MeshFileError(f"a {path.suffix} file that {library} can read ({reason})")


def line_blocks(mesh: meshio.Mesh) -> list[int]:
    """Return the numbers of the cell blocks with two-node lines.

    Raises:
        MeshFileError: there are other cells than lines and points, or there are no lines.
    """
    for block in mesh.cells:
        if block.type in (LINE, POINT) or not len(block.data):
            continue
        cells = f"{len(block.data)} {{}}cells of type {block.type}"
        if block.type.startswith("line") or "CURVE" in block.type:
            raise MeshFileError(
                f"straight two-node lines, found {cells.format('curved ')}: mesh with elements of"
                " first order, and shorter ones along curves"
            )
        raise OtherCellsError(f"lines only, found {cells.format('')}")
    blocks = [n for n, block in enumerate(mesh.cells) if block.type == LINE and len(block.data)]
    if not blocks:
        raise MeshFileError("a mesh with lines; there are none")
    return blocks


def stacked(arrays: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Concatenate arrays; without arrays, return an empty array."""
    return np.concatenate(arrays) if len(arrays) else np.zeros(0, dtype=np.int64)
