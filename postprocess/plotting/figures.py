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
        kinds: figures of the registry.
        dataset: a run or a sweep; it has the figures whose needed variables it has.
        source: further arguments of the functions of the registry that compute the data of a
            figure, after the dataset.
    """

    def __init__(
        self, kinds: Mapping[str, FigureKind], dataset: xr.Dataset, *source: object
    ) -> None:
        known = {name for name, values in dataset.variables.items() if values.size}
        self._missing = {
            name: [each for each in kind.needs if not {*each.split(" or ")} & known]
            for name, kind in kinds.items()
        }
        #: figures that the dataset has
        self.kinds = {name: kind for name, kind in kinds.items() if not self._missing[name]}
        self.names = [*self.kinds]
        self._source = (dataset, *source)

    def draw(self, name: str) -> tuple[Figure, xr.Dataset]:
        """Draw a figure; return the figure and its dataset.

        Raises:
            ViewError: the dataset has no figure of this name, or its data cannot be computed, such
                as an orbit of a stage at rest.
        """
        if name not in self.kinds:
            lacks = ", ".join(self._missing.get(name, ()))
            expected = f"a result with {lacks}" if lacks else f"one of {', '.join(self.kinds)}"
            raise ViewError(f"figure {name!r}: expected {expected}")
        kind = self.kinds[name]
        if ":" in kind.data:
            source = [getattr(self, argument) for argument in kind.arguments] or self._source
            data = resolve_name(f"{POSTPROCESS}.{kind.data}")(*source, **kind.options)
        else:
            data = getattr(self, kind.data)
            data = data(**kind.options) if callable(data) else data
        return resolve_name(f"{POSTPROCESS}.{kind.plot}")(data), data
