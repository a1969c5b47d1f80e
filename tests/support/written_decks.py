"""Meshes of solids as files of Ansys, Nastran and Code_Aster, written by meshlane."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import meshlane
import numpy as np
from solid_meshes import cantilever

ANSYS_STEEL = """MPTEMP,R5.0, 1, 1,  0.00000000    ,
MPDATA,R5.0, 1,EX  ,       1, 1,  210000000000.    ,
MPDATA,R5.0, 1,PRXY,       1, 1, 0.300000000    ,
MPDATA,R5.0, 1,DENS,       1, 1,  7800.00000    ,
"""
NASTRAN_STEEL = "MAT1,7,2.1+11,,0.3,7800.\nPSOLID,3,7\n"


def rounded(kind: str, boxes: tuple[int, int, int] = (3, 2, 1)) -> meshio.Mesh:
    """Return a blade with short coordinates: meshlane writes no long negative ones for Nastran."""
    mesh = cantilever(kind, boxes)
    mesh.points = mesh.points.round(8)
    return mesh


def as_meshlane(mesh: meshio.Mesh, **data: Any) -> Any:
    cells = [(block.type, block.data) for block in mesh.cells]
    return meshlane.Mesh(mesh.points, cells, point_sets=mesh.point_sets, **data)


def ansys(path: Path, mesh: meshio.Mesh) -> None:
    file = path.with_suffix(".cdb")
    meshlane.ansysInp.write(str(file), as_meshlane(mesh))
    text = file.read_text().replace("ET,1,285", "ET,1,185")
    text = text.replace("NBLOCK", f"{ANSYS_STEEL}KEYOPT,1,2,1\nNBLOCK")
    # KEYOPT(2) = 1 is full integration of SOLID186, but reduced integration of SOLID185.
    file.write_text(text.replace("KEYOPT,1,2,1\n", "") if "ET,1,185" in text else text)


def nastran(path: Path, mesh: meshio.Mesh) -> None:
    file = path.with_suffix(".bdf")
    refs = [np.full(len(block.data), 3) for block in mesh.cells]
    meshlane.nastran.write(str(file), as_meshlane(mesh, cell_data={"nastran:ref": refs}))
    root, tip = (mesh.point_sets[name] + 1 for name in ("root", "tip"))
    sets = "".join(f"SPC1,1,123456,{node}\n" for node in root) + f"SET1,2,{_lines(tip)}\n"
    text = file.read_text().replace("ENDDATA", f"{NASTRAN_STEEL}{sets}ENDDATA")
    # meshlane adds a low line to the names of elements of second order.
    file.write_text(re.sub(r"^(C[A-Z]+)_", r"\1 ", text, flags=re.MULTILINE))


def _lines(numbers: Any) -> str:
    words = list(map(str, numbers))
    rows = [words[:7], *(words[at : at + 8] for at in range(7, len(words), 8))]
    return "\n,".join(",".join(row) for row in rows)


def code_aster(path: Path, mesh: meshio.Mesh) -> None:
    meshlane.med.write(str(path.with_suffix(".med")), as_meshlane(mesh))


WRITERS: dict[str, Callable[[Path, meshio.Mesh], None]] = {
    ".cdb": ansys,
    ".bdf": nastran,
    ".med": code_aster,
}
GROUPS = {".bdf": {"clamped": "SPC 1", "contact": "SET 2"}}
