"""The benchmarks run; their results need an idle machine."""

import subprocess
import sys

import pytest
from places import ROOT

BENCHMARKS = ROOT / "benchmarks"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("script", "arguments", "words"),
    [
        ("joints.py", ["--points", "2"], ["100 N", "30 N"]),
        ("march.py", ["--repeat", "1"], ["no contact", "few contacts", "NumPy"]),
        ("shaft_line.py", ["--repeat", "1"], ["fan on the line", "ready after", "301"]),
        (
            "sweep.py",
            ["--workers", "1", "--points", "1", "--duration", "0.01", "--turns", "1"],
            ["per step of a worker", "efficiency"],
        ),
    ],
)
def test_benchmark(script: str, arguments: list[str], words: list[str]) -> None:
    command = [sys.executable, str(BENCHMARKS / script), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert all(word in done.stdout for word in words)
