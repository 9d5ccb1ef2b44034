"""The result of a run in space: histories, peaks, verdict; as CSV."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...common.aliases import Alias
from ...common.errors import needing
from ...common.frames import EXTRA
from ...common.notebook import history, rows_of
from ...kernels.structure.layout import JOINED_GAP
from ..outputs import BASE, BOND, CONTACT, TIE, peaks_by_name
from ..pictures import draw
from ..response import Result
from ..uncertainty import Debris
from .blocks.faces import FloatArray
from .outputs import OUTPUTS, StructureHistories
from .overlap import Overlap, deepest_overlap

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .model import Structure

MOST_HITS = 5  # named before a fall


class Moved(NamedTuple):
    """The quantities of a run that its rows lack: velocities, m/s (rows, n, 3), and energies, J (rows,)."""

    velocity: FloatArray
    energy: FloatArray


class Impact(NamedTuple):
    """The contact of two neighbours in a run."""

    between: str  # their names, as in `pair_names`
    gap: float  # m, the least; below 0 they press on each other
    force: float  # N, the largest across
    first: float  # s, of the first row with a force; NaN without one
    energy: float = math.nan  # J, kinetic, of the first contact as a central impact; NaN without one

    @property
    def texts(self) -> tuple[str, str, str, str, str]:
        """The names, the gap in mm, the force in kN, the time in s and energy in J of the first contact as texts."""
        missed = "between two rows" if self.force else "none"
        first = missed if math.isnan(self.first) else f"{self.first:.3g}"
        energy = "" if math.isnan(self.energy) else f"{self.energy:.3g}"
        return self.between, f"{1e3 * self.gap:.3g}", f"{1e-3 * self.force:.3g}", first, energy


@dataclass(eq=False, repr=False)
class SpatialResponse(StructureHistories, Result):
    """Histories of a structure: rows are instants, columns blocks, joints or ties in the order of the structure.

    Blocks: ux, uy, uz (m), of the centroids relative to the base, from the structure as built and without weight;
    rotation (rows, n, 3), axis times angle (rad). Joints, along the axes of the joint: N (N, compression), Mx, My, Mz
    (N m, restoring), Tx, Ty (N, of the upper block on the lower one), contact (0..1 of the area), sigma_max (Pa), slip
    (m, the size of what friction has yielded by). Joints that bear tension or cohesion: bond (0..1 of the area,
    unbroken). Ties: tie (N, tension). Bearings: dx, dy (m), along their axes, and d (m), in any direction. Pairs of
    neighbours: gap (m, negative while they press on each other), hit (N). Base: base (rows, 6), force and moment about
    the origin of the structure on the base.

    `overturned` is True if a block has fallen, also after the histories.

    Attributes
    ----------
    peaks
        Largest absolute values of the continuous motion by these names; the least of contact, bond and gap; u: of the
        horizontal displacement.
    verdict
        "overturned" (some block is lower than built by half of its least extent, is tipped by more than a quarter turn,
        or has come off a bearing), "standing" or "undecided".
    stats
        Counts and times of the run: steps, rejected, evaluations, looks, wall_time (s), settled_for (s); of one that
        goes on after a fall also `released`, by which the ends of joints have changed the energy (J).
    time, reason, overturn_time, fallen, what_fell, estimated_error, horizon, ensemble
        As in the Response of a column.
    """

    model: Structure
    rows: FloatArray
    _again: Callable[[], Moved]  # repeats the run and returns velocities and energies
    # (5, pairs): 1 if a pair has begun to touch; when, s; the rate of its gap then, m/s; least gap, m; largest force, N
    _touched: FloatArray
    dimensions = MappingProxyType({TIE: "tie_number", BOND: "bonded_joint", CONTACT: "pair", BASE: "component"})
    overturned_block = Alias(
        "fallen", lambda response: response.model.names[response.fallen - 1] if response.fallen else ""
    )
    peak_ux, plot_structure = Alias("peak_centroid_ux"), Alias("plot_model")

    @property
    def centroid_ux(self) -> FloatArray:
        """The displacements of the centroids along x, relative to the base: ux, m (rows, n)."""
        return self.ux

    @property
    def peak_centroid_ux(self) -> FloatArray:
        """The peaks of the displacements of the centroids along x, m (n,)."""
        return self.peaks["ux"]

    def _lines(self) -> Iterable[Sequence[object]]:
        shown = {f"|{name}| (mm)": 1e3 * self.peaks[name] for name in ("ux", "uy", "uz")}
        return rows_of({"peaks of block": np.array(self.model.names), **shown})

    def _picture(self) -> str:
        most = int(np.argmax(self.peaks["u"]))
        return history(self.time, 1e3 * self.ux[:, most], f"ux of {self.model.names[most]} (mm)")

    @cached_property
    def _moved(self) -> Moved:
        return self._again()

    @property
    def velocity(self) -> FloatArray:
        """The velocities of the centroids relative to the base along x, y, z, m/s (rows, n, 3).

        The first use of velocity or energy repeats the run, which takes its time. Raises SolverError.
        """
        return self._moved.velocity

    @property
    def energy(self) -> FloatArray:
        """The kinetic, elastic and gravitational energy of the motion relative to the base, above that at rest (J).

        Shape (rows,). Raises SolverError, as velocity.
        """
        return self._moved.energy

    @cached_property
    def impacts(self) -> tuple[Impact, ...]:
        """The contacts of neighbours, one for each two bodies, in the order in which they first touch."""
        found: dict[str, Impact] = {}
        for k, name in enumerate(self.model.pair_names):
            met, first, _, gap, force = self._touched[:, k].tolist()
            one = Impact(name, gap, force, first if met else math.nan, self._energy_of_hit(k))
            other = found.get(name, one)  # two bodies may meet with several sides
            early = min(other, one, key=lambda each: np.nan_to_num(each.first, nan=math.inf))
            found[name] = early._replace(gap=min(one.gap, other.gap), force=max(one.force, other.force))
        found = {name: one for name, one in found.items() if one.gap < JOINED_GAP}
        return tuple(sorted(found.values(), key=lambda one: (np.nan_to_num(one.first, nan=math.inf), one.gap)))

    def _energy_of_hit(self, k: int) -> float:
        """Return the kinetic energy of the first contact of pair k, J, by the rate at which its gap closes."""
        (met, first, rate, _, _), pair = self._touched[:, k].tolist(), self.model.neighbours[k]
        if not met or first <= self.time[0]:
            return math.nan
        masses = [self.model.blocks[i].mass for i in (pair.one, pair.other) if i < self.model.n]
        return 0.5 * rate * rate / sum(1.0 / mass for mass in masses)

    @property
    def hits_before_fall(self) -> str:
        """The first hits of neighbours before the fall, at most MOST_HITS, in words; "" without any."""
        hits = [f"{one.between} at {one.first:.4g} s" for one in self.impacts if one.first <= self.overturn_time]
        more = f" and {len(hits) - MOST_HITS} more pairs" if len(hits) > MOST_HITS else ""
        return f"{', '.join(hits[:MOST_HITS])}{more}"

    @property
    def debris(self) -> Debris | None:
        """The places at the end and the neighbours that have hit, of a run that has gone on after its fall."""
        if not self.model.after_fall or not self.overturned:
            return None
        moved = np.column_stack([self.ux[-1], self.uy[-1], self.uz[-1]])
        places = np.array([block.centroid for block in self.model.blocks]) + moved
        return Debris(places, tuple(one.between for one in self.impacts if one.force > 0.0))

    @cached_property
    def overlap(self) -> Overlap:
        """The deepest overlap of blocks without a joint, or of neighbours beyond their contacts."""
        return deepest_overlap(self.model, self.time, self)

    @property
    def remarks(self) -> tuple[str, ...]:
        """The warnings of the run, of blocks that overlap where the model has no contact."""
        return (self.overlap.sentence,) if self.overlap.between else ()

    @property
    def names(self) -> list[str]:
        """The names of the columns of the CSV."""
        return ["time", *self.row_names]

    def to_pandas(self) -> Any:
        """Return the histories as a pandas.DataFrame, with time as index and columns as in the CSV.

        Raises InputError without pandas (the extra `studies`).
        """
        with needing(EXTRA, "pandas"):
            import pandas
        return pandas.DataFrame(self.rows, index=pandas.Index(self.time, name="time"), columns=self.row_names)

    def plot_plan(
        self, path: str | os.PathLike[str] | None = None, blocks: Sequence[str | int] | None = None
    ) -> Figure:
        """Draw the orbits of blocks in plan; that of the highest block unless some are named.

        Raises InputError without matplotlib (the extra `plot`).
        """
        return draw(self, "plot_plan", path, blocks)


def peaks_in_space(structure: Structure, peaks: FloatArray, farthest: FloatArray) -> dict[str, FloatArray]:
    """Return the peaks by name from those of the kernels and the largest horizontal displacements, m (n,)."""
    found = peaks_by_name(OUTPUTS, structure.sizes, peaks)
    found |= {f"base_{part.name}": found["base"][k : k + 1] for k, part in enumerate(StructureHistories.base.parts)}
    found["u"] = farthest
    return found
