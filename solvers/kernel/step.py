"""The compiled contact step: central differences with forward-increment Lagrange multipliers.

The scheme is that of Carpenter, Taylor and Katona (1991) with damping and sliding friction. A step
from n to n + 1 has six stages:

    predict   x_p = a x_n + b x_{n-1} + c f_n          a, b, c diagonal in modal coordinates
    look      g_p = gaps of x_p under the tips as they stand at n + 1; none negative: x_{n+1} = x_p
    solve     0 <= lambda  perp  g_p + W lambda >= 0   W = B_N^T c (B_N + mu B_T S)
    correct   x_{n+1} = x_p + c (B_N + mu B_T S) lambda; look again, and let tips join that it shut
    account   impulses, works and losses of the step, and the smallest gaps
    record    at record steps: x_n, its velocity (x_{n+1} - x_{n-1}) / (2 dt), and the ledger to n

Springs between the bodies, and those under the shaft that stand still and differ, have a stiffness
K*(t) that turns with the rotor; they add -K*_n x_n to f_n.

Dampers at points make the damping matrix a full one, G^T G beside the diagonal. They take part in
the prediction by what it gives them, phi = -G (x_p - x_{n-1}) / (2 dt), which without contact is
the scheme itself; what a contact force changes they feel from the next step on.

Coriolis forces on the rotor make its A = M / dt^2 + (D + 2 Omega G) / (2 dt) a full matrix, of one
block for each nodal diameter; c is then its inverse, and its dampers and the damping of its modes
at rest are part of it.

Fields are evaluated in two stages so that one code serves cyclic and general stages: modal
coordinates, laid out as (rows, columns), are first summed over rows with weights, giving one
number a column, and the columns are then spread over tips or casing nodes by a shape matrix. On a
cyclic stage a column is a Fourier harmonic and both stages are small; on any other stage there is
one row, a column is a mode, and the shape matrix is dense.

`solvers.march.reference` is the same scheme in NumPy, written from the definitions.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from numba import njit

from bladewhirl.solvers.kernel.arrays import (
    DAMPING,
    DIVERGED,
    EXTERNAL,
    FRICTION,
    LCP_PIVOTS,
    NORMAL,
    PARAMETRIC,
    RUNNING,
    STEP_CONTACTS,
    CasingArrays,
    DamperArrays,
    GyroscopicArrays,
    MarchNumbers,
    Records,
    RotorArrays,
    Scratch,
    Slots,
    SpringArrays,
    State,
)
from bladewhirl.solvers.kernel.compilation import COMPILE, ENTRY, digest
from bladewhirl.solvers.kernel.contact import (
    LAST_TRIAL,
    MENDED_TOGETHER,
    complementarity_residual,
    contact_multipliers,
    join_contacts,
    propose_contacts,
)
from bladewhirl.solvers.kernel.fields import (
    close_gaps,
    keeps_limit,
    place_tips,
    sliding_signs,
    sum_radial,
)
from bladewhirl.solvers.kernel.forces import (
    account_contact,
    correct_casing,
    correct_rotor,
    tip_forces,
)
from bladewhirl.solvers.kernel.motion import (
    add_dampers,
    add_loads,
    add_springs,
    damper_loss,
    damping_loss,
    external_work,
    load_amplitudes,
    predict,
    settle,
    spring_waves,
    turn_springs,
    write_record,
)
from bladewhirl.solvers.kernel.turning import (
    add_circulation,
    circulation_work,
    correct_turning_rotor,
    turn,
    turning_loss,
)
from bladewhirl.solvers.kernel.vectors import bare, plain

CHECK_EVERY = 100
"""Steps between looks at displacements other than the tips' radial ones."""


@njit(**COMPILE)
def _predict(
    rotor: RotorArrays,
    casing: CasingArrays,
    springs: SpringArrays | None,
    dampers: DamperArrays | None,
    gyroscopic: GyroscopicArrays | None,
    loaded: bool,
    state: State,
    slots: Slots,
    s: Scratch,
) -> None:
    """x_p of both bodies, into slot ``new``."""
    x, y, zero, one = state.rotor, state.casing, plain(0), plain(1)
    predict(rotor.body, x, slots)
    predict(casing.body, y, slots)
    if loaded:
        add_loads(rotor.body, s.amplitude, x, slots)
        add_loads(casing.body, s.amplitude, y, slots)
    if springs is not None:
        add_springs(springs.rotor, s.springs.force, zero, rotor.body.c, x, slots)
        add_springs(springs.casing, s.springs.force, one, casing.body.c, y, slots)
    if dampers is not None:
        stroke, force = s.stroke, s.damper_force
        if gyroscopic is None:
            add_dampers(dampers.rotor, rotor.body.c, x, slots, stroke, force, zero)
        add_dampers(dampers.casing, casing.body.c, y, slots, stroke, force, one)
    if gyroscopic is not None:
        add_circulation(gyroscopic, x, slots)
        turn(rotor, gyroscopic, x, slots, s.turned)


@njit(**COMPILE)
def _account(
    rotor: RotorArrays,
    casing: CasingArrays,
    dampers: DamperArrays | None,
    gyroscopic: GyroscopicArrays | None,
    march: MarchNumbers,
    loaded: bool,
    touching: bool,
    state: State,
    slots: Slots,
    s: Scratch,
) -> None:
    """Book an accepted step."""
    x, y, work = state.rotor, state.casing, state.work
    gap = s.fields.gap if touching else s.fields.free_gap
    state.counts[STEP_CONTACTS] = 0
    if touching:
        worst = complementarity_residual(march.gap_scale, s.fields, s.contact)
        state.residual[0] = max(state.residual[0], worst)
        work[NORMAL] += s.contact.work[0]
        work[FRICTION] += s.contact.work[1]
        account_contact(march, state, s.contact)
    for j in range(len(state.gap)):
        state.gap[j] = min(state.gap[j], gap[j])
    if loaded:
        work[EXTERNAL] += external_work(rotor.body, s.amplitude, x, slots)
        work[EXTERNAL] += external_work(casing.body, s.amplitude, y, slots)
    lost = damping_loss(casing.body, y, slots)
    if gyroscopic is None:
        lost += damping_loss(rotor.body, x, slots)
    else:
        lost += turning_loss(rotor, gyroscopic, x, slots, s.turned)
        work[PARAMETRIC] += circulation_work(gyroscopic, x, slots)
    work[DAMPING] += lost / march.time_step
    if dampers is not None:
        stroke, force = s.stroke, s.damper_force
        work[DAMPING] += damper_loss(dampers.rotor, x, slots, stroke, force, plain(0))
        work[DAMPING] += damper_loss(dampers.casing, y, slots, stroke, force, plain(1))


@njit(**COMPILE)
def _march(
    rotor: RotorArrays,
    casing: CasingArrays,
    springs: SpringArrays | None,
    dampers: DamperArrays | None,
    gyroscopic: GyroscopicArrays | None,
    wheel_speed: float | None,
    march: MarchNumbers,
    state: State,
    records: Records,
    s: Scratch,
    step: int,
    steps: int,
    record_every: int,
) -> tuple[int, int, int]:
    """`advance` with all arrays bare."""
    x, y, limit = state.rotor, state.casing, march.displacement_limit
    fields, contact, status, written = s.fields, s.contact, RUNNING, plain(0)
    slots, end = Slots(plain(0), plain(1), plain(2)), step + steps
    spring_energy, turning_work = 0.0, 0.0
    for j in range(len(contact.sign)):
        contact.sign[j], contact.known[0, j] = march.sliding, -1
    if springs is not None:
        spring_waves(springs.rotor, x, slots.old, s.springs.rotor, (step + 1) % 2)
        spring_waves(springs.casing, y, slots.old, s.springs.casing, (step + 1) % 2)
    while step < end:
        loaded = load_amplitudes(march.loads, step * march.time_step, s.amplitude)
        if springs is not None:
            spring_energy, turning_work = turn_springs(springs, x, y, slots.now, s.springs, step)
        trial, penetrating = plain(0), plain(0)
        while True:
            if trial != 1:
                _predict(rotor, casing, springs, dampers, gyroscopic, loaded, state, slots, s)
            if trial == 0:
                turned = march.elements_per_step * (step + 1)
                place_tips(rotor, casing, march.elements_per_metre, turned, x, slots, fields)
                sum_radial(rotor, casing, x, y, slots, fields)
            else:
                trial, size = contact_multipliers(trial, rotor, casing, state, fields, contact)
                mixed, ratio = tip_forces(size, march.friction, casing.nodes, fields, contact)
                if gyroscopic is None:
                    correct_rotor(rotor, size, mixed, ratio, x, slots, fields, contact)
                else:
                    correct_turning_rotor(
                        rotor, gyroscopic, size, mixed, ratio, x, slots, fields, contact, s.turned
                    )
                correct_casing(casing, size, mixed, ratio, y, slots, fields, contact)
            found = fields.free_gap if trial == 0 else fields.gap
            within = close_gaps(rotor, casing, limit, fields, found)
            if trial == 0:
                penetrating = propose_contacts(fields.free_gap, state.held)
                if penetrating == 0:
                    break
                if wheel_speed is not None:
                    sliding_signs(
                        rotor, casing, wheel_speed, march.time_step, x, y, slots, fields,
                        contact.sign,
                    )  # fmt: skip
            else:
                if trial >= LAST_TRIAL or not within:
                    break
                if join_contacts(fields.gap, state.held, trial > MENDED_TOGETHER) == 0:
                    break
                state.counts[LCP_PIVOTS] += 1
            trial += 1
        if within and (step + 1) % CHECK_EVERY == 0:
            within = keeps_limit(rotor, casing, limit, x, slots, fields)
        if step % record_every == 0 or not within:
            write_record(
                records, written, state, rotor.body, casing.body, slots, march.time_step,
                spring_energy, step, within,
            )  # fmt: skip
            written += 1
        if not within:
            status = DIVERGED
            break
        _account(
            rotor, casing, dampers, gyroscopic, march, loaded, penetrating > 0, state, slots, s
        )
        state.work[PARAMETRIC] += turning_work
        slots = Slots(slots.now, slots.new, slots.old)
        step += 1
    settle(x, slots)
    settle(y, slots)
    return status, step, written


def _advance(sources: int) -> Callable[..., tuple[int, int, int]]:
    """The entry; ``sources`` is there for numba's cache, see `digest`."""

    @njit(**ENTRY)
    def advance(
        rotor: RotorArrays,
        casing: CasingArrays,
        springs: SpringArrays | None,
        dampers: DamperArrays | None,
        gyroscopic: GyroscopicArrays | None,
        wheel_speed: float | None,
        march: MarchNumbers,
        state: State,
        records: Records,
        s: Scratch,
        step: int,
        steps: int,
        record_every: int,
    ) -> tuple[int, int, int]:
        """March from ``step`` to ``step + steps``, recording at multiples of ``record_every``.

        Before the first step, slot 0 of the state holds x_{n-1} and slot 1 x_n; the same holds on
        return. What a march does not have is None, and is then not compiled: ``springs``,
        ``dampers``, ``gyroscopic`` forces, ``wheel_speed`` R Omega [m/s] where sliding is
        permanent.

        Returns:
            status (RUNNING or DIVERGED), the step reached, and the number of records written. On
            divergence the last state within the displacement limit is recorded, its velocity a
            backward difference.
        """
        _ = sources
        return _march(  # type: ignore[no-any-return]
            bare(rotor), bare(casing), bare(springs), bare(dampers), bare(gyroscopic), wheel_speed,
            bare(march), bare(state), bare(records), bare(s), step, steps, record_every,
        )  # fmt: skip

    return advance  # type: ignore[no-any-return]


advance = _advance(digest(Path(__file__).parent))
"""March compiled on the first call; see the function inside `_advance`."""
