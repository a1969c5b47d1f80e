"""Meshes of solids in bulk data of Nastran, read with pyyeti: free, small and large fields.

Groups are the nodes that the SPC, SPC1 and SPCADD entries with one number and the field PS of GRID
hold along x, y and z (``SPC 5``, ``PS``), the nodes of SET1 entries and of SET commands
(``SET 9``), and the elements of each property (``PSOLID 1``), which also have the material of its
MAT1 entry. Every other entry is harmless for the linear motion, or named.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from bladewhirl.files import open_text
from bladewhirl.meshes.files.abaqus_solids import Section, SolidMesh
from bladewhirl.meshes.files.groups import MeshFileError, check_numbers, constant
from bladewhirl.meshes.files.meshio_cells import readable
from bladewhirl.meshes.line_mesh import IntArray

CELLS = {
    "CTETRA": {4: "tetra", 10: "tetra10"},
    "CPENTA": {6: "wedge", 15: "wedge15"},
    "CHEXA": {8: "hexahedron", 20: "hexahedron20"},
}
"""Type of the cell by the entry and the number of nodes, named as in meshio."""

ORDERS = {
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
    "hexahedron20": [*range(12), 16, 17, 18, 19, 12, 13, 14, 15],
}
"""Places of the nodes of VTK among those of Nastran, where upright edges come before upper ones."""

OTHER_SOLIDS = ("CPYRAM", "CPYRA", "CTETRAR", "CHEXA1", "CHEXA2")
OTHER_MATERIALS = ("MAT2", "MAT9", "MAT10", "MAT11")

USED = ("GRID", "GRDSET", *CELLS, "PSOLID", "MAT1", "SPC", "SPC1", "SPCADD", "SET1", "PARAM")
"""Names of the entries that are read; of PARAM, WTMASS."""

ENTRIES = (*USED, *OTHER_SOLIDS, *OTHER_MATERIALS)
"""Names of the entries that are looked for."""

HARMLESS = (
    *("ENDDATA", "BEGIN", "ECHO*", "CORD[123][CRS]", "EIG*", "FORCE*", "MOMENT*", "PLOAD*", "GRAV"),
    *("ACCEL*", "RFORCE", "LOAD", "DLOAD", "[RT]LOAD[12]", "DAREA", "LSEQ", "SPCD", "TEMP*"),
    *("FREQ*", "TSTEP*", "TABLE*", "TABDMP1", "DELAY", "DPHASE", "PSHELL", "PBAR*", "PBEAM*"),
    *("PROD", "PBUSH*", "PELAS*", "PMASS", "PDAMP*", "PTUBE", "PSHEAR", "PGAP", "PVISC", "PLOTEL"),
    *("MAT[45]", "DTI", "SET3", "GROUP", "BSURF*", "MONPNT*", "NLPARM", "DRESP*", "DES*"),
)
"""Patterns of names of entries that say nothing about the linear motion, or belong to named ones.
"""

MOST_LETTERS = 8  #: largest length of the name of an entry

Cards = Mapping[str, list[list[Any]]]
"""Fields of all entries by their name; none for other names."""

SET = re.compile(r"^[ \t]*SET[ \t]+(\d+)[ \t]*=[ \t]*((?:.*,[ \t]*\n)*.*)$", re.I | re.M)
CHOSEN = re.compile(r"^[ \t]*SPC[ \t]*=[ \t]*(\d+)", re.I | re.M)
INCLUDE = re.compile(r"^[ \t]*INCLUDE\b", re.I | re.M)


class _Material(Section):
    """Material of the elements of one property."""

    __slots__ = ()

    def missing(self, key: str) -> str:
        field = {"density": "RHO", "young_modulus": "E", "poisson_ratio": "NU"}[key]
        if self.unread:
            return f"material {self.material} of {self.group} is {self.unread}, which is not read"
        return f"{self.group} has no MAT1 {self.material} with {field}"


def nastran_mesh(path: Path) -> SolidMesh:
    """Return the elements CTETRA, CPENTA and CHEXA of bulk data, with its sets.

    Raises:
        MeshFileError: pyyeti is not installed, the file cannot be read, or has other elements of
            solids, pyramids for instance, or nodes in other than the basic coordinates.
    """
    try:
        from pyyeti.nastran import bulk
    except ImportError:
        needed = "pip install 'bladewhirl[nastran]'"
        raise MeshFileError(f"pyyeti, which reads bulk data of Nastran: {needed}") from None
    with readable(path, "pyyeti"):
        with open_text(path, errors="replace") as stream:
            text = stream.read()
        check_numbers(text.splitlines())
        counts = _counts(text)
        options = {"return_var": "list", "no_data_return": [], "follow_includes": False}
        pattern = f"({'|'.join(ENTRIES)})"  # of the start of a line
        found = bulk.rdcards(str(path), pattern, regex=True, keep_name=True, **options)
        cards = defaultdict[str, list[list[Any]]](list)
        for name, *values in found:
            cards[name.strip().rstrip("*").upper()].append(values)
        if INCLUDE.search(text):
            raise MeshFileError("one file with all bulk data, without INCLUDE")
        if others := [name for name in OTHER_SOLIDS if name in cards]:
            raise MeshFileError(f"elements CTETRA, CPENTA and CHEXA; found {others[0]}")
        mesh, partly = _mesh(cards, text)
        named = (n for n in sorted(counts) if n not in ENTRIES and not _is_harmless(n))
        return mesh._replace(ignored=(*(f"{counts[name]} {name}" for name in named), *partly))


def _is_harmless(name: str) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in HARMLESS)


def _counts(text: str) -> Counter[str]:
    """Return the number of the entries of each name; without BEGIN BULK all lines are entries."""
    _, begin, bulk = text.upper().partition("BEGIN BULK")
    lines = (bulk.partition("\n")[2] if begin else text.upper()).splitlines()
    words = (re.match(r"[A-Z][A-Z0-9]*", line[:MOST_LETTERS]) for line in lines)
    return Counter(word[0] for word in words if word)


def _mesh(cards: Cards, text: str) -> tuple[SolidMesh, list[str]]:
    """Return the mesh, and constraints of single displacements."""
    grid = [(*row, *[""] * 7)[:8] for row in cards["GRID"]]
    default = [row[1] for row in cards["GRDSET"] if row[1:] and row[1]]
    turned = [row[0] for row in grid if row[1] not in ("", 0)]
    if turned or default:
        what = f"node {turned[0]} is in another one" if turned else "GRDSET states another one"
        raise MeshFileError(f"nodes in the basic coordinate system; {what}")
    place = {int(row[0]): number for number, row in enumerate(grid)}
    _check_single("GRID", [int(row[0]) for row in grid])
    _check_single("element", [row[0] for entry in CELLS for row in cards[entry]])
    points = [[float(x or 0.0) for x in (*row[2:5], "", "", "")[:3]] for row in grid]
    rows = defaultdict[str, list[list[int]]](list)
    members = defaultdict[str, defaultdict[str, list[int]]](lambda: defaultdict(list))
    for entry, types in CELLS.items():
        for number, property_, *nodes in cards[entry]:
            while nodes and nodes[-1] == "":
                nodes.pop()
            if len(nodes) not in types or "" in nodes:
                counts = " or ".join(map(str, types))
                raise MeshFileError(f"{counts} nodes of each {entry}; element {number} has others")
            kind = types[len(nodes)]
            members[f"PSOLID {property_ or number}"][kind].append(len(rows[kind]))
            rows[kind].append([place.get(node, -1) for node in nodes])
    cells = [
        (kind, np.array(one)[:, ORDERS.get(kind, list(range(len(one[0]))))])
        for kind, one in rows.items()
    ]
    properties = {f"PSOLID {row[0]}": row[1] for row in cards["PSOLID"]}
    if fluid := [row[0] for row in cards["PSOLID"] if "PFLUID" in row]:
        raise MeshFileError(f"elements of solids; PSOLID {fluid[0]} is a fluid")
    usual = next((row[6] for row in cards["GRDSET"] if row[6:]), "")
    permanent = {int(row[0]): str(usual if row[6] == "" else row[6]) for row in grid}
    components = _constraints(cards, permanent, list(place))
    held = {name: [n for n, by in of.items() if {*"123"} <= by] for name, of in components.items()}
    partly = [
        f"{name} of single displacements of {number} nodes"
        for name, of in components.items()
        if (number := sum(bool({*"123"} & by) for by in of.values()) - len(held[name]))
    ]
    sets = {
        name: np.array([place[node] for node in nodes if node in place], dtype=np.int64)
        for name, nodes in (*held.items(), *_node_sets(cards, text, list(place)))
        if nodes
    }
    mesh = meshio.Mesh(
        np.array(points),
        cells,
        point_sets=sets,
        cell_sets={
            name: [np.array(of_kind[kind], dtype=np.int64) for kind, _ in cells]
            for name, of_kind in members.items()
        },
    )
    sections = tuple(_materials(cards, properties, list(members)))
    partly += _unread(cards)
    command = CHOSEN.search(text)
    if command and int(command[1]) and f"SPC {int(command[1])}" not in components:
        partly.append(f"SPC = {command[1]}, for which there are no entries,")
    return SolidMesh(mesh, sections=sections, held=_chosen(text, cards, list(held))), partly


def _check_single(what: str, numbers: Sequence[Any]) -> None:
    """Check that no number is used twice."""
    if twice := [number for number, count in Counter(numbers).items() if count > 1]:
        raise MeshFileError(f"each {what} once; {what} {twice[0]} is there twice")


def _unread(cards: Cards) -> list[str]:
    """Return fields of the entries that are read whose content is not."""
    integrated = sum(any(row[place] for place in (3, 5) if row[place:]) for row in cards["PSOLID"])
    damped = sum(bool(row[7:] and row[7]) for row in cards["MAT1"])
    values = {str(row[0]).upper(): row[1] for row in cards["PARAM"] if row[1:]}
    return [
        *([f"the integration of {integrated} PSOLID"] if integrated else []),
        *([f"the damping GE of {damped} MAT1"] if damped else []),
        *(f"SET1 {row[0]} with {words[0]}" for row in cards["SET1"] if (words := _words(row[1:]))),
        *(f"PARAM {name}" for name in ("G", "ALPHA1", "ALPHA2") if values.get(name)),
    ]


def _constraints(
    cards: Cards, permanent: Mapping[int, str], nodes: list[int]
) -> dict[str, dict[int, set[str]]]:
    """Return the components that each set of constraints holds, by node; those of the field PS
    belong to every set, and are one of their own without others."""
    sets = defaultdict[int, defaultdict[int, set[str]]](lambda: defaultdict(set))
    for number, components, *members in cards["SPC1"]:
        for node in _listed(members, nodes):
            sets[number][node] |= {*str(components)}
    for number, *rest in cards["SPC"]:
        for node, components in zip(rest[::3], rest[1::3], strict=False):
            sets[number][int(node)] |= {*str(components)}
    for number, *members in cards["SPCADD"]:
        for other in [member for member in members if member != ""]:
            for node, components in list(sets[other].items()):
                sets[number][node] |= components
    always = {node: {*components} for node, components in permanent.items() if components}
    for of in sets.values():
        for node, components in always.items():
            of[node] |= components
    named: dict[str, dict[int, set[str]]] = {f"SPC {n}": dict(of) for n, of in sets.items()}
    return named or ({"PS": always} if always else {})


def _chosen(text: str, cards: Cards, names: list[str]) -> str:
    """Return the set of constraints that the case control or SPCADD chooses, or the only one."""
    command = CHOSEN.search(text)
    numbers = {str(int(command[1]))} if command else {str(row[0]) for row in cards["SPCADD"]}
    chosen = [name for name in names if name.removeprefix("SPC ") in numbers] or names
    return chosen[0] if len(chosen) == 1 else ""


def _node_sets(cards: Cards, text: str, nodes: list[int]) -> Iterator[tuple[str, list[int]]]:
    """Yield name and nodes of each set; entries with one number are one set."""
    sets = defaultdict[str, list[int]](list)
    for number, *members in cards["SET1"]:
        if not _words(members):
            sets[f"SET {number}"] += _listed(members, nodes)
    for found in SET.finditer(text):
        words = found[2].replace(",", " ").replace("=", " ").upper().split()
        if all(word in ("THRU", "EXCEPT") or word.isdigit() for word in words):
            members = [int(word) if word.isdigit() else word for word in words]
            sets[f"SET {found[1]}"] += _listed(members, nodes)
    yield from sets.items()


def _words(members: Sequence[Any]) -> list[str]:
    """Return the words in a list of nodes other than THRU."""
    return [one for one in members if isinstance(one, str) and one not in ("", "THRU")]


def _listed(members: Sequence[Any], nodes: list[int]) -> list[int]:
    """Return the nodes of a list in which THRU stands between the ends of a range, and EXCEPT
    before numbers and ranges within it that are left out."""
    chosen: list[int] = []
    given = [member for member in members if member != ""]
    numbers: IntArray = np.array(nodes)
    without, end = set[int](), 0
    for place, member in enumerate(given):
        if member == "EXCEPT":
            end = max(chosen)
            continue
        own = [int(member)] if member != "THRU" else []
        if member == "THRU":
            first, last = given[place - 1], given[place + 1]
            own = numbers[(numbers > first) & (numbers < last)].tolist()
        if own and max(own) < end:
            without.update(own)
        else:
            chosen += own
    return [node for node in chosen if node not in without]


def _materials(cards: Cards, properties: dict[str, Any], used: list[str]) -> Iterator[_Material]:
    """Yield the material of each property of the elements."""
    constants = {row[0]: (*row[1:5], "", "", "", "")[:4] for row in cards["MAT1"]}
    others = {row[0]: name for name in OTHER_MATERIALS for row in cards[name]}
    given = (row[1] for row in cards["PARAM"] if str(row[0]).upper() == "WTMASS")
    weight = next(given, 1.0)
    if isinstance(weight, str) or not weight > 0.0:
        raise MeshFileError(f"a positive PARAM,WTMASS, got {weight}")
    for name in used:
        number = properties.get(name, "")
        young, shear, ratio, density = constants.get(number, ("", "", "", ""))
        if ratio == "" and young and shear:
            ratio = young / (2.0 * shear) - 1.0
        by_key = {"young_modulus": young, "poisson_ratio": ratio, "density": density}
        values = {
            key: constant(key, float(value), f" (MAT1 {number})")
            for key, value in by_key.items()
            if value != "" and (key != "density" or value)
        }
        if "density" in values:
            values["density"] *= weight
        yield _Material(name, str(number), values, others.get(number, ""))
