"""Figures of stability and coupled modes: what they are drawn from, and that all of it is there."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import xarray as xr
from coupled_system import paper_modes
from matplotlib.collections import QuadMesh

from bladewhirl.models.case.case import Case
from bladewhirl.models.coupling.springs import CouplingModes
from bladewhirl.models.coupling.stage_modes import StageModes
from bladewhirl.postprocess.modal.coupled_modes import plot_phases
from bladewhirl.postprocess.modal.stability import plot_chart, plot_spectrum, plot_truncation
from bladewhirl.solvers.stability.coupled_modes import CoupledMotion
from bladewhirl.solvers.stability.growth import growth_rate
from bladewhirl.studies.modal.coupled_system import EvenSystem
from bladewhirl.studies.modal.stability import motion_dataset
from bladewhirl.studies.modal.stability_chart import spectrum_along, stability_chart, truncation

UNIT = 250.0


def six_modes() -> CouplingModes:
    return paper_modes(casing=0.055 * UNIT, first_flexural=UNIT, suspension=2.5 * UNIT)


def system(modes: CouplingModes) -> EvenSystem:
    """Modes without the finite elements that they come from."""
    stage = StageModes(
        modes=modes, number=np.arange(modes.entries), modal=cast(Any, SimpleNamespace(case=Case()))
    )
    return EvenSystem(
        modes=modes, stage=stage, all_modes=stage, damped=False, physical=False, reference=UNIT
    )


def chart(modes: CouplingModes, low: float = 0.6, high: float = 3.0) -> xr.Dataset:
    speeds, kappas = np.linspace(low, high, 60) * UNIT, np.linspace(0.0, 1000.0, 12)
    return stability_chart(system(modes), speeds, kappas)


def motion() -> CoupledMotion:
    """A shaft forward in the static frame at 30 rad/s, 90 degrees behind the smallest clearance."""
    time = np.linspace(0.0, 0.5, 400)
    shaft = np.exp(1j * (30.0 - 200.0) * time)
    return CoupledMotion(
        time=time,
        nodal_diameter=1,
        speed=200.0,
        displacement=np.zeros((400, 6)),
        velocity=np.zeros((400, 6)),
        shaft=1e-3 * np.stack([shaft.real, shaft.imag], axis=-1),
        rotor_wave=np.zeros(400, dtype=np.complex128),
        casing_wave=1e-3 * np.exp(1j * (30.0 * time - 0.5 * np.pi)),
    )


@pytest.mark.slow
def test_chart_draws_its_zones_up_from_the_coincidence_speeds() -> None:
    data = chart(six_modes())
    figure = plot_chart(data, point=(1.17, 500.0))
    axes = figure.axes[0]
    mesh = next(item for item in axes.collections if isinstance(item, QuadMesh))
    drawn = np.ma.masked_array(mesh.get_array())
    assert (~drawn.mask).sum() == (data["growth"].values > 1e-4).sum() > 0
    borders = [line for line in axes.lines if line.get_linestyle() == "-"]
    assert len(borders) == 4
    starts = sorted(float(np.asarray(line.get_xdata())[0]) for line in borders)
    assert starts == pytest.approx([1.055, 1.055, 2.555, 2.555])
    assert [text.get_text() for text in axes.texts] == ["casing and 1F", "casing and suspension"]
    lightest = np.mean(mesh.to_rgba(np.array([0.0, 1.0, 10.0]))[:, :3], axis=1)
    assert lightest[0] == lightest.max()  # what hardly grows is nearly as light as what is stable
    assert data["growth"].dims == ("kappa", "speed")
    assert set(data["zone_rotor"].values) == {"1F", "suspension"}


@pytest.mark.slow
def test_spectrum_shows_three_types_of_modes() -> None:
    data = spectrum_along(system(six_modes()), np.array([0.6, 3.0]) * UNIT, 500.0)
    figure = plot_spectrum(data)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["oscillatory mode", "damped mode", "divergent mode"]
    drawn = np.array([line.get_ydata() for line in figure.axes[0].lines], dtype=np.float64)
    upper, lower = ({text.get_text() for text in axes.texts} for axes in figure.axes)
    assert upper == {"casing and 1F", "casing and suspension"}
    ways = [f"{name}, {way}" for name in six_modes().name for way in ("forward", "backward")]
    assert lower == set(ways)
    growth = growth_rate(six_modes(), speed=data["speed"].values * UNIT, kappa=500.0).max()
    assert [np.nanmin(drawn), np.nanmax(drawn)] == pytest.approx([-growth, growth])


def test_a_spectrum_without_growth_has_no_panel_of_growth_rates() -> None:
    data = spectrum_along(system(six_modes()), np.array([1.6, 1.9]) * UNIT, 50.0)
    figure = plot_spectrum(data)
    assert [axes.get_ylabel() for axes in figure.axes] == ["frequency / ω₁ [–]"]
    assert "No mode grows or decays" in figure.get_suptitle()


@pytest.mark.slow
def test_truncation_shows_zones_that_six_modes_hide() -> None:
    six = six_modes()
    second = replace(six, nodal_diameter=np.full(3, 2), name=("casing 2", "1F 2", "s 2"))
    names = ("on_casing", "nodal_diameter", "frequency", "amplitude", "damping_ratio", "paired")
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(six, name), getattr(second, name)]) for name in names
    }
    whole = CouplingModes(name=six.name + second.name, **arrays)
    data = truncation(chart(whole), chart(six))
    figure = plot_truncation(data)
    fills = figure.axes[0].collections
    outlines = figure.axes[0].lines
    assert len(fills) == 4
    assert len(outlines) == 4


def test_phases_and_their_difference() -> None:
    data = motion_dataset(motion(), reference=UNIT)
    assert data.attrs["casing_wave_speed"] == pytest.approx(30.0)
    assert np.diff(data["shaft_phase"].values) == pytest.approx(30.0 * 0.5 / 399)
    assert np.degrees(data["shaft_lead"].values) == pytest.approx(-90.0)
    figure = plot_phases(data)
    shaft = np.asarray(figure.axes[0].lines[0].get_ydata(), dtype=np.float64)
    assert np.nanmax(np.abs(np.diff(shaft))) < 10.0  # wrapped jumps are breaks, not strokes
