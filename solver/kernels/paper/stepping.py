"""The central differences at a fixed step, the paper's integrator (eqs. 25 and 26), in the one stepping loop.

Written with the velocities at the steps (velocity Verlet), which gives the same displacements as u(t+h) - 2 u(t) +
u(t-h) = h^2 u''(t) and its usual start, without the loss of digits in the second difference. Order 2, symplectic. The
rates that dampers and velocity terms need at the new time are the half-step rates extrapolated with the last
acceleration.
"""

import math

from ..column.formulations.base_motion import anchor_wave
from ..column.formulations.dispatch import evaluate_at
from ..column.stepping.advance import finish_step, take_step
from ..column.stepping.condition import rotation
from ..layout.spaces import OK, SLACK
from ..numba_ext.jit import leaf
from .equations import is_paper, of_paper, tilt


@leaf
def predict(work, h):
    """Predict the coordinates at the end of a step of h seconds; extrapolate rates and accelerations from the start."""
    start, end = work.start, work.end
    for i in range(2 * work.n):
        acceleration = start.accelerations[i]
        half_rate = start.rates[i] + 0.5 * h * acceleration
        end.coordinates[i] = start.coordinates[i] + h * half_rate
        end.rates[i] = half_rate + 0.5 * h * acceleration
        end.accelerations[i] = acceleration


@leaf
def correct(work, h):
    """Correct the rates at the end of a step of h seconds by the accelerations there."""
    start, end = work.start, work.end
    for i in range(2 * work.n):
        change = end.accelerations[i] - start.accelerations[i]
        end.rates[i] += 0.5 * h * change


@leaf
def in_equal_steps(left, step):
    """Return the number of equal steps, of at most `step` s each, that divide `left` s."""
    # rounding: a remainder of 0.00999...98 or 0.0100...02 is one step of 0.01
    return max(1.0, math.ceil(left / step * (1.0 - SLACK)))


@take_step.version(of_paper)
def _take_step(column, watch, t, left, to_sample):
    work = column.work
    anchor_wave(column.base, t)
    pieces = in_equal_steps(to_sample, column.model.settings.step)
    step = to_sample if pieces == 1.0 else to_sample / pieces
    predict(work, step)
    code = evaluate_at(column, work.end, t + step)
    correct(work, step)
    return finish_step(column, watch, t, step) if code == OK else (code, step)


@rotation.version(is_paper)
def _rotation(model, row, i):
    return tilt(model.blocks, row, i, model.n)
