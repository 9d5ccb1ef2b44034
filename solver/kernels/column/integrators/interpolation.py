"""Interpolation of the response within a step of any integrator.

Coordinates, rates and accelerations at both ends define one quintic Hermite polynomial per coordinate; its error is of
order six in the step, and the accelerations are continuous within a step because the inputs are. Long steps of a high
order need more: `refine` evaluates the accelerations half-way and adds to the quintic the bump c s^3 (1 - s)^3, which
leaves the ends unchanged and matches that acceleration.
"""

from ...engine.interpolation import quintic_through, value_of, weights_at
from ...layout.spaces import RIGID_FIELDS
from ...numba_ext.jit import kernel, leaf
from ..formulations.dispatch import evaluate_at


@leaf
def _difference(row, i, less):
    """Return row[i] - row[less], or row[i] if less < 0."""
    return row[i] - row[less] if less >= 0 else row[i]


@leaf
def slips_of(work):
    """Return the range of the slips in a phase that are integrated: (first place, place after the last)."""
    first = RIGID_FIELDS * work.n
    return first, first + int(work.slips.count)


@leaf
def bump_of(work, i):
    """Return the index in `work.bump` of the coordinate at place i of a phase."""
    return i if i < 2 * work.n else i - 4 * work.n


@leaf
def quintic_of(work, i, less, h):
    """Return the quintic of the coordinate at place i, less that at place `less` if >= 0, over a step of `h` s."""
    # without bump where `refine` has not added one
    start, end = work.start, work.end
    bump = _difference(work.bump, bump_of(work, i), less) if work.interpolation.has_bump != 0.0 else 0.0
    return quintic_through(
        h,
        _difference(start.coordinates, i, less),
        _difference(start.rates, i, less),
        _difference(start.accelerations, i, less),
        _difference(end.coordinates, i, less),
        _difference(end.rates, i, less),
        _difference(end.accelerations, i, less),
        bump,
    )


@leaf
def interpolate_one(work, i, h, s):
    """Return the coordinate at place i and its rate at fraction s of the step of `h` s."""
    return value_of(quintic_of(work, i, -1, h), s)


@leaf
def interpolate_acceleration(work, i, s):
    """Return a first guess of the acceleration of the coordinate at place i: linear between the ends of the step."""
    return (1.0 - s) * work.start.accelerations[i] + s * work.end.accelerations[i]


@kernel
def interpolate_phase(work, h, fraction):
    """Fill `work.between` with the phase at a fraction of the step of `h` s; its accelerations are guesses only."""
    size, between = 2 * work.n, work.between
    # rotations and openings, and their rates
    q, v = weights_at(h, fraction)
    _weigh(work.start, work.end, q, v, between, size)
    # the bump that `refine` has added
    if work.interpolation.has_bump != 0.0:
        for i in range(size):
            between.coordinates[i] += q.bump * work.bump[i]
            between.rates[i] += v.bump * work.bump[i]
    # accelerations: first guesses for an evaluation
    for i in range(size):
        between.accelerations[i] = interpolate_acceleration(work, i, fraction)
    # slips and friction work
    first, end = slips_of(work)
    for i in range(first, end):
        between.coordinates[i], between.rates[i] = interpolate_one(work, i, h, fraction)
        between.coordinates[work.n + i] = spent(work, i + work.n, h, fraction)


@leaf
def _weigh(start, end, q, v, between, size):
    """Fill coordinates and rates of `between` with the quintics without bump, by the weights of one instant."""
    # differences to the start keep the digits of small movements
    for i in range(size):
        q0, v0, a0 = start.coordinates[i], start.rates[i], start.accelerations[i]
        v1, a1 = end.rates[i], end.accelerations[i]
        rise = end.coordinates[i] - q0
        between.coordinates[i] = q0 + (q.rise * rise + ((q.v0 * v0 + q.v1 * v1) + (q.a0 * a0 + q.a1 * a1)))
        between.rates[i] = v.rise * rise + ((v.v0 * v0 + v.v1 * v1) + (v.a0 * a0 + v.a1 * a1))


@leaf
def spent(work, i, h, s):
    """Return the friction work (J) at place i at fraction s of the step: the cubic by values and rates at its ends."""
    start, end = work.start.coordinates[i], work.end.coordinates[i]
    # rise over the step, and the rates times h
    rise, p0, p1 = end - start, h * work.start.rates[i], h * work.end.rates[i]
    return start + s * (p0 + s * ((3.0 * rise - 2.0 * p0 - p1) + s * (p0 + p1 - 2.0 * rise)))


@leaf
def begin(work, fine):
    """Start a step with the quintic alone; `fine`: `refine` adds the bump if the step is evaluated within."""
    work.interpolation.has_bump = 0.0
    work.interpolation.knows_middle = 0.0
    work.interpolation.wants_bump = 1.0 if fine else 0.0


@leaf
def _add_bump(work, i, h):
    """Set the bump of the coordinate at place i from its acceleration half-way, which is in `work.between`."""
    v0, a0 = work.start.rates[i], work.start.accelerations[i]
    v1, a1 = work.end.rates[i], work.end.accelerations[i]
    quintic = 1.5 * h * (v1 - v0) - 0.25 * h * h * (a0 + a1)  # its second derivative half-way, times h^2
    # the second derivative of s^3 (1 - s)^3 is -3/8 at s = 1/2
    work.bump[bump_of(work, i)] = -8.0 / 3.0 * (h * h * work.between.accelerations[i] - quintic)


@kernel
def refine(column, t, h):
    """Add the bump, once, if the step from t to t + h needs it; this costs one evaluation."""
    work = column.work
    # only where the method asks for it
    if work.interpolation.wants_bump == 0.0:
        return
    work.interpolation.wants_bump = 0.0
    # accelerations half-way
    size = 2 * work.n
    interpolate_phase(work, h, 0.5)
    evaluate_at(column, work.between, t + 0.5 * h)
    # bumps of all coordinates
    for i in range(size):
        _add_bump(work, i, h)
    first, behind = slips_of(work)
    for i in range(first, behind):
        _add_bump(work, i, h)
    work.interpolation.has_bump = 1.0


@kernel
def refinement(work, h, s):
    """Fill `work.between` with what `refine` added to coordinates and rates at fraction s of the step of `h` s."""
    size, between = 2 * work.n, work.between
    hill = s * (1.0 - s)
    first, behind = slips_of(work)
    # coordinates of rotations and openings, then slips
    for i in range(size + behind - first):
        place = i if i < size else first + i - size
        bump = work.bump[i] if work.interpolation.has_bump != 0.0 else 0.0
        # the bump s^3 (1 - s)^3 and its derivative
        between.coordinates[place] = bump * hill * hill * hill
        between.rates[place] = bump * 3.0 * hill * hill * (1.0 - 2.0 * s) / h
