"""Reference values as data; each file states how its numbers were made."""

from __future__ import annotations

import json
from functools import cache
from importlib import resources
from typing import Any

FOLDER = resources.files("bladewhirl.studies.verification") / "data"


@cache
def reference(name: str) -> Any:
    """Contents of a file of references, without its suffix."""
    return json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
