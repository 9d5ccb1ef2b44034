"""The memory of brittle joints, and what follows from it: versions of kernels for columns that have some.

A phase holds the bonds at its instant. An evaluation computes the part of them that is left (joint/bond.py). An
accepted step stores it. A joint that begins to slide loses its bond.
"""

from ..api.observing import beside_row
from ..column.assembly import begin_memory
from ..column.description import GIVEN, GIVEN_SETTINGS, describe_more
from ..column.rest import balance, bearing_part, find_rest
from ..formulations.dispatch import evaluate
from ..formulations.outputs import show_more
from ..formulations.slips import (
    change_directions,
    evaluate_after_jump,
    keep_memory,
    note_directions,
    note_memory,
    phase_size,
    stop_what_is_still,
    take_memory,
)
from ..integrators.bracket import bracket, narrowed, trial_within
from ..integrators.interpolation import refine, value_of
from ..integrators.stage import stage
from ..joint.bond import (
    BROKEN,
    GROWS_LEFT,
    GROWS_RIGHT,
    Bond,
    bond_margin,
    bond_regime,
    bonded_forces,
    bonded_part,
    bonded_peak_pressure,
    held_bonded_forces,
)
from ..joint.law import largest_pressure, law_of, loaded_part, resultants, resultants_of
from ..joint.regimes import ANY, contact_regime, regime_margin
from ..joint.sliding import can_slide, opening_felt, opening_rate_felt, shear_capacity, slip_of
from ..layout.spaces import ELASTIC, IMPLICIT, OK, PHASE_FIELDS, ROW
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.numbers import half_sine_cosine
from ..numba_ext.views import copy
from ..sections.section import contact_of, ends_of
from ..stepping.holding import (
    CLOSE_ENOUGH,
    MOST_TRIALS,
    course_of,
    end_of_regime,
    first_turn,
    less_below,
    margin_of,
    margin_within,
    regime_of,
)
from .layout import BONDS, PHASE

# Relative to the first step of the column: a bond that would break within this time is broken at once. Uniform tension
# may cross the whole joint in it, which no step could follow.
SOON = 1e-6
CUTS = 1000  # iterations at most, until a column rests on the bonds that are left
CUT = 1e-9  # relative to the contact: a smaller cut is ignored

_bonds, _phase = BONDS.over, PHASE.over
_FIELDS, _BONDS = PHASE.per_n, BONDS.per_n
_GIVEN_SETTINGS, _GIVEN_BLOCK = GIVEN_SETTINGS.beside, GIVEN.beside
_ROW_PER_N, _ROW_BESIDE = ROW.per_n, ROW.beside


def is_bonded(model, *_):
    """Return True if a model has brittle joints, from numba's type of it."""
    return "bonds" in model.names


def of_bonds(column, *_):
    """Return True if the model of a column has brittle joints, from numba's type of it."""
    return is_bonded(column.types[0])


@leaf
def bonds_of(phase, n):
    """Return the bonds (BONDS) that a phase holds."""
    return _bonds(phase.buffer[PHASE_FIELDS * n :], n)


@leaf
def _contact_as_built(blocks, i):
    """Return the contact of joint i as built, all of which a brittle joint bonds."""
    return contact_of(blocks, i, blocks.offset[i])


@leaf
def _lost(model, i, left, right):
    """Return the broken share of the bond of joint i as built, where left to right (m) remains; 0 for a dry joint."""
    first, last = ends_of(model.blocks, i, model.blocks.offset[i])
    return 1.0 - max(0.0, right - left) / (last - first) if model.bonds.reach[i] >= 0.0 else 0.0


@leaf
def _keep(bonds, model, i, left, right):
    """Store the bond of joint i, from left to right (m), and its broken share."""
    bonds.left[i], bonds.right[i], bonds.lost[i] = left, right, _lost(model, i, left, right)


# --- the model, and the column at rest


@describe_more.version(is_bonded)
def _describe_bonds(model, given):
    n, blocks, bonds = model.n, model.blocks, model.bonds
    behind = given[_GIVEN_SETTINGS + _GIVEN_BLOCK * n :]
    # reach: strength over stiffness, negative for a dry joint
    for i in range(n):
        bonds.reach[i] = behind[i] / blocks.stiffness[i] if behind[i] > 0.0 or behind[n + i] > 0.0 else -1.0
        bonds.cohesion[i] = behind[n + i]
    # neither method supports bonds
    model.settings.without = float(int(model.settings.without) | ELASTIC | IMPLICIT)


@begin_memory.version(is_bonded)
def _begin_memory(model, rest):
    n, blocks, bonds = model.n, model.blocks, bonds_of(rest, model.n)
    for i in range(n):
        contact = _contact_as_built(blocks, i)
        left, right = (contact.left, contact.right) if model.bonds.reach[i] >= 0.0 else BROKEN
        _keep(bonds, model, i, left, right)


@bearing_part.version(is_bonded)
def _bearing_part(model, phase, i, left, right, opening, slope):
    """Return the part of the contact that bears at rest: one interval, of the bond and the loaded part.

    A crack at rest is open on its side.
    """
    bonds = bonds_of(phase, model.n)
    lo, hi = loaded_part(left, right, 0.0, opening, slope, 0.0, 0.0)
    if not bonds.left[i] < bonds.right[i]:
        return lo, hi
    if not lo < hi:
        return bonds.left[i], bonds.right[i]
    return min(lo, bonds.left[i]), max(hi, bonds.right[i])


@find_rest.version(is_bonded)
def _find_rest(model, phase, room):
    """Find the rest, cutting bonds until those that are left bear the weight; return True if a stable rest exists."""
    blocks, n, bonds = model.blocks, model.n, bonds_of(phase, model.n)
    for _ in range(CUTS):
        if not balance(model, phase, room):
            return False
        cut = False
        for i in range(n):
            if not bonds.left[i] < bonds.right[i]:
                continue
            # the part of the bond that is whole in this phase
            contact, bond = (
                contact_of(blocks, i, phase.slip[i]),
                Bond(bonds.left[i], bonds.right[i], model.bonds.reach[i]),
            )
            opening, slope, _, _ = _motion_of(model, phase, i)
            left, right = bonded_part(contact, bond, opening, slope)
            # cut the bond, and balance again
            if (right - left) < (bond.right - bond.left) - CUT * (contact.right - contact.left):
                _keep(bonds, model, i, left, right)
                cut = True
        if not cut:
            return True
    return False


@leaf
def _motion_of(model, phase, i):
    """Return the opening in the middle of the contact of joint i (m), the slope (rad), and their rates."""
    turn, spin = less_below(phase.theta, i, model.n), less_below(phase.theta_rate, i, model.n)
    sine, cosine = half_sine_cosine(turn)
    slope, slope_rate = 2.0 * sine, cosine * spin
    slip, slip_rate = slip_of(model, phase, i)
    opening = opening_felt(phase.opening[i], slip, slope)
    return opening, slope, opening_rate_felt(phase.opening_rate[i], slip, slip_rate, slope, slope_rate), slope_rate


# --- an evaluation


@resultants_of.version(is_bonded)
def _resultants_of(model, joints, hold, i, opening, slope, opening_rate, slope_rate, slip):
    blocks, left, right = model.blocks, joints.bond_left[i], joints.bond_right[i]
    joints.bonded_left[i], joints.bonded_right[i] = BROKEN
    motion = opening, slope, opening_rate, slope_rate
    # a dry joint
    if not left < right:
        return resultants(blocks, hold, i, opening, slope, opening_rate, slope_rate, slip)
    # a bonded joint, freely or held in a regime
    contact, law, bond = contact_of(blocks, i, slip), law_of(blocks, i), Bond(left, right, model.bonds.reach[i])
    regime = hold.held[i]
    if regime == ANY:
        force, moment, length, left, right = bonded_forces(contact, law, bond, *motion)
    else:
        force, moment, length, left, right, margin = held_bonded_forces(regime, contact, law, bond, *motion)
        if margin < 0.0:
            hold.outside[i] = 1
    joints.bonded_left[i], joints.bonded_right[i] = left, right
    return force, moment, length


@shear_capacity.version(is_bonded)
def _shear_capacity(model, joints, i, normal):
    blocks = model.blocks
    bonded = (joints.bonded_right[i] - joints.bonded_left[i]) * blocks.depth[i]
    return max(0.0, blocks.friction[i] * normal + blocks.dowel[i] + model.bonds.cohesion[i] * bonded)


@largest_pressure.version(lambda joints, *_: "bonded_left" in joints.names)
def _largest_pressure(joints, i, contact, law, length, opening, slope, opening_rate, slope_rate):
    left, right = joints.bonded_left[i], joints.bonded_right[i]
    return bonded_peak_pressure(contact, law, left, right, opening, slope, opening_rate, slope_rate)


@evaluate_after_jump.version(of_bonds)
def _evaluate_after_jump(column, phase, motion):
    work, n = column.work, column.work.n
    take_memory(work, phase)
    if not can_slide(column.model):
        return evaluate(column, phase, motion)
    # change directions until none is wrong; joints that slide lose their bonds
    stop_what_is_still(work.joints, phase, n)
    _break_what_slides(work)
    evaluate(column, phase, motion)
    for _ in range(2 * n + 2):
        if not change_directions(work.joints, phase, n):
            break
        _break_what_slides(work)
        evaluate(column, phase, motion)
    note_directions(work, phase)
    # store the bonds that broke
    bonds = bonds_of(phase, n)
    for i in range(n):
        if bonds.left[i] < bonds.right[i] and not work.joints.bond_left[i] < work.joints.bond_right[i]:
            _keep(bonds, column.model, i, *BROKEN)
    return OK


@leaf
def _break_what_slides(work):
    joints = work.joints
    for i in range(work.n):
        if joints.sliding[i] != 0.0:
            joints.bond_left[i], joints.bond_right[i] = BROKEN


# --- memory in phases


@phase_size.version(lambda work: "bonds" in work.names)
def _phase_size(work):
    return _FIELDS * work.n


@stage.version(lambda work, k: "bonds" in work.names)
def _stage(work, k):
    return _phase(work.stages[_FIELDS * work.n * (k - 1) :], work.n)


@take_memory.version(lambda work, phase: "bonds" in work.names)
def _take_memory(work, phase):
    bonds = bonds_of(phase, work.n)
    copy(work.joints.bond_left, bonds.left, work.n)
    copy(work.joints.bond_right, bonds.right, work.n)


@keep_memory.version(lambda work, phase: "bonds" in work.names)
def _keep_memory(work, phase):
    copy(bonds_of(phase, work.n).row, bonds_of(work.start, work.n).row, _BONDS * work.n)


@note_memory.version(of_bonds)
def _note_memory(column, phase):
    model, work = column.model, column.work
    blocks, bonds, soon = model.blocks, bonds_of(phase, model.n), SOON * model.settings.first_step
    for i in range(model.n):
        left, right = work.joints.bond_left[i], work.joints.bond_right[i]
        if left < right:
            # the part of the bond that is left
            contact, reach = contact_of(blocks, i, slip_of(model, phase, i)[0]), model.bonds.reach[i]
            opening, slope, opening_rate, slope_rate = _motion_of(model, phase, i)
            left, right = bonded_part(contact, Bond(left, right, reach), opening, slope)
            if left < right:
                # a bond that would break within SOON is broken at once
                then = opening + soon * opening_rate, slope + soon * slope_rate
                first, last = bonded_part(contact, Bond(left, right, reach), *then)
                if not first < last:
                    left, right = BROKEN
                    work.slips.change = 1.0  # the forces jump
        _keep(bonds, model, i, left, right)


# --- regimes


@regime_of.version(of_bonds)
def _regime_of(column, i, slip, opening, slope, opening_rate, slope_rate):
    blocks, joints = column.model.blocks, column.work.joints
    contact, damping = contact_of(blocks, i, slip), blocks.damping[i]
    # a bonded joint, else a dry one
    if joints.bond_left[i] < joints.bond_right[i]:
        bond = Bond(joints.bond_left[i], joints.bond_right[i], column.model.bonds.reach[i])
        return bond_regime(contact, damping, bond, opening, slope, opening_rate, slope_rate)
    return contact_regime(contact.left, contact.right, damping, opening, slope, opening_rate, slope_rate)


@margin_of.version(of_bonds)
def _margin_of(column, i, regime, slip, opening, slope, opening_rate, slope_rate):
    blocks, joints = column.model.blocks, column.work.joints
    contact, damping = contact_of(blocks, i, slip), blocks.damping[i]
    # a bonded joint, else a dry one
    if joints.bond_left[i] < joints.bond_right[i]:
        bond = Bond(joints.bond_left[i], joints.bond_right[i], column.model.bonds.reach[i])
        return bond_margin(regime, contact, damping, bond, opening, slope, opening_rate, slope_rate)
    return regime_margin(regime, contact.left, contact.right, damping, opening, slope, opening_rate, slope_rate)


@first_turn.version(of_bonds)
def _first_turn(column, t, h, first):
    """Return the fraction of the step at which a bond breaks between the phases that are examined, else `first`.

    The stretch of a fibre at an end of a bond may exceed the reach and turn back within the step.
    """
    work, joints = column.work, column.work.joints
    for i in range(column.model.n):
        if work.hold.regime[i] & (GROWS_LEFT | GROWS_RIGHT) or not joints.bond_left[i] < joints.bond_right[i]:
            continue
        # stretch and its rate at both ends of the bond, at both ends of the step
        for place in (joints.bond_left[i], joints.bond_right[i]):
            here, pulls = _pulled(column, work.start, i, place)
            there, pulled = _pulled(column, work.end, i, place)
            # upper bound of the stretch: where the tangents at both ends meet
            if pulls > 0.0 > pulled:
                most = (there * pulls - here * pulled - h * pulls * pulled) / (pulls - pulled)
                if most > column.model.bonds.reach[i]:
                    first = min(first, _turned_between(column, t, h, i, place, first))
    return first


@leaf
def _pulled(column, phase, i, place):
    """Return the stretch (m) of the fibre at a place of joint i (m), and its rate (m/s)."""
    opening, slope, opening_rate, slope_rate = _motion_of(column.model, phase, i)
    return opening - place * slope, opening_rate - place * slope_rate


@kernel
def _turned_between(column, t, h, i, place, before):
    """Return the fraction of the step where the regime of joint i ends, before the stretch at a place turns."""
    refine(column, t, h)
    regime, course = column.work.hold.regime[i], course_of(column, i, h)
    known = bracket(0.0, 1.0, 1.0, -1.0)
    # bracket the maximum of the stretch: the zero of its rate
    for _ in range(MOST_TRIALS):
        if known.hi - known.lo <= CLOSE_ENOUGH:
            break
        trial = trial_within(known)
        _, spin = value_of(course.turn, trial)
        _, rate = value_of(course.opening, trial)
        known = narrowed(known, trial, rate - place * spin)
    # the first end of the regime up to there
    if known.hi >= before or margin_within(column, i, regime, course, known.hi) >= 0.0:
        return before
    return end_of_regime(column, i, regime, course, 0.0, known.hi)


# --- outputs


@beside_row.version(of_bonds)
def _beside_row(column):
    return column.model.n


@show_more.version(of_bonds)
def _show_bonds(column, phase, motion, row):
    model, n, joints = column.model, column.model.n, column.work.joints
    shares = row.buffer[_ROW_PER_N * n + _ROW_BESIDE :]
    for i in range(n):
        shares[i] = 1.0 - _lost(model, i, joints.bonded_left[i], joints.bonded_right[i])
