"""Random cases, their mirror images, the same turned by a sector, and with front and back
exchanged. An energy balance closes with any force that the program applies; images do not."""

from pathlib import Path

import numpy as np
import pytest
from long_cases import slow_except
from symmetric_cases import (
    Image,
    beam_case,
    blades_of,
    changed,
    difference,
    marched,
    solid_case,
    write_parts,
)

LIMIT = 5e-6  #: largest difference of an image, of the largest value; chaos amplifies rounding


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("parts")
    write_parts(folder)
    return folder


def check(case: dict[str, object], *kinds: str, rubs: bool = True) -> None:
    result = marched(case)
    assert not rubs or result["friction_impulse"].values.any()
    for kind in kinds:
        image = Image(kind, blades_of(case))
        found = difference(result, marched(changed(case, image)), image)
        assert max(found.values()) < LIMIT, (kind, found)


@pytest.mark.parametrize("seed", slow_except([0, 2, 3, 4, 6], 3, 6))  # of cases in which blades rub
def test_images_of_beams_move_as_images(seed: int) -> None:
    check(beam_case(np.random.default_rng(seed)), "mirror", "turn")


@pytest.mark.parametrize("seed", slow_except(range(7), 0, 5))
def test_images_of_solids_move_as_images(seed: int, parts: Path) -> None:
    check(solid_case(np.random.default_rng(seed), parts), "mirror", "turn", "flip")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 140))
def test_images_of_more_stages_move_as_images(seed: int, parts: Path) -> None:
    check(beam_case(np.random.default_rng(seed)), "mirror", "turn", rubs=False)
    check(solid_case(np.random.default_rng(seed), parts), "mirror", "turn", "flip", rubs=False)


def test_a_key_without_a_rule_is_not_compared_in_silence() -> None:
    with pytest.raises(KeyError, match=r"casing\.new\.angle"):
        changed({"casing": {"new": {"angle": 1.0}}}, Image("mirror", 5))
