"""Serialized states of FMUs, changed number by number under a right checksum.

    python -m stress.changed_states FILE.fmu SEED FIRST COUNT

makes states FIRST to FIRST + COUNT - 1 of a seeded sequence in this process, which may die of them, and prints a line
(JSON) for each. A state is refused with status Error, or it is taken; then outputs, their derivatives and further steps
have finite numbers or a status other than OK. After each the instance goes on from a whole state with the same bits.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import random
import signal
import struct
import subprocess
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .faults import ROOT, environment, finish

EXAMPLES = ROOT / "examples"
# name -> file, options of build_fmu.py; each also without Python, but the paper's column
SOURCES: dict[str, tuple[str, tuple[str, ...]]] = {
    "column": ("columns/phocas-damped.toml", ()),
    "sliding column with ports": ("columns/portico.toml", ()),
    "brittle column": ("columns/mortar.toml", ()),
    "driven column": ("columns/doric.toml", ("--drive", "body")),
    "column of the paper": ("columns/phocas.toml", ()),
    "bonds": ("structures/parapet.toml", ()),
    "neighbours": ("structures/cask-row.toml", ()),
    "bearings": ("structures/statue-on-pendulums.toml", ()),
    "turning base": ("structures/trilith.toml", ("--turns",)),
    "driven turning base": ("structures/trilith.toml", ("--turns", "--drive", "body")),
}
NATIVE = ("--native", "--platforms", "linux64")
WITHOUT_NATIVE = ("column of the paper",)
PATIENCE = 120  # s of one state
HEADER, DIGEST = 96, 64  # bytes before what a state keeps: native, of a PythonFMU
NAN, INF = math.nan, math.inf
ODD = [NAN, INF, -INF, 0.0, -1.0, 1.0, 2.0, 3.0, 0.5, 5e-324, -1e-300, 200.0, -5.0, 2.5, 5000.0, 1e5, -1e5, 1e6]
ODD += [1e12, -1e15, 1e30, -1e30, 1e100, -1e200, 1e300, sys.float_info.max, -sys.float_info.max]
WHOLE = [-1, 0, 1, 2, 3, 7, 129, 2**31, 2**40, 2**63 - 1, -(2**63)]
LARGEST = 1e6  # of inputs: beyond it outputs need not be finite
STEP = 0.01  # s


def changed(data: bytes, some: random.Random, begin_of_model: int = 0) -> bytes:
    """Return a state in which one number differs, seldom three, under a right checksum.

    begin_of_model: number of the first word of the model at the end of a native state, which is seldom changed: it is
    compared as a whole.
    """
    if data[DIGEST : DIGEST + 1] == b"{":
        return _changed_text(data, some)
    content = bytearray(data[HEADER:])
    for _ in range(some.choice([1, 1, 1, 3])):
        words = len(content) // 8
        place = 8 * some.randrange(begin_of_model if begin_of_model and some.random() < 0.9 else words)
        (number,) = struct.unpack_from("<d", content, place)
        if some.random() < 0.2:
            struct.pack_into("<q", content, place, some.choice(WHOLE))
        else:
            struct.pack_into("<d", content, place, _other(number, some))
    return _sealed(data[:HEADER], content)


def _sealed(head: bytes, content: bytearray) -> bytes:
    """Return a native state with its checksum."""
    checksum = 14695981039346656037
    for byte in content:
        checksum = ((checksum ^ byte) * 1099511628211) % 2**64
    words = head.rstrip(b"\0").split(b"\n")
    words[-1] = f"{checksum:016x}".encode()
    return b"\n".join(words).ljust(HEADER, b"\0") + content


def _changed_text(data: bytes, some: random.Random) -> bytes:
    parts = json.loads(data[DIGEST:])
    lists = [parts["values"], parts["built_from"], *(numbers for _, numbers in parts["arrays"].values())]
    for _ in range(some.choice([1, 1, 1, 3])):
        if some.random() < 0.05:
            name = some.choice(["time", "input_time", "shaken", "retune", "inputs_stand", "mode"])
            parts[name] = some.choice([*ODD, True, False, "stepping", "terminated", "initialization"])
            continue
        numbers = some.choice([lists[0], lists[1], *3 * lists[2:]])
        k = some.randrange(len(numbers))
        if isinstance(numbers[k], float):
            numbers[k] = _other(numbers[k], some)
        elif isinstance(numbers[k], int):
            numbers[k] = some.choice(WHOLE)
    content = json.dumps(parts).encode()
    return hashlib.sha256(content).hexdigest().encode() + content


def _other(number: float, some: random.Random) -> float:
    """Return another number in the place of this one."""
    way = some.randrange(10)
    if way < 6 or not math.isfinite(number):
        return some.choice(ODD)
    return [-number, 1e3 * number, number + 1.0, number * (1.0 + 1e-6)][way - 6]


class Campaign:
    """One instance, and whole states of it."""

    def __init__(self, fmu: str) -> None:
        from support.instance import Instance

        self.body = Instance(fmu)
        of = {kind: [v for v in self.body.variables.values() if v.causality == kind] for kind in ("input", "output")}
        self.inputs = [variable.name for variable in of["input"]]
        self.outputs = [v.valueReference for v in of["output"] if v.type == "Real"]
        self.references = [v.valueReference for v in of["input"]]
        # those that follow the motion, and so have derivatives
        self.continuous = [v.valueReference for v in of["output"] if v.type == "Real" and v.variability == "continuous"]
        self.continuous = [r for r in self.continuous if self._has_derivative(r)]
        self.whole = [self._saved()]
        self.push(2.0)
        for k in range(30):
            self.body.step(k * STEP, STEP)
        self.t = 30 * STEP
        self.whole.append(self._saved())
        self.push(1.0)
        self.body.fmi.getReal(self.outputs)
        self.whole.append(self._saved())
        self.ends = [self._end(k) for k in range(len(self.whole))]
        self.begin_of_model = self._begin_of_model()
        read = [self.body.fmi.deSerializeFMUstate(data) for _, data in self.whole]
        assert [self._end(k, state) for k, state in enumerate(read)] == self.ends, (
            "a whole state is not read as it was written"
        )

    def _has_derivative(self, reference: int) -> bool:
        with contextlib.suppress(Exception):
            self.body.fmi.getRealOutputDerivatives([reference], [1])
            return True
        return False

    def _saved(self) -> tuple[Any, bytes]:
        state = self.body.fmi.getFMUState()
        return state, bytes(self.body.fmi.serializeFMUstate(state))

    def _begin_of_model(self) -> int:
        """Return the first word of a native state in and behind which no bit may change; 0 of a PythonFMU's."""
        data = self.whole[1][1]
        if data[DIGEST : DIGEST + 1] == b"{":
            return 0
        low, high = 0, (len(data) - HEADER) // 8
        while low < high:
            middle, content = (low + high) // 2, bytearray(data[HEADER:])
            content[8 * middle] ^= 1
            if self.body.attempt("deSerializeFMUstate", _sealed(data[:HEADER], content)) == "ok":
                low = middle + 1
            else:
                high = middle
        return low

    def push(self, size: float) -> None:
        """Set the inputs: accelerations, and for a body that drives the base its mass and its force."""
        usual = {"ax": size, "jx": 5.0, "az": 0.1, "theta_y": 1e-3, "omega_y": 1e-2, "fx": 10.0, "F0x": 1e4 * size}
        usual |= {"M": 1e4, "Mxx": 1e4, "Mzz": 1e4, "Mtt": 1e4, "Jxx": 1e4, "Jyy": 1e4}
        self.body.set({name: usual.get(name.rpartition(".")[2], 0.0) for name in self.inputs})

    def _end(self, k: int, state: Any = None) -> list[str]:
        """Return the bits of the outputs one step after a whole state, or another that is the same."""
        self.body.fmi.setFMUState(self.whole[k][0] if state is None else state)
        self.body.step(self.t if k else 0.0, STEP)
        return [float(value).hex() for value in self.body.fmi.getReal(self.outputs)]

    def try_state(self, number: int, seed: int) -> dict[str, Any]:
        """Make the state of that number, and judge it: {"answer", "failures"}."""
        some = random.Random(f"{seed} {number}")
        k = some.randrange(len(self.whole))
        data = changed(self.whole[k][1], some, self.begin_of_model)
        failures: list[str] = []
        answer = self._judge(data, 0.0 if k == 0 else self.t, failures)
        if self._end(k) != self.ends[k]:
            failures.append("the instance does not go on from a whole state as before")
        return {"number": number, "answer": answer, "failures": failures}

    def _judge(self, data: bytes, t: float, failures: list[str]) -> str:
        fmi = self.body.fmi
        try:
            state = fmi.deSerializeFMUstate(data)
        except Exception:
            return "refused"
        try:
            fmi.setFMUState(state)
        except Exception:
            return "refused"
        finally:
            fmi.freeFMUState(state)
        if all(abs(value) <= LARGEST for value in fmi.getReal(self.references)):
            self._look("as restored", failures)
        with contextlib.suppress(Exception):  # nothing is set where the run has ended
            self.push(0.5)
        self._look("with other inputs", failures)
        for k in range(2):
            if self.body.attempt("step", t + k * STEP, STEP) != "ok":
                return "taken, cannot step"
            self._look(f"after step {k + 1}", failures)
        return "taken"

    def _look(self, when: str, failures: list[str]) -> None:
        """Note outputs and derivatives that are no numbers, with status OK."""
        fmi, order = self.body.fmi, [1] * len(self.continuous)
        calls = {"outputs": lambda: fmi.getReal(self.outputs)}
        if self.continuous:
            calls["derivatives"] = lambda: fmi.getRealOutputDerivatives(self.continuous, order)
            some = self.references[:1]
            calls["directional derivatives"] = lambda: fmi.getDirectionalDerivative(self.continuous, some, [1.0])
        for what, call in calls.items():
            with contextlib.suppress(Exception):
                values = list(call())
                bad = sum(not math.isfinite(value) for value in values)
                if bad:
                    failures.append(f"{when}: {bad} of {len(values)} {what} are not finite, with status OK")


def campaign(seed: int, first: int, count: int, only: str | None = None) -> Iterator[dict[str, Any]]:
    """Build the FMUs, and judge `count` states of all of them together, of each from number `first` on."""
    named = [name for name in SOURCES if only in (None, name)]
    kinds = [(name, is_native) for is_native in (False, True) for name in named]
    kinds = [(name, is_native) for name, is_native in kinds if not (is_native and name in WITHOUT_NATIVE)]
    each = -(-count // len(kinds))
    with tempfile.TemporaryDirectory(prefix="stress_") as folder:
        for name, is_native in kinds:
            source, own = SOURCES[name]
            fmu, called = Path(folder) / "body.fmu", f"{name}{', native' if is_native else ''}"
            code, _, err = finish(
                "build_fmu.py", EXAMPLES / source, "-o", fmu, "--force", *own, *(NATIVE if is_native else ())
            )
            about = {"name": called, "seed": seed}
            yield about | ({"tried": 0, "failures": [err]} if code else judged(fmu, seed, first, each))


def judged(fmu: Path, seed: int, first: int, count: int) -> dict[str, Any]:
    """Judge states of one FMU, in a process that is made again after it has died."""
    answers: Counter[str] = Counter()
    failures: list[str] = []
    number, end = first, first + count
    while number < end:
        arguments = [sys.executable, "-m", "stress.changed_states", fmu, seed, number, end - number]
        with subprocess.Popen(
            list(map(str, arguments)), cwd=ROOT, env=environment(), stdout=subprocess.PIPE, text=True
        ) as process:
            assert process.stdout is not None
            begun = number
            for line in process.stdout:
                found = json.loads(line)
                answers[found["answer"]] += 1
                failures += [f"state {found['number']}: {failure}" for failure in found["failures"]]
                number = found["number"] + 1
            status = process.wait()
        if status:
            failures.append(f"state {number}: the process ended with status {status}")
            if number == begun == first:  # none is made at all
                break
            number += 1
    return {"tried": sum(answers.values()), "answers": answers, "failures": failures}


def main() -> None:
    """Judge states in this process."""
    answers, errors = (os.fdopen(os.dup(k), "w", encoding="utf-8") for k in (1, 2))
    nothing = os.open(os.devnull, os.O_WRONLY)
    for k in (1, 2):  # output of the FMU
        os.dup2(nothing, k)
    fmu, seed, first, count = sys.argv[1], *map(int, sys.argv[2:])
    try:
        of = Campaign(fmu)
        for number in range(first, first + count):
            signal.alarm(PATIENCE)  # ends this process
            print(json.dumps(of.try_state(number, seed)), file=answers, flush=True)
    except Exception:
        traceback.print_exc(file=errors)
        raise


if __name__ == "__main__":
    main()
