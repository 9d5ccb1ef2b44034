"""What a column can be coupled with: a slave whose acceleration follows from the column's split reaction.

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
from typing import ClassVar, NamedTuple

from pythonfmu import Fmi2Slave

from .host import finalize_at_exit, leave_search_path, survive_exception

PARABOLA, LINE, HELD, GIVEN = "parabola", "line", "held", "given"
ALIKE = 1e-6  # of a step: steps that differ by less are the same


class Port(NamedTuple):
    """One variable: a row of the partner's table."""

    name: str
    causality: str
    unit: str
    description: str
    start: object = None
    depends_on: tuple = ()


def port_input(name, unit, description):
    return Port(name, "input", unit, description, 0.0)


def port_output(name, unit, description, depends_on=()):
    return Port(name, "output", unit, description, None, tuple(depends_on))


def parameter(name, unit, description, start):
    return Port(name, "parameter", unit, description, start)


def slope_parameter(start):
    """How the body accelerates within a step."""
    text = "Slope within a step: parabola (of the steps before), line (since the step before), held (none), given"
    return parameter("slope", "", text, start)


class Partner(Fmi2Slave):
    """A body that carries a column. Subclasses say what it has and how it moves.

    axes: names of the accelerations; for each there is an input given.<axis>, the slope followed where slope = "given".
    """

    log_categories: ClassVar = {
        "logStatusWarning": "What may be a mistake",
        "logStatusDiscard": "Why a step was not made",
        "logStatusError": "Why the slave cannot go on",
        "logStatusFatal": "What the wrapper could not handle",
        "logAll": "Everything else",
    }
    title = ""
    about = ""
    ports: tuple = ()
    axes: tuple = ()

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        resources = Path(self.resources)
        if "logger" in kwargs:
            finalize_at_exit(resources)
            leave_search_path(resources)
        self.modelName = self.title
        guid = resources / "guid.txt"
        if guid.is_file():
            self.guid = guid.read_text(encoding="utf-8").strip()
        self._names = [port.name for port in self.ports]
        self._numbers = {port.name: port.start for port in self.ports}
        self._time = 0.0
        self._before = []  # the last steps, the latest first: their length, s, and the accelerations at their start
        self._fresh = False
        self._work = 0.0  # J, given to the column so far
        self.motion = self.at_start()

    # --- what a subclass has to say

    def at_start(self):
        """Everything that changes from step to step, as a list of numbers."""
        raise NotImplementedError

    def accelerations(self):
        """Accelerations of the body along `axes`, from `motion` and the inputs."""
        raise NotImplementedError

    def needs(self, a):
        """Forces (and moment) that the body needs of the column to accelerate by a: what its equation lacks."""
        raise NotImplementedError

    def velocities(self):
        """Velocities of the body along `axes`, in space."""
        raise NotImplementedError

    def move(self, a, slope, h):
        """Take `motion` over h s under accelerations a + slope s."""
        raise NotImplementedError

    def outputs(self, a, slope):
        """Values of the outputs by name."""
        raise NotImplementedError

    # --- what is common

    def value(self, name):
        """Input or parameter."""
        return self._numbers[name]

    def slopes(self, a):
        """How the accelerations go on from here, per s."""
        way = self.value("slope")
        if way == GIVEN:
            return [self.value(f"given.{axis}") for axis in self.axes]
        if way == HELD or not self._before:
            return [0.0] * len(a)
        step, before = self._before[0]
        line = [(now - then) / step for now, then in zip(a, before, strict=True)]
        if way == LINE or len(self._before) == 1 or abs(self._before[1][0] - step) > ALIKE * step:
            return line
        older = [(then - oldest) / step for then, oldest in zip(before, self._before[1][1], strict=True)]
        return [(11.0 * later - 5.0 * earlier) / 6.0 for later, earlier in zip(line, older, strict=True)]

    def do_step(self, current_time, step_size):
        """Move on by step_size s."""
        numbers = [value for value in self._numbers.values() if isinstance(value, float)]
        reason = ""
        if not (math.isfinite(step_size) and step_size > 0.0):  # no shorter one is any better: not a Discard
            self._fail(f"step from t = {current_time} s of {step_size} s not made: the step must be a positive time")
        if not all(map(math.isfinite, numbers)):
            reason = "an input or a parameter is no finite number"
        elif self.value("slope") not in (PARABOLA, LINE, HELD, GIVEN):
            reason = f"slope = {self.value('slope')!r}: must be parabola, line, held or given"
        else:
            try:
                a = self.accelerations()
                slope = self.slopes(a)
                power = self._power(a)
                self.move(a, slope, step_size)
                power += self._power([first + step_size * each for first, each in zip(a, slope, strict=True)])
                self._work += 0.5 * step_size * power
            except (ArithmeticError, ValueError) as error:
                reason = str(error)
        if reason:
            print(f"{self.instance_name}: step from t = {current_time} s not made: {reason}", file=sys.stderr)
            return False
        self._before = [[step_size, a], *self._before[:1]]
        self._fresh = False
        self._time = current_time + step_size
        return True

    def _power(self, a):
        """What the body gives to the column, W, by its own law: by the column's it is the same but for the coupling."""
        return -sum(need * v for need, v in zip(self.needs(a), self.velocities(), strict=True))

    def _get(self, references):
        try:
            if not self._fresh:
                a = self.accelerations()
                self._numbers.update(self.outputs(a, self.slopes(a)))
                self._numbers["work"] = self._work
                self._fresh = True
            return [self._numbers[self._names[reference]] for reference in references]
        except Exception as error:
            self._fail(error)

    def _set(self, references, values):
        try:
            for reference, value in zip(references, values, strict=True):
                if self.ports[reference].causality == "output":
                    raise ValueError(f"{self._names[reference]}: is an output")
                self._numbers[self._names[reference]] = value
            self._fresh = False
        except Exception as error:
            self._fail(error)

    get_real = get_string = _get
    set_real = set_string = _set

    def exit_initialization_mode(self):
        """Begin from rest under the parameters as they stand."""
        try:
            self.motion = self.at_start()
            self._work, self._before, self._fresh = 0.0, [], False
        except Exception as error:
            self._fail(error)

    def _fail(self, error):
        print(f"{self.instance_name}: {error}", file=sys.stderr)
        survive_exception(self, type(self), self.log_queue)
        raise RuntimeError(str(error))

    def _get_fmu_state(self):
        return {
            "numbers": dict(self._numbers),
            "motion": list(self.motion),
            "before": [list(step) for step in self._before],
            "time": self._time,
            "work": self._work,
        }

    def _set_fmu_state(self, state):
        self._numbers = dict(state["numbers"])
        self.motion = list(state["motion"])
        self._before = [list(step) for step in state["before"]]
        self._time, self._work = state["time"], state["work"]
        self._fresh = False

    def to_xml(self, model_options=None):
        """The model description, written as that of the column is."""
        from fmu_src.model_description import Experiment, model_description
        from fmu_src.variables import Variable

        table = []
        parameters = tuple(port.name for port in self.ports if port.causality == "parameter")
        for reference, port in enumerate(self.ports):
            variability = "fixed" if port.causality == "parameter" else "continuous"
            kind = "String" if isinstance(port.start, str) else "Real"
            table.append(
                Variable(
                    port.name, reference, kind, port.causality, variability, port.description, port.unit, port.start,
                    depends_on=port.depends_on, initially=(*port.depends_on, *parameters),
                )
            )  # fmt: skip
        return model_description(self.title, str(self.guid), self.about, "1", table, Experiment())


def travel(position, rate, acceleration, slope, h):
    """(position, rate) after h s."""
    return (
        position + h * (rate + h * (0.5 * acceleration + h * slope / 6.0)),
        rate + h * (acceleration + 0.5 * h * slope),
    )
