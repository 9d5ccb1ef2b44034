"""The one stepping loop: internal steps, error control, overturning, peaks, output rows."""

import math

from .dynamics import accelerate, base_acceleration, observe, reach_of, rotation, scratch_offset, top_motion
from .integrators import central_difference, dormand_prince, modal, rosenbrock
from .interpolation import interpolate_phase, turning_point
from .jit import entry, kernel
from .layout import (
    BASE_AX,
    BASE_AZ,
    BLOCK_FIELDS,
    CENTRAL_DIFFERENCE,
    ELASTIC_STEP,
    ELASTIC_STEPS,
    ELASTIC_WAIT,
    EXACT,
    EXPLICIT_STEP,
    FALL_ANGLE,
    FIRST_STEP,
    FORMULATION,
    HAS_OVERTURNED,
    IMPLICIT,
    IMPLICIT_STEPS,
    INPUT_AMPLITUDE,
    INPUT_AX,
    INPUT_AZ,
    INPUT_JX,
    INPUT_JZ,
    INPUT_OMEGA,
    INPUT_T0,
    INTEGRATOR,
    JOINT_LENGTH,
    JOINT_WIDTH,
    LAST_ERROR,
    MODEL_HEADER,
    N_BLOCKS,
    NEXT_ROW,
    NEXT_STEP,
    NOT_FINITE,
    OK,
    OVERTURN_TIME,
    OVERTURNED,
    PHASE_BETWEEN,
    PHASE_END,
    PHASE_START,
    RATE_FLOOR,
    RATE_SCALE,
    REJECTED,
    ROTATION_FLOOR,
    ROTATION_SCALE,
    SCRATCH_FIELDS,
    SINCE_PROBE,
    STARTED,
    STATE_HEADER,
    STEP,
    STEP_TOO_SMALL,
    STEPS,
    TIME_FLIGHT,
    TIME_FULL,
    TIME_ROCKING,
    TOP_BETWEEN,
    TOP_END,
    TOP_START,
    TURN_SIZE,
)

SAFETY = 0.9
SHRINK = 0.2
GROW = 5.0
# step control with memory (K. Gustafsson, ACM Trans. Math. Softw. 17 (1991) 533-554), parts of one over the order: a
# step at the edge of stability is not tried beyond it every other time
INTEGRAL = 0.7
PROPORTIONAL = 0.4
LEAST_ERROR = 1e-4
# when `auto` changes its method
GAIN = 1.2  # the implicit method has to step further than the explicit one by so much
PROBE = 2.0  # times the explicit step: how far the implicit method is tried
STEPS_PER_PROBE = 100
SMOOTHING = 0.2
# when the modal method is used: a step of it costs half of one of the others
ELASTIC_COST = 0.5
WAIT_OPEN = 10  # steps of the others after a joint was found open before it is tried again
WAIT_SHORT = 30  # and after its steps had become too short
SPARE = 0.3  # of the tolerance: with a smaller error the step becomes longer
SLACK = 1e-9  # of a step: times closer than this are the same
LEAST_STEP = 1e-13  # of the time scale: below this the error control has failed


@kernel
def _has_fallen(model, x, o):
    """Whether a block, or the joint under it, has turned beyond its angle of no return."""
    n = int(model[N_BLOCKS])
    fallen = False
    below = 0.0
    for i in range(n - 1, -1, -1):
        turn = rotation(model, x, o, i)
        limit = model[MODEL_HEADER + BLOCK_FIELDS * i + FALL_ANGLE]
        fallen = fallen or abs(turn - below) > limit or abs(turn) > limit
        below = turn
    return fallen


@kernel
def _take_stock(model, state, work, o, h):
    """Scales, regime and validity after a step of h seconds to the phase at work[o:]. Returns a code."""
    n = int(model[N_BLOCKS])
    exact = model[FORMULATION] == EXACT
    lengths = scratch_offset(n) + JOINT_LENGTH
    turned = 0.0
    spun = 0.0
    least = 1.0
    sum_all = 0.0
    for i in range(n):
        row = MODEL_HEADER + BLOCK_FIELDS * i
        size = model[row + TURN_SIZE]
        turned = max(turned, abs(work[o + i]) / size)
        spun = max(spun, abs(work[o + 2 * n + i]) / size)
        opening = work[o + n + i]
        if exact and opening > 0.0:  # as the corner of a joint that turns about the other one
            half_width = 0.5 * model[row + JOINT_WIDTH]
            turned = max(turned, opening / half_width)
            spun = max(spun, abs(work[o + 3 * n + i]) / half_width)
        least = min(least, work[lengths + SCRATCH_FIELDS * i] / model[row + JOINT_WIDTH])
        sum_all += work[o + 4 * n + i] + work[o + 5 * n + i]
    state[ROTATION_SCALE] = max(state[ROTATION_SCALE], turned)
    state[RATE_SCALE] = max(state[RATE_SCALE], spun)
    if least >= 1.0:
        state[TIME_FULL] += h
    elif least > 0.0:
        state[TIME_ROCKING] += h
    else:
        state[TIME_FLIGHT] += h
    # what is not finite in a coordinate or a rate is not finite in the accelerations either
    return OK if math.isfinite(sum_all) else NOT_FINITE


@kernel
def _widest_joint(model, x, o):
    """Number of the joint that has turned most."""
    n = int(model[N_BLOCKS])
    widest = 0
    most = -1.0
    for i in range(n):
        turned = abs(rotation(model, x, o, i) - rotation(model, x, o, i + 1))
        if turned > most:
            widest, most = i + 1, turned
    return widest


@kernel
def _moment_of_overturning(model, work, h):
    """Fraction of the step at which the column passes the angle of no return; its phase is left in PHASE_BETWEEN."""
    n = int(model[N_BLOCKS])
    start, end, between = 6 * n * PHASE_START, 6 * n * PHASE_END, 6 * n * PHASE_BETWEEN
    lo, hi = 0.0, 1.0
    for _ in range(40):
        middle = 0.5 * (lo + hi)
        interpolate_phase(work, start, end, between, 2 * n, h, middle)
        if _has_fallen(model, work, between):
            hi = middle
        else:
            lo = middle
    interpolate_phase(work, start, end, between, 2 * n, h, hi)
    return hi


@kernel
def _track_peaks(model, state, work, h):
    """Raise the peaks of |u_x| by the step just made, turning points inside it included."""
    n = int(model[N_BLOCKS])
    fields = scratch_offset(n)
    start, end, between = 6 * n * PHASE_START, 6 * n * PHASE_END, 6 * n * PHASE_BETWEEN
    peaks = STATE_HEADER + 6 * n
    # nobody can have moved by more than this in the step: leave it there unless it reaches a peak
    reach = 0.0
    passed = False
    for i in range(n - 1, -1, -1):
        reach += reach_of(model, work, end, i) + h * reach_of(model, work, end + 2 * n, i)
        passed = passed or reach > state[peaks + i]
    if not passed:
        return
    first, last, middle = fields + TOP_START * n, fields + TOP_END * n, fields + TOP_BETWEEN * n
    top_motion(model, work, start, work, first)
    top_motion(model, work, end, work, last)
    for i in range(n):
        d0, d1 = work[first + i], work[last + i]
        v0, v1 = work[first + n + i], work[last + n + i]
        state[peaks + i] = max(state[peaks + i], abs(d1))
        # beyond its ends the step can only add a turning point, and no more than a quarter of speed times step
        if v0 * v1 < 0.0 and max(abs(d0), abs(d1)) + h * min(abs(v0), abs(v1)) > state[peaks + i]:
            interpolate_phase(work, start, end, between, 2 * n, h, turning_point(d0, v0, d1, v1, h))
            top_motion(model, work, between, work, middle)
            state[peaks + i] = max(state[peaks + i], abs(work[middle + i]))


@kernel
def _serve_rows(model, inputs, work, counters, t, h, times, rows):
    """Write the output rows that fall into the step from t to t + h. Returns a code."""
    n = int(model[N_BLOCKS])
    between = 6 * n * PHASE_BETWEEN
    while counters[NEXT_ROW] < times.size and times[counters[NEXT_ROW]] <= t + h * (1.0 + SLACK):
        r = counters[NEXT_ROW]
        fraction = min(1.0, max(0.0, (times[r] - t) / h))
        interpolate_phase(work, 6 * n * PHASE_START, 6 * n * PHASE_END, between, 2 * n, h, fraction)
        base_ax, base_az = base_acceleration(inputs, t + fraction * h)
        code = observe(model, work, between, base_ax, base_az, work, counters, rows, r)
        if code != OK:
            return code
        counters[NEXT_ROW] += 1
    return OK


@kernel
def _serve_held_rows(model, state, work, counters, end_time, times, rows):
    """Write the output rows up to end_time of a column that has fallen: all alike. Returns a code."""
    n = int(model[N_BLOCKS])
    between = 6 * n * PHASE_BETWEEN
    while counters[NEXT_ROW] < times.size and times[counters[NEXT_ROW]] <= end_time:
        for i in range(6 * n):
            work[between + i] = state[STATE_HEADER + i]
        code = observe(model, work, between, state[BASE_AX], state[BASE_AZ], work, counters, rows, counters[NEXT_ROW])
        if code != OK:
            return code
        counters[NEXT_ROW] += 1
    return OK


@kernel
def _chooses_implicit(model, state, counters, step, left):
    """Whether `auto` makes its next step, of so many seconds, by the implicit method.

    A step of either costs about the same, so the one that makes longer steps is the better. The implicit one is left
    where it steps no further than the explicit one did; from time to time it is tried with a longer step.
    """
    if model[FORMULATION] != EXACT:
        return False
    if counters[IMPLICIT] == 1:
        return min(step, left) > GAIN * state[EXPLICIT_STEP]
    if counters[SINCE_PROBE] >= STEPS_PER_PROBE and PROBE * step <= left:
        counters[SINCE_PROBE] = 0
        return True
    return False


@kernel
def _elastic_step(model, state, counters, work, most):
    """What `auto` makes its next step by, s, if that is to be the modal method with all joints in contact; else 0."""
    if not modal.available(model) or most < modal.LEAST_STEP:
        return 0.0
    if counters[ELASTIC_WAIT] > 0:
        return 0.0
    if modal.longest_step(model) < ELASTIC_COST * state[NEXT_STEP]:
        return 0.0
    if not modal.suits(model, work):
        counters[ELASTIC_WAIT] = WAIT_OPEN
        return 0.0
    return min(state[ELASTIC_STEP], modal.longest_step(model))


@kernel
def _accepts_elastic(state, counters, step, code, error):
    """Whether a modal step just tried is good enough; proposes the next one either way."""
    if code != OK:
        counters[REJECTED] += 1
        counters[ELASTIC_WAIT] = WAIT_OPEN
        return False
    if error > 1.0:
        counters[REJECTED] += 1
        state[ELASTIC_STEP] = step * max(SHRINK, SAFETY * error ** (-1.0 / modal.ORDER))
        if state[ELASTIC_STEP] < ELASTIC_COST * state[NEXT_STEP]:
            counters[ELASTIC_WAIT] = WAIT_SHORT
            state[ELASTIC_STEP] = state[NEXT_STEP]
        return False
    counters[ELASTIC_STEPS] += 1
    # steps that stay the same share their responses: no change without need
    if error > SAFETY:
        state[ELASTIC_STEP] = step * SAFETY
    elif error < SPARE:
        longer = step * min(GROW, SAFETY * max(error, LEAST_ERROR) ** (-1.0 / modal.ORDER))
        state[ELASTIC_STEP] = max(state[ELASTIC_STEP], longer)
    return True


@kernel
def _attempt(model, state, counters, inputs, work, t, step, implicit):
    """One step of `auto` from t; returns (code, error in tolerances)."""
    if implicit:
        return rosenbrock.attempt(model, inputs, work, counters, state[ROTATION_SCALE], state[RATE_SCALE], t, step)
    return dormand_prince.attempt(model, inputs, work, counters, state[ROTATION_SCALE], state[RATE_SCALE], t, step)


@kernel
def _accepts(state, counters, step, implicit, code, error):
    """Whether a step just tried is good enough; proposes the next one either way."""
    order = rosenbrock.ORDER if implicit else dormand_prince.ORDER
    if code != OK or not error <= 1.0:
        counters[REJECTED] += 1
        if implicit and counters[IMPLICIT] == 0:  # a probe that failed: go on as before
            return False
        factor = SHRINK
        if code == OK and math.isfinite(error):
            factor = max(SHRINK, SAFETY * error ** (-1.0 / order))
        state[NEXT_STEP] = step * factor
        state[LAST_ERROR] = 1.0
        return False
    error = max(error, LEAST_ERROR)
    factor = SAFETY * error ** (-INTEGRAL / order) * state[LAST_ERROR] ** (PROPORTIONAL / order)
    factor = min(GROW, max(SHRINK, factor))
    state[LAST_ERROR] = error
    if implicit:
        counters[IMPLICIT_STEPS] += 1
        counters[IMPLICIT] = 1
        state[NEXT_STEP] = step * factor if factor < 1.0 else max(step * factor, state[NEXT_STEP])
        return True
    counters[SINCE_PROBE] += 1
    # a step cut short by the end of the call says nothing against the longer one proposed before
    if step >= state[NEXT_STEP] * (1.0 - SLACK):
        state[EXPLICIT_STEP] += SMOOTHING * (step - state[EXPLICIT_STEP])
        if counters[IMPLICIT] == 1:
            counters[IMPLICIT] = 0
    state[NEXT_STEP] = step * factor if factor < 1.0 else max(step * factor, state[NEXT_STEP])
    return True


@kernel
def advance(model, state, counters, inputs, work, t, h, times, rows):
    """Take the column from t to t + h, landing there exactly. Returns a code.

    The inputs hold within the call. Output rows for those of `times` that lie inside are written by interpolation;
    with no times neither rows nor peaks are kept. A column that has overturned keeps its state. On an error the phase
    in the state is that at t.
    """
    n = int(model[N_BLOCKS])
    size = 6 * n
    start = size * PHASE_START
    end = size * PHASE_END
    watched = times.size > 0
    if counters[OVERTURNED] > 0:
        code = _serve_held_rows(model, state, work, counters, t + h * (1.0 + SLACK), times, rows)
        return code if code != OK else HAS_OVERTURNED

    for i in range(size):
        work[start + i] = state[STATE_HEADER + i]
    base_ax, base_az = base_acceleration(inputs, t)
    if counters[STARTED] == 0 or base_ax != state[BASE_AX] or base_az != state[BASE_AZ]:
        code = accelerate(model, work, start, base_ax, base_az, work, counters)
        if code != OK:
            return code
        if counters[STARTED] == 0:
            counters[STARTED] = 1
            state[NEXT_STEP] = model[FIRST_STEP]
            state[EXPLICIT_STEP] = model[FIRST_STEP]
            state[LAST_ERROR] = 1.0
            state[ELASTIC_STEP] = 10.0 * model[FIRST_STEP]
            state[ROTATION_SCALE] = max(state[ROTATION_SCALE], model[ROTATION_FLOOR])
            state[RATE_SCALE] = max(state[RATE_SCALE], model[RATE_FLOOR])
            code = _take_stock(model, state, work, start, 0.0)
            if code != OK:
                return code
    if watched:
        top = scratch_offset(n) + TOP_START * n
        top_motion(model, work, start, work, top)
        for i in range(n):
            peak = STATE_HEADER + 6 * n + i
            state[peak] = max(state[peak], abs(work[top + i]))

    fixed = model[INTEGRATOR] == CENTRAL_DIFFERENCE
    # a step that arrives as 0.00999...98 or 0.0100...02 is one of 0.01
    pieces = max(1.0, math.ceil(h / model[STEP] * (1.0 - SLACK)))
    modal.forget(model, work)
    made = 0.0
    gone = 0.0  # time since t
    fallen = False
    while gone < h and not fallen:
        left = h - gone
        last = True
        if fixed:
            last = made + 1.0 >= pieces
            step = left if last else h * ((made + 1.0) / pieces) - gone
            code, error = central_difference.attempt(
                model, inputs, work, counters, state[ROTATION_SCALE], state[RATE_SCALE], t + gone, step
            )
            if code != OK:
                return code
        else:
            elastic = _elastic_step(model, state, counters, work, left)
            step = elastic if elastic > 0.0 else state[NEXT_STEP]
            if inputs[INPUT_AMPLITUDE] != 0.0:  # never skip over a cycle of the motion
                step = min(step, 1.0 / inputs[INPUT_OMEGA])
            implicit = elastic == 0.0 and _chooses_implicit(model, state, counters, step, left)
            if counters[SINCE_PROBE] == 0 and counters[IMPLICIT] == 0 and implicit:
                step *= PROBE
            if step * (1.0 + SLACK) >= left:
                step = left
            else:
                last = False
                if 2.0 * step > left:  # two alike rather than one and a sliver
                    step = 0.5 * left
            if elastic > 0.0:
                code, error = modal.attempt(
                    model, inputs, work, counters, state[ROTATION_SCALE], state[RATE_SCALE], t + gone, step
                )
                if not _accepts_elastic(state, counters, step, code, error):
                    continue
            else:
                modal.forget(model, work)
                code, error = _attempt(model, state, counters, inputs, work, t + gone, step, implicit)
            if elastic == 0.0 and not _accepts(state, counters, step, implicit, code, error):
                if state[NEXT_STEP] < LEAST_STEP * max(model[FIRST_STEP], abs(t + gone)):
                    return code if code != OK else STEP_TOO_SMALL
                continue
            if elastic == 0.0 and counters[ELASTIC_WAIT] > 0:
                counters[ELASTIC_WAIT] -= 1
        counters[STEPS] += 1
        code = _take_stock(model, state, work, end, step)
        if code != OK:
            return code

        fallen = _has_fallen(model, work, end)
        if fallen:
            step *= _moment_of_overturning(model, work, step)
            for i in range(size):
                work[end + i] = work[size * PHASE_BETWEEN + i]
            base_ax, base_az = base_acceleration(inputs, t + gone + step)
            code = accelerate(model, work, end, base_ax, base_az, work, counters)
            if code != OK:
                return code
            state[OVERTURN_TIME] = t + gone + step
        if watched:
            _track_peaks(model, state, work, step)
            code = _serve_rows(model, inputs, work, counters, t + gone, step, times, rows)
            if code != OK:
                return code
        for i in range(size):
            work[start + i] = work[end + i]
        made += 1.0
        gone = h if last and not fallen else gone + step

    for i in range(size):
        state[STATE_HEADER + i] = work[start + i]
    state[BASE_AX], state[BASE_AZ] = base_acceleration(inputs, t + gone)
    if fallen:
        counters[OVERTURNED] = _widest_joint(model, work, start)
        code = _serve_held_rows(model, state, work, counters, t + h * (1.0 + SLACK), times, rows)
        return code if code != OK else HAS_OVERTURNED
    return OK


@entry
def advance_once(model, state, counters, inputs, work, t, h, times, rows):
    """`advance` as called from Python."""
    return advance(model, state, counters, inputs, work, t, h, times, rows)


@entry
def observe_state(model, state, counters, inputs, work, t, rows):
    """Fill rows[0] with what is visible of the state at time t under the inputs of that time. Returns a code."""
    n = int(model[N_BLOCKS])
    between = 6 * n * PHASE_BETWEEN
    for i in range(6 * n):
        work[between + i] = state[STATE_HEADER + i]
    base_ax, base_az = base_acceleration(inputs, t)
    if counters[OVERTURNED] > 0:
        base_ax, base_az = state[BASE_AX], state[BASE_AZ]
    return observe(model, work, between, base_ax, base_az, work, counters, rows, 0)


@entry
def run(model, state, counters, inputs, work, knots, ax, az, hold, stop, times, rows):
    """`advance` from knot to knot of a sampled motion up to time `stop`. Returns a code.

    knots: (m,) s, increasing; ax, az: (m,) m/s2 at the knots, linear in between or, with hold, kept. After the last
    knot the base acceleration is zero, the harmonic part of the inputs included.
    """
    code = OK
    m = knots.size
    for k in range(m):
        begin = knots[k]
        if begin >= stop:
            return code
        finish = stop
        if k + 1 < m:
            finish = min(stop, knots[k + 1])
            inputs[INPUT_AX] = ax[k]
            inputs[INPUT_AZ] = az[k]
            if hold:
                inputs[INPUT_JX] = 0.0
                inputs[INPUT_JZ] = 0.0
            else:
                width = knots[k + 1] - begin
                inputs[INPUT_JX] = (ax[k + 1] - ax[k]) / width
                inputs[INPUT_JZ] = (az[k + 1] - az[k]) / width
        else:
            inputs[INPUT_AX] = 0.0
            inputs[INPUT_AZ] = 0.0
            inputs[INPUT_JX] = 0.0
            inputs[INPUT_JZ] = 0.0
            inputs[INPUT_AMPLITUDE] = 0.0
        inputs[INPUT_T0] = begin
        code = advance(model, state, counters, inputs, work, begin, finish - begin, times, rows)
        if code < OK:
            return code
    return code
