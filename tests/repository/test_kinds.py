"""Places that ask whether a bladed disk consists of beams or is a superelement.

Features are built for one type, `models/stage/stage.py`. The list below holds what is left; it may
only become shorter.
"""

import re
from collections import Counter

from places import ROOT

LAYERS = ("models", "solvers", "postprocess", "studies")

KINDS = (
    "Stage|Beams|Matrices|ModalModel|ModalDisk|BeamDisk|MatrixDisk"
    "|ListedModes|WhirlModes|LabelledModes|ContactProblem"
)

QUESTIONS = re.compile(
    rf"isinstance\([^()]*\b(?:{KINDS})\)"
    r"|\.superelement\b(?: is(?: not)? None|:)"
)

BUILDERS = {
    "models/stage/build.py",
    "models/stage/modal.py",
    "models/elements/build.py",  # of beams: refuses a superelement
    "models/case/bladed_disk.py",  # the table that has either
}

LEFT = {"models/case/case.py": 1}


def test_no_further_place_asks_for_the_kind_of_a_stage() -> None:
    found: Counter[str] = Counter()
    for layer in LAYERS:
        for path in sorted((ROOT / layer).rglob("*.py")):
            name = path.relative_to(ROOT).as_posix()
            if name not in BUILDERS and not name.startswith("studies/verification/"):
                found[name] += len(QUESTIONS.findall(path.read_text(encoding="utf-8")))
    assert {name: count for name, count in found.items() if count} == LEFT
