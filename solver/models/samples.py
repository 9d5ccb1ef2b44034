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
    """The samples of a record, in the order of the arguments of entries.

    Attributes
    ----------
    time : ndarray
        Times (s), which may continue after the base motion.
    ax, ay, az : ndarray
        Accelerations of the base (m/s2); ay is not read in a plane.
    scale : float
        Factor on the accelerations.
    held : bool
        True if samples are held, False if straight lines join them.
    loads : ndarray
        On each interval of `time` the loads on the ports by component, then their slopes, a number for each port.
    """

    time: FloatArray
    ax: FloatArray
    ay: FloatArray
    az: FloatArray
    scale: float = 1.0
    held: bool = False
    loads: FloatArray = _NONE


NO_SAMPLES = Samples(_NONE, _NONE, _NONE, _NONE)


def samples_of(motion: Motion | None, ports: Sequence[str] = (), in_plane: bool = False) -> Samples:
    """Return the samples of a motion and of its loads; none for None.

    Parameters
    ----------
    motion : Motion or None
        The motion of the base, with loads.
    ports : sequence of str
        The names of the ports.
    in_plane : bool
        Whether only the components of loads in the plane x, z are kept.
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
