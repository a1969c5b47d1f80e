"""Structs of the header, made of arrays that its comments describe."""

import re
from importlib import resources
from typing import Any

import numpy as np
import pytest

from bladewhirl.solvers.kernel.structs import Struct, zeros


def ends(**changes: Any) -> Struct:
    arrays = {"place": np.zeros(3, int), "wave": np.zeros(3, int), "amplitude": np.zeros(3)}
    return Struct("SpringEnds", **(arrays | changes))


def test_arrays_are_attributes_and_c_points_to_them() -> None:
    struct = ends(amplitude=np.array([1.0, 2.0, 3.0]))
    assert struct.pointer.amplitude.size == 3
    struct.amplitude[1] = 5.0
    assert struct.pointer.amplitude.at[1] == 5.0


@pytest.mark.parametrize(
    "array", [np.zeros(4), np.zeros(6)[::2], np.zeros(3, np.float32), np.zeros((3, 1))]
)
def test_an_array_of_another_type_or_shape_is_refused(array: np.ndarray[Any, Any]) -> None:
    with pytest.raises(TypeError, match=r"SpringEnds.amplitude"):
        ends(amplitude=array)


def test_every_field_is_needed_and_no_other() -> None:
    with pytest.raises(TypeError, match="SpringEnds: expected the fields place, wave, amplitude"):
        Struct("SpringEnds", place=np.zeros(3, int))


def test_zeros_have_the_shapes_of_the_header() -> None:
    arrays = zeros("DamperEnds", {"dampers": 3, "entries": 8})
    shapes = {name: array.shape for name, array in arrays.items()}
    assert shapes == {"rows": (3, 8), "solve": (3, 3)}


def test_every_array_of_the_header_has_a_shape() -> None:
    header = resources.files("bladewhirl.solvers.kernel").joinpath("kernel.h").read_text()
    arrays = re.findall(r"^ {4}(?:Int)?(?:Vector|Matrix|Cube) \w+;.*", header, re.MULTILINE)
    assert len(arrays) > 100
    assert not [line for line in arrays if not re.search(r"/\* \([\w, ]+\)", line)]
