"""Bladed disks drawn part by part: what comes out, and what is refused by name."""

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from faults import faults
from stages import beam, bladed_disk, clamped, natural_frequencies, steel, translation

from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import loads
from bladewhirl.models.case.sketch import SketchNode
from bladewhirl.models.case.template import dumps_case
from bladewhirl.models.elements.bladed_disk import assemble_bladed_disk
from bladewhirl.models.geometry.sketch import Sketch
from bladewhirl.models.sections.rectangular import Section


def star(sectors: int = 5, elements: int = 2) -> Sketch:
    """Blades on spokes, without a rim."""
    sketch = Sketch(sectors)
    sketch.node("centre", 0.0, 0.0, shared=True)
    sketch.node("root", "50 mm")
    sketch.node("tip", 0.5)
    sketch.member("blades", "root", "tip", steel(0.01), elements=elements)
    sketch.member("spokes", "centre", "root", steel(0.03))
    sketch.set("centre", "centre")
    sketch.set("tips", "tip")
    return sketch


def test_the_stage_of_the_paper_reads_like_a_sketch() -> None:
    sketch = star(22, elements=10)
    sketch.member("rim", "root", "root+1", steel(0.03))
    drawn = assemble_bladed_disk(sketch.build(), shaft_stiffness=3.4e7, clamped=False)
    known = bladed_disk(disk_thickness=0.03)
    np.testing.assert_array_equal(drawn.mesh.points, known.mesh.points)
    np.testing.assert_array_equal(drawn.mesh.lines, known.mesh.lines)
    assert abs(drawn.structure.stiffness - known.structure.stiffness).max() == 0.0
    assert repr(drawn.model) == "<BeamModel: 243 nodes, 264 lines, 22 tips, 110.3 kg>"


def test_a_case_holds_a_sketch_in_full() -> None:
    sketch = star()
    sketch.mass("tip", "20 g", inertia=1e-6)
    sketch.spring("root", "root+1", radial="1 kN/m", rotation=3.0)
    sketch.move(1, "tip", 0.51, 0.02)
    sketch.change(2, "blades", stiffness=1.1, section=[steel(0.012), steel(0.008)])
    case = Case(sketch=sketch.table)
    again = loads(dumps_case(case))
    assert again == case
    assert again.blades == 5
    assert again.tip_radius == pytest.approx(np.hypot(0.51, 0.02))
    one, other = sketch.build(), Sketch.build(sketch)
    np.testing.assert_array_equal(one.mesh.points, other.mesh.points)


def test_one_sector_can_differ() -> None:
    sketch = star(elements=4)
    sketch.move(3, "tip", 0.48)
    sketch.change(1, "blades", stiffness=2.0, mass=3.0)
    model, tuned = sketch.build(), star(elements=4).build()
    assert model.mesh.sectors is not None
    np.testing.assert_allclose(model.tip_recess, [0, 0, 0, 0.02, 0], atol=1e-15)
    assert model.tip_radius == 0.5
    blade = model.mesh.line_sets["blades"].reshape(5, 4)
    lengths = model.mesh.lengths[blade]
    np.testing.assert_allclose(lengths[3], 0.43 / 4)
    np.testing.assert_allclose(lengths[[0, 1, 2, 4]], 0.45 / 4)
    for name, factor in (("bending_stiffness", 2.0), ("axial_stiffness", 2.0), ("line_mass", 3.0)):
        expected = getattr(tuned.properties, name).copy()
        expected[blade[1]] *= factor
        np.testing.assert_allclose(getattr(model.properties, name), expected, rtol=1e-15)


def test_a_quarter_arc_under_a_load_at_its_end() -> None:
    """Thin curved beam, bending alone counts: pi/4 F R^3 / EI along the load at the end.

    The load pulls along the radius of the clamp; Castigliano's theorem for a quarter circle
    gives v = (3 pi / 4 - 2) F R^3 / EI across and pi/4 along.
    """
    section, radius = steel(0.002), 1.0
    errors = []
    for elements in (8, 16, 32):
        sketch = Sketch()
        # Clamped at the origin with the tangent along +x, it ends at (R, R) going up.
        sketch.node("clamp", 0.0, shared=True)
        sketch.node("end", radius, radius)
        angle = np.linspace(-np.pi / 2.0, 0.0, 41)[1:-1]
        path = np.column_stack([radius * np.cos(angle), radius + radius * np.sin(angle)])
        sketch.member("arc", "clamp", "end", section, elements=elements, path=path.tolist())
        sketch.set("centre", "clamp")
        sketch.set("tips", "end")
        disk = clamped(sketch)
        force = np.zeros(disk.structure.size)
        # Down along -y at the end: the moment at angle s from the end is F R (1 - cos s).
        axis = disk.mesh.node_axes[disk.model.tips[0]]
        force[disk.tip_radial[0]], force[disk.tip_tangential[0]] = -np.sin(axis), -np.cos(axis)
        actual = np.linalg.solve(disk.structure.stiffness.toarray(), force)
        end = disk.cartesian(actual[:, None])[disk.model.tips[0], :, 0]
        exact = (3.0 * np.pi / 4.0 - 2.0) * radius**3 / section.bending_stiffness
        errors.append(abs(-end[1] / exact - 1.0))
    assert errors[-1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.2)


def test_rotary_inertia_of_a_mass() -> None:
    """A light beam with a heavy disk at its end: the 2 x 2 eigenproblem of the end alone."""
    section = Section(width=0.1, thickness=0.01, young_modulus=2.1e11, density=1e-6)
    sketch = beam(section, 3)
    sketch.mass("clamp", 5.0)  # without inertia
    sketch.mass("end", 2.0, inertia=0.3)
    assert sketch.build().masses.inertia.tolist() == [0.0, 0.3]
    bending = section.bending_stiffness
    stiffness = bending * np.array([[12.0, -6.0], [-6.0, 4.0]])
    expected = np.sqrt(la.eigvalsh(stiffness, np.diag([2.0, 0.3])))
    np.testing.assert_allclose(natural_frequencies(clamped(sketch))[:2], expected, rtol=1e-6)


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_rigid_arm_moves_its_end_as_a_beam_of_great_stiffness_does(angle: float) -> None:
    actual = []
    for stiff in (False, True):
        sketch = Sketch()
        sketch.node("clamp", 0.0, shared=True)
        sketch.node("knee", 0.6)
        sketch.node("end", 0.6 + 0.2 * np.cos(angle), 0.2 * np.sin(angle) + 0.1)
        sketch.node("tip", 0.9, 0.4)
        sketch.member("beam", "clamp", "knee", steel(0.01), elements=3)
        sketch.member("outer", "end", "tip", steel(0.01), elements=3)
        if stiff:
            arm = Section(width=1.0, thickness=1.0, young_modulus=1e12, density=1e-9)
            sketch.member("arm", "knee", "end", arm)
        else:
            sketch.link("knee", "end")
        sketch.set("centre", "clamp")
        sketch.set("tips", "tip")
        disk = clamped(sketch)
        force = np.zeros((disk.structure.size, 2))
        force[disk.tip_radial[0], 0] = force[disk.tip_tangential[0], 1] = 1.0
        field = disk.cartesian(np.linalg.solve(disk.structure.stiffness.toarray(), force))
        # Node numbers differ between the two; places do not.
        order = np.lexsort(disk.mesh.points.round(9).T)
        actual.append((field[order], natural_frequencies(disk)[:4]))
    largest = abs(actual[0][0]).max()
    np.testing.assert_allclose(actual[0][0], actual[1][0], atol=1e-5 * largest)
    np.testing.assert_allclose(actual[0][1], actual[1][1], rtol=1e-5)


def test_springs_act_between_nodes_and_to_the_frame() -> None:
    sketch = star(3, elements=1)
    sketch.spring("tip", radial=10.0, tangential=20.0, rotation=30.0)
    sketch.spring("root", "root+1", radial=3.0, tangential=5.0)
    bare = assemble_bladed_disk(star(3, 1).build(), shaft_stiffness=1e6, clamped=False)
    disk = assemble_bladed_disk(sketch.build(), shaft_stiffness=1e6, clamped=False)
    added = (disk.structure.stiffness - bare.structure.stiffness).toarray()
    tips = disk.structure.node_dofs[disk.model.tips]
    np.testing.assert_allclose(np.diag(added)[tips], [[10.0, 20.0, 30.0]] * 3, rtol=1e-6)
    assert disk.structure.is_cyclic
    # A translation of the whole strains only what leads to the frame.
    field = translation(disk, 1.0, 0.0)
    expected = 10.0 * 1.5 + 20.0 * 1.5  # cos^2 and sin^2 over three blades
    assert field @ added @ field == pytest.approx(expected, rel=1e-6)


def _loose(sketch: Sketch) -> None:
    sketch.node("a", 0.3, 0.1)
    sketch.node("b", 0.4, 0.1)
    sketch.member("debris", "a", "b", steel(0.01))


def _twice_changed(sketch: Sketch) -> None:
    sketch.change(0, "blades", stiffness=1.1)
    sketch.change(0, "blades", mass=1.2)


def _changed_where_it_is_not(sketch: Sketch) -> None:
    sketch.member("rim", "root", "root+1", steel(0.01), sectors=[0, 2])
    sketch.change(1, "rim", mass=2.0)


def _shaft(sketch: Sketch, **more: Any) -> None:
    sketch.node("hub", 0.01, shared=True)
    sketch.member("shaft", "centre", "hub", steel(0.01), **more)


BAD: list[tuple[Callable[[Sketch], object], str]] = [
    (_loose, r"joined to the centre; part 'debris' at \(0\.3, 0\.1\) m is not"),
    (lambda s: s.node("spare", 0.2), "node 'spare': expected a member, a link or a spring at this"),
    (lambda s: s.member("rim", "root", "root+1"), "member 'rim': expected either a section"),
    (
        lambda s: s.move(2, "tip", 0.05),
        "member 'blades' in sector 2: expected different consecutive",
    ),
    (
        lambda s: s.member("rim", "root", "rood", steel(0.01)),
        r"member 'rim': expected a node of the sketch \(centre, root, tip\), not 'rood'",
    ),
    (lambda s: s.mass("tip", -1.0), r"masses 'tip'.mass = -1\.0: expected a number of zero or"),
    (lambda s: s.move(7, "tip", 0.4), "edit of sector 7: expected a sector from 0 to 4"),
    (lambda s: s.link("root", "tip"), 'a set "tips" of nodes that are not tied'),
    (
        lambda s: s.member("rim", "root", "root+1", steel(0.01), sectors=[0, 0]),
        "member 'rim': expected sectors from 0 to 4, each at most once",
    ),
    (
        _twice_changed,
        "edit of member 'blades' in sector 0: expected at most one edit for each part",
    ),
    (lambda s: s.move(2, "centre", 0.1), "'centre' in sector 2: expected sector 0: shared parts"),
    (_changed_where_it_is_not, r"'rim' in sector 1: expected a sector with this part \(0, 2\)"),
    (
        lambda s: s.mass("centre", 1.0, sectors=[1, 2]),
        "mass at 'centre': not allowed with a list of sectors",
    ),
    (lambda s: _shaft(s, sectors=[3]), "member 'shaft': not allowed with a list of sectors"),
    (
        lambda s: s.member("again", "centre", "root", steel(0.01)),
        r"one beam between two nodes; 'spokes' and 'again' coincide between node",
    ),
    (lambda s: s.node("a", "1 kg"), r"at\[0\] = \"1 kg\": expected a finite number in m"),
]


@pytest.mark.parametrize(("spoil", "message"), BAD, ids=[message[:40] for _, message in BAD])
def test_faults_name_the_part(spoil: Callable[[Sketch], object], message: str) -> None:
    sketch = star()

    def build() -> None:
        spoil(sketch)
        sketch.build()

    assert re.search(message, "\n".join(faults(build)))


def test_sectors_of_two_blades_are_found_to_be_two_sectors() -> None:
    sketch = Sketch(3)
    sketch.node("centre", 0.0, 0.0, shared=True)
    for blade, turn in enumerate((0.0, np.pi / 3.0)):
        sketch.node(f"tip {blade}", 0.4 * np.cos(turn), 0.4 * np.sin(turn))
        sketch.member(f"blade {blade}", "centre", f"tip {blade}", steel(0.02), elements=2)
    sketch.set("centre", "centre")
    sketch.set("tips", "tip 0", "tip 1")
    actual = assemble_bladed_disk(sketch.build(), shaft_stiffness=1e7, clamped=False)
    assert actual.structure.symmetry == "6 equal sectors: cyclic path"
    sketch.mass("tip 1", 0.1)
    actual = assemble_bladed_disk(sketch.build(), shaft_stiffness=1e7, clamped=False)
    assert actual.structure.symmetry == "6 sectors that differ: dense path"


def test_a_node_may_be_at_a_radius_and_an_angle() -> None:
    node = SketchNode.model_validate({"name": "tip", "at": ["120 mm", "30 deg"]})
    assert node.at == pytest.approx((0.12 * np.cos(np.pi / 6.0), 0.06))
    assert SketchNode.model_validate({"name": "tip", "at": [0.1, "2 mm"]}).at == (0.1, 0.002)
