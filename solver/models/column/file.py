"""The TOML file of a column: tables, keys derived from others, repeated blocks, a profile."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from ...common.errors import InputError, InputWarning, check_number, check_whole, shown
from ...common.ranges import LENGTH, MAX_BLOCKS, NUMBERS, check, check_choice, check_keys
from ...common.tables import PLACE, check_table
from ...kernels.column.sections.faces import SECTIONS
from ..ports import ports_from
from .block import BLOCK_SECTIONS, Block, Given, Joint, Load, check_block, check_depths
from .materials import MATERIALS, Material
from .settings import WITHOUT_STEP, Settings

ROUND = ("circle", "annulus")

BEYOND = 1e-3  # of the column's height, by which its blocks may reach beyond the profile without a warning
MUCH_HIGHER = 10.0  # times the column's height, limit of the profile: a broken shaft may have that of the whole one

# the keys of the tables of a TOML file
_COLUMN_KEYS = ("name", "g", "material", "block", "joint", "solver", "profile", "port")
# of a block: the fields of `Block`, and keys from which others are derived
_BLOCK_KEYS = (
    *("height", "width", "depth", "mass", "density", "centroid", "inertia", "joint", "section", "diameter"),
    *("top_width", "top_depth", "top_diameter", "bore", "tilt", "load", "repeat", "material"),
)
_JOINT_KEYS = (*(item.name for item in fields(Joint)), "diameter")
_WORDS = ("section", "strips")  # keys of a joint that are not numbers
_LOAD_KEYS = tuple(item.name for item in fields(Load))
_SETTINGS_KEYS = tuple(item.name for item in fields(Settings))

# hints in the messages about missing keys, after the range of the key
_HINTS = {"damping": "; 0 if none is meant: an undamped rocking column is chaotic and its motion cannot be predicted"}


def parts_from(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of `Column` from the mapping that `Column.from_dict` describes.

    These are name, blocks, settings, ports and, if given, g. Raises InputError on an unknown, missing or wrong key.
    """
    if has_blocks_in_space(data):
        raise InputError("is a structure in space, must be a column: Structure.from_toml and from_dict read structures")
    if "bearing" in data:
        raise InputError('bearing: needs blocks in space, with on = "base" or position: a column in its plane has none')
    if "neighbours" in data:
        raise InputError("neighbours: needs space, a column in its plane meets none: --space, Structure.from_toml")
    check_keys("", data, _COLUMN_KEYS)
    if "name" not in data:
        raise InputError('name: missing, must be a file name: letters, digits, "_", "-", "." and space')
    joint_defaults = _table("joint", data, _JOINT_KEYS)
    for key, value in joint_defaults.items():  # checked here to report the key that the user wrote
        if key not in _WORDS:
            check(f"joint.{key}", value)
    if "section" in joint_defaults:
        check_choice("joint.section", joint_defaults["section"], tuple(SECTIONS))
    if "strips" in joint_defaults:
        check_depths("joint.strips", joint_defaults["strips"])
    blocks = _blocks_from(data, joint_defaults)
    for line in _unused(data, blocks):
        warnings.warn(line, InputWarning, stacklevel=4)
    solver = _table("solver", data, _SETTINGS_KEYS)
    settings: dict[str, Any] = {
        key: _number("solver", solver, key) if key in NUMBERS else value for key, value in solver.items()
    }
    found = Settings(**settings)
    if found.formulation == "exact" and found.step != Settings.step:
        raise InputError(f"solver.step = {found.step:g}: {WITHOUT_STEP}")
    gravity = {"g": _number("", data, "g")} if "g" in data else {}
    ports = ports_from(data, names_of(len(blocks)), _point)
    return {"name": data["name"], "blocks": blocks, "settings": found, "ports": ports, **gravity}


def names_of(blocks: int) -> list[str]:
    """Return the names of the blocks, as in space: block1 is the top one."""
    return [f"block{number}" for number in range(1, blocks + 1)]


def _point(key: str, value: object, body: int) -> list[float]:
    """Return a point in the plane, from [x, z], or [x, 0, z] as in a structure."""
    at = [0.0, 0.0] if value is None else value
    if isinstance(at, (list, tuple)) and len(at) == 3 and at[1] == 0:
        at = [at[0], at[2]]
    if not isinstance(at, (list, tuple)) or len(at) != 2:
        raise InputError(f"{key} = {shown(value)}: must be [x, z] in m, from the centroid in the plane of the column")
    return [check_number(f"{key}[{k}]", part, *PLACE) for k, part in enumerate(at)]


def has_blocks_in_space(data: Mapping[str, Any]) -> bool:
    """Return True if a block has a position, a shape or the block that it stands on, as in a structure."""
    tables = data.get("block")
    blocks = [table for table in tables if isinstance(table, Mapping)] if isinstance(tables, list) else []
    return any({"on", "position", "shape"} & table.keys() for table in blocks)


def _table(key: str, data: Mapping[str, Any], known: Sequence[str]) -> Mapping[str, Any]:
    """Return the optional table under the last part of `key`, empty if absent.

    Raises InputError if it has keys that are not `known`.
    """
    table: Mapping[str, Any] = data.get(key.rpartition(".")[2], {})
    check_table(f"{key}.", table, known)
    return table


def _number(prefix: str, table: Mapping[str, Any], name: str) -> float:
    key = f"{prefix}.{name}" if prefix else name
    if name not in table:
        raise InputError(f"{key}: missing, must be {NUMBERS[name][1]}{_HINTS.get(name, '')}")
    return check(key, table[name])


def _block_tables(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    tables = data.get("block")
    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables):
        given = "missing" if tables is None else "is not an array of tables"
        raise InputError(f"block: {given}, must be one table [[block]] for each block, from the top down")
    return tables


def _blocks_from(data: Mapping[str, Any], joint_defaults: Mapping[str, Any]) -> tuple[Block, ...]:
    """Return the blocks of the tables, repeated as the tables say; missing diameters are taken from the profile."""
    tables: list[tuple[str, Mapping[str, Any]]] = []
    for number, table in enumerate(_block_tables(data), start=1):
        key, times = f"block[{number}]", table.get("repeat", 1)
        check_keys(f"{key}.", table, _BLOCK_KEYS)
        meaning = f"a whole number from 1 to {MAX_BLOCKS}"
        tables += [(key, table)] * check_whole(f"{key}.repeat", times, 1, MAX_BLOCKS, meaning)
    profile, usual = _profile_from(data), _material("material", data)
    blocks: list[Block] = []
    foot = 0.0  # height of the bottom face above the base
    for key, table in reversed(tables):
        given = dict(table)
        if profile and _takes_profile(table):
            height = _number(key, table, "height")
            if "top_diameter" in table:
                raise InputError(
                    f"{key}.top_diameter: must be left out, or given with diameter: else profile gives both"
                )
            given["diameter"], given["top_diameter"] = np.interp([foot, foot + height], *profile).tolist()
        material = _material(f"{key}.material", table) or usual
        blocks.append(_block_from(key, given, joint_defaults, material))
        foot += blocks[-1].height
    return tuple(reversed(blocks))


def _material(key: str, table: Mapping[str, Any]) -> Material | None:
    """Return the material that a table names, or None."""
    if "material" not in table:
        return None
    check_choice(key, table["material"], tuple(MATERIALS))
    return MATERIALS[table["material"]]


def _takes_profile(table: Mapping[str, Any]) -> bool:
    return table.get("section") in ROUND and not {"diameter", "width", "depth"} & table.keys()


def _unused(data: Mapping[str, Any], blocks: tuple[Block, ...]) -> list[str]:
    """Return a line for each value that is given but used by no block."""
    lines, tables = [], _block_tables(data)
    for name in data.get("joint", ()):
        if all(name in table.get("joint", ()) for table in tables):
            lines.append(f"joint.{name}: no block uses it, each has a joint.{name} of its own")
    if "profile" not in data:
        return lines
    begin, top, height = data["profile"][0][0], data["profile"][-1][0], sum(block.height for block in blocks)
    # the heights of the blocks that take their diameters from it
    each = [table for table in tables for _ in range(table.get("repeat", 1))]
    tops = np.cumsum([block.height for block in reversed(blocks)])[::-1].tolist()
    taken = [
        (top - block.height, top) for table, block, top in zip(each, blocks, tops, strict=True) if _takes_profile(table)
    ]
    if not taken:
        lines.append('profile: no block uses it; a block does that has section = "circle" or "annulus" and no diameter')
    elif top > MUCH_HIGHER * height:
        lines.append(f"profile: reaches up to {top:g} m, the column to {height:g} m; heights and diameters are in m")
    elif max(begin - taken[-1][0], taken[0][1] - top) > BEYOND * height:
        lines.append(
            f"profile: reaches from {begin:g} to {top:g} m, its blocks from {taken[-1][0]:g} to {taken[0][1]:g} m; "
            "beyond it their diameters are constant"
        )
    return lines


def _profile_from(data: Mapping[str, Any]) -> tuple[list[float], list[float]] | None:
    """Return the heights above the base and the diameters of the profile (m), or None."""
    if "profile" not in data:
        return None
    points = data["profile"]
    meaning = "must be a list of at least two pairs [height above the base, diameter] in m, from the bottom up"
    if not isinstance(points, list) or len(points) < 2:
        raise InputError(f"profile = {shown(points)}: {meaning}")
    heights, diameters = [], []
    for k, point in enumerate(points):
        if not isinstance(point, list) or len(point) != 2:
            raise InputError(f"profile[{k}] = {shown(point)}: {meaning}")
        heights.append(check_number(f"profile[{k}][0]", point[0], (0.0, 1e6), "a height in m, from 0 to 1e6"))
        diameters.append(check_number(f"profile[{k}][1]", point[1], *LENGTH))
        if k and not heights[k - 1] < heights[k]:
            raise InputError(f"profile[{k}][0] = {shown(point[0])}: must be above {shown(heights[k - 1])} m")

    return heights, diameters


def _block_from(
    key: str, table: Mapping[str, Any], joint_defaults: Mapping[str, Any], material: Material | None
) -> Block:
    """Return a block and the joint under it; the material gives missing density, stiffness and strength."""
    joint_table = _table(f"{key}.joint", table, _JOINT_KEYS)
    shape: dict[str, Any] = {"height": _number(key, table, "height"), "section": table.get("section", "rectangle")}
    check_choice(f"{key}.section", shape["section"], BLOCK_SECTIONS)
    shape |= _faces_from(key, table, shape["section"])
    # the material gives the values that the tables leave out
    if material is not None:
        if "mass" not in table:
            table = {"density": material.density, **table}
        usual = {"stiffness": material.modulus(shape["height"]), "strength": material.strength}
        joint_defaults = usual | dict(joint_defaults)
    if ("mass" in table) == ("density" in table):
        given = "both given" if "mass" in table else "missing"
        raise InputError(f"{key}.mass, {key}.density: {given}, must be exactly one of mass in kg and density in kg/m3")
    joint = _joint_from(f"{key}.joint", {**joint_defaults, **joint_table}, shape["section"])
    shape |= {"tilt": _number(key, table, "tilt")} if "tilt" in table else {}
    numbers = {name: _number(key, table, name) for name in ("centroid", "inertia", "mass", "density") if name in table}
    body = Given(**numbers, load=_load_from(f"{key}.load", table))
    block = Block(mass=body.mass or 1.0, joint=joint, **shape)
    if body.density is not None and not block.is_cuboid:  # the volume needs a valid shape
        check_block(key, block)
    block = block.derived(body)
    return block if body.density or body.load else replace(block, given=None)


def _faces_from(key: str, table: Mapping[str, Any], section: str) -> dict[str, float]:
    """Return width and depth of the bottom face, and those of the top face and the bore if given."""
    if section not in ROUND:
        for name in ("diameter", "top_diameter"):
            if name in table:
                raise InputError(f'{key}.{name}: must be left out, or section = "circle" or "annulus"')
        names = ["width", "depth", *(name for name in ("top_width", "top_depth", "bore") if name in table)]
        return {name: _number(key, table, name) for name in names}
    found: dict[str, float] = {}
    for name, width, depth in (("diameter", "width", "depth"), ("top_diameter", "top_width", "top_depth")):
        if width in table or depth in table:  # `to_dict` writes both
            if not {width, depth} <= table.keys():
                given = width if width in table else depth
                raise InputError(f"{key}.{given}: must be left out, give {name}: a round block has no {given}")
            if name in table:
                raise InputError(f"{key}.{name}: given beside {width} or {depth}, must be alone")
            found |= {width: _number(key, table, width), depth: _number(key, table, depth)}
            if found[width] != found[depth]:
                raise InputError(f"{key}.{depth} = {shown(found[depth])}: must be the {width} of a round block")
        elif name in table or name == "diameter":
            found[width] = found[depth] = _number(key, table, name)
    if "bore" in table:
        found["bore"] = _number(key, table, "bore")
    return found


def _load_from(key: str, table: Mapping[str, Any]) -> Load | None:
    """Return the load that rests on a block, or None."""
    if "load" not in table:
        return None
    check_table(f"{key}.", table["load"], _LOAD_KEYS)
    above = {"above": _number(key, table["load"], "above")} if "above" in table["load"] else {}
    return Load(_number(key, table["load"], "mass"), **above)


def _joint_from(key: str, table: Mapping[str, Any], section: str) -> Joint:
    given: dict[str, Any] = {name: _number(key, table, name) for name in ("stiffness", "damping")}
    words = {name: table[name] for name in _WORDS if name in table}
    is_round = words.get("section", section) in ROUND
    if is_round and "depth" in table:
        raise InputError(f"{key}.depth: must be left out, a round contact has a diameter")
    if "diameter" in table and (not is_round or "width" in table):
        raise InputError(f"{key}.diameter: must be left out, or alone in a contact that is a circle or an annulus")
    rest = [name for name in table if name not in (*given, *_WORDS)]
    given |= {("width" if name == "diameter" else name): _number(key, table, name) for name in rest}
    return Joint(**given, **words)


def plain(items: list[tuple[str, Any]]) -> dict[str, Any]:
    """Make a dict of dataclass fields, without None, with NumPy scalars as floats and tuples of names as lists."""
    plain: dict[str, Callable[[Any], Any]] = dict.fromkeys(NUMBERS, float) | {"without": list}
    return {key: plain[key](value) if key in plain else value for key, value in items if value is not None}
