"""Inputs that nobody means, given to the command line: `python tests/support/fuzz.py KIND`.

Each input is one command, tried in a process of its own with little time and memory, which must
end in an answer or in a sentence: no traceback, no warning, no number that is none, no kill. Inputs
are made from their number alone, so a finding is repeated by `--first NUMBER --count 1`.
"""

import argparse
import contextlib
import json
import multiprocessing
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import solid_decks
from command_line import answer
from places import DATA, EXAMPLES
from small_run import COMMAND, SMALL, small
from solid_decks import SolidMakers
from typer.testing import CliRunner

from bladewhirl.meshes.files.registry import WRITERS
from bladewhirl.models.case.file import read_case
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.inputs.errors import toml_value
from bladewhirl.studies.commands.cli import app

SECONDS, BYTES, FILE_BYTES = 30, 6 * 2**30, 2**28
"""Limits of a command: processor time (twenty times that on the clock), memory and disk."""

SHORT = "march = { speed = 1.05, time_step = 2e-6, record_step = 2e-5, duration = 4e-4 }"

VALUES: tuple[Any, ...] = (
    *(0, 1, -1, 2, 3, 7, 22, 2**31, 2**63, -(2**63), 10**30, True, False),
    *(0.0, -0.0, 0.5, -1.5, 1e-300, 5e-324, 1e-9, 1e9, 1e299, 1.7e308, -1e308),
    *(float("nan"), float("inf"), -float("inf")),
    *("", "a", "1 mm", "120 mm", "-3 mm", "1e400 mm", "2500 rpm", "nan Hz", "inf", "1 kg", "m"),
    *"all six free 1F:1 casing:99 none imbalance harmonic \x00 ü\u202e".split(" "),
    *([], {}, [1], ["a"], [[0.0, 1.0]], [{}], {"a": 1}, {"width": "120 mm"}, [[[]]]),
)
"""Values of a case or of a JSON document."""

FACTORS = (0, -1, 1e-300, 1e-12, 1e-3, 0.3, 0.9, 1.1, 2, 3, 4, 1e3, 1e12, 1e300)
"""Multipliers of numbers of a case or of a JSON document."""

TOKENS = ("1e400", "1e300", "nan", "-1", "0", "7", "99999999999", "\n", '"', "\xff")
"""Words that replace bytes or numbers of a file."""

STORED: dict[str, tuple[Any, ...]] = {
    "f": (np.nan, np.inf, -1.0, 1e300, 0.0, 999.0),
    "i": (-1, 0, 99, 127),
    "O": ("nothing",),
    "": ("fast", "", np.nan, np.inf, -1, 0, 999, 1e300, b"\xff", []),
}
"""Values of a netCDF file by the kind of the array; those of attributes under ""."""

WORDS = (
    *("0", "1", "-1", "3", "1e300", "nan", "inf", "-inf", "1e-300", "99999999999", "x", "", " "),
    *("0:1", "1:2:3", "2:1:3", "0:1:-1", "nan:1:2", "0:1e300:3", "::", "1 rpm:2 rpm:2", "0:0:0"),
    *("1 ms", "-1 ms", "1e400 s", "a,b", "1F:1", "casing:1", "1F:1,,", "1,2", "\ud800", "ü" * 9),
    *("march.speed=1.2", "march.speed=fast", "casing.struts=[{}]", "title=x", "=", "a.b.c=1"),
    *("march.speed=1.1,1.2", "contact.friction=0:0.2:2", "casing=1", "excitation={type='none'}"),
)
"""Arguments of options."""

READING = (
    *("plot run orbit", "plot run energy -o p.png", "plot run gaps", "plot run spectrum --data"),
    *("plot run contact-phase", "plot run stress", "plot run regime", "plot run whirl"),
    *("plot run energy-families", "export run --frames 2 -o s", "export run --frames 2 --surface"),
    *("report run", "run --resume run --frames 0", "run --resume run --set march.duration=0.003"),
)

COMMANDS = {
    "case": (
        *("show case.toml", "show case.toml --case", "modes case.toml --json --count 9"),
        *("mesh case.toml", "mesh case.toml -o out.vtu", "mesh case.toml -o out.inp"),
        *("campbell case.toml --json", "veering case.toml --json"),
        "stability case.toml --json --speed 1.1 --kappa 300",
        "stability case.toml --json --speeds 0.9:1.2:0.1 --kappas 0:300:300",
        "sweep case.toml --over march.speed=1,2 --dry",
    ),
    "mesh": ("show case.toml --json", "modes case.toml --json"),
    "result": READING,
    "sweep": ("plot sweep", "plot sweep frequency-map", "report sweep", "plot sweep regimes"),
    "options": READING,
}
"""Commands by the kind of input."""

SOLIDS = ("inp", "msh", "vtu", "cdb", "bdf", "med", "calculix", "matrices")
"""Kinds of decks and matrices of solids, see `solid_decks`."""

FILES = {
    "result": (
        *("result.nc",) * 8,
        *("checkpoint.npz", "case.toml", "summary.json", "provenance.json"),
    ),
    "sweep": ("sweep.nc", "sweep.nc", "sweep.json", "failures.json"),
}
"""Files of a run and of a sweep, by how often they are spoiled."""


class Makers:
    """Inputs of all kinds, by number; the files that they begin with are made once, in a folder.

    Args:
        base: the folder.
    """

    def __init__(self, base: Path) -> None:
        self._base = base
        files = [*sorted(EXAMPLES.glob("*.toml")), DATA / "sketch_stage.toml"]
        cases = [*map(read_case, files), small()]
        self._tables = [cheap(case.model_dump(exclude_none=True)) for case in cases]

    def prepare(self, kind: str) -> None:
        """Make the files that inputs of a kind begin with, and load the modules of commands."""
        recorded = {"march.record_step": 2e-5, "march.duration": 0.002}
        (self._base / "case.toml").write_text(dumps_case(small(**recorded)))
        meshes = self._base / "meshes"
        shutil.copytree(DATA / "meshes", meshes)
        shutil.copy(EXAMPLES / "shrouded_fan.msh", meshes)
        with contextlib.chdir(self._base):
            for suffix in WRITERS:
                answer("mesh", "case.toml", "-o", f"meshes/disk{suffix}")
            answer("run", "case.toml", "--frames", 2, "-o", "result")
            if kind == "sweep":  # pools leave threads behind, which forks don't go with
                over = "sweep case.toml --over march.speed=1,1.1 -o sweep --workers 1 --yes"
                given = [sys.executable, "-c", COMMAND, *over.split(), "--set", SHORT]
                subprocess.run(given, check=True, capture_output=True)
                failures = [{"point": 1, "march.speed": 1.1, "reason": "why"}]
                Path("sweep/failures.json").write_text(json.dumps(failures))
            shutil.copytree("result", "run")
            for words in COMMANDS[kind]:
                CliRunner().invoke(app, words.split())

    def case(self, chance: random.Random, folder: Path) -> list[str]:
        """A case with other values or tables, or other bytes."""
        tables = json.loads(json.dumps(chance.choice(self._tables)))
        for _ in range(chance.choice((1, 1, 2, 3))):
            if chance.random() < 0.8:
                change(tables, chance)
            else:
                other = chance.choice(self._tables)
                name = chance.choice(sorted(other))
                tables[name] = json.loads(json.dumps(other[name]))
        text = "\n".join(f"{key} = {toml_value(value)}" for key, value in tables.items()).encode()
        content = mutated(text, chance) if chance.random() < 0.2 else text
        (folder / "case.toml").write_bytes(content)
        run = "run case.toml --frames 0 -o run"
        given = chance.choice((*COMMANDS["case"], run, f"{run} --json")).split()
        return given + ["--set", SHORT] * (given[0] == "run" and chance.random() < 0.8)

    def mesh(self, chance: random.Random, folder: Path) -> list[str]:
        """A mesh file with other bytes, looked at, written, or named by a case."""
        files = [f for f in sorted((self._base / "meshes").iterdir()) if f.suffix in WRITERS]
        source = chance.choice(files)
        suffix = chance.choice((source.suffix,) * 9 + tuple(WRITERS))
        (folder / f"disk{suffix}").write_bytes(mutated(source.read_bytes(), chance))
        if chance.random() < 0.6:
            out = chance.choice(([], ["-o", f"out{chance.choice(tuple(WRITERS))}"]))
            return ["mesh", f"disk{suffix}", *out]
        table = f'bladed_disk.mesh = {{ file = "disk{suffix}", tips = "tips" }}\n'
        (folder / "case.toml").write_text(table + chance.choice(("", "casing.elements = 12\n")))
        return chance.choice(COMMANDS["mesh"]).split()

    def result(self, chance: random.Random, folder: Path) -> list[str]:
        """A run with other bytes or values in its files, looked at."""
        shutil.copytree(self._base / "result", folder / "run")
        spoil(folder / "run" / chance.choice(FILES["result"]), chance)
        return chance.choice(READING).split()

    def sweep(self, chance: random.Random, folder: Path) -> list[str]:
        """A sweep with other bytes or values in its files, looked at or gone on with."""
        shutil.copytree(self._base / "sweep", folder / "sweep")
        file = folder / "sweep" / chance.choice(FILES["sweep"])
        spoil(file, chance)
        resume = ["sweep --resume sweep --workers 1 --yes"] if file.suffix == ".json" else []
        return chance.choice((*COMMANDS["sweep"], *resume)).split()

    def options(self, chance: random.Random, folder: Path) -> list[str]:
        """A command with words that fit none of its options, or all."""
        import typer.main

        (folder / "case.toml").write_text(SMALL)
        os.symlink(self._base / "result", folder / "run")
        commands: dict[str, Any] = vars(typer.main.get_command(app))["commands"]
        costly = {"search", "reproduce", "verify", "convergence", "render"}
        name = chance.choice(sorted(set(commands) - costly))
        given = [name]
        for parameter in commands[name].params:
            if parameter.param_type_name == "argument":
                right = "run" if name in {"plot", "report", "export"} else "case.toml"
                given.append(right if chance.random() < 0.9 else chance.choice(WORDS))
            elif chance.random() < 0.2:
                given.append(parameter.opts[0])
                if not parameter.is_flag:
                    given.append(chance.choice((*WORDS, "out", "out.png", "run", "case.toml")))
        if name in {"run", "sweep"} and chance.random() < 0.8:
            given += ["--set", SHORT]
        return [word for word in given if name != "new" or not word.startswith("/")]


def cheap(tables: dict[str, Any]) -> dict[str, Any]:
    """Return the tables of a case with fewer elements."""
    disk = tables.get("bladed_disk", {})
    if "superelement" in disk:
        tables["reduction"]["free_interface_modes"] = 5
    elif "mesh" not in disk and not any(disk.get(key) for key in ("centre_line", "taper")):
        disk["elements_per_blade"] = 3
    tables["reduction"]["fixed_interface_modes"] = 10
    tables["march"] |= {"duration": 4e-4}
    return tables


def change(document: Any, chance: random.Random, values: tuple[Any, ...] = VALUES) -> None:
    """Give a place in nested tables and lists another value, or drop it."""
    while document:
        place = chance.choice([*document] if isinstance(document, dict) else range(len(document)))
        old, way = document[place], chance.random()
        if isinstance(old, dict | list) and old and way < 0.95:
            document = old
            continue
        if 0.8 < way < 0.84:
            del document[place]
        elif isinstance(old, int | float) and not isinstance(old, bool) and way < 0.8:
            number = (float(old) or 1.0) * chance.choice(FACTORS)
            whole = isinstance(old, int) and abs(number) < 1e308
            document[place] = int(number) if whole else number
        else:
            document[place] = chance.choice(values)
        return


def mutated(content: bytes, chance: random.Random) -> bytes:
    """Return bytes some of which are flipped, cut out, doubled, replaced or lost at the end."""
    made = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 8))):
        at, way = chance.randrange(len(made) + 1), chance.random()
        span, token = slice(at, at + chance.choice((1, 1, 4, 30, 500))), chance.choice(TOKENS)
        numbers = [*re.finditer(rb"-?\d+\.?\d*(e-?\d+)?", made[:100_000])]
        if way < 0.3 and numbers:
            made[slice(*chance.choice(numbers).span())] = token.encode("latin-1")
        elif way < 0.35:
            del made[at:]
        else:
            flipped = bytes(byte ^ 1 << chance.randrange(8) for byte in made[span])
            made[span] = chance.choice((flipped, b"", 2 * made[span], token.encode("latin-1")))
    return bytes(made)


def spoil(file: Path, chance: random.Random) -> None:
    """Change the values of a netCDF or JSON file, or the bytes of any file."""
    if chance.random() < 0.4 or file.suffix not in {".nc", ".json"}:
        file.write_bytes(mutated(file.read_bytes(), chance))
    elif file.suffix == ".nc":
        edit(file, chance)
    else:
        document = json.loads(file.read_text())
        change(document, chance, (*VALUES, None))
        file.write_text(json.dumps(document))


def edit(file: Path, chance: random.Random) -> None:
    """Give a netCDF file another attribute, another value or array, or one less of them."""
    way = chance.random()
    with h5py.File(file, "r+") as h5:
        if chance.random() < 0.5:
            name = chance.choice(sorted(key for key in h5.attrs if not key.startswith("_")))
            if way < 0.15:
                del h5.attrs[name]
            else:
                h5.attrs[name] = chance.choice(STORED[""])
            return
        name = chance.choice(sorted(name for name in h5 if isinstance(h5[name], h5py.Dataset)))
        data = h5[name]
        if way < 0.1:
            del h5[name]
        elif data.size:
            where = tuple(chance.randrange(length) for length in data.shape)
            number = data.dtype.kind in "fi"
            value = chance.choice(STORED[data.dtype.kind if number else "O"])
            data[where if number and way < 0.6 else ...] = value


def attempt(arguments: list[str], folder: Path) -> tuple[int, str, str]:
    """Give a command in a process of its own: exit code, fault (empty if none), its words."""
    child = multiprocessing.get_context("fork").Process(target=_child, args=(arguments, folder))
    child.start()
    child.join(20 * SECONDS)
    with contextlib.suppress(ProcessLookupError):  # and what it started and left
        os.killpg(child.pid or 0, signal.SIGKILL)
    child.join()
    out, messages = ((folder / name).read_text(errors="replace") for name in (".out", ".err"))
    code = child.exitcode or 0
    return code, _fault(code, out, messages, arguments), messages


def _child(arguments: list[str], folder: Path) -> None:
    """Give a command, with limits and its words in files."""
    os.setsid()
    for limit, most in (
        (resource.RLIMIT_CPU, SECONDS),
        (resource.RLIMIT_AS, BYTES),
        (resource.RLIMIT_FSIZE, FILE_BYTES),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(limit, (most, most))
    os.chdir(folder)
    for stream, name in ((1, ".out"), (2, ".err")):
        os.dup2(os.open(name, os.O_CREAT | os.O_WRONLY | os.O_TRUNC), stream)
    warnings.simplefilter("error")
    solid_decks.run(arguments)


def _fault(code: int, out: str, messages: str, arguments: list[str]) -> str:
    """Return why a command did not end well; nothing if it did."""
    if code == -signal.SIGKILL and "Large stage: " in messages:
        return ""  # it said before it began what it takes
    if code < 0:
        return f"killed by {signal.Signals(-code).name}"
    if found := re.search(r"Traceback|\w+Warning\b", messages) or re.search("Traceback", out):
        return found[0]
    if code not in (0, 1, 2) or (code and not messages.strip()):
        return f"exit code {code}, {len(messages)} characters"
    if code == 0 and "--json" in arguments:
        try:
            json.loads(out, parse_constant=_refuse)
        except ValueError as error:
            return f"no JSON: {error}"
    elif code == 0 and arguments[0] != "new" and "--case" not in arguments:
        number = re.search(r"(?<![\w:/.-])[-+]?(nan|inf|infinity)(?![\w:/=-])", out, re.IGNORECASE)
        if number and number[0] not in arguments:  # a folder may have any name
            return f"a number that is none: {number[0]}"
    return ""


def _refuse(constant: str) -> None:
    raise ValueError(f"a number that is none: {constant}")


def fuzz(kind: str, first: int, count: int, keep: Path | None = None) -> int:
    """Try inputs of a kind, print the findings, return their number.

    Args:
        kind: name of a method of `Makers`.
        first: number of the first input.
        count: of inputs.
        keep: folder for what offended; none when None.
    """
    answered = findings = 0
    with tempfile.TemporaryDirectory(prefix="fuzz-") as place:
        base = Path(place)
        makers = SolidMakers(base, mutated) if kind in SOLIDS else Makers(base)
        makers.prepare(kind)
        for number in range(first, first + count):
            folder = Path(place) / "input"
            folder.mkdir()
            arguments = getattr(makers, kind)(random.Random(f"{kind} {number}"), folder)
            code, fault, messages = attempt(arguments, folder)
            answered += code == 0
            if fault:
                findings += 1
                last = "\n".join(messages.splitlines()[-6:])
                print(f"{kind} {number}: {arguments}: {fault}\n{last}\n", flush=True)
                if keep is not None:
                    shutil.copytree(folder, keep / f"{kind}_{number}", symlinks=True)
            shutil.rmtree(folder)
    print(f"{kind}: {count} inputs, {answered} answered, {findings} findings")
    return findings


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Give the command line inputs nobody means.")
    parser.add_argument("kind", choices=(*COMMANDS, *SOLIDS))
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--keep", type=Path)
    given = parser.parse_args()
    sys.exit(bool(fuzz(given.kind, given.first, given.count, given.keep)))
