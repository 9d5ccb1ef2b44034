"""The bonds of brittle joints: an interval of each contact, which a phase holds at its instant (docs/mortar.md).

An evaluation computes the part of them that is left (joint/bond.py). An accepted step stores it. A joint that begins to
slide loses its bond. Without brittle joints `work.slips.bonds` is 0, and no loop below has an iteration.
"""

from ...numba_ext.jit import kernel, leaf
from ...numba_ext.numbers import half_sine_cosine
from ...numba_ext.views import copy
from ..joint.bond import BROKEN, Bond, bonded_part
from ..joint.sliding import less_below, opening_felt, opening_rate_felt, slip_of
from ..sections.section import contact_of, ends_of

# Relative to the first step of the column: a bond that would break within this time is broken at once. Uniform tension
# may cross the whole joint in it, which no step could follow.
SOON = 1e-6


@leaf
def lost_share(model, i, left, right):
    """Return the broken share of the bond of joint i as built, where left to right (m) remains; 0 for a dry joint."""
    first, last = ends_of(model.blocks, i, model.blocks.offset[i])
    return 1.0 - max(0.0, right - left) / (last - first) if model.blocks.reach[i] >= 0.0 else 0.0


@leaf
def keep_bond(phase, model, i, left, right):
    """Store in a phase the bond of joint i, from left to right (m), and its broken share."""
    phase.bond_left[i], phase.bond_right[i] = left, right
    phase.bond_lost[i] = lost_share(model, i, left, right)


@kernel
def begin_bonds(model, rest):
    """Store in a phase the bonds as built: all of the contact of a brittle joint."""
    blocks = model.blocks
    for i in range(model.n):
        contact = contact_of(blocks, i, blocks.offset[i])
        left, right = (contact.left, contact.right) if blocks.reach[i] >= 0.0 else BROKEN
        keep_bond(rest, model, i, left, right)


@leaf
def take_bonds(work, phase):
    """Load the bonds of a phase for the evaluations that follow."""
    bonds = int(work.slips.bonds)
    copy(work.joints.bond_left, phase.bond_left, bonds)
    copy(work.joints.bond_right, phase.bond_right, bonds)


@leaf
def keep_bonds(work, phase):
    """Store in a phase within a step the bonds at the start of the step."""
    copy(phase.bonds, work.start.bonds, 3 * int(work.slips.bonds))


@leaf
def drop_bonds(work):
    """Remove the bonds of joints that slide."""
    joints = work.joints
    for i in range(int(work.slips.bonds)):
        if joints.sliding[i] != 0.0:
            joints.bond_left[i], joints.bond_right[i] = BROKEN


@leaf
def keep_lost(model, work, phase):
    """Store in a phase the bonds that `drop_bonds` has broken."""
    joints = work.joints
    for i in range(int(work.slips.bonds)):
        if phase.bond_left[i] < phase.bond_right[i] and not joints.bond_left[i] < joints.bond_right[i]:
            keep_bond(phase, model, i, *BROKEN)


@leaf
def motion_of_joint(model, phase, i):
    """Return the opening in the middle of the contact of joint i (m), the slope (rad), and their rates."""
    turn, spin = less_below(phase.theta, i, model.n), less_below(phase.theta_rate, i, model.n)
    sine, cosine = half_sine_cosine(turn)
    slope, slope_rate = 2.0 * sine, cosine * spin
    slip, slip_rate = slip_of(model, phase, i)
    opening = opening_felt(phase.opening[i], slip, slope)
    return opening, slope, opening_rate_felt(phase.opening_rate[i], slip, slip_rate, slope, slope_rate), slope_rate


@kernel
def note_bonds(column, phase):
    """Store in a phase, just evaluated at the end of a step, the bonds that are left from then on."""
    model, work = column.model, column.work
    blocks, soon = model.blocks, SOON * model.settings.first_step
    for i in range(int(work.slips.bonds)):
        left, right = work.joints.bond_left[i], work.joints.bond_right[i]
        if left < right:
            # the part of the bond that is left
            contact, reach = contact_of(blocks, i, slip_of(model, phase, i)[0]), blocks.reach[i]
            opening, slope, opening_rate, slope_rate = motion_of_joint(model, phase, i)
            left, right = bonded_part(contact, Bond(left, right, reach), opening, slope)
            if left < right:
                # a bond that would break within SOON is broken at once
                then = opening + soon * opening_rate, slope + soon * slope_rate
                first, last = bonded_part(contact, Bond(left, right, reach), *then)
                if not first < last:
                    left, right = BROKEN
                    work.slips.change = 1.0  # the forces jump
        keep_bond(phase, model, i, left, right)
