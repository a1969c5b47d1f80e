"""Resonances along a swept speed: those that the matrices by nodal diameter give."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from exported_stages import Kind, beams, exported
from long_cases import slow_except
from sweep_work import in_process
from synthetic_result import ROTOR_FREQUENCY, synthetic_result

import bladewhirl as bw
from bladewhirl.postprocess.fields.by_blade import ANY, natural_modes
from bladewhirl.postprocess.sweep.figures import SweepFigures
from bladewhirl.postprocess.sweep.interaction import ORDERS, interaction
from bladewhirl.postprocess.sweep.nodes import ORDERS as SPECTRAL_ORDERS
from bladewhirl.postprocess.sweep.nodes import node_spectra

SPEEDS = (0.11, 0.6)
KINDS = ("sector", "blade", "wheel", "beams")


def case_of(kind: str, folder: Path) -> bw.Case:
    """A short march without contact of a small stage of beams, or of its matrices."""
    whole: Kind = "wheel" if kind == "beams" else kind  # type: ignore[assignment]
    own = beams(whole)
    march = {"speed": 0.2, "time_step": 1e-6, "duration": 2e-3, "record_step": 1e-5}
    if kind == "beams":
        given = {f"march.{key}": value for key, value in march.items()}
        return bw.with_values(own, {**given, "reduction.fixed_interface_modes": 35})
    modes = {"free_interface_modes": 20 if kind == "wheel" else 4}  # with the suspension
    return exported(own, whole, folder, march=march, reduction=modes)


@pytest.fixture(scope="module", params=slow_except(KINDS, "sector", "beams"))
def swept(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder = tmp_path_factory.mktemp(request.param)
    case, made = case_of(request.param, folder), folder / "swept"
    with in_process():
        over = {"march.speed": SPEEDS, "casing.clearance": (2e-3, 3e-3)}
        assert bw.run_sweep(case, over, made).done == 4
    with bw.open_sweep(made) as sweep:
        yield case, sweep.load()


def expected(case: bw.Case, orders: range) -> np.ndarray:
    """Order, normalised speed and frequency [Hz] of each resonance within the sweep, from the waves
    of each nodal diameter."""
    diagram = bw.campbell(case, orders=list(orders), families=6, speeds=(0.0, 1.0))
    order, turns = diagram["resonance_order"].values, diagram["resonance_free_rpm"].values / 60.0
    rows = np.column_stack([order, diagram["resonance_free"].values, order * turns])
    rows = rows[(rows[:, 1] > SPEEDS[0]) & (rows[:, 1] < SPEEDS[-1])]
    return rows[np.lexsort(rows.T[::-1])]


def drawn(data: xr.Dataset, **row: int) -> np.ndarray:
    """Rows as those of `expected`, of one row of a figure."""
    names = ("resonance_order", "resonance_at", "resonance_frequency")
    rows = np.column_stack([data[name].values for name in names])
    rows = rows[np.all([data[f"resonance_{name}"] == place for name, place in row.items()], axis=0)]
    return rows[np.lexsort(rows.T[::-1])]


def test_drawn_pairs_are_those_of_the_waves(swept: tuple[bw.Case, xr.Dataset]) -> None:
    case, sweep = swept
    pairs = expected(case, ORDERS)
    assert len(pairs) >= 3
    data = interaction(sweep, "march_speed")
    for across in (0, 1):
        np.testing.assert_allclose(drawn(data, line=0, across=across), pairs, rtol=1e-6)
    assert interaction(sweep, "casing_clearance").sizes["resonance"] == 0


def test_rings_stand_where_an_order_meets_its_diameter(swept: tuple[bw.Case, xr.Dataset]) -> None:
    case, sweep = swept
    if "contact_spectrum" not in sweep:
        pytest.skip("beams have spectra of the shaft")
    figure, data = SweepFigures(sweep).draw("node-spectra")
    pairs = expected(case, SPECTRAL_ORDERS)
    np.testing.assert_allclose(drawn(data, line=0), pairs, rtol=1e-6)
    (rings,) = (line for line in figure.axes[0].lines if line.get_marker() == "o")
    hertz = 1e3 if "kHz" in figure.get_supylabel() else 1.0
    places = np.array(rings.get_xydata()) * [1.0, hertz]
    order = [np.argsort(each[:, 0]) for each in (places, pairs[:, 1:])]
    np.testing.assert_allclose(places[order[0]], pairs[order[1], 1:], rtol=1e-6)
    assert node_spectra(sweep, "march_speed").sizes["line"] == 2


def test_natural_modes_are_in_hertz_with_pairs_once() -> None:
    result = synthetic_result(records=3)
    frequency, diameter = natural_modes(result)
    first = np.abs(ROTOR_FREQUENCY[[3, 0, 2]]) / (2.0 * np.pi)
    np.testing.assert_allclose(frequency, first)
    assert diameter.tolist() == [1, 1, 0]  # bending, translation, rotation
    waves = {"rotor_backward_frequency": ("rotor_mode", 1.1 * ROTOR_FREQUENCY)}
    np.testing.assert_allclose(natural_modes(result.assign(waves))[0], 1.1 * first)


def test_separate_blades_have_no_diameter() -> None:
    """The modes of the first of two copies are returned."""
    result = xr.Dataset(
        {
            "rotor_frequency": ("rotor_mode", 2.0 * np.pi * np.array([80.0, 30.0, 81.0, 31.0])),
            "copied": ("copy", [0, 1]),
        }
    )
    frequency, diameter = natural_modes(result)
    np.testing.assert_allclose(frequency, [30.0, 80.0])
    assert diameter.tolist() == [ANY, ANY]
