"""The derived fields of the packed model, and the rest state, from the values that describe a column."""

import math

from ...engine.control import LEAST_TOLERANCE, LIGHTLY_DAMPED
from ...layout.spaces import DASHPOTS
from ...numba_ext.jit import kernel
from ...numba_ext.views import copy
from ..formulations.bonds import begin_bonds
from ..joint.law import joint_forces, law_of
from ..joint.resultants import is_bonded
from ..sections.faces import RECTANGLE
from ..sections.section import contact_of, full_stiffness, full_turning_stiffness
from .rest import find_rest

# The errors of steps add up: each may have this part of the user's tolerance.
STEP_PART = 0.1

# Order 8 is the cheaper explicit method where the tolerance is tight, or where joint modes keep ringing because they
# are damped by less than LIGHTLY_DAMPED of the critical damping.
TIGHT = 2e-5
RINGING_PART = 0.4  # share of the tolerance of a step, where errors do not decay

NO_DAMPING = 1e-300  # s: a dashpot without effect is computed with this value

# Errors are relative to the largest rotation so far, and at least to this part of the rotation at which the base joint
# opens: a column at rest, or nearly, needs no relative accuracy.
FLOOR = 1e-2
LEAST_FLOOR = 1e-9  # rad

# A column has overturned when a block, or the joint under it, has turned by more than this many times the angle at
# which the block alone would stand on its edge (below that angle gravity still rights it), and by at least LEAST_FALL,
# at most a quarter turn.
FALL_MARGIN = 1.5
LEAST_FALL = 0.5  # rad

CARRIED = 1e-9  # relative to the weight: tolerance of the force of a joint at rest


@kernel
def derive(model):
    """Fill in the fields that follow from those that describe the column and its settings.

    The tolerance is the user's on entry and that of a step on return: call once.
    """
    n, settings, blocks = model.n, model.settings, model.blocks
    # tolerance of a step, from that of the response
    tight = settings.tolerance <= TIGHT
    settings.tolerance = max(LEAST_TOLERANCE, STEP_PART * settings.tolerance)
    # geometry and derived constants of each block, from the base up
    height = 0.0  # m, of the top face of the block
    built_x = 0.0  # m, x of the middle of that face, as built
    for i in range(n - 1, -1, -1):
        # position of the top face, m
        height += blocks.height[i]
        built_x += blocks.offset[i] * math.cos(blocks.lean[i]) + blocks.height[i] * math.sin(blocks.tilt[i])
        blocks.built_x[i] = built_x
        # without this short cut an undamped joint has a dashpot, though a negligible one
        if int(settings.without) & DASHPOTS:
            blocks.damping[i] = max(blocks.damping[i], NO_DAMPING)
        blocks.upper[i] = blocks.height[i] - blocks.centroid[i]
        blocks.per_mass[i] = 1.0 / blocks.mass[i]
        blocks.per_inertia[i] = 1.0 / blocks.inertia[i]
        blocks.per_masses[i] = blocks.per_mass[i] + (blocks.per_mass[i + 1] if i + 1 < n else 0.0)
        # stiffness per width (N/m2), and rotation radius of the contact (m)
        blocks.rigidity[i] = blocks.stiffness[i] * blocks.depth[i]
        if blocks.section[i] == RECTANGLE:
            blocks.open_size[i] = blocks.width[i] / math.sqrt(12.0)
        else:
            blocks.open_size[i] = math.sqrt(full_turning_stiffness(blocks, i) / full_stiffness(blocks, i))
        blocks.per_open_size[i] = 1.0 / blocks.open_size[i]
        # rotation at which a block or joint counts as overturned, rad
        left, right = blocks.left[i], blocks.right[i]
        if settings.slides != 0.0:  # with slips and offsets it may turn about any point of its own face
            left, right = blocks.own_left[i], blocks.own_right[i]
        edge_angle = math.atan2(max(-left, right), blocks.centroid[i])
        blocks.fall_angle[i] = min(0.5 * math.pi, max(LEAST_FALL, FALL_MARGIN * edge_angle))

    # an upper bound of the joint modes' frequencies, from each block between two stiff joints
    fastest = 0.0
    opening_rotation = math.inf  # rad, least rotation at which a joint opens at rest
    carried = 0.0
    spring_above = 0.0
    damping = 0.0  # s, the largest
    for i in range(n):
        # bound of the squared frequency by the springs above and below, 1/s2
        spring = full_stiffness(blocks, i)
        fastest = max(fastest, (spring + spring_above) / blocks.mass[i])
        spring_above = spring
        damping = max(damping, blocks.damping[i])
        # least rotation at which a joint opens under the weight it carries
        carried += blocks.mass[i]
        opening_rotation = min(opening_rotation, 2.0 * (settings.gravity * carried / spring) / blocks.width[i])
    fastest = math.sqrt(2.0 * fastest)  # rad/s
    # scales of the integrator
    settings.per_slip = 1.0 / height
    settings.first_step = 0.1 / fastest
    ringing = 0.5 * damping * fastest < LIGHTLY_DAMPED
    settings.explicit_order = 8.0 if tight or ringing else 5.0
    if ringing:
        settings.tolerance = max(LEAST_TOLERANCE, RINGING_PART * settings.tolerance)
    settings.rotation_floor = max(LEAST_FLOOR, FLOOR * opening_rotation)
    settings.rate_floor = settings.rotation_floor * math.sqrt(max(settings.gravity, 1e-3) / height)


@kernel
def settle_joints(model, phase):
    """Fill in the openings (m) of a column at rest under gravity; other values stay."""
    n, blocks = model.n, model.blocks
    carried = 0.0
    for i in range(n):
        carried += blocks.mass[i]
        # opening under the weight above, m: negative
        phase.opening[i] = -(model.settings.gravity * carried / full_stiffness(blocks, i))


@kernel
def rest_of(model, rest, room):
    """Fill a phase of zeros with the rest of a column whose joints have not slid; return True if a stable rest exists.

    A column on its axis, of any law, is checked for joints that carry the weight there.
    """
    blocks, settings = model.blocks, model.settings
    # on the axis: openings under the weight, and bonds as built
    settle_joints(model, rest)
    if is_bonded(model):
        begin_bonds(model, rest)
    if settings.off_axis == 0.0:
        return carries(model)
    # off the axis: Newton's method from the straight column
    copy(rest.slip, blocks.offset, model.n)
    stands = not settings.gravity > 0.0 or find_rest(model, rest, room)
    for i in range(model.n):
        blocks.rest_turn[i] = rest.theta[i] if stands else math.inf  # there is no rest
        blocks.rest_opening[i] = rest.opening[i]
    return stands


@kernel
def carries(model):
    """Return True if all joints carry the weight on them once they settle as far as their stiffness lets them."""
    blocks, weight = model.blocks, 0.0
    for i in range(model.n):
        # weight on the joint, N
        weight += model.settings.gravity * blocks.mass[i]
        # opening of a linear spring under the weight, and the force of the law there
        opening = -weight / full_stiffness(blocks, i)
        normal, _, _ = joint_forces(contact_of(blocks, i), law_of(blocks, i), opening, 0.0, 0.0, 0.0)
        if not abs(normal - weight) <= CARRIED * weight:
            return False
    return True
