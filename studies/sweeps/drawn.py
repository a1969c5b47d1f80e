"""Cases of single random draws of a sweep, to march them again."""

from pathlib import Path

import numpy as np

from bladewhirl.files import write_atomically
from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import with_values
from bladewhirl.models.inputs.errors import UserError, writing
from bladewhirl.solvers.march.schema import DRAW
from bladewhirl.studies.runs import folder
from bladewhirl.studies.sweeps.axes import Grid
from bladewhirl.studies.sweeps.plan import read_plan, require_new


def drawn_case(directory: str | Path, draw: int, **at: float) -> Case:
    """Return the case that a random draw of a sweep marched, to march it again on its own::

        case = bladewhirl.drawn_case("sweep", 7, march_speed=1.05)

    Args:
        directory: folder of the sweep.
        draw: number of the draw, from 0.
        at: value of each swept key, named and given as the coordinate in `open_sweep`; `point` for
            the sweep of a table.

    Raises:
        UserError: the folder contains no sweep with draws, or the sweep has no such point.
    """
    plan = read_plan(Path(directory))
    numbers = draw_points(plan.grid, draw)
    for axis in (axis for axis in plan.grid.axes if axis.key != DRAW):
        values = plan.coordinates[axis.key][0]
        place = np.flatnonzero(np.isclose(values, at.pop(axis.name, np.nan), rtol=1e-9, atol=0.0))
        if not place.size:
            raise UserError(f"drawn_case: expected {axis.name} of a point of the sweep")
        numbers = numbers.take(place[:1], axis=plan.grid.axes.index(axis))
    if at:
        raise UserError(f"drawn_case: expected only swept keys, not {', '.join(at)}")
    return with_values(plan.case, plan.grid.values(numbers.item()))


def draw_points(grid: Grid, draw: int) -> IntArray:
    """Return the numbers of all points with a random draw, over the other axes of the grid.

    Raises:
        UserError: the sweep has no such draw.
    """
    count = 0 if grid.draws is None else grid.draws.count
    if not 0 <= draw < count:
        expected = f"0 to {count - 1}" if count else "a sweep with --draws"
        raise UserError(f"--draw {draw}: expected {expected}")
    return np.arange(grid.size).reshape(grid.shape)[..., draw]


def write_drawn_cases(case: Case, grid: Grid, draw: int, directory: Path) -> list[str]:
    """Write the case of a random draw at each point into a new folder; return a text for each
    file: its name and the values of its keys.

    Raises:
        UserError: the sweep has no such draw, or the folder exists or cannot be written.
    """
    written = []
    points = draw_points(grid, draw).ravel()
    require_new(directory)
    with writing(directory):
        directory.mkdir(parents=True, exist_ok=True)
        for point, number in enumerate(points.tolist()):
            files = folder.case_files(with_values(case, grid.values(number)))
            name = f"point_{point}_draw_{draw}.toml"
            write_atomically(directory / name, files.pop(folder.CASE_NAME))
            for copy, content in files.items():
                write_atomically(directory / copy, content)
            written.append(f"{name}: {grid.label(number)}")
    return written
