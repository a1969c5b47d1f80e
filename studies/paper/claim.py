"""Claims of the source paper, and the rules by which they are judged.

The file claims.csv in this folder contains the text of each claim, its place in the paper, and the
marches (`trials.TRIALS`) and sweeps (`trials.SURVEYS`) by which it is judged. A function in a
module claims_* computes the measures of a claim; checks.csv contains their thresholds. A claim
holds if all checks are met, and holds partly if only some are met. It does not hold if no check is
met, or if an essential check fails. A claim that cannot be judged is not testable, for a stated
reason.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

from bladewhirl.files import packaged_rows
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.studies.paper.trials import Evidence, NotTestableError

Verdict = Literal["holds", "partly", "does not hold", "not testable"]

VERDICTS: tuple[Verdict, ...] = get_args(Verdict)


@dataclass(frozen=True, kw_only=True)
class Check:
    """Comparison of a measure with a criterion."""

    text: str  #: name of the measure, computed number, threshold
    met: bool
    essential: bool = False  #: the claim does not hold if this check fails


@dataclass(frozen=True, kw_only=True)
class Finding:
    """The outcome of judging a claim once."""

    ours: str  #: computed value, in the form of the paper's value
    checks: tuple[Check, ...] = ()
    obstacle: str = ""  #: why the claim cannot be judged; empty if the claim is judged

    @property
    def verdict(self) -> Verdict:
        """Verdict by the rules in the docstring of this module."""
        if self.obstacle:
            return "not testable"
        if all(check.met for check in self.checks):
            return "holds"
        wrong = any(check.essential and not check.met for check in self.checks)
        return "does not hold" if wrong or not any(c.met for c in self.checks) else "partly"

    @property
    def why(self) -> str:
        """Reason in one sentence: the failed criteria, or all criteria if none failed."""
        if self.obstacle:
            return f"{self.obstacle}."
        failed = [check.text for check in self.checks if not check.met]
        met = [check.text for check in self.checks if check.met]
        if not failed:
            return f"{'; '.join(met)}."
        kept = f"; met: {'; '.join(met)}" if met else ""
        return f"not met: {'; '.join(failed)}{kept}."


Measures = Mapping[str, Any]
"""Numbers, texts and flags by name, for the checks and the computed value of a claim."""

Measure = Callable[..., Measures]
"""Function that computes measures from the marches and sweeps of a claim, or from an `Evidence` if
the claim has neither marches nor sweeps."""

CRITERIA: Mapping[str, tuple[str, Callable[[float, float, float], bool]]] = {
    "near": ("{0:g} ± {1:g}{2}", lambda value, target, tolerance: abs(value - target) <= tolerance),
    "between": ("{0:g} to {1:g}{2}", lambda value, low, high: low <= value <= high),
    "at least": ("{0:g}{2} or more", lambda value, low, _: value >= low),
    "at most": ("{0:g}{2} or less", lambda value, high, _: value <= high),
}
"""Criteria for numbers: text of the expected value, and function that returns whether a number
meets it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Claim:
    """A statement of the paper that can be tested, and the function that computes its measures."""

    number: int
    section: str  #: section of the paper
    figures: tuple[str, ...]  #: figures of the paper
    text: str  #: the claim in our words
    paper: str  #: the paper's value
    ours: str  #: format of the computed value, with names of measures in braces
    trials: tuple[str, ...]  #: names of the marches by which the claim is judged
    sweeps: tuple[str, ...]  #: names of the sweeps by which the claim is judged
    checks: tuple[Mapping[str, str], ...]  #: rows of checks.csv
    measure: Measure

    @property
    def place(self) -> list[int]:
        """Numbers of the section and of the sections that contain it, as a sort key."""
        return [int(part) for part in self.section.split(".")]

    def judge(self, evidence: Evidence) -> Finding:
        """Judge the claim once; if it cannot be judged, the finding contains the obstacle."""
        try:
            motions = [evidence.motion(name) for name in self.trials]
            sweeps = [evidence.sweep(name) for name in self.sweeps]
            return self.finding(self.measure(*([*motions, *sweeps] or [evidence])))
        except (NotTestableError, ViewError) as error:
            return Finding(ours="–", obstacle=str(error).rstrip("."))

    def finding(self, measures: Measures) -> Finding:
        """Compare measures with their thresholds; checks without a measure are left out."""
        rows = [row for row in self.checks if row["measure"] in measures]
        return Finding(
            ours=self.ours.format_map(measures),
            checks=tuple(check(row, measures[row["measure"]]) for row in rows),
        )


def check(row: Mapping[str, str], value: Any) -> Check:
    """Compare a measure with the criterion of a row of checks.csv."""
    name, criterion = row["name"], row["criterion"]
    if criterion == "is true":
        text, met = name, bool(value)
    elif criterion == "equal":
        met = str(value) == row["first"]
        text = f"{name}: {value}" if isinstance(value, str) else f"{name} = {value}"
        text += "" if met else f" (expected {row['first']})"
    else:
        expected, meets = CRITERIA[criterion]
        first, second = float(row["first"]), float(row["second"] or "nan")
        limits = expected.format(first, second, row["unit"])
        text = f"{name} = {value:.4g}{row['unit']} (expected {limits})"
        met = bool(meets(value, first, second))
    return Check(text=text, met=met, essential=row["essential"] == "yes")


CLAIMS: dict[int, Claim] = {}  #: all claims by number, filled by the modules claims_*

ROWS = {int(row["number"]): row for row in packaged_rows(__package__, "claims.csv")}
CHECKS = packaged_rows(__package__, "checks.csv")


def measures(*numbers: int) -> Callable[[Measure], Measure]:
    """Return a decorator for the function that computes the measures of the claims `numbers`."""

    def register(measure: Measure) -> Measure:
        for number in numbers:
            row: dict[str, Any] = ROWS[number] | {"number": number}
            for name in ("figures", "trials", "sweeps"):
                row[name] = tuple(filter(None, row[name].split("; ")))
            checks = tuple(check for check in CHECKS if int(check["claim"]) == number)
            CLAIMS[number] = Claim(checks=checks, measure=measure, **row)
        return measure

    return register
