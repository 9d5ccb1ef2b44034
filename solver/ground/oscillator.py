"""The response of linear oscillators to base accelerations linear between samples: exact, but for rounding.

The closed form of Nigam and Jennings (1969), Bull. Seism. Soc. Am. 59 (2), 909-922.
"""

from __future__ import annotations

import numpy as np

from .records.record import FloatArray


def response(
    steps: FloatArray, before: FloatArray, after: FloatArray, omega: FloatArray, damping: float
) -> tuple[FloatArray, FloatArray]:
    """Compute the motion of oscillators relative to the base, from rest.

    Parameters
    ----------
    steps : ndarray of shape (m,)
        The durations of the line segments (s).
    before, after : ndarray of shape (m,)
        The base acceleration at both ends of each segment (m/s2).
    omega : ndarray of shape (p,)
        The undamped angular frequencies (rad/s).
    damping : float
        The damping ratio, at least 0 and less than 1.

    Returns
    -------
    u : ndarray of shape (m + 1, p)
        The relative displacement (m).
    v : ndarray of shape (m + 1, p)
        The relative velocity (m/s).
    """
    lengths, which = np.unique(steps, return_inverse=True)
    unit = np.eye(4)
    # effect of (u, v, acceleration before, after) = 1 on (u, v) in one step: four pairs of (lengths, p)
    maps = [_one_step(lengths[:, None], omega, damping, *unit[k]) for k in range(4)]
    (uu, vu), (uv, vv), (ub, vb), (ua, va) = maps
    push_u = ub[which] * before[:, None] + ua[which] * after[:, None]
    push_v = vb[which] * before[:, None] + va[which] * after[:, None]
    if len(omega) == 1:
        maps_alone = np.stack((uu, uv, vu, vv))[:, which, 0].tolist()
        return _alone(maps_alone, push_u[:, 0].tolist(), push_v[:, 0].tolist())
    u, v = np.zeros((len(steps) + 1, len(omega))), np.zeros((len(steps) + 1, len(omega)))
    for k, i in enumerate(which):
        u[k + 1] = uu[i] * u[k] + uv[i] * v[k] + push_u[k]
        v[k + 1] = vu[i] * u[k] + vv[i] * v[k] + push_v[k]
    return u, v


def _alone(maps: list[list[float]], push_u: list[float], push_v: list[float]) -> tuple[FloatArray, FloatArray]:
    """Compute `response` of one oscillator with Python floats: equal bits in a tenth of the time."""
    uu, uv, vu, vv = maps
    u, v = [0.0], [0.0]
    for k in range(len(push_u)):
        u.append(uu[k] * u[k] + uv[k] * v[k] + push_u[k])
        v.append(vu[k] * u[k] + vv[k] * v[k] + push_v[k])
    return np.array(u)[:, None], np.array(v)[:, None]


def free_peak(u: FloatArray, v: FloatArray, omega: FloatArray, damping: float) -> FloatArray:
    """Return the largest |u| of the free vibration that begins at (u, v).

    Parameters
    ----------
    u, v : ndarray of shape (p,)
        The initial displacement (m) and velocity (m/s).
    omega : ndarray of shape (p,)
        The undamped angular frequencies (rad/s).
    damping : float
        The damping ratio.

    Returns
    -------
    ndarray of shape (p,)
    """
    damped = omega * np.sqrt(1.0 - damping**2)
    b = (v + damping * omega * u) / damped
    t = np.mod(np.arctan2(v, damped * u + damping * omega * b), np.pi) / damped  # the first extremum
    extremum = np.exp(-damping * omega * t) * (u * np.cos(damped * t) + b * np.sin(damped * t))
    return np.maximum(np.abs(u), np.abs(extremum))


def peaks(steps: FloatArray, values: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
    """Return the largest absolute values of histories, also between their samples.

    Between two samples a history is the cubic of its values and slopes at both ends, which is exact for the velocity of
    the base, of fourth order for a displacement.

    Parameters
    ----------
    steps : ndarray of shape (m,)
        The durations of the intervals (s).
    values : ndarray of shape (m + 1, p)
        The histories.
    before, after : ndarray of shape (m, p)
        The slopes at both ends of each interval.

    Returns
    -------
    ndarray of shape (p,)
    """
    largest: FloatArray = np.max(np.abs(values), axis=0)
    rows, columns = np.divmod(np.flatnonzero(before * after < 0.0), before.shape[1])
    h = steps[rows]
    u0, u1 = values[rows, columns], values[rows + 1, columns]
    np.maximum.at(largest, columns, _turns(u0, u1, h * before[rows, columns], h * after[rows, columns]))
    return largest


def peak(steps: FloatArray, values: FloatArray, before: FloatArray, after: FloatArray) -> float:
    """Return `peaks` of one history, all of shape (m,) or (m + 1,), in a fourth of the time."""
    largest = np.abs(values).max()
    rows = (before * after < 0.0).nonzero()[0]
    if rows.size:
        h = steps[rows]
        largest = max(largest, _turns(values[rows], values[rows + 1], h * before[rows], h * after[rows]).max())
    return float(largest)


def _turns(u0: FloatArray, u1: FloatArray, v0: FloatArray, v1: FloatArray) -> FloatArray:
    """Return the absolute values at the turning points of cubics on the unit interval.

    `u0`, `u1` are the values and `v0`, `v1` the slopes at both ends; the slopes differ in sign.
    """
    a, b = 6.0 * (u0 - u1) + 3.0 * (v0 + v1), 6.0 * (u1 - u0) - 4.0 * v0 - 2.0 * v1
    x = 2.0 * v0 / (-b + np.copysign(np.sqrt(b * b - 4.0 * a * v0), v0))  # the root of a x^2 + b x + v0 in between
    return np.abs(u0 + x * (v0 + x * (b / 2.0 + x * a / 3.0)))


def _one_step(
    h: FloatArray, omega: FloatArray, damping: float, u: float, v: float, before: float, after: float
) -> tuple[FloatArray, FloatArray]:
    """Return (u, v) a time h later, each of shape (lengths, p)."""
    damped, decay = omega * np.sqrt(1.0 - damping**2), damping * omega
    slope = (after - before) / h
    # the particular solution p + q t
    q = -slope / omega**2
    p = -(before - 2.0 * damping * slope / omega) / omega**2
    c = u - p
    d = (v - q + decay * c) / damped
    fade, cos, sin = np.exp(-decay * h), np.cos(damped * h), np.sin(damped * h)
    return (
        p + q * h + fade * (c * cos + d * sin),
        q + fade * ((damped * d - decay * c) * cos - (damped * c + decay * d) * sin),
    )
