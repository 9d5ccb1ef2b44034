"""Calls to a native FMU in any order, with right and wrong arguments: `python random_calls.py FILE.fmu COUNT [SEED]`.

Every kind of call is to succeed at times, bytes that are no state and pointers to nothing never; afterwards the
instance does what a new one does. Bytes of a state in which numbers were changed, under a right checksum, may be taken
or not.
"""

from __future__ import annotations

import ctypes
import random
import sys
import time
from typing import Any

from fmpy.fmi2 import fmi2Integer, fmi2Real, fmi2ValueReference

from support.inside.hostile import FMI2_CALLS, changed, with_null
from support.instance import Instance

NUMBERS = [0.0, 1.0, -1.0, 0.01, 1e-7, 1e300, float("nan"), float("inf")]
NEVER = ("damaged", "null")  # succeed
PATIENCE = 10.0  # s of the processor for any call
WORDS = ["", "rest", "elastic, rest", "nonsense", "x" * 400]


class Caller:
    """One instance and what was got from it so far."""

    def __init__(self, fmu: str, seed: int) -> None:
        self.some = random.Random(seed)
        self.column = Instance(fmu, initialize=False)
        self.names = list(self.column.variables)
        self.states: list[Any] = []
        self.longest = 0.0  # s of the processor, of one call
        self.calls = {
            self.get: 8,
            self.set: 4,
            self.push: 8,
            self.step: 16,
            self.odd_step: 2,
            self.set_up: 1,
            self.enter: 1,
            self.exit: 1,
            self.initialize: 4,
            self.terminate: 1,
            self.reset: 2,
            self.save: 2,
            self.restore: 2,
            self.through_bytes: 1,
            self.damaged: 1,
            self.changed: 2,
            self.null: 2,
            self.rates: 2,
            self.effective_mass: 2,
            self.slope: 2,
        }

    def run(self, count: int) -> dict[str, int]:
        """Make random calls; return the number of each kind that was answered with OK."""
        succeeded = dict.fromkeys((call.__name__ for call in self.calls), 0)
        for _ in range(count):
            (call,) = self.some.choices(list(self.calls), list(self.calls.values()))
            begun = time.process_time()
            try:
                call()
            except Exception:
                continue
            finally:
                self.longest = max(self.longest, time.process_time() - begun)
                if len(self.states) > 20:
                    self.column.fmi.freeFMUState(self.states.pop(0))
            succeeded[call.__name__] += 1
        for state in self.states:
            self.column.fmi.freeFMUState(state)
        return succeeded

    def now(self) -> float:
        """End of the last step, s."""
        reached = ctypes.c_double()
        self.column.fmi.dll.fmi2GetRealStatus(self.column.fmi.component, 2, ctypes.byref(reached))
        return reached.value

    def get(self) -> None:
        self.column.get(*self.some.sample(self.names, 5))

    def set(self) -> None:
        name = self.some.choice(self.names)
        variable = self.column.variables[name]
        start = float(variable.start or 0.0) if variable.type == "Real" else 0.0
        numbers = [0.0, -1.0, float("nan"), float("inf"), 0.9 * start, 1.1 * start, start]
        kinds: dict[str, list[Any]] = {"String": WORDS, "Enumeration": [0, 1, 1, 2, 7]}
        values = kinds.get(variable.type, numbers)
        self.column.set({name: self.some.choice(values)})

    def push(self) -> None:
        self.column.set({"base.ax": self.some.uniform(-2.0, 2.0)})

    def step(self) -> None:
        self.column.step(self.now(), self.some.choice([1e-3, 0.01, 0.1]))

    def odd_step(self) -> None:
        self.column.step(self.some.choice([self.now(), *NUMBERS]), self.some.choice(NUMBERS))

    def set_up(self) -> None:
        stop, tolerance = self.some.choice([None, 5.0, -1.0, NUMBERS[-2]]), self.some.choice([None, 1e-6, 0.0])
        start = self.some.choice(NUMBERS[:4] + NUMBERS[-2:])
        self.column.fmi.setupExperiment(tolerance=tolerance, startTime=start, stopTime=stop)

    def enter(self) -> None:
        self.column.fmi.enterInitializationMode()

    def exit(self) -> None:
        self.column.fmi.exitInitializationMode()

    def initialize(self) -> None:
        self.column.initialize()

    def terminate(self) -> None:
        self.column.fmi.terminate()

    def reset(self) -> None:
        self.column.fmi.reset()

    def save(self) -> None:
        self.states.append(self.column.fmi.getFMUState())

    def restore(self) -> None:
        self.column.fmi.setFMUState(self.some.choice(self.states))

    def through_bytes(self) -> None:
        data = self.column.fmi.serializeFMUstate(self.some.choice(self.states))
        self.states.append(self.column.fmi.deSerializeFMUstate(data))

    def damaged(self) -> None:
        self.column.fmi.deSerializeFMUstate(bytes(self.some.randrange(256) for _ in range(500)))

    def changed(self) -> None:
        data = self.column.fmi.serializeFMUstate(self.some.choice(self.states))
        self.states.append(self.column.fmi.deSerializeFMUstate(changed(data, self.some)))

    def null(self) -> None:
        name = self.some.choice([*FMI2_CALLS])
        self._check(self.some.choice(with_null("fmi2", self.column.fmi.dll, self.column.fmi.component, name))())

    def _reference(self, name: str) -> Any:
        return (fmi2ValueReference * 1)(self.column.variables[name].valueReference)

    def _check(self, status: int) -> None:
        if status:
            raise ValueError(f"status {status}")

    def rates(self) -> None:
        fmi, value = self.column.fmi, (fmi2Real * 1)()
        one = (self._reference(self.some.choice(self.names)), 1, (fmi2Integer * 1)(1))
        self._check(fmi.dll.fmi2GetRealOutputDerivatives(fmi.component, *one, value))

    def effective_mass(self) -> None:
        of, by = (self.column.variables[name].valueReference for name in ("base.Fx", self.some.choice(self.names[:8])))
        self.column.fmi.getDirectionalDerivative([of], [by], [1.0])

    def slope(self) -> None:
        fmi = self.column.fmi
        one = (self._reference(self.some.choice(self.names[:8])), 1, (fmi2Integer * 1)(1), (fmi2Real * 1)(1.0))
        self._check(fmi.dll.fmi2SetRealInputDerivatives(fmi.component, *one))


def usual(column: Instance) -> list[Any]:
    """Return the outputs of a run that is always the same."""
    column.fmi.reset()
    column.initialize()
    column.set({"base.ax": 1.2})
    column.step(0.0, 0.5)
    return column.get()


def main(fmu: str, count: int, seed: int = 3) -> int:
    """Return the exit code."""
    caller = Caller(fmu, seed)
    succeeded = caller.run(count)
    never = [name for name, times in succeeded.items() if not times and name not in NEVER]
    fresh = Instance(fmu)
    same = usual(caller.column) == usual(fresh)
    for column in (caller.column, fresh):
        column.close()
    print(
        f"{count} calls, of which {sum(succeeded.values())} succeeded; never: {', '.join(never) or 'none'}; "
        f"the longest took {caller.longest:.1f} s"
    )
    return 0 if same and not never and caller.longest < PATIENCE and not any(succeeded[name] for name in NEVER) else 1


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1], *map(int, sys.argv[2:])))
