"""What a mesh suggests: cut faces, axis, clamped nodes, units; and the command made of it."""

import re
import shlex
from pathlib import Path

import meshio
import numpy as np
import pytest
from command_line import answer, refusal
from long_cases import slow_except
from places import EXAMPLES
from solid_meshes import (
    SECTORS,
    STEEL,
    TIE,
    Array,
    bladed_sector,
    cantilever,
    deck,
    deck_text,
    grid_mesh,
    wheel_frequencies,
)

import bladewhirl as bw
from bladewhirl.meshes.files.volumes import read_volume_mesh
from bladewhirl.models.inputs.errors import Hint
from bladewhirl.models.solids.sectors import find_sector
from bladewhirl.models.superelements.frequencies import frequencies_by_diameter

MATERIAL = """*ELSET, ELSET=HUB
all
*MATERIAL, NAME=steel
*ELASTIC
2.1e5, 0.3
*DENSITY
7.8e-9
*SOLID SECTION, ELSET=all, MATERIAL=steel
"""
CALCULIX = [
    [777.1096, 1992.991, 2861.722, 2967.148],
    [782.7945, 1782.657, 2933.495, 3291.776],
    [783.8342, 2016.255, 2938.521, 3371.408],
    [784.1245, 2785.271, 2984.931, 3827.632],
    [784.0397, 2890.396, 3075.696, 4573.747],
    [783.9218, 2901.311, 3108.154, 4994.086],
]
"""Frequencies of examples/sector.inp [Hz], nodal diameters 0 to 5, by CalculiX 2.20, with BORE
held, *TIE, CYCLIC SYMMETRY between LEFT and RIGHT, and *CYCLIC SYMMETRY MODEL, N=23."""
ORDER = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}
"""Coordinates of a mesh about z that become x, y and z of the same mesh about another axis."""


def turned(mesh: meshio.Mesh, axis: str) -> meshio.Mesh:
    return meshio.Mesh(mesh.points[:, ORDER[axis]], mesh.cells, point_sets=mesh.point_sets)


def at_angle(radius: Array, pitches: Array, height: Array) -> Array:
    """Return positions at radii, angles in pitches of a sector, and heights, (n, 3)."""
    angle = 2.0 * np.pi / SECTORS * pitches
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)


def wheel(mesh: meshio.Mesh) -> meshio.Mesh:
    """Return a wheel of copies of a sector whose faces are not joined."""
    angles = 2.0 * np.pi / SECTORS * np.arange(SECTORS)
    x, y, z = mesh.points.T
    turns = [(np.cos(a) * x - np.sin(a) * y, np.sin(a) * x + np.cos(a) * y, z) for a in angles]
    (block,) = mesh.cells
    cells = [block.data + n * len(mesh.points) for n in range(SECTORS)]
    return meshio.Mesh(
        np.concatenate([np.stack(one, axis=1) for one in turns]),
        [(block.type, np.concatenate(cells))],
    )


@pytest.mark.parametrize("kind", ["tetra", "tetra10", "wedge15", "hexahedron20", "hexahedron27"])
def test_cut_faces_are_found(kind: str) -> None:
    mesh = bladed_sector(kind)
    sector = find_sector(read_volume_mesh(mesh))
    assert sector is not None
    assert sector.copies == SECTORS
    volumes = read_volume_mesh(mesh)
    for side, name in ((sector.left, "left"), (sector.right, "right")):
        assert side.tolist() == volumes.groups[name].tolist()
    assert find_sector(volumes, SECTORS + 1) is None
    assert not len(sector.unmatched)


def test_cut_faces_that_match_in_part_are_named(tmp_path: Path) -> None:
    """They would be open where nodes do not match."""
    mesh = bladed_sector("hexahedron")
    moved = np.flatnonzero(np.isin(np.arange(len(mesh.points)), mesh.point_sets["right"]))
    mesh.points[moved[np.hypot(*mesh.points[moved, :2].T).argmax()], 2] *= 0.9
    path = deck(tmp_path, mesh, "C3D8")
    expected = "cut faces match in part: . nodes that touch the next sector, at radii from"
    assert re.search(expected, " ".join(answer("mesh", path).stdout.split()))
    with pytest.warns(Hint, match=expected):
        bw.mesh3d(path, **STEEL, copies=SECTORS)


def test_sides_of_a_blade_are_not_taken_for_cut_faces_that_do_not_match(tmp_path: Path) -> None:
    """They match after 1/36 of a turn, by which sectors would overlap."""
    mesh = grid_mesh(
        (5, 3, 1),
        lambda place: at_angle(0.05 + 0.1 * place[:, 0], place[:, 1] - 0.5, 0.02 * place[:, 2]),
        "hexahedron20",
        lambda centre: centre[0] < 0.4 or 1 / 3 < centre[1] < 2 / 3,
        moved=lambda place: (place[:, 0] == 0.2) & (place[:, 1] == 1.0),
    )
    path = deck(tmp_path, mesh, "C3D20R")
    assert f"--copies {SECTORS} " in answer("mesh", path).stdout
    mesh.points[mesh.point_sets["moved"], :2] *= 1.1
    path = deck(tmp_path, mesh, "C3D20R")
    printed = " ".join(answer("mesh", path).stdout.split())
    missed = "about -15 and 15 degrees bound 1/12 of a turn, but their 13 and 13 nodes do not match"
    assert missed in printed
    assert "--copies '?' " in printed
    refused = refusal("mesh3d", path, "--copies", "?")
    assert refused.startswith("--copies ?: expected a whole number, of the sectors")
    for copies in (SECTORS, 3 * SECTORS):
        with pytest.raises(bw.CaseError, match=f"{missed}.*0.007 m from the nearest"):
            bw.mesh3d(path, **STEEL, clamped="r < 0.051", contact="outermost", copies=copies)


@pytest.mark.parametrize("corner", [(0.0, 0.0, 0.0), (-0.05, -0.05, -0.05), (1.0, 0.2, 0.3)])
def test_the_geometry_of_a_cube_does_not_tell_the_axis(
    corner: tuple[float, float, float], tmp_path: Path
) -> None:
    mesh = grid_mesh((1, 1, 1), lambda place: corner + 0.1 * place, "hexahedron")
    printed = " ".join(answer("mesh", deck(tmp_path, mesh, "C3D8")).stdout.split())
    assert "axis: the geometry does not tell it" in printed
    assert "--axis '?'" in printed


@pytest.mark.parametrize("mesh", [cantilever("hexahedron20"), wheel(bladed_sector("tetra10"))])
def test_blades_and_wheels_have_no_cut_faces(mesh: meshio.Mesh) -> None:
    for axis in ORDER:
        assert find_sector(read_volume_mesh(turned(mesh, axis))) is None


def test_a_sector_that_reaches_the_axis_is_proposed_with_clamped_nodes_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A prism at the axis and two bricks, a twelfth of a disk."""
    monkeypatch.chdir(tmp_path)
    half = np.pi / SECTORS
    sides = [(r * np.cos(a), r * np.sin(a)) for r in (0.05, 0.1, 0.15) for a in (-half, half)]
    points = [(x, y, z) for z in (0.0, 0.02) for x, y in [(0.0, 0.0), *sides]]
    prism, bricks = [0, 1, 2], [[1, 3, 4, 2], [3, 5, 6, 4]]
    mesh = meshio.Mesh(
        np.array(points),
        [
            ("wedge", np.array([[*prism, *(n + 7 for n in prism)]])),
            ("hexahedron", np.array([[*one, *(n + 7 for n in one)] for one in bricks])),
        ],
    )
    mesh.write("disk.vtu")
    printed = answer("mesh", "disk.vtu").stdout
    assert f"match after 1/{SECTORS} of a turn about z and meet on it" in " ".join(printed.split())
    [line] = [one for one in printed.splitlines() if " mesh3d " in one]
    for key, value in STEEL.items():
        option = f"--{key.replace('_', '-')}"
        line = line.replace(f"{option} '?'", f"{option} {shlex.quote(str(value))}")
    answer(*shlex.split(line)[1:])
    part = bw.read_superelement("disk.npz")
    assert part.sectors == SECTORS
    assert part.size == 36  # all nodes but those on the axis


@pytest.mark.parametrize("axis", slow_except(["x", "y", "z"], "x"))
@pytest.mark.parametrize("named", [True, False])
def test_a_proposal_pasted_as_it_is_makes_the_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, axis: str, named: bool
) -> None:
    monkeypatch.chdir(tmp_path)
    mesh = turned(bladed_sector("hexahedron20"), axis)
    mesh.points = 1e3 * mesh.points
    if not named:
        mesh.point_sets = {}
    Path("my deck.inp").write_text(deck_text(mesh, "C3D20R") + MATERIAL)
    [line] = [one for one in answer("mesh", "my deck.inp").stdout.splitlines() if " mesh3d " in one]
    words = shlex.split(line)
    assert words[words.index("--copies") + 1] == str(SECTORS)
    assert ("--left" in words) == named
    assert ("--clamped root" in line) == named  # never the volume HUB
    printed = " ".join(answer(*words[1:]).stdout.split())
    part = bw.read_superelement("my deck.npz")
    assert part.command == line.replace(" --clamped root --contact tip", "")  # the defaults
    assert part.sectors == SECTORS
    direct = bw.mesh3d(deck(tmp_path, bladed_sector("hexahedron20"), "C3D20R"), **STEEL, **TIE)
    expected = wheel_frequencies(direct, SECTORS, 3)
    assert wheel_frequencies(part, SECTORS, 3) == pytest.approx(expected, rel=1e-6)
    assert f"0 {expected[0, 0]:.6g} {expected[0, 1]:.6g}" in printed
    assert Path("my deck.png").stat().st_size > 10_000


def test_the_shipped_deck_has_the_frequencies_of_calculix(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To a unit of its last digit, by the command as printed; the case has Coriolis forces."""
    monkeypatch.chdir(tmp_path)
    Path("sector.inp").write_text((EXAMPLES / "sector.inp").read_text())
    printed = answer("mesh", "sector.inp").stdout
    [line] = [one for one in printed.splitlines() if " mesh3d " in one]
    answer(*shlex.split(line)[1:])
    part = bw.read_superelement("sector.npz")
    found = [*frequencies_by_diameter(part, 4, range(6))]
    assert np.array(found) == pytest.approx(np.array(CALCULIX), rel=5e-7)
    answer("new", "sector.toml", "--from", "sector.npz")
    assert bw.read_case("sector.toml").rotation.effects == "full"


def test_what_is_not_known_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    mesh = cantilever("hexahedron20")
    mesh.point_sets = {}
    mesh.write("blade.vtu")
    printed = answer("mesh", "blade.vtu").stdout
    [line] = [one for one in printed.splitlines() if " mesh3d " in one]
    options = shlex.split(line.replace(" --coriolis", ""))[2:]
    given = dict(zip(options[1::2], options[2::2], strict=True))
    values = {
        "--axis": "z",
        "--young-modulus": "210 GPa",
        "--poisson-ratio": "0.3",
        "--density": "7800",
        "--clamped": "x = 0.2",
        "--contact": "x = 0.3",
    }
    assert {option for option, value in given.items() if value == "?"} == {*values}
    while unknown := [option for option, value in given.items() if value == "?"]:
        line = refusal("mesh3d", "blade.vtu", *(word for pair in given.items() for word in pair))
        key = line.split(" ")[0].replace("_", "-")
        assert f"--{key}" in unknown
        assert not Path("blade.npz").exists()
        given[f"--{key}"] = values[f"--{key}"]
    answer("mesh3d", "blade.vtu", *(word for pair in given.items() for word in pair))
    assert Path("blade.npz").exists()


def test_a_wheel_in_one_piece_becomes_a_case(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    whole = turned(wheel(bladed_sector("tetra")), "y")
    Path("wheel.inp").write_text(deck_text(whole, "C3D4") + MATERIAL.replace("2.1e5", "2.1e11"))
    Path("wheel.inp").write_text(Path("wheel.inp").read_text().replace("7.8e-9", "7800"))
    printed = answer("mesh", "wheel.inp").stdout
    [line] = [one for one in printed.splitlines() if " mesh3d " in one]
    assert "axis: the mesh is a whole wheel about y" in printed
    chosen = f"--clamped 'r < 0.051 m' --contact outermost --copies {SECTORS} --axis y --coriolis"
    assert line.endswith(f"{chosen} -o wheel.npz")
    answer(*shlex.split(line)[1:])
    answer("new", "wheel.toml", "--from", "wheel.npz")
    table = bw.read_case("wheel.toml").bladed_disk.superelement
    assert table is not None
    assert (table.kind, table.copies) == ("wheel", SECTORS)


@pytest.mark.slow
def test_a_wheel_in_one_piece_has_the_modes_of_its_sector(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    sector = bladed_sector("hexahedron20")
    # Nodes in another order, so that those of a blade do not follow each other.
    whole, number = (
        wheel(sector),
        np.random.default_rng(1).permutation(SECTORS * len(sector.points)),
    )
    points = np.empty_like(whole.points)
    points[number] = whole.points
    (block,) = whole.cells
    points = points.round(7)  # as decks with seven digits
    mixed = meshio.Mesh(points, [(block.type, number[block.data])])
    with pytest.warns(Hint, match="nodes merged"):
        part = bw.mesh3d(
            *(mixed,), **STEEL, clamped="r < 0.051", contact="outermost", contacts=3, copies=SECTORS
        )
    assert part.contacts == 3 * SECTORS
    angle = part.contact_angle.reshape(SECTORS, 3)
    pitch = 2.0 * np.pi / SECTORS
    assert np.ptp(np.unwrap(angle, period=2.0 * np.pi), axis=1).max() < pitch
    assert np.diff(angle, axis=0) % (2.0 * np.pi) == pytest.approx(pitch)
    bw.write_superelement("wheel.npz", part)
    answer("new", "wheel.toml", "--from", "wheel.npz")
    Path("still.toml").write_text(Path("wheel.toml").read_text().replace("centrifugal", "none"))
    listed = bw.modes(bw.read_case("still.toml"), count=6)
    direct = bw.mesh3d(sector, **STEEL, left="left", right="right", copies=SECTORS)
    expected = wheel_frequencies(direct, SECTORS, 1)[:, 0]
    for k, frequency in enumerate(expected[:2]):
        own = listed.frequency.sel(family="1F", nodal_diameter=k).values
        assert own == pytest.approx(frequency, rel=1e-3)
    [(met, k)] = re.findall(
        "meets (.*) Hz, the lowest frequency of nodal diameter (.)", Path("wheel.toml").read_text()
    )
    assert float(met) == pytest.approx(expected[int(k)], rel=1e-3)


def test_blades_that_do_not_repeat_are_refused(tmp_path: Path) -> None:
    with pytest.raises(bw.CaseError, match="contact nodes do not lie on others"):
        bw.mesh3d(
            *(wheel(bladed_sector("tetra")),), **STEEL,
            clamped="r < 0.051", contact="outermost", copies=5,
        )  # fmt: skip
