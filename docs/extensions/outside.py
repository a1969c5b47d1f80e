"""Types in signatures: short, linked to other libraries without fetching their inventories."""

from __future__ import annotations

import re

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment

PAGES = {
    "xr.Dataset": "https://docs.xarray.dev/en/stable/generated/xarray.Dataset.html",
    "xr.DataArray": "https://docs.xarray.dev/en/stable/generated/xarray.DataArray.html",
    "Dataset": "https://docs.xarray.dev/en/stable/generated/xarray.Dataset.html",
    "DataArray": "https://docs.xarray.dev/en/stable/generated/xarray.DataArray.html",
    "ndarray": "https://numpy.org/doc/stable/reference/generated/numpy.ndarray.html",
    "NDArray": "https://numpy.org/doc/stable/reference/typing.html#numpy.typing.NDArray",
    "ArrayLike": "https://numpy.org/doc/stable/reference/typing.html#numpy.typing.ArrayLike",
    "Figure": "https://matplotlib.org/stable/api/figure_api.html#matplotlib.figure.Figure",
    "Path": "https://docs.python.org/3/library/pathlib.html#pathlib.Path",
    "Mapping": "https://docs.python.org/3/library/collections.abc.html#collections.abc.Mapping",
    "Sequence": "https://docs.python.org/3/library/collections.abc.html#collections.abc.Sequence",
    "Callable": "https://docs.python.org/3/library/collections.abc.html#collections.abc.Callable",
    "Exception": "https://docs.python.org/3/library/exceptions.html#Exception",
}
"""Pages of names, by the end of the full name."""

ARRAY_LIKE = re.compile(r"\S*_?Buffer \|.*_NestedSequence\[[^\[\]]*\]")
"""`numpy.typing.ArrayLike`, as it is written out."""

LONGEST = 300
"""Characters of a class's signature that is left as it is."""


def link(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, inside: nodes.Element
) -> nodes.reference | None:
    """A link to the page of a name that is not ours."""
    target = node.get("reftarget", "")
    page = PAGES.get(target) or PAGES.get(target.rpartition(".")[2])
    if node.get("refdomain") != "py" or page is None:
        return None
    return nodes.reference("", "", inside, refuri=page, internal=False)


def plain(app: Sphinx, *_: object) -> None:
    """Simplify parameter types to what Python checks, with "array-like" for NumPy's."""
    for types in app.env.current_document.autodoc_annotations.values():
        for name, hint in types.items():
            short = re.sub(r"Annotated\[((?:[^\[\],]|\[[^\]]*\])*),.*\]", r"\1", hint)
            types[name] = ARRAY_LIKE.sub("array-like", short)


def brief(
    app: Sphinx,
    kind: str,
    name: str,
    item: object,
    options: object,
    arguments: str | None,
    out: str,
) -> tuple[str, str] | None:
    """Return a long signature without defaults that are objects."""
    if kind != "class" or arguments is None or len(arguments) < LONGEST:
        return None
    return re.sub(r"=[A-Z]\w*\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\)", "=…", arguments), out


def setup(app: Sphinx) -> dict[str, bool]:
    """Resolve references that Sphinx does not find; keep types short."""
    app.connect("missing-reference", link)
    app.connect("autodoc-process-signature", brief)
    app.connect("object-description-transform", plain, priority=400)  # before types are listed
    return {"parallel_read_safe": True, "parallel_write_safe": True}
