/* One evaluation of the accelerations in C: the arithmetic of solver/kernels/exact.py and joint.py, operation by
 * operation, to see what the compiled Python costs beyond it. Where things lie in the arrays (HEIGHT, ALPHA_S, ...) is
 * defined on the command line from solver/kernels/layout.py and exact.py. */
#include <math.h>

static double greater(double a, double b) { return a > b ? a : b; }
static double lesser(double a, double b) { return a < b ? a : b; }

/* The part (lo, hi) of an interval where value + slope s > 0. */
static void positive_part(double value, double slope, double *lo, double *hi)
{
    if (slope > 0.0)
        *lo = greater(*lo, -value / slope);
    else if (slope < 0.0)
        *hi = lesser(*hi, -value / slope);
    else if (!(value > 0.0))
        *lo = *hi;
}

/* Normal force (N), moment (N m) and loaded length (m) of a no-tension joint. */
static inline void joint_forces(double stiffness, double width, double depth, double damping, double opening,
                                double slope, double opening_rate, double slope_rate, double *force, double *moment,
                                double *length)
{
    double lo = -0.5 * width, hi = 0.5 * width;
    positive_part(-opening, slope, &lo, &hi);
    if (damping > 0.0 && lo < hi)
        positive_part(-opening - damping * opening_rate, slope + damping * slope_rate, &lo, &hi);
    *length = hi - lo;
    if (!(*length > 0.0)) {
        *force = *moment = *length = 0.0;
        return;
    }
    const double mean = -(opening + damping * opening_rate), gradient = slope + damping * slope_rate;
    const double middle = 0.5 * (lo + hi), rigidity = stiffness * depth * *length;
    *force = rigidity * (mean + gradient * middle);
    *moment = middle * *force + rigidity * gradient * (*length * *length) / 12.0;
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

/* Accelerations x[4n:6n] of the phase x (coordinates, rates) upon a base that moves by (a_x, a_z, theta, omega, alpha). */
void accelerations(const double *model, double *x, const double *base, double *scratch)
{
    const int n = (int)model[N_BLOCKS];
    double mu = 0.0, lever = 0.0, push_n = 0.0, push_t = 0.0, torque = 0.0, cos_above = 1.0, sin_above = 0.0;
    double c_t_above = 0.0, c_n_above = 0.0, turn = x[0], spin = x[2 * n] + base[3];
    /* downwards: collect the part above, eliminate the block's own unknowns */
    for (int i = 0; i < n; i++) {
        const double *row = model + MODEL_HEADER + BLOCK_FIELDS * i;
        double *out = scratch + SCRATCH_FIELDS * i;
        const double height = row[HEIGHT], mass = row[MASS], over = height - row[CENTROID];
        const double opening = x[n + i], opening_rate = x[3 * n + i];
        const double turn_below = i + 1 < n ? x[i + 1] : 0.0;
        const double spin_below = i + 1 < n ? x[2 * n + i + 1] + base[3] : base[3];
        const double mean_spin = 0.5 * (spin + spin_below);
        double sin_half, cos_half, normal, moment, length;
        sine_cosine(0.5 * (turn - turn_below), &sin_half, &cos_half);
        joint_forces(row[STIFFNESS], row[JOINT_WIDTH], row[JOINT_DEPTH], row[DAMPING], opening, 2.0 * sin_half,
                     opening_rate, cos_half * (spin - spin_below), &normal, &moment, &length);
        const double moment_turn = moment * cos_half, half_opening = 0.5 * opening;
        const double b_t = half_opening + height * cos_half, b_n = -height * sin_half, fling = height * spin * spin;
        const double c_t = 2.0 * opening_rate * mean_spin - fling * sin_half;
        const double c_n = -opening * mean_spin * mean_spin - fling * cos_half;

        /* the part above, turned into the frame of this joint, and the block itself */
        const double cos_beta = cos_above * cos_half - sin_above * sin_half;
        const double sin_beta = sin_above * cos_half + cos_above * sin_half;
        const double swing = mass * over, centripetal = swing * spin * spin, pull = mu * lever;
        const double m_nn = mass + mu * (sin_beta * sin_beta), m_nt = -mu * (sin_beta * cos_beta);
        const double j_t = pull * cos_beta - swing * cos_half, j_n = swing * sin_half - pull * sin_beta;
        const double j_a = pull * lever + (swing * over + row[INERTIA]);
        double p_t = (push_n * sin_beta + push_t * cos_beta) + centripetal * sin_half;
        const double p_n = (push_n * cos_beta - push_t * sin_beta) + centripetal * cos_half;
        double p_a = lever * push_t - torque;
        /* eliminate the opening, then the rotation */
        const double per_mass = 1.0 / m_nn, t_scaled = mass * (mass + mu);
        const double jt_scaled = mass * j_t - swing * mu * (sin_beta * sin_above), ja_scaled = j_a * m_nn - j_n * j_n;
        const double free = (normal - p_n) * per_mass;
        p_t += m_nt * free;
        p_a += j_n * free + (normal * b_n + moment_turn);
        const double g_scaled = jt_scaled + b_t * t_scaled;
        const double inertia_scaled = ja_scaled + b_t * (jt_scaled + g_scaled), per_inertia = 1.0 / inertia_scaled;
        const double alpha_s = -g_scaled * per_inertia, alpha_0 = -(p_a + b_t * p_t) * (per_inertia * m_nn);
        const double at_s = 1.0 + b_t * alpha_s, at_0 = b_t * alpha_0;
        const double an_s = -(j_n * alpha_s + m_nt * at_s) * per_mass;
        const double an_0 = free - (j_n * alpha_0 + m_nt * at_0) * per_mass;
        out[ALPHA_S] = alpha_s;
        out[ALPHA_0] = alpha_0;
        out[OPEN_S] = an_s - b_n * alpha_s;
        out[OPEN_0] = an_0 - b_n * alpha_0;
        out[ABOVE_S] = (at_s * cos_beta - an_s * sin_beta) + lever * alpha_s;
        out[ABOVE_0] = (at_0 * cos_beta - an_0 * sin_beta) + (lever * alpha_0 + c_t_above);
        out[RISE_S] = at_s * sin_beta + an_s * cos_beta;
        out[RISE_0] = at_0 * sin_beta + an_0 * cos_beta + c_n_above;
        mu = (t_scaled * ja_scaled - jt_scaled * jt_scaled) / (m_nn * inertia_scaled);
        const double tau = p_t + g_scaled * per_mass * alpha_0;
        out[FORCE_S] = mu;
        out[FORCE_0] = tau;
        out[JOINT_NORMAL] = normal;
        out[JOINT_MOMENT] = moment;
        out[JOINT_LENGTH] = length;
        /* hand over to the block below */
        lever = half_opening;
        push_n = normal;
        push_t = tau + mu * c_t;
        torque = moment_turn;
        cos_above = cos_half;
        sin_above = sin_half;
        c_t_above = c_t;
        c_n_above = c_n;
        turn = turn_below;
        spin = spin_below;
    }

    /* upwards: gravity is an upward acceleration of the base */
    const double pull_up = base[1] + model[GRAVITY];
    double sine, cosine;
    sine_cosine(base[2], &sine, &cosine);
    const double along = base[0] * cosine - pull_up * sine, lift = base[0] * sine + pull_up * cosine;
    double s_t = (along * cos_above - lift * sin_above) + (c_t_above + lever * base[4]);
    double s_n = (along * sin_above + lift * cos_above) + c_n_above;
    for (int i = n - 1; i >= 0; i--) {
        double *out = scratch + SCRATCH_FIELDS * i;
        x[4 * n + i] = out[ALPHA_S] * s_t + (out[ALPHA_0] - base[4]);
        x[5 * n + i] = out[OPEN_S] * s_t + (out[OPEN_0] - s_n);
        out[TANGENTIAL] = out[FORCE_S] * s_t + out[FORCE_0];
        s_n = out[RISE_S] * s_t + out[RISE_0];
        s_t = out[ABOVE_S] * s_t + out[ABOVE_0];
    }
}

/* `rounds` times the accelerations of `count` phases of 6n numbers, one after the other. */
void repeat(const double *model, double *phases, int count, int rounds, const double *base, double *scratch)
{
    const int n = (int)model[N_BLOCKS];
    for (int r = 0; r < rounds; r++)
        for (int k = 0; k < count; k++)
            accelerations(model, phases + 6 * n * k, base, scratch);
}
