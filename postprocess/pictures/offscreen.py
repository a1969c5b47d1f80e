"""Pictures of a stage as pixels, drawn without a display.

Before VTK draws, the required libraries are checked, because VTK crashes if a library is missing.
"""

from __future__ import annotations

import ctypes
import functools
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from PIL import Image

from bladewhirl.models.inputs.errors import UserError
from bladewhirl.postprocess.fields.kinematics import IntArray
from bladewhirl.postprocess.pictures.appearance import FINER
from bladewhirl.postprocess.pictures.drawing import Drawing

if TYPE_CHECKING:
    import pyvista

Pixels = NDArray[np.uint8]  #: (height, width, 3)

PACKAGES = "libegl1 libegl-mesa0 libgl1-mesa-dri libx11-6"
_CHOICE, _EGL = "VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow"
_PLATFORM_DEVICE = 0x313F  # EGL_PLATFORM_DEVICE_EXT
_MOST_DEVICES = 16


class OffScreenError(UserError):
    """A library for drawing without a display is missing; the message names packages to install."""


@functools.cache
def require_off_screen() -> None:
    """Make VTK draw off-screen through EGL, or raise OffScreenError.

    On Linux VTK loads OpenGL when the first window opens, and ends with a segmentation fault if
    libEGL or a driver is missing. This function tries to load both first. Nothing is checked on
    other systems, which contain OpenGL, or if the user has set VTK_DEFAULT_OPENGL_WINDOW to another
    window than EGL.
    """
    if not sys.platform.startswith("linux") or os.environ.get(_CHOICE, _EGL) != _EGL:
        return
    try:
        egl = ctypes.CDLL("libEGL.so.1")
    except OSError as error:
        raise _missing("libEGL.so.1") from error
    if not _has_driver(egl):
        raise _missing("an OpenGL driver for libEGL.so.1")
    # Otherwise VTK tries an X display first, which gives a warning if there is no display, and a
    # crash if libX11 is missing as well.
    os.environ[_CHOICE] = _EGL


@contextmanager
def off_screen_plotter(size: tuple[int, int]) -> Iterator[pyvista.Plotter]:
    """Yield a white plotter without a display, for pictures of the given size [pixels].

    The plotter is `FINER` times as wide and as high as the pictures, and `pixels_of` reduces its
    picture. This smooths edges in two thirds of the time that multi-sampling takes. pyvista is
    imported after the check of the libraries.

    Raises:
        OffScreenError: the system cannot draw without a display.
    """
    require_off_screen()
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=[FINER * length for length in size])
    try:
        plotter.set_background("white")
        plotter.disable_anti_aliasing()
        plotter.suppress_rendering = True  # every change would draw, and each picture is drawn once
        yield plotter
    finally:
        plotter.close()


def pixels_of(plotter: pyvista.Plotter) -> Pixels:
    """Return the picture in a plotter from `off_screen_plotter`, reduced to its final size."""
    plotter.suppress_rendering = False
    plotter.render()
    pixels = plotter.screenshot(return_img=True)
    plotter.suppress_rendering = True
    return np.array(Image.fromarray(pixels).reduce(FINER))


def tiled(pictures: Sequence[Pixels], columns: int | None = None) -> Pixels:
    """Return a sheet of pictures of one size, row by row; it is about square if `columns` is
    None."""
    wide = columns or int(np.ceil(np.sqrt(len(pictures))))
    height, width, _ = pictures[0].shape
    sheet = np.full((-(-len(pictures) // wide) * height, wide * width, 3), 255, dtype=np.uint8)
    for index, picture in enumerate(pictures):
        row, column = divmod(index, wide)
        place = slice(row * height, (row + 1) * height), slice(column * width, (column + 1) * width)
        sheet[place] = picture
    return sheet


@contextmanager
def stage_view(
    dataset: xr.Dataset,
    drawing: Drawing,
    size: tuple[int, int],
    note: str = "",
    *,
    trail: IntArray | None = None,
    sheet: bool = False,
) -> Iterator[Callable[[int | None], Pixels]]:
    """Yield a function of an index, which returns the picture of the stage at the index-th record.

    For the index None the function returns the previous picture again, with a panel that describes
    all records. See `Panel` for `note`, `trail` and `sheet`.
    """
    with off_screen_plotter(size) as plotter:
        from bladewhirl.postprocess.pictures.panel import Panel
        from bladewhirl.postprocess.pictures.scene import StageScene

        scene = StageScene(plotter, drawing)
        panel = Panel(scene, dataset, note=note, trail=trail, sheet=sheet)
        scene.aim()

        def picture(index: int | None) -> Pixels:
            if index is None:
                panel.show_all()
            else:
                seen = drawing.picture(index)
                scene.show(seen)
                panel.show(seen)
            return pixels_of(plotter)

        yield picture


def _missing(library: str) -> OffScreenError:
    return OffScreenError(
        f"drawing without a display needs {library}, which was not found; "
        f"on Debian or Ubuntu: apt-get install {PACKAGES}"
    )


def _has_driver(egl: ctypes.CDLL) -> bool:
    """Return true if EGL can be initialised on a graphics card or by a software driver.

    Displays are left open: closing them would also close the displays of VTK in this process.
    """
    pointer, integer = ctypes.c_void_p, ctypes.c_int
    egl.eglGetProcAddress.restype = pointer
    query_address = egl.eglGetProcAddress(b"eglQueryDevicesEXT")
    display_address = egl.eglGetProcAddress(b"eglGetPlatformDisplayEXT")
    if not (query_address and display_address):
        return False
    query = ctypes.CFUNCTYPE(
        ctypes.c_uint, integer, ctypes.POINTER(pointer), ctypes.POINTER(integer)
    )(query_address)
    open_display = ctypes.CFUNCTYPE(pointer, ctypes.c_uint, pointer, pointer)(display_address)
    egl.eglInitialize.argtypes = [pointer, pointer, pointer]
    devices, count = (pointer * _MOST_DEVICES)(), integer(0)
    if not query(_MOST_DEVICES, devices, ctypes.byref(count)):
        return False
    displays = (open_display(_PLATFORM_DEVICE, device, None) for device in devices[: count.value])
    return any(display and egl.eglInitialize(display, None, None) for display in displays)
