"""Blocks in space, drawn from back to front with exact occlusion by the planes of their faces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_hex, to_rgb
from mpl_toolkits.mplot3d.proj3d import proj_transform
from numpy.typing import NDArray

from ..models.structure.blocks.faces import FloatArray
from ..models.structure.blocks.shapes import turned
from .scene.bodies import SceneBody, normal_of

STONE, EDGE = "#e6dac4", "#6b6558"
LIGHT = np.array([-0.35, -0.6, 0.72])
SHADES = np.linspace(0.66, 1.0, 5)  # few, so that the palette of a GIF holds them all
SHADED = [to_hex(shade * np.array(to_rgb(STONE))) for shade in SHADES]
MOST_ORDERED = 200  # blocks; more are sorted by depth alone
AT_ONCE = 10  # blocks up to which the order is computed for every frame; less often with more


class Solids(PolyCollection):
    """The visible faces of all blocks, on 3D axes in orthographic projection."""

    def __init__(self, bodies: Sequence[SceneBody]) -> None:
        super().__init__([], linewidths=0.5, edgecolors=EDGE, zorder=1.0)
        self._centre = np.array([body.centroid for body in bodies])
        # faces of all blocks; rims of drums as pairs of points
        faces, normals, edged = [], [], []
        for i, body in enumerate(bodies):
            for surface in body.surfaces:
                face, normal = body.centroid + surface.points, normal_of(surface.points)
                faces.append((i, face))
                normals.append(normal)
                edged.append(surface.edged)
                if not (surface.edged or body.meshed):  # the rims of a drum
                    faces += (i, face[:2]), (i, face[2:])
                    normals += normal, normal
                    edged += True, True
        # flat arrays over faces and corners
        self._n = len(bodies)
        self._owner = np.array([i for i, _ in faces])
        self._edged = np.array(edged)
        self._counts = np.array([len(face) for _, face in faces])
        self._starts = np.concatenate([[0], np.cumsum(self._counts)])
        self._of = np.repeat(self._owner, self._counts)
        self._whole = np.repeat(self._counts > 2, self._counts)  # corners of faces, not of rims
        self._built = np.concatenate([face for _, face in faces])
        self._normals = np.array(normals)
        self._every, self._seen, self._order = -(-self._n // AT_ONCE), 0, np.arange(self._n)
        self._points, self._outward = self._built, self._normals
        self.place(np.zeros((self._n, 3)), np.zeros((self._n, 3)))

    def place(self, u: FloatArray, turn: FloatArray) -> None:
        """Move the blocks by `u`, m (n, 3), and rotate them by `turn`, rad (n, 3)."""
        arms = self._built - self._centre[self._of]
        self._points = self._built + u[self._of] + turned(turn[self._of], arms)
        self._outward = turned(turn[self._owner], self._normals) + self._normals

    @property
    def points(self) -> FloatArray:
        """The corners of all faces at their current positions, m (corners, 3)."""
        return self._points

    def do_3d_projection(self) -> float:
        """Project and shade the visible faces; the axes call it before they draw."""
        axes: Any = self.axes
        towards = towards_viewer(axes)
        if self._seen % self._every == 0:
            self._order = self._from_behind(towards)
        self._seen += 1
        # visible faces, ordered by block, within a mesh by depth
        x, y, _ = proj_transform(*self._points.T, axes.M)
        flat, rank = np.column_stack([x, y]), np.argsort(self._order)
        visible = np.flatnonzero(self._outward @ towards > 1e-9)
        depth = np.add.reduceat(self._points @ towards, self._starts[:-1]) / self._counts  # within a mesh
        visible = visible[np.lexsort((depth[visible], rank[self._owner[visible]]))]
        self.set_verts([flat[self._starts[f] : self._starts[f + 1]] for f in visible])
        # diffuse shading, quantized
        light = np.clip(self._outward[visible] @ (LIGHT / np.linalg.norm(LIGHT)), 0.0, 1.0)
        shade = SHADES[np.rint(light * (len(SHADES) - 1)).astype(int)]
        colours = shade[:, None] * np.array(to_rgb(STONE))
        self.set_facecolor(colours)
        edges: Any = np.where(self._edged[visible, None], np.array(to_rgb(EDGE)), colours)
        self.set_edgecolor(edges)
        return 0.0

    def _from_behind(self, towards: FloatArray) -> NDArray[np.intp]:
        """Return the indices of the blocks from the farthest on.

        Of two blocks, the one beyond a face of the other that is turned to the viewer is in front.
        """
        depth = np.array([np.mean(self._points[self._of == i] @ towards) for i in range(self._n)])
        if self._n > MOST_ORDERED:
            return np.argsort(depth)
        planes = np.flatnonzero(self._counts > 2)  # rims have no plane, and their corners are those of faces
        outward, owner = self._outward[planes], self._owner[planes]
        offset = np.einsum("fk,fk->f", outward, self._points[self._starts[planes]])
        facing, begins = outward @ towards, np.searchsorted(owner, np.arange(self._n))
        beyond = np.full((self._n, self._n), -np.inf)  # distance of j beyond the face of i that separates them best
        front = np.zeros((self._n, self._n))  # orientation of that face: > 0 if turned to the viewer
        for j in range(self._n):
            gaps = np.min(outward @ self._points[self._whole & (self._of == j)].T, axis=1) - offset
            beyond[:, j] = np.maximum.reduceat(gaps, begins)
            best = np.flatnonzero(gaps >= beyond[owner, j])
            front[:, j] = facing[best[np.searchsorted(owner[best], np.arange(self._n))]]
        ahead = np.where(beyond >= beyond.T, front, -front.T)  # > 0: j is in front of i
        ahead[np.abs(ahead) < 1e-9] = 0.0
        np.fill_diagonal(ahead, 0.0)
        # topological order from the back: a block that hides none of the others comes first
        order: list[int] = []
        left = list(np.argsort(depth))
        while left:
            free = (i for i in left if not np.any(ahead[np.array(left), i] > 0.0))
            order.append(next(free, left[0]))  # cyclic overlap of three or more: take the farthest
            left.remove(order[-1])
        return np.array(order)


def towards_viewer(axes: Any) -> FloatArray:
    """Return the unit vector from the scene of 3D axes to the viewer."""
    elevation, azimuth = np.deg2rad(axes.elev), np.deg2rad(axes.azim)
    level = np.cos(elevation)
    return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
