"""The cases, one module each, in the order in which they run."""

from ..case import Case
from . import (
    closed_forms,
    codes,
    drums,
    failure_amplitudes,
    free_rocking,
    housner,
    overturning,
    reference_study,
    rocks_in_space,
    shaken_rocks,
    size,
    structures,
    two_blocks,
)

CASES: tuple[Case, ...] = (
    closed_forms.CASE,
    housner.CASE,
    two_blocks.CASE,
    overturning.CASE,
    shaken_rocks.CASE,
    rocks_in_space.CASE,
    free_rocking.CASE,
    codes.CASE,
    failure_amplitudes.CASE,
    size.CASE,
    structures.CASE,
    reference_study.CASE,
    drums.CASE,
)
