/* Data dictionary of the compiled marches: name, shape, unit.
 *
 * Python fills these structs from NumPy arrays (`arrays.py`, where dtype, shape and contiguity are
 * checked). Matrices lie row by row; "padded" rows end in zeros up to a multiple of LANES. Lines
 * that the preprocessor reads begin with #; cffi is given all others.
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
enum { EXTERNAL, NORMAL, FRICTION, DAMPING, PARAMETRIC, WORKS };
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
    Vector a;         /* multiplies x_n */
    Vector b;         /* multiplies x_{n-1} */
    Vector c;         /* multiplies forces: inverse of the scheme's diagonal [s2] */
    Vector stiffness; /* omega^2 [rad2/s2] */
    Vector damping;   /* 2 xi omega [rad/s] */
    Matrix load;      /* load patterns, (patterns, entries) */
    IntMatrix loaded; /* registers of each pattern that are not zero, then -1 */
} Body;

typedef struct {
    Body body;
    Matrix radial;      /* weights, (rows, columns) */
    Matrix tangential;  /* weights with the radial shape, (rows, columns) */
    Matrix crossed;     /* weights with the tangential shape, (rows, columns) */
    Matrix shape;       /* (columns, padded tips) */
    Matrix cross_shape; /* the same for the tangential direction */
    Matrix spread;      /* shape by tip, (tips, columns) */
    Matrix drag_spread; /* distribution of friction: the same, or cross_shape by tip */
    int64_t half;       /* columns from one to its partner, see `Arrangement`; 0 without */
    int64_t shared;     /* 1 where friction is distributed as the normal force is */
    Matrix w;           /* r c (r + mu s t)^T for s = -1, 0, 1, by column, (3 tips, tips) */
    Vector position;    /* angle of each tip in elements of the casing, (padded tips,) */
    Vector recess;      /* of each tip at rest beyond the clearance [m], (padded tips,) */
} Rotor;

/* Inverse of the rotor's A = M / dt^2 + (D + 2 Omega G) / (2 dt), with its dampers [s2].
 * On a cyclic rotor it is blocks: modes of a column get R of its own and X of its partner's if the
 * column is a cosine, R and -X if it is a sine. */
typedef struct {
    Vector blocks; /* by HALF cosines, ROWS rows at a time, and rows: R of these, then X */
    Vector rest;   /* entries that this leaves out, those of single harmonics among them */
    IntVector to;  /* the entry that each of these moves */
    IntVector by;  /* the entry of its force */
    Matrix full;   /* without symmetry: answer to a force on each, (modes, entries); else empty */
    Vector loss;   /* damping of cosine and sine alike: upper triangle, twice off the diagonal; by
                    * HALF columns, groups of ROWS rows and rows from the group's first on */
    Matrix full_loss;     /* the triangle of all, where columns are damped together; else empty */
    Matrix normal;        /* answer to normal forces by column, (rows, columns); else empty */
    Matrix normal_across; /* to those of the partner column */
    Matrix shear;         /* to friction */
    Matrix shear_across;
    Matrix circulation; /* forces of dampers that stand still, by `centre`, (0 or 2, entries) */
    Matrix centre;      /* displacement that causes them, (0 or 2, entries) */
} Gyroscopic;

/* One displacement of the casing, w or u, and its slope at the nodes. */
typedef struct {
    Matrix weight; /* of the values, (rows, columns) */
    Matrix slope_weight;
    int64_t half; /* columns from one to the place of its sum, see `column_sums` */
    int64_t slope_half;
    Matrix shape; /* (columns, padded nodes) */
    Matrix slope_shape;
    Matrix spread; /* shape by node, (nodes, columns) */
    Matrix slope_spread;
    Matrix start; /* nodal clearance and its slope, or zero, (2, padded nodes) [m, 1] */
} NodalField;

typedef struct {
    Body body;
    NodalField radial;
    NodalField tangential;
    Matrix fold;           /* shape on a quarter of the circle, see `folded_fields`, or empty */
    int64_t half;          /* columns from one to its partner */
    int64_t shared;        /* 1 where all nodal values have one shape */
    Vector compliance;     /* blocks of 4 x 4 for s = -1, 0, 1, see `delassus` */
    int64_t spacing;       /* blocks from one element to the next */
    int64_t nodes;         /* number of nodes and of elements */
    double element_length; /* [m] */
} Casing;

/* Modes of one body that the springs move. */
typedef struct {
    IntVector place;  /* among the body's entries, (modes,) */
    IntVector wave;   /* twice the harmonic of each, and one more for a sine */
    Vector amplitude; /* of each at the springs [kg^-1/2] */
} SpringEnds;

/* Springs between the bodies by nodal diameter (harmonic). A wave is the cosine or sine part of a
 * body's radial displacement in one harmonic. Springs under the shaft are a harmonic of their own,
 * with one nodal diameter and no mode of the casing. */
typedef struct {
    Vector nodal_diameter; /* of each harmonic, (harmonics,) */
    Vector factor;         /* stiffness f_k kappa of each wave [N/m], (waves,) */
    SpringEnds rotor;
    SpringEnds casing;
    double angle_per_step; /* turn of the rotor a step [rad] */
} Springs;

typedef struct {
    Matrix rows;  /* G, displacement of each damper times the root of its strength */
    Matrix solve; /* (2 dt + G c G^T)^-1, (dampers, dampers) */
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
    Matrix loads;              /* end, ramp, frequency, phase of each pattern, (patterns, 4) */
} Numbers;

/* Everything a march needs to go on; advanced in place. */
typedef struct {
    Matrix rotor;    /* x_{n-1}, x_n and scratch, (3, entries) */
    Matrix casing;   /* the same for the casing */
    Vector gap;      /* smallest gap of each tip since the last record [m], (tips,) */
    Vector impulse;  /* normal impulse since the last record [N s], (tips,) */
    Vector drag;     /* friction impulse since the last record [N s], (tips,) */
    Vector touched;  /* steps with contact since the last record, (tips,) */
    Vector held;     /* 1 for tips in contact at the last step, (tips,) */
    Vector work;     /* external, normal, friction work, damping loss, parametric work [J] */
    Vector residual; /* largest complementarity residual, (1,) */
    Vector counts;   /* contacts at the last step, LCP failures, pivots, steps with contact */
} State;

/* Rows written at record steps. */
typedef struct {
    IntVector step;        /* (records,) */
    Matrix rotor;          /* displacement, (records, entries) */
    Matrix rotor_velocity; /* (records, entries) */
    Matrix casing;
    Matrix casing_velocity;
    Matrix gap; /* (records, tips) */
    Matrix impulse;
    Matrix drag;
    Matrix touched;
    Vector contacts; /* (records,) */
    Vector energy;   /* half-step energy [J], (records,) */
    Matrix work;     /* (records, WORKS) */
} Records;

typedef struct {
    Vector rotor; /* sums by column of the rotor, (columns,) */
    Vector value; /* sums by column of nodal values of the casing, (columns,) */
    Vector slope;
    Vector nodal; /* nodal values of the casing's field, node 0 again, (padded nodes,) */
    Vector nodal_slope;
    Matrix moved;      /* displacement over a step, rotor and casing, (2, entries) */
    Vector at;         /* place of each tip in elements, (padded tips,) */
    IntVector element; /* element under each tip, (tips,) */
    Matrix hermite;    /* weights of each tip on its element: w, w', w, w', (4, padded tips) */
    Vector radial;     /* displacement of each tip [m], (padded tips,) */
    Vector tangential;
    Vector other;    /* scratch, (padded tips,) */
    Vector free_gap; /* without contact [m], (padded tips,) */
    Vector gap;      /* after the correction [m], (padded tips,) */
} FieldScratch;

typedef struct {
    Vector sign;       /* direction of sliding, (tips,) */
    Vector multiplier; /* [N], (tips,) */
    IntVector active;  /* tips of the active set, (tips,) */
    IntMatrix known;   /* tips and senses that `on_rotor` stands for, (2, tips) */
    Matrix on_rotor;   /* the rotor's part of W of the active tips, by column */
    Vector ends;       /* Hermite weights by active tip, (4 padded tips,) */
    Matrix system;     /* W by column, then a right-hand side, (tips + 1, padded tips) */
    Matrix others;     /* 1 off the diagonal, 0 on it, (tips, padded tips) */
    Vector diagonal;   /* W_jj of the active tips, (tips,) */
    Vector solution;   /* (tips,) */
    Matrix tableau;    /* of Lemke's method, (tips, 2 tips + 2) */
    IntVector basis;   /* of Lemke's method, (tips,) */
    IntVector rows;    /* rows that a product takes, (2 padded tips,) */
    Matrix factor;     /* and with what factors, (6, 2 padded tips) */
    Matrix columns;    /* forces by column: casing w, w', u, u', rotor normal, friction */
    Vector work;       /* of the contact forces over this step [J], (2,) */
} ContactScratch;

typedef struct {
    Matrix rotor; /* waves at the last step and at this, by its parity, (2, waves) */
    Matrix casing;
    Matrix stretch; /* by angle and displacement, see `stretch_springs`, (4, waves) */
    Matrix force;   /* on the waves of rotor and casing, (2, waves) */
} SpringScratch;

typedef struct {
    FieldScratch fields;
    ContactScratch contact;
    SpringScratch springs;
    Vector turned;       /* modal forces on the rotor, (entries,) */
    Vector amplitude;    /* of each load pattern, (patterns,) */
    Vector stroke;       /* of each damper over two steps, (most dampers,) */
    Matrix damper_force; /* phi on rotor and casing, (2, most dampers) */
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
enum { DENSE_EXTERNAL, DENSE_NORMAL, DENSE_FRICTION, DENSE_DAMPING, DENSE_TURNING };
enum { DENSE_RESIDUAL, DENSE_CONTACT_STEPS, DENSE_UNSOLVED, DENSE_CONTACTS };
enum { DENSE_GAP, DENSE_IMPULSE, DENSE_DRAG, DENSE_TOUCHED };

/* Constants of a dense march; the modes of the rotor precede those of the casing. */
typedef struct {
    Vector stiffness;   /* squared frequencies [rad2/s2], (modes,) */
    Vector damping;     /* diagonal part of C [1/s], (modes,) */
    Matrix dampers;     /* rows G of its part G^T G, (dampers, modes) */
    Matrix by_velocity; /* Coriolis forces and the rest of C, (rotor modes, same) or empty */
    Matrix inverse;     /* of A, (modes, modes) */
    Matrix centre;      /* x and y of the rotor's centre, (2, modes) */
    double circulation; /* of fixed dampers under it [N/m] */
    IntVector coupled;  /* modes that turning springs join, (coupled,) */
    Cube turning_cos;   /* their stiffness by harmonics of the rotor's angle, (n, coupled, same) */
    Cube turning_sin;
    Matrix loads;          /* (loads, modes) */
    Matrix load_times;     /* end, ramp, frequency, phase, (loads, 4) */
    Matrix tip_radial;     /* (tips, rotor modes) */
    Matrix tip_tangential; /* (tips, rotor modes) */
    Vector tip_angle;      /* [rad], (tips,) */
    Vector tip_recess;     /* [m], (tips,) */
    Cube nodal;            /* w, w', u, u' by node, (nodes, 4, casing modes) */
    Matrix clearance;      /* and its slope [m, 1], (nodes, 2) */
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
    Vector displacement; /* x_n, (modes,) */
    Vector velocity;     /* v_n, (modes,) */
    Matrix sums;         /* smallest gap, impulse, drag, steps touched since the record, (4, tips) */
    Vector works;        /* DENSE_EXTERNAL ... [J], (5,) */
    Vector counts;       /* DENSE_RESIDUAL ..., (4,) */
} DenseState;

typedef struct {
    Vector load; /* forces of loads, of springs that turn and dampers that stand still, (modes,) */
    Vector turned;
    Vector middle; /* x at half the step, without contact, (modes,) */
    Vector seen;   /* displacement at which gaps are computed, (modes,) */
    Vector v_free; /* velocities without and with contact, (modes,) */
    Vector v_after;
    Vector moved;      /* displacement over the step, (modes,) */
    Vector force;      /* scratch, (modes,) */
    Vector row;        /* scratch, (modes,) */
    Matrix rows;       /* B_N, then B_T of the tips that touch, (2 tips, modes) */
    Matrix answers;    /* velocities by unit impulses, (2 tips, modes) */
    Matrix compliance; /* B A^-1 B^T, (2 tips, 2 tips) */
    IntVector active;  /* tips that touch, (tips,) */
    Vector free;       /* velocities without impulses, normal then tangential, (2 tips,) */
    Vector before;     /* normal velocities at the start of the step, (tips,) */
    Vector impulse;    /* normal then tangential [N s], (2 tips,) */
} DenseScratch;

/* Do steps of length h in place, until displacements leave their limit; the number done. */
int64_t dense_march(const DenseStage *stage, const DenseLaw *law, DenseState *state,
                    DenseScratch *scratch, double h, int64_t first, int64_t steps);

#endif
