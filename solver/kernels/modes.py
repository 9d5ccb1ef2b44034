"""The modal data at the end of a packed model: limits, modes, shapes and their inverses (layout.py)."""

from .jit import leaf
from .layout import MODAL_LIMITS, MODE

_limits = MODAL_LIMITS.over
_mode = MODE.over
LIMITS = MODAL_LIMITS.beside
FIELDS = MODE.beside


@leaf
def limits_of(model):
    """The record of what limits the modal method."""
    return _limits(model.modal, 0)


@leaf
def mode_of(model, k):
    """The record of mode k of 2 n: first those of the rotations."""
    return _mode(model.modal[LIMITS + FIELDS * k :], 0)


@leaf
def shapes_of(model):
    """The row of the n x n matrices of shapes, by rows: of the rotations, then of the openings."""
    return model.modal[LIMITS + FIELDS * 2 * model.n :]


@leaf
def inverses_of(model):
    """The row of the inverses of the shapes, likewise."""
    return model.modal[LIMITS + FIELDS * 2 * model.n + 2 * model.n * model.n :]
