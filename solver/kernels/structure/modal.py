"""Steps by modes for structures in space, while all joints are in full contact and neither slide nor twist.

The coordinates of a body are the displacement of its centroid from rest and twice the vector of its quaternion, less
that at rest: with their rates they represent position and velocity exactly, and the equations of motion give their
accelerations. About rest they move as 6 n linear modes (models/structure/modal_data.py); everything else is the
remainder of engine/modal_steps.py. Groups of coordinates without mutual forces have modes of their own. In a
structure that is its own mirror image in the plane x, z the modes in the plane come first, and they alone move in a
plane motion.
"""

import math

from ..engine.modal_steps import (
    OPENS,
    Drive,
    attempt_of,
    bounds_of,
    multiply,
    pays,
    set_limits,
    sweep_of,
)
from ..engine.samples import is_silent
from ..layout.modal import mode_at
from ..layout.spaces import INTERPOLATION_PART, OK
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import index_of
from ..numba_ext.views import clear, copy
from .attempt import evaluate_at, rate
from .base import acceleration, line
from .bond import raised_by_bond, with_strength
from .evaluate import evaluate_state, moving, show
from .joint import friction_limits, middle_of
from .kinematics import spin_of
from .layout import MEMORY, OF_BLOCK, OF_JOINT, PHASE, POLYGON, RINGING_ORDER, STAGES
from .modal_layout import AXES, THREE, body_of, data_of, room_of
from .watch import BETWEEN_RATES, END, STAGE, START, quaternion_curve, row, seen

SPREAD = 0.1  # least margin left by the parabola, over the spread of its three values
FASTEST = 10.0  # period / 2 pi of the fastest joint, over the first step
SMALL = 0.05  # force of dampers while damping is computed, over the weight of one block
# damping that couples the modes belongs to the remainder: its rate times the step is at most this. Steel ties, with
# little damping, couple ten times as much as the 0.03 of columns allows; errors are the same
COUPLED_PART = 0.3
FAR = 0.01
QUIET = 1e-9  # of critical damping: smaller values are rounding
STEP_PART = 0.1  # tolerance of a step over that of a run: errors of long steps add up
RINGING_PART = 1e-2  # the same with undamped joints
LEAST_TOLERANCE = 1e-13
_phase, _three = PHASE.over, THREE.over_begin
_PER_BODY, _PER_JOINT = PHASE.per_n, MEMORY.per_n
_BLOCKS, _JOINTS, _CONTACT = len(OF_BLOCK), len(OF_JOINT), OF_JOINT.index("contact")
_TX, _TY, _MZ = (OF_JOINT.index(name) for name in ("Tx", "Ty", "Mz"))


@kernel
def _multiply(body, matrices, x, y, segments):
    """Multiply one to three segments of the row x by the matrices of all groups that move, into the row y."""
    size = AXES * body.scene.n
    begin, place = 0, 0
    # the diagonal block of each group
    for part in range(body.parts):
        m = int(body.data.coordinates.group[part])
        multiply(matrices[place:], _three(x, size), _three(y, size), begin, m, segments)
        begin, place = begin + m, place + m * m


@leaf
def _scale(n, place):
    """Return the ratio of a coordinate to its number in a phase: 2 for parts of a quaternion, else 1."""
    return 2.0 if place >= 3 * n else 1.0


@kernel
def _take_accelerations(body, y, f):
    """Fill the accelerations of the coordinates at a state y with rates f."""
    n, x, places = body.scene.n, body.x, body.data.coordinates.place
    phase, rates, second = _phase(y, n), _phase(f, n), row(body.scene, BETWEEN_RATES)
    curve = _phase(second, n)
    # second derivatives of places and quaternions
    for i in range(n):
        curve.ux[i], curve.uy[i], curve.uz[i] = rates.vx[i], rates.vy[i], rates.vz[i]
        _, curve.q1[i], curve.q2[i], curve.q3[i] = quaternion_curve(phase, rates, i)
    # those of the coordinates
    for c in range(body.active):
        place = int(places[c])
        x.third[c] = _scale(n, place) * second[place]


@kernel
def _take_coordinates(body, y, f):
    """Fill coordinates, rates and accelerations at a state y with rates f."""
    n, x, coordinates = body.scene.n, body.x, body.data.coordinates
    # accelerations, then coordinates and rates
    _take_accelerations(body, y, f)
    for c in range(body.active):
        place = int(coordinates.place[c])
        scale = _scale(n, place)
        x.first[c], x.second[c] = scale * (y[place] - coordinates.rest[c]), scale * f[place]


@kernel
def _place(body, y, f, segments):
    """Fill the state y from the coordinates and rates, and with `segments` 3 its rates f; the rest is as at START.

    With two segments f has the rates of places alone.
    """
    scene, x, coordinates = body.scene, body.x, body.data.coordinates
    n = scene.n
    second = row(scene, BETWEEN_RATES)
    # start from the state and rates at START
    copy(y, row(scene, START), moving(scene))
    copy(f, rate(scene, 0), moving(scene))
    if segments > 2:
        clear(second, _PER_BODY * n)
    # numbers that are coordinates
    for c in range(body.active):
        place = int(coordinates.place[c])
        per = 1.0 / _scale(n, place)
        y[place], f[place] = coordinates.rest[c] + per * x.first[c], per * x.second[c]
        if segments > 2:
            second[place] = per * x.third[c]
    phase, rates, curve = _phase(y, n), _phase(f, n), _phase(second, n)
    for i in range(n):
        v1, v2, v3 = phase.q1[i], phase.q2[i], phase.q3[i]
        p1, p2, p3 = rates.q1[i], rates.q2[i], rates.q3[i]
        # scalar of the quaternion from its unit norm
        scalar = math.sqrt(max(0.0, 1.0 - (v1 * v1 + v2 * v2 + v3 * v3)))
        falls = -(v1 * p1 + v2 * p2 + v3 * p3) / scalar
        phase.q0[i], rates.q0[i] = scalar, falls
        # velocities
        phase.vx[i], phase.vy[i], phase.vz[i] = rates.ux[i], rates.uy[i], rates.uz[i]
        q = scalar, v1, v2, v3
        phase.wx[i], phase.wy[i], phase.wz[i] = spin_of(q, (falls, p1, p2, p3))
        if segments > 2:
            # accelerations
            a1, a2, a3 = curve.q1[i], curve.q2[i], curve.q3[i]
            bends = -(v1 * a1 + v2 * a2 + v3 * a3 + p1 * p1 + p2 * p2 + p3 * p3 + falls * falls) / scalar
            rates.vx[i], rates.vy[i], rates.vz[i] = curve.ux[i], curve.uy[i], curve.uz[i]
            rates.wx[i], rates.wy[i], rates.wz[i] = spin_of(q, (bends, a1, a2, a3))


# --- whether the structure stays as it is at rest


@leaf
def _pressed(scene, joints_seen, j):
    """Return the resultants of the pressure on joint j about the centre of its contact, N, N m, from an output row."""
    normal, (x, y) = joints_seen[j], middle_of(scene, j)
    return normal, joints_seen[scene.m + j] + normal * y, joints_seen[2 * scene.m + j] - normal * x


@leaf
def _least_pressure(scene, joints_seen, j):
    """Return the least pressure on joint j in full contact, Pa, plus the strength of its bond."""
    joints = scene.joints
    normal, g1, g2 = _pressed(scene, joints_seen, j)
    # linear pressure from the resultants
    ixx, iyy, ixy = joints.ixx[j], joints.iyy[j], joints.ixy[j]
    per = 1.0 / (ixx * iyy - ixy * ixy)
    along_x, along_y = per * (iyy * g2 + ixy * g1), -per * (ixx * g1 + ixy * g2)
    at = normal / joints.area[j]
    # least at the rim of a disc, or at a corner
    if joints.section[j] != POLYGON:
        return at - joints.outer[j] * math.sqrt(along_x * along_x + along_y * along_y)
    least, corners = math.inf, scene.corners[2 * index_of(joints.first[j]) :]
    for k in range(index_of(joints.corners[j])):
        least = min(least, along_x * corners[2 * k] + along_y * corners[2 * k + 1])
    return with_strength(scene, j, at + least)


@leaf
def _sliding_margins(scene, joints_seen, j):
    """Return the force (N) and the couple (N m) that joint j would bear beyond those it bears now."""
    m = scene.m
    # friction limits, raised by a bond
    pressed = _pressed(scene, joints_seen, j)
    limit, couple = friction_limits(scene.joints, j, *pressed)
    limit, couple = raised_by_bond(scene, j, pressed[0], limit, couple)
    # limits less the present force and couple
    force = math.hypot(joints_seen[_TX * m + j], joints_seen[_TY * m + j])
    return limit - force, couple - abs(joints_seen[_MZ * m + j])


@leaf
def _dips(a, b, c):
    """Return True if a margin may vanish within a step; a, b, c: its values at start, middle and end."""
    bend, rise = a - 2.0 * b + c, c - a
    least = min(a, b, c)
    # minimum of the parabola
    if bend > 0.0 and abs(rise) < 2.0 * bend:
        least = min(least, b - rise * rise / (8.0 * bend))
    return not least > SPREAD * (max(a, b, c) - least)


@leaf
def _joints_in(scene, k):
    return seen(scene, k)[_BLOCKS * scene.n :]


@leaf
def _ties_in(scene, k):
    return seen(scene, k)[_BLOCKS * scene.n + _JOINTS * scene.m :]


@leaf
def _has_slid_far(scene, j):
    """Return True if slips have moved the contact of joint j so far that the modes change."""
    p1, p2, p3 = scene.slips.p1[j], scene.slips.p2[j], scene.slips.p3[j]
    arm = scene.joints.arm[j]
    return max(abs(p1), abs(p2), arm * abs(p3)) > FAR * arm


@leaf
def _to_ring(scene, k, i):
    """Return the distance of bearing i from its ring, m, in output row k of a step."""
    b = scene.extras.b
    return scene.joints.ring[scene.m - b + i] - _ties_in(scene, k)[scene.k + 2 * b + i]


@kernel
def _is_within_rings(scene, k):
    """Return True if no bearing touches its ring in output row k of a step."""
    touching = 0
    for i in range(scene.extras.b):
        touching += 0 if _to_ring(scene, k, i) > 0.0 else 1
    return touching == 0


@kernel
def _may_touch_ring(scene):
    """Return True if a bearing may touch its ring within the step, by its start, middle and end."""
    for i in range(scene.extras.b):
        # distances at start, middle and end
        begins, halfway, ends = _to_ring(scene, 0, i), _to_ring(scene, 1, i), _to_ring(scene, 2, i)
        if ends != math.inf and _dips(begins, halfway, ends):
            return True
    return False


@kernel
def _is_as_at_rest(body, k, giving):
    """Return True if all joints are in full contact and stick and ties pull as at rest, by output row k of a step.

    giving: rates of the state there.
    """
    scene = body.scene
    joints, ties = _joints_in(scene, k), _ties_in(scene, k)
    # contact of joints
    for j in range(scene.m):
        if not joints[_CONTACT * scene.m + j] >= 1.0 or _has_slid_far(scene, j):
            return False
    # ties
    for e in range(scene.k):
        if (ties[e] != 0.0) != (body.data.taut[e] != 0.0):
            return False
    # bearings within their rings
    if not _is_within_rings(scene, k):
        return False
    # sliding and yielding
    slides = 0.0
    for place in range(_PER_BODY * scene.n, moving(scene)):
        slides += abs(giving[place])
    return slides == 0.0


@kernel
def _joint_leaves(scene, j):
    """Return True if joint j may open, slide or twist within the step, by its start, middle and end."""
    a, b, c = _joints_in(scene, 0), _joints_in(scene, 1), _joints_in(scene, 2)
    # opening
    if _dips(_least_pressure(scene, a, j), _least_pressure(scene, b, j), _least_pressure(scene, c, j)):
        return True
    if scene.joints.friction[j] == math.inf:
        return False
    # sliding and twisting
    begins, halfway, ends = _sliding_margins(scene, a, j), _sliding_margins(scene, b, j), _sliding_margins(scene, c, j)
    return _dips(begins[0], halfway[0], ends[0]) or _dips(begins[1], halfway[1], ends[1])


@kernel
def _tie_leaves(body, e):
    """Return True if tie e may become slack or taut, or yield, within the step."""
    scene = body.scene
    a, b, c = _ties_in(scene, 0)[e], _ties_in(scene, 1)[e], _ties_in(scene, 2)[e]
    # yielding
    most = scene.ties.yields_at[e]
    if most != math.inf and _dips(most - abs(a), most - abs(b), most - abs(c)):
        return True
    # ties that bear compression are never slack
    if scene.ties.tension_only[e] == 0.0:
        return False
    # slack or taut
    if body.data.taut[e] != 0.0:
        return _dips(a, b, c)
    halfway, end = -body.elastic[e], -scene.pulls.elastic[e]
    return not min(halfway, end) > abs(end - halfway)


@kernel
def _leaves(body):
    """Return True if a joint, tie or bearing may have changed its regime within the step."""
    # joints
    for j in range(body.scene.m):
        if _joint_leaves(body.scene, j):
            return True
    # ties and bearings
    leaves, scene = False, body.scene
    for e in range(scene.k):
        leaves = leaves or _tie_leaves(body, e)
    return leaves or _may_touch_ring(scene)


# --- a step


@leaf
def _drive(body, t):
    scene, k = body.scene, body.segment
    base = scene.base
    # linear part
    ax, ay, az, jx, jy, jz = line(scene, k, t)
    # harmonic part
    omega = 0.0 if is_silent(scene.samples, k) else base.omega
    amplitude = 0.0 if omega == 0.0 else max(abs(base.amplitude_x), abs(base.amplitude_y))
    angle = omega * t + base.phase
    sine, cosine = (math.sin(angle), math.cos(angle)) if omega != 0.0 else (0.0, 0.0)
    by_sine = base.amplitude_x * sine, 0.0, base.amplitude_y * sine
    by_cosine = base.amplitude_x * cosine, 0.0, base.amplitude_y * cosine
    return Drive((ax, az, ay), (jx, jz, jy), by_sine, by_cosine, amplitude, omega, sine, cosine)


@kernel
def _begin(body, modal):
    _take_coordinates(body, row(body.scene, START), rate(body.scene, 0))
    _multiply(body, body.data.inverses, body.x.row, modal.first.row, 3)


@kernel
def _reach(body, modal, half, t, h, sine):
    """Evaluate the structure at the predicted modes, and check joints and ties (modal_steps.py, `sweep_of`).

    Return OK or OPENS, and the base acceleration (x, z, y), m/s2.
    """
    scene = body.scene
    # the state in the middle (half 0) or at the end of the step
    y, f = row(scene, STAGE if half == 0 else END), rate(scene, 1 if half == 0 else STAGES - 1)
    to = modal.mean if half == 0 else modal.last
    _multiply(body, body.data.shapes, to.row, body.x.row, 2)
    _place(body, y, f, 2)
    evaluate_at(scene, body.segment, y, f, t)
    show(scene, _phase(y, scene.n), seen(scene, 1 + half), True)
    ax, ay, az = acceleration(scene, body.segment, t)
    # regime
    if not _is_as_at_rest(body, 1 + half, f) or (half == 1 and _leaves(body)):
        return OPENS, (ax, az, ay)
    if half == 0:
        copy(body.elastic, scene.pulls.elastic, scene.k)
    # modal accelerations
    _take_accelerations(body, y, f)
    _multiply(body, body.data.inverses, body.x.third, to.accelerations, 1)
    return OK, (ax, az, ay)


@kernel
def _end(body, modal):
    scene = body.scene
    _multiply(body, body.data.shapes, modal.last.row, body.x.row, 3)
    _place(body, row(scene, END), rate(scene, STAGES - 1), 3)


_attempt = attempt_of(sweep_of(_begin, _reach, _end))


@leaf
def step_tolerance_of(settings):
    """Return the tolerance of a step by modes."""
    return max(LEAST_TOLERANCE, (RINGING_PART if settings.order == RINGING_ORDER else STEP_PART) * settings.tolerance)


@leaf
def between_part(settings):
    """Return the allowed error between the ends of a step, where errors do not add up, over the tolerance of a step."""
    return INTERPOLATION_PART * STEP_PART * settings.tolerance / step_tolerance_of(settings)


@kernel
def attempt(scene, segment, t, h):
    """Make one step by modes over h seconds from row START to row END; return (code, error in tolerances)."""
    settings, control = scene.settings, scene.control
    body, modal = body_of(scene, segment, settings.in_plane != 0.0)
    # bounds of the error
    scales = control.largest, control.largest_rate
    bounds = bounds_of(body.data.limits, step_tolerance_of(settings), *scales, between_part(settings))
    return _attempt(body, modal, _drive(body, t), bounds, int(body.data.limits.sweeps), t, h)


@leaf
def cost_of(scene):
    """Return the cost of a step by modes over that of an explicit step."""
    limits = data_of(scene).limits
    return limits.cost if scene.settings.in_plane == 0.0 else limits.flat_cost


@kernel
def suits(scene, segment):
    """Return True if a step by modes may be tried from row START."""
    body, _ = body_of(scene, segment, scene.settings.in_plane != 0.0)
    return _is_as_at_rest(body, 0, rate(scene, 0))


@kernel
def forget(scene):
    """Mark the trend of the remainder as unknown, at the first step of a call or after steps by other methods."""
    if scene.settings.has_modes != 0.0:
        _, modes = body_of(scene, 0, False)
        modes.trend.known = 0.0


# --- what follows from the dampers


@kernel
def prepare(scene):
    """Compute damping and limits of the modes once, by evaluations at rest; uses the rows of a step and all the room.

    They depend on the dampers and the tolerance, which a caller may have set. Modes are switched off if dampers couple
    them too strongly to pay.
    """
    settings = scene.settings
    if settings.has_modes == 0.0 or data_of(scene).limits.ready != 0.0:
        return
    # all modes, at rest
    in_plane = settings.in_plane
    settings.in_plane = 0.0
    body, modal = body_of(scene, 0, False)
    # accelerations and taut ties at rest
    _stand_at_rest(body)
    still, pace = modal.mean, small_rate(scene)
    _accelerate(body, still)
    for e in range(scene.k):
        body.data.taut[e] = 1.0 if scene.pulls.force[e] != 0.0 else 0.0
    # damping of each mode by a small rate, and its coupling to the others
    coupled, fastest, damped = 0.0, 0.0, False
    for k in range(body.active):
        mode = mode_at(modal.modes, k)
        little = pace / mode.size
        _move_by_mode(body, k, little)
        _accelerate(body, modal.last)
        # couplings of mode k
        across = 0.0
        for j in range(body.active):
            beta = (still.accelerations[j] - modal.last.accelerations[j]) / little
            if j == k:
                mode.damping = max(0.0, beta)
                damped = damped or mode.damping > QUIET * math.sqrt(mode.square)
            else:
                across += abs(beta)
        coupled, fastest = max(coupled, across), max(fastest, mode.square)
    # limits of the step
    longest = COUPLED_PART / max(coupled, 1e-300)
    set_limits(body.data.limits, step_tolerance_of(settings), between_part(settings), longest, damped)
    body.data.limits.ready = 1.0
    modal.trend.known = 0.0
    settings.in_plane = in_plane
    if not pays(body.data.limits, fastest):
        settings.has_modes = 0.0


@kernel
def _stand_at_rest(body):
    """Fill row START with the state at rest, and clear the room of the modes."""
    scene, coordinates = body.scene, body.data.coordinates
    # no rates, and the memory at rest
    begin, size = row(scene, START), AXES * scene.n
    clear(begin, _PER_BODY * scene.n)
    clear(rate(scene, 0), moving(scene))
    copy(begin[_PER_BODY * scene.n :], body.data.remembered, _PER_JOINT * scene.m + scene.k)
    clear(scene.modal_room, room_of(scene).total)
    # places at rest
    for c in range(size):
        begin[int(coordinates.place[c])] = coordinates.rest[c]


@leaf
def small_rate(scene):
    """Return a rate, rad/s, at which a damper bears a small fraction of the weight of one block."""
    # longest time constant, and largest block
    slowest, largest = FASTEST * scene.settings.first_step, 0.0
    # g T^2, the penetration under the weight of a spring with the time constant T, m
    settled = scene.settings.gravity * slowest * slowest
    for j in range(scene.m):
        slowest = max(slowest, scene.joints.damping[j])
    for i in range(scene.n):
        largest = max(largest, scene.bodies.size[i])
    return SMALL * settled / (slowest * largest)


@kernel
def _move_by_mode(body, k, pace):
    """Fill the rates of the coordinates where mode k alone moves, at this modal rate."""
    begin, place = 0, 0
    clear(body.x.second, body.active)
    for part in range(body.parts):
        # the group of mode k
        m = int(body.data.coordinates.group[part])
        if begin <= k < begin + m:
            for c in range(m):
                body.x.second[begin + c] = pace * body.data.shapes[place + m * c + k - begin]
        begin, place = begin + m, place + m * m


@kernel
def _accelerate(body, to):
    """Fill `to` with the modal accelerations at the coordinates and their rates, on a still base."""
    scene = body.scene
    # state, forces, then modal accelerations
    y, f = row(scene, STAGE), rate(scene, 1)
    _place(body, y, f, 2)
    evaluate_state(scene, y, f, 0.0, 0.0, 0.0)
    _take_accelerations(body, y, f)
    _multiply(body, body.data.inverses, body.x.third, to.accelerations, 1)
