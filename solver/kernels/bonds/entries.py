"""Entries as those of the same names in api/entries.py, of a column with brittle joints.

`given` ends with GIVEN_OF_BOND of all joints (layout.py). Behind an output row stands what is bonded of each joint.
"""

from ..api.driven_entries import driven_entries_of
from ..api.engine import column_in
from ..api.entries import entries_of
from . import memory  # noqa: F401  versions of kernels
from .layout import MODEL, STATE, WORK

column_over = column_in(MODEL, STATE, WORK)
assemble, run, observe_state, observe_snapshots, arrive_base, couple_base, examine_base = entries_of(
    "bonds", __name__, column_over
)
driven_entries_of("bonds", __name__, column_over)
