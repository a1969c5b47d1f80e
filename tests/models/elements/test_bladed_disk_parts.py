"""What the [bladed_disk] table can describe, against closed forms, totals and drawings by hand."""

from typing import Any

import numpy as np
import pytest
from stages import natural_frequencies

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import case_from
from bladewhirl.models.case.file import loads
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.elements.build import case_beam_model, case_bladed_disk
from bladewhirl.models.geometry.beam_model import BeamModel
from bladewhirl.models.inputs.errors import CaseError


def disk(*, clamped: bool = False, **tables: Any) -> BladedDiskModel:
    """A bladed disk of six blades, as a case file would describe it."""
    case = case_from({"bladed_disk": {"blades": 6, **tables}})
    assert loads(dumps_case(case)) == case
    return case_bladed_disk(case, clamped=clamped)


def model(**tables: Any) -> BeamModel:
    return disk(**tables).model


def along_blade(shown: BeamModel, blade: int) -> FloatArray:
    """Nodes of one blade from root to tip, (nodes, 2)."""
    lines = shown.mesh.lines[shown.mesh.line_sets["blades"]]
    node = int(shown.mesh.node_sets["roots"][blade])
    tip, chain = int(shown.tips[blade]), [node]
    while node != tip:
        node = int(lines[lines[:, 0] == node, 1][0])
        chain.append(node)
    return shown.mesh.points[chain]


def test_a_taper_runs_from_root_to_tip_through_cuts() -> None:
    """Mass of a truncated wedge; a node for a shroud on the way changes none of its stations."""
    taper = [{"thickness": 0.014}, {"thickness": 0.006, "width": 0.06}]
    blade = {"disk_kind": "rigid", "taper": taper, "elements_per_blade": 9}
    plain = model(**blade)
    cut = model(**blade, point_masses=[{"radius": 0.2, "mass": 0.0}])
    area = 0.1 * 0.014 + 0.5 * (0.1 * -0.008 - 0.04 * 0.014) + (0.04 * 0.008) / 3.0
    whole = 6 * 0.45 * 7800.0 * area
    assert plain.mass == pytest.approx(whole, rel=1e-12)
    assert cut.mass == pytest.approx(whole, rel=1e-12)
    first = plain.properties.thickness[plain.mesh.line_sets["blades"]].reshape(6, 9)
    np.testing.assert_allclose(first[0], 0.014 - 0.008 * (np.arange(9) + 0.5) / 9)


def test_materials_by_name() -> None:
    case = case_from(
        {
            "material": {"named": [{"name": "ti", "young_modulus": "114 GPa", "density": 4430.0}]},
            "bladed_disk": {
                "blades": 4,
                "blade": {"material": "ti"},
                "shrouds": [{"radius": 0.4, "material": "ti"}],
            },
        }
    )
    shown = case_beam_model(case)
    parts = np.array(shown.mesh.line_parts)
    titanium = np.isin(parts, ["blades", "shrouds"])
    np.testing.assert_array_equal(shown.properties.density, np.where(titanium, 4430.0, 7800.0))
    np.testing.assert_array_equal(
        shown.properties.young_modulus, np.where(titanium, 1.14e11, 2.1e11)
    )


def test_masses_are_where_they_were_put() -> None:
    shown = model(
        tip_mass="10 g",
        point_masses=[
            {"radius": 0.0, "mass": 3.0},
            {"radius": 0.05, "mass": 0.4},
            {"radius": 0.3, "mass": 0.2, "inertia": 1e-4, "blades": [1, 4]},
        ],
    )
    bare = model()
    assert shown.mass - bare.mass == pytest.approx(3.0 + 6 * (0.01 + 0.4) + 2 * 0.2)
    radii = np.linalg.norm(shown.mesh.points[shown.masses.node], axis=1)
    by_radius = {
        radius: float(shown.masses.mass[np.isclose(radii, radius)].sum())
        for radius in (0.0, 0.05, 0.3, 0.5)
    }
    assert by_radius == pytest.approx({0.0: 3.0, 0.05: 2.4, 0.3: 0.4, 0.5: 0.06})
    angles = np.arctan2(*shown.mesh.points[shown.masses.node[np.isclose(radii, 0.3)]].T[::-1])
    np.testing.assert_allclose(np.mod(angles, 2 * np.pi), np.array([1, 4]) * np.pi / 3.0)
    assert shown.masses.inertia.sum() == pytest.approx(2e-4)


def test_a_centre_line_leans_and_curves() -> None:
    rows = [{"span": 0.5, "angle": "3 deg"}, {"span": 1.0, "angle": "12 deg"}]
    points = along_blade(model(centre_line=rows, elements_per_blade=60), 0)
    radius, angle = np.hypot(*points.T), np.degrees(np.arctan2(points[:, 1], points[:, 0]))
    assert (radius[0], angle[0]) == pytest.approx((0.05, -12.0))
    assert (radius[-1], angle[-1]) == pytest.approx((0.5, 0.0), abs=1e-12)
    assert np.interp(0.275, radius, angle) == pytest.approx(-9.0, abs=0.01)
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert lengths.std() < 1e-3 * lengths.mean()
    leaning = along_blade(model(centre_line=rows[1:]), 0)
    spans = np.diff(leaning, axis=0)
    np.testing.assert_allclose(spans, np.broadcast_to(spans[0], spans.shape), atol=1e-12)


def test_cuts_stay_on_the_centre_line() -> None:
    rows = [{"span": 0.5, "angle": 0.1}, {"span": 1.0, "angle": 0.3}]
    plain = along_blade(model(centre_line=rows, elements_per_blade=40), 2)
    cut = along_blade(model(centre_line=rows, elements_per_blade=40, shrouds=[{"radius": 0.31}]), 2)
    assert np.isclose(np.hypot(*cut.T), 0.31, rtol=1e-9).any()
    angle = np.unwrap(np.arctan2(plain[:, 1], plain[:, 0]))
    at_cut = np.interp(np.hypot(*cut.T), np.hypot(*plain.T), angle)
    np.testing.assert_allclose(np.unwrap(np.arctan2(cut[:, 1], cut[:, 0])), at_cut, atol=2e-4)


def test_shrouds_close_or_stay_open() -> None:
    section = {"width": 0.02, "thickness": 0.005}
    bare = model().mass
    per_metre = 0.02 * 0.005 * 7800.0
    chord = 2.0 * 0.4 * np.sin(np.pi / 6.0)
    closed = model(shrouds=[{"radius": 0.4, **section}])
    assert closed.mass - bare == pytest.approx(6 * chord * per_metre)
    cut = model(shrouds=[{"radius": 0.4, **section, "cuts": [5, 2]}])
    assert cut.mass - bare == pytest.approx(4 * chord * per_metre)
    assert not disk(shrouds=[{"radius": 0.4, "cuts": [5]}]).structure.is_cyclic
    arc = model(shrouds=[{"radius": 0.5, **section, "elements": 8}])
    assert arc.mass - bare == pytest.approx(2.0 * np.pi * 0.5 * per_metre, rel=1e-3)
    lines = arc.mesh.line_sets["shrouds"]
    ring = np.unique(arc.mesh.lines[lines])
    np.testing.assert_allclose(np.hypot(*arc.mesh.points[ring].T), 0.5, rtol=1e-5)


def test_rings_and_spokes_add_up() -> None:
    per_metre = 0.1 * 0.03 * 7800.0
    spokes = model(disk_kind="spokes").mass
    rigid = model(disk_kind="rigid").mass
    assert spokes - rigid == pytest.approx(6 * 0.05 * per_metre)
    whole = model(disk_rings=[{"radius": 0.04}, {"radius": 0.02, "thickness": 0.015}])
    assert whole.mass - model().mass == pytest.approx(6 * (0.04 + 0.02 / 2.0) * per_metre)
    assert len(whole.mesh.line_sets["rings"]) == 12
    assert len(whole.mesh.line_sets["spokes"]) == 18


def test_a_rim_is_joined_by_its_springs_alone() -> None:
    """With the centre held, a stiff ring of heavy blades swings on the web: 3 N/2 of each."""
    hub = [{"radius": 0.0, "mass": 10.0}]
    web = {"web_radial": 200.0, "web_tangential": 100.0}
    thick = {"width": 0.1, "thickness": 0.2}
    body = disk(disk_kind="rim", point_masses=hub, blade=thick, disk=thick, clamped=True, **web)
    mass = body.model.mass - 10.0
    actual = natural_frequencies(body)[:3]
    expected = np.sqrt(6 * (200.0 + 100.0) / 2.0 / mass)  # cos^2 and sin^2 over six roots
    assert np.isclose(actual, expected, rtol=1e-4).sum() == 2
    with pytest.raises(CaseError, match=r"a mass at radius = 0"):
        disk(disk_kind="rim")


def test_mistuning_by_lists() -> None:
    ones = [1.0] * 6
    lists = {
        "stiffness": [*ones[:5], 1.5],
        "mass": [2.0, *ones[:5]],
        "length": [1.0, 1.0, 0.998, 1.0, 1.001, 1.0],
    }
    shown, tuned = model(mistuning=lists), model()
    blades = shown.mesh.line_sets["blades"].reshape(6, 10)
    for name, blade, factor in (("young_modulus", 5, 1.5), ("density", 0, 2.0)):
        ratio = getattr(shown.properties, name) / getattr(tuned.properties, name)
        expected = np.ones(len(ratio))
        expected[blades[blade]] = factor
        np.testing.assert_allclose(ratio, expected, rtol=1e-15)
    recess = [0.0, 0.0, 0.9e-3, 0.0, -0.45e-3, 0.0]
    np.testing.assert_allclose(shown.tip_recess, recess, atol=1e-15)
    np.testing.assert_allclose(shown.mesh.lengths[blades[2]], 0.998 * 0.045)
    assert not disk(mistuning=lists).structure.is_cyclic


@pytest.mark.slow
def test_random_mistuning_comes_from_its_seed() -> None:
    def factors(**changes: Any) -> FloatArray:
        given = {"stiffness_spread": 0.03, "seed": 5} | changes
        shown = model(blades=40, mistuning=given)
        return shown.properties.young_modulus[shown.mesh.line_sets["blades"]][::10] / 2.1e11

    one = factors()
    np.testing.assert_array_equal(one, factors(mass_spread=0.1))  # streams of their own
    assert abs(one - factors(seed=6)).max() > 0.01
    np.testing.assert_allclose(one - 1.0, (factors(stiffness_spread=0.06) - 1.0) / 2.0)
    many = disk(blades=2000, elements_per_blade=1, mistuning={"mass_spread": 0.1}).model
    drawn = many.properties.density[many.mesh.line_sets["blades"]] / 7800.0
    assert drawn.mean() == pytest.approx(1.0, abs=0.01)
    assert drawn.std() == pytest.approx(0.1, rel=0.1)


BAD: list[tuple[dict[str, Any], str]] = [
    ({"shrouds": [{"radius": 0.6}]}, r"shrouds = .* radii above bladed_disk.disk_radius = 0.05"),
    ({"shrouds": [{"radius": 0.4, "cuts": [6]}]}, "blades from 0 to 5, each at most once"),
    ({"shrouds": [{"radius": 0.4}, {"radius": 0.4, "cuts": [1]}]}, "one shroud at each radius"),
    ({"point_masses": [{"radius": 0.01, "mass": 1.0}]}, "radii of 0 or from disk_radius"),
    ({"disk_rings": [{"radius": 0.05}]}, "different radii below bladed_disk.disk_radius"),
    ({"disk_rings": [{"radius": 0.02}], "disk_kind": "rigid"}, "remove the rings, or choose"),
    ({"taper": [{"material": "x"}]}, r'materials of material.named \(none\), not "x"'),
    ({"centre_line": [{"span": 0.5, "angle": 0.1}]}, "ascending spans that end with span = 1"),
    ({"mistuning": {"mass": [1.0] * 6, "mass_spread": 0.1}}, "either factors or"),
    (
        {"mistuning": {"length": [1.01] * 6}},
        "the tip of blade 0, at radius 0.5045 m, is outside by",
    ),
    (
        {"elements_per_blade": 1, "shrouds": [{"radius": 0.4}]},
        "elements_per_blade = 1: expected at least 2",
    ),
    (
        {"centre_line": [{"span": 0.9, "angle": 1.5}, {"span": 1.0, "angle": -1.5}]},
        "centre_line: expected a centre line whose radius increases",
    ),
]


@pytest.mark.parametrize(("tables", "message"), BAD)
def test_what_cannot_be_is_refused_by_key(tables: dict[str, Any], message: str) -> None:
    with pytest.raises(CaseError, match=message):
        disk(**tables)


def test_a_shroud_stays_at_its_radius_on_a_longer_blade() -> None:
    given = model(shrouds=[{"radius": 0.4}], mistuning={"length": [0.99, *[1.0] * 5]})
    nodes = np.unique(given.mesh.lines[given.mesh.line_sets["shrouds"]])
    np.testing.assert_allclose(np.linalg.norm(given.mesh.points[nodes], axis=1), 0.4, rtol=1e-14)
    tips = np.linalg.norm(given.mesh.points[given.tips], axis=1)
    np.testing.assert_allclose(tips, [0.05 + 0.99 * 0.45, *[0.5] * 5], rtol=1e-14)


def test_tips_that_reach_into_lobes_are_named() -> None:
    case = case_from(
        {
            "bladed_disk": {"blades": 3, "mistuning": {"length": [1.0, 1.001, 1.0]}},
            "casing": {"clearance_lobes": [{"lobes": 2, "amplitude": "0.6 mm"}]},
        }
    )
    with pytest.raises(CaseError, match=r"blade 1, at radius 0.50045 m, reaches into its lobes"):
        case_beam_model(case)
