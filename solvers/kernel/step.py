"""The compiled contact step: central differences with forward-increment Lagrange multipliers.

The scheme is that of Carpenter, Taylor and Katona (1991) with damping and sliding friction:

    x_p = a x_n + b x_{n-1} + c f_n          a, b, c diagonal in modal coordinates
    0 <= lambda  perp  g_p + W lambda >= 0   W = B_N^T c (B_N + mu B_T S)
    x_{n+1} = x_p + c (B_N + mu B_T S) lambda

Springs between the bodies, and those under the shaft that stand still and differ, have a stiffness
K*(t) that turns with the rotor; they add -K*_n x_n to f_n.

Dampers at points make the damping matrix a full one, G^T G beside the diagonal. They take part in
the prediction by what it gives them, phi = -G (x_p - x_{n-1}) / (2 dt), which without contact is
the scheme itself; what a contact force changes they feel from the next step on.

Fields are evaluated in two stages so that one code serves cyclic and general stages: modal
coordinates, laid out as (rows, columns), are first summed over rows with weights, giving one
number a column, and the columns are then spread over tips or casing nodes by a shape matrix. On a
cyclic stage a column is a Fourier harmonic and both stages are small; on any other stage there is
one row, a column is a mode, and the shape matrix is dense.

`advance` takes its arrays in named tuples and makes bare addresses of them once; every other
function gets the few that it works on, because a tuple handed on costs a copy for each of its
arrays, which at this step length is more than the work itself. Slots of the state are addressed by
number for the same reason.
"""

from __future__ import annotations

from collections.abc import Callable

from numba import njit

from bladewhirl.solvers.kernel import arrays as kernel_arrays
from bladewhirl.solvers.kernel import compilation as compiled
from bladewhirl.solvers.kernel import contact as kernel_contact
from bladewhirl.solvers.kernel import fields as kernel_fields
from bladewhirl.solvers.kernel import forces as kernel_forces
from bladewhirl.solvers.kernel import kernel_motion, kernel_records
from bladewhirl.solvers.kernel import vectors as lanes
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
    U_KIND,
    U_SLOPE,
    W_KIND,
    W_SLOPE,
    Body,
    Casing,
    Dampers,
    March,
    Records,
    Rotor,
    Scratch,
    Springs,
    State,
)
from bladewhirl.solvers.kernel.compilation import ENTRY, digest
from bladewhirl.solvers.kernel.contact import (
    LAST_TRIAL,
    MENDED_TOGETHER,
    complementarity_residual,
    contact_multipliers,
    join_contacts,
    propose_contacts,
)
from bladewhirl.solvers.kernel.fields import (
    casing_tangential,
    close_gaps,
    column_sums,
    combine_rows,
    keeps_limit,
    nodal_fields,
    place_tips,
    sliding_signs,
    step_difference,
    tip_tangential,
)
from bladewhirl.solvers.kernel.forces import (
    account_contact,
    casing_columns,
    correct_casing,
    correct_rotor,
    rotor_columns,
    tip_forces,
)
from bladewhirl.solvers.kernel.kernel_motion import (
    add_load,
    add_springs,
    damp,
    damper_loss,
    damping_loss,
    energy_of_springs,
    external_work,
    load_factors,
    predict,
    settle,
    spring_forces,
    spring_stretches,
    spring_waves,
)
from bladewhirl.solvers.kernel.kernel_records import write_record
from bladewhirl.solvers.kernel.vectors import LANES, bare, load, plain, store

CHECK_EVERY = 100  # steps between looks at displacements other than the tips' radial ones


def _advance(sources: int) -> Callable[..., tuple[int, int, int]]:
    """The entry; ``sources`` is there for numba's cache, see `digest`."""

    @njit(**ENTRY)
    def advance(
        rotor: Rotor,
        casing: Casing,
        rotor_body: Body,
        casing_body: Body,
        springs: Springs | None,
        dampers: Dampers | None,
        wheel_speed: float | None,
        march: March,
        state: State,
        records: Records,
        s: Scratch,
        step: int,
        steps: int,
        record_every: int,
    ) -> tuple[int, int, int]:
        """March from ``step`` to ``step + steps``, recording at multiples of ``record_every``.

        A record at step n is written once x_{n+1} is known, its velocity being
        (x_{n+1} - x_{n-1}) / (2 dt). Before the first step, slot 0 of the state holds x_{n-1} and
        slot 1 x_n; the same holds on return.

        What a march does not have is None, and is then not compiled: ``springs``, ``dampers``,
        ``wheel_speed`` R Omega [m/s] where sliding is permanent.

        Returns:
            status (RUNNING or DIVERGED), the step reached, and the number of records written. On
            divergence the last state within the displacement limit is recorded, its velocity a
            backward difference.
        """
        _ = sources
        dt, friction, limit = march.time_step, march.friction, march.displacement_limit
        per_step, per_metre = march.elements_per_step, march.elements_per_metre
        gap_scale = march.gap_scale
        spacing, nodes, length = casing.spacing, casing.nodes, casing.element_length
        loads, factors = bare(march.loads), bare(s.load)
        xs, ys = bare(state.rotor), bare(state.casing)
        ra, rb, rc = bare(rotor_body.a), bare(rotor_body.b), bare(rotor_body.c)
        ca, cb, cc = bare(casing_body.a), bare(casing_body.b), bare(casing_body.c)
        r_load, c_load = bare(rotor_body.load), bare(casing_body.load)
        r_loaded, c_loaded = bare(rotor_body.loaded), bare(casing_body.loaded)
        r_damping, c_damping = bare(rotor_body.damping), bare(casing_body.damping)
        radial, tangential = bare(rotor.radial), bare(rotor.tangential)
        crossed, position, recess = bare(rotor.crossed), bare(rotor.position), bare(rotor.recess)
        shape, cross_shape = bare(rotor.shape), bare(rotor.cross_shape)
        spread, drag_spread = bare(rotor.spread), bare(rotor.drag_spread)
        rotor_w, r_half, r_shared = bare(rotor.w), rotor.half, rotor.shared
        w_weight, w_s_weight = bare(casing.weight[W_KIND]), bare(casing.weight[W_SLOPE])
        u_weight, u_s_weight = bare(casing.weight[U_KIND]), bare(casing.weight[U_SLOPE])
        w_shape, w_s_shape = bare(casing.shape.w), bare(casing.shape.w_slope)
        u_shape, u_s_shape = bare(casing.shape.u), bare(casing.shape.u_slope)
        w_spread, w_s_spread = bare(casing.spread.w), bare(casing.spread.w_slope)
        u_spread, u_s_spread = bare(casing.spread.u), bare(casing.spread.u_slope)
        fold, c_half, shared = bare(casing.fold), casing.half, casing.shared
        compliance, clearance = bare(casing.compliance), bare(casing.clearance)
        no_clearance = bare(casing.no_clearance)
        column, values, slopes = bare(s.columns[0]), bare(s.columns[1]), bare(s.columns[2])
        forces, factor = bare(s.forces), bare(s.factor)
        w, w_s = bare(s.nodal[0]), bare(s.nodal[1])
        free_gap, gap = bare(s.gap[0]), bare(s.gap[1])
        u_r, u_t, tip_scratch, at = bare(s.tip[0]), bare(s.tip[1]), bare(s.tip[2]), bare(s.tip[3])
        hermite, element, moved = bare(s.hermite), bare(s.element), bare(s.difference)
        sign, multiplier, diagonal = bare(s.sign), bare(s.multiplier), bare(s.diagonal)
        held, active, ends = bare(state.held), bare(s.active), bare(s.ends)
        known, on_rotor, others = bare(s.known), bare(s.on_rotor), bare(s.others)
        solve, solution, tableau = bare(s.solve), bare(s.solution), bare(s.tableau)
        basis, index, step_work = bare(s.basis), bare(s.rows), bare(s.work)
        work, count, residual = bare(state.work), bare(state.counts), bare(state.residual)
        smallest, impulse = bare(state.gap), bare(state.impulse)
        drag, touched = bare(state.drag), bare(state.touched)
        zero, one, two = plain(0), plain(1), plain(2)
        earlier, later_waves, spring_energy, parametric = zero, one, 0.0, 0.0
        if springs is not None:
            diameter, spring = bare(springs.nodal_diameter), bare(springs.factor)
            r_place, c_place = bare(springs.rotor_place), bare(springs.casing_place)
            r_wave, c_wave = bare(springs.rotor_wave), bare(springs.casing_wave)
            r_amplitude = bare(springs.rotor_amplitude)
            c_amplitude = bare(springs.casing_amplitude)
            r_waves, c_waves = bare(s.rotor_waves), bare(s.casing_waves)
            stretch, pull, turn = bare(s.stretch), bare(s.spring_force), springs.angle_per_step
            spring_waves(r_place, r_wave, r_amplitude, xs, zero, r_waves, earlier)
            spring_waves(c_place, c_wave, c_amplitude, ys, zero, c_waves, earlier)
        if dampers is not None:
            r_damper, r_solve = bare(dampers.rotor), bare(dampers.rotor_solve)
            c_damper, c_solve = bare(dampers.casing), bare(dampers.casing_solve)
            stroke, damper_force = bare(s.stroke), bare(s.damper_force)
        for j in range(len(sign)):
            sign[j], known[0, j] = march.sliding, -1
        tips, written, status = len(element), zero, RUNNING
        old, now, new, end = zero, one, two, step + steps
        while step < end:
            recording = step % record_every == 0
            loaded = load_factors(loads, step * dt, factors)
            if springs is not None:
                angle, last_angle = turn * step, turn * (step - 1)
                spring_waves(r_place, r_wave, r_amplitude, xs, now, r_waves, later_waves)
                spring_waves(c_place, c_wave, c_amplitude, ys, now, c_waves, later_waves)
                spring_stretches(
                    diameter, angle, last_angle, r_waves, c_waves, earlier, later_waves, stretch
                )
                spring_energy = energy_of_springs(spring, stretch, zero)
                parametric = energy_of_springs(spring, stretch, two) - spring_energy
                spring_forces(diameter, spring, angle, stretch, pull)
                earlier, later_waves = later_waves, earlier
            contacts = count[STEP_CONTACTS]
            count[STEP_CONTACTS] = 0
            trial, size, penetrating, within = zero, zero, zero, True
            while True:
                if trial != 1:
                    # Predict without contact.
                    predict(ra, rb, xs, old, now, new)
                    predict(ca, cb, ys, old, now, new)
                    if loaded:
                        add_load(r_load, r_loaded, factors, rc, xs, new)
                        add_load(c_load, c_loaded, factors, cc, ys, new)
                    if springs is not None:
                        add_springs(r_place, r_wave, r_amplitude, pull, zero, rc, xs, new)
                        add_springs(c_place, c_wave, c_amplitude, pull, one, cc, ys, new)
                    if dampers is not None:
                        damp(r_damper, r_solve, rc, xs, old, new, stroke, damper_force, zero)
                        damp(c_damper, c_solve, cc, ys, old, new, stroke, damper_force, one)

                if trial == 0:
                    # Where the tips stand at the end of the step.
                    for j in range(0, len(at), LANES):
                        store(at, j, load(position, j))
                    if per_metre != 0.0:
                        tip_tangential(
                            tangential, crossed, shape, cross_shape, xs, new, column, u_t,
                            tip_scratch,
                        )  # fmt: skip
                        for j in range(tips):
                            at[j] += per_metre * u_t[j]
                    place_tips(at, per_step * (step + 1), nodes, length, hermite, element)
                    column_sums(radial, xs, new, zero, column)
                    column_sums(w_weight, ys, new, zero, values)
                    column_sums(w_s_weight, ys, new, c_half, slopes)
                else:
                    trial, size = contact_multipliers(
                        trial, free_gap, active, held, compliance, spacing, rotor_w, sign, nodes,
                        hermite, element, known, on_rotor, ends, index, solve, others, diagonal,
                        solution, tableau, basis, multiplier, count,
                    )  # fmt: skip
                    # Correct.
                    mixed, ratio = tip_forces(
                        active, size, multiplier, sign, friction, nodes, hermite, element, index,
                        factor,
                    )  # fmt: skip
                    dragging, slides = rotor_columns(
                        spread, drag_spread, r_shared, mixed, ratio, active, factor, size, r_half,
                        forces,
                    )  # fmt: skip
                    correct_rotor(
                        rc, forces, dragging, slides, r_half, radial, tangential, crossed, xs, old,
                        new, step_work, column,
                    )  # fmt: skip
                    dragging, slides = casing_columns(
                        w_spread, w_s_spread, u_spread, u_s_spread, shared, mixed, ratio, index,
                        factor, 2 * size, c_half, forces,
                    )  # fmt: skip
                    correct_casing(
                        cc, forces, dragging, slides, c_half, w_weight, w_s_weight, u_weight,
                        u_s_weight, ys, old, new, step_work, values, slopes,
                    )  # fmt: skip

                combine_rows(shape, column, u_r)
                nodal_fields(
                    fold, w_shape, w_s_shape, values, slopes, c_half, nodes, clearance, w, w_s
                )
                found = free_gap if trial == 0 else gap
                within = close_gaps(w, w_s, hermite, element, u_r, recess, limit, found)
                if trial == 0:
                    penetrating = propose_contacts(free_gap, held)
                    if penetrating == 0:
                        break
                    if wheel_speed is not None:
                        step_difference(xs, now, old, moved, zero)
                        step_difference(ys, now, old, moved, one)
                        tip_tangential(
                            tangential, crossed, shape, cross_shape, moved, zero, column, u_t,
                            tip_scratch,
                        )  # fmt: skip
                        casing_tangential(
                            u_weight, u_s_weight, fold, u_shape, u_s_shape, c_half, moved, one,
                            values, slopes, nodes, no_clearance, w, w_s, hermite, element,
                            tip_scratch,
                        )  # fmt: skip
                        sliding_signs(u_t, tip_scratch, wheel_speed, dt, sign)
                else:
                    if trial >= LAST_TRIAL or not within:
                        break
                    if join_contacts(gap, held, trial > MENDED_TOGETHER) == 0:
                        break
                    count[LCP_PIVOTS] += 1
                trial += 1

            if within and (step + 1) % CHECK_EVERY == 0:
                tip_tangential(
                    tangential, crossed, shape, cross_shape, xs, new, column, u_t, tip_scratch
                )
                within = keeps_limit(u_t, tips, w, clearance, nodes, limit)

            if recording or not within:
                later, interval = (new, 2.0 * dt) if within else (now, dt)
                write_record(
                    records, written, state, rotor_body.stiffness, casing_body.stiffness, dt, step,
                    contacts, spring_energy, old, now, later, interval,
                )  # fmt: skip
                written += 1
            if not within:
                status = DIVERGED
                break

            # Accept the step.
            if penetrating > 0:
                worst = complementarity_residual(gap_scale, free_gap, gap, diagonal, multiplier)
                residual[0] = max(residual[0], worst)
                work[NORMAL] += step_work[0]
                work[FRICTION] += step_work[1]
                account_contact(multiplier, sign, friction, dt, impulse, drag, touched, held, count)
                for j in range(tips):
                    smallest[j] = min(smallest[j], gap[j])
            else:
                for j in range(tips):
                    smallest[j] = min(smallest[j], free_gap[j])
            if loaded:
                work[EXTERNAL] += external_work(r_load, r_loaded, factors, xs, old, new)
                work[EXTERNAL] += external_work(c_load, c_loaded, factors, ys, old, new)
            work[DAMPING] += (
                damping_loss(r_damping, xs, old, new) + damping_loss(c_damping, ys, old, new)
            ) / dt
            if springs is not None:
                work[PARAMETRIC] += parametric
            if dampers is not None:
                work[DAMPING] += damper_loss(r_damper, xs, old, new, stroke, damper_force, zero)
                work[DAMPING] += damper_loss(c_damper, ys, old, new, stroke, damper_force, one)
            old, now, new = now, new, old
            step += 1
        settle(xs, old, now, new)
        settle(ys, old, now, new)
        return status, step, written

    return advance  # type: ignore[no-any-return]


advance = _advance(
    digest(
        compiled, kernel_arrays, kernel_contact, kernel_fields, kernel_forces, kernel_motion,
        kernel_records, lanes,
    )
)  # fmt: skip
"""March compiled on the first call; see the function inside `_advance`."""
