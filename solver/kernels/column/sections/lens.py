"""Two round faces, one slipped over the other: parts of their intersection, in closed form (theory.md section 10).

The face of the block above is a circle about 0, that of the block below a circle about -slip. At each abscissa along
the motion the shorter of their chords bears, so that the contact is a lens: a part of one circle up to the common
chord, and a part of the other beyond. With bores the longer chord is open. So the integrals of circle.py are
sufficient. Of one joint or of lanes.
"""

from ...engine.circle import circle_part
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.lanes import (
    any_of,
    greater,
    lesser,
    magnitude,
    square_root,
    where,
)


@leaf
def meeting(below, own, slip):
    """Return the abscissa (m) of the common chord of circles of radius `below` about -slip and `own` about 0."""
    return 0.5 * ((below - own) * (below + own) - slip * slip) / slip


@kernel
def _halves(below, own, slip, of_both, lo, hi):
    """Return the ends (m) of the parts from lo to hi that belong to the circle above and to that below.

    of_both: True for the intersection of both circles, False for their union.
    """
    # the common chord, clipped; which circle comes first from the left
    meet = greater(lesser(meeting(below, own, slip), hi), lo)
    own_first, own_alone = (slip > 0.0, own <= below) if of_both else (slip < 0.0, own >= below)
    # concentric circles: one of them alone
    still = slip == 0.0
    meet, own_first = where(still, hi, meet), (still & own_alone) | ((slip != 0.0) & own_first)
    return (
        where(own_first, lo, meet),
        where(own_first, meet, hi),
        where(own_first, meet, lo),
        where(own_first, hi, meet),
    )


@kernel
def lens_part(own, bore, below, bore_below, slip, lo, hi):
    """Return middle, area, first and second moment about it of the part between two abscissas; all four radii in m.

    A loop over the four circles, which is compiled once.
    """
    # moments about the middle of the interval
    about = 0.5 * (lo + hi)
    area = first = second = 0.0 * about
    hollow = greater(bore, bore_below) > 0.0
    for k in range(4):
        outer, is_below = k < 2, k % 2 == 1
        # faces without bores are done
        if k == 2 and not any_of(hollow):
            break
        # the circle below or above, of the outline or of the bores
        one, other = (below, own) if outer else (bore_below, bore)
        own_lo, own_hi, below_lo, below_hi = _halves(one, other, slip, outer, lo, hi)
        radius, centre = (one, -slip) if is_below else (other, 0.0 * slip)
        begin, end = (below_lo, below_hi) if is_below else (own_lo, own_hi)
        # moments about the common middle; those of bores are subtracted
        middle, a, b, c = circle_part(radius, begin - centre, end - centre)
        off, sign = (middle + centre) - about, 1.0 if outer else -1.0
        area += sign * a  # zero without a bore
        first += sign * (b + off * a)
        second += sign * (c + off * (2.0 * b + off * a))
    return about, area, first, second


@kernel
def ends_of_rings(own, bore, below, bore_below, slip, left, right):
    """Return the ends of the contact (m), cut where a bore reaches beyond the rim of the other face."""
    ahead, moved = slip > 0.0, magnitude(slip)
    # whether the bore above crosses the rim below, and the bore below the rim above
    cut = magnitude(below - moved) < bore
    cut_behind = magnitude(own - moved) < bore_below
    end, behind = meeting(below, bore, slip), meeting(bore_below, own, slip)
    # a slip towards +x: the bore above cuts on the right, the one below on the left
    left, right = (
        where(ahead, where(cut_behind, behind, left), where(cut, end, left)),
        where(ahead, where(cut, end, right), where(cut_behind, behind, right)),
    )
    return left, right


@kernel
def push_of(radius, slip, lo, hi, stiffness, opening, slope):
    """Return the decrease of elastic energy per metre of slip (J/m) over a part (lo, hi) of a circle about -slip."""
    # chords and penetrations at both ends
    one, other = lo + slip, hi + slip
    chord = 2.0 * square_root(greater((radius - one) * (radius + one), 0.0))
    other_chord = 2.0 * square_root(greater((radius - other) * (radius + other), 0.0))
    at_one, at_other = slope * lo - opening, slope * hi - opening
    # integral over the part between them
    middle, area, first, _ = circle_part(radius, one, other)
    force = (slope * (middle - slip) - opening) * area + slope * first
    return stiffness * (0.5 * (at_one * at_one * chord - at_other * at_other * other_chord) + slope * force)


@kernel
def lens_push(own, bore, below, bore_below, slip, lo, hi, stiffness, opening, slope):
    """Return the force (N, towards +x) of the rims on the block above; pressed from lo to hi (m)."""
    # the part that the circle below bounds
    _, _, first, last = _halves(below, own, slip, True, lo, hi)
    force = push_of(below, slip, first, last, stiffness, opening, slope)
    # less that of the bore below
    hollow = bore_below > 0.0
    if any_of(hollow):
        _, _, first, last = _halves(bore_below, bore, slip, False, lo, hi)
        force = where(hollow, force - push_of(bore_below, slip, first, last, stiffness, opening, slope), force)
    return force
