"""Results that can be kept of each of many runs, by name."""

from __future__ import annotations

import numpy as np

from ..protocol import Kept
from .response import BASE_HISTORIES, BLOCK_HISTORIES, UNITS

# names -> those among the peaks of a Response, which lanes do not watch
WATCHED = {
    "least_contact" if name == "contact" else f"peak_{name}": name for name in (*BLOCK_HISTORIES, "friction")[1:]
}
WATCHED_OF_BASE = {f"peak_{name}": name for name in BASE_HISTORIES}
WATCHED_ALL = WATCHED.keys() | WATCHED_OF_BASE.keys()
# peaks: of the absolute values within the duration; docs/studies.md says what each is. verdict, path: numbers of
# protocol.WORDS.
KEPT: dict[str, Kept] = {
    "peak_ux": Kept("m"),
    **{name: Kept(UNITS.get(watched, "")) for name, watched in WATCHED.items()},
    **{name: Kept(UNITS[watched], np.float64) for name, watched in WATCHED_OF_BASE.items()},
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
