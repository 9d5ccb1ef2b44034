"""The loads on ports of a column in its plane, and the motion of the ports: versions of kernels for records with loads.

A load is a force along x and z and a couple about y, clockwise, on a point of a block. x and z are the axes of the base
as built: they do not turn with a base that rotates, as those of u_x and of the base reaction. A load is samples, a
value and a slope on each segment of the record, and the inputs of an FMU beside them. Elsewhere the type of the record
has no loads, and nothing of this is compiled.

The force on a block gives it an acceleration u beside that of its joints. It enters the rows of the two joints of the
block as the acceleration of the base enters the lowest one: T by u along the joint, the opening by u across it.
"""

from typing import NamedTuple

from ..api.engine import BASE_INPUTS, beside_inputs, load
from ..api.observing import beside_row, motion_held, motion_of_snapshot, see
from ..api.slopes import at_once, met_by_loads
from ..formulations.base_motion import base_motion, enter, is_loaded, is_silent, moving, smooth_reach, to_next_sample
from ..formulations.dispatch import base_as_shown
from ..formulations.exact import with_couple, with_push
from ..formulations.outputs import show_more
from ..joint.sliding import can_slide
from ..layout.spaces import BASE, LOAD, PORTS, ROW, SPLIT, SPOTS, STATE, WORK
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.numbers import sine_cosine
from ..output.peaks import examines_all, raise_port_peaks
from ..stepping.advance import ROUNDING, base_jumps, belongs_to, jumps

_COMPONENTS, _SEEN, _BASE = len(LOAD), len(SPOTS.fields), BASE.beside
_INPUTS, _SPLIT = BASE_INPUTS.beside, SPLIT.beside
_spots, _ports = SPOTS.over, PORTS.over
_ROW_PER_N, _ROW_BESIDE = ROW.per_n, ROW.beside
_STATE_PER_N, _STATE_BESIDE, _WORK_PER_N, _WORK_BESIDE = STATE.per_n, STATE.beside, WORK.per_n, WORK.beside


class Loaded(NamedTuple):
    """A record with loads: as `Samples`, but its `size` instants may continue after those of the base.

    Attributes
    ----------
    size, times, ax, az, scale, held
        Those of `Samples`.
    shaken : int
        Number of samples of the base.
    spotted : int
        Number of ports.
    ports : row
        PORTS of all ports.
    lasting : int
        1 if the record has loads, else 0.
    loads : row
        Loads of each segment by component, then their slopes; none if `lasting` is 0.
    rows : row
        Times of snapshots, s.
    """

    size: int
    times: object
    ax: object
    az: object
    scale: float
    held: int
    shaken: int
    spotted: int
    ports: object
    lasting: int
    loads: object
    rows: object


class Pushed(NamedTuple):
    """The motion of the base at an instant, as `exact.Motion`, and the loads then."""

    ax: float
    az: float
    theta: float
    omega: float
    alpha: float
    spotted: int
    ports: object
    given: object  # inputs of the ports by component, then their slopes
    since: float  # s, time since these inputs were set
    lasting: int  # 1 if the record has loads too
    loads: object  # of the segment: by component, then their slopes
    past: float  # s, time since the segment began


def _are_loaded(samples, *_):
    return getattr(samples, "instance_class", None) is Loaded


def _beside_loaded(base, samples, *_):
    return _are_loaded(samples)


def of_loaded(column, *_):
    """Return True if the record of a column has loads, from numba's type of it."""
    return _are_loaded(column.types[4])


def _is_pushed(motion, *_):
    return getattr(motion, "instance_class", None) is Pushed


def _becomes_pushed(before, motion):
    return _is_pushed(motion)


# --- loads over time


@beside_inputs.version(_are_loaded)
def _beside_inputs(samples):
    return 2 * _COMPONENTS * samples.spotted


@load.version(_beside_loaded)
def _load_ports(base, samples, inputs, elapsed, t):
    taken, given, count = base.buffer[_BASE:], inputs[_INPUTS:], _COMPONENTS * samples.spotted
    past = elapsed - (t - base.t0)
    # loads at the time t0 of the base, and their slopes
    for i in range(count):
        slope = given[count + i]
        taken[i], taken[count + i] = given[i] + slope * past, slope


@is_silent.version(_are_loaded)
def _is_silent(samples, k):
    return k < 0 or k >= samples.shaken - 1


@leaf
def _lasts(samples, k):
    """Return True if segment k of the record has loads."""
    return samples.lasting > 0 and 0 <= k < samples.size - 1


@moving.version(_beside_loaded)
def _moving(base, samples, t, ax, az, theta, omega, alpha):
    count, given, k = samples.spotted, base.buffer[_BASE:], int(base.segment)
    loads, lasting, past = samples.loads, 0, 0.0
    # loads of the segment and the time since it began
    if _lasts(samples, k):
        loads, lasting, past = samples.loads[2 * _COMPONENTS * count * k :], 1, t - samples.times[k]
    return Pushed(ax, az, theta, omega, alpha, count, samples.ports, given, t - base.t0, lasting, loads, past)


@motion_held.version(_are_loaded)
def _motion_held(samples, control):
    held = control.base_ax, control.base_az, control.base_theta, control.base_omega, control.base_alpha
    return Pushed(*held, 0, samples.ports, samples.loads, 0.0, 0, samples.loads, 0.0)


@motion_of_snapshot.version(of_loaded)
def _motion_of_snapshot(column, snapshot, k):
    """Return the motion of the base at a snapshot; at the instant of a jump, with the loads after it."""
    t = column.samples.rows[k]
    if column.counts.overturned > 0:
        t = min(t, column.state.control.overturn_time)
    enter(column.base, column.samples, t)
    return moving(column.base, column.samples, t, snapshot.base.ax, snapshot.base.az, 0.0, 0.0, 0.0)


@base_as_shown.version(of_loaded)
def _base_as_shown(column, t):
    return base_motion(column.base, column.samples, t)


@smooth_reach.version(_beside_loaded)
def _smooth_reach(base, samples, t, step, left, roughest):
    return to_next_sample(base, samples, t, left)  # a load may jump there


@is_loaded.version(_beside_loaded)
def _is_loaded(base, samples):
    numbers, k = 2 * _COMPONENTS * samples.spotted, int(base.segment)
    loaded = False
    # inputs of an FMU, then the record
    for i in range(numbers):
        loaded = loaded or base.buffer[_BASE + i] != 0.0
    if _lasts(samples, k):
        for i in range(numbers):
            loaded = loaded or samples.loads[numbers * k + i] != 0.0
    return loaded


@belongs_to.version(lambda control, motion: _is_pushed(motion))
def _belongs_to(control, motion):
    return False  # the state does not hold the loads


@leaf
def _load(motion, component, p):
    """Return a component of the load on port p (N or N m)."""
    k, slope = component * motion.spotted + p, (_COMPONENTS + component) * motion.spotted + p
    load = motion.given[k] + motion.since * motion.given[slope]
    if motion.lasting > 0:
        load += motion.loads[k] + motion.past * motion.loads[slope]
    return load


@jumps.version(_becomes_pushed)
def _jumps(before, motion):
    found = base_jumps(before, motion)
    # loads that differ by more than rounding
    for component in range(_COMPONENTS):
        for p in range(motion.spotted):
            load = _load(motion, component, p)
            found = found or not abs(load - _load(before, component, p)) <= ROUNDING * abs(load)
    return found


# --- loads on blocks


@leaf
def _arm(motion, model, phase, ports, p):
    """Return the block of port p, and the place of the port from its centroid (m along x and z)."""
    i = int(ports.body[p])
    sine, cosine = sine_cosine(phase.theta[i] + motion.theta + model.blocks.tilt[i])
    return i, ports.x[p] * cosine + ports.z[p] * sine, ports.z[p] * cosine - ports.x[p] * sine


@with_couple.version(_is_pushed)
def _with_couple(motion, model, phase, i, couple):
    ports = _ports(motion.ports, motion.spotted)
    # couples, and moments of the forces about the centroid
    for p in range(motion.spotted):
        if int(ports.body[p]) == i:
            _, x, z = _arm(motion, model, phase, ports, p)
            couple += _load(motion, 2, p) + (z * _load(motion, 0, p) - x * _load(motion, 1, p))
    return couple


@with_push.version(_is_pushed)
def _with_push(motion, model, phase, i, joint, right, opens):
    # resultant of the loads on the block
    x, z = 0.0, 0.0
    ports = _ports(motion.ports, motion.spotted)
    for p in range(motion.spotted):
        if int(ports.body[p]) == i:
            x, z = x + _load(motion, 0, p), z + _load(motion, 1, p)
    if x == 0.0 and z == 0.0:
        return right, opens
    # its components along and across the joint
    turn_below = phase.theta[joint + 1] if joint + 1 < model.n else 0.0
    phi = 0.5 * (phase.theta[joint] + turn_below) + motion.theta + model.blocks.lean[joint]
    sine, cosine = sine_cosine(phi)
    over = model.blocks.per_mass[i] if joint == i else -model.blocks.per_mass[i]  # else the joint lies on the block
    return right - over * (x * cosine - z * sine), opens + over * (x * sine + z * cosine)


# --- motion of the ports


@kernel
def see_points(motion, model, phase, ports, spots):
    """Fill `spots` with the motion of the ports (SPOTS, of as many as `ports`) in an evaluated phase.

    Along the chain, from the base up. Displacements count from the column as built, and all is relative to the point of
    the base under the column: m, m/s, m/s2.
    """
    n, blocks, slides = model.n, model.blocks, can_slide(model)
    x, z, built_x, built_z, vx, vz, ax, az = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0  # of the top face below
    turn_below, spin_below, alpha_below = motion.theta, motion.omega, motion.alpha
    for i in range(n - 1, -1, -1):
        turn, spin = phase.theta[i] + motion.theta, phase.theta_rate[i] + motion.omega
        alpha = phase.theta_acceleration[i] + motion.alpha
        # across the joint: the opening along n, the slip along t
        phi, swing, swings = 0.5 * (turn + turn_below), 0.5 * (spin + spin_below), 0.5 * (alpha + alpha_below)
        sine, cosine = sine_cosine(phi + blocks.lean[i])
        opening, opens, opened = phase.opening[i], phase.opening_rate[i], phase.opening_acceleration[i]
        slip, slides_by, slid = 0.0, 0.0, 0.0
        if slides:
            slip, slides_by, slid = phase.slip[i], phase.slip_rate[i], phase.slip_acceleration[i]
            sine_built, cosine_built = sine_cosine(blocks.lean[i])
            built_x, built_z = built_x + blocks.offset[i] * cosine_built, built_z - blocks.offset[i] * sine_built
        x, z = x + (opening * sine + slip * cosine), z + (opening * cosine - slip * sine)
        # velocity: rates across and along the joint, with its rotation
        across, along = opens - slip * swing, slides_by + opening * swing
        vx, vz = vx + (across * sine + along * cosine), vz + (across * cosine - along * sine)
        # acceleration, with the terms of Coriolis and centripetal acceleration
        across = opened - opening * swing * swing - 2.0 * slides_by * swing - slip * swings
        along = slid - slip * swing * swing + 2.0 * opens * swing + opening * swings
        ax, az = ax + (across * sine + along * cosine), az + (across * cosine - along * sine)
        sine, cosine = sine_cosine(turn + blocks.tilt[i])
        sine_built, cosine_built = sine_cosine(blocks.tilt[i])
        square, upper = spin * spin, blocks.height[i]
        # ports of the block: from the middle of its bottom face by an arm that turns with it
        for p in range(ports.n):
            if int(ports.body[p]) == i:
                right, up = ports.x[p], blocks.centroid[i] + ports.z[p]
                arm_x, arm_z = up * sine + right * cosine, up * cosine - right * sine
                spots.x[p] = (x - built_x) + (arm_x - (up * sine_built + right * cosine_built))
                spots.z[p] = (z - built_z) + (arm_z - (up * cosine_built - right * sine_built))
                spots.vx[p], spots.vz[p] = vx + spin * arm_z, vz - spin * arm_x
                spots.ax[p] = ax + alpha * arm_z - square * arm_x
                spots.az[p] = az - alpha * arm_x - square * arm_z
        # the middle of the top face, for the next block
        x, z, built_x, built_z = (
            x + upper * sine,
            z + upper * cosine,
            built_x + upper * sine_built,
            built_z + upper * cosine_built,
        )
        vx, vz = vx + spin * upper * cosine, vz - spin * upper * sine
        ax += upper * (alpha * cosine - square * sine)
        az -= upper * (alpha * sine + square * cosine)
        turn_below, spin_below, alpha_below = turn, spin, alpha


@beside_row.version(of_loaded)
def _beside_row(column):
    return _SEEN * column.samples.spotted


@show_more.version(of_loaded)
def _show_ports(column, phase, motion, row):
    count, behind = column.samples.spotted, _ROW_PER_N * column.model.n + _ROW_BESIDE
    spots = _spots(row.buffer[behind:], count)
    see_points(motion, column.model, phase, _ports(column.samples.ports, count), spots)


@raise_port_peaks.version(of_loaded)
def _raise_port_peaks(column, phase, motion):
    count, n = column.samples.spotted, column.model.n
    peaks, scratch = (
        column.state.buffer[_STATE_PER_N * n + _STATE_BESIDE :],
        column.work.buffer[_WORK_PER_N * n + _WORK_BESIDE :],
    )
    # motion of the ports in scratch, and its largest magnitudes
    see_points(motion, column.model, phase, _ports(column.samples.ports, count), _spots(scratch, count))
    for j in range(_SEEN * count):
        peaks[j] = max(peaks[j], abs(scratch[j]))


@examines_all.version(of_loaded)
def _examines_all(column):
    return True


# --- derivatives by loads


@leaf
def _more(motion, along_x, along_z, alpha, seeds, elapsed):
    """Return the motion with accelerations and loads added; elapsed: time since their slopes began, s."""
    begin = motion.ax + along_x, motion.az + along_z, motion.theta, motion.omega, motion.alpha + alpha
    return Pushed(*begin, motion.spotted, motion.ports, motion.given, motion.since, 1, seeds[_INPUTS:], elapsed)


@met_by_loads.version(of_loaded)
def _met_by_loads(column, motion, seeds, elapsed, other, split, other_split):
    # the change of the split reaction by the seeds: with the added loads, less without
    for i in range(_SPLIT):
        split.row[i] -= other_split.row[i]
    see(column, _more(motion, 0.0, 0.0, 0.0, seeds, elapsed), other, other_split)
    for i in range(_SPLIT):
        split.row[i] += other_split.row[i]
    see(column, motion, other, other_split)


@at_once.version(of_loaded)
def _at_once(column, motion, seeds, elapsed, along_x, along_z, alpha, row, other, other_split):
    length = _ROW_PER_N * column.model.n + _ROW_BESIDE + beside_row(column)
    # the change of the output row by the seeds: with them, less without
    for i in range(length):
        row.buffer[i] -= other.buffer[i]
    see(column, _more(motion, along_x, along_z, alpha, seeds, elapsed), other, other_split)
    for i in range(length):
        row.buffer[i] += other.buffer[i]
