"""The joint of six components: a no-tension bed, elastic in shear up to Coulomb's limit (theory.md section 13)."""

import math

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import (
    any_of,
    greater,
    index_of,
    lesser,
    magnitude,
    opposite,
    square_root,
    where,
    with_sign,
    zero_like,
)
from .bearing import TINY, bed_of_point, lifted, with_bearing, with_parallel_forces
from .bed import Plane, chosen, nothing, subtract, whole
from .bond import limits_with_bond, with_bond
from .disc import round_bed
from .kinematics import cross, dot, out_of, plus, push, relative_motion
from .layout import JOINED, POINT
from .overlap import bed_after_slip, goes_by_faces
from .polygon import polygon_bed
from .pressure_shear import bound_of_pressure_shear, pressure_shear
from .section import bearing_area, has_inside, inside_of, outline_of


@leaf
def _has_slid(scene, j):
    slips = scene.slips
    slid = (slips.p1[j] != 0.0) | (slips.p2[j] != 0.0) | (slips.p3[j] != 0.0)
    return slid & (scene.joints.friction[j] != math.inf)


@leaf
def middle_of(scene, j):
    """Return the centre of the contact after slips, m from half-way between the centres of both faces.

    It follows the face that lies within the other one; of equal faces it stays half-way.
    """
    p1, p2 = scene.slips.p1[j], scene.slips.p2[j]
    part = zero_like(p1)
    slid = _has_slid(scene, j)
    if any_of(slid):
        slip = greater(square_root(p1 * p1 + p2 * p2), TINY)
        # middle of the overlap of two discs, as a part of the slip
        part = 0.5 * (scene.joints.rim_b[j] - scene.joints.rim_a[j]) / slip
        # limited to half of the slip
        part = where(slid, greater(lesser(part, 0.5), -0.5), 0.0)
    return part * p1, part * p2


@leaf
def bed_of_joint(scene, j, p, q):
    """Return the bed of joint j from penetration p and damped penetration q (m), with bearing and bond."""
    bond = index_of(scene.joints.bond[j])
    if any_of(scene.joints.section[j] == POINT):
        # a bearing, or faces
        bed = bed_of_point(scene.joints, j, p, q)
    else:
        bed = _bed_of_faces(scene, j, p, q)
    # mortar bears in addition
    if bond > 0:
        bed = with_bond(scene, bond - 1, p, q, bed)
    return bed


@leaf
def _bed_of_faces(scene, j, p, q):
    """Return the bed of the outline of joint j, less that of the inside that its rim leaves open."""
    outline = outline_of(scene, j)
    bed = _bed_of_section(scene, j, outline, p, q)
    rims = has_inside(scene, j)
    if any_of(rims):
        # in full contact both parts are pressed as a whole: no difference of two large numbers
        full = rims & (bed.area == outline.area) & opposite(_has_slid(scene, j))
        rim = subtract(bed, _bed_of_inside(scene, j, p, q))
        bed = chosen(rims, chosen(full, whole(*bearing_area(scene, j), q, bed.largest), rim), bed)
    return bed


@kernel
def _bed_of_inside(scene, j, p, q):
    """Return the bed of the inside that the rim of joint j leaves open."""
    return _bed_of_section(scene, j, inside_of(scene, j), p, q)


@leaf
def _bed_of_section(scene, j, section, p, q):
    """Return the bed of a section of joint j: as built until it has slid, then of the intersection of both faces."""
    bed, slid = nothing(p), goes_by_faces(scene, j, _has_slid(scene, j))
    # lanes that have not slid, with the contact as built
    if any_of(opposite(slid)):
        bed = _bed_as_built(section, p, q)
    # lanes that have slid, with the intersection of the shifted faces
    if any_of(slid):
        bed = chosen(slid, bed_after_slip(scene, j, section, slid, p, q), bed)
    return bed


@leaf
def _bed_as_built(section, p, q):
    # closed forms of polygons and round sections
    area, moments = section.area, section.moments
    if section.is_polygon:
        return polygon_bed(section.corners, section.corners_count, whole(area, moments, q, zero_like(q.at)), p, q)
    return round_bed(section.outer, section.inner, area, moments, p, q)


@leaf
def penetration(scene, j, motion):
    """Return the penetration over the section of joint j, m, as a linear function."""
    gap = motion.gap
    return lifted(scene, j, Plane(-gap[2], motion.turn[1], -motion.turn[0]), gap, (0.5 * gap[0], 0.5 * gap[1]))


@leaf
def penetration_rate(scene, j, motion):
    """Return the rate of the penetration over the section of joint j, m/s, as a linear function."""
    rate, moves = motion.turn_rate, motion.gap_rate
    return lifted(scene, j, Plane(-moves[2], rate[1], -rate[0]), motion.gap, (moves[0], moves[1]))


@leaf
def _rate_on_upper(scene, j, motion, p):
    """Return the rate of the penetration p of joint j where it follows the upper face, m/s, as a linear function.

    Its damping does not feel a slide then, and adds no energy: theory.md section 13.
    """
    joints, rate = scene.joints, penetration_rate(scene, j, motion)
    slides = joints.friction[j] != math.inf
    if any_of(slides & (joints.section[j] != POINT)):
        # half of the relative motion, as that of the face in the frame half-way
        v1, v2 = 0.5 * where(slides, motion.gap_rate[0], 0.0), 0.5 * where(slides, motion.gap_rate[1], 0.0)
        spin = 0.5 * where(slides, motion.turn_rate[2], 0.0)
        moves = p.along_x * v1 + p.along_y * v2
        rate = Plane(rate.at + moves, rate.along_x + p.along_y * spin, rate.along_y - p.along_x * spin)
    return rate


@leaf
def friction_limits(joints, j, normal, g1, g2):
    """Return the largest force along joint j, N, and the largest twisting couple, N m.

    The couple is that of friction about the centre: with the arm of a uniform pressure, or that of the resultant if it
    is farther out. normal, g1, g2: resultants of the pressure about the centre, N and N m.
    """
    pressed = normal > 0.0
    # friction under pressure, and the dowel
    force = where(pressed, joints.friction[j] * normal, 0.0) + joints.dowel[j]
    # a resultant far from the centre has a longer arm
    arm, moment = joints.arm[j], g1 * g1 + g2 * g2
    farther = pressed & (moment > arm * normal * (arm * normal))
    if any_of(farther):
        arm = where(farther, square_root(moment) / normal, arm)
    return force, force * arm


@leaf
def _along_joint(scene, j, motion, p, normal, g1, g2):
    """Return the forces along joint j on the upper block, N, and the twisting couple on its energy, N m.

    A slider in series with a spring and a dashpot moves at the rate at which both together bear the limit of friction,
    in addition to the shear of the pressure. Its rates are stored in the scene. Force and couple act at the centre of
    the contact.

    Parameters
    ----------
    motion : Relative
        Relative motion of the faces.
    p : Plane
        Penetration, m.
    normal, g1, g2 : float or lanes
        Resultants of the pressure, N, N m.
    """
    joints, slips, found, giving = scene.joints, scene.slips, scene.resultants, scene.giving_slips
    shear, twist, damping = joints.shear[j], joints.twist[j], joints.shear_damping[j]
    # elastic slips and twist, and their rates, at the centre of the contact
    x, y = middle_of(scene, j)
    s1, s2, z3, v3 = motion.gap[0], motion.gap[1], motion.turn[2], motion.turn_rate[2]
    s3 = z3 + slips.p3[j]
    z1, z2 = s1 - slips.p1[j] - z3 * y, s2 - slips.p2[j] + z3 * x
    v1, v2 = motion.gap_rate[0] - v3 * y, motion.gap_rate[1] + v3 * x
    # spring and dashpot
    t1, t2 = -shear * (z1 + damping * v1), -shear * (z2 + damping * v2)
    g3 = twist * (z3 + damping * v3)
    # rates of the slider, m/s and rad/s
    r1, r2, r3 = zero_like(v1), zero_like(v2), zero_like(v3)
    if any_of(joints.friction[j] != math.inf):
        # limits of friction
        limit, couple = friction_limits(joints, j, normal, g1 + normal * y, g2 - normal * x)
        limit, couple = limits_with_bond(scene, j, normal, limit, couple, z1 * z1 + z2 * z2, z3)
        # shear of the pressure, evaluated only if friction may reach its limit
        w1, w2, w3 = z1 + damping * v1, z2 + damping * v2, z3 + damping * v3
        bound, turning = bound_of_pressure_shear(scene, j, p, normal)
        least, square = greater(limit - bound, 0.0), shear * shear * greater(w1 * w1 + w2 * w2, z1 * z1 + z2 * z2)
        near = square > least * least
        near = near | (twist * greater(magnitude(w3), magnitude(z3)) > greater(couple - turning, 0.0))
        near, way = near & (joints.friction[j] != math.inf), (w1 + w3 * y, w2 - w3 * x, w3)
        push1, push2, push3 = pressure_shear(scene, j, near, p, normal, g1, g2, way)
        # a twist of the slider rotates the frame, so that a slipped contact moves along the normal
        push3 += 0.5 * motion.per_scalar * normal * (motion.vector[0] * s1 + motion.vector[1] * s2)
        push3 += push1 * y - push2 * x
        f1, f2 = t1 - push1, t2 - push2  # borne by friction
        square = f1 * f1 + f2 * f2
        # force beyond the limit: the slider moves
        slides = square > limit * limit
        if any_of(slides):
            part = limit / square_root(square)
            rate = (1.0 - part) / (shear * damping)
            r1, r2 = where(slides, -f1 * rate, r1), where(slides, -f2 * rate, r2)
            t1, t2 = where(slides, f1 * part + push1, t1), where(slides, f2 * part + push2, t2)
        # elastic slip within the limit, for the energy and a rest
        f1, f2 = -(shear * z1) - push1, -(shear * z2) - push2
        square = f1 * f1 + f2 * f2
        beyond = square > limit * limit
        if any_of(beyond):
            part = limit / square_root(square)
            z1 = where(beyond, -(f1 * part + push1) / shear, z1)
            z2 = where(beyond, -(f2 * part + push2) / shear, z2)
        # likewise the twist, but for bearings, which do not resist one
        f3 = g3 + push3
        size, resists = magnitude(f3), twist > 0.0
        twists = resists & (size > couple)
        if any_of(twists):
            r3 = where(twists, with_sign((size - couple) / (twist * damping), f3), r3)
            g3 = where(twists, with_sign(couple, f3) - push3, g3)
        f3 = twist * z3 + push3
        beyond = resists & (magnitude(f3) > couple)
        if any_of(beyond):
            z3 = where(beyond, (with_sign(couple, f3) - push3) / twist, z3)
    g3 += t1 * y - t2 * x  # moment about the place half-way
    t1, t2 = with_parallel_forces(scene, j, motion, normal, t1, t2)
    turned = 0.5 * motion.per_scalar * motion.gap[2] * r3  # slip by the rotation of the frame as the slider twists
    # store rates and resultants
    giving.p1[j], giving.p2[j] = r1 + r3 * y - turned * motion.vector[0], r2 - r3 * x - turned * motion.vector[1]
    giving.p3[j] = r3
    found.t1[j], found.t2[j], found.g3[j] = t1, t2, g3
    found.s1[j], found.s2[j], found.s3[j] = s1, s2, s3
    found.z1[j], found.z2[j], found.z3[j] = z1 + z3 * y, z2 - z3 * x, z3
    return t1, t2, g3


@leaf
def is_held(scene, j):
    """Return True unless joint j has ended after a fall."""
    pair = index_of(scene.joints.pair[j])
    return pair == 0 or any_of(scene.extras.stretches.touches[pair - 1] == JOINED)


@leaf
def load_joint(scene, phase, j):
    """Add the forces of joint j to those on its two bodies, and store its resultants in the scene; none once ended."""
    if is_held(scene, j):
        _load_held(scene, phase, j)
    else:
        _release(scene, j)


@kernel
def _release(scene, j):
    """Clear the resultants of a joint that has ended, and the rates of its slider."""
    found, giving = scene.resultants, scene.giving_slips
    zero = zero_like(found.normal[j])
    found.normal[j], found.area[j], found.pressure[j] = zero, zero, zero
    found.g1[j], found.g2[j], found.g3[j], found.t1[j], found.t2[j] = zero, zero, zero, zero, zero
    giving.p1[j], giving.p2[j], giving.p3[j] = zero, zero, zero


@kernel
def _load_held(scene, phase, j):
    joints, found = scene.joints, scene.resultants
    # pressure and its resultants
    motion = relative_motion(scene, phase, j)
    p = penetration(scene, j, motion)
    rate = _rate_on_upper(scene, j, motion, p)
    # damped penetration
    eta, k = joints.damping[j], joints.stiffness[j]
    q = Plane(p.at + eta * rate.at, p.along_x + eta * rate.along_x, p.along_y + eta * rate.along_y)
    bed = bed_of_joint(scene, j, p, q)
    normal, g1, g2 = k * bed.force, -k * bed.first_y, k * bed.first_x
    found.normal[j], found.g1[j], found.g2[j] = normal, g1, g2
    found.area[j], found.pressure[j] = bed.area, k * bed.largest
    # forces along the joint
    t1, t2, g3 = _along_joint(scene, j, motion, p, normal, g1, g2)
    force, couple = (t1, t2, normal), (g1, g2, g3)
    # couples about both faces' centres, from the derivatives of the energy by the rotation
    across = cross(motion.gap, force)
    vector, per = motion.vector, motion.per_scalar
    own = plus((-g1, -g2, -g3), vector, per * dot(vector, couple))
    lever = cross(across, vector)
    on_a = plus(plus(own, across, -0.5), lever, 0.5 * per)
    on_b = plus(plus((-own[0], -own[1], -own[2]), across, -0.5), lever, -0.5 * per)
    # along the axes of the base
    e1, e2, e3 = motion.e1, motion.e2, motion.e3
    force = out_of(e1, e2, e3, force)
    push(scene.poses, index_of(joints.upper[j]), motion.arm_a, force, out_of(e1, e2, e3, on_a), 1.0)
    push(scene.poses, index_of(joints.lower[j]), motion.arm_b, force, out_of(e1, e2, e3, on_b), -1.0)


@kernel
def joint_energy(scene, phase, j):
    """Return the elastic energy of joint j, J, for the phase of the last evaluation.

    Along a pressed joint it is that of the whole elastic slip, also where the dashpot bears what exceeds friction.
    """
    joints, found = scene.joints, scene.resultants
    if not is_held(scene, j):
        return zero_like(found.normal[j])
    # bed without damping
    p = penetration(scene, j, relative_motion(scene, phase, j))
    bed = bed_of_joint(scene, j, p, p)
    square = p.at * bed.force + p.along_x * bed.first_x + p.along_y * bed.first_y  # integral of p^2
    # elastic slips and twist at the centre of the contact
    (x, y), slips, pressed = middle_of(scene, j), scene.slips, found.normal[j] > 0.0
    z3 = where(pressed, found.s3[j] - slips.p3[j], found.z3[j])
    z1 = where(pressed, found.s1[j] - slips.p1[j], found.z1[j]) - z3 * y
    z2 = where(pressed, found.s2[j] - slips.p2[j], found.z2[j]) + z3 * x
    shear, twist = z1 * z1 + z2 * z2, z3 * z3
    doubled = joints.stiffness[j] * square + joints.shear[j] * shear + joints.twist[j] * twist
    return 0.5 * with_bearing(scene, j, doubled)
