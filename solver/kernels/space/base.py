"""The acceleration of the base in three components: samples, and a horizontal harmonic beside them."""

import math
from typing import NamedTuple

from ..formulations.base_motion import segment_at
from ..numba_ext.jit import kernel, leaf

SLACK = 1e-9  # of a sampling interval: instants closer than this are equal


class Shaking(NamedTuple):
    """Samples of the base acceleration, m/s2 at times in s; before the first and after the last it is zero."""

    size: int
    times: object
    ax: object
    ay: object
    az: object
    base: object  # BASE


@leaf
def segment_after(shaking, t):
    """Number of the sample from which a step that begins at time t goes on; -1 before the first."""
    k = segment_at(shaking, t)
    if 0 <= k + 1 < shaking.size:
        width = shaking.times[1] - shaking.times[0] if k < 0 else shaking.times[k + 1] - shaking.times[k]
        if shaking.times[k + 1] - t <= SLACK * width:
            k += 1
    return k


@leaf
def is_still(shaking, k):
    """Whether the base does not accelerate from sample k on until the next."""
    return k < 0 or k >= shaking.size - 1


@leaf
def acceleration(shaking, k, t):
    """(ax, ay, az) of the base at time t on segment k, m/s2."""
    if is_still(shaking, k):
        return 0.0, 0.0, 0.0
    ax, ay, az = shaking.ax[k], shaking.ay[k], shaking.az[k]
    if shaking.base.held == 0.0:
        part = (t - shaking.times[k]) / (shaking.times[k + 1] - shaking.times[k])
        ax += part * (shaking.ax[k + 1] - ax)
        ay += part * (shaking.ay[k + 1] - ay)
        az += part * (shaking.az[k + 1] - az)
    if shaking.base.omega != 0.0:
        sine = math.sin(shaking.base.omega * t + shaking.base.phase)
        ax += shaking.base.amplitude_x * sine
        ay += shaking.base.amplitude_y * sine
    return ax, ay, az


@kernel
def is_quiet(shaking, k):
    """Whether the base stays still for good from segment k on."""
    return k >= shaking.size - 1
