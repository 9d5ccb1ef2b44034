"""Entries called from Python, as those of the same names in api/entries.py, of a column with ports.

What it follows are instants of base and loads, `times`; accelerations of the base, which may end before; loads on each
segment (loads.py); PORTS. Inputs at ports lie behind those of the base, peaks of ports behind the state, outputs of
ports behind an output row.
"""

from ..api.entries import arrive_base as arrive_base
from ..api.entries import assemble_column as assemble_column
from ..api.entries import couple_base as couple_base
from ..api.entries import entries_of
from ..api.entries import examine_base as examine_base
from ..layout.spaces import PORTS
from ..numba_ext.jit import leaf
from .loads import Loaded

_PORT = len(PORTS.fields)


@leaf
def _samples(times, ax, az, scale, held, loads, ports, at):
    lasting = 1 if loads.size > 0 else 0
    begin = times.size, times.row, ax.row, az, scale, held, ax.size
    return Loaded(*begin, ports.size // _PORT, ports.row, lasting, loads.row, at)


_, run, observe_state, observe_snapshots = entries_of("ports", __name__, samples_of=_samples)
