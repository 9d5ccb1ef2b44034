"""The condition of the column: standing or fallen, at rest or not, in contact, rocking or in flight."""

import math

from .dynamics import base_rotates, rotation, scratch_offset
from .interpolation import interpolate_phase
from .jit import kernel
from .layout import (
    AUTO,
    BASE_OMEGA,
    BASE_THETA,
    BLOCK_FIELDS,
    EXACT,
    FALL_ANGLE,
    FORMULATION,
    GRAVITY,
    IN_FLIGHT,
    INPUT_AMPLITUDE,
    INPUT_AX,
    INPUT_AZ,
    INPUT_JX,
    INPUT_JZ,
    INTEGRATOR,
    JOINT_DEPTH,
    JOINT_LENGTH,
    JOINT_WIDTH,
    MASS,
    MODEL_HEADER,
    N_BLOCKS,
    NOT_FINITE,
    OK,
    OPEN_SIZE,
    PHASE_BETWEEN,
    RATE_SCALE,
    REST,
    ROTATION_SCALE,
    SCRATCH_FIELDS,
    STATE_HEADER,
    STIFFNESS,
    TIME_FLIGHT,
    TIME_FULL,
    TIME_ROCKING,
    TOLERANCE,
    TURN_SIZE,
    WITHOUT,
)

# Openings count by so much in what errors are measured against: what is little of a flight is much of the landing.
FLIGHT_PART = 1e-3


@kernel
def has_fallen(model, x, o):
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
def widest_joint(model, x, o):
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
def moment_of_overturning(model, work, h):
    """Fraction of the step at which the column passes the angle of no return; its phase is left in PHASE_BETWEEN."""
    n = int(model[N_BLOCKS])
    between = 6 * n * PHASE_BETWEEN
    lo, hi = 0.0, 1.0
    for _ in range(40):
        middle = 0.5 * (lo + hi)
        interpolate_phase(work, 2 * n, h, middle)
        if has_fallen(model, work, between):
            hi = middle
        else:
            lo = middle
    interpolate_phase(work, 2 * n, h, hi)
    return hi


@kernel
def take_stock(model, state, counters, work, o, h):
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
            turned = max(turned, FLIGHT_PART * opening / half_width)
            spun = max(spun, abs(work[o + 3 * n + i]) / half_width)
        least = min(least, work[lengths + SCRATCH_FIELDS * i] / model[row + JOINT_WIDTH])
        sum_all += work[o + 4 * n + i] + work[o + 5 * n + i]
    state[ROTATION_SCALE] = max(state[ROTATION_SCALE], turned)
    state[RATE_SCALE] = max(state[RATE_SCALE], spun)
    counters[IN_FLIGHT] = 0 if least > 0.0 else 1
    if least >= 1.0:
        state[TIME_FULL] += h
    elif least > 0.0:
        state[TIME_ROCKING] += h
    else:
        state[TIME_FLIGHT] += h
    # what is not finite in a coordinate or a rate is not finite in the accelerations either
    return OK if math.isfinite(sum_all) else NOT_FINITE


@kernel
def is_quiet(inputs):
    """Whether the base neither accelerates nor rotates, nor is tilted."""
    steady = inputs[INPUT_AX] == 0.0 and inputs[INPUT_AZ] == 0.0 and not base_rotates(inputs)
    return steady and inputs[INPUT_JX] == 0.0 and inputs[INPUT_JZ] == 0.0 and inputs[INPUT_AMPLITUDE] == 0.0


@kernel
def rests(model, state):
    """Whether the column is at rest under its weight, but for a motion that the tolerance does not see."""
    if model[FORMULATION] != EXACT or model[INTEGRATOR] != AUTO or int(model[WITHOUT]) & REST:
        return False
    if state[BASE_THETA] != 0.0 or state[BASE_OMEGA] != 0.0:
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
