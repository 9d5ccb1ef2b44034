"""Bracketing of roots by false position with halved weights.

M. Dowell, P. Jarratt, BIT 11 (1971) 168-174, the Illinois algorithm; bisection if that leaves the bracket.
"""

from typing import NamedTuple

from ..numba_ext.jit import leaf


class Bracket(NamedTuple):
    """An interval and the function at its ends: not negative at lo, negative at hi.

    moved: the end that moved last, -1 for lo, 1 for hi, 0 for none.
    """

    lo: float
    hi: float
    at_lo: float
    at_hi: float
    moved: int


@leaf
def bracket(lo, hi, at_lo, at_hi):
    """Return a bracket that has not moved yet."""
    return Bracket(lo, hi, at_lo, at_hi, 0)


@leaf
def trial_within(known):
    """Return the next trial point."""
    # false position; bisection where rounding puts it outside
    trial = (known.lo * known.at_hi - known.hi * known.at_lo) / (known.at_hi - known.at_lo)
    return trial if known.lo < trial < known.hi else 0.5 * (known.lo + known.hi)


@leaf
def narrowed(known, trial, value):
    """Return the bracket after a trial; the value of an end that stays for the second time is halved."""
    # replace the end with the same sign
    if value < 0.0:
        return Bracket(known.lo, trial, known.at_lo * (0.5 if known.moved == 1 else 1.0), value, 1)
    # the value at hi is halved if lo moves for the second time
    return Bracket(trial, known.hi, value, known.at_hi * (0.5 if known.moved == -1 else 1.0), -1)
