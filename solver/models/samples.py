"""The base motion, and the loads on ports, as kernels read them (kernels/engine/samples.py)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..ground.loads import COMPONENTS, IN_PLANE, on_one_grid
from ..ground.motion import Motion

FloatArray = NDArray[np.float64]

_NONE = np.zeros(0)
_OF_PLANE = [name in IN_PLANE for name in COMPONENTS]


def plain(row: ArrayLike) -> FloatArray:
    """Return the row as a contiguous float64 array, as kernels read it."""
    return np.require(row, dtype=np.float64, requirements=["C"])


class Samples(NamedTuple):
    """The samples of a record, in the order of the arguments of entries."""

    time: FloatArray  # s; may continue after the base motion
    ax: FloatArray  # m/s2, of the base
    ay: FloatArray  # not read in a plane
    az: FloatArray
    scale: float = 1.0  # factor on the accelerations
    held: bool = False  # samples are held; else straight lines join them
    loads: FloatArray = _NONE  # on ports in each interval of `time`, by component and port, then their slopes


NO_SAMPLES = Samples(_NONE, _NONE, _NONE, _NONE)


def samples_of(motion: Motion | None, ports: Sequence[str] = (), in_plane: bool = False) -> Samples:
    """Return the samples of a motion of the base and of its loads on these ports; none for None.

    in_plane: keep only the components of loads in the plane x, z.
    """
    if motion is None:
        return NO_SAMPLES
    samples = [motion.time, motion.ax, motion.ay, motion.az]
    if motion.end > motion.time[-1]:  # the last held sample lasts until the motion ends
        samples = [np.append(motion.time, motion.end), *(np.append(part, 0.0) for part in samples[1:])]
    loads = _NONE
    if motion.loads:
        *samples, loads = on_one_grid(samples, motion.hold, motion.loads, ports)
        if in_plane:
            loads = loads.reshape(-1, len(COMPONENTS), len(ports))[:, _OF_PLANE].ravel()
    time, ax, ay, az = map(plain, samples)
    return Samples(time, ax, ay, az, held=motion.hold, loads=plain(loads))
