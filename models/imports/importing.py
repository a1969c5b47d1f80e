"""Superelements from files of other programs: `bladewhirl.import_superelement`."""

import warnings
from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.imports.calculix import read_calculix
from bladewhirl.models.imports.evidence import check_order, hints_of
from bladewhirl.models.imports.inspection import Inspection, inspect, mass_hints
from bladewhirl.models.imports.nastran import read_nastran
from bladewhirl.models.imports.parts import Choice, ForeignPart, superelement_from
from bladewhirl.models.imports.tables import (
    read_matlab,
    read_matlab_superelement,
    read_matrix_market,
)
from bladewhirl.models.inputs.errors import Hint
from bladewhirl.models.inputs.units import RAD_PER_S, finite, rotation
from bladewhirl.models.superelements.file import read_superelement
from bladewhirl.models.superelements.superelement import (
    FIXED,
    Superelement,
    SuperelementError,
    dense,
    errors_of,
)

MATLAB, SUPERELEMENT = ".mat", ".npz"
CALCULIX, NASTRAN = ".inp", ".op4"  #: formats whose files contain the nodes


def import_superelement(
    source: str | PathLike[str],
    *,
    mass: str | PathLike[str] | None = None,
    nodes: str | PathLike[str] | None = None,
    speed: float | str | None = None,
    at: Mapping[float | str, str | PathLike[str]] | None = None,
    outside_files: bool = False,
    **choice: Any,
) -> Superelement:
    """Make a superelement from the matrices of another finite element code, and check it.

    The name of `source` determines the format:

    - .inp: input of CalculiX, beside .sti, .mas and .dof of the same name, which CalculiX writes in
      a step with ``*FREQUENCY, SOLVER=MATRIXSTORAGE``. Groups are its sets of nodes and elements.
    - .op4: external superelement of Nastran, beside .asm and .pch of the same name; this needs
      pyyeti, ``pip install 'bladewhirl[nastran]'``.
    - .mat: matrices M and K, perhaps D and G, of NLvib or another program. The nodes are in
      `nodes`; without `nodes`, the file has contact nodes and all else as for `read_superelement`.
    - .npz: a superelement.
    - any other name: the stiffness in Matrix Market; `mass` and `nodes` are required. Files of
      lines of row, column and value, without a head, are read too.

    Args:
        source: path of the main file.
        mass: path of the mass matrix in Matrix Market.
        nodes: path of a CSV file with a first line ``node,x,y,z``, the number and position of each
            node. Columns ``row_x,row_y,row_z`` are the rows of its displacements in the matrices,
            from 1; 0 or nothing for fixed displacements. Without these columns each node has the
            same number of consecutive rows, the first of which are x, y and z. A column ``group``
            has the names of groups, separated by blanks.
        speed: speed of rotation to which the stiffness belongs [rad/s], or text such as
            "9000 rpm"; unknown by default, or 0 with `at`.
        at: files with the stiffness of the same part at one or two further speeds, by speed: other
            files like `source`. The stiffness K + Omega^2 K1 + Omega^4 K2 is fitted to them;
            without a second one, K2 = 0. Stiffnesses include the spin softening.
        outside_files: whether files that the input of CalculiX names in ``*INCLUDE`` and ``INPUT=``
            may be outside its folder.
        choice: contact, clamped and hub (groups, conditions on positions, or numbers of nodes
            separated by commas), contacts, left, right, copies, length_unit, mass_unit, axis and
            name, see `mesh3d`. `clamped` is needed only if the matrices contain nodes to clamp. The
            matrices contain all nodes of `hub`; their stiffnesses at speeds are those with these
            nodes held in the static state only. The unit of time is the second.

    Returns:
        the superelement, in SI units.

    Raises:
        SuperelementError: files are missing or invalid, or describe no structure: matrices are
            indefinite or not symmetric, nodes are unknown, or the first frequency is implausible.
    """
    part, inspection, _ = imported(
        *(source,),
        mass=mass,
        nodes=nodes,
        speed=speed,
        at=at,
        outside_files=outside_files,
        **choice,
    )
    for hint in inspection.hints:
        warnings.warn(hint, Hint, stacklevel=2)
    return part


def imported(
    source: str | PathLike[str],
    *,
    mass: str | PathLike[str] | None = None,
    nodes: str | PathLike[str] | None = None,
    speed: float | str | None = None,
    at: Mapping[float | str, str | PathLike[str]] | None = None,
    outside_files: bool = False,
    **choice: Any,
) -> tuple[Superelement, Inspection, FloatArray | None]:
    """Return a superelement, its properties, and its mass along x, y and z without fixed nodes
    [kg], (3,). The mass is None if the file is already a superelement. See `import_superelement`.
    """
    path = Path(source)
    given = {key: value for key, value in choice.items() if value is not None}
    if path.suffix.lower() == SUPERELEMENT or (path.suffix.lower() == MATLAB and nodes is None):
        if given.keys() - {"name"} or at or any(x is not None for x in (mass, nodes, speed)):
            reason = "a superelement states its own contact nodes and units"
            if path.suffix.lower() == MATLAB:
                reason = "without a table of nodes, the file states contact nodes and units itself"
            raise SuperelementError(
                f"{path}: of the other arguments only name is allowed; {reason}"
            )
        read = (
            read_superelement if path.suffix.lower() == SUPERELEMENT else read_matlab_superelement
        )
        part = replace(read(path), **given)
        with errors_of(path):
            return part, inspect(part), None
    foreign = _read(path, mass, nodes, outside_files)
    if speed is not None:
        foreign = replace(foreign, speed=_speed("speed", speed))
    if at:
        if len(at) > 2:
            raise SuperelementError(
                f"{path}: at: expected one or two further speeds, got {len(at)}"
            )
        further = {
            _speed("at", each): _read(Path(file), mass, nodes, outside_files).stiffness
            for each, file in at.items()
        }
        with errors_of(path):
            foreign = foreign.over_speeds(further)
    if "contact" not in given:
        raise SuperelementError(f"{path}: expected contact nodes: a group or numbers of nodes")
    with errors_of(path):
        check_order(foreign)
        part, along = superelement_from(foreign, Choice(**given))
        total = dense(along @ part.mass @ along.T).diagonal()
        inspection = inspect(part)
        free = "clamped" in given
        held = free or bool((foreign.dofs == FIXED).all(axis=1).any())
        alone = held and part.left_dofs is None
        evidence = hints_of(foreign, total, inspection.rigid_modes, free=free, clamped=alone)
        hints = (*inspection.hints, *mass_hints(part, float(total.max())), *evidence)
        return part, replace(inspection, hints=hints), total


def _speed(key: str, value: float | str) -> float:
    try:
        return rotation(value, RAD_PER_S) if isinstance(value, str) else finite(value)
    except (TypeError, ValueError) as error:
        expected = f'a number in rad/s, or text such as "9000 rpm" ({error})'
        raise SuperelementError(f"{key} = {value}: expected {expected}") from None


def _read(
    path: Path,
    mass: str | PathLike[str] | None,
    nodes: str | PathLike[str] | None,
    outside: bool,
) -> ForeignPart:
    if path.suffix.lower() in (CALCULIX, NASTRAN):
        if mass is not None or nodes is not None:
            raise SuperelementError(
                f"{path}: mass and nodes are not allowed; they are in the files beside it"
            )
        if path.suffix.lower() == NASTRAN:
            return read_nastran(path)
        return read_calculix(path, outside=outside)
    if nodes is None:
        raise SuperelementError(
            f"{path}: expected a table of nodes (a CSV file with node,x,y,z) beside the matrices"
        )
    if path.suffix.lower() == MATLAB:
        return read_matlab(path, Path(nodes))
    if mass is None:
        raise SuperelementError(f"{path}: expected the mass too, in a second file of Matrix Market")
    return read_matrix_market(path, Path(mass), Path(nodes))
