"""The kernels for callers that have pointers instead of arrays: what a program without Python links with.

Everything between the parameters of a column and its outputs is here, so that the caller needs to calculate nothing.
A record is `count` samples of the base acceleration at `times`, s, with straight lines in between; `count` is 0
without one.
"""

import math
from collections.abc import Callable
from typing import Any

from numba import types
from numba.extending import intrinsic, register_jitable
from numba.np.arrayobj import make_array, populate_array

from .advance import advance, base_of
from .advance import look as visible
from .assembly import derive, rest
from .dynamics import base_motion, observe
from .feedthrough import base_direction, effective_mass, shear_gains, split_reaction
from .jit import OPTIONS, kernel
from .layout import (
    AUTO,
    BASE_AX,
    BASE_OMEGA,
    BASE_THETA,
    BLOCK_FIELDS,
    CENTRAL_DIFFERENCE,
    CENTROID,
    COUNTERS,
    DAMPING,
    EXACT,
    FIRST_STEP,
    FORMULATION,
    GRAVITY,
    HEIGHT,
    INERTIA,
    INPUT_AX,
    INPUT_AZ,
    INPUT_BASE_ALPHA,
    INPUT_BASE_OMEGA,
    INPUT_BASE_THETA,
    INPUT_JX,
    INPUT_JZ,
    INPUT_T0,
    INPUTS,
    INTEGRATOR,
    JOINT_DEPTH,
    JOINT_WIDTH,
    MASS,
    MODAL,
    MODAL_MOST,
    MODEL_HEADER,
    N_BLOCKS,
    OK,
    OVERTURNED,
    PHASE_BETWEEN,
    PHASE_START,
    ROW_FIELDS,
    ROW_FX,
    ROW_FZ,
    ROW_MY,
    ROW_S,
    SPLIT,
    STEP,
    STIFFNESS,
    TOLERANCE,
    WITHOUT,
    modal_size,
    row_size,
    state_size,
    work_size,
)
from .normal_modes import normal_modes
from .normal_modes import scratch_size as modes_scratch
from .stability import longest_stable_step
from .stability import scratch_size as stability_scratch

# what describes a column: settings, then fields of each block; 0 for an optional value that is not given
GIVEN_SETTINGS = ("g", "step", "tolerance", "formulation", "integrator", "without")
GIVEN_BLOCK = ("height", "width", "depth", "mass", "centroid", "inertia")
GIVEN_JOINT = ("stiffness", "damping", "width", "depth")
GIVEN_FIELDS = len(GIVEN_BLOCK) + len(GIVEN_JOINT)

# codes of `assemble`, beside those of layout.py
NOT_STABLE = -10  # the fixed step is beyond the limit, which is left in told[0]
TOO_LARGE = -11  # the moment of inertia of block told[0] is beyond float64

STEP_SLACK = 1e-6  # the limit itself is known to so many digits
SAMPLE_SLACK = 1e-9  # of a sampling interval: times closer than this are the same
PROBE_TURN = 1e-9  # rad, and
PROBE_SPIN = 1e-6  # rad/s, by which the rotation of the base is varied
RATE_PART = 1e-4  # of the first step: half the time over which outputs are differenced

# order of the base's inputs
BASE_AX_INPUT, BASE_AZ_INPUT, BASE_JX_INPUT, BASE_JZ_INPUT = 0, 1, 2, 3
BASE_THETA_INPUT, BASE_OMEGA_INPUT, BASE_ALPHA_INPUT = 4, 5, 6


def model_room(n: int) -> int:
    """Length of the largest packed model of n blocks."""
    return MODEL_HEADER + BLOCK_FIELDS * n + (modal_size(n) if n <= MODAL_MOST else 0)


def scratch_room(n: int, fixed_step: bool) -> int:
    """Length of the scratch of `assemble`, for a fixed step or one that is chosen."""
    if fixed_step:
        return stability_scratch(n)
    return modes_scratch(n) if n <= MODAL_MOST else 1


_intrinsic: Callable[..., Any] = intrinsic  # called with one argument less than it is written with


@_intrinsic
def _array(typing, pointer, length):
    """The array of `length` numbers behind a pointer; nobody counts who holds it."""
    kind = types.Array(pointer.dtype, 1, "C")

    def generate(context, builder, signature, arguments):
        array = make_array(kind)(context, builder)
        size = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(pointer.dtype)))
        data, count = arguments
        populate_array(array, data=data, shape=[count], strides=[size], itemsize=size, meminfo=None)
        return array._getvalue()

    return kind(pointer, types.intp), generate


@_intrinsic
def _row(typing, pointer, length):
    """The array of one row of `length` numbers behind a pointer."""
    kind = types.Array(pointer.dtype, 2, "C")

    def generate(context, builder, signature, arguments):
        array = make_array(kind)(context, builder)
        size = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(pointer.dtype)))
        data, count = arguments
        one = context.get_constant(types.intp, 1)
        strides = [builder.mul(size, count), size]
        populate_array(array, data=data, shape=[one, count], strides=strides, itemsize=size, meminfo=None)
        return array._getvalue()

    return kind(pointer, types.intp), generate


# formulas of lengths, for Python and for the kernels here
for _formula in (modal_size, model_room, row_size, state_size, work_size, modes_scratch, stability_scratch):
    register_jitable(**OPTIONS)(_formula)


@kernel
def _arrays(n, model, state, counters, inputs, work):
    return (
        _array(model, model_room(n)),
        _array(state, state_size(n)),
        _array(counters, COUNTERS),
        _array(inputs, INPUTS),
        _array(work, work_size(n)),
    )


# --- from parameters to a model


def assemble(n, given, afresh, model, state, counters, inputs, work, scratch, told):
    """The packed model of the column that `given` describes; a column at rest with `afresh`. Returns a code.

    Without `afresh` the motion goes on from the present coordinates and rates. On an error nothing else than `model`
    has changed, which may not be used then.
    """
    m, s, c, i, w = _arrays(n, model, state, counters, inputs, work)
    for k in range(m.size):
        m[k] = 0.0
    m[N_BLOCKS] = n
    m[GRAVITY] = given[0]
    m[STEP] = given[1]
    m[TOLERANCE] = given[2]
    m[FORMULATION] = given[3]
    m[INTEGRATOR] = given[4]
    m[WITHOUT] = given[5]
    for k in range(n):
        row = MODEL_HEADER + BLOCK_FIELDS * k
        block = len(GIVEN_SETTINGS) + GIVEN_FIELDS * k
        height, width, depth, mass = given[block], given[block + 1], given[block + 2], given[block + 3]
        centroid, inertia = given[block + 4], given[block + 5]
        joint_width, joint_depth = given[block + 8], given[block + 9]
        m[row + HEIGHT] = height
        m[row + MASS] = mass
        m[row + CENTROID] = 0.5 * height if centroid == 0.0 else centroid
        m[row + INERTIA] = mass * (height * height + width * width) / 12.0 if inertia == 0.0 else inertia
        m[row + STIFFNESS] = given[block + 6]
        m[row + DAMPING] = given[block + 7]
        m[row + JOINT_WIDTH] = width if joint_width == 0.0 else joint_width
        m[row + JOINT_DEPTH] = depth if joint_depth == 0.0 else joint_depth
        if not math.isfinite(m[row + INERTIA]):
            told[0] = k + 1.0
            return TOO_LARGE
    derive(m)
    if m[INTEGRATOR] == CENTRAL_DIFFERENCE:
        told[0] = longest_stable_step(m, c, w, _array(scratch, stability_scratch(n)))
        if m[STEP] > told[0] * (1.0 + STEP_SLACK):
            return NOT_STABLE
    for k in range(w.size):  # responses of the modes of another model
        w[k] = 0.0
    if m[FORMULATION] == EXACT and m[INTEGRATOR] == AUTO and n <= MODAL_MOST:
        end = MODEL_HEADER + BLOCK_FIELDS * n
        if normal_modes(m, m, end, _array(scratch, modes_scratch(n))):
            m[MODAL] = end
    if afresh != 0:
        rest(m, s, 0.0)
        for k in range(COUNTERS):
            c[k] = 0
        for k in range(INPUTS):
            i[k] = 0.0
    elif c[OVERTURNED] == 0:
        s[BASE_AX] = math.nan  # belongs to no input: the accelerations are to be computed anew
    return OK


# --- the base


@kernel
def _after(times, count, t):
    """Number of the first sample after time t; `count` if there is none."""
    low, high = 0, count
    while low < high:
        middle = (low + high) // 2
        if t < times[middle]:
            high = middle
        else:
            low = middle + 1
    return low


@kernel
def _not_before(times, count, t):
    """Number of the first sample at time t or after it; `count` if there is none."""
    low, high = 0, count
    while low < high:
        middle = (low + high) // 2
        if times[middle] < t:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def _drive(inputs, base, gone, t, inside, count, times, ax, az, scale):
    """Let the base follow, from time t on, its inputs, set `gone` s before, and the record.

    Of the record, the straight line that passes through the instant `inside`; nothing before or after it.
    """
    inputs[INPUT_AX] = base[BASE_AX_INPUT] + base[BASE_JX_INPUT] * gone
    inputs[INPUT_JX] = base[BASE_JX_INPUT]
    inputs[INPUT_AZ] = base[BASE_AZ_INPUT] + base[BASE_JZ_INPUT] * gone
    inputs[INPUT_JZ] = base[BASE_JZ_INPUT]
    omega, alpha = base[BASE_OMEGA_INPUT], base[BASE_ALPHA_INPUT]
    inputs[INPUT_BASE_THETA] = base[BASE_THETA_INPUT] + gone * (omega + 0.5 * gone * alpha)
    inputs[INPUT_BASE_OMEGA] = omega + gone * alpha
    inputs[INPUT_BASE_ALPHA] = alpha
    inputs[INPUT_T0] = t
    k = _after(times, count, inside) - 1
    if 0 <= k < count - 1:
        since = t - times[k]
        width = times[k + 1] - times[k]
        first, first_z = scale * ax[k], scale * az[k]
        slope = (scale * ax[k + 1] - first) / width
        slope_z = (scale * az[k + 1] - first_z) / width
        inputs[INPUT_AX] += first + slope * since
        inputs[INPUT_JX] += slope
        inputs[INPUT_AZ] += first_z + slope_z * since
        inputs[INPUT_JZ] += slope_z


# --- motion and what is seen of it


def follow(n, model, state, counters, inputs, work, base, start, h, count, times, ax, az, dt, scale, told):
    """Take the column from `start` to start + h, s, over the samples of the record in between. Returns a code.

    base: the base's inputs, which begin at `start`. The time from which the column could not go on is left in told[0].
    """
    m, s, c, i, w = _arrays(n, model, state, counters, inputs, work)
    stop = start + h
    first = _after(times, count, start + SAMPLE_SLACK * dt)
    last = _not_before(times, count, stop - SAMPLE_SLACK * dt)
    code = OK
    begin = start
    for k in range(first, max(first, last) + 1):
        end = times[k] if k < last else stop
        told[0] = begin
        _drive(i, base, begin - start, begin, 0.5 * (begin + end), count, times, ax, az, scale)
        # without a record the step is the caller's, to the last bit
        code = advance(m, s, c, i, w, begin, h if count == 0 else end - begin, _array(told, 0), _row(told, 0))
        if code < OK:
            return code
        begin = end
    return OK


def look(
    n, model, state, counters, inputs, work, base, afresh, upright, gone, t, count, times, ax, az, dt, scale, row, split
):
    """Fill output row and split reaction with what is visible at time t. Returns a code.

    With `afresh` under the base's inputs, set `gone` s before; else under those that the last step has left. With
    `upright` the column stands on the base as it is turned and turning, instead of upright in space.
    """
    m, s, c, i, w = _arrays(n, model, state, counters, inputs, work)
    if afresh != 0:
        _drive(i, base, gone, t, t + SAMPLE_SLACK * dt, count, times, ax, az, scale)
    if upright != 0:
        s[BASE_THETA] = i[INPUT_BASE_THETA]
        s[BASE_OMEGA] = i[INPUT_BASE_OMEGA]
    return visible(m, s, c, w, base_of(s, c, i, t), _row(row, row_size(n)), _array(split, SPLIT))


def rates(n, model, state, counters, inputs, work, t, row, split, other, other_split):
    """Fill row and split with the rate of every output at time t, 1/s; `look` has been called then. Returns a code.

    Central differences over a fraction of the fastest motion of the column that the first step is made for, on the
    parabola that coordinates, rates and accelerations describe. The others are room for another row and split.
    """
    m, s, c, i, w = _arrays(n, model, state, counters, inputs, work)
    here, there = _row(row, row_size(n)), _row(other, row_size(n))
    parts, other_parts = _array(split, SPLIT), _array(other_split, SPLIT)
    _clear(here, parts)
    if c[OVERTURNED] > 0:
        return OK
    code = visible(m, s, c, w, base_motion(i, t), there, other_parts)
    between, kept = 6 * n * PHASE_BETWEEN, 6 * n * PHASE_START
    for k in range(6 * n):
        w[kept + k] = w[between + k]
    past = RATE_PART * m[FIRST_STEP]
    for _ in range(2):
        for k in range(2 * n):
            q, v, a = w[kept + k], w[kept + 2 * n + k], w[kept + 4 * n + k]
            w[between + k] = q + past * (v + 0.5 * past * a)
            w[between + 2 * n + k] = v + past * a
            w[between + 4 * n + k] = a
        then = base_motion(i, t + past)
        code = min(code, observe(m, w, between, then, w, c, there, 0))
        code = min(code, split_reaction(m, w, between, then, w, c, there, 0, other_parts))
        _add(here, parts, there, other_parts, 0.5 / past)
        past = -past
    return code


@kernel
def _clear(row, split):
    for k in range(row.size):
        row[0, k] = 0.0
    for k in range(SPLIT):
        split[k] = 0.0


@kernel
def _add(row, split, other, other_split, factor):
    for k in range(row.size):
        row[0, k] += factor * other[0, k]
    for k in range(SPLIT):
        split[k] += factor * other_split[k]


def feedthrough(n, model, state, counters, inputs, work, seeds, gone, t, row, split, other, other_split):
    """Fill row and split with the derivative of every output by the base's inputs, in the direction `seeds`.

    seeds: one for each of the base's inputs, which were set `gone` s before; as at time t under the inputs that `look`
    has left. What follows the accelerations of the base at once is linear in them: shears and reaction by the recursion
    of kernels/feedthrough.py, exactly; in the first-order model the difference over 1 m/s2, which is the derivative
    too. What follows its rotation and the rate of that is differenced. Returns a code.
    """
    m, s, c, i, w = _arrays(n, model, state, counters, inputs, work)
    here, there = _row(row, row_size(n)), _row(other, row_size(n))
    parts, other_parts = _array(split, SPLIT), _array(other_split, SPLIT)
    _clear(here, parts)
    if c[OVERTURNED] > 0:
        return OK
    along_x = seeds[BASE_AX_INPUT] + gone * seeds[BASE_JX_INPUT]
    along_z = seeds[BASE_AZ_INPUT] + gone * seeds[BASE_JZ_INPUT]
    alpha = seeds[BASE_ALPHA_INPUT]
    spin = seeds[BASE_OMEGA_INPUT] + gone * alpha
    turn = seeds[BASE_THETA_INPUT] + gone * (seeds[BASE_OMEGA_INPUT] + 0.5 * gone * alpha)
    base = base_motion(i, t)
    code = OK
    if m[FORMULATION] != EXACT:
        there_x, there_z = base[0] + along_x, base[1] + along_z
        code = min(code, visible(m, s, c, w, (there_x, there_z, base[2], base[3], alpha), there, other_parts))
        _add(here, parts, there, other_parts, 1.0)
        code = min(code, visible(m, s, c, w, base, there, other_parts))
        _add(here, parts, there, other_parts, -1.0)
        for k in range(SPLIT):  # neither part of the split follows the accelerations
            parts[k] = 0.0
    else:
        code = min(code, visible(m, s, c, w, base, there, other_parts))
        between = 6 * n * PHASE_BETWEEN
        g_x, g_z, g_m = base_direction(m, w, between, base[2])
        met = g_x * along_x + g_z * along_z + g_m * alpha
        force = effective_mass(m, w) * met
        tail = ROW_FIELDS * n
        shear_gains(m, w, between, base[2], w, w, 6 * n * PHASE_START)
        for k in range(n):
            here[0, ROW_S * n + k] = w[6 * n * PHASE_START + k] * met
        here[0, tail + ROW_FX] = -g_x * force
        here[0, tail + ROW_FZ] = -g_z * force
        here[0, tail + ROW_MY] = -g_m * force
    way = 1.0
    for _ in range(2):
        if turn != 0.0:
            then = base[0], base[1], base[2] + way * PROBE_TURN, base[3], base[4]
            code = min(code, visible(m, s, c, w, then, there, other_parts))
            _add(here, parts, there, other_parts, 0.5 * turn / (way * PROBE_TURN))
        if spin != 0.0:
            then = base[0], base[1], base[2], base[3] + way * PROBE_SPIN, base[4]
            code = min(code, visible(m, s, c, w, then, there, other_parts))
            _add(here, parts, there, other_parts, 0.5 * spin / (way * PROBE_SPIN))
        way = -1.0
    return code


_numbers, _counters = types.CPointer(types.double), types.CPointer(types.int64)
_number, _whole = types.double, types.int64
_column = (_whole, _numbers, _numbers, _counters, _numbers, _numbers)  # n, model, state, counters, inputs, work
_record = (_whole, _numbers, _numbers, _numbers, _number, _number)  # count, times, ax, az, dt, scale
# entry -> types of its arguments; all return a code
ENTRIES = {
    assemble: (_whole, _numbers, _whole, _numbers, _numbers, _counters, _numbers, _numbers, _numbers, _numbers),
    follow: (*_column, _numbers, _number, _number, *_record, _numbers),
    look: (*_column, _numbers, _whole, _whole, _number, _number, *_record, _numbers, _numbers),
    rates: (*_column, _number, _numbers, _numbers, _numbers, _numbers),
    feedthrough: (*_column, _numbers, _number, _number, _numbers, _numbers, _numbers, _numbers),
}
