"""Reductions kept beside the file of a superelement."""

import hashlib
import io
import os
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from solid_meshes import SECTORS, STEEL, TIE, bladed_sector

import bladewhirl as bw
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.stage.build_matrices import build_matrices
from bladewhirl.models.superelements import kept_reduction
from bladewhirl.models.superelements.cholesky import Cholesky
from bladewhirl.models.superelements.kept_reduction import Arrays
from bladewhirl.models.superelements.superelement import Superelement


@pytest.fixture(scope="module")
def sector() -> Superelement:
    mesh = bladed_sector("hexahedron20")
    values = {"young_modulus": 2.1e11, "poisson_ratio": 0.3, "density": 7800.0}
    return mesh3d(
        mesh,
        contacts=3,
        left="left",
        right="right",
        copies=SECTORS,
        **values,  # type: ignore[arg-type]
    )


class Counted:
    """A function that computes arrays, and the number of its calls."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self) -> list[Arrays]:
        self.calls += 1
        return [{"a": np.arange(3.0)}, {"a": np.array([1j])}]


@pytest.fixture
def in_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep reductions of all sizes in a folder only."""
    monkeypatch.setattr(kept_reduction, "LARGE", 0)
    monkeypatch.setattr(kept_reduction, "IN_MEMORY", 0)


def kept(folder: Path, part: Superelement, compute: Counted, *settings: int) -> list[Arrays]:
    return kept_reduction.kept_reduction(str(folder / "a.npz"), part, settings, compute)


@pytest.mark.usefixtures("in_folder")
def test_a_reduction_is_computed_once_for_the_same_content(
    tmp_path: Path, sector: Superelement
) -> None:
    compute = Counted()
    for _ in range(2):
        first, second = kept(tmp_path, replace(sector, name="another"), compute, 12, 5)
        assert first["a"] == pytest.approx(np.arange(3.0))
        assert second["a"] == np.array([1j])
    assert compute.calls == 1
    for part, *settings in (
        (sector, 12, 6),
        (sector, 13, 5),
        (replace(sector, stiffness=1.000001 * sector.stiffness), 12, 5),
        (replace(sector, contact_dofs=sector.contact_dofs[:, [1, 0, 2]]), 12, 5),
    ):
        kept(tmp_path, part, compute, *settings)
    assert compute.calls == 5


@pytest.mark.usefixtures("in_folder")
def test_damaged_and_old_reductions_are_made_again(
    tmp_path: Path,
    sector: Superelement,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    compute = Counted()
    kept(tmp_path, sector, compute, 12, 5)
    (file,) = (tmp_path / "a.npz.reduced").iterdir()
    content = file.read_bytes()
    buffer = io.BytesIO()
    altered: dict[str, Any] = {"0/a": 1.1 * np.arange(3.0), "1/a": np.array([1j])}
    np.savez(buffer, **altered)  # whole, with other numbers
    for damaged in (
        content[: len(content) // 2],
        b"",
        b"PK\x03\x04",
        content[:200] + content[230:],
        buffer.getvalue(),
    ):
        file.write_bytes(damaged)
        before = compute.calls
        assert kept(tmp_path, sector, compute, 12, 5)[0]["a"] == pytest.approx(np.arange(3.0))
        assert compute.calls == before + 1
        assert file.read_bytes() == content
        (record,) = caplog.records
        assert "damaged" in record.getMessage()
        assert "\n" not in record.getMessage()
        caplog.clear()
    kept(tmp_path, sector, compute, 12, 6)
    (other,) = set(file.parent.iterdir()) - {file}
    shutil.copy(other, file)  # whole, but of other settings
    kept(tmp_path, sector, compute, 12, 5)
    assert compute.calls == 8
    monkeypatch.setattr(kept_reduction, "VERSION", 0)
    kept(tmp_path, sector, compute, 12, 5)
    assert compute.calls == 9


@pytest.mark.usefixtures("in_folder")
def test_a_folder_that_cannot_be_written_only_costs_time(
    tmp_path: Path, sector: Superelement
) -> None:
    (tmp_path / "a.npz.reduced").write_text("a file where the folder would be")
    compute = Counted()
    for _ in range(2):
        assert kept(tmp_path, sector, compute, 12, 5)[0]["a"].shape == (3,)
    assert compute.calls == 2


@pytest.mark.usefixtures("in_folder")
def test_old_reductions_are_removed(tmp_path: Path, sector: Superelement) -> None:
    for modes in range(kept_reduction.MOST + 3):
        kept(tmp_path, sector, Counted(), 12, modes)
    assert len(list((tmp_path / "a.npz.reduced").iterdir())) == kept_reduction.MOST


@pytest.mark.usefixtures("in_folder")
def test_what_is_no_regular_file_is_neither_read_nor_followed(
    tmp_path: Path, sector: Superelement, caplog: pytest.LogCaptureFixture
) -> None:
    compute = Counted()
    kept(tmp_path, sector, compute, 12, 5)
    (file,) = (tmp_path / "a.npz.reduced").iterdir()
    outside = tmp_path / "outside.npz"
    for linked in (False, True):
        file.replace(outside)
        if linked:
            file.symlink_to(outside)
        else:
            os.mkfifo(file)
        kept(tmp_path, sector, compute, 12, 5)
        assert file.is_file()
        assert not file.is_symlink()
        assert caplog.records.pop().getMessage().count("a regular file") == 1
    assert compute.calls == 3
    kept(tmp_path, sector, compute, 12, 5)
    assert compute.calls == 3
    file.parent.rename(tmp_path / "elsewhere")
    file.parent.symlink_to(tmp_path / "elsewhere")
    kept(tmp_path, sector, compute, 12, 5)
    kept(tmp_path, sector, compute, 12, 6)
    assert compute.calls == 5
    assert len(list((tmp_path / "elsewhere").iterdir())) == 1
    assert "found a link" in caplog.text


def test_a_small_sector_of_a_large_wheel_is_kept_in_the_folder(
    tmp_path: Path, sector: Superelement
) -> None:
    size = sector.size
    assert size < kept_reduction.LARGE
    kept(tmp_path, sector, Counted(), 10, 5)
    assert not (tmp_path / "a.npz.reduced").exists()
    kept(tmp_path, sector, Counted(), 10 * kept_reduction.LARGE // size + 1, 5)
    assert len(list((tmp_path / "a.npz.reduced").iterdir())) == 1


@pytest.mark.usefixtures("in_folder")
def test_a_large_foreign_file_is_not_read(
    tmp_path: Path, sector: Superelement, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept(tmp_path, sector, Counted(), 12, 5)
    (file,) = (tmp_path / "a.npz.reduced").iterdir()
    os.truncate(file, 10**12)  # most of it is a hole
    monkeypatch.setattr(np, "load", None)
    monkeypatch.setattr(hashlib, "file_digest", None)
    assert kept(tmp_path, sector, compute := Counted(), 12, 5)[0]["a"].shape == (3,)
    assert compute.calls == 1


@pytest.mark.usefixtures("in_folder")
def test_files_of_the_user_are_not_removed(tmp_path: Path, sector: Superelement) -> None:
    folder = tmp_path / "a.npz.reduced"
    folder.mkdir()
    names = [f"mine{number}.npz" for number in range(kept_reduction.MOST + 3)]
    for name in names:
        (folder / name).write_bytes(b"mine")
        os.utime(folder / name, (1e9, 1e9))
    for modes in range(kept_reduction.MOST + 1):
        kept(tmp_path, sector, Counted(), 12, modes)
    assert {*names} <= {one.name for one in folder.iterdir()}
    assert len(list(folder.iterdir())) == len(names) + kept_reduction.MOST


def test_points_of_a_sweep_reduce_a_sector_once(
    tmp_path: Path, sector: Superelement, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Stages that differ in casing and contact share the reduction, also of a small sector."""
    bw.write_superelement(tmp_path / "sector.npz", sector)
    made = []
    factorised = Cholesky.of

    def counted(*args: Any) -> Any:
        made.append(args)
        return factorised(*args)

    monkeypatch.setattr(Cholesky, "of", counted)
    values = {
        "bladed_disk.superelement.file": str(tmp_path / "sector.npz"),
        "bladed_disk.superelement.kind": "sector",
        "bladed_disk.superelement.copies": SECTORS,
        "reduction.free_interface_modes": 3,
        "casing.type": "rigid",
    }
    frequencies = []
    for clearance in (1e-3, 2e-3, 3e-3):
        case = bw.with_values(bw.Case(), values | {"casing.clearance": clearance})
        frequencies.append(build_matrices(case).reference_frequency)
    assert len(made) == 1
    assert len(set(frequencies)) == 1
    assert not (tmp_path / "sector.npz.reduced").exists()  # it is small


@pytest.mark.usefixtures("in_folder")
def test_listed_modes_of_a_sector_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At a speed, with the motions that the rotation couples to them; each of the two structures,
    at rest and at the speed, is factorised once."""
    sector = mesh3d(bladed_sector("wedge"), **STEEL, **TIE, contacts=2, coriolis=True)
    bw.write_superelement(tmp_path / "sector.npz", sector)
    part = {"superelement": {"file": str(tmp_path / "sector.npz"), "copies": SECTORS}}
    values = {"bladed_disk": part, "reduction": {"free_interface_modes": 3}}
    case = bw.case_from(values | {"rotation": {"effects": "full"}, "march": {"speed": "9000 rpm"}})
    factorised, of = list[Cholesky](), Cholesky.of

    def counted(*given: Any) -> Cholesky:
        factorised.append(of(*given))
        return factorised[-1]

    monkeypatch.setattr(Cholesky, "of", counted)
    first = bw.modes(case, count=4)
    assert len(factorised) == 2
    monkeypatch.setattr(Cholesky, "of", None)  # nothing is factorised again
    assert bw.modes(case, count=4).identical(first)
