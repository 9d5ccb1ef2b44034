"""The results of each of many runs that can be stored, by name."""

from __future__ import annotations

import numpy as np

from ..outputs import BOND, PORT
from ..protocol import Kept, kept_peaks
from .outputs import OUTPUTS

WATCHED = {output.kept for output in OUTPUTS if output.field != "ux"}  # peaks that lanes do not watch
# peaks: of the absolute values within the duration; docs/studies.md defines each. verdict, path: codes of
# protocol.WORDS.
KEPT: dict[str, Kept] = {
    # the entries of a joint are listed by its block
    **{
        name: kept if kept.of in (PORT, BOND) else kept._replace(of="block")
        for name, kept in kept_peaks(OUTPUTS).items()
    },
    "peak_centroid_ux": Kept("m"),
    "residual_ux": Kept("m"),
    "residual_theta": Kept("rad"),
    "residual_slip": Kept("m"),
    "energy": Kept("J", np.float64),
    "verdict": Kept(kind=np.uint8),
    "overturn_time": Kept("s", np.float64),
    "overturned_joint": Kept(kind=np.int64),
    "steps": Kept(kind=np.int64),
    "evaluations": Kept(kind=np.int64),
    "path": Kept(kind=np.uint8),
}
KEYS = {output.extreme: output.kept for output in OUTPUTS if output.extreme != output.kept} | {
    "peak_top_ux": "peak_ux",
    "residual_top_ux": "residual_ux",
    "residual_ry": "residual_theta",
    "fallen": "overturned_joint",
}
