"""Stills and animations as files: read back, and looked at by what colours are where."""

import ctypes
import math
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr
from numpy.typing import NDArray
from PIL import Image

from bladewhirl.postprocess.pictures.colouring import scale_end
from bladewhirl.postprocess.pictures.films import write_pictures
from bladewhirl.postprocess.pictures.offscreen import OffScreenError, require_off_screen
from bladewhirl.postprocess.pictures.render import (
    animation_records,
    render_animation,
    render_still,
    strongest_contact,
)
from bladewhirl.postprocess.plotting.style import COLOUR_MAPS

SMALL = (320, 240)
STAGE = 240  # the left three quarters of the window

Pixels = NDArray[np.int64]


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return synthetic.synthetic_result(elements=2)


def pixels(path: Path) -> Pixels:
    return np.asarray(Image.open(path).convert("RGB"), dtype=np.int64)


def vermilion(image: Pixels) -> NDArray[np.bool_]:
    """Where the stage's part of an image has the colour of contact."""
    return np.asarray(np.abs(image[:, :STAGE] - [0xD5, 0x5E, 0x00]).sum(axis=-1) < 40)


class TestRecords:
    """One turn is 78.5 records; 22 blades need 66 pictures a turn, so each record is one."""

    def test_window_of_the_strongest_contact(self, result: xr.Dataset) -> None:
        records = animation_records(result, frames=20)
        impulse = result.contact_impulse.values.sum(axis=1)
        totals = [impulse[i : i + 20].sum() for i in range(len(impulse) - 19)]
        assert totals[records[0]] == pytest.approx(max(totals))
        np.testing.assert_array_equal(np.diff(records), 1)
        assert len(records) == 20

    def test_end_of_the_run_without_contact(self, result: xr.Dataset) -> None:
        free = result.assign(contact_impulse=0.0 * result.contact_impulse)
        assert animation_records(free, frames=30)[-1] == 400
        assert strongest_contact(free) == 400

    def test_window(self, result: xr.Dataset) -> None:
        assert animation_records(result, frames=5, start=0.1).tolist() == [100, 101, 102, 103, 104]
        assert animation_records(result, frames=3, end=0.1).tolist() == [98, 99, 100]
        assert len(animation_records(result, start=0.1, end=0.3)) == 201
        spread = animation_records(result, frames=5, start=0.1, end=0.3)
        assert spread.tolist() == [100, 150, 200, 250, 300]


@pytest.mark.usefixtures("can_draw")
class TestStill:
    def test_contact_is_marked_where_it_is(self, result: xr.Dataset, tmp_path: Path) -> None:
        record = strongest_contact(result)
        image = pixels(render_still(result, tmp_path / "contact.png", record, size=SMALL))
        assert image.shape == (240, 320, 3)
        row, column = np.nonzero(vermilion(image))
        seen = math.atan2(119.5 - row.mean(), column.mean() - 119.5)
        touched = np.flatnonzero(result.contact_impulse.values[record])
        turned = synthetic.SPEED * float(result.time[record])
        expected = np.angle(np.exp(1j * (result.tip_angle.values[touched] + turned)).sum())
        assert abs(np.angle(np.exp(1j * (seen - expected)))) < 0.15

    def test_no_contact_shows_none(self, result: xr.Dataset, tmp_path: Path) -> None:
        free = int(np.argmin(result.contacts.values))
        image = pixels(render_still(result, tmp_path / "free.png", free, size=SMALL))
        assert not vermilion(image).any()
        assert len(np.unique(image.reshape(-1, 3), axis=0)) > 100  # and yet a picture


@pytest.mark.usefixtures("can_draw")
class TestAnimation:
    def test_gif(self, result: xr.Dataset, tmp_path: Path) -> None:
        calls: list[tuple[int, int]] = []
        path = render_animation(
            result,
            tmp_path / "run.gif",
            np.arange(100, 140, 5),
            size=SMALL,
            progress=lambda done, total: calls.append((done, total)),
        )
        assert calls == [(i, 8) for i in range(1, 9)]
        with Image.open(path) as film:
            assert film.format == "GIF"
            assert getattr(film, "n_frames", 1) == 8
            assert film.info["duration"] == 40
            assert film.info["loop"] == 0
            frames = []
            for number in range(8):
                film.seek(number)
                frames.append(np.asarray(film.convert("RGB"), dtype=np.int64)[:, :STAGE])
        for one, other in pairwise(frames):
            assert np.any(one != other, axis=-1).mean() > 0.02
        assert frames[0][0, 0].tolist() == [255, 255, 255]

    def test_colours_of_a_gif_are_those_of_its_pictures(self, tmp_path: Path) -> None:
        """All colours of a scale in light from dark to bright, as on turned surfaces."""
        scale = COLOUR_MAPS["magnitude"](np.linspace(0.0, 1.0, 160))[None, :, :3]
        lit = np.round(255 * scale * np.linspace(0.6, 1.0, 120)[:, None, None]).astype(np.uint8)
        path = write_pictures(tmp_path / "lit.gif", lambda index: np.roll(lit, index, axis=1), 8)
        with Image.open(path) as film:
            apart = np.abs(np.asarray(film.convert("RGB"), dtype=np.int64) - lit).max(axis=-1)
        assert apart.mean() < 5
        assert (apart > 12).mean() < 0.01

    def test_mp4(self, result: xr.Dataset, tmp_path: Path) -> None:
        path = render_animation(result, tmp_path / "run.mp4", np.arange(100, 110), size=SMALL)
        decoder = [imageio_ffmpeg.get_ffmpeg_exe(), "-i", str(path), "-f", "rawvideo"]
        raw = subprocess.run([*decoder, "-pix_fmt", "rgb24", "-"], capture_output=True, check=True)
        assert b"h264" in raw.stderr
        assert b"320x240" in raw.stderr
        assert b"25 fps" in raw.stderr
        frames = np.frombuffer(raw.stdout, np.uint8).astype(np.int64).reshape(-1, 240, 320, 3)
        assert len(frames) == 10
        assert np.abs(frames[0] - frames[9])[:, :STAGE].mean() > 1

    def test_failure_leaves_nothing(self, result: xr.Dataset, tmp_path: Path) -> None:
        def stop(done: int, total: int) -> None:
            if done == 3:
                raise KeyboardInterrupt

        for name in ("run.gif", "run.mp4"):
            with pytest.raises(KeyboardInterrupt):
                render_animation(result, tmp_path / name, np.arange(9), size=SMALL, progress=stop)
        assert list(tmp_path.iterdir()) == []


class TestRefusals:
    def test_other_kinds_of_file(self, result: xr.Dataset, tmp_path: Path) -> None:
        with pytest.raises(ValueError, match=r"still\.jpg must end in \.png"):
            render_still(result, tmp_path / "still.jpg", 0)
        with pytest.raises(ValueError, match=r"must end in \.gif or \.mp4"):
            render_animation(result, tmp_path / "run.avi", np.arange(3))

    def test_without_egl_the_error_names_packages(
        self, result: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def missing(name: str) -> ctypes.CDLL:
            raise OSError(f"{name}: cannot open shared object file")

        monkeypatch.setattr(sys, "platform", "linux")
        monkeypatch.delenv("VTK_DEFAULT_OPENGL_WINDOW", raising=False)
        monkeypatch.setattr(ctypes, "CDLL", missing)
        require_off_screen.cache_clear()
        with pytest.raises(OffScreenError) as caught:
            render_still(result, tmp_path / "still.png", 0)
        message = str(caught.value)
        assert "\n" not in message
        for package in ("libegl1", "libegl-mesa0", "libgl1-mesa-dri", "libx11-6"):
            assert package in message
        assert list(tmp_path.iterdir()) == []


def test_ends_of_colour_scales_are_round() -> None:
    assert scale_end(1.12) == pytest.approx(1.2)
    assert scale_end(10.0) == pytest.approx(10.0)
    assert scale_end(0.0) == 1.0
