"""Text of .cdb files of Ansys: commands, parameters, and blocks of numbers of fixed width."""

import re
from collections.abc import Iterator
from typing import NamedTuple

from bladewhirl.meshes.files.groups import MeshFileError

COMMANDS = frozenset(
    "/INP *DO *DOW *REP *USE *CRE *GO NGEN EGEN FILL NMOD NSCA EDEL NDEL EMOD".split()
)
"""First four letters of commands that read files, repeat others or change the mesh."""

USED = {
    **{name[:4]: name for name in ("ETBLOCK", "KEYOPT", "NBLOCK", "EBLOCK", "CMBLOCK", "RLBLOCK")},
    **{name[:4]: name for name in ("ET", "MP", "MPDATA", "N", "D", "R", "*SET", "CMSEL", "NSEL")},
}
"""Commands that are read, by the first four letters, which are those that matter; N is the end of
NBLOCK, or a node that no solid has."""

HARMLESS = frozenset(
    """
    *CFC *CFO *DEL *DIM *ELS *END *GET *IF *MSG *VGE *VWR /ANG /AUX /BAT /CLE /COM /CON /DEL
    /EOF /ERA /EXI /FIL /GO /GOL /GOP /GRA /INQ /NER /NOL /NOP /NUM /OUT /PLO /PNU /POS /PRE
    /REP /RGB /SHO /SOL /STI /SYS /TIT /UNI /VIE /WB ACEL ALLS ANTY ARCL AUTO BCSO BF BFBL BFDE
    BFE BFEB BFUN BUCO CDWR CGLO CGOM CLOC CMDE CMLI CMOM CNVT CORI CRPL CSCI CSYS CUTC CYCL
    CYCO DCGO DCUM DDOP DELT DOF DOFS DOME DSPO DSYS ELIS EPLO EQSL ERES ESEL ESLL ESLN ESYS
    EXTO F FBLO FCUM FDEL FINI HARF HARM HROP IRLF KBC KEYW KUSE LNSR LOCA LSCL LSWR MAT MODC
    MODO MONI MPRE MPTE MSAV MXPA NCNV NEQI NLAD NLDI NLGE NLHI NLIS NPLO NROP NROT NSLE NSLL
    NSUB NUMO OMEG OUTP OUTR PCGO PIVC PRED PSTR QRDO RATE REAL RESC RLBL RMOR SAVE SECB SECC
    SECD SECN SECO SECT SET SF SFCU SFDE SFE SFEB SFGR SHPP SOLC SOLV SSTI STAB TBDA TBFI TBPT
    TBTE TIME TIMI TINT TOFF TREF TRNO TSHA TUNI TYPE VFOP
    """.split()
)
"""First four letters of commands that say nothing about the linear motion."""

RESULTS = ("/POS", "/AUX")
"""First four letters of commands after which results are looked at, to the next of `MODELS`."""

MODELS = ("/PRE", "/SOL")

COMMAND = re.compile(r"[A-Za-z/*][^,!]*")


class Command(NamedTuple):
    """A command with the name that is read, or as the file has it."""

    name: str  #: name in capitals
    fields: list[str]  #: fields after the name, in capitals
    row: int  #: number of its line among the lines, from 0
    line: str  #: text of its line


def canonical(lines: list[str]) -> Iterator[str]:
    """Yield the lines with the full names of the commands that are read, and with the values of
    parameters in place of their names.

    Raises:
        MeshFileError: a command that is read depends on a condition.
    """
    values: dict[str, str] = {}
    conditions = 0
    for line in (part for row in lines for part in row.split("$")):
        if not COMMAND.match(line := line.lstrip() if COMMAND.match(line.lstrip()) else line):
            yield line
            continue
        if line.startswith(("C***", "c***")):  # a comment
            continue
        head, *rest = line.split("!")[0].split(",")
        command = head.strip().upper()[:4]
        conditions += (command == "*IF" and bool(rest) and rest[-1].strip().upper() == "THEN") - (
            command == "*END"
        )
        if conditions > 0 and command in USED and command != "*SET":
            raise MeshFileError(f"a file without {head.strip()} that depends on a condition (*IF)")
        name, equals, value = head.partition("=")
        if equals or name.strip().upper() == "*SET":
            key, given = (name, value) if equals else (*rest, "", "")[:2]
            values[key.strip().upper()] = given.strip()
            continue
        full = USED.get(name.strip().upper()[:4], name)
        yield ",".join([full, *(values.get(word.strip().upper(), word) for word in rest)])


def commands_of(lines: list[str]) -> list[Command]:
    """Return the commands of lines."""
    found = ((row, line, words(line)) for row, line in enumerate(lines) if COMMAND.match(line))
    return [Command(name, fields, row, line) for row, line, (name, *fields) in found]


def words(line: str) -> list[str]:
    """Return the fields of a command in capitals, without its comment."""
    return [word.strip().upper() for word in line.split("!")[0].split(",")]


def whole_in(word: str, line: str) -> int:
    """Return a whole number in a command, which may have a decimal point."""
    if (value := real_in(word, line)) != int(value):
        raise MeshFileError(f"a whole number in {line.strip()[:60]!r}, got {word!r}")
    return int(value)


def real_in(word: str, line: str) -> float:
    """Return a number in a command."""
    try:
        return float(word)
    except ValueError:
        raise MeshFileError(f"a number in {line.strip()[:60]!r}, got {word!r}") from None


def is_number(word: str) -> bool:
    """Return whether a word is a number."""
    try:
        return float(word) is not None
    except ValueError:
        return False


def width_of(lines: list[str], row: int) -> int:
    """Return the width of the integers in the Fortran format in a row, such as (19i9)."""
    form = lines[row] if row < len(lines) else ""
    found = re.search(r"\d+i(\d+)", form, re.IGNORECASE)
    if found is None:
        raise MeshFileError(f"a format such as (19i9), got {form.strip()[:40]!r}")
    return int(found[1])


def integers(row: str, width: int) -> list[int]:
    """Return the integers of a row of fields of fixed width."""
    row = row.rstrip()
    fields = [row[start : start + width].strip() for start in range(0, len(row), width)]
    try:
        return [int(one or 0) for one in fields]  # a blank field is 0
    except ValueError:
        raise MeshFileError(f"whole numbers of {width} letters, got {row[:60]!r}") from None


def rows_of(lines: list[str], start: int) -> Iterator[tuple[int, str]]:
    """Yield number and text of the rows of a block to its end, which is -1 or a command.

    Args:
        lines: lines of the file.
        start: number of the first row, after the format of the block.
    """
    for number in range(start, len(lines)):
        row = lines[number]
        if row.strip().startswith("-1") or COMMAND.match(row.lstrip()) or not row.strip():
            return
        yield number, row
