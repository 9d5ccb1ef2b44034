"""The result of a run: histories, peaks, verdict; as CSV and as a picture."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ...common.errors import NOT_NEGATIVE, InputError, check_number, needing
from ...common.notebook import history, rows_of
from ...kernels.layout import spaces as at
from ..outputs import DIGITS
from ..response import Result
from ..uncertainty import PERCENTILES
from .kinematics import chain_of
from .model import Column
from .outputs import ColumnHistories
from .packing import FloatArray, carried_weights

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(eq=False, repr=False)
class Response(ColumnHistories, Result):
    """Histories (nt, n), block and joint 1 (the top) first; base reaction (nt,).

    time (s); ux (m), top face relative to the base, +x; uz (m), centroid, up, from the unloaded geometry; theta (rad),
    clockwise; N (N), compression; M (N m), restoring; S (N), horizontal, and T (N), along the joint, of the part above
    on the part below; contact, 0..1 of the joint's width; sigma_max (Pa); slip (m), of the block relative to the body
    under it, to +x; Fx, Fz (N) and My (N m, clockwise), of the column on the base at the centre of joint n.

    peaks: largest absolute values of the continuous motion by these names, (n,), or (1,) of the base reaction; the
    least of contact; friction: |T| / N where N is above 0.05 of the weight carried at rest. They do not depend on the
    rows. A column that is run without "peaks" has those of ux only. peak_ux: peaks["ux"]. overturned, overturn_time (s,
    NaN if not), overturned_joint (0 if not).

    stats: steps, implicit_steps and elastic_steps (of these), why_no_modes (words; empty where elastic steps are taken
    while nothing opens or slides), rejected, events (steps cut off where the contact of a joint changes), evaluations,
    sweeps, looks (evaluations for peaks and snapshots, not counted in evaluations); full_contact, rocking, flight:
    parts of the time; at_rest: part that was not stepped; undamped_joints; observed_rows; wall_time (s); settled_for
    (s): time that the column was followed after the histories' end.

    verdict: "overturned", "standing" (it cannot fall any more) or "undecided"; reason: why, in words. It includes the
    time after the histories: a column that falls later has `overturned` and an `overturn_time` after the last row.
    estimated_error (uncertainty.py) and horizon (s): None unless the run was checked. ensemble (uncertainty.py): None
    without one. motion: of the base; drawn above the histories.

    Histories are computed from the motion when one of them is first used, which may raise SolverError.
    """

    column: Column
    _observe: Callable[[], FloatArray]  # returns the output rows (nt, ROW of layout/spaces.py)
    overturned_joint: int
    _phases: FloatArray  # as of kinematics.py, (nt, 4 n) or (nt, 6 n)

    @property
    def velocity(self) -> FloatArray:
        """Horizontal velocities of the top faces relative to the base, the rates of ux, m/s (nt, n)."""
        return chain_of(self.column).top_velocities(self._phases)

    @property
    def opening(self) -> FloatArray:
        """Largest gap of each joint, at an edge of its contact, m (nt, n); 0 where it is pressed all over."""
        return chain_of(self.column).gaps(self._phases)

    @cached_property
    def energy(self) -> FloatArray:
        """Kinetic, elastic and gravitational energy above that at rest, of the motion relative to the base, J (nt,)."""
        return chain_of(self.column).energies(self._phases)

    @property
    def _fall(self) -> str:
        return f"fell at {self.overturn_time:.4g} s over joint {self.overturned_joint}"

    def _lines(self) -> Iterable[Sequence[object]]:
        shown = {"ux": ("|ux| (mm)", 1e3), "N": ("N (kN)", 1e-3), "sigma_max": ("pressure (MPa)", 1e-6)}
        shown |= {"contact": ("least contact", 1.0), "friction": ("|T| / N", 1.0)}
        found = {head: scale * self.peaks[name] for name, (head, scale) in shown.items() if name in self.peaks}
        return rows_of({"peaks of block, joint": np.arange(1, self.column.n + 1), **found})

    def _picture(self) -> str:
        return history(self.time, 1e3 * self.ux[:, 0], "top (mm)")

    def __getstate__(self) -> dict[str, Any]:
        """For pickle and copy: the histories themselves, not the solver that computes them. Raises SolverError."""
        self.observe()
        return {name: value for name, value in vars(self).items() if name != "_observe"}

    def observe(self) -> None:
        """Compute all histories now. Raises SolverError."""
        self.rows  # noqa: B018

    @cached_property
    def rows(self) -> FloatArray:  # type: ignore[override]  # computed on access
        self.stats["observed_rows"] = len(self.time)
        return self._observe()

    @property
    def model(self) -> Column:
        """The column."""
        return self.column

    def friction_demand(self, part: float = at.COUNTS_FROM) -> FloatArray:
        """Largest |T| / N of each joint over the rows, (n,), where N is above `part` of the weight carried."""
        return np.max(self._friction(part), axis=0)

    def time_exceeded(self, mu: float, part: float = at.COUNTS_FROM) -> FloatArray:
        """Time for which each joint needs more friction than mu, s (n,); N as in `friction_demand`."""
        mu = check_number("mu", mu, NOT_NEGATIVE, "a coefficient of friction, zero or positive")
        over = self._friction(part) - mu
        first, last = over[:-1], over[1:]  # linear between rows
        change = np.abs(last - first)
        crossing = np.divide(np.maximum(first, last), change, out=np.zeros_like(change), where=change > 0.0)
        share = np.where(np.minimum(first, last) > 0.0, 1.0, np.where(np.maximum(first, last) > 0.0, crossing, 0.0))
        return np.diff(self.time) @ share

    def _friction(self, part: float) -> FloatArray:
        return friction_history(self.T, self.N, carried_weights(self.column), part)

    def to_csv(self, path: str | os.PathLike[str], digits: int = DIGITS) -> None:
        """Write every history under the name of the FMU's output, in the order of the FMU's outputs.

        digits: significant ones of every number, 1 to 17; 17 give every float64 in full.
        With an ensemble, the percentiles of its ux follow as ensemble.block[i].ux.p16, p50, p84: nan after all have
        fallen.
        """
        behind: dict[str, FloatArray] = {}
        if self.ensemble is not None:
            for percent, band in zip(PERCENTILES, self.ensemble.ux, strict=True):
                behind |= {f"ensemble.block[{i}].ux.p{percent}": ux for i, ux in enumerate(band.T, start=1)}
        behind["overturned"] = (self.time >= self.overturn_time).astype(float)
        self._write(path, digits, {"time": self.time}, behind)

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Draw ground motion, displacements, rotations, forces and contact over time; saved to `path` if given.

        Raises InputError without matplotlib (the extra `plot`).
        """
        with needing("plot", "matplotlib"):
            from ...plotting.plots import plot_response
        return plot_response(self, path)

    def plot_column(
        self, path: str | os.PathLike[str] | None = None, at: float | None = None, scale: float | None = None
    ) -> Figure:
        """Draw the deformed column at time `at`, s (None: its peak), deformation times `scale` (None: chosen).

        Raises InputError without matplotlib (the extra `plot`).
        """
        with needing("plot", "matplotlib"):
            from ...plotting.drawings import plot_column
        return plot_column(self, path, at, scale)

    def film(
        self,
        path: str | os.PathLike[str],
        scale: float | None = None,
        fps: int = 20,
        speed: float = 1.0,
        callback: Callable[[int, int], object] | None = None,
    ) -> None:
        """Write a film of the column, a GIF or, if ffmpeg is installed, an MP4; `speed`: s of motion in a s of film.

        callback: is given the number of pictures made, and of all.
        Raises InputError without matplotlib (the extra `plot`).
        """
        with needing("plot", "matplotlib"):
            from ...plotting.film import film
        film(self, path, scale, fps, speed, callback)


def friction_history(T: FloatArray, N: FloatArray, carried: FloatArray, part: float = at.COUNTS_FROM) -> FloatArray:
    """Friction needed to prevent sliding: |T| / N of forces of the joints (nt, n), N, else 0; (nt, n).

    N vanishes where a joint is about to open, and in flight the model still keeps the blocks in line: T / N has no
    meaning there. N counts where it is above `part` of the weight carried at rest, N (n,).

    Raises InputError unless part is from 0.001 to 1 and every joint carries something.
    """
    part = check_number("part", part, (1e-3, 1.0), "a part of the weight carried at rest, from 0.001 to 1")
    if not np.all(carried > 0.0):
        raise InputError("g = 0.0: must be positive for joints that carry a weight at rest")
    return np.where(part * carried < N, np.abs(T) / np.maximum(N, part * carried), 0.0)
