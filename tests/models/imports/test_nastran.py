"""External superelements of Nastran: test files of pyyeti, made with NX Nastran 9."""

import builtins
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bladewhirl.models.imports.importing import import_superelement, imported
from bladewhirl.models.superelements.superelement import SuperelementError

pyyeti = pytest.importorskip("pyyeti")
FILES = Path(pyyeti.__file__).parent / "tests" / "nas2cam_extseout"
UNITS: dict[str, Any] = {"length_unit": "inch", "mass_unit": "lbf s2/inch"}


def test_displacements_are_turned_into_the_basic_axes() -> None:
    """Node 11 has axes of its own: with the wrong ones the mass would differ by direction."""
    part, actual, total = imported(FILES / "inboard.op4", contact="11,19", **UNITS)
    printed = 1.755052 * 0.45359237 * 9.80665 / 0.0254  # mass in inboard.out
    assert total == pytest.approx([printed] * 3, rel=1e-6)
    assert actual.rigid_modes == 6
    inch = 0.0254
    assert part.contact_position == pytest.approx(np.array([[600, 300, 300], [600, 300, 0]]) * inch)
    assert np.array_equal(part.contact_dofs, [[6, 7, 8], [12, 13, 14]])
    assert part.size == 24 + 8
    axes = np.eye(3)[[1, 2, 0]]  # x, y, z of the node are y, z, x
    stiffness = _block(_raw()["kxx"])
    assert _block(part.stiffness) == pytest.approx(
        axes.T @ stiffness @ axes * printed / 1.755052, rel=1e-12
    )


def _raw() -> Any:
    from pyyeti.nastran import op4

    return op4.read(str(FILES / "inboard.op4"))


def _block(matrix: Any) -> Any:
    return np.asarray(matrix)[6:9, 6:9]


def test_missing_files_nodes_and_packages_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copy(FILES / "inboard.op4", tmp_path)
    with pytest.raises(SuperelementError, match=r"expected inboard.asm in the same folder"):
        import_superelement(tmp_path / "inboard.op4", contact="11")
    with pytest.raises(SuperelementError, match="which has no node 12"):
        import_superelement(FILES / "inboard.op4", contact="12", **UNITS)
    monkeypatch.setattr(builtins, "__import__", _without_pyyeti(builtins.__import__))
    with pytest.raises(SuperelementError, match=r"pip install 'bladewhirl\[nastran\]'"):
        import_superelement(FILES / "inboard.op4", contact="11")


def _without_pyyeti(load: Any) -> Any:
    def refuse(name: str, *rest: Any) -> Any:
        if name.startswith("pyyeti"):
            raise ImportError(name)
        return load(name, *rest)

    return refuse
