"""Blocks in space, drawn from behind to the front: a block hides what lies behind one of its faces, exactly."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_hex, to_rgb
from mpl_toolkits.mplot3d.proj3d import proj_transform
from numpy.typing import NDArray

from ..models.structure.blocks.faces import FloatArray
from ..models.structure.blocks.parts import Solid
from ..models.structure.blocks.shapes import turned
from ..models.structure.model import Structure

STONE, EDGE = "#d9d2c3", "#6b6558"
SIDES = 24
LIGHT = np.array([-0.35, -0.6, 0.72])
SHADES = np.linspace(0.66, 1.0, 5)  # few, so that a GIF has a colour for each
SHADED = [to_hex(shade * np.array(to_rgb(STONE))) for shade in SHADES]
MOST_ORDERED = 200  # blocks; more are sorted by depth alone
AT_ONCE = 10  # blocks, for which the order is found again at every picture


class Solids(PolyCollection):
    """The faces of all blocks that are seen, in axes in space of parallel projection."""

    def __init__(self, structure: Structure) -> None:
        super().__init__([], linewidths=0.5, edgecolors=EDGE, zorder=1.0)
        self._centre = np.array([block.centroid for block in structure.blocks])
        faces, normals, edged = [], [], []
        meshed = np.array([len(block.surface) > 0 for block in structure.blocks])
        for i, block in enumerate(structure.blocks):
            for face, has_edges in surfaces(block):
                normal = _normal(face, None if meshed[i] else self._centre[i])
                faces.append((i, face))
                normals.append(normal)
                edged.append(has_edges)
                if not (has_edges or meshed[i]):  # the rims of a drum
                    faces += (i, face[:2]), (i, face[2:])
                    normals += normal, normal
                    edged += True, True
        self._n = structure.n
        self._owner = np.array([i for i, _ in faces])
        self._edged = np.array(edged)
        self._counts = np.array([len(face) for _, face in faces])
        self._starts = np.concatenate([[0], np.cumsum(self._counts)])
        self._of = np.repeat(self._owner, self._counts)
        whole = (self._edged | meshed[self._owner]) & (self._counts > 2)
        self._whole = np.repeat(whole, self._counts)  # corners of the faces of blocks
        self._built = np.concatenate([face for _, face in faces])
        self._normals = np.array(normals)
        self._every, self._seen, self._order = -(-self._n // AT_ONCE), 0, np.arange(self._n)
        self._points, self._outward = self._built, self._normals
        self.place(np.zeros((self._n, 3)), np.zeros((self._n, 3)))

    def place(self, u: FloatArray, turn: FloatArray) -> None:
        """Displace the blocks by u, m (n, 3), and turn them, rad (n, 3)."""
        arms = self._built - self._centre[self._of]
        self._points = self._built + u[self._of] + turned(turn[self._of], arms)
        self._outward = turned(turn[self._owner], self._normals) + self._normals

    @property
    def points(self) -> FloatArray:
        """Corners of all faces where they are now, m (corners, 3)."""
        return self._points

    def do_3d_projection(self) -> float:
        """Called by the axes before they draw."""
        axes: Any = self.axes
        towards = _towards_viewer(axes)
        if self._seen % self._every == 0:
            self._order = self._from_behind(towards)
        self._seen += 1
        x, y, _ = proj_transform(*self._points.T, axes.M)
        flat, rank = np.column_stack([x, y]), np.argsort(self._order)
        visible = np.flatnonzero(self._outward @ towards > 1e-9)
        depth = np.add.reduceat(self._points @ towards, self._starts[:-1]) / self._counts  # within a mesh
        visible = visible[np.lexsort((depth[visible], rank[self._owner[visible]]))]
        self.set_verts([flat[self._starts[f] : self._starts[f + 1]] for f in visible])
        light = np.clip(self._outward[visible] @ (LIGHT / np.linalg.norm(LIGHT)), 0.0, 1.0)
        shade = SHADES[np.rint(light * (len(SHADES) - 1)).astype(int)]
        colours = shade[:, None] * np.array(to_rgb(STONE))
        self.set_facecolor(colours)
        edges: Any = np.where(self._edged[visible, None], np.array(to_rgb(EDGE)), colours)
        self.set_edgecolor(edges)
        return 0.0

    def _from_behind(self, towards: FloatArray) -> NDArray[np.intp]:
        """Numbers of the blocks from the farthest on: of two, the one beyond a face of the other that looks here."""
        depth = np.array([np.mean(self._points[self._of == i] @ towards) for i in range(self._n)])
        if self._n > MOST_ORDERED:
            return np.argsort(depth)
        planes = np.flatnonzero(self._counts > 2)  # of the others, which are rims, no corner is needed either
        outward, owner = self._outward[planes], self._owner[planes]
        offset = np.einsum("fk,fk->f", outward, self._points[self._starts[planes]])
        facing, begins = outward @ towards, np.searchsorted(owner, np.arange(self._n))
        beyond = np.full((self._n, self._n), -np.inf)  # how far j is beyond the best face of i
        front = np.zeros((self._n, self._n))  # of that face: > 0 looks to the viewer
        for j in range(self._n):
            gaps = np.min(outward @ self._points[self._whole & (self._of == j)].T, axis=1) - offset
            beyond[:, j] = np.maximum.reduceat(gaps, begins)
            best = np.flatnonzero(gaps >= beyond[owner, j])
            front[:, j] = facing[best[np.searchsorted(owner[best], np.arange(self._n))]]
        ahead = np.where(beyond >= beyond.T, front, -front.T)  # > 0: j is before i
        ahead[np.abs(ahead) < 1e-9] = 0.0
        np.fill_diagonal(ahead, 0.0)
        order: list[int] = []
        left = list(np.argsort(depth))
        while left:
            free = (i for i in left if not np.any(ahead[np.array(left), i] > 0.0))
            order.append(next(free, left[0]))  # a circle of three or more: the farthest
            left.remove(order[-1])
        return np.array(order)


def surfaces(block: Solid) -> list[tuple[FloatArray, bool]]:
    """Polygons of the surface of a block as built, (corners, 3) m each, and whether it has edges.

    A drum's side is in strips, which have none, two corners below and two above; of a mesh the triangles have none.
    """
    if len(block.surface):
        return [(triangle, False) for triangle in block.surface]
    found = [(face.points(SIDES), True) for face in block.faces]
    round_faces = [face for face in block.faces if face.radius]
    if len(round_faces) == 2:
        low, high = (face.points(SIDES) for face in round_faces)
        high = np.roll(high[::-1], 1, axis=0)  # seen from the other side
        found += [(np.array([low[k - 1], low[k], high[k], high[k - 1]]), False) for k in range(SIDES)]
    elif len(block.faces) == 2:  # a box that tapers
        low, high = (face.points() for face in block.faces)
        high = high[[int(np.argmin(np.linalg.norm(high[:, :2] - corner[:2], axis=1))) for corner in low]]
        found += [(np.array([low[k - 1], low[k], high[k], high[k - 1]]), True) for k in range(len(low))]
    return found


def _normal(face: FloatArray, centre: FloatArray | None) -> FloatArray:
    """The unit vector out of a face of a body around `centre`; None: to the side from which it turns to the left."""
    found = np.sum(np.cross(face, np.roll(face, -1, axis=0)), axis=0)
    found = found / max(float(np.linalg.norm(found)), 1e-300)
    if centre is None:
        return found
    outward: FloatArray = found * np.sign((np.mean(face, axis=0) - centre) @ found)
    return outward


def _towards_viewer(axes: Any) -> FloatArray:
    elevation, azimuth = np.deg2rad(axes.elev), np.deg2rad(axes.azim)
    level = np.cos(elevation)
    return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
