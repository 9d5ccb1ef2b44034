"""Results that can be kept of each of many runs of structures, by name."""

from __future__ import annotations

import numpy as np

from ..protocol import Kept

OF_RUN = {
    "verdict": Kept(kind=np.uint8),
    "overturn_time": Kept("s", np.float64),
    "steps": Kept(kind=np.int64),
    "evaluations": Kept(kind=np.int64),
    "settled_for": Kept("s", np.float64),
    "path": Kept(kind=np.uint8),
}
_UNITS = {
    "block": {"u": "m", "ux": "m", "uy": "m", "uz": "m", "rx": "rad", "ry": "rad", "rz": "rad"},
    "joint": {"N": "N", "Mx": "N m", "My": "N m", "Tx": "N", "Ty": "N", "Mz": "N m", "sigma_max": "Pa", "slip": "m"},
    "tie": {"tie": "N"},
    "base": {"base": ""},  # three forces in N, three moments in N m
}
KEPT: dict[str, Kept] = {
    **OF_RUN,
    **{f"peak_{name}": Kept(unit, None, of) for of, units in _UNITS.items() for name, unit in units.items()},
    "least_contact": Kept("", None, "joint"),
}
FROM_LANES = {*OF_RUN, "peak_u", "peak_ux", "peak_uy", "peak_uz"}
