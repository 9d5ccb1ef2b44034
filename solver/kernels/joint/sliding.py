"""A joint that slides, or is built off its axis (theory.md section 9): where it touches, what it bears along itself.

The contact belongs to the block above: its middle has moved by half of the slip from the middle of the joint. Pressure
acts along the normal of the lower face, which is turned by half of the joint's rotation against that of the joint: the
part of it along the joint is called drift, with what a rim adds that cuts the contact off. Friction and dowel bear the
rest.
"""

from ..jit import by_width, leaf
from ..lanes import LANES, LanesType
from .section import contact_of, depth_at

RIGID = 1e300  # N, as the dowel of a joint that never slides


def can_slide(model):
    """Whether slips are coordinates of the column: some joint may slide, or it is off its axis. In lanes none is."""
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
def drift(normal, sine, at_rim):
    """Part of the pressure along the joint, N, on the block above; sine of half the joint's rotation."""
    return at_rim - normal * sine


def rim_force(blocks, i, opening, slope, slip):
    """What the rim that cuts the contact of joint i off pushes the block above outwards by, N, towards +x.

    The elastic energy that a slip of a metre takes off the contact: else energy would be lost or won by it.
    """
    raise NotImplementedError("for kernels only")


@by_width(rim_force)
def _choose_rim_force(blocks, i, opening, slope, slip):
    if isinstance(slip, LanesType):
        return lambda blocks, i, opening, slope, slip: 0.0 * slip
    return _rim_force_of_one


def _rim_force_of_one(blocks, i, opening, slope, slip):
    contact = contact_of(blocks, i, slip)
    edge, whole = (contact.right, blocks.right[i]) if slip > 0.0 else (contact.left, blocks.left[i])
    if edge == whole or not contact.left < contact.right:
        return 0.0
    pressed = max(0.0, slope * edge - opening)
    force = 0.5 * blocks.stiffness[i] * pressed * pressed * depth_at(contact, edge)
    return force if slip > 0.0 else -force


@leaf
def bearable(blocks, i, normal):
    """What joint i bears along itself, N: without end where it never slides."""
    return blocks.friction[i] * normal + blocks.dowel[i]
