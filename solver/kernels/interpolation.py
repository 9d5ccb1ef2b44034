"""The response inside a step, whatever integrator made it.

Coordinates, rates and accelerations at both ends define one quintic Hermite polynomial per coordinate; its error is of
order six in the step, and the accelerations are continuous inside a step because the inputs are. Long steps of a high
order need more: `refine` evaluates the accelerations half-way and adds to the quintic the bump c s^3 (1 - s)^3, which
leaves the ends as they are and meets that acceleration.
"""

from .dynamics import accelerate
from .jit import kernel, leaf, place
from .layout import N_BLOCKS, OK, PHASE_BETWEEN, PHASE_BUMP, PHASE_END, PHASE_START


@leaf
def interpolate_one(work, size, i, h, s):
    """Coordinate i and its rate at fraction s of the step h (s)."""
    start = place(3 * size * PHASE_START + i)
    end = place(3 * size * PHASE_END + i)
    q0 = work[start]
    v0 = work[start + size]
    a0 = work[start + 2 * size]
    # what a parabola from the start misses at the end, in displacement, velocity and acceleration
    miss_q = (work[end] - q0) - h * (v0 + 0.5 * h * a0)
    miss_v = h * (work[end + size] - v0 - h * a0)
    miss_a = h * h * (work[end + 2 * size] - a0)
    c3 = 10.0 * miss_q - 4.0 * miss_v + 0.5 * miss_a
    c4 = -15.0 * miss_q + 7.0 * miss_v - miss_a
    c5 = 6.0 * miss_q - 3.0 * miss_v + 0.5 * miss_a
    q = q0 + s * (h * (v0 + 0.5 * s * h * a0) + s * s * (c3 + s * (c4 + s * c5)))
    v = v0 + s * (h * a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)) / h)
    bump = work[place(3 * size * PHASE_BUMP + i)]
    if bump != 0.0:
        hill = s * (1.0 - s)
        q += bump * hill * hill * hill
        v += bump * 3.0 * hill * hill * (1.0 - 2.0 * s) / h
    return q, v


@leaf
def interpolate_acceleration(work, size, i, s):
    """A guess of acceleration i at fraction s of the step: on the line between its ends."""
    a0 = work[3 * size * PHASE_START + 2 * size + i]
    return (1.0 - s) * a0 + s * work[3 * size * PHASE_END + 2 * size + i]


@kernel
def interpolate_phase(work, size, h, fraction):
    """Fill PHASE_BETWEEN at `fraction` of the step h (s); the accelerations there are guesses only.

    size: coordinates per phase.
    """
    between = 3 * size * PHASE_BETWEEN
    for i in range(size):
        work[between + i], work[between + size + i] = interpolate_one(work, size, i, h, fraction)
        work[between + 2 * size + i] = interpolate_acceleration(work, size, i, fraction)


@kernel
def begin(model, work, fine):
    """Begin with the quintic alone; `fine` says whether `refine` shall improve on it where the step is looked into."""
    size = 2 * int(model[N_BLOCKS])
    for i in range(size):
        work[3 * size * PHASE_BUMP + i] = 0.0
    work[3 * size * PHASE_BUMP + size] = 1.0 if fine else 0.0


@kernel
def refine(model, inputs, work, counters, t, h):
    """Add the bump, once, if the step from t to t + h is to have one; costs an evaluation. Returns a code."""
    size = 2 * int(model[N_BLOCKS])
    bump = 3 * size * PHASE_BUMP
    if work[bump + size] == 0.0:
        return OK
    work[bump + size] = 0.0
    start, end, between = 3 * size * PHASE_START, 3 * size * PHASE_END, 3 * size * PHASE_BETWEEN
    interpolate_phase(work, size, h, 0.5)
    code = accelerate(model, inputs, work, between, t + 0.5 * h, work, counters)
    for i in range(size):
        v0, a0 = work[start + size + i], work[start + 2 * size + i]
        v1, a1 = work[end + size + i], work[end + 2 * size + i]
        quintic = 1.5 * h * (v1 - v0) - 0.25 * h * h * (a0 + a1)  # its second derivative half-way, times h^2
        work[bump + i] = -8.0 / 3.0 * (h * h * work[between + 2 * size + i] - quintic)
    return code


@kernel
def refinement(work, size, h, s):
    """What `refine` added to coordinates and rates at fraction s of the step: left in PHASE_BETWEEN."""
    bump, between = 3 * size * PHASE_BUMP, 3 * size * PHASE_BETWEEN
    hill = s * (1.0 - s)
    for i in range(size):
        work[between + i] = work[bump + i] * hill * hill * hill
        work[between + size + i] = work[bump + i] * 3.0 * hill * hill * (1.0 - 2.0 * s) / h


@kernel
def turning_point(d0, v0, d1, v1, h):
    """Fraction of the step where the cubic through two displacements and velocities turns; v0 * v1 < 0."""
    # velocity of the cubic: v0 + 2 b s + 3 c s^2 over a step of unit length
    rise = (d1 - d0) / h
    b = 3.0 * rise - 2.0 * v0 - v1
    c = v0 + v1 - 2.0 * rise
    root = max(0.0, b * b - 3.0 * c * v0) ** 0.5
    # the root inside is the one whose denominator does not cancel
    below = -(b + root) if b > 0.0 else -(b - root)
    first = v0 / below if below != 0.0 else 0.5
    if 0.0 <= first <= 1.0:
        return first
    second = below / (3.0 * c) if c != 0.0 else 0.5
    return min(1.0, max(0.0, second))
