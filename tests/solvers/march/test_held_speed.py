"""A speed that varies, of blades whose states of steady rotation differ in shape: every output of a
held speed is that of the constant speed, and a run-up is that of all unknowns."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from solid_meshes import Array
from symmetric_cases import marched, write_parts

import bladewhirl as bw
from bladewhirl.models.superelements.superelement import dense
from bladewhirl.models.superelements.wheel import whole_wheel
from bladewhirl.postprocess.fields.point_stresses import VON_MISES, PointStresses

HELD, LATER = 1200.0, 1500.0  #: speed that is held, and that of the modes [rad/s]


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("parts")
    write_parts(folder)
    return folder


def case(folder: Path, kind: str, copies: int, march: dict[str, Any], **more: Any) -> Any:
    table = {"file": str(folder / f"{kind}.npz"), "kind": kind, "copies": copies}
    load = {"type": "engine-order", "order": [2], "amplitude": 30.0, "phase": 0.3}
    given = {
        "bladed_disk": {"superelement": table},
        "rotation": {"effects": "full"},
        "casing": {"type": "rigid", "clearance": 5e-3},
        "damping": {"ratio": 0.01},
        "excitation": load,
        "reduction": {"free_interface_modes": 20 if kind == "blade" else 12},
        "march": {"time_step": 2.5e-7, "duration": 6e-3, "record_step": 1e-5, **march},
    }
    return given | more


def steady(part: Any, speed: float) -> Array:
    """Displacements of all unknowns in the state of steady rotation."""
    stiffness = dense(part.at(speed).stiffness)
    return np.asarray(np.linalg.solve(stiffness, speed**2 * part.centrifugal_load))


def moved_by(result: Any) -> Array:
    """Displacements of the points of the first copy, (time, 3p)."""
    modes = result["point_shape"].shape[-1]
    motion = np.asarray(result["rotor_displacement"])[:, :modes]
    return np.asarray(motion @ result["point_shape"].values.reshape(-1, modes).T)


@pytest.mark.parametrize(
    ("kind", "copies", "boundary"),
    [
        ("blade", 2, "massless"),
        pytest.param("sector", 12, "massless", marks=pytest.mark.slow),
        ("blade", 2, "consistent"),
    ],
)
def test_every_output_of_a_held_speed_is_that_of_the_constant_speed(
    parts: Path, kind: str, copies: int, boundary: str
) -> None:
    part: Any = bw.read_superelement(parts / f"{kind}.npz")
    point = int(np.hypot(*(part.points - part.points.mean(axis=0)).T[:2]).argmin())
    sensors = [{"type": "strain", "name": "g", "point": point, "direction": [1.0, 0.2, 0.1]}]
    table = [["0 s", f"{HELD} rad/s"], ["1 s", f"{HELD} rad/s"], ["2 s", f"{LATER} rad/s"]]
    more: dict[str, Any] = {"sensor": sensors}
    if boundary == "consistent":
        more["reduction"] = {"boundary": boundary, "fixed_interface_modes": 20}
    limit = 2e-2 if boundary == "consistent" else 3e-3  # whose damping is shared with the boundary
    constant, held = (
        marched(case(parts, kind, copies, march, **more))
        for march in ({"speed": f"{HELD} rad/s"}, {"speed_table": table})
    )
    whole = part if kind == "blade" else whole_wheel(part, copies)
    now, later = steady(whole, HELD), steady(whole, LATER)
    assert np.abs(now - later).max() > 0.2 * np.abs(now).max()

    def apart(one: Any, other: Any) -> Array:
        """The difference of two histories, which has to be constant."""
        found = np.asarray(one) - np.asarray(other)
        scale = np.ptp(np.asarray(other), axis=0).max()
        assert np.abs(found - found[0]).max() < limit * scale
        return np.asarray(found[0])

    contact = np.asarray(held["contact_displacement"])[:, : whole.contacts]
    moved = apart(contact, constant["contact_displacement"][:, : whole.contacts])
    exact = (whole.contact_rows @ (now - later)).reshape(-1, 3)
    np.testing.assert_allclose(moved, exact, atol=2e-5 * np.abs(exact).max())

    shift = apart(moved_by(held), moved_by(constant))
    exact = np.asarray(whole.recovery @ (now - later))
    np.testing.assert_allclose(shift, exact, atol=2e-5 * np.abs(exact).max())

    every = np.arange(held.sizes["time"])
    stress, expected = (PointStresses(each).at(every) for each in (held, constant))
    np.testing.assert_allclose(stress, expected, atol=limit * expected.max())
    still = (np.asarray(whole.stress_recovery @ now).reshape(-1, 6) @ VON_MISES.T) ** 2
    still_stress = np.sqrt(still.sum(axis=1))
    assert expected[0, : len(still_stress)] == pytest.approx(still_stress, rel=1e-4)

    strains = [
        bw.sensors(each)["g"].values.reshape(held.sizes["time"], -1) for each in (held, constant)
    ]
    apart(*strains)
    timing = [bw.tip_timing(each, 0.0)["deflection"].values for each in (held, constant)]
    late = timing[0].ravel()[0] - timing[1].ravel()[0]
    assert late == pytest.approx(moved[:, 1].mean(), rel=0.02)
    # Energy and work of the loads are those from the state at the fastest speed.
    stored = [(each["energy"] - each["external_work"]).values[:, None] for each in (held, constant)]
    apart(*stored)
    apart(*(each["damping_work"].values[:, None] for each in (held, constant)))


@pytest.mark.slow
def test_a_run_up_of_a_blade_is_that_of_all_unknowns(parts: Path) -> None:
    """Newmark on all unknowns with the matrices and the loads of every instant."""
    part: Any = bw.read_superelement(parts / "blade.npz")
    first, last, begin, end, duration = 600.0, 1500.0, 4e-4, 4e-3, 5e-3
    run_up = {"from": f"{first} rad/s", "to": f"{last} rad/s", "start": begin, "end": end}
    given = case(parts, "blade", 1, {"run_up": run_up, "duration": duration})
    given |= {"excitation": {"type": "none"}, "reduction": {"free_interface_modes": 10}}
    result = marched(given)
    course = bw.case_from(given).march.course(1.0)
    assert course is not None
    mass, rest = dense(part.mass), dense(part.stiffness)
    squares, shapes = la.eigh(rest, mass)
    root = mass @ shapes
    loss = np.asarray(0.02 * (root * np.sqrt(squares)) @ root.T)
    coriolis = dense(part.gyroscopic)

    def at(time: float) -> tuple[Array, Array, Array]:
        """Stiffness, velocity matrix and force."""
        speed, rate = float(course.speed(time)), float(course.acceleration(time))
        stiffness = dense(part.at(speed).stiffness) + 0.5 * rate * coriolis
        force = speed**2 * part.centrifugal_load + rate * part.euler_load
        return stiffness, loss + speed * coriolis, np.asarray(force)

    step, records = 1e-5, []
    stiffness, velocity, force = at(0.0)
    x: Any = np.linalg.solve(stiffness, force)
    v: Any = np.zeros_like(x)
    a = v
    for n in range(round(duration / step) + 1):
        records.append(part.contact_rows @ x)
        stiffness, velocity, force = at((n + 1) * step)
        ahead, faster = x + step * v + step**2 / 4.0 * a, v + step / 2.0 * a
        effective = mass + step / 2.0 * velocity + step**2 / 4.0 * stiffness
        a = np.linalg.solve(effective, force - velocity @ faster - stiffness @ ahead)
        x, v = ahead + step**2 / 4.0 * a, faster + step / 2.0 * a
    exact = np.array(records) - part.contact_rows @ steady(part, last)
    moved = result["contact_displacement"].values.reshape(len(exact), -1)
    assert np.abs(moved - exact).max() < 1e-3 * np.abs(exact).max()
