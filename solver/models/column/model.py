"""The column: superimposed rigid blocks, and the settings of their equations."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

from ...common import ranges
from ...common.errors import InputError, reading, shown
from ...common.files import check_file_name, toml_of
from ...common.notebook import NotebookRepr, counted, outlines
from ...kernels.column.sections.faces import RECTANGLE, STRIPS, is_round
from ..ports import Port
from ..protocol import kind_of, structure_of
from .block import Block, Joint, check_block, check_friction
from .contact import Contact, check_contacts, contacts_of
from .file import names_of, parts_from, plain
from .settings import Settings, check_settings

if TYPE_CHECKING:
    from ..structure.model import Structure


@dataclass(frozen=True, repr=False)
class Column(NotebookRepr):
    """Superimposed rigid blocks, listed from the TOP down; the last joint rests on the base.

    Raises InputError on a value out of range, however the column was made; keys count blocks from 1, the top one.
    """

    name: str  # a file name (files.check_file_name), from which the FMU's model identifier is made
    blocks: tuple[Block, ...]
    settings: Settings = field(default_factory=Settings)
    g: float = 9.80665  # m/s2
    ports: tuple[Port, ...] = ()  # with `at` = (x, z)

    def __post_init__(self) -> None:
        object.__setattr__(self, "blocks", tuple(self.blocks))
        object.__setattr__(self, "ports", tuple(self.ports))
        check_file_name("name", self.name)
        ranges.check("g", self.g)
        if not 1 <= len(self.blocks) <= ranges.MAX_BLOCKS:
            raise InputError(f"block: {len(self.blocks)} blocks, must be 1 to {ranges.MAX_BLOCKS}")
        for number, block in enumerate(self.blocks, start=1):
            check_block(f"block[{number}]", block)
            check_friction(f"block[{number}].joint", block.joint)
        check_contacts(self.blocks)
        _check_settings(self)

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        """The hash, cached as results stored for a column are looked up by it several times in a run."""
        return hash((self.name, self.blocks, self.settings, self.g, self.ports))

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in self.__dict__.items() if key != "_hash"}  # each process has its own hashes

    def _facts(self) -> tuple[str, ...]:
        height, mass = (sum(getattr(block, name) for block in self.blocks) for name in ("height", "mass"))
        return self.name, counted(self.n, "block"), f"{height:.4g} m high", f"{1e-3 * mass:.4g} t"

    def _lines(self) -> Iterable[Sequence[object]]:
        yield "block", "height (m)", "width (m)", "mass (t)", "stiffness (N/m3)", "damping (s)", "friction"
        for number, block in enumerate(self.blocks, start=1):
            joint = block.joint
            friction = "no sliding" if joint.friction is None else joint.friction
            yield number, block.height, block.width, 1e-3 * block.mass, joint.stiffness, joint.damping, friction

    def _picture(self) -> str:
        shapes, foot, middle = [], 0.0, 0.0
        for block in reversed(self.blocks):  # without leans, which are too small to be visible
            middle += block.joint.offset or 0.0
            top, half, upper = foot + block.height, 0.5 * block.width, 0.5 * (block.top_width or block.width)
            left, right = middle - half, middle + half
            shapes.append(((left, foot), (right, foot), (middle + upper, top), (middle - upper, top)))
            foot = top
        return outlines(shapes)

    @property
    def n(self) -> int:
        """The number of blocks."""
        return len(self.blocks)

    @property
    def sizes(self) -> dict[str, int]:
        """The numbers of blocks, joints, ties, ports and components of the base."""
        bonded = self.n if self.is_brittle else 0
        others = {"tie": 0, "bearing": 0, "port": len(self.ports), "bond": bonded, "base": 6}
        return {"block": self.n, "joint": self.n, **others}

    @property
    def laws(self) -> tuple[Joint, ...]:
        """The joints, from the top."""
        return tuple(block.joint for block in self.blocks)

    @property
    def kind(self) -> Any:
        """The kind of model (models/protocol.py), by formulation."""
        return kind_of(self)

    @cached_property
    def contacts(self) -> tuple[Contact, ...]:
        """The contact under each block within the face below, without slips and offsets."""
        return contacts_of(self.blocks)

    @cached_property
    def has_rims(self) -> bool:
        """True if the faces of some joint touch in a rim."""
        return any(contact.rim for contact in self.contacts)

    @property
    def stands_on_edges(self) -> bool:
        """True if the faces of some joint touch in a rim, or on strips with a gap between them."""
        return self.has_rims or any(0.0 in (block.joint.strips or ())[1:-1] for block in self.blocks)

    @cached_property
    def sections(self) -> set[int]:
        """The codes of the sections of the contacts; of columns with slips also those after a slip."""
        found = {contact.section for contact in self.contacts}
        return found | {contact.slipped for contact in self.contacts} if self.has_slips else found

    @property
    def springs(self) -> tuple[float, ...]:
        """The stiffness of each joint in full contact (N/m)."""
        joined = zip(self.blocks, self.contacts, strict=True)
        return tuple(contact.stiffness(block.joint.stiffness) for block, contact in joined)

    def with_settings(
        self,
        *,
        formulation: str | None = None,
        integrator: str | None = None,
        step: float | None = None,
        tolerance: float | None = None,
        without: Sequence[str] | None = None,
    ) -> Column:
        """Return the column with other settings; None keeps the present one.

        The integrator of a new formulation is its default. Raises InputError as `Column` does.
        """
        if formulation is not None and integrator is None:
            integrator = ""  # default of the formulation
        if formulation == "exact" and step is None:
            step = Settings.step
        given = {"formulation": formulation, "integrator": integrator, "step": step, "tolerance": tolerance}
        changes = {key: value for key, value in (given | {"without": without}).items() if value is not None}
        if not changes:
            return self  # itself, with its cached contacts
        changed = _changed(self, settings=replace(self.settings, **changes))  # type: ignore[arg-type]
        _check_settings(changed)
        return changed

    def with_joints(self, stiffness: Sequence[float], damping: Sequence[float]) -> Column:
        """Return a copy whose joints have these moduli (N/m3) and dampings (s), each (n,) from the top joint down.

        Raises InputError as `Column` does.
        """
        blocks = []
        for number, (block, modulus, eta) in enumerate(zip(self.blocks, stiffness, damping, strict=True), start=1):
            modulus = ranges.check(f"block[{number}].joint.stiffness", modulus)
            eta = ranges.check(f"block[{number}].joint.damping", eta)
            blocks.append(_changed(block, joint=_changed(block.joint, stiffness=modulus, damping=eta)))
        return _changed(self, blocks=tuple(blocks))

    def scaled_joints(self, stiffness: Sequence[float], damping: Sequence[float]) -> Column:
        """Return a copy with these factors on the moduli and dampings of the joints. Raises InputError likewise."""
        moduli = [factor * law.stiffness for factor, law in zip(stiffness, self.laws, strict=True)]
        return self.with_joints(moduli, [factor * law.damping for factor, law in zip(damping, self.laws, strict=True)])

    @property
    def is_damped(self) -> bool:
        """True if a joint has a dashpot."""
        return any(law.damping for law in self.laws)

    @cached_property
    def slides(self) -> bool:
        """True if some joint may slide."""
        return any(block.joint.friction is not None for block in self.blocks)

    @cached_property
    def off_axis(self) -> bool:
        """True if some block stands off its axis as built, so that the rest is not the straight column."""
        return any(block.is_off_axis for block in self.blocks)

    @cached_property
    def has_slips(self) -> bool:
        """True if slips are among the coordinates: some joint may slide, or the column is off its axis."""
        return self.slides or self.off_axis

    @cached_property
    def is_brittle(self) -> bool:
        """True if some joint is bonded until it breaks."""
        return any(block.joint.is_brittle for block in self.blocks)

    @property
    def brittle_key(self) -> str:
        """The key of the strength that makes a joint brittle, for messages."""
        return next((block.joint.brittle_key for block in self.blocks if block.joint.is_brittle), "")

    @cached_property
    def other_law(self) -> str:
        """The key of the property that makes the law of some joint other than the linear law; "" without one.

        Code outside kernels/column/joint/law.py that assumes the linear law checks this first.
        """
        return next((block.joint.other_law for block in self.blocks if block.joint.other_law), "")

    def in_space(self) -> Structure:
        """Return these blocks and joints as a structure in space (`Structure.stack`).

        Raises InputError if they cannot be one.
        """
        return structure_of(self)

    @property
    def rolls_in_space(self) -> bool:
        """True if a contact is round: in space it rolls on its rim, which motion in the plane excludes."""
        return any(is_round(block.joint_section) for block in self.blocks)

    @property
    def is_alike_across(self) -> bool:
        """True if widths and depths are equal, and it stands on its axis."""
        return not self.off_axis and all(
            (block.width, block.joint_width, block.top_width or block.width)
            == (block.depth, block.joint_depth, block.top_depth or block.depth)
            for block in self.blocks
        )

    def across(self) -> Column:
        """Return the column as it moves in the other direction: widths and depths exchanged.

        Inertia beyond that of a homogeneous block is assumed equal about both axes, as in space. Raises InputError for
        properties of one direction: an offset, inclination or tilt, and strips.
        """
        blocks = tuple(_across(f"block[{number}]", block) for number, block in enumerate(self.blocks, start=1))
        ports = tuple(replace(port, at=(0.0, port.at[1])) for port in self.ports)
        return replace(self, name=f"{self.name} across", blocks=blocks, ports=ports)

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Column:
        """Read a column from a TOML file; its keys are those of `from_dict`.

        Raises InputError that begins with `path` if the file cannot be read, is not TOML or has an invalid key.
        """
        with reading(path):
            return cls.from_dict(toml_of(path))

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Column:
        """Make a column from the mapping that the TOML file holds.

        name, g (optional), block: one table for each block from the top down with height, width, depth, mass or
        density, centroid and inertia (optional) and the table joint; joint (optional): defaults for all joints; solver
        (optional): the fields of Settings; port (optional): a table for each with name, block (block1 is the top one)
        and at (optional: [x, z] m from its centroid along its own axes). Units as in `Block`, `Joint` and `Settings`;
        density in kg/m3.

        Raises InputError on an unknown, missing or wrong key.
        """
        return cls(**parts_from(data))

    def to_dict(self) -> dict[str, Any]:
        """Return the mapping that `from_dict` converts to an equal column: plain numbers, strings, lists and dicts.

        Defaults are written out, except those that follow from other values (None), which are absent, as the step of
        the exact formulation, which has no effect. Blocks have the density and load of their file.
        """
        data = asdict(self, dict_factory=plain)
        for block, table in zip(self.blocks, data["blocks"], strict=True):
            given = table.pop("given", {})
            if block.is_as_given:
                for key in _DERIVED:
                    table.pop(key, None)
                table |= given
        if self.settings.formulation == "exact":
            del data["settings"]["step"]
        found = {"name": data["name"], "g": data["g"], "block": list(data["blocks"]), "solver": data["settings"]}
        names = names_of(self.n)
        ports = [{"name": port.name, "block": names[port.body], "at": [*port.at]} for port in self.ports]
        return found | ({"port": ports} if ports else {})


_DERIVED = ("mass", "centroid", "inertia")  # numbers of a block that follow from its `given`

Part = TypeVar("Part", "Column", Block, Joint)


def _changed(part: Part, **values: Any) -> Part:
    """Return a copy with other values, without checks; values computed from its other fields hold for the copy.

    So no cached_property may depend on settings, moduli or dampings.
    """
    made = object.__new__(type(part))
    made.__dict__.update(part.__dict__, **values)
    made.__dict__.pop("_hash", None)
    return made


def _across(key: str, block: Block) -> Block:
    """Return a block with width and depth exchanged. Raises InputError if it is off its axis, or on strips."""
    if block.is_off_axis or block.joint_section == STRIPS:
        raise InputError(f"{key}: must stand on its axis, and not on strips, to be turned to the other direction")
    joint = block.joint
    if not is_round(block.joint_section):
        joint = replace(joint, width=joint.depth, depth=joint.width)
    turned = replace(
        block,
        width=block.depth,
        depth=block.width,
        top_width=block.top_depth,
        top_depth=block.top_width,
        joint=joint,
        inertia=None,
    )
    if block.given is not None and block.given.inertia is None and block.is_as_given:
        return turned.derived(block.given)
    # the inertia beyond that of a homogeneous block is kept
    if block.inertia is None:
        return turned
    return replace(turned, inertia=block.inertia - block.homogeneous[1] + turned.homogeneous[1])


def _check_settings(column: Column) -> None:
    check_settings("solver", column.settings)
    if column.ports and column.settings.formulation == "paper":
        raise InputError('port: solver.formulation must be "exact", "paper" has no loads')
    if column.has_slips:
        _check_general(column)
    if column.is_brittle:
        _check_brittle(column)


def _check_brittle(column: Column) -> None:
    """Raise InputError for features that brittle joints do not support."""
    for number, (block, contact) in enumerate(zip(column.blocks, column.contacts, strict=True), start=1):
        if block.joint.is_brittle:
            name = block.joint.brittle_key
            key = f"block[{number}].joint.{name} = {shown(getattr(block.joint, name))}: must be left out"
            if column.settings.formulation == "paper":
                raise InputError(f'{key}, or solver.formulation "exact": "paper" has no bonds')
            if column.ports:
                raise InputError(f"{key} of a column with ports")
            if {contact.section, contact.slipped, block.joint_section} != {RECTANGLE}:
                raise InputError(f"{key} where the contact is no rectangle")


def _check_general(column: Column) -> None:
    """Raise InputError for settings that columns whose joints slide, or that are off their axis, do not support."""
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
        raise InputError(f'{name} = {shown(value)}: solver.formulation must be "exact", "paper" does not support it')
    if column.other_law:  # forces of rims and the bent rest assume the linear law
        raise InputError(f"{name} = {shown(value)}: must be left out beside joint.{column.other_law}")
