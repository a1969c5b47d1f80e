"""Content of the page of a film."""

import base64
import json
import re
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bladewhirl.postprocess.pictures.web_page import FULL


def page(path: Path) -> tuple[dict[str, Any], NDArray[np.int16], NDArray[np.uint8]]:
    """What the page of a film knows, its places and its shades, (record, number) each."""
    text = path.read_text(encoding="utf-8")
    about = json.loads(re.search(r"^const about = (.*);$", text, re.MULTILINE)[1])  # type: ignore[index]
    packed = {
        name: zlib.decompress(base64.b64decode(re.search(rf'{name}: "([^"]*)"', text)[1]))  # type: ignore[index]
        for name in ("places", "shades")
    }
    count = len(about["times"])
    return (
        about,
        np.frombuffer(packed["places"], dtype="<i2").reshape(count, -1),
        np.frombuffer(packed["shades"], dtype=np.uint8).reshape(count, -1),
    )


def part(about: dict[str, Any], places: NDArray[np.int16], name: str) -> NDArray[np.float64]:
    """One kind of thing at all records, as the page finds it."""
    first, *shape = about["layout"][name]
    return np.asarray(places[:, first : first + int(np.prod(shape))].reshape(-1, *shape) / FULL)
