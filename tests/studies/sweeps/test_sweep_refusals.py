"""Sweeps that are refused, in one line and before a folder is made."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from faults import fault
from small_run import small

from bladewhirl.studies.sweeps.sweep import run_sweep

FRICTION = ["contact.friction = 0.1"]
SPEEDS: dict[str, Any] = {"march.speed": [1.0, 1.1]}
CLOSING = {"casing.closure": {"amount": 1e-4, "time_constant": 0.1}}

KEYS: list[tuple[dict[str, Any], str]] = [
    ({}, "expected at least one key"),
    ({"march.sped": (1, 2)}, "holds a number; the nearest is march.speed"),
    ({"contact.sliding": (1, 2)}, "holds a number; the nearest is contact."),
    ({"march": (1, 2)}, "holds a number; the nearest is "),
    ({"blade_loss.share": (0.1, 0.5)}, "holds a number; the nearest is "),
    ({"excitation.clearance_speed": (1, 2)}, "holds a number; the nearest is "),
    *(
        ({"march.speed": values}, "--over march.speed: expected")
        for values in ((1.0,), (1.0, 1.0), (1, 1.0), ())
    ),
    (
        {"contact.friction": (0.1, -0.1), "march.speed": (1.0, 1.1)},
        "point contact.friction = -0.1, march.speed = 1.0: contact.friction = -0.1",
    ),
    # Only the stage has the critical step.
    ({"march.time_step": (2e-6, 1e-4)}, "point march.time_step = 1e-4: march.time_step"),
]
"""Values of `over`."""

COLUMNS: list[tuple[dict[str, Any], str]] = [
    ({"march.speed": [1, 2], "contact.friction": [0.1]}, "of equal length, not of 2, 1"),
    ({"march.sped": [1, 2]}, "table, march.sped: expected a key of the case"),
    ({"casing.clearance": ["1 mm", "1 kg"]}, "table, casing.clearance: expected one unit"),
    (
        {"casing.clearance [kg]": [1]},
        'table, row 0, casing.clearance = "1 kg": casing.clearance = "1 kg": expected',
    ),
    ({"march.speed": [1.0, np.nan]}, "table, row 1, march.speed = nan: expected a number"),
    (
        {"contact.friction": [0.1, -1]},
        "table, row 1, contact.friction = -1: contact.friction = -1: expected",
    ),
]
"""Values of `table`."""

OPTIONS: list[tuple[dict[str, Any], str]] = [
    ({"draws": 3}, "--draws 3: needs --perturb"),
    ({"perturb": FRICTION}, "--perturb: needs --draws"),
    ({"draws": 1, "perturb": FRICTION}, "expected 2 to 10000 random draws"),
    ({"draws": 3, "perturb": FRICTION * 2}, "expected each key at most once"),
    *(
        ({"draws": 3, "perturb": [change]}, expected)
        for change, expected in (
            ("contact.friction", 'expected "KEY = SIZE"'),
            ("contact.friction = 0", "a size above zero"),
            ("contact.friction = 0.1 uniform normal", 'expected "KEY = SIZE"'),
            ("contact.grip = 0.1", "a key of the case that holds a number"),
        )
    ),
    *(
        (
            {"draws": 20, "perturb": FRICTION, "until": width},
            f"--until {width}: expected the width of a confidence interval",
        )
        for width in (0.0, 1.0, float("nan"))
    ),
    ({"until": 0.2}, "--until 0.2: needs --draws"),
    ({"screen": True}, "--screen: needs --draws of at least"),
    ({"screen": True, "draws": 3, "perturb": FRICTION}, "--screen: needs --draws of at least"),
    (
        {"screen": True, "draws": 9, "perturb": FRICTION, "histories": True},
        "--screen: not allowed together with --histories",
    ),
    ({"carry": "up", "over": {"contact.friction": [0.1, 0.2]}}, "needs --over march.speed"),
    ({"carry": "up", "stop_when": "damped"}, "not allowed together with --screen, --until"),
    ({"start": "periodic"}, "as tips of beams have mass"),
    ({"start": "periodic", "histories": True}, "--start periodic: not allowed together with"),
    ({"carry": "up"}, "--continue: expected marches of at least 3 revolutions, not of"),
    ({"carry": "up", "case": CLOSING}, "--continue: expected a casing without casing.coating"),
]
"""Other arguments of `run_sweep`, and values of the case."""


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        *(({"over": keys}, expected) for keys, expected in KEYS),
        *(({"over": {}, "table": table}, expected) for table, expected in COLUMNS),
        *OPTIONS,
    ],
)
def test_sweeps_are_refused(given: dict[str, Any], expected: str, tmp_path: Path) -> None:
    arguments: dict[str, Any] = {"over": SPEEDS, **given}
    case = small(**arguments.pop("case", {}))
    assert expected in fault(run_sweep, case, directory=tmp_path / "sweep", **arguments)
    assert not [*tmp_path.iterdir()]
