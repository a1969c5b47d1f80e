"""Rotation with a negative speed: the mirror image, with the same forward and backward waves."""

from functools import cache

import numpy as np
import pytest
import xarray as xr

import bladewhirl as bw
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.models.structure.rotating import Effects
from bladewhirl.postprocess.fields.kinematics import tip_rows
from bladewhirl.postprocess.modal.mode_shapes import plot_mode_shapes
from bladewhirl.postprocess.modal.motion import Wave, mode_motion, shapes_dataset
from bladewhirl.studies.modal.modes import document, mode_lists
from bladewhirl.studies.modal.veering import veering


@cache
def stage(effects: Effects, speed: float) -> ModalModel:
    return modal_model(
        bw.case_from(
            {
                "bladed_disk": {"blades": 8, "elements_per_blade": 4},
                "casing": {"elements": 24},
                "rotation": {"effects": effects},
                "march": {"speed": speed},
            }
        )
    )


@pytest.mark.slow
@pytest.mark.parametrize("effects", ["none", "centrifugal", "full"])
@pytest.mark.parametrize("speed", [0.7, 1.6])
def test_modes_are_listed_alike(effects: Effects, speed: float) -> None:
    if effects == "centrifugal":
        speed *= 0.5  # below the critical speed
    ahead, astern = (
        document(mode_lists(modal_model(stage(effects, s))), 12) for s in (speed, -speed)
    )
    assert ahead.keys() == astern.keys()
    for name, rows in ahead.items():
        for one, other in zip(rows, astern[name], strict=True):
            for key, value in one.items():
                same = value if isinstance(value, str | None) else pytest.approx(value, rel=1e-9)
                assert other[key] == same


def test_veering_is_listed_alike() -> None:
    springs = np.geomspace(1e6, 1e9, 5)
    ahead, astern = (veering(stage("full", s), stiffnesses=springs) for s in (0.7, -0.7))
    assert ahead["branch_direction"].values.tolist() == astern["branch_direction"].values.tolist()
    for name in ("branch_frequency", "branch_spring_share", "clamped_frequency"):
        xr.testing.assert_allclose(ahead[name], astern[name])


def turns(motion: xr.Dataset, body: str) -> float:
    """Rate at which a wave of one nodal diameter turns over one record, positive towards +theta."""
    if body == "casing":
        angle, shape = motion["casing_angle"].values, motion["casing_shape"].values[:, 0]
        field = motion["casing_displacement"].values @ shape.T
    else:
        angle = motion["tip_angle"].values
        field = motion["rotor_displacement"].values @ tip_rows(motion)[0].T
    phase = np.angle(field @ np.exp(1j * angle))
    return float(np.angle(np.exp(1j * np.diff(phase))).sum())


@pytest.mark.parametrize("effects", ["none", "full"])
@pytest.mark.parametrize("body", ["bladed-disk", "casing"])
@pytest.mark.parametrize("wave", ["forward", "backward"])
def test_films_of_waves_turn_with_the_rotation_or_against_it(
    effects: Effects, body: str, wave: Wave
) -> None:
    for speed in (0.7, -0.7):
        given = stage(effects, speed)
        numbers = pair(given, body, wave)
        motion = mode_motion(given, body, numbers, wave=wave, title="")  # type: ignore[arg-type]
        sense = np.sign(speed) * (1.0 if wave == "forward" else -1.0)
        assert np.sign(turns(motion, body)) == sense


def pair(given: ModalModel, body: str, wave: Wave) -> np.ndarray:
    if body == "casing":
        return np.flatnonzero(given.casing_modes.nodal_diameter == 1)[:2]
    if given.effects != "full":
        return np.flatnonzero(given.disk_modes.nodal_diameter == 1)[:2]
    rotating, _ = given.listed_modes.named_directions(given.speed)
    k = given.listed_modes.nodal_diameter
    return np.flatnonzero((k == 1) & (np.array(rotating) == wave))[:1]


@pytest.mark.parametrize("speed", [0.7, -0.7])
def test_pictures_say_the_sense_of_rotation_and_the_directions(speed: float) -> None:
    given = stage("full", speed)
    data = shapes_dataset(given, "bladed-disk", pair(given, "bladed-disk", "forward"))
    assert data["rotor_direction"].values.tolist() == ["forward"]
    text = " ".join(
        each.get_text()
        for each in plot_mode_shapes(data, "bladed-disk").findobj()
        if hasattr(each, "get_text")
    )
    assert f"rotation is {'counter-' if speed > 0 else ''}clockwise" in text
