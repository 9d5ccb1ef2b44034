"""The results of all models, responses and modes: verdict, error estimates, conversion to frames and files."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..common.aliases import Renamed, aliases_of
from ..common.files import write_table
from ..common.frames import Frame, Framed
from ..common.notebook import NotebookRepr, counted
from ..ground.motion import Motion
from .outputs import BOND, DIGITS, JOINT, FloatArray, Histories, units_of
from .pictures import draw, scenes_of
from .protocol import SCALAR, UNDECIDED
from .uncertainty import Debris, Ensemble, ErrorEstimate

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(eq=False, repr=False, kw_only=True)
class Result(Histories, Framed, NotebookRepr):
    """The result of a run of any model.

    Attributes
    ----------
    model : Column or Structure
        The model.
    time : ndarray of shape (rows,)
        The times of the rows (s).
    peaks : dict of str to ndarray
        The peaks by name, those of ux (m) among them.
    stats : dict
        The statistics of the run.
    overturn_time : float
        The time of the fall (s), NaN if there is none.
    fallen : int
        The number of the block that has fallen, from 1; 0 if there is none.
    what_fell : str
        What has fallen, in words, such as "block 2 over joint 2"; "" if nothing has.
    verdict, reason : str
        The verdict and its reason.
    estimated_error : ErrorEstimate or None
        The estimate of the error, if it was made.
    horizon : float or None
        The time up to which the motion is predictable (s), if it was computed.
    ensemble : Ensemble or None
        The runs with varied data, if they were made.
    motion : Motion or None
        The motion of the base.
    """

    time: FloatArray  # s
    peaks: dict[str, FloatArray]
    stats: dict[str, Any]
    overturn_time: float = math.nan  # s
    fallen: int = 0
    what_fell: str = ""
    verdict: str = UNDECIDED
    reason: str = ""
    estimated_error: ErrorEstimate | None = None
    horizon: float | None = None  # s
    ensemble: Ensemble | None = None
    motion: Motion | None = None  # of the base
    dimensions: ClassVar[Mapping[str, str]] = {JOINT: "block", BOND: "bonded_joint"}  # of owners in a frame

    def __post_init__(self) -> None:
        self.peaks = Renamed(self.peaks, aliases_of(type(self)), "peaks")

    @property
    def overturned(self) -> bool:
        """True if it has fallen, within the run or after it."""
        return not math.isnan(self.overturn_time)

    @property
    def displacements(self) -> FloatArray:
        """The largest horizontal displacement of each block, m (n,).

        Those of a column are of its top faces, those of a structure of its centroids, in any direction.
        """
        return self.peaks[self.model.kind.largest]

    @property
    def hits_before_fall(self) -> str:
        """The first hits of neighbours before the fall, in words; "" without any."""
        return ""

    @property
    def debris(self) -> Debris | None:
        """The debris of a run that has gone on after its fall; None of others."""
        return None

    @property
    def remarks(self) -> tuple[str, ...]:
        """The sentences of which `simulate` warns."""
        return ()

    def to_csv(self, path: str | os.PathLike[str], digits: int = DIGITS) -> None:
        """Write time and every history with `digits` significant digits, under names such as block[1].ux, base.Fx.

        Raises InputError for invalid `digits`, OSError.
        """
        self._write(path, digits, {"time": self.time})

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Draw the motion of the base and the histories of blocks and joints, and save them to `path` if given.

        Raises InputError without matplotlib (the extra `plot`).
        """
        return draw(self, "plot_response", path)

    def plot_model(
        self, path: str | os.PathLike[str] | None = None, at: float | None = None, scale: float | None = None
    ) -> Figure:
        """Draw the model, deformed at the time `at` (s; by default that of its peak), and save it to `path` if given.

        `scale` is the factor on the deformation, automatic by default. Raises InputError without matplotlib (the extra
        `plot`).
        """
        return draw(self, "plot_model", path, at, scale)

    def film(
        self,
        path: str | os.PathLike[str],
        scale: float | None = None,
        fps: int = 20,
        speed: float = 1.0,
        callback: Callable[[int, int], object] | None = None,
    ) -> None:
        """Write a film of the motion, a GIF or, if ffmpeg is installed, an MP4.

        `scale` is the factor on the deformation, automatic by default; `fps` the number of frames per second, in a GIF
        100 over a whole number; `speed` the seconds of motion in a second of film. `callback` is called with the number
        of frames made, and of all. Raises InputError without matplotlib (the extra `plot`).
        """
        draw(self, "film", path, scale, fps, speed, callback)

    def view(self, path: str | os.PathLike[str], scale: float | None = None) -> None:
        """Write one HTML page that plays the motion in any browser and fetches nothing.

        `scale` is the initial factor on the deformation; None means 1. Raises InputError, OSError.
        """
        scenes_of(self).write_view(self, path, scale)

    def to_gltf(self, path: str | os.PathLike[str]) -> None:
        """Write the blocks and their motion relative to the base as binary glTF 2.0 (.glb), for Blender and others.

        At most 30 frames per second. Raises InputError, OSError.
        """
        scenes_of(self).write_gltf(self, path)

    def _repr_html_(self) -> str:
        return f"<div>{super()._repr_html_()}{scenes_of(self).frame_of(self)}</div>"

    def to_vtk(self, folder: str | os.PathLike[str], fps: float = 30.0) -> None:
        """Write blocks.pvd and joints.pvd for ParaView: the blocks, and the loaded parts of joints, over time.

        Blocks and joints have their outputs as cell data, loaded parts the elastic pressure (Pa) at their corners.
        `fps` is the largest number of rows per second. Raises InputError, OSError.
        """
        scenes_of(self).write_vtk(self, folder, fps)

    def kept(self, name: str) -> Any:
        """Return the result of this name among those that many runs can store (`Kind.kept`)."""
        if name == "path":
            return SCALAR
        if name in self.stats:
            return self.stats[name]
        kind = self.model.kind
        new = {key: name for name, key in kind.keys.items()}.get(name, name)
        peaks = dict(self.peaks).get(new.removeprefix("least_" if new.startswith("least_") else "peak_"))
        if peaks is None:
            return getattr(self, new)
        return peaks if kind.kept[name].kind is None else peaks[0]

    def _facts(self) -> tuple[str, ...]:
        model, ensemble = self.model, self.ensemble
        facts = [
            f"of {model.name}",
            self.verdict,
            f"{1e3 * float(np.max(self.displacements)):.4g} mm at most",
        ]
        if self.overturned:
            facts.append(f"{self.what_fell} fell at {self.overturn_time:.4g} s")
        if ensemble is not None:
            facts.append(f"{ensemble.overturned} of {ensemble.size} varied {model.kind.word}s overturned")
        return *facts, counted(len(self.time), "row")

    def _frame(self) -> Frame:
        there = self.model.sizes
        seen = [output for output in self.outputs if not output.only_peak and there.get(output.owner, 1)]
        columns = {output.key: getattr(self, output.field) for output in seen}
        attributes = {self.model.kind.word: self.model.name, "verdict": self.verdict}
        of = {output.key: self.dimensions.get(output.owner, output.owner) for output in seen}
        labels = {self.dimensions.get(owner, owner): names for owner, names in self.labels.items()}
        return Frame(("time", self.time), columns, units_of(seen), attributes, of, labels)


class ModeTable(Framed):
    """The modes of a model as a table, a row for each; a subclass has the columns, and the model's frequencies (Hz)."""

    model: Any
    frequency: FloatArray
    units: ClassVar[Mapping[str, str]]

    @property
    def _columns(self) -> dict[str, NDArray[Any]]:
        """The columns of the table: a number of each mode, (modes,), or of the blocks in it, (modes, n)."""
        raise NotImplementedError

    def _frame(self) -> Frame:
        index = "mode", np.arange(1, len(self.frequency) + 1)
        return Frame(index, self._columns, self.units, {self.model.kind.word: self.model.name})

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write a row for each mode: frequency, damping ratio, effective masses, shape.

        Raises OSError if the file cannot be written.
        """
        labels = getattr(self.model, "names", range(1, self.model.n + 1))  # blocks of a column have numbers
        names, parts = ["mode"], []
        for name, values in self._columns.items():
            if values.dtype.kind == "f":
                names += [name] if values.ndim == 1 else [f"block[{label}].{name}" for label in labels]
                parts.append(values.reshape(len(values), -1))
        rows = enumerate(np.hstack(parts), start=1)
        write_table(path, names, ([k, *map(repr, map(float, row))] for k, row in rows))

    def plot(self, path: str | os.PathLike[str] | None = None, most: int = 6) -> Figure:
        """Draw the first `most` shapes, and save them to `path` if given.

        Raises InputError without matplotlib (the extra `plot`), OSError.
        """
        return draw(self, "plot_modes", path, most)
