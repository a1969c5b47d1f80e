"""Parameters of which most are long tests."""

from collections.abc import Iterable
from typing import Any

import pytest


def slow_except(values: Iterable[Any], *quick: Any) -> list[Any]:
    """Return the values of a parameter, or the tuples of several, all marked slow but some."""
    values = list(values)
    assert all(value in values for value in quick), quick
    return [
        value
        if value in quick
        else pytest.param(
            *(value if isinstance(value, tuple) else (value,)), marks=pytest.mark.slow
        )
        for value in values
    ]
