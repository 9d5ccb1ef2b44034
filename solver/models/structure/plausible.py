"""The data of a structure in space for the checks of plausibility in common/plausible.py."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ...common import plausible
from ...common.errors import InputError
from ..column.model import Column
from ..column.rest import known_warnings
from .blocks.faces import FloatArray
from .blocks.parts import OF_COLUMN, Bearing
from .model import Structure
from .rest import Rest, full_stiffness, rest_of

ITERATIONS = 4  # of inverse iteration, from a sway of the structure


@lru_cache(maxsize=64)
def known_warnings_in_space(structure: Structure, at_rest: bool = True) -> tuple[str, ...]:
    """Return warnings of implausible values of a structure, a line each; those of the column's file for a stack.

    at_rest: also check what follows from the rest, if there is one.
    """
    rest = None
    if at_rest:
        with suppress(InputError):
            rest = rest_of(structure)
    if structure.is_stack:
        return known_warnings(Column.from_dict(structure.to_dict()[OF_COLUMN]))
    # facts by block and by joint
    blocks, beds = structure.blocks, [joint.bed for joint in structure.joints]
    first = 6 * structure.n
    facts = plausible.Facts(
        block_key=lambda i: f"block[{structure.names[i]}]",
        block_name=lambda i: structure.names[i],
        joint_key=lambda j: f"joint[{structure.joint_names[j]}]",
        joint_name=lambda j: f"joint[{structure.joint_names[j]}]",
        mass=[block.mass for block in blocks],
        volume=[block.volume for block in blocks],
        loaded=[False] * structure.n,
        height=[float(np.ptp(block.corners[:, 2])) for block in blocks],
        g=structure.g,
        stiffness=[bed.stiffness for bed in beds],
        damping=[bed.damping for bed in beds],
        friction=[bed.friction for bed in beds],
        strength=[bed.strength for bed in beds],
        area=[joint.moments[0] for joint in structure.joints],
        upper=[joint.upper for joint in structure.joints],
        carried=[] if rest is None else rest.row[first : first + len(beds)].tolist(),
        damping_ratio=0.0 if rest is None else _first_damping_ratio(structure, rest),
        most_damped=plausible.MOST_DAMPED_ON_RIMS if any(bed.rim for bed in beds) else plausible.MOST_DAMPED,
    )
    return tuple(plausible.lines_of(facts))


def _first_damping_ratio(structure: Structure, rest: Rest) -> float:
    """Return the damping ratio of the first sway mode, all joints in full contact; 0 without damping or weight.

    It is found by inverse iteration, accurately enough for a warning; `modes_in_space` computes it exactly.
    """
    damping = [joint.bed.damping for joint in structure.joints]
    if not any(damping) or not structure.weight > 0.0:
        return 0.0
    # damping matrix: a stiffness matrix of the dashpots
    moduli = [joint.bed.damping * joint.bed.stiffness for joint in structure.joints]
    joints = structure.with_joints(moduli, damping).joints  # bearings are meant to damp
    joints = tuple(replace(joint, bearing=joint.bearing and Bearing(joint.bearing.kind)) for joint in joints)
    dampers = full_stiffness(replace(structure, joints=joints, described=None))
    inertia = np.zeros((structure.n, 6, 6))
    for own, block in zip(inertia, structure.blocks, strict=True):
        own[:3, :3], own[3:, 3:] = block.mass * np.eye(3), block.inertia
    stiffness = 0.5 * (rest.stiffness + rest.stiffness.T)

    def inertial(shape: FloatArray) -> FloatArray:
        return np.einsum("bij,bj->bi", inertia, shape.reshape(-1, 6)).ravel()

    # inverse iteration, then the Rayleigh quotients
    shape = np.tile([1.0, 0.7, 0.0, 0.0, 0.0, 0.0], structure.n)
    for _ in range(ITERATIONS):
        shape = np.linalg.solve(stiffness, inertial(shape))
        shape /= np.max(np.abs(shape))
    elastic, kinetic = float(shape @ stiffness @ shape), float(shape @ inertial(shape))
    ratio = float(shape @ dampers @ shape) / (2.0 * math.sqrt(abs(elastic * kinetic)))
    return ratio if math.isfinite(ratio) else 0.0
