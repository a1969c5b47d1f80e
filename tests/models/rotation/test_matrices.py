"""What rotation adds to bladed disks of all parts: closed forms, invariances, measured orders."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from stages import bladed_disk, steel, translation

from bladewhirl.models.elements.bladed_disk import BladedDiskModel, assemble_bladed_disk
from bladewhirl.models.elements.cyclic import SectorLayout
from bladewhirl.models.elements.structure import Structure
from bladewhirl.models.geometry.sketch import Sketch
from bladewhirl.models.modal.whirl_modes import WhirlModes, directions, travelling, whirl_modes
from bladewhirl.models.rotation.at_speed import speed_of_growth
from bladewhirl.models.rotation.internal_growth import internal_growth
from bladewhirl.models.rotation.matrices import rotation_matrices
from bladewhirl.models.sections.rectangular import Section
from bladewhirl.models.structure.eigenproblems import (
    damped_eigenvalues,
    lowest_gyroscopic_eigen,
    modal_damping,
)

THREAD = Section(width=1e-4, thickness=1e-4, young_modulus=1.0, density=1e-3)


def assembled(sketch: Sketch, *, stiffness: Any = 3.4e7, clamped: bool = False) -> BladedDiskModel:
    return assemble_bladed_disk(sketch.build(), shaft_stiffness=stiffness, clamped=clamped)


def fan(blades: int = 4) -> Sketch:
    """Blades of all kinds of parts: curved, tapered, shrouded, with masses, links and springs."""
    sketch = Sketch(blades)
    sketch.node("hub", 0.0, 0.0, shared=True)
    sketch.node("root", 0.1)
    sketch.node("pad", 0.11, 0.02)
    sketch.node("middle", 0.3, 0.02)
    sketch.node("tip", 0.5)
    sketch.node("cap", 0.49, 0.03)
    sketch.spring("root", "hub", radial=5e8, tangential=2e8, rotation=1e5)
    sketch.member("rim", "root", "root+1", steel(0.03), elements=2)
    sketch.link("root", "pad")
    sketch.member("inner", "pad", "middle", [steel(0.02), steel(0.012)], elements=4)
    sketch.member("outer", "middle", "tip", steel(0.01), elements=4, path=[(0.42, 0.015)])
    sketch.member("shroud", "middle", "middle+1", steel(0.008), elements=2)
    sketch.mass("tip", 0.2, inertia=1e-3)
    sketch.mass("hub", 5.0)
    sketch.link("tip", "cap")
    sketch.mass("cap", 0.1)
    sketch.set("centre", "hub")
    sketch.set("tips", "tip")
    return sketch


@pytest.mark.parametrize("disk", [bladed_disk(), assembled(fan())], ids=["table 1", "fan"])
def test_a_mass_that_moves_outward_is_pushed_backward(disk: BladedDiskModel) -> None:
    matrices = rotation_matrices(disk)
    along, across = translation(disk, 1.0, 0.0), translation(disk, 0.0, 1.0)
    assert along @ matrices.coriolis @ across == pytest.approx(-disk.model.mass, rel=1e-9)
    assert along @ matrices.translated @ along == pytest.approx(disk.model.mass, rel=1e-9)
    assert abs(matrices.coriolis + matrices.coriolis.T).max() == 0.0
    # The whole disk, moved aside, is in balance about its own centre: no load, no growth.
    assert along @ matrices.loads[:, 0] == pytest.approx(0.0, abs=1e-9 * disk.model.mass)


def test_at_rest_nothing_changes() -> None:
    disk = bladed_disk()
    matrices = rotation_matrices(disk)
    assert matrices.at(240.0, "none").stiffness_speed is None
    rest = matrices.at(0.0, "full")
    assert abs(rest.stiffness - disk.structure.stiffness).max() == 0.0
    assert abs(rest.drag(0.0)).max() == 0.0
    assert abs(matrices.translated - disk.structure.mass).max() == 0.0


def test_rotary_inertia_of_point_masses_is_not_pulled_at() -> None:
    disk = assembled(fan())
    added = disk.structure.mass - rotation_matrices(disk).translated
    tips = disk.structure.node_dofs[disk.model.tips, 2]
    np.testing.assert_allclose(added.diagonal()[tips], 1e-3)
    assert added.sum() == pytest.approx(4e-3)


def test_a_pendulum_on_a_rigid_link() -> None:
    """A mass m on an arm a, hinged at radius R on a spring c: c + Omega^2 m R a over m a^2."""
    sketch = Sketch(3)
    sketch.node("hub", 0.0, 0.0, shared=True)
    sketch.node("hinge", 0.4)
    sketch.node("bob", 0.5)
    sketch.spring("hinge", "hub", radial=1e12, tangential=1e12)
    sketch.spring("hinge", rotation=2e3)
    sketch.member("stub", "hub", "hinge", THREAD)
    sketch.link("hinge", "bob")
    sketch.mass("bob", 2.0)
    sketch.mass("hinge", 5.0)
    sketch.set("centre", "hub")
    sketch.set("tips", "hinge")
    matrices = rotation_matrices(assembled(sketch, clamped=True))
    for omega in (0.0, 300.0):
        structure = matrices.at(omega, "centrifugal")
        square = la.eigvalsh(structure.stiffness.toarray(), structure.mass.toarray())[0]
        assert square == pytest.approx(
            (2e3 + omega**2 * 2.0 * 0.4 * 0.1) / (2.0 * 0.1**2), rel=1e-5
        )


@pytest.mark.parametrize("effects", ["centrifugal", "full"])
def test_sector_by_sector_or_all_at_once(effects: Any) -> None:
    """A fan of all parts; the modes with most of their shape are the same waves."""
    structure = rotation_matrices(assembled(fan(5))).at(400.0, effects)
    assert structure.is_cyclic
    by_sector, whole = whirl_modes(structure, 25), plain(structure, 25)
    np.testing.assert_allclose(whole.frequency, by_sector.frequency, rtol=1e-8)
    if effects == "full":
        assert whole.direction == by_sector.direction
        np.testing.assert_array_equal(whole.nodal_diameter, by_sector.nodal_diameter)
    fields = by_sector.fields(np.arange(25))
    for p, w in zip(fields.T, by_sector.frequency, strict=True):
        turning = 1j * w * (structure.drag(400.0) @ p)
        rest = structure.stiffness @ p + turning - w**2 * (structure.mass @ p)
        assert la.norm(rest) < 1e-7 * la.norm(structure.stiffness @ p)
        assert (p.conj() @ structure.mass @ p).real == pytest.approx(1.0)


def plain(structure: Structure, count: int) -> WhirlModes:
    """Modes found without symmetry."""
    bare = replace(structure)
    object.__setattr__(bare, "is_cyclic", False)
    return whirl_modes(bare, count)


def test_waves_are_seen_from_the_static_frame() -> None:
    """Tips looked at whenever the disk has turned by one sector, from places that stand still."""
    sectors, omega = 5, -400.0
    disk = assembled(fan(sectors))
    modes = whirl_modes(rotation_matrices(disk).at(omega, "full"), 25)
    pitch, places = 2.0 * np.pi / sectors, np.arange(sectors)
    time = pitch / abs(omega)
    branches = np.rec.fromarrays([modes.nodal_diameter, modes.direction])
    for branch in np.unique(branches):  # ascending frequencies, so from the lowest
        own = modes.rank[branches == branch]
        np.testing.assert_array_equal(own, np.arange(len(own)))
    actual = modes.static_frequency(omega), modes.named_directions(omega)[1]
    fields = modes.fields(np.arange(modes.count))[disk.tip_radial]
    for mode, (w, static, way) in enumerate(zip(modes.frequency, *actual, strict=True)):
        k = modes.nodal_diameter[mode]
        if modes.direction[mode] == "standing":
            assert (k, static, way) == (0, w, "standing")
            continue
        seen = [
            np.roll((fields[:, mode] * np.exp(1j * w * n * time)).real, n * int(np.sign(omega)))
            for n in (0, 1)
        ]
        waves = np.array(seen) @ np.exp(-1j * k * places * pitch)
        assert waves[1] / waves[0] == pytest.approx(np.exp(1j * static * time))
        assert way == ("forward" if static > 0.0 else "backward")  # in the sense of rotation
    assert directions(np.array([1.0, -1.0, 1e-4, -1e-4]), omega) == (
        *("backward", "forward", "standing", "standing"),
    )


def test_waves_are_told_apart_in_fields_that_mix_them() -> None:
    """Shares by mass of waves both ways, the centre's motion among those of one nodal diameter."""
    layout = SectorLayout(sector_dofs=np.arange(3, 13).reshape(5, 2), centre_dofs=np.arange(3))
    weights = np.array([9.0, 9.0, 1.0, *np.tile([1.0, 4.0], 5)])
    one, two = (layout.basis(k).toarray() for k in (1, 2))
    centre, light, heavy = one[:, 2], two[:, 0], two[:, 1]
    none = layout.basis(0).toarray()[:, 0]
    fields = [
        centre + 4.0 * light.conj(),  # masses 9 and 16
        2.0 * centre + centre.conj() + one[:, 0],
        1.2 * heavy + heavy.conj() + none,
        centre.conj(),
    ]
    diameter, purity, ways = travelling(np.stack(fields, axis=1), weights, layout)
    np.testing.assert_array_equal(diameter, [2, 1, 2, 1])
    np.testing.assert_allclose(purity, [16 / 25, 1.0, 4 * 2.44 / (4 * 2.44 + 1), 1.0])
    assert ways == ["forward", "backward", "standing", "forward"]


def test_large_structures_have_their_lowest_modes_found() -> None:
    structure = rotation_matrices(assembled(fan(5))).at(400.0, "full")
    w, fields = lowest_gyroscopic_eigen(
        structure.mass, structure.stiffness, structure.drag(400.0), 20
    )
    actual = whirl_modes(structure, 10).frequency
    np.testing.assert_allclose(np.sort(np.abs(w.real))[::2], actual, rtol=1e-8)
    assert np.abs(w.imag).max() < 1e-6
    norms = np.einsum("im,im->m", fields.conj(), structure.mass @ fields).real
    np.testing.assert_allclose(norms, 1.0)


def test_the_other_sense_of_rotation_mirrors_all_waves() -> None:
    matrices = rotation_matrices(bladed_disk())
    one, other = (whirl_modes(matrices.at(omega, "full"), 40) for omega in (300.0, -300.0))
    np.testing.assert_allclose(one.frequency, other.frequency, rtol=1e-9)
    for direction, mirrored in (("backward", "forward"), ("standing", "standing")):
        ours = [way == direction for way in one.direction]
        theirs = [way == mirrored for way in other.direction]
        np.testing.assert_allclose(one.frequency[ours], other.frequency[theirs], rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("omega", [200.0, 300.0, -800.0])
def test_internal_damping_feeds_whirl_until_bearings_hold_it(omega: float) -> None:
    """Waves by nodal diameter against real matrices of all sectors."""
    disk = assembled(fan(), stiffness=3e6)
    rest = rotation_matrices(disk)
    mass, stiffness = rest.mass.toarray(), rest.stiffness.toarray()

    def rate(bearing: float) -> float:
        damping = modal_damping(mass, stiffness, 0.01) + omega * rest.drag(1.0).toarray()
        turning, (x, y) = rest.stiffness_at(omega).toarray(), disk.centre
        damping[[x, y], [x, y]] += bearing
        turning[x, y] -= bearing * omega  # it stands still, so it pulls at what turns
        turning[y, x] += bearing * omega
        return float(damped_eigenvalues(mass, damping, turning)[0].real.max())

    actual = internal_growth(replace(disk, structure=rest), omega, "full", damping_ratio=0.01)
    assert actual.nodal_diameter == 1
    assert actual.rate == pytest.approx(rate(0.0), abs=1e-7)
    assert (actual.rate > 0.0) == (abs(omega) > 255.0)  # its lowest frequency
    assert actual.holding is not None
    if actual.rate > 0.0:
        assert rate(actual.holding) == pytest.approx(0.0, abs=1e-6)
    else:
        assert actual.holding == 0.0


def test_growth_goes_with_the_square_of_the_speed_unless_the_load_follows_it() -> None:
    disk = assembled(fan())
    matrices = rotation_matrices(disk)
    one, three = (matrices.static_displacement(omega, follows=False) for omega in (1.0, -3.0))
    np.testing.assert_allclose(three, 9.0 * one, rtol=1e-14)
    tips = one[disk.tip_radial]
    assert np.all(tips > 0.0)
    room = 9.0 * tips * np.array([1.0, 2.0, 3.0, 4.0])
    assert speed_of_growth(replace(disk, structure=matrices), room) == pytest.approx(3.0, rel=1e-6)
    inward = replace(matrices, centrifugal_load=-matrices.loads[:, 0])
    assert speed_of_growth(replace(disk, structure=inward), room) == np.inf
