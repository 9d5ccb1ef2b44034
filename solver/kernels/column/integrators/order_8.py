"""The Runge-Kutta method of order 8 of Dormand and Prince with the error estimate of Hairer, Norsett and Wanner.

P. J. Prince, J. R. Dormand, High order embedded Runge-Kutta formulae, J. Comp. Appl. Math. 7 (1981) 67-75; E. Hairer,
S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (1993), section II.10: DOP853. The
evaluation at the end is the first stage of the next step.
"""

from typing import Any

from ...engine.order_8 import END, ERROR_3, ERROR_5, NODES, STAGES, error_of, sum_by
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.views import packs, packs_of
from ..formulations.dispatch import evaluate_at
from .error import error_in_tolerances
from .stage import stage, summed


@leaf
def _slope(work, k):
    """Return rates and accelerations at stage k; the start is stage 0."""
    return work.start.rates if k == 0 else stage(work, k).rates


def _step_to(row: int) -> Any:
    """Return a leaf (column, t, h) that computes the stages of a step up to number `row`, or to the END."""
    before = _step_to(row - 1) if row > 1 else _no_stage
    sum_of, node, ends = sum_by(row, _slope), NODES[min(row, STAGES)], row == END

    @leaf
    def step_to(column, t, h):
        before(column, t, h)
        # phase of this stage
        work = column.work
        phase = work.end if ends else stage(work, row)
        y, found = packs_of(work.start.row), packs_of(phase.row)
        for i in range(packs(phase.row, summed(work))):
            found[i] = y[i] + h * sum_of(work, i)
        # its slopes
        evaluate_at(column, phase, t + node * h)

    return step_to


@leaf
def _no_stage(column, t, h):
    pass


def _error_by(row: int) -> Any:
    """Return a kernel (column, h): the error, in tolerances, by a row of WEIGHTS."""
    sum_of = sum_by(row, _slope)

    @kernel
    def error_by(column, h):
        work = column.work
        # weighted sum of the slopes of all stages
        error = packs_of(work.between.row)
        for i in range(packs(work.between.row, summed(work))):
            error[i] = h * sum_of(work, i)
        return error_in_tolerances(column, work.between)

    return error_by


_step, _error_5, _error_3 = _step_to(END), _error_by(ERROR_5), _error_by(ERROR_3)


@kernel
def attempt(column, t, h):
    """Make one step of `h` s from `work.start` to `work.end`; return the error in tolerances."""
    _step(column, t, h)
    return error_of(_error_5(column, h), _error_3(column, h))
