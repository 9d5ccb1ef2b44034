"""Weights of the difference quotients by which the rates of outputs are computed."""

from ..numba_ext.jit import leaf


@leaf
def points(forward):
    """Return the number of instants of a difference quotient."""
    return 3 if forward else 2


@leaf
def point(forward, k, h):
    """Return instant k of a difference quotient, from its own on, s, and the weight of the value there, 1/s.

    Quotients are of order 2 in h (s): central, or forward from where bonds break, which are broken in the past, too.
    """
    if forward:
        return k * h, (-1.5 if k == 0 else 2.0 if k == 1 else -0.5) / h
    return (h, 0.5 / h) if k == 0 else (-h, -0.5 / h)
