"""Marches in some of a stage's modes: names, projection, and the paper's six-mode space."""

from dataclasses import replace

import numpy as np
import pytest
import stages
from contact_cases import assert_same, ledger_residual, run, run_as_reference, thrown
from faults import fault

from bladewhirl.models.case.file import loads
from bladewhirl.models.stage.beams import Beams
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.excitations import radial_mode
from bladewhirl.postprocess.run.summary import summarise
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

CONTACT = ("casing.support=7.975e6", "reduction.fixed_interface_modes=22", "casing.elements=20")


def stage(modes: str, *overrides: str) -> Beams:
    """A coarse stage for contact simulations that keeps some modes."""
    return stages.stage(*CONTACT, *overrides, f"reduction.modes={modes}")


def kept(modes: str) -> tuple[set[tuple[str, int]], set[tuple[str, int]]]:
    """Families and nodal diameters of the modes kept, of bladed disk and casing."""
    arrays = stage(modes).arrays
    rotor = zip(arrays.rotor_family, arrays.rotor_nodal_diameter.tolist(), strict=True)
    casing = zip(arrays.casing_family, arrays.casing_nodal_diameter.tolist(), strict=True)
    return set(rotor), set(casing)


def test_all_modes_are_kept_unless_said() -> None:
    whole = stage("all")
    np.testing.assert_array_equal(whole.kept.rotor, np.arange(whole.reduction.modes.count))
    np.testing.assert_array_equal(whole.kept.casing, np.arange(80 - 1))  # held against rotation


def test_the_papers_six() -> None:
    six = stage("six")
    assert kept("six") == ({("1F", 1), ("suspension", 1)}, {("rigid", 1)})
    assert (len(six.kept.rotor), len(six.kept.casing)) == (4, 2)
    assert kept("1F:1, suspension, casing:1") == kept("six")


@pytest.mark.parametrize(
    ("modes", "rotor", "casing"),
    [
        ("1F,casing:2", {("1F", k) for k in range(12)}, {("1F", 2)}),
        ("suspension,2F:0,casing:rigid", {("suspension", 1), ("2F", 0)}, {("rigid", 1)}),
        ("1F:11,casing:2F:3", {("1F", 11)}, {("2F", 3)}),
    ],
)
def test_other_modes_by_name(
    modes: str, rotor: set[tuple[str, int]], casing: set[tuple[str, int]]
) -> None:
    assert kept(modes) == (rotor, casing)


def test_every_family_of_a_nodal_diameter() -> None:
    rotor, casing = kept("*:1,casing:*:1")
    whole_rotor, whole_casing = kept("all")
    assert rotor == {mode for mode in whole_rotor if mode[1] == 1}
    assert casing == {mode for mode in whole_casing if mode[1] == 1}


def test_casing_without_nodal_diameter_is_the_lowest_radial_mode_of_each() -> None:
    _, casing = kept("1F:1,casing")
    assert casing == {("1F", 0), ("rigid", 1), *(("1F", k) for k in range(2, 10))}


@pytest.mark.parametrize("k", [2, 8])
def test_the_radial_mode_by_name_is_the_one_that_a_distortion_pushes(k: int) -> None:
    """In a thick ring of k = 8 stretching is lower than bending, and moves the wall along."""
    thick = stage(f"1F:1,casing:{k}", "casing.wall.thickness=0.3")
    number = radial_mode(thick, k)
    assert thick.kept.casing.tolist() == [number, number + 1]
    lowest = int(np.flatnonzero(thick.casing_modes.nodal_diameter == k)[0])
    assert (number > lowest) == (k == 8)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('"1F:"', '"1F:" is not a mode name'),
        ('"casing:1:1:1"', "is not a mode name"),
        ("3", "modes by name"),
        ('""', "is not a mode name"),
    ],
)
def test_no_name_of_modes(text: str, expected: str) -> None:
    line = fault(loads, f"[reduction]\nmodes = {text}")
    assert "reduction.modes" in line
    assert expected in line


@pytest.mark.parametrize(
    ("modes", "expected"),
    [
        ("suspention", "did you mean suspension?"),
        ("six,1F", "of the bladed disk are"),
        ("1F:12", "1F of the bladed disk has nodal diameters 0, 1, 2"),
        ("suspension:2", "suspension of the bladed disk has nodal diameters 1"),
        ("casing:10", "radial modes of the casing have nodal diameters 0, 1, 2"),
        ("casing:suspension", "families of the casing are"),
    ],
)
def test_modes_that_the_stage_does_not_have(modes: str, expected: str) -> None:
    assert expected in fault(stage, modes)


def test_the_suspension_of_a_clamped_centre_is_missed() -> None:
    assert "suspension" in fault(stage, "six", "shaft.clamped=true")


def test_a_load_that_no_kept_mode_feels_is_refused() -> None:
    load = ("excitation.type=casing-distortion", "excitation.nodal_diameter=2")
    line = fault(contact_problem, stage("six", *load))
    assert line.startswith("excitation.type")
    assert "a load that excites at least one mode kept by reduction.modes" in line


@pytest.mark.parametrize("modes", ["suspension", "casing:1"])
def test_a_march_needs_modes_of_both_bodies(modes: str) -> None:
    line = fault(contact_problem, stage(modes))
    assert line.endswith("expected modes of the bladed disk and of the casing")


def test_start_is_projected_by_mass() -> None:
    """What is left out is orthogonal in mass to what is kept, so kinetic energies add up."""
    push = "initial.centre_velocity=[0.3, -0.1]"
    whole = contact_problem(stage("all", push)).start
    six = contact_problem(stage("six", push)).start
    rest = contact_problem(stage("*:0,2F,casing", push)).start
    chosen = stage("six", push).kept.rotor
    np.testing.assert_array_equal(six.rotor_velocity, whole.rotor_velocity[chosen])
    assert np.sum(six.rotor_velocity**2) > 0.5 * np.sum(whole.rotor_velocity**2)
    assert np.sum(rest.rotor_velocity**2) < 0.5 * np.sum(whole.rotor_velocity**2)


def sideways(given: ContactProblem) -> ContactProblem:
    """The same stage, its shaft thrown at the casing with 10 m/s."""
    return thrown(given, 10.0 * np.cos(given.rotor.tip_angle - 0.1))


@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_six_modes_march_as_written_out(friction: float) -> None:
    """W has rank two where many tips would go in together; the motion is that of the plain march.

    Tips all around touch, each for a moment.
    """
    given = sideways(replace(contact_problem(stage("six")), friction=friction))
    state, chunk = run_as_reference(given, 2e-5, 300)
    assert (chunk.contact_impulse > 0).any(axis=0).sum() > 2
    assert ledger_residual(chunk) < 1e-10
    assert state.statistics.complementarity_residual < 1e-10
    assert state.statistics.lcp_failures == 0


def test_harmonics_and_products_march_alike() -> None:
    """All k = 1 families, enough of them for either path, against dense products."""
    given = sideways(contact_problem(stage("*:1,1F,2F,casing,casing:2F,casing:3F")))
    assert given.rotor.by_harmonics
    assert given.casing.by_harmonics
    cyclic, dense = (run(given, 2e-6, 600, cyclic=path)[1] for path in (True, False))
    assert cyclic.contacts.any()
    assert_same(cyclic, dense)


@pytest.mark.parametrize(
    ("modes", "march", "count"),
    [("six", "by dense products", (4, 2)), ("all", "harmonic by harmonic", (68, 79))],
)
def test_a_run_says_how_it_was_marched(modes: str, march: str, count: tuple[int, int]) -> None:
    """Symmetry is found all the same; with six modes it does not pay."""
    distorted = stage(modes, "excitation.type=casing-distortion", "march.duration=1 ms")
    result, report = march_in_memory(prepare(distorted.case))
    assert result.attrs["symmetry"] == (
        f"bladed disk: 22 equal sectors: cyclic path, march {march}; "
        f"casing: 20 equal sectors: cyclic path, march {march}"
    )
    assert (result.sizes["rotor_mode"], result.sizes["casing_mode"]) == count
    assert float(result["gap"].min()) < distorted.case.casing.clearance
    summary = summarise(result, report)
    assert summary.strain_energy_final is not None
    assert "1" in summary.strain_energy_final["1F"]
    assert summary.energy_residual < 1e-8
