"""Every figure that a command writes, for both widths of print: sweeps, branches, periodic motions,
modal studies, joints and shaft lines."""

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer
from legible import assert_legible
from matplotlib.figure import Figure

import bladewhirl as bw
from bladewhirl.postprocess.plotting.registry import BRANCH_FIGURES, SWEEP_FIGURES
from bladewhirl.postprocess.plotting.style import COLUMN_WIDTH, FULL_WIDTH, at_width
from bladewhirl.postprocess.run.figures import RunFigures

pytestmark = [pytest.mark.slow, pytest.mark.pictures]
EXAMPLES = Path(__file__).parents[3] / "examples"
WIDTHS = pytest.mark.parametrize("width", [COLUMN_WIDTH, FULL_WIDTH])
SPEEDS = ["--over", "march.speed=0.95:1.1:0.05"]
COATING = 'casing.coating={thickness="2 mm",young_modulus=1e9,yield_stress=1e6,hardening=5e6}'
SWEEPS = {  # example, and options of `bladewhirl sweep`
    "beams": ("imbalance", [*SPEEDS, "--set", "march.duration=0.1", "--set", COATING]),
    "18 beams over two keys": (
        "imbalance",
        [
            *SPEEDS,
            *("--over", "contact.friction=0.05,0.15", "--set", "march.duration=0.05"),
            *("--set", "bladed_disk.blades=18"),
        ],
    ),
    "draws": (
        "casing_distortion",
        [
            *SPEEDS,
            *("--draws", "3", "--perturb", "excitation.modal_force = 1e-6"),
            *("--set", "march.duration=0.05"),
        ],
    ),
    "blade over two keys": (
        "twisted_blade",
        [
            *("--over", "march.speed=6500 rpm:7500 rpm:500 rpm"),
            *("--over", "casing.clearance=0.25 mm,0.35 mm", "--set", "march.duration=0.02"),
        ],
    ),
}
ROTOR = """
title = "A rotor on two bearings"
[shaft_line]
segments = [{ length = "1 m", outer_diameter = "50 mm", elements = 4 }]
disks = [{ position = 0.4, mass = 20, polar_inertia = 0.3, diametral_inertia = 0.16 }]
bearings = [
    { name = "front", position = 0.0, stiffness = "20 MN/m", damping = "1 kN s/m" },
    { position = "1 m", stiffness = [["20 MN/m", 0], [0, "10 MN/m"]], damping = "1 kN s/m" },
]
unbalance = [{ position = 0.4, unbalance = "1 kg mm" }]
[march]
speed = "3000 rpm"
"""
STUDIES = [
    ("casing_distortion", "modes", []),
    ("casing_distortion", "campbell", ["--operating", "0.9:1.2"]),
    ("casing_distortion", "veering", []),
    ("spinning_fan", "modes", []),
    ("spinning_fan", "campbell", []),
    ("spinning_fan", "critical-speeds", []),
    ("engine_order", "response", []),
    ("fan_stage", "stability", ["--no-films"]),
    ("twisted_blade", "modes", []),
    ("twisted_blade", "campbell", []),
    ("bladed_disk", "modes", []),
    ("bladed_disk", "campbell", []),
    ("overhung_fan", "modes", []),
    ("overhung_fan", "campbell", ["--speeds", "0:1.2"]),
    ("overhung_fan", "response", ["--speeds", "6000 rpm:12000 rpm:200 rpm"]),
    ("overhung_fan", "stability", ["--speeds", "0:1.2:0.3"]),
    ("shrouded_blade", "periodic", ["--speeds", "2900 rpm,3000 rpm,3100 rpm"]),
    ("shrouded_blade", "periodic", ["--speeds", "3000 rpm"]),
    ("shrouded_blade", "periodic", ["--over", "joint.shroud.preload=30:34", "--points", "8"]),
    ("shrouded_blade", "periodic", ["--over", "march.speed=2900rpm:3100rpm", "--points", "8"]),
    ("rotor", "modes", ["--count", "6"]),
    ("rotor", "campbell", ["--speeds", "0:4"]),
    ("rotor", "stability", []),
    ("rotor", "response", ["--speeds", "600 rpm:15000 rpm:100 rpm"]),
]


def assert_whole_blades(figure: Figure) -> None:
    """Assert that the ticks of axes of blades and of pairs of nodes are whole numbers."""
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            label = axis.get_label_text()
            if label in ("blade", "joint after blade", "pair of joint nodes"):
                ticks = axis.get_majorticklocs()
                assert not (ticks % 1.0).any(), f"{label}: {ticks}"


@pytest.fixture
def written(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the figures that commands write in this test, with the faults that were found."""
    names = list[str]()

    def check(figure: Figure, path: Path, *_: Any, **__: Any) -> list[Path]:
        try:
            assert_legible(figure)
            assert_whole_blades(figure)
        except AssertionError as fault:
            names.append(f"{path.name}: {fault}")
        else:
            names.append(path.name)
        return []

    monkeypatch.setattr("bladewhirl.studies.runs.figures_folder.save_figure", check)
    return names


@pytest.fixture(scope="module")
def sweep(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of one of the sweeps."""
    example, words = SWEEPS[request.param]
    folder = tmp_path_factory.mktemp("sweep") / "out"
    workers = "--workers", str(os.cpu_count())
    answer("sweep", EXAMPLES / f"{example}.toml", *words, *workers, "-o", folder)
    return folder


@pytest.mark.parametrize("sweep", SWEEPS, indirect=True)
@WIDTHS
def test_of_sweeps(sweep: Path, width: float, written: list[str]) -> None:
    with at_width(width):
        answer("plot", sweep, "all")
    assert len(written) >= 6
    assert set(written) <= set(SWEEP_FIGURES)  # no faults


@WIDTHS
@pytest.mark.parametrize(("example", "command", "words"), STUDIES)
def test_of_modal_studies(
    example: str,
    command: str,
    words: list[str],
    width: float,
    written: list[str],
    tmp_path: Path,
) -> None:
    case = EXAMPLES / f"{example}.toml"
    if example == "rotor":
        case = tmp_path / "rotor.toml"
        case.write_text(ROTOR)
    with at_width(width):
        answer(command, case, *words, "-o", tmp_path / "out")
    assert written
    assert not [name for name in written if ":" in name]


@WIDTHS
def test_of_a_run_up_of_a_shaft_line(width: float, written: list[str], tmp_path: Path) -> None:
    case, folder = tmp_path / "rotor.toml", tmp_path / "out"
    case.write_text(ROTOR)
    speeds = "march.run_up={from='1200 rpm',to='3000 rpm',start=0.01,end=0.15}"
    steps = ("march.time_step=8e-6", "march.record_step=2e-4", "march.duration=0.2")
    changes = [word for each in (speeds, *steps) for word in ("--set", each)]
    answer("run", case, *changes, "-o", folder, "--frames", "0")
    written.clear()
    with at_width(width):
        answer("plot", folder, "all")
    assert {"run-up", "line-orbits", "line-bearing-forces"} <= set(written)
    assert not [name for name in written if ":" in name]


OVAL = """
title = "A twisted blade in an oval wall"
[bladed_disk.superelement]
file = "FILE"
[reduction]
free_interface_modes = 20
[damping]
ratio = 0.01
[casing]
type = "rigid"
clearance = "0.35 mm"
closure = { amount = "0.1 mm", time_constant = "1 ms" }
profile = { harmonics = [{ lobes = 2, amplitude = "0.27 mm" }] }
[contact]
friction = 0.05
sliding = "full"
[march]
speed = "7000 rpm"
time_step = "1 us"
"""


@WIDTHS
def test_of_branches(width: float, written: list[str], tmp_path: Path) -> None:
    """Two branches, one laid over the other, and their backbone."""
    case, folders = tmp_path / "oval.toml", [tmp_path / "one", tmp_path / "two"]
    case.write_text(OVAL.replace("FILE", str(EXAMPLES / "twisted_blade.npz")))
    over = ["--over", "march.speed=6900rpm:7100rpm", "--points", "6"]
    for folder, friction in zip(folders, ("0.05", "0.1"), strict=True):
        answer("periodic", case, *over, "--set", f"contact.friction={friction}", "-o", folder)
    written.clear()
    with at_width(width):
        answer("plot", folders[0], "all")
        answer("plot", folders[0], "backbone", "--with", folders[1])
    assert set(written) == set(BRANCH_FIGURES)


@WIDTHS
@pytest.mark.parametrize(
    ("example", "time", "names"),
    [
        ("shrouded_blade", "0.05", {"joints"}),
        ("overhung_fan", "0.02", {"line-orbits", "line-bearing-forces", "card"}),
    ],
)
def test_of_runs_with_joints_and_on_a_shaft_line(
    example: str, time: str, names: set[str], width: float, written: list[str], tmp_path: Path
) -> None:
    folder, changes = tmp_path / "out", ["--set", f"march.duration={time}"]
    answer("run", EXAMPLES / f"{example}.toml", *changes, "-o", folder, "--frames", "0")
    written.clear()
    with at_width(width):
        answer("plot", folder, "all")
    assert names <= set(written)
    assert not [name for name in written if ":" in name]


def test_loops_and_states_of_joints_are_those_of_the_result(tmp_path: Path) -> None:
    """Each drawn line is the force over the displacement of a pair along its larger tangent, and
    each cell of the map the state of most steps, counted here by themselves."""
    folder = tmp_path / "out"
    changes = ["--set", "march.duration=0.05"]
    answer("run", EXAMPLES / "shrouded_blade.toml", *changes, "-o", folder, "--frames", "0")
    with bw.open_result(folder) as result:
        loops, states = RunFigures(result).draw("joints")[0].axes[:2]
        records = len(np.asarray(loops.lines[0].get_xydata()))
        turns = 50.0 * float(result["time"][-1] - result["time"][-records])
        assert turns == pytest.approx(2.0, abs=0.01)
        late = slice(-records, None)
        moved = result["joint_displacement"].values[late]
        force, steps = (result[f"joint_{name}"].values[late] for name in ("force", "steps"))
        for line in loops.lines:
            blade = int(str(line.get_label()).split()[-1])
            pair = result["joint_blade"].values.tolist().index(blade)
            main = 1 + np.ptp(moved[:, pair, 1:], axis=0).argmax()
            place, drawn = np.asarray(line.get_xydata()).T
            np.testing.assert_allclose(place, 1e6 * moved[:, pair, main])
            np.testing.assert_array_equal(drawn, force[:, pair, main])
        (cells,) = states.collections
        most = steps.argmax(axis=2)[1:].T
        np.testing.assert_array_equal(np.asarray(cells.get_array()).reshape(most.shape), most)
