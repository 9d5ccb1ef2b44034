"""The result of a run in space: histories, peaks, verdict; as CSV."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...common.errors import needing
from ...common.frames import EXTRA
from ...common.notebook import history, rows_of
from ..outputs import BASE, CONTACT, DIGITS, TIE, peaks_by_name
from ..response import Result
from .blocks.faces import FloatArray
from .outputs import OUTPUTS, StructureHistories
from .overlap import Overlap, deepest_overlap

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .model import Structure


class Moved(NamedTuple):
    """What the rows of a run do not have: velocities m/s (rows, n, 3), energies J (rows,)."""

    velocity: FloatArray
    energy: FloatArray


@dataclass(eq=False, repr=False)
class SpatialResponse(StructureHistories, Result):
    """Histories of a structure: rows are instants, columns blocks, joints or ties in the order of the structure.

    time (s). Blocks: ux, uy, uz (m), of the centroids relative to the base, from the structure as built and without
    weight; rotation (rows, n, 3), axis times angle (rad). Joints, along the axes of the joint: N (N, compression), Mx,
    My, Mz (N m, restoring), Tx, Ty (N, of the upper block on the lower one), contact (0..1 of the area), sigma_max
    (Pa), slip (m, that friction has given way by). bond (0..1 of the area, that has not broken), of joints that bear
    tension or cohesion. tie (N, tension). Bearings: dx, dy, d (m), along their axes, and
    whichever way. Neighbours, pair by pair: gap (m, below 0 while
    they press on each other), hit (N). base (rows, 6): force and moment about the origin of the structure on the base.

    peaks: largest absolute values of the continuous motion by these names; the least of contact, bond and gap; u: of
    the horizontal displacement, over the rows. verdict: "overturned" (some block lies lower than built by half of its
    least extent, is tipped by more than a quarter turn, or has come off a bearing), "standing" or "undecided"; reason:
    why, in words; overturn_time (s, NaN if not), overturned_block (name, empty if not). stats: steps, rejected,
    evaluations, looks, wall_time (s), settled_for (s). estimated_error, horizon and ensemble: as of the Response of a
    column. peak_ux: peaks["ux"], of the centroids, whereas those of a column are of its top faces. overturned: whether
    a block has fallen, also after the histories.
    """

    structure: Structure
    rows: FloatArray
    _again: Callable[[], Moved]  # makes the run again, and keeps what rows do not have
    overturned_block: str = ""
    dimensions = MappingProxyType({TIE: "tie_number", CONTACT: "pair", BASE: "component"})

    @property
    def _fall(self) -> str:
        return f"{self.overturned_block} fell at {self.overturn_time:.4g} s"

    def _lines(self) -> Iterable[Sequence[object]]:
        shown = {f"|{name}| (mm)": 1e3 * self.peaks[name] for name in ("ux", "uy", "uz")}
        return rows_of({"peaks of block": np.array(self.structure.names), **shown})

    def _picture(self) -> str:
        most = int(np.argmax(self.peaks["u"]))
        return history(self.time, 1e3 * self.ux[:, most], f"ux of {self.structure.names[most]} (mm)")

    @cached_property
    def _moved(self) -> Moved:
        return self._again()

    @property
    def velocity(self) -> FloatArray:
        """Velocities of the centroids relative to the base along x, y, z, m/s (rows, n, 3).

        The run is made once more when velocity or energy is first used, which takes its time. Raises SolverError.
        """
        return self._moved.velocity

    @property
    def energy(self) -> FloatArray:
        """Kinetic, elastic and gravitational energy above that at rest, of the motion relative to the base, J (rows,).

        Raises as velocity.
        """
        return self._moved.energy

    @cached_property
    def overlap(self) -> Overlap:
        """The deepest overlap of blocks without a joint, of neighbours beyond what their contacts know of."""
        return deepest_overlap(self.structure, self.time, self)

    model = StructureHistories.model

    @property
    def remarks(self) -> tuple[str, ...]:
        """Lines on the run: blocks that overlap where the model does not let them meet."""
        return (self.overlap.sentence,) if self.overlap.between else ()

    def to_csv(self, path: str | os.PathLike[str], digits: int = DIGITS) -> None:
        """Write time and every history, under names such as block[left].ux, joint[left-base].N, tie[1].F, base.Fx."""
        super().to_csv(path, digits)

    @property
    def names(self) -> list[str]:
        """Names of the columns of the CSV."""
        return ["time", *self.row_names]

    def to_pandas(self) -> Any:
        """A pandas.DataFrame of the histories, time as its index, columns as in the CSV.

        Raises InputError without pandas (the extra `studies`).
        """
        with needing(EXTRA, "pandas"):
            import pandas
        return pandas.DataFrame(self.rows, index=pandas.Index(self.time, name="time"), columns=self.row_names)

    def to_xarray(self) -> Any:
        """An xarray.Dataset of the histories over time and the names of blocks, joints and ties.

        Raises InputError without xarray (the extra `studies`).
        """
        return super().to_xarray()

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Draw displacements, rotations, contact over time; saved to `path` if given.

        Raises InputError without matplotlib (the extra `plot`).
        """
        with needing("plot", "matplotlib"):
            from ...plotting.structures import plot_response
        return plot_response(self, path)

    def plot_structure(
        self, path: str | os.PathLike[str] | None = None, at: float | None = None, scale: float | None = None
    ) -> Figure:
        """Draw the deformed structure at time `at`, s (None: its peak), deformation times `scale` (None: chosen).

        Raises InputError without matplotlib (the extra `plot`).
        """
        with needing("plot", "matplotlib"):
            from ...plotting.structures import plot_structure
        return plot_structure(self, path, at, scale)

    def film(
        self,
        path: str | os.PathLike[str],
        scale: float | None = None,
        fps: int = 20,
        speed: float = 1.0,
        callback: Callable[[int, int], object] | None = None,
    ) -> None:
        """Write a film of the structure, a GIF or, if ffmpeg is installed, an MP4; `speed`: s of motion in a s of film.

        callback: is given the number of pictures made, and of all.
        Raises InputError without matplotlib (the extra `plot`).
        """
        with needing("plot", "matplotlib"):
            from ...plotting.structures import film
        film(self, path, scale, fps, speed, callback)

    def plot_plan(
        self, path: str | os.PathLike[str] | None = None, blocks: Sequence[str | int] | None = None
    ) -> Figure:
        """Draw the orbits of blocks in plan; of the highest one unless some are named.

        Raises InputError without matplotlib (the extra `plot`).
        """
        with needing("plot", "matplotlib"):
            from ...plotting.structures import plot_plan
        return plot_plan(self, path, blocks)


def peaks_in_space(structure: Structure, rows: FloatArray, peaks: FloatArray) -> dict[str, FloatArray]:
    """Peaks by name, from those of the kernels; u: of the horizontal displacement, over the rows."""
    n = structure.n
    found = peaks_by_name(OUTPUTS, structure.sizes, peaks)
    found["u"] = np.max(np.hypot(rows[:, :n], rows[:, n : 2 * n]), axis=0)
    return found
