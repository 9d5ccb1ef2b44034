"""Push-over: a structure under a steady acceleration of its base that grows."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...common.errors import FINITE, InputError, check_number, check_type
from ...common.notebook import NotebookRepr, counted, history, rows_of
from ...ground.loads import pattern_of, push_unit
from ..outputs import DIGITS
from ..pictures import draw
from .blocks.faces import FloatArray
from .equilibria import (
    FELL,
    FOLLOWED,
    FURTHER,
    LOST,
    NO_ROOM_LEFT,
    EquilibriumPath,
    Place,
    bears_at_rest,
    has_opened,
    has_slid,
)
from .model import Structure
from .outputs import StructureHistories

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class PushOver(StructureHistories, NotebookRepr):
    """A structure under a growing push, from rest to the largest push that it balances.

    The histories are those of a `SpatialResponse` (ux, rotation, N, contact, base, ...), with a row for each point of
    the path; `displacement` returns those of a point of a block.

    Attributes
    ----------
    direction
        Direction of the push, rad from x to y; the base accelerates the other way.
    vertical
        Upward part of the push relative to the horizontal one.
    acceleration
        (rows,) horizontal push over the mass, m/s2; the first is 0.
    uplift, sliding
        Push at which the first of the joints that bear at rest opens, if it was closed, and at which the first one
        slides, m/s2; NaN if none.
    uplift_joint, sliding_joint
        Names of these joints.
    jumps
        Pushes beyond which it tips, slides or cracks on until a slack tie, a neighbour, the ring of a bearing or what a
        crack has left bears it, or at which a bond breaks suddenly, m/s2.
    ends
        Reason why the path ends.
    pattern
        Loads on ports applied in place of an acceleration, or None; with loads, all pushes are factors on them.
    """

    def __init__(
        self,
        structure: Structure,
        direction: float,
        vertical: float,
        places: Sequence[Place],
        pattern: Mapping[str, float] | None = None,
    ) -> None:
        self.model, self.direction, self.vertical = structure, direction, vertical
        self.pattern = None if pattern is None else dict(pattern)
        self.acceleration: FloatArray = np.array([place.push for place in places])
        self.rows: FloatArray = np.array([place.row for place in places])
        self.uplift, self.uplift_joint = self._first(self.opened)
        self.sliding, self.sliding_joint = self._first(self.slides)
        self.jumps: FloatArray = np.empty(0)
        self.ends = ""

    def _first(self, found: NDArray[np.bool_]) -> tuple[float, str]:
        rows, joints = np.nonzero(found & bears_at_rest(self.N[0], self.model.weight))
        if not rows.size:
            return math.nan, ""
        return float(self.acceleration[rows[0]]), self.model.joint_names[joints[0]]

    @property
    def opened(self) -> NDArray[np.bool_]:
        """The mask of joints, closed at rest, that are partly open, (rows, joints)."""
        return has_opened(self.contact, self.contact[0])

    @property
    def slides(self) -> NDArray[np.bool_]:
        """The mask of joints that have slid since rest, (rows, joints)."""
        moved = self.rows[:, : 3 * self.model.n] - self.rows[0, : 3 * self.model.n]
        return has_slid(self.slip - self.slip[0], self.contact, np.max(np.abs(moved), axis=1, keepdims=True))

    @property
    def unit(self) -> tuple[float, str]:
        """The unit in which pushes are shown: its size and its name."""
        return push_unit(self.pattern is not None)

    @property
    def largest_acceleration(self) -> float:
        """The largest push that the structure balances (m/s2)."""
        return float(self.acceleration[-1])

    @property
    def limit(self) -> str:
        """The word for the largest push: "at most", or "at least" if the path was not followed to its end."""
        if self.ends.startswith((FURTHER, FOLLOWED)):
            return "at least"
        return "at most, as far as found" if self.ends in (LOST, FELL) else "at most"

    @property
    def moves_most(self) -> int:
        """The index of the block whose centroid is displaced most by the largest push."""
        moved = self.rows[-1, : 3 * self.model.n] - self.rows[0, : 3 * self.model.n]
        return int(np.argmax(np.linalg.norm(moved.reshape(3, -1), axis=0)))

    @property
    def moved(self) -> FloatArray:
        """The distance of the block that moves most from its position at rest, m (rows,)."""
        path = self.displacement(self.moves_most)
        return np.linalg.norm(path - path[0], axis=1)

    def _facts(self) -> tuple[str, ...]:
        size, unit = self.unit
        towards = "by loads" if self.pattern else f"towards {math.degrees(self.direction):.4g} degrees"
        facts = [f"of {self.model.name}", towards]
        for word, push in (("opens", self.uplift), ("slides", self.sliding)):
            facts += [f"{word} from {push / size:.4g} {unit} on"] if math.isfinite(push) else []
        facts.append(f"{self.largest_acceleration / size:.4g} {unit} {self.limit}")
        return *facts, counted(len(self.rows), "place")

    def _lines(self) -> Iterable[Sequence[object]]:
        shown = {"contact at rest": self.contact[0], "at the end": self.contact[-1]}
        return rows_of({"joint": np.array(self.model.joint_names), **shown})

    def _picture(self) -> str:
        size, unit = self.unit
        return history(1e3 * self.moved, self.acceleration / size, f"push ({unit})")

    def to_csv(self, path: str | os.PathLike[str], digits: int = DIGITS) -> None:
        """Write a row for each point of the path, with the names of a SpatialResponse. Raises InputError, OSError."""
        self._write(path, digits, {"acceleration" if self.pattern is None else "factor": self.acceleration})

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Draw the push over the displacement, and the structure at its largest push; saved to `path` if given.

        Raises InputError without matplotlib (the extra `plot`), OSError.
        """
        return draw(self, "plot_push_over", path)


def push_over(
    structure: Structure, direction: float = 0.0, vertical: float = 0.0, pattern: Mapping[str, float] | None = None
) -> PushOver:
    """Push a structure by a steady acceleration that grows from zero to the largest one that it balances.

    The largest push, the first opening and the first sliding are found to 1e-4 of a step or better. The path ends where
    a bearing has moved by its capacity, since what stands on it comes off there.

    Beyond a largest push the structure tips, slides or cracks on, perhaps until a slack tie, a neighbour, the ring of
    a bearing or what a crack has left bears it. Then the path jumps to the place at which it balances more than that
    push, and goes on to the largest push of all. A bond that breaks suddenly, and leaves its force to others, is a jump
    too. The largest push is that under a slowly growing one if neither the impact at the end of a jump nor the
    overshoot after it breaks or overturns anything: that energy does not count. Of walls of mortar with 1.6 % of
    critical damping some fell 17 % below it, with 3 % none. Raises InputError if a value is wrong, or if the structure
    has no weight or no stable rest.

    Parameters
    ----------
    direction : float
        Direction of the push, rad from x to y.
    vertical : float
        Upward part of the push relative to the horizontal one.
    pattern : mapping or None
        Loads on ports in place of the acceleration, as {"roof.Fx": 1000.0} (N, N m); then their factor grows, and
        `acceleration` is that factor. Without direction and vertical.
    """
    check_type("structure", structure, Structure)
    check_number("direction", direction, FINITE, "an angle in rad")
    check_number("vertical", vertical, FINITE, "a ratio, upwards positive")
    if not structure.weight > 0.0:
        raise InputError(f"{structure.name}: g = {structure.g}: must be positive, without weight nothing stands")
    if pattern is not None and (direction or vertical):
        raise InputError("pattern: must be given without direction and vertical, loads take the place of the push")
    loads = None if pattern is None else pattern_of(pattern, [port.name for port in structure.ports])
    path = EquilibriumPath(structure, np.array([math.cos(direction), math.sin(direction), float(vertical)]), loads)
    ends = path.follow()
    if path.stepper.without_room:
        raise InputError(f"{structure.name}: {NO_ROOM_LEFT}")
    found = PushOver(structure, float(direction), float(vertical), path.places, pattern)
    found.ends, found.jumps = ends, np.array(path.jumps)
    return found
