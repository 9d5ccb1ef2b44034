"""Neighbours: pairs of convex bodies of blocks that no joint connects (theory.md section 17)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, product
from typing import Any, NamedTuple

import numpy as np

from ...common.errors import InputError, check_number, shown
from ...common.ranges import LENGTH, NUMBERS, check_keys
from ...common.tables import check_table, tables_in, vector_of
from .blocks.contacts import GROUND
from .blocks.faces import Face, clipped, polygon_moments
from .blocks.parts import BASE, Pair, Side, Solid, SpatialJoint
from .blocks.polyhedra import Polyhedron, polyhedron_of, slab_behind
from .blocks.shapes import box, placed, rectangle
from .convex import ConvexPart, apart, built_overlaps, distance, hulls_of, near_as_built, touching

_REACH = (0.0, 1e6), "a length in m, zero or positive: blocks within it may meet"
_FRICTION = (0.0, 1e3), "a coefficient of friction, 0 without friction"
RANGES = {
    "reach": _REACH,
    "gap": ((0.0, 1e6), "a length in m, zero or positive"),
    "stiffness": ((1e-6, 1e15), "a positive stiffness in N/m3, from 1e-6 to 1e15, of bodies that meet"),
    "line_stiffness": (
        (1e-6, 1e15),
        "a positive stiffness in N/m2, from 1e-6 to 1e15, along the line in which drums meet",
    ),
    "damping": NUMBERS["damping"],
    "restitution": ((1e-3, 1.0), "a coefficient of restitution, from 1e-3 to 1"),
    "friction": _FRICTION,
    "shear_ratio": (
        (1e-6, 1e6),
        "a positive ratio of the stiffness along the contact to that across it, from 1e-6 to 1e6",
    ),
}
_OF_WALL = ("at", "normal", "width", "height")
_OF_PAIR = ("between", *(name for name in RANGES if name != "reach"))
AFTER_FALL = (0.0, 1e3), "a time in s from 0, for which a run goes on after the first fall"
_OF_ALL = tuple(name for name in RANGES if name != "gap")
KEYS = (*_OF_ALL, "after_fall", "pair", "wall")
_DIRECTION = (-1e6, 1e6), "a number, at most 1e6 either way"
_MEANT = {
    "at": "the middle [x, y, z] of its lower edge, three lengths in m",
    "normal": "the direction [x, y] in which it faces",
    "width": LENGTH[1],
    "height": LENGTH[1],
}
MOST = 1000  # pairs
SHEAR_RATIO = 0.4
PARALLEL = 0.5  # cosine of the angle between the axis of a drum and a face beyond which the drum's end faces it
OPPOSITE = -0.9  # largest cosine of the angle between the normals of faces that face each other
LEAST = 1e-6  # of half the length of a drum: sides that face each other over less do not meet
NEAR = 1e-6  # m
DIFFERENCE, ROUNDED = 1e-6, 9  # m, of the distance; decimals of its direction, of which rounding leaves nothing


def after_fall_of(data: Mapping[str, Any]) -> float:
    """Return for how long a run goes on after the first fall, s, by a structure's file. Raises InputError."""
    table = data.get("neighbours", {})
    given = table.get("after_fall", 0.0) if isinstance(table, Mapping) else 0.0
    return check_number("neighbours.after_fall", given, *AFTER_FALL)


def neighbours_from(
    data: Mapping[str, Any], blocks: tuple[Solid, ...], joints: Sequence[SpatialJoint], after_fall: bool = False
) -> tuple[Pair, ...]:
    """Return the pairs that the table `neighbours` of a structure's file describes; empty without one.

    Blocks with a joint between them are no neighbours. After a fall all pairs are, at any distance, and each block with
    the ground; until then those beyond the reach do not meet, and those with a joint until it has ended. Raises
    InputError if a key or a value is wrong, or if blocks overlap as built.
    """
    if "neighbours" not in data:
        return ()
    # common numbers, declared pairs, walls
    table = data["neighbours"]
    check_table("neighbours.", table, KEYS)
    given = _numbers("neighbours", table, _OF_ALL)
    declared: dict[tuple[int, int], tuple[str, dict[str, float]]] = {}
    for number, part in enumerate(tables_in("neighbours.pair", table, 0), start=1):
        key = f"neighbours.pair[{number}]"
        check_keys(f"{key}.", part, _OF_PAIR)
        both = _between(key, part, blocks)
        if both in declared:
            raise InputError(f"{key}.between: is the pair of {declared[both][0]}, must be given once")
        declared[both] = key, _numbers(key, part, _OF_PAIR[1:])
    tables = tables_in("neighbours.wall", table, 0)
    walls = [_wall(f"neighbours.wall[{number}]", part) for number, part in enumerate(tables, start=1)]
    # pairs of blocks within the reach, or declared
    joined = {frozenset((joint.upper, joint.lower)) for joint in joints}
    reach = given.get("reach", -1.0 if declared else math.inf)
    to_walls = given.get("reach", math.inf)
    bodies, found = [_bodies_of(block) for block in blocks], []
    _refuse_overlaps(blocks, joints, {pair for pair, (_, own) in declared.items() if "gap" in own})
    near = near_as_built(blocks, joints, np.array((math.inf if after_fall else reach) + NEAR))
    for one, other in combinations(range(len(blocks)), 2):
        key, own = declared.get((one, other), ("", {}))
        if key and frozenset((one, other)) in joined:
            raise InputError(f"{key}.between: must be two blocks without a joint between them")
        if not key and not near[one, other]:
            continue
        within = math.inf if key or after_fall else reach
        # the largest overlap as built at which sides still face each other
        solids = blocks[one], blocks[other]
        deepest = min(solid.drop for solid in solids) if "gap" in own else touching(*solids)
        pairs = _pairs_between(blocks, bodies, one, other, within, deepest)
        late = not key and min((pair.gap for pair in pairs), default=reach) > reach
        law, least = {**_law(given, own), **own}, min((pair.gap for pair in pairs), default=0.0)
        if "gap" in own:
            pairs = _moved_to(own["gap"], pairs, blocks, (*bodies[one], *bodies[other]))
        for pair in pairs:  # the declared gap is that of the nearest ones: all are nearer by the same length
            gap = {"gap": own["gap"] + (pair.gap - least)} if "gap" in own else {}
            found.append(replace(_with_law(key or "neighbours", pair, law | gap, blocks, pairs), joined=late))
    if after_fall:
        found += _pairs_after_fall(blocks, bodies, joined, given)
    # blocks and walls
    for one, block in enumerate(blocks):
        for number, wall in enumerate(walls, start=1):
            pairs = _pairs_before(block, bodies[one], one, wall, len(blocks))
            # the reach is that of the block, of all its bodies
            late = min((pair.gap for pair in pairs), default=0.0) > to_walls
            if after_fall or not late:
                numbered = (replace(pair, wall=number, joined=late) for pair in pairs)
                found += [_with_law("neighbours", pair, given, blocks, pairs) for pair in numbered]
    if len(found) > MOST:
        raise InputError(f"neighbours.reach: {len(found)} pairs of bodies lie within it, must be at most {MOST}")
    return tuple(found)


def _refuse_overlaps(blocks: tuple[Solid, ...], joints: Sequence[SpatialJoint], apart: set[tuple[int, int]]) -> None:
    """Raise InputError for two blocks that overlap as built, unless a table gives their gap."""
    for one, other, depth in built_overlaps(blocks, joints):
        if (one, other) not in apart:
            names = f"{blocks[one].name} and {blocks[other].name} overlap by {1e3 * depth:.3g} mm as built"
            raise InputError(f"neighbours: {names}, must stand apart, or have a gap in [[neighbours.pair]]")


def _wall(key: str, table: Mapping[str, Any]) -> Face:
    """Return a vertical plane that moves with the base; the centre of its lower edge is at `at`."""
    check_keys(f"{key}.", table, _OF_WALL)
    for word in _OF_WALL:
        if word not in table:
            raise InputError(f"{key}.{word}: missing, must be {_MEANT[word]}")
    at = vector_of(f"{key}.at", table["at"], 3, meaning=_MEANT["at"])
    normal = vector_of(f"{key}.normal", table["normal"], 2, _DIRECTION, _MEANT["normal"])
    size = math.hypot(*normal)
    if not size > 0.0:
        raise InputError(f"{key}.normal = {shown(table['normal'])}: must have a length")
    width, height = (check_number(f"{key}.{word}", table[word], *LENGTH) for word in ("width", "height"))
    third, second = np.array([normal[0] / size, normal[1] / size, 0.0]), np.array([0.0, 0.0, 1.0])
    axes = np.column_stack([np.cross(second, third), second, third])
    return Face(at + 0.5 * height * second, axes, rectangle(width, height))


def _law(given: Mapping[str, float], own: Mapping[str, float]) -> dict[str, float]:
    """Return the default law for a pair; its own damping or restitution replaces either of them."""
    says = {"damping", "restitution"} & own.keys()
    return {name: value for name, value in given.items() if not (says and name in ("damping", "restitution"))}


def _numbers(key: str, table: Mapping[str, Any], names: tuple[str, ...]) -> dict[str, float]:
    found = {name: check_number(f"{key}.{name}", table[name], *RANGES[name]) for name in names if name in table}
    if "damping" in found and "restitution" in found:
        raise InputError(f"{key}.restitution: must be left out beside damping, which it stands for")
    return found


def _between(key: str, table: Mapping[str, Any], blocks: tuple[Solid, ...]) -> tuple[int, int]:
    names, pair = [block.name for block in blocks], table.get("between")
    if not isinstance(pair, (list, tuple)) or len(pair) != 2 or pair[0] == pair[1]:
        raise InputError(f"{key}.between = {shown(pair)}: must be two names of blocks")
    for name in pair:
        if name not in names:
            raise InputError(f"{key}.between: {shown(name)} must be the name of a block")
    one, other = sorted(names.index(name) for name in pair)
    return one, other


def side_of_drum(solid: Solid) -> Side | None:
    """Return the side of a drum with equal ends; None for other blocks."""
    ends = [face for face in solid.faces if face.radius]
    if len(ends) != 2 or len(solid.faces) != 2 or not math.isclose(ends[0].radius, ends[1].radius, rel_tol=1e-9):
        return None
    along = ends[1].centre - ends[0].centre
    length = float(np.linalg.norm(along))
    return Side(0.5 * (ends[0].centre + ends[1].centre), along / length, 0.5 * length, ends[0].radius)


class _Body(NamedTuple):
    """A convex part of a block in two forms."""

    part: ConvexPart
    polyhedron: Polyhedron


def _bodies_of(block: Solid) -> list[_Body]:
    """Return the convex parts of a block. Raises InputError for one of too many faces."""
    key = f"block[{block.name}]"
    return [_Body(part, polyhedron_of(part.faces, block.centroid, key)) for part in hulls_of(block)]


def _pairs_between(
    blocks: tuple[Solid, ...], bodies: list[list[_Body]], one: int, other: int, reach: float, deepest: float
) -> list[Pair]:
    """Return the pairs of convex bodies of two blocks that lie within a reach (m) as built, without their laws.

    A drum comes first, and meets another drum and each face before it by its side too. deepest: largest overlap as
    built at which plane faces still face each other, m.
    """
    drums = side_of_drum(blocks[one]), side_of_drum(blocks[other])
    if drums[1] and not drums[0]:
        one, other, drums = other, one, drums[::-1]
    between, found = blocks[other].centroid - blocks[one].centroid, list[Pair]()
    for a, b in product(bodies[one], bodies[other]):
        both = a.polyhedron, b.polyhedron
        away, _ = apart(a.part, b.part, between)
        if drums[0] and drums[1]:
            gap, length = _gap_of_drums(drums[0], drums[1])
            length = length or 2.0 * min(drums[0].half, drums[1].half)
            faces = not math.isinf(gap)
            pairs = [Pair(one, other, both, gap if faces else away, length, drums[0], drums[1], faces=faces)]
        elif drums[0]:
            pairs = _before_faces(one, other, both, drums[0], b.part.faces)
        else:
            pairs = []
        if not pairs:
            area = _facing_area(a.part.faces, b.part.faces, deepest)
            size = area or min(body.mean_area for body in both)
            pairs = [Pair(one, other, both, away, size, faces=area > 0.0)]
        found += pairs
    return found if min(pair.gap for pair in found) <= reach else []


def _moved_to(gap: float, pairs: list[Pair], blocks: tuple[Solid, ...], bodies: Iterable[_Body]) -> list[Pair]:
    """Return the pairs of two blocks as if the first were moved along their distance until the least gap is `gap` (m).

    A rigid shape moves, so that its contact derives from an energy at any gap. Sides of drums keep their places: their
    radius counts instead (`farther`).
    """
    nearest = min(pairs, key=lambda pair: pair.gap)
    by = nearest.gap - gap
    if nearest.side or by == 0.0:
        return pairs
    # direction of the distance: of the nearest points, or by central differences
    parts, still = {id(body.polyhedron): body.part for body in bodies}, np.zeros((3, 3))
    between, steps = blocks[nearest.other].centroid - blocks[nearest.one].centroid, DIFFERENCE * np.eye(3)
    one, other = (parts[id(body)] for body in nearest.bodies)
    _, direction = apart(one, other, between)
    if direction is None:
        ahead, behind = (distance(one, other, still, still, between + step) for step in (steps, -steps))
        direction = np.round((ahead - behind) / (2.0 * DIFFERENCE), ROUNDED)
    vector = by * direction / np.linalg.norm(direction)
    # the bodies, and their distances then
    moved = {id(pair.bodies[0]): pair.bodies[0].moved(vector) for pair in pairs}
    made = []
    for pair in pairs:
        if pair.side:
            made.append(pair)
            continue
        one, other = (parts[id(body)] for body in pair.bodies)
        left, _ = apart(one, other, between - vector)
        both = moved[id(pair.bodies[0])], pair.bodies[1]
        made.append(replace(pair, bodies=both, gap=gap if pair is nearest else left, shift=abs(by)))
    return made


def _before_faces(
    one: int, other: int, both: tuple[Polyhedron, Polyhedron], drum: Side, faces: Sequence[Face]
) -> list[Pair]:
    """Return the pairs of a drum with the faces of another body that its side faces; its body presses in the first."""
    gaps = [(face, gap) for face in faces if (gap := _gap_before_face(drum, face))]
    return [Pair(one, other, both, *gap, drum, face, presses=k == 0) for k, (face, gap) in enumerate(gaps)]


def _pairs_before(block: Solid, bodies: list[_Body], one: int, wall: Face, base: int) -> list[Pair]:
    """Return the pairs of the convex bodies of a block with a wall before which they stand.

    None for a block behind the plane of the wall. The gap of a body that overlaps the wall is negative.
    """
    drum, slab, found, still = side_of_drum(block), slab_behind(wall), [], np.zeros((1, 3))
    ends = np.array([body.part.extent(still, wall.normal[None, None]) for body in bodies])
    back, front = float(np.min(ends[:, 0])), float(np.max(ends[:, 1]))
    if front + float((block.centroid - wall.centre) @ wall.normal) <= min(touching(block), 0.5 * (front - back)):
        return []
    for body in bodies:
        both = body.polyhedron, slab
        pairs = _before_faces(one, base, both, drum, (wall,)) if drum else []
        if not pairs:
            # the box about the body along the axes of the wall
            places = (block.centroid + body.polyhedron.corners - wall.centre) @ wall.axes
            low, high, half = np.min(places, axis=0), np.max(places, axis=0), np.ptp(wall.outline, axis=0) / 2.0
            beside = np.maximum(np.maximum(low[:2] - half, -half - high[:2]), 0.0)
            gap = float(np.hypot(low[2], np.hypot(*beside))) if np.any(beside) else float(low[2])
            if low[2] < -touching(block):
                solid = _solid_behind(wall)
                away = (solid.centroid - block.centroid)[None]
                gap = float(distance(body.part, ConvexPart(solid), still, still, away)[0])
                if gap >= -touching(block):  # beside the wall
                    continue
            area = _facing_area(body.part.faces, (wall,), touching(block))
            size = area or both[0].mean_area
            pairs = [Pair(one, base, both, gap, size, beside=wall, faces=area > 0.0)]
        found += pairs
    return found


def _solid_behind(wall: Face) -> Solid:
    """Return the solid of `slab_behind`."""
    width, height = np.ptp(wall.outline, axis=0).tolist()
    thick, (first, second, third) = max(width, height), wall.axes.T
    turn = np.column_stack([first, -third, second])
    return placed(
        box("wall", *((width, thick),) * 2, height, 1.0), wall.centre - 0.5 * (thick * third + height * second), turn
    )


def _pairs_after_fall(
    blocks: tuple[Solid, ...], bodies: list[list[_Body]], joined: set[frozenset[int]], law: Mapping[str, float]
) -> list[Pair]:
    """Return the pairs that meet only once their joints have ended, and those of all blocks with the ground."""
    base, found = len(blocks), []
    for one, other in combinations(range(base), 2):
        if frozenset((one, other)) in joined:
            found += _pairs_between(blocks, bodies, one, other, math.inf, math.inf)
    for one, block in enumerate(blocks):
        found += _pairs_on_ground(block, bodies[one], one, base)
    # with the clearance as built
    made = [_with_law("neighbours", replace(pair, faces=False), {**law, "gap": 0.0}, blocks) for pair in found]
    return [replace(pair, farther=0.0, joined=frozenset((pair.one, pair.other)) in joined) for pair in made]


def _pairs_on_ground(block: Solid, bodies: list[_Body], one: int, base: int) -> list[Pair]:
    """Return the pairs of the convex bodies of a block with the ground, on which a drum may roll."""
    drum, ground, found = side_of_drum(block), slab_behind(GROUND), []
    for body in bodies:
        both, area = (body.polyhedron, ground), body.polyhedron.mean_area
        low = float(np.min((block.centroid + body.polyhedron.corners)[:, 2]))
        found.append(Pair(one, base, both, low, 2.0 * drum.half if drum else area, drum, GROUND if drum else None))
    return found


def _facing_area(own: Sequence[Face], others: Sequence[Face], deepest: float) -> float:
    """Return the largest area over which two faces face each other (m2), 0 without any.

    Faces that overlap by more than `deepest` (m) do not face each other.
    """
    return max((_area_of_faces(one, other, deepest) for one, other in product(own, others)), default=0.0)


def _area_of_faces(one: Face, other: Face, deepest: float) -> float:
    cosine = float(one.normal @ other.normal)
    if one.radius or other.radius or cosine > OPPOSITE:
        return 0.0
    if math.hypot(*((one.centre - other.centre) @ other.axes[:, :2])) > one.size + other.size:
        return 0.0
    common = clipped(one.seen_from(other), other.outline)
    if not len(common):
        return 0.0
    places = other.centre + common @ other.axes[:, :2].T
    gap = float(np.min((one.centre - places) @ one.normal / cosine))
    area = float(polygon_moments(common)[0])
    return area if gap >= -deepest and area > LEAST * float(polygon_moments(other.outline)[0]) else 0.0


def _gap_of_drums(a: Side, b: Side) -> tuple[float, float]:
    """Return the distance of the sides of two drums (m), and the length over which they face each other (m)."""
    between, axis = a.middle - b.middle, b.axis * math.copysign(1.0, float(a.axis @ b.axis))
    # both axes in planes across their bisector (theory.md section 17)
    both, apart = a.axis + axis, a.axis - axis
    shift = float(between @ both) / float(both @ both)
    at, lean, leans = between - shift * both, 0.5 * float(apart @ between), 0.5 * float(apart @ apart)

    def across(s: float) -> float:
        w = at + s * apart
        return math.sqrt(max(float(w @ w) - (lean + s * leans) ** 2, NEAR * NEAR))

    # planes before the ends of both
    ends = [
        [s + side.radius * (lean + s * leans) / across(s) for s in (own * shift - side.half, own * shift + side.half)]
        for side, own in ((a, 1.0), (b, -1.0))
    ]
    low, high = max(ends[0][0], ends[1][0]), min(ends[0][1], ends[1][1])
    if high - low <= LEAST * min(a.half, b.half):
        return math.inf, 0.0
    # the plane in which both are nearest to each other
    s = min(max(-lean / leans if leans > 1e-24 else 0.0, low), high)
    return across(s) - a.radius - b.radius, high - low


def _gap_before_face(drum: Side, face: Face) -> tuple[float, float] | None:
    """Return the distance of a drum from a face (m), and the length over which it faces it (m); None if it does not."""
    c = float(drum.axis @ face.normal)
    if face.radius or abs(c) > PARALLEL:
        return None
    between, sine = drum.middle - face.centre, math.sqrt(1.0 - c * c)
    between = between - (face.normal - c * drum.axis) * drum.radius / sine
    low, high = -drum.half, drum.half
    # clip the generatrix of the drum that is nearest to the face to its outline
    x, y = between @ face.axes[:, :2], drum.axis @ face.axes[:, :2]
    for a, b in zip(face.outline, np.roll(face.outline, -1, axis=0), strict=True):
        side = b - a
        level, slope = float(side[0] * (x[1] - a[1]) - side[1] * (x[0] - a[0])), float(side[0] * y[1] - side[1] * y[0])
        if slope > 1e-12:
            low = max(low, -level / slope)
        elif slope < -1e-12:
            high = min(high, -level / slope)
        elif level <= 0.0:
            return None
    if high - low <= LEAST * drum.half:
        return None
    away = float(between @ face.normal)
    gap = away + min(low * c, high * c)
    return (gap, high - low) if away + drum.radius * sine > 0.0 else None


def _names(pair: Pair, blocks: tuple[Solid, ...]) -> str:
    names = (*(block.name for block in blocks), BASE)
    return f"{names[pair.one]} and {f'wall {pair.wall}' if pair.wall else names[pair.other]}"


def _with_law(
    key: str, pair: Pair, law: Mapping[str, float], blocks: tuple[Solid, ...], others: Sequence[Pair] = ()
) -> Pair:
    """Return a pair with its law and gap; `others` are those of the same blocks, itself included. Raises InputError."""
    names = _names(pair, blocks)
    of_kind = "line_stiffness" if pair.side else "stiffness"
    radius = pair.side.radius if pair.side else math.sqrt(min(body.mean_area for body in pair.bodies) / math.pi)
    # where no sides face each other as built, either stiffness is enough
    if not pair.faces and {"stiffness", "line_stiffness"} & law.keys():
        either = {"stiffness": law.get("line_stiffness", 0.0) / radius}
        law = either | {"line_stiffness": law.get("stiffness", 0.0) * radius} | dict(law)
    if of_kind not in law:
        raise InputError(f"{key}.{of_kind}: missing, must be {RANGES[of_kind][1]}: {names} may meet")
    if "friction" not in law:
        raise InputError(f"{key}.friction: missing, must be {_FRICTION[1]}: {names} may meet")
    if not {"damping", "restitution"} & law.keys():
        raise InputError(f"{key}.damping: missing, must be {NUMBERS['damping'][1]}, or a restitution: {names} may meet")
    if "gap" not in law and pair.gap < -touching(*(blocks[i] for i in (pair.one, pair.other) if i < len(blocks))):
        deep = f"{-1e3 * pair.gap:.3g} mm as built"
        raise InputError(f"{key}: {names} overlap by {deep}, must stand apart{'' if pair.wall else ', or have a gap'}")
    # damping, from the restitution with the reduced mass of both blocks and all their parts that meet at once
    stiffness = law[of_kind] * pair.size
    if "damping" in law:
        damping = law["damping"]
    else:
        mass = 1.0 / sum(1.0 / blocks[i].mass for i in (pair.one, pair.other) if i < len(blocks))
        along = [one for one in others if one.faces and (one.side is None) == (pair.side is None)]
        at_once = sum(one.size for one in along if abs(one.gap - pair.gap) <= NEAR) if pair.faces else 0.0
        damping = damping_of(law["restitution"], mass, law[of_kind] * (at_once or pair.size))
    gap = max(pair.gap, 0.0) if pair.shift else law.get("gap", max(pair.gap, 0.0))
    # of the body of a drum, if no other is given: its line spread over the radius
    own = law.get("stiffness", law[of_kind] / radius)
    return replace(
        pair,
        gap=gap,
        farther=gap - pair.gap,
        stiffness=law[of_kind],
        body_stiffness=own if pair.presses else 0.0,
        damping=damping,
        friction=law["friction"],
        shear=law.get("shear_ratio", SHEAR_RATIO) * stiffness,
    )


def restitution_of(damping: float, mass: float, stiffness: float) -> float:
    """Return the coefficient of restitution of a central impact on a damped bed that bears no tension.

    The damping is in s, the stiffness of the bed in N/m; the mass (kg) of two blocks is m1 m2 / (m1 + m2). The impact
    is the damped half-oscillation until the force is zero.
    Source: T. Schwager and T. Pöschel, Granular Matter 9 (2007) 465.
    """
    zeta = 0.5 * damping * math.sqrt(stiffness / mass)
    if zeta == 0.0:
        return 1.0
    if zeta < 1.0:
        free = math.sqrt(1.0 - zeta * zeta)
        return math.exp(-zeta / free * math.atan2(2.0 * zeta * free, 2.0 * zeta * zeta - 1.0))
    if zeta == 1.0:
        return math.exp(-2.0)
    fast = math.sqrt(zeta * zeta - 1.0)
    return math.exp(-zeta / fast * math.log((zeta + fast) / (zeta - fast)))


def damping_of(restitution: float, mass: float, stiffness: float) -> float:
    """Return the damping (s) that gives this restitution: the inverse of `restitution_of`, by bisection."""
    low, high = 0.0, 1.0
    while restitution_of(high, mass, stiffness) > restitution:
        high *= 2.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if restitution_of(middle, mass, stiffness) > restitution else (low, middle)
    return 0.5 * (low + high) if restitution < 1.0 else 0.0
