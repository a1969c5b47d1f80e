"""Figures and films of modal analysis: what they show, and that it can be read."""

from functools import cache
from itertools import pairwise
from typing import Literal

import numpy as np
import pytest
import xarray as xr
from legible import assert_legible
from matplotlib.figure import Figure
from matplotlib.text import Text
from numpy.typing import NDArray

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.meshes.plane import rotate
from bladewhirl.models.modal.labels import Body
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.modal.whirl_modes import WhirlModes
from bladewhirl.models.stage.modal import modal_model
from bladewhirl.postprocess.fields.kinematics import casing_rows, combine, turn
from bladewhirl.postprocess.modal.campbell import drawn_part, plot_campbell
from bladewhirl.postprocess.modal.mode_shapes import plot_mode_shapes, plot_travelling_wave
from bladewhirl.postprocess.modal.motion import PICTURES, Wave, mode_motion, shapes_dataset
from bladewhirl.postprocess.modal.response import plot_amplification
from bladewhirl.postprocess.modal.scenarios import plot_scenario
from bladewhirl.postprocess.modal.veering import plot_families, plot_shaft_veering
from bladewhirl.postprocess.plotting.axes import name_ends
from bladewhirl.postprocess.plotting.style import new_figure
from bladewhirl.solvers.stability.coupled_modes import phase_rate, wave_coefficient
from bladewhirl.studies.modal.scenarios import scenario_dataset, whirling_modes

pytestmark = pytest.mark.pictures

RECORDS = np.arange(PICTURES)


def rotor_field(data: xr.Dataset) -> NDArray[np.float64]:
    """Displacement of the rotor's nodes in static axes, (record, rotor_node, 2) [m]."""
    modes = data["rotor_displacement"].values[RECORDS]
    field = combine(modes, data["rotor_shape"].values[:, :2])
    return rotate(field, turn(data, RECORDS)[:, None])


def casing_field(data: xr.Dataset, angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Displacement of the casing at static angles, (record, point, 2) [m]."""
    modes = data["casing_displacement"].values[RECORDS]
    return rotate(combine(modes, casing_rows(data, angle)), angle)


@cache
def stage(clearance: float = 1e-3, effects: str = "none") -> ModalModel:
    return modal_model(
        bw.with_values(
            bw.Case(),
            {
                "bladed_disk.blades": 9,
                "bladed_disk.elements_per_blade": 3,
                "casing.elements": 16,
                "casing.clearance": clearance,
                "rotation.effects": effects,
            },
        )
    )


def moving(body: Body, family: str, k: int, wave: Wave, clearance: float = 1e-3) -> xr.Dataset:
    own = stage(clearance=clearance)
    modes = own.disk_modes if body == "bladed-disk" else own.casing_modes
    return mode_motion(own, body, modes.find(family, k), wave=wave, title="a mode")


def radial(data: xr.Dataset, body: Body) -> tuple[FloatArray, FloatArray]:
    """Angles, and the radial displacement there over time, in the body's own frame."""
    if body == "bladed-disk":
        angle, field = data["tip_angle"].values, rotor_field(data)
        field = field[:, data["tip_node"].values]
    else:
        angle = data["casing_angle"].values
        field = casing_field(data, angle)
    outward = np.column_stack([np.cos(angle), np.sin(angle)])
    return angle, np.sum(field * outward, axis=-1)


@pytest.mark.parametrize(
    ("body", "family", "k"),
    [("bladed-disk", "suspension", 1), ("bladed-disk", "2F", 3), ("casing", "1F", 2)],
)
@pytest.mark.parametrize(("wave", "sense"), [("forward", 1.0), ("backward", -1.0)])
def test_waves_travel_as_they_are_called(
    body: Body, family: str, k: int, wave: Wave, sense: float
) -> None:
    data = moving(body, family, k, wave)
    angle, field = radial(data, body)
    crest = wave_coefficient(field, angle, k)
    np.testing.assert_allclose(np.abs(crest), np.abs(crest[0]), rtol=1e-9)
    frequency = float(data["rotor_frequency" if body == "bladed-disk" else "casing_frequency"][0])
    assert phase_rate(data["time"].values, crest) == pytest.approx(sense * frequency)


@pytest.mark.parametrize("k", [0, 1, 3])
def test_whirling_modes_travel_as_they_are_called(k: int) -> None:
    """With Coriolis forces each wave has a frequency of its own, at speed."""
    own = stage(effects="full")
    actual = own.listed_modes
    assert isinstance(actual, WhirlModes)
    numbers = own.listed_modes.find("1F", k)
    assert {actual.direction[number] for number in numbers} == (
        {"forward", "backward"} if k else {"standing"}
    )
    for number in numbers:
        way = actual.direction[number]
        wave: Wave = way
        data = mode_motion(own, "bladed-disk", np.array([number]), wave=wave, title="a mode")
        angle, field = radial(data, "bladed-disk")
        sense = {"forward": 1.0, "backward": -1.0}.get(way, 0.0)
        crest = wave_coefficient(field, angle, k)
        frequency = actual.frequency[number]
        rate = phase_rate(data["time"].values, crest) if sense else 0.0
        assert rate == pytest.approx(sense * frequency)
        velocity, moved = data["rotor_velocity"].values, data["rotor_displacement"].values
        turn = 2.0 * np.pi / PICTURES
        rates = (np.roll(moved, -1, axis=0) - np.roll(moved, 1, axis=0)) * frequency / 2.0
        np.testing.assert_allclose(rates, velocity * np.sin(turn), atol=1e-9 * velocity.max())


def test_a_travelling_wave_is_followed_by_its_filled_crest() -> None:
    data = moving("casing", "1F", 2, "forward").assign_attrs(case="a case")
    figure = plot_travelling_wave(data, "casing")
    angles = []
    for axes in figure.axes[:4]:
        x, y = next(
            np.asarray(line.get_xydata())[0].tolist()
            for line in axes.lines
            if line.get_marker() == "D" and line.get_markerfacecolor() != "none"
        )
        angles.append(np.degrees(np.arctan2(y, x)))
    np.testing.assert_allclose(np.diff(angles), 15.0, atol=1e-6)  # 90 degrees of phase, k = 2


def test_a_standing_wave_keeps_its_nodes() -> None:
    angle, field = radial(moving("casing", "1F", 2, "standing"), "casing")
    crest = wave_coefficient(field, angle, 2)
    assert np.abs(crest.imag).max() < 1e-12 * np.abs(crest.real).max()
    assert crest.real.min() == pytest.approx(-crest.real.max())


@pytest.mark.parametrize("clearance", [1e-3, 0.0])
def test_a_mode_in_time_keeps_its_size_and_holds_nothing_that_a_mode_has_not(
    clearance: float,
) -> None:
    data = moving("bladed-disk", "suspension", 1, "backward", clearance)
    assert not {"contact_impulse", "energy", "external_work"} & set(data.data_vars)
    size = np.linalg.norm(rotor_field(data), axis=-1)
    assert size.max() == pytest.approx(0.7 * clearance or 5e-4, rel=1e-3)
    np.testing.assert_array_less(-1e-12 - (0.0 if clearance else 5e-4), data["gap"].values)
    strain = data["rotor_frequency"] * data["rotor_displacement"]
    energy = (data["rotor_velocity"] ** 2 + strain**2).sum("rotor_mode")
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)
    # Velocities are the rates of displacements: exact for one harmonic over a whole period.
    rate = data["rotor_displacement"].differentiate("time").values[1:-1]
    velocity = data["rotor_velocity"].values[1:-1]
    turn = 2.0 * np.pi / PICTURES
    np.testing.assert_allclose(rate, velocity * np.sin(turn) / turn, atol=1e-9 * velocity.max())


def test_a_single_mode_does_not_travel() -> None:
    with pytest.raises(
        ValueError, match="a single mode is a standing wave; it has no forward wave"
    ):
        moving("bladed-disk", "1F", 0, "forward")


def shapes(body: Body) -> xr.Dataset:
    own = stage()
    modes, ks = (
        (own.disk_modes, (0, 1, 2, 4))
        if body == "bladed-disk"
        else (own.casing_modes, (2, 3, 4, 5))
    )
    return shapes_dataset(own, body, np.array([modes.find("1F", k)[0] for k in ks]))


@cache
def diagrams() -> xr.Dataset:
    return bw.veering(stage(), families=4, stiffnesses=np.geomspace(1e5, 1e9, 10))


@pytest.mark.slow
@pytest.mark.parametrize("frame", ["rotating", "static"])
def test_coincidences_are_marked_where_a_level_meets_a_ray(
    frame: Literal["rotating", "static"],
) -> None:
    data = bw.campbell(stage(), families=2, speeds=(0.0, 5.0))
    (axes,) = plot_campbell(data, frame).axes
    rings = [line for line in axes.lines if line.get_marker() == "o"]
    marked = np.vstack([line.get_xydata() for line in rings])
    assert len(marked) == np.count_nonzero(drawn_part(data)["normalised_speed"] <= 5.0) > 2
    named = {text.get_text() for text in axes.texts}
    assert {str(k) for k in drawn_part(data)["nodal_diameter"].values} <= named
    assert {"1F", "suspension", "k = 1", "k = 2"} <= named
    lines = [line for line in axes.lines if line.get_marker() != "o"]
    for speed, frequency in marked:
        through = []
        for line in lines:
            x, y = np.asarray(line.get_xydata()).T
            if abs(np.interp(speed, x, y) - frequency) < 1e-3:
                through.append(line.get_linestyle())
        assert {"-", "--"} <= set(through)  # one body's level and the other's ray


@cache
def figures() -> dict[str, Figure]:
    own = stage()
    whirl = scenario_dataset(
        whirling_modes(own, casing_share=2.0), reference=own.reference_frequency
    ).assign_attrs(case="a case")
    return {
        "shapes": plot_mode_shapes(shapes("bladed-disk"), "bladed-disk"),
        "families": plot_families(diagrams()),
        "shaft": plot_shaft_veering(diagrams()),
        "rotating": plot_campbell(bw.campbell(own), "rotating"),
        "scenario": plot_scenario(whirl),
    }


@pytest.mark.parametrize("name", ["shapes", "families", "shaft", "rotating", "scenario"])
@pytest.mark.slow
def test_figures_are_as_wide_as_a_column_or_a_page_with_legible_text_inside(name: str) -> None:
    figure = figures()[name]
    width = 0.085 if name in ("families", "shaft") else 0.17
    assert figure.get_figwidth() * 0.0254 == pytest.approx(width)
    assert_legible(figure)


@pytest.mark.slow
def test_families_are_drawn_with_both_centres_and_differ_for_one_nodal_diameter() -> None:
    """On a broken axis: the second family above, the suspension, the first."""
    figure = plot_families(diagrams(), 2)
    panels = figure.axes
    assert [axes.texts[0].get_text() for axes in panels] == ["2F", "suspension", "1F"]
    for axes in (panels[0], panels[2]):
        free, clamped = (
            np.asarray(line.get_xydata()) for line in axes.lines if line.get_marker() == "o"
        )
        np.testing.assert_array_equal(free[:, 0], clamped[:, 0])
        assert set(free[np.abs(free[:, 1] - clamped[:, 1]) > 1e-9, 0]) == {1.0}
    (whole,) = plot_families(diagrams()).axes
    assert whole.get_yscale() == "log"


def test_the_tuned_peak_of_an_amplification_is_in_turns_in_a_minute() -> None:
    """At half of 50 Hz."""
    shares = {"amplification": (("order", "draw"), [[1.1, 1.2]]), "tuned_speed": ("order", [0.5])}
    attrs = {"reference_frequency_hz": 50.0, "whitehead_bound": 1.5, "stiffness_spread": 0.01}
    figure = plot_amplification(xr.Dataset(shares, {"order": [2]}, attrs | {"case": ""}))
    assert "tuned peak at 1500 rpm" in figure.axes[0].get_legend_handles_labels()[1][0]


def test_names_beside_lines_keep_the_order_of_the_lines_and_do_not_overlap() -> None:
    axes = new_figure(height=0.06).subplots()
    axes.set(xlim=(0.0, 2.0), ylim=(0.0, 10.0))
    heights = [9.9, 5.0, 9.8, 5.1, 9.85]
    name_ends(axes, 1.0, heights, ["e", "a", "c", "b", "d"], "black", right=True)
    new = axes.get_figure(root=True)
    assert new is not None
    new.draw_without_rendering()
    extents = [(Text.get_window_extent(text), text.get_text()) for text in axes.texts]
    boxes = sorted(extents, key=lambda extent: extent[0].y0)
    assert "".join(name for _, name in boxes) == "abcde"
    assert all(low.y1 <= high.y0 for (low, _), (high, _) in pairwise(boxes))
    assert boxes[-1][0].y1 <= axes.bbox.y1


@cache
def whirling() -> xr.Dataset:
    own = stage(effects="full")
    case_stiffness = own.case.shaft.stiffness
    springs = np.array([0.5, 1.0, 2.0]) * case_stiffness
    return bw.veering(own, families=2, stiffnesses=springs)


@pytest.mark.slow
def test_veering_at_speed_tells_waves_both_ways() -> None:
    """Branches at the case's stiffness are the whirling modes, found from other matrices."""
    own, data = stage(effects="full"), whirling()
    actual = own.listed_modes
    assert isinstance(actual, WhirlModes)
    for way in ("backward", "forward"):
        here = (actual.nodal_diameter == 1) & (np.array(actual.direction) == way)
        branches = data.isel(branch=(data["branch_direction"] == way).values)
        drawn = 2.0 * np.pi * branches["branch_frequency"].sel(stiffness=own.case.shaft.stiffness)
        size = branches.sizes["branch"]
        np.testing.assert_allclose(drawn, actual.frequency[here][:size], rtol=1e-8)
        share = branches["branch_spring_share"].sel(stiffness=own.case.shaft.stiffness)
        np.testing.assert_allclose(share, actual.spring_share[here][:size], rtol=1e-6, atol=1e-9)
        names = np.array(own.listed_modes.family)[here][:size]
        assert branches["branch_family"].values.tolist() == names.tolist()
    first = data.frequency.sel(centre="free", family="1F", nodal_diameter=1)
    assert sorted(first["direction"].values.tolist()) == ["backward", "forward"]
    for figure in (plot_families(data), plot_families(data, 2), plot_shaft_veering(data)):
        figure.draw_without_rendering()
        assert figure.get_suptitle().startswith("Fan stage")


@pytest.mark.parametrize(
    ("share", "kind", "lead"), [(0.5, "standard", 0.0), (2.0, "inverted", np.pi)]
)
def test_scenario_pictures_measure_what_they_show(share: float, kind: str, lead: float) -> None:
    own = stage()
    data = scenario_dataset(
        whirling_modes(own, casing_share=share), reference=own.reference_frequency
    )
    assert data.attrs["scenario"] == kind
    apart = np.exp(1j * (data["shaft_phase"] - data["smallest_clearance_phase"]).values)
    np.testing.assert_allclose(apart, np.exp(1j * lead), atol=0.01)
    np.testing.assert_allclose(data["smallest_clearance"], 0.0, atol=1e-8)
    # Backward in the rotating frame, at the frequency of the mode.
    turned = np.unwrap(data["shaft_phase"].values)[-1]
    assert turned == pytest.approx(-data.attrs["frequency"] * float(data["time"][-1]))
