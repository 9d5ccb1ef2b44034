"""The subject of a check: the interface behind which a check treats columns and structures alike."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import singledispatch
from typing import Any, ClassVar

import numpy as np

from ..common.errors import InputError, shown
from ..ground.motion import Motion
from ..models.column.model import Column
from ..models.structure.overlap import Overlap
from ..runs.table import Table
from ..statics.rocking import restitution_sentence
from .kinematic import CONFIDENCE_FACTOR
from .spectra import FloatArray

Pair = tuple[Any, Motion]  # a model and its motion
OF_BEARINGS = "peak_d"  # column of a table of runs


@dataclass(frozen=True, eq=False)
class JointProperties:
    """The properties of the joints that demands are compared with; NaN where a joint has none."""

    names: tuple[str, ...]
    width: FloatArray  # m
    strength: FloatArray  # Pa
    friction: FloatArray

    @classmethod
    def of(cls, names: Sequence[str], width: Sequence[float], laws: Sequence[Any]) -> JointProperties:
        """Create from names, widths (m) and laws; a strength of 0 counts as none."""
        strength = [law.strength or math.nan for law in laws]
        friction = [math.nan if law.friction is None else law.friction for law in laws]
        return cls(tuple(names), *map(np.array, (width, strength, friction)))


@dataclass(frozen=True, eq=False)
class Subject:
    """A model under check. The base class answers for a model without joints and ties.

    In its methods `run` is the response of the model to one motion.
    """

    model: Any
    confidence_factor: float = CONFIDENCE_FACTOR
    column: Column | None = None  # the column of which a structure is the model in space, if known
    of_model: ClassVar[tuple[str, ...]] = ()  # sentences on the effects that the model leaves out

    def __post_init__(self) -> None:
        if "peaks" in self.model.settings.without:
            raise InputError('solver.without has "peaks", must not in a check, which compares them')

    @property
    def planar(self) -> Column | None:
        """The column in its plane; None for a structure that is no column."""
        return self.column

    @property
    def joints(self) -> JointProperties:
        """The joints."""
        return JointProperties((), *np.empty((3, 0)))

    @property
    def yields(self) -> FloatArray:
        """The forces at which the ties yield (N); NaN for ties that do not."""
        return np.empty(0)

    @property
    def bearings(self) -> tuple[tuple[str, ...], FloatArray]:
        """The names of the bearings, and their displacement capacities (m)."""
        return (), np.empty(0)

    @property
    def neighbours(self) -> tuple[str, ...]:
        """The names of the pairs of neighbours that may hit each other."""
        return ()

    @property
    def bonds(self) -> tuple[str, ...]:
        """The names of the joints that bear tension or cohesion until they break."""
        return ()

    @property
    def period(self) -> float:
        """The period of the first mode about rest (s); 0 if nothing sways before it lifts."""
        return 0.0

    @property
    def longest(self) -> float:
        """The period (s) when it rocks by 0.4 of the overturning displacement."""
        return math.inf

    @property
    def isolated(self) -> float:
        """The longest period while all bearings slide or yield (s); 0 without bearings."""
        return 0.0

    @property
    def edge(self) -> float:
        """The displacement of the top at which it balances without a push (m); NaN if it is not defined."""
        return math.nan

    @property
    def restitution(self) -> str:
        """The sentence on the restitution of the model; "" without one."""
        return "" if self.planar is None else restitution_sentence(self.planar)

    @property
    def two_ways(self) -> bool:
        """True if a motion and its mirror image differ."""
        return False

    def deferred_points(self, both: bool) -> Iterable[str]:
        """Return sentences on the points that this check leaves to another.

        `both` is True if the other direction is checked as well.
        """
        return ()

    def moved(self, run: Any) -> float:
        """Return the largest displacement (m); for a column that of its top."""
        return float(np.max(run.displacements))

    def shear_ratio(self, run: Any) -> FloatArray:
        """Return shear over compression of each joint while it is compressed, (rows, joints)."""
        return np.empty((len(run.time), 0))

    def overlap(self, run: Any) -> Overlap | None:
        """Return the overlap of blocks that no joint connects; None if there are no such blocks."""
        return None

    def to_vary(self, run: Any) -> Any:
        """Return the model that is varied, given the run of the model as given."""
        return self.model

    def tops(self, table: Table) -> FloatArray:
        """Return the displacements of `moved` for each row of a table of runs (m)."""
        return np.max(table.displacements, axis=1)

    def by_hand(self, action: Any, limits: Any) -> Any:
        """Return `ByHand` under an Action with Limits; None if the methods do not apply."""
        return None

    def digest(self) -> bytes:
        """Return the bytes of all numbers of the model."""
        return json.dumps(self.model.to_dict(), sort_keys=True).encode()


@singledispatch
def subject_of(model: Any, confidence_factor: float = CONFIDENCE_FACTOR) -> Subject:
    """Return a model as subject of checks, as registered for its class (`subject_of.register`).

    Raises InputError if the class is not registered, SolverError if the model does not stand at rest.
    """
    registered = "; of another model its class must be known to subject_of (checks/subject.py)"
    more = registered if hasattr(model, "kind") else ""
    raise InputError(f"column = {shown(model)}: must be a Column or a Structure{more}")


def can_be_made(make: Callable[[], object]) -> bool:
    """Return True if a model can be made into another one: `make` raises no InputError."""
    try:
        make()
    except InputError:
        return False
    return True
