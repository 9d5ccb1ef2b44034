"""What a study shakes: columns in their plane or structures in space, and what differs between the two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..column.column import Column
from ..common.errors import InputError
from ..runs.many_in_space import KEPT as KEPT_IN_SPACE
from ..runs.outputs import KEPT, Kept
from ..space.blocks.parts import OF_COLUMN
from ..space.structure import Structure
from ..space.structure_file import describes_structure, in_space
from .motions import Shaking
from .parameters import column_with, is_of_column, single_names
from .parameters_in_space import is_of_structure, single_names_in_space, structure_with

Subject = Column | Structure
DIRECTION = "direction"  # of a motion in plan
IN_PLANE = "a column moves in its plane; structure = FILE, in place of column, solves it in space"


def subject_from(data: Mapping[str, Any], space: bool = False) -> Subject:
    """A column or a structure from the mapping that its file holds; space: a column as its stack. Raises InputError."""
    data = in_space(data) if space else data
    return Structure.from_dict(data) if describes_structure(data) else Column.from_dict(data)


def subjects_in(paths: Sequence[Path], in_space: bool) -> tuple[Subject, ...]:
    """The columns, or structures, of files. Raises InputError that begins with the path."""
    return tuple((Structure if in_space else Column).from_toml(path) for path in paths)


def are_in_space(subjects: Sequence[Subject]) -> bool:
    """Whether these are structures. Raises InputError for a mixture."""
    found = {isinstance(subject, Structure) for subject in subjects}
    if len(found) > 1:
        raise InputError("columns: must all be columns, or all structures")
    return found == {True}


def can_slide(subject: Subject) -> bool:
    """Whether some joint has a friction that may give way."""
    if isinstance(subject, Structure):
        return any(joint.bed.friction is not None for joint in subject.joints)
    return any(block.joint.friction is not None for block in subject.blocks)


def kept(in_space: bool) -> Mapping[str, Kept]:
    """The results that can be kept of a run, by name."""
    return KEPT_IN_SPACE if in_space else KEPT


def always_kept(in_space: bool) -> tuple[str, str]:
    """The largest displacements, which every picture and table needs, and the verdict."""
    return "peak_u" if in_space else "peak_ux", "verdict"


def sizes_of(subjects: Sequence[Subject]) -> dict[str, int]:
    """The most blocks, joints and ties of one, and the components of the base: the lengths of what is kept."""
    joints = [len(one.joints) if isinstance(one, Structure) else one.n for one in subjects]
    ties = [len(one.ties) if isinstance(one, Structure) else 0 for one in subjects]
    return {"block": max(one.n for one in subjects), "joint": max(joints), "tie": max(ties), "base": 6}


def is_number_of(name: str, subject: Subject) -> bool:
    """Whether a dotted name belongs to a subject."""
    if isinstance(subject, Structure) and not subject.is_stack:
        return is_of_structure(name)
    return is_of_column(name) or (isinstance(subject, Structure) and _is_law(name))


def _is_law(name: str) -> bool:
    """Whether a name of a stack is of the law of a joint, as structures have it; all others are of the column."""
    return name.startswith("joint") and is_of_structure(name)


def numbers_of_each(name: str, subject: Subject) -> list[str]:
    """The names of the numbers that a name refers to, one for each block, joint or tie."""
    return single_names_in_space(name, subject) if isinstance(subject, Structure) else single_names(name, subject.n)


def subject_with(subject: Subject, values: Mapping[str, tuple[float, bool]]) -> Subject:
    """The subject with numbers set: name -> (number, whether it multiplies what is there). Raises InputError."""
    if isinstance(subject, Column):
        return column_with(subject, values)
    if subject.is_stack:
        of_column = {name: value for name, value in values.items() if not _is_law(name)}
        if of_column:
            column = Column.from_dict(subject.to_dict()[OF_COLUMN])
            subject = Structure.stack(column_with(column, of_column))
        values = {name: value for name, value in values.items() if _is_law(name)}
    return structure_with(subject, values)


def check_motion(key: str, shaking: Shaking, in_space: bool) -> None:
    """Raise InputError for a motion that leaves the plane of a column."""
    if in_space:
        return
    if DIRECTION in shaking.numbers:
        raise InputError(f"{key}.{DIRECTION}: must be left out, {IN_PLANE}")
    if shaking.record is not None and shaking.record.has_ay:
        raise InputError(f"{key}: ay: {IN_PLANE}")
