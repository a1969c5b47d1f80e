"""The card of a run: what is drawn is what is stored, and the sentence says it."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from legible import assert_legible
from long_cases import slow_except
from matplotlib.collections import PolyCollection
from matplotlib.patches import Rectangle, StepPatch
from three_runs import KINDS, Kind, run_of

from bladewhirl.models.case.file import loads
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.postprocess.fields.kinematics import contact_forces
from bladewhirl.postprocess.pictures.card import card, nearest_order, plot_card, verdict
from bladewhirl.postprocess.plotting.style import at_width, save_figure
from bladewhirl.postprocess.run.extremes import largest_force
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.run.histories import contact_force

pytestmark = pytest.mark.pictures

STAGE, HISTORY, CLOCK, STRESS, CASING, CAMPBELL = range(6)


@pytest.mark.parametrize("kind", slow_except(KINDS, "blade"))
def test_what_is_drawn_is_what_is_stored(kind: Kind) -> None:
    run = run_of(kind)
    with at_width(0.085):
        figure, data = RunFigures(run).draw("card")
    assert figure.get_size_inches() == pytest.approx([11.693, 8.268], abs=1e-3)  # A4 at any width
    assert_legible(figure)
    panels = [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]
    force = contact_force(run)["normal"].values
    record = int(force.max(axis=1).argmax())
    assert data.attrs["shown_time"] == float(run["time"][record])
    stage = panels[STAGE].collections[0]
    assert isinstance(stage, PolyCollection)
    assert len(stage.get_paths()) == data.sizes["polygon"] > 100
    top = data["limits"].values[0, 1]
    assert 0.5 * top < np.nanmax(np.abs(data["value"])) <= max(top, data["limits"].values[-1, 1])
    scales = [str(name) for name in data["scale"].values]
    assert scales[0].endswith("stress, rotor [MPa]")
    assert len(scales) == (1 if kind == "blade" else 2)  # a rigid wall has no stress
    arrows = np.ptp(data["arrow"].values, axis=1).max(axis=1) > 0.0
    pushed = np.any(contact_forces(run, np.array([record]))[0], axis=1)
    assert pushed.any()
    assert not (arrows & ~pushed).any()
    (line, cursor) = panels[HISTORY].lines
    assert np.max(line.get_ydata()) in (force.max(), pytest.approx(1e-3 * force.max()))
    assert np.asarray(cursor.get_xdata())[0] == data.attrs["shown_time"]
    if kind != "blade":
        bars = [patch for patch in panels[CLOCK].patches if isinstance(patch, Rectangle)]
        stored = data["largest_force"].values
        heights = np.array([bar.get_height() for bar in bars])
        np.testing.assert_allclose(heights / heights.max(), stored / stored.max())
    points = np.concatenate(
        [line.get_ydata() for line in panels[STRESS].lines if line.get_marker() == "o"]
    )
    np.testing.assert_allclose(np.sort(points), np.sort(1e-6 * data["alternating"].values))
    (around,) = [patch for patch in panels[CASING].patches if isinstance(patch, StepPatch)]
    drawn = around.get_data()[0]
    stored = data["force" if kind == "wheel" else "wear"].max("axial").values
    factor = np.nanmax(drawn) / np.nanmax(stored)
    units = (1.0, 1e-3) if kind == "wheel" else (1e3, 1e6)
    assert factor in [pytest.approx(each) for each in units]
    np.testing.assert_allclose(drawn, factor * stored)
    speeds = [
        np.asarray(line.get_xdata())[0]
        for line in panels[CAMPBELL].lines
        if line.get_linestyle() == "-"
    ]
    assert run.attrs["speed"] * 30 / np.pi in (pytest.approx(speed) for speed in speeds)


@pytest.mark.parametrize("kind", KINDS)
def test_the_sentence_has_the_numbers_of_the_summary(kind: Kind) -> None:
    run = run_of(kind).assign_attrs(endurance=2e8, strength=9e8)
    figures = RunFigures(run)
    data = card(run, figures.known_stresses, figures.energies)
    text = verdict(data)
    margin = float(data["margin"].min())
    sense = "within" if margin >= 1.0 else "beyond"
    assert f"{sense} the limits of its material (margin {margin:.3g})" in text
    assert text.endswith(".")
    assert ("of the coating are removed" in text) == (kind != "wheel")
    if kind == "beams":
        assert f"blade {largest_force(run)['blade']} is pushed by up to" in text
    near = nearest_order(data)
    assert near is not None
    turns = run.attrs["speed"] / (2 * np.pi)
    assert abs(near[0] * turns / near[1] - 1.0) == pytest.approx(near[2])
    if kind == "beams":  # whose waves have two frequencies
        return
    modes = modal_model(loads(run.attrs["case"])).listed_modes
    hertz, orders = modes.frequency / (2 * np.pi), np.arange(1, 9)[:, None]
    apart = np.where(hertz <= 8 * turns, np.abs(orders * turns / hertz - 1.0), np.inf)
    if kind == "wheel":
        apart[np.minimum(orders % 18, -orders % 18) != modes.nodal_diameter] = np.inf
    assert near[2] == pytest.approx(apart.min(), rel=1e-4)


def test_the_page_is_one_file_of_a4(tmp_path: Path) -> None:
    figure, drawn = RunFigures(run_of("beams")).draw("card")
    path, data = save_figure(figure, tmp_path / "card", drawn, formats=["pdf"])
    assert data.name == "card.nc"
    assert b"/MediaBox [ 0 0 841.88" in path.read_bytes().replace(b"\n", b" ")


def test_a_run_without_contact_says_so() -> None:
    run = run_of("wheel")
    none = {
        name: 0 * run[name] for name in ("contact_impulse", "friction_impulse", "contact_steps")
    }
    figure, data = RunFigures(run.assign(none)).draw("card")
    assert verdict(data).startswith("No contact: the smallest gap is")
    assert_legible(figure)


def test_each_order_excites_separate_blades() -> None:
    """Modes of one of 24 blades have all nodal diameters in nearly equal shares."""
    shares = np.full((1, 13), 2.0 / 24.0)
    shares[0, [0, 12]] = 1.0 / 24.0
    data = xr.Dataset(
        {
            "mode_frequency": ("mode", [248.0]),
            "diameter_share": (("mode", "nodal_diameter"), shares),
        },
        attrs={"speed": 2.0 * np.pi * 83.0, "blades": 24, "applied_orders": np.array([4])},
    )
    near = nearest_order(data)
    assert near is not None
    assert near[:2] == (3, 248.0)
    assert near[2] == pytest.approx(249.0 / 248.0 - 1.0)


def test_applied_orders_come_first() -> None:
    """Order 4 is nearer to a mode than order 3, which a load has."""
    data = xr.Dataset(
        {
            "mode_frequency": ("mode", [248.0, 332.0]),
            "diameter_share": (("mode", "nodal_diameter"), np.full((2, 13), 1.0 / 12.0)),
        },
        attrs={"speed": 2.0 * np.pi * 83.0, "blades": 24, "applied_orders": np.array([3, 9])},
    )
    near = nearest_order(data)
    assert near is not None
    assert near[0] == 3
    near = nearest_order(data.assign_attrs(applied_orders=np.array([9])))
    assert near is not None
    assert near[0] == 4


def test_lost_blades_are_crossed_out_on_the_clock() -> None:
    run = run_of("beams")
    figures = RunFigures(run)
    data = card(run, figures.known_stresses, figures.energies)
    figure = plot_card(data.assign_attrs(lost_blades=np.array([2]), loss_time=0.01))
    clock = [axes for axes in figure.axes if axes.get_label() != "<colorbar>"][CLOCK]
    (cross,) = (line for line in clock.lines if line.get_marker() == "x")
    np.testing.assert_allclose(np.asarray(cross.get_xdata()), data["blade_angle"].values[2])
    assert clock.get_title().endswith("×: lost")
