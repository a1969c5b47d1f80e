/* Data dictionary of the compiled marches: name, shape, unit.
 *
 * Python makes these structs of NumPy arrays (`structs.py`). The comment of an array begins with its
 * shape, by which it is made and checked: numbers, or names of lengths within the struct. An array
 * may be empty where the march does without. Matrices lie row by row; `columns`, `wide` (tips or
 * nodes) and `closed` (nodes and the first again) are padded with zeros to a multiple of LANES.
 * Lines that the preprocessor reads begin with #; cffi is given all others.
 */
#ifndef KERNEL_H
#define KERNEL_H

#include <stdint.h>

enum { LANES = 8, HALF = 4 }; /* doubles of a register, and of a narrow one */
enum { ROWS = 4 };            /* of a block, summed at a time */
enum { RUNNING, DIVERGED };   /* status of a march */
enum { CHECK_EVERY = 100 };   /* steps between checks of displacements other than radial of tips */

/* Rows of forces and of nodal values: w, w', u, u' of the casing's nodes, then tips. */
enum { W_KIND, W_SLOPE, U_KIND, U_SLOPE, PUSH, DRAG };
/* Works; CLOSING is the part of NORMAL that stops tips as their gaps close. */
enum { EXTERNAL, NORMAL, FRICTION, DAMPING, PARAMETRIC, CLOSING, WORKS };
enum { STEP_CONTACTS, LCP_FAILURES, LCP_PIVOTS, CONTACT_STEPS };
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

/* Modal recurrence of one body over its entries (rows * columns), zero where padded. Where Coriolis
 * forces couple modes, A is not diagonal and a, b, c give A (x_{n+1} - x_{n-1}). */
typedef struct {
    Vector a;         /* (entries) multiplies x_n */
    Vector b;         /* (entries) multiplies x_{n-1} */
    Vector c;         /* (entries) multiplies forces: inverse of the scheme's diagonal [s2] */
    Vector stiffness; /* (entries) omega^2 [rad2/s2] */
    Vector damping;   /* (entries) 2 xi omega [rad/s] */
    Matrix load;      /* (patterns, entries) load patterns */
    IntMatrix loaded; /* (patterns, registers) registers of each pattern that are not zero, then
                       * -1 */
} Body;

typedef struct {
    Body body;
    Matrix radial;      /* (rows, columns) weights */
    Matrix tangential;  /* (rows, columns) weights with the radial shape */
    Matrix crossed;     /* (rows, columns) weights with the tangential shape */
    Matrix shape;       /* (sums, wide) */
    Matrix cross_shape; /* (sums, wide) the same for the tangential direction */
    Matrix spread;      /* (tips, columns) shape by tip */
    Matrix drag_spread; /* (tips, columns) distribution of friction: the same, or cross_shape by
                         * tip */
    int64_t half;       /* columns from one to its partner, see `Arrangement`; 0 without */
    int64_t shared;     /* 1 where friction is distributed as the normal force is */
    Cube w;             /* (3, tips, tips) r c (r + mu s t)^T for s = -1, 0, 1, by column */
    Vector position;    /* (wide) angle of each tip in elements of the casing */
    Vector recess;      /* (wide) of each tip at rest beyond the clearance [m] */
} Rotor;

/* Inverse of the rotor's A = M / dt^2 + (D + 2 Omega G) / (2 dt), with its dampers [s2].
 * On a cyclic rotor it is blocks: modes of a column get R of its own and X of its partner's if the
 * column is a cosine, R and -X if it is a sine. */
typedef struct {
    Vector blocks;        /* (blocks) by HALF cosines, ROWS rows at a time, and rows: R of these,
                           * then X */
    Vector rest;          /* (rest) entries that this leaves out, those of single harmonics among
                           * them */
    IntVector to;         /* (rest) the entry that each of these moves */
    IntVector by;         /* (rest) the entry of its force */
    Matrix full;          /* (modes, entries) without symmetry: answer to a force on each; else
                           * empty */
    Vector loss;          /* (loss) damping of cosine and sine alike: upper triangle, twice off
                           * the diagonal; by HALF columns, groups of ROWS rows and rows from the
                           * group's first on */
    Matrix full_loss;     /* (entries, entries) the triangle of all, where columns are damped
                           * together; else empty */
    Matrix normal;        /* (rows, columns) answer to normal forces by column; else empty */
    Matrix normal_across; /* (rows, columns) to those of the partner column */
    Matrix shear;         /* (rows, columns) to friction */
    Matrix shear_across;  /* (rows, columns) */
    Matrix circulation;   /* (fixed, entries) forces of dampers that stand still, by `centre` */
    Matrix centre;        /* (fixed, entries) displacement that causes them */
} Gyroscopic;

/* One displacement of the casing, w or u, and its slope at the nodes. */
typedef struct {
    Matrix weight;       /* (rows, columns) of the values */
    Matrix slope_weight; /* (rows, columns) */
    int64_t half;        /* columns from one to the place of its sum, see `column_sums` */
    int64_t slope_half;
    Matrix shape;        /* (sums, wide) */
    Matrix slope_shape;  /* (sums, wide) */
    Matrix spread;       /* (nodes, columns) shape by node */
    Matrix slope_spread; /* (nodes, columns) */
    Matrix start;        /* (2, closed) nodal clearance and its slope, or zero [m, 1] */
} NodalField;

typedef struct {
    Body body;
    NodalField radial;
    NodalField tangential;
    Matrix fold;           /* (folded, quarter) shape on a quarter of the circle, see
                            * `folded_fields`, or empty */
    int64_t half;          /* columns from one to its partner */
    int64_t shared;        /* 1 where all nodal values have one shape */
    Vector compliance;     /* (compliance) blocks of 4 x 4 for s = -1, 0, 1, see `delassus` */
    int64_t spacing;       /* blocks from one element to the next */
    int64_t nodes;         /* number of nodes and of elements */
    double element_length; /* [m] */
} Casing;

/* Modes of one body that the springs move. */
typedef struct {
    IntVector place;  /* (moved) among the body's entries */
    IntVector wave;   /* (moved) twice the harmonic of each, and one more for a sine */
    Vector amplitude; /* (moved) of each at the springs [kg^-1/2] */
} SpringEnds;

/* Springs between the bodies by nodal diameter (harmonic). A wave is the cosine or sine part of a
 * body's radial displacement in one harmonic. Springs under the shaft are a harmonic of their own,
 * with one nodal diameter and no mode of the casing. */
typedef struct {
    Vector nodal_diameter; /* (harmonics) of each harmonic */
    Vector factor;         /* (waves) stiffness f_k kappa of each wave [N/m] */
    SpringEnds rotor;
    SpringEnds casing;
    double angle_per_step; /* turn of the rotor a step [rad] */
} Springs;

typedef struct {
    Matrix rows;  /* (dampers, entries) G, displacement of each damper times the root of its
                   * strength */
    Matrix solve; /* (dampers, dampers) (2 dt + G c G^T)^-1 */
} DamperEnds;

typedef struct {
    DamperEnds rotor;
    DamperEnds casing;
} Dampers;

typedef struct {
    double time_step;          /* [s] */
    double elements_per_step;  /* turn of the rotor a step, in casing elements */
    double friction;           /* coefficient mu */
    double sliding;            /* sign of permanent sliding */
    double elements_per_metre; /* casing elements a metre of u_t; 0 where neglected */
    double displacement_limit; /* of a tip, or of the casing radially [m] */
    double gap_scale;          /* smallest scale of the complementarity residual [m] */
    Matrix loads;              /* (patterns, 4) end, ramp, frequency, phase of each pattern */
} Numbers;

/* Everything a march needs to go on; advanced in place. */
typedef struct {
    Matrix rotor;    /* (3, rotor_entries) x_{n-1}, x_n and scratch */
    Matrix casing;   /* (3, casing_entries) the same for the casing */
    Vector gap;      /* (tips) smallest gap of each tip since the last record [m] */
    Vector impulse;  /* (tips) normal impulse since the last record [N s] */
    Vector drag;     /* (tips) friction impulse since the last record [N s] */
    Vector touched;  /* (tips) steps with contact since the last record */
    Vector held;     /* (tips) 1 for tips in contact at the last step */
    Matrix gaps;     /* (2, tips) at the last step and at this, by its parity [m] */
    Vector work;     /* (6) EXTERNAL ... [J] */
    Vector residual; /* (1) largest complementarity residual */
    Vector counts;   /* (4) contacts at the last step, LCP failures, pivots, steps with contact */
} State;

/* Rows written at record steps. */
typedef struct {
    IntVector step;         /* (records) */
    Matrix rotor;           /* (records, rotor_entries) displacement */
    Matrix rotor_velocity;  /* (records, rotor_entries) */
    Matrix casing;          /* (records, casing_entries) */
    Matrix casing_velocity; /* (records, casing_entries) */
    Matrix gap;             /* (records, tips) */
    Matrix impulse;         /* (records, tips) */
    Matrix drag;            /* (records, tips) */
    Matrix touched;         /* (records, tips) */
    Vector contacts;        /* (records) */
    Vector energy;          /* (records) half-step energy [J] */
    Matrix work;            /* (records, 6) */
} Records;

typedef struct {
    Vector rotor;       /* (sums) sums by column of the rotor */
    Vector value;       /* (sums) sums by column of nodal values of the casing */
    Vector slope;       /* (sums) */
    Vector nodal;       /* (closed) nodal values of the casing's field, node 0 again */
    Vector nodal_slope; /* (closed) */
    Matrix moved;       /* (2, entries) displacement over a step, rotor and casing */
    Vector at;          /* (wide) place of each tip in elements */
    IntVector element;  /* (tips) element under each tip */
    Matrix hermite;     /* (4, wide) weights of each tip on its element: w, w', w, w' */
    Vector radial;      /* (wide) displacement of each tip [m] */
    Vector tangential;  /* (wide) */
    Vector other;       /* (wide) scratch */
    Vector free_gap;    /* (wide) without contact [m] */
    Vector gap;         /* (wide) after the correction [m] */
} FieldScratch;

typedef struct {
    Vector sign;       /* (tips) direction of sliding */
    Vector multiplier; /* (tips) [N] */
    IntVector active;  /* (tips) tips of the active set */
    IntMatrix known;   /* (2, tips) tips and senses that `on_rotor` stands for */
    Matrix on_rotor;   /* (tips, wide) the rotor's part of W of the active tips, by column */
    Vector ends;       /* (ends) Hermite weights by active tip */
    Matrix system;     /* (bordered, wide) W by column, then a right-hand side */
    Matrix others;     /* (tips, wide) 1 off the diagonal, 0 on it */
    Vector diagonal;   /* (tips) W_jj of the active tips */
    Vector solution;   /* (tips) */
    Matrix tableau;    /* (tips, tableau) of Lemke's method */
    IntVector basis;   /* (tips) of Lemke's method */
    IntVector rows;    /* (twice_wide) rows that a product takes */
    Matrix factor;     /* (6, twice_wide) and with what factors */
    Matrix columns;    /* (6, sums) forces by column: casing w, w', u, u', rotor normal, friction */
    Vector work;       /* (2) of the contact forces over this step [J] */
} ContactScratch;

typedef struct {
    Matrix rotor;   /* (2, waves) waves at the last step and at this, by its parity */
    Matrix casing;  /* (2, waves) */
    Matrix stretch; /* (4, waves) by angle and displacement, see `stretch_springs` */
    Matrix force;   /* (2, waves) on the waves of rotor and casing */
} SpringScratch;

typedef struct {
    FieldScratch fields;
    ContactScratch contact;
    SpringScratch springs;
    Vector turned;          /* (rotor_entries) modal forces on the rotor */
    Vector amplitude;       /* (patterns) of each load pattern */
    Vector stroke;          /* (dampers) of each damper over two steps */
    Matrix damper_force;    /* (2, dampers) phi on rotor and casing */
} Scratch;

/* March from `step` over `steps`, recording at multiples of `record_every`. NULL stands for an
 * option that a march does not have: springs, dampers, gyroscopic forces, and the wheel speed
 * R Omega [m/s] where sliding is permanent. Before the first step, and on return, row 0 of the
 * state holds x_{n-1} and row 1 x_n. Returns RUNNING or DIVERGED; `reached` gets the step reached
 * and the number of records written. On divergence the last state within the displacement limit is
 * recorded, its velocity a backward difference. */
int march(const Rotor *rotor, const Casing *casing, const Springs *springs, const Dampers *dampers,
          const Gyroscopic *gyroscopic, const double *wheel_speed, const Numbers *numbers,
          State *state, Records *records, Scratch *scratch, int64_t step, int64_t steps,
          int64_t record_every, int64_t *reached);

/* Works, quality, and sums since the last record of the dense schemes. */
enum {
    DENSE_EXTERNAL,
    DENSE_NORMAL,
    DENSE_FRICTION,
    DENSE_DAMPING,
    DENSE_TURNING,
    DENSE_CLOSING,
    DENSE_WORKS
};
enum { DENSE_RESIDUAL, DENSE_CONTACT_STEPS, DENSE_UNSOLVED, DENSE_CONTACTS };
enum { DENSE_GAP, DENSE_IMPULSE, DENSE_DRAG, DENSE_TOUCHED };

/* Constants of a dense march; the modes of the rotor precede those of the casing. */
typedef struct {
    Vector stiffness;      /* (modes) squared frequencies [rad2/s2] */
    Vector damping;        /* (modes) diagonal part of C [1/s] */
    Matrix dampers;        /* (dampers, modes) rows G of its part G^T G */
    Matrix by_velocity;    /* (rotor_modes, rotor_modes) Coriolis forces and the rest of C, or
                            * empty */
    Matrix inverse;        /* (modes, modes) of A */
    Matrix centre;         /* (2, modes) x and y of the rotor's centre */
    double circulation;    /* of fixed dampers under it [N/m] */
    IntVector coupled;     /* (coupled) modes that turning springs join */
    Cube turning_cos;      /* (harmonics, coupled, coupled) their stiffness by harmonics of the
                            * rotor's angle */
    Cube turning_sin;      /* (harmonics, coupled, coupled) */
    Matrix loads;          /* (loads, modes) */
    Matrix load_times;     /* (loads, 4) end, ramp, frequency, phase */
    Matrix tip_radial;     /* (tips, rotor_modes) */
    Matrix tip_tangential; /* (tips, rotor_modes) */
    Vector tip_angle;      /* (tips) [rad] */
    Vector tip_recess;     /* (tips) [m] */
    Cube nodal;            /* (nodes, 4, casing_modes) w, w', u, u' by node */
    Matrix clearance;      /* (nodes, 2) and its slope [m, 1] */
    double tip_radius;     /* [m] */
    double element_length; /* [m] */
    double speed;          /* [rad/s] */
    double follows;        /* 1 where a tip's angle follows its displacement, else 0 */
    double limit;          /* of displacements [m] */
} DenseStage;

typedef struct {
    double friction;
    double restitution;
    double penalty;     /* [N/m]; 0 for impulses that keep tips from closing in */
    double stick_speed; /* below which friction grows with the speed [m/s]; 0 where tips stick */
} DenseLaw;

/* Advanced in place. */
typedef struct {
    Vector displacement; /* (modes) x_n */
    Vector velocity;     /* (modes) v_n */
    Matrix sums;         /* (4, tips) smallest gap, impulse, drag, steps touched since the record */
    Vector works;        /* (6) DENSE_EXTERNAL ... [J] */
    Vector counts;       /* (4) DENSE_RESIDUAL ... */
} DenseState;

typedef struct {
    Vector load;       /* (modes) forces of loads, of springs that turn and dampers that stand
                        * still */
    Vector turned;     /* (modes) */
    Vector middle;     /* (modes) x at half the step, without contact */
    Vector seen;       /* (modes) displacement at which gaps are computed */
    Vector v_free;     /* (modes) velocities without and with contact */
    Vector v_after;    /* (modes) */
    Vector moved;      /* (modes) displacement over the step */
    Vector force;      /* (modes) scratch */
    Vector row;        /* (modes) scratch */
    Matrix rows;       /* (twice_tips, modes) B_N, then B_T of the tips that touch */
    Matrix answers;    /* (twice_tips, modes) velocities by unit impulses */
    Matrix compliance; /* (twice_tips, twice_tips) B A^-1 B^T */
    IntVector active;  /* (tips) tips that touch */
    Vector free;       /* (twice_tips) velocities without impulses, normal then tangential */
    Vector before;     /* (tips) normal velocities at the start of the step */
    Vector impulse;    /* (twice_tips) normal then tangential [N s] */
} DenseScratch;

/* Do steps of length h in place, until displacements leave their limit; the number done. */
int64_t dense_march(const DenseStage *stage, const DenseLaw *law, DenseState *state,
                    DenseScratch *scratch, double h, int64_t first, int64_t steps);

#endif
