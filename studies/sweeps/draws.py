"""Random draws of a sweep: each point is marched several times with slightly different values.

Contact near a threshold between regimes is chaotic: a change of 1e-7 in a load can change the
regime. Only several marches with randomly changed values, the draws, show how likely a regime is.
Each draw of a point has its own random stream (Philox, with point and draw as the counter), so that
the values depend neither on the number of workers nor on the order of the points.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bladewhirl.models.inputs.errors import UserError

PERTURB, UNTIL = "--perturb", "--until"

MOST_DRAWS = 10_000  #: largest number of random draws of a point

_FORM = re.compile(
    r"\s*([\w.]+)\s*=\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"((?:\s+(?:relative|absolute|normal|uniform))*)\s*"
)


@dataclass(frozen=True, kw_only=True)
class Perturbation:
    """Random change of a key of the case."""

    text: str  #: as the user wrote it, "excitation.amplitude = 1e-6"
    key: str  #: dotted key, as in the case file
    size: float  #: standard deviation, or half of the width of a uniform distribution
    relative: bool  #: true if the size is a fraction of the value, false if in the SI unit
    uniform: bool  #: true for a uniform distribution, false for a normal distribution

    def value(self, nominal: float, stream: np.random.Generator) -> float:
        """Return the changed value of a key."""
        number = stream.uniform(-1.0, 1.0) if self.uniform else stream.standard_normal()
        return float(nominal + self.size * number * (nominal if self.relative else 1.0))


@dataclass(frozen=True, kw_only=True)
class Draws:
    """Random draws of each point of a sweep."""

    count: int  #: number of draws of each point
    seed: int
    perturbations: tuple[Perturbation, ...]
    #: a point gets no more draws once its confidence intervals are narrower than this; None for all
    #: draws
    until: float | None = None

    def stream(self, point: int, draw: int) -> np.random.Generator:
        """Return the random stream of a draw of a point."""
        counter = [0, 0, point, draw]
        return np.random.Generator(np.random.Philox(key=self.seed, counter=counter))


def parse_draws(
    count: int | None, perturb: Sequence[str], seed: int, until: float | None = None
) -> Draws | None:
    """Return the random draws from the options --draws, --perturb, --seed and --until; None if the
    sweep has none.

    Args:
        count: number of draws of each point.
        perturb: texts "KEY = SIZE", followed by the words relative (default) or absolute, and
            normal (default) or uniform. SIZE is a share of the value, or, if absolute, in the SI
            unit of the key.
        seed: seed of the random streams.
        until: width of confidence intervals, below 1; a point gets no more draws once the intervals
            of the shares of all regimes are narrower, or exclude one half.

    Raises:
        UserError: only one of count and perturb is given, until without count, or an option is not
            valid.
    """
    if until is not None and not 0.0 < until < 1.0:
        raise UserError(
            f"{UNTIL} {until}: expected the width of a confidence interval, between 0 and 1"
        )
    if until is not None and count is None:
        raise UserError(f"{UNTIL} {until}: needs --draws")
    if count is None and not perturb:
        return None
    if count is None:
        raise UserError(f"{PERTURB}: needs --draws, the number of random draws")
    if not perturb:
        raise UserError(f"--draws {count}: needs {PERTURB}, the random changes")
    if not 2 <= count <= MOST_DRAWS:
        raise UserError(f"--draws {count}: expected 2 to {MOST_DRAWS} random draws")
    if seed < 0:
        raise UserError(f"--seed {seed}: expected zero or more")
    perturbations = []
    for text in perturb:
        match = _FORM.fullmatch(text)
        words = match[3].split() if match else []
        twice = {"relative", "absolute"} <= set(words) or {"normal", "uniform"} <= set(words)
        if match is None or not 0.0 < float(match[2]) < np.inf or twice:
            raise UserError(
                f'{PERTURB} "{text}": expected "KEY = SIZE" with a size above zero, which may be'
                " followed by the words absolute and uniform"
            )
        perturbations.append(
            Perturbation(
                text=text,
                key=match[1],
                size=float(match[2]),
                relative="absolute" not in words,
                uniform="uniform" in words,
            )
        )
    keys = [perturbation.key for perturbation in perturbations]
    if len(set(keys)) < len(keys):
        raise UserError(f"{PERTURB}: expected each key at most once")
    return Draws(count=count, seed=seed, perturbations=tuple(perturbations), until=until)
