"""Two round faces, one slipped over the other: parts of what they share, in closed form (theory.md section 10).

The face of the block above is a circle about 0, that of the block below a circle about -slip. At a place along the
motion the shorter of their chords bears, so that the contact is a lens: a part of the one circle, and from where both
chords are equally long a part of the other. Bores likewise: there the longer chord is open. So nothing new is to be
integrated. Of one joint or of lanes.
"""

from ..jit import kernel, leaf
from ..lanes import any_of, greater, lesser, magnitude, square_root, where
from .circle import circle_part


@leaf
def meeting(below, own, slip):
    """Where a circle of the radius `below` about -slip and one of the radius `own` about 0 have the same chord, m."""
    return 0.5 * ((below - own) * (below + own) - slip * slip) / slip


@leaf
def _halves(below, own, slip, of_both, lo, hi):
    """The parts from lo to hi that are those of the circle above and of that below: their ends, m.

    of_both: whether what lies in both circles is meant, or what lies in either of them.
    """
    meet = greater(lesser(meeting(below, own, slip), hi), lo)
    own_first = slip > 0.0 if of_both else slip < 0.0
    return (
        where(own_first, lo, meet),
        where(own_first, meet, hi),
        where(own_first, meet, lo),
        where(own_first, hi, meet),
    )


@leaf
def _moments(radius, centre, lo, hi, about):
    """Area, first and second moment about a place, of the part from lo to hi of a circle about a centre."""
    middle, area, first, second = circle_part(radius, lo - centre, hi - centre)
    off = (middle + centre) - about
    return area, first + off * area, second + off * (2.0 * first + off * area)


@kernel
def _shared(below, own, slip, of_both, lo, hi, about):
    """The same of what lies in both circles, or in either."""
    own_lo, own_hi, lo, hi = _halves(below, own, slip, of_both, lo, hi)
    area, first, second = _moments(own, 0.0, own_lo, own_hi, about)
    other, other_first, other_second = _moments(below, -slip, lo, hi, about)
    return area + other, first + other_first, second + other_second


@kernel
def lens_part(own, bore, below, bore_below, slip, lo, hi):
    """Middle, area, first and second moment about it, of the part between two abscissas; all four radii in m."""
    middle = 0.5 * (lo + hi)
    area, first, second = _shared(below, own, slip, True, lo, hi, middle)
    hollow = greater(bore, bore_below) > 0.0
    if any_of(hollow):
        less, less_first, less_second = _shared(bore_below, bore, slip, False, lo, hi, middle)
        area = where(hollow, area - less, area)
        first = where(hollow, first - less_first, first)
        second = where(hollow, second - less_second, second)
    return middle, area, first, second


@leaf
def ends_of_rings(own, bore, below, bore_below, slip, left, right):
    """Ends of the contact, m: where a bore reaches beyond the rim of the other face, the faces do not touch."""
    ahead, moved = slip > 0.0, magnitude(slip)
    cut = magnitude(below - moved) < bore
    cut_behind = magnitude(own - moved) < bore_below
    end, behind = meeting(below, bore, slip), meeting(bore_below, own, slip)
    left, right = (
        where(ahead, where(cut_behind, behind, left), where(cut, end, left)),
        where(ahead, where(cut, end, right), where(cut_behind, behind, right)),
    )
    return left, right


@leaf
def _push_of(radius, slip, lo, hi, stiffness, opening, slope):
    """What the elastic energy over the part from lo to hi of a circle about -slip falls by for a slip of 1 m, J/m."""
    one, other = lo + slip, hi + slip
    chord = 2.0 * square_root(greater((radius - one) * (radius + one), 0.0))
    other_chord = 2.0 * square_root(greater((radius - other) * (radius + other), 0.0))
    at_one, at_other = slope * lo - opening, slope * hi - opening
    middle, area, first, _ = circle_part(radius, one, other)
    force = (slope * (middle - slip) - opening) * area + slope * first
    return stiffness * (0.5 * (at_one * at_one * chord - at_other * at_other * other_chord) + slope * force)


@kernel
def lens_push(own, bore, below, bore_below, slip, lo, hi, stiffness, opening, slope):
    """The same of the contact where it is pressed, from lo to hi: the force on the block above, N, towards +x."""
    _, _, first, last = _halves(below, own, slip, True, lo, hi)
    force = _push_of(below, slip, first, last, stiffness, opening, slope)
    hollow = bore_below > 0.0
    if any_of(hollow):
        _, _, first, last = _halves(bore_below, bore, slip, False, lo, hi)
        force = where(hollow, force - _push_of(bore_below, slip, first, last, stiffness, opening, slope), force)
    return force
