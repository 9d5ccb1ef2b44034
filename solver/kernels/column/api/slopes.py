"""Derivatives of the outputs of a column: by time, and by the inputs of its base and ports."""

from ...engine.differences import point, points
from ...layout.spaces import ACCELERATION, HORIZONTAL, LOAD, OK, SPLIT
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.numbers import sine_cosine
from ...numba_ext.views import clear, copy
from ..formulations.base_motion import moved_and_loaded
from ..formulations.coupled_base import driven_along, show_driven_along, show_driven_rates
from ..formulations.exact import Motion
from ..formulations.feedthrough import base_direction, effective_mass, split_reaction, tangential_gains
from ..formulations.loads import ports_of, push_ports, pushes_of
from ..formulations.outputs import observe, observe_as_it_slides
from ..formulations.slips import phase_size
from ..integrators.interpolation import slips_of
from ..stepping.advance import take_phase
from .engine import BASE_INPUTS, first_body
from .observing import base_of, row_length, see

PROBE_TURN = 1e-9  # rad, variation of the rotation of the base
PROBE_SPIN = 1e-6  # rad/s, variation of its rate
RATE_PART = 1e-4  # of the first step: half the time over which outputs are differenced

_base_inputs, _INPUTS, _SPLIT, _COMPONENTS = BASE_INPUTS.over, BASE_INPUTS.beside, SPLIT.beside, len(LOAD)


@leaf
def _clear_output(row, split, length):
    clear(row.buffer, length)
    clear(split.row, _SPLIT)


@kernel
def _add(row, split, other, other_split, factor, length):
    for i in range(length):
        row.buffer[i] += factor * other.buffer[i]
    for i in range(_SPLIT):
        split.row[i] += factor * other_split.row[i]


@kernel
def rates(column, t, row, split, other, other_split):
    """Fill row and split with the rate (1/s) of every output at time t, for which `look` was called. Returns a code.

    Differences over a fraction of the period of the fastest mode, to which the first step is proportional, on the
    parabola given by coordinates, rates and accelerations (engine/differences.py).

    Parameters
    ----------
    column : Column
        The column.
    t : float
        Time (s).
    row, split : space ROW, record SPLIT
        Filled.
    other, other_split : space ROW, record SPLIT
        Scratch.
    """
    model, work = column.model, column.work
    n, length = model.n, row_length(column)
    # a column that has overturned is constant; only a driven base moves
    _clear_output(row, split, length)
    show_driven_rates(column.base, model.settings, t, split)
    if column.counts.overturned > 0:
        return OK
    # accelerations at t
    see(column, moved_and_loaded(column, t), other, other_split)
    between, saved = work.between, work.end
    copy(saved.row, between.row, phase_size(work))
    is_brittle = int(work.slips.bonds) > 0
    for k in range(points(is_brittle)):
        # phase at that instant
        past, weight = point(is_brittle, k, RATE_PART * model.settings.first_step)
        for i in range(2 * n):
            _extrapolate(saved, between, i, past)
        first, behind = slips_of(work)
        for i in range(behind - first):
            _extrapolate(saved, between, first + i, past)
            between.sliding[i] = saved.sliding[i]
        # add the weighted outputs there
        then = moved_and_loaded(column, t + past)
        observe(column, work.between, then, other)
        split_reaction(column, work.between, then, other, other_split)
        _add(row, split, other, other_split, weight, length)
    return OK


@leaf
def _extrapolate(saved, to, i, past):
    """Set coordinate i, its rate and acceleration in `to` to those of `saved`, `past` s later."""
    q, v, a = saved.coordinates[i], saved.rates[i], saved.accelerations[i]
    to.coordinates[i] = q + past * (v + 0.5 * past * a)
    to.rates[i] = v + past * a
    to.accelerations[i] = a


@kernel
def feedthrough(column, inputs, seeds, elapsed, t, row, split, other, other_split):
    """Fill row and split with the directional derivative of every output along the input seeds. Returns a code.

    Outputs that depend at once on base accelerations and loads are linear in them (`_at_once`). The dependence on the
    rotation of the base and its rate is differenced. The inputs are those that `look` has left at time t.

    Parameters
    ----------
    column : Column
        The column.
    inputs, seeds : row
        Inputs of base, ports and bodies, and a seed for each.
    elapsed : float
        Time (s) since the inputs were set.
    t : float
        Time (s).
    row, split : space ROW, record SPLIT
        Filled.
    other, other_split : space ROW, record SPLIT
        Scratch.
    """
    settings, length = column.model.settings, row_length(column)
    # a column that has overturned does not respond; only a driven base does
    _clear_output(row, split, length)
    responds = column.counts.overturned == 0
    # seeds of the motion of the base at time t
    seed = _base_inputs(seeds, 0)
    along_x = seed.ax + elapsed * seed.jx
    along_z = seed.az + elapsed * seed.jz
    alpha = seed.alpha
    spin = seed.omega + elapsed * alpha
    turn = seed.theta + elapsed * (seed.omega + 0.5 * elapsed * alpha)
    if settings.drive != ACCELERATION and settings.drive != HORIZONTAL:
        turn = spin = 0.0  # they belong to the state
    # base and loads at time t
    motion = moved_and_loaded(column, t)
    # rotation of the base and its rate, by central differences under the accelerations as they are
    way = 1.0
    for _ in range(2):
        if turn != 0.0 and responds:
            theta = motion.theta + way * PROBE_TURN
            then = Motion(motion.ax, motion.az, theta, motion.omega, motion.alpha)
            see(column, then, other, other_split)
            _add(row, split, other, other_split, 0.5 * turn / (way * PROBE_TURN), length)
        if spin != 0.0 and responds:
            omega = motion.omega + way * PROBE_SPIN
            then = Motion(motion.ax, motion.az, motion.theta, omega, motion.alpha)
            see(column, then, other, other_split)
            _add(row, split, other, other_split, 0.5 * spin / (way * PROBE_SPIN), length)
        way = -1.0
    # loads, and the accelerations of a driven base that result from the changed split
    see(column, base_of(column, t), other, other_split)
    if ports_of(column) > 0 and responds:
        _add_load_reactions(column, motion, t, seeds, elapsed, other, split, other_split)
    # derivative of the acceleration of a driven base, m/s2 and rad/s2
    if settings.drive != ACCELERATION:
        first = first_body(column)
        along_x, along_z, alpha = driven_along(
            settings, inputs, seeds, first, other_split, split, motion, along_z, alpha
        )
    # derivatives of the outputs: by differences where there are loads
    show_driven_along(settings, turn, spin, along_x, along_z, alpha, split)
    if not responds:
        return OK
    if ports_of(column) > 0:
        _differenced(column, motion, seeds, elapsed, along_x, along_z, alpha, row, other, other_split)
    else:
        _at_once(column, motion, along_x, along_z, alpha, row)
    return OK


@leaf
def _add_loads(column, seeds, elapsed):
    """Add the load seeds, which were set `elapsed` s before, to the loads at the present instant."""
    pushes, given, count = pushes_of(column), seeds[_INPUTS:], _COMPONENTS * ports_of(column)
    for i in range(count):
        pushes[i] += given[i] + elapsed * given[count + i]


@kernel
def _see_as_it_slides(column, motion, row, split):
    """Run `see` with the joints that slid in the last observation: seeds of any size do not change which slide."""
    between = column.work.between
    take_phase(column, motion, between)
    observe_as_it_slides(column, between, motion, row)
    split_reaction(column, between, motion, row, split)


@kernel
def _add_load_reactions(column, motion, t, seeds, elapsed, other, split, other_split):
    """Add to `split` the directional derivative of R0 along the load seeds.

    The column was just observed on this motion, with the outputs `other` and `other_split`, and is left so.
    """
    # the change of the split reaction by the seeds: with the added loads, less without
    for i in range(_SPLIT):
        split.row[i] -= other_split.row[i]
    _add_loads(column, seeds, elapsed)
    _see_as_it_slides(column, motion, other, other_split)
    for i in range(_SPLIT):
        split.row[i] += other_split.row[i]
    # restore the loads and the outputs
    push_ports(column, t)
    see(column, motion, other, other_split)


@kernel
def _differenced(column, motion, seeds, elapsed, along_x, along_z, alpha, row, other, other_split):
    """Add to an output row its change by accelerations and loads, as a difference: outputs are linear in both.

    The arguments are those of `_at_once`.
    """
    length = row_length(column)
    # outputs with the changed accelerations and loads, less those without
    for i in range(length):
        row.buffer[i] -= other.buffer[i]
    _add_loads(column, seeds, elapsed)
    begin = motion.ax + along_x, motion.az + along_z, motion.theta, motion.omega, motion.alpha + alpha
    _see_as_it_slides(column, Motion(*begin), other, other_split)
    for i in range(length):
        row.buffer[i] += other.buffer[i]


@kernel
def _at_once(column, motion, along_x, along_z, alpha, row):
    """Add to an output row the derivatives along changes of base accelerations, which act at once.

    The accelerations along_x, along_z (m/s2) and alpha (rad/s2) change the forces along the joints and the reaction
    (formulations/feedthrough.py). The column was just observed on this motion.
    """
    model, work = column.model, column.work
    n, phase = model.n, work.between
    # reaction: effective mass times the acceleration along the direction of the base
    g_x, g_z, g_m = base_direction(model, phase, motion.theta)
    met = g_x * along_x + g_z * along_z + g_m * alpha
    force = effective_mass(model, work) * met
    # forces along the joints, and their horizontal parts
    gains = work.tops.start_ux
    tangential_gains(model, work, gains)
    turn_below = 0.0
    for i in range(n - 1, -1, -1):
        _, cosine = sine_cosine(0.5 * (phase.theta[i] + turn_below) + motion.theta + model.blocks.lean[i])
        row.joints.T[i] -= gains[i] * met
        row.joints.S[i] -= cosine * gains[i] * met
        turn_below = phase.theta[i]
    # reaction of the base, N and N m
    row.base.Fx -= g_x * force
    row.base.Fz -= g_z * force
    row.base.My -= g_m * force
