/* Data of the compiled marches: names, shapes and units.
 *
 * Python makes these structs from NumPy arrays (`structs.py`). The comment of an array begins with
 * its shape, with which Python makes and checks the array: numbers, or names of lengths, which have
 * the same value in the entire struct. Arrays that a march does not need are empty. Matrices are
 * stored row by row. The lengths `columns`, `wide` (tips or nodes) and `closed` (nodes of each wall,
 * and its first node again) are padded with zeros to a multiple of LANES. All lines for the preprocessor
 * begin with #; the other lines are passed to cffi.
 */
#ifndef KERNEL_H
#define KERNEL_H

#include <stdint.h>

enum { LANES = 8, HALF = 4 }; /* number of doubles in a register, and in a narrow register */
enum { ROWS = 4 };            /* number of rows of a block that are summed at a time */
enum { RUNNING, DIVERGED, FUSED }; /* status of a march */
enum { CHECK_EVERY = 100 };   /* steps between checks of all but the radial tip displacements */

/* Rows of forces and of nodal values of the casing nodes: w, w', u, u'. */
enum { W_KIND, W_SLOPE, U_KIND, U_SLOPE, KINDS };
/* Kinds of work; CLOSING is the part of NORMAL that stops tips as their gaps close. */
enum { EXTERNAL, NORMAL, FRICTION, DAMPING, PARAMETRIC, CLOSING, WORKS };
/* Sums of the coating: removed volume, dissipated and stored energy. */
enum { REMOVED, DISSIPATED, STORED, COATING_SUMS };
/* Counts of a state: largest complementarity residual, steps with contact, steps with an unsolved
 * contact problem, contacts at the last step; the first unsolved step, and the impulse [N s] and the
 * worn volume [m3] of the unsolved steps. */
enum { RESIDUAL, CONTACT_STEPS, UNSOLVED, STEP_CONTACTS, FIRST_UNSOLVED, UNSOLVED_IMPULSE,
       UNSOLVED_WEAR, COUNTS };
enum { LOAD_END, LOAD_RAMP, LOAD_FREQUENCY, LOAD_PHASE, LOAD_NUMBERS };

typedef struct {
    double *at;
    int64_t size;
} Vector;

typedef struct {
    double *at;
    int64_t rows, columns;
} Matrix;

typedef struct {
    int64_t *at;
    int64_t size;
} IntVector;

typedef struct {
    int64_t *at;
    int64_t rows, columns;
} IntMatrix;

typedef struct {
    double *at;
    int64_t layers, rows, columns;
} Cube;

/* Recurrence of the modes of a body; there are rows * columns entries, and padding is zero. If
 * Coriolis forces couple the modes, A is not diagonal, and a, b, c give A (x_{n+1} - x_{n-1}). */
typedef struct {
    Vector a;         /* (entries) factor of x_n */
    Vector b;         /* (entries) factor of x_{n-1} */
    Vector c;         /* (entries) factor of forces: inverse of the diagonal matrix A [s2] */
    Vector stiffness; /* (entries) omega^2 [rad2/s2] */
    Vector damping;   /* (entries) 2 xi omega [rad/s] */
    Matrix load;      /* (patterns, entries) load patterns */
    IntMatrix loaded; /* (patterns, registers) positions of the registers of each pattern that are
                       * not zero, padded with -1 */
} Body;

/* Directions of the displacement of a contact node: radial, tangential, axial. */
enum { RADIAL, TANGENTIAL, AXIAL, DIRECTIONS };

/* The bladed disk with its contact nodes, the ends of blades of beams among them. It consists of
 * copies that do not influence each other; contact nodes follow copy by copy, and in a copy blade by
 * blade. `components` are the displacements of the nodes of a copy, DIRECTIONS for each node;
 * `blade_components` are those of the nodes of a blade.
 *
 * If all blades are equal, a component of a blade is a sum over harmonics: the modes are arranged in
 * columns, which are cosines and sines of the harmonics at the blades. On any other bladed disk each
 * copy has a row of modes, and its components are dense. */
typedef struct {
    Body body;
    int64_t copies;     /* number of copies */
    int64_t half;       /* number of columns between cosine and sine, see `Arrangement`; 0 without
                         * harmonics */
    Matrix contact;     /* (components, modes) displacements of unit modal coordinates */
    Cube columns;       /* (3, modes, nodes) the same by direction, transposed */
    Cube own;           /* (blade_components, rows, columns) weight of each mode in its column */
    Cube across;        /* (blade_components, rows, columns) weight in the partner column */
    IntVector crosses;  /* (blade_components) 1 if weights in partner columns are not zero */
    Cube answer;        /* (turning_components, rows, columns) response of the modes to forces in their
                         * column within the step, with Coriolis forces; otherwise empty */
    Cube answer_across; /* (turning_components, rows, columns) response to forces in the partner
                         * column */
    Matrix shape;       /* (sums, blades_wide) value of each column at each blade */
    Matrix fold;        /* (folded_blades, quarter_blades) `shape` on a quarter of the circle, see
                         * `fold_field`, or empty */
    Matrix spread;      /* (blades, columns) transpose of `shape` */
    Cube compliance;    /* (copies, components, components) for each unit force within the step, change
                         * of the radial displacements of all nodes, then of the others [m/N] */
    Vector radius;      /* (wide) radius of each node [m] */
    Vector position;    /* (wide) angle of each node in elements of the casing */
    IntVector wall;     /* (tips) number of the first node of the wall around each node; empty with
                         * one wall */
    Vector recess;      /* (wide) gap of each node at rest minus the clearance [m] */
    Vector normal_part; /* (wide) part of radial lengths that is normal to the wall at each node, on
                         * top of what the clearance contains */
    double massless;    /* 1 if the nodes have no mass; forces then act in the next step */
    double full;        /* 1 if friction is opposite to the slip velocity, otherwise it is tangential */
    double axial;       /* 1 if forces on nodes have axial parts */
} Rotor;

/* Sums of a pair of nodes of a joint: steps in each state since the last record; slip [m], and the
 * energy that the pair takes, the part of it by slip [J], since the start. */
enum { JOINT_OPEN, JOINT_STUCK, JOINT_SLIPPING, JOINT_SLIP, JOINT_WORK, JOINT_WEAR, JOINT_SUMS };

/* Friction joints between nodes without mass, see `joints.h`. A pair has two ends, its left node on the
 * next blade and its right node, or a node and a body, and three values: along the normal and two
 * tangents. */
typedef struct {
    IntVector node;    /* (ends) contact node at each end, -1 at a body */
    Cube axes;         /* (ends, 3, 3) values of the pair for unit displacements of the node */
    IntVector joined;  /* (tips) 1 for nodes in pairs */
    Vector friction;   /* (pairs) friction coefficient */
    Vector gap;        /* (pairs) gap without displacements, negative if they overlap [m] */
    Vector soft;       /* (pairs) flexibility of the natural map [m/N] */
    Matrix compliance; /* (values, wide_values) for each unit force, change of all values [m/N] */
    Matrix modal;      /* (values, wide_values) the part of it due to the modes */
    Matrix given;      /* (patterns, values) values due to the load patterns and the modes that are
                        * left out [m] */
    IntVector body;    /* (pairs) body of each pair, or -1 */
    Cube body_axes;    /* (pairs, 3, 3) values of the pair for unit displacements of its body, times
                        * -1 */
    Vector mobility;   /* (body_values) inverse of the mass in each direction, 0 if held [1/kg] */
    Vector pull;       /* (body_values) centrifugal force on the bodies [N] */
} Joints;

/* A matrix over the modes of the rotor. On a cyclic rotor it consists of blocks R and X: from the
 * values f_c and f_s of a cosine column and its sine column, the cosine modes get R f_c + X f_s, the
 * sine modes R f_s - X f_c. */
typedef struct {
    Vector blocks; /* (blocks) for HALF cosine columns, ROWS rows at a time, and each row of
                    * values: R, then X */
    Vector rest;   /* (rest) entries outside the blocks, such as those of harmonics without a
                    * partner */
    IntVector to;  /* (rest) row of each entry of `rest` */
    IntVector by;  /* (rest) column of each entry of `rest` */
    Matrix full;   /* (modes, columns) columns of the matrix of each copy, without symmetry; otherwise
                    * empty */
    IntVector first; /* (spans) for each 2 LANES entries of a column of `full` and each copy, the
                      * number of the first column in which they are not all zero */
    IntVector last;  /* (spans) the number after the last such column */
} ModalMatrix;

/* Inverse of the matrix A = M / dt^2 + (D + 2 Omega G) / (2 dt) of the rotor, with its dampers
 * [s2]. */
typedef struct {
    ModalMatrix inverse;  /* response of the modes to forces on the modes */
    Vector loss;          /* (loss) damping in blocks R and X as in `ModalMatrix`: the upper triangles,
                           * with twice the entries off the diagonal; for HALF columns, groups of
                           * ROWS rows, and rows from the first row of the group on: R, then X */
    int64_t loss_crosses; /* 0 if the blocks X of `loss` are zero and left out */
    Matrix full_loss;     /* (entries, copy_wide) the upper triangle for all modes of a copy, if damping
                           * has no such blocks; otherwise empty */
    IntVector loss_end;   /* (entries) number of entries of each row of `full_loss` up to the last
                           * that is not zero */
    Matrix circulation;   /* (fixed, entries) force of static dampers for a unit of `centre` */
    Matrix centre;        /* (fixed, entries) displacement of the centre that causes this force */
} Gyroscopic;

/* A displacement field of the casing, w or u, and its slope at the nodes. */
typedef struct {
    Matrix weight;       /* (rows, columns) weights of the values */
    Matrix slope_weight; /* (rows, columns) weights of the slopes */
    int64_t half;        /* offset from a column to the column of its sum, see `column_sums` */
    int64_t slope_half;  /* the same offset for slopes */
    Matrix shape;        /* (sums, of_wall) value of each column at each node of its wall */
    Matrix slope_shape;  /* (sums, of_wall) slope of each column at each node of its wall */
    Matrix spread;       /* (closed_nodes, columns) transpose of `shape` */
    Matrix slope_spread; /* (closed_nodes, columns) transpose of `slope_shape` */
    Matrix start;        /* (2, closed) nodal clearance and its slope for w, zero for u [m, 1] */
} NodalField;

/* The casing. It has one wall or several, each around some contact nodes. Walls of equal number of
 * nodes follow each other in all arrays over nodes, each with its first node again, once or more
 * often; a column moves one wall only. */
typedef struct {
    Body body;
    NodalField radial;
    NodalField tangential;
    Matrix fold;           /* (folded, quarter) shape on a quarter of the circle, see
                            * `fold_field`, or empty */
    int64_t half;          /* number of columns between partners */
    IntVector first;       /* (walls_and_one) number of the first column of each wall, and of all */
    int64_t shared;        /* 1 if all nodal values have the same shape */
    Vector compliance;     /* (compliance) tables of blocks of 4 x 4, see `compliance.h` */
    int64_t spacing;       /* number of blocks of a table between consecutive elements */
    int64_t modes;         /* number of modes; 0 for a rigid wall */
    int64_t nodes;         /* number of nodes of a wall, which is also the number of elements */
    double element_length; /* arc length of an element, to which slopes belong [m] */
} Casing;

/* Modes of one body that are coupled by the springs. */
typedef struct {
    IntVector place;  /* (moved) position of each mode among the entries of the body */
    IntVector wave;   /* (moved) number of the wave of each mode: 2 h for the cosine part of
                       * harmonic h, 2 h + 1 for its sine part */
    Vector amplitude; /* (moved) amplitude of each mode at the springs [kg^-1/2] */
} SpringEnds;

/* Springs between the bodies by nodal diameter (harmonic). A wave is the cosine or the sine part of
 * the radial displacement of a body in one harmonic. Unequal static springs of the shaft are a
 * separate harmonic with nodal diameter one and no mode of the casing. */
typedef struct {
    Vector nodal_diameter; /* (harmonics) nodal diameter of each harmonic */
    Vector factor;         /* (waves) stiffness f_k kappa of each wave [N/m] */
    SpringEnds rotor;
    SpringEnds casing;
} Springs;

typedef struct {
    Matrix rows;  /* (dampers, entries) G: displacement of each damper times the square root of its
                   * damping */
    Matrix solve; /* (dampers, dampers) (2 dt + G c G^T)^-1 */
} DamperEnds;

typedef struct {
    DamperEnds rotor;
    DamperEnds casing;
} Dampers;

typedef struct {
    double time_step;          /* time step [s] */
    double angle_per_step;     /* rotation of the rotor in a step [rad] */
    double elements_per_step;  /* rotation of the rotor in a step, in casing elements */
    double friction;           /* friction coefficient mu */
    double is_signed;          /* 1 if the direction of sliding follows from velocities */
    double tip_rotation;       /* 1 if u_t / R is added to the angle of a node */
    double speed;              /* Omega [rad/s] */
    double displacement_limit; /* limit of displacements of nodes, and of w of the casing [m] */
    double gap_scale;          /* smallest reference length of the complementarity residual [m] */
    Matrix loads;              /* (patterns, 4) end, ramp, frequency, phase of each pattern */
} Numbers;

/* Clearance that is lost over time: closure(t) times its share around the casing. */
typedef struct {
    Matrix share;  /* (2, closed) share of the closure at each node, and its slope [1, 1/m] */
    Matrix table;  /* (points, 2) time [s] and closure [m], linear in between; or empty */
    double amount; /* closure without a table: amount (1 - exp(-rate t)) [m] */
    double rate;   /* [1/s] */
} Closure;

/* Quadratic forms of the distances by which tips draw back, 1/2 sum_i s_i y_i^2 with y = F x; see
 * `foreshortening.h`. A pair is n tips + m for a force on tip n and its effect on tip m. */
typedef struct {
    Cube rows;      /* (tips, terms, entries) rows F of each tip */
    Cube answers;   /* (answered, terms, entries) A^-1 F^T with Coriolis forces; otherwise empty */
    Cube own;       /* (waves, rows, columns) weight of each mode in its column, for each term, if the
                     * terms of all blades are equal; otherwise empty */
    Cube across;    /* (waves, rows, columns) weight in the partner column */
    Matrix spread;  /* (tips, twice_columns) value of each column and of its partner at each tip */
    Matrix sign;    /* (tips, term_lanes) signs s */
    Cube by_push;   /* (tips, tips, term_lanes) F_m A^-1 n_n */
    Cube by_drag;   /* (tips, tips, term_lanes) F_m A^-1 t_n */
    Cube felt;      /* (tips, tips, term_lanes) n_m A^-1 F_n^T */
    Cube crossed;   /* (pairs, terms, term_lanes) F_m A^-1 F_n^T, a row for each term of n */
    IntVector order; /* (terms) 0, 1, 2 ... */
    Vector near;    /* (wide) gap without foreshortening below which a tip is near the wall [m] */
    int64_t hold;   /* number of steps with one linearisation */
    int64_t check;  /* number of steps between checks of all openings */
} Foreshortening;

/* Abradable coating: rods in tracks, see `rods.h`. */
typedef struct {
    Vector half;          /* (tips) half of the footprint of each node, in rods */
    IntVector track;      /* (tips) track of each node */
    Vector area;          /* (tracks) area of a rod of each track [m2] */
    int64_t rods;         /* number of rods of a track */
    double thickness;     /* thickness h [m] */
    double young_modulus; /* E [Pa] */
    double yield_stress;  /* s_y [Pa] */
    double hardening;     /* H, slope in plastic strain [Pa] */
    double limit;         /* largest plastic strain */
} Coating;

/* Numbers of a piece of the speed over time: start [s], and what is added by the change of the speed:
 * angle at the start [rad], and speed as a polynomial in the time since the start. */
enum { PIECE_START, PIECE_ANGLE, PIECE_SPEED, PIECE_DEGREE = 3, PIECE_NUMBERS = 6 };
/* A load pattern is multiplied by cos(order psi + ...) and by a sum of four terms: a constant, and
 * factors of Omega^2 - base^2, of Omega^4 - base^4 and of Omega'. */
enum { BY_ANGLE, CONSTANT, BY_SQUARE, BY_FOURTH, BY_ACCELERATION, SPEED_FACTORS };
/* Recorded numbers of the rotation: angle [rad] and speed [rad/s]. */
enum { ANGLE, SPEED, ROTATION_NUMBERS };
enum { MOST_POINTS = 8 }; /* largest number of speeds at which arrays are known */

/* Speed that varies over time, see `speed.h`. All arrays of the stage are those at the speed `base`;
 * those that depend on the speed are parts of `current`. */
typedef struct {
    double base;            /* [rad/s] */
    Matrix pieces;          /* (pieces, 6) PIECE_START ... of each piece, relative to rotation at the
                             * speed `base`, in order of time */
    Matrix factors;         /* (patterns, 5) BY_ANGLE ... of each load pattern [1, 1, s2, s4, s2] */
    Vector points;          /* (points) speeds at which `samples` are known [rad/s] */
    Matrix samples;         /* (points, depending) values of `current` at these speeds */
    Vector current;         /* (depending) values at the present speed */
    ModalMatrix stiffening; /* K_1, increase of the stiffness by Omega^2 [1] */
    ModalMatrix stiffening4; /* K_2, increase of the stiffness by Omega^4 [s2]; empty without it */
    ModalMatrix coriolis;   /* G, of the Coriolis force -2 Omega G x' [1] */
    int64_t direct;         /* 1 if the blocks X of `stiffening` are zero and left out */
} Speed;

/* State of a free speed: angle at n - 1 and n [rad], speed at n - 1/2 [rad/s], acceleration in the last
 * step [rad/s2], product of the speeds at n - 1/2 and n - 3/2 [rad2/s2], angular momentum at n - 1/2
 * [N m s], the works of the torque, of the loss, and of the contact forces and static dampers on the
 * rotation [J], the speed of the arrays that depend on it [rad/s], the angular impulse of the contact
 * forces of the last step, and the change of the momentum at n - 1/2 by the displacements that these
 * forces cause [N m s]. */
enum {
    DRIVE_BEFORE, DRIVE_ANGLE, DRIVE_SPEED, DRIVE_ACCELERATION, DRIVE_SQUARE, DRIVE_MOMENTUM,
    DRIVE_WORK, DRIVE_LOSS, DRIVE_CONTACT, DRIVE_CENTRE, DRIVE_IMPULSE,
    DRIVE_MOVED,
    DRIVE_NUMBERS
};

/* Drive of a rotor whose speed is free, see `drive.h`. */
typedef struct {
    double inertia;   /* moment of inertia of the rotor in the state at the speed `base` [kg m2] */
    double torque;    /* [N m] */
    double loss;      /* torque of losses by speed [N m s] */
    double damping;   /* of static dampers at the centre [N s/m] */
    Matrix centre;    /* (2, spun_drive) x and y of the centre, if `damping` is not zero */
    Vector along;     /* (spun_drive) a: half of the change of the inertia by displacements */
    Vector across;    /* (spun_drive) b: momentum of velocities */
    Vector held;      /* (spun_drive) force that holds the rotor in the state at the speed `base` */
} Drive;

/* Support of the centre that fuses, see `fuse.h`. */
typedef struct {
    Matrix force;    /* (2, rotor_entries) force in the springs along x and y [N] */
    Vector constant; /* (2) part of this force that does not depend on displacements [N] */
    double limit;    /* force at which the support fuses [N] */
} Fuse;

/* Bearings between places of the rotor and the ground or supports, see `bearings.h`. A bearing has two
 * ends: x and y, or the slopes of the shaft along them. Matrices of a bearing are k_0 and k_2, with their
 * real and imaginary parts. */
typedef struct {
    Matrix rotor;           /* (ends, rotor_entries) B: displacement of the rotor, rotating axes */
    Matrix answer;          /* (ends, rotor_entries) A^-1 B^T: response to a unit force on the rotor */
    Matrix casing;          /* (ends, casing_entries) S: displacement of the support, static axes; or
                             * empty */
    Matrix casing_answer;   /* (ends, casing_entries) c S^T: response to a unit force on the support; or
                             * empty */
    Matrix compliance;      /* (ends, wide_ends) W = B A^-1 B^T + S c S^T, and zeros [m/N] */
    Matrix unit;            /* (more_ends, wide_ends) unit matrix of one more row, and zeros */
    Matrix inverse;         /* (ends, ends) (1 + C W / (2 h))^-1 if C is the same at all angles; or
                             * empty */
    Matrix stiffness;       /* (bearings, 4) [N/m] */
    Matrix damping;         /* (bearings, 4) [N s/m] */
    int64_t damped;         /* 1 if any damping is not zero */
} Bearings;

/* State of a march, which is advanced in place. */
typedef struct {
    Matrix rotor;    /* (3, rotor_entries) x_{n-1}, x_n and scratch of the rotor */
    Matrix casing;   /* (3, casing_entries) x_{n-1}, x_n and scratch of the casing */
    Vector gap;      /* (tips) smallest gap of each tip since the last record [m] */
    Vector impulse;  /* (tips) normal impulse since the last record [N s] */
    Vector drag;     /* (tips) friction impulse since the last record [N s] */
    Vector touched;  /* (tips) steps with contact since the last record */
    Matrix gaps;     /* (2, tips) gaps at the last two steps, row by parity of the step [m] */
    Vector work;     /* (6) works since the start: EXTERNAL ... [J] */
    Vector counts;   /* (7) RESIDUAL ... */
    Matrix strain;   /* (tracks, rods) plastic strain of each rod of the coating */
    Vector coating;  /* (coating_sums) REMOVED ... [J, m3] */
    Vector coating_impulse; /* (coated_tips) part of `impulse` on the coating [N s] */
    Matrix bend;     /* (bent_tips, term_lanes) y at the linearisation of each tip [m^1/2] */
    Vector axial;    /* (tips) axial friction impulse since the last record [N s] */
    Matrix force;    /* (copies, components) contact forces at step n [N] */
    Matrix direction; /* (copies, twice_nodes) tangential and axial part of the direction of sliding
                       * of each node */
    Vector drive;    /* (drive_numbers) DRIVE_BEFORE ... of a free speed */
    Vector until;    /* (bent_tips) last step of the linearisation of each tip */
    Matrix joint_force; /* (3, joint_values) forces of joints at steps n, n - 1 and n - 2 [N] */
    Matrix joint_place; /* (3, joint_values) displacements of joints at step n, and the part of them
                         * due to the modes at steps n and n - 1 [m] */
    Matrix joint_sums;  /* (pairs, joint_sums) JOINT_OPEN ... */
    Matrix bodies;      /* (2, body_values) displacements of bodies at steps n - 1 and n [m] */
    Matrix checked;  /* (3, bent_wide) opening at the last check, and its first and second
                      * differences between checks [m] */
} State;

/* Rows that are written at record steps. */
typedef struct {
    IntVector step;         /* (records) step n */
    Matrix rotor;           /* (records, rotor_entries) displacements of the rotor */
    Matrix rotor_velocity;  /* (records, rotor_entries) velocities of the rotor */
    Matrix casing;          /* (records, casing_entries) displacements of the casing; empty if
                             * its motion is not recorded */
    Matrix casing_velocity; /* (records, casing_entries) velocities of the casing */
    Matrix gap;             /* (records, tips) smallest gap */
    Matrix impulse;         /* (records, tips) normal impulse */
    Matrix drag;            /* (records, tips) friction impulse */
    Matrix axial;           /* (records, tips) axial friction impulse */
    Matrix force;           /* (records, all_components) contact forces */
    Matrix touched;         /* (records, tips) steps with contact */
    Vector contacts;        /* (records) number of tips in contact */
    Vector energy;          /* (records) energy half a step before the record [J] */
    Matrix work;            /* (records, 6) works since the start */
    Matrix coating;         /* (records, coating_sums) sums of the coating */
    Matrix coating_impulse; /* (records, coated_tips) normal impulse on the coating */
    Matrix rotation;        /* (records, rotation_numbers) ANGLE ... if the speed varies */
    Matrix drive;           /* (records, drive_numbers) DRIVE_BEFORE ... of a free speed */
    Matrix joint_force;     /* (records, joint_values) forces of joints */
    Matrix joint_place;     /* (records, joint_values) displacements of joints */
    Matrix joint_sums;      /* (records, all_joint_sums) sums of joints */
    Matrix bodies;          /* (records, body_values) displacements of bodies */
    Vector rotor_energy;    /* (driven_records) energy of the rotation half a step before the record,
                             * which `energy` lacks, of a free speed [J] */
} Records;

/* Constants of a march. NULL stands for an option that a march does not have. */
typedef struct {
    const Rotor *rotor;
    const Casing *casing;
    const Springs *springs;       /* or NULL */
    const Dampers *dampers;       /* or NULL */
    const Gyroscopic *gyroscopic; /* or NULL */
    const Closure *closure;       /* or NULL */
    const Coating *coating;       /* or NULL */
    const Foreshortening *foreshortening; /* or NULL */
    const Speed *speed;           /* or NULL */
    const Drive *drive;           /* or NULL */
    const Fuse *fuse;             /* or NULL */
    const Bearings *bearings;     /* or NULL */
    const Joints *joints;         /* or NULL */
    const Numbers *numbers;
} Stage;

/* Do a number of `steps` from `step` on and record at multiples of `record_every`. Before the first
 * step and on return, row 0 of the state is x_{n-1} and row 1 is x_n. Returns RUNNING, DIVERGED or FUSED;
 * `reached` gets the number of the last step and the number of records. On divergence, the last
 * state within the displacement limit is recorded, with a backward difference as its velocity. */
int march(const Stage *stage, State *state, Records *records, Vector scratch, int64_t step,
          int64_t steps, int64_t record_every, int64_t *reached);

/* Return the number of doubles of the working arrays of a march. */
int64_t scratch_size(const Stage *stage, const State *state);

#endif
