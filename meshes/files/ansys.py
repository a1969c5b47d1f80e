"""Meshes of solids in .cdb files of Ansys (CDWRITE), read with meshlane.

meshlane reads nodes, elements, also of degenerate shapes, and components. It leaves out the types
and materials of the elements; both are read here and passed to it as further components.
"""

import io
from collections import Counter, defaultdict
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

import meshio

from bladewhirl.files import open_text
from bladewhirl.meshes.files.abaqus_solids import SolidMesh
from bladewhirl.meshes.files.ansys_constraints import held_nodes
from bladewhirl.meshes.files.ansys_elements import (
    Element,
    check_numbers_of,
    element_types,
    elements_of,
    other_blocks,
    real_constants,
)
from bladewhirl.meshes.files.ansys_materials import MATERIAL, PLASTIC, materials_of
from bladewhirl.meshes.files.ansys_text import (
    COMMANDS,
    HARMLESS,
    MODELS,
    RESULTS,
    USED,
    Command,
    canonical,
    commands_of,
    is_number,
    words,
)
from bladewhirl.meshes.files.groups import MeshFileError, check_numbers
from bladewhirl.meshes.files.meshio_cells import readable

INTEGRATION = {
    ("hexahedron", 185): {0: "C3D8", 1: "C3D8R", 2: "C3D8I", 3: "C3D8I"},
    ("hexahedron20", 186): {0: "C3D20R", 1: "C3D20"},
}
"""Element for each value of KEYOPT(2), by the cell and the number of the element of Ansys. SOLID185
has selective reduced integration where C3D8 has full integration."""

OTHERS = {"tetra": "C3D4", "tetra10": "C3D10", "wedge": "C3D6", "wedge15": "C3D15"}
"""Elements of cells whose integration has no options."""

SOLIDS = (185, 186, 187)  #: numbers of the elements that are read

FORMER = {45: 185, 64: 185, 73: 185, 95: 186, 92: 187}
"""Numbers of former elements of solids, and of those that replace them."""

NAMES = {
    14: "COMBIN14",
    21: "MASS21",
    27: "MATRIX27",
    39: "COMBIN39",
    40: "COMBIN40",
    169: "TARGE169",
    170: "TARGE170",
    **{number: f"CONTA{number}" for number in range(171, 179)},
    179: "PRETS179",
    184: "MPC184",
}
"""Elements beside solids that are left out and named."""

SURFACE = 154  #: number of the element of loads on surfaces
SURFACE_STIFFNESS = (4, 6)
"""Numbers of the real constants of `SURFACE` that are a stiffness and a mass."""

EMPTY = 200  #: number of the element of empty meshes

IGNORED = (*NAMES, SURFACE, EMPTY)
"""Numbers of elements that are left out: contact, masses and springs, loads on surfaces, and empty
meshes."""

FORMULATION = {3: "layers", 6: "mixed displacements and pressure"}
"""KEYOPT of solids beside that of the integration which change the stiffness."""

DAMPING = ("DAMP", "DMPR", "DMPS", "BETD", "ALPD")  #: constants of materials that damp

DAMPERS = ("ALPH", "BETA", "DMPR", "DMPS")
"""First four letters of commands that damp if their number is not 0."""

HELD = "D"  #: name of the group of the nodes that the command D holds


def ansys_mesh(path: Path) -> SolidMesh:
    """Return the elements SOLID185, SOLID186 and SOLID187 of a .cdb file, and its components.

    Raises:
        MeshFileError: the file cannot be read, or has other elements of solids.
    """
    from meshlane import ansysInp  # long to load

    with readable(path, "meshlane"):
        with open_text(path, errors="replace") as stream:
            lines = stream.read().splitlines()
        check_numbers(lines)
        for number, line in enumerate(lines, 1):
            for word in (words(part)[0] for part in line.split("!")[0].split("$")):
                if word[:4] in COMMANDS:
                    listed = "with all nodes and elements listed"
                    raise MeshFileError(f"a file without {word}, {listed} (line {number})")
        lines = [*canonical(lines)]
        commands = commands_of(lines)
        types, keyopts = element_types(lines, commands)
        options = {kind: value for (kind, key), value in keyopts.items() if key == 2}
        elements, dropped = [*elements_of(lines, commands)], {*other_blocks(lines, commands)}
        check_numbers_of(lines, commands, elements)
        used = {one.kind for one in elements}
        _check_types(types, used)
        sets = defaultdict[str, list[int]](list)
        for one in elements:
            if types[one.kind] in SOLIDS:
                sets[f"{MATERIAL}{one.material}"].append(one.number)
            else:
                dropped.update(one.rows)
        if not sets:
            raise MeshFileError(
                "solids in NBLOCK and EBLOCK, as CDWRITE writes them in its blocked form"
            )
        held, partly = held_nodes(lines, commands)
        kept = [line for row, line in enumerate(lines) if row not in dropped]
        nodes = {HELD: held} if held else {}
        text = "\n".join([*kept, *_components(sets), *_components(nodes, "NODE")])
        mesh = ansysInp.read(io.StringIO(text))
        cells = [(block.type, block.data) for block in mesh.cells]
        converted = meshio.Mesh(
            mesh.points, cells, point_sets=mesh.point_sets, cell_sets=mesh.cell_sets
        )
        kinds = {(types[kind], options.get(kind, 0)) for kind in used if types[kind] in SOLIDS}
        return SolidMesh(
            converted,
            tuple(_element(block.type, kinds) for block in mesh.cells),
            tuple(materials_of(commands, sets)),
            ignored=(
                *_other_elements(lines, commands, elements, types),
                *_ignored(commands, {types[kind] for kind in used}),
                *_formulation(keyopts, types),
                *partly,
            ),
            held=HELD if held else "",
        )


def _check_types(types: Mapping[int, int], used: Collection[int]) -> None:
    """Check that the types of the elements that are used are known and read, or left out."""
    if unknown := {*used} - types.keys():
        raise MeshFileError(f"a type for all elements; type {min(unknown)} has no ET")
    if others := {types[kind] for kind in used} - {*SOLIDS, *IGNORED}:
        new = {kind: f", for which SOLID{FORMER[kind]} stands" for kind in FORMER}
        names = ", ".join(f"{kind}{new.get(kind, '')}" for kind in sorted(others))
        raise MeshFileError(f"elements SOLID185, SOLID186, SOLID187; found elements {names}")


def _other_elements(
    lines: list[str], commands: list[Command], elements: list[Element], types: Mapping[int, int]
) -> Iterator[str]:
    """Yield the elements beside solids that change the motion, with their number."""
    beside = [
        (types.get(kind, 0), constants)
        for constants, kind in other_blocks(lines, commands).values()
        if kind
    ]
    counts = Counter(number for number, _ in beside)
    own = [(types[one.kind], one.constants) for one in elements if types[one.kind] not in SOLIDS]
    counts.update(number for number, _ in own)
    for number in sorted(counts.keys() - {SURFACE, EMPTY}):
        yield f"{counts[number]} elements {NAMES.get(number, number or 'of an unknown type')}"
    stiff = {
        number for number, place in real_constants(lines, commands) if place in SURFACE_STIFFNESS
    }
    loaded = sum(number == SURFACE and constants in stiff for number, constants in own + beside)
    if loaded:
        yield f"{loaded} elements SURF154 with a stiffness or a mass"


def _ignored(commands: list[Command], used: Collection[int]) -> Iterator[str]:
    """Yield the commands that are neither read nor harmless, with their number."""
    counts, results = Counter[str](), False
    for command, given, *_ in commands:
        name = command[:4]
        results = name in RESULTS or (results and name not in MODELS)
        if results:
            continue
        first = given[0] if given else ""
        if name in ("MP", "MPDA"):
            label = next((one for one in given if one in DAMPING), "")
            command, known = f"MP,{label}", not label
        elif name == "TB":
            command, known = f"TB,{first}", first[:4] in PLASTIC
        elif name == "ETCO":
            known = first != "SET" or 185 not in used
        elif name == "LUMP":
            known = first not in ("ON", "1")
        elif name in DAMPERS:
            known = all(is_number(one) and not float(one) for one in filter(None, given))
        elif name == "EN":
            known = "-1" in given  # the end of elements in unblocked form
        elif name in ("CE", "CP"):  # of the lines of one in blocked form the first counts
            known = first.startswith("R") and given[1:2] != ["DEFI"]
        else:
            known = name in USED or name in HARMLESS
        counts[command] += not known
    yield from (f"{count} {command}" for command, count in sorted(counts.items()) if count)


def _formulation(keyopts: Mapping[tuple[int, int], int], types: Mapping[int, int]) -> Iterator[str]:
    """Yield options of the elements of solids that are not read and change their stiffness."""
    for (kind, key), value in sorted(keyopts.items()):
        if types.get(kind) in SOLIDS and key in FORMULATION and value:
            yield f"KEYOPT({key}) = {value} of SOLID{types[kind]} ({FORMULATION[key]})"


def _element(cell: str, kinds: set[tuple[int, int]]) -> str:
    """Return the name of the element of a cell, from the numbers of the elements in the file and
    their KEYOPT(2)."""
    for (kind, number), names in INTEGRATION.items():
        if kind == cell:
            found = {names.get(option, "") for given, option in kinds if given == number}
            if len(found) != 1 or found == {""}:
                raise MeshFileError(f"one known KEYOPT(2) for all elements SOLID{number}")
            return found.pop()
    return OTHERS.get(cell, cell)


def _components(sets: Mapping[str, list[int]], kind: str = "ELEM") -> Iterator[str]:
    for name, members in sets.items():
        yield f"CMBLOCK,{name},{kind},{len(members):9d}"
        yield "(8i10)"
        for start in range(0, len(members), 8):
            yield "".join(f"{member:10d}" for member in members[start : start + 8])
