"""The longest stable step of central differences, for those who cannot ask an eigenvalue solver (solver/modes.py)."""

import math

from .assembly import rest
from .dynamics import accelerate_on
from .jit import kernel
from .layout import (
    BLOCK_FIELDS,
    DAMPING,
    EVALUATIONS,
    JOINT_WIDTH,
    MODEL_HEADER,
    N_BLOCKS,
    OPEN_SIZE,
    STATE_HEADER,
    SWEEPS,
    TURN_SIZE,
    state_size,
)

LEAST_COMPRESSION = 1e-6  # m, that the joints are given to be in contact where gravity does not compress them
PART = 1e-2  # of the rotation that opens a joint: how far accelerations are differenced
SQUARINGS = 60  # at most
DIGITS = 1e-13


def scratch_size(n: int) -> int:
    """Length of the scratch that `longest_stable_step` needs for n blocks."""
    return 2 * n * n + n + state_size(n)


@kernel
def longest_stable_step(model, counters, work, scratch):
    """s, of the column in full contact (solver/modes.py); what is in work is lost.

    At rest rotations and openings do not act on each other: one n x n matrix M^-1 K for each.
    """
    n = int(model[N_BLOCKS])
    matrix = STATE_HEADER + 7 * n  # behind the state
    damping = matrix + 2 * n * n  # set aside: the matrix is that of the undamped column
    evaluations, sweeps = counters[EVALUATIONS], counters[SWEEPS]
    rest(model, scratch, LEAST_COMPRESSION)
    tilt = math.inf
    most = 0.0
    for i in range(n):
        row = MODEL_HEADER + BLOCK_FIELDS * i
        most = max(most, model[row + DAMPING])
        scratch[damping + i] = model[row + DAMPING]
        model[row + DAMPING] = 0.0
        below = scratch[STATE_HEADER + n + i]
        # in the first-order model the coordinates are the settlements of the blocks
        if scratch[STATE_HEADER + n + i] > 0.0 and i + 1 < n:
            below -= scratch[STATE_HEADER + n + i + 1]
        tilt = min(tilt, PART * 2.0 * abs(below) / model[row + JOINT_WIDTH])
    square = 0.0
    for half in range(2):
        for k in range(n):
            row = MODEL_HEADER + BLOCK_FIELDS * k
            change = tilt * model[row + (TURN_SIZE if half == 0 else OPEN_SIZE)]
            for side in range(2):
                for i in range(4 * n):
                    work[i] = scratch[STATE_HEADER + i]
                for i in range(2 * n):
                    work[4 * n + i] = 0.0
                work[half * n + k] += change if side == 0 else -change
                accelerate_on(model, work, 0, (0.0, 0.0, 0.0, 0.0, 0.0), work, counters)
                for i in range(n):
                    part = work[4 * n + half * n + i] / (2.0 * change)
                    if side == 0:
                        scratch[matrix + n * i + k] = -part
                    else:
                        scratch[matrix + n * i + k] += part
        square = max(square, _spectral_radius(scratch, matrix, n))
    for i in range(n):
        model[MODEL_HEADER + BLOCK_FIELDS * i + DAMPING] = scratch[damping + i]
    counters[EVALUATIONS], counters[SWEEPS] = evaluations, sweeps
    omega = math.sqrt(square)
    d = omega * most
    return 2.0 / (omega * (math.hypot(1.0, d) + d))


@kernel
def _spectral_radius(matrix, begin, n):
    """Largest |eigenvalue| of the n x n matrix at matrix[begin:].

    The limit of |A^k|^(1/k) (Gelfand 1941), where k doubles with every square. The matrix is lost, and so is as much
    room behind it.
    """
    logarithm = 0.0
    weight = 1.0
    last = 0.0
    here, there = begin, begin + n * n
    for _ in range(SQUARINGS):
        size = 0.0
        for i in range(n * n):
            size = max(size, abs(matrix[here + i]))
        if not (size > 0.0 and math.isfinite(size)):
            return math.nan
        logarithm += weight * math.log(size)
        if abs(size - last) <= DIGITS * size:  # one eigenvalue is left: every further squaring gives the same
            logarithm += weight * math.log(size)
            break
        last = size
        weight *= 0.5
        for i in range(n):
            for j in range(n):
                matrix[there + n * i + j] = 0.0
            for k in range(n):
                factor = matrix[here + n * i + k] / size
                for j in range(n):
                    matrix[there + n * i + j] += factor * (matrix[here + n * k + j] / size)
        here, there = there, here
    return math.exp(logarithm)
