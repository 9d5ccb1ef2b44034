"""A joint that slides (theory.md section 9): where its faces touch, and what it bears along itself.

The contact belongs to the block above: its middle has moved by half of the slip from the middle of the joint. Pressure
acts along the normal of the lower face, which is turned by half of the joint's rotation against that of the joint: the
part of it along the joint is called drift. Friction and dowel bear the rest.
"""

from ..jit import by_width, leaf
from ..lanes import LANES

RIGID = 1e300  # N, as the dowel of a joint that never slides


def can_slide(model):
    """Whether some joint of the column may slide; in lanes none does."""
    raise NotImplementedError("for kernels only")


@by_width(can_slide)
def _choose(model):
    if model.kind is LANES:
        return lambda model: False
    return lambda model: model.settings.slides != 0.0


@leaf
def slip_of(model, phase, i):
    """Slip of joint i and its rate."""
    if can_slide(model):
        return phase.slip[i], phase.slip_rate[i]
    return 0.0, 0.0


@leaf
def opening_felt(opening, slip, slope):
    """Opening of a joint in the middle of its contact, m."""
    return opening - 0.5 * slip * slope


@leaf
def opening_rate_felt(opening_rate, slip, slip_rate, slope, slope_rate):
    """Rate of that, m/s."""
    return opening_rate - 0.5 * (slip_rate * slope + slip * slope_rate)


@leaf
def drift(normal, sine):
    """Part of the pressure along the joint, N, on the block above; sine of half the joint's rotation."""
    return -normal * sine


@leaf
def bearable(blocks, i, normal):
    """What joint i bears along itself, N: without end where it never slides."""
    return blocks.friction[i] * normal + blocks.dowel[i]
