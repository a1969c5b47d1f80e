"""A case of a few blades, cheap to march, and what gives commands in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import loads, with_values

SMALL = """
title = "A few blades"
[bladed_disk]
blades = 6
elements_per_blade = 2
[casing]
elements = 12
support = 7.975e6
[reduction]
fixed_interface_modes = 10
[excitation]
type = "casing-distortion"
modal_force = 30000
duration = "5 ms"
[march]
time_step = 2e-6
record_step = 1e-4
duration = 0.01
"""

COMMAND = "from bladewhirl.studies.commands.cli import main; main()"
"""Program of a process that takes the arguments of `bladewhirl`."""


def small(**values: object) -> Case:
    """The case with other values, by dotted key."""
    return with_values(loads(SMALL), values)


def run_script(name: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a script that lies beside this one, which it may import."""
    script = Path(__file__).with_name(name)
    beside = {**os.environ, "PYTHONSAFEPATH": ""}
    return subprocess.run(
        [sys.executable, script, *arguments], capture_output=True, text=True, env=beside
    )
