"""A structure in space as the C core has to know it."""

from __future__ import annotations

from solver.common.ranges import NUMBERS
from solver.kernels.api import pointers_of_structures as pointers_in_space
from solver.kernels.layout import spaces
from solver.kernels.structure import driven
from solver.kernels.structure import layout as at
from solver.models.structure.driven import CONTACT, REASONS, SKIP_CODES, sizes_of

from .. import rules
from ..body import StructureBody
from ..structure_variables import DAMPING_SCALE, OVERTURNED_BLOCK, WITHOUT
from ..variables import (
    OVERTURN_TIME,
    OVERTURNED,
    RECORD,
    RECORD_PGA,
    RECORD_SCALE,
    TOLERANCE,
    VERDICT,
    VERDICT_NOW,
)
from .table import Check, Chosen, Subject


def structure_subject(body: StructureBody) -> Subject:
    """Of a structure; its model and rest are numbers that never change."""
    n, m = body.structure.n, len(body.structure.joints)
    sizes = sizes_of(body.structure, body.packed)
    given = {"tolerance": TOLERANCE, "without": WITHOUT, "damping_scale": DAMPING_SCALE}
    return Subject(
        falls=True,
        sizes={
            **{"N": n, "MODEL": sizes.model, "STATE": sizes.state, "COUNTS": sizes.counts, "BASE": sizes.base},
            **{"WORK": sizes.work, "ROW": sizes.row, "SPLIT": 0, "ROOM": 1},
        },
        codes={
            "STATE_OVERTURN_TIME": at.CONTROL.fields.index("fall_time"),
            "PEAKS": sizes.row,
            "STATE_PEAKS": sizes.state - sizes.row,
            "PEAK_CONTACT": len(at.OF_BLOCK) * n + CONTACT * m,
            "CONTACTS": m,
            "COUNT_RESTING": at.COUNTS.fields.index("resting"),
            "COUNT_OVERTURNED": at.COUNTS.fields.index("fallen"),
            "TOO_MUCH_WORK": spaces.TOO_MUCH_WORK,
        }
        | {f"VERDICT_{word.upper()}": number for word, number in VERDICT.items.items()},
        places={
            "PEAKS": "block[1].ux_peak",
            "VERDICT": VERDICT_NOW.name,
            "OVERTURN_TIME": OVERTURN_TIME.name,
            "FALLEN": OVERTURNED_BLOCK.name,
            "OVERTURNED": OVERTURNED.name,
            "RECORD": RECORD,
            "RECORD_PGA": RECORD_PGA.name,
            "RECORD_SCALE": RECORD_SCALE,
            "TOLERANCE": TOLERANCE,
        },
        inputs=[f"base.{name}" for name in driven.INPUTS.fields],
        slopes={f"base.a{axis}": f"base.j{axis}" for axis in "xyz"},
        split="block[1].ux_peak",
        given=[*(given[name] for name in driven.GIVEN.fields), *body.packed.tolist()],
        choices=[Chosen(WITHOUT, "ANY_WORDS", [(code, word) for word, code in SKIP_CODES.items()])],
        checks=[
            Check(DAMPING_SCALE, *rules.DAMPING_SCALE_LIMITS),
            Check(TOLERANCE, *NUMBERS["tolerance"]),
            Check(RECORD_SCALE, *rules.SCALE_LIMITS),
        ],
        reasons=REASONS,
        entries=pointers_in_space.ENTRIES,
    )
