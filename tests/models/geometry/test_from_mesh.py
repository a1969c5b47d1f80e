"""Stages from mesh files: the same matrices after a round trip, symmetry found, faults named."""

import pickle
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp
from faults import fault
from long_cases import slow_except
from places import EXAMPLES
from scipy.spatial import KDTree
from stages import steel

from bladewhirl.meshes.files.groups import GroupedLines
from bladewhirl.meshes.files.registry import WRITERS, left_out, write_line_mesh
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.bladed_disk import BladedDisk as BladedDiskTable
from bladewhirl.models.case.case import Case, case_from
from bladewhirl.models.case.file import loads, read_case, with_values
from bladewhirl.models.case.mesh_file import MeshSection, MeshTable
from bladewhirl.models.case.template import dumps_case, template
from bladewhirl.models.elements.bladed_disk import BladedDiskModel, assemble_bladed_disk
from bladewhirl.models.elements.build import case_beam_model
from bladewhirl.models.geometry.beam_model import BeamModel
from bladewhirl.models.geometry.from_mesh import grouped_lines
from bladewhirl.models.geometry.sketch import Sketch
from bladewhirl.models.modal.frequencies import lowest_frequencies
from bladewhirl.models.sections.rectangular import Section

EXAMPLE = EXAMPLES / "shrouded_fan.toml"
TITANIUM = Section(width=0.08, thickness=0.006, young_modulus=1.14e11, density=4430.0)


def varied(*, heavy_tip: bool) -> BeamModel:
    """Leaning tapered blades of another material, a shroud, masses; one tip heavier if wanted."""
    sketch = Sketch(7)
    sketch.node("centre", 0.0, 0.0, shared=True)
    sketch.node("root", 0.08)
    sketch.node("tip", 0.4, 0.05)
    sketch.member("spokes", "centre", "root", steel(0.03))
    sketch.member("rim", "root", "root+1", steel(0.02))
    taper = [TITANIUM, replace(TITANIUM, thickness=0.003)]
    sketch.member("blades", "root", "tip", taper, elements=5, path=[(0.25, 0.01)])
    sketch.member("shroud", "tip", "tip+1", steel(0.002))
    sketch.mass("tip", 0.02, inertia=1e-5)
    if heavy_tip:
        sketch.mass("tip", 0.001, sectors=[3])
    for name, node in (("centre", "centre"), ("tips", "tip"), ("blade roots", "root")):
        sketch.set(name, node)
    return sketch.build()


def papers() -> BeamModel:
    return case_beam_model(Case())


def assembled(model: BeamModel) -> BladedDiskModel:
    return assemble_bladed_disk(model, shaft_stiffness=3.4e7, clamped=False)


def from_file(path: Path, **more: Any) -> BeamModel:
    """The beam model of a mesh file, with the material of a case by default."""
    return case_beam_model(case_from({"bladed_disk": {"mesh": {"file": str(path), **more}}}))


def through(path: Path, lines: GroupedLines, **more: Any) -> BeamModel:
    """The beam model of lines that went through a file."""
    write_line_mesh(path, lines)
    return from_file(path, **more)


def renumbered(disk: BladedDiskModel, points: FloatArray) -> list[sp.csr_array]:
    """Mass and stiffness with the nodes in the order of other points."""
    away, node = KDTree(disk.mesh.points).query(points)
    assert away.max() < 1e-14
    dofs = disk.structure.node_dofs[node].ravel()
    kept = dofs[dofs >= 0]
    return [matrix[kept][:, kept] for matrix in (disk.structure.mass, disk.structure.stiffness)]


def hung() -> BeamModel:
    """Blades on rigid arms of a rim that springs join to the centre and to the frame."""
    sketch = Sketch(5)
    sketch.node("centre", 0.0, 0.0, shared=True)
    for name, radius in (("rim", 0.1), ("root", 0.12), ("tip", 0.5), ("weight", 0.45)):
        sketch.node(name, radius, 0.01 * radius)
    sketch.member("blades", "root", "tip", steel(0.01), elements=3)
    sketch.member("rim", "rim", "rim+1", steel(0.02))
    sketch.link("rim", "root")
    sketch.link("tip", "weight")
    sketch.mass("weight", 0.1)
    sketch.mass("centre", 2.0)
    sketch.spring("rim", "centre", radial=1e8, tangential=2e8, rotation=1e5)
    sketch.spring("rim", tangential=3e6)
    sketch.set("centre", "centre")
    sketch.set("tips", "tip")
    return sketch.build()


def of_example(path: Path) -> BeamModel:
    return case_beam_model(read_case(path))


OF_BEAMS = [
    path
    for path in sorted(EXAMPLES.glob("*.toml"))
    if read_case(path).bladed_disk.superelement is None and not read_case(path).joint
]
"""Cases of beams without joints, whose nodes coincide in pairs."""

MODELS: dict[str, Callable[[], BeamModel]] = {
    "varied": lambda: varied(heavy_tip=False),
    "mistuned": lambda: varied(heavy_tip=True),
    "hung": hung,
    **{path.stem: partial(of_example, path) for path in OF_BEAMS},
}


UNLIKE = ("mistuned", "mistuned_blades", "packets")
"""Those whose sectors differ."""


ROUND_TRIPS = [
    *((name, suffix) for name in ("varied", "mistuned", "hung") for suffix in WRITERS),
    *((path.stem, ".msh") for path in OF_BEAMS),
]


@pytest.mark.parametrize(("name", "suffix"), slow_except(ROUND_TRIPS, *ROUND_TRIPS[::3]))
def test_a_round_trip_gives_the_same_matrices(tmp_path: Path, name: str, suffix: str) -> None:
    model = MODELS[name]()
    path = tmp_path / f"stage{suffix}"
    lines = grouped_lines(model)
    if left_out(path, lines):
        pytest.skip("no springs and links in this format")
    again = through(path, lines, tip_radius=model.tip_radius)
    np.testing.assert_allclose(
        again.mesh.points[again.tips], model.mesh.points[model.tips], rtol=0.0, atol=1e-15
    )
    np.testing.assert_allclose(again.tip_recess, model.tip_recess, rtol=0.0, atol=1e-15)
    before, after = assembled(model), assembled(again)
    pairs = zip(
        renumbered(before, model.mesh.points), renumbered(after, model.mesh.points), strict=True
    )
    for old, new in pairs:
        assert abs(new - old).max() <= 1e-12 * abs(old).max()
    assert after.structure.is_cyclic == before.structure.is_cyclic == (name not in UNLIKE)
    old_sets = {k: len(v) for k, v in model.mesh.node_sets.items()}
    assert {k: len(v) for k, v in again.mesh.node_sets.items()} == old_sets
    parts = {k: len(v) for k, v in again.mesh.line_sets.items() if k != "lines"}
    assert parts == {k: len(v) for k, v in model.mesh.line_sets.items()}


def test_a_mesh_of_gmsh_takes_the_cyclic_path_and_gives_the_dense_frequencies() -> None:
    """Gmsh puts nodes on curves to nine digits; symmetry is found all the same."""
    model = case_beam_model(read_case(EXAMPLE))
    assert (len(model.mesh.points), len(model.tips)) == (169, 12)
    assert {k: len(v) for k, v in model.mesh.line_sets.items()} == {
        "disk": 36,
        "blades": 108,
        "shroud": 48,
    }
    assert {k: len(v) for k, v in model.mesh.node_sets.items()} == {"tips": 12, "centre": 1}
    assert model.tip_radius == pytest.approx(0.4, rel=1e-9)
    cyclic = assembled(model)
    assert cyclic.structure.is_cyclic
    mesh = replace(model.mesh, sectors=None)
    dense = assembled(replace(model, mesh=mesh))
    assert not dense.structure.is_cyclic
    stiffness, mass = (m.toarray() for m in (dense.structure.stiffness, dense.structure.mass))
    expected_values = np.sqrt(la.eigh(stiffness, mass, eigvals_only=True))
    actual = lowest_frequencies(cyclic.structure, 4)
    assert [*actual] == [*range(7)]
    for frequency in np.concatenate([*actual.values()]):
        assert np.abs(expected_values - frequency).min() <= 1e-9 * frequency


def test_mass_of_the_example_by_hand() -> None:
    """Lines by their lengths in the .geo: spokes, chords of arcs, blades of two splines."""
    model = case_beam_model(read_case(EXAMPLE))
    lengths = model.mesh.lengths
    spokes_and_rim = 12 * (0.08 + 4 * 0.08 * np.sin(np.pi / 24))
    shroud = 12 * 8 * 0.26 * np.sin(np.pi / 48)
    sets = model.mesh.line_sets
    assert lengths[sets["disk"]].sum() == pytest.approx(spokes_and_rim, rel=1e-8)
    assert lengths[sets["shroud"]].sum() == pytest.approx(shroud, rel=1e-8)
    mass = 7800.0 * 0.08 * 0.025 * spokes_and_rim + 4430.0 * 0.02 * 0.005 * shroud
    mass += 4430.0 * 0.08 * 0.006 * lengths[sets["blades"]].sum()
    assert model.mass == pytest.approx(mass, rel=1e-8)


def test_a_case_finds_its_mesh_beside_it_and_keeps_it(tmp_path: Path) -> None:
    for suffix in (".toml", ".msh"):
        shutil.copy(EXAMPLE.with_suffix(suffix), tmp_path)
    case = read_case(tmp_path / EXAMPLE.name)
    assert case.bladed_disk.mesh is not None
    assert case.bladed_disk.mesh.file == str(tmp_path / "shrouded_fan.msh")
    assert case.blades == 12
    assert case.tip_radius == pytest.approx(0.4, rel=1e-9)
    assert loads(dumps_case(case)) == case
    assert 'unit = "mm"' in dumps_case(case)  # as it was given
    assert pickle.loads(pickle.dumps(case)) == case
    assert "elements_per_blade" not in dumps_case(case)
    thick = with_values(case, {"bladed_disk.mesh.sections.blades.thickness": "8 mm"})
    assert case_beam_model(thick).mass > case_beam_model(case).mass


def test_a_unit_scales_the_mesh(tmp_path: Path) -> None:
    model = papers()
    lines = grouped_lines(model)
    inches = replace(lines, points=lines.points / 0.0254, line_data={})
    sections = dict.fromkeys(PARTS, MeshSection(width=0.1, thickness=0.01))
    again = through(tmp_path / "a.vtu", inches, unit="in", sections=sections)
    assert again.tip_radius == pytest.approx(0.5, rel=1e-12)
    np.testing.assert_allclose(again.mesh.points, model.mesh.points, atol=1e-15)


def test_blade_0_is_the_one_nearest_to_x(tmp_path: Path) -> None:
    lines = grouped_lines(varied(heavy_tip=False))
    turn = -0.3  # tips lean by 0.12, so blade 0 is below +x and still the nearest to it
    cos, sin = np.cos(turn), np.sin(turn)
    turned = replace(lines, points=lines.points @ [[cos, sin], [-sin, cos]])
    angles = assembled(through(tmp_path / "a.vtu", turned)).tip_angles
    lean = np.arctan2(0.05, 0.4)
    expected = lean + turn + 2.0 * np.pi * np.arange(7) / 7
    np.testing.assert_allclose(np.exp(1j * angles), np.exp(1j * expected), atol=1e-14)


def doubled(lines: GroupedLines) -> GroupedLines:
    """The first blade hangs on a root of its own, at the place of the true one."""
    ends = lines.lines.copy()
    ends[0, 0] = len(lines.points)
    return replace(lines, points=np.vstack([lines.points, lines.points[:1]]), lines=ends)


def same(lines: GroupedLines) -> GroupedLines:
    return lines


TOML = 'bladed_disk.mesh = {{ file = "a.vtu"{} }}'
SECTION = "{ width = 0.1, thickness = 0.01 }"
PARTS = ("blades", "spokes", "rim")

BAD: list[tuple[Callable[[GroupedLines], GroupedLines], str, str]] = [
    (same, ', tips = "tip"', 'mesh.tips = "tip": expected a group of nodes of a.vtu: "centre", "'),
    (same, ', centre = "tips"', 'expected one node in the set "centre", not 3'),
    (
        lambda lines: replace(lines, points=np.vstack([lines.points, [[0.0, 0.4]]]), node_groups={
            **lines.node_groups, "tips": np.append(lines.node_groups["tips"], len(lines.points))}),
        "",
        'mesh.tips = "tips": expected every node of the group on a line; of 4 nodes in a.vtu'
        " 1 are on no line, the first at (0, 0.4) m",
    ),
    (same, ', unit = "cm"', "mesh.sections: expected a section for all lines; 12 of 12 have none"),
    (
        lambda lines: replace(lines, line_data={}),
        "",
        "mesh.sections: expected a section for all lines; 12 of 12 have none, in 'blades', 'spok",
    ),
    (doubled, "", "most one node at each place; 1 pairs of nodes coincide, the first at (0.05, 0)"),
    (
        lambda lines: replace(lines, lines=np.vstack([lines.lines, lines.lines[:1, ::-1]]),
                              line_data={k: np.append(v, 1.0) for k, v in lines.line_data.items()}),
        "",
        "expected each line only once; 1 violate this, the first at (0.05, 0)",
    ),
    (
        lambda lines: replace(lines, points=1e3 * lines.points),
        "",
        "mesh.unit = 1.0: expected a unit that puts the tips at 0.001 m to 10 m, not at 500 m",
    ),
    (
        lambda lines: replace(lines, points=lines.points + 0.1),
        "",
        "mesh: expected the centre at the origin, not at (0.1, 0.1) m",
    ),
    (
        lambda lines: replace(lines, lines=lines.lines[:-6], line_groups={},
                              line_data={k: v[:-6] for k, v in lines.line_data.items()}),
        "",
        'mesh.centre = "centre": expected a group of nodes on lines; in a.vtu none of its',
    ),
    (
        lambda lines: replace(lines, node_data={"mass": np.full(len(lines.points), 0.1)}),
        f', unit = "cm", sections = {{ blades = {SECTION}, spokes = {SECTION}, rim = {SECTION} }}',
        'mesh.unit = "cm": expected "m", because a.vtu contains point masses, which are always',
    ),
    (
        lambda lines: replace(lines, line_data={"spring_radial": np.full(12, -1.0)}),
        "",
        "a.vtu\": expected spring_radial of zero or more, not -1",
    ),
    (same, ", sectons = {}", "mesh.sectons = {}: expected a known key; the nearest is "),
]  # fmt: skip


@pytest.mark.parametrize(("spoil", "keys", "message"), BAD, ids=[bad[2][:50] for bad in BAD])
def test_faults_of_a_mapping_are_one_line(
    tmp_path: Path, spoil: Callable[[GroupedLines], GroupedLines], keys: str, message: str
) -> None:
    stage = BladedDiskTable(blades=3, elements_per_blade=2)
    lines = grouped_lines(case_beam_model(Case(bladed_disk=stage)))
    write_line_mesh(tmp_path / "a.vtu", spoil(lines))
    path = tmp_path / "case.toml"
    path.write_text(TOML.format(keys))
    line = fault(of_example, path)
    assert message in line
    assert "bladed_disk.mesh" in line


def test_a_tip_radius_of_its_own_sets_tips_back(tmp_path: Path) -> None:
    model = through(tmp_path / "a.vtu", grouped_lines(papers()), tip_radius="501 mm")
    np.testing.assert_allclose(model.tip_recess, 1e-3, rtol=1e-12)
    table = MeshTable(file=str(tmp_path / "a.vtu"), tip_radius=0.501)
    assert Case(bladed_disk=BladedDiskTable(mesh=table)).tip_radius == 0.501


def test_other_keys_beside_a_mesh_are_refused(tmp_path: Path) -> None:
    write_line_mesh(tmp_path / "a.vtu", grouped_lines(papers()))
    path = tmp_path / "case.toml"
    path.write_text(TOML.format("") + "\nbladed_disk.blades = 12")
    expected = "not allowed together with bladed_disk.mesh; remove this key"
    assert fault(read_case, path) == f"{path}: bladed_disk.blades = 12: {expected}"


def test_what_a_file_says_of_some_lines_is_completed_by_the_material(tmp_path: Path) -> None:
    lines = grouped_lines(papers())
    modulus = np.where(np.arange(len(lines.lines)) < 220, 7e10, np.nan)
    data = {**lines.line_data, "young_modulus": modulus}
    del data["density"]
    actual = through(tmp_path / "a.vtu", replace(lines, line_data=data)).properties
    assert set(actual.density) == {7800.0}
    assert actual.young_modulus.tolist() == [7e10] * 220 + [2.1e11] * 44


def test_the_template_shows_a_mapping_on_one_line(tmp_path: Path) -> None:
    [line] = re.findall(r"^# (mesh = .*)$", template(), flags=re.MULTILINE)
    lines = grouped_lines(papers())
    write_line_mesh(tmp_path / "a.msh", replace(lines, line_data={}))
    mesh = loads(f"[bladed_disk]\n{line}", file=f"{tmp_path}/case.toml").bladed_disk.mesh
    assert mesh is not None
    assert (mesh.metres, [*mesh.sections]) == (1e-3, ["blades"])


@pytest.mark.parametrize("suffix", [".vtu", ".msh", ".inp"])
def test_sections_that_change_along_lines(tmp_path: Path, suffix: str) -> None:
    """Held as numbers of the lines, where the format has such: .inp holds those of the middle."""
    drawn = varied(heavy_tip=False)
    lines, path = grouped_lines(drawn), tmp_path / f"a{suffix}"
    assert [name for name in lines.line_data if name.endswith("_change")] == ["thickness_change"]
    actual = through(path, lines).properties
    kept = drawn.properties.thickness_change if suffix != ".inp" else np.zeros(7 * 8)
    order = np.argsort(drawn.properties.thickness, kind="stable")
    again = np.argsort(actual.thickness, kind="stable")
    np.testing.assert_array_equal(actual.thickness[again], drawn.properties.thickness[order])
    np.testing.assert_array_equal(actual.thickness_change[again], kept[order])
    assert ("thickness_change" in left_out(path, lines)) == (suffix == ".inp")


def test_a_section_in_the_case_is_one_along_its_lines(tmp_path: Path) -> None:
    lines = grouped_lines(varied(heavy_tip=False))
    own = {"blades": MeshSection(width=0.08, thickness=0.006)}
    actual = through(tmp_path / "a.vtu", lines, sections=own).properties
    assert not actual.thickness_change.any()


def test_sections_that_fall_below_zero_along_a_line(tmp_path: Path) -> None:
    lines = grouped_lines(varied(heavy_tip=False))
    change = lines.line_data["thickness_change"].copy()
    change[20] = -2.5 * lines.line_data["thickness"][20]
    broken = replace(lines, line_data={**lines.line_data, "thickness_change": change})
    line = fault(through, tmp_path / "a.vtu", broken)
    assert (
        "thickness_change smaller than twice thickness, so that neither end vanishes; line 20"
        in line
    )
