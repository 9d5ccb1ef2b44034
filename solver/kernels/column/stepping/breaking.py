"""The instant within a step at which a bond of mortar breaks."""

from ...engine.bracket import bracket, narrowed, trial_within
from ...engine.interpolation import value_of
from ...numba_ext.jit import kernel, leaf
from ..formulations.bonds import motion_of_joint
from ..integrators.interpolation import refine
from ..joint.bond import GROWS_LEFT, GROWS_RIGHT
from .holding import CLOSE_ENOUGH, MOST_TRIALS, course_of, end_of_regime, margin_within


@kernel
def first_break(column, t, h, first):
    """Return the fraction of the step at which a bond breaks between the phases that are examined, else `first`.

    The stretch of a fibre at an end of a bond may exceed the reach and turn back within the step.
    """
    work, joints = column.work, column.work.joints
    for i in range(int(work.slips.bonds)):
        if work.hold.regime[i] & (GROWS_LEFT | GROWS_RIGHT) or not joints.bond_left[i] < joints.bond_right[i]:
            continue
        # stretch and its rate at both ends of the bond, at both ends of the step
        for place in (joints.bond_left[i], joints.bond_right[i]):
            here, pulls = _pulled(column, work.start, i, place)
            there, pulled = _pulled(column, work.end, i, place)
            # upper bound of the stretch: where the tangents at both ends meet
            if pulls > 0.0 > pulled:
                most = (there * pulls - here * pulled - h * pulls * pulled) / (pulls - pulled)
                if most > column.model.blocks.reach[i]:
                    first = min(first, _turned_between(column, t, h, i, place, first))
    return first


@leaf
def _pulled(column, phase, i, place):
    """Return the stretch (m) of the fibre at a place of joint i (m), and its rate (m/s)."""
    opening, slope, opening_rate, slope_rate = motion_of_joint(column.model, phase, i)
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
