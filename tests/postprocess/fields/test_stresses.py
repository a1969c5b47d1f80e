"""Stresses over time: against a plain loop, their extremes, and which beams make a blade."""

import numpy as np
import pytest
import synthetic_result as synthetic
import xarray as xr

from bladewhirl.postprocess.fields.blades import line_blades, member_names
from bladewhirl.postprocess.fields.strains import casing_strain_rows, rotor_strain_rows
from bladewhirl.postprocess.run import stresses
from bladewhirl.postprocess.run.extremes import stress_split
from bladewhirl.postprocess.run.stresses import plot_stress, stress_history, utilisation


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    made = synthetic.synthetic_result(records=60, growth=3.0)
    # Another material and thickness for the blades than for the disk.
    blades = made.rotor_part.values == "blades"
    made["rotor_young_modulus"] = "rotor_line", np.where(blades, 1.1e11, 2.1e11)
    made["casing_young_modulus"] = "casing_node", np.linspace(0.7e11, 2.1e11, 40)
    # Axial strain of either sign, so that the two surfaces differ.
    moved = made["rotor_displacement"].values
    scale = np.abs(moved).max()
    shaken = np.random.default_rng(5).standard_normal(moved.shape)
    shaken *= np.linspace(0.0, 1.0, 60)[:, None]
    made["rotor_displacement"] = ("time", "rotor_mode"), moved + 0.02 * scale * shaken
    return made


def test_every_number_is_that_of_a_plain_loop(result: xr.Dataset) -> None:
    actual = stress_history(result)
    assert actual.member.values.tolist() == [
        *(f"blade {number}" for number in range(22)),
        *("spokes", "rim", "casing"),
    ]
    rotor, ring = rotor_strain_rows(result), casing_strain_rows(result, 4)
    lines = {f"blade {b}": np.arange(44 + 4 * b, 48 + 4 * b) for b in range(22)}
    lines |= {"spokes": np.arange(22), "rim": np.arange(22, 44), "casing": np.arange(40)}
    for record in (0, 17, 59):
        for name, own in lines.items():
            body, rows = ("casing", ring) if name == "casing" else ("rotor", rotor)
            q = result[f"{body}_displacement"].values[record]
            modulus = result[f"{body}_young_modulus"].values[own][:, None]
            axial, bending = rows.axial[own] @ q, rows.bending[own] @ q
            at = actual.sel(member=name).isel(time=record)
            upper = max((modulus * (axial + bending)).max(), (modulus * (axial - bending)).max())
            lower = min((modulus * (axial + bending)).min(), (modulus * (axial - bending)).min())
            assert float(at.largest_stress) == pytest.approx(upper, rel=1e-9, abs=1e-6)
            assert float(at.smallest_stress) == pytest.approx(lower, rel=1e-9, abs=1e-6)
            assert abs(float(at.axial_stress)) == pytest.approx(
                np.abs(modulus * axial).max(), rel=1e-9, abs=1e-6
            )
            assert float(at.bending_stress) == pytest.approx(
                np.abs(modulus * bending).max(), rel=1e-9, abs=1e-6
            )
            assert float(at.bending_strain) == pytest.approx(np.abs(bending).max(), rel=1e-9)
            assert abs(float(at.axial_strain)) == pytest.approx(
                np.abs(axial).max(), rel=1e-9, abs=1e-15
            )


def test_peaks_are_the_extremes_of_all_times(result: xr.Dataset) -> None:
    actual = stress_history(result)
    size = np.maximum(actual.largest_stress, -actual.smallest_stress)
    np.testing.assert_allclose(np.abs(actual.peak_stress), size.max("time"))
    at = actual.time.values[size.argmax("time").values]
    np.testing.assert_array_equal(actual.peak_time, at)
    high, low = actual.largest_stress.max("time"), actual.smallest_stress.min("time")
    np.testing.assert_allclose(actual.peak_stress, np.where(high >= -low, high, low), atol=1e-3)
    assert {*np.sign(actual.peak_stress.values)} == {-1.0, 1.0}
    # The blades bend most at their roots (w'' of the mode falls linearly to the tip).
    np.testing.assert_allclose(actual.peak_radius[:22], synthetic.DISK_RADIUS)


def test_the_split_is_that_of_a_plain_loop(result: xr.Dataset) -> None:
    """At the point with the least margin, of both surfaces of each blade."""
    limits = {"endurance": 2e8, "strength": 9e8}
    alone, limited = stress_history(result), stress_history(result.assign_attrs(limits))
    rows = rotor_strain_rows(result)
    for blade in range(22):
        own = np.arange(44 + 4 * blade, 48 + 4 * blade)
        axial, bending = (
            1.1e11 * np.einsum("epm,tm->tep", each[own], result["rotor_displacement"].values)
            for each in (rows.axial, rows.bending)
        )
        sides = np.stack([axial + bending, axial - bending])
        mean = sides.mean(axis=1)
        alternating = np.abs(sides - mean[:, None]).max(axis=1)
        used = alternating / 2e8 + np.maximum(mean, 0.0) / 9e8
        for data, worst in ((alone, (alternating + mean).argmax()), (limited, used.argmax())):
            at = data.sel(member=f"blade {blade}")
            assert float(at.mean_stress) == pytest.approx(mean.flat[worst], rel=1e-9, abs=1e-3)
            assert float(at.alternating_stress) == pytest.approx(alternating.flat[worst], rel=1e-9)
        # As severe as middle and half of the range, or more.
        middle, half = (
            0.5 * (sides.max(axis=1) + sign * sides.min(axis=1)) for sign in (1.0, -1.0)
        )
        assert (used >= half / 2e8 + np.maximum(middle, 0.0) / 9e8 - 1e-12).all()
    split = stress_split(limited)
    margin = 1.0 / utilisation(
        limited.mean_stress.values, limited.alternating_stress.values, limits
    )
    assert split is not None
    assert split["margin"] == pytest.approx(float(margin[:22].min()))
    assert split["member"] == f"blade {int(margin[:22].argmin())}"
    without = stress_split(alone)
    summed = (alone.alternating_stress + np.maximum(alone.mean_stress, 0.0)).values[:22]
    assert without is not None
    assert without["margin"] is None
    assert without["alternating"] == pytest.approx(
        float((alone.alternating_stress)[summed.argmax()])
    )


def test_portions_do_not_show(result: xr.Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = stress_history(result)
    monkeypatch.setattr(stresses, "PORTION_BYTES", 8 * 528 * 7.0)
    xr.testing.assert_allclose(stress_history(result), whole, rtol=1e-13)


def test_the_figure_shows_blades_and_the_rest(result: xr.Dataset) -> None:
    figure = plot_stress(stress_history(result))
    over_time, over_blades = figure.axes
    labels = {str(line.get_label()) for line in over_time.lines}
    assert labels >= {"blades", "casing", "spokes", "rim"}
    assert len(over_blades.patches) == 22
    axial = [line for line in over_blades.lines if line.get_marker() == "_"]
    assert [np.size(line.get_xdata()) for line in axial] == [22, 22]
    assert "Pa]" in over_time.get_ylabel()


class TestBlades:
    def test_of_the_usual_stage(self, result: xr.Dataset) -> None:
        blade = line_blades(result)
        np.testing.assert_array_equal(blade[:44], -1)
        np.testing.assert_array_equal(blade[44:], np.repeat(np.arange(22), 4))

    def test_under_a_shroud(self, result: xr.Dataset) -> None:
        tips = result.tip_node.values
        shroud = np.column_stack([tips, np.roll(tips, -1)])
        with_shroud = xr.Dataset(
            {
                **{name: result[name] for name in ("rotor_point", "tip_node")},
                "rotor_line": (
                    ("rotor_line", "end"),
                    np.vstack([shroud, result.rotor_line.values]),
                ),
                "rotor_part": ("rotor_line", ["shroud"] * 22 + list(result.rotor_part.values)),
            }
        )
        with_shroud["blade"] = np.arange(22)
        blade = line_blades(with_shroud)
        np.testing.assert_array_equal(blade[:22], -1)
        np.testing.assert_array_equal(blade[22:], line_blades(result))
        assert member_names(with_shroud)[0][22:] == ["shroud", "spokes", "rim"]
