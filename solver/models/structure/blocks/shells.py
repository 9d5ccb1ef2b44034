"""Checks of the shells of a closed mesh: whether they bound a solid once, and how many solids are separate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....common.errors import InputError, needing
from .faces import FloatArray

EXTRA = "mesh"
SAMPLES = 1000  # points of the surface at which the winding number is computed, at most
ANGLES = 2 * 10**7  # solid angles that are computed, about
CHUNK = 10**6  # solid angles computed at once
ROUNDED = 1e-4  # of the extent: solids that are closer than this, or overlap by less, touch
REPAIR = "repair = true (--repair) turns triangles"

IntArray = NDArray[np.int64]


def check_closed(faces: IntArray) -> None:
    """Raise InputError unless each edge is passed equally often in both directions, as Green's theorem requires."""
    ends, edge = _edges(faces)
    passed = np.bincount(edge)
    single = int(np.sum(passed % 2))
    if single:
        raise InputError(f"is not closed: {single} edges do not have two triangles, must be a closed mesh")
    forth = np.where(ends[:, 0] < ends[:, 1], 1, -1)
    if np.any(np.bincount(edge, weights=forth)):
        raise InputError(
            f"has triangles that look inwards beside others that look outwards, must be one closed mesh: {REPAIR}"
        )


def check_shells(corners: FloatArray, faces: IntArray) -> None:
    """Raise InputError if some point is enclosed by the mesh more than once, or a negative number of times.

    The winding number must be 0 or 1 on both sides of sampled points of the surface. A single shell whose edges all
    have two triangles is not sampled.
    """
    _, edge = _edges(faces)
    if np.max(np.bincount(edge)) == 2 and np.max(_components(edge.reshape(3, -1).T)) == 0:
        return
    triangles = corners[faces]
    winding = np.rint(_windings(_points_near_surface(triangles), triangles))
    if np.max(winding) > 1.0:
        raise InputError(
            f"has shells that overlap or repeat: part of its volume would count {int(np.max(winding))} times, must be "
            f"one surface around each solid, and one turned inwards around each void: {REPAIR} of voids"
        )
    if np.min(winding) < 0.0:
        raise InputError(f"has a shell turned inwards that lies in no solid, must look outwards: {REPAIR}")


def solids_apart(corners: FloatArray, faces: IntArray) -> int:
    """Return the number of solids that do not touch each other; a void is not counted."""
    shell = _components(faces)
    count = int(np.max(shell)) + 1
    if count == 1:
        return 1
    parts = [faces[shell == k] for k in range(count)]
    solids = [part for part in parts if volume_of(corners[part]) > 0.0]  # a void is none
    boxes = np.array([[np.min(corners[part], axis=(0, 1)), np.max(corners[part], axis=(0, 1))] for part in solids])
    near = ROUNDED * float(np.max(np.ptp(corners, axis=0)))
    meet = np.all(boxes[:, None, 0] <= boxes[None, :, 1] + near, axis=2)
    group = list(range(len(solids)))
    for one, other in np.argwhere(np.triu(meet & meet.T, 1)).tolist():
        if group[one] != group[other] and _gap(corners, solids[one], solids[other], 2.0 * near) <= near:
            group = [group[one] if k == group[other] else k for k in group]
    return len(set(group))


def repaired(corners: FloatArray, faces: IntArray) -> tuple[IntArray, int]:
    """Return the triangles turned so that shells look outwards and voids inwards, and how many were turned."""
    _, edge = _edges(faces)
    turned = _orientation(faces, edge.reshape(3, -1).T)
    made = np.where(turned[:, None], faces[:, ::-1], faces)
    shell = _components(edge.reshape(3, -1).T)
    for k in range(int(np.max(shell)) + 1):
        if volume_of(corners[made[shell == k]]) < 0.0:
            made[shell == k] = made[shell == k][:, ::-1]
            turned[shell == k] ^= True
    outwards = made.copy()
    for k in range(int(np.max(shell)) + 1):  # a shell enclosed by an odd number of others bounds a void
        own, others = corners[outwards[shell == k]], corners[outwards[shell != k]]
        if len(others) and np.median(np.rint(_windings(_points_near_surface(own), others))) % 2.0 == 1.0:
            made[shell == k] = made[shell == k][:, ::-1]
            turned[shell == k] ^= True
    return made, int(np.sum(turned))


def _edges(faces: IntArray) -> tuple[IntArray, IntArray]:
    """Return the ends of the edges of triangles, (3 k, 2), first edges of all first, and the index of each edge."""
    ends = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    _, edge = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    return ends, edge.ravel()


def _components(cells: IntArray) -> IntArray:
    """Return the connected component of each triangle; triangles that share an entry of `cells` (k, 3) are connected.

    cells: corners or edges of each triangle.
    """
    with needing(EXTRA, "scipy"):
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components
    count, size = len(cells), len(cells) + int(np.max(cells)) + 1
    links = np.repeat(np.arange(count), 3), count + cells.ravel()
    graph = coo_array((np.ones(3 * count, dtype=np.int8), links), shape=(size, size))
    component: IntArray = np.asarray(connected_components(graph, directed=False)[1][:count])
    return np.asarray(np.unique(component, return_inverse=True)[1]).ravel()


def _orientation(faces: IntArray, edges: IntArray) -> NDArray[np.bool_]:
    """Return the mask of triangles to turn so that neighbours pass their common edge in opposite directions.

    edges: (k, 3). Triangles are visited breadth first, over edges that have two triangles.
    """
    with needing(EXTRA, "scipy"):
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import breadth_first_order, connected_components
    k = len(faces)
    # pairs of triangles at each edge that has two, and whether both pass it in the same direction
    order = np.argsort(edges.T.ravel(), kind="stable")
    shared = edges.T.ravel()[order]
    first = np.flatnonzero((shared[1:] == shared[:-1]) & (np.bincount(shared)[shared[:-1]] == 2))
    one, other = order[first] % k, order[first + 1] % k
    ends = np.concatenate([faces[:, [j, (j + 1) % 3]] for j in range(3)])
    same = ends[order[first], 0] == ends[order[first + 1], 0]
    graph = coo_array((np.where(same, 2, 1), (one, other)), shape=(k, k)).tocsr()
    graph = graph.maximum(graph.T).tocsr()
    # propagate the orientation from one triangle of each component
    turned = np.zeros(k, dtype=bool)
    for component in np.unique(connected_components(graph, directed=False)[1], return_index=True)[1]:
        reached, before = breadth_first_order(graph, component, directed=False)
        for face in reached[1:].tolist():
            turned[face] = turned[before[face]] ^ (graph[face, before[face]] == 2)
    return turned


def volume_of(triangles: FloatArray) -> float:
    """Return the signed volume bounded by triangles (k, 3, 3), m3; negative if they look inwards."""
    a, b, c = np.moveaxis(triangles - np.mean(triangles, axis=(0, 1)), 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def _points_near_surface(triangles: FloatArray) -> FloatArray:
    """Return points close to both sides of a surface (k, 3, 3), (points, 3), spread by area; deterministic."""
    count = int(np.clip(ANGLES // (2 * len(triangles)), 20, SAMPLES))
    draw = np.random.default_rng(0)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = np.linalg.norm(normals, axis=1)
    chosen = np.searchsorted(np.cumsum(area), np.sum(area) * (np.arange(count) + 0.5) / count).clip(max=len(area) - 1)
    weights = draw.dirichlet(np.ones(3), count)
    points = np.einsum("ij,ijk->ik", weights, triangles[chosen])
    away = ROUNDED * float(np.max(np.ptp(triangles, axis=(0, 1)))) * normals[chosen] / area[chosen, None]
    return np.concatenate([points + away, points - away])


def _windings(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Return the winding number of a closed surface (k, 3, 3) about points: its solid angle over 4 pi.

    Solid angle of a triangle: A. van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125.
    """
    rows = max(1, CHUNK // len(triangles))
    total = np.empty(len(points))
    for begin in range(0, len(points), rows):
        a, b, c = np.moveaxis(triangles[None] - points[begin : begin + rows, None, None], 2, 0)
        la, lb, lc = (np.linalg.norm(side, axis=2) for side in (a, b, c))
        dots = np.sum(a * b, axis=2) * lc + np.sum(b * c, axis=2) * la + np.sum(c * a, axis=2) * lb
        angle = 2.0 * np.arctan2(np.sum(a * np.cross(b, c), axis=2), la * lb * lc + dots)
        total[begin : begin + rows] = np.sum(angle, axis=1) / (4.0 * np.pi)
    return total


def _gap(corners: FloatArray, one: IntArray, other: IntArray, most: float) -> float:
    """Return the distance of two shells, m, up to `most`; 0 if a shell is no manifold."""
    with needing(EXTRA, "manifold3d"):
        from manifold3d import Error, Manifold, Mesh64
    shells = []
    for part in (one, other):
        used, number = np.unique(part, return_inverse=True)
        shells.append(Manifold(Mesh64(corners[used], number.reshape(-1, 3).astype(np.uint64))))
    if any(shell.status() != Error.NoError for shell in shells):
        return 0.0
    return float(shells[0].min_gap(shells[1], most))
