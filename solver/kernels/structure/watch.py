"""The motion within a step: interpolation, output rows, and peaks of the continuous motion.

A step is evaluated at its ends and in the middle. Parabolas through the three show which quantities may peak within the
step; these are evaluated where they may.
"""

import math
from typing import NamedTuple

from ..engine.interpolation import quintic_through, value_of
from ..engine.peaks import (
    MARGIN,
    MOST_TRIALS,
    NEAR,
    apart,
    nearer,
    vertex,
)
from ..engine.queue import peak_over
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import any_of, index_of, square_root, zero_like
from .contact import keep_gaps
from .evaluate import evaluate_state, moving, show, show_block, show_joint
from .extras import first_gap, taken_at
from .joint import load_joint
from .kinematics import pose_body, spin_of
from .layout import MEMORY, OF_BASE, OF_BEARING, OF_BLOCK, OF_JOINT, OF_PAIR, PHASE, PROMISE, STAGES

_phase = PHASE.over
_PER_BODY, _PER_JOINT = PHASE.per_n, MEMORY.per_n
_BLOCKS = len(OF_BLOCK)
_CONTACT = OF_JOINT.index("contact")
EDGE = 0.1  # of a step: least distance of the first trial from its ends
KINKED = 0.5  # of the bend: largest deviation of a joint force, which may have a kink, above the parabola
BEYOND = 0.1  # of the change to the middle: how far such a force may still rise from the start of a step
QUIET = 1e-3  # of the largest peak of a field: smaller peaks are found to a tolerance relative to this


class SpatialWatch(NamedTuple):
    """The times, s, at which output rows are filled; if rows are wider (`wide`), the state follows each."""

    size: int
    times: object
    rows: object
    wide: int  # length of a row


@leaf
def row(scene, k):
    """Return row k of a step: START, RATES at the stages, STAGE, END, BETWEEN (at a time within it), BETWEEN_RATES."""
    return scene.states[k * scene.stride : (k + 1) * scene.stride]


START, RATES = 0, 1
STAGE, END, BETWEEN, BETWEEN_RATES = range(1 + STAGES, 5 + STAGES)


@leaf
def seen(scene, k):
    """Return output row k of a step: 0 start, 1 middle, 2 end, 3 a trial, 4 allowed rises."""
    return scene.outputs[k * scene.visible : (k + 1) * scene.visible]


@leaf
def quaternion_curve(phase, rates, i):
    """Return the second derivative of the quaternion of body i."""
    # quaternion and its rate, angular velocity and acceleration
    q = phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i]
    p = rates.q0[i], rates.q1[i], rates.q2[i], rates.q3[i]
    x, y, z = phase.wx[i], phase.wy[i], phase.wz[i]
    a, b, c = rates.wx[i], rates.wy[i], rates.wz[i]
    # derivative of q' = q w / 2
    return (
        -0.5 * (p[1] * x + p[2] * y + p[3] * z + q[1] * a + q[2] * b + q[3] * c),
        0.5 * (p[0] * x + p[2] * z - p[3] * y + q[0] * a + q[2] * c - q[3] * b),
        0.5 * (p[0] * y + p[3] * x - p[1] * z + q[0] * b + q[3] * a - q[1] * c),
        0.5 * (p[0] * z + p[1] * y - p[2] * x + q[0] * c + q[1] * b - q[2] * a),
    )


@leaf
def _through(h, s, q0, v0, a0, q1, v1, a1):
    """Return value and rate at fraction s of a step by the quintic through value, rate and acceleration at its ends."""
    return value_of(quintic_through(h, q0, v0, a0, q1, v1, a1, 0.0), s)


@kernel
def interpolate_body(scene, h, s, i):
    """Fill row BETWEEN with the place and the rates of body i at fraction s of a step of h s."""
    n = scene.n
    start, end, between = _phase(row(scene, START), n), _phase(row(scene, END), n), _phase(row(scene, BETWEEN), n)
    first, last = _phase(row(scene, RATES), n), _phase(row(scene, RATES + STAGES - 1), n)
    # displacement
    for axis in range(3):
        place = axis * n + i
        q0, v0, a0 = start.displacement[place], first.displacement[place], first.velocity[place]
        q1, v1, a1 = end.displacement[place], last.displacement[place], last.velocity[place]
        between.displacement[place], between.velocity[place] = _through(h, s, q0, v0, a0, q1, v1, a1)
    # quaternion, normalized, and angular velocity
    a, b = quaternion_curve(start, first, i), quaternion_curve(end, last, i)
    q0, p0 = _through(h, s, start.q0[i], first.q0[i], a[0], end.q0[i], last.q0[i], b[0])
    q1, p1 = _through(h, s, start.q1[i], first.q1[i], a[1], end.q1[i], last.q1[i], b[1])
    q2, p2 = _through(h, s, start.q2[i], first.q2[i], a[2], end.q2[i], last.q2[i], b[2])
    q3, p3 = _through(h, s, start.q3[i], first.q3[i], a[3], end.q3[i], last.q3[i], b[3])
    # normalize
    per = 1.0 / (q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3)
    x, y, z = spin_of((q0, q1, q2, q3), (p0, p1, p2, p3))
    between.wx[i], between.wy[i], between.wz[i] = per * x, per * y, per * z
    size = square_root(per)
    between.q0[i], between.q1[i], between.q2[i], between.q3[i] = size * q0, size * q1, size * q2, size * q3


@leaf
def _remembered(scene, h, s, place):
    """Return number `place` of the memory at fraction s of a step, by the cubic through values and rates."""
    begin, end = row(scene, START)[place], row(scene, END)[place]
    first, last = h * row(scene, RATES)[place], h * row(scene, RATES + STAGES - 1)[place]
    left, change = 1.0 - s, end - begin
    return begin + s * (change + left * (left * first - s * last - (left - s) * change))  # exact for a constant


@kernel
def _interpolate(scene, h, s):
    """Fill row BETWEEN with the state at fraction s of the step."""
    for i in range(scene.n):
        interpolate_body(scene, h, s, i)
    # memory of joints, ties and pairs
    between = row(scene, BETWEEN)
    for place in range(_PER_BODY * scene.n, moving(scene)):
        between[place] = _remembered(scene, h, s, place)


@kernel
def look(scene, segment, t, h, s, into, every_gap):
    """Fill the output row `into` at fraction s of the step from t to t + h; every_gap: as of `show`."""
    scene.counts.looks += 1
    # evaluate the interpolated state under the base motion of that instant
    _interpolate(scene, h, s)
    ax, ay, az = taken_at(scene, segment, t + s * h)
    evaluate_state(scene, row(scene, BETWEEN), row(scene, BETWEEN_RATES), ax, ay, az)
    show(scene, _phase(row(scene, BETWEEN), scene.n), into, every_gap)


@leaf
def gaps_in_row(scene):
    """Return the indices of the first gap of neighbours in an output row, and of the number after the last."""
    first = first_gap(scene)
    return first, first + scene.extras.met


@leaf
def _by_least(scene, j):
    """Return True if the peak of quantity j of an output row is its minimum: contacts, bonds and gaps."""
    first, (gap, end) = _BLOCKS * scene.n + _CONTACT * scene.m, gaps_in_row(scene)
    return first <= j < first + scene.m or gap - scene.extras.glued <= j < end


@leaf
def _value(scene, j, value):
    """Return the peak measure of quantity j of an output row: its size, or 1 less the value if its minimum counts."""
    return 1.0 - value if _by_least(scene, j) else abs(value)


@leaf
def _raise_peak(scene, j, value):
    scene.peaks[j] = max(scene.peaks[j], _value(scene, j, value))


@kernel
def _rises(scene, values):
    """Return True if an output row would raise a peak."""
    found = 0
    for j in range(scene.visible):
        found += 1 if _value(scene, j, values[j]) > scene.peaks[j] else 0
    return found > 0


@kernel
def raise_peaks(scene, values):
    """Raise the peaks by an output row."""
    for j in range(scene.visible):
        _raise_peak(scene, j, values[j])


@kernel
def clear_peaks(scene):
    """Set all peaks to zero; least gaps to infinite ones."""
    first, end = gaps_in_row(scene)
    for j in range(scene.visible):
        scene.peaks[j] = -math.inf if first <= j < end else 0.0


@leaf
def _allow_field(scene, allowed, first, count):
    """Fill `allowed` with how far the quantities of a field may exceed their peaks without a search.

    first, count: its indices in an output row.
    """
    # largest peak of the field
    largest = 0.0
    for j in range(first, first + count):
        largest = max(largest, scene.peaks[j])
    # a part of each peak, or of a small part of the largest one
    part = PROMISE * scene.settings.tolerance
    for j in range(first, first + count):
        allowed[j] = part * max(scene.peaks[j], QUIET * largest)


@kernel
def _allow(scene, allowed):
    """Fill the allowed rises of all fields of an output row.

    Forces and moments of the base are two fields, each output of the whole is one.
    """
    n, m = scene.n, scene.m
    for field in range(2):  # displacements, rotations
        _allow_field(scene, allowed, 3 * field * n, 3 * n)
    # joints, ties and extras
    first = _BLOCKS * n
    for field in range(len(OF_JOINT)):
        _allow_field(scene, allowed, first + field * m, m)
    first += len(OF_JOINT) * m
    _allow_field(scene, allowed, first, scene.k)
    _allow_extras(scene, allowed, first + scene.k)
    # force and moment on the base, then each output of the whole
    first = scene.visible - len(OF_BASE)
    for half in range(2):
        _allow_field(scene, allowed, first + 3 * half, 3)
    for other in range(6, len(OF_BASE)):
        _allow_field(scene, allowed, first + other, 1)


@kernel
def _allow_extras(scene, allowed, first):
    """Fill the allowed rises of extras, from index `first`.

    Places, velocities and accelerations of ports are three fields.
    """
    b, spotted = scene.extras.b, scene.extras.spotted
    # bearings, bonds, pairs, ports
    _allow_field(scene, allowed, first, len(OF_BEARING) * b)
    first += len(OF_BEARING) * b
    _allow_field(scene, allowed, first, scene.extras.glued)
    first += scene.extras.glued
    for field in range(len(OF_PAIR)):
        _allow_field(scene, allowed, first + field * scene.extras.met, scene.extras.met)
    first += len(OF_PAIR) * scene.extras.met
    for third in range(3):
        _allow_field(scene, allowed, first + 3 * third * spotted, 3 * spotted)


@kernel
def way_of(scene, h, i):
    """Return more than any point of a body moves in a step of h s, m: twice the mean of both ends; 0 of the base."""
    way = zero_like(h)
    if i < scene.n:
        for k in (START, END):
            phase = _phase(row(scene, k), scene.n)
            v = phase.vx[i] * phase.vx[i] + phase.vy[i] * phase.vy[i] + phase.vz[i] * phase.vz[i]
            w = phase.wx[i] * phase.wx[i] + phase.wy[i] * phase.wy[i] + phase.wz[i] * phase.wz[i]
            way += h * (square_root(v) + scene.bodies.reach[i] * square_root(w))
    return way


@kernel
def travel(scene, h):
    """Add to the ways of all bodies more than any of their points moves in a step of h s, m, if there are pairs."""
    if scene.extras.met == 0:
        return
    for i in range(scene.n):
        scene.poses.way[i] += way_of(scene, h, i)


@kernel
def _raise_turns(scene, h):
    """Raise the peaks of displacements by turning points within the step of h s just made."""
    begin, end, n, peaks = _phase(row(scene, START), scene.n), _phase(row(scene, END), scene.n), scene.n, scene.peaks
    for i in range(n):
        peaks[i] = peak_over(peaks[i], begin.ux[i], begin.vx[i], end.ux[i], end.vx[i], h, True)
        peaks[n + i] = peak_over(peaks[n + i], begin.uy[i], begin.vy[i], end.uy[i], end.vy[i], h, True)
        peaks[2 * n + i] = peak_over(peaks[2 * n + i], begin.uz[i], begin.vz[i], end.uz[i], end.vz[i], h, True)


@kernel
def track_peaks(scene, segment, t, h, by_modes):
    """Raise the peaks by the step just made, whose end has been evaluated last; by modes its middle is known."""
    count = scene.visible
    begin, middle, end = seen(scene, 0), seen(scene, 1), seen(scene, 2)
    # outputs at the end of the step
    show(scene, _phase(row(scene, END), scene.n), end, False)
    keep_gaps(scene, end[first_gap(scene) :])
    if by_modes and _rises(scene, end):  # outputs were those of the prediction
        look(scene, segment, t, h, 1.0, end, False)
    raise_peaks(scene, end)
    # displacements within the step, of all else the middle and tops between
    if scene.settings.watches == 0.0:
        _raise_turns(scene, h)
    else:
        if not by_modes or _rises(scene, middle):
            look(scene, segment, t, h, 0.5, middle, False)
        raise_peaks(scene, middle)
        _find_tops(scene, segment, t, h)
    # the end becomes the start of the next step
    for j in range(count):
        begin[j] = end[j]


@kernel
def pose_between(scene, h, s, one, other):
    """Place two bodies at fraction s of a step of h s; return the phase in which they are filled in."""
    phase = _phase(row(scene, BETWEEN), scene.n)
    for body in (one, other):
        if body < scene.n:
            interpolate_body(scene, h, s, body)
            pose_body(scene, phase, body)
    return phase


@kernel
def load_joint_between(scene, h, s, j):
    """Load joint j at fraction s of a step of h s; return the phase in which its two bodies are filled in."""
    phase = pose_between(scene, h, s, index_of(scene.joints.upper[j]), index_of(scene.joints.lower[j]))
    # slips of the joint at that instant
    if any_of(scene.settings.gives_way != 0.0):
        for place in range(j, _PER_JOINT * scene.m, scene.m):
            scene.memory[place] = _remembered(scene, h, s, _PER_BODY * scene.n + place)
    load_joint(scene, phase, j)
    return phase


@kernel
def _sample_quantity(scene, segment, t, h, s, q):
    """Raise the peaks of the block or joint of quantity q at fraction s of the step; return that quantity there.

    A block needs only itself, a joint its two bodies: so a search costs the same in a structure of any size. Ties and
    the base, of which there are few, need the whole structure.
    """
    n, m, trial, between = scene.n, scene.m, seen(scene, 3), row(scene, BETWEEN)
    of_joints, of_ties = _BLOCKS * n, _BLOCKS * n + len(OF_JOINT) * m
    phase = _phase(between, n)
    if q < of_joints:
        # a block
        i = q % n
        interpolate_body(scene, h, s, i)
        show_block(scene, phase, i, trial)
        for place in range(i, of_joints, n):
            _raise_peak(scene, place, trial[place])
    elif q < of_ties:
        # a joint
        j = (q - of_joints) % m
        load_joint_between(scene, h, s, j)
        show_joint(scene, j, trial)
        for place in range(of_joints + j, of_ties, m):
            _raise_peak(scene, place, trial[place])
    else:
        # anything else
        look(scene, segment, t, h, s, trial, False)
        raise_peaks(scene, trial)
    return trial[q]


@kernel
def _find_tops(scene, segment, t, h):
    """Raise the peaks where parabolas through three points of the step may exceed them, by a few trials each."""
    begin, middle, end = seen(scene, 0), seen(scene, 1), seen(scene, 2)
    allowed = seen(scene, 4)
    _allow(scene, allowed)
    of_joints, of_ties = _BLOCKS * scene.n, _BLOCKS * scene.n + len(OF_JOINT) * scene.m
    for j in range(scene.visible):
        # the three values, so that a peak is a maximum
        by_least = _by_least(scene, j)
        sign = -1.0 if middle[j] < 0.0 or by_least else 1.0
        a, b, c = sign * begin[j], sign * middle[j], sign * end[j]
        bend, rise = 2.0 * b - a - c, c - a
        has_kinks = of_joints <= j < of_ties and not by_least  # where a joint begins to slide or to open
        above = scene.peaks[j] + allowed[j] - (1.0 if by_least else 0.0)
        # the first trial: at the vertex, or near the start where a kink may follow
        if abs(rise) < NEAR * bend:
            s, height = 0.5 + rise / (4.0 * bend), b + rise * rise / (8.0 * bend)
            height += (KINKED if has_kinks else MARGIN) * bend
            s = min(max(s, EDGE), 1.0 - EDGE)
        elif has_kinks and a > b:
            s, height = EDGE, a + BEYOND * (a - b)
        else:
            continue
        trials, known = 0, (0.0, a, 0.5, b, 1.0, c)
        while height > above and trials < MOST_TRIALS and 0.0 < s < 1.0:
            # evaluate, and take the three points that bracket the maximum
            found = sign * _sample_quantity(scene, segment, t, h, s, j)
            trials += 1
            known = nearer(known, s, found)
            s, height = vertex(*known)
            s = apart(known, s)
            above = max(above, found + allowed[j])
