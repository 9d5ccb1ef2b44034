"""The outline of a prism or of a joint, as given in a file."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ....common.errors import InputError
from ....kernels.structure.layout import MOST_CORNERS
from .faces import FloatArray, polygon_moments

THINNEST = 1e-9  # of the square of its extent: the least area
STRAIGHT = 1e-9  # of its extent: a corner closer to the line between its neighbours is dropped
FARTHEST = 1e3  # times its extent: distance from its origin; beyond it the moments lose their digits
TINY = 1e-300  # m
MEANING = f"a list of 3 to {MOST_CORNERS} pairs of lengths in m, the corners of a convex polygon one after the other"


def outline_of(key: str, pairs: Sequence[FloatArray]) -> FloatArray:
    """Return a convex polygon, anticlockwise, (corners, 2) m, without corners on the straight line of their neighbours.

    A last corner that repeats the first is left out. Raises InputError if the pairs are no convex polygon.
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
    # anticlockwise, without straight corners
    if area < 0.0:
        found = found[::-1].copy()
    if not np.all(np.hypot(*(np.roll(found, -1, axis=0) - found).T) > 0.0):
        raise InputError(f"{key}: a corner occurs twice, must be {MEANING}")
    found = found[bent_corners(found)]
    if not is_convex(found):
        raise InputError(f"{key}: is not convex, must be {MEANING}")
    return found


def bent_corners(outline: FloatArray) -> NDArray[np.intp]:
    """Return the indices of the corners of a polygon (corners, 2) that lie off the line between their neighbours.

    The straightest corner is removed first. Any line crosses the rest of a convex polygon twice, whatever the rounding.
    """
    kept = np.arange(len(outline))
    least = STRAIGHT * float(np.max(np.ptp(outline, axis=0)))
    while len(kept) > 3:
        corners = outline[kept]
        before, after = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
        chord = np.maximum(np.hypot(*(before + after).T), TINY)
        height = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]) / chord
        height[np.sum(before * after, axis=1) < 0.0] = math.inf  # a peak, not a straight line
        k = int(np.argmin(height))
        if height[k] > least:
            break
        kept = np.delete(kept, k)
    return kept


def is_convex(outline: FloatArray) -> bool:
    """Return True if all corners of a polygon (corners, 2) turn left, and once around."""
    side = np.roll(outline, -1, axis=0) - outline
    after = np.roll(side, -1, axis=0)
    turns = np.arctan2(side[:, 0] * after[:, 1] - side[:, 1] * after[:, 0], np.sum(side * after, axis=1))
    return bool(np.min(turns) > 0.0) and abs(float(np.sum(turns)) - 2.0 * math.pi) < 1e-6


def corners_around(flat: FloatArray) -> list[int]:
    """Return the indices of the corners of the convex hull of points (n, 2), anticlockwise (Andrew's chain)."""
    order = np.lexsort((flat[:, 1], flat[:, 0])).tolist()
    points = flat.tolist()
    found: list[int] = []
    for way in (order, order[::-1]):
        chain: list[int] = []
        for k in way:
            while len(chain) > 1:
                (x0, y0), (x1, y1), (x, y) = points[chain[-2]], points[chain[-1]], points[k]
                if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 0.0:
                    break
                chain.pop()
            chain.append(k)
        found += chain[:-1]
    return found
