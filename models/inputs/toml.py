"""TOML text of single values; the standard library only reads TOML."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from decimal import Decimal


def toml_value(value: object) -> str:
    """A value in TOML; floats at full precision, tables inline.

    Raises:
        TypeError: TOML has no such value, or it has and a case has not.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # TOML wants DEL escaped, JSON does not; else their basic strings agree.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return _float(value)
    if isinstance(value, Mapping):
        pairs = (f"{toml_key(key)} = {toml_value(item)}" for key, item in value.items())
        return f"{{ {', '.join(pairs)} }}" if value else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    raise TypeError(f"no TOML for {type(value).__name__}")


def toml_key(name: object) -> str:
    """A key, quoted where TOML needs it."""
    text = str(name)
    return text if re.fullmatch(r"[A-Za-z0-9_-]+", text) else toml_value(text)


def _float(value: float) -> str:
    text = repr(float(value))
    if not math.isfinite(value) or value == 0.0 or 1e-3 <= abs(value) < 1e5:
        return text
    mantissa, _, exponent = f"{Decimal(text).normalize():e}".partition("e")
    return f"{mantissa}e{int(exponent)}"
