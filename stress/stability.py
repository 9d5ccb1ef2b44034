"""Checks that must hold in every case, however extreme, and their margins."""

from __future__ import annotations

import math
import multiprocessing
import resource
import signal
import time as clock
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from solver import Block, Column, Joint, Motion, SolverError
from solver.kernels.layout import spaces as at
from solver.models.column.stepper import Stepper

from .cases import MIRRORED, Case, draw
from .energy import Array, Energies

AFFORDABLE = 500_000  # steps times blocks: a run that took more is not repeated at other tolerances
MOST_BLOCKS = 200
ROWS = 200  # of a motion that is not held
ROUNDING = 1e-12
# limit of each figure, in tolerances; docs/notes/campaign.md has the measured ones
LIMITS = {
    "energy gained": 10.0,
    "energy lost, undamped": 10.0,
    "error": 30.0,
    "half the tolerance": 30.0,
    "communication step": 30.0,
}
PREDICTABLE = 30.0  # amplification of a change of the motion: beyond it errors are the motion's, not the solver's


@dataclass
class Track:
    """One run: phases and output rows at `times`, and the verdict."""

    times: Array
    phases: Array
    rows: Array
    overturned: int
    overturn_time: float
    failure: str = ""
    seconds: float = 0.0
    stats: dict[str, Any] = field(default_factory=dict)


def follow(
    column: Column, motion: Motion, times: Array, pieces: int = 1, nudge: float = 0.0, tolerance: float | None = None
) -> Track:
    """Run a column; `pieces`: communication steps per sample, `nudge`: rad added to the top block's rotation."""
    if tolerance is not None:
        column = column.with_settings(tolerance=tolerance)
    stepper = Stepper(column)
    stepper.state.phase.theta[0] += nudge
    begin = clock.perf_counter()
    failure = ""
    snapshots = np.zeros((0, at.SNAPSHOT.beside))
    try:
        snapshots = stepper.run(_cut(motion, pieces), motion.end, times)
        rows = stepper.rows_of(snapshots)
    except SolverError as error:
        failure = str(error)
        rows = np.zeros((0, at.ROW.size(column.n)))
    return Track(
        times[: len(rows)],
        at.phases_in(snapshots),
        rows,
        stepper.fallen,
        stepper.fall_time,
        failure,
        clock.perf_counter() - begin,
        {name: int(getattr(stepper.counts, field)) for name, field in COUNTED.items()},
    )


COUNTED = {"steps": "steps", "implicit": "implicit_steps", "elastic": "elastic_steps", "rejected": "rejected"}


def _cut(motion: Motion, pieces: int) -> Motion:
    """Return the motion with `pieces` times as many samples: shorter communication steps."""
    if pieces == 1:
        return motion
    shares = np.arange(pieces) / pieces
    ends = np.append(motion.time, motion.end) if motion.hold else motion.time
    time = (ends[:-1, None] + np.diff(ends)[:, None] * shares).ravel()
    if motion.hold:
        ax, ay, az = (np.repeat(values, pieces) for values in (motion.ax, motion.ay, motion.az))
    else:
        time = np.append(time, motion.time[-1])
        ax, ay, az = (np.interp(time, motion.time, values) for values in (motion.ax, motion.ay, motion.az))
    return replace(motion, time=time, ax=ax, ay=ay, az=az)


def examine(case: Case) -> dict[str, Any]:
    """Make every check of one case: {"failures": [...], "figures": {...}, ...}."""
    column, motion = case.column, case.motion
    tolerance = column.settings.tolerance
    times = motion.start + np.linspace(0.0, motion.duration, ROWS + 1)
    if motion.hold:
        times = np.append(motion.time, motion.end)
    failures: list[str] = []
    figures: dict[str, float] = {}
    found = {"case": case.line(), "kind": case.kind, "n": column.n, "failures": failures, "figures": figures}

    usual = follow(column, motion, times)
    found |= {"stats": usual.stats, "seconds": usual.seconds, "overturned": usual.overturned}
    if usual.failure:
        failures.append(f"gave up: {usual.failure}")
        return found
    check_rows(column, usual, failures, figures)
    if motion.hold:
        check_energy(column, motion, usual, failures, figures)
    _check_mirror(column, motion, usual, failures)
    if (usual.stats["steps"] + usual.stats["rejected"]) * column.n < AFFORDABLE:
        _check_agreement(case, usual, failures, figures, tolerance)
    failures += above_limits(figures)
    return found


def above_limits(figures: dict[str, float]) -> list[str]:
    """Return a line for each figure that is not within its limit; NaN is not."""
    beyond = [name for name, limit in LIMITS.items() if name in figures and not figures[name] <= limit]
    return [f"{name}: {figures[name]:.3g} tolerances" for name in beyond]


def check_rows(column: Column, run: Track, failures: list[str], figures: dict[str, float]) -> None:
    """Check that rows are finite; N >= 0, |M| <= N b / 2, contact within 0..1."""
    n = column.n
    if not np.all(np.isfinite(run.rows)):
        failures.append("an output is not finite")
        return
    seen = at.ROW.see(run.rows.T, n).joints
    normal, moment, contact, sigma = seen.N.T, seen.M.T, seen.contact.T, seen.sigma_max.T
    width = np.array([contact.width for contact in column.contacts])
    if np.min(normal) < 0.0 or np.min(sigma) < 0.0:
        failures.append(f"tension: N = {np.min(normal):.3g} N, sigma = {np.min(sigma):.3g} Pa")
    held = normal > np.finfo(float).tiny
    parts = np.abs(moment[held]) / (0.5 * normal * width)[held]
    part = float(np.max(parts, initial=0.0))
    figures["moment over N b/2"] = max(part, figures.get("moment over N b/2", 0.0))
    if np.any(moment[~held] != 0.0):
        failures.append("a moment without a normal force")
    if not part <= 1.0 + ROUNDING:
        failures.append(f"|M| = {part:.15g} N b/2")
    if np.min(contact) < 0.0 or np.max(contact) > 1.0:
        failures.append(f"contact from {np.min(contact):.17g} to {np.max(contact):.17g}")


def _standing(run: Track) -> int:
    """Return the number of rows before the verdict."""
    return int(np.searchsorted(run.times, run.overturn_time)) if run.overturned else len(run.times)


def check_energy(column: Column, motion: Motion, run: Track, failures: list[str], figures: dict[str, float]) -> None:
    """Check that the energy never exceeds that at the start plus the work of the base; without damping it is never
    less.
    """
    count = _standing(run)
    if count < 2:
        return
    has = Energies(column, run.phases[:count])
    excess = has.total - has.total[0] - has.work(motion)
    floor = Stepper(column).model.settings.rotation_floor ** 2 * sum(
        0.5 * block.joint.stiffness * contact.second
        for block, contact in zip(column.blocks, column.contacts, strict=True)
    )
    moved = np.abs(has.elastic - has.elastic[0]) + np.abs(has.gravity - has.gravity[0]) + has.kinetic
    rounding = np.abs(has.elastic[0]) + np.max(np.abs(has.gravity))
    scale = np.maximum.accumulate(moved + np.abs(has.work(motion))) + floor + 1e-9 * rounding
    figures["energy gained"] = float(np.max(excess / scale)) / column.settings.tolerance
    if all(block.joint.damping == 0.0 for block in column.blocks):
        figures["energy lost, undamped"] = float(np.max(-excess / scale)) / column.settings.tolerance


def _check_mirror(column: Column, motion: Motion, run: Track, failures: list[str]) -> None:
    """Check that the mirrored motion gives the mirrored response, to the last bit."""
    n = column.n
    mirrored = follow(column, motion.mirrored(), run.times)
    joints = [np.full(n, -1.0 if name in MIRRORED else 1.0) for name in at.OUTPUTS.fields]
    base = [-1.0 if name in MIRRORED else 1.0 for name in at.REACTION.fields]
    sign = np.concatenate([*joints, base])
    if mirrored.failure or not np.array_equal(mirrored.rows, sign * run.rows):
        failures.append(f"mirrored motion: {mirrored.failure or 'not the mirrored response'}")


def _altered(column: Column, part: float) -> Column:
    """Return the column with data changed by a relative amount, smaller than their uncertainty."""
    blocks = tuple(
        replace(block, joint=replace(block.joint, stiffness=block.joint.stiffness * (1.0 + (-1) ** i * part)))
        for i, block in enumerate(column.blocks)
    )
    return replace(column, blocks=blocks)


def _check_agreement(
    case: Case, usual: Track, failures: list[str], figures: dict[str, float], tolerance: float
) -> None:
    """Compare half the tolerance and other communication steps: within the tolerance as long as the motion can be
    predicted.
    """
    column, motion, times = case.column, case.motion, usual.times
    n = column.n
    half = follow(column, motion, times, tolerance=max(1e-13, 0.5 * tolerance))
    pieces = follow(column, motion, times, pieces=3)
    tight = max(1e-12, 1e-2 * tolerance)
    reference = follow(column, motion, times, tolerance=tight)
    pushed = follow(_altered(column, tolerance), motion.scaled(1.0 + tolerance), times, tolerance=tight)
    for name, run in (("half", half), ("pieces", pieces), ("tight", reference), ("pushed", pushed)):
        if run.failure:
            failures.append(f"{name}: gave up: {run.failure}")
            return
        wrong: list[str] = []
        check_rows(column, run, wrong, figures)
        failures += [f"{name}: {line}" for line in wrong]
        if not np.all(np.isfinite(run.rows)):
            return
    ux = np.abs(reference.rows[:, :n])
    height = sum(block.height for block in column.blocks)
    peak = np.maximum.accumulate(np.max(ux, axis=1)) + Stepper(column).model.settings.rotation_floor * height

    def apart(one: Track, other: Track) -> Array:
        return np.asarray(np.maximum.accumulate(np.max(np.abs(one.rows[:, :n] - other.rows[:, :n]), axis=1) / peak))

    sensitivity = np.maximum(1.0, apart(reference, pushed) / tolerance)
    predictable = int(np.searchsorted(sensitivity, PREDICTABLE))
    standing = min(_standing(run) for run in (usual, half, pieces, reference))
    window = min(predictable, standing)
    figures["window"] = window / len(times)
    if window:
        for name, one, other in (
            ("error", usual, reference),
            ("half the tolerance", usual, half),
            ("communication step", usual, pieces),
        ):
            figures[name] = float(np.max((apart(one, other) / sensitivity)[:window])) / tolerance
    verdicts = [run.overturned > 0 for run in (usual, half, pieces, reference)]
    if verdicts_disagree(verdicts, predictable, standing):
        failures.append(f"verdicts differ: {verdicts}")
    elif len(set(verdicts)) > 1:
        figures["verdicts differ"] = 1.0  # beyond what can be predicted


def verdicts_disagree(verdicts: list[bool], predictable: int, standing: int) -> bool:
    """Return True if runs whose motion can be predicted up to the first fall have different verdicts.

    predictable: rows before the sensitivity exceeds PREDICTABLE; standing: rows before the first fall of any run.
    """
    return len(set(verdicts)) > 1 and predictable >= standing


def _serve(pipe: Connection, seed: int, most_blocks: int, patience: int) -> None:
    """Examine the requested cases; the system ends the process if one takes too long."""
    # compiled before time is counted
    still = Motion.from_samples(1e-3, [0.0, 0.0])
    follow(Column("still", (Block(1.0, 1.0, 1.0, 1e3, Joint(1e9, 1e-3)),)), still, still.time)
    with np.errstate(all="ignore"):
        while True:
            number = pipe.recv()
            used = resource.getrusage(resource.RUSAGE_SELF)
            resource.setrlimit(resource.RLIMIT_CPU, (int(used.ru_utime + used.ru_stime) + 1 + patience, -1))
            try:
                pipe.send(examine(draw(seed, number, most_blocks)))
            except Exception as error:  # a defect of solver or campaign: reported with the case
                pipe.send({"failures": [f"{type(error).__name__}: {error}"], "figures": {}})


def campaign(
    seed: int, first: int, count: int, most_blocks: int = MOST_BLOCKS, patience: int = 20, seconds: float = math.inf
) -> Iterator[dict[str, Any]]:
    """Return the findings of the cases first, first + 1, ..., until `count` cases or `seconds` are reached.

    patience: s of processor time for one case; one that takes longer is reported as slow. A case that ends the process
    is reported as well, and the campaign continues.
    """
    context = multiprocessing.get_context("spawn")
    worker = None
    end = clock.monotonic() + seconds
    for number in range(first, first + count):
        if clock.monotonic() > end:
            break
        if worker is None:
            pipe, other = context.Pipe()
            worker = context.Process(target=_serve, args=(other, seed, most_blocks, patience), daemon=True)
            worker.start()
            other.close()
        pipe.send(number)
        try:
            found = pipe.recv()
        except EOFError:
            worker.join()
            slow = worker.exitcode == -signal.SIGXCPU
            found = {
                "figures": {},
                "failures": [] if slow else [f"the process ended with {worker.exitcode}"],
                "slow": slow,
            }
            worker = None
        case = draw(seed, number, most_blocks)
        yield {"seed": seed, "number": number, "case": case.line(), "kind": case.kind, "n": case.column.n} | found
    if worker is not None:
        worker.kill()
