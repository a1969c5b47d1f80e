"""The stage of a run with its panel, drawn without a display, as pixels."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import xarray as xr

from bladewhirl.postprocess.fields.fields import IntArray
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.pictures.off_screen import Pixels, off_screen_plotter, pixels_of


@contextmanager
def stage_view(
    dataset: xr.Dataset,
    drawing: Drawing,
    size: tuple[int, int],
    note: str = "",
    *,
    trail: IntArray | None = None,
) -> Iterator[Callable[[int | None], Pixels]]:
    """An off-screen stage: a function that gives the pixels of the index-th record, or, for None,
    of the one before with the times of all records written instead of its own.
    """
    with off_screen_plotter(size) as plotter:
        from bladewhirl.postprocess.pictures.panel import Panel
        from bladewhirl.postprocess.pictures.scene import StageScene

        scene = StageScene(plotter, drawing)
        panel = Panel(scene, dataset, note=note, trail=trail)
        scene.look()

        def picture(index: int | None) -> Pixels:
            if index is None:
                panel.show_span(float(drawing.times[0]), float(drawing.times[-1]))
            else:
                seen = drawing.picture(index)
                scene.show(seen)
                panel.show(seen)
            return pixels_of(plotter)

        yield picture
