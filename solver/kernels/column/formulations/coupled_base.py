"""The base as a body that a partner moves too, which both solve for: a coupling without feedthrough (theory.md, 15).

The partner sends what its state determines, its force F0 and its mass M at the base, and the column R0 and m:

    (M + m) a = F0 + R0

is the acceleration of the base at the instant of the exchange, the same on both sides. Over the step both extrapolate
it with the same slope, from the accelerations at the steps before, so that the base is in one place for both.
"""

from typing import NamedTuple

from ...engine.exchange import SINGULAR, are_silent, goes_on, gone_on, slope_of
from ...layout.spaces import (
    ACCELERATION,
    BODY_LACKING,
    DRIVEN,
    HORIZONTAL,
    OK,
    SPLIT,
)
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.views import Record, clear
from .base_motion import base_spin, base_turn

# inputs of each body at the base: force, N and N m, and mass, kg, kg m and kg m2
BODY = Record("F0x", "F0z", "F0m", "Mxx", "Mxz", "Mxt", "Mzz", "Mzt", "Mtt")

_body, _BODY = BODY.over, BODY.beside
_driven, _DRIVEN, _SPLIT = DRIVEN.over, DRIVEN.beside, SPLIT.beside


class Sums(NamedTuple):
    """The forces and masses at the base, of all bodies and the column: N, N m, kg, kg m, kg m2."""

    x: float
    z: float
    m: float
    xx: float
    xz: float
    xt: float
    zz: float
    zt: float
    tt: float


@leaf
def sums(bodies, inputs, first, split):
    """Return forces and masses at the base, of the bodies in `inputs` from place `first` on and of the column.

    Those of the column are R0 and m in `split`; bodies: their number.
    """
    x, z, m = split.R0x, split.R0z, split.R0m
    xx, xz, xt, zz, zt, tt = split.mxx, split.mxz, split.mxt, split.mzz, split.mzt, split.mtt
    for k in range(bodies):
        body = _body(inputs[first + k * _BODY :], 0)
        x, z, m = x + body.F0x, z + body.F0z, m + body.F0m
        xx, xz, xt = xx + body.Mxx, xz + body.Mxz, xt + body.Mxt
        zz, zt, tt = zz + body.Mzz, zt + body.Mzt, tt + body.Mtt
    return Sums(x, z, m, xx, xz, xt, zz, zt, tt)


@leaf
def solve(drive, of, az, alpha):
    """Return (code, ax, az, alpha) of the base, m/s2 and rad/s2.

    az and alpha are given where it is driven along x alone.
    """
    # one equation along x
    if drive == HORIZONTAL:
        if not of.xx > 0.0:
            return BODY_LACKING, 0.0, 0.0, 0.0
        return OK, (of.x - of.xz * az - of.xt * alpha) / of.xx, az, alpha
    if not (of.xx > 0.0 and of.zz > 0.0 and of.tt > 0.0):
        return BODY_LACKING, 0.0, 0.0, 0.0
    # eliminate x, then z
    by_z, by_t = of.xz / of.xx, of.xt / of.xx
    zz, zt = of.zz - by_z * of.xz, of.zt - by_z * of.xt
    if not zz > SINGULAR * of.zz:
        return BODY_LACKING, 0.0, 0.0, 0.0
    by = zt / zz
    tt = of.tt - by_t * of.xt - by * zt
    if not tt > SINGULAR * of.tt:
        return BODY_LACKING, 0.0, 0.0, 0.0
    # back substitution
    z, m = of.z - by_z * of.x, of.m - by_t * of.x
    turned = (m - by * z) / tt
    lifted = (z - zt * turned) / zz
    return OK, (of.x - of.xz * lifted - of.xt * turned) / of.xx, lifted, turned


@kernel
def show_driven(base, settings, t, split):
    """Fill the row behind a split reaction with the motion of the base at time t (DRIVEN), where bodies may drive it.

    It is all zeros while its own inputs move the base.
    """
    if settings.bodies == 0.0:
        return
    shown, past = _driven(split.buffer[_SPLIT:], 0), t - base.t0
    clear(shown.row, _DRIVEN)
    if settings.drive != ACCELERATION:
        shown.x, shown.vx, shown.ax = gone_on(base.x, base.vx, base.ax, base.jx, past)
        shown.z, shown.vz, shown.az = gone_on(base.z, base.vz, base.az, base.jz, past)
        shown.theta, shown.omega = base_turn(base, t), base_spin(base, t)
        shown.alpha = base.alpha + past * base.jalpha


@kernel
def show_driven_rates(base, settings, t, split):
    """Fill the row behind a split reaction with the rates of `show_driven`."""
    if settings.bodies == 0.0:
        return
    show_driven(base, settings, t, split)
    shown = _driven(split.buffer[_SPLIT:], 0)
    # rates of coordinates, of velocities, of accelerations
    shown.x, shown.z, shown.theta = shown.vx, shown.vz, shown.omega
    shown.vx, shown.vz, shown.omega = shown.ax, shown.az, shown.alpha
    shown.ax, shown.az, shown.alpha = 0.0, 0.0, 0.0
    if settings.drive != ACCELERATION:
        shown.ax, shown.az, shown.alpha = base.jx, base.jz, base.jalpha


@kernel
def show_driven_along(settings, turn, spin, along_x, along_z, alpha, split):
    """Fill the row behind a split reaction with the derivative of `show_driven` along rotation and accelerations."""
    if settings.bodies == 0.0:
        return
    shown = _driven(split.buffer[_SPLIT:], 0)
    clear(shown.row, _DRIVEN)
    if settings.drive != ACCELERATION:
        shown.theta, shown.omega, shown.ax, shown.az, shown.alpha = turn, spin, along_x, along_z, alpha


@kernel
def arrive(base, settings, given, t):
    """Advance the base to time t, and turn it by its inputs where bodies do not: before its column is observed at t.

    Where time has advanced since the last exchange, the accelerations of that are kept. given: inputs of the base by
    name.
    """
    # displacements and velocities
    past = t - base.t0
    base.x, base.vx, _ = gone_on(base.x, base.vx, base.ax, base.jx, past)
    base.z, base.vz, _ = gone_on(base.z, base.vz, base.az, base.jz, past)
    # shift the history of accelerations, and turn the base
    if goes_on(base, t):
        base.before_ax, base.before_az, base.before_alpha = base.last_ax, base.last_az, base.last_alpha
        base.last_ax, base.last_az, base.last_alpha = base.ax, base.az, base.alpha
        base.theta, base.omega = base_turn(base, t), base_spin(base, t)
    # accelerations at t
    base.ax, base.az, base.alpha = base.ax + base.jx * past, base.az + base.jz * past, base.alpha + base.jalpha * past
    if settings.drive == HORIZONTAL or base.coupled == 0.0:
        base.theta, base.omega = given.theta, given.omega
    base.t0 = t


@kernel
def couple(base, settings, given, inputs, first, split):
    """Set the accelerations of the base, which has arrived, and their slopes from bodies and column; return a code.

    Without a mass, and before a body has sent anything, the bodies do not accelerate the base.

    Parameters
    ----------
    base, settings
        The base, and the settings of the column.
    given : record
        Inputs of the base by name.
    inputs : row
        Inputs, those of the bodies from place `first` on.
    first : int
        Place of the first body.
    split : record
        R0 and m of the column.

    Returns
    -------
    int
        OK, or BODY_LACKING.
    """
    bodies, code, ax, az, alpha = int(settings.bodies), OK, 0.0, 0.0, 0.0
    # driven along x alone, it has the other accelerations of its inputs in any case
    if settings.drive == HORIZONTAL:
        az, alpha = given.az, given.alpha
    base.mass_x, base.mass_z, base.mass_turn = 0.0, 0.0, 0.0
    # accelerations: (M + m) a = F0 + R0
    if not are_silent(inputs, first, bodies * _BODY):
        of = sums(bodies, inputs, first, split)
        base.mass_x, base.mass_z, base.mass_turn = of.xx, of.zz, of.tt
        code, ax, az, alpha = solve(settings.drive, of, given.az, given.alpha)
    base.ax, base.az, base.alpha = ax, az, alpha
    # their slopes until the next exchange
    way, steps, step, before = settings.slope, base.steps, base.last_step, base.before_step
    base.jx = slope_of(way, steps, step, before, ax, base.last_ax, base.before_ax)
    if settings.drive == HORIZONTAL:
        base.jz, base.jalpha = given.jz, 0.0
    else:
        base.jz = slope_of(way, steps, step, before, az, base.last_az, base.before_az)
        base.jalpha = slope_of(way, steps, step, before, alpha, base.last_alpha, base.before_alpha)
    base.coupled = 1.0
    return code


@kernel
def driven_along(settings, inputs, seeds, first, split, met, motion, az, alpha):
    """Return the change of (ax, az, alpha) of the base (m/s2, rad/s2) as its inputs change by `seeds`.

    Parameters
    ----------
    settings
        The settings of the column.
    inputs, seeds : row
        Inputs and their changes, those of the bodies from place `first` on.
    first : int
        Place of the first body.
    split, met : record
        R0 and m of the column, and their change.
    motion : Motion
        Motion of the base.
    az, alpha : float
        Changes of its own inputs, m/s2 and rad/s2.
    """
    bodies = int(settings.bodies)
    # before a body has sent anything the base moves by its own inputs alone
    if are_silent(inputs, first, bodies * _BODY):
        own = 1.0 if settings.drive == HORIZONTAL else 0.0
        return 0.0, own * az, own * alpha
    # right side: change of the forces less change of the masses times the accelerations
    of, change = sums(bodies, inputs, first, split), sums(bodies, seeds, first, met)
    x, z, m = change.x, change.z, change.m
    xx, xz, xt, zz, zt, tt = change.xx, change.xz, change.xt, change.zz, change.zt, change.tt
    x -= xx * motion.ax + xz * motion.az + xt * motion.alpha
    z -= xz * motion.ax + zz * motion.az + zt * motion.alpha
    m -= xt * motion.ax + zt * motion.az + tt * motion.alpha
    changed = Sums(x, z, m, of.xx, of.xz, of.xt, of.zz, of.zt, of.tt)
    _, along_x, along_z, turned = solve(settings.drive, changed, az, alpha)
    return along_x, along_z, turned
