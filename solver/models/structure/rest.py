"""The rest under weight, from the structure as built and without weight, by Newton's method; signs of mistaken units.

If joints may slide, the weight is applied in steps, and the joints remember each: a statically indeterminate structure
rests as if it had been built on falsework that is then slowly lowered.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from ...common import plausible
from ...common.errors import InputError
from ...kernels.structure import layout as at
from ..column.model import Column
from ..column.rest import known_warnings
from ..ports import Port
from ..protocol import NoRestError
from .blocks.faces import FloatArray
from .blocks.parts import OF_COLUMN, Pair, Solid, SpatialJoint, Tie
from .blocks.shapes import cross, rotated
from .model import Structure
from .packing import FLOOR, centroid_of
from .stepper import SpatialStepper

# steps of the weight if joints may slide; the next number if Newton's method does not converge. Of 56 colonnades whose
# moduli vary by 20 % six do not converge in four steps, all of them do in one; one and five agree to seven digits
LOADS = (4, 1, 5)
MOST_ITERATIONS = 200
MOST_BREAKS, MOST_MET = 20, 2  # times that a bond breaks further, or a pair meets or separates, before all balance
STILL = (0.0, 0.0, 0.0)
PUSHES = 5  # steps in which loads on ports are applied
CLOSE = 1e-11  # of the weight: residual
ROUGH = 1e-3  # of the weight: largest rounding error of the forces at rest
TOO_FAR_APART = "its numbers lie too far apart for its rest to be found"
MOST_PARTS = 5
PERTURBED = 1e-3  # of the settlement: differences for the tangent
OF_ONE = 0.1  # of the settlement of a joint under one block: differences for the tangent at rest
WIDER = 10.0, 100.0, 1000.0  # of them, where neighbours may press
STALLED = 1e-7  # of the weight: residual at which Newton's method may end between neighbours, whose forces have kinks
SOFTENING = 1e-4  # of the stiffness in full contact: first addition to a tangent that does not converge
# growth of the residual that steps may cause where a joint begins to slide, since it was to bear a part of the load of
# all blocks above it, and their number
GRACE, GRACES = 2.0, 10
ITERATIONS = 4  # inverse iterations to the first mode, from a sway of the structure


class SpatialRest(NamedTuple):
    """A structure at rest: phase, output row, tangent stiffness (entries.py)."""

    phase: FloatArray
    row: FloatArray
    stiffness: FloatArray


def rest_of(structure: Structure) -> SpatialRest:
    """Return the rest of a structure. Raises NoRestError if it has no stable rest, InputError if a block is free."""
    try:
        parts = structure.blocks, structure.joints, structure.ties, structure.g
        return _rest_of(*parts, structure.ports, structure.neighbours)
    except InputError as error:
        raise type(error)(f"{structure.name}: {error}") from None


@lru_cache(maxsize=64)
def _rest_of(
    blocks: tuple[Solid, ...],
    joints: tuple[SpatialJoint, ...],
    ties: tuple[Tie, ...],
    g: float,
    ports: tuple[Port, ...],
    neighbours: tuple[Pair, ...],
) -> SpatialRest:
    """Compute the rest from the parts of a structure: the settings of a run do not affect it."""
    structure = Structure("structure", blocks, joints, ties, g, ports=ports, neighbours=neighbours)
    if not joints:
        raise InputError("all blocks hang by ties, at least one must stand on a joint or a bearing")
    # the linear solution is the first guess and the scale of the differences
    linear = full_stiffness(structure)
    if not force_scale(structure) > 0.0:
        return _finished(SpatialStepper(structure), linear)
    # the weight, without gravity the pretensions
    load = weights(structure) if structure.weight > 0.0 else residual_of(SpatialStepper(structure))[0]
    slides = any(joint.bed.friction is not None for joint in structure.joints)
    try:
        settlement: FloatArray = np.linalg.solve(linear, load).astype(np.float64)
    except np.linalg.LinAlgError:
        raise InputError("some block is free to move") from None
    size = float(np.max(np.abs(settlement)))
    # differences, and those so small that no joint under the weight of one block opens
    close = deltas_of(structure, closed(structure))
    deltas = [PERTURBED * deltas_of(structure, part * size) for part in _parts_of(structure, size)]
    # ever smaller differences and other numbers of steps, until one converges
    for delta, loads in product(deltas, LOADS if slides else (1,)):
        stepper = _loaded(structure, linear, settlement, delta, loads)
        if stepper is not None:
            if _rounding(stepper.phase, linear, delta / delta[0]) > ROUGH * force_scale(structure):
                raise InputError(TOO_FAR_APART)
            sticks = sticking(stepper)
            tangents = [np.minimum(one, close) for one in (delta, *deltas[1:])]
            # aligned faces that press share less area at each side of this place: a kink that larger differences pass
            tangents += [close * wider for wider in WIDER if structure.neighbours]
            return _finished(stepper, *(sticks.stiffness(one) for one in tangents))
    moduli = sorted(joint.bed.stiffness for joint in structure.joints)
    apart = f", or its stiffnesses, {moduli[0]:g} to {moduli[-1]:g} N/m3, lie too far apart" if len(deltas) > 3 else ""
    raise NoRestError(f"no rest found, it does not stand under its weight{apart}")


def force_scale(structure: Structure) -> float:
    """Return the scale of the forces at rest: the weight, without gravity the sum of the pretensions, N."""
    return structure.weight or sum(tie.pretension for tie in structure.ties)


def _parts_of(structure: Structure, settlement: float) -> list[float]:
    """Return the fractions of the settlement from which differences for the tangent are made, the largest first.

    A stiff joint between soft ones opens, or slides, under a displacement that is small for the others.
    """
    stiffest = max(j.bed.stiffness * max(1.0, j.bed.shear_ratio) * j.moments[0] for j in structure.joints)
    ratio = settlement * stiffest / force_scale(structure)
    return [1.0, *(0.01**k for k in range(1, MOST_PARTS) if 10.0 ** (2 * k - 1) < ratio)]


def _loaded(
    structure: Structure, linear: FloatArray, settlement: FloatArray, delta: FloatArray, loads: int
) -> SpatialStepper | None:
    """Return a stepper in balance under the weight, applied in `loads` steps; None if a step finds no balance."""
    stepper = SpatialStepper(structure)
    ties, drawn = stepper.model.ties, np.array([tie.pretension / tie.stiffness for tie in structure.ties])
    length = ties.length[: len(drawn)].copy()
    move(stepper, settlement / loads)
    for step in range(1, loads + 1):
        # the same part of the weight and of pretensions
        stepper.model.settings.gravity = structure.g * step / loads
        ties.length[: len(drawn)] = length + (1.0 - step / loads) * drawn if step < loads else length
        if not settle(stepper, linear, delta, CLOSE * force_scale(structure)) or _has_fallen(stepper):
            return None
    return stepper


def _has_fallen(stepper: SpatialStepper) -> bool:
    """Return True if a block lies far below its place as built, or a face is tilted by over 90 degrees, as in runs."""
    joints, see = stepper.structure.joints, stepper.see
    turned = np.column_stack([np.array([see.q0, see.q1, see.q2, see.q3]), [1.0, 0.0, 0.0, 0.0]])  # the base comes last
    built = np.array([joint.face.axes[:, 2] for joint in joints]).T
    above, below = (rotated(turned[:, [getattr(joint, end) for joint in joints]], built) for end in ("upper", "lower"))
    tipped = np.sum(above * below, axis=0) < 0.0  # by the cosines between the normals of both faces
    return bool(np.any(tipped) or np.any(see.uz < -stepper.model.bodies.drop[: stepper.structure.n]))


def rest_in_steps(structure: Structure, loads: FloatArray) -> FloatArray | None:
    """Return the phase at rest under loads on the ports, (6, ports) N and N m, applied in steps; None if not found."""
    rest = rest_of(structure)
    stepper, linear = SpatialStepper(structure), full_stiffness(structure)
    stepper.phase[:] = rest.phase
    size = structure.model.names.settings.motion_floor * structure.model.names.settings.extent / FLOOR
    delta = PERTURBED * deltas_of(structure, size)
    for step in range(1, PUSHES + 1):
        for name, row in zip(at.LOAD, loads, strict=True):
            getattr(stepper.pushes, name)[:] = row * step / PUSHES
        close = CLOSE * max(structure.weight, float(np.max(np.abs(loads[:3]))))
        if not settle(stepper, linear, delta, close) or _has_fallen(stepper):
            return None
    return stepper.phase.copy()


def closed(structure: Structure) -> float:
    """Return a displacement so small that no joint under the weight of one block opens, m."""
    settings = structure.model.names.settings
    return float(OF_ONE * settings.motion_floor * settings.extent / FLOOR)


def sticking(stepper: SpatialStepper) -> SpatialStepper:
    """Return the same state with joints that stick: sliding joints have no symmetric stiffness."""
    other = stepper.over(model=stepper.arrays.model.copy())
    other.model.joints.friction[:] = np.inf
    return other


def _finished(stepper: SpatialStepper, *stiffnesses: FloatArray) -> SpatialRest:
    """Return the rest with the first of these tangents that is stable."""
    stepper.observe(keep=at.KEEP)
    for stiffness in stiffnesses:
        symmetric = 0.5 * (stiffness + stiffness.T)
        if not np.all(np.isfinite(symmetric)):
            raise InputError(TOO_FAR_APART)
        with suppress(np.linalg.LinAlgError):
            np.linalg.cholesky(symmetric)
            return SpatialRest(stepper.phase.copy(), stepper.row.copy(), stiffness)
    raise NoRestError("its rest is not stable, it falls without any motion")


def weights(structure: Structure) -> FloatArray:
    """Return the weights of the blocks as forces along the coordinates, N (6 n,)."""
    load = np.zeros(6 * structure.n)
    load[2::6] = [-structure.g * block.mass for block in structure.blocks]
    return load


def deltas_of(structure: Structure, settlement: float) -> FloatArray:
    """Return a displacement (m) and the rotations that move a block as far (rad), for each coordinate, (6 n,)."""
    sizes = np.array([block.size for block in structure.blocks])
    parts = np.column_stack([np.ones((structure.n, 3)), np.repeat(1.0 / sizes[:, None], 3, axis=1)])
    return (settlement * parts.ravel()).astype(np.float64)


def full_stiffness(structure: Structure) -> FloatArray:
    """Return the stiffness with all joints in full contact and all ties taut, as built, without weight, (6 n, 6 n)."""
    springs = []
    for joint in structure.joints:
        across, beside = joint.bed.stiffness, (0.0, 0.0)
        if joint.bearing is not None:  # a pendulum as under an equal part of the weight
            share = structure.weight / len(structure.bearings)
            beside = joint.bearing.spring, joint.bearing.pendulum * share
        springs.append((across, joint.bed.shear_ratio * across, beside))
    return _assembled(structure, springs, [tie.stiffness for tie in structure.ties])


@lru_cache(maxsize=64)
def fastest_decay(structure: Structure) -> float:
    """Return the fastest decay rate by the dampers (1/s), with all joints in full contact."""
    table, dashpots = structure.model.names.joints, []
    for j, joint in enumerate(structure.joints):
        along = table.shear[j] * table.shear_damping[j] / joint.moments[0]
        beside = joint.bearing.dashpot if joint.bearing is not None else 0.0
        dashpots.append((float(table.stiffness[j] * table.damping[j]), float(along), (beside, 0.0)))
    resisted = _assembled(structure, dashpots, [tie.damping for tie in structure.ties])
    for i, block in enumerate(structure.blocks):  # scale by the inverse Cholesky factor of the mass, from both sides
        part = np.zeros((6, 6))
        part[:3, :3] = np.eye(3) / math.sqrt(block.mass)
        part[3:, 3:] = np.linalg.inv(np.linalg.cholesky(block.inertia))
        rows = slice(6 * i, 6 * i + 6)
        resisted[rows] = part @ resisted[rows]
        resisted[:, rows] = resisted[:, rows] @ part.T
    return float(np.linalg.eigvalsh(resisted)[-1])


def _assembled(
    structure: Structure, joints: Sequence[tuple[float, float, tuple[float, float]]], ties: Sequence[float]
) -> FloatArray:
    """Assemble springs or dashpots in the coordinates of the blocks, (6 n, 6 n).

    `joints` has those across and along each joint, per area, and the two in parallel with the slider of a bearing:
    spring and pendulum. `ties` has those along the ties.
    """
    n = structure.n
    matrix = np.zeros((6 * (n + 1), 6 * (n + 1)))
    for joint, (across, along, beside) in zip(structure.joints, joints, strict=True):
        area, ixx, iyy, ixy = joint.moments
        own = np.diag([along * area, along * area, across * area, across * iyy, across * ixx, along * (ixx + iyy)])
        own[3, 4] = own[4, 3] = -across * ixy
        if joint.bearing is not None:  # of a point
            along = along * area + beside[0] + beside[1]
            own = np.diag([along, along, across * area, 0.0, 0.0, 0.0])
        motion = np.zeros((6, 12))
        for k, (body, sign) in enumerate(((joint.upper, 1.0), (joint.lower, -1.0))):
            motion[:, 6 * k : 6 * k + 6] = sign * moved_with(structure, joint.face.axes, joint.face.centre, body)
        _add(matrix, motion.T @ own @ motion, joint.upper, joint.lower)
    for tie, pull in zip(structure.ties, ties, strict=True):
        ends = [centroid_of(structure.blocks, tie.one) + tie.from_, centroid_of(structure.blocks, tie.other) + tie.to]
        way = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        parts = [
            -way @ moved_with(structure, np.eye(3), ends[0], tie.one)[:3],
            way @ moved_with(structure, np.eye(3), ends[1], tie.other)[:3],
        ]
        motion = np.concatenate(parts)[None, :]
        _add(matrix, pull * motion.T @ motion, tie.one, tie.other)
    return matrix[: 6 * n, : 6 * n]


def moved_with(structure: Structure, axes: FloatArray, point: FloatArray, body: int) -> FloatArray:
    """Return the displacement and rotation, along axes, at a point of a body per coordinate of the body, (6, 6)."""
    x, y, z = point - centroid_of(structure.blocks, body)
    lever = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    found = np.zeros((6, 6))
    found[:3, :3] = found[3:, 3:] = axes.T
    found[:3, 3:] = axes.T @ lever
    return found


def _add(matrix: FloatArray, part: FloatArray, one: int, other: int) -> None:
    places = np.concatenate([6 * one + np.arange(6), 6 * other + np.arange(6)])
    matrix[np.ix_(places, places)] += part


def move(stepper: SpatialStepper, change: FloatArray) -> None:
    """Move and rotate the blocks by small amounts along and about the axes of the base, (6 n,)."""
    parts, see = change.reshape(-1, 6), stepper.see
    see.ux += parts[:, 0]
    see.uy += parts[:, 1]
    see.uz += parts[:, 2]
    half = 0.5 * parts[:, 3:].T
    scalar = np.sqrt(np.maximum(0.0, 1.0 - np.sum(half**2, axis=0)))
    q0, q = see.q0.copy(), np.array([see.q1, see.q2, see.q3])
    see.q0[:] = scalar * q0 - np.sum(half * q, axis=0)
    see.q1[:], see.q2[:], see.q3[:] = scalar * q + q0 * half + cross(half, q)


def change_between(phase: FloatArray, other: FloatArray, n: int) -> FloatArray:
    """Return the small displacements and rotations that `move` one phase of n blocks to the other, (6 n,)."""
    one, two = at.PHASE.see(phase, n), at.PHASE.see(other, n)
    before, after = np.array([one.q1, one.q2, one.q3]), np.array([two.q1, two.q2, two.q3])
    half = one.q0 * after - two.q0 * before + cross(before, after)
    return np.concatenate([[two.ux - one.ux, two.uy - one.uy, two.uz - one.uz], 2.0 * half]).T.ravel()


def residual_of(stepper: SpatialStepper, base: Sequence[float] | FloatArray = STILL) -> tuple[FloatArray, float]:
    """Return the residual forces and moments on the blocks, N and N m (6 n,), and the energy, J.

    They are along and about the axes of the base. base: its acceleration along x, y, z, m/s2.
    """
    ax, ay, az = base
    energy = stepper.observe(ax, ay, az)
    n, see = stepper.structure.n, stepper.see
    # moments from rates of spin, rotated from the axes of the bodies to those of the base
    rates, bodies = at.PHASE.see(stepper.rates, n), stepper.model.bodies
    own = np.array(
        [
            bodies.jxx[:n] * rates.wx + bodies.jxy[:n] * rates.wy + bodies.jxz[:n] * rates.wz,
            bodies.jxy[:n] * rates.wx + bodies.jyy[:n] * rates.wy + bodies.jyz[:n] * rates.wz,
            bodies.jxz[:n] * rates.wx + bodies.jyz[:n] * rates.wy + bodies.jzz[:n] * rates.wz,
        ]
    )
    with np.errstate(over="ignore", invalid="ignore"):  # a step of Newton's method may go far beyond a rest
        moments = rotated(np.array([see.q0, see.q1, see.q2, see.q3]), own)
    forces = bodies.mass[:n] * np.array([rates.vx, rates.vy, rates.vz])
    return np.concatenate([forces, moments]).T.ravel(), energy


def largest_of(residual: FloatArray, per: FloatArray) -> float:
    """Return the largest component of a residual as a force, N; `per` converts moments."""
    return float(np.max(np.abs(residual * per)))


def settle(
    stepper: SpatialStepper,
    linear: FloatArray,
    delta: FloatArray,
    close: float,
    base: Sequence[float] | FloatArray = STILL,
) -> bool:
    """Find the balance as `balance`, in which no bond breaks and no pair of neighbours meets or separates.

    Bonds that break and pairs that meet pass load to others. A crack that runs by itself has no balance; it grows from
    the one of the bonds that are left. Return True if there is a balance.
    """
    structure, left = stepper.structure, 0.0
    changes = bool(structure.bonds or structure.neighbours)
    for _ in range(1 + MOST_BREAKS * len(structure.bonds) + MOST_MET * len(structure.neighbours)):
        if structure.neighbours:
            stepper.observe(keep=at.PRESUME)
        before = stepper.phase.copy()
        balances = balance(stepper, linear, delta, close, base)
        if structure.bonds and not balances:
            stepper.phase[:] = before
            stepper.bonds.held[:] = 1.0
            balances = balance(stepper, linear, delta, close, base)
            stepper.bonds.held[:] = 0.0
        if not balances:
            return False
        stepper.observe(base[0], base[1], base[2], keep=at.KEEP)
        if changes:
            left = largest_of(residual_of(stepper, base)[0], delta / delta[0])
            if left <= close:
                break
    return left <= ROUGH * force_scale(structure)


def balance(
    stepper: SpatialStepper,
    linear: FloatArray,
    delta: FloatArray,
    close: float,
    base: Sequence[float] | FloatArray = STILL,
) -> bool:
    """Find balance by Newton's method; return True if it converges.

    The phase of the stepper is the first guess and becomes the result. `linear` is the stiffness in full contact (6 n,
    6 n); `delta` (6 n,) has the differences for the tangent, m and rad; `close` is the residual at which the method
    ends, N; `base` the acceleration of the base, m/s2.

    If a step reduces neither the residual nor the energy, the tangent is stiffened. Near collapse the residual grows
    along the path to a rest while the energy falls; with friction or loads on ports there is no such potential. A
    residual that no longer decreases and is below its rounding error counts as zero, as with a stiff joint between soft
    ones.
    """
    per = delta / delta[0]  # converts moments to forces by the size of the block
    left, energy = residual_of(stepper, base)
    size = largest_of(left, per)
    softening, graces = 0.0, GRACES
    # the energy does not include the work of loads
    pushed = np.any(base) or any(np.any(getattr(stepper.pushes, name)) for name in at.LOAD)
    potential = bool(np.all(np.isinf(stepper.model.joints.friction))) and not pushed
    tangent = stepper.stiffness(delta)
    for _ in range(MOST_ITERATIONS):
        if size <= close:
            return True
        before, new, lower = stepper.phase.copy(), math.inf, math.inf
        with suppress(np.linalg.LinAlgError):
            change: FloatArray = np.linalg.solve(tangent + softening * linear, left).astype(np.float64)
            move(stepper, change)
            now, lower = residual_of(stepper, base)
            new = largest_of(now, per)
        # accept a residual of rounding errors, a smaller one, a few larger ones, or a lower energy; else stiffen
        if new >= size and size <= _rounding(before, linear, per):
            stepper.phase[:] = before
            return True
        graced = graces > 0 and not potential and size <= new < GRACE * size
        graces -= graced
        if new < size or graced or (potential and lower < energy):
            left, size, energy = now, new, lower
            softening = 0.1 * softening if softening > SOFTENING else 0.0
            tangent = stepper.stiffness(delta)
        else:
            stepper.phase[:] = before
            softening = max(SOFTENING, 4.0 * softening)
            if softening > 1e3:
                break
    return bool(stepper.structure.neighbours) and size <= STALLED * force_scale(stepper.structure)


def _rounding(phase: FloatArray, linear: FloatArray, per: FloatArray) -> float:
    """Return the rounding error of the forces on the blocks in a phase, N; moments count times `per`."""
    see = at.PHASE.see(phase, len(per) // 6)
    place = np.array([see.ux, see.uy, see.uz, 2.0 * see.q1, 2.0 * see.q2, 2.0 * see.q3]).T.ravel()
    return float(np.finfo(np.float64).eps * np.max(per * (np.abs(linear) @ np.abs(place))))


# --- values that are valid but probably unintended (common/plausible.py)


@lru_cache(maxsize=64)
def known_warnings_in_space(structure: Structure, at_rest: bool = True) -> tuple[str, ...]:
    """Return warnings of implausible values of a structure, a line each; those of the column's file for a stack.

    at_rest: also check what follows from the rest, if there is one.
    """
    if structure.is_stack:
        return known_warnings(Column.from_dict(structure.to_dict()[OF_COLUMN]))
    rest = None
    if at_rest:
        with suppress(InputError):
            rest = rest_of(structure)
    # facts by block and by joint
    blocks, beds = structure.blocks, structure.laws
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
        laws=beds,
        area=[joint.moments[0] for joint in structure.joints],
        upper=[joint.upper for joint in structure.joints],
        carried=[] if rest is None else rest.row[first : first + len(beds)].tolist(),
        damping_ratio=0.0 if rest is None else _first_damping_ratio(structure, rest),
        most_damped=plausible.MOST_DAMPED_ON_RIMS if any(bed.rim for bed in beds) else plausible.MOST_DAMPED,
    )
    return tuple(plausible.lines_of(facts))


def _first_damping_ratio(structure: Structure, rest: SpatialRest) -> float:
    """Return the damping ratio of the first sway mode, all joints in full contact; 0 without damping or weight.

    It is found by inverse iteration, accurately enough for a warning; `modes_in_space` computes it exactly.
    """
    if not any(bed.damping for bed in structure.laws) or not structure.weight > 0.0:
        return 0.0
    # damping matrix of the joints; bearings and ties are meant to damp
    rates = [(bed.damping * bed.stiffness, bed.shear_ratio) for bed in structure.laws]
    dashpots = [(across, ratio * across, (0.0, 0.0)) for across, ratio in rates]
    dampers = _assembled(structure, dashpots, [0.0] * len(structure.ties))
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
