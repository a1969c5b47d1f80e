"""Formulas as MathML, which browsers draw themselves: no script and no font from a network."""

from __future__ import annotations

import html
import re
import xml.etree.ElementTree as ET
from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx

_MATHML = "{http://www.w3.org/1998/Math/MathML}"
_DOTS = ("˙", "¨")
_ENTITY = re.compile(r"&(?!lt;|gt;|amp;|quot;)\w+;")
"""Of HTML, such as a space; XML does not have it."""

ET.register_namespace("", _MATHML[1:-1])


def formula(tex: str, *, block: bool) -> str:
    """Return the MathML of a formula; the index of a dotted symbol is beside it, not below."""
    text = _ENTITY.sub(lambda match: html.unescape(match[0]), tex2mathml(tex, as_block=block))
    root = ET.fromstring(text)
    for symbol in list(root.iter(f"{_MATHML}munderover")):
        base, index, accent = symbol
        if accent.text in _DOTS:
            symbol.tag = f"{_MATHML}msub"
            dotted = ET.Element(f"{_MATHML}mover", accent="true")
            dotted.extend([base, accent])
            symbol[:] = [dotted, index]
    return ET.tostring(root, encoding="unicode")


def visit_math(translator: Any, node: nodes.math) -> None:
    """A formula in a line of text."""
    translator.body.append(formula(node.astext(), block=False))
    raise nodes.SkipNode


def visit_math_block(translator: Any, node: nodes.math_block) -> None:
    """Return a displayed formula."""
    translator.body.append(f'<div class="math">{formula(node.astext(), block=True)}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer as "mathml"."""
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_math_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
