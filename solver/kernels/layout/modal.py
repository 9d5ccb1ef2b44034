"""The modal data at the end of a packed model: limits, modes, shapes and their inverses (spaces.py)."""

from ..numba_ext.jit import leaf
from .spaces import MODAL_LIMITS, MODE

_limits = MODAL_LIMITS.over
_mode = MODE.over
LIMITS = MODAL_LIMITS.beside
FIELDS = MODE.beside


@leaf
def limits_of(model):
    """Return the record of the limits of the modal method."""
    return _limits(model.modal, 0)


@leaf
def parts_of(model):
    """Return the number of separate modal problems: 2 on the axis (rotations and openings), else 1."""
    return int(limits_of(model).parts)


@leaf
def mode_at(modes, k):
    """Return record k of a row of modes."""
    return _mode(modes[FIELDS * k :], 0)


@leaf
def modes_of(model):
    """Return the row of the records of all 2 n modes, those of the first part first."""
    # behind the limits
    return model.modal[LIMITS:]


@leaf
def mode_of(model, k):
    """Return the record of mode k."""
    return mode_at(modes_of(model), k)


@leaf
def shapes_of(model):
    """Return the row of the square matrices of shapes, by rows, a matrix for each part."""
    # behind the limits and the 2 n modes
    return model.modal[LIMITS + FIELDS * 2 * model.n :]


@leaf
def inverses_of(model):
    """Return the row of the inverses of the shapes, stored as `shapes_of`."""
    # behind the shapes
    return model.modal[LIMITS + FIELDS * 2 * model.n + 4 * model.n * model.n :]
