/* A step of the contact march: central differences with forward-increment Lagrange multipliers.
 *
 * The scheme is that of Carpenter, Taylor and Katona (1991) with damping and sliding friction. A
 * step from n to n + 1 has six stages:
 *
 *     predict   x_p = a x_n + b x_{n-1} + c f_n          a, b, c diagonal in modal coordinates
 *     gaps      g_p = gaps of x_p, with tips at their positions at n + 1; if none is negative,
 *               x_{n+1} = x_p
 *     solve     0 <= lambda  perp  g_p + W lambda >= 0   W = B_N^T c (B_N + mu B_T S)
 *     correct   x_{n+1} = x_p + c (B_N + mu B_T S) lambda; if this makes gaps of other tips
 *               negative, these tips are added to the active set
 *     account   add impulses, works and losses of the step, and update the smallest gaps
 *     record    at record steps: x_n, the velocity (x_{n+1} - x_{n-1}) / (2 dt), and works up to n
 *
 * S is the diagonal matrix of the signs of sliding.
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
 * at tips or casing nodes. On a cyclic body a column is a Fourier harmonic, and both stages are
 * small. On any other body there is one row, a column is a mode, and the shape matrix is dense.
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
    if (m->coated) {
        add_coating(rotor, &s->coating.rotor, x);
        add_coating(casing, &s->coating.casing, y);
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
    if (m->stage.nodes && m->stage.nodes->massless > 0.0)
        add_node_forces(m);
    if (m->stage.gyroscopic) {
        add_circulation(m->stage.gyroscopic, m->rotation.circulation, x);
        const Vector *further = &s->speed.force; /* empty if only the loads depend on the speed */
        turn(m->stage.rotor, m->stage.gyroscopic, x, further->size > 0 ? further->at : NULL,
             s->turned.at);
    }
    if (m->stage.drive)
        predict_drive(m);
}

/* Add the response to the contact forces of the active set to x_p. */
static inline void correct(March *m, int64_t size)
{
    FieldScratch *f = &m->scratch->fields;
    ContactScratch *c = &m->scratch->contact;
    double ratio;
    BendScratch *s = &m->scratch->bending;
    const double *along = NULL;
    int mixed = tip_forces(size, m->stage.numbers->friction, m->stage.casing->nodes, f, c, &ratio);
    if (m->stage.foreshortening
        && push_along(m->stage.foreshortening, c->active.at, size, c->multiplier.at, NULL,
                      m->x.new, s, s->force.at))
        along = s->force.at;
    if (m->stage.gyroscopic)
        correct_turning_rotor(m->stage.rotor, m->stage.gyroscopic, size, mixed, ratio, along, m->x,
                              f, c, m->scratch->turned.at);
    else if (along)
        correct_rotor(m->stage.rotor, size, mixed, ratio, along, m->x, f, c);
    else
        correct_rotor(m->stage.rotor, size, mixed, ratio, NULL, m->x, f, c);
    correct_casing(m->stage.casing, size, mixed, ratio, m->y, f, c);
}

/* Compute the gaps of x_p with the tips at their positions at the end of the step; `recess` gets the
 * recess of the tips. Returns whether x_p is within the displacement limit. */
static inline int find_gaps(const March *m, int64_t step, const double **recess)
{
    const Numbers *numbers = m->stage.numbers;
    FieldScratch *f = &m->scratch->fields;
    place_tips(m->stage.rotor, m->stage.casing, numbers->elements_per_metre,
               m->rotation.elements, m->x.new, f);
    *recess = recess_at(m->stage.rotor, m->stage.closure, (double)(step + 1) * numbers->time_step, f);
    sum_radial(m->stage.rotor, m->stage.casing, m->x.new, m->y.new, f);
    return close_gaps(m->stage.rotor, m->stage.casing, *recess, numbers->displacement_limit, f,
                      f->free_gap.at);
}

/* Press the tips into the coating at x_p, after `find_gaps`, and compute the modal forces. Returns
 * whether any tip touches the coating. */
static int press_coating(const March *m, int64_t step)
{
    const Numbers *numbers = m->stage.numbers;
    const Coating *coating = m->stage.coating;
    FieldScratch *f = &m->scratch->fields;
    ContactScratch *c = &m->scratch->contact;
    CoatingScratch *s = &m->scratch->coating;
    const double *places = numbers->elements_per_metre == 0.0 ? m->stage.rotor->position.at : f->at.at;
    double nodes = (double)m->stage.casing->nodes, rate, closed = 0.0;
    double removable = coating->limit * coating->thickness;
    double turned = m->rotation.elements;
    int64_t size = 0, wide = c->factor.columns;
    if (m->stage.closure)
        closed = closure_at(m->stage.closure, (double)(step + 1) * numbers->time_step, &rate);
    if (m->stage.numbers->is_signed != 0.0) {
        sliding_signs(m->stage.rotor, m->stage.casing, m->rotation.wheel_speed, numbers->time_step, m->x, m->y, f,
                      c->sign.at);
        sum_radial(m->stage.rotor, m->stage.casing, m->x.new, m->y.new, f);
        nodal_field(m->stage.casing, &m->stage.casing->radial, f);
    }
    s->sums.at[REMOVED] = s->sums.at[DISSIPATED] = s->sums.at[STORED] = 0.0;
    for (int64_t j = 0; j < s->push.size; j++) {
        double place = places[j] + turned;
        place -= nodes * floor(place / nodes);
        double recess = m->stage.rotor->recess.at[j] - removable;
        if (m->stage.foreshortening)
            recess += m->scratch->bending.opened.at[j];
        s->push.at[j] = press_tip(coating, m->stage.casing, m->stage.closure, closed, j, place,
                                  f->free_gap.at[j] - removable, recess,
                                  coating->friction * c->sign.at[j], f, m->state->strain.at, s);
        if (s->push.at[j] != 0.0)
            c->active.at[size++] = j;
    }
    if (size == 0)
        return 0;
    int mixed = 0;
    double ratio = coating->friction * c->sign.at[c->active.at[0]];
    for (int64_t n = 0; n < size; n++) {
        int64_t j = c->active.at[n];
        double slides = coating->friction * c->sign.at[j];
        mixed |= slides != ratio;
        c->factor.at[PUSH * wide + n] = -s->push.at[j];
        c->factor.at[DRAG * wide + n] = -s->push.at[j] * slides;
    }
    rotor_coating_force(m->stage.rotor, size, mixed, ratio, c, &s->rotor);
    if (m->stage.foreshortening)
        push_along(m->stage.foreshortening, c->active.at, size, s->push.at, s->rotor.at, NULL,
                   &m->scratch->bending, s->rotor.at);
    int64_t count = gather_nodes(m->stage.casing, s, c);
    casing_coating_force(m->stage.casing, count, mixed, ratio, c, &s->casing);
    return 1;
}

/* Compute x_{n+1} with contact. Returns whether x_{n+1} is within the displacement limit;
 * `penetrating` gets the number of tips that are inside the casing at x_p. */
static inline int solve_step(March *m, int64_t step, int64_t *penetrating)
{
    const Rotor *rotor = m->stage.rotor;
    const Casing *casing = m->stage.casing;
    const Numbers *numbers = m->stage.numbers;
    State *state = m->state;
    FieldScratch *f = &m->scratch->fields;
    ContactScratch *c = &m->scratch->contact;
    double limit = numbers->displacement_limit;
    BendScratch *bending = &m->scratch->bending;
    const double *recess;
    m->coated = 0;
    predict(m);
    if (m->stage.nodes)
        return solve_nodes(m, step, penetrating);
    int within = find_gaps(m, step, &recess);
    if (m->stage.foreshortening && within) {
        if (bend_tips(m->stage.foreshortening, rotor, state, f->free_gap.at, step + 1, m->x,
                      bending))
            c->known.at[0] = -1;
        open_gaps(bending, m->x.new, f->free_gap.at);
    }
    if (m->stage.coating && within && (m->coated = press_coating(m, step))) {
        if (m->stage.gyroscopic || m->stage.dampers)
            predict(m); /* which also includes the forces of the coating */
        else {
            add_coating(&rotor->body, &m->scratch->coating.rotor, m->x);
            add_coating(&casing->body, &m->scratch->coating.casing, m->y);
        }
        within = find_gaps(m, step, &recess);
        if (m->stage.foreshortening && within)
            open_gaps(bending, m->x.new, f->free_gap.at);
    }
    *penetrating = propose_contacts(f->free_gap.at, &state->held);
    if (*penetrating == 0)
        return within;
    if (m->stage.numbers->is_signed != 0.0)
        sliding_signs(rotor, casing, m->rotation.wheel_speed, numbers->time_step, m->x, m->y, f,
                      c->sign.at);
    Candidates tips = {c->multiplier.size, f->free_gap.at, state->held.at, c->multiplier.at, NULL};
    int solved = 1;
    for (int64_t trial = 1;; trial++) {
        if (trial > 1)
            predict(m);
        int64_t size = contact_multipliers(&trial, &solved, m, &tips, fill_tips);
        state->counts.at[UNSOLVED] += !solved;
        correct(m, size);
        within = close_gaps(rotor, casing, recess, limit, f, f->gap.at);
        if (m->stage.foreshortening && within)
            open_corrected(bending, c, size, f->gap.at);
        if (trial >= LAST_TRIAL || !within)
            return within;
        if (join_contacts(f->gap.at, &state->held, trial > MENDED_TOGETHER) == 0)
            return within;
    }
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
    if (m->stage.nodes)
        account_nodes(m, touching, gap, before);
    else if (touching) {
        double worst = complementarity_residual(m->stage.numbers->gap_scale, &s->fields, &s->contact);
        state->counts.at[RESIDUAL] = larger(state->counts.at[RESIDUAL], worst);
        work[NORMAL] += s->contact.work.at[0];
        work[FRICTION] += s->contact.work.at[1];
        account_contact(m->stage.numbers, state, &s->contact, gap, before);
    }
    if (m->stage.coating)
        state->coating.at[STORED] = 0.0;
    if (m->coated)
        account_coating(m->stage.coating, m->stage.numbers, state, &s->coating, &s->contact, x, y,
                        touching);
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
        account_drive(m, touching);
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
    const Vector *pushes = &m->scratch->contact.multiplier;
    if (counts[UNSOLVED] == before)
        return;
    if (before == 0.0)
        counts[FIRST_UNSOLVED] = (double)(step + 1);
    counts[UNSOLVED] = before + 1.0;
    for (int64_t n = 0; m->stage.nodes && n < state->touched.size; n++)
        force -= state->force.at[DIRECTIONS * n + RADIAL];
    for (int64_t n = 0; !m->stage.nodes && n < pushes->size; n++)
        force += pushes->at[n];
    counts[UNSOLVED_IMPULSE] += m->stage.numbers->time_step * force;
    if (state->coating.size > 0)
        counts[UNSOLVED_WEAR] += state->coating.at[REMOVED] - removed;
}

/* Initialise the directions of sliding, and the waves at the springs of the previous step. */
static void begin(const March *m, int64_t step)
{
    ContactScratch *c = &m->scratch->contact;
    for (int64_t j = 0; j < c->sign.size; j++)
        c->sign.at[j] = m->stage.numbers->sliding;
    for (int64_t j = 0; j < c->known.columns; j++)
        c->known.at[j] = -1;
    if (m->stage.foreshortening)
        resume_bending(m->stage.foreshortening, m->state, step, &m->scratch->bending);
    if (m->stage.springs) {
        SpringScratch *s = &m->scratch->springs;
        int64_t waves = m->stage.springs->factor.size, row = (step + 1) % 2 * waves;
        spring_waves(&m->stage.springs->rotor, m->x.old, s->rotor.at + row, waves);
        spring_waves(&m->stage.springs->casing, m->y.old, s->casing.at + row, waves);
    }
}

int march(const Stage *stage, State *state, Records *records, Scratch *scratch, int64_t step,
          int64_t steps, int64_t record_every, int64_t *reached)
{
    const Numbers *numbers = stage->numbers;
    const Springs *springs = stage->springs;
    const Rotor *rotor = stage->rotor;
    const Casing *casing = stage->casing;
    March m = {.stage = *stage, .state = state, .scratch = scratch,
               .x = motion_of(&state->rotor), .y = motion_of(&state->casing)};
    double energy[2] = {0.0, 0.0}, dt = numbers->time_step;
    int64_t end = step + steps, written = 0, penetrating;
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
        double unsolved = state->counts.at[UNSOLVED];
        double removed = state->coating.size > 0 ? state->coating.at[REMOVED] : 0.0;
        int within = solve_step(&m, step, &penetrating);
        if (within && (step + 1) % CHECK_EVERY == 0)
            within = keeps_limit(rotor, casing, numbers->displacement_limit, m.x.new,
                                 &scratch->fields) &&
                     (!stage->nodes || nodes_keep_limit(&m));
        if (step % record_every == 0 || !within) {
            double stored = energy[0] + (stage->nodes ? flexible_energy(&m) : 0.0);
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
        account(&m, step, penetrating > 0);
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
