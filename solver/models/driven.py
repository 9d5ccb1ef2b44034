"""Models that are stepped in Python, from call to call: over a motion, and by their FMUs."""

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
from .protocol import OF_RUN, Kept, Kind, RunPlan, kept_peaks
from .still_base import Settling, conclude

NOT_YET = -1.0  # s, the value that stands for no fall
INPUTS = 2  # the acceleration of the base and its slope


class Shaking(NamedTuple):
    """The acceleration of the base in one interval: a line plus a harmonic."""

    begin: float  # s, at which the line has its value
    value: float  # m/s2
    slope: float  # m/s3
    amplitude: float = 0.0  # m/s2, of the harmonic
    omega: float = 0.0  # rad/s
    start: float = 0.0  # s, of its zero phase

    def at(self, t: float) -> float:
        """Return the acceleration at time t (m/s2)."""
        wave = self.amplitude * math.sin(self.omega * (t - self.start))
        return self.value + self.slope * (t - self.begin) + wave


def pieces(motion: Motion | None, t: float, end: float) -> Iterator[tuple[float, Shaking]]:
    """Yield the end of each interval of a motion from t to `end` (s), and its shaking; zero beyond the motion."""
    if motion is None:
        yield end, Shaking(t, 0.0, 0.0)
        return
    times = motion.time
    inner = times[(times > t) & (times < end)].tolist()
    if motion.hold and t < motion.end < end:  # the last held sample ends with the motion
        inner.append(motion.end)
    marks = [t, *inner, end]
    for begin, stop in pairwise(marks):
        k = int(np.searchsorted(times, begin, side="right")) - 1
        value = slope = 0.0
        if k >= 0 and motion.hold and begin < motion.end:
            value = float(motion.ax[k])
        elif 0 <= k < len(times) - 1 and not motion.hold:
            slope = float((motion.ax[k + 1] - motion.ax[k]) / (times[k + 1] - times[k]))
            value = float(motion.ax[k]) + slope * (begin - float(times[k]))
        amplitude = motion.amplitude if motion.start <= begin < motion.end else 0.0
        yield stop, Shaking(begin, value, slope, amplitude, 2.0 * math.pi * motion.frequency, motion.start)


class Driven(Settling):
    """A model between two calls; the caller owns the time.

    Its whole state is in `arrays`, and copying them saves it: `state` (the last number is the time of the fall, s),
    `counts` and `base` (inputs and their time, s). A subclass defines `size`, `follow`, `at_rest`, `seen`,
    `visible_peaks` and `why_it_stands`.
    """

    size = 0  # length of the state without the time of the fall

    def __init__(self, model: Any) -> None:
        self.model = model
        state, counts, base = np.zeros(self.size + 1), np.zeros(2, np.int64), np.zeros(1 + INPUTS)
        self.arrays = SimpleNamespace(state=state, counts=counts, base=base)
        self.arrays.state[-1] = NOT_YET
        self.record: Motion | None = None  # followed in addition to the inputs

    def follow(self, shaking: Shaking, t: float, end: float) -> None:
        """Advance from t to `end` (s) in one interval of the motion.

        Raises SolverError.
        """
        raise NotImplementedError

    @property
    def at_rest(self) -> bool:
        """True if nothing moves."""
        raise NotImplementedError

    @property
    def seen(self) -> FloatArray:
        """The output row."""
        raise NotImplementedError

    @property
    def visible_peaks(self) -> FloatArray:
        """The extremes so far, in the order of the outputs."""
        raise NotImplementedError

    def drive(self, t: float, *inputs: float, since: float | None = None) -> None:
        """Set the acceleration of the base (m/s2) and its slope (m/s3), given for time `since` (s); None means t."""
        self.arrays.base[:] = t if since is None else since, *inputs

    def advance(self, t: float, h: float) -> None:
        """Advance from t to t + h (s).

        Raises SolverError.
        """
        since, value, slope = self.arrays.base.tolist()
        begin = t
        for end, shaking in pieces(self.record, t, t + h):
            own = value + slope * (begin - since)
            both = shaking._replace(value=shaking.value + own, slope=shaking.slope + slope)
            self.follow(both, begin, end)
            self.arrays.counts[0] = self.at_rest and not any(both[1:4])
            begin = end

    def observe(self, t: float) -> FloatArray:
        """Return the output row at time t."""
        return self.seen

    def stand_on_base(self) -> None:
        """Do nothing: the base cannot rotate."""

    def retune(self, model: Any) -> None:
        """Replace the model and continue from the present state."""
        self.model = model

    @property
    def counts(self) -> SimpleNamespace:
        """The counts: `resting`, whether it was at rest on a still base at the end of the last step, and `steps`."""
        return SimpleNamespace(resting=int(self.arrays.counts[0]), steps=int(self.arrays.counts[1]))

    @property
    def fall_time(self) -> float:
        when = float(self.arrays.state[-1])
        return math.nan if when == NOT_YET else when

    # --- on a base at rest (still_base.py)

    unclear = "still moves"

    @property
    def fallen(self) -> int:
        return int(not math.isnan(self.fall_time))

    @property
    def what_fell(self) -> str:
        return f"the {self.model.kind.word}" if self.fallen else ""

    def rest_until(self, t: float, end: float) -> None:
        self.follow(Shaking(t, 0.0, 0.0), t, end)


class Driving(Kind):
    """A kind of models that are stepped in Python."""

    stepper: type[Driven]  # steps a model
    response: type[Any]  # of the results, with a table of outputs

    def __init_subclass__(cls) -> None:
        cls.outputs = cls.response.outputs
        cls.kept = {**kept_peaks(cls.outputs), **OF_RUN, "fallen": Kept(kind=np.int64)}

    def single_run(self, model: Any, plan: RunPlan) -> tuple[Any, FloatArray]:
        """Follow a model through the motion, then on the still base.

        Raises InputError if the plan has an initial state, SolverError.
        """
        if plan.initial is not None:
            raise InputError(f"initial: must be left out, a {self.word} begins at rest")
        body, t, rows = self.stepper(model), plan.motion.start, []
        body.record, stop = plan.motion, t + plan.duration
        for time in plan.times.tolist():
            # rows at the times of the plan
            body.advance(t, time - t)
            rows.append(body.seen)
            t = time
            if plan.callback is not None:
                plan.callback(t, body)
        body.advance(t, stop - t)
        peaks, stats = peaks_by_name(self.outputs, model.sizes, body.visible_peaks), {"steps": body.counts.steps}
        found = self.response(model, np.array(rows), time=plan.times, peaks=peaks, stats=stats, motion=plan.motion)
        # the verdict, on a still base
        conclude(found, body, stop, plan.settle)
        return found, getattr(found, self.largest)
