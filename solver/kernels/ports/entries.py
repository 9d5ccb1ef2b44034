"""The entries of a column with ports, named as those in api/entries.py.

The record that Python passes: instants of base and loads, `times`; accelerations of the base, which may end before;
loads on each segment (loads.py); PORTS. Inputs at ports lie behind those of the base, peaks of ports behind the state,
outputs of ports behind an output row. Native FMUs keep the ports behind the model: what they give to `assemble` ends
with the number of ports, and PORTS.
"""

from ..api import engine
from ..api.driven_entries import driven_entries_of
from ..api.entries import entries_of
from ..column.description import GIVEN, GIVEN_SETTINGS
from ..layout.spaces import BASE, LOAD, OK, PORTS, SPOTS, STATE
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.views import clear, copy
from .loads import Loaded

_PORT, _SEEN, _LOADS, _BASE = len(PORTS.fields), len(SPOTS.fields), 2 * len(LOAD), BASE.beside
_STATE_PER_N, _STATE_BESIDE = STATE.per_n, STATE.beside
_SETTINGS, _BLOCK = GIVEN_SETTINGS.beside, GIVEN.beside


@leaf
def _samples(times, ax, az, scale, held, loads, ports, at):
    lasting = 1 if loads.size > 0 else 0
    begin = times.size, times.row, ax.row, az, scale, held, ax.size
    return Loaded(*begin, ports.size // _PORT, ports.row, lasting, loads.row, at)


@leaf
def _samples_inside(n, model, times, ax, az, scale):
    behind = model[engine.model_room(n) :]
    ports = behind[1:]
    return Loaded(times.size, times.row, ax, az, scale, 0, times.size, int(behind[0]), ports, 0, ports, ports)


@kernel
def _assemble(column, given, from_rest, scratch, detail):
    """Run `engine.assemble`, and store the given ports behind the model; return a code."""
    n, state = column.model.n, column.state.buffer
    code, last = engine.assemble(column, given.row, from_rest, scratch, detail), _SETTINGS + _BLOCK * n
    if code != OK or given.size == last:
        return code
    # number of ports and PORTS, and zeros for their peaks and loads
    behind = given.row[last:]
    spotted = int(behind[0])
    copy(column.model.buffer[engine.model_room(n) :], behind, 1 + _PORT * spotted)
    if from_rest != 0:
        clear(state[_STATE_PER_N * n + _STATE_BESIDE :], _SEEN * spotted)
        clear(column.base.buffer[_BASE:], _LOADS * spotted)
    return code


assemble, run, observe_state, observe_snapshots, arrive_base, couple_base, examine_base = entries_of(
    "ports", __name__, samples_of=_samples, assembled=_assemble
)
driven_entries_of("ports", __name__, samples_of=_samples_inside)
