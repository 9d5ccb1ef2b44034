"""A structure from its TOML file."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...common.errors import InputError, InputWarning, check_number, check_whole, shown
from ...common.ranges import LENGTH, MAX_BLOCKS, NUMBERS, check, check_choice
from ...common.tables import check_table, tables_in, vector_of
from ...kernels.structure.layout import MOST_CORNERS
from ..column.file import has_blocks_in_space
from ..ports import Port, ports_from
from .bearing_tables import bearings_from
from .bearing_tables import check_table as check_bearing
from .blocks.contacts import GROUND, axes_of, joints_between, with_rim
from .blocks.faces import Face, FloatArray, polygon_moments
from .blocks.outlines import MEANING, outline_of
from .blocks.parts import BASE, BESIDE_COLUMN, OF_COLUMN, TOLERANCE, JointLaw, Solid, SpatialJoint, Tie
from .blocks.placement import check_joints, check_places
from .blocks.shapes import box, drum, placed, prism, rectangle, rotation_matrix
from .convex import built_overlaps
from .hull_tables import OF_HULL, OF_MESH, solid_from_hull
from .neighbours import after_fall_of, neighbours_from

SHAPES = ("box", "drum", "prism", "hull", "mesh")
_OF_SECTION = {
    "rectangle": ("width", "depth"),
    "circle": ("diameter",),
    "ring": ("diameter", "bore"),
    "polygon": ("outline",),
}
_KEYS = ("name", "g", "block", "joint", "joints", "bearing", "tie", "port", "neighbours", "solver")
_BOND = ("tensile_strength", "cohesion")
_LAW = ("stiffness", "damping", "shear_ratio", "shear_damping", "friction", "dowel", "strength", "rim", *_BOND)
_OF_SHAPE = {
    "box": ("width", "depth", "height", "top_width", "top_depth"),
    "drum": ("diameter", "top_diameter", "bore", "height"),
    "prism": ("outline", "depth"),
    "hull": OF_HULL,
    "mesh": OF_MESH,
}
_BLOCK = ("name", "shape", "on", "at", "position", "rotation", "mass", "density", "joint", "repeat")
_PATCH = ("normal", "section", "width", "depth", "diameter", "bore", "outline")  # of a joint with its own position
_JOINT = ("between", "at", *_PATCH, *_LAW)
_TIE = ("between", "from", "to", "stiffness", "damping", "slack", "pretension", "tension_only", "yield")
OWN_RANGES = {
    "shear_ratio": ((1e-6, 1e6), "a positive ratio of the modulus along the joint to that across it, from 1e-6 to 1e6"),
    "shear_damping": NUMBERS["damping"],
    "rim": (LENGTH[0], "a positive width in m of the band along the edges in which faces touch, from 1e-6 to 1e6"),
}
_ANGLE = (-2.0 * math.pi, 2.0 * math.pi), "an angle in rad, at most a full turn either way"
OF_TIES = {
    "stiffness": ((1e-6, 1e15), "a positive stiffness in N/m, from 1e-6 to 1e15"),
    "damping": ((0.0, 1e15), "a damping in N s/m, zero or positive"),
    "slack": ((0.0, 1e6), "a length in m, zero or positive"),
    "pretension": ((0.0, 1e15), "a force in N, zero or positive"),
    "yield": ((1e-6, 1e15), "a positive force in N, from 1e-6 to 1e15"),
}


def parts_from(data: Mapping[str, Any], surfaces: Mapping[int, FloatArray]) -> dict[str, Any]:
    """Return the fields of a structure from its file (docs/structures.md), with hulls in place of meshes.

    `surfaces` has triangles (k, 3, 3), m, to draw the blocks of a table by, keyed by the number of the table from 1.
    Raises InputError if a key or a value is wrong.
    """
    check_table("", data, _KEYS)
    if "name" not in data:
        raise InputError('name: missing, must be a file name: letters, digits, "_", "-", "." and space')
    # blocks, in the order of the tables
    law, explicit = _joint_tables(data)
    solids = _Solids()
    joints: list[SpatialJoint] = []
    tables = tables_in("block", data)
    for word in ("joints", "tie"):
        if word in data and OF_COLUMN not in data and not has_blocks_in_space(data):
            raise InputError(f"{word}: is of a structure, whose blocks have on or position; a column has [joint]")
    count = sum(_times(f"block[{number}]", table) for number, table in enumerate(tables, start=1))
    if count > MAX_BLOCKS:
        raise InputError(f"block: {count} blocks, must be 1 to {MAX_BLOCKS}")
    for number, table in enumerate(tables, start=1):
        for part in _repeated(f"block[{number}]", table):
            solids.add(f"block[{number}]", part, surfaces.get(number))
    blocks = tuple(solids.found)
    check_places([key for key, _ in solids.standing], blocks)
    # joints between a block and its supports, listed joints, bearings
    for upper, (key, supports) in enumerate(solids.standing):
        own = solids.laws[upper]
        for lower in supports:
            bed, below = bed_from(f"{key}.joint", {**law, **own}), len(blocks) if lower < 0 else lower
            joints += joints_between(blocks, upper, below, bed, f"{key}.on")
    for number, table in enumerate(explicit, start=1):
        joints += _joints_from(f"joint[{number}]", table, law, blocks)
    for number, table in enumerate(tables_in("bearing", data, 0), start=1):
        joints += _bearings_from(f"bearing[{number}]", table, blocks)
    check_joints(blocks, joints)
    # ties, ports, settings
    ties = tuple(_tie_from(f"tie[{e}]", table, blocks) for e, table in enumerate(tables_in("tie", data, 0), start=1))
    ports = ports_of(data, blocks)
    solver = data.get("solver", {})
    check_table("solver.", solver, ("tolerance", "without"))
    tolerance = check("solver.tolerance", solver.get("tolerance", TOLERANCE))
    gravity = check("g", data.get("g", 9.80665))
    after_fall = after_fall_of(data)
    if "neighbours" not in data:
        _warn_of_overlaps(blocks, joints)
    found = {
        "name": data["name"],
        "blocks": blocks,
        "joints": tuple(joints),
        "ties": ties,
        "ports": ports,
        "neighbours": neighbours_from(data, blocks, joints, after_fall > 0.0),
        "after_fall": after_fall,
        "g": gravity,
    }
    return found | {"tolerance": tolerance, "without": names_from("solver.without", solver.get("without", ()))}


def _warn_of_overlaps(blocks: tuple[Solid, ...], joints: Sequence[SpatialJoint]) -> None:
    """Warn of blocks without a joint that overlap as built."""
    overlaps = built_overlaps(blocks, joints)
    if overlaps:
        one, other, depth = overlaps[0]
        more = f"; {len(overlaps) - 1} more pairs overlap" if len(overlaps) > 1 else ""
        warnings.warn(
            f"block[{blocks[one].name}] and block[{blocks[other].name}] overlap by {1e3 * depth:.3g} mm as built, and "
            f"no joint connects them{more}; move them apart",
            InputWarning,
            stacklevel=5,
        )


def names_from(key: str, value: object) -> tuple[Any, ...]:
    """Convert a list to a tuple. Raises InputError for anything else."""
    if not isinstance(value, (list, tuple)):
        raise InputError(f"{key} = {shown(value)}: must be a list of names")
    return tuple(value)


def written_out(data: Mapping[str, Any]) -> dict[str, Any]:
    """Expand the file to one table for each block, as plain lists and dicts, so that each number can be set."""
    tables = [part for k, table in enumerate(data["block"], start=1) for part in _repeated(f"block[{k}]", table)]
    return _plain({**data, "block": tables})


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(part) for part in value]
    return value.item() if isinstance(value, np.generic) else value


def _repeated(key: str, table: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the tables of repeated blocks, each standing on the previous one: name.1, name.2, ...

    Drums taper over all of them together.
    """
    if "repeat" not in table:
        return [table]
    count = _times(key, table)
    for word, why in (("name", "the blocks count from it"), ("on", "the lowest one stands on it")):
        if not isinstance(table.get(word), str):
            raise InputError(f"{key}.{word} = {shown(table.get(word))}: must be a name beside repeat, {why}")
    # linear taper over all blocks; only the first has a position
    found: list[Mapping[str, Any]] = []
    for k in range(count):
        part: dict[str, Any] = {word: value for word, value in table.items() if word != "repeat"} | {
            "name": f"{table['name']}.{k + 1}"
        }
        if k:
            part["on"] = f"{table['name']}.{k}"
        if "top_diameter" in table:
            wide, narrow = (_number(key, table, word) for word in ("diameter", "top_diameter"))
            ends = [wide + (narrow - wide) * place / count for place in (k, k + 1)]
            part["diameter"], part["top_diameter"] = ends
        if k:
            part.pop("at", None)
        found.append(part)
    return found


def _times(key: str, table: Mapping[str, Any]) -> int:
    """Return the number of blocks that a table describes."""
    meaning = f"a whole number from 1 to {MAX_BLOCKS}"
    return check_whole(f"{key}.repeat", table.get("repeat", 1), 1, MAX_BLOCKS, meaning)


def describes_structure(data: Mapping[str, Any]) -> bool:
    """Return True if a file describes a structure, not a column: its blocks have supports or positions."""
    return bool({"tie", "joints", OF_COLUMN} & data.keys()) or has_blocks_in_space(data)


def in_space(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the mapping of a structure; that of a column is wrapped."""
    if describes_structure(data):
        return data
    column = {key: value for key, value in data.items() if key not in BESIDE_COLUMN}
    return {OF_COLUMN: column, **{key: data[key] for key in BESIDE_COLUMN if key in data}}


class _Solids:
    """The blocks read so far, with their supports and the laws of the joints below them."""

    def __init__(self) -> None:
        self.found: list[Solid] = []
        self.numbers = {BASE: -1}  # by name; -1 stands for the base until the number of blocks is known
        self.standing: list[tuple[str, list[int]]] = []  # key of the table
        self.laws: list[Mapping[str, Any]] = []

    def add(self, key: str, table: Mapping[str, Any], surface: FloatArray | None) -> None:
        """Read one table; surface: triangles to draw it by (see `solid_from_hull`)."""
        shape = table.get("shape", "box")
        check_choice(f"{key}.shape", shape, SHAPES)
        check_table(f"{key}.", table, (*_BLOCK, *_OF_SHAPE[shape]))
        name = table.get("name", f"block{len(self.found) + 1}")
        if not isinstance(name, str) or not name or not name.isprintable():
            raise InputError(f"{key}.name = {shown(name)}: must be a word that can be printed")
        if name in self.numbers:
            raise InputError(f"{key}.name = {shown(name)}: must be another name, it is taken")
        # law of its joints, supports, shape
        own = table.get("joint", {})
        check_table(f"{key}.joint.", own, _LAW)
        _law_numbers(f"{key}.joint", own)  # also of a block with a position, whose listed joints do not use them
        supports = self._named(key, table)
        solid = _solid_from(key, name, shape, table, self._place(key, table, supports), surface)
        self.numbers[name] = len(self.found)
        self.found.append(solid)
        self.laws.append(own)
        self.standing.append((key, supports))

    def _named(self, key: str, table: Mapping[str, Any]) -> list[int]:
        """Return the indices of the supports of a block; -1 for the base."""
        on = table.get("on", [])
        if not isinstance(on, (str, list, tuple)):
            raise InputError(
                f"{key}.on = {shown(on)}: must be {BASE}, the name of a block before it, or a list of them"
            )
        given = [on] if isinstance(on, str) else on
        for k, name in enumerate(given):
            if not isinstance(name, str) or name not in self.numbers:
                check_choice(f"{key}.on", name, tuple(self.numbers))
            if name in given[:k]:
                raise InputError(f"{key}.on: names {name} twice, each contact must be there once")
        return [self.numbers[name] for name in given]

    def _place(self, key: str, table: Mapping[str, Any], supports: list[int]) -> FloatArray:
        """Return the position of a block: the centre of its bottom face, or the origin of its outline or points (m)."""
        if "position" in table:
            if "at" in table:
                raise InputError(f"{key}.at: must be left out beside position")
            return vector_of(f"{key}.position", table["position"], 3)
        if not supports:
            raise InputError(f'{key}.on: missing, must be "base" or the name of a block before it; or give position')
        # on top of the first support
        first = self.found[supports[0]] if supports[0] >= 0 else None
        corners = np.zeros((1, 3)) if first is None else first.corners
        top = float(np.max(corners[:, 2]))
        if "at" in table:
            return np.array([*vector_of(f"{key}.at", table["at"], 2), top])
        if first is None:
            return np.zeros(3)
        level = [face for face in first.faces if face.normal[2] > 1.0 - 1e-9 and abs(face.centre[2] - top) < 1e-9]
        return level[0].centre if level else np.array([*first.centroid[:2], top])


def _solid_from(
    key: str, name: str, shape: str, table: Mapping[str, Any], place: FloatArray, surface: FloatArray | None
) -> Solid:
    def number(word: str, default: float | None = None) -> float:
        return _number(key, table, word, default)

    if ("mass" in table) == ("density" in table):
        raise InputError(f"{key}.density: must be given, in kg/m3, or mass in kg, one of the two")
    turn = rotation_matrix(vector_of(f"{key}.rotation", table.get("rotation", [0.0, 0.0, 0.0]), 3, _ANGLE))
    density = number("density", 1.0)
    # shape at the origin, from its density
    if shape == "box":
        bottom = number("width"), number("depth")
        top = number("top_width", bottom[0]), number("top_depth", bottom[1])
        made = box(name, bottom, top, number("height"), density)
    elif shape == "drum":
        outer = number("diameter")
        top_outer = number("top_diameter", outer)
        given = table.get("bore", 0.0)
        bore = 0.0 if given == 0 and not isinstance(given, bool) else number("bore")
        if bore >= min(outer, top_outer):
            raise InputError(f"{key}.bore = {bore}: must be less than the outer diameter = {min(outer, top_outer)} m")
        made = drum(name, outer, top_outer, bore, number("height"), density)
    elif shape == "hull":
        made = solid_from_hull(key, name, table, density, surface, stands="position" not in table)
    else:
        made = prism(name, _outline(f"{key}.outline", table), number("depth"), density)
    made = placed(made, place, turn)
    if "mass" not in table:
        return made
    # scale to the given mass
    factor = number("mass") / made.mass
    return replace(made, mass=made.mass * factor, inertia=made.inertia * factor)


def _outline(key: str, table: Mapping[str, Any]) -> FloatArray:
    """Return the outline of a table as a convex polygon, anticlockwise, (corners, 2) m."""
    points = table.get("outline")
    if not isinstance(points, (list, tuple, np.ndarray)):
        raise InputError(f"{key} = {shown(points)}: must be {MEANING}")
    if not 3 <= len(points) <= MOST_CORNERS + 1:
        raise InputError(f"{key}: {len(points)} corners, must be {MEANING}")
    return outline_of(key, [vector_of(f"{key}[{k}]", point, 2) for k, point in enumerate(points)])


def _joint_tables(data: Mapping[str, Any]) -> tuple[Mapping[str, Any], list[Mapping[str, Any]]]:
    """Return the default law of joints, and the tables of the listed joints."""
    given, defaults = data.get("joint", []), data.get("joints", {})
    if isinstance(given, Mapping):
        if "joints" in data:
            raise InputError("joints: must be left out beside the table joint, which says the same")
        given, defaults = [], given
    check_table("joint.", defaults, _LAW)
    _law_numbers("joint" if defaults is data.get("joint") else "joints", defaults)  # also if no joint uses them
    return defaults, tables_in("joint", {"joint": given}, 0)


def _law_numbers(key: str, table: Mapping[str, Any]) -> dict[str, float]:
    """Return the numbers of the law of a joint that a table has. Raises InputError for one that is out of range."""
    ranges = {word: OWN_RANGES.get(word) or NUMBERS[word] for word in _LAW if word in table}
    return {word: check_number(f"{key}.{word}", table[word], *ranges[word]) for word in ranges}


def bed_from(key: str, table: Mapping[str, Any]) -> JointLaw:
    """Return the law of a joint from its keys. Raises InputError."""
    found: dict[str, Any] = _law_numbers(key, table)
    # keys that are required, and keys that exclude or require each other
    for word in ("stiffness", "damping"):
        if word not in found:
            raise InputError(f"{key}.{word}: missing, must be {NUMBERS[word][1]}")
    if "rim" in found and (found.get("tensile_strength") or found.get("cohesion")):
        raise InputError(f"{key}.rim = {found['rim']:g}: must be left out of a joint that bears tension or cohesion")
    if found.get("dowel") and "friction" not in found:
        raise InputError(f"{key}.dowel = {found['dowel']}: needs friction; a joint without friction never slides")
    if found.get("cohesion") and "friction" not in found:
        raise InputError(f"{key}.cohesion = {found['cohesion']:g}: needs friction; a joint without never slides")
    return JointLaw(**found)


def _joints_from(
    key: str, table: Mapping[str, Any], law: Mapping[str, Any], blocks: tuple[Solid, ...]
) -> list[SpatialJoint]:
    check_table(f"{key}.", table, _JOINT)
    upper, lower = _upper_first(key, table, blocks)
    bed = bed_from(key, {**law, **{word: table[word] for word in _LAW if word in table}})
    if "at" not in table:
        for word in _PATCH:
            if word in table:
                raise InputError(f"{key}.{word}: must be left out, or at given with it: the faces that touch are taken")
        return joints_between(blocks, upper, lower, bed, key, sides=True)
    place, frame = vector_of(f"{key}.at", table["at"], 3), _frame(key, table)
    # an inclined plane of the base
    if lower == len(blocks) and not set(_PATCH[1:]) & table.keys():
        plane = Face(place, frame, GROUND.outline)
        return joints_between(blocks, upper, lower, bed, key, sides=True, ground=plane)
    # a joint with its own position and section
    section = table.get("section", "rectangle")
    check_choice(f"{key}.section", section, tuple(_OF_SECTION))
    for word in ("width", "depth", "diameter", "bore", "outline"):
        if word in table and word not in _OF_SECTION[section]:
            known = ", ".join(_OF_SECTION[section])
            raise InputError(f"{key}.{word}: must be left out, a {section} has {known}")
    if section in ("circle", "ring"):
        diameter = _number(key, table, "diameter")
        bore = _number(key, table, "bore") if section == "ring" else 0.0
        if bore >= diameter:
            raise InputError(f"{key}.bore = {bore}: must be less than the outer diameter = {diameter} m")
        face = Face(place, frame, np.zeros((0, 2)), 0.5 * diameter, 0.5 * bore)
        return [with_rim(SpatialJoint(upper, lower, face, bed, key))]
    if section == "rectangle":
        outline = rectangle(_number(key, table, "width"), _number(key, table, "depth"))
    else:
        outline = _outline(f"{key}.outline", table)
    area, first, _ = polygon_moments(outline)
    middle = first / area
    face = Face(place + frame[:, :2] @ middle, frame, outline - middle)
    return [with_rim(SpatialJoint(upper, lower, face, bed, key))]


def _frame(key: str, table: Mapping[str, Any]) -> FloatArray:
    """Return the axes of a joint from its normal, (3, 3)."""
    normal = vector_of(f"{key}.normal", table.get("normal", [0.0, 0.0, 1.0]), 3)
    size = float(np.linalg.norm(normal))
    if not size > 0.0:
        raise InputError(f"{key}.normal = {shown(table['normal'])}: must have a length")
    return axes_of(normal / size)


def _bearings_from(key: str, table: Mapping[str, Any], blocks: tuple[Solid, ...]) -> list[SpatialJoint]:
    """Return the bearings of a table: one, or equal ones at several positions."""
    check_bearing(key, table)
    bodies, at = _upper_first(key, table, blocks), table.get("at")
    if not isinstance(at, (list, tuple)) or not at:
        raise InputError(f"{key}.at = {shown(at)}: must be a place [x, y, z] in m, or a list of them")
    several = isinstance(at[0], (list, tuple))
    places = (
        [vector_of(f"{key}.at[{k}]", part, 3) for k, part in enumerate(at)]
        if several
        else [vector_of(f"{key}.at", at, 3)]
    )
    return bearings_from(key, table, bodies, _frame(key, table), places)


def _tie_from(key: str, table: Mapping[str, Any], blocks: tuple[Solid, ...]) -> Tie:
    check_table(f"{key}.", table, _TIE)
    one, other = _pair(key, table, blocks)
    ends = []
    for word, body in (("from", one), ("to", other)):
        if word not in table:
            raise InputError(f"{key}.{word}: missing, must be a point of its block, three lengths in m")
        point = vector_of(f"{key}.{word}", table[word], 3)
        ends.append(point if body == len(blocks) else blocks[body].axes @ point)
    given = {}
    for word, (limits, meaning) in OF_TIES.items():
        if word in table:
            given["yield_" if word == "yield" else word] = check_number(f"{key}.{word}", table[word], limits, meaning)
    if "stiffness" not in given:
        raise InputError(f"{key}.stiffness: missing, must be {OF_TIES['stiffness'][1]}")
    # a tie pulls only, unless the table says otherwise
    tension_only = table.get("tension_only", True)
    if not isinstance(tension_only, bool):
        raise InputError(f"{key}.tension_only = {shown(tension_only)}: must be true or false")
    tie = Tie(one, other, ends[0], ends[1], tension_only=tension_only, **given)
    tie.check(key)
    return tie


def ports_of(data: Mapping[str, Any], blocks: tuple[Solid, ...]) -> tuple[Port, ...]:
    """Return the ports of a structure with these blocks. Raises InputError."""

    def point(key: str, value: object, body: int) -> list[float]:
        along: list[float] = (blocks[body].axes @ vector_of(key, [0.0] * 3 if value is None else value, 3)).tolist()
        return along

    return ports_from(data, [block.name for block in blocks], point)


def _upper_first(key: str, table: Mapping[str, Any], blocks: tuple[Solid, ...]) -> tuple[int, int]:
    """Return the indices of the two bodies of a table; the first must be a block."""
    upper, lower = _pair(key, table, blocks)
    if upper == len(blocks):
        raise InputError(f'{key}.between: must name the block first, then "{BASE}"')
    return upper, lower


def _pair(key: str, table: Mapping[str, Any], blocks: tuple[Solid, ...]) -> tuple[int, int]:
    """Return the indices of the two bodies of a table; the base is `len(blocks)`."""
    names = (*(block.name for block in blocks), BASE)
    pair = table.get("between")
    if not isinstance(pair, Sequence) or isinstance(pair, str) or len(pair) != 2:
        raise InputError(f"{key}.between = {shown(pair)}: must be two names of blocks, or a block and {BASE}")
    found = []
    for body in pair:
        if isinstance(body, int) and not isinstance(body, bool) and 0 <= body < len(blocks):
            found.append(body)
            continue
        check_choice(f"{key}.between", body, names)
        found.append(names.index(body))
    if found[0] == found[1]:
        raise InputError(f"{key}.between = {shown(pair)}: must be two different bodies")
    return found[0], found[1]


def _number(key: str, table: Mapping[str, Any], word: str, default: float | None = None) -> float:
    if word not in table and default is not None:
        return default
    if word not in table:
        raise InputError(f"{key}.{word}: missing, must be {NUMBERS.get(word, LENGTH)[1]}")
    return check(f"{key}.{word}", table[word])
