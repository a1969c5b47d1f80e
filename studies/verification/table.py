"""Table of verification cases: computation, and output as text, JSON, Markdown or a page."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module, metadata

from bladewhirl.files import json_text
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.reports.page import Page, PageSection, PageTable
from bladewhirl.studies.verification.case import CASES, Outcome, VerificationCase, rows

SUBJECTS = {
    "modes": "Modes and stiffnesses",
    "rings": "Rings",
    "contact": "Impacts and friction",
    "march": "March in time",
    "results": "Balances from the result file",
    "stability": "Parametric stability",
    "rotation": "Effects of rotation",
    "whirl": "Marches with Coriolis forces",
    "shaft": "Shaft lines",
    "speed": "Speed that varies",
    "forced": "Engine-order forces",
    "sensors": "Sensors",
    "coating": "Abradable coating",
    "foreshortening": "Blades that draw back",
    "superelement": "Superelements",
    "periodic": "Periodic rubs",
    "joints": "Friction joints",
}
"""Titles of the subjects by the name of their module, in the order of the table."""

HEAD = ("", "quantity", "source", "values", "reference", "calculated", "largest error", "allowed")

WORDS = (
    "Each quantity is computed through the functions that commands and Python use, and compared"
    " with a closed-form solution, a published value, another program, or a law of motion. Of"
    " several values, the value with the largest error is shown. Errors are relative unless stated"
    " otherwise."
)


@dataclass(frozen=True, kw_only=True)
class Verification:
    """Outcomes of cases, in the order of the table."""

    outcomes: tuple[Outcome, ...]

    @property
    def passed(self) -> bool:
        """True if all cases pass."""
        return all(outcome.passed for outcome in self.outcomes)

    @property
    def summary(self) -> str:
        """Sentence with the numbers of cases."""
        failed = [outcome.name for outcome in self.outcomes if not outcome.passed]
        count, seconds = len(self.outcomes), sum(each.seconds for each in self.outcomes)
        text = f"{count - len(failed)} of {count} cases pass, {seconds:.0f} s"
        return f"{text}; failed: {', '.join(failed)}" if failed else text

    def by_subject(self) -> dict[str, list[Outcome]]:
        """Return the outcomes by subject."""
        grouped: dict[str, list[Outcome]] = {}
        for outcome in self.outcomes:
            grouped.setdefault(outcome.subject, []).append(outcome)
        return grouped

    def to_json(self) -> str:
        """Return a JSON document; non-finite values are null."""
        rows = [asdict(outcome) | {"passed": outcome.passed} for outcome in self.outcomes]
        version = metadata.version("bladewhirl")
        return json_text({"version": version, "passed": self.passed, "cases": rows})

    def to_markdown(self) -> str:
        """Return a table for each subject; times are left out, so that only rounding errors differ
        between two runs."""
        parts = []
        for subject, outcomes in self.by_subject().items():
            rows = [HEAD, ["---"] * len(HEAD), *map(cells, outcomes)]
            lines = ["| " + " | ".join(c.replace("|", "\\|") for c in row) + " |" for row in rows]
            parts.append("\n".join([f"## {SUBJECTS[subject]}\n", *lines]))
        return "\n\n".join(parts) + "\n"

    def page(self) -> Page:
        """Return a report as an HTML page."""
        count = len(self.outcomes)
        good = sum(outcome.passed for outcome in self.outcomes)
        sections = [
            PageSection(
                name=subject,
                title=SUBJECTS[subject],
                blocks=[
                    PageTable(
                        name=f"{subject}-cases",
                        title="",
                        head=HEAD,
                        rows=[cells(outcome) for outcome in outcomes],
                    )
                ],
            )
            for subject, outcomes in self.by_subject().items()
        ]
        return Page(
            title="Verification",
            subject=f"bladewhirl {metadata.version('bladewhirl')}",
            verdict="All cases pass" if self.passed else f"{count - good} of {count} cases fail",
            tone="good" if self.passed else "bad",
            reason=WORDS,
            warnings=[f"failed: {o.name}" for o in self.outcomes if not o.passed],
            figures=[("cases", str(count), f"{good} pass")],
            sections=sections,
        )


def cells(outcome: Outcome) -> Sequence[str]:
    """Return the cells of a line of the table, see `HEAD`."""
    unit = "" if outcome.unit == "1" else f" [{outcome.unit}]"
    bound = {"relative": "", "of largest": " of the largest", "absolute": " absolute"}
    return (
        "pass" if outcome.passed else "FAIL",
        f"{outcome.quantity}{unit}",
        outcome.source,
        str(outcome.values),
        f"{outcome.reference:.6g}",
        f"{outcome.ours:.6g}",
        f"{outcome.error:.1e}",
        f"{outcome.tolerance:.2g}{bound[outcome.measure]}",
    )


def cases(subjects: Iterable[str] = (), *, full: bool = False) -> list[VerificationCase]:
    """Return the cases of some subjects; all cases if no subject is given.

    Raises:
        UserError: a subject does not exist.
    """
    expected = list(subjects) or list(SUBJECTS)
    for subject in expected:
        if subject not in SUBJECTS:
            raise UserError(f"{subject}: expected one of the subjects {', '.join(SUBJECTS)}")
    for subject in SUBJECTS:
        if subject in expected:
            import_module(f"bladewhirl.studies.verification.{subject}")
    order = list(rows())
    chosen = [case for case in CASES if case.subject in expected and (full or not case.long)]
    return sorted(chosen, key=lambda case: order.index(case.name.partition("[")[0]))


def verify(
    subjects: Iterable[str] = (),
    *,
    full: bool = False,
    progress: Callable[[int, int], object] | None = None,
) -> Verification:
    """Compute problems with known answers, and compare the results with these answers.

    Args:
        subjects: names such as "modes", "rings"; all subjects if empty.
        full: whether to include the cases that take long.
        progress: called with the numbers of finished cases and of all cases.

    Raises:
        UserError: a subject does not exist.
    """
    chosen, outcomes = cases(subjects, full=full), []
    for done, case in enumerate(chosen, 1):
        outcomes.append(case.run())
        if progress is not None:
            progress(done, len(chosen))
    return Verification(outcomes=tuple(outcomes))
