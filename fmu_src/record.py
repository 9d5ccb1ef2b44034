"""A record of the base acceleration inside the FMU, sampled where the communication steps do not reach."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

from solver.motion import Motion
from solver.stepper import Record as Samples


def read_motion(path: Path) -> Motion:
    """The motion in a file of one record that says all itself. Raises InputError that begins with `path`."""
    return Motion.from_file(path)


class Record:
    """A sampled motion as the solver follows it: straight lines from sample to sample, zero before and after."""

    def __init__(self, motion: Motion) -> None:
        self.samples = Samples(motion.time, motion.ax, motion.az)
        self.dt = float(np.min(np.diff(motion.time)))  # s, the shortest sampling interval
        self.pga = motion.pga  # m/s2
        content = hashlib.sha256(motion.time.tobytes() + motion.ax.tobytes() + motion.az.tobytes())
        self.digest = content.hexdigest()
