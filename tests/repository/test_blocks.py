"""Blocks of pages: what a short run leaves of a command, and words that a page states."""

from pathlib import Path

import blocks
import pytest
from places import EXAMPLES

LONG = str(EXAMPLES / "imbalance.toml")  # marches longer than a short run


@pytest.mark.parametrize(
    ("given", "short"),
    [
        (f"run {LONG} --frames 20", f"run {LONG} --frames 2 --set march.duration=0.1"),
        (
            f"run {LONG} --set march.duration=0.02",
            f"run {LONG} --set march.duration=0.02 --frames 2",
        ),
        (
            f"sweep {LONG} --over march.speed=1:2:0.1 --over contact.friction=0,0.1,0.2",
            f"sweep {LONG} --over march.speed=1,2 --over contact.friction=0,0.2"
            " --set march.duration=0.1",
        ),
        (
            f"sweep {LONG} --set march.revolutions=20 -o map",
            f"sweep {LONG} --set march.revolutions=20 -o map --set march.revolutions=1",
        ),
        ("sweep --resume map", "sweep --resume map"),
        (
            "render rub --gif --frames 8 --from 0.5 --to 0.6 -o a",
            "render rub --gif --frames 2 -o a",
        ),
        ("periodic a.toml --over march.speed=1:2", "periodic a.toml --over march.speed=1:2"),
        ("response a.toml --draws 200 -o b", "response a.toml --draws 8 -o b"),
        ("periodic a.toml --from branch", "periodic a.toml --from branch"),
    ],
)
def test_a_short_run_marches_sweeps_and_films_little(given: str, short: str) -> None:
    assert blocks.shortened(given.split()) == short.split()


def test_words_that_no_block_prints_are_refused_at_full_length(tmp_path: Path) -> None:
    page = "```python\nprint('5  of', 22)\n```\n\n<!-- printed: 5 of 22 -->\n"
    assert blocks.run(page, tmp_path) == ["5  of 22\n"]
    other = page.replace("-- printed: 5", "-- printed: 6")
    assert blocks.run(other, tmp_path, short=True) == ["5  of 22\n"]
    with pytest.raises(RuntimeError, match="no block prints '6 of 22'"):
        blocks.run(other, tmp_path)


def test_a_short_run_leaves_long_blocks_out(tmp_path: Path) -> None:
    page = "<!-- long: many marches -->\n```python\nprint(1)\n```\n```python\nprint(2)\n```\n"
    assert blocks.run(page, tmp_path) == ["1\n", "2\n"]
    assert blocks.run(page, tmp_path, short=True) == ["", "2\n"]
