"""Joints of beams whose shrouds are cut, against beams assembled in NumPy."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import bladewhirl as bw
from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray, IntArray
from bladewhirl.models.joints.build import jointed_wheel
from bladewhirl.models.joints.limits import LIMITS
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.jointed_beams import JointedBeams
from bladewhirl.postprocess.run.measures import energy_residual
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

BLADES, ORDER, FORCE = 5, 2, 20.0
ROOT, RING, TIP, ELEMENTS = 0.1, 0.35, 0.5, 5
WIDTH, BLADE, SHROUD = 0.05, 0.012, 0.008
YOUNG, DENSITY = 2.1e11, 7800.0
NORMAL = np.array([0.6, 0.8])  #: radial and tangential


def tables(**joint: Any) -> dict[str, Any]:
    """Tables of a case of blades that are clamped at their roots."""
    return {
        "bladed_disk": {
            "blades": BLADES,
            "disk_radius": ROOT,
            "tip_radius": TIP,
            "elements_per_blade": ELEMENTS,
            "disk_kind": "rigid",
            "blade": {"width": WIDTH, "thickness": BLADE},
            "shrouds": [{"radius": RING, "width": WIDTH, "thickness": SHROUD, "elements": 2}],
        },
        "shaft": {"clamped": True},
        "reduction": {"free_interface_modes": 60},
        "damping": {"ratio": 0.0},
        "casing": {"type": "rigid", "clearance": "20 mm"},
        "excitation": {"type": "engine-order", "order": ORDER, "amplitude": FORCE},
        "joint": [{"name": "shroud", "normal": [*NORMAL, 0.0], "friction": 0.3} | joint],
        "march": {"speed": "1500 rpm", "steps_per_revolution": 1024, "revolutions": 2},
    }


def beam(first: FloatArray, second: FloatArray, thickness: float) -> tuple[FloatArray, FloatArray]:
    """Stiffness and mass of a Bernoulli beam on x, y and rotation of both ends, (6, 6) each."""
    way = second - first
    s = float(np.hypot(*way))
    area, bending = WIDTH * thickness, WIDTH * thickness**3 / 12.0
    line, stretch = [0, 3], np.array([[1.0, -1.0], [-1.0, 1.0]])
    k, m = np.zeros((2, 6, 6))
    k[np.ix_(line, line)] = YOUNG * area / s * stretch
    m[np.ix_(line, line)] = DENSITY * area * s / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    across, scale = [1, 2, 4, 5], np.array([1.0, s, 1.0, s])
    bend = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    heavy = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
    k[np.ix_(across, across)] = YOUNG * bending / s**3 * scale[:, None] * bend * scale
    m[np.ix_(across, across)] = DENSITY * area * s / 420.0 * scale[:, None] * heavy * scale
    c, d = way / s
    turn = np.kron(np.eye(2), np.array([[c, d, 0.0], [-d, c, 0.0], [0.0, 0.0, 1.0]]))
    return turn.T @ k @ turn, turn.T @ m @ turn


def all_blades() -> tuple[FloatArray, FloatArray, IntArray]:
    """Stiffness and mass of all blades without joints, and the first displacement of the tip and of
    the left and the right end of each blade, (blades, 3)."""
    inner = np.linspace(ROOT, RING, 4)[1:-1]
    span = np.array([ROOT, *inner, RING, (RING + TIP) / 2.0, TIP])
    half = np.pi / BLADES
    assert len(span) == ELEMENTS + 1
    count = len(span) + 2
    k, m = np.zeros((2, 3 * BLADES * count, 3 * BLADES * count))
    named = np.zeros((BLADES, 3), dtype=np.int64)
    for b in range(BLADES):
        places = np.array([*([r, 0.0] for r in span), [RING, -half], [RING, half]])
        angle = places[:, 1] + 2.0 * half * b
        at = places[:, :1] * np.column_stack([np.cos(angle), np.sin(angle)])
        lines = [(n, n + 1, BLADE) for n in range(ELEMENTS)]
        for one, other, thickness in (*lines, (3, count - 2, SHROUD), (3, count - 1, SHROUD)):
            own = beam(at[one], at[other], thickness)
            where = (3 * (count * b + np.array([[one], [other]])) + np.arange(3)).ravel()
            k[np.ix_(where, where)] += own[0]
            m[np.ix_(where, where)] += own[1]
        named[b] = 3 * (count * b + np.array([ELEMENTS, count - 2, count - 1]))
    kept = np.flatnonzero(np.arange(len(k)) // 3 % count)  # the roots are clamped
    return k[np.ix_(kept, kept)], m[np.ix_(kept, kept)], np.searchsorted(kept, named)


class Tied(NamedTuple):
    tips: ComplexArray  #: radial and tangential displacements, (blades, 2)
    moved: ComplexArray  #: relative displacements in the joint of the first blade, (2,)
    force: ComplexArray  #: forces in this joint that hold it, (2,), normal and tangential


def tied(omega: float, held: tuple[int, ...]) -> Tied:
    """Motion in which the relative displacements of the ends of the shrouds along the normal, or
    along all directions, are zero."""
    k, m, named = all_blades()
    w, turn = ORDER * omega, 2.0 * np.pi / BLADES * np.arange(BLADES)
    force, every = np.zeros(len(k), dtype=np.complex128), np.zeros((BLADES, 2, len(k)))
    for b in range(BLADES):
        e_r = np.array([np.cos(turn[b]), np.sin(turn[b])])
        e_t = np.array([-e_r[1], e_r[0]])
        force[named[b, 0] : named[b, 0] + 2] = FORCE * np.exp(1j * ORDER * turn[b]) * e_t
        a = turn[b] + np.pi / BLADES
        frame = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
        ways = np.array([NORMAL, [-NORMAL[1], NORMAL[0]]]) @ frame
        every[b][:, named[(b + 1) % BLADES, 1] + np.arange(2)] = ways
        every[b][:, named[b, 2] + np.arange(2)] = -ways
    ways_held = min(len(held), 2)
    flat = every[:, :ways_held].reshape(-1, len(k))
    saddle = np.block([[k - w**2 * m, flat.T], [flat, np.zeros((len(flat), len(flat)))]])
    moved = np.linalg.solve(saddle, np.append(force, np.zeros(len(flat))))
    own = np.append(moved[len(k) : len(k) + ways_held], np.zeros(2 - ways_held))
    tips = moved[named[:, :1] + np.arange(2)]
    c, s = np.cos(turn), np.sin(turn)
    turned = np.stack([c * tips[:, 0] + s * tips[:, 1], -s * tips[:, 0] + c * tips[:, 1]], axis=1)
    return Tied(turned, every[0] @ moved[: len(k)], own)


@pytest.mark.parametrize(
    ("limit", "joint"),
    [
        ("free", {"gap": "50 mm"}),
        ("closed without friction", {"friction": 0.0, "preload": "10 kN"}),
        ("stuck", {"friction": 1e4, "preload": "10 kN"}),
    ],
)
def test_joints_of_beams_have_the_limits_of_beams_that_are_tied(
    limit: str, joint: dict[str, Any]
) -> None:
    given = bw.case_from(tables(**joint))
    data = bw.response(given, speeds=["1500 rpm", "900 rpm"])  # not ascending: no search of peaks
    for n, rpm in enumerate(data["rpm"].values):
        expected = tied(rpm * np.pi / 30.0, LIMITS[limit]).tips
        for k, name in enumerate(("tip_radial", "tip_tangential")):
            found = data[name].sel(limit=limit).isel(speed=n).values
            assert np.abs(found - expected[:, k]).max() < 1e-6 * np.abs(expected).max()
    motions = bw.periodic(given, speeds=["1500 rpm", "900 rpm"])
    for n, rpm in enumerate(motions["rpm"].values):
        one, exact = motions.isel(speed=n), tied(rpm * np.pi / 30.0, LIMITS[limit])
        moved = first_harmonic(one["relative_displacement"].values[:, 0])[[0, 2]]
        assert moved == pytest.approx(np.abs(exact.moved), abs=1e-6 * np.abs(exact.tips).max())
        normal = first_harmonic(one["normal_force"].values[:, 0])
        tangential = first_harmonic(one["tangential_force"].values[:, 0, 1])
        size = max(np.abs(exact.force).max(), FORCE)
        assert [normal, tangential] == pytest.approx(np.abs(exact.force), abs=1e-6 * size)


def first_harmonic(values: FloatArray) -> FloatArray:
    """Amplitude of the first harmonic of values at the instants of a period."""
    return np.asarray(np.abs(np.fft.fft(values, axis=0)[1]) * 2.0 / len(values))


def slipping(**changes: Any) -> bw.Case:
    """A case whose joints slip and open."""
    own = tables(preload="40 N")
    own["damping"], own["reduction"] = {"ratio": 0.02}, {"free_interface_modes": 20}
    own["march"] |= {"steps_per_revolution": 2048, "record_step": "0.1 ms"}
    own["excitation"] = {"type": "engine-order", "order": ORDER, "amplitude": 40.0}
    return bw.with_values(bw.case_from(own), changes)


def test_a_march_conserves_energy_and_follows_the_balance() -> None:
    data, report = march_in_memory(prepare(slipping(**{"march.revolutions": 40})))
    assert report["unsolved_steps"] == 0
    shares = data["joint_steps"].values.sum(axis=(0, 1))
    assert (shares > 0).all()
    assert energy_residual(data) < 1e-8
    stage = build_stage(slipping())
    assert isinstance(stage, JointedBeams)
    motion = bw.periodic(slipping(), speeds=["1500 rpm"])
    late = data.where(data["time"] > 39.0 / 40.0 * float(data["time"][-1]), drop=True)
    marched = late["joint_force"].values[..., 0].max()
    assert marched == pytest.approx(float(motion["largest_normal_force"].values[0, 0]), rel=2e-2)


@pytest.mark.parametrize("last", ["1500 rpm", "1800 rpm"])
def test_a_mirrored_wheel_has_the_mirrored_motion(last: str) -> None:
    march = dict.fromkeys(["march.speed", "march.steps_per_revolution", "march.revolutions"])
    march |= {"march.time_step": 2e-5, "march.duration": 0.08}
    one, other = (
        march_in_memory(prepare(slipping(**march, **changes)))[0]
        for changes in (
            {"march.speed_table": [[0.0, "1500 rpm"], [0.08, last]]},
            {
                "march.speed_table": [[0.0, "-1500 rpm"], [0.08, f"-{last}"]],
                "joint.shroud.normal": [-NORMAL[0], NORMAL[1], 0.0],
                "excitation.phase": "180 deg",
            },
        )
    )
    blade = -np.arange(BLADES) % BLADES
    moved = [each["contact_displacement"].values.reshape(-1, BLADES, 3, 3) for each in (one, other)]
    mirrored = moved[1][:, blade][:, :, [0, 2, 1]] * [1.0, -1.0, 1.0]
    assert np.abs(moved[0] - mirrored).max() < 1e-9 * np.abs(moved[0]).max()


def test_a_ring_end_opens_by_the_rotation() -> None:
    own = tables(opening_by_speed=True)
    own["march"]["speed"] = "150 rpm"  # without stiffening
    with pytest.raises(bw.CaseError, match=r"rotation\.effects"):
        jointed_wheel(build_stage(bw.case_from(own)))  # type: ignore[arg-type]
    stage = build_stage(bw.case_from(own | {"rotation": {"effects": "centrifugal"}}))
    assert isinstance(stage, JointedBeams)
    disk = stage.disk
    moved = disk.cartesian(disk.structure.static_displacement(disk.speed, follows=True)[:, None])
    left, right = (disk.mesh.node_sets[f"shroud 0 {side}"] for side in ("left", "right"))
    a = np.pi / BLADES
    frame = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    opened = NORMAL @ frame @ (moved[left[1], :2, 0] - moved[right[0], :2, 0])
    assert jointed_wheel(stage).gap == pytest.approx([opened], rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"joint.shroud.ring": 1}, r"joint\[0\]\.ring = 1: expected a row of bladed_disk.shrouds"),
        ({"joint.shroud.left": [0], "joint.shroud.right": [1]}, r"joint\[0\]\.left .*ring"),
        ({"joint.shroud.normal": [0.0, 1.0, 0.2]}, r"joint\[0\]\.normal .* in the plane"),
        ({"bladed_disk.shrouds": None}, "row of bladed_disk.shrouds"),
        ({"contact.foreshortening": True}, r"contact\.foreshortening"),
        ({"reduction.free_interface_modes": 200}, r"reduction\.free_interface_modes"),
    ],
)
def test_what_does_not_fit_is_refused(changes: dict[str, Any], expected: str) -> None:
    with pytest.raises(bw.CaseError, match=expected):
        build_stage(bw.with_values(bw.case_from(tables()), changes))


def test_modes_of_blades_of_the_same_frequency_are_orthonormal() -> None:
    stage = build_stage(bw.case_from(tables()))
    assert isinstance(stage, JointedBeams)
    shapes, mass = stage.reduced.shapes, stage.part.mass
    assert shapes is not None
    unit = shapes.T @ (mass @ shapes)
    assert np.abs(unit - np.eye(len(unit))).max() < 1e-9


def test_an_exported_wheel_has_the_same_joints(tmp_path: Path) -> None:
    given = slipping()
    stage = build_stage(given)
    file = tmp_path / "wheel.npz"
    bw.write_superelement(file, stage.to_superelement())
    with pytest.raises(bw.UserError, match=r"\[\[joint\]\]"):
        stage.to_superelement("blade")
    omega = stage.speed / (2.0 * np.pi)
    other = bw.with_values(
        given,
        {
            "bladed_disk": {"superelement": {"file": str(file)}},
            "march.speed": f"{omega!r} Hz",
            "shaft.clamped": None,
        },
    )
    one, two = (march_in_memory(prepare(each))[0]["joint_force"].values for each in (given, other))
    assert np.abs(one - two).max() < 1e-6 * np.abs(one).max()
