"""The column: rigid blocks, the joints under them, solver settings; their validation and their TOML form."""

from __future__ import annotations

import difflib
import os
import re
import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

from .errors import InputError, check_number, reading, shown

FORMULATIONS = ("exact", "paper")
INTEGRATORS = ("auto", "central-difference")
# what can be left out: short cuts, to check or to measure them, and the peaks of all but ux
SKIPS = ("elastic", "rest", "dashpots", "resultants", "implicit", "peaks")
MAX_BLOCKS = 1000

# What each numeric key may hold, whichever table it stands in: far beyond anything built, but so that nothing that is
# worked out of it leaves the range of float64.
_LENGTH = ((1e-6, 1e6), "a positive length in m, from 1e-6 to 1e6")
NUMBERS: dict[str, tuple[tuple[float, float], str]] = {
    "g": ((0.0, 1e6), "an acceleration in m/s2, zero or positive, at most 1e6"),
    "height": _LENGTH,
    "width": _LENGTH,
    "depth": _LENGTH,
    "mass": ((1e-9, 1e15), "a positive mass in kg, from 1e-9 to 1e15"),
    "density": ((1e-6, 1e9), "a positive density in kg/m3, from 1e-6 to 1e9"),
    "centroid": _LENGTH,
    "inertia": ((1e-21, 1e27), "a positive moment of inertia in kg m2, from 1e-21 to 1e27"),
    "stiffness": ((1e-3, 1e20), "a positive Winkler modulus in N/m3, from 1e-3 to 1e20"),
    "damping": ((0.0, 1e6), "a time in s, zero or positive, at most 1e6"),
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
    width: float | None = None  # m, contact along the motion; None: the block's
    depth: float | None = None  # m, contact across the motion; None: the block's


@dataclass(frozen=True)
class Block:
    """A rigid block and the joint under it."""

    height: float  # m
    width: float  # m, along the motion
    depth: float  # m, across the motion
    mass: float  # kg
    joint: Joint
    centroid: float | None = None  # m above the bottom face; None: height / 2
    inertia: float | None = None  # kg m2 about the centroid; None: that of a homogeneous block

    @property
    def resolved_centroid(self) -> float:
        """Height of the centroid above the bottom face, m."""
        return 0.5 * self.height if self.centroid is None else self.centroid

    @property
    def resolved_inertia(self) -> float:
        """Moment of inertia about the centroid, kg m2."""
        if self.inertia is None:
            return self.mass * (self.height * self.height + self.width * self.width) / 12.0
        return self.inertia

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
_COLUMN_KEYS = ("name", "g", "block", "joint", "solver")
_BLOCK_KEYS = ("height", "width", "depth", "mass", "density", "centroid", "inertia", "joint")
_JOINT_KEYS = tuple(item.name for item in fields(Joint))
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
        _check_settings("solver", self.settings)

    @property
    def n(self) -> int:
        """Number of blocks."""
        return len(self.blocks)

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
            _check(f"joint.{key}", value)
        blocks = tuple(
            _block_from(f"block[{number}]", table, joint_defaults)
            for number, table in enumerate(_block_tables(data), start=1)
        )
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
    for rule in BLOCK_RULES:
        name = f"{key}.joint.{rule.key}" if rule.of_joint else f"{key}.{rule.key}"
        value = _check(name, _resolved(block, rule))
        bound = getattr(block, rule.bound) if rule.bound else None
        if bound is not None and (value >= bound if rule.strict else value > bound):
            raise InputError(f"{name} = {shown(value)}: {rule.relation} = {shown(bound)} m")


def _resolved(block: Block, rule: Rule) -> object:
    """The value that a rule is about, as the block has it or as it follows from others."""
    if rule.of_joint:
        return getattr(block, f"joint_{rule.key}") if rule.optional else getattr(block.joint, rule.key)
    return getattr(block, f"resolved_{rule.key}" if rule.optional else rule.key)


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


def _block_from(key: str, table: Mapping[str, Any], joint_defaults: Mapping[str, Any]) -> Block:
    _check_keys(f"{key}.", table, _BLOCK_KEYS)
    joint_table = _table(f"{key}.joint", table, _JOINT_KEYS)
    height, width, depth = (_number(key, table, name) for name in ("height", "width", "depth"))
    if ("mass" in table) == ("density" in table):
        given = "both given" if "mass" in table else "missing"
        raise InputError(f"{key}.mass, {key}.density: {given}, must be exactly one of mass in kg and density in kg/m3")
    mass = _number(key, table, "mass") if "mass" in table else _number(key, table, "density") * height * width * depth
    optional = {name: _number(key, table, name) for name in ("centroid", "inertia") if name in table}
    return Block(height, width, depth, mass, _joint_from(f"{key}.joint", {**joint_defaults, **joint_table}), **optional)


def _joint_from(key: str, table: Mapping[str, Any]) -> Joint:
    given = {name: _number(key, table, name) for name in ("stiffness", "damping")}
    optional = {name: _number(key, table, name) for name in table if name not in given}
    return Joint(**given, **optional)


def _plain(items: list[tuple[str, Any]]) -> dict[str, Any]:
    """Make a dict of dataclass fields without those that are None, numpy's scalars as floats, names in lists."""
    plain: dict[str, Callable[[Any], Any]] = dict.fromkeys(NUMBERS, float) | {"without": list}
    return {key: plain[key](value) if key in plain else value for key, value in items if value is not None}
