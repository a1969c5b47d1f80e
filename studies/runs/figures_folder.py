"""Folders of figures and their data."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.files import claim
from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.models.inputs.progress import tracked
from bladewhirl.postprocess.plotting.style import FORMATS, save_figure


def check_figure_folder(folder: Path | None, *, overwrite: bool) -> None:
    """Check that figures may be written into a folder; the folder is not made.

    Raises:
        UserError: the folder exists and must not be written into, or is a file.
    """
    if folder is None or not folder.exists():
        return
    if not folder.is_dir():
        raise UserError(f"{folder}: expected a folder, found a file")
    if not overwrite:
        raise UserError(f"{folder}: already exists; --overwrite writes into it")


def save_figures(
    folder: Path,
    figures: Mapping[str, tuple[Figure, xr.Dataset]],
    *,
    overwrite: bool = False,
    formats: Sequence[str] = FORMATS,
) -> None:
    """Save figures and their data into a folder, and list the files in the manifest of the folder.

    The keys of `figures` are file names without suffix. With `overwrite`, existing files that
    bladewhirl did not write are replaced.

    Raises:
        UserError: a file cannot be written, or exists and was not written by bladewhirl.
    """
    with writing(folder):
        files = [f"{name}.{suffix}" for name in figures for suffix in (*formats, "nc")]
        claim(folder, files, overwrite=overwrite)
        for name, (figure, data) in tracked("saving figures", figures.items()):
            save_figure(figure, folder / name, data, formats)
