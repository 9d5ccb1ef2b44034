"""Contact of neighbouring blocks that no joint connects (theory.md section 17).

The normal forces are those of drum_contact.py and face_contact.py. They act on both blocks at one point, so that
momentum is conserved. Friction is a slider in series with a spring and a dashpot, perpendicular to the resultant of the
contact. A pair touches or not during a whole step: a step ends where a gap closes (meeting.py), so that the damping of
an impact, which starts abruptly, leaves steps smooth. Pairs that are apart are not evaluated.
"""

import math

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import greater, magnitude, zero_like
from .drum_contact import gap_before_face, gap_of_drums, load_drum_before_face, load_drums
from .face_contact import gap_of_faces, load_faces
from .kinematics import dot, minus, plus
from .layout import DRUMS, MEMORY, PLANE, STRETCH
from .sides import arms_to, place_of, push_both, scaled, sides_of, velocity_of

_stretch, _PER_JOINT = STRETCH.over, MEMORY.per_n


@leaf
def _add_friction(scene, phase, extras, p, sides, touch):
    """Add the friction of pair p to the forces; store the rates of its stretch in the scene.

    Friction acts perpendicular to the resultant of the contact, the normal of the side on which the other one's edge
    slides. touch: the contact without friction (`Touch`).
    """
    pairs, stretch, giving = extras.pairs, extras.stretches, extras.giving_stretches
    # direction of the resultant
    pressed = math.sqrt(dot(touch.resultant, touch.resultant))
    n = scaled(touch.resultant, 1.0 / pressed) if pressed > 0.0 else sides.v
    # relative velocity and elastic stretch, tangential components
    on_a, on_b = arms_to(sides, touch.place)
    v = minus(velocity_of(scene, phase, sides.a, on_a), velocity_of(scene, phase, sides.b, on_b))
    v = plus(v, n, -dot(v, n))
    z = stretch.z1[p], stretch.z2[p], stretch.z3[p]
    z = plus(z, n, -dot(z, n))
    # spring and dashpot
    lag, limit = pairs.shear_damping[p], pairs.friction[p] * pressed
    force = scaled(plus(z, v, lag), -pairs.shear[p])
    size = math.sqrt(dot(force, force))
    # the slider moves so fast that spring and dashpot bear the limit
    if size > limit:
        part = limit / size
        v = plus(v, plus(scaled(z, 1.0 / lag), v, 1.0), part - 1.0)
        force = scaled(force, part)
        extras.hits.slides[p] = 1.0
    giving.z1[p], giving.z2[p], giving.z3[p] = v
    push_both(scene, sides, touch.place, force)


@kernel
def load_pair(scene, phase, extras, p):
    """Add the forces of pair p to those on its two blocks if it touches.

    Fills the force (N), energy (J) and sliding flag of the pair, and the rates of its stretch (m/s); all are zero of a
    pair that is apart.
    """
    hits, giving, pairs = extras.hits, extras.giving_stretches, extras.pairs
    # pairs that are apart exert nothing
    hits.force[p], hits.energy[p], hits.slides[p] = 0.0, 0.0, 0.0
    giving.z1[p], giving.z2[p], giving.z3[p] = 0.0, 0.0, 0.0
    hits.bears[p] = extras.stretches.touches[p]
    if hits.bears[p] == 0.0:
        return
    # normal forces, by kind
    sides = sides_of(scene, phase, pairs, p)
    if pairs.kind[p] == DRUMS:
        touch = load_drums(scene, phase, pairs, p, sides)
    elif pairs.kind[p] == PLANE:
        touch = load_drum_before_face(scene, phase, pairs, p, sides)
    else:
        touch = load_faces(scene, phase, pairs, p, sides)
    hits.force[p], hits.energy[p] = touch.force, touch.energy
    # friction
    if pairs.friction[p] > 0.0:
        _add_friction(scene, phase, extras, p, sides, touch)


@kernel
def load_pairs(scene, phase):
    """Add the forces of all pairs that touch to those on their blocks."""
    touches, bears = scene.extras.stretches.touches, scene.extras.hits.bears
    for p in range(scene.extras.met):
        if touches[p] != 0.0 or bears[p] != 0.0:
            load_pair(scene, phase, scene.extras, p)


@leaf
def stretches_in(scene, remembered):
    """Return the table of pair stretches within all that a state remembers."""
    return _stretch(remembered[_PER_JOINT * scene.m + scene.k :], scene.extras.met)


@kernel
def error_of_pairs(scene, errors):
    """Return the largest error of a pair stretch, m."""
    z, largest = stretches_in(scene, errors), zero_like(scene.settings.tolerance)
    for p in range(scene.extras.met):
        largest = greater(largest, magnitude(z.z1[p]) + magnitude(z.z2[p]) + magnitude(z.z3[p]))
    return largest


@kernel
def pairs_energy(scene):
    """Return the elastic energy of all pairs at the last evaluation, J."""
    z, pairs, total = scene.extras.stretches, scene.extras.pairs, 0.0
    for p in range(scene.extras.met):
        # normal contact and elastic stretch
        square = z.z1[p] * z.z1[p] + z.z2[p] * z.z2[p] + z.z3[p] * z.z3[p]
        total += scene.extras.hits.energy[p] + 0.5 * pairs.shear[p] * square
    return total


@kernel
def gap_of(scene, phase, pairs, p):
    """Return the distance of both sides of pair p, m: negative by the deepest overlap, beyond the ends that to them."""
    sides = sides_of(scene, phase, pairs, p)
    # by kind
    if pairs.kind[p] == DRUMS:
        return gap_of_drums(pairs, p, sides)
    if pairs.kind[p] == PLANE:
        return gap_before_face(scene, pairs, p, sides)
    return gap_of_faces(scene, pairs, p, sides)


@leaf
def is_near(scene, phase, pairs, p):
    """Return True if the bounding spheres of both blocks of pair p overlap."""
    # distance of the centroids against both radii
    between = minus(place_of(scene, phase, int(pairs.one[p])), place_of(scene, phase, int(pairs.other[p])))
    return dot(between, between) < pairs.reach[p] * pairs.reach[p]
