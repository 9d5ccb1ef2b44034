"""Peaks of everything visible, of the motion between the output rows too.

A step is looked into only where a new peak may lie inside. Whether it may follows from three instants: the resultants
at its start and its end are known, and half-way the joint law alone is evaluated on the quintic. Forces along the
joints cannot be had that cheaply; how far they stray from their ends follows from how far N and M do, and in a smooth
step one look half-way tells more. Where a peak may lie, the step is evaluated at the ends of its pieces. A polynomial
through all of them tells the extremes of what is smooth within the step; where it is not sure of one, parabolas lead
there: until they promise no more than a part of the tolerance.

Rotations count as small in what is estimated, never in what is kept. Where joints can slide nothing is estimated: all
steps are looked into.
"""

from ..formulations.base import base_motion, base_turn
from ..formulations.either import is_exact, joint_opening, rotation
from ..formulations.outputs import show
from ..formulations.slips import evaluate_anew, phase_size
from ..jit import kernel, leaf
from ..joint.law import resultants
from ..joint.sliding import can_slide
from ..layout import COUNTS_FROM, OK, OUTPUTS, PEAKS, PIECES, ROW
from .bracket import bracket, narrowed, trial_within
from .interpolation import interpolate_phase, refine

_peaks, _row = PEAKS.over, ROW.over
_PER_N, _BESIDE = PEAKS.per_n, PEAKS.beside
_OF_JOINTS = OUTPUTS.per_n
_CONTACT = OUTPUTS.fields.index("contact")
_FRICTION = (PEAKS.per_n - 1, PEAKS.beside)  # where it begins

TURNS, RISES = 1, 2  # within the step; beyond its end
MARGIN = 0.1  # of the bend of a parabola through three values: how far beyond it the curve may go
NEAR = 2.6  # of the bend: a rise that turns within the step, 2 on a parabola; 2.4 on a sine over 1.5 rad
PROMISE = 0.1  # of the tolerance: a peak that is expected to rise by less has been found
QUIET = 1e-3  # of the largest peak in the column: tolerances of a smaller one are parts of this
SURE = 3.0  # of that: what the highest term of the polynomial may come to where it is believed
# Of the bend of N times the inclination, and of the bend of M over the height of the centroid: what T may bend by. One
# slender block upon its joint has less than 0.75 of both
NORMAL_STRAY = 1.0
MOMENT_STRAY = 1.0
BASE_STRAY = 2e-3  # of T: what the curvature of the base acceleration may add to these
STEEP = 6.0  # times that: ends that differ by more have no extreme between them
MOST_TRIALS = 8
CLOSE = 1e-4  # of a step: no two evaluations are closer


# --- where a peak may lie


@leaf
def _beyond(start, middle, end, peak):
    """How |f| passes a peak within a step, by f(0), f(1/2) and f(1): 0, or a sum of TURNS and RISES."""
    bend = 2.0 * middle - start - end
    if max(abs(start), abs(middle), abs(end)) + (0.5 + MARGIN) * abs(bend) <= peak:
        return 0
    found = RISES if abs(end) > peak else 0
    if abs(start) > peak and abs(start) >= abs(end):
        return found | TURNS
    sign = -1.0 if middle < 0.0 else 1.0
    bend, rise = sign * bend, end - start
    beyond = peak - sign * middle - MARGIN * bend
    if bend > 0.0 and abs(rise) < NEAR * bend and rise * rise > 8.0 * bend * beyond:
        return found | TURNS
    return found


@leaf
def _beyond_with(start, end, stray, peak):
    """The same of what is known at both ends only and strays by so much from the straight line between them."""
    here, there = abs(start), abs(end)
    if max(here, there) + stray <= peak:
        return 0
    found = RISES if there > peak else 0
    return found | TURNS if abs(end - start) < STEEP * stray or (here > peak and here >= there) else found


@leaf
def _edge_pressure(blocks, i, opening, slope, opening_rate, slope_rate):
    """Pressure at the edge of joint i that is pressed most, Pa; there may be none."""
    damping = blocks.damping[i]
    mean, gradient = opening + damping * opening_rate, slope + damping * slope_rate
    edge = blocks.right[i] if gradient > 0.0 else blocks.left[i]
    return max(0.0, blocks.stiffness[i] * (gradient * edge - mean))


@kernel
def _resultants(blocks, hold, i, opening, slope, opening_rate, slope_rate):
    """As the joint law has it, compiled once for both that ask here."""
    return resultants(blocks, hold, i, opening, slope, opening_rate, slope_rate)


@leaf
def _curved(phi, normal, along):
    """What is neglected of S where the sine of the inclination is phi and its cosine 1."""
    return phi * phi * (0.2 * abs(phi) * normal + 0.5 * along)


@kernel
def _go_half_way(work, h):
    """Coordinates and rates in the middle of the step, on the quintic: left in work.between."""
    size = 2 * work.n
    start, end, middle = work.start.row, work.end.row, work.between.row
    per_step = 1.875 / h
    for i in range(size):
        v0, a0, v1, a1 = start[size + i], start[2 * size + i], end[size + i], end[2 * size + i]
        middle[i] = 0.5 * (start[i] + end[i]) + h * (0.15625 * (v0 - v1) + h * (0.015625 * (a0 + a1)))
        middle[size + i] = per_step * (end[i] - start[i]) - 0.4375 * (v0 + v1) + h * (0.03125 * (a1 - a0))


@kernel
def _pressures_beyond(column, h, turn_middle, turn_end):
    """How what follows from positions and rates passes its peaks; and how T may stray from a straight line, N.

    Notes the end of the step, but for T, and N in the middle; turn: rotation of the base.
    """
    model, work = column.model, column.work
    n, blocks, joints, notes = model.n, model.blocks, work.joints, work.notes
    middle, end = work.between, work.end
    space, allowances = _peaks(column.state.peaks, n), _peaks(work.allowed, n)
    peaks, allowed = space.joints, allowances.joints
    exact = is_exact(model)
    _go_half_way(work, h)
    found, stray = 0, 0.0
    rise_m, turn_m, spin_m = 0.0, 0.0, 0.0  # of what is below, in the middle of the step
    rise_e, turn_e, spin_e = 0.0, 0.0, 0.0  # and at its end
    for i in range(n - 1, -1, -1):
        turned_m, spun_m = rotation(model, middle.theta, i), rotation(model, middle.theta_rate, i)
        opening, opening_rate = joint_opening(model, middle.opening, i), joint_opening(model, middle.opening_rate, i)
        slope, slope_rate = turned_m - turn_m, spun_m - spin_m
        normal, moment, length = _resultants(blocks, work.hold, i, opening, slope, opening_rate, slope_rate)
        edge = _edge_pressure(blocks, i, opening, slope, opening_rate, slope_rate)
        theta, phi = turned_m + turn_middle, 0.5 * (turned_m + turn_m) + turn_middle
        dip, uz = -0.5 * theta * theta, -middle.opening[i]
        if exact:
            uz = rise_m + opening + blocks.centroid[i] * dip
        rise_m += opening + blocks.height[i] * dip
        turn_m, spin_m = turned_m, spun_m

        turned_e, spun_e = rotation(model, end.theta, i), rotation(model, end.theta_rate, i)
        opening, opening_rate = joint_opening(model, end.opening, i), joint_opening(model, end.opening_rate, i)
        edge_e = _edge_pressure(blocks, i, opening, turned_e - turn_e, opening_rate, spun_e - spin_e)
        theta_e = turned_e + turn_end
        dip, uz_e = -0.5 * theta_e * theta_e, -end.opening[i]
        if exact:
            uz_e = rise_e + opening + blocks.centroid[i] * dip
        rise_e += opening + blocks.height[i] * dip
        notes.phi_end[i] = 0.5 * (turned_e + turn_e) + turn_end
        turn_e, spin_e = turned_e, spun_e

        normal_e, moment_e, length_e = joints.normal[i], joints.moment[i], joints.length[i]
        whole = blocks.width[i]
        found |= _beyond(notes.N[i], normal, normal_e, peaks.N[i] + allowed.N[i])
        found |= _beyond(notes.M[i], moment, moment_e, peaks.M[i] + allowed.M[i])
        found |= _beyond(notes.edge[i], edge, edge_e, peaks.sigma_max[i] + allowed.sigma_max[i])
        lost = whole * (peaks.contact[i] + allowed.contact[i])
        found |= _beyond(whole - notes.length[i], whole - length, whole - length_e, lost)
        found |= _beyond(notes.uz[i], uz, uz_e, peaks.uz[i] + allowed.uz[i])
        found |= _beyond(notes.theta[i], theta, theta_e, peaks.theta[i] + allowed.theta[i])
        if i == n - 1:
            most = space.base.My + allowances.base.My - 0.5 * abs(opening * joints.tangential[i])
            found |= _beyond(notes.M[i], moment, moment_e, most)
        stray += NORMAL_STRAY * abs(notes.N[i] - 2.0 * normal + normal_e) * abs(phi)
        stray += MOMENT_STRAY * abs(notes.M[i] - 2.0 * moment + moment_e) / blocks.centroid[i]
        notes.N_middle[i] = normal
        notes.M[i], notes.edge[i], notes.length[i] = moment_e, edge_e, length_e
        notes.uz[i], notes.theta[i] = uz_e, theta_e
    return found, stray


@kernel
def _forces_beyond(column, stray):
    """How what follows from the forces along the joints passes its peaks.

    Notes the end of the step, and leaves what the forces were at its start in the first row of work.seen.
    """
    model, work = column.model, column.work
    n, notes, joints = model.n, work.notes, work.joints
    peaks, allowed = _peaks(column.state.peaks, n), _peaks(work.allowed, n)
    begin = _peaks(work.seen, n)
    found = 0
    for i in range(n):
        normal, normal_m, normal_e = notes.N[i], notes.N_middle[i], joints.normal[i]
        along, along_e = notes.T[i], joints.tangential[i]
        phi, phi_e = notes.phi[i], notes.phi_end[i]
        across, across_e = normal * phi + along, normal_e * phi_e + along_e
        most, bend = max(abs(along), abs(along_e)) + stray, abs(normal - 2.0 * normal_m + normal_e)
        neglected = _curved(phi_e, max(normal, normal_m, normal_e), most)
        strays = stray + BASE_STRAY * most
        found |= _beyond_with(along, along_e, strays, peaks.joints.T[i] + allowed.joints.T[i])
        bound = peaks.joints.S[i] + allowed.joints.S[i] - neglected
        found |= _beyond_with(across, across_e, strays + abs(phi_e) * bend, bound)
        counts, least = notes.counts[i], min(normal, normal_m, normal_e)
        begin.joints.N[i], begin.joints.T[i], begin.joints.S[i] = normal, -along, -across
        begin.friction[i] = abs(along) / normal if normal > counts else 0.0
        asked = peaks.friction[i] + allowed.friction[i]
        if max(normal, normal_m, normal_e) > counts and most > asked * max(least, counts):
            here, there = abs(along) * normal_e, abs(along_e) * normal  # over both N
            turns = normal_m < min(normal, normal_e) or least < counts or abs(along_e - along) < STEEP * strays
            found |= TURNS if turns or here >= there else RISES
        if i == n - 1:
            lifted, lifted_e = normal - along * phi, normal_e - along_e * phi_e
            lifted_m = normal_m - 0.5 * (along * phi + along_e * phi_e)
            found |= _beyond(lifted, lifted_m, lifted_e, peaks.base.Fz + allowed.base.Fz - abs(phi_e) * stray)
            begin.base.Fx, begin.base.Fz = -across, -lifted
        notes.N[i], notes.T[i], notes.phi[i] = normal_e, along_e, phi_e
    return found


@kernel
def begin_extremes(column, motion, evaluated):
    """Note the start of a step that does not begin where the last one has ended, and raise the peaks by it.

    evaluated: work.joints belongs to the start.
    """
    model, work = column.model, column.work
    n, blocks, start, joints, notes = model.n, model.blocks, work.start, work.joints, work.notes
    peaks = _peaks(column.state.peaks, n)
    work.watched.rises = work.watched.seen = 0.0
    rise, turn, spin = 0.0, 0.0, 0.0
    for i in range(n - 1, -1, -1):
        turned, spun = rotation(model, start.theta, i), rotation(model, start.theta_rate, i)
        opening, opening_rate = joint_opening(model, start.opening, i), joint_opening(model, start.opening_rate, i)
        slope, slope_rate = turned - turn, spun - spin
        normal, moment, length = joints.normal[i], joints.moment[i], joints.length[i]
        if not evaluated:
            normal, moment, length = _resultants(blocks, work.hold, i, opening, slope, opening_rate, slope_rate)
        notes.N[i], notes.M[i], notes.length[i] = normal, moment, length
        notes.T[i] = joints.tangential[i] if evaluated else 0.0  # what it is, the end of the last step has told
        notes.edge[i] = _edge_pressure(blocks, i, opening, slope, opening_rate, slope_rate)
        notes.theta[i] = turned + motion.theta
        notes.phi[i] = 0.5 * (turned + turn) + motion.theta
        dip = -0.5 * notes.theta[i] * notes.theta[i]
        notes.uz[i] = rise + opening + blocks.centroid[i] * dip if is_exact(model) else -start.opening[i]
        rise += opening + blocks.height[i] * dip
        turn, spin = turned, spun
    carried = 0.0
    new = peaks.joints.N[n - 1] == 0.0 or (evaluated and can_slide(model))  # the first of all, or not noted
    for i in range(n):
        carried += model.settings.gravity * blocks.mass[i]
        notes.counts[i] = COUNTS_FROM * carried
        if evaluated:  # what follows the base at once
            normal, along, phi = notes.N[i], notes.T[i], notes.phi[i]
            across = abs(normal * phi + along) + _curved(phi, normal, abs(along))
            new = new or abs(along) > peaks.joints.T[i] or across > peaks.joints.S[i]
            new = new or (normal > notes.counts[i] and abs(along) > peaks.friction[i] * normal)
    if new:
        _take_start(column, motion)
    _allow(column)


@kernel
def end_extremes(column, motion):
    """Raise the peaks by what still rises where the last step has ended, upon a base that moves like that there."""
    if column.work.watched.rises != 0.0:
        column.work.watched.rises = 0.0
        _take_start(column, motion)


# --- looking into a step


@kernel
def _allow(column):
    """Set by how much each quantity may pass its peak unnoticed."""
    n, peaks, allowed = column.model.n, column.state.peaks, column.work.allowed
    part = PROMISE * column.model.settings.tolerance
    for field in range(_PER_N):
        first = field * n if field < _OF_JOINTS else field * n + _BESIDE
        largest = 0.0
        for j in range(first, first + n):
            largest = max(largest, peaks[j])
        for j in range(first, first + n):
            allowed[j] = part * max(peaks[j], QUIET * largest)
    for j in range(_OF_JOINTS * n, _OF_JOINTS * n + _BESIDE):
        allowed[j] = part * peaks[j]


@kernel
def _take_start(column, motion):
    work = column.work
    for i in range(phase_size(work)):
        work.between.row[i] = work.start.row[i]
    _take(column, motion, work.seen)


@kernel
def _take(column, motion, seen):
    """Fill `seen` with all that is visible of work.between but u_x, on such a base, and raise the peaks by it."""
    if evaluate_anew(column, column.work.between, motion) == OK:
        show(column, column.work.between, motion, _row(seen, column.model.n))
        _raise_peaks(column, seen)


@kernel
def _raise_peaks(column, seen):
    """Raise the peaks by an output row, which becomes one of PEAKS."""
    work, peaks = column.work, column.state.peaks
    n = column.model.n
    visible = _peaks(seen, n)
    for i in range(n):
        normal = visible.joints.N[i]
        visible.friction[i] = abs(visible.joints.T[i]) / normal if normal > work.notes.counts[i] else 0.0
        visible.joints.contact[i] = 1.0 - visible.joints.contact[i]
    for j in range(n, _PER_N * n + _BESIDE):  # u_x upon a base that turns counts relative to it
        peaks[j] = max(peaks[j], abs(seen[j]))


@kernel
def _look(column, t, h, s, seen):
    """`_take` at fraction s of the step from t to t + h."""
    work = column.work
    interpolate_phase(work, h, s)
    for i in range(int(work.slips.count)):  # the joints slide as they did in the step
        work.between.sliding[i] = work.end.sliding[i]
    _take(column, base_motion(column.base, column.samples, t + s * h), seen)


@kernel
def _see_end(column, t, h):
    """Fill the last row of work.seen at the end of the step; work.joints holds its resultants.

    Returns the first piece whose beginning has not been seen: as the end of the step before.
    """
    work, n = column.work, column.model.n
    size = _PER_N * n + _BESIDE
    end = work.seen[PIECES * size :]
    begins_seen = work.watched.seen != 0.0
    if begins_seen:
        for j in range(size):
            work.seen[j] = end[j]
    show(column, work.end, base_motion(column.base, column.samples, t + h), _row(end, n))
    _raise_peaks(column, end)
    work.watched.seen = 1.0
    refine(column, t, h)
    return 1 if begins_seen else 0


@kernel
def _look_within(column, t, h, certain):
    """Fill work.seen at the ends of the pieces of the step, and say whether something may have its peak within.

    Unless that is certain, only forces along the joints may, in a smooth step: looked at half-way, they mostly do not.
    """
    seen, n = column.work.seen, column.model.n
    size = _PER_N * n + _BESIDE
    first = _see_end(column, t, h)
    middle = PIECES // 2
    _look(column, t, h, middle / PIECES, seen[middle * size :])
    if not certain and not _forces_turn(column, seen, seen[middle * size :], seen[PIECES * size :]):
        return False
    for k in range(first, PIECES):
        if k != middle:
            _look(column, t, h, k / PIECES, seen[k * size :])
    return True


@kernel
def _forces_turn(column, begin, middle, end):
    """Whether a force along a joint may turn beyond its peak in a step, by rows at its start, half-way and its end."""
    n, counts = column.model.n, column.work.notes.counts
    begin, middle, end = _peaks(begin, n), _peaks(middle, n), _peaks(end, n)
    peaks, allowed = _peaks(column.state.peaks, n), _peaks(column.work.allowed, n)
    T, S, friction = peaks.joints.T, peaks.joints.S, peaks.friction
    T_0, T_1, T_2 = begin.joints.T, middle.joints.T, end.joints.T
    N_0, N_1, N_2 = begin.joints.N, middle.joints.N, end.joints.N
    found = 0
    for i in range(n):
        found |= _beyond(T_0[i], T_1[i], T_2[i], T[i] + allowed.joints.T[i])
        found |= _beyond(begin.joints.S[i], middle.joints.S[i], end.joints.S[i], S[i] + allowed.joints.S[i])
        asked = friction[i] + allowed.friction[i]
        found |= _beyond(begin.friction[i], middle.friction[i], end.friction[i], asked)
        begins_to_count = min(N_0[i], N_1[i], N_2[i]) < counts[i] < max(N_0[i], N_1[i], N_2[i])
        if begins_to_count and max(abs(T_0[i]), abs(T_1[i]), abs(T_2[i])) > asked * counts[i]:
            found |= TURNS
    found |= _beyond(begin.base.Fx, middle.base.Fx, end.base.Fx, peaks.base.Fx + allowed.base.Fx)
    found |= _beyond(begin.base.Fz, middle.base.Fz, end.base.Fz, peaks.base.Fz + allowed.base.Fz)
    return found & TURNS != 0


@leaf
def _vertex(a, f_a, b, f_b, c, f_c):
    """(place, height) of the top of the parabola through three points; the best of them where it has none inside."""
    left, right = (f_b - f_a) / (b - a), (f_c - f_b) / (c - b)
    bend = (left - right) / (c - a)
    if bend > 0.0:
        slope = left - bend * (b - a)  # at b
        place = b + 0.5 * slope / bend
        if a < place < c:
            return place, f_b + 0.25 * slope * slope / bend
    return b, max(f_a, f_b, f_c)


@leaf
def _mark_tops(seen, peaks, allowed, first, size, marks):
    """Fill `marks`, positive where a parabola through three neighbours of the values in a step may turn beyond a peak.

    Inside, it is above the largest of them by a quarter of their range at most. One loop without a branch: a processor
    takes eight quantities at a time.
    """
    for j in range(first, size):
        f_0, f_1, f_2, f_3 = seen[j], seen[size + j], seen[2 * size + j], seen[3 * size + j]
        f_4 = seen[4 * size + j]
        a, b, c, d = f_1 - f_0, f_2 - f_1, f_3 - f_2, f_4 - f_3
        # slopes at the ends of a parabola: three times what is near less what is far
        turns = min((3.0 * a - b) * (3.0 * b - a), (3.0 * b - c) * (3.0 * c - b), (3.0 * c - d) * (3.0 * d - c))
        least, most = min(f_0, f_1, f_2, f_3, f_4), max(f_0, f_1, f_2, f_3, f_4)
        beyond = max(most, -least) + 0.25 * (most - least) - (peaks[j] + allowed[j])
        marks[j] = beyond if turns < 0.0 else -1.0


@leaf
def _top(f_0, f_1, f_2, f_3, f_4, near):
    """(place, height, its highest term there) of the top next to `near` of the quartic through values at 0, 1 ... 4."""
    rise, fall = f_3 - f_1, f_4 - f_0
    sides, ends = f_1 + f_3, f_0 + f_4
    c1, c2 = (8.0 * rise - fall) / 12.0, (16.0 * sides - ends - 30.0 * f_2) / 24.0
    c3, c4 = (fall - 2.0 * rise) / 12.0, (ends - 4.0 * sides + 6.0 * f_2) / 24.0
    x = near - 2.0
    for _ in range(3):
        bend = 2.0 * c2 + x * (6.0 * c3 + x * 12.0 * c4)
        if not bend < 0.0:
            break
        x = min(2.0, max(-2.0, x - (c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * 4.0 * c4))) / bend))
    height = f_2 + x * (c1 + x * (c2 + x * (c3 + x * c4)))
    far = -2.0 if x > 0.0 else 2.0  # the end that a cubic does without
    return x + 2.0, height, c4 * (x + far) * (x + 1.0) * x * (x - 1.0)


@kernel
def _climb(column, t, h, j, a, f_a, b, f_b, c, f_c, sign, s, height):
    """Go up to the extreme of quantity j between the fractions a and c of the step, expected at s, so high."""
    n, work, peaks = column.model.n, column.work, column.state.peaks
    trial = work.seen[(PIECES + 1) * (_PER_N * n + _BESIDE) :]
    for _ in range(MOST_TRIALS):
        if not height > peaks[j] + work.allowed[j]:
            return
        if abs(s - b) < CLOSE:
            s = b + CLOSE if c - b > b - a else b - CLOSE
        if not a < s < c:
            return
        _look(column, t, h, s, trial)
        f_s = sign * trial[j]
        if s < b:
            if f_s >= f_b:
                b, f_b, c, f_c = s, f_s, b, f_b
            else:
                a, f_a = s, f_s
        elif f_s >= f_b:
            a, f_a, b, f_b = b, f_b, s, f_s
        else:
            c, f_c = s, f_s
        s, height = _vertex(a, f_a, b, f_b, c, f_c)


@kernel
def _find_top(column, t, h, j, size):
    """Raise the peak of quantity j by its highest top within the step."""
    n, seen, peaks, allowed = column.model.n, column.work.seen, column.state.peaks, column.work.allowed[j]
    best, place, at, way = 0.0, 0.0, 0, 1.0
    for k in range(1, PIECES):
        sign = -1.0 if seen[k * size + j] < 0.0 else 1.0
        f_a, f_b, f_c = sign * seen[(k - 1) * size + j], sign * seen[k * size + j], sign * seen[(k + 1) * size + j]
        x, height = _vertex(k - 1.0, f_a, k, f_b, k + 1.0, f_c)
        if height > best:
            best, place, at, way = height, x, k, sign
    if not best > peaks[j] + allowed:
        return
    f_0, f_1, f_2 = way * seen[j], way * seen[size + j], way * seen[2 * size + j]
    f = (f_0, f_1, f_2, way * seen[3 * size + j], way * seen[4 * size + j])
    x, height, term = _top(f[0], f[1], f[2], f[3], f[4], place)
    if not abs(x - at) < 1.0:
        x, height = place, best
    elif abs(term) <= SURE * allowed:
        peaks[j] = max(peaks[j], min(height, 1.0) if j // n == _CONTACT else height)
        return
    a, b, c = (at - 1) / PIECES, at / PIECES, (at + 1) / PIECES
    _climb(column, t, h, j, a, f[at - 1], b, f[at], c, f[at + 1], way, x / PIECES, height)


@kernel
def _cross(column, t, h, i, weight, lo, f_lo, hi, f_hi):
    """Look at the moment at which N of joint i passes `weight` in a piece of the step, where T / N begins to count."""
    n, work = column.model.n, column.work
    trial = work.seen[(PIECES + 1) * (_PER_N * n + _BESIDE) :]
    enough = column.model.settings.tolerance * weight
    way = 1.0 if f_lo > 0.0 else -1.0
    known = bracket(lo, hi, way * f_lo, way * f_hi)
    for _ in range(2 * MOST_TRIALS):
        s = trial_within(known)
        _look(column, t, h, s, trial)
        f_s = _peaks(trial, n).joints.N[i] - weight
        if 0.0 <= f_s <= enough:
            return
        known = narrowed(known, s, way * f_s)


@kernel
def _find_tops(column, t, h):
    """Raise the peaks by what lies between the values in work.seen."""
    model, work, peaks = column.model, column.work, column.state.peaks
    n, seen = model.n, work.seen
    size = _PER_N * n + _BESIDE
    first = _FRICTION[0] * n + _FRICTION[1]
    marks = seen[(PIECES + 2) * size :]
    _mark_tops(seen, peaks, work.allowed, n, size, marks)
    for j in range(n, size):
        if marks[j] > 0.0:
            _find_top(column, t, h, j, size)
    for i in range(n):
        weight = work.notes.counts[i]
        for k in range(PIECES):
            here, there = _peaks(seen[k * size :], n).joints, _peaks(seen[(k + 1) * size :], n).joints
            f_lo, f_hi = here.N[i] - weight, there.N[i] - weight
            along = max(abs(here.T[i]), abs(there.T[i]))
            if f_lo * f_hi < 0.0 and along > (peaks[first + i] + work.allowed[first + i]) * weight:
                _cross(column, t, h, i, weight, k / PIECES, f_lo, (k + 1) / PIECES, f_hi)


@kernel
def track_extremes(column, t, h):
    """Raise the peaks by the step just made from t to t + h; work.joints holds the resultants of its end."""
    base, watched = column.base, column.work.watched
    watched.rises = 0.0
    found = TURNS
    if not can_slide(column.model):  # the estimates know nothing of slips
        found, stray = _pressures_beyond(column, h, base_turn(base, t + 0.5 * h), base_turn(base, t + h))
        forces = _forces_beyond(column, stray)
        watched.rises = 1.0 if (found | forces) & RISES else 0.0
        if not (found | forces) & TURNS:
            watched.seen = 0.0
            return
    if _look_within(column, t, h, found & TURNS != 0 or watched.smooth == 0.0):
        _find_tops(column, t, h)
    _allow(column)
