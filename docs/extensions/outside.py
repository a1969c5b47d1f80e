"""Shorten types in signatures, and link them to pages of other libraries without downloads."""

import re

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment

XARRAY = "https://docs.xarray.dev/en/stable/generated/xarray."
NUMPY = "https://numpy.org/doc/stable/reference/"
PYTHON = "https://docs.python.org/3/library/"

PAGES = {
    "Dataset": f"{XARRAY}Dataset.html",
    "DataArray": f"{XARRAY}DataArray.html",
    "ndarray": f"{NUMPY}generated/numpy.ndarray.html",
    "NDArray": f"{NUMPY}typing.html#numpy.typing.NDArray",
    "ArrayLike": f"{NUMPY}typing.html#numpy.typing.ArrayLike",
    "Figure": "https://matplotlib.org/stable/api/figure_api.html#matplotlib.figure.Figure",
    "Path": f"{PYTHON}pathlib.html#pathlib.Path",
    "Mapping": f"{PYTHON}collections.abc.html#collections.abc.Mapping",
    "Sequence": f"{PYTHON}collections.abc.html#collections.abc.Sequence",
    "Callable": f"{PYTHON}collections.abc.html#collections.abc.Callable",
    "Exception": f"{PYTHON}exceptions.html#Exception",
}
"""Addresses of the pages of types, by the last part of the full name."""

ARRAY_LIKE = re.compile(r"\S*_?Buffer \|.*_NestedSequence\[[^\[\]]*\]")
"""Pattern of the union of types for which `numpy.typing.ArrayLike` stands."""


def link(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, inside: nodes.Element
) -> nodes.reference | None:
    """Return a link to the page of a type of another library; None for other references."""
    page = PAGES.get(node.get("reftarget", "").rpartition(".")[2])
    if node.get("refdomain") != "py" or page is None:
        return None
    return nodes.reference("", "", inside, refuri=page, internal=False)


def plain(app: Sphinx, *_: object) -> None:
    """Shorten parameter types: omit `Annotated` metadata, write "array-like" for NumPy's union."""
    for types in app.env.current_document.autodoc_annotations.values():
        for name, hint in types.items():
            short = re.sub(r"Annotated\[((?:[^\[\],]|\[[^\]]*\])*),.*\]", r"\1", hint)
            types[name] = ARRAY_LIKE.sub("array-like", short)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register `link`, for references that Sphinx does not resolve, and `plain`."""
    app.connect("missing-reference", link)
    app.connect("object-description-transform", plain, priority=400)  # before types are listed
    return {"parallel_read_safe": True, "parallel_write_safe": True}
