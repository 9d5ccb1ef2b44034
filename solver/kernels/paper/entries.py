"""The entries called from Python, with the arguments of those named alike in api/entries.py and batch/entries.py."""

from ..column.api.engine import column_in, reset
from ..column.api.entries import entries_of
from ..column.batch.entries import lanes_entry
from ..column.model.assembly import carries
from ..column.model.description import NO_REST, describe
from ..layout.spaces import OK
from ..numba_ext.jit import kernel
from . import outputs, stepping  # noqa: F401  versions of kernels
from .equations import MODEL, factorize_mass, settle
from .lanes import SPACE, follow_fixed_steps


@kernel
def _assemble(column, given, from_rest, scratch, detail):
    """Assemble the column at rest; return a code. from_rest and scratch are not used."""
    code = describe(column, given, detail)
    if code != OK:
        return code
    factorize_mass(column.model)
    reset(column)
    settle(column.model, column.state.phase)
    return OK if carries(column.model) else NO_REST


assemble, run, observe_state, observe_snapshots, arrive_base, couple_base, examine_base = entries_of(
    "paper", __name__, column_in(MODEL), assembled=_assemble
)
run_fixed_steps = lanes_entry("run_fixed_steps", "paper_lanes", __name__, SPACE, follow_fixed_steps)
