"""The static capacity of a column: at rest, and under a steady horizontal acceleration up to overturning.

A base that accelerates steadily by a towards -x pushes every block by a times its mass towards +x. The equilibria of
the column under this push form a curve: from rest, over the largest acceleration that it balances, down to the
equilibrium on its edge without any push. push.py follows it.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..common.aliases import Alias
from ..common.errors import InputError, SolverError, check_number, check_type, needing, shown
from ..common.files import write_table
from ..common.frames import Frame, Framed
from ..ground.loads import pattern_of, push_unit
from ..models.column.linearization import StillColumn, undamped
from ..models.column.model import Column
from ..models.column.outputs import UNITS, ColumnHistories
from ..models.column.packing import FloatArray
from ..models.column.push import FOLLOWED, BalanceCurve
from ..models.column.rest import check_rest, instability, is_stable

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Rest:
    """The column under its weight alone, (n,) each, the top joint first."""

    model: Column
    settlement: FloatArray  # m, compression of each joint
    N: FloatArray  # N
    stress: FloatArray  # Pa, the largest in each joint
    contact: FloatArray  # part of its width
    column = Alias("model")


HISTORIES = ("ux", "uz", "ry", "N", "My", "Tx", "contact", "sigma_max")
OUTPUTS = tuple(getattr(ColumnHistories, name) for name in HISTORIES)


@dataclass(frozen=True, eq=False)
class CapacityCurve(Framed):
    """The m equilibria of a column under a steady horizontal acceleration, from rest to the edge.

    Histories (m, n) as in a `Response`: the top block and its joint first; the push is towards +x.
    """

    model: Column
    acceleration: FloatArray  # (m,) m/s2, of the base, towards -x
    base_shear: FloatArray  # (m,) N, reaction of the base to the push
    base_moment: FloatArray  # (m,) N m, about the middle of the lowest joint, clockwise on the base
    ux: FloatArray  # m, top faces
    uz: FloatArray  # m, centroids, up, from the unloaded geometry
    ry: FloatArray  # rad
    N: FloatArray  # N
    My: FloatArray  # N m
    Tx: FloatArray  # N, along the joint
    contact: FloatArray  # part of the width
    sigma_max: FloatArray  # Pa
    uplift: FloatArray  # (n,) m/s2, acceleration at which each joint begins to open; NaN if the column topples before
    direction: int  # 1, or -1 for the curve of pushes towards -x
    # loads on ports in place of an acceleration: then all pushes are factors on them
    pattern: Mapping[str, float] | None = None
    # reason why the curve ends before the push is zero again, as where loads lift the column; else empty
    ends: str = ""
    column, theta, M, T = Alias("model"), Alias("ry"), Alias("My"), Alias("Tx")

    def _frame(self) -> Frame:
        pushes = {"acceleration": "m/s2" if self.pattern is None else "1", "base_shear": "N", "base_moment": "N m"}
        columns = {name: getattr(self, name) for name in pushes}
        columns, units = columns | {one.key: getattr(self, one.field) for one in OUTPUTS}, pushes | UNITS
        return Frame(("place", np.arange(len(self.acceleration))), columns, units, {"column": self.model.name})

    @property
    def unit(self) -> tuple[float, str]:
        """The unit in which a push is shown: the divisor and its name."""
        return push_unit(self.pattern is not None)

    @property
    def towards(self) -> str:
        """The side to which the column is pushed, "+x" or "-x"."""
        return "+x" if self.direction > 0 else "-x"

    @property
    def strongest(self) -> int:
        """The row of the largest acceleration."""
        return int(np.argmax(self.acceleration))

    @property
    def largest_acceleration(self) -> float:
        """The largest steady acceleration that the column balances (m/s2)."""
        return float(self.acceleration[self.strongest])

    @property
    def limit(self) -> str:
        """The word for the largest push: "at most", or "at least" if the push still grows where the curve ends."""
        still_grows = self.ends.startswith(FOLLOWED) and self.strongest == len(self.acceleration) - 1
        return "at least" if still_grows else "at most"

    @property
    def overturning_displacement(self) -> float:
        """The top displacement (m) beyond which the column falls without a push; NaN if the curve ends before."""
        return math.nan if self.ends else float(abs(self.ux[-1, 0]))

    @property
    def friction(self) -> float:
        """The largest T / N of any joint up to the largest acceleration.

        With less friction the column slides before.
        """
        rows = slice(0, self.strongest + 1)
        shear, normal = np.abs(self.Tx[rows]), self.N[rows]
        # a joint that a load has lifted has neither force
        return float(np.max(np.divide(shear, normal, out=np.zeros_like(shear), where=shear > 0.0)))

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write a row for each equilibrium, under the names of a response. Raises OSError."""
        joints = [one for one in OUTPUTS if one.field != "uz"]
        names = ["acceleration" if self.pattern is None else "factor", "base.shear", "base.moment"]
        names += [one.name_of(i + 1) for one in joints for i in range(self.model.n)]
        parts = [self.acceleration[:, None], self.base_shear[:, None], self.base_moment[:, None]]
        rows = np.hstack([*parts, *(getattr(self, one.field) for one in joints)])
        write_table(path, names, ([repr(float(value)) for value in row] for row in rows))

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Draw the curve and the column, and save the picture to `path` if given.

        Raises InputError without matplotlib, OSError.
        """
        with needing("plot", "matplotlib"):
            from .static_plots import plot_capacity
        return plot_capacity(self, path)


def rest_of(column: Column) -> Rest:
    """Return settlement, force, stress and contact of the joints of a column at rest.

    Warns (InputWarning) as `simulate` does. Raises InputError without gravity.
    """
    check_type("column", column, Column)
    check_rest(column, from_rest=False)
    still = StillColumn(undamped(column.with_settings(formulation="exact")))
    joints = still.row(still.rest).joints
    return Rest(column, -still.rest[still.n :], *(getattr(joints, name) for name in ("N", "sigma_max", "contact")))


def uplift_accelerations(column: Column) -> FloatArray:
    """Return the steady base acceleration at which each joint begins to open (m/s2), (n,).

    It is NaN for a joint that stays closed until the column topples. Raises as `capacity_curve` does.
    """
    return capacity_curve(column).uplift


def curves_each_way(column: Column) -> list[CapacityCurve]:
    """Return the curve towards each side, the weaker first, or the one curve of a column on its axis.

    Warns and raises as `capacity_curve` does.
    """
    check_type("column", column, Column)
    curves = [capacity_curve(column, direction) for direction in ((1, -1) if column.off_axis else (1,))]
    return sorted(curves, key=lambda curve: curve.largest_acceleration)


def capacity_curve(column: Column, direction: int = 1, pattern: Mapping[str, float] | None = None) -> CapacityCurve:
    """Follow the equilibria of a column under a steady acceleration from rest to the edge, by finite rotations.

    No joint slides. Loads that lift the column, or never overturn it, have no such edge: `ends` is the reason why their
    curve ends. Warns (InputWarning) as `simulate` does.

    Parameters
    ----------
    column : Column
        The column.
    direction : int
        1 for a push towards +x, -1 towards -x.
    pattern : mapping, optional
        Loads on ports (N, N m), as {"roof.Fx": 1000.0}, that grow by a factor in place of the acceleration; then
        `acceleration` is the factor.

    Returns
    -------
    CapacityCurve
        The equilibria.

    Raises
    ------
    InputError
        Without gravity, or if the direction is another number.
    SolverError
        If the rest is not stable or the curve cannot be followed.
    """
    check_type("column", column, Column)
    if check_number("direction", direction, (-1.0, 1.0), "1 or -1") not in (1.0, -1.0):
        raise InputError(f"direction = {shown(direction)}: must be 1 or -1")
    if not column.g == 0.0 and not is_stable(column):
        raise SolverError(instability(column))
    check_rest(column, from_rest=False)
    loads = None if pattern is None else pattern_of(pattern, [port.name for port in column.ports])
    curve = BalanceCurve(undamped(column.with_settings(formulation="exact")), direction, loads)
    points = curve.follow()
    # histories along the curve, and the push at which each joint opens
    rows = [curve.row(point) for point in points]
    joints = {one.field: np.array([getattr(row.joints, one.key) for row in rows]) for one in OUTPUTS}
    pushes = np.array([point.push for point in points])
    opened = joints["contact"][: int(np.argmax(pushes)) + 1] < 1.0  # beyond the largest push nothing is at rest
    return CapacityCurve(
        column,
        pushes,
        np.array([direction * row.base.Fx for row in rows]),
        np.array([direction * row.base.My for row in rows]),
        **joints,
        uplift=np.where(np.any(opened, axis=0), pushes[np.argmax(opened, axis=0)], np.nan),
        direction=direction,
        pattern=None if pattern is None else dict(pattern),
        ends=curve.ends,
    )
