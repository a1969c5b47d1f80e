"""Every figure that a command writes, for both widths of print: sweeps, branches, modal studies."""

import os
from pathlib import Path
from typing import Any

import pytest
from command_line import answer
from legible import assert_legible
from matplotlib.figure import Figure

from bladewhirl.postprocess.plotting.registry import SWEEP_FIGURES
from bladewhirl.postprocess.plotting.style import COLUMN_WIDTH, FULL_WIDTH, at_width

pytestmark = pytest.mark.slow
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
    ("rotor", "modes", ["--count", "6"]),
    ("rotor", "campbell", ["--speeds", "0:4"]),
    ("rotor", "stability", []),
    ("rotor", "response", ["--speeds", "600 rpm:15000 rpm:100 rpm"]),
]


@pytest.fixture
def written(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the figures that commands write in this test, with the faults that were found."""
    names = list[str]()

    def check(figure: Figure, path: Path, *_: Any, **__: Any) -> list[Path]:
        try:
            assert_legible(figure)
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
