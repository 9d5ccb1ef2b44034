"""The samples of a record: acceleration of the base, and loads on ports, for both kinds of models."""

from typing import NamedTuple

from ..numba_ext.jit import leaf

SAMPLE_SLACK = 1e-9  # relative to a sampling interval: closer times are equal


class Samples(NamedTuple):
    """A record: samples of the base acceleration, and of the loads on ports.

    The acceleration is zero before the first sample and after the last one.

    Attributes
    ----------
    size : int
        Number of times; 0 without a record.
    times : row
        Times (s), which may continue after the samples of the base.
    ax, ay, az : row
        Accelerations of the base (m/s2); ay is not read in a plane.
    scale : float
        Factor on the accelerations.
    held : int
        1 if each sample is held until the next; 0 if straight lines join them.
    shaken : int
        Number of samples of the base.
    loads : row
        Loads on ports on each segment by component, then their slopes, if there are any.
    loaded : int
        1 if there are loads.
    """

    size: int
    times: object
    ax: object
    ay: object
    az: object
    scale: float
    held: int
    shaken: int
    loads: object
    loaded: int


@leaf
def samples_over(times, ax, ay, az, scale, held, loads):
    """Return the record over sized rows of times, ax and loads, and rows of ay and az."""
    return Samples(times.size, times.row, ax.row, ay, az, scale, held, ax.size, loads.row, 1 if loads.size > 0 else 0)


@leaf
def unloaded(times, size, ax, ay, az, scale, held):
    """Return the record of `size` samples without loads."""
    return Samples(size, times, ax, ay, az, scale, held, size, times, 0)


@leaf
def no_samples(row):
    """Return a record without samples; row: any row of float64."""
    return unloaded(row, 0, row, row, row, 1.0, 0)


@leaf
def is_silent(samples, k):
    """Return True if the acceleration of the record is zero from sample k on until the next."""
    return k < 0 or k >= samples.shaken - 1


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


@leaf
def segment_from(samples, t):
    """Return the index of the sample from which a step that begins at time t (s) continues; -1 before the first.

    A sample that follows within rounding counts as reached.
    """
    k = segment_at(samples, t)
    if k + 1 < samples.size and samples.times[k + 1] - t <= _slack_after(samples, k):
        k += 1
    return k


@leaf
def segment_until(samples, t):
    """Return the index of the sample from which a step that ends at time t (s) comes; 0 at the first sample."""
    k = segment_from(samples, t)
    if k > 0 and t - samples.times[k] <= _slack_after(samples, k - 1):
        k -= 1
    return k


@leaf
def next_sample(samples, k, end):
    """Return the time (s) of the sample after number k, or `end` unless that is later by more than rounding."""
    if k + 1 < samples.size and end - samples.times[k + 1] > _slack_after(samples, k):
        return samples.times[k + 1]
    return end


@leaf
def _slack_after(samples, k):
    """Return the difference (s) up to which times after sample k, or before the first, are equal."""
    first = max(k, 0)
    return SAMPLE_SLACK * (samples.times[first + 1] - samples.times[first])
