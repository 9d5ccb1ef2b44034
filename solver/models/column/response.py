"""The result of a run: histories, peaks, verdict; as CSV and as a picture."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ...common.errors import check_whole, needing
from ...common.files import write_table
from ...common.frames import Frame, Framed
from ...common.notebook import Shown, counted, history, rows_of
from ...ground.motion import Motion
from ...kernels.layout import spaces as at
from ..uncertainty import PERCENTILES, Ensemble, ErrorEstimate
from .friction import friction_demand, time_exceeded
from .model import Column
from .packing import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DIGITS = 9  # significant ones of histories as text: far more than a run is exact to
MOST_DIGITS = 17  # with which every float64 is read back to the bit
# names of the histories of blocks and joints -> names among the outputs of the FMU, in their order there
BLOCK_HISTORIES = {
    name: f"{'block' if name in ('ux', 'uz', 'theta') else 'joint'}[{{i}}].{name}" for name in at.OUTPUTS.fields
}
BASE_HISTORIES = {name: f"base.{name}" for name in at.REACTION.fields}
UNITS = dict.fromkeys(("ux", "uz", "slip"), "m") | dict.fromkeys(("N", "S", "T", "Fx", "Fz"), "N")
UNITS |= {"time": "s", "theta": "rad", "M": "N m", "My": "N m", "sigma_max": "Pa"}
# names of `Response.peaks` -> names among the outputs of the FMU, in the order of the kernels (layout/spaces.py, PEAKS)
PEAKS = {name: f"{output}_{'least' if name == 'contact' else 'peak'}" for name, output in BLOCK_HISTORIES.items()}
PEAKS |= {name: f"{output}_peak" for name, output in BASE_HISTORIES.items()} | {"friction": "joint[{i}].friction_peak"}


def check_digits(key: str, digits: int) -> int:
    """Return a number of significant digits, 1 to 17. Raises InputError."""
    return check_whole(key, digits, 1, MOST_DIGITS, f"a whole number from 1 to {MOST_DIGITS}")


@dataclass(eq=False, repr=False)
class Response(Framed, Shown):
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
    without one.

    Histories are computed from the motion when one of them is first used, which may raise SolverError.
    """

    column: Column
    time: FloatArray
    _observe: Callable[[], FloatArray]  # returns the output rows (nt, ROW of layout/spaces.py)
    peaks: dict[str, FloatArray]
    overturned_joint: int
    overturn_time: float
    stats: dict[str, Any]
    verdict: str = "undecided"
    reason: str = ""
    estimated_error: ErrorEstimate | None = None
    horizon: float | None = None
    ensemble: Ensemble | None = None
    motion: Motion | None = None  # of the base; drawn above the histories

    def _facts(self) -> tuple[str, ...]:
        facts = [f"of {self.column.name}", self.verdict, f"{1e3 * float(np.max(self.peak_ux)):.4g} mm at most"]
        if self.overturned:
            facts.append(f"fell at {self.overturn_time:.4g} s over joint {self.overturned_joint}")
        if self.ensemble is not None:
            facts.append(f"{self.ensemble.overturned} of {self.ensemble.size} varied columns overturned")
        return *facts, counted(len(self.time), "row")

    def _lines(self) -> Iterable[Sequence[object]]:
        shown = {"ux": ("|ux| (mm)", 1e3), "N": ("N (kN)", 1e-3), "sigma_max": ("pressure (MPa)", 1e-6)}
        shown |= {"contact": ("least contact", 1.0), "friction": ("|T| / N", 1.0)}
        found = {head: scale * self.peaks[name] for name, (head, scale) in shown.items() if name in self.peaks}
        return rows_of({"peaks of block, joint": np.arange(1, self.column.n + 1), **found})

    def _picture(self) -> str:
        return history(self.time, 1e3 * self.ux[:, 0], "top (mm)")

    def _frame(self) -> Frame:
        columns = {name: getattr(self, name) for name in (*BLOCK_HISTORIES, *BASE_HISTORIES)}
        return Frame(("time", self.time), columns, UNITS, {"column": self.column.name, "verdict": self.verdict})

    def __getstate__(self) -> dict[str, Any]:
        """For pickle and copy: the histories themselves, not the solver that computes them. Raises SolverError."""
        self.observe()
        return {name: value for name, value in vars(self).items() if name != "_observe"}

    def observe(self) -> None:
        """Compute all histories now. Raises SolverError."""
        self._rows  # noqa: B018  computed on access

    @cached_property
    def _rows(self) -> FloatArray:
        self.stats["observed_rows"] = len(self.time)
        return self._observe()

    def _joints(self, name: str) -> FloatArray:
        n = self.column.n
        field = at.OUTPUTS.fields.index(name)
        return self._rows[:, field * n : (field + 1) * n]

    def _base(self, name: str) -> FloatArray:
        return self._rows[:, at.OUTPUTS.size(self.column.n) + at.REACTION.fields.index(name)]

    ux = property(lambda self: self._joints("ux"))
    uz = property(lambda self: self._joints("uz"))
    theta = property(lambda self: self._joints("theta"))
    N = property(lambda self: self._joints("N"))
    M = property(lambda self: self._joints("M"))
    S = property(lambda self: self._joints("S"))
    T = property(lambda self: self._joints("T"))
    slip = property(lambda self: self._joints("slip"))
    contact = property(lambda self: self._joints("contact"))
    sigma_max = property(lambda self: self._joints("sigma_max"))
    Fx = property(lambda self: self._base("Fx"))
    Fz = property(lambda self: self._base("Fz"))
    My = property(lambda self: self._base("My"))

    @property
    def model(self) -> Column:
        """The column."""
        return self.column

    @property
    def remarks(self) -> tuple[str, ...]:
        """Nothing that `simulate` warns of."""
        return ()

    @property
    def overturned(self) -> bool:
        """Whether the column falls, within the run or after it."""
        return self.overturned_joint > 0

    @property
    def peak_ux(self) -> FloatArray:
        """The peaks of ux, m (n,)."""
        return self.peaks["ux"]

    def friction_demand(self, part: float = at.COUNTS_FROM) -> FloatArray:
        """Largest |T| / N of each joint over the rows, (n,), where N is above `part` of the weight carried."""
        return friction_demand(self, part)

    def time_exceeded(self, mu: float, part: float = at.COUNTS_FROM) -> FloatArray:
        """Time for which each joint needs more friction than mu, s (n,); N as in `friction_demand`."""
        return time_exceeded(self, mu, part)

    def to_csv(self, path: str | os.PathLike[str], digits: int = DIGITS) -> None:
        """Write every history under the name of the FMU's output, in the order of the FMU's outputs.

        digits: significant ones of every number, 1 to 17; 17 give every float64 in full.
        With an ensemble, the percentiles of its ux follow as ensemble.block[i].ux.p16, p50, p84: nan after all have
        fallen.
        """
        names = ["time"]
        parts = [self.time[:, None]]
        for name, output in BLOCK_HISTORIES.items():
            names += [output.format(i=i + 1) for i in range(self.column.n)]
            parts.append(getattr(self, name))
        for name, output in BASE_HISTORIES.items():
            names.append(output)
            parts.append(getattr(self, name)[:, None])
        if self.ensemble is not None:
            for percent, band in zip(PERCENTILES, self.ensemble.ux, strict=True):
                names += [f"ensemble.block[{i + 1}].ux.p{percent}" for i in range(self.column.n)]
                parts.append(band)
        names.append("overturned")
        parts.append((self.time >= self.overturn_time)[:, None].astype(float))
        write = f"%.{check_digits('digits', digits)}g".__mod__
        write_table(path, names, ([write(value) for value in row] for row in np.hstack(parts).tolist()))

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
