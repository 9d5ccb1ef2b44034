"""The FMI lifecycle of one column or structure: parameters in, steps made, outputs read; the solver computes.

The wrapper supports three results only: OK; Discard, when do_step returns False; and Fatal, when an exception reaches
it, which would leave a dead instance behind. A step that the solver cannot make is discarded: a shorter one, or another
input, may succeed. A failure that no repetition can mend ends in an exception whose damage is undone first
(host.survive_exception), so that reset and free still work; native/guard.c makes Error of that Fatal.
"""

from __future__ import annotations

import contextlib
import hashlib
import math
import sys
from functools import partialmethod
from pathlib import Path
from typing import Any, NoReturn
from xml.etree.ElementTree import Element

import numpy as np
from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

from solver import __version__
from solver.common.errors import InputError, SolverError, TooMuchWorkError, check_number
from solver.common.files import identifier_of
from solver.ground.motion import Motion

from . import rules, state, state_ranges
from .alternation import Alternation
from .body import body_of
from .description_parts import LOG_CATEGORIES, About
from .drive import MOTION, USUAL, Idle, idle
from .host import finalize_at_exit, leave_search_path, survive_exception
from .model_description import FLAGS, model_description
from .record import Record, usual_experiment
from .state import Mode
from .variables import (
    ACCELERATIONS,
    DRIVE,
    OVERTURN_TIME,
    OVERTURNED,
    RECORD,
    RECORD_PGA,
    RECORD_SCALE,
    STEP_SIZE,
    TOLERANCE,
    VERDICT,
    VERDICT_NOW,
    Variable,
    with_real_outputs,
)

TOOL = "build_fmu.py with PythonFMU"
BODY_FILE = "body.json"
GUID_FILE = "guid.txt"
RECORD_FOLDER = "record"  # holds the record inside the FMU, if there is one
STEPPING = Mode.STEPPING
ARRAYS = ("state", "counts", "base")  # of the stepper: its complete state
# type of the calls of FMI 2.0 -> kinds of variables
ACCESS = {"Real": ("Real",), "Integer": ("Integer", "Enumeration"), "Boolean": ("Boolean",), "String": ("String",)}


class Request:
    """A cached lookup of the references that a master asked for; it usually asks for the same ones again."""

    def __init__(self, references: list[int], table: list[Variable], place_of: dict[int, int], kind: str) -> None:
        self.places = []
        for reference in references:
            place = place_of.get(reference)
            if place is None or table[place].kind not in ACCESS[kind]:
                raise InputError(rules.NO_VARIABLE % (reference, kind))
            self.places.append(place)
        self.references = list(references)
        self.needs_outputs = any(table[place].causality == "output" for place in self.places)
        self.last = max(self.places, default=-1)
        first = self.places[0] if references else 0
        row = self.places == list(range(first, first + len(references)))
        self.row = slice(first, first + len(references)) if row else None

    def of(self, values: list[Any]) -> list[Any]:
        """Return the values at the requested references."""
        return values[self.row] if self.row else [values[place] for place in self.places]


class BlocksSlave(Fmi2Slave):  # type: ignore[misc]
    """A column or structure of blocks as a co-simulation slave; `resources` holds its body.json and guid.txt."""

    log_categories = LOG_CATEGORIES
    real_outputs = False  # True if the model description lists real outputs only
    _fmu_state_to_bytes = staticmethod(state.to_bytes)
    _fmu_state_from_bytes = staticmethod(state.from_bytes)

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        resources = Path(self.resources)
        if "logger" in kwargs:  # run by the wrapper; the builder passes no logger
            finalize_at_exit(resources)
            leave_search_path(resources)
        # body, record and table of variables
        text = (resources / BODY_FILE).read_text(encoding="utf-8")
        self._body = body_of(text)
        # inside an FMU the name of the package ends in the hash of its content and of the solver's
        self._stamp = state.Stamp(hashlib.sha256(text.encode()).hexdigest(), f"{__version__} ({__package__})")
        self._own_record = next(iter(sorted((resources / RECORD_FOLDER).glob("*"))), None)
        self._table = self._body.table(self._own_record.name if self._own_record else "")
        self._place = {variable.name: k for k, variable in enumerate(self._table)}
        self._place_of = {variable.reference: k for k, variable in enumerate(self._table)}
        self._input_of = {variable.reference: k for k, variable in enumerate(self._body.inputs)}
        self._values: list[Any] = [0.0 if variable.start is None else variable.start for variable in self._table]
        # slices of the table
        row, split, peaks = self._body.sizes
        self._inputs = self._body.inputs
        self._seen = slice(len(self._inputs), len(self._inputs) + row + split)
        self._peaks = slice(self._seen.stop, self._seen.stop + peaks)
        self._parameters = slice(self._place[self._body.first_parameter], len(self._table))
        verdict = OVERTURN_TIME, self._body.fallen, OVERTURNED, VERDICT_NOW
        self._verdict = [self._place[item.name] for item in verdict]
        self._tell_verdict(-1.0, 0, False, VERDICT.items["undecided"])
        self._requests = {kind: Request([], self._table, self._place_of, kind) for kind in ACCESS}
        # state of the instance
        self._mode = Mode.INSTANTIATED
        self._time = 0.0
        self._stop = math.inf  # s, end of the experiment; not part of the state
        self._tolerance_set = False  # True if the master set the solver's tolerance: the experiment's is ignored
        self._input_time = 0.0  # s, time from which the slopes of the inputs count
        self._stepper: Any = None  # that of the body
        self._built_from: list[Any] = []  # parameters from which the stepper was built
        self._record: Record | None = None
        self._record_name = ""
        self._retune = False  # True if a tunable parameter was set and not yet applied
        self._inputs_stand = False  # True if no inputs were set since the last step, whose inputs the stepper has
        self._outdated = True  # True if the outputs belong to an earlier time, input or parameter
        self._late_outdated = False  # True if only peaks and verdict do
        self._shaken = False  # True if the base has moved
        self._stepped = False  # True if this instance has made a step
        self._coarse_warned = self._unstable_warned = self._long_warned = False
        self._idle_warned: set[str] = set()
        # monitors of the coupling
        self._allowed = self._body.place_in_base("allowed_step")
        self._accelerations = [item for item in self._inputs if item.unit in ACCELERATIONS]
        self._in_base = [self._body.base.index(item.name.removeprefix("base.")) for item in self._accelerations]
        self._alternation = Alternation(len(self._accelerations))  # no part of the state
        self._motion = [self._body.base.index(name) for name in MOTION if name in self._body.base]  # in the array base
        self._loads = [k for k, item in enumerate(self._inputs) if item.name.startswith("port[")]
        self.modelName = identifier_of(self._body.name)  # names the libraries in PythonFMU
        guid = resources / GUID_FILE
        if guid.is_file():
            self.guid = guid.read_text(encoding="utf-8").strip()

    def to_xml(self, model_options: dict[str, str] | None = None) -> Element:
        """Return the model description; every flag comes from fmu_src/model_description.py."""
        body, motion = self._body, Motion.from_file(self._own_record) if self._own_record else None
        experiment = usual_experiment(body.tolerance, motion)
        about = About(body.name, str(self.guid), body.about, __version__, experiment, FLAGS, TOOL)
        return model_description(about, with_real_outputs(self._table) if self.real_outputs else self._table)

    # --- lifecycle

    def setup_experiment(self, start_time: float, stop_time: float | None, tolerance: float | None) -> None:
        """Set times and tolerance; a tolerance that was set as a parameter takes precedence."""
        self._check_mode(rules.WHEN_SET_UP, Mode.INSTANTIATED)
        if not math.isfinite(start_time):
            self._fail(rules.START_TIME % start_time)
        if stop_time is not None and not stop_time >= start_time:
            self._fail(rules.STOP_TIME % (stop_time, start_time))
        self._time = self._input_time = start_time
        self._stop = math.inf if stop_time is None else stop_time
        if tolerance is not None and not self._tolerance_set:
            self._put(TOLERANCE, tolerance)
            self.log(rules.TOLERANCE % tolerance)

    def enter_initialization_mode(self) -> None:
        """Enter the mode in which outputs can be read, computed from the current inputs and parameters."""
        self._check_mode(rules.WHEN_ENTERED, Mode.INSTANTIATED)
        self._mode = Mode.INITIALIZATION

    def exit_initialization_mode(self) -> None:
        """Build the body from the current parameters."""
        self._check_mode(rules.WHEN_EXITED, Mode.INSTANTIATED, Mode.INITIALIZATION)
        try:
            self._build()
            self._stepper.drive(self._time, *self._values[: len(self._inputs)], since=self._input_time)
            self._stepper.stand_on_base()
            self._inputs_stand, self._outdated = False, True
        except Exception as error:
            self._fail(_message_of(error))
        self._mode = Mode.STEPPING
        for variable, value in zip(self._inputs, self._values, strict=False):
            if value != variable.start:
                self._warn_of_idle(variable.name, False)
        self.log(rules.PREFERRED % (self._record.dt if self._record else STEP_SIZE))

    def terminate(self) -> None:
        """End the run; only reset, or a state saved earlier, makes another one possible."""
        if self._mode == Mode.STEPPING and self._stepped and not self._shaken:
            self._say(Fmi2Status.warning, rules.NOT_DRIVEN if self._is_driven else rules.NOT_SHAKEN)
        self._mode = Mode.TERMINATED

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance by step_size, s; return False (Discard) with the state restored and the reason logged if that fails.

        A call that no shorter step can make valid is an error.
        """
        reason = self._wrong_call(current_time, step_size)
        if reason is not None:
            self._fail(rules.NOT_MADE % (current_time, step_size, reason))
        try:
            given = self._values[: len(self._inputs)]
            reason = None if math.isfinite(sum(given)) else self._wrong_input(given)
            if reason is None:
                self._advance(current_time, step_size, given)
                return True
        except TooMuchWorkError as error:
            self._fail(rules.NOT_MADE % (current_time, step_size, error))
        except Exception as error:
            reason = _message_of(error)
        self._say(Fmi2Status.discard, rules.NOT_MADE % (current_time, step_size, reason))
        return False

    def _wrong_call(self, current_time: float, step_size: float) -> str | None:
        """Return the reason why no step is possible at these times, or None."""
        if self._mode is not STEPPING:
            return rules.ENDED if self._mode == Mode.TERMINATED else rules.NOT_BEGUN
        if not 0.0 < step_size < math.inf:
            return rules.NOT_POSITIVE
        if not abs(current_time - self._time) <= rules.TIME_SLACK * step_size + 1e-12 * abs(self._time):
            return rules.LAST_ENDED % self._time
        if current_time + step_size - self._stop > rules.TIME_SLACK * step_size + 1e-12 * abs(self._stop):
            return rules.BEYOND % self._stop
        return None

    def _wrong_input(self, given: list[float]) -> str | None:
        """Return the reason why no step is possible under the current inputs, or None."""
        for variable, value in zip(self._inputs, given, strict=True):
            if not math.isfinite(value):
                return rules.NOT_FINITE % (variable.name, value, variable.unit)
        return None

    def _advance(self, start: float, step: float, given: list[float]) -> None:
        """Advance from `start` to `start + step`, s, following the record sample by sample, with the inputs `given`."""
        stepper = self._stepper
        arrays = stepper.arrays
        kept = arrays.state, arrays.counts, arrays.base
        before = kept[0].tobytes(), kept[1].tobytes(), kept[2].tobytes()  # cheaper than copies of arrays
        record = self._record
        try:
            if self._retune:
                self._apply_parameters(stepper)
            self._input_time = start
            stepper.drive(start, *given)
            stepper.advance(start, step)
        except BaseException:
            for array, numbers in zip(kept, before, strict=True):
                array[:] = np.frombuffer(numbers, array.dtype)
            self._inputs_stand = False
            raise
        # flags and warnings after the step
        self._retune = False
        self._time = start + step
        self._stepped = True
        self._inputs_stand = self._outdated = True
        if not self._shaken:
            self._shaken = self._has_moved(start, given)
        sampled = record.dt if record is not None and self._values[self._place[RECORD_SCALE]] else math.inf
        if step > sampled * (1.0 + rules.STEP_SLACK) and not self._coarse_warned:
            self._coarse_warned = True
            self._say(Fmi2Status.warning, rules.COARSE % (step, sampled))
        if self._allowed is not None and not self._long_warned:
            self._warn_of_long_step(step)
        if not self._unstable_warned:
            self._warn_of_instability(start)

    def _has_moved(self, start: float, given: list[float]) -> bool:
        """Return True if the base moved in the last step, begun at `start`, or a port was loaded."""
        record, base = self._record, self._stepper.arrays.base
        least = rules.STILL if self._is_driven else 0.0
        follows = record is not None and self._time > record.begins and start < record.ends
        return follows or any(abs(base[k]) > least for k in self._motion) or any(given[k] for k in self._loads)

    @property
    def _is_driven(self) -> bool:
        """True if bodies drive the base."""
        return self._body.drive.is_chosen and self._values[self._place[DRIVE]] != USUAL.drive

    def _warn_of_idle(self, name: str, is_coupled: bool) -> None:
        """Warn once that an input has no effect, if it has none because the base is driven."""
        owner = name[:4]  # one warning for the inputs of the base, one for those of bodies
        if owner in self._idle_warned or not self._body.drive.is_chosen:
            return
        drive = self._values[self._place[DRIVE]]
        when = idle(drive, name)
        if when is None or (when is Idle.LATER and not is_coupled):
            return
        self._idle_warned.add(owner)
        way = {"acceleration": rules.BY_ACCELERATION, "body": rules.BY_BODY}.get(drive, rules.BY_HORIZONTAL)
        later = rules.IDLE_LATER if when is Idle.LATER else ""
        self._say(Fmi2Status.warning, rules.IDLE % (name, later, drive, way))

    def _warn_of_long_step(self, step: float) -> None:
        """Warn once that a step is longer than the coupling with the bodies at the base allows."""
        allowed = self._stepper.arrays.base.item(self._allowed)
        if allowed > 0.0:
            self._long_warned = True
            self._say(Fmi2Status.warning, rules.TOO_LONG % (step, allowed))

    def _warn_of_instability(self, start: float) -> None:
        """Warn once that the accelerations of the base, held from `start` on, diverge with the coupling."""
        base = self._stepper.arrays.base
        accelerations = [base.item(place) for place in self._in_base]
        found = self._alternation.found(start, accelerations)
        if found >= 0:
            self._unstable_warned = True
            variable = self._accelerations[found]
            said = variable.name, accelerations[found], variable.unit, start
            self._say(Fmi2Status.warning, rules.UNSTABLE % said)

    # --- state

    def _get_fmu_state(self) -> state.Snapshot:
        stepper = self._stepper
        return state.Snapshot(
            self._stamp,
            self._mode,
            self._time,
            self._input_time,
            self._shaken,
            self._retune,
            self._inputs_stand,
            self._tolerance_set,
            self._values.copy(),
            self._built_from,
            self._record.digest if self._record else "",
            {name: getattr(stepper.arrays, name).copy() for name in ARRAYS} if stepper else {},
        )

    def _set_fmu_state(self, snapshot: state.Snapshot | state.Unreadable) -> None:
        try:
            if isinstance(snapshot, state.Unreadable):
                raise InputError(snapshot.reason)
            if snapshot.stamp is not self._stamp:
                snapshot.check(self._stamp)
            self._restore(snapshot)
        except Exception as error:
            self._fail(rules.NOT_SET % _message_of(error))

    def _restore(self, snapshot: state.Snapshot) -> None:
        """Restore the instance from a snapshot. An exception leaves the instance unchanged."""
        stepper, record, name = self._stepper, self._record, self._record_name
        from_bytes = snapshot.stamp is not self._stamp
        # build another stepper if parameters differ, or the snapshot comes from bytes
        if not snapshot.arrays:
            stepper = None
        elif stepper is None or from_bytes or snapshot.built_from != self._built_from:
            values = snapshot.values.copy()
            values[self._parameters] = snapshot.built_from
            record, name = self._loaded(values[self._place[RECORD]], values[self._place[RECORD_SCALE]])
            stepper = self._body.stepper(self._described(values))
        # bytes may hold anything: check them, and the outputs that they give
        if from_bytes:
            body, samples = self._body, len(record.motion.time) if record else 0
            arrays = {name: getattr(stepper.arrays, name) for name in ARRAYS} if stepper else {}
            ranges = body.state_ranges(stepper) if stepper else None
            snapshot.check_contents(self._table, arrays, ranges, body.place_in_base("segment"), samples)
        if stepper is not None:
            if (record.digest if record else "") != snapshot.record:
                raise InputError(f"base.record = {name!r}: its samples are not those that the state belongs to")
            stepper.record = self._body.samples(record.motion if record else None)
            snapshot.copy_to(stepper)
            if from_bytes:
                self._check_outputs(snapshot, stepper)
                snapshot.copy_to(stepper)
        # no error is possible from here on
        self._stepper, self._record, self._record_name = stepper, record, name
        self._built_from = snapshot.built_from
        self._values = snapshot.values.copy()
        self._mode = Mode(snapshot.mode)
        self._time, self._input_time = snapshot.time, snapshot.input_time
        self._shaken, self._retune = snapshot.shaken, snapshot.retune
        self._inputs_stand, self._outdated = snapshot.inputs_stand, True
        self._tolerance_set = snapshot.tolerance_set

    def _check_outputs(self, snapshot: state.Snapshot, stepper: Any) -> None:
        """Raise InputError if the outputs of a state are beyond any motion, for any inputs."""
        if not snapshot.inputs_stand:
            given = snapshot.values[: len(self._inputs)]
            if not all(abs(value) <= state_ranges.MOST_TRIED for value in given):
                given = [variable.start for variable in self._inputs]
            stepper.drive(snapshot.time, *given, since=snapshot.input_time)
        with contextlib.suppress(SolverError):  # an Error when outputs are got
            stepper.observe(snapshot.time)
            if not (np.abs(stepper.seen) <= state_ranges.MOST).all():
                raise InputError("its outputs are no finite numbers that a motion can have")

    # --- variables

    def _get(self, vrs: list[int], kind: str) -> list[Any]:
        try:
            request = self._requests[kind]
            if vrs != request.references:
                request = self._requests[kind] = Request(vrs, self._table, self._place_of, kind)
            if self._outdated and request.needs_outputs:
                self._update()
            if self._late_outdated and request.last >= self._peaks.start:
                self._update_the_rest()
            return request.of(self._values)
        except Exception as error:
            self._fail(rules.NOT_READ % (self._time, _message_of(error)))

    def _set(self, vrs: list[int], values: list[Any], kind: str) -> None:
        if self._mode == Mode.TERMINATED:
            self._fail(rules.NOTHING_SET)
        places = [self._place_of.get(reference, -1) for reference in vrs]
        for place, reference in zip(places, vrs, strict=True):
            self._check_settable(place, reference, kind)
        self._watch_inputs(places, values)
        for place, value in zip(places, values, strict=True):
            self._values[place] = value
            if place == self._place[TOLERANCE]:
                self._tolerance_set = True
            if place >= self._parameters.start:
                self._retune = self._mode == Mode.STEPPING
            elif place < len(self._inputs):
                self._input_time = self._time
        self._inputs_stand, self._outdated = False, True

    def _check_settable(self, place: int, reference: int, kind: str) -> None:
        known = place >= 0 and self._table[place].kind in ACCESS[kind]
        if not known or self._table[place].causality == "output":
            self._fail(rules.NOT_SETTABLE % (reference, kind))
        variable = self._table[place]
        if self._mode == Mode.STEPPING and variable.variability == "fixed":
            self._fail(rules.FIXED % variable.name)

    # As PythonFMU calls them. Outputs are brought up to date with time and inputs first. Inputs and tunable parameters
    # can be set before any step, other parameters before the end of initialization, no Boolean.
    get_integer, set_integer = partialmethod(_get, kind="Integer"), partialmethod(_set, kind="Integer")
    get_boolean, set_boolean = partialmethod(_get, kind="Boolean"), partialmethod(_set, kind="Boolean")
    get_string, set_string = partialmethod(_get, kind="String"), partialmethod(_set, kind="String")

    def get_real(self, vrs: list[int]) -> list[Any]:
        """Get values as the other getters do; called at every step, and therefore not a partial method."""
        return self._get(vrs, "Real")

    def set_real(self, vrs: list[int], values: list[Any]) -> None:
        """Set values as the other setters do; inputs, which are set at every step, skip the check."""
        own, input_of = self._values, self._input_of
        known = self._mode is STEPPING
        for reference in vrs:
            known = known and reference in input_of
        if not known:
            self._set(vrs, values, "Real")
            return
        if self._body.drive.is_chosen:
            self._watch_inputs([input_of[reference] for reference in vrs], values)
        for reference, value in zip(vrs, values, strict=True):
            own[input_of[reference]] = value
        self._input_time = self._time
        self._inputs_stand, self._outdated = False, True

    def _watch_inputs(self, places: list[int], values: list[Any]) -> None:
        """Warn once that an input has no effect, if new values change it in a run of a driven base."""
        if self._mode is not STEPPING or not self._body.drive.is_chosen:
            return
        stepper = self._stepper
        is_coupled = bool(stepper.counts.started and stepper.arrays.base[self._body.base.index("coupled")])
        for place, value in zip(places, values, strict=True):
            if place < len(self._inputs) and value != self._values[place]:
                self._warn_of_idle(self._inputs[place].name, is_coupled)

    def _update(self) -> None:
        """Update the outputs, except peaks and verdict, which are read less often."""
        if self._mode is not STEPPING:
            if self._mode == Mode.INSTANTIATED:
                raise InputError(rules.TOO_EARLY)
            if self._mode == Mode.INITIALIZATION:
                self._build()
        stepper = self._stepper
        if stepper is None:  # terminated before a run: keep the start values
            return
        if self._retune:
            self._apply_parameters(stepper)
            self._retune = False
        if not self._inputs_stand:
            stepper.drive(self._time, *self._values[: len(self._inputs)], since=self._input_time)
        if self._mode is not STEPPING and self._mode == Mode.INITIALIZATION:
            stepper.stand_on_base()
        stepper.observe(self._time)
        self._values[self._seen] = stepper.seen.tolist()
        self._outdated, self._late_outdated = False, True

    def _update_the_rest(self) -> None:
        """Update peaks and verdict, after all other outputs."""
        self._late_outdated = False
        stepper = self._stepper
        if stepper is None:
            return
        self._values[self._peaks] = stepper.visible_peaks.tolist()
        fallen, when = stepper.fallen, stepper.fall_time
        word = "overturned" if fallen else "standing" if stepper.counts.resting else "undecided"
        self._tell_verdict(when if fallen else -1.0, fallen, fallen > 0, VERDICT.items[word])

    # --- parameters

    def _described(self, values: list[Any] | None = None) -> Any:
        """Return the description that the parameters give. Raises InputError."""
        values = self._values if values is None else values
        return self._body.described(lambda name: values[self._place[name]])

    def _loaded(self, name: str, scale: float) -> tuple[Record | None, str]:
        """Return the scaled record of a name, and the key under which it is cached. Raises InputError."""
        check_number(RECORD_SCALE, scale, *rules.SCALE_LIMITS)
        if not name:
            return None, ""
        known_as = f"{name} times {scale}"
        if known_as == self._record_name:
            return self._record, known_as
        own = self._own_record is not None and name == self._own_record.name
        motion = Motion.from_file(self._own_record if own and self._own_record else Path(name))
        return Record(motion.scaled(scale)), known_as

    def _build(self) -> None:
        """Make stepper and record from the current parameters. Raises InputError."""
        parameters = self._values[self._parameters]
        if self._stepper is not None and parameters == self._built_from:
            return
        values = self._values
        body, described = self._body, self._described()
        record, name = self._loaded(values[self._place[RECORD]], values[self._place[RECORD_SCALE]])
        stepper = body.stepper(described)
        stepper.record = body.samples(record.motion if record else None)
        stepper.observe(self._time)  # compiles now, if necessary, and not in the first step
        body.stepper(described).advance(0.0, 1e-6)
        self._stepper, self._record, self._record_name = stepper, record, name
        self._built_from = parameters
        self._put(RECORD_PGA.name, record.pga if record else 0.0)
        self._inputs_stand, self._outdated = False, True

    def _apply_parameters(self, stepper: Any) -> None:
        """Apply the current tunable parameters to the stepper. Raises InputError."""
        self._body.retune(stepper, self._described())
        self._built_from = self._values[self._parameters]

    def _put(self, name: str, value: float | int | bool) -> None:
        self._values[self._place[name]] = value

    def _tell_verdict(self, *verdict: float | int | bool) -> None:
        for place, value in zip(self._verdict, verdict, strict=True):
            self._values[place] = value

    # --- messages

    def _check_mode(self, what: str, *modes: Mode) -> None:
        if self._mode not in modes:
            self._fail(rules.WRONG_MODE % (what, self._mode))

    def _say(self, status: Fmi2Status, message: str) -> None:
        """Send a message to the master's logger, and to stderr in case the logger is turned off."""
        self.log(message, status)
        with contextlib.suppress(OSError, ValueError):  # a host may have closed it
            print(f"{self.instance_name}: {message}", file=sys.stderr)

    def _fail(self, message: str) -> NoReturn:
        """Report an error, and leave through the wrapper's only exit, an exception, with the instance kept alive."""
        self._say(Fmi2Status.error, message)
        survive_exception(self, type(self), self.log_queue)
        raise RuntimeError(message)


def _message_of(error: Exception) -> str:
    """Return the message of an error, never empty."""
    return str(error) or repr(error)
