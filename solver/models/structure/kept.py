"""The results that can be kept of each of many runs of structures, by name."""

from __future__ import annotations

import numpy as np

from ..outputs import BASE
from ..protocol import Kept, kept_peaks
from .outputs import OUTPUTS, StructureHistories

OF_RUN = {
    "verdict": Kept(kind=np.uint8),
    "overturn_time": Kept("s", np.float64),
    "fallen": Kept(kind=np.int64),
    "steps": Kept(kind=np.int64),
    "evaluations": Kept(kind=np.int64),
    "settled_for": Kept("s", np.float64),
    "path": Kept(kind=np.uint8),
}
KEPT: dict[str, Kept] = {**OF_RUN, "peak_u": Kept("m"), **kept_peaks(OUTPUTS)}
KEPT |= {f"peak_base_{one.name}": Kept(one.unit, np.float64, BASE) for one in StructureHistories.base.parts}
KEPT["least_contact"] = KEPT.pop("least_contact")  # the last one
FROM_LANES = {*OF_RUN, "peak_u", "peak_ux", "peak_uy", "peak_uz", "peak_d", "least_gap", "least_bond"}
KEYS = {"peak_centroid_ux": "peak_ux"}
