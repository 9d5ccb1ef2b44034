"""Normal modes of the column about its rest state, all joints in full contact, as the modal method wants them.

At rest rotations and openings do not act on each other (theory.md section 4 to second order), so that there are n modes
of rocking and n of vertical vibration. Both problems M y'' + C y' + K y = -b a are small, symmetric and written down in
closed form, the negative stiffness of gravity included. K is brought to the normal form by the Cholesky factor of M and
diagonalized by the cyclic Jacobi method (Jacobi 1846; G. Golub, C. Van Loan, Matrix Computations, section 8.5).
"""

import math
from typing import NamedTuple

from ..jit import kernel, leaf
from ..joint.section import full_stiffness, full_turning_stiffness
from ..layout import INTERPOLATION_BOUND, INTERPOLATION_PART, MODAL_MOST, modal_size
from ..modes import inverses_of, limits_of, mode_of, shapes_of

# Damping that couples the modes is left to the nonlinear remainder, which a step takes to change little within it: the
# step times the rate of that damping is at most this.
COUPLED_PART = 0.03
LEAST_TURN = 10.0  # rad of the fastest mode in such a step: with fewer the general methods do as well

# Third over second difference of a remainder that varies as fast as twice the fastest motion resolved, for one radian
# of the latter per step: the third of sin(2 x s) is (2 x)^3 / (72 sqrt 3), the second (2 x)^2 / 8.
THIRD_DIFFERENCE = 2.0 * 8.0 / (72.0 * math.sqrt(3.0))

JACOBI_SWEEPS = 60  # at most; six to nine are usual
ROUNDING = 2.0**-54  # of the diagonal: an element below it is none

MATRICES = 4
VECTORS = 2


class Scratch(NamedTuple):
    """Rows: n x n matrices by rows, then vectors of n."""

    masses: object  # M, upper part
    normal: object  # K, then the normal form, then its eigenvalues on the diagonal
    vectors: object  # one a row
    lower: object  # sway of the centroids, then the Cholesky factor of M
    push: object
    dashpots: object  # of the joints, against the coordinates of this half


def scratch_size(n: int) -> int:
    """Length of the scratch that `normal_modes` needs for n blocks."""
    return MATRICES * n * n + VECTORS * n


@leaf
def _scratch(row, n):
    m = n * n
    return Scratch(row, row[m:], row[2 * m :], row[3 * m :], row[4 * m :], row[4 * m + n :])


@kernel
def normal_modes(model, scratch):
    """Fill model.modal with what layout.py lists as modal data; whether there is any. scratch: a row.

    There is none without gravity, which leaves the joints open, where the rest state is not stable, where damping
    couples the modes, and for more than MODAL_MOST blocks.
    """
    n = model.n
    if n > MODAL_MOST or not model.settings.gravity > 0.0:
        return False
    s = _scratch(scratch, n)
    coupled = 0.0
    damped = False
    fastest = 0.0
    for half in range(2):
        if half == 0:
            _rotations(model, s)
        else:
            _openings(model, s)
        if not _normal_form(s, n):
            return False
        _diagonalize(s, n)
        shapes, inverses = shapes_of(model)[half * n * n :], inverses_of(model)[half * n * n :]
        for k in range(n):
            mode = mode_of(model, half * n + k)
            least = _next_mode(s, n, k)
            square = s.normal[n * least + least]
            if not square > 0.0:
                return False
            fastest = max(fastest, square)
            mode.square = square
            _shape(s, n, least, k, shapes)
            push = 0.0
            largest = 0.0
            for i in range(n):
                part = shapes[n * i + k]
                push -= part * s.push[i]
                size = model.blocks.turn_size[i] if half == 0 else model.blocks.open_size[i]
                largest = max(largest, abs(part) / size)
            mode.push = push
            mode.size = largest
        for k in range(n):
            for j in range(n):
                product = 0.0
                for i in range(n):
                    product += shapes[n * i + k] * s.masses[_upper(i, j, n)]
                inverses[n * k + j] = product
        for k in range(n):
            across = 0.0
            for j in range(n):
                rate = _modal_damping(s, n, half, shapes, j, k)
                if j == k:
                    mode_of(model, half * n + k).damping = rate
                    damped = damped or rate != 0.0
                else:
                    across += abs(rate)
            coupled = max(coupled, across)
    limits = limits_of(model)
    resolved = (INTERPOLATION_BOUND * INTERPOLATION_PART * model.settings.tolerance) ** (1.0 / 6.0)
    limits.third = min(1.0, THIRD_DIFFERENCE * resolved)
    limits.longest = COUPLED_PART / max(coupled, 1e-300)
    limits.sweeps = 1.0 if damped else 2.0
    for i in range(modal_size(n)):
        if not math.isfinite(model.modal[i]):
            return False
    return limits.longest * math.sqrt(fastest) >= LEAST_TURN


@leaf
def _upper(i, j, n):
    """Place of element (i, j) of a symmetric matrix of which the upper part is kept."""
    return n * i + j if i <= j else n * j + i


@kernel
def _rotations(model, s):
    """M (upper part) and K of the rotations, what base ax pushes them by, and the joints' dashpots."""
    n, blocks, gravity = model.n, model.blocks, model.settings.gravity
    sway = s.lower
    carried = 0.0
    opening_above = 0.0
    carried_opening_above = 0.0  # opening times mass carried, of the joint above
    turning_above = 0.0
    for j in range(n):
        spring, turning = full_stiffness(blocks, j), full_turning_stiffness(blocks, j)
        above = carried
        carried += blocks.mass[j]
        opening = -gravity * carried / spring
        s.dashpots[j] = blocks.damping[j] * turning
        # horizontal displacement of centroid i for a unit rotation of block j
        for i in range(n):
            value = 0.0
            if j > i:
                value = blocks.height[j] + 0.5 * (opening + opening_above)
            elif j == i:
                value = blocks.centroid[j] + 0.5 * opening
            sway[n * i + j] = value
        for i in range(n):
            s.normal[n * j + i] = 0.0
        lowered = 0.25 * (carried_opening_above + opening * carried)
        lowered += blocks.mass[j] * blocks.centroid[j] + blocks.height[j] * above
        s.normal[n * j + j] = turning + turning_above - gravity * lowered
        if j > 0:
            beside = -turning_above - gravity * (0.25 * carried_opening_above)
            s.normal[n * j + j - 1] = beside
            s.normal[n * (j - 1) + j] = beside
        opening_above, carried_opening_above, turning_above = opening, opening * carried, turning
    for j in range(n):
        push = 0.0
        for i in range(j + 1):
            push += blocks.mass[i] * sway[n * i + j]
        s.push[j] = push
        for k in range(j, n):
            mass = blocks.inertia[j] if j == k else 0.0
            for i in range(j + 1):
                mass += blocks.mass[i] * sway[n * i + j] * sway[n * i + k]
            s.masses[n * j + k] = mass


@kernel
def _openings(model, s):
    """The same of the openings, under base az + g; K and C are diagonal."""
    n, blocks = model.n, model.blocks
    carried = 0.0
    for j in range(n):
        spring = full_stiffness(blocks, j)
        carried += blocks.mass[j]
        s.dashpots[j] = blocks.damping[j] * spring
        s.push[j] = carried
        for k in range(n):
            s.normal[n * j + k] = spring if j == k else 0.0
            s.masses[n * j + k] = carried  # of the upper of the two joints


@kernel
def _normal_form(s, n):
    """K becomes L^-1 K L^-T, with M = L L'; L is left below and on the diagonal of `lower`. Whether M is positive."""
    low, a = s.lower, s.normal
    for i in range(n):
        for j in range(i + 1):
            rest = s.masses[n * j + i]
            for k in range(j):
                rest -= low[n * i + k] * low[n * j + k]
            if i > j:
                low[n * i + j] = rest / low[n * j + j]
            else:
                if not rest > 0.0:  # masses too far apart for float64
                    return False
                low[n * i + i] = math.sqrt(rest)
    for _ in range(2):  # L^-1 K, transposed, and again: K is symmetric
        for j in range(n):
            for i in range(n):
                rest = a[n * i + j]
                for k in range(i):
                    rest -= low[n * i + k] * a[n * k + j]
                a[n * i + j] = rest / low[n * i + i]
        for i in range(n):
            for j in range(i):
                a[n * i + j], a[n * j + i] = a[n * j + i], a[n * i + j]
    for i in range(n):
        for j in range(i):
            mean = 0.5 * (a[n * i + j] + a[n * j + i])
            a[n * i + j] = mean
            a[n * j + i] = mean
    return True


@kernel
def _diagonalize(s, n):
    """Rotate `normal` until its eigenvalues are on its diagonal; row k of `vectors` is the vector that belongs to k."""
    a, v = s.normal, s.vectors
    for i in range(n):
        for j in range(n):
            v[n * i + j] = 1.0 if i == j else 0.0
    for _ in range(JACOBI_SWEEPS):
        turned = False
        for p in range(n):
            for q in range(p + 1, n):
                beside = a[n * p + q]
                first, second = a[n * p + p], a[n * q + q]
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
                    x, y = a[n * p + k], a[n * q + k]
                    a[n * p + k] = cosine * x - sine * y
                    a[n * q + k] = sine * x + cosine * y
                    x, y = v[n * p + k], v[n * q + k]
                    v[n * p + k] = cosine * x - sine * y
                    v[n * q + k] = sine * x + cosine * y
                for k in range(n):
                    a[n * k + p] = a[n * p + k]
                    a[n * k + q] = a[n * q + k]
                a[n * p + p] = first - tangent * beside
                a[n * q + q] = second + tangent * beside
                a[n * p + q] = 0.0
                a[n * q + p] = 0.0
        if not turned:
            return


@kernel
def _next_mode(s, n, k):
    """Which row of `vectors` holds mode k, counted from the slowest."""
    for i in range(n):
        square = s.normal[n * i + i]
        before = 0
        for j in range(n):
            other = s.normal[n * j + j]
            if other < square or (other == square and j < i):
                before += 1
        if before == k:
            return i
    return k  # where something is not a number


@kernel
def _shape(s, n, vector, k, shapes):
    """Column k of the shapes: L^-T times a vector, of unit modal mass."""
    for i in range(n - 1, -1, -1):
        rest = s.vectors[n * vector + i]
        for j in range(i + 1, n):
            rest -= s.lower[n * j + i] * shapes[n * j + k]
        shapes[n * i + k] = rest / s.lower[n * i + i]


@kernel
def _modal_damping(s, n, half, shapes, j, k):
    """Element (j, k) of Phi' C Phi, 1/s: C acts on the difference of rotations across a joint, or on its opening."""
    product = 0.0
    for i in range(n):
        x, y = shapes[n * i + j], shapes[n * i + k]
        if half == 0 and i + 1 < n:
            x -= shapes[n * (i + 1) + j]
            y -= shapes[n * (i + 1) + k]
        product += s.dashpots[i] * x * y
    return product
