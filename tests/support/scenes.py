"""The kernels' view of a structure, for compiled functions of tests."""

from solver.kernels.engine.samples import no_samples
from solver.kernels.numba_ext.jit import kernel
from solver.kernels.numba_ext.views import row_of
from solver.kernels.structure.entries import see


@kernel
def seen(arrays):
    """Return the scene of a structure, and its state as a row, over its arrays."""
    work = row_of(arrays[4])
    return see(row_of(arrays[0]), row_of(arrays[1]), row_of(arrays[2]), row_of(arrays[3]), no_samples(work), work)
