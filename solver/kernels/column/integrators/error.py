"""The norm of an error, for the step control of every integrator."""

from ...engine.control import worse
from ...numba_ext.jit import leaf
from ...numba_ext.lanes import magnitude
from ..joint.sliding import can_slide


@leaf
def error_in_tolerances(column, difference):
    """Return the largest error of coordinates and rates in a phase, relative to the allowed error.

    The allowed error is the tolerance times the largest rotation (rad) or rate (rad/s) so far, times the size that a
    coordinate has for a unit rotation.
    """
    blocks, control = column.model.blocks, column.state.control
    tolerance = column.model.settings.tolerance
    # zero, or zero in every lane
    error = 0.0 * tolerance
    rate_error = error
    for i in range(column.model.n):
        # rotations and openings, and their rates
        open_ = blocks.per_open_size[i]
        error = worse(error, magnitude(difference.theta[i]))
        error = worse(error, magnitude(difference.opening[i]) * open_)
        rate_error = worse(rate_error, magnitude(difference.theta_rate[i]))
        rate_error = worse(rate_error, magnitude(difference.opening_rate[i]) * open_)
        # slips as rotations
        if can_slide(column.model):
            slip = column.model.settings.per_slip
            error = worse(error, magnitude(difference.slip[i]) * slip)
            rate_error = worse(rate_error, magnitude(difference.slip_rate[i]) * slip)
    # relative to the largest rotation and the largest rate so far
    return worse(error / (tolerance * control.rotation_scale), rate_error / (tolerance * control.rate_scale))
