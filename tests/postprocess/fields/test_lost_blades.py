"""Pictures, series, figures and summary of a run that loses a blade."""

from pathlib import Path

import meshio
import numpy as np
import pytest
import rod_blade
import xarray as xr
from legible import assert_legible
from places import EXAMPLES
from solid_meshes import STEEL, cantilever

import bladewhirl as bw
from bladewhirl.models.case.file import read_case
from bladewhirl.models.stage.beams import Beams
from bladewhirl.models.stage.blade_loss import lost_part, remaining_disk
from bladewhirl.postprocess.energy.strain import family_energies, strain_energies
from bladewhirl.postprocess.fields.by_blade import contact_motion
from bladewhirl.postprocess.fields.enlarged import EnlargedStage
from bladewhirl.postprocess.fields.lost_blades import lost_beams, lost_blades
from bladewhirl.postprocess.fields.point_stresses import PointStresses
from bladewhirl.postprocess.paraview.series import export_vtk
from bladewhirl.postprocess.pictures.drawing import Drawing
from bladewhirl.postprocess.run.blade_contact import contact_maps
from bladewhirl.postprocess.run.figures import RunFigures
from bladewhirl.postprocess.run.stresses import peak_stresses, stress_history
from bladewhirl.postprocess.run.summary import summarise
from bladewhirl.postprocess.run.summary_table import summary_rows
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

pytestmark = pytest.mark.pictures

CHANGES = (
    "bladed_disk.blades=9",
    "reduction.fixed_interface_modes=36",
    "march.duration=0.02",
    "damping.ratio=0.01",
    "blade_loss={blade=[2,5],time=0.01,from=0.3}",
)


@pytest.fixture(scope="module")
def run() -> tuple[xr.Dataset, dict[str, float]]:
    return march_in_memory(prepare(read_case(EXAMPLES / "imbalance.toml", CHANGES)))


def test_lost_blades_vanish_from_pictures(run: tuple[xr.Dataset, dict[str, float]]) -> None:
    result, _ = run
    lost = lost_blades(result)
    assert lost is not None
    lines = lost_beams(result, lost).lines
    assert len(lines) == 14  # seven of ten beams of each blade
    records = np.array([50, 99, 100, 150])
    stage = EnlargedStage(result, records, factor=10.0, pieces=4, per_element=4)
    drawn = [stage.body.stations(stage.points(n)) for n in range(4)]
    lengths = np.linalg.norm(np.diff(drawn, axis=2), axis=3).sum(2)
    assert (lengths[:2] > 0.01).all()
    assert (lengths[2:][:, lines] == 0.0).all()
    others = np.setdiff1d(np.arange(lengths.shape[1]), lines)
    assert (lengths[2:][:, others] > 0.01).all()
    drawing = Drawing(result, records)
    assert [len(drawing.picture(n).blade_forces) for n in range(4)] == [9, 9, 7, 7]
    # What has flown away has no stress that would set the scale.
    values = Drawing(result, records, colour="stress").colouring.points
    none = [np.isnan(drawing.points[0].stations(each)).all(axis=(1, 2)) for each in values]
    assert not np.any(none[:2])
    assert [np.flatnonzero(each).tolist() for each in none[2:]] == 2 * [sorted(lines)]


def test_lost_blades_vanish_from_series(
    run: tuple[xr.Dataset, dict[str, float]], tmp_path: Path
) -> None:
    result, _ = run
    export_vtk(result, tmp_path, records=np.array([50, 150]))
    before, after = (
        meshio.read(tmp_path / "frames" / f"rotor_0000{n}.vtu").cells[0].data for n in range(2)
    )
    assert len(before) - len(after) == 14
    tips = meshio.read(tmp_path / "frames" / "contact_00001.vtu").cell_data["blade"][0]
    np.testing.assert_array_equal(tips, [0, 1, 3, 4, 6, 7, 8])


def test_values_of_lost_blades(run: tuple[xr.Dataset, dict[str, float]]) -> None:
    result, report = run
    after = result["time"].values > 0.0101
    moved = contact_motion(result, 0)
    assert np.isnan(moved[after][:, [2, 5]]).all()
    assert np.isfinite(np.delete(moved, [2, 5], axis=1)).all()
    assert np.isfinite(moved[result["time"].values < 0.0099]).all()
    gaps = contact_maps(result)["gap"].values[-1]
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(gaps)), [2, 5])
    stress = stress_history(result)["largest_stress"].sel(member="blade 2").values
    assert stress[~after].max() > 0.0
    rows = summary_rows(summarise(result, report))
    assert rows["loss"] == "blades 2, 5 lost at 0.01 s beyond 30 % of the length"


@pytest.mark.slow
@pytest.mark.parametrize("effects", ["none", "full"])
def test_strain_energy_is_that_of_the_matrices_of_what_remains(effects: str) -> None:
    changes = (*CHANGES, f"rotation.effects={effects}", "excitation.ramp=0", "march.duration=0.015")
    prepared = prepare(read_case(EXAMPLES / "imbalance.toml", changes))
    result, report = march_in_memory(prepared)
    energies = strain_energies(result)
    stage = prepared.stage
    assert isinstance(stage, Beams)
    model = stage.disk.model
    remaining = remaining_disk(stage.case, model, lost_part(stage.case, model))
    after = result["time"].values > 0.01 - 1e-9
    moved = result["rotor_displacement"].values @ stage.reduction.modes.shapes.T
    speed = stage.speed if effects == "full" else 0.0
    for now, disk in ((after, remaining), (~after, stage.disk)):
        stiffness = disk.structure.still.stiffness_at(speed)
        exact = 0.5 * np.einsum("ti,it->t", moved[now], stiffness @ moved[now].T)
        total = energies["total"].values[now]
        np.testing.assert_allclose(total, exact, rtol=1e-6, atol=1e-6 * exact.max())
        groups = energies["suspension"] + energies["first_family"].sum("nodal_diameter")
        np.testing.assert_allclose((groups + energies["rest"]).values[now], total, rtol=1e-9)
    by_family = family_energies(result)["energy"].sum(["family", "nodal_diameter"], skipna=False)
    assert np.isnan(by_family.values[after]).all()
    np.testing.assert_allclose(by_family.values[~after], energies["total"].values[~after])
    assert summarise(result, report).strain_energy_rest is None
    figure, _ = RunFigures(result).draw("energy-families")
    assert_legible(figure)


def test_lost_3d_blades_vanish(tmp_path: Path) -> None:
    bw.write_superelement(tmp_path / "rods.npz", rod_blade.blade())
    given = rod_blade.tables(tmp_path / "rods.npz", blade_loss={"blade": 1, "time": 0.01})
    result, _ = march_in_memory(prepare(bw.case_from(given)))
    gone = result["time"].values > 0.01 - 1e-6
    moved = contact_motion(result, 0)
    assert np.isnan(moved[gone][:, 3:6]).all()
    assert np.isfinite(moved[~gone]).all()
    assert np.isfinite(moved[gone][:, [0, 1, 2, 6, 7, 8]]).all()
    stage = EnlargedStage(result, np.array([100, 400]), factor=2.0, pieces=1, per_element=1)
    sizes = [np.ptp(stage.points(n)[stage.body.blade == 1], axis=0).max() for n in range(2)]
    assert sizes[0] > 0.03
    assert sizes[1] == 0.0
    assert np.ptp(stage.points(1)[stage.body.blade == 2], axis=0).max() > 0.03


def test_lost_3d_blades_have_no_stress(tmp_path: Path) -> None:
    bw.write_superelement(tmp_path / "part.npz", bw.mesh3d(cantilever("hexahedron"), **STEEL))
    given = {
        "bladed_disk": {"superelement": {"file": str(tmp_path / "part.npz"), "copies": 3}},
        "casing": {"type": "rigid", "clearance": 1e-4},
        "rotation": {"effects": "centrifugal"},
        "march": {"speed": "700 rad/s", "duration": 0.002, "time_step": 5e-7},
        "reduction": {"free_interface_modes": 12},
        "blade_loss": {"blade": [0, 2], "time": 0.001},
    }
    result, _ = march_in_memory(prepare(bw.case_from(given)))
    last = result.sizes["time"] - 1
    before, after = PointStresses(result).at(np.array([1, last])).reshape(2, 3, -1)
    assert (before.max(axis=1) > 1e6).all()
    assert (after.max(axis=1) > 1e6).tolist() == [False, True, False]
    assert not after[[0, 2]].any()
    split = peak_stresses(result)["alternating_stress"]
    assert np.isfinite(split.values).tolist() == [False, True, False]
