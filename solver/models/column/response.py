"""The result of a run: histories, peaks, verdict; as CSV and as a picture."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...common.aliases import Alias
from ...common.errors import NOT_NEGATIVE, InputError, check_number
from ...common.notebook import history, rows_of
from ...kernels.layout import spaces as at
from ..outputs import DIGITS
from ..response import Result
from ..uncertainty import PERCENTILES
from .kinematics import chain_of
from .model import Column
from .outputs import ColumnHistories
from .packing import FloatArray, carried_weights


@dataclass(eq=False, repr=False)
class Response(ColumnHistories, Result):
    """The result of a run: histories (nt, n), block and joint 1 (the top) first; base reaction (nt,).

    Histories are computed from the motion when one of them is first used, which may raise SolverError. Peaks are those
    of the continuous motion, independent of the rows. The verdict includes the time after the histories: a column that
    falls later has `overturned` and an `overturn_time` after the last row.

    Attributes
    ----------
    time
        The times of the rows (s).
    ux
        The displacement of the top face relative to the base, to +x (m).
    uz
        The displacement of the centroid, up, from the unloaded geometry (m).
    ry
        The rotation, clockwise (rad).
    N, My
        The normal force, in compression (N), and the moment, restoring (N m).
    S, Tx
        The forces of the part above on the part below: horizontal, and along the joint (N).
    contact
        The fraction of the joint's width in contact.
    sigma_max
        The largest pressure (Pa).
    slip
        The slip of the block relative to the body under it, to +x (m).
    base_Fx, base_Fz, base_My
        The forces (N) and the clockwise moment (N m) of the column on the base at the centre of joint n.
    peaks
        The largest absolute values by these names, (n,), or (1,) of the base reaction; the least of contact; friction:
        |T| / N where N is above 0.05 of the weight carried at rest. Those of ux only if the column is run without
        "peaks".
    overturned, overturn_time
        Whether and when (s, NaN if not) the column falls.
    fallen, what_fell
        The number of the block that falls over its joint (0 if none), and the same in words.
    stats
        steps, implicit_steps and elastic_steps (of these), why_no_modes (words; "" if elastic steps are taken while
        nothing opens or slides), rejected, events (steps cut off where the contact of a joint changes), evaluations,
        sweeps, looks (evaluations for peaks and snapshots, not counted in evaluations); full_contact, rocking, flight:
        fractions of the time; at_rest: fraction that was not stepped; undamped_joints; observed_rows; wall_time (s);
        settled_for (s): time that the column was followed after the histories' end.
    verdict, reason
        "overturned", "standing" (it cannot fall any more) or "undecided", and the reason as a sentence.
    estimated_error, horizon
        The estimate of the error (uncertainty.py) and the horizon of prediction (s); None unless the run was checked.
    ensemble
        The ensemble (uncertainty.py), None without one.
    motion
        The motion of the base, drawn above the histories.
    """

    model: Column
    _observe: Callable[[], FloatArray]  # returns the output rows (nt, ROW of layout/spaces.py)
    _phases: FloatArray  # as in kinematics.py, (nt, 4 n) or (nt, 6 n)
    column, overturned_joint, peak_ux = Alias("model"), Alias("fallen"), Alias("peak_top_ux")
    plot_column, velocity = Alias("plot_model"), Alias("top_vx")

    @property
    def top_ux(self) -> FloatArray:
        """The displacements of the top faces along x, relative to the base: ux, m (nt, n)."""
        return self.ux

    @property
    def centroid_ux(self) -> FloatArray:
        """The displacements of the centroids along x, relative to the base and from as built, m (nt, n)."""
        return chain_of(self.model).centroid_displacements(self._phases)

    @property
    def peak_top_ux(self) -> FloatArray:
        """The peaks of the displacements of the top faces along x, m (n,)."""
        return self.peaks["ux"]

    @property
    def peak_centroid_ux(self) -> FloatArray:
        """The largest displacements of the centroids along x in the rows, m (n,)."""
        return np.max(np.abs(self.centroid_ux), axis=0)

    @property
    def top_vx(self) -> FloatArray:
        """The horizontal velocities of the top faces relative to the base, the rates of ux, m/s (nt, n)."""
        return chain_of(self.model).top_velocities(self._phases)

    @property
    def opening(self) -> FloatArray:
        """The largest gap of each joint, at an edge of its contact, m (nt, n); 0 in full contact."""
        return chain_of(self.model).gaps(self._phases)

    @cached_property
    def energy(self) -> FloatArray:
        """The kinetic, elastic and gravitational energy of the relative motion above that at rest, J (nt,)."""
        return chain_of(self.model).energies(self._phases)

    def _lines(self) -> Iterable[Sequence[object]]:
        shown = {"ux": ("|ux| (mm)", 1e3), "N": ("N (kN)", 1e-3), "sigma_max": ("pressure (MPa)", 1e-6)}
        shown |= {"contact": ("least contact", 1.0), "friction": ("|T| / N", 1.0)}
        found = {head: scale * self.peaks[name] for name, (head, scale) in shown.items() if name in self.peaks}
        return rows_of({"peaks of block, joint": np.arange(1, self.model.n + 1), **found})

    def _picture(self) -> str:
        return history(self.time, 1e3 * self.ux[:, 0], "top (mm)")

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickle and copy: the histories, not the solver that computes them.

        Raises SolverError if they cannot be computed.
        """
        self.observe()
        return {name: value for name, value in vars(self).items() if name != "_observe"}

    def observe(self) -> None:
        """Compute all histories now. Raises SolverError if they cannot be computed."""
        self.rows  # noqa: B018

    @cached_property
    def rows(self) -> FloatArray:  # type: ignore[override]  # computed on access
        self.stats["observed_rows"] = len(self.time)
        return self._observe()

    def friction_demand(self, part: float = at.COUNTS_FROM) -> FloatArray:
        """Return the largest |T| / N of each joint over the rows, (n,), where N exceeds `part` of that at rest."""
        return np.max(self._friction(part), axis=0)

    def time_exceeded(self, mu: float, part: float = at.COUNTS_FROM) -> FloatArray:
        """Return the time for which each joint needs more friction than mu, s (n,); `part` as in `friction_demand`."""
        mu = check_number("mu", mu, NOT_NEGATIVE, "a coefficient of friction, zero or positive")
        over = self._friction(part) - mu
        first, last = over[:-1], over[1:]  # linear between rows
        change = np.abs(last - first)
        crossing = np.divide(np.maximum(first, last), change, out=np.zeros_like(change), where=change > 0.0)
        share = np.where(np.minimum(first, last) > 0.0, 1.0, np.where(np.maximum(first, last) > 0.0, crossing, 0.0))
        return np.diff(self.time) @ share

    def _friction(self, part: float) -> FloatArray:
        return friction_history(self.Tx, self.N, carried_weights(self.model), part)

    def to_csv(self, path: str | os.PathLike[str], digits: int = DIGITS) -> None:
        """Write every history under the name of the FMU's output, in the order of the FMU's outputs.

        With an ensemble, the percentiles of its ux follow as ensemble.block[i].ux.p16, p50, p84: nan after all have
        fallen. `digits` is the number of significant digits, 1 to 17; 17 give every float64 in full. Raises InputError
        for invalid `digits`, OSError.
        """
        behind: dict[str, FloatArray] = {}
        if self.ensemble is not None:
            for percent, band in zip(PERCENTILES, self.ensemble.ux, strict=True):
                behind |= {f"ensemble.block[{i}].ux.p{percent}": ux for i, ux in enumerate(band.T, start=1)}
        behind["overturned"] = (self.time >= self.overturn_time).astype(float)
        self._write(path, digits, {"time": self.time}, behind)


def friction_history(T: FloatArray, N: FloatArray, carried: FloatArray, part: float = at.COUNTS_FROM) -> FloatArray:
    """Return the friction needed to prevent sliding, |T| / N where N counts, else 0, (nt, n).

    N vanishes where a joint is about to open, and in flight the model still keeps the blocks in line: T / N has no
    meaning there. N counts if it is above `part`, from 0.001 to 1, of the weight carried at rest. T and N are in N,
    (nt, n), as is `carried`, (n,). Raises InputError unless part is in range and every joint carries a weight.
    """
    part = check_number("part", part, (1e-3, 1.0), "a part of the weight carried at rest, from 0.001 to 1")
    if not np.all(carried > 0.0):
        raise InputError("g = 0.0: must be positive for joints that carry a weight at rest")
    return np.where(part * carried < N, np.abs(T) / np.maximum(N, part * carried), 0.0)
