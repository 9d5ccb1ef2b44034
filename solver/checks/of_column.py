"""A column under a check: the subject that moves in one plane."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from ..models.column.model import Column
from ..models.column.modes import natural_frequencies
from ..models.column.packing import carried_weights
from ..models.column.push import WITHOUT_BONDS
from ..models.column.response import Response, friction_history
from ..models.column.rest import check_rest
from ..runs.table import Table
from ..statics.capacity import curves_each_way
from .action import Action
from .by_hand import ByHand, by_hand
from .kinematic import Mechanism
from .limits import Limits
from .spectra import FloatArray
from .subject import JointProperties, Subject, can_be_made, subject_of

# largest ratio of implicit to explicit steps of the run as given at which varied runs share lanes, however stiff the
# dampers. Measured (Phocas, doric, statue; eta 5e-4 to 2e-2 s; 0.04 to 0.6 g): 1.1 to 3.3 times as fast as one by one
# below this ratio, 0.2 to 1.4 times above it
MOST_IMPLICIT = 0.05

OF_EDGE = "The displacement at which it balances on its edge, and the methods by hand, are"
ROLLS = "Its contacts are round: in space they roll on their rims, and may fall under less than here"


@subject_of.register(Column)
@dataclass(frozen=True, eq=False)
class InPlane(Subject):
    """A column as subject of a check. Raises as `check_rest` does."""

    model: Column
    of_model = (
        "The column moves in one vertical plane. It does not twist, and no motion across the plane is applied.",
        "Once a column has fallen it is held; what it hits is not considered.",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_rest(self.model, from_rest=True)

    @property
    def planar(self) -> Column:
        return self.model

    @cached_property
    def joints(self) -> JointProperties:
        """The joints, from the top."""
        names = [f"joint {i}" for i in range(1, self.model.n + 1)]
        return JointProperties.of(names, [contact.width for contact in self.model.contacts], self.model.laws)

    @property
    def bonds(self) -> tuple[str, ...]:
        return self.joints.names if self.model.is_brittle else ()

    @cached_property
    def mechanism(self) -> Mechanism:
        """The overturning mechanism under a slow push, in the weaker direction. Raises as `capacity_curve` does."""
        return Mechanism(curves_each_way(self.model)[0], self.confidence_factor)

    @property
    def two_ways(self) -> bool:
        return self.model.off_axis

    @cached_property
    def period(self) -> float:
        return 1.0 / float(natural_frequencies(self.model)[0])

    @property
    def longest(self) -> float:
        """The period at 0.4 of the displacement on the edge (s; C8.7.1.10)."""
        return self.mechanism.period

    @property
    def edge(self) -> float:
        return self.mechanism.curve.overturning_displacement

    def deferred_points(self, both: bool) -> Iterator[str]:
        if not both and not self.model.is_alike_across:
            other = ": check the other direction too (--both)" if can_be_made(self.model.across) else ""
            yield f"It is shaken along its width alone{other}."
        if self.model.is_brittle:
            yield f"{OF_EDGE} {WITHOUT_BONDS}."
        if self.model.rolls_in_space:
            yield f"{ROLLS}{' (--space)' if can_be_made(self.model.in_space) else ''}."

    def moved(self, run: Response) -> float:
        return float(run.peak_top_ux[0])

    def shear_ratio(self, run: Response) -> FloatArray:
        return friction_history(run.Tx, run.N, carried_weights(run.model))

    def to_vary(self, run: Response) -> Column:
        column = self.model
        # without implicit steps, if the run took hardly any, so that the varied runs can share lanes
        steps, implicit, elastic = (int(run.stats[name]) for name in ("steps", "implicit_steps", "elastic_steps"))
        if implicit > MOST_IMPLICIT * (steps - implicit - elastic):
            return column
        return column.with_settings(without=(*column.settings.without, "implicit"))

    def tops(self, table: Table) -> FloatArray:
        return table.displacements[:, 0]

    def by_hand(self, action: Action, limits: Limits) -> ByHand:
        return by_hand(self.mechanism, self.period, action, limits)
