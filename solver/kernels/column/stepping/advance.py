"""The stepping loop, common to all methods.

A step is planned (`plan_modal` or `plan_general`), attempted by its method, and judged, which may shorten it. It is
then finished: scales and peaks are updated, requested results stored, and its end becomes the start of the next step.
"""

from typing import NamedTuple

from ...engine.control import (
    ELASTIC_COST,
    INSTANT,
    WORK_OF_A_STEP,
    accepts_elastic,
    is_too_short,
    most_of_a_call,
    most_work,
    shared,
)
from ...layout.spaces import (
    CALL_TOO_LONG,
    HAS_OVERTURNED,
    INPUT_TOO_LARGE,
    LOAD,
    OK,
    STEP_TOO_SMALL,
    TOO_MUCH_WORK,
)
from ...numba_ext.jit import kernel, leaf, varied
from ...numba_ext.views import copy
from ..formulations.base_motion import (
    anchor_wave,
    ends_soon,
    enter,
    inputs_are_bounded,
    moved_and_loaded,
    smooth_reach,
    to_next_sample,
)
from ..formulations.bonds import note_bonds, take_bonds
from ..formulations.dispatch import evaluate_at
from ..formulations.exact import STILL
from ..formulations.loads import is_loaded, ports_of, pushes_of, scratch_of_ports
from ..formulations.slips import evaluate_after_jump, note_directions, phase_size, take_directions
from ..integrators import modal
from ..integrators.error import error_in_tolerances
from ..integrators.interpolation import begin, interpolate_phase, refinement
from ..integrators.stage import stage
from ..integrators.traits import MODES, attempt_by, traits_of
from ..joint.sliding import can_slide
from ..output.peaks import clear_peaks
from ..output.watch import begin_watching, take_held_snapshots, watch_step
from .breaking import first_break
from .condition import (
    fallen_joint,
    has_fallen,
    is_quiet,
    moment_of_overturning,
    rests,
    take_stock,
)
from .control import accepts, elastic_step, general_step
from .holding import NO_CHANGE, expected_change, first_change, hold, release
from .sliding import NEAR, begin_step, first_slip_change

WELL_ENOUGH = 1.0  # in tolerances: largest correction by `refine` with which an interpolation ends a step
BEYOND = 1e-5  # of a step: distance beyond the change at which a repeated step ends; the error is its square
JUST_BEFORE, JUST_AFTER = 0.98, 1.02  # factors on the time at which a joint starts or stops sliding
LEAST_CUT = 1e-4  # of a step: regimes that change sooner are not held
# error of a step from the kinks of a record, in tolerances of a rate times the height of the lowest centroid
KINKS = 20.0

_COMPONENTS = len(LOAD)
ROUNDING = 1e-13  # of the base acceleration: smaller changes are rounding, not jumps
REJECTED = 0.0  # s advanced by a step that is to be attempted again
ENDS = -1.0  # returned as the time advanced where the call is to end before the step


# --- the base under the state


@leaf
def belongs_to(column, motion):
    """Return True if the accelerations of the state were computed for this motion of the base and for no loads."""
    control = column.state.control
    if ports_of(column) > 0:
        return False  # the state does not hold the loads
    translates = motion.ax == control.base_ax and motion.az == control.base_az
    turns = motion.theta == control.base_theta and motion.omega == control.base_omega
    return translates and turns and motion.alpha == control.base_alpha


@leaf
def keep_base(control, motion):
    """Store the motion of the base that the phase of the state belongs to."""
    control.base_ax, control.base_az = motion.ax, motion.az
    control.base_theta, control.base_omega, control.base_alpha = motion.theta, motion.omega, motion.alpha


@leaf
def _jumps(before, now):
    """Return True if a value jumps by more than rounding."""
    return not abs(now - before) <= ROUNDING * abs(now)


@kernel
def _jump_into(column, t):
    """Enter the segment of the record at time t (s); return True if base acceleration or loads jump there.

    The motion of the base after the jump is left as `moved_and_loaded` leaves it.
    """
    # base acceleration and loads before the sample, then after it
    before, kept, loads = moved_and_loaded(column, t), scratch_of_ports(column), _COMPONENTS * ports_of(column)
    copy(kept, pushes_of(column), loads)
    enter(column.base, column.samples, t)
    modal.forget(column.work)
    now, pushes = moved_and_loaded(column, t), pushes_of(column)
    # a jump of either, beyond rounding
    jump = max(abs(now.ax - before.ax), abs(now.az - before.az))
    found = not jump <= ROUNDING * max(abs(now.ax), abs(now.az))
    for i in range(loads):
        found = found or _jumps(kept[i], pushes[i])
    return found


@kernel
def take_phase(column, motion, phase):
    """Fill `phase` with the phase of the state, its rotations taken relative to the base of `motion`.

    The positions and velocities of the blocks in space stay; the rotation of the base may have been changed.
    """
    state = column.state
    n = column.model.n
    copy(phase.row, state.phase.row, phase_size(column.work))
    # change of the base rotation, rad, and of its rate, rad/s, since the phase was stored
    turn, spin = motion.theta - state.control.base_theta, motion.omega - state.control.base_omega
    if turn != 0.0 or spin != 0.0:
        for i in range(n):
            phase.theta[i] -= turn
            phase.theta_rate[i] -= spin


# --- steps


class StepPlan(NamedTuple):
    """The step to be attempted next."""

    method: int
    step: float  # s
    held: bool  # whether the joints are held in their regimes


@kernel
def plan_modal(column, step, left):
    """Return the plan of a modal step of about `step` s, of which `left` s remain."""
    begin(column.work, False)
    return StepPlan(MODES, shared(step, left), False)


@kernel
def plan_general(column, t, left):
    """Return the plan of a step by a general method that ends just after the first expected change of a joint's regime.

    Parameters
    ----------
    column : Column
        The column; its joints are held in their regimes if the method holds them.
    t : float
        Start of the step (s).
    left : float
        Time (s) that remains in the call.
    """
    settings = column.model.settings
    # method and step proposed by the error control
    method, step = general_step(column, left)
    traits = traits_of(method)
    # longest step that the record allows
    reach = left
    # a load may jump at each sample; in long steps of low order a kink costs more accuracy than the estimate shows
    if ports_of(column) > 0 or traits.implicit:
        reach = to_next_sample(column.base, column.samples, t, left)
    elif column.samples.size > 0:
        length = column.model.blocks.centroid[column.model.n - 1]
        roughest = KINKS * settings.tolerance * column.state.control.rate_scale * length
        reach = smooth_reach(column.base, column.samples, t, step, left, roughest)
    step = shared(step, reach)
    # end just after a joint is expected to leave its regime
    held = traits.holds and column.counts.unheld == 0
    if held:
        hold(column, step)
        step = min(step, expected_change(column, step))
    # or to stop sliding
    if can_slide(column.model):
        step = min(step, JUST_AFTER * begin_step(column, step))
    begin(column.work, traits.long)
    return StepPlan(method, step, held)


@kernel
def judge_step(column, plan, t, code, error):
    """Accept, shorten or reject the step just attempted.

    Parameters
    ----------
    column : Column
        The column after the attempt.
    plan : StepPlan
        The step.
    t : float
        Start of the step (s).
    code : int
        Code that the method returned: a modal step may fail, and a method be unknown.
    error : float
        Estimated error, in tolerances.

    Returns
    -------
    code : int
        A code of layout/spaces.py.
    made : float
        Time advanced (s); `REJECTED` if the step is to be attempted again.
    again : bool
        True if the step has to be repeated with the length `made`.
    """
    counts = column.counts
    method, step, held = plan
    # modal steps: accepted or rejected, never shortened
    if method == MODES:
        control = column.state.control
        accepted = accepts_elastic(counts, control, step, code, error, ELASTIC_COST)
        return OK, step if accepted else REJECTED, False
    if code != OK:
        return code, REJECTED, False
    if not accepts(column, method, step, error):
        return _reject(column, t), REJECTED, False
    # accepted: shorten it if a regime changes within
    counts.unheld = 0
    if counts.elastic_wait > 0:
        counts.elastic_wait -= 1
    if not held and not can_slide(column.model):
        return OK, step, False
    return _end_at_change(column, plan, t, step)


@kernel
def _end_at_change(column, plan, t, step):
    """End the step where a joint first leaves its regime, or starts or stops sliding; release the joints.

    Returns the values of `judge_step`.
    """
    work, counts = column.work, column.counts
    traits = traits_of(plan.method)
    # first change of regime, as a fraction of the step
    first, second, third = traits.inside
    looked_at = (stage(work, first), stage(work, second), stage(work, third))
    cut = NO_CHANGE
    if plan.held:
        cut = first_change(column, looked_at, traits.nodes, t, step)
        cut = first_break(column, t, step, cut)
    # a slip that starts or stops before that ends the step instead
    if can_slide(column.model):
        slides_at = first_slip_change(column, looked_at, traits.nodes, t, step)
        if slides_at <= min(cut, 1.0):
            release(column)
            return _end_at_slip(column, t, step, max(NEAR, slides_at), traits.long)
    release(column)
    if cut == NO_CHANGE:
        # the search may have evaluated the middle of the step last
        if work.interpolation.has_bump != 0.0:
            return evaluate_at(column, work.end, t + step), step, False
        return OK, step, False
    if cut < LEAST_CUT:
        counts.unheld = 1
        return OK, REJECTED, False
    counts.events += 1
    if work.interpolation.has_bump == 0.0 or _interpolates_well(column, step, cut):
        return end_within(column, t, step, cut, traits.long), cut * step, False
    # the interpolation error in a long step of high order matters at tight tolerances
    step *= min(1.0, cut + BEYOND)
    hold(column, step)
    begin(work, traits.long)
    return OK, step, True


@kernel
def _end_at_slip(column, t, step, cut, fine):
    """End the step where a joint starts or stops sliding. Returns the values of `judge_step`."""
    work = column.work
    if work.interpolation.has_bump == 0.0 or _interpolates_well(column, step, cut):
        column.counts.events += 1
        work.slips.change = 1.0
        return end_within(column, t, step, cut, fine), cut * step, False
    # repeat the step up to just before the change: the next one interpolates well near its start
    step *= JUST_BEFORE * cut
    hold(column, step)
    begin(work, fine)
    return OK, step, True


@kernel
def _interpolates_well(column, h, fraction):
    """Return True if the interpolation at a fraction of a step of `h` s is as accurate as the step."""
    refinement(column.work, h, fraction)
    return error_in_tolerances(column, column.work.between) <= WELL_ENOUGH


@kernel
def end_within(column, t, h, fraction, fine):
    """End the step of `h` s at a fraction of it and evaluate the column there. Returns a code."""
    work = column.work
    interpolate_phase(work, h, fraction)
    copy(work.end.row, work.between.row, phase_size(work))
    begin(work, fine)
    return evaluate_at(column, work.end, t + fraction * h)


@kernel
def _reject(column, t):
    """Release the joints so that the step at time t (s) is attempted again. Returns `STEP_TOO_SMALL` or `OK`."""
    release(column)
    too_short = is_too_short(column.state.control.next_step, column.model.settings.first_step, t)
    return STEP_TOO_SMALL if too_short else OK


@kernel
def repeat_step(column, method, t, step):
    """Repeat an accurate step with the shorter length `step` (s), up to a change of regime. Returns (code, s made).

    A joint that hardly moves may start the shorter step in another regime, so its error is judged again.
    """
    _, error = attempt_by(method, column, t, step)
    if not error <= 1.0:
        accepts(column, method, step, error)
        return _reject(column, t), REJECTED
    release(column)
    return evaluate_at(column, column.work.end, t + step), step


@kernel
def finish_step(column, watch, t, step):
    """Update scales and peaks after a step, store the requested results, and start the next step from its end.

    Parameters
    ----------
    column : Column
        The column, with the step just made in `work.start` and `work.end`.
    watch : Watch
        Requested results.
    t, step : float
        Start and length of the step (s).

    Returns
    -------
    code : int
        A code of layout/spaces.py.
    made : float
        Time advanced (s): `step`, or less if the column overturns within it.
    """
    model, state, counts, work = column.model, column.state, column.counts, column.work
    counts.steps += 1
    counts.resting = 0
    # shorten the step to the instant of overturning
    if has_fallen(model, work.end):
        fraction = moment_of_overturning(column, step)
        code = end_within(column, t, step, fraction, False)
        if code != OK:
            return code, step
        step *= fraction
        state.control.overturn_time = t + step
        counts.overturned = fallen_joint(model, work.end)
    # scales of errors, and validity
    code = take_stock(column, work.end, step)
    if code != OK:
        return code, step
    # results within the step
    note_directions(work, work.end)
    note_bonds(column, work.end)
    watch_step(column, watch, t, step)
    # the end becomes the start of the next step
    copy(work.start.row, work.end.row, phase_size(work))
    take_directions(work, work.start)
    take_bonds(work, work.start)
    # decide sticking or sliding where a slip has changed
    if work.slips.change != 0.0:
        work.slips.change = 0.0
        motion = moved_and_loaded(column, t + step)
        code = evaluate_after_jump(column, work.start, motion)
        if code == OK:
            begin_watching(column, watch, motion, True)
        return code, step
    return OK, step


@varied
def take_step(column, watch, t, left, to_sample):
    """Make the next step. Returns (code, s made), the latter `REJECTED` or `ENDS` where no step was made.

    Parameters
    ----------
    column : Column
        The column, advanced in place.
    watch : Watch
        Requested results.
    t : float
        Start of the step (s).
    left : float
        Time that remains in the call (s).
    to_sample : float
        Time that remains in the present segment of the record (s).
    """
    # a column at rest on a still base needs no steps
    quiet = is_quiet(column.base, column.samples) and not is_loaded(column)
    if quiet and rests(column, column.work.start):
        _rest_until(column, watch, t, to_sample)
        return OK, to_sample
    # plan a modal step, or else a general one
    anchor_wave(column.base, t)
    elastic = elastic_step(column, to_sample)
    if elastic > 0.0:
        plan = plan_modal(column, elastic, to_sample)
    elif column.counts.until_opening == 1:
        return OK, ENDS
    else:
        modal.forget(column.work)
        plan = plan_general(column, t, left)
    # attempt it, and repeat it shorter if a regime changes within
    code, error = attempt_by(plan.method, column, t, plan.step)
    code, made, again = judge_step(column, plan, t, code, error)
    if again:
        code, made = repeat_step(column, plan.method, t, made)
    if code == OK and made > 0.0:
        code, made = finish_step(column, watch, t, made)
    return code, made


# --- from t to t + h


@kernel
def _start(column, motion, t):
    """Set the scales and the first trial steps at the first use of a state. Returns a code."""
    settings, control = column.model.settings, column.state.control
    column.counts.started = 1
    clear_peaks(column)  # an output row may have been asked for under other inputs
    control.next_step = settings.first_step
    control.explicit_step = settings.first_step
    control.previous_error = 1.0
    control.elastic_step = 10.0 * settings.first_step
    control.rotation_scale = max(control.rotation_scale, settings.rotation_floor)
    control.rate_scale = max(control.rate_scale, settings.rate_floor)
    return take_stock(column, column.work.start, 0.0)


@kernel
def _rest_until(column, watch, t, left):
    """Hold a column at rest for `left` s."""
    control = column.state.control
    column.counts.resting = 1
    copy(column.state.phase.row, column.work.start.row, phase_size(column.work))
    keep_base(control, STILL)
    control.time_full += left
    control.time_at_rest += left
    take_held_snapshots(column, watch, t, left)


@kernel
def advance(column, t, h, watch):
    """Advance the column from t to exactly t + h (s), or as far as `until_opening` allows. Returns a code.

    Inputs of the base hold within the call; snapshots assume that the base does not rotate. Snapshots within a step are
    interpolated. A column that has overturned keeps its state. After an error the phase of the state is that at t.

    Parameters
    ----------
    column : Column
        The column, advanced in place.
    t, h : float
        Start and length (s).
    watch : Watch
        Requested results.

    Returns
    -------
    int
        A code of layout/spaces.py: `OK`, `HAS_OVERTURNED` or a negative one.
    """
    _, state, counts, base, samples, work = column
    if not inputs_are_bounded(base, t, h):
        return INPUT_TOO_LARGE
    # end of the step: the call ends, or the record enters its next segment
    if counts.overturned > 0:
        take_held_snapshots(column, watch, t, h)
        return HAS_OVERTURNED
    # start: the phase relative to the present base
    enter(base, samples, t)
    motion = moved_and_loaded(column, t)
    take_phase(column, motion, work.start)
    take_directions(work, work.start)
    take_bonds(work, work.start)
    # recompute accelerations that belong to another motion of the base
    stale = counts.started == 0 or not belongs_to(column, motion)
    if stale:
        code = evaluate_after_jump(column, work.start, motion)
        if code != OK:
            return code
        note_bonds(column, work.start)
        take_bonds(work, work.start)
        if counts.started == 0:
            code = _start(column, motion, t)
            if code != OK:
                return code
    begin_watching(column, watch, motion, stale)
    modal.forget(work)
    # nothing moves in an instant
    elapsed = 0.0
    if h <= INSTANT * column.model.settings.first_step:
        take_held_snapshots(column, watch, t, h)
        elapsed = h
    # limits of the work in this call
    most = most_work(column.model.settings, h) + samples.size  # silent samples are passed one by one
    most_here = most_of_a_call(column.model.n) + WORK_OF_A_STEP * samples.size
    begun = counts.evaluations + counts.sweeps
    rounds = 0
    while elapsed < h:
        rounds += 1
        spent = counts.evaluations + counts.sweeps - begun
        if rounds + spent > most:
            return TOO_MUCH_WORK
        if WORK_OF_A_STEP * rounds + spent > most_here:
            return CALL_TOO_LONG
        # one step
        now = t + elapsed
        to_sample = to_next_sample(base, samples, now, h - elapsed)
        code, made = take_step(column, watch, now, h - elapsed, to_sample)
        if code != OK:
            return code
        if made == ENDS:
            break
        if made == REJECTED:
            continue
        if counts.overturned > 0:
            elapsed += made
            break
        if made == h - elapsed:
            elapsed = h
        else:
            elapsed += made
            code = _pass_samples(column, watch, t + elapsed)
            if code != OK:
                return code

    # store the end in the state
    copy(state.phase.row, work.start.row, phase_size(work))
    motion = moved_and_loaded(column, t + elapsed)
    state.control.reached = t + elapsed
    keep_base(state.control, motion)
    if counts.overturned > 0:
        take_held_snapshots(column, watch, t, h)
        return HAS_OVERTURNED
    return OK


@kernel
def _pass_samples(column, watch, t):
    """Enter the segment of the record at time t (s); re-evaluate where accelerations jump there. Returns a code."""
    base, samples = column.base, column.samples
    if samples.size == 0 or not ends_soon(base, t):
        return OK
    if not _jump_into(column, t):
        return OK
    motion = moved_and_loaded(column, t)
    code = evaluate_after_jump(column, column.work.start, motion)
    if code == OK:
        begin_watching(column, watch, motion, True)
    return code
