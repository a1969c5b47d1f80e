"""Nodes that stick: Coulomb's law holds in every step, where friction exceeds the limit at which
blades lock against the wall, and where a coating presses hard."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from solid_meshes import SECTORS, STEEL, TIE, bladed_sector
from symmetric_cases import write_parts

import bladewhirl as bw
from bladewhirl.models.stage.modal_loads import Load
from bladewhirl.solvers.march.sudden_changes import make_scheme
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory
from bladewhirl.studies.verification.bodies import marched, problem, small_rotor, wall
from bladewhirl.studies.verification.contact import pad_on_a_wall

SPEED, STEP = 600.0, 5e-7


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("parts")
    write_parts(folder)
    many = bw.mesh3d(bladed_sector("hexahedron20"), **STEEL, **TIE, contacts=4, coriolis=True)
    bw.write_superelement(folder / "wheel.npz", many)
    return folder


@pytest.mark.parametrize(
    ("part", "friction", "layer"),
    [
        ("blade", 0.3, None),
        ("blade", 0.3, 4e10),
        ("blade", 1.5, None),
        ("wheel", 1.0, None),  # up to 22 nodes touch at once
    ],
)
def test_friction_holds_nodes_or_opposes_their_slip(
    parts: Path, part: str, friction: float, layer: float | None
) -> None:
    copies, amount, duration = (3, 1e-4, 8e-3) if part == "blade" else (SECTORS, 2e-4, 4e-3)
    casing: dict[str, Any] = {"type": "rigid", "clearance": 1e-4}
    casing |= {"clearance_lobes": [{"lobes": 2, "amplitude": 9e-5}]}
    casing |= {"closure": {"amount": amount, "time_constant": 0.625 * duration}}
    if layer:
        casing["coating"] = {"thickness": 2e-3, "young_modulus": layer, "yield_stress": 1e15}
    case = {
        "bladed_disk": {"superelement": {"file": str(parts / f"{part}.npz"), "copies": copies}},
        "reduction": {"free_interface_modes": 8},
        "casing": casing,
        "contact": {"friction": friction, "sliding": "full"},
        "damping": {"ratio": 0.01},
        "rotation": {"effects": "full"},
        "march": {"speed": f"{SPEED} rad/s", "time_step": STEP, "record_step": STEP},
    }
    case["march"]["duration"] = duration  # type: ignore[index]
    result, report = march_in_memory(prepare(bw.case_from(case)))
    assert report["unsolved_steps"] == 0
    force = result["contact_force"].values[1:]
    moved = np.diff(result["contact_displacement"].values, axis=0)
    around = SPEED * STEP * result["contact_radius"].values
    slip = np.stack([moved[..., 1] + around, moved[..., 2]], axis=-1)
    pressed, drag = -force[..., 0], force[..., 1:]
    touching = pressed > 1e-9 * pressed.max()
    slip, drag, limit = slip[touching], drag[touching], friction * pressed[touching]
    size, way = np.linalg.norm(drag, axis=1), np.linalg.norm(slip, axis=1)
    assert (size <= limit * (1.0 + 1e-6)).all()
    still = size < limit * (1.0 - 1e-6)
    assert still.sum() > 10
    assert (way[still] < 1e-6 * around.max()).all()
    sliding = ~still & (way > 1e-3 * around.max())
    opposite = -(drag * slip).sum(axis=1)[sliding] / (size * way)[sliding]
    assert opposite == pytest.approx(1.0, abs=1e-5)
    sums = ("external_work", "normal_work", "friction_work", "coupling_work")
    works = sum(result[name].values for name in sums) - result["damping_work"].values
    energy = result["energy"].values - result["energy"].values[0]
    assert np.abs(energy - works).max() < 1e-9 * np.abs(works).max()


def test_a_tip_under_a_load_stays_up_to_the_limit_of_friction() -> None:
    """Pulled with 0.9 and 1.1 of what friction holds: it stays, or slides."""
    base = pad_on_a_wall()
    body = replace(base.rotor, frequency=np.array([50.0, 0.0]))
    base = replace(base, rotor=body, sliding="full")
    start, moved = replace(base.start, rotor=np.array([1e-3, 0.0])), []
    for pull in (0.9, 1.1):
        load = Load(rotor=np.array([0.0, pull]), casing=np.zeros(1))
        given = replace(base, start=start, loads=(*base.loads, load))
        moved.append(marched(given, 1e-5, 100_000, every=1000).rotor_displacement[:, 1])
    assert np.abs(moved[0]).max() < 1e-8
    assert np.ptp(moved[0][1:]) == 0.0
    assert moved[1][-1] == pytest.approx(0.5 * 0.1, rel=1e-3)  # a t^2 / 2 after 1 s


@pytest.mark.parametrize("speed", [20.0, 34.0, 40.0, 50.0, 100.0])
def test_friction_of_an_impact_stops_the_slip_at_most(speed: float) -> None:
    """A unit mass thrown against a wall that slides past it at 10 m/s: the impulse of the friction
    is the smaller of that of sliding, 0.3 P, and of what stops the slip. Nothing moves axially."""
    rotor = small_rotor(
        np.array([0.0, 0.0]),
        tip_radial=np.array([[1.0, 0.0]]),
        tip_tangential=np.array([[0.0, 1.0]]),
    )
    thrown = {"rotor_velocity": np.array([speed, 0.0])}
    alone = problem(rotor, wall(1e-3), start=thrown, speed=10.0, friction=0.3, sliding="full")
    scheme = make_scheme(alone, 1e-6, 1)
    _, chunk, _ = scheme.advance(scheme.init(), 100)
    assert chunk.contact_impulse.sum() == pytest.approx(speed)
    assert chunk.friction_impulse.sum() == pytest.approx(min(0.3 * speed, 10.0))
