"""Notebooks to download: one for each executed page with Python, without outputs.

The text of the page and its blocks become cells. In the cells commands begin with "!", and a block
that is written to a file begins with "%%writefile".
"""

import json
from pathlib import Path
from typing import Any

import blocks

MARK = "<!--"
FORMAT = {"nbformat": 4, "nbformat_minor": 5}
LANGUAGE = {"language_info": {"name": "python"}}
EXAMPLES = "Run this notebook in a folder that contains the folder `examples` of bladewhirl.\n\n"


def write(page: str, text: str, folder: Path) -> str:
    """Write the notebook of a page into a folder; return the line that links to it.

    Args:
        page: name of the page, such as "tutorials/modes".
        text: text of the page without generated parts.
        folder: folder of the notebooks.
    """
    cells, last = [], text.index("\n# ")
    for number, block in enumerate(block for block in blocks.blocks(text) if block.runs):
        cells += [_cell("markdown", _prose(text[last : block.start]), 2 * number)]
        cells += [_cell("code", _source(block), 2 * number + 1)]
        last = block.end
    cells.append(_cell("markdown", _prose(text[last:]), len(cells)))
    cells[0]["source"] += "\n\n" + EXAMPLES
    notebook = {"cells": cells, "metadata": LANGUAGE, **FORMAT}
    file = folder / f"{page.replace('/', '-')}.ipynb"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(notebook, indent=1, ensure_ascii=False), encoding="utf-8")
    up = "../" * page.count("/")
    return f"\n\n{{download}}`This page as a notebook <{up}built/notebooks/{file.name}>`\n"


def _prose(text: str) -> str:
    """Return text without the marks of generated parts."""
    lines = [line for line in text.splitlines() if not line.startswith(MARK)]
    return "\n".join(lines).strip()


def _source(block: blocks.Block) -> str:
    """Return the code of a block for a cell of a notebook."""
    if block.mark == "file":
        return f"%%writefile {block.argument}\n{block.code}"
    if block.language == "console":
        return "\n".join(f"!{line}" for line in blocks.commands(block.code))
    return block.code.rstrip()


def _cell(kind: str, source: str, number: int) -> dict[str, Any]:
    extra = {"execution_count": None, "outputs": []} if kind == "code" else {}
    return {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": source} | extra
