"""A base that rotates about x and y, under a structure in space (theory.md section 15).

The equations remain relative to the base, whose axes rotate with it: inertial forces of rotating axes act on the
bodies. The rotation is a vector of two components, rad; omega and alpha are its first and second derivatives: for a
rotation about one axis its angular velocity and acceleration, otherwise up to the square of the angle. It is about the
origin of the structure, whose acceleration is the base acceleration. Not used in lanes (extras.py).
"""

import math

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import index_of
from .contact import stretches_in
from .kinematics import cross, minus, momentum, plus, push, rotation_vector, seen_from, spin_of, standing
from .layout import OF_BASE, OF_PORT, PHASE
from .sides import place_of

# coefficients c_k of f(s) = sin(a/2) / a = sum of c_k s^k, s = a^2; exact to rounding for angles a up to 3 rad
SERIES = tuple((-1.0) ** k / (2.0 ** (2 * k + 1) * math.factorial(2 * k + 1)) for k in range(14))
MOST_TURN = 3.0  # rad

_PER_BODY = PHASE.per_n


@leaf
def is_turned(base):
    """Return True if the base is rotated or rotating."""
    along = base.theta_y != 0.0 or base.omega_y != 0.0 or base.alpha_y != 0.0 or base.jalpha_y != 0.0
    return along or is_turned_across(base)


@leaf
def is_turned_across(base):
    """Return True if the base is rotated or rotating about the axis x."""
    return base.theta_x != 0.0 or base.omega_x != 0.0 or base.alpha_x != 0.0 or base.jalpha_x != 0.0


@leaf
def rotation_at(base, t):
    """Return (theta_x, theta_y, omega_x, omega_y) of the base at time t, rad and rad/s."""
    past = t - base.t0
    # the angular acceleration is linear in time
    half, sixth = 0.5 * past, past * past / 6.0
    x = base.theta_x + past * (base.omega_x + half * base.alpha_x + sixth * base.jalpha_x)
    y = base.theta_y + past * (base.omega_y + half * base.alpha_y + sixth * base.jalpha_y)
    spin_x = base.omega_x + past * (base.alpha_x + half * base.jalpha_x)
    return x, y, spin_x, base.omega_y + past * (base.alpha_y + half * base.jalpha_y)


@kernel
def _curve(x, y, u, v, a, b):
    """Return the quaternion of a rotation vector (x, y, 0), and its first two derivatives.

    (u, v), (a, b): first and second derivative of (x, y). The vector of the quaternion is f(s) (x, y, 0) with s the
    square of the angle, and its scalar has the derivative -f/4 by s.
    """
    s, f, f1, f2 = x * x + y * y, 0.0, 0.0, 0.0
    # Horner's scheme for f and its derivatives by s
    for k in range(len(SERIES)):
        f2 = f2 * s + 2.0 * f1
        f1 = f1 * s + f
        f = f * s + SERIES[len(SERIES) - 1 - k]
    # derivatives of s and f by time
    s1, s2 = 2.0 * (x * u + y * v), 2.0 * (u * u + v * v + x * a + y * b)
    to, bends = f1 * s1, f2 * s1 * s1 + f1 * s2
    # the quaternion and its derivatives
    q = math.cos(0.5 * math.sqrt(s)), f * x, f * y, 0.0
    rate = -0.25 * f * s1, to * x + f * u, to * y + f * v, 0.0
    bend = -0.25 * (f1 * s1 * s1 + f * s2), bends * x + 2.0 * to * u + f * a, bends * y + 2.0 * to * v + f * b, 0.0
    return q, rate, bend


@leaf
def _change(q, x, y, z):
    """Return the change of a vector by the rotation of a unit quaternion."""
    axis = q[1], q[2], q[3]
    across = cross(axis, (x, y, z))
    swept = plus((q[0] * across[0], q[0] * across[1], q[0] * across[2]), cross(axis, across), 1.0)
    return 2.0 * swept[0], 2.0 * swept[1], 2.0 * swept[2]


@leaf
def _back(q):
    return q[0], -q[1], -q[2], -q[3]


@kernel
def turn_base(scene, base, t, ax, ay, az):
    """Set the rotation of the base at time t, s; (ax, ay, az): its acceleration along fixed axes, m/s2.

    The loads on ports, which have been set along fixed axes, are rotated to those of the base.
    """
    taken, past = scene.extras.turn, t - base.t0
    if not is_turned(base):
        taken.turned = 0.0
        return
    # rotation, angular velocity and acceleration
    x, y, u, v = rotation_at(base, t)
    q, rate, bend = _curve(x, y, u, v, base.alpha_x + past * base.jalpha_x, base.alpha_y + past * base.jalpha_y)
    taken.turned, taken.q0, taken.q1, taken.q2 = 1.0, q[0], q[1], q[2]
    taken.wx, taken.wy, taken.wz = spin_of(q, rate)
    taken.bx, taken.by, taken.bz = spin_of(q, bend)
    # additional acceleration and gravity along the axes of the base
    taken.gx, taken.gy, taken.gz = _change(_back(q), ax, ay, az + scene.settings.gravity)
    _turn_loads(scene, _back(q))


@leaf
def stop_turning(scene):
    """Clear the rotation of the base."""
    scene.extras.turn.turned = 0.0


@kernel
def load_turned(scene, phase):
    """Add to the forces on the bodies the inertial forces of rotating axes.

    They include the change of weight and base acceleration by the rotation.
    """
    turn, bodies, poses = scene.extras.turn, scene.bodies, scene.poses
    if turn.turned == 0.0:
        return
    spin, grows, drawn = (turn.wx, turn.wy, turn.wz), (turn.bx, turn.by, turn.bz), (turn.gx, turn.gy, turn.gz)
    for i in range(scene.n):
        place = place_of(scene, phase, i)
        v = phase.vx[i], phase.vy[i], phase.vz[i]
        # Coriolis, Euler and centrifugal acceleration
        swept = plus(cross(spin, place), v, 2.0)
        more = plus(plus(drawn, cross(grows, place), 1.0), cross(spin, swept), 1.0)
        # rate of change of the angular momentum by the rotation of the axes
        w, own, grown = (phase.wx[i], phase.wy[i], phase.wz[i]), seen_from(poses, i, spin), seen_from(poses, i, grows)
        borne = momentum(bodies, i, own)  # in the axes of the body
        couple = plus(momentum(bodies, i, grown), cross(w, borne), 1.0)
        couple = plus(couple, cross(own, plus(momentum(bodies, i, w), borne, 1.0)), 1.0)
        couple = minus(momentum(bodies, i, cross(w, own)), couple)
        push(poses, i, (0.0, 0.0, 0.0), more, standing(poses, i, couple[0], couple[1], couple[2]), -bodies.mass[i])


@leaf
def _turn_entries(q, entries, first, stride):
    """Rotate a vector in an output row from index `first`, whose components are `stride` apart."""
    x, y, z = entries[first], entries[first + stride], entries[first + 2 * stride]
    change = _change(q, x, y, z)
    entries[first], entries[first + stride], entries[first + 2 * stride] = x + change[0], y + change[1], z + change[2]


@kernel
def show_turned(scene, phase, shown):
    """Transform blocks, ports and the force on the base in an output row to fixed axes.

    They remain relative to the origin, which moves with the base.
    """
    turn, n, ports = scene.extras.turn, scene.n, scene.extras.spotted
    if turn.turned == 0.0:
        return
    q = turn.q0, turn.q1, turn.q2, 0.0
    # displacements and rotations of blocks
    for i in range(n):
        place = place_of(scene, phase, i)
        moved = _change(q, place[0], place[1], place[2])
        shown[i], shown[n + i], shown[2 * n + i] = plus((phase.ux[i], phase.uy[i], phase.uz[i]), moved, 1.0)
        whole = _product(q, (phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i]))
        shown[3 * n + i], shown[4 * n + i], shown[5 * n + i] = rotation_vector(whole[0], whole[1], whole[2], whole[3])
    # ports, and force and moment on the base
    base = scene.visible - len(OF_BASE)
    for p in range(ports):
        _show_port(scene, q, p, shown, base - len(OF_PORT) * ports + p)
    _turn_entries(q, shown, base, 1)
    _turn_entries(q, shown, base + 3, 1)


@leaf
def _show_port(scene, q, p, shown, first):
    """Fill in the motion of port p along fixed axes, in an output row from index `first`."""
    turn, ports, seen, apart = scene.extras.turn, scene.extras.ports, scene.extras.spots, scene.extras.spotted
    spin, i = (turn.wx, turn.wy, turn.wz), index_of(ports.body[p])
    moved, v = (seen.x[p], seen.y[p], seen.z[p]), (seen.vx[p], seen.vy[p], seen.vz[p])
    # position, velocity and acceleration, rotation of the axes included
    built = scene.bodies.x[i] + ports.x[p], scene.bodies.y[i] + ports.y[p], scene.bodies.z[i] + ports.z[p]
    place = plus(built, moved, 1.0)
    swept = plus(cross(spin, place), v, 1.0)
    bends = plus(cross((turn.bx, turn.by, turn.bz), place), cross(spin, plus(swept, v, 1.0)), 1.0)
    bends = plus((seen.ax[p], seen.ay[p], seen.az[p]), bends, 1.0)
    # to fixed axes
    change = _change(q, place[0], place[1], place[2])
    for k in range(3):
        at = first + k * apart
        shown[at], shown[at + 3 * apart], shown[at + 6 * apart] = moved[k] + change[k], swept[k], bends[k]
    _turn_entries(q, shown, first + 3 * apart, apart)
    _turn_entries(q, shown, first + 6 * apart, apart)


@leaf
def _turn_loads(scene, q):
    """Rotate the loads on ports, which are along fixed axes, to those of the base."""
    ports, pushes = scene.extras.spotted, scene.extras.pushes.row
    for p in range(ports):
        _turn_entries(q, pushes, p, ports)
        _turn_entries(q, pushes, 3 * ports + p, ports)


@kernel
def turn_beneath(scene, phase, base, x, y, u, v):
    """Change rotation (x, y), rad, and rate (u, v), rad/s, of the base at its time t0; blocks stay in place."""
    # old and new rotation, and the step between them
    q, rate, _ = _curve(base.theta_x, base.theta_y, base.omega_x, base.omega_y, 0.0, 0.0)
    other, other_rate, _ = _curve(x, y, u, v, 0.0, 0.0)
    spin, new_spin = spin_of(q, rate), spin_of(other, other_rate)
    step = _product(_back(other), q)
    if x == base.theta_x and y == base.theta_y:  # a change of the rate alone turns nothing, not even by rounding
        step = 1.0, 0.0, 0.0, 0.0
    base.theta_x, base.theta_y, base.omega_x, base.omega_y = x, y, u, v
    # change of the angular velocity, rad/s
    change = _change(_back(step), new_spin[0], new_spin[1], new_spin[2])
    less = minus(spin, plus(new_spin, change, 1.0))  # along the old axes of the base
    for i in range(scene.n):
        # position and velocity of a block
        place = place_of(scene, phase, i)
        moved = _change(step, place[0], place[1], place[2])
        swept = plus((phase.vx[i], phase.vy[i], phase.vz[i]), cross(spin, place), 1.0)
        swept = plus(swept, _change(step, swept[0], swept[1], swept[2]), 1.0)
        swept = minus(swept, cross(new_spin, plus(place, moved, 1.0)))
        # rotation and angular velocity of a block
        own = phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i]
        left = plus(less, _change(_back(own), less[0], less[1], less[2]), 1.0)
        phase.ux[i], phase.uy[i], phase.uz[i] = phase.ux[i] + moved[0], phase.uy[i] + moved[1], phase.uz[i] + moved[2]
        phase.vx[i], phase.vy[i], phase.vz[i] = swept
        phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i] = _product(step, own)
        phase.wx[i], phase.wy[i], phase.wz[i] = phase.wx[i] + left[0], phase.wy[i] + left[1], phase.wz[i] + left[2]
    # stretches of pairs
    stretches = stretches_in(scene, phase.buffer[_PER_BODY * scene.n :])
    for p in range(scene.extras.met):
        z = stretches.z1[p], stretches.z2[p], stretches.z3[p]
        stretches.z1[p], stretches.z2[p], stretches.z3[p] = plus(z, _change(step, z[0], z[1], z[2]), 1.0)


@leaf
def _product(a, b):
    """Return the product of two quaternions."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    )
