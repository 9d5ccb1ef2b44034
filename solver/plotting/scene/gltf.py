"""A response as binary glTF 2.0 with its motion as an animation, for Blender and other programs."""

from __future__ import annotations

import json
import math
import os
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from ...common.errors import InputError
from ...common.files import whole_file
from ...models.column.outputs import OUTPUTS as OF_COLUMN
from ...models.outputs import BLOCK
from ...models.structure.blocks.faces import FloatArray
from ...models.structure.outputs import OUTPUTS as OF_STRUCTURE
from .bodies import SceneBody, normal_of, poses, scene_of

FPS = 30.0  # rows per second, at most
FLOAT, UNSIGNED = 5126, 5125  # component types
STONE = [0.61, 0.53, 0.41, 1.0]  # linear
UPWARDS = [-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]  # z up, to y up as glTF has it


def write_gltf(response: Any, path: str | os.PathLike[str]) -> None:
    """Write the scene of a response to a .glb file. Raises InputError, OSError."""
    if Path(path).suffix.lower() != ".glb":
        raise InputError(f"{path}: must end in .glb")
    scene = scene_of(response, FPS)
    content = _moving(still(scene.name, scene.bodies, walls=scene.walls), scene.time, scene.u, scene.turn)
    with whole_file(path) as partial:
        Path(partial).write_bytes(content)


def animated(found: bytes, time: FloatArray, histories: Mapping[str, FloatArray]) -> bytes:
    """Return the glTF of `still` with the motion given by the outputs of its FMU as an animation.

    Parameters
    ----------
    found : bytes
        Result of `still`, with `in_plane`.
    time : array (rows,)
        Times, s.
    histories : mapping of str to array (rows,)
        Outputs by name: block[1].ux or block1.ux, and so on.

    Raises
    ------
    InputError
        If an output is missing.
    """
    bodies = [SimpleNamespace(**node["extras"]) for node in _parts(found)[0]["nodes"] if "extras" in node]
    outputs = OF_COLUMN if bodies[0].in_plane else OF_STRUCTURE

    def history(number: int, output: str) -> FloatArray:
        for name in (f"block[{number}].{output}", f"block{number}.{output}"):
            if name in histories:
                return histories[name]
        raise InputError(f"block[{number}].{output}: is missing, the table must have all outputs of blocks")

    rows = {
        one.field: np.column_stack([history(number, one.name) for number in range(1, len(bodies) + 1)])
        for one in outputs
        if one.owner == BLOCK
    }
    return _moving(found, time, *poses(bodies, SimpleNamespace(**rows)))


def quaternions(turn: FloatArray) -> FloatArray:
    """Return the quaternions (..., 4), the real part last, of rotations, axis times angle, rad (..., 3)."""
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    return np.concatenate([0.5 * np.sinc(0.5 * angle / np.pi) * turn, np.cos(0.5 * angle)], axis=-1)


class _Buffer:
    """The binary part of a glTF file, with the views and accessors into it."""

    def __init__(self, description: Any, data: bytes = b"") -> None:
        self.data = bytearray(data)
        self.views: list[dict[str, Any]] = description.setdefault("bufferViews", [])
        self.accessors: list[dict[str, Any]] = description.setdefault("accessors", [])

    def add(self, values: FloatArray, kind: str, bounds: bool = False, target: int | None = None) -> int:
        """Append float32 values, or indices (kind SCALAR and target 34963), and return the index of the accessor."""
        indices = target == 34963
        stored = np.ascontiguousarray(values, dtype="<u4" if indices else "<f4")
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": stored.nbytes})
        if target is not None:
            self.views[-1]["target"] = target
        self.data += stored.tobytes()
        accessor = {"bufferView": len(self.views) - 1, "count": len(stored), "type": kind}
        accessor["componentType"] = UNSIGNED if indices else FLOAT
        if bounds:
            flat = stored.reshape(len(stored), -1)
            accessor |= {"min": flat.min(axis=0).tolist(), "max": flat.max(axis=0).tolist()}
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def still(
    name: str, bodies: Sequence[SceneBody], in_plane: bool | None = None, walls: Sequence[SceneBody] = ()
) -> bytes:
    """Return the glTF of bodies as built, and of walls, which are visible from one side.

    Parameters
    ----------
    name : str
        Name of the scene.
    bodies : sequence of SceneBody
    in_plane : bool, optional
        If given, each node stores the numbers with which `animated` poses it from the outputs of an FMU; True for those
        of a column in its plane.
    walls : sequence of SceneBody
        Walls, of one surface each.

    Returns
    -------
    bytes
        Content of a .glb file.
    """
    n = len(bodies)
    # the position as built is a JSON number of full precision; float32 holds only the displacement
    held = [*range(1, n + 1), *range(2 * n + 1, 2 * n + 1 + len(walls))]
    nodes: list[dict[str, Any]] = [{"name": name, "rotation": UPWARDS, "children": held}]
    nodes += [{"translation": body.centroid.tolist(), "children": [n + 1 + i]} for i, body in enumerate(bodies)]
    nodes += [{"name": body.name, "mesh": i} for i, body in enumerate(bodies)]
    nodes += [{"name": wall.name, "mesh": n + k, "translation": wall.centroid.tolist()} for k, wall in enumerate(walls)]
    if in_plane is not None:
        for node, body in zip(nodes[n + 1 : 2 * n + 1], bodies, strict=True):
            node["extras"] = {"in_plane": in_plane, "reach": body.reach, "tilt": body.tilt}
    # scene, material and meshes
    description: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "multiblock-fmu"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "materials": [
            {"pbrMetallicRoughness": {"baseColorFactor": STONE, "metallicFactor": 0.0, "roughnessFactor": 0.9}}
        ],
    }
    buffer = _Buffer(description)
    description["meshes"] = [_mesh(body, buffer) for body in (*bodies, *walls)]
    return _packed(description, buffer)


def _moving(found: bytes, time: FloatArray, u: FloatArray, turn: FloatArray) -> bytes:
    """Return the glTF of `still` with displacements, m, and rotations, rad, (rows, n, 3) each, as an animation."""
    description, data = _parts(found)
    buffer, n = _Buffer(description, data), u.shape[1]
    clock = buffer.add(time - time[0], "SCALAR", bounds=True)
    samplers, channels = [], []
    turns = quaternions(turn)
    nearest = np.cumprod(np.where(np.sum(turns[1:] * turns[:-1], axis=-1) < 0.0, -1.0, 1.0), axis=0)
    turns[1:] *= nearest[..., None]  # of q and -q, choose the one nearer to the previous row
    for i in range(n):
        for name, values, kind in (("translation", u, "VEC3"), ("rotation", turns, "VEC4")):
            samplers.append({"input": clock, "output": buffer.add(values[:, i], kind), "interpolation": "LINEAR"})
            channels.append({"sampler": len(samplers) - 1, "target": {"node": n + 1 + i, "path": name}})
    description["animations"] = [{"name": "response", "samplers": samplers, "channels": channels}]
    return _packed(description, buffer)


def _packed(description: dict[str, Any], buffer: _Buffer) -> bytes:
    """Return the content of a .glb file."""
    description["buffers"] = [{"byteLength": len(buffer.data)}]
    text = json.dumps(description, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data = bytes(buffer.data) + bytes(-len(buffer.data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _parts(found: bytes) -> tuple[Any, bytes]:
    """Return the description and the buffer of a .glb file."""
    size = int.from_bytes(found[12:16], "little")
    description = json.loads(found[20 : 20 + size])
    begin = 28 + size
    return description, found[begin : begin + description["buffers"][0]["byteLength"]]


def _mesh(body: SceneBody, buffer: _Buffer) -> dict[str, Any]:
    """Return the triangles of a body; each surface has vertices of its own, with its normal."""
    points, normals, corners, count = [], [], [], 0
    for surface in body.surfaces:
        k = len(surface.points)
        points.append(surface.points)
        normals.append(np.tile(normal_of(surface.points), (k, 1)))
        corners += [(count, count + j, count + j + 1) for j in range(1, k - 1)]
        count += k
    attributes = {
        "POSITION": buffer.add(np.concatenate(points), "VEC3", bounds=True, target=34962),
        "NORMAL": buffer.add(np.concatenate(normals), "VEC3", target=34962),
    }
    indices = buffer.add(np.array(corners).ravel(), "SCALAR", target=34963)
    return {"name": body.name, "primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}
