"""The friction needed to prevent sliding in a response; a joint without `friction` never slides.

N vanishes where a joint is about to open, and in flight the model still keeps the blocks in line: T / N has no meaning
there. So it counts only where N is more than a part of the weight that the joint carries at rest.
"""

from __future__ import annotations

import numpy as np

from ...common.errors import InputError, check_number
from ...kernels.layout.spaces import COUNTS_FROM
from .packing import FloatArray


def friction_history(T: FloatArray, N: FloatArray, carried: FloatArray, part: float = COUNTS_FROM) -> FloatArray:
    """|T| / N where N > part * carried, else 0, (nt, n).

    T, N: forces of the joints, N (nt, n). carried: weight that each joint carries at rest, N (n,).

    Raises InputError unless part is from 0.001 to 1 and every joint carries something.
    """
    part = check_number("part", part, (1e-3, 1.0), "a part of the weight carried at rest, from 0.001 to 1")
    if not np.all(carried > 0.0):
        raise InputError("g = 0.0: must be positive for joints that carry a weight at rest")
    ratio: FloatArray = np.where(part * carried < N, np.abs(T) / np.maximum(N, part * carried), 0.0)
    return ratio
