"""Stills for print: size, letters, and the forces and the scale that they state."""

from pathlib import Path

import numpy as np
import pytest
from legible import assert_legible
from long_cases import slow_except
from matplotlib.image import imread
from three_runs import KINDS, Kind, run_of

import bladewhirl as bw
from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.fields.by_blade import of_blades
from bladewhirl.postprocess.fields.kinematics import contact_forces
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.pictures.printed import printed
from bladewhirl.postprocess.pictures.render import strongest_contact
from bladewhirl.postprocess.plotting.style import COLUMN_WIDTH, FULL_WIDTH

pytestmark = pytest.mark.pictures


@pytest.mark.parametrize("kind", slow_except(KINDS, "blade"))
def test_letters_lie_apart_and_the_title_has_the_largest_force(kind: Kind) -> None:
    run = run_of(kind)
    record = np.array([strongest_contact(run)])
    figure = printed(run, Drawing(run, record, colour="stress"), COLUMN_WIDTH)
    assert_legible(figure, least=7.0)
    forces = of_blades(run, contact_forces(run, record)[0].T)
    largest = float(np.linalg.norm(forces, axis=0).max())
    assert handy(largest, "N", 3) in figure.get_suptitle().replace("\n", " ")


def test_a_still_has_the_width_of_the_page(tmp_path: Path) -> None:
    path = bw.render(run_of("beams"), tmp_path / "still.png", width=FULL_WIDTH)
    assert imread(path).shape[1] == 2007  # 170 mm at 300 dots an inch
    with pytest.raises(ValueError, match="omit width"):
        bw.render(run_of("beams"), tmp_path / "film.gif", width=FULL_WIDTH)
