"""Pages of a checkout: what can be read there, and conventions that readers look for."""

import pytest
from places import ROOT


@pytest.mark.parametrize(
    ("page", "words"),
    [
        ("README.md", "`bladewhirl new` explains keys, `--help` commands"),
        ("docs/model.md", "bladewhirl COMMAND --help"),
        ("docs/model.md", "--install-completion"),
        ("docs/model.md", "3D blades"),
        ("docs/model.md", "for Ω < 0 it is opposite to the rotation"),
        ("docs/model.md", "negative clearance where no contact node is"),
        ("docs/model.md", "At speed 0 these axes do not turn"),
        ("docs/tutorials/sensors.md", "positive towards +θ, also at negative speed"),
        ("docs/tutorials/sweep.md", 'it needs no `if __name__ == "__main__":`'),
        ("models/case/analysis.py", "the number per sector"),
    ],
)
def test_a_page_states_what_readers_look_for(page: str, words: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    assert words in " ".join(text.split())
