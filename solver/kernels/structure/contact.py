"""Contact of neighbouring blocks that no joint connects (theory.md section 17).

The normal forces are those of convex bodies (bodies.py), and for drums those of their sides (drum_contact.py), beside
which the body of a drum is a prism within it. They act on both blocks at one point, so that momentum is conserved.
Friction is a slider in series with a spring and a dashpot, perpendicular to the resultant of the contact. A pair
touches or not during a whole step: a step ends where a gap closes (meeting.py), so that the damping of an impact, which
starts abruptly, leaves steps smooth. Pairs that are apart are not evaluated.
"""

import math

from ..engine.control import worse
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import magnitude, zero_like
from .bodies import energy_of_bodies, gap_of_bodies, least_gap_of_bodies, load_bodies, may_press
from .drum_contact import gap_before_face, gap_of_drums, load_drum_before_face, load_drums
from .kinematics import dot, minus, plus, push
from .layout import APART, BY_BODIES, BY_SIDES, CONVEX, DRUMS, JOINED, JOINED_GAP, MEMORY, STRETCH
from .sides import NO_TOUCH, NOTHING, SLACK, Touch, place_of, scaled, sides_of, velocity_of

_stretch, _PER_JOINT = STRETCH.over, MEMORY.per_n
LEAST_COSINE, MOST_SINE = 0.6, 0.5  # of the axes of drums, and of an axis and the normal of a face, that are parallel
# of the radii: sides deeper within each other are none that face each other, or do not begin a contact
DEEP, SHALLOW = 0.1, 1e-6
LATER = 0.02  # of the radius: overlap of sides beyond which the bodies may press too


@leaf
def _add_friction(scene, phase, extras, p, touch):
    """Add the friction of pair p to the forces; store the rates of its stretch in the scene.

    Friction acts perpendicular to the resultant of the contact, the normal of the side on which the other one's edge
    slides. touch: the contact without friction (`Touch`).
    """
    pairs, stretch, giving = extras.pairs, extras.stretches, extras.giving_stretches
    a, b = int(pairs.one[p]), int(pairs.other[p])
    # direction of the resultant
    pressed = math.sqrt(dot(touch.resultant, touch.resultant))
    n = scaled(touch.resultant, 1.0 / pressed) if pressed > 0.0 else NOTHING
    # relative velocity and elastic stretch, tangential components
    v = minus(velocity_of(scene, phase, a, touch.on_a), velocity_of(scene, phase, b, touch.on_b))
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
    push(scene.poses, a, touch.on_a, force, NOTHING, 1.0)
    push(scene.poses, b, touch.on_b, force, NOTHING, -1.0)


@leaf
def _farther(pairs, p, touches):
    """Return what is added to the distance of the bodies of pair p, m: more while its sides press."""
    return pairs.farther[p] + (LATER * pairs.radius_a[p] if touches == BY_SIDES else 0.0)


@leaf
def _together(one, other):
    """Return the contact of a pair from those of its sides and of its bodies, centred by their forces."""
    total = one.force + other.force
    part = one.force / total if total > 0.0 else 1.0
    return Touch(
        total,
        one.energy + other.energy,
        plus(one.resultant, other.resultant, 1.0),
        plus(scaled(one.on_a, part), other.on_a, 1.0 - part),
        plus(scaled(one.on_b, part), other.on_b, 1.0 - part),
    )


@kernel
def _load_sides(scene, phase, pairs, p):
    """Add the normal forces of the side of a drum; return their contact."""
    sides = sides_of(scene, phase, pairs, p)
    if pairs.kind[p] == DRUMS:
        return load_drums(scene, phase, pairs, p, sides)
    return load_drum_before_face(scene, phase, pairs, p, sides)


@kernel
def load_pair(scene, phase, extras, p):
    """Add the forces of pair p to those on its two blocks if it touches.

    Fills the force (N), energy (J) and sliding flag of the pair, and the rates of its stretch (m/s); all are zero of a
    pair that is apart.
    """
    hits, giving, pairs = extras.hits, extras.giving_stretches, extras.pairs
    # pairs that are apart exert nothing
    hits.force[p], hits.energy[p], hits.slides[p], hits.highest[p] = 0.0, 0.0, 0.0, 0.0
    giving.z1[p], giving.z2[p], giving.z3[p] = 0.0, 0.0, 0.0
    hits.bears[p] = max(extras.stretches.touches[p], APART)
    if hits.bears[p] == APART:
        return
    # normal forces: of the sides of drums, then of both bodies
    touch = NO_TOUCH
    if hits.bears[p] == BY_SIDES:
        touch = _load_sides(scene, phase, pairs, p)
    farther = _farther(pairs, p, hits.bears[p])
    if pairs.body_stiffness[p] > 0.0 and (pairs.kind[p] == CONVEX or may_press(scene, phase, pairs, p, farther)):
        touch = _together(touch, load_bodies(scene, phase, pairs, p, farther))
    hits.force[p], hits.energy[p] = touch.force, touch.energy
    # friction
    if pairs.friction[p] > 0.0:
        _add_friction(scene, phase, extras, p, touch)


@kernel
def load_pairs(scene, phase):
    """Add the forces of all pairs that touch to those on their blocks."""
    touches, bears = scene.extras.stretches.touches, scene.extras.hits.bears
    for p in range(scene.extras.met):
        if touches[p] > APART or bears[p] != APART:
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
        largest = worse(largest, magnitude(z.z1[p]) + magnitude(z.z2[p]) + magnitude(z.z3[p]))
    return largest


@kernel
def pairs_energy(scene, phase):
    """Return the elastic energy of all pairs at the last evaluation, of this phase, J."""
    z, pairs, hits, total = scene.extras.stretches, scene.extras.pairs, scene.extras.hits, 0.0
    for p in range(scene.extras.met):
        # normal contact and elastic stretch
        square = z.z1[p] * z.z1[p] + z.z2[p] * z.z2[p] + z.z3[p] * z.z3[p]
        total += hits.energy[p] + 0.5 * pairs.shear[p] * square
        if hits.bears[p] != 0.0 and pairs.body_stiffness[p] > 0.0:
            total += energy_of_bodies(scene, phase, pairs, p, _farther(pairs, p, hits.bears[p]))
    return total


@kernel
def _gap_of_sides(scene, phase, pairs, p, touches):
    """Return the distance of the sides of pair p, m; NaN where no side is before the other.

    Unless they press already, sides face each other only where they are nearly parallel and not deep within each other.
    """
    sides = sides_of(scene, phase, pairs, p)
    along, radius = abs(dot(sides.u, sides.v)), pairs.radius_a[p]
    if pairs.kind[p] == DRUMS:
        gap, parallel, radius = gap_of_drums(pairs, p, sides), along >= LEAST_COSINE, radius + pairs.radius_b[p]
    else:
        gap, parallel = gap_before_face(scene, pairs, p, sides), along <= MOST_SINE
    if touches == BY_SIDES or (parallel and gap > -DEEP * radius):
        return gap
    return math.nan


@kernel
def gap_of(scene, phase, pairs, p, touches, highest):
    """Return the distance of pair p, m, negative where it overlaps: of sides that face each other, or of the bodies.

    touches: JOINED, for which it is JOINED_GAP, APART, BY_SIDES or BY_BODIES. highest: of the last evaluation if
    that was of this phase, else 0.
    """
    if touches == JOINED:
        return JOINED_GAP
    if pairs.kind[p] == CONVEX:
        return gap_of_bodies(scene, phase, pairs, p, pairs.farther[p], highest)
    gap, farther = _gap_of_sides(scene, phase, pairs, p, touches), _farther(pairs, p, touches)
    if gap != gap:
        return gap_of_bodies(scene, phase, pairs, p, farther, highest)
    # ends and edges may be nearer than sides
    if may_press(scene, phase, pairs, p, farther):
        gap = min(gap, gap_of_bodies(scene, phase, pairs, p, farther, highest))
    return gap


@kernel
def begins_by(scene, phase, pairs, p, deepest):
    """Return how the contact of pair p begins: by sides that are hardly within each other, else by the bodies.

    deepest: of the radius, the overlap of sides that may begin.
    """
    if pairs.kind[p] == CONVEX:
        return BY_BODIES
    gap = _gap_of_sides(scene, phase, pairs, p, APART)
    # NaN where no sides face each other
    return BY_SIDES if -deepest * pairs.radius_a[p] < gap <= gap_of(scene, phase, pairs, p, APART, 0.0) else BY_BODIES


@leaf
def _ways(scene, p):
    """Return the sum of the ways of the bodies of pair p since the start, m."""
    return scene.poses.way[int(scene.extras.pairs.one[p])] + scene.poses.way[int(scene.extras.pairs.other[p])]


@leaf
def _within(pairs, p):
    """Return more than the depth, m, at which the prisms of drums lie within their sides."""
    return 0.0 if pairs.kind[p] == CONVEX else LATER * (abs(pairs.radius_a[p]) + abs(pairs.radius_b[p]))


@kernel
def gap_or_bound(scene, phase, p, touches, least, highest):
    """Return the distance of pair p, m, or a lower bound of it if that is more than `least` and both are apart.

    highest: as of `gap_of`.
    """
    pairs = scene.extras.pairs
    # the bound costs a tenth
    if touches == APART:
        bound = least_gap_of_bodies(scene, phase, pairs, p, pairs.farther[p]) - _within(pairs, p)
        if bound > max(least, 0.0) + SLACK:
            return bound
    return gap_of(scene, phase, pairs, p, touches, highest)


@leaf
def keep_gap(scene, p, gap):
    """Store a gap of pair p, m, which is apart, and the ways of its bodies, by which the gap may become less."""
    scene.extras.hits.clear[p] = gap - _within(scene.extras.pairs, p) + _ways(scene, p)


@kernel
def keep_gaps(scene, gaps):
    """Store those of some gaps, m, that are known and of pairs that are apart."""
    for p in range(scene.extras.met):
        if gaps[p] < math.inf and scene.extras.stretches.touches[p] == APART:
            keep_gap(scene, p, gaps[p])


@kernel
def forget_known_gaps(scene):
    """Clear what is known of gaps, and the ways of the bodies, where the state has been set or a step is made again."""
    for p in range(scene.extras.met):
        scene.extras.hits.clear[p] = -math.inf
    for i in range(scene.n):
        scene.poses.way[i] = 0.0


@kernel
def forget_directions(scene):
    """Clear the directions of the last distances, at the start of a call: what follows depends on the state alone."""
    hits = scene.extras.hits
    for p in range(scene.extras.met):
        hits.nx[p], hits.ny[p], hits.nz[p] = 0.0, 0.0, 0.0


@leaf
def may_be_least(scene, p, least):
    """Return True if the gap of pair p may be less than `least`, m."""
    return not scene.extras.hits.clear[p] - _ways(scene, p) > least


@leaf
def _square_between(scene, phase, pairs, p):
    """Return the squared distance of the centroids of pair p, m2."""
    between = minus(place_of(scene, phase, int(pairs.one[p])), place_of(scene, phase, int(pairs.other[p])))
    return dot(between, between)


@leaf
def is_near(scene, phase, pairs, p):
    """Return True if the bounding spheres of both blocks of pair p overlap."""
    return _square_between(scene, phase, pairs, p) < pairs.reach[p] * pairs.reach[p]


@leaf
def gap_of_spheres(scene, phase, pairs, p):
    """Return the distance of the bounding spheres of both blocks of pair p, m."""
    return math.sqrt(_square_between(scene, phase, pairs, p)) - pairs.reach[p]
