"""What is checked: the questions that models answer differently."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import singledispatch
from typing import Any, ClassVar

import numpy as np

from ..common.errors import InputError, shown
from ..ground.motion import Motion
from ..models.column.model import Column
from ..models.structure.overlap import Overlap
from ..runs.table import Table
from .kinematic import CONFIDENCE_FACTOR
from .spectra import FloatArray

Pair = tuple[Any, Motion]  # a model and its motion
OF_BEARINGS = "peak_d"  # in a table of runs


@dataclass(frozen=True, eq=False)
class Joints:
    """Numbers of the joints that demands are compared with; NaN where there is none."""

    names: tuple[str, ...]
    width: FloatArray  # m
    strength: FloatArray  # Pa
    friction: FloatArray

    @classmethod
    def of(cls, names: Sequence[str], width: Sequence[float], laws: Sequence[Any]) -> Joints:
        """From widths and laws; a strength of 0 is none."""
        strength = [law.strength or math.nan for law in laws]
        friction = [math.nan if law.friction is None else law.friction for law in laws]
        return cls(tuple(names), *map(np.array, (width, strength, friction)))


@dataclass(frozen=True, eq=False)
class Subject:
    """A model under a check; run: its response to one motion. As it stands: of a model without joints and ties."""

    model: Any
    confidence_factor: float = CONFIDENCE_FACTOR
    column: Column | None = None  # that a structure stands for in space, if known
    of_model: ClassVar[tuple[str, ...]] = ()  # sentences on what the model leaves out

    @property
    def planar(self) -> Column | None:
        """The column in its plane, None of a structure that is none."""
        return self.column

    @property
    def joints(self) -> Joints:
        """The joints."""
        return Joints((), *np.empty((3, 0)))

    @property
    def yields(self) -> FloatArray:
        """Forces at which the ties yield, N; NaN where they do not."""
        return np.empty(0)

    @property
    def bearings(self) -> tuple[tuple[str, ...], FloatArray]:
        """Names of the bearings, and the displacements that they allow, m."""
        return (), np.empty(0)

    @property
    def neighbours(self) -> tuple[str, ...]:
        """Names of the pairs of neighbours that may hit each other."""
        return ()

    @property
    def bonds(self) -> tuple[str, ...]:
        """Names of the joints that bear tension or cohesion until they break."""
        return ()

    @property
    def period(self) -> float:
        """Of the first mode about rest, s; 0 where nothing sways before it lifts."""
        return 0.0

    @property
    def longest(self) -> float:
        """Period when it rocks by 0.4 of what overturns it, s."""
        return math.inf

    @property
    def isolated(self) -> float:
        """Longest period while all bearings slide or yield, s; 0 without bearings."""
        return 0.0

    @property
    def edge(self) -> float:
        """Displacement of the top at which it balances without a push, m; NaN if there is no such number."""
        return math.nan

    @property
    def two_ways(self) -> bool:
        """Whether a motion and its mirror image differ."""
        return False

    def left_to_others(self, both: bool) -> Iterable[str]:
        """Sentences on what is left to another check; both: the other direction is checked beside it."""
        return ()

    def moved(self, run: Any) -> float:
        """Largest displacement, m; of a column that of its top."""
        return float(np.max(run.peaks[self.model.kind.largest]))

    def shear_ratio(self, run: Any) -> FloatArray:
        """Shear over compression of each joint, where it is compressed (rows, joints)."""
        return np.empty((len(run.time), 0))

    def overlap(self, run: Any) -> Overlap | None:
        """Of blocks that no joint connects; None where there are none."""
        return None

    def to_vary(self, run: Any) -> Any:
        """The model that is varied around a run."""
        return self.model

    def tops(self, table: Table) -> FloatArray:
        """As `moved`, of a table of runs with the largest displacements."""
        return np.max(table[f"peak_{self.model.kind.largest}"], axis=1)

    def by_hand(self, action: Any, limits: Any) -> Any:
        """`ByHand` under an Action with Limits; None if there are no such methods."""
        return None

    def digest(self) -> bytes:
        """All numbers of the model."""
        return json.dumps(self.model.to_dict(), sort_keys=True).encode()


@singledispatch
def subject_of(model: Any, confidence_factor: float = CONFIDENCE_FACTOR) -> Subject:
    """A model as subject of checks: what is registered for its class (`subject_of.register`).

    Raises InputError, and SolverError if it does not stand at rest.
    """
    registered = "; of another model its class must be known to subject_of (checks/subject.py)"
    more = registered if hasattr(model, "kind") else ""
    raise InputError(f"column = {shown(model)}: must be a Column or a Structure{more}")
