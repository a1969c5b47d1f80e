"""Errors of the operating system end in one line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import refusal
from small_run import COMMAND


def bladewhirl(*arguments: str, output: str = os.devnull) -> subprocess.CompletedProcess[str]:
    with Path(output).open("w") as stream:
        return subprocess.run(
            [sys.executable, "-c", COMMAND, *arguments],
            stdout=stream,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONIOENCODING": "ascii"},
        )


def test_full_standard_output() -> None:
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full")
    ended = bladewhirl("--version", output="/dev/full")
    expected = "standard output: cannot be used (No space left on device)\n"
    assert (ended.returncode, ended.stderr) == (2, expected)


def test_a_pipe_is_no_case(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "case.toml")
    line = refusal("show", tmp_path / "case.toml")
    assert line.endswith("expected a readable file (it is not a regular file)")
