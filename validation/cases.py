"""The cases, in the order in which they run."""

from . import closed_forms, codes, drums, free_rocking, housner, overturning, shaken_rocks, size
from .case import Case

CASES: tuple[Case, ...] = (
    closed_forms.CASE,
    housner.CASE,
    overturning.CASE,
    shaken_rocks.CASE,
    free_rocking.CASE,
    codes.CASE,
    size.CASE,
    drums.CASE,
)
