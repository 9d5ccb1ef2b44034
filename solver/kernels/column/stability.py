"""The longest stable step of central differences."""

import math

from ..formulations.dispatch import evaluate
from ..formulations.exact import STILL
from ..numba_ext.jit import kernel
from ..numba_ext.views import clear
from .assembly import settle

LEAST_COMPRESSION = 1e-6  # m, given to the joints so that they are in contact if gravity does not compress them
PART = 1e-2  # of the rotation that opens a joint: size of finite differences
SQUARINGS = 60  # at most
DIGITS = 1e-13


def scratch_size(n: int) -> int:
    """Length of the scratch that `longest_stable_step` needs for n blocks."""
    return 2 * n * n + n


@kernel
def longest_stable_step(column, scratch):
    """s, of the column in full contact: 2 / (omega (sqrt(1 + d^2) + d)), omega that of the highest mode.

    d = eta omega counts because rates are extrapolated explicitly: a mode x'' + eta omega^2 x' + omega^2 x = 0, stepped
    as in integrators/central_difference.py, reaches the amplification factor -1 where (omega h)^2 / 4 + d omega h = 1.
    Joints that open only become softer.

    At rest rotations and openings are uncoupled: one n x n matrix M^-1 K for each, from central differences of the
    undamped accelerations. `work` is overwritten; n = model.n; scratch: a row.
    """
    model, counts, phase, rest = column.model, column.counts, column.work.start, column.work.end
    blocks = model.blocks
    n = model.n
    matrix, other, damping = scratch, scratch[n * n :], scratch[2 * n * n :]
    evaluations, sweeps = counts.evaluations, counts.sweeps
    clear(rest.row, 6 * n)
    settle(model, rest, LEAST_COMPRESSION)
    tilt = math.inf
    most = 0.0
    for i in range(n):
        most = max(most, blocks.damping[i])
        damping[i] = blocks.damping[i]  # saved: the matrix is that of the undamped column
        blocks.damping[i] = 0.0
        below = rest.opening[i]
        # in the first-order model the coordinates are the settlements of the blocks
        if below > 0.0 and i + 1 < n:
            below -= rest.opening[i + 1]
        tilt = min(tilt, PART * 2.0 * abs(below) / blocks.width[i])
    square = 0.0
    for half in range(2):
        for k in range(n):
            change = tilt * (blocks.turn_size[k] if half == 0 else blocks.open_size[k])
            for side in range(2):
                for i in range(6 * n):
                    phase.row[i] = rest.row[i]
                phase.row[half * n + k] += change if side == 0 else -change
                evaluate(column, phase, STILL)
                accelerations = phase.theta_acceleration if half == 0 else phase.opening_acceleration
                for i in range(n):
                    part = accelerations[i] / (2.0 * change)
                    matrix[n * i + k] = -part if side == 0 else matrix[n * i + k] + part
        square = max(square, _spectral_radius(matrix, other, n))
    for i in range(n):
        blocks.damping[i] = damping[i]
    counts.evaluations, counts.sweeps = evaluations, sweeps
    omega = math.sqrt(square)
    d = omega * most
    return 2.0 / (omega * (math.hypot(1.0, d) + d))


@kernel
def _spectral_radius(matrix, other, n):
    """Largest |eigenvalue| of the n x n matrix in a row; both rows are overwritten.

    The limit of |A^k|^(1/k) (Gelfand 1941), where k doubles with every square.
    """
    logarithm = 0.0
    weight = 1.0
    last = 0.0
    here, there = matrix, other
    for _ in range(SQUARINGS):
        size = 0.0
        for i in range(n * n):
            size = max(size, abs(here[i]))
        if not (size > 0.0 and math.isfinite(size)):
            return math.nan
        logarithm += weight * math.log(size)
        if abs(size - last) <= DIGITS * size:  # one eigenvalue is left: every further squaring gives an equal value
            logarithm += weight * math.log(size)
            break
        last = size
        weight *= 0.5
        for i in range(n):
            for j in range(n):
                there[n * i + j] = 0.0
            for k in range(n):
                factor = here[n * i + k] / size
                for j in range(n):
                    there[n * i + j] += factor * (here[n * k + j] / size)
        here, there = there, here
    return math.exp(logarithm)
