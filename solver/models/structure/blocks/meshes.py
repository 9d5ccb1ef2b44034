"""Closed meshes of triangles from files: OBJ, STL, glTF and others that trimesh reads."""

from __future__ import annotations

import os
import warnings
from io import BytesIO
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from ....common.errors import InputError, InputWarning, needing, reading, shortened
from ....common.files import MB, content_of
from ....common.tables import PLACE
from .faces import FloatArray
from .shells import EXTRA, check_closed, check_shells, repaired, solids_apart, volume_of

MOST = 200 * MB  # of a mesh, and of all buffers that it names
KINDS = (".obj", ".stl", ".gltf", ".glb", ".ply", ".off")
COLOURED = (".obj", ".gltf", ".glb", ".ply")  # formats that may name files of materials, which are not read
TALL = 100.0  # m: a mesh higher than this is probably in mm
UP = ("x", "y", "z")
# axis that points up in a file -> which of its axes become x, y, z, and their signs; of y as in glTF files written here
TURNS = {"x": ((1, 2, 0), (1.0, 1.0, 1.0)), "y": ((0, 2, 1), (1.0, -1.0, 1.0)), "z": ((0, 1, 2), (1.0, 1.0, 1.0))}


def triangles_of(path: Path, unit: float, up: str | None, repair: bool = False, scale: float = 1.0) -> FloatArray:
    """Return the triangles of a closed mesh, anticlockwise from outside, (k, 3, 3) m.

    `unit` is the length of a unit of the file, m; `up` the axis of the file that points up, None: y of glTF, which
    defines it, z of others. `repair` turns triangles that look inwards. `scale` is a factor of all lengths that is yet
    to be applied, for the height. Warns of solids that do not touch, of a height beyond `TALL` and of triangles that
    were repaired. Raises InputError if the file is no mesh or bounds no solid; the message begins with the path.
    """
    kind = path.suffix.lower()
    if kind not in KINDS:
        raise InputError(f"{path}: must end with one of {', '.join(KINDS)}")
    with reading(path):
        content = content_of(path, MOST)
        with needing(EXTRA, "trimesh"):
            import trimesh
        buffers: Any = _Buffers(path.parent, MOST - len(content))
        colourless = {"skip_materials": True} if kind in COLOURED else {}
        try:
            mesh = trimesh.load_mesh(
                BytesIO(content), file_type=kind[1:], resolver=buffers, process=False, **colourless
            )
            mesh.merge_vertices(merge_tex=True, merge_norm=True)
        except (InputError, OSError):
            raise
        except Exception as error:  # parsers of many formats raise anything
            raise InputError(f"cannot be read as a mesh: {type(error).__name__}: {shortened(error)}") from None
        corners, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)
        faces = faces[np.all(faces != np.roll(faces, 1, axis=1), axis=1)]  # drop triangles with merged corners
        if not len(faces) or not np.isfinite(corners).all():
            raise InputError("has no triangles, must be a closed mesh" if not len(faces) else "has no finite places")
        if repair:
            faces, turned = repaired(corners, faces)
            if turned:
                _warn(path, f"{turned} of {len(faces)} triangles turned")
        check_closed(faces)
        # turn the axes, so that z points up, and the triangles, so that the volume is positive
        order, signs = TURNS[up or ("y" if kind in (".gltf", ".glb") else "z")]
        corners = unit * np.array(signs) * corners[:, order]
        farthest, most = float(np.max(np.abs(corners))), PLACE[0][1]
        if farthest > most:
            raise InputError(
                f"coordinates reach {farthest:.4g} m, must be at most {most:.0e} m: shift them near the origin"
            )
        found: FloatArray = corners[faces]
        if not volume_of(found) > 0.0:
            faces, found = faces[:, ::-1], found[:, ::-1].copy()
        check_shells(corners, faces)
        solids = solids_apart(corners, faces)
    if solids > 1:
        _warn(path, f"{solids} solids that do not touch, taken as one rigid block")
    height = scale * float(np.ptp(found[:, :, 2]))
    if height > TALL:
        _warn(path, f"{height:.4g} m high: a mesh in mm needs unit = 1e-3 (--unit 1e-3)")
    return found


def _warn(path: Path, text: str) -> None:
    warnings.warn(f"{path}: {text}", InputWarning, stacklevel=2)


class _Buffers:
    """The files that a mesh names, as trimesh looks them up: ordinary ones in its folder, `most` bytes in all."""

    def __init__(self, folder: Path, most: int) -> None:
        self._inside, self._left = Path(os.path.realpath(folder)), most

    def __getitem__(self, name: str) -> bytes:
        # resolve links, so that no file outside the folder is read
        named = next((text for text in (name, unquote(name)) if (self._inside / text).exists()), name)
        place = Path(os.path.realpath(self._inside / named))
        if self._inside not in place.parents:
            raise InputError(f"needs {name}, must be a file in its own folder, or in one below it")
        if not place.exists():
            raise InputError(f"needs {name} beside it, which is not there")
        with reading(name):
            content = content_of(place, self._left)
        self._left -= len(content)
        return content

    get = __getitem__
