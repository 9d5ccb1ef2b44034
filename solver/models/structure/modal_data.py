"""The modes of a structure about its rest, in the form of the kernels (kernels/structure/modal_layout.py)."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...kernels.layout.spaces import MODE
from ...kernels.structure import layout as at
from ...kernels.structure import modal_layout as modal
from .blocks.faces import FloatArray
from .model import Structure
from .rest import SpatialRest, rest_of
from .stepper import SpatialStepper

MOST = 64  # blocks: the matrices grow with the square
APART = 1e-8  # relative coupling of two coordinates below which it is left to the remainder
IN_PLANE = (0, 2, 4)  # ux, uz, ry
# microseconds of a step by modes: fixed, per joint, mode, entry of the shapes; of an explicit step: fixed, per joint
OF_MODES = 1.3, 0.3, 0.1, 4.5e-3
OF_GENERAL = 1.0, 1.1


class ModalData(NamedTuple):
    """The modal data for the kernels, empty if there are none, and the reason for that."""

    numbers: FloatArray
    why_none: str


def modal_data_of(structure: Structure) -> ModalData:
    """Return the modal data of a structure whose rest is stable. Raises InputError."""
    if "elastic" in structure.without:
        return ModalData(np.zeros(0), "left out")
    if structure.neighbours:
        return ModalData(np.zeros(0), "neighbours may meet")
    return _modal_data(structure.blocks, structure.joints, structure.ties, structure.g)


@lru_cache(maxsize=64)
def _modal_data(*parts: object) -> ModalData:
    structure = Structure("structure", *parts)  # type: ignore[arg-type]
    rest = rest_of(structure)
    why = _reason_against_modes(structure, rest)
    return ModalData(np.zeros(0) if why else _numbers(structure, rest), why)


def _reason_against_modes(structure: Structure, rest: SpatialRest) -> str:
    n, m = structure.n, len(structure.joints)
    first = len(at.OF_BLOCK) * n + at.OF_JOINT.index("contact") * m
    if n > MOST:
        return f"more than {MOST} blocks"
    if not structure.weight > 0.0 or np.any(rest.row[first : first + m] < 1.0):
        return "no rest in full contact"
    stepper = SpatialStepper(structure)
    stepper.phase[:] = rest.phase
    stepper.observe()
    return "a joint slides at rest" if np.any(stepper.rates[at.PHASE.size(n) :]) else ""


def _numbers(structure: Structure, rest: SpatialRest) -> FloatArray:
    """Return the modal data, except for what `prepare` of kernels/structure/modal.py computes."""
    n, m, k = structure.n, len(structure.joints), len(structure.ties)
    stiffness, mass, places = _about_rest(structure, rest)
    groups, flat = _groups(stiffness, mass, n, structure.is_plane)
    matrices = sum(len(group) ** 2 for group in groups)
    sizes = 6 * n, at.remembered(structure.model.sizes), k, matrices
    numbers = np.zeros(modal.MODAL.size(sizes))
    data = modal.MODAL.see(numbers, sizes)
    # counts and costs
    limits, table = data.limits, data.coordinates
    limits.parts, limits.flat_parts = len(groups), flat
    limits.count, limits.flat_count = 6 * n, sum(map(len, groups[:flat]))
    limits.matrices = matrices
    limits.cost, limits.flat_cost = _cost(m, groups), _cost(m, groups[:flat])
    # coordinates at rest
    order = np.concatenate(groups)
    table.place[:], table.rest[:] = places[order], rest.phase[places[order]]
    table.group[: len(groups)] = [len(group) for group in groups]
    data.remembered[:] = rest.phase[at.PHASE.size(n) :][: sizes[1]]
    # shapes and records, group by group
    modes = data.modes.reshape(6 * n, -1)
    first = place = 0
    for group in groups:
        end, behind = first + len(group), place + len(group) ** 2
        square, shape, inverse = _modes(stiffness[np.ix_(group, group)], mass[np.ix_(group, group)])
        data.shapes[place:behind], data.inverses[place:behind] = shape.ravel(), inverse.ravel()
        _fill_modes(modes[first:end], structure, group, square, shape, inverse)
        first, place = end, behind
    return numbers


def _cost(m: int, groups: list[np.ndarray]) -> float:
    """Return the cost of a step by the modes of these groups relative to an explicit step, with m joints."""
    counts = 1.0, m, sum(map(len, groups)), sum(len(group) ** 2 for group in groups)
    return float(np.dot(OF_MODES, counts) / np.dot(OF_GENERAL, counts[:2]))


def _about_rest(structure: Structure, rest: SpatialRest) -> tuple[FloatArray, FloatArray, np.ndarray]:
    """Return stiffness and mass about rest in the coordinates of the kernels, body by body, and their phase indices."""
    n = structure.n
    see = at.PHASE.see(rest.phase, n)
    (to_base, mass), places = np.zeros((2, 6 * n, 6 * n)), np.zeros(6 * n, dtype=np.int64)
    for i, block in enumerate(structure.blocks):
        # rotations about the axes of the base by the coordinates
        v = np.array([see.q1[i], see.q2[i], see.q3[i]])
        across = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
        turn = np.eye(3) + 2.0 * (see.q0[i] * across + across @ across)
        first = 6 * i
        to_base[first : first + 3, first : first + 3] = np.eye(3)
        to_base[first + 3 : first + 6, first + 3 : first + 6] = np.linalg.inv(see.q0[i] * np.eye(3) - across)
        mass[first : first + 3, first : first + 3] = block.mass * np.eye(3)
        mass[first + 3 : first + 6, first + 3 : first + 6] = turn @ block.inertia @ turn.T
        places[first : first + 6] = np.array([0, 1, 2, 4, 5, 6]) * n + i
    stiffness = 0.5 * (rest.stiffness + rest.stiffness.T)
    return to_base.T @ stiffness @ to_base, to_base.T @ mass @ to_base, places


def _groups(stiffness: FloatArray, mass: FloatArray, n: int, is_plane: bool) -> tuple[list[np.ndarray], int]:
    """Return the groups of coupled coordinates, and the number of groups in the plane x, z, which come first."""
    sizes = np.sqrt(np.outer(np.diag(stiffness), np.diag(stiffness)))
    acts = (np.abs(stiffness) > APART * sizes) | (np.abs(mass) > APART * np.sqrt(np.outer(*2 * [np.diag(mass)])))
    flat = np.tile([axis in IN_PLANE for axis in range(6)], n)
    if is_plane:
        acts &= flat[:, None] == flat[None, :]
    # connected components
    groups: list[np.ndarray] = []
    left = np.ones(6 * n, dtype=bool)
    while np.any(left):
        inside = np.zeros(6 * n, dtype=bool)
        grows = np.arange(6 * n) == np.argmax(left)
        while np.any(grows & ~inside):
            inside |= grows
            grows = np.any(acts[inside], axis=0)
        groups.append(np.flatnonzero(inside))
        left &= ~inside
    if not is_plane:
        return groups, 0
    groups.sort(key=lambda group: not flat[group[0]])
    return groups, sum(bool(flat[group[0]]) for group in groups)


def _modes(stiffness: FloatArray, mass: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the squared frequencies (1/s2), the shapes of unit modal mass by columns, and the inverse shapes."""
    root = np.linalg.cholesky(mass)
    inverse = np.linalg.inv(root)
    squares, vectors = np.linalg.eigh(inverse @ stiffness @ inverse.T)
    return squares, inverse.T @ vectors, vectors.T @ root.T


def _fill_modes(
    modes: FloatArray,
    structure: Structure,
    group: np.ndarray,
    square: FloatArray,
    shape: FloatArray,
    inverse: FloatArray,
) -> None:
    """Fill in the records of the modes of a group of coordinates, a row for each; the last three are from `_modes`."""
    axis, body = group % 6, group // 6
    per = np.where(axis < 3, 1.0 / np.array([block.size for block in structure.blocks])[body], 1.0)
    parts = np.zeros((structure.n, 2, len(group)))
    np.add.at(parts, (body, axis // 3), (per[:, None] * shape) ** 2)
    fields = MODE.places
    modes[:, fields["square"]] = square
    modes[:, fields["size"]] = np.sqrt(np.max(parts, axis=(0, 1)))
    for name, along in (("push", 0), ("across", 1), ("lift", 2)):
        modes[:, fields[name]] = -np.sum(inverse[:, axis == along], axis=1)
