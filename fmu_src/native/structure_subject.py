"""The description of a structure in space for the C core."""

from __future__ import annotations

from solver.common.ranges import NUMBERS
from solver.kernels.structure import driven, entries
from solver.kernels.structure import layout as at
from solver.models.structure.driven import REASONS, SKIP_CODES, sizes_in
from solver.models.structure.outputs import OUTPUTS

from .. import rules, structure_variables
from ..body import StructureBody
from ..structure_variables import DAMPING_SCALE, WITHOUT
from ..variables import RECORD_SCALE, TOLERANCE
from .column_subject import given_of, slopes_of, subject_of
from .table import FIRST_PEAK, NativeSubject, RangeCheck, peaks_of


def structure_subject(body: StructureBody) -> NativeSubject:
    """Return the description of a structure; its model and rest are constants."""
    sizes = sizes_in(body.packed)
    # arguments of `assemble`: parameters by name, and constants
    given: dict[str, str | float] = {"tolerance": TOLERANCE, "without": WITHOUT, "damping_scale": DAMPING_SCALE}
    given |= given_of(body.drive) | {"turns": float(body.drive.turns)}
    state = at.STATE.size(sizes)
    return subject_of(
        body,
        SKIP_CODES,
        sizes={
            "MODEL": at.MODEL.size(sizes),
            "STATE": state,
            "COUNTS": at.COUNTS.beside,
            "BASE": at.INPUT_MOTION.size(sizes),
            "WORK": at.WORK.size(sizes),
            "ROOM": 1,
        },
        codes={
            "STATE_OVERTURN_TIME": at.CONTROL.fields.index("fall_time"),
            "COUNT_RESTING": at.COUNTS.fields.index("resting"),
            "COUNT_OVERTURNED": at.COUNTS.fields.index("fallen"),
        },
        inputs=[item.name for item in body.inputs],
        slopes={f"base.a{axis}": f"base.j{axis}" for axis in "xyz"}
        | (_slopes_of_rotation() if body.drive.turns else {})
        | slopes_of(structure_variables.inputs_of_ports(body.model)),
        split="driven.x" if body.sizes[1] else FIRST_PEAK,
        given=[*(given[name] for name in driven.GIVEN.fields), *body.packed.tolist()],
        checks=[
            RangeCheck(DAMPING_SCALE, *rules.DAMPING_SCALE_LIMITS),
            RangeCheck(TOLERANCE, *NUMBERS["tolerance"]),
            RangeCheck(RECORD_SCALE, *rules.SCALE_LIMITS),
        ],
        reasons=REASONS,
        peaks=peaks_of(OUTPUTS, body.model.sizes, state),
        group=entries.follow.group,
    )


def _slopes_of_rotation() -> dict[str, str]:
    """Map the rotation of the base to its rate, and that to its acceleration."""
    names = [item.name for item in structure_variables.ROTATION]  # of both axes: angles, rates, accelerations
    return dict(zip(names[:4], names[2:], strict=True))
