"""A file knows whether it is a sector, of how many, or a wheel."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from exported_stages import beams, exported
from solid_meshes import SECTORS, STEEL, TIE, bladed_sector

import bladewhirl as bw
from bladewhirl.models.inputs.errors import CaseError


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("part") / "sector.npz"
    part = bw.mesh3d(bladed_sector("hexahedron20"), **STEEL, **TIE, contacts=2)
    bw.write_superelement(path, part)
    return path


def case(file: Path, **table: Any) -> bw.Case:
    tables = {"bladed_disk": {"superelement": {"file": str(file)} | table}}
    return bw.case_from(tables | {"casing": {"type": "rigid"}})


def test_a_case_that_names_only_the_file_takes_its_kind_and_copies(file: Path) -> None:
    assert bw.read_superelement(file).sectors == SECTORS
    table = case(file).bladed_disk.superelement
    assert table is not None
    assert (table.kind, table.copies) == ("sector", SECTORS)
    assert case(file, kind="sector", copies=SECTORS) == case(file)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"kind": "blade"}, r'superelement\.kind = "blade": expected "sector" for a file with the'),
        ({"kind": "wheel"}, r'superelement\.kind = "wheel": expected "sector" for a file with the'),
        ({"copies": 11}, r"superelement\.copies = 11: expected 12, the number of sectors or"),
    ],
)
def test_a_case_that_contradicts_its_file_is_refused(
    file: Path, table: dict[str, Any], message: str
) -> None:
    with pytest.raises(CaseError, match=message):
        case(file, **table)


def test_a_sector_without_a_number_needs_copies(file: Path, tmp_path: Path) -> None:
    alone = replace(bw.read_superelement(file), sectors=None)
    bw.write_superelement(tmp_path / "alone.npz", alone)
    with pytest.raises(CaseError, match=r"copies.*at least 2 sectors"):
        case(tmp_path / "alone.npz")
    table = case(tmp_path / "alone.npz", copies=9).bladed_disk.superelement
    assert table is not None
    assert table.kind == "sector"


def test_a_file_with_a_centre_is_a_wheel(tmp_path: Path) -> None:
    wheel = exported(beams(), "wheel", tmp_path)
    table = wheel.bladed_disk.superelement
    assert table is not None
    again = case(Path(table.file)).bladed_disk.superelement
    assert again is not None
    assert again.kind == "wheel"


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"march": {"spead": 1.0}}, "march.spead = 1.0: expected a known key; the nearest is"),
        ({"bladed_disk": {"superelement": {"copys": 3}}}, "bladed_disk.superelement.copys = 3: "),
        ({"bladed_disk": {"blade_count": 3}}, "bladed_disk.blade_count = 3: expected a known key"),
    ],
)
def test_a_misspelt_key_is_found_before_the_file_is_read(
    tables: dict[str, Any], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "bladewhirl.models.case.superelement._cached", lambda *_: pytest.fail("read")
    )
    disk = tables.pop("bladed_disk", {})
    table = {"file": "never_read.npz"} | disk.pop("superelement", {})
    with pytest.raises(CaseError) as error:
        bw.case_from({**tables, "bladed_disk": {**disk, "superelement": table}})
    (line,) = error.value.lines
    assert line.startswith(message)
