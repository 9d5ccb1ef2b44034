"""The integration methods and their properties, for the stepping loop."""

import math
from typing import NamedTuple

from ...engine import dormand_prince as tableau_5
from ...engine import order_8 as tableau_8
from ...layout.spaces import OK, UNKNOWN_METHOD
from ...numba_ext.jit import kernel, leaf
from . import dormand_prince, modal, order_8, rosenbrock

NONE = 0
ORDER_5 = 1
ORDER_8 = 2
LINEARLY_IMPLICIT = 3
MODES = 4


class Traits(NamedTuple):
    """The properties of a method with error control."""

    order: int  # for the choice of step lengths
    implicit: bool
    holds: bool  # whether its steps are made with the joints held in their regimes, and end where one changes
    long: bool  # whether its steps are so long that the quintic inside them needs refinement
    inside: tuple[int, int, int]  # inner stages at which to look for a joint that leaves its regime and returns
    nodes: tuple[float, float, float]  # fractions of the step at which these are


@leaf
def traits_of(method):
    """Return the traits of a general method."""
    if method == ORDER_8:
        return Traits(tableau_8.ORDER, False, True, True, (4, 9, 10), (tableau_8.C4, tableau_8.C9, tableau_8.C10))
    if method == LINEARLY_IMPLICIT:
        return Traits(rosenbrock.ORDER, True, False, False, (1, 2, 3), (0.25, 0.5, 0.75))
    if method == ORDER_5:
        nodes = (tableau_5.C2, tableau_5.C3, tableau_5.C4)
        return Traits(tableau_5.ORDER, False, True, False, (2, 3, 4), nodes)
    return Traits(1, False, False, False, (1, 1, 1), (0.0, 0.0, 0.0))  # no method: `attempt_by` refuses it


@leaf
def explicit_method(order):
    """Return the explicit method of this order (`explicit_order` of the settings); NONE if there is none."""
    if order == tableau_8.ORDER:
        return ORDER_8
    return ORDER_5 if order == tableau_5.ORDER else NONE


@kernel
def attempt_by(method, column, t, h):
    """Make one step of `h` s by a method; return (code, error in tolerances)."""
    if method == ORDER_5:
        return OK, dormand_prince.attempt(column, t, h)
    if method == ORDER_8:
        return OK, order_8.attempt(column, t, h)
    if method == LINEARLY_IMPLICIT:
        return OK, rosenbrock.attempt(column, t, h)
    if method == MODES:
        return modal.attempt(column, t, h)
    return UNKNOWN_METHOD, math.inf
