"""The rest of a column that is off its axis: the minimum of the potential energy, by Newton's method.

Only the two blocks at a joint and its opening enter the energy of that joint and of the weight it carries (theory.md
section 12): with the openings eliminated, the second derivatives by the rotations are a symmetric tridiagonal matrix. A
rest is stable where its pivots are positive. Newton's method begins at the straight column, the joints in full contact;
the joints only become softer from there on, so that no step goes too far.
"""

import math
from typing import Any, NamedTuple

from ...numba_ext.jit import kernel, leaf
from ..formulations.bonds import keep_bond, motion_of_joint
from ..joint.bond import Bond, bonded_part
from ..joint.law import loaded_part
from ..joint.resultants import is_bonded
from ..joint.sliding import opening_felt
from ..sections.section import contact_of, forces_over, part_stiffness

MOST_STEPS = 100
CUTS = 1000  # iterations at most, until a column rests on the bonds that are left
CUT = 1e-9  # relative to the contact: a smaller cut is ignored
CLOSE = 1e-7  # relative to the rotation floor: a last correction, as the next one would be below rounding


class _Row(NamedTuple):
    """The results of the pass down for the pass up, rows of n."""

    pivot: Any
    right: Any
    side: Any  # element next to the pivot
    along: Any  # N/m, by the opening
    unbalanced: Any  # N, on the opening
    over: Any  # N, derivative of that by the rotation of the block
    under: Any  # N, derivative by the rotation of the body below


class JointAtRest(NamedTuple):
    """A joint at rest with the weight it carries: unbalanced forces, second derivatives of the energy."""

    touches: bool  # whether the faces overlap
    is_full: bool  # whether the whole contact is pressed
    unbalanced: float  # N, on the opening
    couple: float  # N m, of the pressure, against the rotation of the joint
    fall: float  # N m, of the weight, along the mean rotation of both faces
    along: float  # N/m, by the opening
    twist: float  # N, by the opening and the rotation of the joint
    elastic: float  # N m, by the rotation of the joint, of the stiffness alone
    turning: float  # N m, by the rotation of the joint, with the pressure turning
    across: float  # N, of the weight, along the joint
    spread: float  # N m, of the weight, by the mean rotation of either face


@kernel
def find_rest(model, phase, room):
    """Move a phase from the straight column to its rest; return True if a stable rest exists. Slips stay.

    Bonds are cut until those that are left bear the weight.
    """
    # dry joints
    if not is_bonded(model):
        return _balance(model, phase, room)
    # mortar: balance, cut, and balance again until no bond breaks
    for _ in range(CUTS):
        if not _balance(model, phase, room):
            return False
        if not _cut_bonds(model, phase):
            return True
    return False


@kernel
def _cut_bonds(model, phase):
    """Cut the bonds by the part of each that breaks in a phase at rest; return True if any is cut."""
    blocks, found = model.blocks, False
    for i in range(model.n):
        bond = Bond(phase.bond_left[i], phase.bond_right[i], blocks.reach[i])
        if bond.left < bond.right:
            # part of it that holds at this stretch
            contact = contact_of(blocks, i, phase.slip[i])
            opening, slope, _, _ = motion_of_joint(model, phase, i)
            left, right = bonded_part(contact, bond, opening, slope)
            # the bond breaks there, by more than rounding
            if (right - left) < (bond.right - bond.left) - CUT * (contact.right - contact.left):
                keep_bond(phase, model, i, left, right)
                found = True
    return found


@kernel
def _balance(model, phase, room):
    """Find the rest from a phase near it, as `find_rest`, with the bonds as they are."""
    enough = CLOSE * model.settings.rotation_floor
    row = _Row(room.a, room.b, room.c, room.d, room.e, room.f, room.g)
    # Newton's method: eliminate from the top down, then correct from the base up
    for _ in range(MOST_STEPS):
        if not _eliminate(model, phase, row):
            return False
        size, below = 0.0, 0.0
        for i in range(model.n - 1, -1, -1):
            # corrections of rotation (rad) and opening (m)
            change = (row.right[i] - row.side[i] * below) / row.pivot[i]
            opened = -(row.unbalanced[i] + row.over[i] * change + row.under[i] * below) / row.along[i]
            phase.theta[i] += change
            phase.opening[i] += opened
            size = max(size, abs(change), abs(opened) * model.blocks.per_open_size[i])
            below = change
        # end at rounding, or where the correction diverges
        if not math.isfinite(size):
            return False
        if size <= enough:
            return True
    return False


@leaf
def _bearing_part(model, phase, i, left, right, opening, slope):
    """Return the part (lo, hi) of the contact of joint i, left to right (m), that bears at rest; lo >= hi if none.

    It is one interval, of the bond and the loaded part. A crack at rest is open on its side.
    """
    lo, hi = loaded_part(left, right, 0.0, opening, slope, 0.0, 0.0)
    if not (is_bonded(model) and phase.bond_left[i] < phase.bond_right[i]):
        return lo, hi
    # the bond alone, or the bond and the pressed part
    if not lo < hi:
        return phase.bond_left[i], phase.bond_right[i]
    return min(lo, phase.bond_left[i]), max(hi, phase.bond_right[i])


@kernel
def joint_about(model, phase, i, carried):
    """Return joint i at a phase at rest, with the mass that it carries (kg)."""
    blocks = model.blocks
    # rotations of both blocks, slip and opening
    turn, slip, opening = phase.theta[i], phase.slip[i], phase.opening[i]
    below = phase.theta[i + 1] if i + 1 < model.n else 0.0
    # motion of the joint
    sine, cosine = math.sin(0.5 * (turn - below)), math.cos(0.5 * (turn - below))
    slope = 2.0 * sine
    phi = 0.5 * (turn + below) + blocks.lean[i]
    contact, stiffness = contact_of(blocks, i, slip), blocks.stiffness[i]
    felt = opening_felt(opening, slip, slope)
    # forces of the pressure
    lo, hi = _bearing_part(model, phase, i, contact.left, contact.right, felt, slope)
    is_full = lo == contact.left and hi == contact.right
    normal, moment = 0.0, 0.0
    if lo < hi:
        normal, moment = forces_over(contact, stiffness, lo, hi, hi - lo, felt, slope)
    else:
        lo, hi = contact.left, contact.right
    # second derivatives of the elastic energy
    along, mixed, second = part_stiffness(contact, stiffness, lo, hi)
    moment += 0.5 * slip * normal
    elastic = (second + slip * (mixed + 0.25 * slip * along)) * cosine * cosine
    twist = -(mixed + 0.5 * slip * along) * cosine
    # the weight that the joint carries
    weight = model.settings.gravity * carried
    down, across = weight * math.cos(phi), weight * math.sin(phi)
    return JointAtRest(
        contact.left < contact.right,
        is_full,
        down - normal,
        moment * cosine,
        -0.5 * (opening * across + slip * down),
        along,
        twist,
        elastic,
        elastic - 0.5 * moment * sine,
        across,
        -0.25 * (opening * down - slip * across),
    )


@kernel
def _eliminate(model, phase, row):
    """Compute gradient and second derivatives of the energy, top down; return True if all pivots are positive."""
    n, blocks = model.n, model.blocks
    carried = 0.0
    diagonal, right = 0.0, 0.0  # contribution of the joint above to the row of the block
    side, pivot, last = 0.0, 1.0, 0.0
    for i in range(n):
        # the block
        lever = model.settings.gravity * (carried * blocks.height[i] + blocks.mass[i] * blocks.centroid[i])
        carried += blocks.mass[i]
        diagonal -= lever * math.cos(phase.theta[i] + blocks.tilt[i])
        right += lever * math.sin(phase.theta[i] + blocks.tilt[i])
        # the joint and the weight it carries
        joint = joint_about(model, phase, i, carried)
        if not joint.touches:
            return False
        along, unbalanced, turning, spread = joint.along, joint.unbalanced, joint.turning, joint.spread
        over, under = joint.twist - 0.5 * joint.across, -joint.twist - 0.5 * joint.across
        diagonal += turning + spread - over * over / along
        right += over * unbalanced / along - (joint.fall + joint.couple)
        # eliminate the block above
        part = side / pivot
        diagonal -= part * side
        right -= part * last
        if not diagonal > 0.0:
            return False
        side, pivot, last = spread - turning - over * under / along, diagonal, right
        row.pivot[i], row.right[i], row.side[i] = pivot, right, side
        row.along[i], row.unbalanced[i], row.over[i], row.under[i] = along, unbalanced, over, under
        diagonal = turning + spread - under * under / along
        right = under * unbalanced / along - (joint.fall - joint.couple)
    return True
