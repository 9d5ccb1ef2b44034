"""The limits that demands are compared with, and the options of a check; each has a stated default."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

from ..common.errors import POSITIVE, check_number, check_type, check_whole
from ..models.structure.convex import TOUCH
from ..models.uncertainty import Spread
from .kinematic import CONFIDENCE_FACTOR, LIFE_SAFETY

MOST_RUNS = 10_000

# error tolerance of the varied runs: peaks of eight drums under El Centro differ in the fourth digit from those at
# 1e-4; the spread of the data changes them by a fifth
TOLERANCE = 1e-3
# uncertainty of a real column, as standard deviations of logarithms: docs/check.md
UNCERTAIN = Spread(stiffness=0.2, damping=0.5, motion=0.01)


def _limit(default: float | None, meaning: str, least: float = 0.0, most: float = POSITIVE[1]) -> Any:
    """Return a dataclass field: a limit with its meaning (for messages, options, reports) and range; None: no limit."""
    return field(default=default, metadata={"meaning": meaning, "range": (least, most)})


@dataclass(frozen=True)
class Limits:
    """The capacities of the table of checks. Raises InputError for a value out of range."""

    share: float = _limit(0.0, "share of the runs that may fall", 0.0, 1.0)
    displacement: float = _limit(
        LIFE_SAFETY, "part of the displacement at which the column balances on its edge, of the top", 1e-3, 1.0
    )
    strength_factor: float = _limit(1.0, "the strength is divided by it", 0.1, 100.0)
    slip: float = _limit(0.05, "part of the width of the joint, of the largest slip", 0.0, 1.0)
    residual: float = _limit(0.02, "part of the width of the joint, of the slip that is left", 0.0, 1.0)
    overlap: float = _limit(TOUCH, "depth in m by which blocks that no joint connects may overlap", 0.0, 1.0)
    hits: float | None = _limit(None, "share of the runs that may hit a neighbour; not limited if not given", 0.0, 1.0)
    opening: float | None = _limit(None, "part of the width of the joint that may open; not limited if not given")
    friction: float | None = _limit(None, "coefficient of joints that have none in the column file", 1e-3, 10.0)

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if value is not None:
                low, high = item.metadata["range"]
                check_number(f"limits.{item.name}", value, (low, high), f"{item.metadata['meaning']}, from {low:g}")


@dataclass(frozen=True)
class Plan:
    """The options of a check: limits, ensemble, margin. Raises InputError for a value out of range."""

    limits: Limits = field(default_factory=Limits)
    ensemble: int = 8  # number of runs with varied data, per motion
    spread: Spread = UNCERTAIN
    margin: bool = True  # whether to compute the factor at which overturning begins
    confidence_factor: float = CONFIDENCE_FACTOR
    joints: bool = True  # whether to repeat all runs with other moduli and dampings (other_joints.py)

    def __post_init__(self) -> None:
        check_type("limits", self.limits, Limits)
        check_type("spread", self.spread, Spread)
        check_number("confidence_factor", self.confidence_factor, (1.0, 3.0), "a confidence factor from 1 to 3")
        check_whole("ensemble", self.ensemble, 1, MOST_RUNS, f"a number of runs from 1 to {MOST_RUNS}")
