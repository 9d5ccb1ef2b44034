"""The cases, in the order in which they run."""

from . import closed_forms, housner, overturning
from .case import Case

CASES: tuple[Case, ...] = (closed_forms.CASE, housner.CASE, overturning.CASE)
