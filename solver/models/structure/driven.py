"""A structure under inputs that a caller sets from call to call, as its FMUs follow it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...common.errors import SolverError, TooMuchWorkError
from ...ground.motion import Motion
from ...kernels.layout.spaces import CALL_TOO_LONG, INPUT_TOO_LARGE, TOO_MUCH_WORK
from ...kernels.structure import driven
from ...kernels.structure import layout as at
from ...kernels.structure.entries import assemble_structure, follow_structure, look_structure
from ...kernels.structure.modal_layout import room_size
from ..column.first_run import compile_for
from ..column.stepper import REASONS as IN_PLANE
from .blocks.faces import FloatArray
from .modal_data import modal_data_of
from .model import Structure
from .rest import rest_of
from .stepper import TOO_SMALL

REASONS = {
    at.STEP_TOO_SMALL: TOO_SMALL,
    CALL_TOO_LONG: IN_PLANE[CALL_TOO_LONG],
    TOO_MUCH_WORK: "the motion is too fast to be followed; the input or the state is not a physical one",
    INPUT_TOO_LARGE: "an input of the base is, or becomes, larger than 1e6 (m/s2)",
}
SKIP_CODES = {"peaks": driven.WITHOUT_PEAKS, "elastic": driven.WITHOUT_ELASTIC}
CONTACT = at.OF_JOINT.index("contact")


class Record(NamedTuple):
    """Samples of the base acceleration: times s, accelerations m/s2."""

    time: FloatArray
    ax: FloatArray
    ay: FloatArray
    az: FloatArray


def record_of(motion: Motion | None) -> Record:
    """The samples of a motion; none without one."""
    if motion is None:
        return Record(*(np.zeros(0) for _ in Record._fields))
    samples = motion.time, motion.ax, motion.ay, motion.az
    return Record(*(np.require(part, np.float64, ["C", "W"]) for part in samples))


class Sizes(NamedTuple):
    """Lengths of the arrays of a structure (kernels/structure/driven.py)."""

    model: int
    state: int
    counts: int
    base: int
    work: int
    row: int


def sizes_of(structure: Structure, model: FloatArray) -> Sizes:
    """The lengths for a structure; model: see `packed`."""
    n, m, k = structure.n, len(structure.joints), len(structure.ties)
    work = at.work_size(n, m, k, structure.model.corners.size) + room_size(n, k)
    counted = at.COUNTS.beside, at.BASE.beside, work, at.row_size(n, m, k)
    return Sizes(int(driven.HEAD.see(model).size), driven.state_size(n, m, k), *counted)


def packed(structure: Structure) -> FloatArray:
    """The model of a structure and its rest, as `assemble` is given them. Raises InputError if it does not stand."""
    n, m, k = structure.n, len(structure.joints), len(structure.ties)
    rest, modal = rest_of(structure), modal_data_of(structure.with_settings(without=())).numbers
    model = structure.model._replace(settings=structure.model.settings.copy(), modal=modal)
    at.SETTINGS.see(model.settings).has_modes = float(modal.size > 0)
    size = driven.model_size(n, m, k, model.corners.size, modal.size)
    phase = rest.phase.copy()
    if structure.is_plane:  # what is zero by symmetry, but for rounding
        seen = at.PHASE.see(phase, n)
        for name in ("uy", "q1", "q3"):
            getattr(seen, name)[:] = 0.0
    head = np.array([n, m, k, structure.is_plane, model.corners.size, size], dtype=np.float64)
    return np.concatenate([head, *model, phase])


def make_kernels(_: object = None) -> None:
    """Compile the entries that an FMU calls, unless they are cached."""
    row, counts = np.empty(0), np.empty(0, dtype=np.int64)
    arrays = row, row, counts, row
    compile_for(assemble_structure, *arrays, row, row, 1)
    compile_for(follow_structure, *arrays, row, row, 0.0, 0.0, *record_of(None))
    compile_for(look_structure, *arrays, row, row, 1, 0.0, 0.0, row)


class Arrays(NamedTuple):
    """All that differs from one moment to another, beside the model."""

    state: FloatArray
    counts: FloatArray
    base: FloatArray


class DrivenStructure:
    """A structure between two calls; the caller owns the time. Its whole state is in `arrays`: copying them saves it.

    packed: see `packed`. record: followed beside the inputs.
    """

    def __init__(self, structure: Structure, model: FloatArray, given: tuple[float, float, float]) -> None:
        self.structure = structure
        self.sizes = sizes_of(structure, model)
        self.packed = model
        self.arrays = Arrays(
            np.zeros(self.sizes.state), np.zeros(self.sizes.counts, dtype=np.int64), np.zeros(self.sizes.base)
        )
        self.record = record_of(None)
        self._model, self._work = np.zeros(self.sizes.model), np.zeros(self.sizes.work)
        self._inputs, self._row = np.zeros(driven.INPUTS.beside), np.zeros(self.sizes.row)
        self._elapsed, self._new = 0.0, False
        self.counts = at.COUNTS.see(self.arrays.counts)
        self.split = np.zeros(0)  # of the reaction: it follows from the state alone
        self._assemble(given, True)

    def _assemble(self, given: tuple[float, float, float], from_rest: bool) -> None:
        described = np.concatenate([np.array(given, dtype=np.float64), self.packed])
        assemble_structure(self._model, *self.arrays, self._work, described, int(from_rest))

    def retune(self, given: tuple[float, float, float]) -> None:
        """Go on with another tolerance, code of what is left out, and factor on the damping (GIVEN)."""
        self._assemble(given, False)

    def drive(self, t: float, *inputs: float, since: float | None = None) -> None:
        """Set accelerations of the base, m/s2, and their slopes, m/s3, from time t on.

        since: s, the time that they are given for; None: t.
        """
        self._inputs[:] = inputs
        self._elapsed, self._new = 0.0 if since is None else t - since, True

    def advance(self, t: float, h: float) -> None:
        """Go from t to t + h, s. Raises SolverError."""
        arrays = self._model, *self.arrays, self._work
        code = follow_structure(*arrays, self._inputs, float(t), float(h), *self.record)
        self._new = False
        if code < at.OK:
            kind = TooMuchWorkError if code == TOO_MUCH_WORK else SolverError
            raise kind(f"at t = {t:.6g} s: {REASONS[code]}")

    def observe(self, t: float) -> FloatArray:
        """The output row (kernels/structure/layout.py); overwritten by the next call."""
        arrays = self._model, *self.arrays, self._work
        look_structure(*arrays, self._inputs, int(self._new), self._elapsed, float(t), self._row)
        return self._row

    def stand_on_base(self) -> None:
        """It does already: its base does not rotate."""

    @property
    def visible_peaks(self) -> FloatArray:
        """Largest absolute values so far in the order of a row, of contacts the least."""
        peaks = self.arrays.state[-self.sizes.row :].copy()
        m = len(self.structure.joints)
        first = len(at.OF_BLOCK) * self.structure.n + CONTACT * m
        peaks[first : first + m] = 1.0 - peaks[first : first + m]
        return peaks

    @property
    def fallen_block(self) -> int:
        """Number of the block that has fallen, from 1; 0 while none has."""
        return int(self.counts.fallen)

    @property
    def fall_time(self) -> float:
        """When it fell, s."""
        return float(at.CONTROL.see(self.arrays.state).fall_time)
