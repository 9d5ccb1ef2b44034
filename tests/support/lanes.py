"""Helpers of the tests of lanes: eight columns at once compared with each alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from solver import Column, Motion
from solver.column.packing import pack_model
from solver.dynamics.kinematics import Chain
from solver.kernels.formulations.exact import Motion as BaseMotion
from solver.kernels.formulations.exact import exact_accelerations
from solver.kernels.layout import spaces as at
from solver.kernels.numba_ext.jit import from_python
from solver.kernels.numba_ext.lanes import WIDTH
from solver.kernels.numba_ext.views import Space, lanes_of, row_of
from solver.runs.batch import BatchResult, run_batch
from solver.runs.single_run import single_run
from support.probe import Array, sliding_state

RECORDS = ("elcentro-1940-ns.AT2", "northridge-1994-arleta-360.AT2", "kobe-1995-nishi-akashi-090.AT2")
_model, _phase, _work = at.MODEL.over, at.PHASE.over, at.WORK.over


def in_lanes(rows: Array) -> Array:
    """Eight rows interleaved: eight neighbouring numbers an element."""
    return np.ascontiguousarray(rows.T).reshape(-1)


# --- accelerations


def _accelerating_over(view: Callable[[Array], Any]) -> Callable[[int, Array, Array, Array, Array], None]:
    """`exact_accelerations` over arrays seen through `view`; base: ax, az, theta, omega, alpha."""

    @from_python
    def accelerate_over(n: int, model: Array, phase: Array, work: Array, base: Array) -> None:
        b = view(base)
        motion = BaseMotion(b[0], b[1], b[2], b[3], b[4])
        space = _work(view(work), n)
        exact_accelerations(
            _model(view(model), n), _phase(view(phase), n), motion, space.joints, space.hold, space.room
        )

    return accelerate_over


accelerate, accelerate_eight = _accelerating_over(row_of), _accelerating_over(lanes_of)  # of one column; of eight


def accelerating(space: Space) -> Callable[[int, Array, Array], None]:
    """`exact_accelerations` for eight columns, whose buffer holds the space; the phase is its work.start."""
    over = space.over

    @from_python
    def accelerate_lanes(n: int, buffer: Array, base: Array) -> None:
        b, space = lanes_of(base), over(lanes_of(buffer), n)
        motion, work = BaseMotion(b[0], b[1], b[2], b[3], b[4]), space.work
        exact_accelerations(space.model, work.start, motion, work.joints, work.hold, work.room)

    return accelerate_lanes


def assert_sliding_accelerations_are_those_of_each(
    make: Callable[[np.random.Generator, int], Column], n: int, space: Space, accelerate_lanes: Callable[..., None]
) -> None:
    """Eight columns with slips, drawn by `make`, in the kind of lanes that the kernel was made for.

    The accelerations of one column are compared with Lagrange's equations in test_sliding.py.
    """
    buffer = np.zeros((space.size(n), WIDTH))
    seen = space.see(buffer, n)  # names over rows of lanes
    models, phases, motions = [], [], []
    for k in range(WIDTH):
        rng = np.random.default_rng([k, n])
        column = make(rng, n)
        q, rate, direction = sliding_state(rng, column, 10.0 ** rng.uniform(-4.0, -0.5))
        zeros = np.zeros(n)
        parts = [q[: 2 * n], rate[: 2 * n], zeros, zeros, q[2 * n :], zeros, rate[2 * n :], zeros, zeros, direction]
        models.append(pack_model(column)[: at.MODEL.size(n)])
        phases.append(np.concatenate(parts))
        motions.append(rng.uniform(-1.0, 1.0, 5) * [column.g, column.g, 1.0, 2.0, 10.0])
        seen.work.joints.sliding[:, k] = direction
    buffer[: at.MODEL.size(n)] = np.array(models).T
    place = buffer.shape[0] - at.WORK.size(n)  # place of `start`, the first part of the work
    buffer[place : place + at.PHASE.size(n)] = np.array(phases).T
    accelerate_lanes(n, buffer.reshape(-1), in_lanes(np.array(motions)))
    for k in range(WIDTH):
        phase, work = phases[k].copy(), np.zeros(at.WORK.size(n))
        alone = at.WORK.see(work, n)
        alone.joints.sliding[:] = at.PHASE.see(phase, n).sliding
        accelerate(n, models[k].copy(), phase, work, motions[k].copy())
        expected, found = at.PHASE.see(phase, n), seen.work.start
        names = ("theta_acceleration", "opening_acceleration", "slip_acceleration")
        largest = max(np.max(np.abs(getattr(expected, name))) for name in names)
        for name in names:
            assert getattr(found, name)[:, k] == pytest.approx(getattr(expected, name), abs=1e-13 * largest), name
        for name in ("normal", "moment", "tangential", "drift", "overcome", "shear_capacity"):
            wanted = getattr(alone.joints, name)
            scale = 1e-13 * max(1.0, float(np.max(np.abs(wanted))))
            assert getattr(seen.work.joints, name)[:, k] == pytest.approx(wanted, abs=scale), name


# --- runs


def parts_of(result: BatchResult, k: int) -> list[Any]:
    """All results of run k."""
    falls = result.overturned_joint[k], np.nan_to_num(result.overturn_time[k])
    return [*falls, result.peak_ux[k], result.steps[k], result.ends[k], result.phases[k]]


def assert_nothing_depends_on_the_others(
    columns: Sequence[Column], motions: Sequence[Motion], durations: Sequence[float] | None = None
) -> BatchResult:
    """Each run has equal bits with the others, in another order in two threads, and alone."""
    times = np.array([0.0, 0.5, 0.7])

    def made(which: Sequence[int], **options: int) -> BatchResult:
        long = None if durations is None else [durations[k] for k in which]
        return run_batch([columns[k] for k in which], [motions[k] for k in which], long, times=times, **options)

    together = made(range(len(columns)))
    order = np.random.default_rng(1).permutation(len(columns)).tolist()
    shuffled = made(order, threads=2)
    for place, k in enumerate(order):
        alone = made([k])
        for one, other, third in zip(parts_of(together, k), parts_of(shuffled, place), parts_of(alone, 0), strict=True):
            assert np.array_equal(one, other)
            assert np.array_equal(one, third)
    return together


def assert_the_tolerance_is_kept(
    columns: Sequence[Column],
    motions: Sequence[Motion],
    *,
    tame: int,
    slid: int = 0,
    overturned: int = 0,
    within: float = 10.0,
) -> None:
    """Tops and slips agree within some tolerances of the largest top, in runs that amplify a change by less than 100.

    tame, slid: least number of such runs, and of runs that slip by a millimetre; overturned: largest number that fall,
    which are left out.
    """
    duration, times = 8.0, np.linspace(0.0, 7.95, 160)
    chains, n = [Chain(column) for column in columns], columns[0].n

    def history(k: int, phases: Array) -> Array:
        return np.hstack([chains[k].top_displacements(phases), phases[:, 4 * n : 5 * n]])

    def alone(k: int, factor: float) -> Array:
        column, motion = columns[k].with_settings(tolerance=1e-9, without=("peaks",)), motions[k].scaled(factor)
        _, phases = single_run(column, motion, duration, motion.start + times, None, 0.0)
        return history(k, phases)

    truth = [alone(k, 1.0) for k in range(len(columns))]
    sizes = [np.max(np.abs(found[:, :n])) for found in truth]
    change = [np.max(np.abs((alone(k, 1.0 + 1e-7) - truth[k])[:, :n])) for k in range(len(columns))]
    followed = [k for k in range(len(columns)) if change[k] < 1e-5 * sizes[k]]
    assert len(followed) >= tame
    assert sum(bool(np.any(np.ptp(found[:, n:], axis=0) > 1e-3)) for found in truth) >= slid
    for tolerance in (1e-3, 1e-5):
        result = run_batch(columns, motions, [duration] * len(columns), tolerance=tolerance, times=times)
        assert np.all(result.finished)
        assert np.count_nonzero(result.overturned_joint) <= overturned
        for k in followed:
            if not result.overturned_joint[k]:
                error = np.max(np.abs(history(k, result.phases[k]) - truth[k]))
                assert error <= within * tolerance * sizes[k]
