"""The loads on the ports of a column: forces along x and z and a couple about y, clockwise, on points of its blocks.

x and z are the axes of the base as built: they do not turn with a base that rotates, as those of u_x and of the base
reaction. A load is a value and a slope on each segment of the record, and the inputs of an FMU beside them. Without
ports no loop below has an iteration.

The force on a block gives it an acceleration u beside that of its joints. It enters the rows of the two joints of the
block as the acceleration of the base enters the lowest one: T by u along the joint, the opening by u across it.
"""

from typing import NamedTuple

from ...layout.spaces import (
    BASE,
    LOAD,
    PORTS,
    PUSHES,
    WORK,
    model_room,
)
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.numbers import sine_cosine

_COMPONENTS, _BASE = len(LOAD), BASE.beside
_WORK_PER_N, _WORK_BESIDE = WORK.per_n, WORK.beside
_ports, _pushes = PORTS.over, PUSHES.over
LOADS_PER_PORT = 2 * _COMPONENTS  # values and slopes


class Loads(NamedTuple):
    """The loads on the ports at an instant: number of ports, PORTS, PUSHES."""

    number: int
    ports: object
    pushes: object


@leaf
def begin_loads(model, work):
    """Note the number of ports, and whether there are ports or bonds."""
    work.loading.ports = model.settings.ports
    work.loading.general = model.settings.ports + model.settings.bonded


@leaf
def ports_of(column):
    """Return the number of ports."""
    return int(column.work.loading.ports)


@leaf
def places_of_ports(column):
    """Return PORTS of all ports, which lie behind the model."""
    return column.model.buffer[model_room(column.model.n) :]


@leaf
def pushes_of(column):
    """Return the row of the loads on the ports at the instant of the last `moved_and_loaded` (PUSHES)."""
    return column.work.buffer[_WORK_PER_N * column.model.n + _WORK_BESIDE :]


@leaf
def loads_of(column):
    """Return the loads at the instant of the last `moved_and_loaded`."""
    count = ports_of(column)
    return Loads(count, _ports(places_of_ports(column), count), _pushes(pushes_of(column), count))


@leaf
def scratch_of_ports(column):
    """Return a row with room for SPOTS of all ports."""
    return pushes_of(column)[_COMPONENTS * ports_of(column) :]


# --- over time


@leaf
def _records_loads(column, k):
    """Return True if segment k of the record has loads."""
    return column.samples.loaded != 0 and 0 <= k < column.samples.size - 1


@kernel
def push_ports(column, t):
    """Compute the loads on the ports at time t, on the present segment of the record."""
    base, samples, count = column.base, column.samples, _COMPONENTS * ports_of(column)
    pushes, inputs, k = pushes_of(column), base.buffer[_BASE:], int(base.segment)
    # inputs and their slopes
    since = t - base.t0
    for i in range(count):
        pushes[i] = inputs[i] + since * inputs[count + i]
    # the line of the record beside them
    if _records_loads(column, k):
        line, past = samples.loads[2 * count * k :], t - samples.times[k]
        for i in range(count):
            pushes[i] += line[i] + past * line[count + i]


@kernel
def load_inputs(column, inputs, elapsed, t):
    """Set the loads that a caller set `elapsed` s before time t, at the time t0 of the base, and their slopes."""
    base, count = column.base, _COMPONENTS * ports_of(column)
    stored, past = base.buffer[_BASE:], elapsed - (t - base.t0)
    for i in range(count):
        slope = inputs[count + i]
        stored[i], stored[count + i] = inputs[i] + slope * past, slope


@leaf
def is_loaded(column):
    """Return True if a load acts on the present segment, or begins to."""
    return ports_of(column) > 0 and _any_load(column)


@kernel
def _any_load(column):
    numbers, k, loads = LOADS_PER_PORT * ports_of(column), int(column.base.segment), column.samples.loads
    loaded = False
    # inputs of an FMU, then the record
    for i in range(numbers):
        loaded = loaded or column.base.buffer[_BASE + i] != 0.0
    if _records_loads(column, k):
        for i in range(numbers):
            loaded = loaded or loads[numbers * k + i] != 0.0
    return loaded


# --- in the equations of motion


@kernel
def with_couple(loads, motion, model, phase, i, couple):
    """Return the couple on block i (N m) with that of the loads on it."""
    ports, pushes = loads.ports, loads.pushes
    for p in range(loads.number):
        if int(ports.body[p]) == i:
            # the place of the port from the centroid
            sine, cosine = sine_cosine(phase.theta[i] + motion.theta + model.blocks.tilt[i])
            x, z = ports.x[p] * cosine + ports.z[p] * sine, ports.z[p] * cosine - ports.x[p] * sine
            # the couple, and the moments of the forces about the centroid
            couple += pushes.my[p] + (z * pushes.fx[p] - x * pushes.fz[p])
    return couple


@kernel
def with_push(loads, motion, model, phase, i, joint, right, opens):
    """Return right side and opening of the row of a joint of block i, with the part of the loads on the block."""
    ports, pushes = loads.ports, loads.pushes
    # resultant of the loads on the block
    x, z = 0.0, 0.0
    for p in range(loads.number):
        if int(ports.body[p]) == i:
            x, z = x + pushes.fx[p], z + pushes.fz[p]
    if x == 0.0 and z == 0.0:
        return right, opens
    # its components along and across the joint
    turn_below = phase.theta[joint + 1] if joint + 1 < model.n else 0.0
    phi = 0.5 * (phase.theta[joint] + turn_below) + motion.theta + model.blocks.lean[joint]
    sine, cosine = sine_cosine(phi)
    over = model.blocks.per_mass[i] if joint == i else -model.blocks.per_mass[i]  # else the joint lies on the block
    return right - over * (x * cosine - z * sine), opens + over * (x * sine + z * cosine)
