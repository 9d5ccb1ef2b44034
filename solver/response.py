"""What a run returns: histories, peaks, verdict; as CSV and as a picture."""

from __future__ import annotations

import csv
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .column import Column
from .kernels import layout as at
from .packing import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# name of the history, its place in an output row, its name among the outputs of the FMU
BLOCK_HISTORIES = (
    ("ux", at.ROW_UX, "block[{i}].ux"),
    ("uz", at.ROW_UZ, "block[{i}].uz"),
    ("theta", at.ROW_THETA, "block[{i}].theta"),
    ("N", at.ROW_N, "joint[{i}].N"),
    ("M", at.ROW_M, "joint[{i}].M"),
    ("S", at.ROW_S, "joint[{i}].S"),
    ("contact", at.ROW_CONTACT, "joint[{i}].contact"),
    ("sigma_max", at.ROW_SIGMA, "joint[{i}].sigma_max"),
)
BASE_HISTORIES = (("Fx", at.ROW_FX, "base.Fx"), ("Fz", at.ROW_FZ, "base.Fz"), ("My", at.ROW_MY, "base.My"))


@dataclass(frozen=True, eq=False)
class Response:
    """Histories (nt, n), block and joint 1 (the top) first; base reaction (nt,).

    time s; ux m, top face relative to the base, +x; uz m, centroid, up, from the unloaded geometry; theta rad,
    clockwise; N N, compression; M N m, restoring; S N, horizontal, of the part above on the part below; contact 0..1
    of the joint's width; sigma_max Pa; Fx, Fz N and My N m (clockwise), of the column on the base at the centre of
    joint n. peak_ux m (n,): largest |ux| of the continuous motion. overturned, overturn_time s (NaN if not),
    overturned_joint (0 if not). stats: steps, implicit_steps and elastic_steps (of these), rejected, evaluations,
    sweeps; full_contact, rocking, flight: parts of the time; wall_time s.
    """

    column: Column
    time: FloatArray
    ux: FloatArray
    uz: FloatArray
    theta: FloatArray
    N: FloatArray
    M: FloatArray
    S: FloatArray
    contact: FloatArray
    sigma_max: FloatArray
    Fx: FloatArray
    Fz: FloatArray
    My: FloatArray
    peak_ux: FloatArray
    overturned: bool
    overturn_time: float
    overturned_joint: int
    stats: dict[str, Any]

    @classmethod
    def from_rows(
        cls,
        column: Column,
        time: FloatArray,
        rows: FloatArray,
        peak_ux: FloatArray,
        overturned_joint: int,
        overturn_time: float,
        stats: dict[str, Any],
    ) -> Response:
        """Cut output rows (nt, 8 n + 3) into histories."""
        n = column.n
        histories = {name: rows[:, field * n : (field + 1) * n] for name, field, _ in BLOCK_HISTORIES}
        histories |= {name: rows[:, at.ROW_FIELDS * n + field] for name, field, _ in BASE_HISTORIES}
        return cls(
            column=column,
            time=time,
            peak_ux=peak_ux,
            overturned=overturned_joint > 0,
            overturn_time=overturn_time,
            overturned_joint=overturned_joint,
            stats=stats,
            **histories,
        )

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write every history under the name of the FMU's output, in the order of the FMU's outputs."""
        names = ["time"]
        parts = [self.time[:, None]]
        for name, _, output in BLOCK_HISTORIES:
            names += [output.format(i=i + 1) for i in range(self.column.n)]
            parts.append(getattr(self, name))
        for name, _, output in BASE_HISTORIES:
            names.append(output)
            parts.append(getattr(self, name)[:, None])
        names.append("overturned")
        parts.append((self.time >= self.overturn_time)[:, None].astype(float))
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(names)
            writer.writerows([[repr(float(value)) for value in row] for row in np.hstack(parts)])

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Draw displacements, rotations, resultants and contact over time; saved to `path` if given."""
        from .plots import plot_response

        return plot_response(self, path)
