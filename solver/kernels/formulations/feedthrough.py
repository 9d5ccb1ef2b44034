"""Direct feedthrough of the base: the reaction split into R0 and the part that follows the base acceleration at once.

The column is rigid along the tangent of every joint, so that its base reaction R = (Fx, Fz, My) and the forces along
the joints depend on the base acceleration a = (a_x, a_z, alpha) of the same instant (theory.md section 7):

    R = R0 - M a,     M = mu g g',     g = (cos phi, -sin phi, delta / 2)

phi and delta are those of the base joint, mu is the last inverse pivot of exact.py: the mass that the column opposes
along that joint. The joint is elastic along its normal, so M has rank one. All functions of this module read the
results of `evaluate` in `work` and evaluate nothing in the exact formulation.
"""

from ..joint.sliding import can_slide
from ..layout.spaces import OK
from ..numba_ext.jit import kernel
from ..numba_ext.numbers import sine_cosine
from ..numba_ext.views import copy
from .dispatch import evaluate, is_exact
from .exact import Motion, joint_row
from .first_order import sweep_rows


@kernel
def base_direction(model, phase, base_turn):
    """g (1, 1, m): the acceleration of the base joint along its tangent is g . (a_x, a_z, alpha); exact formulation.

    base_turn: rotation of the base, rad.
    """
    last = model.n - 1
    sine, cosine = sine_cosine(0.5 * phase.theta[last] + base_turn + model.blocks.lean[last])
    return cosine, -sine, 0.5 * phase.opening[last]


@kernel
def effective_mass(model, work):
    """mu, kg: mass that the column opposes to that acceleration, from the last evaluation; exact formulation.

    None where the base joint slides: friction does not follow the acceleration at once.
    """
    if can_slide(model) and work.joints.sliding[model.n - 1] != 0.0:
        return 0.0
    return joint_row(work.room, model.n - 1).pivot


@kernel
def tangential_gains(model, work, gains):
    """Derivatives of the tangential forces T_i, kg, by that acceleration, from the last evaluation: row of n.

    No other resultant (N, M) follows the acceleration of the base at once. Exact formulation.
    """
    n = model.n
    gain = joint_row(work.room, n - 1).pivot
    for i in range(n - 1, -1, -1):
        if can_slide(model) and work.joints.sliding[i] != 0.0:
            gain = 0.0
        gains[i] = gain
        if i > 0:
            gain = -joint_row(work.room, i).part * gain


@kernel
def _paper_effective_mass(column, phase, motion):
    """(code, mu, phi) of the first-order model, linear in the acceleration too: from one more evaluation."""
    model, work = column.model, column.work
    n = model.n
    aside = work.start  # not in use while outputs are computed
    copy(aside.row, phase.row, 6 * n)
    rows = sweep_rows(work.room)
    force = rows.horizontal[n - 1]
    change = model.settings.gravity + 1.0
    code = evaluate(column, aside, Motion(motion.ax + change, motion.az, 0.0, 0.0, 0.0))
    return code, (rows.horizontal[n - 1] - force) / change, 0.5 * rows.theta[n - 1]


@kernel
def split_reaction(column, phase, motion, row, split):
    """Split the base reaction of an output row, just observed at the phase, into R0 and M. Returns a code.

    R = R0 - M a to rounding. In the paper formulation M is that to the first order of the rotations, g = (1, -phi, 0).
    """
    model = column.model
    if is_exact(model):
        mu = effective_mass(model, column.work)
        g_x, g_z, g_m = base_direction(model, phase, motion.theta)
    else:
        code, mu, phi = _paper_effective_mass(column, phase, motion)
        if code != OK:
            return code
        g_x, g_z, g_m = 1.0, -phi, 0.0
    met = mu * (g_x * motion.ax + g_z * motion.az + g_m * motion.alpha)
    split.R0x = row.base.Fx + g_x * met
    split.R0z = row.base.Fz + g_z * met
    split.R0m = row.base.My + g_m * met
    split.mxx = mu * g_x * g_x
    split.mxz = mu * g_x * g_z
    split.mxt = mu * g_x * g_m
    split.mzz = mu * g_z * g_z
    split.mzt = mu * g_z * g_m
    split.mtt = mu * g_m * g_m
    return OK
