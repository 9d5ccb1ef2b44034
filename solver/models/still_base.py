"""The verdict on a run: a model is followed on a still base until it has fallen or cannot fall any more."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, Protocol

from ..common.errors import SolverError
from .protocol import OVERTURNED, STANDING, UNDECIDED, Verdict

BETWEEN_LOOKS = 0.25  # s, interval of checks after the motion by default


class Settling(Protocol):
    """A model in motion whose base has come to rest."""

    @property
    def fallen(self) -> int:
        """The number of the block that has fallen; 0 without a fall."""

    @property
    def what_fell(self) -> str:
        """The parts that have fallen, in words, such as "block 2 over joint 2"; "" without a fall."""

    @property
    def fall_time(self) -> float:
        """The time of the fall (s); NaN without a fall."""

    @property
    def unclear(self) -> str:
        """The predicate for a model that neither falls nor surely stands."""

    @abstractmethod
    def why_it_stands(self) -> str:
        """Return the reason why it cannot fall any more; "" if it may."""

    def next_look(self, t: float, stop: float, settle: float) -> float:
        """Return the time of the next check after time t (s), at most stop + settle."""
        return min(t + BETWEEN_LOOKS, stop + settle)

    def rest_until(self, t: float, end: float) -> object:
        """Advance from t to `end` (s) on a still base.

        Raises SolverError.
        """


def settled(model: Settling, stop: float, settle: float) -> Verdict:
    """Determine the verdict on a run that ended at time `stop` (s), after at most `settle` (s) on a still base."""
    t = stop
    # alternate checks of the energy and pieces of motion
    while not model.what_fell:
        why = model.why_it_stands()
        if why:
            return Verdict(STANDING, why, t)
        if not t < stop + settle:
            return Verdict(UNDECIDED, f"{settle:g} s after the end it {model.unclear}", t)
        end = model.next_look(t, stop, settle)
        try:
            model.rest_until(t, end)
        except SolverError as failure:
            return Verdict(UNDECIDED, f"after the end, {failure}", t)
        t = end
    later = model.fall_time - stop
    when = f"{later:.4g} s after the end of the run" if later > 0.0 else "within the run"
    return Verdict(OVERTURNED, f"{model.what_fell}, {when}", max(t, stop))


def conclude(response: Any, model: Settling, stop: float, settle: float) -> None:
    """Determine the verdict on a run, and enter it and the fall into its response; the rest as in `settled`."""
    verdict = settled(model, stop, settle)
    response.verdict, response.reason = verdict.word, verdict.reason
    response.fallen, response.what_fell, response.overturn_time = model.fallen, model.what_fell, model.fall_time
    response.stats["settled_for"] = verdict.time - stop
