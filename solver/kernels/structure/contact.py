"""Contact of blocks that stand beside each other and that no joint connects (theory.md section 17).

Forces across are those of drum_contact.py and face_contact.py. They act on both blocks at one place, so that momentum
is kept. Along the contact a slider in series with a spring and a dashpot bears what friction does, where the resultant
across is. A pair touches or not from one end of a step to the next: a step ends where a gap closes (meeting.py), so
that the damping of an impact, which begins at once, leaves steps smooth. Nothing is evaluated of a pair that is apart.
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
def _rub(scene, phase, extras, p, sides, touch):
    """Add the force of friction; the rates of what it stretches by are left in the scene.

    It acts across the resultant of all that the contact bears: the normal of the side on which the other one's edge
    slides.
    """
    pairs, stretch, giving = extras.pairs, extras.stretches, extras.giving_stretches
    pressed = math.sqrt(dot(touch.resultant, touch.resultant))
    n = scaled(touch.resultant, 1.0 / pressed) if pressed > 0.0 else sides.v
    on_a, on_b = arms_to(sides, touch.place)
    v = minus(velocity_of(scene, phase, sides.a, on_a), velocity_of(scene, phase, sides.b, on_b))
    v = plus(v, n, -dot(v, n))
    z = stretch.z1[p], stretch.z2[p], stretch.z3[p]
    z = plus(z, n, -dot(z, n))
    lag, limit = pairs.shear_damping[p], pairs.friction[p] * pressed
    force = scaled(plus(z, v, lag), -pairs.shear[p])
    size = math.sqrt(dot(force, force))
    if size > limit:
        part = limit / size
        v = plus(v, plus(scaled(z, 1.0 / lag), v, 1.0), part - 1.0)
        force = scaled(force, part)
        extras.hits.slides[p] = 1.0
    giving.z1[p], giving.z2[p], giving.z3[p] = v
    push_both(scene, sides, touch.place, force)


@kernel
def load_pair(scene, phase, extras, p):
    """Add the forces of a pair that touches to those on its two blocks; one that has let go bears nothing."""
    hits, giving, pairs = extras.hits, extras.giving_stretches, extras.pairs
    hits.force[p], hits.energy[p], hits.slides[p] = 0.0, 0.0, 0.0
    giving.z1[p], giving.z2[p], giving.z3[p] = 0.0, 0.0, 0.0
    hits.bears[p] = extras.stretches.touches[p]
    if hits.bears[p] == 0.0:
        return
    sides = sides_of(scene, phase, pairs, p)
    if pairs.kind[p] == DRUMS:
        touch = load_drums(scene, phase, pairs, p, sides)
    elif pairs.kind[p] == PLANE:
        touch = load_drum_before_face(scene, phase, pairs, p, sides)
    else:
        touch = load_faces(scene, phase, pairs, p, sides)
    hits.force[p], hits.energy[p] = touch.force, touch.energy
    if pairs.friction[p] > 0.0:
        _rub(scene, phase, extras, p, sides, touch)


@kernel
def load_pairs(scene, phase):
    """Add the forces of all pairs that touch."""
    touches, bears = scene.extras.stretches.touches, scene.extras.hits.bears
    for p in range(scene.extras.met):
        if touches[p] != 0.0 or bears[p] != 0.0:
            load_pair(scene, phase, scene.extras, p)


@leaf
def stretches_in(scene, remembered):
    """What a state remembers of pairs, from all that it remembers."""
    return _stretch(remembered[_PER_JOINT * scene.m + scene.k :], scene.extras.met)


@kernel
def error_of_pairs(scene, errors):
    """Largest error, m, of what pairs are stretched by."""
    z, largest = stretches_in(scene, errors), zero_like(scene.settings.tolerance)
    for p in range(scene.extras.met):
        largest = greater(largest, magnitude(z.z1[p]) + magnitude(z.z2[p]) + magnitude(z.z3[p]))
    return largest


@kernel
def pairs_energy(scene):
    """Elastic energy of all pairs, J, of the last evaluation."""
    z, pairs, total = scene.extras.stretches, scene.extras.pairs, 0.0
    for p in range(scene.extras.met):
        square = z.z1[p] * z.z1[p] + z.z2[p] * z.z2[p] + z.z3[p] * z.z3[p]
        total += scene.extras.hits.energy[p] + 0.5 * pairs.shear[p] * square
    return total


@kernel
def gap_of(scene, phase, pairs, p):
    """Distance of both sides of pair p, m, below 0 by the deepest overlap; beside their ends that of these."""
    sides = sides_of(scene, phase, pairs, p)
    if pairs.kind[p] == DRUMS:
        return gap_of_drums(pairs, p, sides)
    if pairs.kind[p] == PLANE:
        return gap_before_face(scene, pairs, p, sides)
    return gap_of_faces(scene, pairs, p, sides)


@leaf
def is_near(scene, phase, pairs, p):
    """Whether the spheres about both blocks of a pair overlap."""
    between = minus(place_of(scene, phase, int(pairs.one[p])), place_of(scene, phase, int(pairs.other[p])))
    return dot(between, between) < pairs.reach[p] * pairs.reach[p]
