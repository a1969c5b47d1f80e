"""Spectrum, spectrogram and the lines of modes, against circles and a chirp in closed form."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr
from numpy.typing import ArrayLike

from bladewhirl.postprocess.shaft.orbits import shaft_orbit
from bladewhirl.postprocess.shaft.spectra import (
    modal_lines,
    plot_spectrogram,
    plot_spectrum,
    shaft_spectrogram,
    shaft_spectrum,
    with_lines,
)
from bladewhirl.postprocess.shaft.transforms import Frame

RADIUS = 0.8e-3


def peak(spectrum: xr.Dataset) -> tuple[float, float]:
    """Frequency and height of the largest amplitude."""
    at = int(np.argmax(spectrum.amplitude.values))
    return float(spectrum.frequency[at]), float(spectrum.amplitude[at])


def along(complex_place: ArrayLike) -> xr.Dataset:
    """An orbit whose place in rotating axes is x + i y."""
    place = np.asarray(complex_place, dtype=np.complex128)
    orbit = shaft_orbit(synthetic.synthetic_result(records=len(place)))
    orbit["rotating"] = ("time", "axis"), np.column_stack([place.real, place.imag])
    return orbit


class TestSpectrum:
    @pytest.mark.parametrize(
        ("frame", "speed", "frequency"),
        [("rotating", 80.0, -70.0), ("static", 80.0, 10.0), ("rotating", -80.0, 70.0)],
    )
    def test_a_circle_is_one_line_with_its_radius(
        self, frame: Frame, speed: float, frequency: float
    ) -> None:
        orbit = shaft_orbit(synthetic.synthetic_result(records=4001, speed=speed))
        spectrum = shaft_spectrum(orbit, frame)
        actual, height = peak(spectrum)
        assert actual == pytest.approx(frequency, abs=0.5 * spectrum.attrs["resolution"])
        assert height == pytest.approx(RADIUS, rel=0.02)
        mirrored = spectrum.amplitude.sel(frequency=-frequency, method="nearest")
        assert float(mirrored) < 1e-3 * RADIUS

    def test_a_straight_vibration_is_two_lines_of_half_its_amplitude(self) -> None:
        time = synthetic.RECORD_STEP * np.arange(4001)
        spectrum = shaft_spectrum(along(np.exp(0.7j) * RADIUS * np.cos(200 * time)))
        for side in (-200.0, 200.0):
            near = spectrum.amplitude.sel(frequency=slice(side - 2, side + 2))
            assert float(near.max()) == pytest.approx(RADIUS / 2, rel=0.02)


class TestSpectrogram:
    def test_the_ridge_of_a_chirp_is_its_rate(self) -> None:
        time = synthetic.RECORD_STEP * np.arange(6001)
        chirp = RADIUS * np.exp(1j * (30 * time**2 - 400 * time))
        spectrogram = shaft_spectrogram(along(chirp), length=0.5)
        ridge = spectrogram.frequency[spectrogram.amplitude.argmax("frequency").values]
        expected = -400 + 60 * spectrogram.time.values
        np.testing.assert_allclose(ridge, expected, atol=0.5 * spectrogram.attrs["resolution"])
        assert len(ridge) > 100
        assert spectrogram.attrs["resolution"] == pytest.approx(2 * np.pi / 0.5, rel=5e-3)
        np.testing.assert_allclose(spectrogram.amplitude.max("frequency"), RADIUS, rtol=0.1)


class TestModalLines:
    def test_frames_differ_by_the_speed(self) -> None:
        result = synthetic.synthetic_result()
        rotating, static = (modal_lines(result, frame) for frame in ("rotating", "static"))
        of_modes = static["mode"].values != "Ω"
        np.testing.assert_allclose((static - rotating)[of_modes], synthetic.SPEED)
        # What rests in space runs backward round the rotor; what turns with it runs forward.
        assert [*rotating.values[~of_modes], *static.values[~of_modes]] == [-80.0, 80.0]

    def test_modes_are_where_they_vibrate(self) -> None:
        result = synthetic.synthetic_result()
        rotating, static = (modal_lines(result, frame) for frame in ("rotating", "static"))
        seen = {
            str(name): sorted(rotating.values[rotating["mode"].values == name])
            for name in rotating["mode"].values
        }
        assert seen["1F"] == [-75.0, 75.0]
        assert seen["suspension"] == [-190.0, 190.0]
        assert sorted(static.values[static["mode"].values == "casing"]) == [-5.0, 5.0]

    def test_over_time_they_follow_the_speed(self) -> None:
        times = np.array([0.0, 0.005, 0.01])
        result = synthetic.synthetic_result()
        record = result["time"].values
        speed = 80.0 + 1e3 * record
        result["rotation_speed"] = ("time", speed)
        result["rotation_angle"] = ("time", 80.0 * record + 500.0 * record**2)
        lines = modal_lines(result, "rotating", times)
        assert lines["mode"].values.tolist() == ["Ω", "casing", "casing"]
        shifts = np.array([[0.0], [-5.0], [5.0]])
        np.testing.assert_allclose(lines, shifts - [80.0, 85.0, 90.0])

    def test_coriolis_forces_part_them(self) -> None:
        result = synthetic.synthetic_result()
        result["rotor_forward_frequency"] = result["rotor_frequency"] - 90.0
        lines = modal_lines(result, "rotating")
        assert lines.values[lines["mode"].values == "1F"].tolist() == [-75.0, -15.0]


class TestFigures:
    def test_all_lines_are_seen_once_in_the_legend(self) -> None:
        result = synthetic.synthetic_result(records=2001)
        orbit, lines = shaft_orbit(result), modal_lines(result, "rotating")
        for figure in (
            plot_spectrum(with_lines(shaft_spectrum(orbit), lines)),
            plot_spectrogram(with_lines(shaft_spectrogram(orbit), lines)),
        ):
            (legend,) = figure.legends
            texts = [text.get_text() for text in legend.get_texts()]
            assert texts == ["−Ω", "1F, k = 1", "suspension", "casing, k = 1"]
        axes = plot_spectrum(with_lines(shaft_spectrum(orbit), lines)).axes[0]
        low, high = axes.get_xlim()
        assert low < -190 / (2 * np.pi)
        assert high > 190 / (2 * np.pi)
        assert "Hz" in axes.get_xlabel()
