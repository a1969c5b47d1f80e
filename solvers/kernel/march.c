/* A step of the contact march: central differences with forward-increment Lagrange multipliers.
 *
 * The scheme is that of Carpenter, Taylor and Katona (1991) with damping and sliding friction. A
 * step from n to n + 1 has six stages:
 *
 *     predict   x_p = a x_n + b x_{n-1} + c f_n          a, b, c diagonal in modal coordinates
 *     gaps      g_p = gaps of x_p, with nodes at their positions at n + 1; if none is negative,
 *               x_{n+1} = x_p
 *     solve     0 <= lambda  perp  g_p + W lambda >= 0   W = B_N^T c (B_N + mu B_T S)
 *     correct   x_{n+1} = x_p + c (B_N + mu B_T S) lambda; if this makes gaps of other nodes
 *               negative, these nodes are added to the group
 *     account   add impulses, works and losses of the step, and update the smallest gaps
 *     record    at record steps: x_n, the velocity (x_{n+1} - x_{n-1}) / (2 dt), and works up to n
 *
 * S is the diagonal matrix of the signs of sliding. `nodes.h` has the equations of nodes that slide in
 * any direction or stick, and of nodes without mass.
 *
 * Springs between the bodies, and unequal static springs of the shaft, have a stiffness K*(t) that
 * depends on the angle of the rotor; they add -K*_n x_n to f_n.
 *
 * Point dampers add the full matrix G^T G to the diagonal damping matrix. They are included in the
 * prediction, phi = -G (x_p - x_{n-1}) / (2 dt), which is exact for the scheme without contact.
 * They respond to a contact force from the next step on.
 *
 * With Coriolis forces, the matrix A = M / dt^2 + (D + 2 Omega G) / (2 dt) of the rotor is not
 * diagonal; it has a block for each nodal diameter. c is then the inverse of A, and D includes the
 * point dampers of the rotor and the damping of its modes at rest.
 *
 * Fields are evaluated in two stages, so that the same code is used for cyclic and general bodies.
 * Modal coordinates, arranged in rows and columns, are first summed over rows with weights, which
 * gives a number for each column. A shape matrix then converts the numbers of the columns to values
 * at blades or casing nodes. On a cyclic body a column is a Fourier harmonic, and both stages are
 * small. On any other casing there is one row, a column is a mode, and the shape matrix is dense;
 * any other rotor has dense matrices for each copy.
 *
 * `tests/support/reference_march.py` is the same scheme in NumPy, which follows the definitions.
 */
#include "nodes.h"
#include "drive.h"
#include "fuse.h"

/* Compute x_p of both bodies. */
static inline void predict(March *m)
{
    const Body *rotor = &m->stage.rotor->body, *casing = &m->stage.casing->body;
    Scratch *s = m->scratch;
    Motion x = m->x, y = m->y;
    predict_body(rotor, x);
    predict_body(casing, y);
    if (m->loaded) {
        add_loads(rotor, s->amplitude.at, x);
        add_loads(casing, s->amplitude.at, y);
    }
    if (m->stage.springs) {
        const double *force = s->springs.force.at;
        add_springs(&m->stage.springs->rotor, force, rotor->c.at, x.new);
        add_springs(&m->stage.springs->casing, force + s->springs.force.columns, casing->c.at, y.new);
    }
    if (m->stage.dampers) {
        double *force = s->damper_force.at;
        if (!m->stage.gyroscopic)
            add_dampers(&m->stage.dampers->rotor, rotor->c.at, x, s->stroke.at, force);
        force += s->damper_force.columns;
        add_dampers(&m->stage.dampers->casing, casing->c.at, y, s->stroke.at, force);
    }
    if (m->stage.rotor->massless > 0.0)
        add_node_forces(m);
    if (m->stage.gyroscopic) {
        add_circulation(m->stage.gyroscopic, m->rotation.circulation, x);
        const Vector *further = &s->speed.force; /* empty if only the loads depend on the speed */
        turn(m->stage.rotor, m->stage.gyroscopic, x, further->size > 0 ? further->at : NULL,
             s->turned.at);
    }
    if (m->stage.bearings)
        add_bearings(m);
    if (m->stage.drive)
        predict_drive(m);
}

/* Add the impulses, works and losses of an accepted step to the state. */
static inline void account(March *m, int64_t step, int touching)
{
    State *state = m->state;
    Scratch *s = m->scratch;
    Motion x = m->x, y = m->y;
    double *work = state->work.at;
    const double *gap = touching ? s->fields.gap.at : s->fields.free_gap.at;
    double *before = state->gaps.at + (step + 1) % 2 * state->gaps.columns;
    state->counts.at[STEP_CONTACTS] = 0.0;
    account_nodes(m, touching, gap, before);
    if (m->stage.joints)
        account_joints(m);
    for (int64_t j = 0; j < state->gap.size; j++) {
        before[j] = gap[j];
        state->gap.at[j] = smaller(state->gap.at[j], gap[j]);
    }
    if (m->loaded) {
        work[EXTERNAL] += external_work(&m->stage.rotor->body, s->amplitude.at, x);
        work[EXTERNAL] += external_work(&m->stage.casing->body, s->amplitude.at, y);
    }
    double lost = damping_loss(&m->stage.casing->body, y);
    if (m->stage.gyroscopic) {
        lost += turning_loss(m->stage.rotor, m->stage.gyroscopic, x, s->turned.at);
        work[PARAMETRIC] += circulation_work(m->stage.gyroscopic, m->rotation.circulation, x);
    } else
        lost += damping_loss(&m->stage.rotor->body, x);
    work[DAMPING] += lost / m->stage.numbers->time_step;
    if (m->stage.speed)
        account_speed(m);
    if (m->stage.drive)
        account_drive(m, step, touching);
    if (m->stage.bearings)
        account_bearings(m, step);
    if (m->stage.dampers) {
        const double *force = s->damper_force.at;
        work[DAMPING] += damper_loss(&m->stage.dampers->rotor, x, s->stroke.at, force);
        force += s->damper_force.columns;
        work[DAMPING] += damper_loss(&m->stage.dampers->casing, y, s->stroke.at, force);
    }
}

/* Note an accepted step whose contact problem was not solved; `before` and `removed` are the number of
 * such steps and the worn volume before it. */
static void note_unsolved(March *m, int64_t step, double before, double removed)
{
    const State *state = m->state;
    double *counts = state->counts.at, force = 0.0;
    if (counts[UNSOLVED] == before)
        return;
    if (before == 0.0)
        counts[FIRST_UNSOLVED] = (double)(step + 1);
    counts[UNSOLVED] = before + 1.0;
    for (int64_t n = 0; n < state->touched.size; n++)
        force -= state->force.at[DIRECTIONS * n + RADIAL];
    counts[UNSOLVED_IMPULSE] += m->stage.numbers->time_step * force;
    if (state->coating.size > 0)
        counts[UNSOLVED_WEAR] += state->coating.at[REMOVED] - removed;
}

/* Initialise what is kept between steps, and the waves at the springs of the previous step. */
static void begin(March *m, int64_t step)
{
    m->held = m->pushed = 1;
    if (m->scratch->nodes.known.size > 0)
        m->scratch->nodes.known.at[0] = -1;
    if (m->stage.foreshortening)
        resume_bending(m->stage.foreshortening, m->state, step, &m->scratch->bending);
    if (m->stage.springs) {
        SpringScratch *s = &m->scratch->springs;
        int64_t waves = m->stage.springs->factor.size, row = (step + 1) % 2 * waves;
        spring_waves(&m->stage.springs->rotor, m->x.old, s->rotor.at + row, waves);
        spring_waves(&m->stage.springs->casing, m->y.old, s->casing.at + row, waves);
    }
}

int march(const Stage *stage, State *state, Records *records, Vector arena, int64_t step,
          int64_t steps, int64_t record_every, int64_t *reached)
{
    const Numbers *numbers = stage->numbers;
    const Springs *springs = stage->springs;
    const Rotor *rotor = stage->rotor;
    const Casing *casing = stage->casing;
    Scratch working, *scratch = &working;
    lay_scratch(&(Arena){.at = arena.at}, stage, state, scratch);
    March m = {.stage = *stage, .state = state, .scratch = scratch,
               .x = motion_of(&state->rotor), .y = motion_of(&state->casing)};
    double energy[2] = {0.0, 0.0}, dt = numbers->time_step;
    int64_t end = step + steps, written = 0, touching;
    int status = RUNNING;
    begin(&m, step);
    for (; step < end; step++) {
        if (stage->drive)
            prepare_drive(&m, step, step == end - steps);
        else
            prepare_speed(&m, step, step == end - steps);
        m.loaded = load_amplitudes(&numbers->loads, stage->speed,
                                   &m.rotation, (double)step * dt, scratch->amplitude.at);
        if (springs)
            turn_springs(springs, m.rotation.angle, m.x, m.y, &scratch->springs, step, energy);
        double stored = stage->bearings ? turn_bearings(&m, step == end - steps) : 0.0;
        double unsolved = state->counts.at[UNSOLVED];
        double removed = state->coating.size > 0 ? state->coating.at[REMOVED] : 0.0;
        predict(&m);
        int within = solve_nodes(&m, step, &touching);
        if (within && (step + 1) % CHECK_EVERY == 0)
            within = keeps_limit(&m) && (!stage->bearings || bearings_keep_limit(&m));
        if (step % record_every == 0 || !within) {
            stored += energy[0] + flexible_energy(&m);
            if (stage->joints)
                record_joints(&m, records, written);
            if (stage->speed)
                stored += record_speed(&m, records, written);
            if (stage->drive)
                record_drive(&m, records, written);
            write_record(records, written++, state, rotor, casing, m.x, m.y, dt, stored, step,
                         within);
        }
        if (!within) {
            status = DIVERGED;
            break;
        }
        account(&m, step, touching > 0);
        note_unsolved(&m, step, unsolved, removed);
        state->work.at[PARAMETRIC] += energy[1];
        turn_slots(&m.x);
        turn_slots(&m.y);
        if (stage->fuse && fuses(stage->fuse, m.x.now)) {
            status = FUSED;
            step++;
            break;
        }
    }
    settle(&state->rotor, m.x);
    settle(&state->casing, m.y);
    reached[0] = step;
    reached[1] = written;
    return status;
}
