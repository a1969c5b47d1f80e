"""The paper's cases give the numbers that they gave: see `support/golden.py`."""

import json

import pytest
from golden import FILE, GOLDEN, numbers


@pytest.mark.parametrize("name", GOLDEN)
def test_short_marches_give_what_they_gave(name: str) -> None:
    expected = json.loads(FILE.read_text())[name]
    assert numbers(GOLDEN[name]) == pytest.approx(expected, rel=1e-6, abs=1e-12)
