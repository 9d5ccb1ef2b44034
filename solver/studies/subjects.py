"""The models of a study, all of one kind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..common.errors import InputError
from ..models.column.kind import KIND as COLUMNS
from ..models.column.model import Column
from ..models.protocol import Kind, Model
from ..models.structure.file import describes_structure, in_space
from ..models.structure.kind import STRUCTURES
from ..models.structure.model import Structure
from .motions import ACROSS, Shaking

DIRECTION = "direction"  # direction of a motion in plan
OF_SPACE = (ACROSS, DIRECTION)  # numbers of a motion that leaves the plane of a column
IN_PLANE = "a column moves in its plane; structure = FILE, in place of column, solves it in space"
ALL_KEPT = {**STRUCTURES.kept, **COLUMNS.kept}  # a name of both has the same unit


def subject_from(data: Mapping[str, Any], space: bool = False) -> Column | Structure:
    """Return a column or a structure from the mapping that its file holds.

    With `space` a column becomes the structure of its stack. Raises InputError.
    """
    data = in_space(data) if space else data
    return Structure.from_dict(data) if describes_structure(data) else Column.from_dict(data)


def subjects_in(paths: Sequence[Path], in_space: bool) -> tuple[Model, ...]:
    """Return the columns, or structures, of files. Raises InputError that begins with the path."""
    return tuple((Structure if in_space else Column).from_toml(path) for path in paths)


def check_alike(subjects: Sequence[Model]) -> None:
    """Raise InputError for models of several kinds."""
    words = sorted({f"{subject.kind.word}s" for subject in subjects})
    if len(words) > 1:
        raise InputError(f"columns: must all be {', or all '.join(words)}")


def can_slide(subject: Model) -> bool:
    """Return True if any joint has a coefficient of friction."""
    return any(law.friction is not None for law in subject.laws)


def kind_in(head: Mapping[str, Any]) -> Any:
    """Return the kind of the models of a journal, from its first line."""
    return STRUCTURES if "sizes" in head else COLUMNS


def always_kept(kind: Kind) -> tuple[str, str]:
    """Return the names of the outputs that every picture and table needs: largest displacements and verdict."""
    return kind.keys.get(kind.displacements, kind.displacements), "verdict"


def sizes_of(subjects: Sequence[Model]) -> dict[str, int]:
    """Return the largest numbers of blocks, joints and ties, and of components of the base: lengths of the outputs."""
    return {part: max(one.sizes[part] for one in subjects) for part in subjects[0].sizes}


def check_motion(key: str, shaking: Shaking, across: bool) -> None:
    """Raise InputError for a motion that leaves the plane of a column."""
    if across:
        return
    for name in OF_SPACE:
        if name in shaking.numbers:
            raise InputError(f"{key}.{name}: must be left out, {IN_PLANE}")
    if shaking.record is not None and shaking.record.has_ay:
        raise InputError(f"{key}: ay: {IN_PLANE}")
