"""The result of a run in space: histories, peaks, verdict; as CSV."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.errors import InputError, needing, reading
from ..common.files import whole_file
from ..common.frames import EXTRA
from ..common.notebook import Shown, counted, history, rows_of
from ..dynamics.response import DIGITS, check_digits
from ..dynamics.uncertainty import Ensemble, ErrorEstimate
from ..ground.motion import Motion
from ..kernels.space import layout as at
from .blocks.faces import FloatArray
from .blocks.shapes import turned

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .structure import Structure

OF_BLOCK = at.OF_BLOCK
OF_JOINT = at.OF_JOINT
OF_BASE = ("base.Fx", "base.Fy", "base.Fz", "base.Mx", "base.My", "base.Mz")


class SpatialResponse(Shown):
    """Histories of a structure: rows are instants, columns blocks, joints or ties in the order of the structure.

    time (s). Blocks: ux, uy, uz (m), of the centroids relative to the base, from the structure as built and without
    weight; rotation (rows, n, 3), axis times angle (rad). Joints, along the axes of the joint: N (N, compression), Mx,
    My, Mz (N m, restoring), Tx, Ty (N, of the upper block on the lower one), contact (0..1 of the area), sigma_max
    (Pa), slip (m, that friction has given way by). tie (N, tension). base (rows, 6): force and moment about the origin
    of the structure on the base.

    peaks: largest absolute values of the continuous motion by these names; the least of contact; u: of the horizontal
    displacement, over the rows. verdict: "overturned" (some block lies lower than built by half of its least extent),
    "standing" or "undecided"; reason: why, in words; overturn_time (s, NaN if not), overturned_block (name, empty if
    not). stats: steps, rejected, evaluations, looks, wall_time (s), settled_for (s). estimated_error, horizon and
    ensemble: as of the Response of a column.
    """

    def __init__(
        self, structure: Structure, time: FloatArray, rows: FloatArray, peaks: FloatArray, stats: dict[str, Any]
    ) -> None:
        self.structure, self.time, self.rows, self.stats = structure, time, rows, stats
        self.peaks = _peaks_of(structure, rows, peaks)
        self.verdict, self.reason = "undecided", ""
        self.overturn_time, self.overturned_block = float("nan"), ""
        self.estimated_error: ErrorEstimate | None = None
        self.horizon: float | None = None
        self.ensemble: Ensemble | None = None
        self.motion: Motion | None = None

    def _facts(self) -> tuple[str, ...]:
        facts = [f"of {self.structure.name}", self.verdict, f"{1e3 * float(np.max(self.peaks['u'])):.4g} mm at most"]
        if self.overturned:
            facts.append(f"{self.overturned_block} fell at {self.overturn_time:.4g} s")
        if self.ensemble is not None:
            facts.append(f"{self.ensemble.overturned} of {self.ensemble.size} varied structures overturned")
        return *facts, counted(len(self.time), "row")

    def _lines(self) -> Iterable[Sequence[object]]:
        shown = {f"|{name}| (mm)": 1e3 * self.peaks[name] for name in ("ux", "uy", "uz")}
        return rows_of({"peaks of block": np.array(self.structure.names), **shown})

    def _picture(self) -> str:
        most = int(np.argmax(self.peaks["u"]))
        return history(self.time, 1e3 * self.ux[:, most], f"ux of {self.structure.names[most]} (mm)")

    @property
    def overturned(self) -> bool:
        """Whether a block has fallen, also after the histories."""
        return bool(self.overturned_block)

    @property
    def peak_ux(self) -> FloatArray:
        """The peaks of ux, m (n,)."""
        return self.peaks["ux"]

    def _field(self, name: str) -> FloatArray:
        first, count = _places(self.structure)[name]
        return self.rows[:, first : first + count]

    ux = property(lambda self: self._field("ux"))
    uy = property(lambda self: self._field("uy"))
    uz = property(lambda self: self._field("uz"))
    N = property(lambda self: self._field("N"))
    Mx = property(lambda self: self._field("Mx"))
    My = property(lambda self: self._field("My"))
    Mz = property(lambda self: self._field("Mz"))
    Tx = property(lambda self: self._field("Tx"))
    Ty = property(lambda self: self._field("Ty"))
    contact = property(lambda self: self._field("contact"))
    sigma_max = property(lambda self: self._field("sigma_max"))
    slip = property(lambda self: self._field("slip"))
    tie = property(lambda self: self._field("tie"))
    base = property(lambda self: self._field("base"))

    @property
    def rotation(self) -> FloatArray:
        """Axis times angle of each block, rad (rows, n, 3)."""
        return np.stack([self._field(name) for name in ("rx", "ry", "rz")], axis=-1)

    def displacement(self, block: str | int, point: Sequence[float] = (0.0, 0.0, 0.0)) -> FloatArray:
        """Displacement of a point of a block, m (rows, 3); the point counts from its centroid, along its own axes.

        Raises InputError for a block that there is none of.
        """
        i = self.structure.number(block)
        arm = self.structure.blocks[i].axes @ np.asarray(point, dtype=np.float64)
        if arm.shape != (3,):
            raise InputError(f"point = {list(point)}: must be three lengths in m")
        moved = np.column_stack([self.ux[:, i], self.uy[:, i], self.uz[:, i]])
        return moved + turned(self.rotation[:, i], arm)

    def to_csv(self, path: str | os.PathLike[str], digits: int = DIGITS) -> None:
        """Write time and every history, under names such as block[left].ux, joint[left-base].N, tie[1].F, base.Fx."""
        check_digits("digits", digits)
        table = np.column_stack([self.time, self.rows])
        with reading(path), whole_file(path) as partial:
            header = ",".join(f'"{name}"' if "," in name else name for name in self.names)
            np.savetxt(partial, table, fmt=f"%.{digits}g", delimiter=",", header=header, comments="")

    @property
    def names(self) -> list[str]:
        """Names of the columns of the CSV."""
        structure = self.structure
        return [
            "time",
            *(f"block[{block}].{name}" for name in OF_BLOCK for block in structure.names),
            *(f"joint[{joint}].{name}" for name in OF_JOINT for joint in structure.joint_names),
            *(f"tie[{e}].F" for e in range(1, len(structure.ties) + 1)),
            *OF_BASE,
        ]

    def to_pandas(self) -> Any:
        """A pandas.DataFrame of the histories, time as its index, columns as in the CSV.

        Raises InputError without pandas (the extra `studies`).
        """
        with needing(EXTRA, "pandas"):
            import pandas
        return pandas.DataFrame(self.rows, index=pandas.Index(self.time, name="time"), columns=self.names[1:])

    def to_xarray(self) -> Any:
        """An xarray.Dataset of the histories over time and the names of blocks, joints and ties.

        Raises InputError without xarray (the extra `studies`).
        """
        with needing(EXTRA, "xarray"):
            import xarray
        structure = self.structure
        ties = [str(e) for e in range(1, len(structure.ties) + 1)]
        parts = {"block": structure.names, "joint": structure.joint_names, "tie_number": ties, "component": OF_BASE}
        of = dict.fromkeys(OF_BLOCK, "block") | dict.fromkeys(OF_JOINT, "joint")
        of |= {"tie": "tie_number", "base": "component"}
        data = {name: (("time", part), self._field(name)) for name, part in of.items()}
        coordinates = {"time": self.time, **{name: list(values) for name, values in parts.items()}}
        return xarray.Dataset(data, coordinates, {"structure": structure.name, "verdict": self.verdict})

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Draw displacements, rotations, contact over time; saved to `path` if given.

        Raises InputError without matplotlib (the extra `plot`).
        """
        with needing("plot", "matplotlib"):
            from .pictures import plot_response
        return plot_response(self, path)

    def plot_structure(
        self, path: str | os.PathLike[str] | None = None, at: float | None = None, scale: float | None = None
    ) -> Figure:
        """Draw the deformed structure at time `at`, s (None: its peak), deformation times `scale` (None: chosen).

        Raises InputError without matplotlib (the extra `plot`).
        """
        with needing("plot", "matplotlib"):
            from .pictures import plot_structure
        return plot_structure(self, path, at, scale)

    def film(self, path: str | os.PathLike[str], scale: float | None = None, fps: int = 20, speed: float = 1.0) -> None:
        """Write a film of the structure, a GIF or, if ffmpeg is installed, an MP4; `speed`: s of motion in a s of film.

        Raises InputError without matplotlib (the extra `plot`).
        """
        with needing("plot", "matplotlib"):
            from .pictures import film
        film(self, path, scale, fps, speed)

    def plot_plan(self, path: str | os.PathLike[str] | None = None, blocks: Sequence[str | int] = (0,)) -> Figure:
        """Draw the orbits of blocks in plan.

        Raises InputError without matplotlib (the extra `plot`).
        """
        with needing("plot", "matplotlib"):
            from .pictures import plot_plan
        return plot_plan(self, path, blocks)


def _places(structure: Structure) -> dict[str, tuple[int, int]]:
    """First place and length of each field in an output row."""
    found, first = {}, 0
    n, m, k = structure.n, len(structure.joints), len(structure.ties)
    for names, count in ((OF_BLOCK, n), (OF_JOINT, m), (("tie",), k), (("base",), len(OF_BASE))):
        for name in names:
            found[name] = first, count
            first += count
    return found


def _peaks_of(structure: Structure, rows: FloatArray, peaks: FloatArray) -> dict[str, FloatArray]:
    found = {name: peaks[first : first + count].copy() for name, (first, count) in _places(structure).items()}
    found["contact"] = 1.0 - found["contact"]
    n = structure.n
    found["u"] = np.max(np.hypot(rows[:, :n], rows[:, n : 2 * n]), axis=0)
    return found
