"""Periodic motions as the start of a march: displacements, velocities and contact forces at t = 0.

Points of a sweep take their motion from a branch over a swept key, which is followed once, or from
the search of `bladewhirl.periodic`.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from bladewhirl.meshes.hermite import cubic_weights, slope_weights
from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.stage.build import build_stage, contact_problem
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Start
from bladewhirl.models.stage.stage import Stage
from bladewhirl.models.stage.wall import ReducedCasing
from bladewhirl.postprocess.periodic.dataset import BRANCH_NAME, open_branch
from bladewhirl.solvers.periodic.blade import DIRECTIONS, Blade, Grid, lasts
from bladewhirl.solvers.periodic.contact import Motion, NotConverged
from bladewhirl.solvers.periodic.corotating import CorotatingContact, corotating_contact
from bladewhirl.solvers.periodic.search import periodic_motion, prolonged, refined
from bladewhirl.studies.periodic import corotating
from bladewhirl.studies.periodic.branches import branch, resume_branch
from bladewhirl.studies.periodic.motions import blade_of
from bladewhirl.studies.sweeps.axes import NUMBER, Value

INSTANTS, POINTS = 256, 20
"""Instants of the points of a branch, and number of its longest steps over the swept values."""
LIKE = 0.1
"""Largest difference of the impulse of a motion from that of the branch, relative to the latter."""
AROUND = 8  #: least number of instants in the time in which a tip passes a casing element


def check(case: Case) -> None:
    """Check that marches of a case can start on a periodic motion.

    Raises:
        UserError: they cannot; the message has the reason.
    """
    stage = build_stage(case)
    if case.march.varies or case.blade_loss is not None or case.shaft.fuse_force is not None:
        raise UserError("expected a constant speed, and no [blade_loss] and shaft.fuse_force")
    if not corotating.is_corotating(contact_problem(stage)):
        blade_of(stage, 0)


def follow(case: Case, key: str, values: Sequence[Value], directory: Path) -> None:
    """Follow the branch of a case from the smallest to the largest value of a key into a folder, or
    continue it there.

    Nothing is written if there is no branch: without contact, with contact that is constant in
    rotating axes, or if no motion is found at the smallest value.
    """
    if corotating.is_corotating(contact_problem(build_stage(case))):
        return
    ends = sorted(values, key=_number)
    try:
        if (directory / BRANCH_NAME).exists():
            resume_branch(directory)
            return
        branch(case, key, ends[0], ends[-1], points=POINTS, instants=INSTANTS, directory=directory)
    except UserError:
        return  # the search at each point states in the dataset whether it finds a motion


def start_of(
    stage: Stage, directory: Path | None = None, value: Value | None = None
) -> tuple[Start, float] | None:
    """Return a periodic motion of a stage at t = 0, and its impulse per revolution [N s].

    Args:
        stage: stage that is marched.
        directory: folder of a branch of the stage; of its motions at the value of its key the one
            with the largest impulse is returned, if some are stable, of these.
        value: value of the key of the branch.

    Returns:
        start and impulse; None if no motion was found. Without a branch the motion is that of the
        search of `bladewhirl.periodic`, which can be one without contact.
    """
    problem = contact_problem(stage)
    try:
        if corotating.is_corotating(problem):
            return of_corotating(problem, corotating_contact(problem))
        return of_blades(stage, _first_motion(blade_of(stage, 0), directory, value))
    except NotConverged:
        return None


def _number(value: Value) -> float:
    """Return a value without its unit."""
    match = NUMBER.fullmatch(str(value))
    assert match is not None
    return float(match[1])


def of_blades(stage: Stage, motion: Motion, number: int = 0) -> tuple[Start, float]:
    """Return start and impulse of the 3D blades of a stage, of which one has a motion, by its
    number; in a flexible casing the others follow it.

    Raises:
        NotConverged: no motion of another blade was found.
    """
    problem, first = contact_problem(stage), motion.grid.blade
    rotor = problem.rotor
    angle = rotor.by_copy(rotor.tip_angle)[:, 0]
    states, impulse = [], 0.0
    for copy in range(rotor.copies):
        own, time = motion, float((angle[copy] - angle[number]) / problem.speed)
        if first.ring is None and copy != number:  # blades can differ
            own, time = _near(blade_of(stage, copy, first.periods), motion, time), 0.0
        states.append(_at(own, time))
        impulse += own.impulse
    rotor_state = [np.stack([state[k] for state in states]) for k in range(2)]
    force = np.concatenate([state[2] for state in states])
    still = np.zeros(len(problem.casing.frequency))
    wall = (still, still)
    if first.ring is not None:
        around = np.tile(motion.force, (first.lobes, 1)).reshape(-1, first.nodes, DIRECTIONS)
        wall = _casing(problem, around, first.angle, first.copies)
    start = Start(
        rotor=rotor_state[0],
        rotor_velocity=rotor_state[1],
        casing=wall[0] + _pressed(problem),
        casing_velocity=wall[1],
        contact_force=force,
    )
    return start, impulse


def _first_motion(blade: Blade, directory: Path | None, value: Value | None) -> Motion:
    """Return the motion of a blade.

    Raises:
        NotConverged: no motion was found.
    """
    if directory is not None and value is not None and (directory / BRANCH_NAME).exists():
        for guess, impulse in _of_branch(blade, directory, _number(value)):
            try:
                motion = refined(prolonged(guess))
            except NotConverged:
                continue
            if abs(motion.impulse - impulse) <= LIKE * impulse:
                return motion
    return periodic_motion(blade)


def _of_branch(blade: Blade, directory: Path, value: float) -> Iterator[tuple[Motion, float]]:
    """Yield motions of a branch at a value as guesses, with their impulses; stable ones first, then
    by falling impulse."""
    points = open_branch(directory)
    points = points.isel(point=points["kind"].values == 0)
    place, impulse = points["parameter"].values, points["impulse_per_revolution"].values
    parts = [points[f"multiplier_{part}"].values for part in ("real", "imaginary")]
    size = np.hypot(*parts).max(axis=1)
    found = []
    for n in np.flatnonzero((place[:-1] - value) * (place[1:] - value) <= 0.0):
        width = place[n + 1] - place[n]
        share = float((value - place[n]) / width) if width else 0.0
        normal, angle = points["normal_force"].values, points["slip_direction"].values
        near = int(n + round(share))
        guess = Motion(
            Grid(blade, points.sizes["instant"]),
            (1.0 - share) * normal[n] + share * normal[n + 1],
            angle[near],
        )
        between = float((1.0 - share) * impulse[n] + share * impulse[n + 1])
        found.append((size[near] >= 1.0, -between, n, guess))
    for _, negative, _, guess in sorted(found, key=lambda each: each[:3]):
        if negative:
            yield guess, -negative


def _near(blade: Blade, motion: Motion, time: float) -> Motion:
    """Return the motion of a blade that does what another one has done a time before [s].

    Raises:
        NotConverged: no motion was found.
    """
    grid = Grid(blade, motion.grid.instants)
    back = np.mod(np.arange(grid.instants) + time / grid.step, grid.instants)
    low = back.astype(int)
    share, nearest = (back - low)[:, None], np.rint(back).astype(int) % grid.instants
    low, after = low % grid.instants, (low + 1) % grid.instants
    normal = (1.0 - share) * motion.normal[low] + share * motion.normal[after]
    try:
        return refined(prolonged(Motion(grid, normal, motion.angle[nearest])))
    except NotConverged:
        return periodic_motion(blade)


def _at(motion: Motion, time: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return modal displacements and velocities, (modes,), and contact forces, (nodes, 3), of a
    motion at a time [s], between its instants by cubic and linear interpolation."""
    grid = motion.grid
    place = np.mod(time / grid.step, grid.instants)
    low, share = int(place) % grid.instants, place - int(place)
    high = (low + 1) % grid.instants
    q, v = motion.modes
    ends = q[low], v[low], q[high], v[high]
    moved, rate = (
        np.asarray(weights(np.array(share), grid.step) @ np.stack(ends))
        for weights in (cubic_weights, slope_weights)
    )
    force = (1.0 - share) * motion.force[low] + share * motion.force[high]
    return moved, rate, force.reshape(-1, DIRECTIONS)


def of_corotating(problem: ContactProblem, contact: CorotatingContact) -> tuple[Start, float]:
    """Return start and impulse of contact that is constant in rotating axes."""
    way = float(np.sign(problem.speed)) * problem.friction
    force = -contact.normal[:, None] * np.array([1.0, way, 0.0])
    around = np.broadcast_to(force, (AROUND * len(problem.casing.nodal), *force.shape))
    wall = _casing(problem, around, problem.rotor.tip_angle, 1)
    supports = contact.supports, contact.supports_velocity(problem.speed)
    start = Start(
        rotor=contact.rotor,
        rotor_velocity=np.zeros_like(contact.rotor),
        casing=np.append(wall[0], supports[0]),
        casing_velocity=np.append(wall[1], supports[1]),
        contact_force=force,
    )
    return start, float(contact.normal.sum() * 2.0 * np.pi / abs(problem.speed))


def _casing(
    problem: ContactProblem, force: FloatArray, angle: FloatArray, copies: int
) -> tuple[FloatArray, FloatArray]:
    """Return modal displacements and velocities of a uniform casing without supports at t = 0 in
    its periodic motion under contact forces on moving tips, (modes,) each.

    Args:
        problem: contact problem.
        force: contact forces on the tips of one blade at equally spaced instants of a turn, or on
            all tips of the stage [N], (instants, tips, 3).
        angle: angle of each of these tips from +x at t = 0 [rad], (tips,).
        copies: number of blades, at equal angles, whose forces follow one another.
    """
    casing, speed = problem.casing.wall, problem.speed
    instants = len(force)
    if not casing.is_flexible:
        return np.zeros(0), np.zeros(0)
    turned = np.sign(speed) * 2.0 * np.pi / instants * np.arange(float(instants))
    pull = np.zeros((instants, len(casing.frequency)))
    for tip, own in enumerate(angle):
        pull -= np.einsum("td,tdm->tm", force[:, tip, :2], casing.shapes_at(own + turned))
    line = np.arange(instants // 2 + 1)
    spectrum = np.fft.rfft(pull, axis=0) * np.where(line % copies == 0, copies, 0)[:, None]
    w, own = (line * abs(speed))[:, None], casing.frequency
    moved = spectrum / (own**2 - w**2 + 2j * casing.damping_ratio * own * w)
    return _first(moved, instants), _first(1j * w * moved, instants)


def _first(spectrum: ComplexArray, instants: int) -> FloatArray:
    """Return the values at the first instant of their harmonics, (modes,)."""
    return np.asarray(np.fft.irfft(spectrum, instants, axis=0)[0])


def _pressed(problem: ContactProblem) -> FloatArray:
    """Return the modal displacements of the casing under constant loads, (modes,)."""
    casing: ReducedCasing = problem.casing
    total = np.zeros(len(casing.frequency))
    for load in problem.loads:
        if lasts(load) and load.casing.any():
            total += load.casing * np.cos(load.phase) / casing.frequency**2
    return total
