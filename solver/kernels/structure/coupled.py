"""The base of a structure that inputs turn, or that bodies drive: an exchange without feedthrough (theory.md 15).

A structure has no mass of its own at its base, whose joints are elastic along themselves.
"""

from typing import NamedTuple

from ..formulations.coupled_base import SINGULAR, are_silent, goes_on, slope_of
from ..layout.spaces import BODY_LACKING, HORIZONTAL, OK
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.views import Record
from .layout import LOAD
from .turning import rotation_at, turn_beneath

INPUTS = Record("ax", "ay", "az", "jx", "jy", "jz")  # m/s2; m/s3, their slopes; then INPUT_LOADS of the ports
# behind them where the base may turn: rad, rad/s, rad/s2
ROTATION = Record("theta_x", "theta_y", "omega_x", "omega_y", "alpha_x", "alpha_y")
BODY = Record("F0x", "F0y", "F0z", "M")  # then, of each body that drives the base: N, kg
# behind it where the base may turn: N m; kg m, of motion along x with turns about y, and along y about x; kg m2
TURNING_BODY = Record("F0mx", "F0my", "Mxry", "Myrx", "Jxx", "Jyy", "Jxy")

_inputs, _rotation, _body, _turning_body = INPUTS.over, ROTATION.over, BODY.over, TURNING_BODY.over
_INPUTS, _ROTATION, _BODY, _TURNING_BODY = INPUTS.beside, ROTATION.beside, BODY.beside, TURNING_BODY.beside
_LOAD = len(LOAD)


@leaf
def start_at(base, t):
    """Let time t0 be t: the rotation of the base goes on from there."""
    base.theta_x, base.theta_y, base.omega_x, base.omega_y = rotation_at(base, t)
    past = t - base.t0
    base.alpha_x, base.alpha_y = base.alpha_x + past * base.jalpha_x, base.alpha_y + past * base.jalpha_y
    base.t0 = t


@leaf
def turned_by(scene, inputs):
    """The rotation that is given, rad and rad/s, and its acceleration."""
    return _rotation(inputs[_INPUTS + 2 * _LOAD * scene.extras.spotted :], 0)


@kernel
def turn(scene, phase, base, inputs):
    """Turn the base as its inputs say: where it has not come to this alone, beneath blocks that stay as they are.

    Before the first step all that stands on it is turned with it, and has no rate.
    """
    turned = turned_by(scene, inputs)
    x, y, u, v = turned.theta_x, turned.theta_y, turned.omega_x, turned.omega_y
    if scene.counts.started == 0:
        base.theta_x, base.theta_y, base.omega_x, base.omega_y = x, y, 0.0, 0.0
    if x != base.theta_x or y != base.theta_y or u != base.omega_x or v != base.omega_y:
        turn_beneath(scene, phase, base, x, y, u, v)


@leaf
def _place_of(scene, k):
    """Place among the inputs of what body k that drives the base says: it says more, where the base may turn."""
    turns = int(scene.settings.turns)
    first = _INPUTS + 2 * _LOAD * scene.extras.spotted + _ROTATION * turns
    return first + k * (_BODY + _TURNING_BODY * turns)


@leaf
def _said(scene, inputs, k):
    """What body k says, and what it says of turns."""
    said = inputs[_place_of(scene, k) :]
    return _body(said, 0), _turning_body(said[_BODY:], 0)


@leaf
def _have_said_nothing(scene, inputs):
    first = _place_of(scene, 0)
    return are_silent(inputs, first, _place_of(scene, int(scene.settings.bodies)) - first)


@kernel
def arrive(scene, phase, base, inputs, t):
    """Let the base come to time t, and turn it as inputs say where bodies do not: before the structure is seen at t.

    Where time has gone on since the last exchange, the accelerations of that are kept.
    """
    if goes_on(base, t):
        base.before_ax, base.before_ay, base.before_az = base.last_ax, base.last_ay, base.last_az
        base.before_alpha_x, base.before_alpha_y = base.last_alpha_x, base.last_alpha_y
        base.last_ax, base.last_ay, base.last_az = base.ax, base.ay, base.az
        base.last_alpha_x, base.last_alpha_y = base.alpha_x, base.alpha_y
    start_at(base, t)
    if scene.settings.turns != 0.0 and (base.coupled == 0.0 or scene.settings.drive == HORIZONTAL):
        turn(scene, phase, base, inputs)


class Sums(NamedTuple):
    """Forces and masses at the base, of all bodies and the structure: N, N m, kg, kg m, kg m2."""

    x: float
    y: float
    z: float
    mx: float
    my: float
    mass: float
    with_y: float  # of motion along x with turns about y
    with_x: float  # of motion along y with turns about x
    xx: float
    yy: float
    xy: float


@leaf
def _sums(scene, inputs, flat, reaction):
    """All that acts at the base; of a structure that moves in the plane x, z alone (flat) nothing across it."""
    x, y, z, mass = reaction[0], 0.0 if flat else reaction[1], reaction[2], 0.0
    mx, my, with_y, with_x, xx, yy, xy = 0.0 if flat else reaction[3], reaction[4], 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(int(scene.settings.bodies)):
        body, turning = _said(scene, inputs, k)
        x, y, z, mass = x + body.F0x, y + body.F0y, z + body.F0z, mass + body.M
        if scene.settings.turns != 0.0:
            mx, my, with_y, with_x = mx + turning.F0mx, my + turning.F0my, with_y + turning.Mxry, with_x + turning.Myrx
            xx, yy, xy = xx + turning.Jxx, yy + turning.Jyy, xy + turning.Jxy
    return Sums(x, y, z, mx, my, mass, with_y, with_x, xx, yy, xy)


@leaf
def _turns_of(of):
    """(code, alpha_x, alpha_y) of a base that bodies turn, rad/s2: without what moves along x and y with it."""
    mx, my = of.mx - of.with_x * of.y / of.mass, of.my - of.with_y * of.x / of.mass
    xx, yy = of.xx - of.with_x * of.with_x / of.mass, of.yy - of.with_y * of.with_y / of.mass
    whole = xx * yy
    left = whole - of.xy * of.xy
    if not (xx > 0.0 and yy > 0.0 and left > SINGULAR * whole):
        return BODY_LACKING, 0.0, 0.0
    return OK, (yy * mx - of.xy * my) / left, (xx * my - of.xy * mx) / left


@kernel
def exchange(scene, base, inputs, flat, reaction):
    """Let the base, which has arrived, go on as bodies and the structure drive it (formulations/coupled_base.py).

    Returns a code. flat: whether the structure moves in the plane x, z alone. reaction: its force and couple on the
    base, along fixed axes.
    """
    settings, given, of = scene.settings, _inputs(inputs, 0), _sums(scene, inputs, flat, reaction)
    turns, is_whole = settings.turns != 0.0, settings.drive != HORIZONTAL
    base.coupled = 1.0
    if not of.mass > 0.0:  # without one it does not accelerate
        base.ax, base.ay, base.az, base.jx, base.jy, base.jz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        base.alpha_x, base.alpha_y, base.jalpha_x, base.jalpha_y = 0.0, 0.0, 0.0, 0.0
        return OK if _have_said_nothing(scene, inputs) else BODY_LACKING
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
    x, y = of.x - of.with_y * base.alpha_y, of.y - of.with_x * base.alpha_x
    base.ax, base.ay, base.az, base.jz = x / of.mass, y / of.mass, given.az, given.jz
    base.jx = slope_of(way, steps, step, before, base.ax, base.last_ax, base.before_ax)
    base.jy = slope_of(way, steps, step, before, base.ay, base.last_ay, base.before_ay)
    if is_whole:
        base.az = of.z / of.mass
        base.jz = slope_of(way, steps, step, before, base.az, base.last_az, base.before_az)
    return OK
