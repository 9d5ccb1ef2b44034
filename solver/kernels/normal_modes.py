"""Normal modes of the column about its rest state, all joints in full contact, as the modal method wants them.

At rest rotations and openings do not act on each other (theory.md section 4 to second order), so that there are n modes
of rocking and n of vertical vibration. Both problems M y'' + C y' + K y = -b a are small, symmetric and written down in
closed form, the negative stiffness of gravity included. K is brought to the normal form by the Cholesky factor of M and
diagonalized by the cyclic Jacobi method (Jacobi 1846; G. Golub, C. Van Loan, Matrix Computations, section 8.5).
"""

import math

from .jit import entry, kernel, leaf
from .layout import (
    BLOCK_FIELDS,
    CENTROID,
    DAMPING,
    GRAVITY,
    HEIGHT,
    INERTIA,
    INTERPOLATION_BOUND,
    INTERPOLATION_PART,
    JOINT_DEPTH,
    JOINT_WIDTH,
    MASS,
    MODAL_HEADER,
    MODAL_LONGEST,
    MODAL_MOST,
    MODAL_SWEEPS,
    MODAL_THIRD,
    MODE_DAMPING,
    MODE_FIELDS,
    MODE_PUSH,
    MODE_SIZE,
    MODE_SQUARE,
    MODEL_HEADER,
    N_BLOCKS,
    OPEN_SIZE,
    STIFFNESS,
    TOLERANCE,
    TURN_SIZE,
)

# Damping that couples the modes is left to the nonlinear remainder, which a step takes to change little within it: the
# step times the rate of that damping is at most this.
COUPLED_PART = 0.03
LEAST_TURN = 10.0  # rad of the fastest mode in such a step: with fewer the general methods do as well

# Third over second difference of a remainder that varies as fast as twice the fastest motion resolved, for one radian
# of the latter per step: the third of sin(2 x s) is (2 x)^3 / (72 sqrt 3), the second (2 x)^2 / 8.
THIRD_DIFFERENCE = 2.0 * 8.0 / (72.0 * math.sqrt(3.0))

JACOBI_SWEEPS = 60  # at most; six to nine are usual
ROUNDING = 2.0**-54  # of the diagonal: an element below it is none

# scratch: n x n matrices by rows, then fields of n numbers each
MASSES = 0
NORMAL = 1  # K, then the normal form, then its eigenvalues on the diagonal
VECTORS = 2  # one a row
SWAY = 3
MATRICES = 4
PUSH = 0
DASHPOT = 1  # of the joints, against the coordinates of this half
VECTOR_FIELDS = 2


def scratch_size(n: int) -> int:
    """Length of the scratch that `normal_modes` needs for n blocks."""
    return MATRICES * n * n + VECTOR_FIELDS * n


@kernel
def normal_modes(model, data, begin, scratch):
    """Fill data[begin:] with what layout.py lists as modal data; whether there is any.

    There is none without gravity, which leaves the joints open, where the rest state is not stable, where damping
    couples the modes, and for more than MODAL_MOST blocks.
    """
    n = int(model[N_BLOCKS])
    if n > MODAL_MOST or not model[GRAVITY] > 0.0:
        return False
    coupled = 0.0
    damped = False
    fastest = 0.0
    for half in range(2):
        if half == 0:
            _rotations(model, scratch, n)
        else:
            _openings(model, scratch, n)
        if not _normal_form(scratch, n):
            return False
        _diagonalize(scratch, n)
        modes = begin + MODAL_HEADER + half * n * MODE_FIELDS
        shapes = begin + MODAL_HEADER + 2 * n * MODE_FIELDS + half * n * n
        for k in range(n):
            mode = modes + MODE_FIELDS * k
            least = _next_mode(scratch, n, k)
            square = scratch[NORMAL * n * n + least * n + least]
            if not square > 0.0:
                return False
            fastest = max(fastest, square)
            data[mode + MODE_SQUARE] = square
            _shape(scratch, n, least, k, data, shapes)
            push = 0.0
            largest = 0.0
            for i in range(n):
                row = MODEL_HEADER + BLOCK_FIELDS * i
                part = data[shapes + n * i + k]
                push -= part * scratch[MATRICES * n * n + PUSH * n + i]
                largest = max(largest, abs(part) / model[row + (TURN_SIZE if half == 0 else OPEN_SIZE)])
            data[mode + MODE_PUSH] = push
            data[mode + MODE_SIZE] = largest
        inverses = shapes + 2 * n * n
        for k in range(n):
            for j in range(n):
                product = 0.0
                for i in range(n):
                    product += data[shapes + n * i + k] * scratch[MASSES * n * n + _upper(i, j, n)]
                data[inverses + n * k + j] = product
        for k in range(n):
            across = 0.0
            for j in range(n):
                rate = _modal_damping(scratch, n, half, data, shapes, j, k)
                if j == k:
                    data[modes + MODE_FIELDS * k + MODE_DAMPING] = rate
                    damped = damped or rate != 0.0
                else:
                    across += abs(rate)
            coupled = max(coupled, across)
    resolved = (INTERPOLATION_BOUND * INTERPOLATION_PART * model[TOLERANCE]) ** (1.0 / 6.0)
    data[begin + MODAL_THIRD] = min(1.0, THIRD_DIFFERENCE * resolved)
    data[begin + MODAL_LONGEST] = COUPLED_PART / max(coupled, 1e-300)
    data[begin + MODAL_SWEEPS] = 1.0 if damped else 2.0
    for i in range(MODAL_HEADER + 2 * n * MODE_FIELDS + 4 * n * n):
        if not math.isfinite(data[begin + i]):
            return False
    return data[begin + MODAL_LONGEST] * math.sqrt(fastest) >= LEAST_TURN


@leaf
def _upper(i, j, n):
    """Place of element (i, j) of a symmetric matrix of which the upper part is kept."""
    return n * i + j if i <= j else n * j + i


@kernel
def _rotations(model, scratch, n):
    """M (upper part) and K of the rotations, what base_ax pushes them by, and the joints' dashpots."""
    size = n * n
    fields = MATRICES * size
    carried = 0.0
    opening_above = 0.0
    carried_opening_above = 0.0  # opening times mass carried, of the joint above
    turning_above = 0.0
    for j in range(n):
        row = MODEL_HEADER + BLOCK_FIELDS * j
        width = model[row + JOINT_WIDTH]
        spring = model[row + STIFFNESS] * width * model[row + JOINT_DEPTH]
        turning = spring * (width * width) / 12.0
        above = carried
        carried += model[row + MASS]
        opening = -model[GRAVITY] * carried / spring
        scratch[fields + DASHPOT * n + j] = model[row + DAMPING] * turning
        # horizontal displacement of centroid i for a unit rotation of block j
        for i in range(n):
            sway = 0.0
            if j > i:
                sway = model[row + HEIGHT] + 0.5 * (opening + opening_above)
            elif j == i:
                sway = model[row + CENTROID] + 0.5 * opening
            scratch[SWAY * size + n * i + j] = sway
        for i in range(n):
            scratch[NORMAL * size + n * j + i] = 0.0
        lowered = 0.25 * (carried_opening_above + opening * carried)
        lowered += model[row + MASS] * model[row + CENTROID] + model[row + HEIGHT] * above
        scratch[NORMAL * size + n * j + j] = turning + turning_above - model[GRAVITY] * lowered
        if j > 0:
            beside = -turning_above - model[GRAVITY] * (0.25 * carried_opening_above)
            scratch[NORMAL * size + n * j + j - 1] = beside
            scratch[NORMAL * size + n * (j - 1) + j] = beside
        opening_above, carried_opening_above, turning_above = opening, opening * carried, turning
    for j in range(n):
        push = 0.0
        for i in range(j + 1):
            push += model[MODEL_HEADER + BLOCK_FIELDS * i + MASS] * scratch[SWAY * size + n * i + j]
        scratch[fields + PUSH * n + j] = push
        for k in range(j, n):
            mass = model[MODEL_HEADER + BLOCK_FIELDS * j + INERTIA] if j == k else 0.0
            for i in range(j + 1):
                part = model[MODEL_HEADER + BLOCK_FIELDS * i + MASS] * scratch[SWAY * size + n * i + j]
                mass += part * scratch[SWAY * size + n * i + k]
            scratch[MASSES * size + n * j + k] = mass


@kernel
def _openings(model, scratch, n):
    """The same of the openings, under base_az + g; K and C are diagonal."""
    size = n * n
    fields = MATRICES * size
    carried = 0.0
    for j in range(n):
        row = MODEL_HEADER + BLOCK_FIELDS * j
        spring = model[row + STIFFNESS] * model[row + JOINT_WIDTH] * model[row + JOINT_DEPTH]
        carried += model[row + MASS]
        scratch[fields + DASHPOT * n + j] = model[row + DAMPING] * spring
        scratch[fields + PUSH * n + j] = carried
        for k in range(n):
            scratch[NORMAL * size + n * j + k] = spring if j == k else 0.0
            scratch[MASSES * size + n * j + k] = carried  # of the upper of the two joints


@kernel
def _normal_form(scratch, n):
    """K becomes L^-1 K L^-T, with M = L L'; L is left below and on the diagonal of SWAY. Whether M is positive."""
    size = n * n
    low, a = SWAY * size, NORMAL * size
    for i in range(n):
        for j in range(i + 1):
            rest = scratch[MASSES * size + n * j + i]
            for k in range(j):
                rest -= scratch[low + n * i + k] * scratch[low + n * j + k]
            if i > j:
                scratch[low + n * i + j] = rest / scratch[low + n * j + j]
            else:
                if not rest > 0.0:  # masses too far apart for float64
                    return False
                scratch[low + n * i + i] = math.sqrt(rest)
    for _ in range(2):  # L^-1 K, transposed, and again: K is symmetric
        for j in range(n):
            for i in range(n):
                rest = scratch[a + n * i + j]
                for k in range(i):
                    rest -= scratch[low + n * i + k] * scratch[a + n * k + j]
                scratch[a + n * i + j] = rest / scratch[low + n * i + i]
        for i in range(n):
            for j in range(i):
                here, there = a + n * i + j, a + n * j + i
                scratch[here], scratch[there] = scratch[there], scratch[here]
    for i in range(n):
        for j in range(i):
            mean = 0.5 * (scratch[a + n * i + j] + scratch[a + n * j + i])
            scratch[a + n * i + j] = mean
            scratch[a + n * j + i] = mean
    return True


@kernel
def _diagonalize(scratch, n):
    """Rotate NORMAL until its eigenvalues are on its diagonal; row k of VECTORS is the vector that belongs to k."""
    a, v = NORMAL * n * n, VECTORS * n * n
    for i in range(n):
        for j in range(n):
            scratch[v + n * i + j] = 1.0 if i == j else 0.0
    for _ in range(JACOBI_SWEEPS):
        turned = False
        for p in range(n):
            for q in range(p + 1, n):
                beside = scratch[a + n * p + q]
                first, second = scratch[a + n * p + p], scratch[a + n * q + q]
                if not abs(beside) > ROUNDING * math.sqrt(abs(first * second)):
                    continue
                turned = True
                slope = 0.5 * (second - first) / beside
                tangent = 1.0 / (abs(slope) + math.sqrt(1.0 + slope * slope))
                if slope < 0.0:
                    tangent = -tangent
                cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
                sine = tangent * cosine
                for k in range(n):
                    x, y = scratch[a + n * p + k], scratch[a + n * q + k]
                    scratch[a + n * p + k] = cosine * x - sine * y
                    scratch[a + n * q + k] = sine * x + cosine * y
                    x, y = scratch[v + n * p + k], scratch[v + n * q + k]
                    scratch[v + n * p + k] = cosine * x - sine * y
                    scratch[v + n * q + k] = sine * x + cosine * y
                for k in range(n):
                    scratch[a + n * k + p] = scratch[a + n * p + k]
                    scratch[a + n * k + q] = scratch[a + n * q + k]
                scratch[a + n * p + p] = first - tangent * beside
                scratch[a + n * q + q] = second + tangent * beside
                scratch[a + n * p + q] = 0.0
                scratch[a + n * q + p] = 0.0
        if not turned:
            return


@kernel
def _next_mode(scratch, n, k):
    """Which row of VECTORS holds mode k, counted from the slowest."""
    a = NORMAL * n * n
    for i in range(n):
        square = scratch[a + n * i + i]
        before = 0
        for j in range(n):
            other = scratch[a + n * j + j]
            if other < square or (other == square and j < i):
                before += 1
        if before == k:
            return i
    return k  # where something is not a number


@kernel
def _shape(scratch, n, vector, k, data, shapes):
    """Column k of the shapes: L^-T times a vector, of unit modal mass."""
    low, v = SWAY * n * n, VECTORS * n * n + n * vector
    for i in range(n - 1, -1, -1):
        rest = scratch[v + i]
        for j in range(i + 1, n):
            rest -= scratch[low + n * j + i] * data[shapes + n * j + k]
        data[shapes + n * i + k] = rest / scratch[low + n * i + i]


@kernel
def _modal_damping(scratch, n, half, data, shapes, j, k):
    """Element (j, k) of Phi' C Phi, 1/s: C acts on the difference of rotations across a joint, or on its opening."""
    dashpots = MATRICES * n * n + DASHPOT * n
    product = 0.0
    for i in range(n):
        x, y = data[shapes + n * i + j], data[shapes + n * i + k]
        if half == 0 and i + 1 < n:
            x -= data[shapes + n * (i + 1) + j]
            y -= data[shapes + n * (i + 1) + k]
        product += scratch[dashpots + i] * x * y
    return product


@entry
def find_normal_modes(model, data, scratch):
    """`normal_modes` as called from Python."""
    return normal_modes(model, data, 0, scratch)
