"""Models whose motion is followed in Python, from call to call: over a motion, and as their FMUs follow it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from ..common.errors import InputError
from ..ground.motion import Motion
from .outputs import FloatArray, peaks_by_name
from .protocol import Kept, Kind, Plan, kept_peaks
from .still_base import Settling, settled

NOT_YET = -1.0  # s, in the place of the time of a fall
INPUTS = 2  # acceleration of the base and its slope


class Shaking(NamedTuple):
    """Acceleration of the base in one piece of the time, m/s2: from `begin`, value, slope; amplitude, omega, start."""

    begin: float
    value: float
    slope: float
    amplitude: float = 0.0
    omega: float = 0.0
    start: float = 0.0

    def at(self, t: float) -> float:
        """Its value, m/s2."""
        wave = self.amplitude * math.sin(self.omega * (t - self.start))
        return self.value + self.slope * (t - self.begin) + wave


def pieces(motion: Motion | None, t: float, end: float) -> Iterator[tuple[float, Shaking]]:
    """The motion from t to `end`, s: where each piece ends, and the shaking in it; zero beyond the last sample."""
    if motion is None:
        yield end, Shaking(t, 0.0, 0.0)
        return
    times = motion.time
    marks = [t, *times[(times > t) & (times < end)].tolist(), end]
    wave = motion.amplitude, 2.0 * math.pi * motion.frequency, motion.start
    for begin, stop in pairwise(marks):
        k = int(np.searchsorted(times, begin, side="right")) - 1
        value = slope = 0.0
        if k >= 0 and motion.hold and begin < motion.end:
            value = float(motion.ax[k])
        elif 0 <= k < len(times) - 1 and not motion.hold:
            slope = float((motion.ax[k + 1] - motion.ax[k]) / (times[k + 1] - times[k]))
            value = float(motion.ax[k]) + slope * (begin - float(times[k]))
        yield stop, Shaking(begin, value, slope, *wave)


class Driven(Settling):
    """A model between two calls; the caller owns the time. Its whole state is in `arrays`: copying them saves it.

    A class of its own has `size`, `follow`, `at_rest`, `seen`, `visible_peaks` and `why_it_stands`.
    record: followed beside the inputs.
    """

    size = 0  # of its state, but for the time of a fall

    def __init__(self, model: Any) -> None:
        self.model = model
        state, counts, base = np.zeros(self.size + 1), np.zeros(2, np.int64), np.zeros(1 + INPUTS)
        self.arrays = SimpleNamespace(state=state, counts=counts, base=base)
        self.arrays.state[-1] = NOT_YET
        self.record: Motion | None = None

    def follow(self, shaking: Shaking, t: float, end: float) -> None:
        """Go from t to `end`, s, in one piece of the motion. Raises SolverError."""
        raise NotImplementedError

    @property
    def at_rest(self) -> bool:
        """Whether nothing moves."""
        raise NotImplementedError

    @property
    def seen(self) -> FloatArray:
        """The output row."""
        raise NotImplementedError

    @property
    def visible_peaks(self) -> FloatArray:
        """Extremes so far, in the order of the outputs."""
        raise NotImplementedError

    def drive(self, t: float, *inputs: float, since: float | None = None) -> None:
        """Set the acceleration of the base, m/s2, and its slope, m/s3, that count from time `since`; None: t."""
        self.arrays.base[:] = t if since is None else since, *inputs

    def advance(self, t: float, h: float) -> None:
        """Go from t to t + h, s. Raises SolverError."""
        since, value, slope = self.arrays.base.tolist()
        begin = t
        for end, shaking in pieces(self.record, t, t + h):
            own = value + slope * (begin - since)
            both = shaking._replace(value=shaking.value + own, slope=shaking.slope + slope)
            self.follow(both, begin, end)
            self.arrays.counts[0] = self.at_rest and not any(both[1:4])
            begin = end

    def observe(self, t: float) -> FloatArray:
        """The output row."""
        return self.seen

    def stand_on_base(self) -> None:
        """It does already: its base does not rotate."""

    def retune(self, model: Any) -> None:
        """Go on as this model."""
        self.model = model

    @property
    def counts(self) -> SimpleNamespace:
        """resting: whether it was at rest on a still base at the end of the last step; steps: made."""
        return SimpleNamespace(resting=int(self.arrays.counts[0]), steps=int(self.arrays.counts[1]))

    @property
    def fall_time(self) -> float:
        """When it fell, s; NaN: it has not."""
        when = float(self.arrays.state[-1])
        return math.nan if when == NOT_YET else when

    # --- on a base at rest (still_base.py)

    unclear = "still moves"

    @property
    def fallen(self) -> str:
        """What has."""
        return "" if math.isnan(self.fall_time) else f"the {self.model.kind.word}"

    def rest_until(self, t: float, end: float) -> None:
        """Without acceleration."""
        self.follow(Shaking(t, 0.0, 0.0), t, end)


class Driving(Kind):
    """A kind of such models: `stepper` follows one, `response` is the class of its results, with a table of outputs."""

    stepper: type[Driven]
    response: type[Any]

    def __init_subclass__(cls) -> None:
        cls.outputs = cls.response.outputs
        results = {"verdict": Kept(kind=np.uint8), "path": Kept(kind=np.uint8), "overturn_time": Kept("s", np.float64)}
        cls.kept = {**kept_peaks(cls.outputs), **results, "steps": Kept(kind=np.int64)}

    def single_run(self, model: Any, plan: Plan) -> tuple[Any, FloatArray]:
        """Follow the motion, and then the still base. Raises InputError, SolverError."""
        if plan.initial is not None:
            raise InputError(f"initial: must be left out, a {self.word} begins at rest")
        body, t, rows = self.stepper(model), plan.motion.start, []
        body.record, stop = plan.motion, t + plan.duration
        for time in plan.times.tolist():
            body.advance(t, time - t)
            rows.append(body.seen)
            t = time
            if plan.callback is not None:
                plan.callback(t, body)
        body.advance(t, stop - t)
        peaks = peaks_by_name(self.outputs, model.sizes, body.visible_peaks)
        verdict = settled(body, stop, plan.settle)
        stats = {"steps": body.counts.steps, "settled_for": verdict.time - stop}
        found = self.response(model, np.array(rows), time=plan.times, peaks=peaks, stats=stats, motion=plan.motion)
        found.verdict, found.reason, found.overturn_time = verdict.word, verdict.reason, body.fall_time
        return found, getattr(found, self.largest)
