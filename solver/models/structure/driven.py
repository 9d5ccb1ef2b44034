"""A structure under inputs that a caller sets from call to call, as in its FMUs."""

from __future__ import annotations

import struct
from typing import NamedTuple

import numpy as np

from ...common.errors import SolverError, TooMuchWorkError
from ...kernels.layout.spaces import (
    ACCELERATION,
    BODY_LACKING,
    CALL_TOO_LONG,
    INPUT_TOO_LARGE,
    RECORD_BESIDE,
    SLOPE_PARABOLA,
    TOO_MUCH_WORK,
)
from ...kernels.machine.entry import Call, offset
from ...kernels.structure import coupled, driven, entries
from ...kernels.structure import layout as at
from ..column.stepper import REASONS as IN_PLANE
from ..outputs import visible_peaks
from ..samples import NO_SAMPLES, Samples
from .blocks.faces import FloatArray
from .modal_data import modal_data_of
from .model import Structure
from .outputs import OUTPUTS
from .packing import PackedModel, arrays_of, shear_damping_in_file, with_modes
from .rest import rest_of
from .stepper import TOO_SMALL

REASONS = {
    at.STEP_TOO_SMALL: TOO_SMALL,
    CALL_TOO_LONG: IN_PLANE[CALL_TOO_LONG],
    TOO_MUCH_WORK: "the motion is too fast to be followed; the input or the state is not a physical one",
    BODY_LACKING: "what drives the base has no mass: body.M must be positive, and Jxx, Jyy where it turns",
    RECORD_BESIDE: IN_PLANE[RECORD_BESIDE],
    INPUT_TOO_LARGE: "an input of the base is, or becomes, larger than 1e6 (m/s2), or its rotation than 3 rad",
}
SKIP_CODES = {
    "peaks": driven.WITHOUT_PEAKS,
    "elastic": driven.WITHOUT_ELASTIC,
    "stabilized": driven.WITHOUT_STABILIZED,
}


_T_H, _LOOK = struct.Struct("=2d"), struct.Struct("=q2d")  # layout of the buffers of calls
_T_OF_FOLLOW, _NEW_OF_LOOK = offset(entries.follow, "start"), offset(entries.look, "new_inputs")


class Chosen(NamedTuple):
    """The options of a caller, in the order of the kernels (driven.py, GIVEN)."""

    tolerance: float
    without: float = 0.0  # sum of SKIP_CODES
    damping_scale: float = 1.0
    drive: float = ACCELERATION  # how the base moves: codes of layout/spaces.py; bodies that drive it
    slope: float = SLOPE_PARABOLA
    bodies: float = 1.0
    turns: float = 0.0  # 1: inputs and bodies may turn the base too


def packed(structure: Structure) -> FloatArray:
    """Return the model of a structure followed by its phase at rest, as `assemble` takes them.

    Its shear damping is that of the file: `assemble` scales it, and then applies the least value of sliding joints.
    Raises InputError if the structure has no rest.
    """
    rest = rest_of(structure)
    model = with_modes(structure.model, modal_data_of(structure.with_settings(without=())).numbers)
    model.names.head.is_plane = float(structure.is_plane)
    model.names.settings.after_fall = structure.after_fall
    model.names.joints.shear_damping[:] = [shear_damping_in_file(joint) for joint in structure.joints]
    phase = rest.phase.copy()
    if structure.is_plane:  # set to zero what is zero by symmetry
        seen = at.PHASE.see(phase, structure.n)
        for name in ("uy", "q1", "q3"):
            getattr(seen, name)[:] = 0.0
    return np.concatenate([model.numbers, phase])


def sizes_in(packed: FloatArray) -> at.Sizes:
    """Return the sizes of the structure in an array from `packed`."""
    return at.Sizes(*packed[: len(at.Sizes._fields)].astype(int).tolist())


def driven_size(bodies: int, turns: int) -> int:
    """Return the number of values of the motion of a base driven by bodies; 0 without bodies."""
    return at.DRIVEN.beside + turns * at.DRIVEN_TURN.beside if bodies else 0


class DrivenStructure:
    """A structure between two calls; the caller keeps the time. Copying `arrays` saves its whole state.

    `model` is its model and its rest, from `packed`.
    """

    def __init__(self, structure: Structure, model: FloatArray, given: Chosen) -> None:
        self.structure = structure
        self.sizes = sizes_in(model)
        self.packed = model
        self.arrays = arrays_of(PackedModel(self.sizes, model[: at.MODEL.size(self.sizes)]))
        # inputs: base, loads on ports, rotation, bodies
        of_ports = at.INPUT_LOADS.size(self.sizes.ports)
        turns, bodies = int(given.turns), int(given.bodies)
        of_bodies = bodies * (coupled.BODY.beside + turns * coupled.TURNING_BODY.beside)
        self._inputs = np.zeros(coupled.INPUTS.beside + of_ports + turns * coupled.ROTATION.beside + of_bodies)
        self.seen = np.zeros(self.sizes.visible + driven_size(bodies, turns))
        """The output row last observed, then the motion of the base where bodies may drive it."""
        self._row, self._driven = self.seen[: self.sizes.visible], self.seen[self.sizes.visible :]
        self._room = np.zeros(self.sizes.visible)
        self._elapsed, self._new = 0.0, False
        self.record = NO_SAMPLES
        self.counts, self._state = at.COUNTS.see(self.arrays.counts), at.STATE.see(self.arrays.state, self.sizes)
        self._assemble(given, True)

    @property
    def record(self) -> Samples:
        """The record that is added to the inputs."""
        return self._record

    @record.setter
    def record(self, record: Samples) -> None:
        self._record, passed = record, (*self.arrays, self._inputs)
        lines = record[: record._fields.index("held")]  # neither held samples nor loads
        self._follow = Call(entries.follow, (*passed, 0.0, 0.0, *lines, self._room))
        self._look = Call(entries.look, (*passed, 0, 0.0, 0.0, *lines, self._row, self._driven))

    def _assemble(self, given: Chosen, from_rest: bool) -> None:
        described = np.concatenate([np.array(given, dtype=np.float64), self.packed])
        entries.assemble(*self.arrays, described, from_rest)

    def retune(self, given: Chosen) -> None:
        """Apply other options, except those of the base, without a restart."""
        self._assemble(given, False)

    def drive(self, t: float, *inputs: float, since: float | None = None) -> None:
        """Set the inputs from time t on, which all hold at the time `since`, s; None: t.

        They are the accelerations of the base, m/s2, and their slopes, m/s3; then loads on ports with their slopes
        (layout.py, INPUT_LOADS); then the rotation of the base, where it may turn; then the inputs of the bodies that
        drive the base (kernels/structure/coupled.py, ROTATION, BODY, TURNING_BODY).
        """
        self._inputs[: len(inputs)] = inputs
        self._elapsed, self._new = 0.0 if since is None else t - since, True

    def advance(self, t: float, h: float) -> None:
        _T_H.pack_into(self._follow.buffer, _T_OF_FOLLOW, t, h)
        code = self._follow()
        self._new = False
        if code < at.OK:
            kind = TooMuchWorkError if code == TOO_MUCH_WORK else SolverError
            raise kind(f"at t = {t:.6g} s: {REASONS[code]}")

    def observe(self, t: float) -> FloatArray:
        """Return the output row (kernels/structure/layout.py) at time t; the next call overwrites it."""
        _LOOK.pack_into(self._look.buffer, _NEW_OF_LOOK, self._new, self._elapsed, t)
        self._look()
        return self._row

    def stand_on_base(self) -> None:
        """Do nothing: until the first step the structure turns with its base."""

    @property
    def visible_peaks(self) -> FloatArray:
        """The largest absolute values so far, in the order of an output row; the least for contacts."""
        return visible_peaks(OUTPUTS, self.structure.sizes, self._state.peaks)

    @property
    def fallen(self) -> int:
        return int(self.counts.fallen)

    @property
    def fall_time(self) -> float:
        return float(self._state.control.fall_time)
