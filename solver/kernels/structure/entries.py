"""Entries called from Python: a structure over flat arrays."""

from ..numba_ext.jit import entry, kernel
from ..numba_ext.views import lanes_of, row_of
from . import driven
from .base import Shaking
from .cracking import settle_bonds
from .evaluate import energy, evaluate, recall, settle_memory, show
from .in_lanes import Queue, batch_over, follow_queue
from .layout import INPUT_MOTION, PHASE, STATE, scene_of, sizes_in
from .stepping import advance
from .watch import Watch

_phase, _input, _state = PHASE.over, INPUT_MOTION.over, STATE.over

# arrays: model, state, counts, base, work; behind them, but for the entries of driven.py, extras: WITH_EXTRAS, or None
# if the structure has none


@kernel
def _rows(arrays):
    return row_of(arrays[0]), row_of(arrays[1]), row_of(arrays[2]), row_of(arrays[3]), row_of(arrays[4])


@kernel
def see(arrays):
    """The scene of a structure, and its state as a row."""
    model, state, counts, _, work = _rows(arrays)
    scene = scene_of(model, state, counts, work, arrays[5])
    return scene, _state(state, sizes_in(model)).phase.row


@kernel
def _input_of(arrays):
    return _input(row_of(arrays[3]), sizes_in(row_of(arrays[0])))


@entry
def run_structure(arrays, record, at, rows, t, stop, most):
    """`stepping.advance` over a record (times, ax, ay, az, loads: base.py), with an output row at each time of `at`.

    rows: with room for a state behind each, that is filled in too, as far as it moves.
    """
    scene, state = see(arrays)
    times, ax, ay, az, loads = record
    samples, inputs = (row_of(times), row_of(ax), row_of(ay), row_of(az)), _input_of(arrays)
    of_loads = 1 if loads.size > 0 else 0, row_of(loads), inputs.loads.row
    shaking = Shaking(times.size, ax.size, *samples, inputs.motion, *of_loads)
    watch = Watch(at.size, row_of(at), row_of(rows), rows.size // max(1, at.size))
    return advance(scene, shaking, watch, state, t, stop, most)


@entry
def observe_structure(arrays, rates, ax, ay, az, row, keep):
    """Evaluate the state under an acceleration of the base, m/s2, and the loads in WORK: its rates and output row.

    Returns its energy, J.
    keep: whether joints and ties remember this state, as after a long rest.
    """
    scene, state = see(arrays)
    seen = _phase(state, scene.n)
    recall(scene, state)
    evaluate(scene, seen, _phase(row_of(rates), scene.n), ax, ay, az)
    if keep:
        settle_memory(scene, state)
        if settle_bonds(scene, state):
            evaluate(scene, seen, _phase(row_of(rates), scene.n), ax, ay, az)
    show(scene, seen, row_of(row))
    return energy(scene, seen)


@entry
def stiffness_of(arrays, scratch, rates, delta, matrix):
    """Tangent stiffness about the state, which has no rates: matrix (6 n x 6 n) by rows, N and N m per m and rad.

    Forces on the centroids by displacements and rotations about the axes of the base, by central differences of `delta`
    (a number for each coordinate, m or rad). Joints and ties remember what the state says.
    """
    scene, from_ = see(arrays)
    n = scene.n
    size = 6 * n
    to, found = row_of(scratch), row_of(matrix)
    turned, poses = _phase(to, n), scene.poses
    recall(scene, from_)
    for column in range(size):
        i, axis = column // 6, column % 6
        for way in range(2):
            for place in range(13 * n):
                to[place] = from_[place]
            step = delta[column] if way == 0 else -delta[column]
            if axis < 3:
                to[axis * n + i] += step
            else:
                _turn(turned, i, axis - 3, step)
            evaluate(scene, turned, _phase(row_of(rates), n), 0.0, 0.0, 0.0)
            per = -0.5 / step
            for other in range(n):
                place = 6 * other * size + column
                for part in range(6):
                    if way == 0:
                        found[place + part * size] = 0.0
                found[place] += per * poses.fx[other]
                found[place + size] += per * poses.fy[other]
                found[place + 2 * size] += per * poses.fz[other]
                found[place + 3 * size] += per * poses.mx[other]
                found[place + 4 * size] += per * poses.my[other]
                found[place + 5 * size] += per * poses.mz[other]


@kernel
def _turn(phase, i, axis, angle):
    """Turn body i by an angle, rad, about an axis of the base, to the second order."""
    half = 0.5 * angle
    x, y, z = half if axis == 0 else 0.0, half if axis == 1 else 0.0, half if axis == 2 else 0.0
    scalar = (1.0 - half * half) ** 0.5
    q0, q1, q2, q3 = phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i]
    phase.q0[i] = scalar * q0 - x * q1 - y * q2 - z * q3
    phase.q1[i] = scalar * q1 + x * q0 + y * q3 - z * q2
    phase.q2[i] = scalar * q2 + y * q0 + z * q1 - x * q3
    phase.q3[i] = scalar * q3 + z * q0 + x * q2 - y * q1


@entry
def run_structures_in_lanes(buffer, size, models, states, runs, outcomes, peaks, record, flag, extras):
    """`in_lanes.follow_queue` over arrays; buffer: eight numbers for each of a lane; extras: as above."""
    given = row_of(models), row_of(states), row_of(runs), row_of(outcomes), row_of(peaks)
    times, ax, ay, az = record
    queue = Queue(size, *given, row_of(times), row_of(ax), row_of(ay), row_of(az), row_of(flag), extras)
    follow_queue(batch_over(sizes_in(row_of(models)), lanes_of(buffer), queue))


# --- a structure under inputs: driven.py over arrays


@entry
def assemble_structure(arrays, given, from_rest):
    """`driven.assemble`."""
    return driven.assemble(*_rows(arrays), row_of(given), from_rest)


@entry
def follow_structure(arrays, inputs, t, h, times, ax, ay, az, row):
    """`driven.follow`."""
    record = times.size, row_of(times), row_of(ax), row_of(ay), row_of(az), 1.0
    return driven.follow(*_rows(arrays), row_of(inputs), t, h, *record, row_of(row))


@entry
def look_structure(arrays, inputs, new_inputs, elapsed, t, times, ax, ay, az, row, driven_row):
    """`driven.look`."""
    record = times.size, row_of(times), row_of(ax), row_of(ay), row_of(az), 1.0
    return driven.look(*_rows(arrays), row_of(inputs), new_inputs, elapsed, t, *record, row_of(row), row_of(driven_row))
