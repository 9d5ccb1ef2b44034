"""The outputs of the paper's equations, and u_x, which is v."""

from ..column.formulations.base_motion import base_motion
from ..column.formulations.dispatch import base_as_shown, reach_of, top_motion
from ..column.formulations.exact import Motion
from ..column.formulations.feedthrough import share_reaction, split_reaction
from ..column.formulations.outputs import show, show_joint
from ..column.joint.sliding import less_below
from ..layout.spaces import OK, RIGID_FIELDS
from ..numba_ext.views import copy
from .equations import evaluate, of_paper, sweep_rows, tilt


@show.version(of_paper)
def _show(column, phase, resultants, motion, row):
    model, joints, base = column.model, row.joints, row.base
    n, blocks = model.n, model.blocks
    turn_below, spin_below = 0.0, 0.0
    # outputs of the joints, from the base up
    for i in range(n - 1, -1, -1):
        turn, spin = tilt(blocks, phase.theta, i, n), tilt(blocks, phase.theta_rate, i, n)
        opening, opening_rate = -less_below(phase.opening, i, n), -less_below(phase.opening_rate, i, n)
        phi, slope, slope_rate = 0.5 * (turn + turn_below), turn - turn_below, spin - spin_below
        joints.uz[i] = -phase.opening[i]
        joints.theta[i] = turn
        show_joint(model, i, resultants, phi, 1.0, opening, slope, opening_rate, slope_rate, 0.0, joints)
        turn_below, spin_below = turn, spin
    # base reaction
    weight = 0.0
    for i in range(n):
        weight += blocks.mass[i] * (model.settings.gravity + motion.az - phase.opening_acceleration[i])
    base.Fx = joints.S[n - 1]
    base.Fz = -weight
    base.My = joints.M[n - 1]


@base_as_shown.version(of_paper)
def _base_as_shown(column, t):
    return base_motion(column, t)


@top_motion.version(of_paper)
def _top_motion(column, phase, ux, rate, turn, spin):
    copy(ux, phase.theta, column.model.n)
    copy(rate, phase.theta_rate, column.model.n)


@reach_of.version(of_paper)
def _reach_of(column, first, last, i):
    return abs(less_below(first, i, column.model.n))


@split_reaction.version(of_paper)
def _split_reaction(column, phase, motion, row, split):
    """Split the base reaction to the first order of the rotations: g = (1, -phi, 0).

    mu follows from one more evaluation: the model is linear in the acceleration of the base.
    """
    model, work = column.model, column.work
    n = model.n
    aside = work.start  # not in use while outputs are computed
    copy(aside.row, phase.row, RIGID_FIELDS * n)
    rows = sweep_rows(work.room.row, n)
    force = rows.horizontal[n - 1]
    # the horizontal reaction at another base acceleration
    change = model.settings.gravity + 1.0
    code = evaluate(column, aside, Motion(motion.ax + change, motion.az, 0.0, 0.0, 0.0))
    mu = (rows.horizontal[n - 1] - force) / change
    if code == OK:
        share_reaction(mu, (1.0, -0.5 * rows.theta[n - 1], 0.0), motion, row, split)
    return code
