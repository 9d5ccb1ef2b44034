"""Entry points: the kernels of a structure over flat buffers."""

from ..engine.samples import no_samples, samples_over, unloaded
from ..machine.entry import entry
from ..machine.kinds import Int, Ints, Real, Reals, SizedReals
from ..numba_ext.jit import kernel
from ..numba_ext.views import lanes_of
from . import driven
from .cracking import settle_bonds
from .evaluate import energy, evaluate, recall, settle_memory, show
from .in_lanes import SpatialQueue, batch_over, follow_queue
from .layout import KEEP, PHASE, PRESUME, STATE, scene_of, sizes_in
from .meeting import presume_pairs, settle_pairs
from .stepping import advance
from .watch import SpatialWatch

_phase, _state = PHASE.over, STATE.over


@kernel
def see(model, state, counts, base, samples, work):
    """Return the scene of a structure, and its state as a row."""
    # the state without its padding
    sizes, scene = sizes_in(model), scene_of(model, state, counts, base, samples, work)
    return scene, _state(state, sizes).phase.buffer[: sizes.state]


@kernel
def _turn(phase, i, axis, angle):
    """Rotate body i by an angle, rad, about an axis of the base, to second order in the angle."""
    half = 0.5 * angle
    x, y, z = half if axis == 0 else 0.0, half if axis == 1 else 0.0, half if axis == 2 else 0.0
    scalar = (1.0 - half * half) ** 0.5
    # product of both quaternions
    q0, q1, q2, q3 = phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i]
    phase.q0[i] = scalar * q0 - x * q1 - y * q2 - z * q3
    phase.q1[i] = scalar * q1 + x * q0 + y * q3 - z * q2
    phase.q2[i] = scalar * q2 + y * q0 + z * q1 - x * q3
    phase.q3[i] = scalar * q3 + z * q0 + x * q2 - y * q1


@kernel
def _find_stiffness(scene, from_, scratch, rates, delta, matrix):
    """Fill `matrix` with the tangent stiffness by rows, N and N m per m and rad, by central differences of `delta`."""
    n = scene.n
    size = 6 * n
    turned, poses = _phase(scratch, n), scene.poses
    recall(scene, from_)
    for column in range(size):
        i, axis = column // 6, column % 6
        for way in range(2):
            # the state with one coordinate moved
            for place in range(13 * n):
                scratch[place] = from_[place]
            step = delta[column] if way == 0 else -delta[column]
            if axis < 3:
                scratch[axis * n + i] += step
            else:
                _turn(turned, i, axis - 3, step)
            evaluate(scene, turned, _phase(rates, n), 0.0, 0.0, 0.0)
            # half of the difference of the forces on all bodies
            per = -0.5 / step
            for other in range(n):
                place = 6 * other * size + column
                for part in range(6):
                    if way == 0:
                        matrix[place + part * size] = 0.0
                matrix[place] += per * poses.fx[other]
                matrix[place + size] += per * poses.fy[other]
                matrix[place + 2 * size] += per * poses.fz[other]
                matrix[place + 3 * size] += per * poses.mx[other]
                matrix[place + 4 * size] += per * poses.my[other]
                matrix[place + 5 * size] += per * poses.mz[other]


@entry("structure")
def run_structure(
    model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, times: SizedReals, ax: SizedReals,
    ay: Reals, az: Reals, scale: Real, held: Int, loads: SizedReals, at: SizedReals, rows: SizedReals, t: Real,
    stop: Real, most: Int,
) -> Int:  # fmt: skip
    """Run `stepping.advance` over a record (base.py), with an output row at each time of `at`; return its code.

    Parameters
    ----------
    model, state, counts, base, work : row
        The arrays of a structure (layout.py).
    times, ax, ay, az : row
        Times of the samples, s, and accelerations of the base, m/s2.
    scale, held : float, int
        Factor on the accelerations; 1: samples are held, 0: joined by straight lines.
    loads : row
        Loads at ports, values and slopes of each interval (port.py), or empty.
    at : row
        Times of the output rows, s.
    rows : row
        The output rows to fill; if they are wider, each is followed by the integrated part of the state.
    t, stop : float
        Time interval, s.
    most : int
        Largest number of steps.
    """
    scene, phase = see(model, state, counts, base, samples_over(times, ax, ay, az, scale, held, loads), work)
    # output rows
    watch = SpatialWatch(at.size, at.row, rows.row, rows.size // max(1, at.size))
    return advance(scene, watch, phase, t, stop, most)


@entry("structure")
def observe_structure(
    model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, rates: Reals, ax: Real, ay: Real, az: Real,
    row: Reals, keep: Int,
) -> Real:  # fmt: skip
    """Evaluate the state under a base acceleration and the loads in WORK; fill its rates and output row.

    Parameters
    ----------
    model, state, counts, base, work : row
        The arrays of a structure (layout.py).
    rates : row
        Rates of the phase to fill.
    ax, ay, az : float
        Acceleration of the base, m/s2.
    row : row
        Output row to fill.
    keep : int
        KEEP: the memory of joints, ties and pairs is set to this state, as after a long rest. PRESUME: first, all pairs
        that are near are let touch, so that a balance is found with the contacts that close on the way to it.

    Returns
    -------
    float
        Mechanical energy, J.
    """
    scene, phase = see(model, state, counts, base, no_samples(work), work)
    seen = _phase(phase, scene.n)
    if keep == PRESUME:
        presume_pairs(scene, phase)
    recall(scene, phase)
    evaluate(scene, seen, _phase(rates, scene.n), ax, ay, az)
    # plastic parts are set to what exceeds the limits, pairs meet or separate, and bonds are broken
    if keep == KEEP:
        settle_memory(scene, phase)
        met = settle_pairs(scene, phase)
        if settle_bonds(scene, phase) or met:
            recall(scene, phase)
            evaluate(scene, seen, _phase(rates, scene.n), ax, ay, az)
    show(scene, seen, row, True)
    return energy(scene, seen)


@entry("structure")
def stiffness_of(
    model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, scratch: Reals, rates: Reals, delta: Reals,
    matrix: Reals,
):  # fmt: skip
    """Fill `matrix` (6 n x 6 n, by rows) with the tangent stiffness about the state, which has no rates.

    Its entries are forces and couples on the centroids by displacements and rotations about the axes of the base, N and
    N m per m and rad. delta: step of each coordinate, m or rad. The memory of joints and ties is that of the state.
    """
    scene, phase = see(model, state, counts, base, no_samples(work), work)
    _find_stiffness(scene, phase, scratch, rates, delta, matrix)


@entry("structure_lanes")
def run_structures_in_lanes(
    buffer: Reals, size: Int, models: Reals, states: Reals, runs: Reals, outcomes: Reals, peaks: Reals,
    times: Reals, ax: Reals, ay: Reals, az: Reals, row_times: SizedReals, places: Reals, flag: Reals,
):  # fmt: skip
    """Run `in_lanes.follow_queue`; buffer: scratch space, eight numbers for each of one lane."""
    queue = SpatialQueue(
        size, models, states, runs, outcomes, peaks, times, ax, ay, az, row_times.row, row_times.size, places, flag
    )
    follow_queue(batch_over(sizes_in(models), lanes_of(buffer), queue))


# --- a structure under inputs, for both FMUs: driven.py over buffers. A record is as in api/driven_entries.py, with ay


@entry("structure_driven")
def assemble(
    model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, given: Reals, from_rest: Int
) -> Int:  # fmt: skip
    """Run `driven.assemble`."""
    return driven.assemble(model, state, counts, base, work, given, from_rest)


@entry("structure_driven")
def follow(
    model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, inputs: Reals, start: Real, h: Real,
    times: SizedReals, ax: Reals, ay: Reals, az: Reals, scale: Real, row: Reals,
) -> Int:  # fmt: skip
    """Run `driven.follow`."""
    samples = unloaded(times.row, times.size, ax, ay, az, scale, 0)
    return driven.follow(model, state, counts, base, work, inputs, start, h, samples, row)


@entry("structure_driven")
def look(
    model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, inputs: Reals, new_inputs: Int, elapsed: Real,
    t: Real, times: SizedReals, ax: Reals, ay: Reals, az: Reals, scale: Real, row: Reals, split: Reals,
) -> Int:  # fmt: skip
    """Run `driven.look`."""
    samples = unloaded(times.row, times.size, ax, ay, az, scale, 0)
    return driven.look(model, state, counts, base, work, inputs, new_inputs, elapsed, t, samples, row, split)


@entry("structure_driven")
def rates(
    model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, t: Real, times: SizedReals, ax: Reals,
    ay: Reals, az: Reals, scale: Real, row: Reals, split: Reals,
) -> Int:  # fmt: skip
    """Run `driven.rates`."""
    samples = unloaded(times.row, times.size, ax, ay, az, scale, 0)
    return driven.rates(model, state, counts, base, work, t, samples, row, split)


@entry("structure_driven")
def feedthrough(
    model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, seeds: Reals, elapsed: Real, t: Real,
    row: Reals, split: Reals,
) -> Int:  # fmt: skip
    """Run `driven.feedthrough`."""
    return driven.feedthrough(model, state, counts, base, work, seeds, elapsed, t, row, split)
