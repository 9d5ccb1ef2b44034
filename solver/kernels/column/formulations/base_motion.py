"""The motion of the base: inputs that are smooth within a call, and samples of a record beside them.

The samples are joined by straight lines, or each is held until the next. Before the first and after the last the record
is silent, and so is the harmonic part of the inputs where there is a record.
"""

import math

from ...engine.samples import SAMPLE_SLACK, is_silent, segment_from
from ...layout.spaces import MOST_INPUT
from ...numba_ext.jit import kernel, leaf
from .exact import Motion
from .loads import push_ports

SOON = 0.1  # rad of the harmonic part, within which the polynomials are exact to rounding


@leaf
def record_line(samples, k, t):
    """Return acceleration and slope of the record at time t on segment k: (ax, jx, az, jz), m/s2 and m/s3."""
    if is_silent(samples, k):
        return 0.0, 0.0, 0.0, 0.0
    ax, az = samples.scale * samples.ax[k], samples.scale * samples.az[k]
    if samples.held:
        return ax, 0.0, az, 0.0
    # the straight line to the next sample
    begin = samples.times[k]
    per_width = 1.0 / (samples.times[k + 1] - begin)
    jx = (samples.scale * samples.ax[k + 1] - ax) * per_width
    jz = (samples.scale * samples.az[k + 1] - az) * per_width
    return ax + jx * (t - begin), jx, az + jz * (t - begin), jz


@kernel
def enter(base, samples, t):
    """Let the base follow, from time t on, the segment of the record that begins there or before."""
    if samples.size == 0:
        return
    k = segment_from(samples, t)
    # the segment, its ends and its line
    base.segment = k
    base.piece_begin = samples.times[k] if k >= 0 else samples.times[0]
    base.piece_end = samples.times[k + 1] if k + 1 < samples.size else math.inf
    base.piece_ax, base.piece_jx, base.piece_az, base.piece_jz = record_line(samples, k, base.piece_begin)


@leaf
def ends_soon(base, t):
    """Return True if the present segment of the record ends at time t, to rounding, or has ended."""
    return t >= base.piece_end - SAMPLE_SLACK * (base.piece_end - base.piece_begin)


@leaf
def base_line(base, samples, t):
    """Return the part of the base acceleration linear in time from t on: (ax, jx, az, jz), m/s2 and m/s3."""
    past = t - base.t0
    ax, az = base.ax + base.jx * past, base.az + base.jz * past
    if samples.size == 0:
        return ax, base.jx, az, base.jz
    # the line of the record beside that of the inputs
    within = t - base.piece_begin
    ax += base.piece_ax + base.piece_jx * within
    az += base.piece_az + base.piece_jz * within
    return ax, base.jx + base.piece_jx, az, base.jz + base.piece_jz


@leaf
def wave_amplitude(base, samples):
    """Return the amplitude (m/s2) of the harmonic part of ax from the present segment on."""
    if samples.size > 0 and is_silent(samples, int(base.segment)):
        return 0.0
    return base.wave_amplitude


@leaf
def anchor_wave(base, t):
    """Compute the sine of the harmonic part at time t, unless that was done shortly before."""
    if base.wave_amplitude != 0.0 and not abs(base.wave_omega * (t - base.anchor)) <= 0.5 * SOON:
        angle = base.wave_omega * t + base.wave_phase
        base.anchor = t
        base.anchor_sine = math.sin(angle)
        base.anchor_cosine = math.cos(angle)


@leaf
def wave(base, t):
    """Return (sine, cosine) of wave_omega t + wave_phase; near the anchor by the addition theorem, which is faster."""
    x = base.wave_omega * (t - base.anchor)
    if not abs(x) <= SOON:
        angle = base.wave_omega * t + base.wave_phase
        return math.sin(angle), math.cos(angle)
    # Taylor polynomials of sin x and cos x - 1
    y = x * x
    sine = x * (1.0 + y * (-1.0 / 6.0 + y * (1.0 / 120.0 + y * (-1.0 / 5040.0 + y * (1.0 / 362880.0)))))
    dip = y * (-0.5 + y * (1.0 / 24.0 + y * (-1.0 / 720.0 + y * (1.0 / 40320.0))))  # cos x - 1
    begun, across = base.anchor_sine, base.anchor_cosine
    return begun + (begun * dip + across * sine), across + (across * dip - begun * sine)


@leaf
def base_motion(column, t):
    """Return the motion of the base at time t, within a step that began on the present segment or soon after."""
    sine = wave(column.base, t)[0] if column.base.wave_amplitude != 0.0 else 0.0
    return base_motion_beside(column, t, sine)


@leaf
def base_motion_beside(column, t, sine):
    """Return `base_motion` from the value of `wave` at that time (sine)."""
    base, samples = column.base, column.samples
    past = t - base.t0
    ax, _, az, _ = base_line(base, samples, t)
    if samples.size > 0 and t > base.piece_end and not samples.held:
        k = int(base.segment)  # a step crosses kinks of the straight lines, never a jump
        while 0 <= k < samples.size - 2 and t > samples.times[k + 1]:
            k += 1
        r_ax, _, r_az, _ = record_line(samples, k, t)
        ax, az = base.ax + base.jx * past + r_ax, base.az + base.jz * past + r_az
    # the harmonic part
    amplitude = wave_amplitude(base, samples)
    if amplitude != 0.0:
        ax += amplitude * sine
    turn, spin = base_turn(base, t), base_spin(base, t)
    return Motion(ax, az, turn, spin, base.alpha + past * base.jalpha)


@leaf
def moved_and_loaded(column, t):
    """Return `base_motion`, and leave the loads at that time in the work of the column until the next call."""
    if column.work.loading.general != 0.0:
        push_ports(column, t)
    return base_motion(column, t)


@leaf
def base_turn(base, t):
    """Return the rotation of the base at time t (rad clockwise)."""
    past = t - base.t0
    return base.theta + past * (base.omega + (0.5 * past * base.alpha + past * past * (base.jalpha / 6.0)))


@leaf
def base_spin(base, t):
    """Return the rate of rotation of the base at time t (rad/s)."""
    past = t - base.t0
    return base.omega + past * (base.alpha + 0.5 * past * base.jalpha)


@leaf
def base_rotates(base):
    """Return True if the base is turned or turning."""
    return base.theta != 0.0 or base.omega != 0.0 or base.alpha != 0.0 or base.jalpha != 0.0


@leaf
def inputs_are_bounded(base, t, h):
    """Return True if every input of the base is at most MOST_INPUT, in its unit, at time t and at time t + h."""
    bounded = abs(base.wave_amplitude) <= MOST_INPUT and abs(base.alpha) <= MOST_INPUT
    # at both ends of the step
    for k in range(2):
        end = t + k * h
        ax, az = base.ax + base.jx * (end - base.t0), base.az + base.jz * (end - base.t0)
        bounded = bounded and abs(ax) <= MOST_INPUT and abs(az) <= MOST_INPUT
        bounded = bounded and abs(base_turn(base, end)) <= MOST_INPUT and abs(base_spin(base, end)) <= MOST_INPUT
    return bounded


@leaf
def to_next_sample(base, samples, t, left):
    """Return the time (s) from t to the end of the present segment; `left` if it does not end within `left` s."""
    k = int(base.segment) + 1
    if samples.size == 0 or k >= samples.size:
        return left
    ahead = base.piece_end - t
    # a sample at the end of a call, to rounding, must not leave a tiny step
    return ahead if ahead < left - SAMPLE_SLACK * (base.piece_end - base.piece_begin) else left


@kernel
def smooth_reach(base, samples, t, step, left, roughest):
    """Return the time (s) from t over which a step may go: at most `left`, not across a jump or kinks that matter.

    A step of h s across a kink of the straight lines, where their slope changes by j, has an error of about j h^2 in a
    velocity.

    Parameters
    ----------
    base, samples
        The base and its record.
    t : float
        Time, s.
    step, left : float
        Step that is asked for, and time until the end of the call, s.
    roughest : float
        Limit of that error for all kinks together, m/s, within twice the step.
    """
    reach = to_next_sample(base, samples, t, left)
    if samples.held:
        return reach
    k = int(base.segment)
    kinks = 0.0
    while reach < min(2.0 * step, left):  # a kink just beyond a step must not shorten it either
        k += 1
        if is_silent(samples, k) or is_silent(samples, k - 1):  # the record begins or ends: a jump
            return reach
        # change of the slope at the kink
        _, before_x, _, before_z = record_line(samples, k - 1, t)
        _, jx, _, jz = record_line(samples, k, t)
        kinks += abs(jx - before_x) + abs(jz - before_z)
        following = samples.times[k + 1] - t
        length = min(step, left, following)
        if kinks * length * length > roughest:
            return reach
        reach = min(left, following)
    return left
