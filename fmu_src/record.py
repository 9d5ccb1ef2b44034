"""A record of the base acceleration inside the FMU, sampled where the communication steps do not reach."""

from __future__ import annotations

import hashlib
from bisect import bisect_left, bisect_right
from pathlib import Path

import numpy as np

from solver.motion import Motion

SLACK = 1e-9  # of a sampling interval: times closer than this are the same


def read_motion(path: Path) -> Motion:
    """The motion in a file of one record that says all itself. Raises InputError that begins with `path`."""
    return Motion.from_file(path)


class Record:
    """A sampled motion as straight lines from sample to sample; zero before the first and after the last."""

    def __init__(self, motion: Motion) -> None:
        self._motion = motion
        widths = np.diff(motion.time)
        self._times: list[float] = motion.time.tolist()
        self._ax: list[float] = motion.ax.tolist()
        self._az: list[float] = motion.az.tolist()
        self._jx: list[float] = (np.diff(motion.ax) / widths).tolist()
        self._jz: list[float] = (np.diff(motion.az) / widths).tolist()
        self.dt = float(np.min(widths))  # s, the shortest sampling interval
        self.pga = motion.pga  # m/s2
        content = hashlib.sha256(motion.time.tobytes() + motion.ax.tobytes() + motion.az.tobytes())
        self.digest = content.hexdigest()

    def edges(self, start: float, stop: float) -> list[float]:
        """`start`, the samples in between, `stop`, s: from one to the next the record is a straight line."""
        slack = SLACK * self.dt
        first, last = bisect_right(self._times, start + slack), bisect_left(self._times, stop - slack)
        return [start, *self._times[first:last], stop]

    def line(self, inside: float, t: float) -> tuple[float, float, float, float]:
        """(ax, jx, az, jz) at time t of the straight line that passes through the instant `inside`; m/s2, m/s3."""
        k = bisect_right(self._times, inside) - 1
        if not 0 <= k < len(self._jx):
            return 0.0, 0.0, 0.0, 0.0
        gone = t - self._times[k]
        jx, jz = self._jx[k], self._jz[k]
        return self._ax[k] + jx * gone, jx, self._az[k] + jz * gone, jz

    def after(self, t: float) -> tuple[float, float, float, float]:
        """(ax, jx, az, jz) from time t on; m/s2, m/s3."""
        return self.line(t + SLACK * self.dt, t)
