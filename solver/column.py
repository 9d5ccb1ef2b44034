"""The column: rigid blocks, the joints under them, solver settings; their validation and their TOML form."""

from __future__ import annotations

import difflib
import os
import re
import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

import numpy as np

from .errors import InputError, check_number, reading, shown
from .kernels.joint.section import ANNULUS, RECTANGLE, SECTIONS, STRIPS, whole
from .kernels.layout import MOST_STRIPS
from .solids import Solid, solid_between, with_load

FORMULATIONS = ("exact", "paper")
INTEGRATORS = ("auto", "central-difference")
# what can be left out: short cuts, to check or to measure them, and the peaks of all but ux
SKIPS = ("elastic", "rest", "dashpots", "resultants", "implicit", "peaks")
MAX_BLOCKS = 1000
BLOCK_SECTIONS = tuple(name for name in SECTIONS if name != "strips")  # strips are of contacts only
ROUND = ("circle", "annulus")

# What each numeric key may hold, whichever table it stands in: far beyond anything built, but so that nothing that is
# worked out of it leaves the range of float64.
_LENGTH = ((1e-6, 1e6), "a positive length in m, from 1e-6 to 1e6")
NUMBERS: dict[str, tuple[tuple[float, float], str]] = {
    "g": ((0.0, 1e6), "an acceleration in m/s2, zero or positive, at most 1e6"),
    "height": _LENGTH,
    "width": _LENGTH,
    "depth": _LENGTH,
    "top_width": _LENGTH,
    "top_depth": _LENGTH,
    "diameter": _LENGTH,
    "top_diameter": _LENGTH,
    "bore": _LENGTH,
    "above": ((0.0, 1e6), "a height in m, zero or positive, at most 1e6"),
    "mass": ((1e-9, 1e15), "a positive mass in kg, from 1e-9 to 1e15"),
    "density": ((1e-6, 1e9), "a positive density in kg/m3, from 1e-6 to 1e9"),
    "centroid": _LENGTH,
    "inertia": ((1e-21, 1e27), "a positive moment of inertia in kg m2, from 1e-21 to 1e27"),
    "stiffness": ((1e-3, 1e20), "a positive Winkler modulus in N/m3, from 1e-3 to 1e20"),
    "damping": ((0.0, 1e6), "a time in s, zero or positive, at most 1e6"),
    "friction": ((1e-6, 1e3), "a positive coefficient of friction, at most 1e3; without it the joint never slides"),
    "dowel": ((0.0, 1e15), "a force in N, zero or positive, at most 1e15"),
    "step": ((1e-9, 1e6), "a positive time in s, from 1e-9 to 1e6"),
    "tolerance": ((1e-13, 0.1), "a number from 1e-13 to 0.1"),
}


# what the absence of a key is answered by, beside what the key may hold
_HINTS = {"damping": "; 0 if none is meant: an undamped rocking column is chaotic and nobody predicts its motion"}


@dataclass(frozen=True)
class Joint:
    """The no-tension elastic joint under a block."""

    stiffness: float  # N/m3, Winkler modulus: pressure per penetration
    damping: float  # s, eta of the Kelvin-Voigt law; 0 is none, which makes a rocking column chaotic
    width: float | None = None  # m, contact along the motion, the diameter of a round one; None: the block's
    depth: float | None = None  # m, contact across the motion, not of a round one; None: the block's
    section: str | None = None  # of the contact, one of SECTIONS; None: the block's
    bore: float | None = None  # m, inner diameter of an annulus; None: the block's
    strips: tuple[float, ...] | None = None  # m, depths of equal strips from -x to +x, 0 where nothing touches
    friction: float | None = None  # Coulomb's coefficient; None: the joint never slides
    dowel: float | None = None  # N, shear that the joint bears beside friction, and goes on bearing as it slides

    def __post_init__(self) -> None:
        if isinstance(self.strips, list):  # as TOML and JSON have it
            object.__setattr__(self, "strips", tuple(self.strips))


@dataclass(frozen=True)
class Block:
    """A rigid block and the joint under it."""

    height: float  # m
    width: float  # m, along the motion, of the bottom face; the diameter of a round block
    depth: float  # m, across the motion
    mass: float  # kg
    joint: Joint
    centroid: float | None = None  # m above the bottom face; None: that of a homogeneous block
    inertia: float | None = None  # kg m2 about the centroid; None: that of a homogeneous block
    section: str = "rectangle"  # one of BLOCK_SECTIONS
    top_width: float | None = None  # m, of the top face of a block that tapers; None: that of the bottom face
    top_depth: float | None = None
    bore: float | None = None  # m, inner diameter of a hollow drum, section annulus

    @property
    def solid(self) -> Solid:
        """Volume, centroid and inertia of the block if it is homogeneous and of density 1 kg/m3."""
        bottom = (self.width, self.depth)
        top = (self.top_width or self.width, self.top_depth or self.depth)
        return solid_between(SECTIONS.index(self.section), self.height, bottom, top, self.bore or 0.0)

    @property
    def is_cuboid(self) -> bool:
        """Whether the block is a rectangle all the way up."""
        return self.section == "rectangle" and self.top_width is None and self.top_depth is None

    @property
    def resolved_centroid(self) -> float:
        """Height of the centroid above the bottom face, m."""
        if self.centroid is None:
            return 0.5 * self.height if self.is_cuboid else self.solid.centroid
        return self.centroid

    @property
    def resolved_inertia(self) -> float:
        """Moment of inertia about the centroid, kg m2."""
        if self.inertia is not None:
            return self.inertia
        if self.is_cuboid:
            return self.mass * (self.height * self.height + self.width * self.width) / 12.0
        solid = self.solid
        return self.mass / solid.volume * solid.inertia

    def written_out(self) -> Block:
        """The block with its centroid and inertia as numbers, where they are not those of a cuboid."""
        if self.is_cuboid:
            return self
        return replace(self, centroid=self.resolved_centroid, inertia=self.resolved_inertia)

    @property
    def joint_section(self) -> int:
        """Code of the section of the contact under the block."""
        return SECTIONS.index(self.joint.section or self.section)

    @property
    def joint_bore(self) -> float:
        """Inner diameter of the contact under the block, m; 0 where it is not an annulus."""
        return (self.joint.bore or self.bore or 0.0) if self.joint_section == ANNULUS else 0.0

    @property
    def joint_moments(self) -> tuple[float, ...]:
        """Area m2 and first and second moment (m3, m4), about the middle of the block, of the contact under it."""
        strips = self.joint.strips or ()
        return whole(self.joint_section, self.joint_width, self.joint_depth, self.joint_bore, strips)

    @property
    def joint_stiffness(self) -> float:
        """Stiffness of the joint under the block in full contact, N/m."""
        if self.joint_section == RECTANGLE:
            return self.joint.stiffness * self.joint_width * self.joint_depth
        return self.joint.stiffness * self.joint_moments[0]

    @property
    def joint_width(self) -> float:
        """Width of the contact under the block, m."""
        return self.width if self.joint.width is None else self.joint.width

    @property
    def joint_depth(self) -> float:
        """Depth of the contact under the block, m."""
        return self.depth if self.joint.depth is None else self.joint.depth


@dataclass(frozen=True)
class Settings:
    """How the equations are written and integrated."""

    formulation: str = "exact"  # one of FORMULATIONS
    integrator: str = "auto"  # one of INTEGRATORS
    step: float = 1e-4  # s, of an integrator with a fixed step
    tolerance: float = 1e-5  # relative error of an integrator that chooses its steps
    without: tuple[str, ...] = ()  # of SKIPS: what is not to be done

    def __post_init__(self) -> None:
        if isinstance(self.without, list):  # as TOML and JSON have it
            object.__setattr__(self, "without", tuple(self.without))


# the keys of the tables of a TOML file
_COLUMN_KEYS = ("name", "g", "block", "joint", "solver", "profile")
# of a block: those of `Block`, and those that others follow from
_BLOCK_KEYS = (
    *("height", "width", "depth", "mass", "density", "centroid", "inertia", "joint", "section", "diameter"),
    *("top_width", "top_depth", "top_diameter", "bore", "load", "repeat"),
)
_JOINT_KEYS = (*(item.name for item in fields(Joint)), "diameter")
_WORDS = ("section", "strips")  # keys of a joint that are no number
_LOAD_KEYS = ("mass", "above")  # of what rests on a block: kg, and m of its centroid above the top face
_SETTINGS_KEYS = tuple(item.name for item in fields(Settings))


@dataclass(frozen=True)
class Column:
    """Superimposed rigid blocks, listed from the TOP down; the last joint rests on the base.

    Raises InputError on a value out of range, however the column was made; keys count blocks from 1, the top one.
    """

    name: str  # a C identifier: it becomes the FMU's model identifier
    blocks: tuple[Block, ...]
    settings: Settings = field(default_factory=Settings)
    g: float = 9.80665  # m/s2

    def __post_init__(self) -> None:
        object.__setattr__(self, "blocks", tuple(self.blocks))
        _check_name(self.name)
        _check("g", self.g)
        if not 1 <= len(self.blocks) <= MAX_BLOCKS:
            raise InputError(f"block: {len(self.blocks)} blocks, must be 1 to {MAX_BLOCKS}")
        for number, block in enumerate(self.blocks, start=1):
            _check_block(f"block[{number}]", block)
            _check_friction(f"block[{number}].joint", block.joint)
        _check_settings("solver", self.settings)
        if self.slides:
            _check_sliding(self)

    @property
    def n(self) -> int:
        """Number of blocks."""
        return len(self.blocks)

    @property
    def has_rectangles_only(self) -> bool:
        """Whether all joints are rectangles, the one section that lanes know."""
        return all(block.joint_section == RECTANGLE for block in self.blocks)

    def with_settings(
        self,
        *,
        formulation: str | None = None,
        integrator: str | None = None,
        step: float | None = None,
        tolerance: float | None = None,
        without: Sequence[str] | None = None,
    ) -> Column:
        """Return a copy with other settings; None keeps the present one. Raises InputError as `Column` does."""
        given = {
            "formulation": formulation,
            "integrator": integrator,
            "step": step,
            "tolerance": tolerance,
            "without": without,
        }
        changes: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
        return replace(self, settings=replace(self.settings, **changes))

    @property
    def slides(self) -> bool:
        """Whether some joint may slide."""
        return any(block.joint.friction is not None for block in self.blocks)

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Column:
        """Read a column from a TOML file; its keys are those of `from_dict`.

        Raises InputError that begins with `path` if the file cannot be read, is not TOML or is wrong in any key.
        """
        with reading(path), open(path, "rb") as file:
            return cls.from_dict(tomllib.load(file))

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Column:
        """Build a column from the mapping that the TOML file holds.

        name, g (optional), block: one table for each block from the top down with height, width, depth, mass or
        density, centroid and inertia (optional) and the table joint; joint (optional): defaults for all joints;
        solver (optional): the fields of Settings. Units as in `Block`, `Joint` and `Settings`; density in kg/m3.

        Raises InputError on an unknown, missing or wrong key.
        """
        _check_keys("", data, _COLUMN_KEYS)
        if "name" not in data:
            raise InputError("name: missing, must be a C identifier")
        joint_defaults = _table("joint", data, _JOINT_KEYS)
        for key, value in joint_defaults.items():  # checked here, where the user wrote them
            if key not in _WORDS:
                _check(f"joint.{key}", value)
        blocks = _blocks_from(data, joint_defaults)
        solver = _table("solver", data, _SETTINGS_KEYS)
        settings: dict[str, Any] = {
            key: _number("solver", solver, key) if key in NUMBERS else value for key, value in solver.items()
        }
        gravity = {"g": _number("", data, "g")} if "g" in data else {}
        return cls(data["name"], blocks, Settings(**settings), **gravity)

    def to_dict(self) -> dict[str, Any]:
        """Return the mapping that `from_dict` turns into this very column: plain numbers, strings, lists and dicts.

        Values left to their defaults are written out, except those that follow from other values (None) which stay
        absent.
        """
        data = asdict(self, dict_factory=_plain)
        return {"name": data["name"], "g": data["g"], "block": list(data["blocks"]), "solver": data["settings"]}


# checks of a finished column


def _check(key: str, value: object) -> float:
    """Return `value` as a float if it suits the last part of `key`."""
    limits, meaning = NUMBERS[key.rpartition(".")[2]]
    return check_number(key, value, limits, meaning)


def _check_name(name: object) -> None:
    if not isinstance(name, str) or not re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", name):
        raise InputError(
            f"name = {shown(name)}: must be a C identifier (letters, digits and _, no digit first): "
            "it becomes the FMU's model identifier"
        )


@dataclass(frozen=True)
class Rule:
    """What a number of a block, or of its joint, is held to beside the range of its key in NUMBERS."""

    key: str
    of_joint: bool = False
    optional: bool = False  # follows from others where it is not given
    bound: str = ""  # key of the block that it may not exceed, or with `strict` not reach
    strict: bool = False
    relation: str = ""


# in the order in which they are checked
BLOCK_RULES = (
    *(Rule(key) for key in ("height", "width", "depth", "mass")),
    Rule("centroid", False, True, "height", True, "must lie below the top face, height"),
    Rule("inertia", optional=True),
    Rule("stiffness", True),
    Rule("damping", True),
    *(Rule(key, True, True, key, False, f"must not exceed the block's {key}") for key in ("width", "depth")),
)


def _check_block(key: str, block: object) -> None:
    if not isinstance(block, Block):
        raise InputError(f"{key} = {shown(block)}: must be a Block")
    if not isinstance(block.joint, Joint):
        raise InputError(f"{key}.joint = {shown(block.joint)}: must be a Joint")
    _check_section(key, block)
    sizes = tuple(rule for rule in BLOCK_RULES if not (rule.of_joint or rule.optional))
    _check_rules(key, block, sizes)
    if block.section == "annulus" and block.bore is None:
        raise InputError(f"{key}.bore: missing, must be {NUMBERS['bore'][1]}: the inner diameter")
    narrowest = min(block.width, block.top_width or block.width)
    _check_bore(key, block.bore, block.section, narrowest)
    _check_rules(key, block, tuple(rule for rule in BLOCK_RULES if rule not in sizes))
    _check_bore(f"{key}.joint", block.joint.bore, SECTIONS[block.joint_section], block.joint_width)
    if block.joint_section == ANNULUS and not 0.0 < block.joint_bore < block.joint_width:
        raise InputError(f"{key}.joint.bore: must be an inner diameter in m, less than {shown(block.joint_width)} m")
    _check_strips(f"{key}.joint.strips", block)


def _check_rules(key: str, block: Block, rules: Sequence[Rule]) -> None:
    for rule in rules:
        name = f"{key}.joint.{rule.key}" if rule.of_joint else f"{key}.{rule.key}"
        value = _check(name, _resolved(block, rule))
        bound = getattr(block, rule.bound) if rule.bound else None
        if bound is not None and (value >= bound if rule.strict else value > bound):
            raise InputError(f"{name} = {shown(value)}: {rule.relation} = {shown(bound)} m")


def _check_bore(owner: str, bore: float | None, section: str, width: float) -> None:
    if bore is not None and section != "annulus":
        raise InputError(f'{owner}.bore = {shown(bore)}: must be left out, or section = "annulus"')
    if bore is not None and bore >= width:
        raise InputError(f"{owner}.bore = {shown(bore)}: must be less than the outer diameter = {shown(width)} m")


def _check_section(key: str, block: Block) -> None:
    """That names of sections are known, and that what goes with them are numbers."""
    _check_choice(f"{key}.section", block.section, BLOCK_SECTIONS)
    if block.joint.section is not None:
        _check_choice(f"{key}.joint.section", block.joint.section, SECTIONS)
    numbers = {f"{key}.{name}": getattr(block, name) for name in ("top_width", "top_depth", "bore")}
    for name, value in (numbers | {f"{key}.joint.bore": block.joint.bore}).items():
        if value is not None:
            _check(name, value)


def _check_strips(key: str, block: Block) -> None:
    strips = block.joint.strips
    if block.joint_section != STRIPS:
        if strips is not None:
            raise InputError(f'{key} = {shown(strips)}: must be left out, or section = "strips"')
        return
    if not isinstance(strips, tuple) or not 1 <= len(strips) <= MOST_STRIPS:
        raise InputError(f"{key} = {shown(strips)}: must be a list of 1 to {MOST_STRIPS} depths in m")
    meaning = f"a depth in m, from 0 to that of the block, {shown(block.depth)}"
    for k, depth in enumerate(strips):
        check_number(f"{key}[{k}]", depth, (0.0, block.depth), meaning)
    if not any(strips):
        raise InputError(f"{key}: all zero, must have a depth somewhere")
    if strips != strips[::-1]:
        raise InputError(f"{key}: must be the same read backwards: the rest of a column is upright")


def _resolved(block: Block, rule: Rule) -> object:
    """The value that a rule is about, as the block has it or as it follows from others."""
    if rule.of_joint:
        return getattr(block, f"joint_{rule.key}") if rule.optional else getattr(block.joint, rule.key)
    return getattr(block, f"resolved_{rule.key}" if rule.optional else rule.key)


def _check_friction(key: str, joint: Joint) -> None:
    for name in ("friction", "dowel"):
        if getattr(joint, name) is not None:
            _check(f"{key}.{name}", getattr(joint, name))
    if joint.dowel is not None and joint.friction is None:
        raise InputError(f"{key}.dowel = {joint.dowel:g}: needs friction; a joint without friction never slides")


def _check_sliding(column: Column) -> None:
    """What cannot be had of a column whose joints slide."""
    number = 1 + next(i for i, block in enumerate(column.blocks) if block.joint.friction is not None)
    key = f"block[{number}].joint.friction = {column.blocks[number - 1].joint.friction:g}"
    if column.settings.formulation == "paper":
        raise InputError(f'{key}: the formulation "paper" knows no joint that slides, must be "exact"')
    if column.settings.integrator != "auto":
        raise InputError(f'{key}: steps of a fixed length miss where a joint slides, solver.integrator must be "auto"')


def _check_settings(key: str, settings: object) -> None:
    if not isinstance(settings, Settings):
        raise InputError(f"{key} = {shown(settings)}: must be Settings")
    _check_choice(f"{key}.formulation", settings.formulation, FORMULATIONS)
    _check_choice(f"{key}.integrator", settings.integrator, INTEGRATORS)
    _check(f"{key}.step", settings.step)
    _check(f"{key}.tolerance", settings.tolerance)
    if not isinstance(settings.without, tuple):
        raise InputError(f"{key}.without = {shown(settings.without)}: must be a list of names of {', '.join(SKIPS)}")
    for name in settings.without:
        _check_choice(f"{key}.without", name, SKIPS)


def _check_choice(key: str, value: object, known: Collection[str]) -> None:
    if not isinstance(value, str) or value not in known:
        raise InputError(f"{key} = {shown(value)}: must be one of {_listed(known, value)}")


def _listed(known: Collection[str], value: object) -> str:
    """Return the known names and, if one is near enough to `value`, which one is probably meant."""
    near = difflib.get_close_matches(str(value).lower(), known, n=1, cutoff=0.5)
    return ", ".join(known) + (f"; did you mean {near[0]}?" if near else "")


# from and to the mapping


def _check_keys(prefix: str, table: Mapping[str, Any], known: Collection[str]) -> None:
    for key in table:
        if key not in known:
            written = repr(key).strip("'\"")  # a quoted key of TOML may hold anything, even a line break
            raise InputError(f"{prefix}{written}: unknown key, must be one of {_listed(known, key)}")


def _table(key: str, data: Mapping[str, Any], known: Collection[str]) -> Mapping[str, Any]:
    """Return the optional table under the last part of `key`, empty if absent, with nothing but `known` keys."""
    table = data.get(key.rpartition(".")[2], {})
    if not isinstance(table, Mapping):
        raise InputError(f"{key} = {shown(table)}: must be a table with the keys {', '.join(known)}")
    _check_keys(f"{key}.", table, known)
    return table


def _number(prefix: str, table: Mapping[str, Any], name: str) -> float:
    key = f"{prefix}.{name}" if prefix else name
    if name not in table:
        raise InputError(f"{key}: missing, must be {NUMBERS[name][1]}{_HINTS.get(name, '')}")
    return _check(key, table[name])


def _block_tables(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    tables = data.get("block")
    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables):
        given = "missing" if tables is None else "is not an array of tables"
        raise InputError(f"block: {given}, must be one table [[block]] for each block, from the top down")
    return tables


def _blocks_from(data: Mapping[str, Any], joint_defaults: Mapping[str, Any]) -> tuple[Block, ...]:
    """The blocks of the tables, those repeated as often as they ask for; what they miss is taken from the profile."""
    tables: list[tuple[str, Mapping[str, Any]]] = []
    for number, table in enumerate(_block_tables(data), start=1):
        key, times = f"block[{number}]", table.get("repeat", 1)
        _check_keys(f"{key}.", table, _BLOCK_KEYS)
        if isinstance(times, bool) or not isinstance(times, int) or not 1 <= times <= MAX_BLOCKS:
            raise InputError(f"{key}.repeat = {shown(times)}: must be a whole number from 1 to {MAX_BLOCKS}")
        tables += [(key, table)] * times
    profile = _profile_from(data)
    blocks: list[Block] = []
    foot = 0.0  # height of the bottom face above the base
    for key, table in reversed(tables):
        given = dict(table)
        if profile and table.get("section") in ROUND and not {"diameter", "width", "depth"} & table.keys():
            height = _number(key, table, "height")
            given["diameter"], given["top_diameter"] = np.interp([foot, foot + height], *profile).tolist()
        blocks.append(_block_from(key, given, joint_defaults))
        foot += blocks[-1].height
    return tuple(reversed(blocks))


def _profile_from(data: Mapping[str, Any]) -> tuple[list[float], list[float]] | None:
    """Heights above the base and diameters there, m."""
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
        diameters.append(check_number(f"profile[{k}][1]", point[1], *_LENGTH))
        if k and not heights[k - 1] < heights[k]:
            raise InputError(f"profile[{k}][0] = {shown(point[0])}: must be above {shown(heights[k - 1])} m")

    return heights, diameters


def _block_from(key: str, table: Mapping[str, Any], joint_defaults: Mapping[str, Any]) -> Block:
    joint_table = _table(f"{key}.joint", table, _JOINT_KEYS)
    shape: dict[str, Any] = {"height": _number(key, table, "height"), "section": table.get("section", "rectangle")}
    _check_choice(f"{key}.section", shape["section"], BLOCK_SECTIONS)
    shape |= _faces_from(key, table, shape["section"])
    if ("mass" in table) == ("density" in table):
        given = "both given" if "mass" in table else "missing"
        raise InputError(f"{key}.mass, {key}.density: {given}, must be exactly one of mass in kg and density in kg/m3")
    joint = _joint_from(f"{key}.joint", {**joint_defaults, **joint_table}, shape["section"])
    shape |= {name: _number(key, table, name) for name in ("centroid", "inertia") if name in table}
    block = Block(mass=_number(key, table, "mass") if "mass" in table else 1.0, joint=joint, **shape)
    if "density" in table:
        if not block.is_cuboid:
            _check_block(key, block)
        volume = block.height * block.width * block.depth if block.is_cuboid else block.solid.volume
        block = replace(block, mass=_number(key, table, "density") * volume)
    return _loaded(key, table, block) if "load" in table else block


def _faces_from(key: str, table: Mapping[str, Any], section: str) -> dict[str, float]:
    """Width and depth of the bottom face, and of the top face and the bore where they are given."""
    if section not in ROUND:
        for name in ("diameter", "top_diameter"):
            if name in table:
                raise InputError(f'{key}.{name}: must be left out, or section = "circle" or "annulus"')
        names = ["width", "depth", *(name for name in ("top_width", "top_depth", "bore") if name in table)]
        return {name: _number(key, table, name) for name in names}
    found: dict[str, float] = {}
    for name, width, depth in (("diameter", "width", "depth"), ("top_diameter", "top_width", "top_depth")):
        if width in table or depth in table:  # as `to_dict` writes them
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


def _loaded(key: str, table: Mapping[str, Any], block: Block) -> Block:
    """The block with a load that rests on it and turns with it."""
    load = table["load"]
    if not isinstance(load, Mapping):
        raise InputError(f"{key}.load = {shown(load)}: must be a table with the keys {', '.join(_LOAD_KEYS)}")
    _check_keys(f"{key}.load.", load, _LOAD_KEYS)
    above = _number(f"{key}.load", load, "above") if "above" in load else 0.0
    mass, centroid, inertia = with_load(
        block.mass,
        block.resolved_centroid,
        block.resolved_inertia,
        _number(f"{key}.load", load, "mass"),
        block.height + above,
    )
    return replace(block, mass=mass, centroid=centroid, inertia=inertia)


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


def _plain(items: list[tuple[str, Any]]) -> dict[str, Any]:
    """Make a dict of dataclass fields without those that are None, numpy's scalars as floats, names in lists."""
    plain: dict[str, Callable[[Any], Any]] = dict.fromkeys(NUMBERS, float) | {"without": list}
    return {key: plain[key](value) if key in plain else value for key, value in items if value is not None}
