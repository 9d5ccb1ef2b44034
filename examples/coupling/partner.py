"""A partner of a column as a slave of PythonFMU: a body whose acceleration follows from R0 and mass.

A partner carries the column on a rigid body. At every communication point it solves

    (M_own + M_column) a = forces of its own + R0

for the acceleration a of that body, of the same instant, and offers a with a slope. Over the step it moves by that
very acceleration a + slope (t - t0), which is what the column is given too: both sides follow one motion, and the
equation is met at the communication points. With the line through the last two accelerations that is the explicit
method of Adams and Bashforth of order 2, with the column itself integrated by its own solver; with the parabola through
the last three, of which the line that gives the same velocity at the end is taken, that of order 3.

Standard library and PythonFMU only: the FMU needs no numpy. `to_xml` runs in the project, where the FMU is built.
"""

import math
import sys
from pathlib import Path
from types import ModuleType
from typing import ClassVar

from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

from .host import finalize_at_exit, leave_search_path, survive_exception
from .law import BEFORE, is_finite, later, power, remember, slopes


class Partner(Fmi2Slave):
    """A body that carries a column; `law` is the module that says what it has and how it moves, such as isolator.py."""

    log_categories: ClassVar = {
        "logStatusWarning": "What may be a mistake",
        "logStatusDiscard": "Why a step was not made",
        "logStatusError": "Why the slave cannot go on",
        "logStatusFatal": "What the wrapper could not handle",
        "logAll": "Everything else",
    }
    law: ModuleType

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        resources = Path(self.resources)
        if "logger" in kwargs:
            finalize_at_exit(resources)
            leave_search_path(resources)
        self.modelName = self.law.TITLE
        guid = resources / "guid.txt"
        if guid.is_file():
            self.guid = guid.read_text(encoding="utf-8").strip()
        ports = self.law.PORTS
        self._names = ["", *(port.name for port in ports)]  # by their references, which count from 1
        self._numbers = {port.name: port.start for port in ports}
        self._inputs = [port for port in ports if port.causality == "input"]
        self._given = [port for port in ports if port.causality != "output"]
        self._outputs = [port.name for port in ports if port.causality == "output"]
        self._time = 0.0
        self._fresh = False
        self._begin()

    def _begin(self):
        """Begin from rest."""
        self.motion = [0.0] * self.law.MOTION
        self._before = [0.0] * BEFORE
        self._work = 0.0  # J, given to the column so far
        self._fresh = False

    def _value(self):
        """Return inputs and parameters as the functions of the law take them. Raises ValueError."""
        values = []
        for port in self._given:
            value = self._numbers[port.name]
            if port.words:
                if value not in port.words:
                    raise ValueError(f"{port.name} = {value!r}: must be {', '.join(port.words)}")
                value = port.words.index(value)
            elif not port.limits[0] <= value <= port.limits[1] and port.causality == "parameter":
                raise ValueError(f"{port.name} = {value}: must be {port.limits[2]}")
            values.append(value)
        return self.law.Given(*values)

    def _accelerations(self, value):
        """Return the accelerations of this instant, and their slopes."""
        a = self.law.accelerations(value, self.motion)
        return a, slopes(value.slope, self.law.given_slopes(value), a, self._before)

    def do_step(self, current_time, step_size):
        """Move on by step_size s."""
        if not (math.isfinite(step_size) and step_size > 0.0):  # no shorter one is any better: not a Discard
            self._fail(f"step from t = {current_time} s of {step_size} s not made: the step must be a positive time")
        reason, before = "", list(self.motion)
        try:
            for port in self._inputs:
                if not math.isfinite(self._numbers[port.name]):
                    raise ValueError(f"{port.name} = {self._numbers[port.name]}: must be a finite number")
            value = self._value()
            a, slope = self._accelerations(value)
            if not is_finite(a):
                raise ValueError("the acceleration is no finite number")
            given = power(self.law.needs(value, self.motion, a), self.law.velocities(self.motion))
            self.law.move(value, self.motion, a, slope, step_size)
            a_end = later(a, slope, step_size)
            given += power(self.law.needs(value, self.motion, a_end), self.law.velocities(self.motion))
            self._work += 0.5 * step_size * given
        except (ArithmeticError, ValueError) as error:
            reason = str(error)
        if reason:
            self.motion = before
            self._say(Fmi2Status.discard, f"step from t = {current_time} s not made: {reason}")
            return False
        remember(self._before, a, step_size)
        self._fresh = False
        self._time = current_time + step_size
        return True

    def _get(self, references):
        try:
            if not self._fresh:
                value = self._value()
                a, slope = self._accelerations(value)
                found = (*self.law.outputs(value, self.motion, a, slope), self._work)
                self._numbers.update(zip(self._outputs, found, strict=True))
                self._fresh = True
            return [self._numbers[self._names[reference]] for reference in references]
        except Exception as error:
            self._fail(error)

    def _set(self, references, values):
        try:
            for reference, value in zip(references, values, strict=True):
                name = self._names[reference]
                if name in self._outputs:
                    raise ValueError(f"{name}: is an output")
                self._numbers[name] = value
            self._fresh = False
        except Exception as error:
            self._fail(error)

    get_real = get_string = _get
    set_real = set_string = _set

    def exit_initialization_mode(self):
        """Begin from rest under the parameters as they stand."""
        try:
            self._value()
            self._begin()
        except Exception as error:
            self._fail(error)

    def _say(self, status, message):
        self.log(message, status)
        print(f"{self.instance_name}: {message}", file=sys.stderr)

    def _fail(self, error):
        self._say(Fmi2Status.error, str(error))
        survive_exception(self, type(self), self.log_queue)
        raise RuntimeError(str(error))

    def _get_fmu_state(self):
        return {
            "numbers": dict(self._numbers),
            "motion": list(self.motion),
            "before": list(self._before),
            "time": self._time,
            "work": self._work,
        }

    def _set_fmu_state(self, state):
        self._numbers = dict(state["numbers"])
        self.motion, self._before = list(state["motion"]), list(state["before"])
        self._time, self._work = state["time"], state["work"]
        self._fresh = False

    def to_xml(self, model_options=None):
        """Return the model description, written as that of the column is."""
        from partner_table import description

        return description(self.law, str(self.guid))
