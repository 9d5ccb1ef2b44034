"""Direct feedthrough of the base: the reaction split into R0 and what follows the base acceleration at once.

The column is rigid along the tangent of every joint, so that its base reaction R = (Fx, Fz, My) and the shears depend
on the base acceleration a = (a_x, a_z, alpha) of the same instant (theory.md section 7):

    R = R0 - M a,     M = mu g g',     g = (cos phi, -sin phi, delta / 2)

phi and delta are those of the base joint, mu is what the recursion of exact.py finds on its way down: the mass that the
column opposes along that joint. Along the normal the joint gives way, hence the rank of one. All functions here read
what `accelerate` has left in the scratch and evaluate nothing in the exact formulation.
"""

from .dynamics import accelerate_on, scratch_offset
from .exact import ABOVE_S, FORCE_S, sine_cosine
from .jit import kernel
from .layout import (
    EXACT,
    FORMULATION,
    GRAVITY,
    N_BLOCKS,
    OK,
    ROW_FIELDS,
    ROW_FX,
    ROW_FZ,
    ROW_MY,
    SCRATCH_FIELDS,
    SPLIT_MTT,
    SPLIT_MXT,
    SPLIT_MXX,
    SPLIT_MXZ,
    SPLIT_MZT,
    SPLIT_MZZ,
    SPLIT_R0M,
    SPLIT_R0X,
    SPLIT_R0Z,
)
from .paper import SUM_HORIZONTAL, THETA

PHASE_ASIDE = 1  # of the work array


@kernel
def base_direction(model, x, o, base_turn):
    """g (1, 1, m): the acceleration of the base joint along its tangent is g . (a_x, a_z, alpha); exact formulation.

    x[o:]: a phase, rotations relative to the base; base_turn: rotation of the base, rad.
    """
    n = int(model[N_BLOCKS])
    sine, cosine = sine_cosine(0.5 * x[o + n - 1] + base_turn)
    return cosine, -sine, 0.5 * x[o + 2 * n - 1]


@kernel
def effective_mass(model, work):
    """mu, kg: what the column opposes to that acceleration, from the last call of `accelerate`; exact formulation."""
    n = int(model[N_BLOCKS])
    return work[scratch_offset(n) + SCRATCH_FIELDS * (n - 1) + FORCE_S]


@kernel
def shear_gains(model, x, o, base_turn, work, out, at):
    """Derivatives of the shears S_i, kg, by that acceleration, from the last call of `accelerate`: out[at:at + n].

    dS_i = out[at + i] * (g . da) with g of `base_direction`; no other resultant (N, M) follows the acceleration of the
    base at once. Exact formulation.
    """
    n = int(model[N_BLOCKS])
    scratch = scratch_offset(n)
    below = 0.0
    gain = 1.0  # of the acceleration along joint i
    for i in range(n - 1, -1, -1):
        turn = x[o + i]
        _, cosine = sine_cosine(0.5 * (turn + below) + base_turn)
        out[at + i] = -cosine * work[scratch + SCRATCH_FIELDS * i + FORCE_S] * gain
        gain *= work[scratch + SCRATCH_FIELDS * i + ABOVE_S]
        below = turn


@kernel
def _paper_effective_mass(model, x, o, base, work, counters):
    """(code, mu, phi) of the first-order model, linear in the acceleration too: from one more evaluation."""
    n = int(model[N_BLOCKS])
    last = scratch_offset(n) + SCRATCH_FIELDS * (n - 1)
    aside = 6 * n * PHASE_ASIDE
    for i in range(6 * n):
        work[aside + i] = x[o + i]
    force = work[last + SUM_HORIZONTAL]
    change = model[GRAVITY] + 1.0
    code = accelerate_on(model, work, aside, (base[0] + change, base[1], 0.0, 0.0, 0.0), work, counters)
    return code, (work[last + SUM_HORIZONTAL] - force) / change, 0.5 * work[last + THETA]


@kernel
def split_reaction(model, x, o, base, work, counters, rows, r, split):
    """Split the base reaction of output row r, just observed at the phase x[o:], into R0 and M. Returns a code.

    split: as layout.py lists it. R = R0 - M a to rounding. In the paper formulation M is that to the first order of the
    rotations, g = (1, -phi, 0).
    """
    n = int(model[N_BLOCKS])
    if model[FORMULATION] == EXACT:
        mu = effective_mass(model, work)
        g_x, g_z, g_m = base_direction(model, x, o, base[2])
    else:
        code, mu, phi = _paper_effective_mass(model, x, o, base, work, counters)
        if code != OK:
            return code
        g_x, g_z, g_m = 1.0, -phi, 0.0
    met = mu * (g_x * base[0] + g_z * base[1] + g_m * base[4])
    tail = ROW_FIELDS * n
    split[SPLIT_R0X] = rows[r, tail + ROW_FX] + g_x * met
    split[SPLIT_R0Z] = rows[r, tail + ROW_FZ] + g_z * met
    split[SPLIT_R0M] = rows[r, tail + ROW_MY] + g_m * met
    split[SPLIT_MXX] = mu * g_x * g_x
    split[SPLIT_MXZ] = mu * g_x * g_z
    split[SPLIT_MXT] = mu * g_x * g_m
    split[SPLIT_MZZ] = mu * g_z * g_z
    split[SPLIT_MZT] = mu * g_z * g_m
    split[SPLIT_MTT] = mu * g_m * g_m
    return OK
