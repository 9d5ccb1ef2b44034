"""Columns with brittle joints for callers that have pointers: the entries of api/pointers.py.

What `assemble` is given and what stands behind an output row are those of entries.py.
"""

from ..api.pointers import entries_of
from .entries import column_over

ENTRIES = entries_of(column_over)
