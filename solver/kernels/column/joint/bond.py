"""A brittle joint: an interval of its contact is bonded and bears tension until it breaks (docs/mortar.md).

A fibre is whole while it has never been stretched by more than the reach, strength over stiffness, without its damper.
The whole fibres at one opening and slope lie on one side of a line: the bond is one interval, which only shrinks. It
bears stiffness * (pen + damping * dpen/dt), in compression or tension. The contact on either side of it is dry.

A crack grows while the fibre at its front is pulled further: the bond then ends where the stretch is the reach. So the
law is smooth in a regime: BONDED, GROWS_LEFT or GROWS_RIGHT, and of each dry side a regime of regimes.py, or NOTHING.
"""

from typing import NamedTuple

from ...numba_ext.jit import leaf
from ..sections.section import ContactSection
from .law import held_forces, joint_forces, loaded_part, positive_part, pressure_forces
from .regimes import contact_regime, regime_margin

NOTHING = 0  # no dry part on that side
OF_SIDE = 31  # mask of the regime of the left dry side; that of the right one is shifted by RIGHT_SIDE bits
RIGHT_SIDE = 5
GROWS_LEFT, GROWS_RIGHT, BONDED = 1 << 10, 1 << 11, 1 << 12
LEAST = 1e-9  # relative to the contact: a shorter bond is broken
ROUNDING = 1e-12  # relative to the stretches: a front this close is at the end of the bond


class Bond(NamedTuple):
    """The bond of a joint: its ends, m from the middle of the block, and its reach (m); no bond unless left < right.

    Attributes
    ----------
    left, right : float
        Ends of the bonded interval, m.
    reach : float
        Stretch at which a fibre breaks, m: strength over stiffness.
    """

    left: float
    right: float
    reach: float


BROKEN = 0.0, 0.0  # ends of a joint without a bond


@leaf
def whole_part(bond, opening, slope):
    """Return the ends (m) of the part of the bond that is whole at this opening (m) and slope (rad)."""
    spare = bond.reach - opening
    if slope == 0.0:
        return (bond.left, bond.right) if spare >= 0.0 else BROKEN
    return positive_part(spare, slope, bond.left, bond.right)


@leaf
def bonded_part(contact, bond, opening, slope):
    """Return `whole_part`, or BROKEN where it is not longer than LEAST times the contact."""
    left, right = whole_part(bond, opening, slope)
    return (left, right) if right - left > LEAST * (contact.right - contact.left) else BROKEN


@leaf
def _side(contact, left, right):
    """Return the contact restricted to the interval from left to right, m."""
    _, _, _, depth, bore, strips, slip, around, round_bore, rim = contact
    return ContactSection(contact.section, left, right, depth, bore, strips, slip, around, round_bore, rim)


@leaf
def bonded_forces(contact, law, bond, opening, slope, opening_rate, slope_rate):
    """Return N, M, the length in contact and the ends of the bonded interval in this motion.

    In contact are the bonded interval and the loaded parts of the dry sides.

    Parameters
    ----------
    contact : ContactSection
        The contact of the joint.
    law : PressureLaw
        Stiffness, N/m3, and damping, s.
    bond : Bond
        The bond before this motion.
    opening, slope, opening_rate, slope_rate : float
        Motion of the joint: m, rad, m/s, rad/s.

    Returns
    -------
    force, moment : float
        N, N (compression positive), and M, N m (restoring).
    length : float
        Length in contact, m.
    left, right : float
        Ends of the part of the bond that is left, m.
    """
    # a broken bond leaves a dry joint
    left, right = bonded_part(contact, bond, opening, slope)
    if not left < right:
        force, moment, length = joint_forces(contact, law, opening, slope, opening_rate, slope_rate)
        return force, moment, length, left, right
    # the bonded interval, in compression or tension
    motion = opening, slope, opening_rate, slope_rate
    force, moment = _pull(contact, law, left, right, *motion)
    # the dry sides separately, then their sum: mirror images have mirrored sums
    before, after = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if contact.left < left:
        before = joint_forces(_side(contact, contact.left, left), law, *motion)
    if right < contact.right:
        after = joint_forces(_side(contact, right, contact.right), law, *motion)
    force, moment = force + (before[0] + after[0]), moment + (before[1] + after[1])
    # sum of the three parts
    return force, moment, _in_contact(contact, left, right, before[2], after[2]), left, right


@leaf
def _in_contact(contact, left, right, before, after):
    """Return the length in contact (m) of a joint bonded from left to right.

    before, after: loaded lengths of the dry sides to the left and to the right, m.
    """
    return (contact.right - contact.left) - (((left - contact.left) - before) + ((contact.right - right) - after))


@leaf
def _pull(contact, law, left, right, opening, slope, opening_rate, slope_rate):
    """Return N and M of the bonded interval from left to right, in compression or tension."""
    mean, gradient = opening + law.damping * opening_rate, slope + law.damping * slope_rate
    return pressure_forces(contact, law, left, right, right - left, mean, gradient)


@leaf
def bond_regime(contact, damping, bond, opening, slope, opening_rate, slope_rate):
    """Return the regime of a bonded joint in this motion: bits of the bond and of both dry sides."""
    regime, left, right = BONDED, bond.left, bond.right
    near = ROUNDING * (abs(opening) + abs(slope) * max(-left, right) + bond.reach)
    # a front grows where the stretch at an end has come to the reach and is increasing
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
    # regimes of the dry sides
    if contact.left < left and not regime & GROWS_LEFT:
        regime += contact_regime(contact.left, left, damping, opening, slope, opening_rate, slope_rate)
    if right < contact.right and not regime & GROWS_RIGHT:
        beyond = contact_regime(right, contact.right, damping, opening, slope, opening_rate, slope_rate)
        regime += beyond << RIGHT_SIDE
    return regime


@leaf
def _front(regime, bond, opening, slope):
    """Return the ends of the bond (m) in a regime: a growing front lies where the stretch is the reach."""
    left, right = bond.left, bond.right
    # the front is at left or right where opening - slope x = reach
    if regime & GROWS_LEFT:
        left = (opening - bond.reach) / slope
    if regime & GROWS_RIGHT:
        right = (opening - bond.reach) / slope
    return left, right


@leaf
def _margin_of_ends(regime, contact, bond, left, right, opening, slope, opening_rate, slope_rate):
    """Return the margin (m) before an end of the bond breaks, or the rate of stretch (m/s) at a growing front.

    The margin of a growing crack is at most the length, m, that the bond has above LEAST times the contact.
    """
    # a growing front: the rate of stretch there, and the length left
    if regime & (GROWS_LEFT | GROWS_RIGHT):
        front = left if regime & GROWS_LEFT else right
        remains = (right - left) - LEAST * (contact.right - contact.left)
        return min(opening_rate - front * slope_rate, remains)
    # a bond that holds: the reach less the stretch at the worse end
    return min(left * slope, right * slope) - opening + bond.reach


@leaf
def held_bonded_forces(regime, contact, law, bond, opening, slope, opening_rate, slope_rate):
    """Return `bonded_forces` by the formula of a regime, even where it does not apply, and the margin of the regime.

    The length in contact consists of the bonded interval and the loaded parts of the dry sides.
    """
    # the bonded interval
    left, right = _front(regime, bond, opening, slope)
    motion = opening, slope, opening_rate, slope_rate
    force, moment = _pull(contact, law, left, right, *motion)
    margin = _margin_of_ends(regime, contact, bond, left, right, *motion)
    before, after = (0.0, 0.0, 0.0, margin), (0.0, 0.0, 0.0, margin)
    # the dry sides, each in its own regime
    side, beyond = regime & OF_SIDE, (regime >> RIGHT_SIDE) & OF_SIDE
    if side != NOTHING:
        before = held_forces(side, _side(contact, contact.left, left), law, *motion)
    if beyond != NOTHING:
        after = held_forces(beyond, _side(contact, right, contact.right), law, *motion)
    # sum, and the least margin
    force, moment = force + (before[0] + after[0]), moment + (before[1] + after[1])
    length, margin = _in_contact(contact, left, right, before[2], after[2]), min(margin, before[3], after[3])
    return force, moment, length, left, right, margin


@leaf
def bond_margin(regime, contact, damping, bond, opening, slope, opening_rate, slope_rate):
    """Return the margin of a regime of a bonded joint (m, or m/s of a growing front); negative beyond it."""
    left, right = _front(regime, bond, opening, slope)
    motion = opening, slope, opening_rate, slope_rate
    margin = _margin_of_ends(regime, contact, bond, left, right, *motion)
    # margins of the dry sides
    side, beyond = regime & OF_SIDE, (regime >> RIGHT_SIDE) & OF_SIDE
    if side != NOTHING:
        margin = min(margin, regime_margin(side, contact.left, left, damping, *motion))
    if beyond != NOTHING:
        margin = min(margin, regime_margin(beyond, right, contact.right, damping, *motion))
    return margin


@leaf
def bonded_peak_pressure(contact, law, left, right, opening, slope, opening_rate, slope_rate):
    """Return the largest pressure (Pa) on a joint bonded from left to right: at an end of bond or loaded part."""
    # opening and slope with the damper's part
    mean, gradient = opening + law.damping * opening_rate, slope + law.damping * slope_rate
    lo, hi = loaded_part(contact.left, contact.right, law.damping, opening, slope, opening_rate, slope_rate)
    # largest penetration at an end of the bond, then of the loaded part
    most = max(gradient * left, gradient * right) - mean if left < right else 0.0
    if lo < hi:
        most = max(most, max(gradient * lo, gradient * hi) - mean)
    return max(0.0, law.stiffness * most)
