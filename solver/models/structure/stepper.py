"""One structure in motion: owns the flat arrays and drives the kernels over them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from copy import copy
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from ...common import effort
from ...common.errors import SolverError, TooMuchWorkError
from ...ground.motion import Motion
from ...kernels.structure import layout as at
from ...kernels.structure.entries import observe_structure, run_structure, stiffness_of
from ...kernels.structure.stabilized import LONGEST_REACH, MOST_STAGES
from ...kernels.structure.stepping import SEEN
from ..samples import NO_SAMPLES, Samples, samples_of
from .blocks.faces import FloatArray
from .packing import Arrays, arrays_of, with_modes

if TYPE_CHECKING:
    from .model import Structure

TOO_SMALL = "the tolerance requires a step that is too small to continue; a larger tolerance may help"
AT_ONCE = 2e5  # evaluations of joints, about, between checks for an interruption
OF_ORDER_5 = 6  # evaluations of a step
_NONE = np.zeros(0)


class SpatialStepper:
    """A structure between two calls; until its phase is set it is as built.

    `arrays` are its whole state; `model`, `state`, `counts` and `base` the same numbers by name (layout.py). `phase` is
    the state without the counters of a run; `see` has the positions and rates of the blocks in it, `slips` the slips
    that joints and ties remember.
    """

    def __init__(self, structure: Structure, modal: FloatArray = _NONE) -> None:
        self.structure = structure
        model = with_modes(structure.model, modal) if modal.size else structure.model
        self.sizes = model.sizes
        self._take(arrays_of(model))
        self.see.q0[:] = 1.0
        self.rates, self.row = np.zeros(self.sizes.state), np.zeros(self.sizes.visible)

    def _take(self, arrays: Arrays) -> None:
        self.arrays, sizes = arrays, self.sizes
        self.model, self.state = at.MODEL.see(arrays.model, sizes), at.STATE.see(arrays.state, sizes)
        self.counts, self.base = at.COUNTS.see(arrays.counts), at.INPUT_MOTION.see(arrays.base, sizes).motion
        self.pushes = at.WORK.see(arrays.work, sizes).pushes
        self.control, self.see, self.slips = self.state.control, self.state.phase, self.state.remembered.slips
        self.phase = arrays.state[at.CONTROL.beside :][: sizes.state]

    def over(self, **arrays: Any) -> Self:
        """Return a copy of the stepper with some of its arrays replaced; it shares the others."""
        other = copy(self)
        other._take(self.arrays._replace(**arrays))
        return other

    def observe(self, ax: float = 0.0, ay: float = 0.0, az: float = 0.0, keep: int = 0) -> float:
        """Evaluate the phase under an acceleration of the base (m/s2) and `pushes`; return the energy, J.

        `rates` and `row` are updated. keep: layout.KEEP, joints, ties, bonds and pairs remember this state, as after a
        long rest; layout.PRESUME, pairs that are near touch from now on.
        """
        energy: float = observe_structure(*self.arrays, self.rates, ax, ay, az, self.row, keep)
        return energy

    @property
    def bonds(self) -> Any:
        """The table of what is known of each bond (layout.SOUND); those that are `held` do not break."""
        return at.WORK.see(self.arrays.work, self.sizes).sound

    def stiffness(self, delta: FloatArray) -> FloatArray:
        """Return the tangent stiffness about the phase, (6 n, 6 n), by differences `delta` (see entries.py)."""
        matrix = np.zeros(36 * self.structure.n**2)
        stiffness_of(*self.arrays, np.zeros_like(self.phase), self.rates, delta, matrix)
        return matrix.reshape(6 * self.structure.n, -1)

    def run(
        self,
        motion: Motion | None,
        t: float,
        stop: float,
        times: FloatArray,
        after_chunk: Callable[[float], None] | None = None,
        states: bool = False,
    ) -> FloatArray:
        """Follow a motion, or a still base (None), from t to `stop`, s; return the output rows at `times`, s.

        `after_chunk` is called with the time reached after each chunk of steps. With `states`, each row has the
        integrated part of the state too. Raises SolverError if the step becomes too small, or the work too much.
        """
        record = NO_SAMPLES if motion is None else self.drive(motion)
        visible = self.sizes.visible
        rows = np.zeros((len(times), visible + states * self.sizes.state))
        self.counts.next_row = 0
        whole = stop - t
        most = max(100, int(AT_ONCE / (7 * max(1, self.sizes.m))))
        while True:
            code = run_structure(*self.arrays, *record, times, rows.ravel(), t, stop, most)
            t = float(self.control.reached)
            if after_chunk is not None:
                after_chunk(t)
            if code != at.PAUSED:
                break
            if motion is not None:  # on a still base it may come to rest long before
                self._check_work(stop - t, motion)
            work, part = float(self.counts.evaluations), 1.0 - (stop - t) / whole
            if effort.is_too_much(work, part, effort.MOST_IN_SPACE):
                raise TooMuchWorkError(f"at t = {t:.6g} s: {effort.slowness(work, part, self._causes(motion))}")
        if code != at.OK:
            raise SolverError(f"at t = {t:.6g} s: {TOO_SMALL}")
        # fill the rows after the end of the motion
        first = int(self.counts.next_row)
        if first < len(times):  # after a fall or at rest: nothing moves any more
            self.observe()
            rows[first:, :visible] = self.row
            rows[first:, visible:] = self.phase[: rows.shape[1] - visible]
        return rows

    @property
    def without_room(self) -> int:
        """The number of contacts so far that were clipped to nothing because their corners had no room."""
        return int(at.WORK.see(self.arrays.work, self.sizes).room[at.NO_ROOM])

    def _check_work(self, left: float, motion: Motion) -> None:
        """Raise TooMuchWorkError if no steps can cover the time left, s, within the evaluations of a run.

        Dampers limit the length of explicit steps, which is known after the first one, and less that of stabilized
        steps.
        """
        settings = self.model.settings
        if settings.has_modes == 0.0 and self.control.decay > 0.0:
            per_step = at.STAGES - 1 if settings.order == at.RINGING_ORDER else OF_ORDER_5
            per_second = self.control.decay / SEEN * per_step
            if settings.stabilizes:
                per_second = self.control.decay * MOST_STAGES / LONGEST_REACH
            needed = float(self.counts.evaluations + left * per_second)
            if needed > effort.MOST_IN_SPACE:
                raise TooMuchWorkError(effort.work_message(needed, effort.MOST_IN_SPACE, self._causes(motion)))

    def _causes(self, motion: Motion | None) -> Iterator[effort.Cause]:
        """Yield the possible causes of short steps."""
        structure = self.structure
        masses = [*(block.mass for block in structure.blocks), math.inf]
        for name, joint in zip(structure.joint_names, structure.joints, strict=True):
            # the lighter body has the higher frequency
            bed, mass = joint.bed, min(masses[joint.upper], masses[joint.lower])
            area = joint.moments[0]
            yield effort.of_joint(f"joint[{name}]", bed.stiffness, area, mass, bed.damping)
            if bed.shear_damping is not None:
                rate = bed.shear_damping * bed.shear_ratio * bed.stiffness * area / mass
                yield effort.of_dashpot(f"joint[{name}].shear_damping", bed.shear_damping, "s", rate)
            if joint.bearing is not None:
                dashpot, ring = joint.bearing.dashpot, joint.bearing.ring_damping
                yield effort.of_dashpot(f"joint[{name}].damping", dashpot, "N s/m", dashpot / mass)
                rate = joint.bearing.ring_stiffness * ring / mass
                yield effort.of_dashpot(f"joint[{name}].rim_damping", ring, "s", rate)
        for e, tie in enumerate(structure.ties, start=1):
            mass = min(masses[tie.one], masses[tie.other])
            yield effort.Cause(math.sqrt(2.0 * tie.stiffness / mass), f"tie[{e}].stiffness = {tie.stiffness:g} N/m")
            yield effort.of_dashpot(f"tie[{e}].damping", tie.damping, "N s/m", tie.damping / mass)
        if motion is not None and (motion.amplitude or motion.amplitude_y):
            yield effort.of_harmonic(motion.frequency)

    def drive(self, motion: Motion) -> Samples:
        """Set the harmonic part of a motion; return its samples."""
        base = self.base
        base.amplitude_x, base.amplitude_y = motion.amplitude, motion.amplitude_y
        shakes = motion.amplitude or motion.amplitude_y
        base.omega = 2.0 * math.pi * motion.frequency if shakes else 0.0
        base.phase = -base.omega * motion.start
        return samples_of(motion, [port.name for port in self.structure.ports])
