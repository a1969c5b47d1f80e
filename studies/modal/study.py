"""A modal study as its command prints and draws it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bladewhirl.models.inputs import progress

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure
    from rich.table import Table

Figures = Mapping[str, tuple["Figure", "xr.Dataset"]]
"""Figures and their data, by file name without suffix."""


@dataclass(frozen=True, kw_only=True)
class Study:
    """Results of a modal study. The modules that draw take long to load and are loaded to draw."""

    name: str  #: name of the command
    document: dict[str, Any]  #: JSON document
    tables: "Sequence[Table | str]"  #: printed without --json
    figures: Callable[[], Figures] | None = None  #: draws the figures
    hints: str = ""  #: warnings about the results, separated by semicolons
    page: Path | None = None  #: page that is already written

    def draw(self, folder: Path, *, overwrite: bool = False) -> None:
        """Draw the figures, if any, into a folder, and save their data.

        Raises:
            UserError: a file cannot be written, or exists and was not written by bladewhirl.
        """
        if self.figures is not None:
            from bladewhirl.studies.runs.figures_folder import save_figures

            progress.report("drawing figures")
            save_figures(folder, self.figures(), overwrite=overwrite)
