"""Operations on a column, from its parameters to its motion: the one engine behind every caller.

`Stepper`, both FMUs and programs without Python call these functions, and those of observing.py and slopes.py, through
entries (entries.py, driven_entries.py). A column is the bundle of the spaces in layout/spaces.py.
"""

import math

from ...layout.spaces import (
    ACCELERATION,
    BASE,
    COUNTS,
    ELASTIC,
    MODAL_MOST,
    MODEL,
    OK,
    PORTS,
    RECORD_BESIDE,
    SPOTS,
    STATE,
    WORK,
    model_room,
)
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.views import Record, clear, copy
from ..formulations.allowed_step import examine_step
from ..formulations.base_motion import enter
from ..formulations.coupled_base import arrive, couple, show_driven
from ..formulations.dispatch import Column
from ..formulations.loads import LOADS_PER_PORT, begin_loads, load_inputs, ports_of
from ..formulations.slips import begin_slips, phase_size
from ..model.assembly import rest_of
from ..model.description import NO_REST, NOT_LINEAR, behind_blocks, describe, is_linear
from ..model.normal_modes import normal_modes
from ..model.normal_modes import scratch_size as modes_scratch
from ..stepping.advance import advance
from .observing import base_of, see, see_at

# inputs of the base, set by a caller: accelerations, their slopes, rotation; behind them those of each body that drives
# it (formulations/coupled_base.py, BODY)
BASE_INPUTS = Record("ax", "az", "jx", "jz", "theta", "omega", "alpha")


_counts, _base = COUNTS.over, BASE.over
_base_inputs, _INPUTS = BASE_INPUTS.over, BASE_INPUTS.beside
_COUNTS, _BASE, _PORT, _SEEN = COUNTS.beside, BASE.beside, len(PORTS.fields), len(SPOTS.fields)


def scratch_room(n: int) -> int:
    """Return the length of the scratch row of `assemble`."""
    return modes_scratch(n) if n <= MODAL_MOST else 1


def column_in(model_space):
    """Return a leaf that returns the column of n blocks over its rows, with its model in this space."""
    # functions that lay names over rows
    _model, _state, _work = model_space.over, STATE.over, WORK.over

    @leaf
    def column_over(n, model, state, counts, base, samples, work):
        # names over the five arrays and the samples of the record
        parts = _model(model, n), _state(state, n), _counts(counts, 0), _base(base, 0)
        column = Column(*parts, samples, _work(work, n))
        # slips, and loads of the record, begin with the call
        begin_slips(column.model, column.work)
        begin_loads(column.model, column.work)
        return column

    return column_over


column_over = column_in(MODEL)


# --- from parameters to a model


@kernel
def assemble(column, given, from_rest, scratch, detail):
    """Fill the packed model of the column that `given` describes; with `from_rest`, set it at rest. Returns a code.

    Without `from_rest` the motion continues from the present coordinates and rates. After an error the model must not
    be used; state, counts and base are unchanged, except that NO_REST leaves no motion either.

    Parameters
    ----------
    column : Column
        The column; its model is filled.
    given : row
        Description of the column (model/description.py).
    from_rest : int
        1: reset the motion.
    scratch : row
        Of length `scratch_room`.
    detail : row
        Filled with the details of an error (model/description.py).

    Returns
    -------
    int
        `OK`, or a code of layout/spaces.py or model/description.py.
    """
    model, state, counts, work = column.model, column.state, column.counts, column.work
    n, settings = model.n, model.settings
    # model
    code = describe(column, given, detail)
    if code != OK:
        return code
    if settings.slides != 0.0 and not is_linear(given, n):
        return NOT_LINEAR
    # rest under the weight, and modes about it
    begin_slips(model, work)
    rest = work.between
    stands = rest_of(model, rest, work.room)
    if int(settings.without) & ELASTIC == 0 and n <= MODAL_MOST and stands:
        settings.has_modes = 1.0 if normal_modes(model, rest, scratch) else 0.0
    # ports, behind the model
    ports = int(settings.ports)
    copy(model.buffer[model_room(n) :], given[behind_blocks(n) :], _PORT * ports)
    # start at rest, or mark the accelerations as outdated
    if from_rest != 0:
        reset(column)
        clear(state.buffer[state.total :], _SEEN * ports)
        clear(column.base.buffer[_BASE:], LOADS_PER_PORT * ports)
        if not stands:
            return NO_REST
        copy(state.phase.row, rest.row, phase_size(work))
    elif counts.overturned == 0:
        state.control.base_ax = math.nan  # belongs to no input: the accelerations will be recomputed
    return OK


@kernel
def reset(column):
    """Reset state, counts and base to those of a column that has not moved yet; the state is all zeros."""
    base = column.base
    clear(column.state.row, column.state.total)
    clear(column.counts.row, _COUNTS)
    clear(base.row, _BASE)
    # no sample entered yet, no anchor of the wave
    base.anchor = -math.inf  # nowhere
    base.segment = -1.0
    base.piece_end = math.inf


# --- the base


@kernel
def drive(base, inputs, elapsed, t):
    """Set the inputs that the base follows from time t (s) on; they were set `elapsed` s before."""
    given = _base_inputs(inputs, 0)
    # accelerations and rotation at time t, and their slopes
    base.ax = given.ax + given.jx * elapsed
    base.jx = given.jx
    base.az = given.az + given.jz * elapsed
    base.jz = given.jz
    base.theta = given.theta + elapsed * (given.omega + 0.5 * elapsed * given.alpha)
    base.omega = given.omega + elapsed * given.alpha
    base.alpha = given.alpha
    base.jalpha = 0.0
    base.t0 = t


@leaf
def first_body(column):
    """Return the place of the inputs of the first body: behind those of base and ports."""
    return _INPUTS + LOADS_PER_PORT * ports_of(column)


@kernel
def exchange(column, inputs, elapsed, t, row, split):
    """Set the base motion from time t (s) on as bodies drive it, by their inputs at that instant. Returns a code.

    Parameters
    ----------
    column : Column
        The column; its base is updated.
    inputs : row
        Inputs of base, ports and bodies.
    elapsed : float
        Time (s) since loads on ports were set.
    t : float
        Time (s).
    row, split : space ROW, record SPLIT
        Filled with the outputs at t, of the accelerations so far.
    """
    if column.samples.size > 0:
        return RECORD_BESIDE
    settings, given = column.model.settings, _base_inputs(inputs, 0)
    # motion of the base up to t, and loads there
    arrive(column.base, settings, given, t)
    load_inputs(column, inputs[_INPUTS:], elapsed, t)
    # reaction at t, and the acceleration that it gives with the bodies
    code = see(column, base_of(column, t), row, split)
    first = first_body(column)
    return couple(column.base, settings, given, inputs, first, split) if code == OK else code


# --- motion


@kernel
def follow(column, inputs, start, h, watch, row, split):
    """Advance the column from `start` to start + h (s) under inputs set at `start`, and the record. Returns a code.

    row, split: scratch for outputs.
    """
    # motion of the base: by the inputs, or by the bodies that drive it
    if column.model.settings.drive == ACCELERATION:
        drive(column.base, inputs, 0.0, start)
    else:
        code = exchange(column, inputs, 0.0, start, row, split)
        if code != OK:
            return code
        examine_step(column.model, column.base, h)
    # loads on the ports
    load_inputs(column, inputs[_INPUTS:], 0.0, start)
    return advance(column, start, h, watch)


@kernel
def look(column, inputs, new_inputs, upright, elapsed, t, row, split):
    """Fill an output row and the split reaction with the outputs at time t (s). Returns a code.

    Parameters
    ----------
    column : Column
        The column.
    inputs : row
        Inputs of base, ports and bodies.
    new_inputs : int
        1: use `inputs`, set `elapsed` s before; 0: those that the last step has left.
    upright : int
        1: the column stands on the base as it is rotated and rotating, instead of upright in space.
    elapsed, t : float
        Time since the inputs were set, and time (s).
    row, split : space ROW, record SPLIT
        Filled.
    """
    base, control = column.base, column.state.control
    # new inputs: motion of the base and loads on the ports
    if new_inputs != 0:
        if column.model.settings.drive == ACCELERATION:
            drive(base, inputs, elapsed, t)
        else:  # before there is a mass at the base it does not move
            exchange(column, inputs, elapsed, t, row, split)
            # until the first step the rotation of the base is that of its inputs, however often outputs are read
            if column.counts.started == 0:
                base.coupled = 0.0
        load_inputs(column, inputs[_INPUTS:], elapsed, t)
    # the segment of the record at t
    enter(base, column.samples, t)
    # rotation of the base on which the column stands
    if upright != 0:
        control.base_theta = base.theta
        control.base_omega = base.omega
    # outputs
    show_driven(base, column.model.settings, t, split)
    return see_at(column, t, row, split)
