"""The entries of a column with brittle joints, named as those in api/entries.py.

`given` ends with GIVEN_OF_BOND of all joints (layout.py). Behind an output row stands the share of each joint's
bond that is left.
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
