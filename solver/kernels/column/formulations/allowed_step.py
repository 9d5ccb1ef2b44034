"""The longest communication step at which a base driven by bodies is stable with the column on it (theory.md, 15).

The column on the base vibrates on its joints: a mass m on a spring k and a dashpot c that move with the base. Within
a step the model follows that exactly; the force on the base acts on its mass M at the exchanges alone, and continues by
the rule for the slope of the acceleration. With d for the deformation, and a + j s over a step,

    d'' = -(c d' + k d) / m - (a + j s),    a = (c d' + k d) / M  at the exchange

A step is too long where this recurrence grows.
"""

from ...engine.allowed_step import is_new, longest_step
from ...layout.spaces import BODY
from ...numba_ext.jit import kernel
from ..sections.section import full_stiffness, full_turning_stiffness


@kernel
def examine_step(model, base, h):
    """Store in `base.allowed_step` the longest stable step (s) if h is too long for the column on its base.

    The lowest block vibrates on its joint: along x by rocking, which moves the effective mass at the joint.
    """
    settings, blocks, low = model.settings, model.blocks, model.n - 1
    if not base.mass_x > 0.0 or not is_new(base, h, base.mass_x + base.mass_z + base.mass_turn):
        return
    way, eta, above, mass = settings.slope, blocks.damping[low], blocks.centroid[low], blocks.mass[low]
    turning, inertia = full_turning_stiffness(blocks, low), blocks.inertia[low] + mass * above * above
    by_turn = mass * above / inertia  # 1/m, rotation per unit of motion along x
    spring = turning * by_turn * by_turn
    # along x; where bodies drive the whole base, also along z and in rotation
    found = longest_step(way, h, eta * spring, spring, inertia * by_turn * by_turn, base.mass_x)
    if settings.drive == BODY:
        spring = full_stiffness(blocks, low)
        found = min(found, longest_step(way, h, eta * spring, spring, mass, base.mass_z))
        found = min(found, longest_step(way, h, eta * turning, turning, inertia, base.mass_turn))
    if found < h:
        base.allowed_step = found
