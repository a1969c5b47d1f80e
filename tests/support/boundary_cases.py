"""Small contact problems of structures with many contact nodes, and their march in plain NumPy."""

from functools import cache
from typing import Any

import numpy as np
import scipy.optimize as so

from bladewhirl.meshes.hermite import cubic_weights
from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Start
from bladewhirl.models.stage.reduced_rotor import ReducedRotor
from bladewhirl.models.stage.ring import flexible_ring
from bladewhirl.models.stage.wall import ReducedCasing
from bladewhirl.models.stage.wall_coating import WallCoating
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import Chunk

CLEARANCE = 2e-4
E, YIELD, HARD, THICK = 1e9, 1e7, 5e7, 2e-3


def advanced(problem: ContactProblem, dt: float, steps: int, every: int = 1) -> Chunk:
    """Records of x_0 .. x_steps."""
    scheme = CentralDifference(problem, dt, every)
    state, chunk, end = scheme.advance(scheme.init(), steps + 1)
    assert end is None
    assert state.statistics.lcp_failures == 0
    return chunk


def ledger(chunk: Chunk) -> float:
    """Error of the energy balance, relative to the largest energy."""
    gained = chunk.external_work + chunk.normal_work + chunk.friction_work - chunk.damping_work
    error = np.abs(chunk.energy - chunk.energy[0] - gained)
    return float(error.max() / np.abs(chunk.energy).max())


def bladed(
    copies: int,
    nodes: int,
    *,
    massless: bool = True,
    ring: ReducedCasing | None = None,
    coating: WallCoating | None = None,
    by_velocity: FloatArray | None = None,
    seed: int = 7,
    **changes: Any,
) -> ContactProblem:
    """Equal blades of random modes that move outward, in an oval wall or in a ring."""
    random, modes = np.random.default_rng(seed), 8
    square = random.standard_normal((3 * nodes, 3 * nodes))
    flexibility = 3e-9 * (square @ square.T / nodes + np.eye(3 * nodes))
    contact = random.standard_normal((3 * nodes, modes))
    contact[::3, 0] = np.linspace(1.4, 1.6, nodes)
    pitch, grid = 2.0 * np.pi / copies * np.arange(copies), 2.0 * np.pi / 64 * np.arange(64)
    oval = np.column_stack([CLEARANCE + 1e-4 * np.cos(2 * grid), -2e-4 * np.sin(2 * grid)])
    radius = 0.3 if ring is None else ring.radius
    rotor = ReducedRotor.of_copies(
        frequency=np.tile(np.linspace(900.0, 3e4, modes), (copies, 1)),
        damping_ratio=np.full((copies, modes), 0.002),
        contact=contact,
        compliance=np.tile(flexibility, (copies, 1, 1)) if massless else None,
        angle=pitch[:, None] + np.linspace(-0.06, 0.06, nodes) * (nodes > 1),
        radius=np.full(nodes, radius),
        recess=np.linspace(2e-5, -2e-5, nodes),
        tip_radius=radius,
        by_velocity=by_velocity,
    )
    given: dict[str, Any] = {
        "rotor": rotor,
        "casing": ReducedCasing.rigid(oval / [1.0, radius], radius) if ring is None else ring,
        "speed": 150.0,
        "friction": 0.1,
        "sliding": "permanent",
        "tip_rotation": False,
        "displacement_limit": 1.0,
        "loads": (),
        "start": Start.of_rotor(
            np.zeros(copies * modes),
            np.outer(1.0 + 0.5 * np.cos(pitch - 0.4), np.eye(modes)[0]).ravel(),
            0 if ring is None else len(ring.frequency),
        ),
        "coating": coating,
    }
    return ContactProblem(**given | changes)


@cache
def casing(
    elements: int, *, support: float = 1e7, damping: float = 0.0, **wall: float
) -> ReducedCasing:
    """An even flexible ring, thin by default."""
    table = {
        "elements": elements,
        "clearance": CLEARANCE,
        "support": support,
        "wall": {"thickness": 5e-3, "width": 0.05} | wall,
    }
    case = {"casing": table, "damping": {"ratio": damping}}
    return flexible_ring(Case.model_validate(case)).reduced_casing


def coating(tracks: FloatArray, footprint: float, *, limit: float = 0.9) -> WallCoating:
    """720 rods in each track, for nodes with their positions along the axis."""
    axial = np.unique(tracks)
    return WallCoating(
        strain=np.zeros((len(axial), 720)),
        axial=axial,
        width=np.full(len(axial), 5e-3),
        track=np.searchsorted(axial, tracks),
        footprint=np.full(len(tracks), footprint),
        radius=0.3,
        thickness=THICK,
        young_modulus=E,
        yield_stress=YIELD,
        hardening=HARD,
        limit=limit,
    )


def rubbing(*, massless: bool = True) -> ContactProblem:
    """Two blades in a coated wall, with two tracks."""
    worn = coating(np.array([0.0, 0.0, 1.0, 1.0]), 4e-3, limit=0.06)
    return bladed(2, 4, massless=massless, coating=worn)


def around(values: FloatArray, length: float, angle: FloatArray) -> FloatArray:
    """Cubics around a circle at angles, (angles, ...).

    Args:
        values: values and derivatives at equally spaced angles, (nodes, 2, ...).
        length: distance of two of them, by which the derivatives are meant.
        angle: angles [rad], (angles,).
    """
    nodes = len(values)
    place = np.mod(angle * nodes / (2.0 * np.pi), nodes)
    first = place.astype(int) % nodes
    weight = cubic_weights(place - np.floor(place), length)
    ends = np.concatenate([values[first], values[(first + 1) % nodes]], axis=1)
    return np.asarray(np.einsum("qn,nq...->n...", weight, ends))


def clearance_at(p: ContactProblem, angle: FloatArray) -> FloatArray:
    """Clearance of the wall at rest [m], (angles,)."""
    return around(p.casing.clearance, p.casing.element_length, angle)


class Rods:
    """The rods under a node at an angle.

    Args:
        p: problem.
        strain: plastic strain of all rods, (tracks, rods).
        node: number of the node in its copy.
        angle: place of the node.
    """

    def __init__(self, p: ContactProblem, strain: FloatArray, node: int, angle: float) -> None:
        assert isinstance(p.coating, WallCoating)
        self._coating, self._track = p.coating, int(p.coating.track[node])
        middle = 2.0 * np.pi * (np.arange(strain.shape[1]) + 0.5) / strain.shape[1]
        apart = np.abs(np.angle(np.exp(1j * (middle - angle)))) * p.coating.radius
        self._under = np.flatnonzero(apart <= 0.5 * p.coating.footprint[node])
        self._offset = clearance_at(p, middle[self._under]) - clearance_at(p, np.array([angle]))
        self._plastic = strain[self._track, self._under]

    def pressed(self, gap: float) -> tuple[float, FloatArray]:
        """Force at a gap to the metal, and the plastic strains there."""
        worn, plastic = self._coating, self._plastic
        depth = worn.removable - gap - self._offset
        trial = np.maximum(0.0, worn.young_modulus * (depth / worn.thickness - plastic))
        rise = np.maximum(0.0, trial - worn.yield_stress - worn.hardening * plastic)
        rise = rise / (worn.young_modulus + worn.hardening)
        rise = np.minimum(rise, np.maximum(0.0, worn.limit - plastic))
        stress = trial - worn.young_modulus * rise
        return float(worn.arc * worn.width[self._track] * stress.sum()), plastic + rise

    def force(self, free: float, flexibility: float) -> float:
        """Force at which the gap is that without a force plus what the force opens."""
        if free + flexibility * self.pressed(0.0)[0] < 0.0:  # metal
            return -free / flexibility
        if self.pressed(free)[0] == 0.0:
            return 0.0
        top = max(free, 0.0) + flexibility * self.pressed(0.0)[0] + 1e-6
        gap = so.brentq(
            lambda gap: gap - free - flexibility * self.pressed(gap)[0], 0.0, top, xtol=1e-18
        )
        return self.pressed(gap)[0]

    def wear(self, strain: FloatArray, gap: float) -> None:
        """Set the strains after a step at a gap."""
        strain[self._track, self._under] = self.pressed(gap)[1]


def contact_forces(
    p: ContactProblem,
    flexible: FloatArray,
    gap: FloatArray,
    slip: FloatArray,
    force: FloatArray,
    rods: list[Rods],
) -> FloatArray:
    """Contact forces after a step by Gauss-Seidel iterations, (nodes, 3). With full sliding the
    friction of each node is projected on its cone; nodes stick or slide.

    Args:
        p: problem.
        flexible: displacements for unit forces [m/N], (nodes, 3, nodes, 3).
        gap: gaps without forces [m], (nodes,).
        slip: slip on the wall in the step without forces [m], (nodes, 3).
        force: forces before the step [N], (nodes, 3).
        rods: rods under each node, empty without a coating.

    Raises:
        ArithmeticError: the iterations do not converge.
    """
    force, full = force.copy(), p.sliding == "full"
    way = np.array([-1.0, 0.0 if full else -p.friction * np.sign(p.speed), 0.0])
    for _ in range(5000):
        before = force.copy()
        for i, answers in enumerate(flexible):
            own, held = answers[:, i], force[i] * [0.0, full, full]
            others = np.tensordot(answers, force, 2) - own @ force[i]
            free, unit = gap[i] - others[0] - own[0] @ held, -own[0] @ way
            normal = rods[i].force(free, unit) if rods else max(0.0, -free / unit)
            force[i] = held + normal * way
            if full:
                moved = slip[i, 1:] + (others + own @ force[i])[1:]
                pull = force[i, 1:] - moved / np.linalg.norm(own[1:, 1:], 2)
                force[i, 1:] = pull * min(1.0, p.friction * normal / max(np.hypot(*pull), 1e-300))
        if np.allclose(force, before, rtol=1e-13, atol=1e-14 * np.abs(force).max()):
            return force
    raise ArithmeticError("the contact forces do not converge")


def pushes(p: ContactProblem, time: float) -> tuple[FloatArray, FloatArray]:
    """Modal forces of the loads on the copies and on a flexible casing."""
    copies = np.zeros(len(p.rotor.frequency))
    casing = np.zeros(len(p.casing.frequency))
    for load in p.loads:
        rise = 0.5 - 0.5 * np.cos(np.pi * min(1.0, time / load.ramp)) if load.ramp else 1.0
        size = rise * np.cos(load.frequency * time + load.phase) * (time < load.end)
        copies, casing = copies + size * load.rotor, casing + size * load.casing
    return p.rotor.by_copy(copies), casing


def plain(p: ContactProblem, dt: float, steps: int) -> dict[str, FloatArray]:
    """March in NumPy only: dense products, and Gauss-Seidel iterations for all nodes together."""
    rotor = p.rotor
    copies, (nodes, modes) = rotor.copies, rotor.tip_radial.shape
    contact, flexibility = rotor.contact, rotor.compliance
    rows, count = contact.reshape(nodes, 3, -1), copies * nodes
    turning = np.zeros((modes, modes)) if rotor.by_velocity is None else rotor.by_velocity
    frequency, massless = rotor.by_copy(rotor.frequency), flexibility is not None
    squares, loss = frequency**2, 2.0 * rotor.by_copy(rotor.damping_ratio) * frequency
    drag = np.array([0.5 / dt * (np.diag(row) + turning) for row in loss])
    inverse = np.linalg.inv(np.eye(modes) / dt**2 + drag)
    ring, stiff = p.casing, p.casing.frequency
    lost = ring.damping_ratio * stiff / dt
    now, rate = rotor.by_copy(p.start.rotor), rotor.by_copy(p.start.rotor_velocity)
    slow = np.zeros(len(stiff))
    slowing = squares * now + loss * rate + rate @ turning.T
    pushed, blown = pushes(p, 0.0)
    old = now - dt * rate + 0.5 * dt**2 * (pushed - slowing)
    slow_old = 0.5 * dt**2 * blown
    force = np.zeros((count, 3))
    strain = p.coating.strain if isinstance(p.coating, WallCoating) else np.zeros((0, 0))
    names = ("force", "q", "casing", "strain")
    out: dict[str, list[FloatArray]] = {name: [] for name in names}
    for step in range(steps + 1):
        for name, value in zip(names, (force, now, slow, strain), strict=True):
            out[name].append(value)
        time, by_copy = step * dt, force.reshape(copies, nodes, 3)
        pushed, blown = pushes(p, time)
        if massless:
            pushed = pushed + np.einsum("ikm,cik->cm", rows, by_copy)
        pulled = (2.0 / dt**2 - squares) * now - old / dt**2 + np.einsum("cij,cj->ci", drag, old)
        new = np.einsum("cij,cj->ci", inverse, pulled + pushed)
        heavy = 1.0 / dt**2 + lost
        later = (2.0 / dt**2 - stiff**2) * slow + (lost - 1.0 / dt**2) * slow_old + blown
        later = later / heavy
        angle = rotor.tip_angle + p.speed * (time + dt)
        on_wall = np.zeros((count, 3, len(stiff)))
        if ring.is_flexible:
            fields = ring.nodal.reshape(len(ring.nodal), 2, 2, -1).swapaxes(1, 2)
            on_wall[:, :2] = around(fields, ring.element_length, angle)  # w and u
        flexible = np.einsum("iam,m,jbm->iajb", on_wall, 1.0 / heavy, on_wall)
        for copy in range(copies):
            own = slice(copy * nodes, (copy + 1) * nodes)
            moving = contact @ inverse[copy] @ contact.T
            block = moving if flexibility is None else flexibility[copy]
            flexible[own, :, own] += block.reshape(nodes, 3, nodes, 3)
        moved = np.einsum("ikm,cm->cik", rows, new).reshape(count, 3)
        change = moved - np.einsum("ikm,cm->cik", rows, now).reshape(count, 3)
        if flexibility is not None:
            bent = np.einsum("cij,cj->ci", flexibility, by_copy.reshape(copies, -1))
            change = change - bent.reshape(count, 3)
        change = change - on_wall @ (later - slow)
        change[:, 1] += p.speed * np.tile(rotor.contact_radius, copies) * dt
        gap = clearance_at(p, angle) + p.metal_recess - moved[:, 0]
        gap = gap + on_wall[:, 0] @ later
        rods: list[Rods] = []
        if p.coating is not None:
            rods = [Rods(p, strain, i % nodes, float(angle[i])) for i in range(count)]
        after = np.zeros_like(force)
        if gap.min() < 0.0 or rods:
            after = contact_forces(p, flexible, gap, change, force, rods)
        if rods:
            strain = strain.copy()
            apart = gap - np.einsum("ijb,jb->i", flexible[:, 0], after)
            for rod, distance in zip(rods, apart.tolist(), strict=True):
                rod.wear(strain, max(0.0, distance))
        if not massless:
            answered = np.einsum("ikm,cik->cm", rows, after.reshape(copies, nodes, 3))
            new = new + np.einsum("cij,cj->ci", inverse, answered)
        later = later - np.einsum("iam,ia->m", on_wall, after) / heavy
        old, now, slow_old, slow, force = now, new, slow, later, after
    return {name: np.array(values) for name, values in out.items()}


def assert_plain(p: ContactProblem, dt: float, steps: int) -> Chunk:
    """Records of the compiled march, which is that of `plain`.

    Raises:
        ArithmeticError: see `contact_forces`.
    """
    expected, chunk = plain(p, dt, steps), advanced(p, dt, steps)
    force, forces = chunk.contact_force, expected["force"]
    moved = {"q": chunk.rotor_displacement, "casing": chunk.casing_displacement}
    np.testing.assert_allclose(force, forces, atol=1e-7 * np.abs(forces).max())
    for name, values in moved.items():
        plainly = expected[name].reshape(values.shape)
        largest = np.abs(plainly).max(initial=0.0)
        np.testing.assert_allclose(values, plainly, atol=1e-9 * largest, err_msg=name)
    if chunk.coating is None or not isinstance(p.coating, WallCoating):
        assert ledger(chunk) < 1e-9
        return chunk
    worn, strain = p.coating, expected["strain"]
    volume = (strain - strain[0]).sum(axis=2) @ worn.width * worn.arc * worn.thickness
    np.testing.assert_allclose(chunk.coating.wear_volume, volume, rtol=1e-7)
    return chunk
