"""The outline of a prism or of a joint, as a user gives it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ....common.errors import InputError
from .faces import FloatArray, polygon_moments

MOST_CORNERS = 100
THINNEST = 1e-9  # of the square of its extent: the least area
FARTHEST = 1e3  # times its extent: distance from its origin; beyond it the moments lose their digits
MEANING = f"a list of 3 to {MOST_CORNERS} pairs of lengths in m, the corners of a convex polygon one after the other"


def outline_of(key: str, pairs: Sequence[FloatArray]) -> FloatArray:
    """A convex polygon, anticlockwise, (corners, 2) m; a last corner that repeats the first is left out.

    Raises InputError for what is no such polygon.
    """
    found = np.array(pairs[:-1] if len(pairs) > 1 and np.array_equal(pairs[0], pairs[-1]) else pairs)
    if len(found) < 3:
        raise InputError(f"{key}: {len(found)} corners, must be {MEANING}")
    extent = float(np.max(np.ptp(found, axis=0)))
    local = found - found[0]
    area = polygon_moments(local)[0]
    if not abs(area) > THINNEST * extent * extent:
        raise InputError(f"{key}: has no area, must be {MEANING}")
    if float(np.max(np.abs(found))) > FARTHEST * extent:
        raise InputError(f"{key}: lies farther from its origin than {FARTHEST:g} times its extent = {extent:g} m")
    if area < 0.0:
        found = found[::-1].copy()
    side = np.roll(found, -1, axis=0) - found
    length = np.hypot(*side.T)
    if not np.all(length > 0.0):
        raise InputError(f"{key}: a corner occurs twice, must be {MEANING}")
    side = side / length[:, None]
    after = np.roll(side, -1, axis=0)
    turns = np.arctan2(side[:, 0] * after[:, 1] - side[:, 1] * after[:, 0], np.sum(side * after, axis=1))
    # a polygon whose corners all turn left is convex if they turn once around
    if np.min(turns) < -1e-9 or abs(float(np.sum(turns)) - 2.0 * math.pi) > 1e-6:
        raise InputError(f"{key}: is not convex, must be {MEANING}")
    return found
