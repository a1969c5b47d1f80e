"""Stability of a shaft line: onset of growth by internal damping and by cross terms."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from solid_meshes import STEEL, fan_sector

from bladewhirl.models.case.case import case_from
from bladewhirl.models.shaft_line.axial import axial_modes
from bladewhirl.models.shaft_line.growth import Growth, borders, growth
from bladewhirl.models.shaft_line.line import LineModel, line_model
from bladewhirl.models.shaft_line.whirl import line_critical_speeds, line_modes
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.superelements.file import write_superelement

E, MASS, LOSS = 2.1e11, 20.0, 1e-5
SHAFT: dict[str, Any] = {"length": 1.0, "outer_diameter": 0.05, "elements": 4}
RIGID = tuple({"position": z, "stiffness": 1e13} for z in (0.0, 1.0))
SOFT = tuple({"position": z, "stiffness": 2e7} for z in (0.0, 1.0))


def disk_on_springs(loss_time: float, **bearing: Any) -> LineModel:
    """A mass on a massless shaft, with a bearing at its place."""
    disk = {"position": 0.5, "mass": MASS, "polar_inertia": 0.0, "diametral_inertia": 0.0}
    at_disk = {"position": 0.5, "stiffness": 0.0} | bearing
    table = {"segments": [SHAFT], "disks": [disk], "bearings": [*RIGID, at_disk]}
    light = {"young_modulus": E, "density": 1e-3}
    return line_model(
        case_from({"material": light, "shaft_line": table | {"loss_time": loss_time}})
    )


def over(line: LineModel, highest: float) -> list[Growth]:
    return [growth(line, omega) for omega in np.linspace(0.0, highest, 12).tolist()]


@pytest.mark.parametrize("damping", [0.0, 100.0, 1000.0])
def test_internal_damping_destabilises_above_the_speed_of_the_closed_form(damping: float) -> None:
    """W = w (1 + c_e / c_i) with the external damping c_e, and c_i = t k of the shaft."""
    line = disk_on_springs(LOSS, damping=damping)
    w = line.reference_frequency
    expected = w * (1.0 + damping / (LOSS * MASS * w**2))
    [onset] = borders(line, over(line, 2.5 * expected))
    assert onset.speed == pytest.approx(expected, rel=1e-6)
    assert onset.eigenvalue.imag == pytest.approx(w, rel=1e-6)
    assert onset.direction == "forward"
    assert growth(line, 0.999 * expected).eigenvalue.real < 0.0


@pytest.mark.parametrize("cross", [3e4, -3e4])
def test_cross_terms_let_whirl_grow_at_all_speeds(cross: float) -> None:
    """m s^2 + c s + k - i k_xy = 0, where k_xy = -k_yx > 0 drives forward whirl."""
    line = disk_on_springs(0.0, stiffness=[[0.0, cross], [-cross, 0.0]], damping=50.0)
    w = line.reference_frequency
    roots = np.roots([MASS, 50.0, MASS * w**2 - 1j * cross])
    expected = roots[roots.real.argmax()]
    found = over(line, 3.0 * w)
    assert borders(line, found) == []
    for each in found[1:]:
        assert each.eigenvalue.real == pytest.approx(expected.real, rel=1e-3)
        assert each.direction == ("forward" if cross > 0.0 else "backward")


def wheel_on_line(folder: Path, **line: Any) -> LineModel:
    solid: Any = {**STEEL, "left": "left", "right": "right", "copies": 5, "hub": "root"}
    write_superelement(folder / "fan.npz", mesh3d(fan_sector(5), stress=False, **solid))
    table = {"segments": [SHAFT], "bearings": SOFT, "wheel": {"position": 0.4}} | line
    case = {"bladed_disk": {"superelement": {"file": str(folder / "fan.npz")}}}
    return line_model(case_from(case | {"shaft_line": table}), 2000.0)


@pytest.mark.parametrize("wheel", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_without_other_damping_growth_begins_at_the_first_critical_speed(
    wheel: bool, tmp_path: Path
) -> None:
    """Round lines do not bend over time in their axes in synchronous whirl."""
    if wheel:
        line = wheel_on_line(tmp_path, loss_time=LOSS)
    else:
        table = {"segments": [SHAFT], "bearings": SOFT, "loss_time": LOSS}
        line = line_model(case_from({"shaft_line": table}))
    critical = line_critical_speeds(line, 4)
    first = critical.speed[critical.direction.index("forward")]
    [onset] = borders(line, over(line, 1.5 * first))
    assert onset.speed == pytest.approx(first, rel=1e-9)
    assert onset.eigenvalue.imag == pytest.approx(first, rel=1e-9)


def test_static_damping_of_bearings_postpones_growth() -> None:
    """Unequal bearings, too; at the border one eigenvalue has no real part."""
    unequal = [row | {"stiffness": [[2e7, 0.0], [0.0, 1e7]], "damping": 2e2} for row in SOFT]
    onsets = []
    for bearings in (SOFT, unequal):
        table = {"segments": [SHAFT], "bearings": bearings, "loss_time": LOSS}
        line = line_model(case_from({"shaft_line": table}))
        [onset] = borders(line, over(line, 9.0 * line.reference_frequency))
        real = line_modes(line, onset.speed, 4).eigenvalue.real
        assert abs(real).min() < 1e-6 < abs(real).max()
        onsets.append(onset.speed / line.reference_frequency)
    assert all(later > 1.5 * first for first, later in pairwise(onsets))


def test_motions_without_dampers_neither_grow_nor_decay(tmp_path: Path) -> None:
    line = wheel_on_line(tmp_path, axial={"position": 0.0, "stiffness": 1e7})
    for omega in (0.0, 400.0):
        modes, axial = line_modes(line, omega, 12), axial_modes(line, omega)
        assert not modes.eigenvalue.real.any()
        assert not axial.eigenvalue.real.any()
        assert len(axial.eigenvalue) > 4
        assert growth(line, omega).eigenvalue.real == 0.0
