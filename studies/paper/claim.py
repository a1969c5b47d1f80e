"""Claims of the source paper, how each is judged, and the list of all of them.

A claim is judged by code: its evaluator looks at numbers computed by bladewhirl and returns checks,
each a comparison with a stated threshold. All met: it holds; some: partly; none, or an essential
one not met: it does not hold. What cannot be judged is not testable, with the reason.

What each claim says, where, and the marches (`trials.TRIALS`) and sweeps (`trials.SURVEYS`) it is
judged by is in claims.csv beside this module; the modules claims_* judge.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.studies.paper.trials import Evidence, NotTestableError, table

Verdict = Literal["holds", "partly", "does not hold", "not testable"]

VERDICTS: tuple[Verdict, ...] = get_args(Verdict)


@dataclass(frozen=True, kw_only=True)
class Check:
    """Comparison of a number with a criterion."""

    text: str  #: what was compared with which threshold, with our number
    met: bool
    essential: bool = False  #: the claim does not hold without it


@dataclass(frozen=True, kw_only=True)
class Finding:
    """The outcome of judging a claim once."""

    ours: str  #: our value, in the words of the claim
    checks: tuple[Check, ...] = ()
    obstacle: str = ""  #: why it could not be judged; empty if it could

    @property
    def verdict(self) -> Verdict:
        """Verdict by the rule at the top of this module."""
        if self.obstacle:
            return "not testable"
        if all(check.met for check in self.checks):
            return "holds"
        wrong = any(check.essential and not check.met for check in self.checks)
        return "does not hold" if wrong or not any(c.met for c in self.checks) else "partly"

    @property
    def why(self) -> str:
        """Reason in one sentence: the criteria that failed, or were met."""
        if self.obstacle:
            return f"{self.obstacle}."
        failed = [check.text for check in self.checks if not check.met]
        met = [check.text for check in self.checks if check.met]
        if not failed:
            return f"{'; '.join(met)}."
        kept = f"; met: {'; '.join(met)}" if met else ""
        return f"not met: {'; '.join(failed)}{kept}."


Evaluator = Callable[..., Finding]
"""Called with the marches of a claim, then its sweeps; with the `Evidence` where it has neither."""


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A statement of the paper that can be computed, and the function that judges it."""

    number: int
    section: str  #: of the paper
    figures: tuple[str, ...]  #: of the paper
    text: str  #: the claim in our words
    paper: str  #: the paper's value
    trials: tuple[str, ...]  #: marches it is judged by
    sweeps: tuple[str, ...]  #: sweeps it is judged by
    evaluate: Evaluator

    def judge(self, evidence: Evidence) -> Finding:
        """Judge the claim once; an obstacle becomes part of the finding."""
        try:
            motions = [evidence.motion(name) for name in self.trials]
            sweeps = [evidence.sweep(name) for name in self.sweeps]
            return self.evaluate(*([*motions, *sweeps] or [evidence]))
        except (NotTestableError, ViewError) as error:
            return Finding(ours="–", obstacle=str(error).rstrip("."))


CLAIMS: dict[int, Claim] = {}
"""All claims by number, filled by the modules claims_*."""


ROWS = {int(row["number"]): row for row in table("claims")}


def evaluates(number: int) -> Callable[[Evaluator], Evaluator]:
    """Register the function that judges a claim."""

    def register(evaluate: Evaluator) -> Evaluator:
        row = ROWS[number]
        CLAIMS[number] = Claim(
            number=number,
            section=row["section"],
            text=row["text"],
            paper=row["paper"],
            evaluate=evaluate,
            **{name: _listed(row[name]) for name in ("figures", "trials", "sweeps")},
        )
        return evaluate

    return register


def _listed(cell: str) -> tuple[str, ...]:
    return tuple(cell.split("; ")) if cell else ()


def near(name: str, value: float, target: float, tolerance: float, unit: str = "") -> Check:
    """A number within a tolerance of the paper's."""
    text = f"{name} {value:.4g}{unit}, expected {target:.4g} ± {tolerance:g}{unit}"
    return Check(text=text, met=abs(value - target) <= tolerance)


def between(name: str, value: float, low: float, high: float, unit: str = "") -> Check:
    """A number within limits."""
    text = f"{name} {value:.3g}{unit}, expected {low:g} to {high:g}{unit}"
    return Check(text=text, met=low <= value <= high)


def at_least(name: str, value: float, low: float, unit: str = "") -> Check:
    """A number from a limit on."""
    text = f"{name} {value:.3g}{unit}, expected {low:g}{unit} or more"
    return Check(text=text, met=value >= low)


def at_most(name: str, value: float, high: float, unit: str = "") -> Check:
    """A number up to a limit."""
    return Check(
        text=f"{name} {value:.3g}{unit}, expected {high:g}{unit} or less", met=value <= high
    )


def equal(name: str, ours: object, expected: object, *, essential: bool = False) -> Check:
    """A kind of motion, a direction, and the like."""
    text = f"{name} {ours}" if ours == expected else f"{name} {ours}, expected {expected}"
    return Check(text=text, met=ours == expected, essential=essential)
