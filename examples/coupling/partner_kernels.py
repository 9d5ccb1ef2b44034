"""The partners for callers that have pointers: what their FMUs without Python are linked with.

Each takes the place that the kernels have in solver/kernels/api/pointers.py, with arguments of the same names; the
functions are those of isolator.py and soil.py as they stand, compiled. A partner's model is its parameters, its state
what moves, the steps before and the work. The state of the ground is the length of the last step.
"""

from __future__ import annotations

import hashlib
import importlib
import inspect
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

from solver.kernels.api import pointers
from solver.kernels.formulations.base_motion import SAMPLE_SLACK, Samples, record_line, segment_at
from solver.kernels.numba_ext.jit import kernel
from solver.kernels.numba_ext.views import Record, row_at

HERE = Path(__file__).resolve().parent
PLAIN, COMPILED = "laws", "compiled_laws"  # the folder as packages: as it stands, and with all functions compiled
NO_NUMBER, NO_DERIVATIVES = -101, -102
REASONS = {NO_NUMBER: "the acceleration is no finite number", NO_DERIVATIVES: "derivatives are not offered"}
Entries = dict[Callable[..., Any], Any]
_column: Any = pointers.ENTRIES
_types = {function.__name__: kinds for function, kinds in _column.items()}


def law_of(name: str, package: str = PLAIN) -> ModuleType:
    """The module of a partner, as a part of a package that this folder is."""
    if package not in sys.modules:
        folder = ModuleType(package)
        folder.__path__ = [str(HERE)]
        sys.modules[package] = folder
    return importlib.import_module(f"{package}.{name}")


def sources(name: str) -> str:
    """What identifies the partner's own sources."""
    content = b"".join((HERE / f"{part}.py").read_bytes() for part in ("law", name, "partner_kernels"))
    return hashlib.sha256(content).hexdigest()[:16]


def _compiled(name: str) -> tuple[ModuleType, ModuleType]:
    """What partners share and the partner, every function compiled: they find each other in their modules."""
    law, own = law_of("law", COMPILED), law_of(name, COMPILED)
    for module in (law, own):
        for key, item in list(vars(module).items()):
            if inspect.isfunction(item):
                setattr(module, key, kernel(item))
    return law, own


def _entries(begin: Callable[..., Any], step: Callable[..., Any], see: Callable[..., Any]) -> Entries:
    """The entries around what is a partner's own: all that such a thing has no use for is left out.

    begin(given, from_rest, model, state), step(inputs, model, state, work, h) -> reason or 0,
    see(inputs, model, state, work, t, samples, row).
    """

    def assemble(n, given, from_rest, model, state, counts, base, work, scratch, detail):
        begin(row_at(given), from_rest, row_at(model), row_at(state))
        return 0

    def follow(n, model, state, counts, base, work, inputs, start, h, count, times, ax, az, scale, row, split):
        return step(row_at(inputs), row_at(model), row_at(state), row_at(work), h)

    # fmt: off
    def look(n, model, state, counts, base, work, inputs, new_inputs, upright, elapsed, t, count, times, ax, az, scale,
             row, split):
        # fmt: on
        samples = Samples(count, row_at(times), row_at(ax), row_at(az), scale, False)
        see(row_at(inputs), row_at(model), row_at(state), row_at(work), t, samples, row_at(row))
        return 0

    return {function: _types[function.__name__] for function in (assemble, follow, look, rates, feedthrough)}


def partner_entries(name: str) -> Entries:
    """Of a body that carries a column."""
    law, own = _compiled(name)
    value_of = Record(*own.Given._fields).over
    inputs_count = sum(port.causality == "input" for port in own.PORTS)
    count, steps = len(own.Given._fields), own.MOTION
    work_place = steps + law.BEFORE
    accelerations, given_slopes, slopes, outputs = own.accelerations, own.given_slopes, law.slopes, own.outputs
    needs, velocities, power, move = own.needs, own.velocities, law.power, own.move
    later, remember, is_finite = law.later, law.remember, law.is_finite

    @kernel
    def given(inputs, model, work):
        for k in range(inputs_count):
            work[k] = inputs[k]
        for k in range(inputs_count, count):
            work[k] = model[k - inputs_count]
        return value_of(work, 0)

    @kernel
    def begin(given, from_rest, model, state):
        """Parameters into the model; from rest."""
        for k in range(count - inputs_count):
            model[k] = given[k]
        if from_rest:
            for k in range(work_place + 1):
                state[k] = 0.0

    @kernel
    def step(inputs, model, motion, work, h):
        value = given(inputs, model, work)
        before = motion[steps:]
        a = accelerations(value, motion)
        slope = slopes(value.slope, given_slopes(value), a, before)
        if not is_finite(a):
            return NO_NUMBER
        watts = power(needs(value, motion, a), velocities(motion))
        move(value, motion, a, slope, h)
        watts += power(needs(value, motion, later(a, slope, h)), velocities(motion))
        motion[work_place] += 0.5 * h * watts
        remember(before, a, h)
        return 0

    @kernel
    def see(inputs, model, motion, work, t, samples, row):
        """The outputs."""
        value = given(inputs, model, work)
        a = accelerations(value, motion)
        slope = slopes(value.slope, given_slopes(value), a, motion[steps:])
        found = outputs(value, motion, a, slope)
        for k in range(len(found)):
            row[k] = found[k]
        row[len(found)] = motion[work_place]

    return _entries(begin, step, see)


def ground_entries() -> Entries:
    """Of the record inside."""

    @kernel
    def at(samples, t):
        """Accelerations and slopes from time t on."""
        k = segment_at(samples, t)
        if -1 <= k < samples.size - 1:
            ahead = samples.times[k + 1] - t
            width = samples.times[1] - samples.times[0] if k < 0 else samples.times[k + 1] - samples.times[k]
            if ahead <= SAMPLE_SLACK * width:
                return record_line(samples, k + 1, samples.times[k + 1])
        return record_line(samples, k, t)

    @kernel
    def begin(given, from_rest, model, state):
        """The step of the parameters, 0 if it is not given."""
        model[0] = given[0]
        if from_rest:
            state[0] = 0.0

    @kernel
    def step(inputs, model, state, work, h):
        """Time goes on."""
        state[0] = h
        return 0

    @kernel
    def see(inputs, model, state, work, t, samples, row):
        """The outputs."""
        step = model[0] if model[0] != 0.0 else state[0]
        now_x, jx, now_z, jz = at(samples, t)
        if step > 0.0:
            then_x, _, then_z, _ = at(samples, t + step)
            jx, jz = (then_x - now_x) / step, (then_z - now_z) / step
        row[0], row[1], row[2], row[3] = now_x, now_z, jx, jz

    return _entries(begin, step, see)


def rates(n, model, state, counts, base, work, t, count, times, ax, az, scale, row, split, other, other_split):
    return NO_DERIVATIVES


# fmt: off
def feedthrough(n, model, state, counts, base, work, inputs, seeds, elapsed, t, count, times, ax, az, scale, row, split,
                other, other_split):
    # fmt: on
    return NO_DERIVATIVES


def __getattr__(name: str) -> Entries:
    """`partner_kernels:isolator` and its like, made when asked for."""
    if name == "ground":
        return ground_entries()
    if name in ("isolator", "soil"):
        return partner_entries(name)
    raise AttributeError(name)
