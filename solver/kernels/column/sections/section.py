"""The shape of a contact, and the resultants of a linear pressure over a part of it (theory.md sections 2 and 10).

A section is a code and a few numbers, kept in `blocks`. Other modules only know its ends, between which the faces of
a joint can touch. Of a part of it, from lo to hi along the motion, three numbers are needed: area m2 and first and
second moment m3, m4 about the middle of the part. Mirror images have mirrored moments, to the last bit.

The rectangle comes first and is written out: it is the most frequent section. Lanes whose columns have rectangles alone
are compiled without the other sections, lanes whose columns have no strips without strips (batch/runs.py).

Faces A and B may touch in a rim along their edges. With A_i and B_i, the points of each that are farther than the rim
from all of its edges, they touch in (A n B) - (A_i n B_i): in their outline without the inside that the rim leaves
open. The inside is the outline inset by the rim, and a section like it. The rim changes neither the ends of a contact
nor, therefore, its regimes.
"""

import math
from typing import Any, NamedTuple

from ...engine.circle import circle_part, ring_part
from ...layout.spaces import MOST_STRIPS, STRIP_NUMBERS
from ...numba_ext.jit import by_width, in_both, kernel, leaf
from ...numba_ext.lanes import (
    LANES,
    LanesType,
    any_of,
    greater,
    lesser,
    magnitude,
    mirrored,
    where,
)
from .band import band_part, ends_of_band
from .faces import (
    ALIKE,
    ANNULUS,
    CIRCLE,
    FRAME,
    LENS,
    ON_BAND,
    ON_RING,
    RECTANGLE,
    STRIPS,
    UNKNOWN,
    after_a_slip,
    common,
    has_inside,
    is_known,
    is_round,
)
from .lens import ends_of_rings, lens_part
from .strips import (
    COUNT,
    DEPTHS,
    PITCH,
    edge_of,
    strips_part,
    strips_part_in_lanes,
)

ROUND = "round_in_lanes"  # name of an empty field of the blocks of lanes whose joints may be round (batch/runs.py)
STRIPPED = "strips_in_lanes"  # the same for joints made of strips
RIMMED = "rims_in_lanes"  # the same for faces that touch in a rim
INSIDE = DEPTHS + 1  # offset in the row of strips: the inside of a straight face, as a row of one strip
NEAR = 1e-4  # relative to the width of a contact: half the interval over which its depth is averaged


class ContactSection(NamedTuple):
    """The part in which the faces of a joint can touch; abscissas in m from the middle of the block."""

    section: float  # code, also FRAME, LENS, ON_RING or ON_BAND (faces.py)
    left: float  # ends of the contact
    right: float
    depth: float  # m, across the motion; the diameter of a circle or an annulus
    bore: float  # m, inner diameter of an annulus
    strips: Any  # row: number and width of the strips, then their depths
    slip: float  # m, of a round face below: its centre is at -slip
    round: float  # m, diameter of that face
    round_bore: float  # m
    rim: float  # m, width of the rim along the edges in which the faces touch; 0: all over


@by_width
def knows_round(blocks):
    """Return True if joints may be round: not in lanes of rectangles, which are compiled without round sections."""
    if blocks.kind is LANES and ROUND not in blocks.names:
        return lambda blocks: False
    return lambda blocks: True


@by_width
def knows_strips(blocks):
    """Return True if the joints of lanes may be made of strips."""
    known = STRIPPED in blocks.names
    return lambda blocks: known


@by_width
def knows_rims(blocks):
    """Return True if the faces of lanes may touch in a rim."""
    known = RIMMED in blocks.names
    return lambda blocks: known


@leaf
def ends_of(blocks, i, slip):
    """Return the ends of the contact of joint i after a slip (m): the rims below cut it off.

    In m from the middle of the block; of one joint or of lanes.
    """
    # as built
    left, right = blocks.left[i], blocks.right[i]
    moved = slip != 0.0
    if any_of(moved):
        # straight rims, then bores
        left = where(moved, greater(blocks.own_left[i], blocks.rim_left[i] - slip), left)
        right = where(moved, lesser(blocks.own_right[i], blocks.rim_right[i] - slip), right)
        if knows_round(blocks):
            left, right = _ends_of_rings(blocks, i, slip, left, right)
        left, right = ends_if_band(blocks, i, blocks.slipped[i], slip, left, right)
    return left, right


@by_width
def ends_if_band(blocks, i, section, slip, left, right):
    """Return the ends of the contact (m), cut off by a bore where one face is round and one straight; not in lanes."""
    if blocks.kind is LANES:
        return lambda blocks, i, section, slip, left, right: (left, right)
    return _ends_of_band


def _ends_of_band(blocks, i, section, slip, left, right):
    strips = blocks.strips[STRIP_NUMBERS * i :]
    # strips over the bore below, or a bore over the strip below
    if section == ON_RING and blocks.bore_below[i] > 0.0:
        left, right = ends_of_band(strips, 0.5 * blocks.bore_below[i], -slip, left, right)
    elif section == ON_BAND and blocks.own_bore[i] > 0.0:
        left, right = ends_of_band(strips, 0.5 * blocks.own_bore[i], 0.0, left, right)
    return left, right


@kernel
def _ends_of_rings(blocks, i, slip, left, right):
    """Return the ends of the contact of joint i (m), cut off by bores where a round face has slipped over another."""
    # lanes in which a round face with a bore has slipped
    hollow = (blocks.own_bore[i] > 0.0) | (blocks.bore_below[i] > 0.0)
    rings = (slip != 0.0) & (blocks.slipped[i] == LENS) & hollow
    if any_of(rings):
        own, bore, bore_below = 0.5 * blocks.own_depth[i], 0.5 * blocks.own_bore[i], 0.5 * blocks.bore_below[i]
        first, last = ends_of_rings(own, bore, blocks.rim_right[i], bore_below, slip, left, right)
        left, right = where(rings, first, left), where(rings, last, right)
    return left, right


@leaf
def contact_of(blocks, i, slip=0.0):
    """Return the contact of joint i after a slip (m)."""
    strips = blocks.strips[STRIP_NUMBERS * i :]
    left, right = ends_of(blocks, i, slip)
    section, depth, bore = blocks.section[i], blocks.depth[i], blocks.bore[i]
    below, bore_below = 0.0, 0.0
    # the shape may differ after a slip
    if slip != 0.0:
        section = blocks.slipped[i]
    # the other, round face
    if section >= LENS:
        depth, bore = blocks.own_depth[i], blocks.own_bore[i]
        below, bore_below = 2.0 * blocks.rim_right[i], blocks.bore_below[i]
        if section == ON_BAND:  # the round face is the upper one
            slip, below, bore_below = 0.0, depth, bore
    return ContactSection(section, left, right, depth, bore, strips, slip, below, bore_below, blocks.rim[i])


@leaf
def inset_bore(bore, rim):
    """Return the bore (m) of a face inset by a rim; 0 where it has none."""
    return where(bore > 0.0, bore + 2.0 * rim, 0.0)


@leaf
def inset(contact, rim):
    """Return a contact that touches all over, inset by a rim (m): the part left open; nothing if left >= right."""
    section, left, right = contact.section, contact.left + rim, contact.right - rim
    depth, below = contact.depth - 2.0 * rim, contact.round - 2.0 * rim
    bore, bore_below = inset_bore(contact.bore, rim), inset_bore(contact.round_bore, rim)
    strips, slip = contact.strips, contact.slip
    # the wider bores may cut off the inside where they do not cut the outline, or contain the other face
    if rim > 0.0 and section >= ON_RING:
        strips = strips[INSIDE:]
        if bore_below > 0.0:
            left, right = ends_of_band(strips, 0.5 * bore_below, -slip, left, right)
    elif rim > 0.0 and section == LENS and max(bore, bore_below) > 0.0:
        left, right = ends_of_rings(0.5 * depth, 0.5 * bore, 0.5 * below, 0.5 * bore_below, slip, left, right)
        if max(bore_below - depth, bore - below) >= 2.0 * abs(slip):
            right = left
    elif section == ANNULUS and bore >= depth:
        right = left
    return ContactSection(section, left, right, depth, bore, strips, slip, below, bore_below, 0.0)


# --- parts of any section but the rectangle


@leaf
def _part(contact, lo, hi):
    """Return the middle of lo and hi, and area and moments about it of the part between them."""
    return _part_of_rim(contact, lo, hi) if contact.rim > 0.0 else _part_of_outline(contact, lo, hi)


@kernel
def _part_of_rim(contact, lo, hi):
    """Return `_part` of a contact that touches in a rim: of its outline less that of its inside."""
    # the outline
    about, area, first, second = _part_of_outline(contact, lo, hi)
    # subtract the inside, about the same middle
    inside = inset(contact, contact.rim)
    left, right = inside.left, inside.right
    if left < right:
        lo, hi = min(max(lo, left), right), min(max(hi, left), right)
        middle, a, b, c = _part_of_outline(inside, lo, hi)
        off = middle - about
        area -= a
        first -= b + off * a
        second -= c + off * (2.0 * b + off * a)
    return about, area, first, second


@kernel
def _part_of_outline(contact, lo, hi):
    """Return `_part` of a contact that touches all over; an area that is no number if its section is unknown."""
    # two faces of which one at least is round
    if contact.section >= LENS:
        outer, inner = 0.5 * contact.round, 0.5 * contact.round_bore
        if contact.section == LENS:
            return lens_part(0.5 * contact.depth, 0.5 * contact.bore, outer, inner, contact.slip, lo, hi)
        return band_part(contact.strips, outer, inner, -contact.slip, lo, hi)
    # one face, as it is
    if contact.section == CIRCLE:
        return circle_part(0.5 * contact.depth, lo, hi)
    if contact.section == STRIPS:
        return strips_part(contact.strips, lo, hi)
    if contact.section == FRAME:
        return _frame_part(contact.depth, lo, hi)
    # a circle less its bore
    about, area, first, second = ring_part(0.5 * contact.depth, 0.5 * contact.bore, lo, hi)
    return about, area if contact.section == ANNULUS else math.nan, first, second


# --- resultants, energy and stiffness for the law


@leaf
def rectangle_forces(lo, hi, length, rigidity, mean, gradient):
    """Return N and M of the pressure gradient * s - mean over a part of a rectangle; rigidity in N/m2, lengths in m."""
    middle = 0.5 * (lo + hi)  # its mirror image is minus it, to the last bit
    area = rigidity * length
    force = area * (gradient * middle - mean)
    return force, middle * force + area * gradient * (length * length) * (1.0 / 12.0)


@leaf
def forces_over(contact, stiffness, lo, hi, length, mean, gradient):
    """Return N (N) and M (N m) of the pressure stiffness * (gradient * s - mean) over a part of the contact.

    Parameters
    ----------
    contact : ContactSection
        The contact of the joint.
    stiffness : float
        Stiffness, N/m3.
    lo, hi, length : float
        Ends of the part and its length, m.
    mean, gradient : float
        Opening, m, and slope, rad, with the damper's part.
    """
    # in closed form for a rectangle
    if contact.section == RECTANGLE:
        return rectangle_forces(lo, hi, length, stiffness * contact.depth, mean, gradient)
    return _part_forces(_part(contact, lo, hi), stiffness, mean, gradient)


@leaf
def _part_forces(part, stiffness, mean, gradient):
    """Return N and M of the pressure of `forces_over` over a part whose middle, area and moments are known."""
    middle, area, first, second = part
    pressure, steep = stiffness * (gradient * middle - mean), stiffness * gradient
    force = pressure * area + steep * first
    return force, middle * force + (pressure * first + steep * second)


@by_width
def part_in_lanes(blocks, i, slip, lo, hi):
    """Return `_part` of joint i in lanes in which each contact is a circle or an annulus."""
    return _part_in_lanes_that_slip if isinstance(slip, LanesType) else _part_in_lanes


def _part_in_lanes(blocks, i, slip, lo, hi):
    return ring_part(0.5 * blocks.depth[i], 0.5 * blocks.bore[i], lo, hi)


def _part_in_lanes_that_slip(blocks, i, slip, lo, hi):
    # lanes as built: circles less their bores
    outer, inner = 0.5 * blocks.depth[i], 0.5 * blocks.bore[i]
    middle, area, first, second = ring_part(outer, inner, lo, hi)
    # lanes that have slipped: lenses
    slipped = (slip != 0.0) & (blocks.slipped[i] == LENS)
    if any_of(slipped):
        outer, inner = 0.5 * blocks.own_depth[i], 0.5 * blocks.own_bore[i]
        found = lens_part(outer, inner, blocks.rim_right[i], 0.5 * blocks.bore_below[i], slip, lo, hi)
        middle, area = where(slipped, found[0], middle), where(slipped, found[1], area)
        first, second = where(slipped, found[2], first), where(slipped, found[3], second)
    return middle, area, first, second


@leaf
def _strips_in_image(blocks, i, slope, lo, hi):
    """Return `_part` of joint i in lanes, each made of strips, in the mirror image of `forces_over_in_lanes`."""
    falls = slope < 0.0
    strips = blocks.strips[STRIP_NUMBERS * i :]
    middle, area, first, second = strips_part_in_lanes(strips, where(falls, -hi, lo), where(falls, -lo, hi))
    return mirrored(middle, slope), area, mirrored(first, slope), second


@leaf
def forces_over_in_lanes(blocks, i, slip, slope, ends, lo, hi, length, mean, gradient):
    """Return `forces_over` of joint i in lanes, whichever of the sections known to these lanes each has.

    Parameters
    ----------
    slip, ends, lo, hi, length : lanes
        Slip, ends of the contact, ends of the part and its length, m, in the mirror image where the slope is negative.
    slope : lanes
        Slope of the joint, rad, not mirrored.
    mean, gradient : lanes
        Opening, m, and slope, rad, with the damper's part, in that image.

    Returns
    -------
    force, moment : lanes
        N, N, and M, N m, in that image.
    """
    stiffness, section = blocks.stiffness[i], blocks.section[i]
    flat, force, moment = section == RECTANGLE, 0.0 * mean, 0.0 * mean
    # strips, then circles and annuli
    if knows_strips(blocks):
        cut = section == STRIPS
        if any_of(cut):
            force, moment = _part_forces(_strips_in_image(blocks, i, slope, lo, hi), stiffness, mean, gradient)
        arched = (section == CIRCLE) | (section == ANNULUS)
        if any_of(arched):
            arch = _part_forces(part_in_lanes(blocks, i, slip, lo, hi), stiffness, mean, gradient)
            force, moment = where(arched, arch[0], force), where(arched, arch[1], moment)
    elif any_of(section != RECTANGLE):
        force, moment = _part_forces(part_in_lanes(blocks, i, slip, lo, hi), stiffness, mean, gradient)
    # rectangles
    if any_of(flat):
        flat_force, flat_moment = rectangle_forces(lo, hi, length, blocks.rigidity[i], mean, gradient)
        force, moment = where(flat, flat_force, force), where(flat, flat_moment, moment)
    # contacts that touch in a rim
    return forces_of_rims(blocks, i, slip, ends, lo, hi, mean, gradient, force, moment)


@by_width
def forces_of_rims(blocks, i, slip, ends, lo, hi, mean, gradient, force, moment):
    """Return N and M of joint i in lanes: those of rims, and the given forces in the other lanes."""
    if RIMMED in blocks.names:
        return _forces_of_rims
    return lambda blocks, i, slip, ends, lo, hi, mean, gradient, force, moment: (force, moment)


def _forces_of_rims(blocks, i, slip, ends, lo, hi, mean, gradient, force, moment):
    # lanes whose contact touches in a rim
    narrow = blocks.rim[i] > 0.0
    if any_of(narrow):
        part = _part_of_rim_in_lanes(blocks, i, slip, ends, lo, hi)
        rim = _part_forces(part, blocks.stiffness[i], mean, gradient)
        force, moment = where(narrow, rim[0], force), where(narrow, rim[1], moment)
    return force, moment


@leaf
def _frame_part(depth, lo, hi):
    """Return middle, area, first and second moment about it of a part of a rectangle."""
    length = hi - lo
    area = depth * length
    return 0.5 * (lo + hi), area, 0.0 * area, area * (length * length) * (1.0 / 12.0)


@leaf
def inside_in_lanes(blocks, i, slip, left, right):
    """Return the ends (m) of the inside that rims leave open of joint i in lanes, as `inset`, from the contact's."""
    rim = blocks.rim[i]
    # straight edges
    left, right = left + rim, right - rim
    # bores of round faces that have slipped over each other
    lens = (slip != 0.0) & (blocks.slipped[i] == LENS)
    bore, bore_below = inset_bore(blocks.own_bore[i], rim), inset_bore(blocks.bore_below[i], rim)
    hollow = lens & ((bore > 0.0) | (bore_below > 0.0))
    if any_of(hollow):
        own, below = blocks.own_depth[i] - 2.0 * rim, 2.0 * (blocks.rim_right[i] - rim)
        first, last = ends_of_rings(0.5 * own, 0.5 * bore, 0.5 * below, 0.5 * bore_below, slip, left, right)
        left, right = where(hollow, first, left), where(hollow, last, right)
        # one face lies within the bore of the other: no inside
        held = hollow & (greater(bore_below - own, bore - below) >= 2.0 * magnitude(slip))
        right = where(held, left, right)
    # a rim wider than half of the ring's thickness: no inside
    solid = ~lens & (inset_bore(blocks.bore[i], rim) >= blocks.depth[i] - 2.0 * rim)
    return left, where(solid, left, right)


@leaf
def _part_of_rim_in_lanes(blocks, i, slip, ends, lo, hi):
    """Return `_part_of_rim` of joint i in lanes, of any section but strips."""
    rim, frame = blocks.rim[i], blocks.section[i] == FRAME
    # the outline
    about, area, first, second = part_in_lanes(blocks, i, slip, lo, hi)
    flat = _frame_part(blocks.depth[i], lo, hi)
    about, area = where(frame, flat[0], about), where(frame, flat[1], area)
    first, second = where(frame, flat[2], first), where(frame, flat[3], second)
    # the inside: an annulus, a lens or a rectangle
    left, right = inside_in_lanes(blocks, i, slip, ends[0], ends[1])
    some = left < right
    if any_of(some):
        lo, hi = lesser(greater(lo, left), right), lesser(greater(hi, left), right)
        depth, bore = blocks.depth[i] - 2.0 * rim, inset_bore(blocks.bore[i], rim)
        middle, a, b, c = ring_part(0.5 * depth, 0.5 * bore, lo, hi)
        lens = (slip != 0.0) & (blocks.slipped[i] == LENS)
        if any_of(lens):
            outer, inner = 0.5 * (blocks.own_depth[i] - 2.0 * rim), 0.5 * inset_bore(blocks.own_bore[i], rim)
            below, bore_below = blocks.rim_right[i] - rim, 0.5 * inset_bore(blocks.bore_below[i], rim)
            found = lens_part(outer, inner, below, bore_below, slip, lo, hi)
            middle, a = where(lens, found[0], middle), where(lens, found[1], a)
            b, c = where(lens, found[2], b), where(lens, found[3], c)
        flat = _frame_part(depth, lo, hi)
        middle, a = where(frame, flat[0], middle), where(frame, flat[1], a)
        b, c = where(frame, flat[2], b), where(frame, flat[3], c)
        # subtract it, about the same middle
        off = middle - about
        area = where(some, area - a, area)
        first = where(some, first - (b + off * a), first)
        second = where(some, second - (c + off * (2.0 * b + off * a)), second)
    return about, area, first, second


@leaf
def energy_over(contact, stiffness, lo, hi, opening, slope):
    """Return the elastic energy (J) of the penetration slope * s - opening over the part from lo to hi."""
    # in closed form for a rectangle
    length = hi - lo
    if contact.section == RECTANGLE:
        middle = slope * 0.5 * (lo + hi) - opening
        return 0.5 * stiffness * contact.depth * length * (middle * middle + slope * slope * (length * length) / 12.0)
    # any other section, from the moments of the part
    about, area, first, second = _part(contact, lo, hi)
    middle = slope * about - opening
    return 0.5 * stiffness * (middle * middle * area + slope * (2.0 * middle * first + slope * second))


@leaf
def part_stiffness(contact, stiffness, lo, hi):
    """Return the stiffness of the part from lo to hi by opening and by slope: (N/m, N, N m).

    The derivatives of N by the opening, of N (or M) by the slope (or opening) and of M by the slope, signs aside.
    """
    # any section, from the moments of the part
    if contact.section != RECTANGLE:
        about, area, first, second = _part(contact, lo, hi)
        mixed = about * area + first
        return stiffness * area, stiffness * mixed, stiffness * (about * mixed + about * first + second)
    # a rectangle in closed form
    length = hi - lo
    middle = 0.5 * (lo + hi)
    along = stiffness * contact.depth * length
    return along, along * middle, along * (middle * middle + length * length / 12.0)


@leaf
def depth_at(contact, place):
    """Return the depth (m) of a contact at a place, m from the middle of the block."""
    if contact.section == RECTANGLE or (contact.section == FRAME and contact.rim == 0.0):
        return contact.depth
    # mean over a short interval about the place
    near = NEAR * (contact.right - contact.left)
    return _part(contact, place - near, place + near)[1] / (2.0 * near)


@leaf
def depth_in_lanes(blocks, i, left, right, place):
    """Return the depth (m) at a place of joint i in lanes, between these ends; cut along a straight line, if at all."""
    depth, flat = blocks.depth[i], blocks.section[i] == RECTANGLE
    # the depth of a frame is that of its outline
    if knows_rims(blocks):
        flat = flat | (blocks.section[i] == FRAME)
    if knows_round(blocks) and any_of(blocks.section[i] != RECTANGLE):
        # mean over a short interval about the place
        near = NEAR * (right - left)
        found = ring_part(0.5 * depth, 0.5 * blocks.bore[i], place - near, place + near)
        depth = where(flat, depth, found[1] / (2.0 * near))
        # strips
        if knows_strips(blocks):
            cut = blocks.section[i] == STRIPS
            if any_of(cut):
                found = strips_part_in_lanes(blocks.strips[STRIP_NUMBERS * i :], place - near, place + near)
                depth = where(cut, found[1] / (2.0 * near), depth)
    return depth


@leaf
def inside_depth_in_lanes(blocks, i, left, right, place):
    """Return the depth (m) at a place of the inside that rims leave open of joint i in lanes, between its ends."""
    rim = blocks.rim[i]
    depth, near = blocks.depth[i] - 2.0 * rim, NEAR * (right - left)
    found = ring_part(0.5 * depth, 0.5 * inset_bore(blocks.bore[i], rim), place - near, place + near)
    return where(blocks.section[i] == FRAME, depth, found[1] / (2.0 * near))


@leaf
def strip_stiffness(contact, stiffness, place, width):
    """Return `part_stiffness` of a narrow strip of this width (m) at this place, m from the middle of the block."""
    along = stiffness * depth_at(contact, place) * width
    return along, along * place, along * place * place


# --- the whole section


@leaf
def full_stiffness(blocks, i):
    """Return the stiffness of joint i in full contact (N/m)."""
    if blocks.section[i] == RECTANGLE:
        return blocks.stiffness[i] * blocks.width[i] * blocks.depth[i]
    return blocks.stiffness[i] * _part(contact_of(blocks, i), blocks.left[i], blocks.right[i])[1]


@leaf
def full_turning_stiffness(blocks, i):
    """Return the stiffness of joint i in full contact against rotation about the middle of the block (N m/rad)."""
    if blocks.section[i] == RECTANGLE:
        return full_stiffness(blocks, i) * (blocks.width[i] * blocks.width[i]) / 12.0
    about, area, first, second = _part(contact_of(blocks, i), blocks.left[i], blocks.right[i])
    return blocks.stiffness[i] * (second + about * (2.0 * first + about * area))


@leaf
def is_off_centre(count, depths):
    """Return True if the depths of the strips are not symmetric about the middle."""
    end, differs = int(count), False
    for k in range(end // 2):
        differs = differs or depths[k] != depths[end - 1 - k]
    return differs


@kernel
def lay_out(blocks, i, own, count, depths, below, rim):
    """Fill `blocks` with the contact of joint i from the contact face of the block above and the face below (faces.py).

    Parameters
    ----------
    own, below : FaceShape
        The contact face of the block above and the face below.
    count : float
        Number of strips that the contact face may be made of, which lie over its width; else 0.
    depths : row
        Depths of the strips, m.
    rim : float
        Width of the rim in which the faces touch, m; 0: all over, as where one of them is no wider than its rim, or
        made of strips.
    """
    # the faces, and their intersection
    strips = blocks.strips[STRIP_NUMBERS * i :]
    half = 0.5 * below.width
    blocks.rim_left[i], blocks.rim_right[i], blocks.bore_below[i] = -half, half, below.bore
    blocks.own_depth[i], blocks.own_bore[i] = own.depth, own.bore
    shared = common(own, below)
    section, depth = shared.section, shared.depth
    slipped = after_a_slip(own, below, section)
    # row of the strips
    first, end = 0, int(count)
    strips[COUNT] = count
    strips[PITCH] = own.width / max(count, 1.0)
    for k in range(MOST_STRIPS):
        strips[DEPTHS + k] = depths[k] if k < end else 0.0
    left, right = -0.5 * own.width, 0.5 * own.width
    # a contact face of strips: from the first to the last that has a depth
    if own.section == STRIPS:
        depth, section = own.depth, STRIPS
        while first < end - 1 and not depths[first] > 0.0:
            first += 1
        while end > first + 1 and not depths[end - 1] > 0.0:
            end -= 1
        left, right = edge_of(strips, first), edge_of(strips, end)
        if is_round(below.section):
            section = STRIPS if _lie_within(strips, below) else ON_RING
        else:
            for k in range(end):
                strips[DEPTHS + k] = min(strips[DEPTHS + k], below.depth)
    elif slipped >= ON_RING:  # the straight face is one strip
        strips[COUNT] = 1.0
        strips[DEPTHS] = below.depth if slipped == ON_BAND else own.depth
    # a rim, and the inside of a straight face as one strip
    if own.section == STRIPS or not (has_inside(own, rim) and has_inside(below, rim)):
        rim = 0.0
    if rim > 0.0:
        strips[INSIDE + COUNT], strips[INSIDE + PITCH] = 1.0, strips[PITCH] - 2.0 * rim
        strips[INSIDE + DEPTHS] = strips[DEPTHS] - 2.0 * rim
        section = float(FRAME) if section == RECTANGLE else section
        slipped = float(FRAME) if slipped == RECTANGLE else slipped
    blocks.rim[i] = rim
    # faces whose intersection, or whose inside, is unknown
    if shared.section == UNKNOWN or (rim > 0.0 and not (is_known(own.section) and is_known(below.section))):
        section = float(UNKNOWN)
    # the results; a bore may cut off the ends
    blocks.own_left[i], blocks.own_right[i] = left, right
    blocks.section[i], blocks.depth[i], blocks.bore[i], blocks.slipped[i] = section, depth, shared.bore, slipped
    left, right = max(left, -half), min(right, half)
    left, right = ends_if_band(blocks, i, section, 0.0, left, right)
    blocks.left[i], blocks.right[i] = left, right
    blocks.width[i] = right - left
    # a contact face that overhangs the face below
    wider = own.width > below.width * ALIKE or below.bore > own.bore * ALIKE
    blocks.overhangs[i] = 1.0 if wider or section == ON_RING else 0.0


@leaf
def _lie_within(strips, face):
    """Return True if strips lie within a round face."""
    count, within = int(strips[COUNT]), face.bore == 0.0
    # corners of each strip within the circle
    for k in range(count):
        reach, half = max(-edge_of(strips, k), edge_of(strips, k + 1)), 0.5 * strips[DEPTHS + k]
        within = within and (not half > 0.0 or 2.0 * math.hypot(reach, half) <= face.width)
    return within


@in_both
def face(section: float, width: float, depth: float, bore: float) -> tuple[float, float]:
    """Return area (m2) and second moment about the middle (m4) of a whole section that is not made of strips.

    They are no numbers if the section is unknown.
    """
    # a rectangle
    if section == RECTANGLE:
        return width * depth, width * depth * width * width / 12.0
    if not is_round(section):
        return math.nan, math.nan
    # a circle less its bore
    outer, inner = width * width, bore * bore if section == ANNULUS else 0.0
    return 0.25 * math.pi * (outer - inner), math.pi / 64.0 * (outer - inner) * (outer + inner)
