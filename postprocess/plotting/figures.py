"""Figures of a run or of a sweep by name."""

from collections.abc import Mapping
from pkgutil import resolve_name

import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.plotting.registry import FigureKind

POSTPROCESS = "bladewhirl.postprocess"


class Figures:
    """Figures of a dataset by name.

    Args:
        kinds: the figures that the dataset has.
        source: arguments of the functions of the registry that compute the data of a figure.
    """

    def __init__(self, kinds: Mapping[str, FigureKind], *source: object) -> None:
        self.kinds = kinds
        self.names = [*kinds]
        self._source = source

    def draw(self, name: str) -> tuple[Figure, xr.Dataset]:
        """Draw a figure; return the figure and its dataset.

        Raises:
            ViewError: there is no figure of this name, or its dataset cannot be computed, such as
                an orbit of a stage at rest.
        """
        if name not in self.kinds:
            raise ViewError(f"figure {name!r}: expected one of {', '.join(self.kinds)}")
        kind = self.kinds[name]
        if ":" in kind.data:
            source = [getattr(self, argument) for argument in kind.arguments] or self._source
            data = resolve_name(f"{POSTPROCESS}.{kind.data}")(*source, **kind.options)
        else:
            data = getattr(self, kind.data)
            data = data(**kind.options) if callable(data) else data
        return resolve_name(f"{POSTPROCESS}.{kind.plot}")(data), data
