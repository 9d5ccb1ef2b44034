"""The base of a structure moved by rotation inputs or coupled bodies: an exchange without feedthrough (theory.md 15).

A structure has no mass at its base, since its joints are elastic in shear.
"""

from typing import NamedTuple

from ..engine.allowed_step import is_new, longest_step
from ..engine.exchange import SINGULAR, are_silent, goes_on, gone_on, slope_of
from ..layout.spaces import ACCELERATION, BODY_LACKING, HORIZONTAL, OK
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.views import Record, clear
from .layout import DRIVEN, DRIVEN_TURN, LOAD
from .turning import rotation_at, turn_beneath

INPUTS = Record("ax", "ay", "az", "jx", "jy", "jz")  # m/s2; slopes, m/s3; then INPUT_LOADS of the ports
# then, if the base may rotate: rad, rad/s, rad/s2
ROTATION = Record("theta_x", "theta_y", "omega_x", "omega_y", "alpha_x", "alpha_y")
BODY = Record("F0x", "F0y", "F0z", "M")  # then, of each body that drives the base: force, N, and mass, kg
# then, if the base may rotate: N m; kg m, coupling of x with rotation about y, and of y with that about x; kg m2
TURNING_BODY = Record("F0mx", "F0my", "Mxry", "Myrx", "Jxx", "Jyy", "Jxy")

_inputs, _rotation, _body, _turning_body = INPUTS.over, ROTATION.over, BODY.over, TURNING_BODY.over
_INPUTS, _ROTATION, _BODY, _TURNING_BODY = INPUTS.beside, ROTATION.beside, BODY.beside, TURNING_BODY.beside
_LOAD = len(LOAD)
_driven, _driven_turn, _DRIVEN, _DRIVEN_TURN = DRIVEN.over, DRIVEN_TURN.over, DRIVEN.beside, DRIVEN_TURN.beside


@leaf
def start_at(base, t):
    """Advance the rotation of the base to time t and set t0 = t."""
    base.theta_x, base.theta_y, base.omega_x, base.omega_y = rotation_at(base, t)
    # angular acceleration
    past = t - base.t0
    base.alpha_x, base.alpha_y = base.alpha_x + past * base.jalpha_x, base.alpha_y + past * base.jalpha_y
    base.t0 = t


@leaf
def turned_by(scene, inputs):
    """Return the record ROTATION of the inputs: rotation, its rate and its acceleration (rad, rad/s, rad/s2)."""
    return _rotation(inputs[_INPUTS + 2 * _LOAD * scene.extras.spotted :], 0)


@kernel
def turn(scene, phase, base, inputs):
    """Set the rotation of the base to that of the inputs.

    If the base did not arrive at it by its own acceleration, it jumps beneath blocks that stay where they are. Before
    the first step everything on the base rotates with it, without a rate, also where it has been turned before.
    """
    turned = turned_by(scene, inputs)
    x, y, u, v = turned.theta_x, turned.theta_y, turned.omega_x, turned.omega_y
    # before the first step the blocks rest: undo the rates relative to a base that was read in motion
    if scene.counts.started == 0:
        undone = base.omega_x != 0.0 or base.omega_y != 0.0
        base.theta_x, base.theta_y, base.omega_x, base.omega_y = x, y, 0.0, 0.0
        for i in range(scene.n if undone else 0):
            phase.vx[i], phase.vy[i], phase.vz[i] = 0.0, 0.0, 0.0
            phase.wx[i], phase.wy[i], phase.wz[i] = 0.0, 0.0, 0.0
    # a jump of angle or rate
    if x != base.theta_x or y != base.theta_y or u != base.omega_x or v != base.omega_y:
        turn_beneath(scene, phase, base, x, y, u, v)


@leaf
def _place_of(scene, k):
    """Return the index among the inputs of the data of body k; it has more numbers if the base may turn."""
    # behind the inputs and loads
    turns = int(scene.settings.turns)
    first = _INPUTS + 2 * _LOAD * scene.extras.spotted + _ROTATION * turns
    return first + k * (_BODY + _TURNING_BODY * turns)


@leaf
def _are_bodies_zero(scene, inputs):
    first = _place_of(scene, 0)
    return are_silent(inputs, first, _place_of(scene, int(scene.settings.bodies)) - first)


@kernel
def arrive(scene, phase, base, inputs, t):
    """Advance the base to time t, and rotate it by the inputs unless bodies do; called before outputs are taken at t.

    If time has advanced since the last exchange, the acceleration history is shifted.
    """
    # translation
    past = t - base.t0
    base.x, base.vx, _ = gone_on(base.x, base.vx, base.ax, base.jx, past)
    base.y, base.vy, _ = gone_on(base.y, base.vy, base.ay, base.jy, past)
    base.z, base.vz, _ = gone_on(base.z, base.vz, base.az, base.jz, past)
    # acceleration history
    if goes_on(base, t):
        base.before_ax, base.before_ay, base.before_az = base.last_ax, base.last_ay, base.last_az
        base.before_alpha_x, base.before_alpha_y = base.last_alpha_x, base.last_alpha_y
        base.last_ax, base.last_ay, base.last_az = base.ax, base.ay, base.az
        base.last_alpha_x, base.last_alpha_y = base.alpha_x, base.alpha_y
    # rotation
    start_at(base, t)
    if scene.settings.turns != 0.0 and (base.coupled == 0.0 or scene.settings.drive == HORIZONTAL):
        turn(scene, phase, base, inputs)


@kernel
def show_driven(settings, base, t, order, row):
    """Fill `row` with the motion of a base that bodies may drive, at time t (DRIVEN, DRIVEN_TURN).

    It is zero while inputs move the base. order: 0 for the values, 1 for their rates.
    """
    if settings.bodies == 0.0:
        return
    # time since the last exchange, s
    turns, past = settings.turns != 0.0, t - base.t0
    clear(row, _DRIVEN + (_DRIVEN_TURN if turns else 0))
    if settings.drive == ACCELERATION:
        return
    # translation
    shown = _driven(row, 0)
    x, vx, ax = gone_on(base.x, base.vx, base.ax, base.jx, past)
    y, vy, ay = gone_on(base.y, base.vy, base.ay, base.jy, past)
    z, vz, az = gone_on(base.z, base.vz, base.az, base.jz, past)
    # displacement, velocity, acceleration, or their rates
    if order == 0:
        shown.x, shown.y, shown.z, shown.vx, shown.vy, shown.vz = x, y, z, vx, vy, vz
        shown.ax, shown.ay, shown.az = ax, ay, az
    else:
        shown.x, shown.y, shown.z, shown.vx, shown.vy, shown.vz = vx, vy, vz, ax, ay, az
        shown.ax, shown.ay, shown.az = base.jx, base.jy, base.jz
    # rotation
    if turns:
        turned = _driven_turn(row[_DRIVEN:], 0)
        theta_x, theta_y, omega_x, omega_y = rotation_at(base, t)
        alpha_x, alpha_y = base.alpha_x + past * base.jalpha_x, base.alpha_y + past * base.jalpha_y
        if order == 0:
            turned.theta_x, turned.theta_y, turned.omega_x, turned.omega_y = theta_x, theta_y, omega_x, omega_y
            turned.alpha_x, turned.alpha_y = alpha_x, alpha_y
        else:
            turned.theta_x, turned.theta_y, turned.omega_x, turned.omega_y = omega_x, omega_y, alpha_x, alpha_y
            turned.alpha_x, turned.alpha_y = base.jalpha_x, base.jalpha_y


class SpatialSums(NamedTuple):
    """The sums of forces and masses at the base over all bodies and the structure: N, N m, kg, kg m, kg m2."""

    x: float
    y: float
    z: float
    mx: float
    my: float
    mass: float
    with_y: float  # coupling of motion along x with rotation about y
    with_x: float  # coupling of motion along y with rotation about x
    xx: float
    yy: float
    xy: float


@leaf
def _sums(scene, inputs, flat, reaction):
    """Sum forces and masses at the base over all bodies and the structure.

    reaction: force and couple of the structure on the base, N and N m; flat: True if the structure moves in the plane
    x, z alone, so that components across it are zero.
    """
    x, y, z, mass = reaction[0], 0.0 if flat else reaction[1], reaction[2], 0.0
    mx, my, with_y, with_x, xx, yy, xy = 0.0 if flat else reaction[3], reaction[4], 0.0, 0.0, 0.0, 0.0, 0.0
    # forces and masses of the bodies
    for k in range(int(scene.settings.bodies)):
        said = inputs[_place_of(scene, k) :]
        # translation
        body = _body(said, 0)
        x, y, z, mass = x + body.F0x, y + body.F0y, z + body.F0z, mass + body.M
        if scene.settings.turns != 0.0:
            # rotation
            turning = _turning_body(said[_BODY:], 0)
            mx, my, with_y, with_x = mx + turning.F0mx, my + turning.F0my, with_y + turning.Mxry, with_x + turning.Myrx
            xx, yy, xy = xx + turning.Jxx, yy + turning.Jyy, xy + turning.Jxy
    return SpatialSums(x, y, z, mx, my, mass, with_y, with_x, xx, yy, xy)


@leaf
def _turns_of(of):
    """Return (code, alpha_x, alpha_y): the angular acceleration of a base that bodies rotate, rad/s2.

    Translation along x and y is eliminated from the equations first.
    """
    # moments and inertia after elimination of the translation
    mx, my = of.mx - of.with_x * of.y / of.mass, of.my - of.with_y * of.x / of.mass
    xx, yy = of.xx - of.with_x * of.with_x / of.mass, of.yy - of.with_y * of.with_y / of.mass
    whole = xx * yy
    left = whole - of.xy * of.xy
    if not (xx > 0.0 and yy > 0.0 and left > SINGULAR * whole):
        return BODY_LACKING, 0.0, 0.0
    # solve the two equations
    return OK, (yy * mx - of.xy * my) / left, (xx * my - of.xy * mx) / left


@kernel
def examine_step(scene, base, h):
    """Set `base.allowed_step` if a communication step of h s is too long for the structure on the base.

    Checked along x, y and z (formulations/allowed_step.py): the blocks on the base move on their joints, horizontally
    with the effective mass at the joint of a block that also rotates. A block on several joints is counted once.
    """
    joints, bodies, n, settings = scene.joints, scene.bodies, scene.n, scene.settings
    # each step length and mass once
    if not base.mass > 0.0 or not is_new(base, h, base.mass):
        return
    # sums over the joints on the base
    along, by_dashpots, across, across_by_dashpots, moved_x, moved_y, moved_z = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(scene.m):
        if int(joints.lower[j]) != n:
            continue
        k = int(joints.upper[j])
        along += joints.shear[j] + joints.spring[j]
        by_dashpots += joints.shear[j] * joints.shear_damping[j] + joints.dashpot[j]
        # stiffness and damping across the joint
        bed = joints.stiffness[j] * joints.area[j]
        across, across_by_dashpots = across + bed, across_by_dashpots + bed * joints.damping[j]
        # effective masses, of each block once
        is_first = True
        for i in range(j):
            is_first = is_first and not (int(joints.lower[i]) == n and int(joints.upper[i]) == k)
        if is_first:
            arm = joints.az[j]
            moved_x += 1.0 / (bodies.per_mass[k] + arm * arm * bodies.iyy[k])
            moved_y += 1.0 / (bodies.per_mass[k] + arm * arm * bodies.ixx[k])
            moved_z += bodies.mass[k]
    # the shortest of the limits along the axes
    way, mass = settings.slope, base.mass
    found = longest_step(way, h, by_dashpots, along, moved_x, mass)
    found = min(found, longest_step(way, h, by_dashpots, along, moved_y, mass))
    if settings.drive != HORIZONTAL:
        found = min(found, longest_step(way, h, across_by_dashpots, across, moved_z, mass))
    if found < h:
        base.allowed_step = found


@kernel
def exchange(scene, base, inputs, flat, reaction):
    """Compute the acceleration of the base, which has arrived, from all forces and masses on it; return a code.

    Parameters
    ----------
    inputs : row
        INPUTS and the data of each body (formulations/coupled_base.py).
    flat : bool
        True if the structure moves in the plane x, z alone.
    reaction : row
        Force and couple of the structure on the base along fixed axes, N and N m.

    Returns
    -------
    int
        OK, or BODY_LACKING if the masses of the bodies do not determine the motion.
    """
    settings, given, of = scene.settings, _inputs(inputs, 0), _sums(scene, inputs, flat, reaction)
    turns, is_whole = settings.turns != 0.0, settings.drive != HORIZONTAL
    base.coupled, base.mass = 1.0, of.mass
    if not of.mass > 0.0:  # without mass there is no acceleration but that of the inputs
        base.ax, base.ay, base.az, base.jx, base.jy, base.jz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        base.alpha_x, base.alpha_y, base.jalpha_x, base.jalpha_y = 0.0, 0.0, 0.0, 0.0
        if not is_whole:
            base.az, base.jz = given.az, given.jz
            if turns:
                turned = turned_by(scene, inputs)
                base.alpha_x, base.alpha_y = turned.alpha_x, turned.alpha_y
        return OK if _are_bodies_zero(scene, inputs) else BODY_LACKING
    # angular acceleration, by bodies or inputs
    way, steps, step, before = settings.slope, base.steps, base.last_step, base.before_step
    if turns and is_whole:
        code, alpha_x, alpha_y = _turns_of(of)
        if code != OK:
            return code
        base.alpha_x, base.alpha_y = alpha_x, alpha_y
        base.jalpha_x = slope_of(way, steps, step, before, alpha_x, base.last_alpha_x, base.before_alpha_x)
        base.jalpha_y = slope_of(way, steps, step, before, alpha_y, base.last_alpha_y, base.before_alpha_y)
    elif turns:
        turned = turned_by(scene, inputs)
        base.alpha_x, base.alpha_y, base.jalpha_x, base.jalpha_y = turned.alpha_x, turned.alpha_y, 0.0, 0.0
    # translation
    x, y = of.x - of.with_y * base.alpha_y, of.y - of.with_x * base.alpha_x
    base.ax, base.ay, base.az, base.jz = x / of.mass, y / of.mass, given.az, given.jz
    base.jx = slope_of(way, steps, step, before, base.ax, base.last_ax, base.before_ax)
    base.jy = slope_of(way, steps, step, before, base.ay, base.last_ay, base.before_ay)
    # vertical motion
    if is_whole:
        base.az = of.z / of.mass
        base.jz = slope_of(way, steps, step, before, base.az, base.last_az, base.before_az)
    return OK
