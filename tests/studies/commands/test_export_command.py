"""`bladewhirl export`: what it writes, what it says, what it refuses."""

from pathlib import Path

import pytest
import pyvista
from command_line import answer


def test_a_window_as_lines(run: Path) -> None:
    arguments = ["--frames", "5", "--from", "100 ms", "--to", "0.2"]
    done = answer("export", run, *arguments)
    assert "5 instants from 0.1 s to 0.2 s" in done.stdout
    assert "frames per revolution" in done.stderr  # too few for a smooth turn
    reader = pyvista.PVDReader(run / "vtk" / "series.pvd")
    assert reader.time_values == pytest.approx([0.1, 0.125, 0.15, 0.175, 0.2])
    assert all(part.area == 0 for part in reader.read())


def test_surfaces_in_a_named_folder(run: Path, tmp_path: Path) -> None:
    target = tmp_path / "deep" / "machine"
    answer("export", run / "result.nc", "--surface", "--frames", "2", "-o", target)
    rotor, casing, contact, _ = pyvista.PVDReader(target / "series.pvd").read()
    assert rotor.area > 0
    assert casing.area > 0
    assert contact.n_points == 22
