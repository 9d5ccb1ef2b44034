"""A structure as its TOML file describes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..common.errors import FINITE, InputError, check_number, shown
from ..common.ranges import LENGTH, MAX_BLOCKS, NUMBERS, check, check_choice, listed
from .blocks.contacts import joints_between, turned_face
from .blocks.faces import Face, FloatArray, polygon_moments
from .blocks.parts import BASE, OF_COLUMN, TOLERANCE, Bed, Joint, Solid, Tie
from .blocks.shapes import box, drum, prism, rectangle, rotation_matrix

SHAPES = ("box", "drum", "prism")
SECTIONS = ("rectangle", "circle", "ring", "polygon")
_KEYS = ("name", "g", "block", "joint", "joints", "tie", "solver")
_LAW = ("stiffness", "damping", "shear_ratio", "shear_damping", "friction", "dowel", "strength")
_OF_SHAPE = {
    "box": ("width", "depth", "height", "top_width", "top_depth"),
    "drum": ("diameter", "top_diameter", "bore", "height"),
    "prism": ("outline", "depth"),
}
_BLOCK = ("name", "shape", "on", "at", "position", "rotation", "mass", "density", "joint", "repeat")
_JOINT = ("between", "at", "normal", "section", "width", "depth", "diameter", "bore", "outline", *_LAW)
_TIE = ("between", "from", "to", "stiffness", "damping", "slack", "pretension", "tension_only", "yield")
_OWN_RANGES = {
    "shear_ratio": ((1e-6, 1e6), "a positive ratio of the modulus along the joint to that across it"),
    "shear_damping": NUMBERS["damping"],
}
_OF_TIES = {
    "stiffness": ((1e-6, 1e15), "a positive stiffness in N/m"),
    "damping": ((0.0, 1e15), "a damping in N s/m, zero or positive"),
    "slack": ((0.0, 1e6), "a length in m, zero or positive"),
    "pretension": ((0.0, 1e15), "a force in N, zero or positive"),
    "yield": ((1e-6, 1e15), "a positive force in N"),
}


def parts_from(data: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of the structure in `data` (docs/structures.md). Raises InputError for a wrong key."""
    _check_keys("", data, _KEYS)
    if "name" not in data:
        raise InputError('name: missing, must be a file name: letters, digits, "_", "-", "." and space')
    law, explicit = _joint_tables(data)
    solids = _Solids()
    joints: list[Joint] = []
    for number, table in enumerate(_tables("block", data), start=1):
        for part in _repeated(f"block[{number}]", table):
            solids.add(f"block[{number}]", part)
    blocks = tuple(solids.found)
    for upper, (key, supports) in enumerate(solids.standing):
        own = solids.laws[upper]
        for lower in supports:
            bed, below = bed_from(f"{key}.joint", {**law, **own}), len(blocks) if lower < 0 else lower
            joints += joints_between(blocks, upper, below, bed, f"{key}.on")
    for number, table in enumerate(explicit, start=1):
        joints += _joints_from(f"joint[{number}]", table, law, blocks)
    ties = tuple(_tie_from(f"tie[{e}]", table, blocks) for e, table in enumerate(_tables("tie", data, 0), start=1))
    solver = data.get("solver", {})
    _check_keys("solver.", solver, ("tolerance", "without"))
    tolerance = check("solver.tolerance", solver.get("tolerance", TOLERANCE))
    gravity = check("g", data.get("g", 9.80665))
    found = {"name": data["name"], "blocks": blocks, "joints": tuple(joints), "ties": ties, "g": gravity}
    return found | {"tolerance": tolerance, "without": tuple(solver.get("without", ()))}


def written_out(data: Mapping[str, Any]) -> dict[str, Any]:
    """The same file with one table for each block, as plain lists and dicts, so that each number has its own place."""
    tables = [part for k, table in enumerate(data["block"], start=1) for part in _repeated(f"block[{k}]", table)]
    found: dict[str, Any] = _plain({**data, "block": tables})
    return found


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(part) for part in value]
    return value.item() if isinstance(value, np.generic) else value


def _repeated(key: str, table: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The blocks of a table, each on the one before: name.1, name.2, ...; drums taper over all of them together."""
    if "repeat" not in table:
        return [table]
    count = table["repeat"]
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MAX_BLOCKS:
        raise InputError(f"{key}.repeat = {shown(count)}: must be a whole number from 1 to {MAX_BLOCKS}")
    for word, why in (("name", "the blocks count from it"), ("on", "the lowest one stands on it")):
        if not isinstance(table.get(word), str):
            raise InputError(f"{key}.{word} = {shown(table.get(word))}: must be a name beside repeat, {why}")
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


def describes_structure(data: Mapping[str, Any]) -> bool:
    """Whether a file describes a structure rather than a column: its blocks say what they stand on, or where."""
    tables = data.get("block")
    blocks = [table for table in tables if isinstance(table, Mapping)] if isinstance(tables, list) else []
    keys = {"tie", "joints", OF_COLUMN} & data.keys()
    return any({"on", "position", "shape"} & table.keys() for table in blocks) or bool(keys)


def in_space(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """The mapping of a structure: what a file holds, or around it if that is a column."""
    return data if describes_structure(data) else {OF_COLUMN: data}


class _Solids:
    """Blocks as they are read: what each stands on, and the law of the joints under it."""

    def __init__(self) -> None:
        self.found: list[Solid] = []
        self.standing: list[tuple[str, list[int]]] = []  # key of the table
        self.laws: list[Mapping[str, Any]] = []

    def add(self, key: str, table: Mapping[str, Any]) -> None:
        """Read one table."""
        shape = table.get("shape", "box")
        check_choice(f"{key}.shape", shape, SHAPES)
        _check_keys(f"{key}.", table, (*_BLOCK, *_OF_SHAPE[shape]))
        name = table.get("name", f"block{len(self.found) + 1}")
        if not isinstance(name, str) or not name:
            raise InputError(f"{key}.name = {shown(name)}: must be a word")
        if name == BASE or any(solid.name == name for solid in self.found):
            raise InputError(f"{key}.name = {shown(name)}: must be another name, it is taken")
        own = table.get("joint", {})
        _check_keys(f"{key}.joint.", own, _LAW)
        supports = self._named(key, table)
        solid = _solid_from(key, name, shape, table, self._place(key, table, supports))
        self.found.append(solid)
        self.laws.append(own)
        self.standing.append((key, supports))

    def _named(self, key: str, table: Mapping[str, Any]) -> list[int]:
        """Numbers of what a block stands on; -1 for the base until the number of blocks is known."""
        on = table.get("on", [])
        names = [solid.name for solid in self.found]
        found = []
        for name in [on] if isinstance(on, str) else on:
            check_choice(f"{key}.on", name, (BASE, *names))
            found.append(-1 if name == BASE else names.index(name))
        return found

    def _place(self, key: str, table: Mapping[str, Any], supports: list[int]) -> FloatArray:
        """The middle of the bottom face of a block, or the origin of a prism's outline, m."""
        if "position" in table:
            if "at" in table:
                raise InputError(f"{key}.at: must be left out beside position")
            return _vector(f"{key}.position", table["position"], 3)
        if not supports:
            raise InputError(f'{key}.on: missing, must be "base" or the name of a block before it; or give position')
        first = self.found[supports[0]] if supports[0] >= 0 else None
        corners = np.zeros((1, 3)) if first is None else first.corners
        top = float(np.max(corners[:, 2]))
        if "at" in table:
            return np.array([*_vector(f"{key}.at", table["at"], 2), top])
        if first is None:
            return np.zeros(3)
        level = [face for face in first.faces if face.normal[2] > 1.0 - 1e-9 and abs(face.centre[2] - top) < 1e-9]
        return level[0].centre if level else np.array([*first.centroid[:2], top])


def _solid_from(key: str, name: str, shape: str, table: Mapping[str, Any], place: FloatArray) -> Solid:
    def number(word: str, default: float | None = None) -> float:
        return _number(key, table, word, default)

    if ("mass" in table) == ("density" in table):
        raise InputError(f"{key}.density: must be given, in kg/m3, or mass in kg, one of the two")
    turn = rotation_matrix(_vector(f"{key}.rotation", table.get("rotation", [0.0, 0.0, 0.0]), 3))
    density = number("density", 1.0)
    if shape == "box":
        bottom = number("width"), number("depth")
        top = number("top_width", bottom[0]), number("top_depth", bottom[1])
        made = box(name, bottom, top, number("height"), density, place, turn)
    elif shape == "drum":
        outer = number("diameter")
        top_outer, bore = number("top_diameter", outer), table.get("bore", 0.0)
        bore = number("bore") if bore else 0.0
        if bore >= min(outer, top_outer):
            raise InputError(f"{key}.bore = {bore}: must be less than the outer diameter = {min(outer, top_outer)} m")
        made = drum(name, outer, top_outer, bore, number("height"), density, place, turn)
    else:
        made = prism(name, _outline(f"{key}.outline", table), number("depth"), density, place, turn)
    if "mass" not in table:
        return made
    factor = number("mass") / made.mass
    return Solid(name, made.mass * factor, made.centroid, made.inertia * factor, made.faces, made.axes)


def _outline(key: str, table: Mapping[str, Any]) -> FloatArray:
    """A convex polygon, anticlockwise."""
    meaning = "must be a list of at least three pairs of lengths in m, a convex polygon"
    points = table.get("outline")
    if not isinstance(points, Sequence) or len(points) < 3:
        raise InputError(f"{key} = {shown(points)}: {meaning}")
    found = np.array([_vector(key, point, 2) for point in points])
    found = found if polygon_moments(found)[0] > 0.0 else found[::-1].copy()
    side = np.roll(found, -1, axis=0) - found
    after = np.roll(side, -1, axis=0)
    if np.min(side[:, 0] * after[:, 1] - side[:, 1] * after[:, 0]) < -1e-9 * np.max(np.abs(side)) ** 2:
        raise InputError(f"{key}: is not convex, {meaning}")
    return found


def _joint_tables(data: Mapping[str, Any]) -> tuple[Mapping[str, Any], list[Mapping[str, Any]]]:
    """The law of every joint that has none of its own, and the joints that are listed."""
    given, defaults = data.get("joint", []), data.get("joints", {})
    if isinstance(given, Mapping):
        if "joints" in data:
            raise InputError("joints: must be left out beside the table joint, which says the same")
        given, defaults = [], given
    _check_keys("joint.", defaults, _LAW)
    return defaults, _tables("joint", {"joint": given}, 0)


def bed_from(key: str, table: Mapping[str, Any]) -> Bed:
    """The law of a joint from its keys. Raises InputError."""
    found: dict[str, Any] = {}
    for word in _LAW:
        if word in table:
            limits, meaning = _OWN_RANGES.get(word) or NUMBERS[word]
            found[word] = check_number(f"{key}.{word}", table[word], limits, meaning)
    for word in ("stiffness", "damping"):
        if word not in found:
            raise InputError(f"{key}.{word}: missing, must be {NUMBERS[word][1]}")
    if found.get("dowel") and "friction" not in found:
        raise InputError(f"{key}.dowel = {found['dowel']}: needs friction; a joint without friction never slides")
    return Bed(**found)


def _joints_from(key: str, table: Mapping[str, Any], law: Mapping[str, Any], blocks: tuple[Solid, ...]) -> list[Joint]:
    _check_keys(f"{key}.", table, _JOINT)
    upper, lower = _pair(key, table, blocks)
    if upper == len(blocks):
        raise InputError(f'{key}.between: must name the block first, then "{BASE}"')
    bed = bed_from(key, {**law, **{word: table[word] for word in _LAW if word in table}})
    if "at" not in table:
        return joints_between(blocks, upper, lower, bed, key, sides=True)
    normal = _vector(f"{key}.normal", table.get("normal", [0.0, 0.0, 1.0]), 3)
    size = float(np.linalg.norm(normal))
    if not size > 0.0:
        raise InputError(f"{key}.normal = {shown(table['normal'])}: must have a length")
    normal = normal / size
    place = _vector(f"{key}.at", table["at"], 3)
    across = np.column_stack([np.zeros(3), np.zeros(3), normal])
    frame = turned_face(Face(place, across, np.zeros((0, 2)), 1.0)).axes
    section = table.get("section", "rectangle")
    check_choice(f"{key}.section", section, SECTIONS)
    if section in ("circle", "ring"):
        bore = _number(key, table, "bore") if section == "ring" else 0.0
        face = Face(place, frame, np.zeros((0, 2)), 0.5 * _number(key, table, "diameter"), 0.5 * bore)
        return [Joint(upper, lower, face, bed, key)]
    if section == "rectangle":
        outline = rectangle(_number(key, table, "width"), _number(key, table, "depth"))
    else:
        outline = _outline(f"{key}.outline", table)
    area, first, _ = polygon_moments(outline)
    middle = first / area
    return [Joint(upper, lower, Face(place + frame[:, :2] @ middle, frame, outline - middle), bed, key)]


def _tie_from(key: str, table: Mapping[str, Any], blocks: tuple[Solid, ...]) -> Tie:
    _check_keys(f"{key}.", table, _TIE)
    one, other = _pair(key, table, blocks)
    ends = []
    for word, body in (("from", one), ("to", other)):
        if word not in table:
            raise InputError(f"{key}.{word}: missing, must be a point of its block, three lengths in m")
        point = _vector(f"{key}.{word}", table[word], 3)
        ends.append(point if body == len(blocks) else blocks[body].axes @ point)
    given = {}
    for word, (limits, meaning) in _OF_TIES.items():
        if word in table:
            given["yield_" if word == "yield" else word] = check_number(f"{key}.{word}", table[word], limits, meaning)
    if "stiffness" not in given:
        raise InputError(f"{key}.stiffness: missing, must be {_OF_TIES['stiffness'][1]}")
    tension_only = table.get("tension_only", True)
    if not isinstance(tension_only, bool):
        raise InputError(f"{key}.tension_only = {shown(tension_only)}: must be true or false")
    tie = Tie(one, other, ends[0], ends[1], tension_only=tension_only, **given)
    tie.check(key)
    return tie


def _pair(key: str, table: Mapping[str, Any], blocks: tuple[Solid, ...]) -> tuple[int, int]:
    """Numbers of the two bodies of a table."""
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


def _check_keys(prefix: str, table: object, known: Sequence[str]) -> None:
    if not isinstance(table, Mapping):
        raise InputError(f"{prefix.rstrip('.')} = {shown(table)}: must be a table with the keys {', '.join(known)}")
    for key in table:
        if key not in known:
            raise InputError(f"{prefix}{str(key)!r}: unknown key, must be one of {listed(known, key)}".replace("'", ""))


def _tables(key: str, data: Mapping[str, Any], least: int = 1) -> list[Mapping[str, Any]]:
    tables = data.get(key, [])
    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables) or len(tables) < least:
        raise InputError(f"{key}: must be one table [[{key}]] for each")
    return tables


def _number(key: str, table: Mapping[str, Any], word: str, default: float | None = None) -> float:
    if word not in table and default is not None:
        return default
    if word not in table:
        raise InputError(f"{key}.{word}: missing, must be {NUMBERS.get(word, LENGTH)[1]}")
    return check(f"{key}.{word}", table[word])


def _vector(key: str, value: object, count: int) -> FloatArray:
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != count:
        raise InputError(f"{key} = {shown(value)}: must be a list of {count} numbers")
    return np.array([check_number(f"{key}[{k}]", part, FINITE, "a finite number") for k, part in enumerate(value)])
