"""Inputs that nobody means, given to the command line: `python tests/support/fuzz.py KIND`.

Each input is one command, tried in a process of its own with little time and memory, which must
end in an answer or in a sentence: no traceback, no warning, no number that is none, no kill. Inputs
are made from their number alone, so a finding is repeated by `--first NUMBER --count 1`.
"""

import argparse
import contextlib
import io
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import h5py
import numpy as np
from small_run import COMMAND, SMALL, small

from bladewhirl.meshes.files.registry import WRITERS
from bladewhirl.models.case.file import read_case
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.inputs.errors import toml_value
from bladewhirl.studies.commands.cli import app, main

ROOT = Path(__file__).parents[2]
SECONDS, BYTES, FILE_BYTES = 30, 6 * 2**30, 2**28
"""What a command may take: of the processor (twenty times that on the clock), memory and disk."""

RECORDED = {"march.record_step": 2e-5, "march.duration": 0.002}
"""Values of the run, and of the case, that inputs begin with."""

SHORT = "march = { speed = 1.05, time_step = 2e-6, record_step = 2e-5, duration = 4e-4 }"

VALUES: tuple[Any, ...] = (
    *(0, 1, -1, 2, 3, 7, 22, 2**31, 2**63, -(2**63), 10**30, True, False),
    *(0.0, -0.0, 0.5, -1.5, 1e-300, 5e-324, 1e-9, 1e9, 1e299, 1.7e308, -1e308),
    *(float("nan"), float("inf"), -float("inf")),
    *("", "a", "1 mm", "120 mm", "-3 mm", "1e400 mm", "2500 rpm", "nan Hz", "inf", "1 kg", "m"),
    *("all six free 1F:1 casing:99 none imbalance harmonic \x00 ü\u202e".split(" ")),
    *([], {}, [1], ["a"], [[0.0, 1.0]], [{}], {"a": 1}, {"width": "120 mm"}, [[[]]]),
)

FACTORS = (0, -1, 1e-300, 1e-12, 1e-3, 0.3, 0.9, 1.1, 2, 3, 4, 1e3, 1e12, 1e300)
"""What numbers of a case are multiplied by."""

WORDS = (
    *("0", "1", "-1", "3", "1e300", "nan", "inf", "-inf", "1e-300", "99999999999", "x", "", " "),
    *("0:1", "1:2:3", "2:1:3", "0:1:-1", "nan:1:2", "0:1e300:3", "::", "1 rpm:2 rpm:2", "0:0:0"),
    *("1 ms", "-1 ms", "1e400 s", "a,b", "1F:1", "casing:1", "1F:1,,", "1,2", "\ud800", "ü" * 9),
    *("march.speed=1.2", "march.speed=fast", "casing.struts=[{}]", "title=x", "=", "a.b.c=1"),
    *("march.speed=1.1,1.2", "contact.friction=0:0.2:2", "casing=1", "excitation={type='none'}"),
)
"""Arguments of options."""

MODAL = (
    *("show", "show --case", "modes --json --count 9", "mesh", "mesh -o out.vtu"),
    *("mesh -o out.inp", "campbell --json", "veering --json"),
    "stability --json --speed 1.1 --kappa 300",
    "stability --json --speeds 0.9:1.2:3 --kappas 0:300:2",
    "sweep --over march.speed=1,2 --dry",
)
"""Commands on a case."""

READING = (
    *("plot run orbit", "plot run energy -o p.png", "plot run gaps", "plot run spectrum --data"),
    *("plot run contact-phase", "plot run stress", "plot run regime", "plot run whirl"),
    *("plot run energy-families", "export run --frames 2 -o s", "export run --frames 2 --surface"),
    *("report run", "run --resume run --frames 0", "run --resume run --set march.duration=0.003"),
)
"""Commands on a run."""


SWEEP = ("plot sweep", "plot sweep frequency-map", "report sweep", "plot sweep regimes")
"""Commands on a sweep."""


class Finding(NamedTuple):
    """An input that ended in something else than an answer or a sentence."""

    number: int
    arguments: list[str]
    fault: str
    told: str  #: the last lines of standard error


class Makers:
    """Inputs of all kinds, by number; what they begin with is made once, in a folder.

    Args:
        base: folder for it.
    """

    def __init__(self, base: Path) -> None:
        self._base = base
        files = sorted((ROOT / "examples").glob("*.toml"))
        self._tables = [_small(read_case(file).model_dump(exclude_none=True)) for file in files]
        self._tables.append(small().model_dump(exclude_none=True))
        self._tables.append(
            read_case(ROOT / "tests/data/sketch_stage.toml").model_dump(exclude_none=True)
        )
        self._keys = sorted({key for tables in self._tables for key in _keys(tables)})

    def prepare(self, kind: str) -> None:
        """Make what inputs of a kind begin with, and load what their commands need."""
        (self._base / "case.toml").write_text(dumps_case(small(**RECORDED)))
        meshes = self._base / "meshes"
        shutil.copytree(ROOT / "tests/data/meshes", meshes)
        shutil.copy(ROOT / "examples/shrouded_fan.msh", meshes)
        with contextlib.chdir(self._base):
            for suffix in WRITERS:
                call(["mesh", "case.toml", "-o", f"meshes/disk{suffix}"])
            call(["run", "case.toml", "--frames", "2", "-o", "run"])
            if kind == "sweep":  # pools leave threads behind, which forks don't go with
                over = "sweep case.toml --over march.speed=1,1.1 -o sweep --workers 1 --yes"
                given = [sys.executable, "-c", COMMAND, *over.split(), "--set", SHORT]
                subprocess.run(given, check=True, capture_output=True)
            shutil.copytree("run", "used")
            warm = {"case": MODAL, "mesh": MODAL[:5], "sweep": SWEEP}.get(kind, READING)
            for words in warm:
                command, *rest = words.replace(" run", " used").split()
                call([command, *(["case.toml"] if words in MODAL else []), *rest])

    def case(self, chance: random.Random, folder: Path) -> list[str]:
        """A case with other values, or other bytes."""
        tables = json.loads(json.dumps(chance.choice(self._tables)))
        own = sorted(_keys(tables))
        for _ in range(chance.choice((1, 1, 2, 3))):
            _change(tables, chance.choice(own if chance.random() < 0.8 else self._keys), chance)
        words = chance.choice((*MODAL, "run --frames 0 --json -o run", "run --frames 0 -o run"))
        text = "\n".join(f"{key} = {toml_value(value)}" for key, value in tables.items()).encode()
        if chance.random() < 0.2:
            text = mutated(text, chance)
        (folder / "case.toml").write_bytes(text)
        command, *rest = words.split()
        march = ["--set", SHORT] if command == "run" and chance.random() < 0.8 else []
        return [command, "case.toml", *rest, *march]

    def mesh(self, chance: random.Random, folder: Path) -> list[str]:
        """A mesh file with other bytes, looked at, written, or named by a case."""
        files = [f for f in sorted((self._base / "meshes").iterdir()) if f.suffix in WRITERS]
        source = chance.choice(files)
        content = mutated(source.read_bytes(), chance)
        suffix = chance.choice((source.suffix,) * 9 + tuple(WRITERS))
        (folder / f"disk{suffix}").write_bytes(content)
        if chance.random() < 0.6:
            out = chance.choice(([], ["-o", f"out{chance.choice(tuple(WRITERS))}"]))
            return ["mesh", f"disk{suffix}", *out]
        table = f'bladed_disk.mesh = {{ file = "disk{suffix}", tips = "tips" }}\n'
        (folder / "case.toml").write_text(table + chance.choice(("", "casing.elements = 12\n")))
        return [chance.choice(("show", "modes")), "case.toml", "--json"]

    def result(self, chance: random.Random, folder: Path) -> list[str]:
        """A run with other bytes or values in its files, looked at."""
        shutil.copytree(self._base / "run", folder / "run")
        names = ("result.nc",) * 8 + ("checkpoint.npz", "case.toml", "summary.json")
        file = folder / "run" / chance.choice((*names, "provenance.json"))
        if file.suffix == ".nc" and chance.random() < 0.6:
            edit(file, chance)
        else:
            file.write_bytes(mutated(file.read_bytes(), chance))
        return chance.choice(READING).split()

    def sweep(self, chance: random.Random, folder: Path) -> list[str]:
        """A sweep with other bytes or values in its files, looked at or gone on with."""
        shutil.copytree(self._base / "sweep", folder / "sweep")
        failures = [{"point": 1, "march.speed": 1.1, "reason": "why"}]
        (folder / "sweep" / "failures.json").write_text(json.dumps(failures))
        names = ("sweep.nc", "sweep.nc", "sweep.json", "failures.json")
        file = folder / "sweep" / chance.choice(names)
        if file.suffix == ".nc" and chance.random() < 0.6:
            edit(file, chance)
        elif file.suffix == ".json" and chance.random() < 0.6:
            document = json.loads(file.read_text())
            _change_json(document, chance)
            file.write_text(json.dumps(document))
        else:
            file.write_bytes(mutated(file.read_bytes(), chance))
        resume = ["sweep --resume sweep --workers 1 --yes"] if file.suffix == ".json" else []
        words = (*SWEEP, *resume)
        return chance.choice(words).split()

    def options(self, chance: random.Random, folder: Path) -> list[str]:
        """A command with words that fit none of its options, or all."""
        import typer.main

        (folder / "case.toml").write_text(SMALL)
        os.symlink(self._base / "run", folder / "run")
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
        if name == "new":
            given = [word for word in given if not word.startswith("/")]
        return given


def _small(tables: dict[str, Any]) -> dict[str, Any]:
    """A case with fewer elements, to be cheap."""
    disk = tables.get("bladed_disk", {})
    if "superelement" in disk:
        tables["reduction"]["free_interface_modes"] = 5
    elif "mesh" not in disk and not any(disk.get(key) for key in ("centre_line", "taper")):
        disk["elements_per_blade"] = 3
    tables["reduction"]["fixed_interface_modes"] = 10
    tables["march"] |= {"duration": 4e-4}
    return tables


def _keys(tables: dict[str, Any], prefix: str = "") -> Iterator[str]:
    for key, value in tables.items():
        yield prefix + key
        if isinstance(value, dict):
            yield from _keys(value, f"{prefix}{key}.")


def _change(tables: Any, key: str, chance: random.Random) -> None:
    """Give a dotted key another value, go into arrays now and then, or drop it."""
    *parents, name = key.split(".")
    for parent in parents:
        if not isinstance(tables, dict):
            return
        tables = tables.setdefault(parent, {})
    if not isinstance(tables, dict):
        return
    old = tables.get(name)
    way = chance.random()
    if isinstance(old, list) and old and way < 0.5:
        row = chance.randrange(len(old))
        if isinstance(old[row], dict) and old[row]:
            _change(old[row], chance.choice(sorted(old[row])), chance)
        else:
            old[row] = chance.choice(VALUES)
    elif way < 0.1:
        tables.pop(name, None)
    elif isinstance(old, int | float) and not isinstance(old, bool) and way < 0.8:
        number = (old or 1) * chance.choice(FACTORS)
        tables[name] = int(number) if isinstance(old, int) and chance.random() < 0.9 else number
    else:
        tables[name] = chance.choice(VALUES)


def _change_json(document: Any, chance: random.Random) -> None:
    """Another value somewhere in a document."""
    while isinstance(document, dict | list) and document:
        keys = list(document) if isinstance(document, dict) else range(len(document))
        key = chance.choice(list(keys))
        if not isinstance(document[key], dict | list) or chance.random() < 0.4:
            document[key] = chance.choice((*VALUES, None))
            return
        document = document[key]


def mutated(content: bytes, chance: random.Random) -> bytes:
    """Bytes with some flipped, cut out, doubled, replaced or lost at the end."""
    made = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 8))):
        at = chance.randrange(len(made) + 1)
        span = min(len(made) - at, chance.choice((1, 1, 4, 30, 500)))
        match chance.randrange(6):
            case 0 | 1 if at < len(made):
                made[at] ^= 1 << chance.randrange(8)
            case 2:
                del made[at : at + span]
            case 3:
                made[at:at] = made[at : at + span]
            case 4:
                word = chance.choice(("1e400", "nan", "-1", "0", "99999999999", "\n", '"', "\xff"))
                made[at : at + span] = word.encode("latin-1")
            case 5 if chance.random() < 0.3:
                del made[at:]
            case _:
                numbers = [*re.finditer(rb"-?\d+\.?\d*(e-?\d+)?", made[:100_000])]
                if numbers:
                    actual = chance.choice(numbers)
                    word = chance.choice(("0", "-1", "1e300", "nan", "7", "99999999999"))
                    made[actual.start() : actual.end()] = word.encode()
    return bytes(made)


def edit(file: Path, chance: random.Random) -> None:
    """Give a netCDF file another attribute, another value, or another shape of an array."""
    words: tuple[Any, ...] = ("fast", "", np.nan, np.inf, -1, 0, 999, 1e300, b"\xff", [])
    with h5py.File(file, "r+") as h5:
        names = sorted(name for name in h5 if isinstance(h5[name], h5py.Dataset))
        if chance.random() < 0.5:
            own = sorted(h5.attrs)
            name = chance.choice([key for key in own if not key.startswith("_")])
            if chance.random() < 0.15:
                del h5.attrs[name]
            else:
                h5.attrs[name] = chance.choice(words)
            return
        name = chance.choice(names)
        data = h5[name]
        way = chance.random()
        if way < 0.1:
            del h5[name]
        elif data.size and data.dtype.kind in "fi":
            where = tuple(chance.randrange(length) for length in data.shape)
            kinds = {"f": (np.nan, np.inf, -1.0, 1e300, 0.0, 999.0), "i": (-1, 0, 99, 127)}
            value = chance.choice(kinds[data.dtype.kind])
            if way < 0.6 or not where:
                data[where] = value
            else:
                data[...] = value
        elif data.size:
            data[...] = "nothing"


def call(arguments: list[str]) -> None:
    """Give a command in this process, output and end aside."""
    out, err = (io.TextIOWrapper(io.BytesIO()) for _ in range(2))
    with (
        mock.patch.object(sys, "argv", ["bladewhirl", *arguments]),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        contextlib.suppress(SystemExit),
    ):
        main()


def attempt(arguments: list[str], folder: Path) -> tuple[int, str, str]:
    """Give a command in a process of its own: exit code, fault (empty if none), its words."""
    child = os.fork()
    if child == 0:
        _child(arguments, folder)
    signal.signal(signal.SIGALRM, lambda *_: os.killpg(child, signal.SIGKILL))
    signal.alarm(20 * SECONDS)
    _, status = os.waitpid(child, 0)
    signal.alarm(0)
    with contextlib.suppress(ProcessLookupError):  # what it started and left
        os.killpg(child, signal.SIGKILL)
    out = (folder / ".out").read_text(errors="replace")
    messages = (folder / ".err").read_text(errors="replace")
    code = os.waitstatus_to_exitcode(status)
    return code, _fault(code, out, messages, arguments), messages


def _child(arguments: list[str], folder: Path) -> None:
    """The process that gives a command; never returns."""
    code = 70
    try:
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
        sys.argv = ["bladewhirl", *arguments]
        main()
        code = 0
    except SystemExit as left:
        code = left.code if isinstance(left.code, int) else 0 if left.code is None else 70
    except BaseException:
        traceback.print_exc()
    with contextlib.suppress(BaseException):
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(code)


def _fault(code: int, out: str, told: str, arguments: list[str]) -> str:
    """Why a command did not end well; empty if it did."""
    if code == -signal.SIGKILL and "Large stage: " in told:
        return ""  # it said before it began what it takes
    if code < 0:
        return f"killed by {signal.Signals(-code).name}"
    if "Traceback" in told or "Traceback" in out:
        return "traceback"
    if re.search(r"\w+Warning\b", told):
        return "warning"
    if code not in (0, 1, 2):
        return f"exit code {code}"
    if code and not told.strip():
        return f"exit code {code} without a word"
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


def fuzz(kind: str, first: int, count: int, keep: Path | None = None) -> list[Finding]:
    """Try inputs of a kind; what went wrong.

    Args:
        kind: name of a method of `Makers`.
        first: number of the first input.
        count: of inputs.
        keep: folder for what offended; none when None.
    """
    actual, answered = [], 0
    with tempfile.TemporaryDirectory(prefix="fuzz-") as place:
        makers = Makers(Path(place))
        makers.prepare(kind)
        for number in range(first, first + count):
            folder = Path(place) / "input"
            folder.mkdir()
            arguments = getattr(makers, kind)(random.Random(f"{kind} {number}"), folder)
            code, fault, messages = attempt(arguments, folder)
            answered += code == 0
            if fault:
                last = "\n".join(messages.splitlines()[-6:])
                actual.append(Finding(number, arguments, fault, last))
                print(f"{kind} {number}: {arguments}: {fault}\n{last}\n", flush=True)
                if keep is not None:
                    shutil.copytree(folder, keep / f"{kind}_{number}", symlinks=True)
            shutil.rmtree(folder)
    print(f"{kind}: {count} inputs, {answered} answered, {len(actual)} findings")
    return actual


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Give the command line inputs nobody means.")
    parser.add_argument("kind", choices=["case", "mesh", "result", "sweep", "options"])
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--keep", type=Path)
    wanted = parser.parse_args()
    sys.exit(bool(fuzz(wanted.kind, wanted.first, wanted.count, wanted.keep)))
