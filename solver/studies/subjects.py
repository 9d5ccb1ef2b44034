"""The models of a study, all of one kind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..common.errors import InputError
from ..models.column.kind import KIND as COLUMNS
from ..models.column.model import Column
from ..models.protocol import Kind, Model
from ..models.structure.file import describes_structure, in_space
from ..models.structure.kind import STRUCTURES
from ..models.structure.model import Structure

ALL_KEPT = {**STRUCTURES.kept, **COLUMNS.kept}  # a name of both has the same unit


def subject_from(data: Mapping[str, Any], space: bool = False) -> Column | Structure:
    """Return a column or a structure from the mapping that its file holds.

    With `space` a column becomes the structure of its stack. Raises InputError.
    """
    data = in_space(data) if space else data
    return Structure.from_dict(data) if describes_structure(data) else Column.from_dict(data)


def check_alike(subjects: Sequence[Model]) -> None:
    """Raise InputError for models of several kinds."""
    words = sorted({f"{subject.kind.word}s" for subject in subjects})
    if len(words) > 1:
        raise InputError(f"columns: must all be {', or all '.join(words)}")


def kind_in(head: Mapping[str, Any]) -> Any:
    """Return the kind of the models of a journal, from its first line."""
    return STRUCTURES if "sizes" in head else COLUMNS


def always_kept(kind: Kind) -> tuple[str, ...]:
    """Return the keys of the outputs that every picture and table needs: largest displacements and verdict."""
    return kind.keys_of((kind.displacements, "verdict"))


def sizes_of(subjects: Sequence[Model]) -> dict[str, int]:
    """Return the largest numbers of blocks, joints and ties, and of components of the base: lengths of the outputs."""
    return {part: max(one.sizes[part] for one in subjects) for part in subjects[0].sizes}
