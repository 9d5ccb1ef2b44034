"""FMI 2.0 calls in any order against the standard's table of legal states, in a process that may die of them.

    python -m stress.fmi_machine FILE.fmu FOLDER

with the FMU's files unpacked in FOLDER, reads one sequence of calls a line (JSON) and answers each with one line:
{"problem": null or text, "calls": number}.

A legal call has to be accepted (a step may be discarded where the solver cannot follow), an illegal or wrong one
refused, with the instance as it was: at the end the accepted calls alone, made to a fresh instance, have to give the
same outputs to the last bit.
"""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import json
import math
import os
import sys
from collections.abc import Callable
from typing import Any

from fmpy import read_model_description
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

OK, WARNING, DISCARD, ERROR, FATAL = range(5)

INSTANTIATED = "instantiated"
INITIALIZATION = "initialization mode"
COMPLETE = "step complete"
FAILED = "step failed"
TERMINATED = "terminated"
STATES = ("save", "restore", "serialize", "deserialize")

# FMI 2.0.4, section 4.2.4, the table of the calling sequence for co-simulation, without what is not declared
LEGAL = {
    INSTANTIATED: {"setup", "enter", "set", "reset", "debug", "null", *STATES},
    INITIALIZATION: {"exit", "get", "set", "reset", "debug", "null", *STATES},
    COMPLETE: {"step", "get", "set", "terminate", "reset", "debug", "null", *STATES},
    FAILED: {"get", "terminate", "reset", "debug", "null", *STATES},
    TERMINATED: {"get", "reset", "debug", "null", *STATES},
}
# calls that the standard does not allow and a slave may grant all the same, because they do no harm
GRANTED = {
    INSTANTIATED: {"exit", "get", "terminate"},  # initialization mode left without a call in it; values that were set
    INITIALIZATION: {"terminate"},
    TERMINATED: {"terminate"},
    FAILED: {"step", "set"},  # the column is as it was before the step
}

# contents from which no instance can be made, behind a right checksum
NO_STATES = {"empty": b"", "no state": b"{}", "deep": b"[" * 100000}
# calls with a pointer to nothing: 0; p: room, 1: a number
NULL_CALLS = {
    **{
        f"fmi2{way}{kind} {k}": given
        for way in ("Get", "Set")
        for kind in ("Real", "Integer", "Boolean", "String")
        for k, given in enumerate(("01p", "p10"))
    },
    **{"fmi2GetFMUstate": "0", "fmi2SetFMUstate": "0", "fmi2SerializedFMUstateSize": "0p"},
    **{"fmi2SerializeFMUstate": "0p1", "fmi2DeSerializeFMUstate": "01p"},
}
NULLS = [*NULL_CALLS]

NO_STEP = ("a step that is no positive time", "a step from another time")
POSITIVE = {"height", "width", "depth", "mass", "stiffness"}
LARGEST = 1e100  # m/s2: outputs under larger inputs are not judged
SMALL, LARGE = 1e-6, 1e11  # parameters in between must not be refused for their size


KINDS = ("Real", "Integer", "Enumeration", "Boolean", "String")


def started(variables: dict[str, Any]) -> dict[str, Any]:
    """Return the start values of the parameters."""
    kinds: dict[str, Callable[[Any], Any]] = {"Real": float, "Enumeration": int, "String": str}
    return {n: kinds[v.type](v.start) for n, v in variables.items() if v.causality == "parameter"}


class RefusedError(Exception):
    """A call that was answered with anything but OK or a warning."""

    def __init__(self, status: int) -> None:
        super().__init__(f"status {status}")
        self.status = status


class ProblemError(Exception):
    """The FMU did something that must not happen."""


class Slave:
    """One instance of the FMU."""

    def __init__(self, library: FMU2Slave, variables: dict[str, Any]) -> None:
        self.fmi = library
        self.variables = variables
        self.outputs = [v for v in variables.values() if v.causality == "output"]
        self.fmi.instantiate(callbacks=CALLBACKS)
        self.component = self.fmi.component
        self.bare = ctypes.CDLL(library.dll._name)  # without FMPy's types of arguments

    def call(self, name: str, *arguments: Any) -> Any:
        """Call a method of FMPy's on this instance. Raises RefusedError."""
        self.fmi.component = self.component
        try:
            return getattr(self.fmi, name)(*arguments)
        except Exception as error:
            raise RefusedError(getattr(error, "status", -1)) from error

    def set(self, name: str, value: Any) -> None:
        variable = self.variables[name]
        kind = "Integer" if variable.type == "Enumeration" else variable.type
        self.call(f"set{kind}", [variable.valueReference], [value])

    def get(self, names: list[str]) -> list[Any]:
        values = []
        for kind in KINDS:
            chosen = [self.variables[n].valueReference for n in names if self.variables[n].type == kind]
            if chosen:
                values += self.call(f"get{'Integer' if kind == 'Enumeration' else kind}", chosen)
        return values

    def free(self) -> None:
        self.fmi.component = self.component
        self.fmi.fmi2FreeInstance(self.component)


class Machine:
    """The state of the instance according to the standard, and the calls and values it has been given."""

    def __init__(self, new: Callable[[], Slave]) -> None:
        self.new = new
        self.slave = new()
        self.log: list[list[Any]] = []  # accepted calls since instantiation
        self.mode = INSTANTIATED
        self.time = 0.0
        self.inputs: dict[str, Any] = {}
        self.values = started(self.slave.variables)
        self.saved: list[tuple[Any, tuple[Any, ...]]] = []
        self.calls = 0

    def _story(self) -> tuple[Any, ...]:
        return list(self.log), self.mode, self.time, dict(self.inputs), dict(self.values)

    # --- validity of values

    def _input_is_wrong(self) -> bool:
        """Return True if an input is no number, or so large that outputs are not judged."""
        return not all(abs(v) <= LARGEST for v in self.inputs.values())

    def _parameters(self) -> str:
        """Return "wrong", "right", or "unknown" where the answer depends on more than the values themselves."""
        sure = True
        for name, value in self.values.items():
            key = name.rpartition(".")[2]
            contact = name.startswith("joint") and key in ("width", "depth")
            if isinstance(value, str):
                sure = sure and value == self.slave.variables[name].start
            elif (
                not math.isfinite(value)
                or (value < 0.0 and not name.startswith("base."))
                or (value == 0.0 and (key == "step" or (key in POSITIVE and not contact)))
                or (key == "tolerance" and not 1e-13 <= value <= 0.1)
            ):
                return "wrong"
            elif value != 0.0 and key != "tolerance" and not SMALL <= value <= LARGE:
                sure = False
        for i in range(1, sum(name.endswith(".mass") for name in self.values) + 1):
            block = {key: self.values[f"block[{i}].{key}"] for key in ("height", "width", "depth", "centroid")}
            joint = {key: self.values[f"joint[{i}].{key}"] for key in ("width", "depth")}
            if (
                block["centroid"] >= block["height"]
                or joint["width"] > block["width"]
                or joint["depth"] > block["depth"]
            ):
                return "wrong"
        return "right" if sure else "unknown"

    # --- one call

    def make(self, call: list[Any]) -> None:
        """Make a call and judge the status. Raises ProblemError."""
        name, *arguments = call
        legal = name in LEGAL[self.mode]
        granted = name in GRANTED.get(self.mode, ())
        self.calls += 1
        before = self.mode
        try:
            wrong = getattr(self, f"_{name}")(*arguments)
        except RefusedError as refused:
            if legal and not self._may_refuse(name, arguments, refused.status):
                raise ProblemError(f"{call} in {before}: refused with status {refused.status}") from refused
            if name == "step" and refused.status == DISCARD and self.mode == COMPLETE:
                self.mode = FAILED
            return
        if wrong:
            raise ProblemError(f"{call} in {before}: accepted: {wrong}")
        if not legal and not granted:
            raise ProblemError(f"{call} in {before}: accepted, is not legal there")

    def _may_refuse(self, name: str, arguments: list[Any], status: int) -> bool:
        if name == "null":
            return True
        if name == "setup":
            return not math.isfinite(arguments[0])
        if name == "exit":
            return self._parameters() != "right"
        if name == "step":
            return True  # the step was wrong, or the solver cannot follow; the caller checks the status
        if name == "set":
            return self._set_is_wrong(*arguments)
        if name == "get":
            return arguments[0] in ("unknown reference", "wrong kind") or self._get_may_fail()
        if name == "deserialize":
            return arguments[1] != "whole"
        return False

    def _get_may_fail(self) -> bool:
        # outputs of initialization follow from the parameters as they stand; tunable ones may stand wrong later
        return self._parameters() != "right"

    def _set_is_wrong(self, name: str, value: Any) -> bool:
        variable = self.slave.variables[name]
        if variable.causality == "output":
            return True
        return variable.causality == "parameter" and self.mode == COMPLETE and variable.variability != "tunable"

    # --- the calls: each returns what was wrong with it, if it was accepted

    def _setup(self, start: float) -> str | None:
        self.slave.call("setupExperiment", None, start)
        if not math.isfinite(start):
            return "a start time that is no number"
        self.time = start
        self.log.append(["setup", start])
        return None

    def _enter(self) -> None:
        self.slave.call("enterInitializationMode")
        self.log.append(["enter"])
        self.mode = INITIALIZATION

    def _exit(self) -> str | None:
        self.slave.call("exitInitializationMode")
        if self._parameters() == "wrong":
            return "parameters that cannot be"
        self.log.append(["exit"])
        self.mode = COMPLETE
        return None

    def _terminate(self) -> None:
        self.slave.call("terminate")
        self.log.append(["terminate"])
        self.mode = TERMINATED

    def _reset(self) -> None:
        self.slave.call("reset")
        self.log, self.mode, self.time, self.inputs = [], INSTANTIATED, 0.0, {}
        self.values = started(self.slave.variables)

    def _set(self, name: str, value: Any) -> str | None:
        self.slave.set(name, value)
        if self._set_is_wrong(name, value):
            return "cannot be set there"
        if self.slave.variables[name].causality == "input":
            self.inputs[name] = value
        else:
            self.values[name] = value
        self.log.append(["set", name, value])
        if self.mode == FAILED:
            self.mode = COMPLETE
        return None

    def _get(self, what: str) -> str | None:
        if what == "unknown reference":
            self.slave.call("getReal", [4294967295])
            return "a reference that no variable has"
        if what == "wrong kind":
            self.slave.call("getReal", [self.slave.variables["base.record"].valueReference])
            return "a String got as a Real"
        if what == "parameters":
            names = list(self.values)
            order = [n for kind in KINDS for n in names if self.slave.variables[n].type == kind]
            got = self.slave.get(names)
            for n, value in zip(order, got, strict=True):
                value = value.decode() if isinstance(value, bytes) else value
                if value != self.values[n] and not (value != value and self.values[n] != self.values[n]):
                    return f"{n} is {value!r} and was set to {self.values[n]!r}"
            return None
        values = self.slave.get([v.name for v in self.slave.outputs])
        if self.mode == INSTANTIATED:
            return "outputs before initialization"
        self._judge_outputs(values)
        return None

    def _judge_outputs(self, values: list[Any]) -> None:
        if self._input_is_wrong():
            return
        names = [v.name for kind in KINDS for v in self.slave.outputs if v.type == kind]
        for name, value in zip(names, values, strict=True):
            if isinstance(value, float) and not math.isfinite(value):
                raise ProblemError(f"{name} = {value} under inputs and parameters that were accepted")
            if name.endswith((".N", ".sigma_max")) and value < 0.0:
                raise ProblemError(f"{name} = {value}")
            if name.endswith(".contact") and not 0.0 <= value <= 1.0:
                raise ProblemError(f"{name} = {value}")

    def _step(self, offset: float, h: float) -> str | None:
        wrong = None
        if not (math.isfinite(h) and h > 0.0):
            wrong = NO_STEP[0]
        elif offset:
            wrong = NO_STEP[1]
        elif not all(math.isfinite(v) for v in self.inputs.values()):
            wrong = "an input that is no number"
        elif self._parameters() == "wrong":
            wrong = "a parameter that cannot be"
        try:
            self.slave.call("doStep", self.time + offset, h)
        except RefusedError as refused:
            if refused.status == DISCARD and wrong in NO_STEP:
                raise ProblemError(f"{wrong} was discarded: a master would try a shorter one") from refused
            moderate = all(abs(v) <= 20.0 for v in self.inputs.values()) and self._parameters() == "right"
            if self.mode == COMPLETE and wrong is None and moderate and 1e-6 <= h <= 0.1:
                raise ProblemError(f"a usual step of {h} s was refused with status {refused.status}") from refused
            raise
        if wrong:
            return wrong
        self.log.append(["step", self.time, h])
        self.time += h
        self.mode = COMPLETE
        self._judge_outputs(self.slave.get([v.name for v in self.slave.outputs]))
        return None

    def _null(self, what: str) -> str:
        """Make a call with a pointer to nothing, which is an Error in any state and changes nothing."""
        kinds = NULL_CALLS[what]
        zeros = (ctypes.c_double * 4)()
        given = {"0": None, "p": ctypes.byref(zeros), "1": ctypes.c_size_t(1)}
        status = getattr(self.slave.bare, what.partition(" ")[0])(
            ctypes.c_void_p(self.slave.component), *(given[kind] for kind in kinds)
        )
        if status == ERROR:
            raise RefusedError(status)
        return f"a pointer to nothing, with status {status}"

    def _debug(self, on: bool) -> None:
        self.slave.call("setDebugLogging", on, ["logAll"] if on else [])

    def _save(self) -> None:
        self.saved.append((self.slave.call("getFMUState"), self._story()))

    def _restore(self, k: int) -> None:
        if self.saved:
            state, story = self.saved[k % len(self.saved)]
            self.slave.call("setFMUState", state)
            self._become(story)

    def _become(self, story: tuple[Any, ...]) -> None:
        log, self.mode, self.time, inputs, values = story
        self.log, self.inputs, self.values = list(log), dict(inputs), dict(values)

    def _serialize(self, k: int) -> None:
        if self.saved:
            self.slave.call("serializeFMUState", self.saved[k % len(self.saved)][0])

    def _deserialize(self, k: int, how: str) -> str | None:
        if not self.saved:
            return None
        state, story = self.saved[k % len(self.saved)]
        data = bytearray(self.slave.call("serializeFMUState", state))
        if how == "changed":
            data[(7919 * (k + 1)) % len(data)] ^= 1 << k % 8
        elif how == "cut":
            del data[len(data) // 2 :]
        elif how == "nothing":
            data = bytearray(b"\0" * 10)
        elif how in NO_STATES:  # with the checksum of a PythonFMU's
            data = bytearray(hashlib.sha256(NO_STATES[how]).hexdigest().encode() + NO_STATES[how])
        read = self.slave.call("deSerializeFMUstate", bytes(data))
        self.slave.call("setFMUState", read)
        if how != "whole":
            return "bytes that are no state"
        self._become(story)
        return None

    # --- at the end

    def finish(self) -> None:
        """Repeat the accepted calls on a fresh instance: outputs must be the same; then free it."""
        names = [v.name for v in self.slave.outputs]
        try:
            if self.mode in (COMPLETE, FAILED) and not self._input_is_wrong():
                with contextlib.suppress(RefusedError):  # tunable parameters may stand wrong
                    seen = self.slave.get(names)
                    again = self._replay(names)
                    if repr(again) != repr(seen):
                        raise ProblemError(f"the accepted calls alone give {again}, not {seen}")
        finally:
            for state, _ in self.saved:
                self.slave.call("freeFMUState", state)
            self.slave.free()

    def _replay(self, names: list[str]) -> list[Any]:
        other = self.new()
        try:
            for name, *arguments in self.log:
                try:
                    if name == "setup":
                        other.call("setupExperiment", None, *arguments)
                    elif name == "set":
                        other.set(*arguments)
                    elif name == "step":
                        other.call("doStep", *arguments)
                    else:
                        other.call({"enter": "enterInitializationMode", "exit": "exitInitializationMode"}[name])
                except RefusedError as refused:
                    raise ProblemError(
                        f"{name} {arguments} was accepted and is not when made again: {refused}"
                    ) from refused
            return other.get(names)
        finally:
            other.free()


@fmi2CallbackLoggerTYPE
def _silent(*_arguments: Any) -> None:
    """Take the messages of the FMU and drop them."""


CALLBACKS = fmi2CallbackFunctions()


def main() -> None:
    """Serve sequences until the input ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)  # output of the FMU
    os.dup2(nothing, 2)
    fmu, folder = sys.argv[1:]
    description = read_model_description(fmu)
    variables = {v.name: v for v in description.modelVariables}
    from fmpy import fmi2

    CALLBACKS.logger = _silent
    CALLBACKS.allocateMemory = fmi2.defaultCallbacks.allocateMemory
    CALLBACKS.freeMemory = fmi2.defaultCallbacks.freeMemory
    identifier = description.coSimulation.modelIdentifier
    library = FMU2Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier=identifier, instanceName="column")
    for line in sys.stdin:
        problem = None
        machine = Machine(lambda: Slave(library, variables))
        try:
            for call in json.loads(line):
                machine.make(call)
        except ProblemError as found:
            problem = str(found)
        try:
            machine.finish()
        except ProblemError as found:
            problem = problem or str(found)
        print(json.dumps({"problem": problem, "calls": machine.calls}), file=answers, flush=True)


if __name__ == "__main__":
    main()
