"""Sphinx configuration of the documentation; `sphinx-build -W -b html docs build/docs`."""

import logging
import sys
from importlib import metadata
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

for library in ("fontTools", "matplotlib", "skfem"):
    logging.getLogger(library).setLevel(logging.WARNING)

project = "bladewhirl"
author = "The authors of bladewhirl"
project_copyright = "2026, the authors of bladewhirl"
version = release = metadata.version("bladewhirl")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",
    "sphinx_design",
    "outside",
    "executed",
]
exclude_patterns = ["built", "extensions", "static"]

myst_enable_extensions = ["attrs_block", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

default_role = "py:obj"  # docstrings put names into single backticks
autodoc_typehints = "description"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
napoleon_use_rtype = False

html_theme = "furo"
html_title = "bladewhirl"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}
html_show_search_summary = False  # fetched page by page, which browsers refuse of file://
