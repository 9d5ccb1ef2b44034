"""A joint that slides, or is built off its axis (theory.md section 9): its contact and the forces along it.

The contact belongs to the block above: its middle has moved by half of the slip from the middle of the joint. Pressure
acts along the normal of the lower face, which is turned by half of the joint's rotation against that of the joint. Its
component along the joint, plus the force of a rim that cuts the contact off, is the shear of the pressure. Friction and
dowel bear the rest.
"""

from ...layout.spaces import STRIP_NUMBERS
from ...numba_ext.jit import by_width, leaf
from ...numba_ext.lanes import LANES, LanesType, any_of, greater, lesser, magnitude, where
from ..sections.band import band_push
from ..sections.faces import LENS, ON_RING
from ..sections.lens import lens_push
from ..sections.section import (
    INSIDE,
    RIMMED,
    contact_of,
    depth_at,
    depth_in_lanes,
    ends_of,
    inset,
    inset_bore,
    inside_depth_in_lanes,
    inside_in_lanes,
    knows_round,
)
from .law import pressed_part

RIGID = 1e300  # N, dowel of a joint that never slides
BARELY = 1e-12  # m, slip by which edges that coincide come apart
MARK = "slips_in_lanes"  # name of an empty part of the spaces of lanes whose columns have slips (batch/runs.py)


def has_no_slips(space):
    """Return True if a space is that of lanes whose columns have no slips.

    It is known at compile time, so that slips cost nothing there. space: numba's type of it.
    """
    return space.kind is LANES and MARK not in space.names


@by_width
def can_slide(model):
    """Return True if slips are coordinates of the column: some joint may slide, or the column is off its axis."""
    # decided at compile time for lanes, at run time for one column
    if has_no_slips(model):
        return lambda model: False
    if model.kind is LANES:
        return lambda model: True
    return lambda model: model.settings.slides != 0.0


@by_width
def slip_if(slides, model, phase, i):
    """Return the slip of joint i (m) and its rate (m/s), or zeros where slips are not coordinates."""
    # columns without slips, lanes with slips, one column by its settings
    if has_no_slips(model):
        return lambda slides, model, phase, i: (0.0, 0.0)
    if model.kind is LANES:
        return lambda slides, model, phase, i: (phase.slip[i], phase.slip_rate[i])
    return lambda slides, model, phase, i: (phase.slip[i], phase.slip_rate[i]) if slides else (0.0, 0.0)


@leaf
def slip_of(model, phase, i):
    """Return the slip of joint i (m) and its rate (m/s)."""
    return slip_if(can_slide(model), model, phase, i)


@leaf
def edges_coincide(blocks, i, slip):
    """Return True if edges of both faces of joint i coincide at a slip (m): any further slip parts them."""
    # bores of the same width coincide at no slip, whatever the outlines
    right, left = blocks.own_right[i] - blocks.rim_right[i] + slip, blocks.own_left[i] - blocks.rim_left[i] + slip
    return lesser(magnitude(slip), lesser(magnitude(right), magnitude(left))) < BARELY


@by_width
def slip_towards(slip, way, coincide):
    """Return the slip (m) by which edges cut the contact: where they coincide, a little further in the direction `way`.

    So the edge of the lower face counts towards which the joint slides, whatever the rounding of widths and slips.
    """
    # lanes without slips, others
    if isinstance(way, LanesType) and not isinstance(slip, LanesType):
        return lambda slip, way, coincide: slip
    return lambda slip, way, coincide: where(coincide, slip + BARELY * way, slip)


@leaf
def less_below(row, i, n):
    """Return row[i] - row[i + 1]: of joint i, between the blocks on both sides; the base below the last counts as 0."""
    return row[i] - row[i + 1] if i + 1 < n else row[i]


@leaf
def opening_felt(opening, slip, slope):
    """Return the opening of a joint in the middle of its contact (m)."""
    return opening - 0.5 * slip * slope


@leaf
def opening_rate_felt(opening_rate, slip, slip_rate, slope, slope_rate):
    """Return the rate of `opening_felt` (m/s)."""
    return opening_rate - 0.5 * (slip_rate * slope + slip * slope_rate)


@leaf
def pressure_shear(normal, sine, at_rim):
    """Return the shear of the pressure (N) on the block above; sine of half the joint's rotation, at_rim in N."""
    return at_rim - normal * sine


@by_width
def rim_force(blocks, i, opening, slope, slip):
    """Return the force (N, towards +x) on the block above of the rims that cut off the contact of joint i.

    It is the decrease of the elastic energy per metre of slip: without it a slip would gain or lose energy.
    """
    # lanes with slips, lanes without, one column
    if isinstance(slip, LanesType):
        return _rim_force_of_lanes
    if isinstance(slope, LanesType):
        return lambda blocks, i, opening, slope, slip: 0.0 * slope
    return _rim_force_of_one


@leaf
def _lens_force(blocks, i, left, right, opening, slope, slip, rim):
    """Return the force (N) of the edges on a round joint above a round face, both inset by a rim (m)."""
    # radii (m) of both faces, and their pressed part
    own, bore = 0.5 * blocks.own_depth[i] - rim, 0.5 * inset_bore(blocks.own_bore[i], rim)
    below, bore_below = blocks.rim_right[i] - rim, 0.5 * inset_bore(blocks.bore_below[i], rim)
    lo, hi = pressed_part(left, right, opening, slope)
    force = lens_push(own, bore, below, bore_below, slip, lo, hi, blocks.stiffness[i], opening, slope)
    return where(lo < hi, force, 0.0)


def _rim_force_of_lanes(blocks, i, opening, slope, slip):
    left, right = ends_of(blocks, i, slip)
    # only a slipped or overhanging contact is cut
    force, met = 0.0 * slope, left < right
    cut = ((slip != 0.0) | (blocks.overhangs[i] != 0.0)) & met
    # straight edges: energy per metre of the strip at the right edge, then at the left one
    for ahead in (True, False):
        edge, own, rim = left, blocks.own_left[i], blocks.rim_left[i]
        if ahead:
            edge, own, rim = right, blocks.own_right[i], blocks.rim_right[i]
        here = cut & (edge != own) & (edge == rim - slip)
        if any_of(here):
            # half of stiffness times penetration squared times depth
            pressed = greater(slope * edge - opening, 0.0)
            push = 0.5 * blocks.stiffness[i] * pressed * pressed * depth_in_lanes(blocks, i, left, right, edge)
            force += where(here, push if ahead else -push, 0.0)
    # round faces instead
    if knows_round(blocks):
        lens = blocks.slipped[i] == LENS
        if any_of(lens & cut):
            force = where(lens, where(cut, _lens_force(blocks, i, left, right, opening, slope, slip, 0.0), 0.0), force)
    # less the edges of the inside
    return less_insides(blocks, i, left, right, opening, slope, slip, cut, force)


@by_width
def less_insides(blocks, i, left, right, opening, slope, slip, cut, force):
    """Return the force of edges in lanes (N) less that of the edges of the open insides, where the contact is cut."""
    if RIMMED in blocks.names:
        return _less_insides
    return lambda blocks, i, left, right, opening, slope, slip, cut, force: force


def _less_insides(blocks, i, left, right, opening, slope, slip, cut, force):
    inside = inside_in_lanes(blocks, i, slip, left, right)
    # where the rims leave an inside open
    open_ = cut & (blocks.rim[i] > 0.0) & (inside[0] < inside[1])
    if any_of(open_):
        less = _inside_force_of_lanes(blocks, i, left, right, inside, opening, slope, slip)
        force = where(open_, force - less, force)
    return force


@leaf
def _inside_force_of_lanes(blocks, i, left, right, inside, opening, slope, slip):
    """Return the force (N) of the edges of the inside of the lower face, in lanes in which it cuts the contact."""
    force, rim, (begin, end) = 0.0 * slope, blocks.rim[i], inside
    # straight edges, inset by the rim: the right one, then the left one
    for ahead in (True, False):
        edge, own, below, place = left, blocks.own_left[i], blocks.rim_left[i], left + rim
        if ahead:
            edge, own, below, place = right, blocks.own_right[i], blocks.rim_right[i], right - rim
        here = (edge != own) & (edge == below - slip)
        if any_of(here):
            # half of stiffness times penetration squared times depth
            pressed = greater(slope * place - opening, 0.0)
            depth = inside_depth_in_lanes(blocks, i, begin, end, place)
            push = 0.5 * blocks.stiffness[i] * pressed * pressed * depth
            force += where(here, push if ahead else -push, 0.0)
    # round faces instead
    lens = blocks.slipped[i] == LENS
    if any_of(lens):
        force = where(lens, _lens_force(blocks, i, begin, end, opening, slope, slip, rim), force)
    return force


def _rim_force_of_one(blocks, i, opening, slope, slip):
    # a contact whose edges are those of its own face
    if slip == 0.0 and blocks.overhangs[i] == 0.0:
        return 0.0
    # edges of the outline
    contact = contact_of(blocks, i, slip)
    force = _force_of_edges(blocks, i, contact, 0.0, opening, slope, slip)
    if contact.rim > 0.0:  # the inside is open
        force -= _force_of_edges(blocks, i, contact, contact.rim, opening, slope, slip)
    return force


@leaf
def _force_of_edges(blocks, i, contact, rim, opening, slope, slip):
    """Return the force (N) of the edges of the lower face of joint i where both faces are inset by a rim (m)."""
    # both faces, inset by the rim
    part, section, stiffness, force = inset(contact, rim), blocks.slipped[i], blocks.stiffness[i], 0.0
    if not part.left < part.right:
        return 0.0
    # round face over a round one
    if section == LENS:
        return _lens_force(blocks, i, part.left, part.right, opening, slope, slip, rim)
    # straight face over a round one
    if section == ON_RING:
        outer, inner = blocks.rim_right[i] - rim, 0.5 * inset_bore(blocks.bore_below[i], rim)
        lo, hi = pressed_part(part.left, part.right, opening, slope)
        strips = blocks.strips[STRIP_NUMBERS * i + (INSIDE if rim > 0.0 else 0) :]
        return band_push(strips, outer, inner, slip, lo, hi, stiffness, opening, slope) if lo < hi else 0.0
    # straight edges that cut the contact: on the right, on the left
    if blocks.rim_right[i] - slip == contact.right != blocks.own_right[i]:
        force += _push_at(part, stiffness, contact.right - rim, opening, slope)
    if blocks.rim_left[i] - slip == contact.left != blocks.own_left[i]:
        force -= _push_at(part, stiffness, contact.left + rim, opening, slope)
    return force


@leaf
def _push_at(contact, stiffness, edge, opening, slope):
    """Return the outward force (N) of a straight rim at this edge of the contact."""
    pressed = max(0.0, slope * edge - opening)
    return 0.5 * stiffness * pressed * pressed * depth_at(contact, edge)
