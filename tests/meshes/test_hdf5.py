"""HDF5 files are opened if their data are their own, of expected kinds and of a plausible size."""

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from written_decks import code_aster, rounded

from bladewhirl.meshes.files.groups import MeshFileError
from bladewhirl.meshes.files.volumes import read_volume_mesh
from bladewhirl.meshes.hdf5 import open_hdf5
from bladewhirl.postprocess.fields.netcdf import ResultError, open_file


def linked(file: h5py.File) -> None:
    file["more/link"] = h5py.ExternalLink("other.h5", "/a")


def stored_elsewhere(file: h5py.File) -> None:
    file.create_dataset("outside", (3,), "f8", external=[("secret.bin", 0, 24)])


def virtual(file: h5py.File) -> None:
    layout = h5py.VirtualLayout((3,), "f8")
    layout[:] = h5py.VirtualSource("other.h5", "a", (3,))
    file.create_virtual_dataset("virtual", layout)


def large(file: h5py.File) -> None:
    file.create_dataset("many", (10**12,), "f8", chunks=(1000,))


def large_chunk(file: h5py.File) -> None:
    file.create_dataset("one", (1,), "f8", chunks=(4 * 10**8,), maxshape=(None,))


def of_any_length(file: h5py.File) -> None:
    file.create_dataset("ragged", (3,), h5py.vlen_dtype(np.float64))


def attribute_of_any_length(file: h5py.File) -> None:
    values = np.empty(1, dtype=object)
    values[0] = np.arange(3)
    file["a"].attrs.create("units", values, dtype=h5py.vlen_dtype(np.int64))


FAULTS = [
    (linked, "more/link is in another file"),
    (stored_elsewhere, "outside is in another file"),
    (virtual, "virtual is in another file"),
    (large, "8e\\+12 bytes of data"),
    (large_chunk, "3.2e\\+09 bytes of data"),
    (of_any_length, "ragged has neither numbers nor text"),
    (attribute_of_any_length, "a has neither numbers nor text"),
]


@pytest.mark.parametrize(("change", "expected"), FAULTS)
def test_files_with_other_data_than_their_own_are_refused_in_one_line(
    tmp_path: Path, change: Callable[[h5py.File], None], expected: str
) -> None:
    path = tmp_path / "branch.nc"
    with h5py.File(path, "w") as file:
        file["a"] = np.arange(3.0)
    with open_hdf5(path) as file:
        assert file["a"][1] == 1.0
    with h5py.File(path, "r+") as file:
        change(file)
    for mode in ("r", "r+"):
        with pytest.raises(OSError, match=expected):
            open_hdf5(path, mode)
    with pytest.raises(ResultError, match=expected) as caught:
        open_file(path, path.name, "a result")
    assert len(str(caught.value).splitlines()) == 1


def test_a_file_in_a_ring_of_groups_is_opened(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "ring.h5", "w") as file:
        file["a/b"] = file["/"]
        file["soft"] = h5py.SoftLink("/a")
    open_hdf5(tmp_path / "ring.h5").close()


@pytest.mark.parametrize("change", [linked, stored_elsewhere, virtual, large])
def test_meshes_of_code_aster_have_their_own_data(
    tmp_path: Path, change: Callable[[h5py.File], None]
) -> None:
    code_aster(tmp_path / "blade", rounded("hexahedron", (1, 1, 1)))
    read_volume_mesh(tmp_path / "blade.med")
    with h5py.File(tmp_path / "blade.med", "r+") as file:
        change(file)
    with pytest.raises(MeshFileError, match=r"a readable file \("):
        read_volume_mesh(tmp_path / "blade.med")


@pytest.mark.parametrize("name", ["NOE/COO", "MAI/HE8/NOD"])
def test_text_in_place_of_numbers_is_named(tmp_path: Path, name: str) -> None:
    path = tmp_path / "blade.med"
    code_aster(tmp_path / "blade", rounded("hexahedron", (1, 1, 1)))
    with h5py.File(path, "r+") as file:
        (mesh,) = file["ENS_MAA"].values()
        (step,) = mesh.values()
        size, attributes = step[name].shape, dict(step[name].attrs)
        del step[name]
        step.create_dataset(name, data=np.full(size, b"abc")).attrs.update(attributes)
    with pytest.raises(MeshFileError, match=f"{name} has no numbers"):
        read_volume_mesh(path)


def test_dimensions_are_found_without_functions_that_end_the_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """HDF5 frees memory twice in them if an attribute is damaged."""
    with h5py.File(tmp_path / "a.nc", "w") as file:
        file["time"], file["load"] = np.arange(3.0), np.arange(3.0)
        file["time"].make_scale()
        file["load"].dims[0].attach_scale(file["time"])
    monkeypatch.delattr(h5py.Dataset, "is_scale")
    monkeypatch.delattr(h5py.Dataset, "dims")
    data, _ = open_file(tmp_path / "a.nc", "a.nc", "a result")
    with data:
        assert data["load"].dims == ("time",)


def test_a_file_of_med_that_is_missing_or_no_hdf5_is_named(tmp_path: Path) -> None:
    path = tmp_path / "blade.med"
    with pytest.raises(MeshFileError, match=r"a readable file \(No such file or directory\)"):
        read_volume_mesh(path)
    path.write_bytes(b"MED")
    with pytest.raises(MeshFileError, match="as Salome and Code_Aster export it"):
        read_volume_mesh(path)
