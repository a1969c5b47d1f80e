"""The registry of figures, and the functions of `bladewhirl.plot` that draw them."""

from pathlib import Path

import pytest
from command_line import loaded
from matplotlib.figure import Figure
from synthetic_result import synthetic_result
from synthetic_sweep import synthetic_sweep

import bladewhirl as bw
from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.plotting.registry import (
    BRANCH_FIGURES,
    RUN_FIGURES,
    SWEEP_FIGURES,
    FigureKind,
)


def test_importing_the_registry_imports_no_plotting_library() -> None:
    assert not {"numpy", "matplotlib", "xarray"} & loaded("import bladewhirl.plot")


@pytest.mark.parametrize(
    "kind", [*RUN_FIGURES.values(), *SWEEP_FIGURES.values(), *BRANCH_FIGURES.values()]
)
def test_captions_are_sentences(kind: FigureKind) -> None:
    assert kind.about[0].isupper()
    assert not kind.about.endswith(".")
    assert "\n" not in kind.about
    assert kind.caption.endswith(".")


def test_captions_of_reports_speak_of_what_is_drawn() -> None:
    works = RUN_FIGURES["work"]
    split = "is split into the work that is lost when a tip is stopped"
    assert split in works.caption
    assert split in works.caption_of({"normal", "closing"})
    assert split not in works.caption_of({"normal"})
    wear = RUN_FIGURES["wear"]
    assert "Only for a casing with a coating." in wear.caption
    assert "Only for" not in wear.caption_of({"depth"})


def test_every_figure_has_a_documented_function() -> None:
    names = {name.replace("-", "_") for name in (*RUN_FIGURES, *SWEEP_FIGURES)}
    of_modes = {"campbell", "critical_speeds", "response", "veering", "shaft_veering"}
    of_modes |= {name.replace("-", "_") for name in BRANCH_FIGURES}
    assert set(bw.plot.__all__) == names | of_modes
    for name in names | of_modes:
        function = getattr(bw.plot, name)
        assert function.__name__ == name
        assert function.__doc__


@pytest.mark.slow
def test_runs_and_sweeps_are_distinguished(tmp_path: Path) -> None:
    run = synthetic_result(shaft_radius=1.2e-3, records=1001)
    figure = bw.plot.whirl(run, start=0.02)
    assert isinstance(figure, Figure)
    assert figure.axes[1].get_ylabel() == "radius [mm]"
    with pytest.raises(
        ViewError, match="figure 'maps': expected one of card, orbit, bearing-forces"
    ):
        bw.plot.maps(run)
    folder = synthetic_sweep(tmp_path / "sweep", {"march.speed": (1.0,)}, [run])
    with bw.open_sweep(folder) as sweep:
        assert "rotating frame" in bw.plot.whirl(sweep).axes[0].get_ylabel()
        with pytest.raises(ViewError, match="figure 'orbit': expected one of frequency-map"):
            bw.plot.orbit(sweep)
        with pytest.raises(ViewError, match="omit start and end: a sweep has no time window"):
            bw.plot.whirl(sweep, start=0.1)
