"""What follows from the values that describe a column: the derived fields of the packed model, and its rest state."""

import math

from .jit import entry, kernel
from .layout import (
    BLOCK_FIELDS,
    CENTROID,
    COUPLING,
    DAMPING,
    DASHPOTS,
    EXACT,
    EXPLICIT_ORDER,
    FALL_ANGLE,
    FIRST_STEP,
    FORMULATION,
    GRAVITY,
    HEIGHT,
    INERTIA,
    JOINT_DEPTH,
    JOINT_WIDTH,
    MASS,
    MODEL_HEADER,
    N_BLOCKS,
    OPEN_SIZE,
    PIVOT,
    RATE_FLOOR,
    ROTATION_FLOOR,
    STATE_HEADER,
    STIFFNESS,
    TOLERANCE,
    TURN_SIZE,
    WITHOUT,
)

# The errors of steps add up: each is allowed this part of the tolerance that the user asks for.
STEP_PART = 0.1
LEAST_TOLERANCE = 1e-13

# Order 8 is the cheaper explicit method where the tolerance is tight, or where joint modes go on ringing because they
# are damped by less than this part of the critical damping.
TIGHT = 2e-5
LIGHTLY_DAMPED = 0.02
RINGING_PART = 0.4  # of the tolerance of a step, where nothing that it errs by dies out

NO_DAMPING = 1e-300  # s: what a dashpot that does nothing is computed with

# Errors are measured against the largest rotation so far, and at least against this part of the rotation at which the
# base joint opens: a column at rest, or nearly, need not be followed digit by digit.
FLOOR = 1e-2
LEAST_FLOOR = 1e-9  # rad

# A column has overturned when a block, or the joint under it, has turned by more than this many times the angle at
# which the block alone would stand on its edge (below that angle gravity still rights it), and by at least LEAST_FALL,
# at most a quarter turn.
FALL_MARGIN = 1.5
LEAST_FALL = 0.5  # rad


@kernel
def derive(model):
    """Fill in the fields that follow from those that describe the column and its settings.

    TOLERANCE is the user's before and that of a step afterwards: to be called once.
    """
    n = int(model[N_BLOCKS])
    tight = model[TOLERANCE] <= TIGHT
    model[TOLERANCE] = max(LEAST_TOLERANCE, STEP_PART * model[TOLERANCE])
    exact = model[FORMULATION] == EXACT
    height = 0.0  # of the top face of the block
    for i in range(n - 1, -1, -1):
        row = MODEL_HEADER + BLOCK_FIELDS * i
        width = model[row + JOINT_WIDTH]
        height += model[row + HEIGHT]
        if int(model[WITHOUT]) & DASHPOTS:
            model[row + DAMPING] = max(model[row + DAMPING], NO_DAMPING)
        model[row + OPEN_SIZE] = width / math.sqrt(12.0)
        model[row + TURN_SIZE] = 1.0 if exact else height
        edge_angle = math.atan2(0.5 * width, model[row + CENTROID])
        model[row + FALL_ANGLE] = min(0.5 * math.pi, max(LEAST_FALL, FALL_MARGIN * edge_angle))
    _factorize_horizontal_mass(model)

    # an upper bound of the joint modes, from each block between two stiff joints
    fastest = 0.0
    opening_rotation = math.inf  # least rotation at which a joint opens at rest
    carried = 0.0
    spring_above = 0.0
    damping = 0.0  # s, the largest
    for i in range(n):
        row = MODEL_HEADER + BLOCK_FIELDS * i
        spring = model[row + STIFFNESS] * model[row + JOINT_WIDTH] * model[row + JOINT_DEPTH]
        fastest = max(fastest, (spring + spring_above) / model[row + MASS])
        spring_above = spring
        damping = max(damping, model[row + DAMPING])
        carried += model[row + MASS]
        opening_rotation = min(opening_rotation, 2.0 * (model[GRAVITY] * carried / spring) / model[row + JOINT_WIDTH])
    fastest = math.sqrt(2.0 * fastest)  # rad/s
    model[FIRST_STEP] = 0.1 / fastest
    ringing = 0.5 * damping * fastest < LIGHTLY_DAMPED
    model[EXPLICIT_ORDER] = 8.0 if tight or ringing else 5.0
    if ringing:
        model[TOLERANCE] = max(LEAST_TOLERANCE, RINGING_PART * model[TOLERANCE])
    model[ROTATION_FLOOR] = max(LEAST_FLOOR, FLOOR * opening_rotation)
    model[RATE_FLOOR] = model[ROTATION_FLOOR] * math.sqrt(max(model[GRAVITY], 1e-3) / height)


@kernel
def _factorize_horizontal_mass(model):
    """LDL' of the tridiagonal B' m B + C' H^-1 I H^-1 C (theory.md section 3): inverse pivots 1/kg and multipliers."""
    n = int(model[N_BLOCKS])
    above = 0.0  # what the block above adds to the diagonal
    side = 0.0  # between it and this block
    pivot = 1.0
    for i in range(n):
        row = MODEL_HEADER + BLOCK_FIELDS * i
        mass = model[row + MASS]
        low = model[row + CENTROID] / model[row + HEIGHT]
        high = 1.0 - low
        turning = model[row + INERTIA] / (model[row + HEIGHT] * model[row + HEIGHT])
        multiplier = side / pivot
        pivot = mass * (low * low) + turning + above - side * multiplier
        above = mass * (high * high) + turning
        side = mass * low * high - turning
        model[row + PIVOT] = 1.0 / pivot
        model[row + COUPLING] = multiplier


@kernel
def rest(model, state, least):
    """State of a column at rest under gravity, every joint compressed by at least so many m."""
    n = int(model[N_BLOCKS])
    for i in range(state.size):
        state[i] = 0.0
    carried = 0.0
    for i in range(n):
        row = MODEL_HEADER + BLOCK_FIELDS * i
        carried += model[row + MASS]
        spring = model[row + STIFFNESS] * model[row + JOINT_WIDTH] * model[row + JOINT_DEPTH]
        state[STATE_HEADER + n + i] = -max(least, model[GRAVITY] * carried / spring)
    if model[FORMULATION] != EXACT:  # settlements of the blocks, positive down
        settled = 0.0
        for i in range(n - 1, -1, -1):
            settled += state[STATE_HEADER + n + i]
            state[STATE_HEADER + n + i] = -settled


@entry
def derive_fields(model):
    """`derive` as called from Python."""
    derive(model)
