"""Damaged and hostile files of matrices: each ends in one line, and none in wrong memory."""

import os
import subprocess
import sys
import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io as sio
import scipy.sparse as sp
from faults import fault
from places import ROOT

from bladewhirl.models.imports.importing import import_superelement
from bladewhirl.models.imports.tables import read_matrix
from bladewhirl.models.superelements import containers
from bladewhirl.models.superelements.file import read_superelement
from bladewhirl.models.superelements.superelement import dense

SPARSE: dict[str, Any] = {
    "data": np.ones(4),
    "indices": np.arange(4),
    "indptr": np.arange(5),
    "shape": [4, 4],
}
CONTACT: dict[str, Any] = {
    "contact_position": np.array([[0.3, 0.4, 0.02]]),
    "contact_dofs": np.array([[0, 1, 2]]),
}
CHAIN = CONTACT | {"mass": np.eye(4), "stiffness": 1e6 * np.eye(4)}
GOOD = CONTACT | {f"{key}_{part}": SPARSE[part] for key in ("mass", "stiffness") for part in SPARSE}


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("indices", [0, 1, 10**9, 3], "mass: expected a sparse matrix"),
        ("indices", [0, -5, 2, 3], "mass: expected a sparse matrix"),
        ("indices", [0.5, 1.5, 2.5, 3.5], "mass_indices: expected whole numbers"),
        ("indices", [0, 1, 2], "mass: expected a sparse matrix"),
        ("indptr", [0, 3, 1, 3, 4], "mass: expected a sparse matrix"),
        ("indptr", [0, 10**6, 10**6, 1, 0], "mass: expected a sparse matrix"),
        ("indptr", [1, 2, 3, 4, 4], "mass: expected a sparse matrix"),
        ("indptr", [0, 1, 2, 3, 9], "mass: expected a sparse matrix"),
        ("shape", [np.inf, 4], "mass_shape: expected finite real numbers"),
        ("shape", [10**9, 4], "mass: expected at most"),
        ("shape", [-4, 4], "mass: expected a sparse matrix"),
        ("shape", [4], "mass: expected a sparse matrix"),
        ("shape", [], "mass: expected a sparse matrix"),
        ("data", [1.0, 1.0, np.nan, 1.0], "mass: expected finite real numbers"),
        ("data", [1.0, 1.0, 1e300, 1.0], "mass: expected finite real numbers"),
        ("data", np.array([1.0, np.inf, 1.0, 1.0], dtype=np.float16), "mass: expected finite"),
        ("data", np.array([1.0, "1e4000", 1.0, 1.0], dtype=np.longdouble), "mass: expected finite"),
        ("data", [1.0, 1j, 1.0, 1.0], "mass: expected finite real numbers"),
        ("data", ["1", "1", "1", "1"], "mass: expected"),
        ("data", [1.0, 1.0, 1e-300, 1.0], "mass: expected numbers of at least 1e-30"),
    ],
)
def test_wrong_sparse_matrices_are_refused(
    tmp_path: Path, key: str, value: Any, expected: str
) -> None:
    np.savez(tmp_path / "a.npz", **GOOD | {f"mass_{key}": value})
    assert fault(read_superelement, tmp_path / "a.npz").startswith(f"{tmp_path}/a.npz: {expected}")


@pytest.mark.parametrize("kind", ["f2", "f4", ">f8", "i1", "u8", "?", "g"])
def test_real_matrices_of_any_type_are_read(tmp_path: Path, kind: str) -> None:
    np.savez(tmp_path / "a.npz", **GOOD | {"mass_data": np.ones(4).astype(kind)})
    assert np.array_equal(dense(read_superelement(tmp_path / "a.npz").mass), np.eye(4))


@pytest.mark.parametrize("unit", [1j, np.nan, np.inf, -1.0, 0.0, "", [], [[]], "kg"])
def test_units_are_positive_numbers_or_text(tmp_path: Path, unit: Any) -> None:
    np.savez(tmp_path / "a.npz", **GOOD | {"length_unit": unit})
    assert "length_unit: expected" in fault(read_superelement, tmp_path / "a.npz")


@pytest.mark.slow
def test_random_mat_files_are_read_or_refused(tmp_path: Path) -> None:
    script = ROOT / "tests" / "support" / "damaged_mat.py"
    command = [sys.executable, "-W", "error", str(script), str(tmp_path), "400"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-500:]
    assert 600 < int(done.stdout) < 800  # of 800


@pytest.mark.parametrize("number", [10**9, -5])
@pytest.mark.parametrize("read", [read_superelement, import_superelement])
def test_indices_of_mat_files_are_checked_before_use(
    tmp_path: Path, number: int, read: Any
) -> None:
    path = tmp_path / "a.mat"
    sparse = {key: sp.csc_array(CHAIN[key]) for key in ("mass", "stiffness")}
    sio.savemat(path, CHAIN | sparse)
    rows = np.arange(4, dtype="<i4").tobytes()
    wrong = np.array([0, 1, number, 3], dtype="<i4").tobytes()
    path.write_bytes(path.read_bytes().replace(rows, wrong, 1))
    assert "mass: expected a sparse matrix (indices are not from 0 to 3)" in fault(read, path)


def _member(shape: str, data: bytes = b"") -> bytes:
    """Return a .npy file with any shape in its head."""
    head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head.encode() + data


def _archive(path: Path, members: dict[str, bytes]) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for key, value in CHAIN.items():
            stream = BytesIO()
            np.save(stream, value)
            archive.writestr(f"{key}.npy", members.get(key, stream.getvalue()))
        for key in members.keys() - CHAIN.keys():
            archive.writestr(f"{key}.npy", members[key])


def _encrypted(path: Path) -> None:
    _archive(path, {})
    content = bytearray(path.read_bytes())
    at = content.find(b"PK\1\2")
    content[at + 8] |= 1
    content[6] |= 1
    path.write_bytes(content)


def _corrupted(path: Path) -> None:
    _archive(path, {})
    content = bytearray(path.read_bytes())
    at = content.find(b"mass.npy") + 8
    content[at : at + 40] = b"\xff" * 40
    path.write_bytes(content)


@pytest.mark.parametrize(
    "damage",
    [
        lambda path: _archive(path, {"mass": _member("(1000000000000,)")}),
        lambda path: _archive(path, {"mass": _member("(-1, 4)", bytes(128))}),
        lambda path: _archive(path, {"mass": _member("(4, 4", bytes(128))}),
        lambda path: _archive(path, {"mass": b"raw"}),
        lambda path: _archive(path, {"mass": b""}),
        _encrypted,
        _corrupted,
        lambda path: path.write_bytes(b""),
        lambda path: path.write_bytes(b"PK\5\6" + bytes(18)),
        lambda path: path.write_bytes(_member("(2,)", bytes(16))),
        os.mkfifo,
        lambda path: path.mkdir(),
        lambda path: path.symlink_to("/dev/zero"),
        lambda path: np.savez(path, **CHAIN | {"points": np.float64(1.0)}),
        lambda path: np.savez(path, **CHAIN | {"contact_dofs": np.full((1, 3), -1)}),
        lambda path: np.savez(path, **CHAIN | {"contact_dofs": [[-1, -1, 2]]}),
        lambda path: np.savez(path, **CHAIN | {"contact_position": [[300.0, 0.0, 0.0]]}),
        lambda path: np.savez(path, **CHAIN | {"damping": -np.eye(4)}),
        lambda path: np.savez(path, **CHAIN | {"stiffness": (1e6 + 5j) * np.eye(4)}),
    ],
)
def test_damaged_archives_are_refused_in_one_line(tmp_path: Path, damage: Any) -> None:
    damage(tmp_path / "a.npz")
    assert fault(read_superelement, tmp_path / "a.npz").startswith(f"{tmp_path}/a.npz: ")


def test_arrays_with_unknown_names_are_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _archive(tmp_path / "a.npz", {"zzzz": _member("(1000000000000,)")})
    assert read_superelement(tmp_path / "a.npz").size == 4
    monkeypatch.setattr(containers, "memory", lambda: 100.0)
    assert "its arrays need" in fault(read_superelement, tmp_path / "a.npz")
    sio.savemat(tmp_path / "a.mat", CHAIN)
    assert "its arrays need" in fault(read_superelement, tmp_path / "a.mat")


@pytest.mark.parametrize(
    "content",
    [
        {},
        CHAIN | {"mass": np.array([["a"], [1.0]], dtype=object)},
        CHAIN | {"contact_position": np.array([[0.3, [1.0], 0.0]], dtype=object)},
        CHAIN | {"mass": 1j * np.eye(4)},
    ],
)
@pytest.mark.parametrize("read", [read_superelement, import_superelement])
def test_mat_files_without_real_matrices_are_refused(
    tmp_path: Path, content: dict[str, Any], read: Any
) -> None:
    sio.savemat(tmp_path / "a.mat", content)
    assert fault(read, tmp_path / "a.mat").startswith(f"{tmp_path}/a.mat: ")


def test_an_empty_file_is_no_mat_file(tmp_path: Path) -> None:
    (tmp_path / "a.mat").write_bytes(b"")
    assert "expected a .mat file before version 7.3" in fault(read_superelement, tmp_path / "a.mat")


MARKET = "%%MatrixMarket matrix coordinate real general\n"
ARRAY = "%%MatrixMarket matrix array real general\n"


@pytest.mark.parametrize("symmetry", ["general", "symmetric"])
def test_matrices_of_matrix_market_are_those_of_scipy(tmp_path: Path, symmetry: str) -> None:
    noise = np.random.default_rng(0).standard_normal((5, 5))
    matrix = noise + noise.T if symmetry == "symmetric" else noise
    for given in (matrix, sp.coo_array(np.where(abs(matrix) > 0.5, matrix, 0.0))):
        sio.mmwrite(tmp_path / "k.mtx", given, symmetry=symmetry, comment="% a comment")
        expected = sio.mmread(tmp_path / "k.mtx")
        expected = expected.toarray() if sp.issparse(expected) else expected
        assert np.array_equal(read_matrix(tmp_path / "k.mtx").toarray(), expected)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f"{MARKET}1000000000 1000000000 1\n1 1 1.0\n", "1000000000 rows and 1 entries"),
        (f"{MARKET}3 3 1000000000\n1 1 1.0\n", "1000000000 entries in"),
        (f"{MARKET}2 2 2\n1.5 1 1.0\n2 2 1.0\n", "rows and columns: expected whole numbers"),
        (f"{MARKET}2 2 2\n1 1 nan\n2 2 1.0\n", "values: expected finite real numbers"),
        (f"{MARKET}2 2 2\n3 1 1.0\n2 2 1.0\n", "rows and columns from 1 to 2, got 3"),
        (f"{MARKET}2 2 2\n1 1 1.0\n", "1 entries in place of 2"),
        (f"{MARKET}2 2 2\n1 1 1.0\n2 2\n", "a file of Matrix Market"),
        (f"{ARRAY}2 2\n1.0\n", "a file of Matrix Market"),
        (f"{MARKET.replace('general', 'skew-symmetric')}1 1 1\n1 1 1.0\n", "skew-symmetric"),
        (f"{MARKET.replace('real', 'complex')}1 1 1\n1 1 1.0 0.0\n", "a square real matrix"),
        ("1.5 1 1.0\n2 2 1.0\n", "rows and columns: expected whole numbers"),
        ("nan 1 1.0\n2 2 1.0\n", "rows and columns: expected finite real numbers"),
        ("1 1 1.0\n1000000000 1000000000 1.0\n", "rows and columns from 1 to 34"),
        ("1 1 inf\n2 2 1.0\n", "values: expected finite real numbers"),
        ("1 1\n", "lines of row, column and value"),
    ],
)
def test_damaged_text_files_of_matrices_are_refused(
    tmp_path: Path, text: str, expected: str
) -> None:
    (tmp_path / "k.mtx").write_text(text)
    assert expected in fault(read_matrix, tmp_path / "k.mtx")


def test_pipes_are_no_matrices(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "k.mtx")
    assert "it is not a regular file" in fault(read_matrix, tmp_path / "k.mtx")


def test_a_byte_order_mark_does_not_hide_a_matrix(tmp_path: Path) -> None:
    (tmp_path / "k.mtx").write_text("\ufeff1 1 2.0\n", encoding="utf-8")
    assert read_matrix(tmp_path / "k.mtx").toarray() == [[2.0]]
