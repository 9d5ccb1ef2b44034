/* One evaluation of the accelerations in C: the arithmetic of solver/kernels/column/formulations/exact.py and
 * solver/kernels/column/joint/law.py, operation by operation, to find the extra cost of compiled Python. The layout of
 * the arrays (MODEL_BLOCKS(n), BLOCKS_MASS(n), SETTINGS_N, ...) is defined on the command line from the tables of
 * solver/kernels/layout/spaces.py. */
#include <math.h>
#include <stdint.h>

static double lesser(double a, double b) { return a < b ? a : b; }

/* The part (lo, hi) of an interval where value + slope s > 0. */
static void positive_part(double value, double slope, double *lo, double *hi)
{
    if (slope > 0.0) {
        const double edge = -value / slope;
        *lo = edge > *lo ? edge : *lo;
    } else if (slope < 0.0) {
        const double edge = -value / slope;
        *hi = edge < *hi ? edge : *hi;
    } else if (!(value > 0.0)) {
        *lo = *hi;
    }
}

/* End of the loaded part by this bound, and the margin of the bound. */
static double side_margin(int64_t bound, double corner, double damping, double opening, double slope, double mean,
                          double gradient, double *edge)
{
    const double touching = corner * slope - opening, pushing = corner * gradient - mean;
    if (bound == CORNER) {
        *edge = corner;
        return damping > 0.0 ? lesser(touching, pushing) : touching;
    }
    if (bound == TOUCH) {
        *edge = opening / slope;
        return damping > 0.0 ? lesser(-touching, *edge * gradient - mean) : -touching;
    }
    *edge = mean / gradient;
    return lesser(-pushing, *edge * slope - opening);
}

/* How far an open joint is from closing. */
static double open_margin(double half, double opening, double slope, double mean, double gradient)
{
    double most = lesser(-opening - half * slope, -mean - half * gradient);
    most = fmax(most, lesser(half * slope - opening, half * gradient - mean));
    const double same = (mean - opening) / (gradient - slope);
    if (fabs(same) < half)
        most = fmax(most, same * slope - opening);
    return -most;
}

/* Normal force (N), moment (N m) and loaded length (m) of a no-tension joint, by the formula of a regime unless that is
 * ANY; `outside` is set where the joint is not in its regime. */
static inline void resultants(int64_t regime, double stiffness, double width, double depth, double damping,
                              double opening, double slope, double opening_rate, double slope_rate, double *force,
                              double *moment, double *length, int64_t *outside)
{
    double lo = -0.5 * width, hi = 0.5 * width;
    const double mean = opening + damping * opening_rate, gradient = slope + damping * slope_rate;
    *force = *moment = *length = 0.0;
    if (regime == ANY) {
        positive_part(-opening, slope, &lo, &hi);
        if (damping > 0.0 && lo < hi)
            positive_part(-mean, gradient, &lo, &hi);
        if (!(hi > lo))
            return;
    } else if (regime == OPEN) {
        if (open_margin(hi, opening, slope, mean, gradient) < 0.0)
            *outside = 1;
        return;
    } else {
        const double on_left = side_margin(regime & 3, lo, damping, opening, slope, mean, gradient, &lo);
        const double on_right = side_margin((regime / RIGHT) & 3, hi, damping, opening, slope, mean, gradient, &hi);
        if (lesser(on_left, on_right) < 0.0)
            *outside = 1;
    }
    *length = hi - lo;
    const double middle = 0.5 * (lo + hi), area = stiffness * depth * *length;
    *force = area * (gradient * middle - mean);
    *moment = middle * *force + area * gradient * (*length * *length) * (1.0 / 12.0);
}

/* sin(x) and cos(x); polynomials where they are exact to rounding. */
static inline void sine_cosine(double x, double *sine, double *cosine)
{
    if (fabs(x) > SMALL) {
        *sine = sin(x);
        *cosine = cos(x);
        return;
    }
    const double y = x * x;
    *sine = x * (1.0 + y * (-1.0 / 6.0 + y * (1.0 / 120.0 - y * (1.0 / 5040.0))));
    *cosine = 1.0 + y * (-0.5 + y * (1.0 / 24.0 - y * (1.0 / 720.0)));
}

/* sin and cos of half of x. */
static inline void half_sine_cosine(double x, double *sine, double *cosine)
{
    if (fabs(x) > 2.0 * SMALL) {
        *sine = sin(0.5 * x);
        *cosine = cos(0.5 * x);
        return;
    }
    const double y = x * x;
    *sine = x * (0.5 + y * (-1.0 / 48.0 + y * (1.0 / 3840.0 - y * (1.0 / 645120.0))));
    *cosine = 1.0 + y * (-0.125 + y * (1.0 / 384.0 - y * (1.0 / 46080.0)));
}

/* number i of a field */
#define BLOCK(field) blocks[BLOCKS_##field(n) + i]
#define PHASE(field, i) phase[PHASE_##field(n) + (i)]
#define JOINT(field) joints[JOINTS_##field(n) + i]
#define ROW(field, i) rows[JOINT_ROW * (i) + JOINT_ROW_##field]

/* Contribution of block i to the row of the joint under it. */
typedef struct { double half, p, free_alpha, diagonal, right, opens; } over_joint;

static inline over_joint add_block(const double *blocks, const double *phase, const double *joints, double *rows,
                                   int64_t n, int64_t i, double spin, double spin_below, double couple)
{
    const double normal = JOINT(NORMAL), per_masses = BLOCK(PER_MASSES), per_inertia = BLOCK(PER_INERTIA);
    const double both_spins = spin + spin_below, square = spin * spin;
    const double quarter = 0.25 * PHASE(OPENING, i), half = quarter + quarter;
    const double lower_sine = BLOCK(CENTROID) * ROW(SINE, i), lower_cosine = BLOCK(CENTROID) * ROW(COSINE, i);
    const double p = lower_cosine + half, p_turns = p * per_inertia;
    const double free_alpha = per_inertia * ((normal * lower_sine - ROW(TURNED, i)) + couple);
    const over_joint found = {
        half, p, free_alpha, per_masses + p * p_turns,
        PHASE(OPENING_RATE, i) * both_spins + (p * free_alpha - lower_sine * square),
        normal * per_masses + (lower_cosine * square + quarter * both_spins * both_spins)};
    ROW(FREE_ALPHA, i) = free_alpha;
    ROW(TURN_BELOW, i) = p_turns;
    return found;
}

/* Accelerations of a phase, from its coordinates and rates, on a base that moves by (ax, az, theta, omega, alpha). */
void accelerations(const double *model, double *phase, const double *motion, double *work)
{
    const int64_t n = (int64_t)model[MODEL_SETTINGS(0) + SETTINGS_N];
    const double *blocks = model + MODEL_BLOCKS(n);
    double *joints = work + SCRATCH_JOINTS(n), *rows = work + SCRATCH_ROOM(n);
    int64_t *hold = (int64_t *)(work + SCRATCH_HOLD(n));
    for (int64_t i = 0; i < n; i++) {
        const double turn = i + 1 < n ? PHASE(THETA, i) - PHASE(THETA, i + 1) : PHASE(THETA, i);
        half_sine_cosine(turn, &ROW(SINE, i), &ROW(COSINE, i));
    }

    /* forces of the joints */
    for (int64_t i = 0; i < n; i++) {
        const double spin = i + 1 < n ? PHASE(THETA_RATE, i) - PHASE(THETA_RATE, i + 1) : PHASE(THETA_RATE, i);
        const double sine = ROW(SINE, i), cosine = ROW(COSINE, i);
        double normal, moment, length;
        resultants(hold[HOLD_HELD(n) + i], BLOCK(STIFFNESS), BLOCK(WIDTH), BLOCK(DEPTH), BLOCK(DAMPING),
                   PHASE(OPENING, i), 2.0 * sine, PHASE(OPENING_RATE, i), cosine * spin, &normal, &moment, &length,
                   &hold[HOLD_OUTSIDE(n) + i]);
        ROW(TURNED, i) = moment * cosine;
        JOINT(NORMAL) = normal;
        JOINT(MOMENT) = moment;
        JOINT(LENGTH) = length;
    }

    /* downwards: finish the row of the joint above, eliminate */
    double spin = PHASE(THETA_RATE, 0) + motion[3], spin_below = n > 1 ? PHASE(THETA_RATE, 1) + motion[3] : motion[3];
    over_joint sum = add_block(blocks, phase, joints, rows, n, 0, spin, spin_below, 0.0);
    for (int64_t i = 1; i < n; i++) {
        spin = spin_below;
        spin_below = i + 1 < n ? PHASE(THETA_RATE, i + 1) + motion[3] : motion[3];
        const double per_mass = BLOCK(PER_MASS), normal = JOINT(NORMAL), normal_above = joints[JOINTS_NORMAL(n) + i - 1];
        const double sine = ROW(SINE, i), cosine = ROW(COSINE, i);
        const double sine_above = ROW(SINE, i - 1), cosine_above = ROW(COSINE, i - 1);
        const double upper_sine = BLOCK(UPPER) * sine_above, upper_cosine = BLOCK(UPPER) * cosine_above;
        const double couple = ROW(TURNED, i - 1) - normal_above * upper_sine;
        const over_joint mine = add_block(blocks, phase, joints, rows, n, i, spin, spin_below, couple);
        const double q = upper_cosine + sum.half, q_turns = q * BLOCK(PER_INERTIA), square = spin * spin;
        const double sine_beta = (sine_above * cosine + cosine_above * sine) * per_mass;
        const double cosine_beta = (cosine_above * cosine - sine_above * sine) * per_mass;
        const double right = sum.right + ((upper_sine * square - normal * sine_beta) + q * mine.free_alpha);
        const double pivot = 1.0 / (sum.diagonal + q * q_turns);
        const double coupling = mine.p * q_turns - cosine_beta, part = coupling * pivot, alone = right * pivot;
        ROW(ALONE, i - 1) = alone;
        ROW(FREE_OPENING, i - 1) = sum.opens + (upper_cosine * square - normal * cosine_beta);
        ROW(PART, i) = part;
        ROW(TURN_ABOVE, i) = q_turns;
        ROW(SINE_BETA, i) = sine_beta;
        sum = mine;
        sum.diagonal -= part * coupling;
        sum.right += normal_above * sine_beta - coupling * alone;
        sum.opens -= normal_above * cosine_beta;
    }
    ROW(PIVOT, n - 1) = 1.0 / sum.diagonal;

    /* the base: gravity is an upward acceleration */
    const double pull = motion[1] + model[MODEL_SETTINGS(0) + SETTINGS_GRAVITY];
    double along = motion[0], lift = pull, opens = sum.opens;
    if (motion[2] != 0.0) {
        double base_sine, base_cosine;
        sine_cosine(motion[2], &base_sine, &base_cosine);
        along = motion[0] * base_cosine - pull * base_sine;
        lift = motion[0] * base_sine + pull * base_cosine;
    }
    const double last_sine = ROW(SINE, n - 1), last_cosine = ROW(COSINE, n - 1);
    const double right = sum.right + ((along * last_cosine - lift * last_sine) + sum.half * motion[4]);
    opens -= along * last_sine + lift * last_cosine;
    double force = right * ROW(PIVOT, n - 1);

    /* upwards */
    double swung_below = 0.0;
    for (int64_t i = n - 1; i >= 0; i--) {
        double alpha = ROW(FREE_ALPHA, i) - ROW(TURN_BELOW, i) * force, force_above = 0.0;
        if (i > 0) {
            force_above = ROW(ALONE, i - 1) - ROW(PART, i) * force;
            alpha -= ROW(TURN_ABOVE, i) * force_above;
            opens += ROW(SINE_BETA, i) * force_above;
        }
        PHASE(THETA_ACCELERATION, i) = alpha - motion[4];
        PHASE(OPENING_ACCELERATION, i) = opens + ROW(SINE, i) * (BLOCK(CENTROID) * alpha - swung_below);
        JOINT(TANGENTIAL) = force;
        if (i > 0)
            opens = ROW(FREE_OPENING, i - 1) - ROW(SINE_BETA, i) * force;
        swung_below = BLOCK(UPPER) * alpha;
        force = force_above;
    }
}

/* `rounds` times the accelerations of `count` phases, one after the other. */
void repeat(const double *model, double *phases, int count, int rounds, const double *motion, double *work)
{
    const int64_t n = (int64_t)model[MODEL_SETTINGS(0) + SETTINGS_N];
    for (int r = 0; r < rounds; r++)
        for (int k = 0; k < count; k++)
            accelerations(model, phases + PHASE_FIELDS * n * k, motion, work);
}
