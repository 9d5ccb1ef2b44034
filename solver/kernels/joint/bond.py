"""A brittle joint: a part of its contact is bonded, and bears tension until it breaks (docs/mortar.md).

A fibre is whole while it has never been stretched by more than the reach, strength over stiffness, without its damper.
Those of one place of the joint that are whole lie on one side of a line: the bond is one interval, which only shrinks.
It bears stiffness * (pen + damping * dpen/dt), pressed or pulled. Beside it, on either side, the joint is dry.

A crack grows while the fibre at its front is pulled further: the bond then ends where the stretch is the reach. So the
law is smooth in a regime: BONDED, GROWS_LEFT or GROWS_RIGHT, and of each dry side a regime of regimes.py, or NOTHING.
"""

from typing import NamedTuple

from ..numba_ext.jit import leaf
from ..sections.section import Contact
from .law import held_forces, joint_forces, loaded_part, positive_part, pressure_forces
from .regimes import contact_regime, regime_margin

NOTHING = 0  # there is no dry part on that side
OF_SIDE = 31  # mask of the regime of a dry side, the left one; that of the right one stands RIGHT_SIDE bits before it
RIGHT_SIDE = 5
GROWS_LEFT, GROWS_RIGHT, BONDED = 1 << 10, 1 << 11, 1 << 12
LEAST = 1e-9  # of the contact: a bond that is shorter is broken
ROUNDING = 1e-12  # of the stretches: a front within it is at the end of the bond


class Bond(NamedTuple):
    """What is bonded of a joint: ends in m from the middle of the block, none if left is right; and its reach, m."""

    left: float
    right: float
    reach: float


BROKEN = 0.0, 0.0  # ends of what is not bonded


@leaf
def whole_part(bond, opening, slope):
    """What is left of the bond in this place of the joint: its ends."""
    spare = bond.reach - opening
    if slope == 0.0:
        return (bond.left, bond.right) if spare >= 0.0 else BROKEN
    return positive_part(spare, slope, bond.left, bond.right)


@leaf
def bonded_part(contact, bond, opening, slope):
    """As `whole_part`; a remainder that is too short is broken."""
    left, right = whole_part(bond, opening, slope)
    return (left, right) if right - left > LEAST * (contact.right - contact.left) else BROKEN


@leaf
def _side(contact, left, right):
    """A part of a contact."""
    _, _, _, depth, bore, strips, slip, around, round_bore, rim = contact
    return Contact(contact.section, left, right, depth, bore, strips, slip, around, round_bore, rim)


@leaf
def bonded_forces(contact, law, bond, opening, slope, opening_rate, slope_rate):
    """N, M, length in contact, and the ends of the part that is bonded in this motion; `bond`: before it.

    In contact is what is bonded, and what else is loaded.
    """
    left, right = bonded_part(contact, bond, opening, slope)
    if not left < right:
        force, moment, length = joint_forces(contact, law, opening, slope, opening_rate, slope_rate)
        return force, moment, length, left, right
    motion = opening, slope, opening_rate, slope_rate
    force, moment = _pull(contact, law, left, right, *motion)
    # each side of its own, then their sum: mirror images have mirrored sums
    before, after = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if contact.left < left:
        before = joint_forces(_side(contact, contact.left, left), law, *motion)
    if right < contact.right:
        after = joint_forces(_side(contact, right, contact.right), law, *motion)
    force, moment = force + (before[0] + after[0]), moment + (before[1] + after[1])
    return force, moment, _in_contact(contact, left, right, before[2], after[2]), left, right


@leaf
def _in_contact(contact, left, right, before, after):
    """Length in contact of a joint bonded from left to right; before, after: loaded of the sides."""
    return (contact.right - contact.left) - (((left - contact.left) - before) + ((contact.right - right) - after))


@leaf
def _pull(contact, law, left, right, opening, slope, opening_rate, slope_rate):
    """N and M of the bonded part, pressed or pulled."""
    mean, gradient = opening + law.damping * opening_rate, slope + law.damping * slope_rate
    return pressure_forces(contact, law, left, right, right - left, mean, gradient)


@leaf
def bond_regime(contact, damping, bond, opening, slope, opening_rate, slope_rate):
    """The regime of a bonded joint in this motion."""
    regime, left, right = BONDED, bond.left, bond.right
    near = ROUNDING * (abs(opening) + abs(slope) * max(-left, right) + bond.reach)
    if slope > 0.0:
        front = (opening - bond.reach) / slope
        if left * slope - opening + bond.reach <= near and front * slope_rate - opening_rate < 0.0:
            regime += GROWS_LEFT
            left = front
    elif slope < 0.0:
        front = (opening - bond.reach) / slope
        if right * slope - opening + bond.reach <= near and front * slope_rate - opening_rate < 0.0:
            regime += GROWS_RIGHT
            right = front
    if contact.left < left and not regime & GROWS_LEFT:
        regime += contact_regime(contact.left, left, damping, opening, slope, opening_rate, slope_rate)
    if right < contact.right and not regime & GROWS_RIGHT:
        beyond = contact_regime(right, contact.right, damping, opening, slope, opening_rate, slope_rate)
        regime += beyond << RIGHT_SIDE
    return regime


@leaf
def _front(regime, bond, opening, slope):
    """Ends of the bonded part by a regime."""
    left, right = bond.left, bond.right
    if regime & GROWS_LEFT:
        left = (opening - bond.reach) / slope
    if regime & GROWS_RIGHT:
        right = (opening - bond.reach) / slope
    return left, right


@leaf
def _margin_of_ends(regime, contact, bond, left, right, opening, slope, opening_rate, slope_rate):
    """How far the ends of a bond are from giving way, m; of one that grows how fast its front is pulled, m/s."""
    if regime & (GROWS_LEFT | GROWS_RIGHT):
        front = left if regime & GROWS_LEFT else right
        remains = (right - left) - LEAST * (contact.right - contact.left)
        return min(opening_rate - front * slope_rate, remains)
    return min(left * slope, right * slope) - opening + bond.reach


@leaf
def held_bonded_forces(regime, contact, law, bond, opening, slope, opening_rate, slope_rate):
    """As `bonded_forces`, by the formula of a regime even where it does not apply, and the margin left.

    Of the length in contact only the bonded part and loaded sides.
    """
    left, right = _front(regime, bond, opening, slope)
    motion = opening, slope, opening_rate, slope_rate
    force, moment = _pull(contact, law, left, right, *motion)
    margin = _margin_of_ends(regime, contact, bond, left, right, *motion)
    before, after = (0.0, 0.0, 0.0, margin), (0.0, 0.0, 0.0, margin)
    side, beyond = regime & OF_SIDE, (regime >> RIGHT_SIDE) & OF_SIDE
    if side != NOTHING:
        before = held_forces(side, _side(contact, contact.left, left), law, *motion)
    if beyond != NOTHING:
        after = held_forces(beyond, _side(contact, right, contact.right), law, *motion)
    force, moment = force + (before[0] + after[0]), moment + (before[1] + after[1])
    length, margin = _in_contact(contact, left, right, before[2], after[2]), min(margin, before[3], after[3])
    return force, moment, length, left, right, margin


@leaf
def bond_margin(regime, contact, damping, bond, opening, slope, opening_rate, slope_rate):
    """How far a bonded joint is from leaving a regime: m, or m/s of a front; negative beyond."""
    left, right = _front(regime, bond, opening, slope)
    motion = opening, slope, opening_rate, slope_rate
    margin = _margin_of_ends(regime, contact, bond, left, right, *motion)
    side, beyond = regime & OF_SIDE, (regime >> RIGHT_SIDE) & OF_SIDE
    if side != NOTHING:
        margin = min(margin, regime_margin(side, contact.left, left, damping, *motion))
    if beyond != NOTHING:
        margin = min(margin, regime_margin(beyond, right, contact.right, damping, *motion))
    return margin


@leaf
def bonded_peak_pressure(contact, law, left, right, opening, slope, opening_rate, slope_rate):
    """Largest pressure on a joint of which the part from left to right is bonded, Pa: at an end of a part."""
    mean, gradient = opening + law.damping * opening_rate, slope + law.damping * slope_rate
    lo, hi = loaded_part(contact.left, contact.right, law.damping, opening, slope, opening_rate, slope_rate)
    most = max(gradient * left, gradient * right) - mean if left < right else 0.0
    if lo < hi:
        most = max(most, max(gradient * lo, gradient * hi) - mean)
    return max(0.0, law.stiffness * most)
