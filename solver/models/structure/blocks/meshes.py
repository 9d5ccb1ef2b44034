"""Closed meshes of triangles from files: OBJ, STL, glTF and others that trimesh reads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ....common.errors import InputError, needing, reading
from ....common.files import MB, check_size
from .faces import FloatArray
from .hulls import EXTRA

MOST = 200 * MB
KINDS = (".obj", ".stl", ".gltf", ".glb", ".ply", ".off")
UP = ("x", "y", "z")
TURNS = {"x": (1, 2, 0), "y": (2, 0, 1), "z": (0, 1, 2)}  # which of its axes become x, y, z


def triangles_of(path: Path, unit: float, up: str | None) -> FloatArray:
    """The triangles of a closed mesh, (k, 3, 3) m, outside anticlockwise.

    unit: m of a unit of the file; up: the axis of the file that points up; None: y of glTF, which says so, z of others.
    Raises InputError, beginning with the path, for a file that is none or is not closed.
    """
    kind = path.suffix.lower()
    if kind not in KINDS:
        raise InputError(f"{path}: must end with one of {', '.join(KINDS)}")
    with reading(path):
        check_size(path, MOST)
        with needing(EXTRA, "trimesh"):
            import trimesh
        try:
            mesh = trimesh.load_mesh(path, process=False)
            mesh.merge_vertices(merge_tex=True, merge_norm=True)
        except (InputError, OSError):
            raise
        except Exception as error:  # parsers of many formats raise anything
            raise InputError(f"cannot be read as a mesh: {type(error).__name__}: {error}".partition("\n")[0]) from None
        corners, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces)
        faces = faces[np.all(faces != np.roll(faces, 1, axis=1), axis=1)]  # corners that are one since they were merged
        if not len(faces) or not np.isfinite(corners).all():
            raise InputError("has no triangles, must be a closed mesh" if not len(faces) else "has no finite places")
        _check_closed(faces)
    order = TURNS[up or ("y" if kind in (".gltf", ".glb") else "z")]
    found: FloatArray = unit * corners[faces][:, :, order]
    middle = np.mean(found, axis=(0, 1))
    a, b, c = np.moveaxis(found - middle, 1, 0)
    return found if float(np.einsum("ij,ij->", a, np.cross(b, c))) > 0.0 else found[:, ::-1].copy()


def _check_closed(faces: NDArray[np.int64]) -> None:
    """Raise InputError unless each edge is passed as often one way as the other: then Green's theorem holds."""
    ends = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    forth = np.where(ends[:, 0] < ends[:, 1], 1, -1)
    _, edge = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    passed, turns = np.bincount(edge.ravel()), np.bincount(edge.ravel(), weights=forth)
    single = int(np.sum(passed % 2))
    if single:
        raise InputError(f"is not closed: {single} edges do not have two triangles, must be a closed mesh")
    if np.any(turns):
        raise InputError("has triangles that look inwards beside others that look outwards, must be one closed mesh")
