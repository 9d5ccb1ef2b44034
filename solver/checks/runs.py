"""The runs of a check: of the subject as given, of its varied models, and of many at once."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from ..common.errors import InputWarning
from ..common.executors import cores
from ..ground.intensity import NAMES
from ..ground.motion import Motion
from ..models.protocol import OVERTURNED, SETTLE, STANDING, UNDECIDED
from ..models.uncertainty import vary
from ..runs.many import Callback, Summary, begin_phase, collected, parts_of_many
from ..runs.simulate import simulate
from ..runs.table import Table
from .limits import TOLERANCE, Plan
from .scaling import ScaledMotion
from .subject import OF_BEARINGS, Pair, Subject

# s: least time of a run, in which a block may still rise or slide, after a component last has STRONG times its peak
STILL, STRONG = 10.0, 0.3
WORSE = (STANDING, UNDECIDED, OVERTURNED)  # from best to worst


def span_of(motion: Motion) -> float:
    """Return the duration of a run under a motion (s): with a still base at the end where the motion ends early.

    A run under a harmonic motion is as long as the motion, which has no end of its own.
    """
    acting = [name for name in NAMES if np.any(getattr(motion, name))]
    if motion.amplitude or motion.amplitude_y or not acting:
        return motion.duration
    # each by its own peak: the strongest part need not be the one that topples
    sizes = [np.abs(getattr(motion, name)) for name in acting]
    last = max(int(np.nonzero(size >= STRONG * np.max(size))[0][-1]) for size in sizes)
    return max(motion.duration, float(motion.time[last]) - motion.start + STILL)


def own_runs(subject: Subject, motions: Sequence[Motion]) -> tuple[tuple[Any, ...], ...]:
    """Simulate the subject under each motion, and return the responses (motions, signs).

    If the sign of a motion counts, there are two for each motion, the worse one first: by verdict, then by the time of
    the fall or the displacement. The other one may still have the larger demand of a joint, tie or neighbour.
    """

    def badness(run: Any) -> tuple[int, float]:
        return WORSE.index(run.verdict), -run.overturn_time if run.overturned else subject.moved(run)

    ways = [way for motion in motions for way in ((motion, motion.mirrored()) if subject.two_ways else (motion,))]
    with ThreadPoolExecutor(cores(), thread_name_prefix="runs") as pool, warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".* pass into each other", InputWarning)  # the table has a row for it
        made = list(pool.map(lambda way: simulate(subject.model, way, duration=span_of(way), settle=SETTLE), ways))
    each = len(ways) // len(motions)
    return tuple(tuple(sorted(made[k : k + each], key=badness, reverse=True)) for k in range(0, len(made), each))


def is_turned(run: Any, motion: Motion) -> bool:
    """Return True if a response is that of the motion turned by 180 degrees, of the opposite sign in the plane."""
    turned = motion.mirrored()
    return _horizontal(run.motion) == _horizontal(turned) != _horizontal(motion)


def _horizontal(motion: Motion) -> list[list[float]]:
    """Return the samples and amplitudes along x and y."""
    return [motion.ax.tolist(), motion.ay.tolist(), [motion.amplitude, motion.amplitude_y]]


def varied(subject: Subject, run: Any, scaled: ScaledMotion, plan: Plan, place: int) -> list[Pair]:
    """Return varied models and motions of a run of the subject under a motion; the same for the same seed and `place`.

    The sign of a record is arbitrary: where it counts, every second motion is mirrored. `place` is the index of the
    motion, part of the seed.
    """
    rng = np.random.default_rng([plan.spread.seed, place])
    model = subject.to_vary(run)
    made = [vary(model, scaled.motion, plan.spread, rng) for _ in range(plan.ensemble)]
    if subject.two_ways:
        made[1::2] = [(held, motion.mirrored()) for held, motion in made[1::2]]
    return made


class Sets:
    """A callback that numbers the sets of runs of a check, each as long as the first or shorter, for another one."""

    def __init__(self, callback: Callback, most: int) -> None:
        self._callback, self._most, self._number = callback, most, 0

    def begin(self, phase: str) -> None:
        """Begin the next set."""
        self._number += 1
        begin_phase(self._callback, f"set {self._number} of at most {self._most}, {phase}")

    def __call__(self, done: int, total: int | None) -> None:
        """Pass on the number of runs made."""
        self._callback(done, total)


def run_all(
    subject: Subject, pairs: Sequence[Pair], peaks: bool, callback: Callback | None, threads: int | None = None
) -> Table:
    """Simulate pairs of models and motions, and return the table of the runs, one row for each.

    A model without a rest falls at once. The verdicts are kept, and with `peaks` the largest displacements, also those
    of bearings, what falls and when, and the least gaps. `callback` and `threads` are those of `simulate_many`.
    """
    keep = ("verdict",)
    if peaks:
        gaps = ("least_gap",) if subject.neighbours else ()
        moved = (OF_BEARINGS,) if subject.bearings[0] else ()
        keep = (subject.model.kind.displacements, "verdict", "overturn_time", "fallen", *gaps, *moved)
    summary = Summary()
    parts = parts_of_many(
        [model for model, _ in pairs],
        [motion for _, motion in pairs],
        duration=[span_of(motion) for _, motion in pairs],
        tolerance=TOLERANCE,
        keep=keep,
        settle=SETTLE,
        threads=threads,
        callback=callback,
        summary=summary,
        refuses=False,
    )
    return collected(parts, summary)
