"""FMI calls and values thought up by hypothesis, made in a process of their own that may die or hang."""

from __future__ import annotations

import json
import select
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fmpy import read_model_description
from hypothesis import given, seed, settings
from hypothesis import strategies as st
from hypothesis.errors import FlakyFailure

from .fuzz_files import SEARCH

ROOT = Path(__file__).resolve().parent.parent
PATIENCE = 300.0  # s for one sequence: the first may compile, on a busy machine

NAN, INF = float("nan"), float("inf")
WRONG = [NAN, INF, -INF, -1.0, 0.0, -0.0, 5e-324, 1e-300, 1e300, 1.7976931348623157e308]
STEPS = [1e-3, 1e-2, 0.05, 1e-6, 1e-12, 0.009999999999999998, 0.0, -1e-3, NAN, INF]
NAMES = {
    "solver.formulation": [1, 2, 0, 3],
    "solver.integrator": [1, 2, -1],
}


class Served:
    """The process that makes the calls; made again after it has died."""

    def __init__(self, fmu: Path) -> None:
        self.fmu = fmu
        self.sequences = 0
        self.calls = 0
        self._process: subprocess.Popen[str] | None = None

    def ask(self, calls: list[Any]) -> str | None:
        """What went wrong with a sequence of calls, None if nothing did."""
        if self._process is None:
            command = [sys.executable, "-m", "stress.fmi_machine", str(self.fmu)]
            self._process = subprocess.Popen(
                command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
            )
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        self.sequences += 1
        process.stdin.write(json.dumps(calls) + "\n")
        process.stdin.flush()
        ready, _, _ = select.select([process.stdout], [], [], PATIENCE)
        answer = process.stdout.readline() if ready else ""
        if not answer:
            process.kill()
            status = process.wait()
            self._process = None
            return f"the process died with status {status}" if ready else f"no answer within {PATIENCE} s"
        told = json.loads(answer)
        self.calls += told["calls"]
        problem: str | None = told["problem"]
        return problem

    def close(self) -> int:
        """End the process as a host does; returns its status."""
        if self._process is None:
            return 0
        assert self._process.stdin is not None
        self._process.stdin.close()
        status = self._process.wait(PATIENCE)
        self._process = None
        return status


def sequences(fmu: Path, longest: int = 40) -> st.SearchStrategy[list[Any]]:
    """Lists of calls for `stress.fmi_machine`: most begin as a master does."""
    variables = read_model_description(str(fmu)).modelVariables
    parameters = [v for v in variables if v.causality == "parameter" and v.type == "Real"]
    inputs = [v.name for v in variables if v.causality == "input"]
    outputs = [v.name for v in variables if v.causality == "output" and v.type == "Real"]
    tunable = [v for v in parameters if v.variability == "tunable"]

    def near(variable: Any) -> st.SearchStrategy[list[Any]]:
        start = float(variable.start)
        usual = st.floats(0.5, 2.0).map(lambda factor: factor * start)
        wrong = st.sampled_from(WRONG)
        return st.one_of(usual, usual, wrong).map(lambda value: ["set", variable.name, value])

    def call(name: str, *arguments: Any) -> st.SearchStrategy[list[Any]]:
        return st.tuples(st.just(name), *arguments).map(list)

    some = st.integers(0, 5)
    usual_input = call("set", st.sampled_from(inputs[:2]), st.floats(-10.0, 10.0))
    usual_step = call("step", st.just(0.0), st.sampled_from(STEPS[:5]))
    calls = st.one_of(
        usual_step,
        usual_step,
        usual_input,
        call("step", st.sampled_from([0.0, 0.0, 1e-3, -1e-3, NAN]), st.sampled_from(STEPS)),
        call("set", st.sampled_from(inputs), st.one_of(st.floats(-1e3, 1e3), st.sampled_from(WRONG))),
        st.sampled_from(parameters).flatmap(near),
        st.sampled_from(tunable).flatmap(near),
        st.sampled_from([["set", name, value] for name, values in NAMES.items() for value in values]),
        call("set", st.sampled_from(outputs), st.just(1.0)),
        call("get", st.sampled_from(["outputs", "outputs", "parameters", "unknown reference", "wrong kind"])),
        st.just(["save"]),
        call("restore", some),
        call("serialize", some),
        call("deserialize", some, st.sampled_from(["whole", "changed", "cut", "nothing"])),
        call("setup", st.sampled_from([0.0, 1.5, -3.0, NAN, INF])),
        st.sampled_from([["enter"], ["exit"], ["terminate"], ["reset"], ["debug", True], ["debug", False]]),
    )
    setting = st.lists(st.sampled_from(parameters).flatmap(near), max_size=2)
    start = setting.map(lambda sets: [*sets, ["setup", 0.0], ["enter"], ["exit"]])
    return st.tuples(st.one_of(start, start, start, st.just([])), st.lists(calls, min_size=10, max_size=longest)).map(
        lambda parts: parts[0] + parts[1]
    )


def fuzz(fmu: Path, number: int, examples: int, report: Callable[[str], None] | None = None) -> dict[str, Any]:
    """So many sequences of a seeded search: {"sequences", "calls", "failures": shortest that fail}."""
    served = Served(fmu)
    failures: list[dict[str, Any]] = []
    smallest: dict[str, Any] = {}

    @seed(number)
    @settings(max_examples=examples, **SEARCH)
    @given(sequences(fmu))
    def hold(calls: list[Any]) -> None:
        problem = served.ask(calls)
        if problem is not None:
            smallest.update(problem=problem, calls=calls)
        assert problem is None, f"{problem}\n{calls}"

    try:
        hold()
    except (AssertionError, FlakyFailure):
        failures.append(dict(smallest))
    status = served.close()
    if status:
        failures.append({"problem": f"the process ended with status {status}", "calls": []})
    return {"sequences": served.sequences, "calls": served.calls, "failures": failures}
