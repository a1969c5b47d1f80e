"""Fixtures that several test modules share."""

import pytest

from bladewhirl.postprocess.off_screen import OffScreenError, require_off_screen


@pytest.fixture
def can_draw() -> None:
    """Skips where the system has no OpenGL for VTK to draw with."""
    try:
        require_off_screen()
    except OffScreenError as error:
        pytest.skip(str(error))
