"""The column: rigid blocks one upon another, and how their equations are solved."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

from . import ranges
from .block import Block, Joint, check_block, check_friction
from .column_file import parts_from, plain
from .errors import InputError, reading, shown
from .kernels.joint.section import RECTANGLE, STRIPS
from .settings import Settings, check_settings


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
        ranges.check("g", self.g)
        if not 1 <= len(self.blocks) <= ranges.MAX_BLOCKS:
            raise InputError(f"block: {len(self.blocks)} blocks, must be 1 to {ranges.MAX_BLOCKS}")
        for number, block in enumerate(self.blocks, start=1):
            check_block(f"block[{number}]", block)
            check_friction(f"block[{number}].joint", block.joint)
        _check_settings(self)

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        """Worked out once: what is kept of a column is asked for several times in a run."""
        return hash((self.name, self.blocks, self.settings, self.g))

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in self.__dict__.items() if key != "_hash"}  # each process has its own

    @property
    def n(self) -> int:
        """Number of blocks."""
        return len(self.blocks)

    @cached_property
    def has_rectangles_only(self) -> bool:
        """Whether all joints are rectangles."""
        return all(block.joint_section == RECTANGLE for block in self.blocks)

    @cached_property
    def has_strips(self) -> bool:
        """Whether some joint is made of strips."""
        return any(block.joint_section == STRIPS for block in self.blocks)

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
        changed = _changed(self, settings=replace(self.settings, **changes))
        _check_settings(changed)
        return changed

    def with_joints(self, stiffness: Sequence[float], damping: Sequence[float]) -> Column:
        """Return a copy whose joints have these moduli, N/m3, and dampings, s, a number each from the top joint down.

        Raises InputError as `Column` does.
        """
        blocks = []
        for number, (block, modulus, eta) in enumerate(zip(self.blocks, stiffness, damping, strict=True), start=1):
            modulus = ranges.check(f"block[{number}].joint.stiffness", modulus)
            eta = ranges.check(f"block[{number}].joint.damping", eta)
            blocks.append(_changed(block, joint=_changed(block.joint, stiffness=modulus, damping=eta)))
        return _changed(self, blocks=tuple(blocks))

    @cached_property
    def slides(self) -> bool:
        """Whether some joint may slide."""
        return any(block.joint.friction is not None for block in self.blocks)

    @cached_property
    def off_axis(self) -> bool:
        """Whether some block stands off its axis as built, so that the rest is not the straight column."""
        return any(block.is_off_axis for block in self.blocks)

    @cached_property
    def has_slips(self) -> bool:
        """Whether slips are among the coordinates: of joints that slide, and of columns that are off their axis."""
        return self.slides or self.off_axis

    @cached_property
    def other_law(self) -> str:
        """Key of what makes the law of some joint another one than the linear one; empty where nothing does.

        What is worked out from the linear law, outside of kernels/joint/law.py, asks this first.
        """
        return next((block.joint.other_law for block in self.blocks if block.joint.other_law), "")

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
        return cls(**parts_from(data))

    def to_dict(self) -> dict[str, Any]:
        """Return the mapping that `from_dict` turns into this very column: plain numbers, strings, lists and dicts.

        Values left to their defaults are written out, except those that follow from other values (None) which stay
        absent.
        """
        data = asdict(self, dict_factory=plain)
        return {"name": data["name"], "g": data["g"], "block": list(data["blocks"]), "solver": data["settings"]}


Part = TypeVar("Part", "Column", Block, Joint)


def _changed(part: Part, **values: Any) -> Part:
    """A copy with other values; the rest of it has been checked, and what was worked out of the rest holds for it.

    So nothing may be remembered (cached_property) that hangs on settings, moduli or dampings.
    """
    made = object.__new__(type(part))
    made.__dict__.update(part.__dict__, **values)
    made.__dict__.pop("_hash", None)
    return made


def _check_name(name: object) -> None:
    if not isinstance(name, str) or not re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", name):
        raise InputError(
            f"name = {shown(name)}: must be a C identifier (letters, digits and _, no digit first): "
            "it becomes the FMU's model identifier"
        )


def _check_settings(column: Column) -> None:
    check_settings("solver", column.settings)
    if column.has_slips:
        _check_general(column)


def _check_general(column: Column) -> None:
    """What cannot be had of a column whose joints slide, or that is off its axis."""
    number, block = next(
        (i, block)
        for i, block in enumerate(column.blocks, start=1)
        if block.joint.friction is not None or block.is_off_axis
    )
    key = f"block[{number}].joint"
    given = {f"{key}.{name}": getattr(block.joint, name) for name in ("friction", "offset", "inclination")}
    given |= {f"block[{number}].tilt": block.tilt, f"{key}.strips": block.joint.strips}
    name, value = next((name, value) for name, value in given.items() if value)
    if column.settings.formulation == "paper":
        raise InputError(f'{name} = {shown(value)}: solver.formulation must be "exact", which "paper" has nothing of')
    if column.settings.integrator != "auto":
        raise InputError(f'{name} = {shown(value)}: solver.integrator must be "auto", steps of a fixed length miss it')
    if column.other_law:  # what rims push by, and the bent rest, are those of the linear law
        raise InputError(f"{name} = {shown(value)}: must be left out beside joint.{column.other_law}")
