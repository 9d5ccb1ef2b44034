"""The base acceleration in three components: record samples, plus a horizontal harmonic, plus inputs."""

import math
from typing import NamedTuple

from ..engine.samples import segment_at
from ..numba_ext.jit import by_width, kernel, leaf
from ..numba_ext.lanes import LanesType, any_of
from ..numba_ext.numbers import sine

SLACK = 1e-9  # of a sampling interval: closer instants are equal


class Shaking(NamedTuple):
    """The samples of the base acceleration and of the loads at ports, and the inputs added to them.

    The acceleration is zero before the first and after the last sample.

    Attributes
    ----------
    size, shaken : int
        Number of `times`, and of those that have a sample of the base; loads may go on after the base.
    times : row
        Times of the samples, s.
    ax, ay, az : row
        Samples of the acceleration, m/s2.
    base : record BASE
        Harmonic part, inputs and rotation of the base.
    loaded : int
        1 if there are loads at ports.
    loads : row
        For each interval, the values of all loads at its start, then their slopes (port.py).
    inputs : row
        INPUT_LOADS at time t0 of `base`.
    """

    size: int  # of times
    shaken: int  # of them with a sample of the base
    times: object
    ax: object
    ay: object
    az: object
    base: object  # BASE
    loaded: int  # 1: there are loads
    loads: object
    inputs: object  # INPUT_LOADS, at time t0


@leaf
def segment_after(shaking, t):
    """Return the index of the sample from which a step that begins at time t continues; -1 before the first."""
    k = segment_at(shaking, t)
    # a time just before a sample belongs to the next interval
    if 0 <= k + 1 < shaking.size:
        width = shaking.times[1] - shaking.times[0] if k < 0 else shaking.times[k + 1] - shaking.times[k]
        if shaking.times[k + 1] - t <= SLACK * width:
            k += 1
    return k


@leaf
def is_still(shaking, k):
    """Return True if the record is zero on the interval from sample k to the next."""
    return k < 0 or k >= shaking.shaken - 1


@by_width
def acceleration(shaking, k, t):
    """Return the base acceleration (ax, ay, az), m/s2, at time t (s) on segment k.

    In lanes each lane has its own segment, whose line is in `shaking.base` (in_lanes.py); k is not used then.
    """
    return _of_lanes if isinstance(t, LanesType) else _of_one


def _of_lanes(shaking, k, t):
    base = shaking.base
    past = t - base.t0
    # the line of the segment, then the harmonic
    ax, ay, az = base.ax + base.jx * past, base.ay + base.jy * past, base.az + base.jz * past
    if any_of((base.amplitude_x != 0.0) | (base.amplitude_y != 0.0)):
        wave = sine(base.omega * t + base.phase)
        ax += base.amplitude_x * wave
        ay += base.amplitude_y * wave
    return ax, ay, az


def _of_one(shaking, k, t):
    base = shaking.base
    past = t - base.t0
    # inputs, linear in time
    beside = base.ax + base.jx * past, base.ay + base.jy * past, base.az + base.jz * past
    if is_still(shaking, k):
        return beside
    # record: held samples, or straight lines between them
    ax, ay, az = base.scale * shaking.ax[k], base.scale * shaking.ay[k], base.scale * shaking.az[k]
    if base.held == 0.0:
        part = (t - shaking.times[k]) / (shaking.times[k + 1] - shaking.times[k])
        ax += part * (base.scale * shaking.ax[k + 1] - ax)
        ay += part * (base.scale * shaking.ay[k + 1] - ay)
        az += part * (base.scale * shaking.az[k + 1] - az)
    # harmonic
    if base.omega != 0.0:
        sine = math.sin(base.omega * t + base.phase)
        ax += base.amplitude_x * sine
        ay += base.amplitude_y * sine
    return beside[0] + ax, beside[1] + ay, beside[2] + az


@leaf
def line(shaking, k, t):
    """Return the part of the base acceleration that is linear in time on segment k, and its slope.

    Returns
    -------
    ax, ay, az, jx, jy, jz : float
        Value at time t, m/s2, and slope, m/s3.
    """
    base = shaking.base
    past = t - base.t0
    # inputs
    ax, ay, az = base.ax + base.jx * past, base.ay + base.jy * past, base.az + base.jz * past
    jx, jy, jz = base.jx, base.jy, base.jz
    if is_still(shaking, k):
        return ax, ay, az, jx, jy, jz
    # record
    ax, ay, az = ax + base.scale * shaking.ax[k], ay + base.scale * shaking.ay[k], az + base.scale * shaking.az[k]
    if base.held != 0.0:
        return ax, ay, az, jx, jy, jz
    # slope of the straight line between samples
    per, within = base.scale / (shaking.times[k + 1] - shaking.times[k]), t - shaking.times[k]
    x = per * (shaking.ax[k + 1] - shaking.ax[k])
    y = per * (shaking.ay[k + 1] - shaking.ay[k])
    z = per * (shaking.az[k + 1] - shaking.az[k])
    return ax + x * within, ay + y * within, az + z * within, jx + x, jy + y, jz + z


@kernel
def is_quiet(shaking, k):
    """Return True if the base and its inputs are still and no load acts from segment k on."""
    base = shaking.base
    # inputs
    pushed = base.ax != 0.0 or base.ay != 0.0 or base.az != 0.0
    pushed = pushed or base.jx != 0.0 or base.jy != 0.0 or base.jz != 0.0
    return k >= shaking.size - 1 and not pushed
