"""Entries called from Python, as those of the same names in api/entries.py, of a column with brittle joints.

`given` ends with GIVEN_OF_BOND of all joints (layout.py). Behind an output row stands what is bonded of each joint.
"""

from ..api.engine import column_in
from ..api.entries import arrive_base as arrive_base
from ..api.entries import couple_base as couple_base
from ..api.entries import entries_of
from ..api.entries import examine_base as examine_base
from . import memory  # noqa: F401  versions of kernels
from .layout import MODEL, STATE, WORK

column_over = column_in(MODEL, STATE, WORK)
assemble_column, run, observe_state, observe_snapshots = entries_of("bonds", __name__, column_over)
