"""The samples of a record."""

from ..numba_ext.jit import leaf

SAMPLE_SLACK = 1e-9  # relative to a sampling interval: closer times are equal


@leaf
def segment_at(samples, t):
    """Return the index of the last sample at time t (s) or before; -1 if there is none."""
    low, high = 0, samples.size
    while low < high:
        middle = (low + high) // 2
        if t < samples.times[middle]:
            high = middle
        else:
            low = middle + 1
    return low - 1
