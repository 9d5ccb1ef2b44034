"""Columns with ports for callers that have pointers: the entries of api/pointers.py.

What `assemble` is given ends with the number of ports and PORTS, which it keeps behind the model. Inputs, peaks and
outputs of ports lie as those of entries.py do.
"""

from ..api import engine
from ..api.pointers import entries_of
from ..column.description import GIVEN, GIVEN_SETTINGS
from ..layout.spaces import BASE, LOAD, OK, PORTS, SPOTS, STATE
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.views import clear, copy, row_at
from .loads import Loaded

_PORT, _SEEN, _LOADS, _BASE = len(PORTS.fields), len(SPOTS.fields), 2 * len(LOAD), BASE.beside
_STATE_PER_N, _STATE_BESIDE = STATE.per_n, STATE.beside
_SETTINGS, _BLOCK = GIVEN_SETTINGS.beside, GIVEN.beside


@leaf
def _samples(n, model, count, times, ax, az, scale):
    own = row_at(model)[engine.model_room(n) :]
    spotted, ports = int(own[0]), own[1:]
    return Loaded(count, row_at(times), row_at(ax), row_at(az), scale, False, count, spotted, ports, 0, ports, ports)


@kernel
def _assemble(column, given, from_rest, scratch, detail):
    """`engine.assemble`, and the ports."""
    n, state, behind = column.model.n, column.state.row, given[_SETTINGS + _BLOCK * column.model.n :]
    spotted = int(behind[0])
    copy(column.model.row[engine.model_room(n) :], behind, 1 + _PORT * spotted)
    code = engine.assemble(column, given, from_rest, scratch, detail)
    if code == OK and from_rest != 0:
        clear(state[_STATE_PER_N * n + _STATE_BESIDE :], _SEEN * spotted)
        clear(column.base.row[_BASE:], _LOADS * spotted)
    return code


ENTRIES = entries_of(samples_of=_samples, assembled=_assemble)
