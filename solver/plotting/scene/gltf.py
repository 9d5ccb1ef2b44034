"""A response as binary glTF 2.0 with its motion as an animation, for Blender and other programs."""

from __future__ import annotations

import json
import math
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np

from ...common.errors import InputError
from ...common.files import whole_file
from ...models.structure.blocks.faces import FloatArray
from .bodies import Body, Scene, scene_of

FPS = 30.0  # the most pictures a second
FLOAT, UNSIGNED = 5126, 5125  # component types
STONE = [0.61, 0.53, 0.41, 1.0]  # linear
UPWARDS = [-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]  # z up, to y up as glTF has it


def write_gltf(response: Any, path: str | os.PathLike[str]) -> None:
    """Write the scene of a response. Raises InputError, OSError."""
    if Path(path).suffix.lower() != ".glb":
        raise InputError(f"{path}: must end in .glb")
    content = _glb(scene_of(response, FPS))
    with whole_file(path) as partial:
        Path(partial).write_bytes(content)


def quaternions(turn: FloatArray) -> FloatArray:
    """Of rotations, axis times angle, rad (..., 3): (..., 4), the real part last."""
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    found: FloatArray = np.concatenate([0.5 * np.sinc(0.5 * angle / np.pi) * turn, np.cos(0.5 * angle)], axis=-1)
    return found


class _Buffer:
    """The binary part, and the views and accessors into it."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, values: FloatArray, kind: str, bounds: bool = False, target: int | None = None) -> int:
        """Add float32 numbers, or indices (kind SCALAR and target 34963); returns the number of the accessor."""
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


def _glb(scene: Scene) -> bytes:
    buffer = _Buffer()
    meshes = [_mesh(body, buffer) for body in scene.bodies]
    n = len(scene.bodies)
    # a body's place as built is a number of JSON, in full; float32 has only its displacement
    nodes: list[dict[str, Any]] = [{"name": scene.name, "rotation": UPWARDS, "children": list(range(1, n + 1))}]
    nodes += [{"translation": body.centroid.tolist(), "children": [n + 1 + i]} for i, body in enumerate(scene.bodies)]
    nodes += [{"name": body.name, "mesh": i} for i, body in enumerate(scene.bodies)]
    clock = buffer.add(scene.time - scene.time[0], "SCALAR", bounds=True)
    samplers, channels = [], []
    turns = quaternions(scene.turn)
    nearest = np.cumprod(np.where(np.sum(turns[1:] * turns[:-1], axis=-1) < 0.0, -1.0, 1.0), axis=0)
    turns[1:] *= nearest[..., None]  # of q and -q the one that is nearer to the last
    for i in range(n):
        for name, values, kind in (("translation", scene.u, "VEC3"), ("rotation", turns, "VEC4")):
            samplers.append({"input": clock, "output": buffer.add(values[:, i], kind), "interpolation": "LINEAR"})
            channels.append({"sampler": len(samplers) - 1, "target": {"node": n + 1 + i, "path": name}})
    description = {
        "asset": {"version": "2.0", "generator": "multiblock-fmu"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [
            {"pbrMetallicRoughness": {"baseColorFactor": STONE, "metallicFactor": 0.0, "roughnessFactor": 0.9}}
        ],
        "animations": [{"name": "response", "samplers": samplers, "channels": channels}],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.data)}],
    }
    text = json.dumps(description, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data = bytes(buffer.data) + bytes(-len(buffer.data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _mesh(body: Body, buffer: _Buffer) -> dict[str, Any]:
    """Triangles, each surface with corners of its own: its normal is theirs."""
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


def normal_of(points: FloatArray) -> FloatArray:
    """The unit normal of a plane polygon."""
    arms = points - points[0]
    area = np.sum(np.cross(arms[1:-1], arms[2:]), axis=0)
    found: FloatArray = area / np.linalg.norm(area)
    return found
