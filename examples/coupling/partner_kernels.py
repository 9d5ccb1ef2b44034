"""The kernels of partners: what their FMUs without Python are linked with, a group of entries for each.

They are called as those of a column (solver/kernels/column/api/driven_entries.py), and take what they need of the same
arguments; the functions are those of isolator.py and soil.py as they stand, compiled. A partner's model is its
parameters, its state what moves, the steps before and the work. The state of the ground is the length of the last step.
"""

import hashlib
import importlib
import inspect
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

from solver.kernels.column.formulations.base_motion import record_line
from solver.kernels.engine.samples import SAMPLE_SLACK, segment_at, unloaded
from solver.kernels.machine.entry import entry
from solver.kernels.machine.groups import GROUPS, Group
from solver.kernels.machine.kinds import Int, Real, Reals, SizedReals
from solver.kernels.numba_ext.jit import kernel
from solver.kernels.numba_ext.views import Record

HERE = Path(__file__).resolve().parent
PARTNERS = ("isolator", "soil")  # that carry a column
PLAIN, COMPILED = "laws", "compiled_laws"  # the folder as packages: as it stands, and with all functions compiled
NO_NUMBER, NO_DERIVATIVES = -101, -102
REASONS = {NO_NUMBER: "the acceleration is no finite number", NO_DERIVATIVES: "derivatives are not offered"}


def law_of(name: str, package: str = PLAIN) -> ModuleType:
    """Return the module of a partner, as a part of a package that this folder is."""
    if package not in sys.modules:
        folder = ModuleType(package)
        folder.__path__ = [str(HERE)]
        sys.modules[package] = folder
    return importlib.import_module(f"{package}.{name}")


def _sources(name: str) -> str:
    """Return what identifies the partner's own sources."""
    content = b"".join((HERE / f"{part}.py").read_bytes() for part in ("law", name, "partner_kernels"))
    return hashlib.sha256(content).hexdigest()[:16]


def _compiled() -> tuple[ModuleType, ...]:
    """Return the modules of the shared law and of the partners, with every function compiled in its module."""
    modules = tuple(law_of(name, COMPILED) for name in ("law", *PARTNERS))
    for module in modules:
        for key, item in list(vars(module).items()):
            if inspect.isfunction(item):
                setattr(module, key, kernel(item))
    return modules


def _entries(group: str, begin: Callable[..., Any], step: Callable[..., Any], see: Callable[..., Any]) -> None:
    """Make the entries around what is a partner's own.

    begin(given, from_rest, model, state), step(inputs, model, state, work, h) -> reason or 0,
    see(inputs, model, state, work, t, samples, row).
    """
    made = entry(group, __name__)

    @made
    def assemble(model: Reals, state: Reals, given: Reals, from_rest: Int) -> Int:
        begin(given, from_rest, model, state)
        return 0

    @made
    def follow(model: Reals, state: Reals, work: Reals, inputs: Reals, h: Real) -> Int:
        return step(inputs, model, state, work, h)

    @made
    def look(
        model: Reals, state: Reals, work: Reals, inputs: Reals, t: Real, times: SizedReals, ax: Reals, az: Reals,
        scale: Real, row: Reals,
    ) -> Int:  # fmt: skip
        samples = unloaded(times.row, times.size, ax, ax, az, scale, 0)
        see(inputs, model, state, work, t, samples, row)
        return 0

    @made
    def rates() -> Int:
        return NO_DERIVATIVES

    @made
    def feedthrough() -> Int:
        return NO_DERIVATIVES


def _partner_entries(name: str, own: ModuleType, law: ModuleType) -> None:
    """Make those of a body that carries a column."""
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
        """Put the parameters into the model, and begin from rest."""
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
        """Fill the outputs."""
        value = given(inputs, model, work)
        a = accelerations(value, motion)
        slope = slopes(value.slope, given_slopes(value), a, motion[steps:])
        found = outputs(value, motion, a, slope)
        for k in range(len(found)):
            row[k] = found[k]
        row[len(found)] = motion[work_place]

    _entries(name, begin, step, see)


def _ground_entries(name: str) -> None:
    """Make those of the record inside."""

    @kernel
    def at(samples, t):
        """Return accelerations and slopes from time t on."""
        k = segment_at(samples, t)
        if -1 <= k < samples.size - 1:
            ahead = samples.times[k + 1] - t
            width = samples.times[1] - samples.times[0] if k < 0 else samples.times[k + 1] - samples.times[k]
            if ahead <= SAMPLE_SLACK * width:
                return record_line(samples, k + 1, samples.times[k + 1])
        return record_line(samples, k, t)

    @kernel
    def begin(given, from_rest, model, state):
        """Return the step of the parameters, 0 if it is not given."""
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
        """Fill the outputs."""
        step = model[0] if model[0] != 0.0 else state[0]
        now_x, jx, now_z, jz = at(samples, t)
        if step > 0.0:
            then_x, _, then_z, _ = at(samples, t + step)
            jx, jz = (then_x - now_x) / step, (then_z - now_z) / step
        row[0], row[1], row[2], row[3] = now_x, now_z, jx, jz

    _entries(name, begin, step, see)


_ground_entries("ground")
_law, *_own = _compiled()
for _name, _module in zip(PARTNERS, _own, strict=True):
    _partner_entries(_name, _module, _law)
GROUPS |= {name: Group(__name__, name, 4, _sources(name)) for name in ("ground", *PARTNERS)}
