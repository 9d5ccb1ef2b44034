"""The column at rest under its own weight: its stability there, and signs of mistaken units."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ...common import plausible
from ..protocol import NoRestError
from .model import Column
from .packing import FloatArray, carried_weights, pack_model, settlements

ITERATIONS = 4  # inverse iterations to the first mode, from a rigid rotation of the column


def check_rest(column: Column, from_rest: bool = True) -> None:
    """Warn (InputWarning) with each line of `warnings_of`.

    Raises NoRestError if a run starts `from_rest` and that rest is not stable.
    """
    if from_rest:
        check_stable(column)
    plausible.warn_of(known_warnings(column))


@lru_cache(maxsize=64)
def known_warnings(column: Column) -> tuple[str, ...]:
    """Return `warnings_of`, cached for repeated calls."""
    return tuple(warnings_of(column))


def check_stable(column: Column) -> None:
    """Raise NoRestError if the rest under gravity is not stable."""
    if not is_stable(column):
        raise NoRestError(instability(column))
    if column.off_axis or column.other_law:  # their rest is computed as the model is packed, which is cached
        pack_model(column)


def instability(column: Column) -> str:
    """Return the reason why a column whose rest is not stable cannot stand, in one line."""
    i = int(np.argmax(settlements(column))) + 1
    return (
        f"{column.name} cannot stand: its rest under gravity is not stable, the joints are too soft for the weight "
        f"above them (block[{i}].joint.stiffness = {column.blocks[i - 1].joint.stiffness:g} settles by "
        f"{settlements(column)[i - 1]:.3g} m); {plausible.UNITS_OF_STIFFNESS}"
    )


def warnings_of(column: Column) -> list[str]:
    """Return a line for each kind of value that is valid but probably unintended; mostly none.

    Of all blocks or joints with the same mistake, the line is about the worst.
    """
    # a block whose mass includes a load has its own centroid and inertia
    return _of_slopes(column) + plausible.lines_of(
        plausible.Facts(
            block_key=lambda i: f"block[{i + 1}]",
            block_name=lambda i: f"block {i + 1}",
            joint_key=lambda i: f"block[{i + 1}].joint",
            joint_name=lambda i: f"joint {i + 1}",
            mass=[block.mass for block in column.blocks],
            volume=[block.volume for block in column.blocks],
            loaded=[bool(block.centroid and block.inertia) for block in column.blocks],
            height=[block.height for block in column.blocks],
            g=column.g,
            laws=column.laws,
            area=[contact.area for contact in column.contacts],
            upper=range(column.n),
            carried=carried_weights(column).tolist(),
            damping_ratio=first_damping_ratio(column) if _may_be_strongly_damped(column) else 0.0,
            most_damped=plausible.MOST_DAMPED_ON_RIMS if column.stands_on_edges else plausible.MOST_DAMPED,
        )
    )


def _of_slopes(column: Column) -> list[str]:
    """Return a line on the first joint on which the blocks above slide under their weight."""
    each = zip(column.blocks, column.contacts, carried_weights(column).tolist(), strict=True)
    for i, (block, contact, carried) in enumerate(each):
        joint = block.joint
        slope, held = abs(joint.inclination or 0.0), (joint.dowel or 0.0) + joint.cohesion * contact.area
        if joint.friction is not None and carried * (math.sin(slope) - joint.friction * math.cos(slope)) > held:
            needed = f"needs {math.tan(slope) - held / (carried * math.cos(slope)):.3g}"
            line = f"block[{i + 1}].joint.friction = {joint.friction:g}: with inclination = {joint.inclination:g} it"
            return [f"{line} slides under its weight, {needed} to stand"]
    return []


def is_stable(column: Column) -> bool:
    """Return True if the rest under gravity, all joints in full contact, is a minimum of the potential energy.

    A column off its axis always passes: without a stable rest no model of it can be made.

    The energy is always a minimum over the openings. The rest is stable if elimination of the rotations leaves positive
    pivots only.
    """
    if column.off_axis:  # packing.py computes its rest and checks the stability when it makes the model
        return True
    pivot, coupling = math.inf, 0.0
    for diagonal, beside in zip(*_rocking_stiffness(column), strict=True):
        pivot = diagonal - coupling * coupling / pivot
        if not pivot > 0.0:
            return False
        coupling = beside
    return True


def _rocking_stiffness(column: Column) -> tuple[list[float], list[float]]:
    """Return diagonal and off-diagonal of the stiffness against the rotations of the blocks, gravity included (N m).

    With the openings of theory.md, section 4, the second derivatives of the potential energy with respect to the
    rotations form a symmetric tridiagonal matrix. The last off-diagonal entry couples the lowest block to the base.
    """
    diagonal, beside = [], []
    turned_above = spread_above = weight_above = 0.0
    for block, contact in zip(column.blocks, column.contacts, strict=True):
        area, _, second_moment = contact.moments
        stiffness, own = block.joint.stiffness, column.g * block.mass
        weight = weight_above + own
        turning = stiffness * second_moment
        spread = 0.25 * weight * weight / (stiffness * area)  # the compressed joint is shortened along its mean normal
        falling = weight_above * block.height + own * block.resolved_centroid
        diagonal.append(turning + turned_above + spread + spread_above - falling)
        beside.append(spread - turning)
        turned_above, spread_above, weight_above = turning, spread, weight
    return diagonal, beside


def _may_be_strongly_damped(column: Column) -> bool:
    """Return True if the damping ratio may be large, as its computation takes a tenth of a short run.

    One rigid block on the lowest joint is stiffer than the column in its first mode, and so has more damping.
    """
    base, eta = column.blocks[-1], max(block.joint.damping for block in column.blocks)
    if not eta:
        return False
    rise = inertia = falling = 0.0
    for block in reversed(column.blocks):
        place = rise + block.resolved_centroid
        inertia += block.resolved_inertia + block.mass * place * place
        falling += column.g * block.mass * place
        rise += block.height
    turning = base.joint.stiffness * column.contacts[-1].moments[2]
    left = turning - falling
    return left <= 0.0 or eta * turning > plausible.MOST_DAMPED * math.sqrt(left * inertia)


def first_damping_ratio(column: Column) -> float:
    """Return the damping ratio of the first sway mode, on its axis and without sliding; 0 if undamped or unstable.

    It is computed by inverse iteration, accurate enough for a warning; `modes.natural_modes` has it exactly.
    """
    eta = np.array([block.joint.damping for block in column.blocks])
    if not column.g or not np.any(eta) or not is_stable(column):
        return 0.0
    n = column.n
    diagonal, beside = (np.array(part) for part in _rocking_stiffness(column))
    stiffness = np.diag(diagonal) + np.diag(beside[:-1], 1) + np.diag(beside[:-1], -1)
    mass = np.array([block.mass for block in column.blocks])
    inertia = np.array([block.resolved_inertia for block in column.blocks])
    # displacement of the centroid of each block (row) for a rotation of 1 rad of each block (column)
    reach = np.triu(np.broadcast_to([block.height for block in column.blocks], (n, n)), 1)
    reach += np.diag([block.resolved_centroid for block in column.blocks])
    moduli = np.array([block.joint.stiffness for block in column.blocks])
    turning = moduli * np.array([contact.moments[2] for contact in column.contacts])

    def inertial(shape: FloatArray) -> FloatArray:
        return np.asarray(reach.T @ (mass * (reach @ shape)) + inertia * shape)

    shape = np.ones(n)
    for _ in range(ITERATIONS):
        try:
            shape = np.linalg.solve(stiffness, inertial(shape))
        except np.linalg.LinAlgError:
            return 0.0
        shape /= np.max(np.abs(shape))
    elastic = float(np.sum(eta * turning * np.diff(shape, append=0.0) ** 2))
    return elastic / (2.0 * math.sqrt(abs(float(shape @ stiffness @ shape) * float(shape @ inertial(shape)))))
