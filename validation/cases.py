"""The cases, in the order in which they run."""

from . import closed_forms, codes, free_rocking, housner, overturning, shaken_rocks
from .case import Case

CASES: tuple[Case, ...] = (
    closed_forms.CASE,
    housner.CASE,
    overturning.CASE,
    shaken_rocks.CASE,
    free_rocking.CASE,
    codes.CASE,
)
