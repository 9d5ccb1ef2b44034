"""The direct feedthrough of the base: the reaction split into R0 and the part proportional to the base acceleration.

The column is rigid along the tangent of every joint, so that its base reaction R = (Fx, Fz, My) and the forces along
the joints depend on the base acceleration a = (a_x, a_z, alpha) of the same instant (theory.md section 7):

    R = R0 - M a,     M = mu g g',     g = (cos phi, -sin phi, delta / 2)

phi and delta are those of the base joint, mu is the last inverse pivot of exact.py: the mass that the column opposes
along that joint. The joint is elastic along its normal, so M has rank one. All functions of this module read the
results of `evaluate` in `work` and evaluate nothing.
"""

from ...layout.spaces import OK
from ...numba_ext.jit import kernel, leaf, varied
from ...numba_ext.numbers import sine_cosine
from ..joint.sliding import can_slide
from .exact import joint_row


@kernel
def base_direction(model, phase, base_turn):
    """Return g (1, 1, m): the acceleration of the base joint along its tangent is g . (a_x, a_z, alpha).

    base_turn: rotation of the base, rad.
    """
    last = model.n - 1
    sine, cosine = sine_cosine(0.5 * phase.theta[last] + base_turn + model.blocks.lean[last])
    return cosine, -sine, 0.5 * phase.opening[last]


@kernel
def effective_mass(model, work):
    """Return mu (kg): the mass that the column opposes to that acceleration, from the last evaluation.

    It is 0 where the base joint slides: friction does not follow the acceleration at once.
    """
    if can_slide(model) and work.joints.sliding[model.n - 1] != 0.0:
        return 0.0
    return joint_row(work.room, model.n - 1).pivot


@kernel
def tangential_gains(model, work, gains):
    """Fill `gains` (kg, row of n) with the derivatives of T_i by that acceleration, from the last evaluation.

    No other resultant (N, M) follows the acceleration of the base at once.
    """
    n = model.n
    gain = joint_row(work.room, n - 1).pivot
    for i in range(n - 1, -1, -1):
        # nothing passes a joint that slides
        if can_slide(model) and work.joints.sliding[i] != 0.0:
            gain = 0.0
        gains[i] = gain
        if i > 0:
            gain = -joint_row(work.room, i).part * gain


@varied
def split_reaction(column, phase, motion, row, split):
    """Split the base reaction of an output row, just observed at the phase, into R0 and M: R = R0 - M a to rounding.

    Returns a code.
    """
    model = column.model
    share_reaction(effective_mass(model, column.work), base_direction(model, phase, motion.theta), motion, row, split)
    return OK


@leaf
def share_reaction(mu, direction, motion, row, split):
    """Split the base reaction as `split_reaction`, from mu (kg) and the direction g."""
    g_x, g_z, g_m = direction
    met = mu * (g_x * motion.ax + g_z * motion.az + g_m * motion.alpha)
    # R0 = R + M a, then M = mu g g'
    split.R0x = row.base.Fx + g_x * met
    split.R0z = row.base.Fz + g_z * met
    split.R0m = row.base.My + g_m * met
    split.mxx = mu * g_x * g_x
    split.mxz = mu * g_x * g_z
    split.mxt = mu * g_x * g_m
    split.mzz = mu * g_z * g_z
    split.mzt = mu * g_z * g_m
    split.mtt = mu * g_m * g_m
