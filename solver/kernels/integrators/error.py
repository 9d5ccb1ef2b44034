"""The size of an error: what the step control of every integrator goes by."""

from ..jit import kernel
from ..layout import BLOCK_FIELDS, MODEL_HEADER, N_BLOCKS, OPEN_SIZE, TOLERANCE, TURN_SIZE


@kernel
def error_in_tolerances(model, work, difference, scale, rate_scale):
    """Largest of the 4 n errors of coordinates and rates at work[difference:], in parts of what is tolerated.

    Tolerated is the tolerance times scale (rad) or rate_scale (rad/s), times the size that a coordinate has for a unit
    rotation.
    """
    n = int(model[N_BLOCKS])
    error = 0.0
    unit = 1.0 / (model[TOLERANCE] * scale)
    for segment in range(4):  # rotations, openings, their rates
        if segment == 2:
            unit = 1.0 / (model[TOLERANCE] * rate_scale)
        field = OPEN_SIZE if segment % 2 else TURN_SIZE
        for i in range(n):
            part = abs(work[difference + segment * n + i]) * unit / model[MODEL_HEADER + BLOCK_FIELDS * i + field]
            if not part <= error:  # keeps a part that is not a number
                error = part
    return error
