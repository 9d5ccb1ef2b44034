"""The one stepping loop, and the entries that Python calls."""

import math

from .condition import has_fallen, is_quiet, moment_of_overturning, rests, take_stock, widest_joint
from .dynamics import accelerate, base_motion, observe, scratch_offset, top_motion
from .feedthrough import split_reaction
from .integrators import dormand_prince, modal, order_8
from .integrators.error import error_in_tolerances
from .interpolation import begin, interpolate_phase, refine, refinement
from .jit import entry, kernel, leaf
from .layout import (
    BASE_ALPHA,
    BASE_AX,
    BASE_AZ,
    BASE_OMEGA,
    BASE_THETA,
    CENTRAL_DIFFERENCE,
    ELASTIC_STEP,
    ELASTIC_WAIT,
    EVENTS,
    EXACT,
    EXPLICIT_STEP,
    FIRST_STEP,
    FORMULATION,
    HAS_OVERTURNED,
    INPUT_AMPLITUDE,
    INPUT_AX,
    INPUT_AZ,
    INPUT_JX,
    INPUT_JZ,
    INPUT_T0,
    INTEGRATOR,
    LAST_ERROR,
    N_BLOCKS,
    NEXT_STEP,
    OK,
    OVERTURN_TIME,
    OVERTURNED,
    PHASE_BETWEEN,
    PHASE_END,
    PHASE_START,
    RATE_FLOOR,
    RATE_SCALE,
    ROTATION_FLOOR,
    ROTATION_SCALE,
    SLACK,
    SNAPSHOT_AX,
    SNAPSHOT_AZ,
    STARTED,
    STATE_HEADER,
    STEP,
    STEP_TOO_SMALL,
    STEPS,
    TIME_AT_REST,
    TIME_FULL,
    TOP_START,
    UNHELD,
)
from .regimes import NO_CHANGE, changes, expected_change, first_change, hold, release
from .step_control import (
    FIXED,
    MODES,
    ORDER_5,
    ORDER_8,
    accepts,
    accepts_elastic,
    attempt,
    choose,
)
from .watch import take_held_snapshots, take_snapshots, track_peaks

WELL_ENOUGH = 1.0  # tolerances: what `refine` adds to an interpolation that will do for the end of a step
BEYOND = 1e-5  # of a step: so far a step made again ends beyond the change, of which it costs the square
LEAST_CUT = 1e-4  # of a step: regimes that change sooner are not held
LEAST_STEP = 1e-13  # of the time scale: below this the error control has failed


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
    inside = order_8.INSIDE if method == ORDER_8 else dormand_prince.INSIDE
    cut = NO_CHANGE
    if changes(model, work, inside, scratch):
        refine(model, inputs, work, counters, t, h)
        cut = first_change(model, work, inside, scratch, h)
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
    return accelerate(model, inputs, work, end, t + fraction * h, work, counters)


@kernel
def _interpolates_well(model, state, work, h, fraction):
    """Whether the interpolation at this fraction of a step of h seconds is as accurate as the step."""
    n = int(model[N_BLOCKS])
    refinement(work, 2 * n, h, fraction)
    part = error_in_tolerances(model, work, 6 * n * PHASE_BETWEEN, state[ROTATION_SCALE], state[RATE_SCALE])
    return part <= WELL_ENOUGH


@kernel
def _make_again(method, model, state, counters, inputs, work, t, h):
    """Make a step of h seconds from t that ends just beyond a change of regime, held until there. Returns a code.

    What the interpolation would miss at the end of a long step of high order counts at tight tolerances.
    """
    n = int(model[N_BLOCKS])
    scratch = scratch_offset(n)
    hold(model, work, 6 * n * PHASE_START, scratch, h)
    begin(model, work, method == ORDER_8)
    code, _ = attempt(method, model, state, counters, inputs, work, t, h)
    release(model, work, scratch)
    if code != OK:
        return code
    return accelerate(model, inputs, work, 6 * n * PHASE_END, t + h, work, counters)


@leaf
def _belongs_to(state, base):
    """Whether the accelerations of the state are those under this motion of the base."""
    translates = base[0] == state[BASE_AX] and base[1] == state[BASE_AZ]
    return translates and base[2] == state[BASE_THETA] and base[3] == state[BASE_OMEGA] and base[4] == state[BASE_ALPHA]


@leaf
def _keep_base(state, base):
    """Note the motion of the base that the phase of the state belongs to."""
    state[BASE_AX], state[BASE_AZ], state[BASE_THETA], state[BASE_OMEGA], state[BASE_ALPHA] = base


@kernel
def _take_phase(model, state, base, work, to):
    """The phase of the state at work[to:], seen from the base as it stands: its rotation may have been set anew.

    The blocks stay where they are and as fast as they are.
    """
    n = int(model[N_BLOCKS])
    for i in range(6 * n):
        work[to + i] = state[STATE_HEADER + i]
    turn, spin = base[2] - state[BASE_THETA], base[3] - state[BASE_OMEGA]
    if turn != 0.0 or spin != 0.0:
        for i in range(n):
            work[to + i] -= turn
            work[to + 2 * n + i] -= spin


@kernel
def advance(model, state, counters, inputs, work, t, h, times, snapshots):
    """Take the column from t to t + h, landing there exactly. Returns a code.

    The inputs hold within the call; snapshots and peaks take it that the base does not rotate. Snapshots at those of
    `times` that lie inside are taken by interpolation; with no times neither snapshots nor peaks are kept. A column
    that has overturned keeps its state. On an error the phase in the state is that at t.
    """
    n = int(model[N_BLOCKS])
    size = 6 * n
    start = size * PHASE_START
    end = size * PHASE_END
    scratch = scratch_offset(n)
    watched = times.size > 0
    if counters[OVERTURNED] > 0:
        take_held_snapshots(model, state, counters, t, h, times, snapshots)
        return HAS_OVERTURNED

    base = base_motion(inputs, t)
    _take_phase(model, state, base, work, start)
    if counters[STARTED] == 0 or not _belongs_to(state, base):
        code = accelerate(model, inputs, work, start, t, work, counters)
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
            code = take_stock(model, state, counters, work, start, 0.0)
            if code != OK:
                return code
    if is_quiet(inputs) and rests(model, state):
        for i in range(size):
            state[STATE_HEADER + i] = work[start + i]
        _keep_base(state, (0.0, 0.0, 0.0, 0.0, 0.0))
        state[TIME_FULL] += h
        state[TIME_AT_REST] += h
        take_held_snapshots(model, state, counters, t, h, times, snapshots)
        return OK
    if watched:
        top = scratch + TOP_START * n
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
            method, step = choose(model, state, counters, inputs, work, left)
            if step * (1.0 + SLACK) >= left:
                step = left
            else:
                last = False
                if 2.0 * step > left:  # two alike rather than one and a sliver
                    step = 0.5 * left
            held = _holds(method, model, counters)
            if held:
                hold(model, work, start, scratch, step)
                expected = expected_change(model, work, start, scratch, step)
                if expected < step:
                    step = expected
                    last = False
        begin(model, work, method == ORDER_8)
        if method != MODES:
            modal.forget(model, work)
        code, error = attempt(method, model, state, counters, inputs, work, t + gone, step)
        if fixed:
            if code != OK:
                return code
        elif method == MODES:
            if not accepts_elastic(state, counters, step, code, error):
                continue
        else:
            if not accepts(method, state, counters, step, code, error):
                release(model, work, scratch)
                if state[NEXT_STEP] < LEAST_STEP * max(model[FIRST_STEP], abs(t + gone)):
                    return code if code != OK else STEP_TOO_SMALL
                continue
            counters[UNHELD] = 0
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
                if not _interpolates_well(model, state, work, step, cut):
                    cut = min(1.0, cut + BEYOND)
                    code = _make_again(method, model, state, counters, inputs, work, t + gone, cut * step)
                else:
                    code = _end_step(method, model, inputs, work, counters, t + gone, step, cut)
                if code != OK:
                    return code
                if cut < 1.0:
                    step *= cut
                    last = False
        counters[STEPS] += 1
        code = take_stock(model, state, counters, work, end, step)
        if code != OK:
            return code

        fallen = has_fallen(model, work, end)
        if fallen:
            fraction = moment_of_overturning(model, work, step)
            code = _end_step(method, model, inputs, work, counters, t + gone, step, fraction)
            if code != OK:
                return code
            step *= fraction
            state[OVERTURN_TIME] = t + gone + step
        if watched:
            track_peaks(model, state, inputs, work, counters, t + gone, step)
            take_snapshots(model, inputs, work, counters, t + gone, step, times, snapshots)
        for i in range(size):
            work[start + i] = work[end + i]
        made += 1.0
        gone = h if last and not fallen else gone + step

    for i in range(size):
        state[STATE_HEADER + i] = work[start + i]
    _keep_base(state, base_motion(inputs, t + gone))
    if fallen:
        counters[OVERTURNED] = widest_joint(model, work, start)
        take_held_snapshots(model, state, counters, t, h, times, snapshots)
        return HAS_OVERTURNED
    return OK


@kernel
def base_of(state, counters, inputs, t):
    """Motion of the base at time t; once the column has overturned, that of the moment."""
    if counters[OVERTURNED] > 0:
        return state[BASE_AX], state[BASE_AZ], state[BASE_THETA], state[BASE_OMEGA], state[BASE_ALPHA]
    return base_motion(inputs, t)


@kernel
def look(model, state, counters, work, base, rows, split):
    """Fill rows[0] with what is visible of the state upon a base that moves like that. Returns a code.

    The phase is left in PHASE_BETWEEN. split: (SPLIT,), the reaction of the base split into R0 and the effective mass.
    """
    between = 6 * int(model[N_BLOCKS]) * PHASE_BETWEEN
    _take_phase(model, state, base, work, between)
    code = observe(model, work, between, base, work, counters, rows, 0)
    if code != OK:
        return code
    return split_reaction(model, work, between, base, work, counters, rows, 0, split)


@entry
def observe_state(model, state, counters, inputs, work, t, rows, split):
    """`look` at the state at time t, under the inputs of that time, as called from Python."""
    return look(model, state, counters, work, base_of(state, counters, inputs, t), rows, split)


@entry
def observe_snapshots(model, work, counters, snapshots, rows):
    """Fill every row with what is visible of the snapshot of the same number. Returns (code, number of the last)."""
    n = int(model[N_BLOCKS])
    between = 6 * n * PHASE_BETWEEN
    for r in range(len(snapshots)):
        for i in range(6 * n):
            work[between + i] = snapshots[r, i]
        base = snapshots[r, 6 * n + SNAPSHOT_AX], snapshots[r, 6 * n + SNAPSHOT_AZ], 0.0, 0.0, 0.0
        code = observe(model, work, between, base, work, counters, rows, r)
        if code != OK:
            return code, r
    return OK, len(snapshots)


@entry
def run(model, state, counters, inputs, work, t, h, samples, hold, times, snapshots):
    """`advance` from t to t + h, under the inputs as they are or, with samples, from knot to knot. Returns a code.

    samples: (3, m), knots in s, increasing from t on, a_x and a_z there in m/s2, linear in between or, with hold, kept.
    After the last knot the base acceleration is zero, the harmonic part of the inputs included.
    """
    knots, ax, az = samples
    m = knots.size
    if m == 0:
        return advance(model, state, counters, inputs, work, t, h, times, snapshots)
    stop = t + h
    code = OK
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
