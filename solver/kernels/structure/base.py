"""The base acceleration in three components: record samples, plus a horizontal harmonic, plus inputs.

The acceleration of the record is zero before its first and after its last sample, and so is the harmonic part.
"""

import math

from ..engine.samples import is_silent
from ..numba_ext.jit import by_width, kernel, leaf
from ..numba_ext.lanes import LanesType, any_of
from ..numba_ext.numbers import sine


@by_width
def acceleration(scene, k, t):
    """Return the base acceleration (ax, ay, az), m/s2, at time t (s) on segment k.

    In lanes each lane has its own segment, whose line is in `scene.base` (in_lanes.py); k is not used then.
    """
    return _of_lanes if isinstance(t, LanesType) else _of_one


def _of_lanes(scene, k, t):
    base = scene.base
    past = t - base.t0
    # the line of the segment, then the harmonic
    ax, ay, az = base.ax + base.jx * past, base.ay + base.jy * past, base.az + base.jz * past
    if any_of((base.amplitude_x != 0.0) | (base.amplitude_y != 0.0)):
        wave = sine(base.omega * t + base.phase)
        ax += base.amplitude_x * wave
        ay += base.amplitude_y * wave
    return ax, ay, az


def _of_one(scene, k, t):
    base, samples, scale = scene.base, scene.samples, scene.samples.scale
    past = t - base.t0
    # inputs, linear in time
    beside = base.ax + base.jx * past, base.ay + base.jy * past, base.az + base.jz * past
    if is_silent(samples, k):
        return beside
    # record: held samples, or straight lines between them
    ax, ay, az = scale * samples.ax[k], scale * samples.ay[k], scale * samples.az[k]
    if samples.held == 0:
        part = (t - samples.times[k]) / (samples.times[k + 1] - samples.times[k])
        ax += part * (scale * samples.ax[k + 1] - ax)
        ay += part * (scale * samples.ay[k + 1] - ay)
        az += part * (scale * samples.az[k + 1] - az)
    # harmonic
    if base.omega != 0.0:
        sine = math.sin(base.omega * t + base.phase)
        ax += base.amplitude_x * sine
        ay += base.amplitude_y * sine
    return beside[0] + ax, beside[1] + ay, beside[2] + az


@leaf
def line(scene, k, t):
    """Return the part of the base acceleration that is linear in time on segment k, and its slope.

    Returns
    -------
    ax, ay, az, jx, jy, jz : float
        Value at time t, m/s2, and slope, m/s3.
    """
    base, samples, scale = scene.base, scene.samples, scene.samples.scale
    past = t - base.t0
    # inputs
    ax, ay, az = base.ax + base.jx * past, base.ay + base.jy * past, base.az + base.jz * past
    jx, jy, jz = base.jx, base.jy, base.jz
    if is_silent(samples, k):
        return ax, ay, az, jx, jy, jz
    # record: the same bits by a scale and by samples that are scaled
    here_x, here_y, here_z = scale * samples.ax[k], scale * samples.ay[k], scale * samples.az[k]
    ax, ay, az = ax + here_x, ay + here_y, az + here_z
    if samples.held != 0:
        return ax, ay, az, jx, jy, jz
    # slope of the straight line between samples
    per, within = 1.0 / (samples.times[k + 1] - samples.times[k]), t - samples.times[k]
    x = per * (scale * samples.ax[k + 1] - here_x)
    y = per * (scale * samples.ay[k + 1] - here_y)
    z = per * (scale * samples.az[k + 1] - here_z)
    return ax + x * within, ay + y * within, az + z * within, jx + x, jy + y, jz + z


@kernel
def is_quiet(scene, k):
    """Return True if the base and its inputs are still and no load acts from segment k on."""
    base, samples = scene.base, scene.samples
    # inputs
    pushed = base.ax != 0.0 or base.ay != 0.0 or base.az != 0.0
    pushed = pushed or base.jx != 0.0 or base.jy != 0.0 or base.jz != 0.0
    return k >= samples.size - 1 and not pushed
