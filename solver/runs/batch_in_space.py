"""Runs of structures, eight at once: into the arrays of the kernels and back (kernels/space/in_lanes.py)."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..common.turns import others_turn
from ..dynamics.verdict import OVERTURNED, STANDING, UNDECIDED
from ..ground.motion import Motion
from ..kernels.numba_ext.lanes import WIDTH
from ..kernels.space import in_lanes as at
from ..kernels.space.entries import run_structures_in_lanes
from ..kernels.space.layout import BASE, JOINTS, SETTINGS
from ..space.blocks.faces import FloatArray
from ..space.rest import Rest, rest_of, start_from
from ..space.run import SAFE, least_barrier
from ..space.stepper import Stepper
from ..space.structure import Structure
from .batch import aligned

STAGES = 6  # evaluations of a step
LANES = "lanes"
FROM_LANES = {
    *("verdict", "overturn_time", "settled_for", "steps", "evaluations", "path"),
    *("peak_u", "peak_ux", "peak_uy", "peak_uz"),
}


class RunInSpace(NamedTuple):
    """One run, from rest."""

    structure: Structure
    motion: Motion
    duration: float  # s


def kind_of(run: RunInSpace) -> Hashable:
    """What runs that share lanes have in common; None where a run is not made in lanes.

    Of lightly damped structures the steps are of order 8, which lanes do not have.
    """
    structure = run.structure
    settings = SETTINGS.see(structure.model.settings)
    if settings.order != 5.0:
        return None
    places = JOINTS.see(structure.model.joints, len(structure.joints))  # of what lanes find by that of the first
    joints = tuple(getattr(places, name).tobytes() for name in ("upper", "lower", "first", "corners", "above", "below"))
    ties = tuple((tie.one, tie.other) for tie in structure.ties)
    sizes = structure.n, len(structure.model.corners)
    return sizes, joints, ties, bool(settings.gives_way), _is_flat(run)


def _is_flat(run: RunInSpace) -> bool:
    """Whether the motion stays in the plane x, z."""
    return run.structure.is_plane and not run.motion.has_ay


def follow_in_lanes(
    runs: Sequence[RunInSpace], rests: Sequence[Rest], settle: float, flag: FloatArray | None = None
) -> list[dict[str, Any]]:
    """Results of runs of one kind, in one thread, by the names of many_in_space.KEPT; empty where lanes do not go on.

    rests: of each structure. settle: s, for how long they are followed after their end at most. Ends soon, without
    usable results, once flag[0] is not zero.
    """
    queue = _Queue(len(runs), settle)
    for k, (run, rest) in enumerate(zip(runs, rests, strict=True)):
        queue.add(k, run, rest)
    with others_turn():
        queue.follow(np.zeros(1) if flag is None else flag)
    return [queue.result(k, run) for k, run in enumerate(runs)]


class _Queue:
    """Runs as rows for the kernels, and what becomes of them."""

    def __init__(self, count: int, settle: float) -> None:
        self._settle = settle
        self._runs, self._outcomes = np.zeros((count, at.RUN.beside)), np.zeros((count, at.OUTCOME.beside))
        self._models: list[FloatArray] = []
        self._states: list[FloatArray] = []
        self._samples: dict[int, tuple[int, int]] = {}  # of a motion: first sample, number of them
        self._records: list[tuple[FloatArray, ...]] = []
        self._sizes = 0, 0, 0, 0
        self._peaks = np.zeros(0)

    def add(self, k: int, run: RunInSpace, rest: Rest) -> None:
        """Let run k wait for a lane."""
        structure, motion, duration = run
        stepper = Stepper(structure)
        start_from(stepper, rest)
        settings = structure.model.settings.copy()
        SETTINGS.see(settings).in_plane = float(_is_flat(run))
        self._models.append(np.concatenate([settings, *structure.model[1:-1]]))
        self._states.append(stepper.phase)
        self._sizes = *stepper.sizes, len(structure.model.corners)
        record = stepper.drive(motion)
        if id(motion) not in self._samples:
            placed = sum(len(times) for times, *_ in self._records)
            self._samples[id(motion)] = placed, len(record[0])
            self._records.append(record)
        see, base = at.RUN.see(self._runs[k]), BASE.see(stepper.base)
        see.start, see.stop, see.last = motion.start, motion.start + duration, motion.start + duration + self._settle
        see.first, see.count = self._samples[id(motion)]
        for name in ("held", "amplitude_x", "amplitude_y", "omega", "phase"):
            setattr(see, name, getattr(base, name))
        see.at_rest, see.enough = stepper.observe(), SAFE * least_barrier(structure, rest)

    def follow(self, flag: FloatArray) -> None:
        """Let all runs pass through the lanes, the longest first: lanes end together."""
        order = np.argsort(self._runs[:, at.RUN.places["start"]] - self._runs[:, at.RUN.places["stop"]], kind="stable")
        models, states = np.array(self._models)[order], np.array(self._states)[order]
        runs, outcomes = self._runs[order], self._outcomes[order]
        peaks = np.zeros((len(order), 4 * self._sizes[0]))
        lanes = aligned(WIDTH * at.lane_size(*self._sizes))
        lanes.reshape(-1, WIDTH)[: models.shape[1]] = models[0][:, None]  # so that lanes without a run have numbers
        samples = tuple(np.concatenate(part) for part in zip(*self._records, strict=True))
        found, highest = outcomes.ravel(), peaks.ravel()
        run_structures_in_lanes(
            *self._sizes, lanes, len(order), models.ravel(), states.ravel(), runs.ravel(), found, highest, samples, flag
        )
        self._outcomes[order], self._peaks = outcomes, np.zeros_like(peaks)
        self._peaks[order] = peaks

    def result(self, k: int, run: RunInSpace) -> dict[str, Any]:
        """Results of run k by name."""
        outcome, stop = at.OUTCOME.see(self._outcomes[k]), run.motion.start + run.duration
        if outcome.ends == at.STEP_TOO_SMALL:
            return {}
        names = zip(("peak_u", "peak_ux", "peak_uy", "peak_uz"), self._peaks[k].reshape(4, -1), strict=True)
        return {
            "verdict": {at.FELL: OVERTURNED, at.STANDS: STANDING, at.UNDECIDED: UNDECIDED}[outcome.ends],
            "overturn_time": outcome.time if outcome.ends == at.FELL else math.nan,
            "settled_for": max(outcome.time, stop) - stop,
            "steps": int(outcome.steps),
            "evaluations": int(STAGES * (outcome.steps + outcome.rejected) + outcome.looks),
            "path": LANES,
            **dict(names),
        }


@lru_cache(maxsize=1)
def load_lanes() -> None:
    """Load the kernels into this process, which takes as long as many runs where they are compiled."""
    block = {"name": "block", "width": 1.0, "depth": 1.0, "height": 1.0, "mass": 1e3, "on": "base"}
    structure = Structure.from_dict({"name": "block", "joints": {"stiffness": 1e9, "damping": 1e-3}, "block": [block]})
    run = RunInSpace(structure, Motion.harmonic(1e-3, 1.0, 1e-3), 1e-3)
    follow_in_lanes([run], [rest_of(structure)], 0.0)
