"""Modal data of a column, made once for columns that are alike."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .kernels import layout as at
from .kernels.normal_modes import find_normal_modes, scratch_size

FloatArray = NDArray[np.float64]


def modal_data(blocks: FloatArray, g: float, tolerance: float) -> FloatArray | None:
    """What kernels/layout.py lists as modal data, read-only; None where there is none (kernels/normal_modes.py).

    blocks: (n, BLOCK_FIELDS) of the packed model; g: m/s2; tolerance: of the packed model.
    """
    if len(blocks) > at.MODAL_MOST or not g > 0.0:
        return None
    return _modal_data(np.ascontiguousarray(blocks).tobytes(), g, tolerance)


@lru_cache(maxsize=64)
def _modal_data(content: bytes, g: float, tolerance: float) -> FloatArray | None:
    blocks = np.frombuffer(content)
    n = blocks.size // at.BLOCK_FIELDS
    model = np.concatenate([np.zeros(at.MODEL_HEADER), blocks])
    model[[at.N_BLOCKS, at.GRAVITY, at.TOLERANCE]] = n, g, tolerance
    data = np.zeros(at.modal_size(n))
    if not find_normal_modes(model, data, np.zeros(scratch_size(n))):
        return None
    data.flags.writeable = False
    return data
