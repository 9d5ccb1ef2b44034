"""The table of variables of a structure in space (variables.py has what it shares with that of a column).

Blocks, joints and ties have their numbers in the structure, from 1, and their descriptions have their names. The
outputs begin with one output row as the kernels write it (solver/kernels/structure/layout.py), then peaks in the same
order.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from solver.common.errors import InputError
from solver.ground.motion import STANDARD_GRAVITY
from solver.kernels.structure.layout import OF_BASE, OF_BLOCK, OF_JOINT
from solver.models.structure.model import Structure

from .references import FAMILY
from .rules import DAMPING_SCALE_LIMITS
from .variables import (
    LARGEST,
    LEAST,
    OVERTURN_TIME,
    OVERTURNED,
    RECORD,
    RECORD_PGA,
    RECORD_SCALE,
    RECORD_TEXT,
    RECORD_TEXT_NATIVE,
    SLOPE,
    TOLERANCE,
    VERDICT_NOW,
    Variable,
    input_of,
    output_of,
    parameter_of,
)

DAMPING_SCALE = "joints.damping_scale"
WITHOUT = "solver.without"
INPUTS = (
    input_of("base.ax", "Base acceleration along x", "m/s2", 1.0),
    input_of("base.ay", "Base acceleration along y", "m/s2", 1.0),
    input_of("base.az", "Base acceleration, vertical, positive up", "m/s2", 1.0),
    input_of("base.jx", SLOPE.format("x"), "m/s3", 10.0),
    input_of("base.jy", SLOPE.format("y"), "m/s3", 10.0),
    input_of("base.jz", SLOPE.format("z"), "m/s3", 10.0),
)
OVERTURNED_BLOCK = output_of(
    *("overturned_block", "", "Number of the block that has fallen, 0 while none has"),
    *("Integer", "discrete"),
    initially=(),
)
_OF_BLOCK = {
    "ux": ("m", "Centroid of {it} along x, relative to the base, from the structure as built and without weight"),
    "uy": ("m", "Centroid of {it} along y"),
    "uz": ("m", "Centroid of {it} upwards"),
    "rx": ("rad", "Rotation of {it}, axis times angle, about x"),
    "ry": ("rad", "Rotation of {it}, axis times angle, about y"),
    "rz": ("rad", "Rotation of {it}, axis times angle, about z"),
}
_OF_JOINT = {
    "N": ("N", "Normal force in {it}, compression"),
    "Mx": ("N.m", "Moment of the pressure about the first axis of {it}, restoring"),
    "My": ("N.m", "Moment of the pressure about the second axis of {it}, restoring"),
    "Tx": ("N", "Force along the first axis of {it} on its second block"),
    "Ty": ("N", "Force along the second axis of {it} on its second block"),
    "Mz": ("N.m", "Twisting moment in {it}, restoring"),
    "contact": ("", "Part of the area of {it} in contact"),
    "sigma_max": ("Pa", "Largest pressure on {it}"),
    "slip": ("m", "Slip of {it} that friction has given way by"),
}
_OF_TIE = {"F": ("N", "Force in {it}, tension")}
_OF_BASE = {
    "Fx": ("N", "Force of the structure on the base along x"),
    "Fy": ("N", "Force of the structure on the base along y"),
    "Fz": ("N", "Force of the structure on the base, upwards"),
    "Mx": ("N.m", "Moment of the structure on the base about x through the origin"),
    "My": ("N.m", "Moment of the structure on the base about y through the origin"),
    "Mz": ("N.m", "Moment of the structure on the base about z through the origin"),
}
_LIMITS: dict[str, dict[str, float]] = {
    "N": {"minimum": 0.0},
    "contact": {"minimum": 0.0, "maximum": 1.0},
    "sigma_max": {"minimum": 0.0},
    "slip": {"minimum": 0.0},
}


def structure_variables(structure: Structure, record: str = "", reads_files: bool = True) -> list[Variable]:
    """The table; as `variables` of a column. Raises InputError for a structure with too many joints or ties."""
    for what, parts in (("joint", structure.joints), ("tie", structure.ties)):
        if len(parts) > FAMILY:
            raise InputError(f"{what}: {len(parts)} of them, must be at most {FAMILY} in an FMU")
    outputs = row_outputs(structure)
    verdict = [OVERTURN_TIME, OVERTURNED_BLOCK, OVERTURNED, VERDICT_NOW, RECORD_PGA]
    text = RECORD_TEXT if reads_files else RECORD_TEXT_NATIVE
    parameters = [
        parameter_of(DAMPING_SCALE, "", "Factor on the damping of all joints and ties", 1.0, DAMPING_SCALE_LIMITS[0]),
        parameter_of(TOLERANCE, "", "Error relative to the largest motion", structure.tolerance),
        parameter_of(WITHOUT, "", "What is not to be done: peaks, of forces and moments", ", ".join(structure.without)),
        parameter_of(RECORD, "", text, record),
        parameter_of(RECORD_SCALE, "", "Factor on the record's accelerations", 1.0),
    ]
    return [*INPUTS, *outputs, *map(_peak, outputs), *verdict, *parameters]


def row_outputs(structure: Structure) -> list[Variable]:
    """The outputs of a row, in its order."""
    nominal = _sizes(structure)
    blocks = _named("block", structure.names)
    joints = _named("joint", structure.joint_names)
    ties = [f"tie {e}" for e in range(1, len(structure.ties) + 1)]
    kinds = (
        ("block", OF_BLOCK, _OF_BLOCK, blocks),
        ("joint", OF_JOINT, _OF_JOINT, joints),
        ("tie", tuple(_OF_TIE), _OF_TIE, ties),
    )
    rows = []
    for owner, fields, texts, names in kinds:
        for field in fields:
            unit, text = texts[field]
            words: dict[str, Any] = {"initially": (), "nominal": nominal[unit], **_LIMITS.get(field, {})}
            for i, name in enumerate(names, start=1):
                rows.append(output_of(f"{owner}[{i}].{field}", unit, text.format(it=name), **words))
    for field in OF_BASE:
        unit, text = _OF_BASE[field]
        rows.append(output_of(f"base.{field}", unit, text, nominal=nominal[unit], initially=()))
    return rows


def _named(owner: str, names: tuple[str, ...]) -> list[str]:
    return [f"{owner} {i} ({name})" for i, name in enumerate(names, start=1)]


def _peak(output: Variable) -> Variable:
    """The extreme of an output since the last reset."""
    is_contact = output.name.endswith("].contact")
    return output_of(
        output.name + ("_least" if is_contact else "_peak"),
        output.unit,
        f"{LEAST if is_contact else LARGEST}: {output.description}",
        variability="discrete",
        nominal=output.nominal,
        minimum=0.0,
        maximum=output.maximum,
        initially=(),
    )


def _sizes(structure: Structure) -> dict[str, float]:
    """Typical size of each output by its unit: solvers of a system scale by it."""
    corners = np.concatenate([block.corners for block in structure.blocks])
    extent = float(np.max(np.ptp(corners, axis=0)))
    weight = (structure.g or STANDARD_GRAVITY) * sum(block.mass for block in structure.blocks)
    area = min((joint.face.moments[0] for joint in structure.joints), default=1.0)
    return {
        "m": 1e-3 * extent,
        "rad": 1e-3,
        "N": weight,
        "N.m": weight * extent / 6.0,
        "": 1.0,
        "Pa": weight / area,
    }
