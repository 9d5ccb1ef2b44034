"""What a study shakes: columns in their plane or structures in space, and what differs between the two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..column.column import Column
from ..common.errors import InputError
from ..ground.motion import check_in_plane
from ..runs.many_in_space import KEPT as KEPT_IN_SPACE
from ..runs.outputs import KEPT, Kept
from ..space.structure import Structure
from ..space.structure_file import describes_structure
from .motions import Shaking
from .parameters import column_with, is_of_column, single_names
from .parameters_in_space import is_of_structure, single_names_in_space, structure_with

Subject = Column | Structure
DIRECTION = "direction"  # of a motion in plan


def subject_from(data: Mapping[str, Any]) -> Subject:
    """A column or a structure from the mapping that its file holds. Raises InputError."""
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


def is_number_of(name: str, in_space: bool) -> bool:
    """Whether a dotted name belongs to a subject."""
    return is_of_structure(name) if in_space else is_of_column(name)


def numbers_of_each(name: str, subject: Subject) -> list[str]:
    """The names of the numbers that a name refers to, one for each block, joint or tie."""
    return single_names_in_space(name, subject) if isinstance(subject, Structure) else single_names(name, subject.n)


def subject_with(subject: Subject, values: Mapping[str, tuple[float, bool]]) -> Subject:
    """The subject with numbers set: name -> (number, whether it multiplies what is there). Raises InputError."""
    return structure_with(subject, values) if isinstance(subject, Structure) else column_with(subject, values)


def check_motion(key: str, shaking: Shaking, in_space: bool) -> None:
    """Raise InputError for a motion that leaves the plane of a column."""
    if in_space:
        return
    if DIRECTION in shaking.numbers:
        raise InputError(f"{key}.{DIRECTION}: must be left out, a column moves in its plane")
    if shaking.record is not None:
        try:
            check_in_plane(shaking.record)
        except InputError as error:
            raise InputError(f"{key}: {error}") from None
