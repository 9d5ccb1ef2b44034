"""What is checked: the questions that a column in its plane and a structure in space answer differently."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..ground.motion import Motion
from ..models.column.model import Column
from ..models.structure.model import Structure
from ..models.structure.overlap import Overlap
from ..runs.table import Table

FloatArray = NDArray[np.float64]
Model = Column | Structure
Pair = tuple[Any, Motion]  # a model and its motion


@dataclass(frozen=True, eq=False)
class Joints:
    """Numbers of the joints that demands are compared with; NaN where there is none."""

    names: tuple[str, ...]
    width: FloatArray  # m
    strength: FloatArray  # Pa
    friction: FloatArray


class Subject(Protocol):
    """A column or a structure under a check. run: its response to one motion."""

    @property
    def model(self) -> Any: ...
    @property
    def joints(self) -> Joints: ...
    @property
    def yields(self) -> FloatArray:
        """Forces at which the ties yield, N; NaN where they do not."""

    @property
    def period(self) -> float:
        """Of the first mode about rest, s."""

    @property
    def longest(self) -> float:
        """Period when it rocks by 0.4 of what overturns it, s."""

    @property
    def edge(self) -> float:
        """Displacement of the top at which it balances without a push, m; NaN if there is no such number."""

    @property
    def two_ways(self) -> bool:
        """Whether a motion and its mirror image differ."""

    @property
    def of_model(self) -> tuple[str, ...]:
        """Sentences on what the model leaves out."""

    def left_to_others(self, both: bool) -> Iterable[str]:
        """Sentences on what is left to another check; both: the other direction is checked beside it."""

    def moved(self, run: Any) -> float:
        """Largest displacement, m."""

    def shear_ratio(self, run: Any) -> FloatArray:
        """Shear over compression of each joint, where it is compressed (rows, joints)."""

    def overlap(self, run: Any) -> Overlap | None:
        """Of blocks that no joint connects; None where there are none."""

    def to_vary(self, run: Any) -> Any:
        """The model that is varied around a run."""

    def tops(self, table: Table) -> FloatArray:
        """As `moved`, of a table of runs with the largest displacements."""

    def by_hand(self, action: Any, limits: Any) -> Any:
        """`ByHand` under an Action with Limits; None if there are no such methods."""

    def digest(self) -> bytes:
        """All numbers of the model."""
