"""Meshes of solids in bulk data of Nastran: free, small and large fields.

Groups are the nodes that the SPC, SPC1 and SPCADD entries with one number and the field PS of GRID
hold along x, y and z (``SPC 5``, ``PS``), the nodes of SET1 and SET3 entries and of SET commands
(``SET 9``), and the elements of each property (``PSOLID 1``), which also have the material of its
MAT1 entry. Every other entry is harmless for the linear motion, or named.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path

import meshio
import numpy as np

from bladewhirl.files import open_text
from bladewhirl.meshes.files.abaqus_solids import SolidMesh
from bladewhirl.meshes.files.groups import MeshFileError, check_numbers, places_of_nodes
from bladewhirl.meshes.files.meshio_cells import readable
from bladewhirl.meshes.files.nastran_coordinates import SYSTEMS, basic_points
from bladewhirl.meshes.files.nastran_entries import Entry, entries
from bladewhirl.meshes.files.nastran_materials import (
    OTHER_MATERIALS,
    Cards,
    is_consistent,
    materials_of,
)
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

USED = (
    *("GRID", "GRDSET", *SYSTEMS, *CELLS, "PSOLID", "MAT1"),
    *("SPC", "SPC1", "SPCADD", "SET1", "SET3", "PARAM"),
)
"""Names of the entries that are read; of PARAM, WTMASS, and of SET3, nodes."""

HARMLESS = (
    *("ECHO*", "CORD3*", "EIG*", "FORCE*", "MOMENT*", "PLOAD*", "GRAV", "ACCEL*", "RFORCE*"),
    *("LOAD", "DLOAD", "[RT]LOAD[12]", "DAREA", "LSEQ", "SPCD", "TEMP*", "LOADCYN", "LOADCYT"),
    *("FREQ*", "TSTEP*", "TABLE*", "DELAY", "DPHASE", "PSHELL", "PBAR*", "PBEAM*"),
    *("PROD", "PBUSH*", "PELAS*", "PMASS", "PDAMP*", "PTUBE", "PSHEAR", "PGAP", "PVISC", "PLOTEL"),
    *(
        "MAT[45]",
        "MATS1",
        "DTI",
        "SET3",
        "GROUP",
        "ABSNMVS",
        "ABSTRCT",
        "BSURF*",
        "MONPNT*",
        "NLPARM",
        "MDLPRM",
    ),
    *("DRESP*", "DES*", "DV*REL*", "DVGRID", "DCON*", "DOPTPRM", "DLINK", "DEQATN", "DSCREEN"),
    *("CYJOIN", "CYSYM", "CYAX", "HMNAME", "HMCOLOR", "HMMOVE", "TOPVAR", "TABRND*", "RAND*"),
    *("NLSTEP", "NLPCI", "TIC", "CHBDY*", "PHBDY", "QBDY*", "QHBDY", "QVOL", "SLOAD", "CONV*"),
    *("PCONV*", "RADBC", "RADM", "RADSET", "VIEW*", "AE*", "CAERO*", "PAERO*", "SPLINE*", "SET2"),
    *("FLUTTER", "FLFACT", "MKAERO*", "GUST", "TRIM"),
)
"""Patterns of names of entries that say nothing about the linear motion, or belong to named ones.
"""

USUAL = {3: ("", "0", "BUBBLE"), 5: ("", "0", "REDUCED")}
"""Fields IN and ISOP of PSOLID, and texts with which the integration is the usual one."""

SET = re.compile(r"^[ \t]*SET[ \t]+(\d+)[ \t]*=[ \t]*((?:.*,[ \t]*\n)*.*)$", re.I | re.M)
COMMENT = re.compile(r"\$.*")
CHOSEN = re.compile(r"^[ \t]*SPC[ \t]*=[ \t]*(\d+)", re.I | re.M)


def nastran_mesh(path: Path) -> SolidMesh:
    """Return the elements CTETRA, CPENTA and CHEXA of bulk data, with its sets.

    Raises:
        MeshFileError: the file cannot be read, or has other elements of solids, pyramids for
            instance.
    """
    with readable(path, "bladewhirl"):
        with open_text(path, errors="replace") as stream:
            text = stream.read()
        check_numbers(text.splitlines())
        cards = defaultdict[str, list[Entry]](list)
        for entry in entries(text):
            cards[entry.name].append(entry)
        text = COMMENT.sub("", text)
        if others := [name for name in OTHER_SOLIDS if name in cards]:
            raise MeshFileError(f"elements CTETRA, CPENTA and CHEXA; found {others[0]}")
        mesh, partly = _mesh(cards, text)
        known = (*USED, *OTHER_MATERIALS)
        named = (
            f"{len(cards[name])} {name}"
            for name in sorted(cards)
            if cards[name] and name not in known and not _is_harmless(name)
        )
        return mesh._replace(ignored=(*named, *partly))


def _is_harmless(name: str) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in HARMLESS)


def _mesh(cards: Cards, text: str) -> tuple[SolidMesh, list[str]]:
    """Return the mesh, and constraints of single displacements."""
    grid, usual = cards["GRID"], (cards["GRDSET"] or [Entry("GRDSET", [], 0)])[0]
    _check_single("GRID", grid)
    _check_single("element", [row for entry in CELLS for row in cards[entry]])
    for name in ("PSOLID", "MAT1"):
        _check_single(name, cards[name])
    place = {row.whole(0): number for number, row in enumerate(grid)}
    rows = defaultdict[str, list[list[int]]](list)
    members = defaultdict[str, defaultdict[str, list[int]]](lambda: defaultdict(list))
    for entry, types in CELLS.items():
        for row in cards[entry]:
            if (size := len(row.fields) - 2) not in types:
                counts = " or ".join(map(str, types))
                raise MeshFileError(
                    f"{counts} nodes of each {entry}; element {row.text(0)} has others"
                )
            nodes = [row.whole(field) for field in range(2, len(row.fields))]
            kind = types[size]
            members[f"PSOLID {row.whole(1, row.whole(0))}"][kind].append(len(rows[kind]))
            rows[kind].append(places_of_nodes(place, row.whole(0), nodes))
    cells = [
        (kind, np.array(one)[:, ORDERS.get(kind, list(range(len(one[0]))))])
        for kind, one in rows.items()
    ]
    if fluid := [row.whole(0) for row in cards["PSOLID"] if "PFLUID" in row.fields]:
        raise MeshFileError(f"elements of solids; PSOLID {fluid[0]} is a fluid")
    permanent = {row.whole(0): row.text(6) or usual.text(6) for row in grid}
    components = _constraints(cards, permanent, list(place))
    held = {name: [n for n, by in of.items() if {*"123"} <= by] for name, of in components.items()}
    sets = {
        name: np.array([place[node] for node in nodes if node in place], dtype=np.int64)
        for name, nodes in (*held.items(), *_node_sets(cards, text, list(place)))
        if nodes
    }
    mesh = meshio.Mesh(
        basic_points(grid, usual.whole(1, 0), cards) if grid else np.zeros((0, 3)),
        cells,
        point_sets=sets,
        cell_sets={
            name: [np.array(of_kind[kind], dtype=np.int64) for kind, _ in cells]
            for name, of_kind in members.items()
        },
    )
    notes = [note for name, of in components.items() for note in _not_held(name, of, place)]
    command = CHOSEN.search(text)
    if command and int(command[1]) and f"SPC {int(command[1])}" not in components:
        notes.append(f"SPC = {command[1]}, for which there are no entries,")
    return SolidMesh(
        mesh,
        sections=(*materials_of(cards, list(members)),),
        held=_chosen(text, cards, list(held)),
    ), [*notes, *_unread(cards)]


def _check_single(what: str, rows: Sequence[Entry]) -> None:
    """Check that no number is used twice."""
    if twice := [n for n, count in Counter(row.whole(0) for row in rows).items() if count > 1]:
        raise MeshFileError(f"each {what} once; {what} {twice[0]} is there twice")


def _not_held(name: str, of: Mapping[int, set[str]], place: Mapping[int, int]) -> Iterator[str]:
    """Yield what a set of constraints says beside nodes that it holds along x, y and z."""
    if number := sum(0 < len({*"123"} & by) < 3 for by in of.values()):
        yield f"{name} of single displacements of {number} nodes"
    if number := sum(node not in place for node in of):
        yield f"{name} of {number} nodes that are not defined"


def _unread(cards: Cards) -> Iterator[str]:
    """Yield fields of the entries that are read whose content is not."""
    integrated, damped, other = (
        sum(any(row.text(n) not in usual for n, usual in USUAL.items()) for row in cards["PSOLID"]),
        sum(bool(row.real(7, 0.0)) for row in cards["MAT1"]),
        sum(not is_consistent(row) for row in cards["MAT1"]),
    )
    if integrated:
        yield f"the integration of {integrated} PSOLID"
    if damped:
        yield f"the damping GE of {damped} MAT1"
    if other:
        yield f"G of {other} MAT1, which is not E / (2 (1 + NU)),"
    for row in cards["SET1"]:
        if words := _words(row.members(1)):
            yield f"SET1 {row.text(0)} with {words[0]}"
    for row in cards["PARAM"]:
        name, value = row.text(0), row.text(1)
        if name in ("G", "ALPHA1", "ALPHA2") and row.real(1, 0.0):
            yield f"PARAM {name}"
        if name == "COUPMASS" and value.startswith("-"):
            yield f"PARAM COUPMASS = {value}, a lumped mass,"


def _constraints(
    cards: Cards, permanent: Mapping[int, str], nodes: list[int]
) -> dict[str, dict[int, set[str]]]:
    """Return the components that each set of constraints holds, by node; those of the field PS
    belong to every set, and are one of their own without others."""
    sets = defaultdict[int, defaultdict[int, set[str]]](lambda: defaultdict(set))
    for row in cards["SPC1"]:
        for node in _listed(row.members(2), nodes):
            sets[row.whole(0)][node] |= {*row.text(1)}
    for row in cards["SPC"]:
        for start in range(1, len(row.fields), 3):
            sets[row.whole(0)][row.whole(start)] |= {*row.text(start + 1)}
    for row in cards["SPCADD"]:
        for other in row.members(1):
            for node, components in list(sets[int(other)].items()):
                sets[row.whole(0)][node] |= components
    always = {node: {*components} for node, components in permanent.items() if components}
    for of in sets.values():
        for node, components in always.items():
            of[node] |= components
    named: dict[str, dict[int, set[str]]] = {f"SPC {n}": dict(of) for n, of in sets.items()}
    return named or ({"PS": always} if always else {})


def _chosen(text: str, cards: Cards, names: list[str]) -> str:
    """Return the set of constraints that the case control or SPCADD chooses, or the only one."""
    command = CHOSEN.search(text)
    numbers = {str(int(command[1]))} if command else {str(row.whole(0)) for row in cards["SPCADD"]}
    chosen = [name for name in names if name.removeprefix("SPC ") in numbers] or names
    return chosen[0] if len(chosen) == 1 else ""


def _node_sets(cards: Cards, text: str, nodes: list[int]) -> Iterator[tuple[str, list[int]]]:
    """Yield name and nodes of each set; entries with one number are one set."""
    sets = defaultdict[str, list[int]](list)
    for row in cards["SET1"]:
        if not _words(members := row.members(1)):
            sets[f"SET {row.whole(0)}"] += _listed(members, nodes)
    for row in cards["SET3"]:
        if row.text(1) == "GRID":
            sets[f"SET {row.whole(0)}"] += _listed(row.members(2), nodes)
    for found in SET.finditer(text):
        words = found[2].replace(",", " ").replace("=", " ").upper().split()
        if all(word in ("THRU", "EXCEPT") or word.isdigit() for word in words):
            given = [int(word) if word.isdigit() else word for word in words]
            sets[f"SET {found[1]}"] += _listed(given, nodes)
    yield from sets.items()


def _words(members: Sequence[int | str]) -> list[str]:
    """Return the words in a list of nodes other than THRU."""
    return [one for one in members if isinstance(one, str) and one != "THRU"]


def _listed(members: Sequence[int | str], nodes: list[int]) -> list[int]:
    """Return the nodes of a list in which THRU stands between the ends of a range, and EXCEPT
    before numbers and ranges within it that are left out."""
    chosen: list[int] = []
    numbers: IntArray = np.array(nodes)
    without, end = set[int](), 0
    for place, member in enumerate(members):
        if member == "EXCEPT":
            end = max(chosen, default=0)
            continue
        if member == "THRU":
            around = (*members[max(place - 1, 0) : place], *members[place + 1 : place + 2])
            ends = [one for one in around if isinstance(one, int)]
            if len(ends) != 2:
                raise MeshFileError("a node before and after each THRU")
            own = numbers[(numbers > ends[0]) & (numbers < ends[1])].tolist()
        elif isinstance(member, str):
            raise MeshFileError(f"nodes, THRU and EXCEPT in a list of nodes, got {member!r}")
        else:
            own = [member]
        if own and max(own) < end:
            without.update(own)
        else:
            chosen += own
    return [node for node in chosen if node not in without]
