"""The one stepping loop: internal steps, error control, overturning, peaks, snapshots."""

import math

from .dynamics import accelerate, base_acceleration, observe, reach_of, rotation, scratch_offset, top_motion
from .integrators import central_difference, dormand_prince, modal, order_8, rosenbrock
from .interpolation import begin, interpolate_acceleration, interpolate_one, interpolate_phase, refine, turning_point
from .jit import entry, kernel, leaf
from .layout import (
    AUTO,
    BASE_AX,
    BASE_AZ,
    BLOCK_FIELDS,
    CENTRAL_DIFFERENCE,
    ELASTIC_STEP,
    ELASTIC_STEPS,
    ELASTIC_WAIT,
    EVENTS,
    EXACT,
    EXPLICIT_STEP,
    FALL_ANGLE,
    FIRST_STEP,
    FORMULATION,
    GRAVITY,
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
    JOINT_DEPTH,
    JOINT_LENGTH,
    JOINT_WIDTH,
    LAST_ERROR,
    MASS,
    MODEL_HEADER,
    N_BLOCKS,
    NEXT_ROW,
    NEXT_STEP,
    NOT_FINITE,
    OK,
    OPEN_SIZE,
    OVERTURN_TIME,
    OVERTURNED,
    PHASE_BETWEEN,
    PHASE_END,
    PHASE_START,
    RATE_FLOOR,
    RATE_SCALE,
    REJECTED,
    REST,
    ROTATION_FLOOR,
    ROTATION_SCALE,
    SCRATCH_FIELDS,
    SINCE_PROBE,
    SNAPSHOT_AX,
    SNAPSHOT_AZ,
    STARTED,
    STATE_HEADER,
    STEP,
    STEP_TOO_SMALL,
    STEPS,
    STIFFNESS,
    TIME_AT_REST,
    TIME_FLIGHT,
    TIME_FULL,
    TIME_ROCKING,
    TOLERANCE,
    TOP_BETWEEN,
    TOP_END,
    TOP_START,
    TURN_SIZE,
    UNHELD,
    WITHOUT,
)
from .regimes import NO_CHANGE, changes, first_change, hold, release

# methods
FIXED = 0  # central differences
ORDER_5 = 1
ORDER_8 = 2
LINEARLY_IMPLICIT = 3
MODES = 4

SAFETY = 0.9
SHRINK = 0.2
GROW = 5.0
# step control with memory (K. Gustafsson, ACM Trans. Math. Softw. 17 (1991) 533-554), parts of one over the order: a
# step at the edge of stability is not tried beyond it every other time
INTEGRAL = 0.7
PROPORTIONAL = 0.4
LEAST_ERROR = 1e-4
# when `auto` changes its method
GAIN = 2.0  # the implicit method has to step further than the explicit one by so much
PROBE = 3.0  # times the explicit step: how far the implicit method is tried
STEPS_PER_PROBE = 100
SMOOTHING = 0.2
# when the modal method is used: a step of it costs half of one of the others
ELASTIC_COST = 0.5
WAIT_OPEN = 10  # steps of the others after a joint was found open before it is tried again
WAIT_SHORT = 30  # and after its steps had become too short
SPARE = 0.3  # of the tolerance: with a smaller error the step becomes longer
SLACK = 1e-9  # of a step: times closer than this are the same
ORDER_8_BELOW = 2e-6  # tolerance of a step from which on order 8 is the cheaper explicit method
LEAST_CUT = 1e-4  # of a step: regimes that change sooner are not held
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
    between = 6 * n * PHASE_BETWEEN
    lo, hi = 0.0, 1.0
    for _ in range(40):
        middle = 0.5 * (lo + hi)
        interpolate_phase(work, 2 * n, h, middle)
        if _has_fallen(model, work, between):
            hi = middle
        else:
            lo = middle
    interpolate_phase(work, 2 * n, h, hi)
    return hi


@kernel
def _track_peaks(model, state, inputs, work, counters, t, h):
    """Raise the peaks of |u_x| by the step just made from t to t + h, turning points inside it included."""
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
            refine(model, inputs, work, counters, t, h)
            interpolate_phase(work, 2 * n, h, turning_point(d0, v0, d1, v1, h))
            top_motion(model, work, between, work, middle)
            state[peaks + i] = max(state[peaks + i], abs(work[middle + i]))


@leaf
def _row_due(counters, times, t, h):
    """Whether a snapshot falls into the step from t to t + h."""
    return counters[NEXT_ROW] < times.size and times[counters[NEXT_ROW]] <= t + h * (1.0 + SLACK)


@kernel
def _take_snapshots(model, inputs, work, counters, t, h, times, snapshots):
    """Keep the column as it is at those of `times` that fall into the step from t to t + h."""
    size = 2 * int(model[N_BLOCKS])
    guess = model[FORMULATION] != EXACT  # accelerations are worked out when the row is; the sweeps want a first guess
    while _row_due(counters, times, t, h):
        r = counters[NEXT_ROW]
        fraction = min(1.0, max(0.0, (times[r] - t) / h))
        refine(model, inputs, work, counters, t, h)
        for i in range(size):
            snapshots[r, i], snapshots[r, size + i] = interpolate_one(work, size, i, h, fraction)
            if guess:
                snapshots[r, 2 * size + i] = interpolate_acceleration(work, size, i, fraction)
        base_ax, base_az = base_acceleration(inputs, t + fraction * h)
        snapshots[r, 3 * size + SNAPSHOT_AX] = base_ax
        snapshots[r, 3 * size + SNAPSHOT_AZ] = base_az
        counters[NEXT_ROW] += 1


@kernel
def _take_held_snapshots(model, state, counters, end_time, times, snapshots):
    """The same up to end_time for a column whose state does not change."""
    n = int(model[N_BLOCKS])
    while counters[NEXT_ROW] < times.size and times[counters[NEXT_ROW]] <= end_time:
        r = counters[NEXT_ROW]
        for i in range(6 * n):
            snapshots[r, i] = state[STATE_HEADER + i]
        snapshots[r, 6 * n + SNAPSHOT_AX] = state[BASE_AX]
        snapshots[r, 6 * n + SNAPSHOT_AZ] = state[BASE_AZ]
        counters[NEXT_ROW] += 1


@kernel
def _choose_method(model, state, counters, step, left):
    """The method by which `auto` makes its next step, of so many seconds.

    Explicit, of order 8 where the tolerance is tight, or implicit. An implicit step costs about as much as one of order
    5 and half as much as one of order 8, so the method that goes further at the same cost is the better. The implicit
    one is left where it does not; from time to time it is tried with a longer step.
    """
    explicit = ORDER_8 if model[TOLERANCE] < ORDER_8_BELOW else ORDER_5
    if model[FORMULATION] != EXACT:
        return ORDER_5
    worth = 0.5 if explicit == ORDER_8 else 1.0
    if counters[IMPLICIT] == 1:
        return LINEARLY_IMPLICIT if min(step, left) > GAIN * worth * state[EXPLICIT_STEP] else explicit
    if counters[SINCE_PROBE] >= STEPS_PER_PROBE and PROBE * worth * step <= left:
        return LINEARLY_IMPLICIT
    return explicit


@kernel
def _attempt(method, model, state, counters, inputs, work, t, step):
    """One step by this method; returns (code, error in tolerances)."""
    scale, rate_scale = state[ROTATION_SCALE], state[RATE_SCALE]
    if method == ORDER_5:
        return dormand_prince.attempt(model, inputs, work, counters, scale, rate_scale, t, step)
    if method == ORDER_8:
        return order_8.attempt(model, inputs, work, counters, scale, rate_scale, t, step)
    if method == LINEARLY_IMPLICIT:
        return rosenbrock.attempt(model, inputs, work, counters, scale, rate_scale, t, step)
    if method == MODES:
        return modal.attempt(model, inputs, work, counters, scale, rate_scale, t, step)
    return central_difference.attempt(model, inputs, work, counters, scale, rate_scale, t, step)


@leaf
def _order(method):
    """Order of a method with error control."""
    if method == ORDER_8:
        return order_8.ORDER
    return rosenbrock.ORDER if method == LINEARLY_IMPLICIT else dormand_prince.ORDER


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
def _accepts(method, state, counters, step, code, error):
    """Whether a step just tried is good enough; proposes the next one either way."""
    order = _order(method)
    implicit = method == LINEARLY_IMPLICIT
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
    else:
        counters[SINCE_PROBE] += 1
        # a step cut short by the end of the call says nothing against the longer one proposed before
        if step >= state[NEXT_STEP] * (1.0 - SLACK):
            state[EXPLICIT_STEP] += SMOOTHING * (step - state[EXPLICIT_STEP])
            counters[IMPLICIT] = 0
    state[NEXT_STEP] = step * factor if factor < 1.0 else max(step * factor, state[NEXT_STEP])
    return True


@leaf
def _holds(method, model, counters):
    """Whether a step is made with the joints held in their regimes."""
    return method in (ORDER_5, ORDER_8) and model[FORMULATION] == EXACT and counters[UNHELD] == 0


@kernel
def _where_regimes_end(method, model, inputs, work, counters, t, h):
    """Fraction of the step just made at which the first joint leaves the regime it is held in; NO_CHANGE if none does.

    The joints are let go.
    """
    n = int(model[N_BLOCKS])
    scratch = scratch_offset(n)
    middle, node = dormand_prince.MIDDLE, dormand_prince.MIDDLE_NODE
    if method == ORDER_8:
        middle, node = order_8.MIDDLE, order_8.MIDDLE_NODE
    cut = NO_CHANGE
    if changes(model, work, 6 * n * middle, 6 * n * PHASE_END, scratch):
        refine(model, inputs, work, counters, t, h)
        cut = first_change(model, work, node, scratch, h)
    release(model, work, scratch)
    return cut


@kernel
def _end_step(method, model, inputs, work, counters, t, h, fraction):
    """Let the step of h seconds from t end at this fraction of it. Returns a code."""
    n = int(model[N_BLOCKS])
    end = 6 * n * PHASE_END
    interpolate_phase(work, 2 * n, h, fraction)
    for i in range(6 * n):
        work[end + i] = work[6 * n * PHASE_BETWEEN + i]
    begin(model, work, method == ORDER_8)
    base_ax, base_az = base_acceleration(inputs, t + fraction * h)
    return accelerate(model, work, end, base_ax, base_az, work, counters)


@kernel
def _is_quiet(inputs):
    """Whether the base does not accelerate."""
    steady = inputs[INPUT_AX] == 0.0 and inputs[INPUT_AZ] == 0.0
    return steady and inputs[INPUT_JX] == 0.0 and inputs[INPUT_JZ] == 0.0 and inputs[INPUT_AMPLITUDE] == 0.0


@kernel
def _rests(model, state):
    """Whether the column is at rest under its weight, but for a motion that the tolerance does not see."""
    if model[FORMULATION] != EXACT or model[INTEGRATOR] != AUTO or int(model[WITHOUT]) & REST:
        return False
    n = int(model[N_BLOCKS])
    turn = model[TOLERANCE] * state[ROTATION_SCALE]
    spin = model[TOLERANCE] * state[RATE_SCALE]
    weight = 0.0
    for i in range(n):
        row = MODEL_HEADER + BLOCK_FIELDS * i
        q = STATE_HEADER + i
        weight += model[GRAVITY] * model[row + MASS]
        settled = -weight / (model[row + STIFFNESS] * model[row + JOINT_WIDTH] * model[row + JOINT_DEPTH])
        size = model[row + OPEN_SIZE]
        if abs(state[q]) > turn or abs(state[q + n] - settled) > turn * size:
            return False
        if abs(state[q + 2 * n]) > spin or abs(state[q + 3 * n]) > spin * size:
            return False
    return True


@kernel
def advance(model, state, counters, inputs, work, t, h, times, snapshots):
    """Take the column from t to t + h, landing there exactly. Returns a code.

    The inputs hold within the call. Snapshots at those of `times` that lie inside are taken by interpolation; with no
    times neither snapshots nor peaks are kept. A column that has overturned keeps its state. On an error the phase
    in the state is that at t.
    """
    n = int(model[N_BLOCKS])
    size = 6 * n
    start = size * PHASE_START
    end = size * PHASE_END
    scratch = scratch_offset(n)
    watched = times.size > 0
    if counters[OVERTURNED] > 0:
        _take_held_snapshots(model, state, counters, t + h * (1.0 + SLACK), times, snapshots)
        return HAS_OVERTURNED

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
    if _is_quiet(inputs) and _rests(model, state):
        for i in range(size):
            state[STATE_HEADER + i] = work[start + i]
        state[BASE_AX], state[BASE_AZ] = 0.0, 0.0
        state[TIME_FULL] += h
        state[TIME_AT_REST] += h
        _take_held_snapshots(model, state, counters, t + h * (1.0 + SLACK), times, snapshots)
        return OK
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
        held = False
        method = FIXED
        if fixed:
            last = made + 1.0 >= pieces
            step = left if last else h * ((made + 1.0) / pieces) - gone
        else:
            elastic = _elastic_step(model, state, counters, work, left)
            step = elastic if elastic > 0.0 else state[NEXT_STEP]
            if inputs[INPUT_AMPLITUDE] != 0.0:  # never skip over a cycle of the motion
                step = min(step, 1.0 / inputs[INPUT_OMEGA])
            method = MODES
            if elastic == 0.0:
                method = _choose_method(model, state, counters, step, left)
            if method == LINEARLY_IMPLICIT and counters[IMPLICIT] == 0:
                counters[SINCE_PROBE] = 0
                step *= PROBE
            if step * (1.0 + SLACK) >= left:
                step = left
            else:
                last = False
                if 2.0 * step > left:  # two alike rather than one and a sliver
                    step = 0.5 * left
            held = _holds(method, model, counters)
            if held:
                hold(model, work, start, scratch, step)
        begin(model, work, method == ORDER_8)
        if method != MODES:
            modal.forget(model, work)
        code, error = _attempt(method, model, state, counters, inputs, work, t + gone, step)
        counters[UNHELD] = 0
        if fixed:
            if code != OK:
                return code
        elif method == MODES:
            if not _accepts_elastic(state, counters, step, code, error):
                continue
        else:
            if not _accepts(method, state, counters, step, code, error):
                release(model, work, scratch)
                if state[NEXT_STEP] < LEAST_STEP * max(model[FIRST_STEP], abs(t + gone)):
                    return code if code != OK else STEP_TOO_SMALL
                continue
            if counters[ELASTIC_WAIT] > 0:
                counters[ELASTIC_WAIT] -= 1
            cut = NO_CHANGE
            if held:
                cut = _where_regimes_end(method, model, inputs, work, counters, t + gone, step)
            if cut < LEAST_CUT:
                counters[UNHELD] = 1
                continue
            if cut < NO_CHANGE:
                counters[EVENTS] += 1
                code = _end_step(method, model, inputs, work, counters, t + gone, step, cut)
                if code != OK:
                    return code
                if cut < 1.0:
                    step *= cut
                    last = False
        counters[STEPS] += 1
        code = _take_stock(model, state, work, end, step)
        if code != OK:
            return code

        fallen = _has_fallen(model, work, end)
        if fallen:
            fraction = _moment_of_overturning(model, work, step)
            code = _end_step(method, model, inputs, work, counters, t + gone, step, fraction)
            if code != OK:
                return code
            step *= fraction
            state[OVERTURN_TIME] = t + gone + step
        if watched:
            _track_peaks(model, state, inputs, work, counters, t + gone, step)
            _take_snapshots(model, inputs, work, counters, t + gone, step, times, snapshots)
        for i in range(size):
            work[start + i] = work[end + i]
        made += 1.0
        gone = h if last and not fallen else gone + step

    for i in range(size):
        state[STATE_HEADER + i] = work[start + i]
    state[BASE_AX], state[BASE_AZ] = base_acceleration(inputs, t + gone)
    if fallen:
        counters[OVERTURNED] = _widest_joint(model, work, start)
        _take_held_snapshots(model, state, counters, t + h * (1.0 + SLACK), times, snapshots)
        return HAS_OVERTURNED
    return OK


@entry
def advance_once(model, state, counters, inputs, work, t, h, times, snapshots):
    """`advance` as called from Python."""
    return advance(model, state, counters, inputs, work, t, h, times, snapshots)


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
def observe_snapshots(model, work, counters, snapshots, rows):
    """Fill every row with what is visible of the snapshot of the same number. Returns (code, number of the last)."""
    n = int(model[N_BLOCKS])
    between = 6 * n * PHASE_BETWEEN
    for r in range(len(snapshots)):
        for i in range(6 * n):
            work[between + i] = snapshots[r, i]
        base_ax, base_az = snapshots[r, 6 * n + SNAPSHOT_AX], snapshots[r, 6 * n + SNAPSHOT_AZ]
        code = observe(model, work, between, base_ax, base_az, work, counters, rows, r)
        if code != OK:
            return code, r
    return OK, len(snapshots)


@entry
def run(model, state, counters, inputs, work, knots, ax, az, hold, stop, times, snapshots):
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
        code = advance(model, state, counters, inputs, work, begin, finish - begin, times, snapshots)
        if code < OK:
            return code
    return code
