"""Runs of structures, eight at once: into the arrays of the kernels and back (kernels/structure/in_lanes.py)."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ...common import effort
from ...common.turns import lock_released
from ...ground.motion import Motion
from ...kernels.numba_ext.lanes import WIDTH
from ...kernels.structure import in_lanes as at
from ...kernels.structure.entries import run_structures_in_lanes
from ...kernels.structure.layout import FACE, INSIDE, NO_ROOM
from ...kernels.structure.stepping import SEEN
from ..column.lanes import aligned
from ..column.packing import FloatArray, IntArray
from ..protocol import LANES, OVERTURNED, STANDING, UNDECIDED, Run
from .model import Structure
from .packing import unbroken_shares
from .rest import SpatialRest, fastest_decay
from .stepper import SpatialStepper
from .verdict import next_look, potential_well_of, reason_for_leaning

STAGES = 6  # evaluations of a step
OF_INSIDE = ("section", "corners", "above", "below")  # fields that lanes read from the first run
NAMES = ("peak_u", "peak_ux", "peak_uy", "peak_uz")


def share_of(structure: Structure) -> Hashable:
    """Return the key that structures in the same lanes must share: sizes, topology, kinds of sections, yielding."""
    names = structure.model.names
    places = names.joints  # fields that lanes read from the first run
    joints = tuple(
        getattr(places, name).tobytes()
        for name in ("upper", "lower", "first", "corners", "above", "below", "section", "bond", "inside")
    )
    ties = tuple((tie.one, tie.other) for tie in structure.ties)
    records = [INSIDE.see(names.corners[int(place) - 1 :]) for place in places.inside if place]
    insides = tuple(tuple(getattr(record, name) for name in OF_INSIDE) for record in records)
    below = [*places.below, *(record.below for record in records)]
    unbounded = tuple(_is_unbounded(names.corners, int(place)) for place in below)
    return structure.model.sizes, joints, insides, unbounded, ties, bool(names.settings.gives_way)


def _is_unbounded(corners: FloatArray, below: int) -> bool:
    """Return True if the lower face at an index of the corners is a plane of the base; False at 0, without faces."""
    return below > 0 and below < len(corners) and FACE.see(corners[below:]).outer == math.inf


@lru_cache(maxsize=64)  # as many as rests
def longest_step_of(structure: Structure) -> float:
    """Return the longest explicit step (s), used to decide whether runs are too long for lanes.

    It is the first step, or a shorter one that dampers allow. A run that needs more evaluations than a run alone may
    make is left to a run alone, which refuses it.
    """
    per_evaluation = effort.MOST_IN_SPACE / effort.MOST_FIRST_STEPS * SEEN / STAGES
    decay = fastest_decay(structure)
    return float(min(structure.model.names.settings.first_step, per_evaluation / decay if decay else math.inf))


def is_flat_run(structure: Structure, motion: Motion) -> bool:
    """Return True if the motion stays in the plane x, z."""
    return structure.is_plane and not motion.has_ay


def follow_in_lanes(
    runs: Sequence[Run],
    rests: Sequence[SpatialRest],
    settle: float,
    flag: FloatArray | None = None,
    times: FloatArray | None = None,
) -> list[dict[str, Any]]:
    """Return the results of runs that share lanes, by the names of outputs.py; empty where lanes cannot continue.

    `rests` are those of their structures. Runs are followed for at most `settle` seconds after their end. Once `flag`
    (1,) is not zero, the function returns soon, without usable results. With `times` after the start of a run, s,
    results have "places", the horizontal displacements at them (rows, n).
    """
    flag = np.zeros(1) if flag is None else flag
    lanes, all_of_them = _Lanes(runs, rests, np.zeros(0) if times is None else times), np.arange(len(runs))
    stops = np.array([run.motion.start + run.duration for run in runs])
    # during the motions
    lanes.follow(all_of_them, np.array([run.motion.start for run in runs]), stops, flag)
    within, found = lanes.outcomes.copy(), [lanes.named(k) for k in range(len(runs))]
    # then on a still base, until each run has fallen, has come to rest or cannot fall any more
    since, stand = 0.0, np.zeros(len(runs), dtype=bool)
    left = all_of_them
    while not flag[0]:
        left = left[lanes.outcomes[left, at.OUTCOME.places["ends"]] == at.STOPPED]
        stand[left] = [lanes.why_it_stands(k) != "" for k in left.tolist()]
        left = left[~stand[left]]
        if not left.size or since >= settle:
            break
        begin, since = since, next_look(since, settle)
        lanes.follow(left, stops[left] + begin, stops[left] + since, flag, still=True)
    made = [
        _result(at.OUTCOME.see(first), at.OUTCOME.see(last), peaks, stop, bool(stands))
        for first, last, peaks, stop, stands in zip(within, lanes.outcomes, found, stops.tolist(), stand, strict=True)
    ]
    if times is not None:
        made = [made_of and {**made_of, "places": places} for made_of, places in zip(made, lanes.places, strict=True)]
    return made


def _result(within: Any, later: Any, peaks: dict[str, FloatArray], stop: float, stands: bool) -> dict[str, Any]:
    """Return the results of a run by name.

    They are from its outcomes within its duration and after it, its peaks by name, its end `stop` (s), and whether its
    energy well holds the structure.
    """
    if at.STEP_TOO_SMALL in (within.ends, later.ends):
        return {}
    fell = later.ends == at.FELL
    return {
        "verdict": OVERTURNED if fell else STANDING if stands or later.ends == at.RESTS else UNDECIDED,
        "overturn_time": later.time if fell else math.nan,
        "fallen": int(later.block) if fell else 0,
        "settled_for": max(later.time, stop) - stop,
        "steps": int(within.steps),
        "evaluations": int(STAGES * (within.steps + within.rejected) + within.looks),
        "path": LANES,
        **peaks,
    }


class _Lanes:
    """Runs as rows for the kernels: models, states, and the outcomes and peaks of the last interval followed."""

    def __init__(self, runs: Sequence[Run], rests: Sequence[SpatialRest], times: FloatArray) -> None:
        self._runs, self._times = runs, times
        self._steppers = {id(run.model): SpatialStepper(run.model) for run in runs}
        self._sizes = self._stepper(0).sizes
        longest = {id(run.model): longest_step_of(run.model) for run in runs}
        self._longest_steps = np.array([longest[id(run.model)] for run in runs])
        models: list[FloatArray] = []
        records: list[tuple[FloatArray, ...]] = []
        self._samples: dict[int, tuple[int, int]] = {}  # of a motion: first sample, number of them
        for k, run in enumerate(runs):
            model = run.model.model._replace(numbers=run.model.model.numbers.copy())
            model.names.settings.in_plane = float(is_flat_run(run.model, run.motion))
            models.append(model.numbers)
            if id(run.motion) not in self._samples:
                record = self._stepper(k).drive(run.motion)[:4]
                self._samples[id(run.motion)] = sum(len(times) for times, *_ in records), len(record[0])
                records.append(record)
        self._models, self._states = np.array(models), np.array([rest.phase for rest in rests])
        self._record = tuple(np.concatenate(part) for part in zip(*records, strict=True))
        self.outcomes = np.zeros((len(runs), at.OUTCOME.beside))
        size = at.PEAKS.per_n * self._sizes.n + self._sizes.b + self._sizes.pairs
        self.peaks = np.zeros((len(runs), size))
        self.places = np.zeros((len(runs), len(times), self._sizes.n))

    def _stepper(self, k: int) -> SpatialStepper:
        return self._steppers[id(self._runs[k].model)]

    def named(self, k: int) -> dict[str, FloatArray]:
        """Return the peaks of run k so far by the names of outputs.py: of blocks, bearings, neighbours; bond shares."""
        size = at.PEAKS.per_n * self._sizes.n
        of_blocks, of_bearings, gaps = np.split(self.peaks[k].copy(), [size, size + self._sizes.b])
        rows, left = of_blocks.reshape(len(NAMES), -1), unbroken_shares(self._states[k], self._runs[k].model.model)
        beside = {"peak_d": of_bearings, "least_gap": gaps, "least_bond": left}
        return {**dict(zip(NAMES, rows, strict=True)), **beside}

    def why_it_stands(self, k: int) -> str:
        """Return the reason why run k, on a still base, can no longer fall from its state; "" if it may."""
        stepper = self._stepper(k)
        stepper.phase[:] = self._states[k]
        return reason_for_leaning(stepper) or potential_well_of(self._runs[k].model).why_it_stands(stepper)

    def follow(
        self, which: IntArray, starts: FloatArray, stops: FloatArray, flag: FloatArray, still: bool = False
    ) -> None:
        """Follow the runs `which` through the lanes from `starts` to `stops`, s; still: on a base that does not move.

        The runs with the most steps begin first, so that lanes finish together.
        """
        order = np.argsort((starts - stops) / self._longest_steps[which], kind="stable")
        which, rows = which[order], np.zeros((len(order), at.RUN.beside))
        for row, k, start, stop in zip(rows, which.tolist(), starts[order], stops[order], strict=True):
            see, stepper = at.RUN.see(row), self._stepper(k)
            stepper.drive(self._runs[k].motion)
            base = stepper.base
            see.start, see.stop = start, stop
            see.first, see.count = self._samples[id(self._runs[k].motion)]
            see.held = self._runs[k].motion.hold
            for name in ("amplitude_x", "amplitude_y", "omega", "phase"):
                setattr(see, name, getattr(base, name))
            if still:
                see.count, see.amplitude_x, see.amplitude_y = 1, 0.0, 0.0
        # gather the rows, run the lanes, scatter the results
        models, states, outcomes, peaks, places = (
            array[which] for array in (self._models, self._states, self.outcomes, self.peaks, self.places)
        )
        lanes = aligned(WIDTH * at.ALL.size(self._sizes))
        lanes.reshape(-1, WIDTH)[: models.shape[1]] = models[0][:, None]  # valid numbers for lanes without a run
        found = models.ravel(), states.ravel(), rows.ravel(), outcomes.ravel(), peaks.ravel()
        with lock_released():
            times = self._times[:0] if still else self._times
            run_structures_in_lanes(lanes, len(which), *found, *self._record, times, places.ravel(), flag)
        if at.ALL.see(lanes.reshape(-1, WIDTH).sum(axis=1), self._sizes).work.room[NO_ROOM] != 0.0:
            outcomes[:, at.OUTCOME.places["ends"]] = at.STEP_TOO_SMALL  # repeated alone, which reports why
        self._states[which], self.outcomes[which] = states, outcomes
        self.peaks[which], self.places[which] = peaks, places
