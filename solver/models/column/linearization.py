"""The accelerations of a column held still in any position; it is in equilibrium if all are zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ...common.errors import InputError
from ...kernels.layout import spaces as at
from .model import Column
from .packing import FloatArray, settlements
from .stepper import Stepper

SHORT = 1e-9  # s, a fixed step that is stable; none is made


class StillColumn:
    """The accelerations of a column at rest in a given position, evaluated by the kernels.

    Coordinates q (2 n,) are those of the column's formulation: of the rotations, then of the openings. Raises
    InputError without gravity, as the joints are then open at rest.
    """

    def __init__(self, column: Column) -> None:
        if column.g == 0.0:
            raise InputError("g = 0.0: must be positive for joints that are in contact at rest")
        self.column = column.with_settings(step=SHORT) if column.kind.fixed else column
        self.n = column.n
        self._stepper = Stepper(self.column)
        self.arrays = self._stepper.arrays
        self.loads = np.zeros(len(at.LOAD) * len(column.ports))
        """On its ports, which it is held under: Fx of each, Fz (N), My (N m)."""
        self._phase = self._stepper.state.phase
        self._between = at.WORK.see(self._stepper.arrays.work, self.n).between
        self.blocks: Any = self._stepper.model.blocks
        self.rest = np.concatenate([self._phase.theta, self._phase.opening])
        """The coordinates under the weight alone, all joints in full contact, (2 n,)."""
        # rad: rotation of a joint at which it opens at rest
        opening_turn = float(np.min(2.0 * settlements(self.column) / self.blocks.width))
        turned, _ = column.kind.chain.coordinates(self.blocks.height, np.ones(self.n), self.rest[self.n :])
        self.sizes = opening_turn * np.concatenate([turned, self.blocks.open_size])
        """Approximate size of the coordinates at which the first joint opens, (2 n,)."""

    def accelerations(
        self, q: FloatArray, ax: float = 0.0, az: float = 0.0, rates: FloatArray | None = None
    ) -> FloatArray:
        """Return the second derivatives of the coordinates q, (2 n,).

        `ax` and `az` are the accelerations of the base (m/s2), `rates` the rates of the coordinates, zero by default.
        """
        self._observe(q, ax, az, rates)
        return np.concatenate([self._between.theta_acceleration, self._between.opening_acceleration])

    def row(self, q: FloatArray, ax: float = 0.0, rates: FloatArray | None = None) -> Any:
        """Return a copy of all outputs at q, by the names of kernels/layout/spaces.py, ROW."""
        return at.ROW.see(self._observe(q, ax, rates=rates).copy(), self.n)

    def stiffness(self, q: FloatArray, part: float, ax: float = 0.0) -> FloatArray:
        """Return M^-1 K, (2 n, 2 n): minus the derivatives of the accelerations by the coordinates.

        They are central differences over `part` of `sizes`, at q (2 n,), with the base acceleration ax (m/s2).
        """
        return self.derivatives(lambda change: self.accelerations(q + change, ax), part * self.sizes)

    def damping(self, q: FloatArray, part: float) -> FloatArray:
        """Return M^-1 C, (2 n, 2 n): minus the derivatives of the accelerations by the rates.

        They are central differences over `part` of `sizes`, divided by the largest damping (s), at least 1 s.
        """
        slowest = max(1.0, *(block.joint.damping for block in self.column.blocks))  # s
        return self.derivatives(lambda change: self.accelerations(q, rates=change), part / slowest * self.sizes)

    def derivatives(self, of: Callable[[FloatArray], FloatArray], changes: FloatArray) -> FloatArray:
        """Return minus the derivatives of a vector function, a column for each coordinate, from central differences."""
        columns = []
        for change, size in zip(np.diag(changes), changes, strict=True):
            columns.append((of(-change) - of(change)) / (2.0 * size))
        return np.array(columns).T

    def _observe(self, q: FloatArray, ax: float, az: float = 0.0, rates: FloatArray | None = None) -> FloatArray:
        n, phase = self.n, self._phase
        phase.theta[:], phase.opening[:] = q[:n], q[n:]
        phase.theta_rate[:], phase.opening_rate[:] = (0.0, 0.0) if rates is None else (rates[:n], rates[n:])
        self._stepper.drive(0.0, ax, az, 0.0, 0.0, 0.0, 0.0, 0.0, *self.loads, *np.zeros_like(self.loads))
        return self._stepper.observe(0.0)


def undamped(column: Column) -> Column:
    """Return the column without damping, its joints rigid in shear and not bonded."""
    return with_all_joints(column, damping=0.0, friction=None, dowel=None, tensile_strength=0.0, cohesion=0.0)


def stuck(column: Column) -> Column:
    """Return the column with joints that never slide and are not bonded."""
    return with_all_joints(column, friction=None, dowel=None, tensile_strength=0.0, cohesion=0.0)


def with_all_joints(column: Column, **changes: float | None) -> Column:
    """Return the column with other properties of all joints, by their names."""
    return replace(
        column,
        blocks=tuple(replace(block, joint=replace(block.joint, **changes)) for block in column.blocks),  # type: ignore
    )
