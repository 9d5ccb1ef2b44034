"""The structure: rigid blocks in space, the joints between their faces, ties; and the settings of a run."""

from __future__ import annotations

import copy
import os
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ...common import ranges
from ...common.errors import InputError, check_number, check_whole, reading, shown
from ...common.files import check_file_name, toml_of
from ...common.notebook import NotebookRepr, counted, outlines
from ...kernels.structure.layout import MOST_CORNERS, MOST_CUT
from ..column.model import Column
from ..column.settings import Settings
from ..ports import Port
from ..protocol import kind_of
from .blocks.faces import Face
from .blocks.parts import (
    BASE,
    BESIDE_COLUMN,
    OF_COLUMN,
    SKIPS,
    TOLERANCE,
    JointLaw,
    Pair,
    Solid,
    SpatialJoint,
    Tie,
    trees_of,
)
from .file import in_space, names_from, parts_from, ports_of, written_out
from .hull_tables import in_folder, with_hulls
from .neighbours import AFTER_FALL, after_fall_of, neighbours_from
from .packing import PackedModel, Parts, centroid_of, model_of
from .stack import in_three, stacked

LEAST_LENGTH = 1e-6  # m, of a tie


def _numbered(names: Sequence[str]) -> tuple[str, ...]:
    """Append numbers from 1 to names that occur more than once."""
    several, so_far, found = Counter(names), Counter[str](), []
    for name in names:
        so_far[name] += 1
        found.append(name if several[name] == 1 else f"{name}.{so_far[name]}")
    return tuple(found)


@dataclass(frozen=True, eq=False, repr=False)
class Structure(NotebookRepr):
    """Rigid blocks in space with joints between their faces, and ties.

    x and y are horizontal, z points up; the base is the plane z = 0. InputError is raised for a block without
    connection to the base, and for names that occur twice.
    """

    name: str
    blocks: tuple[Solid, ...]
    joints: tuple[SpatialJoint, ...]  # bearings last
    ties: tuple[Tie, ...] = ()
    g: float = 9.80665  # gravity, m/s2
    tolerance: float = TOLERANCE  # error relative to the largest motion
    without: tuple[str, ...] = ()  # what a run leaves out: of "peaks", "elastic", "stabilized" (SKIPS)
    described: Mapping[str, Any] | None = None  # the file, with one table for each block; None: made otherwise
    ports: tuple[Port, ...] = ()
    neighbours: tuple[Pair, ...] = ()
    after_fall: float = 0.0  # s: a run goes on so long after the first fall; `going_on`

    def __post_init__(self) -> None:
        check_file_name("name", self.name)
        ranges.check("g", self.g)
        ranges.check("solver.tolerance", self.tolerance)
        if not 1 <= len(self.blocks) <= ranges.MAX_BLOCKS:
            raise InputError(f"block: {len(self.blocks)} blocks, must be 1 to {ranges.MAX_BLOCKS}")
        for name in self.without:
            ranges.check_choice("solver.without", name, SKIPS)
        # names, lengths of ties
        taken = {BASE}
        for i, name in enumerate(self.names):
            if name in taken:
                raise InputError(f"block[{i + 1}].name = {shown(name)}: must be another name, it is taken")
            taken.add(name)
        for e, tie in enumerate(self.ties, start=1):
            apart = centroid_of(self.blocks, tie.other) + tie.to - centroid_of(self.blocks, tie.one) - tie.from_
            if np.linalg.norm(apart) < LEAST_LENGTH:
                raise InputError(f"tie[{e}].to: is the same place as from, must be {LEAST_LENGTH} m apart at least")
        # limits of the kernels on the corners of faces
        for joint in self.joints:
            count = len(joint.face.outline)
            if joint.bed.is_bonded and joint.bearing is None and not 0 < count <= MOST_CUT:
                found = f"{count} corners" if count else "a round section"
                limit = f"must be a polygon of {MOST_CUT} corners at most where a joint bears tension or cohesion"
                raise InputError(f"{joint.key}: {found}, {limit}")
            if joint.bed.friction is None or joint.bearing is not None:
                continue
            for face in (joint.above or joint.face, joint.below or joint.face):
                if len(face.outline) > MOST_CORNERS:
                    limit = f"must be {MOST_CORNERS} at most where a joint may slide"
                    raise InputError(f"{joint.key}: a face of {len(face.outline)} corners, {limit}")
        if any(joint.bearing is None for joint in self.joints[len(self.joints) - len(self.bearings) :]):
            raise InputError("joints: bearings must come last")
        self._check_held()

    def _check_held(self) -> None:
        """Raise InputError unless joints and ties connect every block with the base."""
        links = [(joint.upper, joint.lower) for joint in self.joints] + [(tie.one, tie.other) for tie in self.ties]
        held = trees_of(self.n, links)[0]
        for i, name in enumerate(self.names):
            if i not in held:
                joined = 'must be joined to the base, also by blocks under it: on = "base", a [[joint]] or [[bearing]]'
                raise InputError(f"block[{i + 1}] = {shown(name)}: {joined}")

    def _facts(self) -> tuple[str, ...]:
        parts = [counted(self.n, "block"), counted(len(self.joints), "joint"), counted(len(self.ties), "tie")]
        return self.name, *parts, f"{1e-3 * sum(block.mass for block in self.blocks):.4g} t"

    def _lines(self) -> Iterable[Sequence[object]]:
        yield "block", "mass (t)", "x (m)", "y (m)", "z (m)"
        for block in self.blocks:
            yield block.name, 1e-3 * block.mass, *block.centroid.tolist()

    def _picture(self) -> str:
        return outlines(face.points()[:, [0, 2]] for block in self.blocks for face in block.faces)

    rolls_in_space: ClassVar[bool] = False  # cf. Column: no run of it is left to another model
    is_alike_across: ClassVar[bool] = True

    @property
    def n(self) -> int:
        """The number of blocks."""
        return len(self.blocks)

    @property
    def sizes(self) -> dict[str, int]:
        """The numbers of blocks, joints (with bearings, bonds), ties, neighbours, ports, components of the base."""
        return {
            "block": self.n,
            "joint": len(self.joints),
            "tie": len(self.ties),
            "bearing": len(self.bearings),
            "bond": len(self.bonds),
            "contact": len(self.neighbours),
            "port": len(self.ports),
            "base": 6,
        }

    @property
    def laws(self) -> tuple[JointLaw, ...]:
        """The laws of the joints."""
        return tuple(joint.bed for joint in self.joints)

    @property
    def kind(self) -> Any:
        """The kind of model (models/protocol.py)."""
        return kind_of(self)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the blocks."""
        return tuple(block.name for block in self.blocks)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """The names of the joints: upper and lower body, with a number where two bodies have several joints."""
        names = (*self.names, BASE)
        return _numbered([f"{names[joint.upper]}-{names[joint.lower]}" for joint in self.joints])

    @cached_property
    def bearings(self) -> tuple[SpatialJoint, ...]:
        """The bearings: the last joints."""
        return tuple(joint for joint in self.joints if joint.bearing is not None)

    @cached_property
    def bonds(self) -> tuple[int, ...]:
        """The indices of the joints that bear tension or cohesion until they break."""
        return tuple(j for j, joint in enumerate(self.joints) if joint.bed.is_bonded)

    @property
    def bond_names(self) -> tuple[str, ...]:
        """The names of the joints that bear tension or cohesion."""
        return tuple(self.joint_names[j] for j in self.bonds)

    @property
    def bearing_names(self) -> tuple[str, ...]:
        """The names of the bearings: those of their joints."""
        return self.joint_names[len(self.joints) - len(self.bearings) :]

    @cached_property
    def contact_names(self) -> tuple[str, ...]:
        """The names of the pairs of neighbours, with a number where two bodies meet in several parts or sides."""
        return _numbered(self.pair_names)

    @cached_property
    def pair_names(self) -> tuple[str, ...]:
        """The names of both bodies of each pair of neighbours."""
        return tuple(
            f"{self.names[pair.one]}-{f'wall {pair.wall}' if pair.wall else (*self.names, BASE)[pair.other]}"
            for pair in self.neighbours
        )

    @property
    def is_stack(self) -> bool:
        """True if the structure is described by the file of a column."""
        return self.described is not None and OF_COLUMN in self.described

    def number(self, block: str | int) -> int:
        """Return the index of a block from its name or index. Raises InputError if there is no such block."""
        if isinstance(block, str):
            ranges.check_choice("block", block, self.names)
            return self.names.index(block)
        return check_whole("block", block, 0, self.n - 1, f"a number from 0 to {self.n - 1}, or a name")

    @cached_property
    def model(self) -> PackedModel:
        """The arrays for the kernels."""
        parts = Parts(self.blocks, self.joints, self.ties, self.ports, self.neighbours)
        return model_of(parts, self.g, self.tolerance)

    @property
    def weight(self) -> float:
        """The weight of all blocks (N)."""
        return self.g * sum(block.mass for block in self.blocks)

    @cached_property
    def is_plane(self) -> bool:
        """True if blocks, joints, ties, ports and neighbours are symmetric about the plane x, z."""
        blocks = all(
            abs(block.centroid[1]) <= 1e-9 * block.size and not np.any(block.inertia[[0, 1], [1, 2]])
            for block in self.blocks
        )
        ties = all(tie.from_[1] == 0.0 and tie.to[1] == 0.0 for tie in self.ties)
        ports = all(abs(self.blocks[port.body].centroid[1] + port.at[1]) <= 1e-9 for port in self.ports)
        pairs = all(_is_mirrored_pair(pair) for pair in self.neighbours)
        return blocks and ties and ports and pairs and all(map(_is_mirrored_joint, self.joints))

    @property
    def settings(self) -> Settings:
        """The tolerance and the omissions, as settings of a column."""
        return Settings(tolerance=self.tolerance, without=self.without)

    def with_settings(self, *, tolerance: float | None = None, without: Sequence[str] | None = None) -> Structure:
        """Return a copy with other settings; None keeps the present one. Raises InputError."""
        if tolerance is None and without is None:
            return self
        tolerance = self.tolerance if tolerance is None else tolerance
        without = self.without if without is None else names_from("solver.without", without)
        described = self.described and _with_solver(self.described, {"tolerance": tolerance, "without": [*without]})
        return replace(self, tolerance=tolerance, without=without, described=described)

    def going_on(self, after_fall: float) -> Structure:
        """Return a copy whose runs go on for `after_fall` seconds after the first fall.

        Joints end where they have come apart, then any two blocks meet, and the ground, by the law of the table
        `neighbours` (theory.md section 17). Raises InputError if the file has no such table.
        """
        check_number("after_fall", after_fall, *AFTER_FALL)
        data = self.described or {}
        if "neighbours" not in data:
            raise InputError(f"after_fall = {after_fall}: needs a table [neighbours], the law by which blocks meet")
        data = {**data, "neighbours": {**data["neighbours"], "after_fall": after_fall}}
        found = neighbours_from(data, self.blocks, self.joints, after_fall > 0.0)
        return replace(self, neighbours=found, after_fall=after_fall, described=data)

    def scaled_joints(self, stiffness: Sequence[float], damping: Sequence[float]) -> Structure:
        """Return a copy with these factors on the moduli and dampings of the joints.

        Those on the damping also apply along the joints, to the dashpots of bearings and to their rings.
        """
        joints = (_scaled(*law) for law in zip(self.joints, stiffness, damping, strict=True))
        return replace(self, joints=tuple(joints), described=None)

    @property
    def is_damped(self) -> bool:
        """True if a joint or bearing has a dashpot."""
        beds, bearings = self.laws, [joint.bearing for joint in self.joints if joint.bearing is not None]
        along = any(bed.damping or bed.shear_damping for bed in beds)
        return along or any(bearing.dashpot or bearing.ring_damping for bearing in bearings)

    def to_dict(self) -> dict[str, Any]:
        """Return the mapping from which `from_dict` builds this structure. Raises InputError if there was none."""
        if self.described is None:
            raise InputError(
                f"{self.name}: must be from a structure file, from_dict or a builder, to be written as one"
            )
        return copy.deepcopy(dict(self.described))

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Structure:
        """Read a structure from a TOML file, or the stack of the column in the file. Raises InputError."""
        with reading(path):
            return cls.from_dict(in_folder(in_space(toml_of(path)), Path(path).parent))

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Structure:
        """Build a structure from the mapping of its TOML file (docs/structures.md), or from {"column": a column's}.

        Next to "column" there may be ports and neighbours. Raises InputError.
        """
        if OF_COLUMN in data:
            ranges.check_keys("", data, (OF_COLUMN, *BESIDE_COLUMN))
            made = cls.stack(Column.from_dict(data[OF_COLUMN]))
            beside = {key: data[key] for key in BESIDE_COLUMN if key in data}
            if not beside:
                return made
            after_fall = after_fall_of(data)
            return replace(
                made,
                ports=ports_of(in_three(data), made.blocks) if "port" in data else made.ports,
                neighbours=neighbours_from(data, made.blocks, made.joints, after_fall > 0.0),
                after_fall=after_fall,
                described={**(made.described or {}), **beside},
            )
        data, surfaces = with_hulls(data)
        return cls(**parts_from(data, surfaces), described=written_out(data))

    @classmethod
    def stack(cls, column: Column) -> Structure:
        """Build the structure of a column in space, the top block first.

        Raises InputError if the column has no such form.
        """
        return cls(**stacked(column))


def _with_solver(described: Mapping[str, Any], solver: Mapping[str, Any]) -> Mapping[str, Any]:
    if OF_COLUMN in described:
        column = described[OF_COLUMN]
        return {**described, OF_COLUMN: {**column, "solver": {**column.get("solver", {}), **solver}}}
    return {**described, "solver": solver}


def _scaled(joint: SpatialJoint, stiffer: float, damped: float) -> SpatialJoint:
    """Return a joint with these factors on its stiffnesses and dampings: times, and with a stiffness a dashpot."""
    bed, bearing = joint.bed, joint.bearing
    bed = replace(bed, stiffness=stiffer * bed.stiffness, damping=damped * bed.damping)
    if bed.shear_damping is not None:
        bed = replace(bed, shear_damping=damped * bed.shear_damping)
    if bearing is not None:
        spring, dashpot = stiffer * bearing.spring, stiffer * damped * bearing.dashpot
        bearing = replace(bearing, spring=spring, dashpot=dashpot, ring_damping=damped * bearing.ring_damping)
    return replace(joint, bed=bed, bearing=bearing)


def _is_mirrored_joint(joint: SpatialJoint) -> bool:
    """Return True if the bearing area of a joint is symmetric about the plane x, z."""
    return _is_mirrored(joint.face) and (
        joint.inside is None or not joint.inside.moments[0] or _is_mirrored(joint.inside)
    )


def _is_mirrored_pair(pair: Pair) -> bool:
    """Return True if both bodies of a pair are symmetric about the plane x, z."""
    for body in pair.bodies:
        corners = np.round(body.corners / (1e-9 * float(np.max(np.abs(body.corners)))))
        if {*map(tuple, corners + 0.0)} != {*map(tuple, corners * (1.0, -1.0, 1.0) + 0.0)}:
            return False
    return True


@lru_cache(maxsize=1024)
def _is_mirrored(face: Face) -> bool:
    """Return True if a face is symmetric about the plane x, z, with each axis in that plane or normal to it."""
    across = np.abs(face.axes[1, :])
    in_plane = bool(np.all((across < 1e-9) | (across > 1.0 - 1e-9))) and across[2] < 1e-9
    if not in_plane or abs(face.centre[1]) > 1e-9 * face.size:
        return False
    if face.radius:
        return True
    points = face.outline @ face.axes[:, :2].T
    mirrored = points * np.array([1.0, -1.0, 1.0])
    return all(np.min(np.linalg.norm(points - point, axis=1)) <= 1e-9 * face.size for point in mirrored)
