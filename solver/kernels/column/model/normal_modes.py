"""The normal modes of the column about its rest state, all joints in full contact, for the modal method.

M y'' + C y' + K y = -b a is small, symmetric and written in closed form, with the negative stiffness of gravity.
On the axis rotations and openings are uncoupled (theory.md section 4 to second order): there are n modes of rocking
and n of vertical vibration, two problems of n coordinates. Off the axis there is one problem of 2 n coordinates
(theory.md section 12). K is brought to the normal form by the Cholesky factor of M and diagonalized by the cyclic
Jacobi method (Jacobi 1846; G. Golub, C. Van Loan, Matrix Computations, section 8.5).
"""

import math
from typing import NamedTuple

from ...engine.modal_steps import pays, set_limits
from ...layout.modal import inverses_of, limits_of, mode_of, shapes_of
from ...layout.spaces import INTERPOLATION_PART, modal_size
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.views import clear
from .rest import joint_about

# Damping that couples the modes is left to the nonlinear remainder, which is assumed to change little within a step:
# the step times the rate of that damping is at most this.
COUPLED_PART = 0.03

JACOBI_SWEEPS = 60  # at most; six to nine are usual
ROUNDING = 2.0**-54  # relative to the diagonal: a smaller element counts as zero

MATRICES = 4
VECTORS = 6
DASHPOTS = 3


class Scratch(NamedTuple):
    """The scratch rows: matrices of w x w by rows, vectors of w and of n; w = 2 n coordinates, rotations first."""

    masses: object  # M, upper part
    normal: object  # K, then the normal form, then its eigenvalues on the diagonal
    vectors: object  # eigenvectors, one per row
    lower: object  # the Cholesky factor of M
    own_x: object  # displacement of the centroid of a coordinate's own block per unit coordinate
    own_z: object
    far_x: object  # displacement of the centroids of all blocks above
    far_z: object
    push: object  # forces of base ax and az, of 1 m/s2
    lift: object
    along: object  # damping of the joints: by the opening
    twist: object  # damping by opening and rotation
    turning: object  # damping by the rotation of the joint


def scratch_size(n: int) -> int:
    """Return the length of the scratch that `normal_modes` needs for n blocks."""
    return MATRICES * 4 * n * n + VECTORS * 2 * n + DASHPOTS * n


@leaf
def _scratch(row, n):
    # four w x w matrices, six vectors of w, three of n
    w = 2 * n
    m = w * w
    v = row[4 * m :]
    d = v[6 * w :]
    return Scratch(
        row, row[m:], row[2 * m :], row[3 * m :],
        v, v[w:], v[2 * w :], v[3 * w :], v[4 * w :], v[5 * w :],
        d, d[n:], d[2 * n :],
    )  # fmt: skip


@kernel
def normal_modes(model, rest, scratch):
    """Fill model.modal with the modal data listed in spaces.py; return True if there are any that pay.

    There are none without gravity, which leaves the joints open, where a joint is not in full contact at rest or the
    rest is not stable, and where damping couples the modes.

    Parameters
    ----------
    model : space
        The packed model.
    rest : phase
        The rest state of the column.
    scratch : row
        Scratch of `scratch_size` values.

    Returns
    -------
    bool
        Whether the modal method applies and pays.
    """
    n = model.n
    w = 2 * n
    s = _scratch(scratch, n)
    # M, K and damping at rest
    if not model.settings.gravity > 0.0 or not _linear_about(model, rest, s):
        return False
    # on the axis rotations and openings are independent: two groups of modes
    parts = 2 if model.settings.off_axis == 0.0 else 1
    m = w // parts
    limits_of(model).parts = parts
    coupled = 0.0
    damped = False
    fastest = 0.0
    # rocking and vertical vibration one after the other, or both coupled
    for part in range(parts):
        begin = part * m
        if not _normal_form(s, begin, m, w):
            return False
        _diagonalize(s, begin, m, w)
        shapes, inverses = shapes_of(model)[part * m * m :], inverses_of(model)[part * m * m :]
        # shape, participation and size of each mode
        for k in range(m):
            mode = mode_of(model, begin + k)
            least = _next_mode(s, begin, m, w, k)
            square = s.normal[(w + 1) * (begin + least)]
            if not square > 0.0:
                return False
            fastest = max(fastest, square)
            mode.square = square
            _shape(s, begin, m, w, least, k, shapes)
            # participation in base motion along x and z, and largest rotation
            push, lift = 0.0, 0.0
            largest = 0.0
            for i in range(m):
                part_of, at = shapes[m * i + k], begin + i
                push -= part_of * s.push[at]
                lift -= part_of * s.lift[at]
                size = 1.0 if at < n else model.blocks.open_size[at - n]
                largest = max(largest, abs(part_of) / size)
            mode.push = push
            mode.lift = lift
            mode.across = 0.0
            mode.size = largest
        # inverse of the shapes: Phi' M
        for k in range(m):
            for j in range(m):
                product = 0.0
                for i in range(m):
                    product += shapes[m * i + k] * s.masses[_upper(begin + i, begin + j, w)]
                inverses[m * k + j] = product
        # damping of each mode, and its coupling to others
        for k in range(m):
            across = 0.0
            for j in range(m):
                rate = _modal_damping(s, n, begin, m, shapes, j, k)
                if j == k:
                    mode_of(model, begin + k).damping = rate
                    damped = damped or rate != 0.0
                else:
                    across += abs(rate)
            coupled = max(coupled, across)
    # limits of the step of the modal method
    limits = limits_of(model)
    longest = COUPLED_PART / max(coupled, 1e-300)
    set_limits(limits, model.settings.tolerance, INTERPOLATION_PART, longest, damped)
    # modes that exceed the range of float64 are not used
    for i in range(modal_size(n)):
        if not math.isfinite(model.modal[i]):
            return False
    return pays(limits, fastest)


@leaf
def _upper(i, j, w):
    """Return the index of element (i, j) of a symmetric matrix whose upper part is stored."""
    return w * i + j if i <= j else w * j + i


@leaf
def _add(matrix, w, i, j, value):
    """Add to elements (i, j) and (j, i) of a matrix by rows."""
    matrix[w * i + j] += value
    if i != j:
        matrix[w * j + i] += value


@kernel
def _linear_about(model, rest, s):
    """Fill in M (upper part), K, joint dashpots and forces of the base; return True if all joints are in full contact.

    K in N m/rad, N and N/m; the forces are those of base accelerations of 1 m/s2.
    """
    n, blocks, gravity = model.n, model.blocks, model.settings.gravity
    w = 2 * n
    clear(s.normal, w * w)
    carried = 0.0
    # K: each joint couples its opening and the rotations of both blocks
    for i in range(n):
        lever = gravity * (carried * blocks.height[i] + blocks.mass[i] * blocks.centroid[i])
        carried += blocks.mass[i]
        joint = joint_about(model, rest, i, carried)
        if not joint.is_full:
            return False
        turn, opening = i, n + i
        # stiffness of the opening, and of the rotation of the block above
        _add(s.normal, w, opening, opening, joint.along)
        _add(s.normal, w, turn, opening, joint.twist - 0.5 * joint.across)
        _add(s.normal, w, turn, turn, joint.turning + joint.spread - lever * math.cos(rest.theta[i] + blocks.tilt[i]))
        # stiffness of the rotation of the block below
        if i + 1 < n:
            _add(s.normal, w, turn + 1, opening, -joint.twist - 0.5 * joint.across)
            _add(s.normal, w, turn + 1, turn + 1, joint.turning + joint.spread)
            _add(s.normal, w, turn, turn + 1, joint.spread - joint.turning)
        # damping: eta times the elastic stiffness
        eta = blocks.damping[i]
        s.along[i], s.twist[i], s.turning[i] = eta * joint.along, eta * joint.twist, eta * joint.elastic
    # M and the forces of the base, by the displacements of the centroids
    _moved(model, rest, s)
    above = 0.0
    for block in range(n):  # rows of its rotation and opening; columns of the block and of those below
        own = blocks.mass[block]
        # forces of unit base accelerations on this coordinate
        for at in (block, n + block):
            s.push[at] = own * s.own_x[at] + above * s.far_x[at]
            s.lift[at] = own * s.own_z[at] + above * s.far_z[at]
            # row of the mass matrix
            for other in range(w):
                lower = other % n
                if lower > block:
                    mass = s.push[at] * s.far_x[other] + s.lift[at] * s.far_z[other]
                elif lower == block:
                    mass = own * (s.own_x[at] * s.own_x[other] + s.own_z[at] * s.own_z[other])
                    mass += above * (s.far_x[at] * s.far_x[other] + s.far_z[at] * s.far_z[other])
                    mass += blocks.inertia[block] if at == other == block else 0.0
                else:
                    continue
                s.masses[_upper(at, other, w)] = mass
        above += own
    return True


@kernel
def _moved(model, rest, s):
    """Fill in displacements per unit of each coordinate: of the centroids of its own block and of all blocks above."""
    n, blocks = model.n, model.blocks
    arm_x, arm_z = 0.0, 0.0  # contributions of half the rotation of the joint above
    for i in range(n):
        below = rest.theta[i + 1] if i + 1 < n else 0.0
        # the joint: its opening turned by phi
        phi = 0.5 * (rest.theta[i] + below) + blocks.lean[i]
        sine, cosine = math.sin(phi), math.cos(phi)
        opening, slip = rest.opening[i], rest.slip[i]
        turned_x = 0.5 * (opening * cosine - slip * sine)
        turned_z = -0.5 * (opening * sine + slip * cosine)
        # the block
        direction = rest.theta[i] + blocks.tilt[i]
        level, fall = math.cos(direction), -math.sin(direction)
        s.own_x[i], s.own_z[i] = turned_x + blocks.centroid[i] * level, turned_z + blocks.centroid[i] * fall
        s.far_x[i] = arm_x + turned_x + blocks.height[i] * level
        s.far_z[i] = arm_z + turned_z + blocks.height[i] * fall
        # unit opening: displacement along the normal of the joint
        s.own_x[n + i], s.own_z[n + i] = sine, cosine
        s.far_x[n + i], s.far_z[n + i] = sine, cosine
        # the rotation of the block below turns the joint by half as well
        arm_x, arm_z = turned_x, turned_z


@kernel
def _normal_form(s, begin, m, w):
    """Replace K by L^-1 K L^-T, with M = L L'; return True if M is positive definite.

    L is left below and on the diagonal of `lower`. Here and below only the m coordinates from `begin` on are used.
    """
    low, a, masses = s.lower[(w + 1) * begin :], s.normal[(w + 1) * begin :], s.masses[(w + 1) * begin :]
    # Cholesky factor of M
    for i in range(m):
        for j in range(i + 1):
            rest = masses[w * j + i]
            for k in range(j):
                rest -= low[w * i + k] * low[w * j + k]
            if i > j:
                low[w * i + j] = rest / low[w * j + j]
            else:
                if not rest > 0.0:  # ratio of the masses too large for float64
                    return False
                low[w * i + i] = math.sqrt(rest)
    for _ in range(2):  # K becomes (L^-1 K)', twice: K is symmetric
        for j in range(m):
            for i in range(m):
                rest = a[w * i + j]
                for k in range(i):
                    rest -= low[w * i + k] * a[w * k + j]
                a[w * i + j] = rest / low[w * i + i]
        for i in range(m):
            for j in range(i):
                a[w * i + j], a[w * j + i] = a[w * j + i], a[w * i + j]
    # make K symmetric to the last bit
    for i in range(m):
        for j in range(i):
            mean = 0.5 * (a[w * i + j] + a[w * j + i])
            a[w * i + j] = mean
            a[w * j + i] = mean
    return True


@kernel
def _diagonalize(s, begin, m, w):
    """Rotate `normal` until its eigenvalues are on its diagonal; row k of `vectors` is eigenvector k."""
    a, v = s.normal[(w + 1) * begin :], s.vectors[(w + 1) * begin :]
    # begin with the unit matrix
    for i in range(m):
        for j in range(m):
            v[w * i + j] = 1.0 if i == j else 0.0
    for _ in range(JACOBI_SWEEPS):
        turned = False
        # one sweep of Jacobi rotations over all pairs (p, q)
        for p in range(m):
            for q in range(p + 1, m):
                beside = a[w * p + q]
                first, second = a[w * p + p], a[w * q + q]
                if not abs(beside) > ROUNDING * math.sqrt(abs(first * second)):
                    continue
                turned = True
                # the rotation that makes element (p, q) zero
                slope = 0.5 * (second - first) / beside
                tangent = 1.0 / (abs(slope) + math.sqrt(1.0 + slope * slope))
                if slope < 0.0:
                    tangent = -tangent
                cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
                sine = tangent * cosine
                # rows of the matrix and of the vectors
                for k in range(m):
                    x, y = a[w * p + k], a[w * q + k]
                    a[w * p + k] = cosine * x - sine * y
                    a[w * q + k] = sine * x + cosine * y
                    x, y = v[w * p + k], v[w * q + k]
                    v[w * p + k] = cosine * x - sine * y
                    v[w * q + k] = sine * x + cosine * y
                # columns by symmetry, and the 2 x 2 in closed form
                for k in range(m):
                    a[w * k + p] = a[w * p + k]
                    a[w * k + q] = a[w * q + k]
                a[w * p + p] = first - tangent * beside
                a[w * q + q] = second + tangent * beside
                a[w * p + q] = 0.0
                a[w * q + p] = 0.0
        if not turned:
            return


@kernel
def _next_mode(s, begin, m, w, k):
    """Return the index of the row of `vectors` that holds mode k, counted from the slowest."""
    a = s.normal[(w + 1) * begin :]
    for i in range(m):
        square = a[w * i + i]
        # rank of the eigenvalue; equal ones by their index
        before = 0
        for j in range(m):
            other = a[w * j + j]
            if other < square or (other == square and j < i):
                before += 1
        if before == k:
            return i
    return k  # a value is NaN


@kernel
def _shape(s, begin, m, w, vector, k, shapes):
    """Fill column k of the shapes with L^-T times a vector: a mode of unit modal mass."""
    low, v = s.lower[(w + 1) * begin :], s.vectors[(w + 1) * begin :]
    # back substitution by the transposed Cholesky factor
    for i in range(m - 1, -1, -1):
        rest = v[w * vector + i]
        for j in range(i + 1, m):
            rest -= low[w * j + i] * shapes[m * j + k]
        shapes[m * i + k] = rest / low[w * i + i]


@kernel
def _modal_damping(s, n, begin, m, shapes, j, k):
    """Return element (j, k) of Phi' C Phi (1/s); C acts on the opening and on the rotation of a joint."""
    product = 0.0
    for i in range(n):
        turn_j, turn_k, opening_j, opening_k = 0.0, 0.0, 0.0, 0.0
        # rotations are the first n coordinates, openings the others
        if begin == 0:
            turn_j, turn_k = shapes[m * i + j], shapes[m * i + k]
            if i + 1 < n:
                turn_j -= shapes[m * (i + 1) + j]
                turn_k -= shapes[m * (i + 1) + k]
        if begin + m > n:
            at = n + i - begin
            opening_j, opening_k = shapes[m * at + j], shapes[m * at + k]
        # dashpots of rotation, opening and both
        product += s.turning[i] * turn_j * turn_k + s.along[i] * opening_j * opening_k
        product += s.twist[i] * (turn_j * opening_k + opening_j * turn_k)
    return product
