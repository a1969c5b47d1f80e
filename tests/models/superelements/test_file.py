"""Files of superelements."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io as sio
import scipy.sparse as sp

from bladewhirl.models.superelements.file import read_superelement, write_superelement
from bladewhirl.models.superelements.superelement import (
    Superelement,
    SuperelementError,
    dense,
)

CHAIN: dict[str, Any] = {
    "mass": np.diag([1.0, 2.0, 3.0, 4.0]),
    "stiffness": 2.0 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1),
    "contact_position": np.array([[0.3, 0.4, 0.02]]),
    "contact_dofs": np.array([[0, 1, 2]]),
}


def test_a_written_superelement_is_read_with_its_sparse_matrices(tmp_path: Path) -> None:
    rows = sp.csr_array(np.arange(24.0).reshape(6, 4))
    np.savez(
        tmp_path / "a.npz",
        **CHAIN | {"points": np.ones((2, 3)), "name": "chain", "stiffness": CHAIN["stiffness"]},
        recovery_data=rows.data,
        recovery_indices=rows.indices,
        recovery_indptr=rows.indptr,
        recovery_shape=rows.shape,
    )
    part = read_superelement(tmp_path / "a.npz")
    write_superelement(tmp_path / "b.npz", part)
    again = read_superelement(tmp_path / "b.npz")
    assert again.name == "chain"
    assert np.array_equal(again.mass, part.mass)
    assert isinstance(again.recovery, sp.csr_array)
    assert np.array_equal(again.recovery.toarray(), np.arange(24.0).reshape(6, 4))


def test_units_are_converted_and_matlab_files_are_read(tmp_path: Path) -> None:
    content = CHAIN | {"length_unit": "mm", "mass_unit": "t"}
    content["contact_position"] = 1e3 * content["contact_position"]
    content["stiffness"] = sp.csc_matrix(content["stiffness"])
    sio.savemat(tmp_path / "a.mat", content)
    part = read_superelement(tmp_path / "a.mat")
    assert part.mass.diagonal() == pytest.approx([1e3, 2e3, 3e3, 4e3])  # t in kg
    assert part.stiffness.diagonal() == pytest.approx([2e3] * 4)  # N/mm in N/m
    assert part.contact_radius == pytest.approx([0.5])


def test_the_motion_of_points_has_no_unit(tmp_path: Path) -> None:
    given = {"points": np.full((2, 3), 100.0), "recovery": np.arange(24.0).reshape(6, 4)}
    units = {"length_unit": "mm", "mass_unit": "t"}
    content = CHAIN | given | units | {"contact_position": 1e3 * CHAIN["contact_position"]}
    np.savez(tmp_path / "a.npz", **content)
    part = read_superelement(tmp_path / "a.npz")
    assert part.points == pytest.approx(np.full((2, 3), 0.1))
    assert part.recovery is not None
    assert np.array_equal(dense(part.recovery), given["recovery"])
    np.savez(tmp_path / "a.npz", **content, damping=np.eye(4), gyroscopic=np.zeros((4, 4)))
    damping = read_superelement(tmp_path / "a.npz").damping
    assert dense(damping) == pytest.approx(1e3 * np.eye(4))


def test_rows_of_contacts_are_radial_tangential_and_axial(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", **CHAIN)
    rows = read_superelement(tmp_path / "a.npz").contact_rows.toarray()
    assert rows @ [0.6, 0.8, 0.0, 9.0] == pytest.approx([1.0, 0.0, 0.0])
    assert rows @ [-0.8, 0.6, 0.5, 9.0] == pytest.approx([0.0, 1.0, 0.5])


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({"contact_dofs": [[0, 1, 4]]}, "contact_dofs: expected numbers from 0 to 3, got 4"),
        ({"contact_dofs": [[0, 1, 0.5]]}, "contact_dofs: expected whole numbers"),
        ({"contact_position": [[0.0, 0.0, 1.0]]}, "away from the axis z; node 0 is on it"),
        ({"mass": np.triu(np.ones((4, 4)))}, "mass: expected a symmetric matrix"),
        ({"mass": -np.eye(4)}, "mass: expected no negative numbers"),
        ({"stiffness": np.eye(3)}, "stiffness: expected a square matrix of the size of mass"),
        ({"length_unit": "kg"}, "length_unit: expected a unit such as"),
        ({"recovry": 1.0}, "recovry: unknown key; did you mean recovery?"),
        ({"points": np.ones((2, 3))}, "points: only allowed together with recovery"),
        ({"gyroscopic": np.eye(4)}, "gyroscopic: expected a skew matrix"),
        ({"left_dofs": [[0, 1, 2]]}, "left_dofs: expected both left_dofs and right_dofs"),
    ],
)
def test_a_file_that_cannot_be_right_is_refused(
    tmp_path: Path, changed: dict[str, Any], expected: str
) -> None:
    np.savez(tmp_path / "a.npz", **CHAIN | changed)
    with pytest.raises(SuperelementError) as caught:
        read_superelement(tmp_path / "a.npz")
    assert expected in str(caught.value)
    assert str(caught.value).startswith(str(tmp_path / "a.npz"))


def test_files_that_are_no_superelements_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.npz").write_text("nothing")
    np.savez(tmp_path / "b.npz", mass=np.eye(2))
    for name, expected in (
        ("a.npz", "expected a file of NumPy or MATLAB"),
        ("b.npz", "expected stiffness, contact_position, contact_dofs"),
        ("c.npz", "expected a readable file (No such file"),
        ("d.csv", "expected a .npz file of NumPy or a .mat file of MATLAB"),
    ):
        with pytest.raises(SuperelementError, match=name) as caught:
            read_superelement(tmp_path / name)
        assert expected in str(caught.value)


def test_stresses_are_converted_and_written(tmp_path: Path) -> None:
    """From N, mm, t and s: stress per displacement from N/mm3 to Pa/m, forces from t mm to kg m."""
    rows = np.arange(48.0).reshape(12, 4)
    given = {
        "points": np.full((2, 3), 100.0),
        "recovery": np.arange(24.0).reshape(6, 4),
        "stress_recovery": rows,
        "young_modulus": np.array([[2.1e5, 1.1e5]]),
        "poisson_ratio": np.array([0.3, 0.31]),
        "centrifugal_load": np.arange(4.0),
    }
    units = {"length_unit": "mm", "mass_unit": "t"}
    content = CHAIN | given | units | {"contact_position": 1e3 * CHAIN["contact_position"]}
    np.savez(tmp_path / "a.npz", **content)
    write_superelement(tmp_path / "b.npz", read_superelement(tmp_path / "a.npz"))
    part = read_superelement(tmp_path / "b.npz")
    assert part.stress_recovery is not None
    assert dense(part.stress_recovery) == pytest.approx(1e9 * rows)
    assert part.young_modulus == pytest.approx([2.1e11, 1.1e11])
    assert part.poisson_ratio == pytest.approx([0.3, 0.31])
    assert part.centrifugal_load == pytest.approx(np.arange(4.0))


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"stress_recovery": np.ones((11, 4))}, r"expected \(12, 4\), six rows a point, got"),
        ({"stress_recovery": np.full((12, 4), np.nan)}, "stress_recovery: expected finite numbers"),
        ({"young_modulus": np.ones(3)}, r"a number for each point, \(2,\), got \(3\)"),
        ({"young_modulus": np.array([1.0, -1.0])}, "young_modulus: expected numbers above 0"),
        ({"poisson_ratio": np.array([0.3, 0.6])}, "numbers above -1, up to 0.5"),
        ({"poisson_ratio": None}, "expected both young_modulus and poisson_ratio"),
        ({"stress_recovery": None}, "only allowed together with stress_recovery"),
        ({"centrifugal_load": np.ones(3)}, r"centrifugal_load: expected \(4,\), got \(3\)"),
    ],
)
def test_invalid_stresses_are_refused(changes: dict[str, Any], expected: str) -> None:
    given = {
        "points": np.zeros((2, 3)),
        "recovery": np.ones((6, 4)),
        "stress_recovery": np.ones((12, 4)),
        "young_modulus": np.ones(2),
        "poisson_ratio": np.zeros(2),
        "centrifugal_load": np.ones(4),
    }
    with pytest.raises(SuperelementError, match=expected):
        Superelement(**CHAIN | given | changes)
