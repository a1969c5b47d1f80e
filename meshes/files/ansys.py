"""Meshes of solids in .cdb files of Ansys (CDWRITE), read with meshlane.

meshlane reads nodes, elements, also of degenerate shapes, and components. It leaves out the types
and materials of the elements; both are read here and passed to it as further components.
"""

import io
import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path

import meshio

from bladewhirl.files import open_text
from bladewhirl.meshes.files.abaqus_solids import Section, SolidMesh
from bladewhirl.meshes.files.groups import MeshFileError, check_numbers, constant
from bladewhirl.meshes.files.meshio_cells import readable

MATERIAL = "MAT"  #: start of the name of the group of the elements with a material

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
    184: "MPC184",
}
"""Elements beside solids that are left out and named."""

CONTACT = range(169, 180)  #: numbers of the elements of contact

COMMANDS = frozenset(
    "/INP *DO *DOW *REP *USE *CRE *GO NGEN EGEN FILL NMOD NSCA EDEL NDEL EMOD".split()
)
"""First four letters of commands that read files, repeat others or change the mesh."""

USED = {
    **{name[:4]: name for name in ("ETBLOCK", "KEYOPT", "NBLOCK", "EBLOCK", "CMBLOCK")},
    **{name[:4]: name for name in ("ET", "MP", "MPDATA", "N", "D", "*SET")},
}
"""Commands that are read, by the first four letters, which are those that matter; N is the end of
NBLOCK."""

HARMLESS = frozenset(
    (
        "/COM /PRE /NOP /GOP /TIT /STI /UNI /BAT /OUT /SOL /CON /INQ /FIL *IF *ELS *END *GET *DEL"
        " MPTE FINI ALLS NSEL ESEL CMSE DOFS ANTY NLGE NCNV TIME TREF TUNI BFUN BF BFE BFBL F SF"
        " SFE SFEB SFCU ACEL OMEG CMOM DOME CGLO CGOM IRLF AUTO NSUB DELT KBC EQSL RESC OUTR OUTP"
        " TIMI NUMO KEYW SHPP VFOP ERES EXTO CSYS LOCA DSYS RLBL R RMOR REAL SECT SECD SECB SECO"
        " SECC TYPE MAT ESYS PRED LNSR NROP SSTI PSTR MODO HARF LUMP SOLV SAVE ETCO MXPA SOLC"
        " CNVT LSCL"
    ).split()
)
"""First four letters of commands that say nothing about the linear motion."""

IGNORED = (*CONTACT, *NAMES, 154, 200)
"""Numbers of elements that are left out: contact, masses and springs, loads on surfaces, and empty
meshes."""

FORMULATION = {3: "layers", 6: "mixed displacements and pressure"}
"""KEYOPT of solids beside that of the integration which change the stiffness."""

DAMPING = ("DAMP", "DMPR", "DMPS", "BETD", "ALPD")  #: constants of materials that damp

HELD = "D"  #: name of the group of the nodes that the command D holds

COMMAND = re.compile(r"[A-Za-z/*][^,!]*")

CONSTANTS = {
    "EX": "young_modulus",
    "NUXY": "poisson_ratio",
    "PRXY": "poisson_ratio",
    "DENS": "density",
}
DIRECTIONAL = ("EY", "EZ", "GXY", "GYZ", "GXZ", "NUYZ", "NUXZ", "PRYZ", "PRXZ")
"""Constants of orthotropic materials."""


class _Material(Section):
    """Material of the elements with one number."""

    __slots__ = ()

    def missing(self, key: str) -> str:
        if self.unread:
            return f"material {self.material} {self.unread}"
        label = {"density": "DENS", "young_modulus": "EX", "poisson_ratio": "PRXY or NUXY"}[key]
        return f"material {self.material} of the file lacks {label}"


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
            for word in (_words(part)[0] for part in line.split("!")[0].split("$")):
                if word[:4] in COMMANDS:
                    listed = "with all nodes and elements listed"
                    raise MeshFileError(f"a file without {word}, {listed} (line {number})")
        lines = [*_canonical(lines)]
        types, keyopts = _element_types(lines)
        options = {kind: value for (kind, key), value in keyopts.items() if key == 2}
        elements = dict(_elements(lines))
        used = {kind for _, kind, _ in elements.values()}
        if unknown := used - types.keys():
            raise MeshFileError(f"a type for all elements; type {min(unknown)} has no ET")
        if others := {types[kind] for kind in used} - {*SOLIDS, *IGNORED}:
            new = {kind: f", for which SOLID{FORMER[kind]} stands" for kind in FORMER}
            names = ", ".join(f"{kind}{new.get(kind, '')}" for kind in sorted(others))
            raise MeshFileError(f"elements SOLID185, SOLID186, SOLID187; found elements {names}")
        sets, dropped = defaultdict[str, list[int]](list), set[int]()
        for rows, (number, kind, material) in elements.items():
            if types[kind] in SOLIDS:
                sets[f"{MATERIAL}{material}"].append(number)
            else:
                dropped.update(range(*rows))
        held, partly = _held(lines)
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
            tuple(_materials(lines, sets)),
            ignored=(*_ignored(lines, elements, types), *_formulation(keyopts, types), *partly),
            held=HELD if held else "",
        )


def _canonical(lines: list[str]) -> Iterator[str]:
    """Yield the lines with the full names of the commands that are read, and with the values of
    parameters in place of their names."""
    values: dict[str, str] = {}
    conditions = 0
    for line in (
        part.lstrip() if at else part for x in lines for at, part in enumerate(x.split("$"))
    ):
        if not COMMAND.match(line):
            yield line
            continue
        if line.startswith(("C***", "c***")):  # a comment
            continue
        head, *words = line.split("!")[0].split(",")
        command = head.strip().upper()[:4]
        conditions += (command == "*IF" and bool(words) and words[-1].strip().upper() == "THEN") - (
            command == "*END"
        )
        if conditions > 0 and command in USED and command != "*SET":
            raise MeshFileError(f"a file without {head.strip()} that depends on a condition (*IF)")
        name, equals, value = head.partition("=")
        if equals or name.strip().upper() == "*SET":
            key, given = (name, value) if equals else (*words, "", "")[:2]
            values[key.strip().upper()] = given.strip()
            continue
        full = USED.get(name.strip().upper()[:4], name)
        yield ",".join([full, *(values.get(word.strip().upper(), word) for word in words)])


def _ignored(
    lines: list[str],
    elements: dict[tuple[int, int], tuple[int, int, int]],
    types: dict[int, int],
) -> Iterator[str]:
    """Yield what the file says beside solids that is neither read nor harmless."""
    counts = Counter(types[kind] for _, kind, _ in elements.values())
    for number in sorted(counts.keys() & {*CONTACT, *NAMES}):
        yield f"{counts[number]} elements {NAMES.get(number, number)}"
    damping = Counter(
        words[1] for words in map(_words, lines) if words[0] in ("MP", "MPDATA") and words[1:]
    )
    yield from (f"{damping[label]} MP,{label}" for label in DAMPING if damping[label])
    words = Counter(found[0].strip().upper() for line in lines if (found := COMMAND.match(line)))
    for word, count in sorted(words.items()):
        if word[:4] not in {*USED, *HARMLESS}:
            yield f"{count} {word}"


def _formulation(keyopts: Mapping[tuple[int, int], int], types: Mapping[int, int]) -> Iterator[str]:
    """Yield options of the elements of solids that are not read and change their stiffness."""
    for (kind, key), value in sorted(keyopts.items()):
        if types.get(kind) in SOLIDS and key in FORMULATION and value:
            yield f"KEYOPT({key}) = {value} of SOLID{types[kind]} ({FORMULATION[key]})"


def _held(lines: list[str]) -> tuple[list[int], list[str]]:
    """Return the nodes that the command D holds along x, y and z, and what else it says."""
    held, other = defaultdict[int, set[str]](set), 0
    for words in map(_words, lines):
        if words[0] != "D" or len(words) < 3:
            continue
        node, label, value, _, end, step = (*words[1:], *[""] * 6)[:6]
        if not node.isdigit() or (value and float(value)):
            other += 1
            continue
        axes = {"UX", "UY", "UZ"} if label == "ALL" else {label, *words[7:]} & {"UX", "UY", "UZ"}
        for one in range(int(node), int(end or node) + 1, int(step or 1)):
            held[one] |= axes
    whole = [node for node, axes in held.items() if len(axes) == 3]
    partly = sum(bool(axes) for axes in held.values()) - len(whole)
    notes = [f"D of single displacements of {partly} nodes"] if partly else []
    return whole, notes + ([f"{other} D of motions or named nodes"] if other else [])


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


def _element_types(lines: list[str]) -> tuple[dict[int, int], dict[tuple[int, int], int]]:
    """Return the number of the element of each type, and the values of KEYOPT by the type and the
    number of the option."""
    types, options = dict[int, int](), dict[tuple[int, int], int]()
    for number, line in enumerate(lines):
        words = _words(line)
        if words[0] == "ET" and len(words) > 2:
            kind = _whole(words[1], line)
            types[kind] = _whole(re.sub(r"\D", "", words[2]), line)
            for key, value in enumerate(words[3:9], 1):
                if value:
                    options[kind, key] = _whole(value, line)
        elif words[0] == "KEYOPT" and len(words) > 3 and words[2].isdigit():
            options[_whole(words[1], line), int(words[2])] = _whole(words[3] or "0", line)
        elif words[0] == "ETBLOCK":
            width = _width(lines[number + 1])
            for row in lines[number + 2 : number + 2 + int(words[1])]:
                values = _integers(row, width)
                types[values[0]] = values[1]
                options |= {
                    (values[0], k): value for k, value in enumerate(values[2:8], 1) if value
                }
    return types, options


def _elements(lines: list[str]) -> Iterator[tuple[tuple[int, int], tuple[int, int, int]]]:
    """Yield first row of each element and that of the next one, and its number, type and material.

    Raises:
        MeshFileError: elements are in the compact form, which does not contain materials.
    """
    number = 0
    while number < len(lines):
        words = _words(lines[number])
        number += 1
        if words[0] != "EBLOCK":
            continue
        if "COMPACT" in words:
            raise MeshFileError("EBLOCK in its long form; COMPACT does not contain materials")
        width = _width(lines[number])
        number += 1
        while number < len(lines) and not lines[number].strip().startswith("-1"):
            first, head = number, _integers(lines[number], width)
            number += 1
            left = head[8] - len(head[11:])
            while left > 0:
                left -= len(_integers(lines[number], width))
                number += 1
            yield (first, number), (head[10], head[1], head[0])


def _materials(lines: list[str], sets: dict[str, list[int]]) -> Iterator[_Material]:
    """Yield the materials of the elements, from MPDATA and MP."""
    values = defaultdict[str, dict[str, float]](dict)
    unread = dict[str, str]()
    for row, line in enumerate(lines, 1):
        words = _words(line)
        if words[0] == "MPDATA" and len(words) > 6:
            _, _, count, label, material, first, *numbers = words
            if _whole(count, line) > 1 or _whole(first, line) > 1:
                unread[material] = f"has {label} for several temperatures, which is not read"
        elif words[0] == "MP" and len(words) > 3:
            _, label, material, *numbers = words
            material = material or "1"  # the default of Ansys
            if any(number and _real(number, line) for number in numbers[1:]):
                unread[material] = f"has {label} for several temperatures, which is not read"
        else:
            continue
        if label in DIRECTIONAL:
            unread[material] = f"has {label}, which is not read"
        elif label in CONSTANTS:
            key, place = CONSTANTS[label], f" ({words[0]},{label}, line {row})"
            values[material][key] = constant(key, _real(numbers[0], line), place)
    for group in sets:
        material = group.removeprefix(MATERIAL)
        isotropic = not unread.get(material)
        yield _Material(
            group, material, values[material] if isotropic else {}, unread.get(material, "")
        )


def _components(sets: Mapping[str, list[int]], kind: str = "ELEM") -> Iterator[str]:
    for name, members in sets.items():
        yield f"CMBLOCK,{name},{kind},{len(members):9d}"
        yield "(8i10)"
        for start in range(0, len(members), 8):
            yield "".join(f"{member:10d}" for member in members[start : start + 8])


def _words(line: str) -> list[str]:
    return [word.strip().upper() for word in line.split("!")[0].split(",")]


def _whole(word: str, line: str) -> int:
    """Return a whole number in a command, which may have a decimal point."""
    if (value := _real(word, line)) != int(value):
        raise MeshFileError(f"a whole number in {line.strip()[:60]!r}, got {word!r}")
    return int(value)


def _real(word: str, line: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise MeshFileError(f"a number in {line.strip()[:60]!r}, got {word!r}") from None


def _width(form: str) -> int:
    """Return the width of the integers of a Fortran format such as (19i9)."""
    found = re.search(r"\d+i(\d+)", form, re.IGNORECASE)
    if found is None:
        raise MeshFileError(f"a format such as (19i9), got {form.strip()[:40]!r}")
    return int(found[1])


def _integers(row: str, width: int) -> list[int]:
    row = row.rstrip()
    fields = [row[start : start + width].strip() for start in range(0, len(row), width)]
    try:
        return [int(one or 0) for one in fields]  # a blank field is 0
    except ValueError:
        raise MeshFileError(f"whole numbers of {width} letters, got {row[:60]!r}") from None
