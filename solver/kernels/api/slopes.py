"""Derivatives of what is observed of a column: by time, and by the inputs of its base and ports."""

from ..formulations.base_motion import base_motion, moving
from ..formulations.coupled_base import driven_along, show_driven_along, show_driven_rates
from ..formulations.feedthrough import base_direction, effective_mass, split_reaction, tangential_gains
from ..formulations.outputs import observe
from ..formulations.slips import phase_size
from ..integrators.interpolation import slips_of
from ..layout.spaces import ACCELERATION, HORIZONTAL, OK, SPLIT
from ..numba_ext.jit import kernel, leaf, varied
from ..numba_ext.numbers import sine_cosine
from ..numba_ext.views import clear, copy
from .engine import BASE_INPUTS, beside_inputs
from .observing import row_length, see

PROBE_TURN = 1e-9  # rad, and
PROBE_SPIN = 1e-6  # rad/s, by which the rotation of the base is varied
RATE_PART = 1e-4  # of the first step: half the time over which outputs are differenced

_base_inputs, _INPUTS, _SPLIT = BASE_INPUTS.over, BASE_INPUTS.beside, SPLIT.beside


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
    """Fill row and split with the rate of every output at time t, 1/s; `look` has been called then. Returns a code.

    Central differences over a fraction of the period of the fastest mode, for which the first step is made too, on the
    parabola given by coordinates, rates and accelerations. other, other_split: room for another row and split.
    """
    model, work = column.model, column.work
    n, length = model.n, row_length(column)
    _clear_output(row, split, length)
    show_driven_rates(column.base, model.settings, t, split)
    if column.counts.overturned > 0:
        return OK
    see(column, base_motion(column.base, column.samples, t), other, other_split)
    between, saved = work.between, work.end
    copy(saved.row, between.row, phase_size(work))
    past = RATE_PART * model.settings.first_step
    for _ in range(2):
        for i in range(2 * n):
            _go_on(saved, between, i, past)
        first, behind = slips_of(work)
        for i in range(behind - first):
            _go_on(saved, between, first + i, past)
            between.sliding[i] = saved.sliding[i]
        then = base_motion(column.base, column.samples, t + past)
        observe(column, work.between, then, other)
        split_reaction(column, work.between, then, other, other_split)
        _add(row, split, other, other_split, 0.5 / past, length)
        past = -past
    return OK


@leaf
def _go_on(saved, to, i, past):
    """Coordinate i of a phase `past` s later, its rate and acceleration."""
    q, v, a = saved.coordinates[i], saved.rates[i], saved.accelerations[i]
    to.coordinates[i] = q + past * (v + 0.5 * past * a)
    to.rates[i] = v + past * a
    to.accelerations[i] = a


@kernel
def feedthrough(column, inputs, seeds, elapsed, t, row, split, other, other_split):
    """Fill row and split with the derivative of every output by the inputs, in the direction `seeds`.

    seeds: one for each of the inputs, which were set `elapsed` s before; at time t under the inputs that `look` has
    left. Outputs that depend on accelerations of the base and loads at once are linear in them (`at_once`). Dependence
    on the rotation of the base and its rate is differenced. Returns a code.
    """
    base, samples, settings, length = column.base, column.samples, column.model.settings, row_length(column)
    _clear_output(row, split, length)
    show_driven_along(settings, 0.0, 0.0, 0.0, 0.0, 0.0, split)
    if column.counts.overturned > 0:
        return OK
    seed = _base_inputs(seeds, 0)
    along_x = seed.ax + elapsed * seed.jx
    along_z = seed.az + elapsed * seed.jz
    alpha = seed.alpha
    spin = seed.omega + elapsed * alpha
    turn = seed.theta + elapsed * (seed.omega + 0.5 * elapsed * alpha)
    if settings.drive != ACCELERATION and settings.drive != HORIZONTAL:
        turn = spin = 0.0  # they belong to the state
    motion = base_motion(base, samples, t)
    # rotation of the base and its rate, by central differences under the accelerations as they are
    way = 1.0
    for _ in range(2):
        if turn != 0.0:
            theta = motion.theta + way * PROBE_TURN
            then = moving(base, samples, t, motion.ax, motion.az, theta, motion.omega, motion.alpha)
            see(column, then, other, other_split)
            _add(row, split, other, other_split, 0.5 * turn / (way * PROBE_TURN), length)
        if spin != 0.0:
            omega = motion.omega + way * PROBE_SPIN
            then = moving(base, samples, t, motion.ax, motion.az, motion.theta, omega, motion.alpha)
            see(column, then, other, other_split)
            _add(row, split, other, other_split, 0.5 * spin / (way * PROBE_SPIN), length)
        way = -1.0
    # loads, and the accelerations that bodies at the base follow with: they meet the changed split
    see(column, motion, other, other_split)
    met_by_loads(column, motion, seeds, elapsed, other, split, other_split)
    if settings.drive != ACCELERATION:
        first = _INPUTS + beside_inputs(samples)
        along_x, along_z, alpha = driven_along(
            settings, inputs, seeds, first, other_split, split, motion, along_z, alpha
        )
    show_driven_along(settings, turn, spin, along_x, along_z, alpha, split)
    at_once(column, motion, seeds, elapsed, along_x, along_z, alpha, row, other, other_split)
    return OK


@varied
def met_by_loads(column, motion, seeds, elapsed, other, split, other_split):
    """Add to split what R0 changes by as loads change by their seeds; without ports there are no loads.

    The column was just seen on this motion, as other and other_split say, and is left so.
    """
    return


@varied
def at_once(column, motion, seeds, elapsed, along_x, along_z, alpha, row, other, other_split):
    """Add to an output row what changes at once as the base accelerates by so much more, m/s2 and rad/s2.

    Forces along the joints and reaction (formulations/feedthrough.py). The column was just seen on this motion, as
    `other` says; it and other_split are room afterwards.
    """
    model, work = column.model, column.work
    n, phase = model.n, work.between
    g_x, g_z, g_m = base_direction(model, phase, motion.theta)
    met = g_x * along_x + g_z * along_z + g_m * alpha
    force = effective_mass(model, work) * met
    gains = work.tops.start_ux
    tangential_gains(model, work, gains)
    turn_below = 0.0
    for i in range(n - 1, -1, -1):
        _, cosine = sine_cosine(0.5 * (phase.theta[i] + turn_below) + motion.theta + model.blocks.lean[i])
        row.joints.T[i] -= gains[i] * met
        row.joints.S[i] -= cosine * gains[i] * met
        turn_below = phase.theta[i]
    row.base.Fx -= g_x * force
    row.base.Fz -= g_z * force
    row.base.My -= g_m * force
