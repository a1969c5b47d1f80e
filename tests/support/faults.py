"""What a user would be told of a case that is refused."""

from collections.abc import Callable
from typing import Any

import pytest

from bladewhirl.models.inputs.errors import UserError


def faults(call: Callable[..., object], *given: Any, **more: Any) -> list[str]:
    """Lines of the error that a call ends in."""
    with pytest.raises(UserError) as caught:
        call(*given, **more)
    return caught.value.lines


def fault(call: Callable[..., object], *given: Any, **more: Any) -> str:
    """Its one line."""
    [line] = faults(call, *given, **more)
    return line
