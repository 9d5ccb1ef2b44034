"""The verdict on a run: a model is followed on a still base until it has fallen or cannot fall any more."""

from __future__ import annotations

from abc import abstractmethod
from typing import Protocol

from ..common.errors import SolverError
from .protocol import OVERTURNED, STANDING, UNDECIDED, Verdict

BETWEEN_LOOKS = 0.25  # s, after the motion, where a model does not know better


class Settling(Protocol):
    """A model in motion whose base has come to rest."""

    @property
    def fallen(self) -> str:
        """What has fallen, or over what; "" if nothing has."""

    @property
    def fall_time(self) -> float:
        """When it fell, s."""

    @property
    def unclear(self) -> str:
        """What is said of it where it neither falls nor surely stands."""

    @abstractmethod
    def why_it_stands(self) -> str:
        """Why it cannot fall any more; "" if it may."""

    def next_look(self, t: float, stop: float, settle: float) -> float:
        """When to look again after time t, s; stop + settle at most."""
        return min(t + BETWEEN_LOOKS, stop + settle)

    def rest_until(self, t: float, end: float) -> object:
        """Follow it from t to `end`, s. Raises SolverError."""


def settled(model: Settling, stop: float, settle: float) -> Verdict:
    """The verdict on a run that ended at time `stop`, s, found `settle` s later at most."""
    t = stop
    while not model.fallen:
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
    return Verdict(OVERTURNED, f"{model.fallen}, {when}", max(t, stop))
