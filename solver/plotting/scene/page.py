"""A response as one HTML page that plays it with its own renderer (viewer.js) and loads nothing else."""

from __future__ import annotations

import base64
import json
import math
import os
import re
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from ...common.errors import POSITIVE, InputError, check_number
from ...common.files import whole_file
from ...ground.intensity import Component, histories, is_measurable
from ...ground.motion import Motion
from ...models.structure.blocks.faces import FloatArray
from ..largest import largest_displacement, length
from .bodies import Scene, SceneBody, has_parts, scene_of

FPS = 30.0  # rows per second, at most
MOST_NUMBERS = 270_000  # displacements, rotations and joints: 1.4 MB of the page
MOST_TRIANGLES = 16_000  # of meshes: 0.8 MB
EMBEDDED_FPS, EMBEDDED_NUMBERS, EMBEDDED_TRIANGLES = 15.0, 60_000, 4_000  # of an embedded page
VISIBLE = 0.08  # of the extent: largest displacement drawn at the factor that the page offers
MOST_TIMES = 1e4  # factor on the deformation
AT_REST = 0.01  # of its peak: velocity at the end of a base that does not drift, and of a harmonic displacement
DIGITS = 5  # of lengths in m: of what is drawn
WHOLE = 65535  # full scale of shares stored as 16-bit integers
VERDICTS = {
    "standing": "It stands.",
    "overturned": "It falls at {:.2f} s{}.",
    "undecided": "Whether it stands is undecided.",
}
FRAME = (
    '<iframe class="scene" srcdoc="{}" title="the blocks in motion" loading="lazy" '
    'style="width: 100%; height: {}px; border: 1px solid #8886; border-radius: 6px"></iframe>'
)


def write_view(response: Any, path: str | os.PathLike[str], scale: float | None) -> None:
    """Write the page of a response as `Result.view` describes. Raises InputError, OSError."""
    if Path(path).suffix.lower() != ".html":
        raise InputError(f"{path}: must end in .html")
    if scale is not None:
        scale = check_number("scale", scale, POSITIVE, "a positive factor on the deformation")
    text = _page(response, scale, FPS, MOST_NUMBERS, MOST_TRIANGLES)
    with whole_file(path) as partial:
        Path(partial).write_text(text, encoding="utf-8")


def frame_of(response: Any, height: int = 480) -> str:
    """Return HTML that embeds a smaller page, `height` px high; empty if the shape of the model is not known."""
    if not has_parts(response.model):
        return ""
    return FRAME.format(escape(small_page(response)), height)


def small_page(response: Any, scale: float | None = None) -> str:
    """Return a page with fewer rows and coarser meshes; `scale` as in `write_view`."""
    return _page(response, scale, EMBEDDED_FPS, EMBEDDED_NUMBERS, EMBEDDED_TRIANGLES)


def _page(response: Any, scale: float | None, fps: float, numbers: int, triangles: int) -> str:
    sizes, span = response.model.sizes, max(float(response.time[-1] - response.time[0]), 1e-9)
    scene = scene_of(response, min(fps, numbers / ((6 * sizes["block"] + sizes["joint"] + 3) * span)))
    what_fell = getattr(response, "what_fell", "")
    name, facts = escape(scene.name), VERDICTS.get(response.verdict, "")
    facts = facts.format(response.overturn_time, what_fell and f": {what_fell}")
    until = " before the fall" if math.isfinite(response.overturn_time) else ""
    line = f"{facts} Largest displacement{until} {length(largest_displacement(response)[0])}."
    folder = files(__package__)
    contents = _contents(scene, response, scale, triangles)
    parts = {
        "@TITLE@": name,
        "@NAME@": name,
        "@LINE@": escape(line),
        "@SCENE@": json.dumps(contents, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
        "@VIEWER@": (folder / "viewer.js").read_text(encoding="utf-8"),
    }
    text = (folder / "viewer.html").read_text(encoding="utf-8")
    return re.sub("|".join(parts), lambda mark: parts[mark[0]], text)  # at once: a name may look like a mark


def _contents(scene: Scene, response: Any, scale: float | None, triangles: int) -> dict[str, Any]:
    """Return the data that viewer.js draws."""
    # extent, peak and fall; factor that makes the motion visible
    corners = scene.corners
    low, high = corners.min(axis=0), corners.max(axis=0)
    extent = float(np.linalg.norm(high - low))
    across = np.linalg.norm(scene.u, axis=2)
    fall = response.overturn_time
    fell = not math.isnan(fall) and fall <= scene.time[-1]
    rows = max(1, int(np.searchsorted(scene.time, fall))) if fell else len(scene.time)
    peak = scene.time[int(np.argmax(np.max(across[:rows], axis=1)))]
    wanted = VISIBLE * extent / max(float(np.max(across)), 1e-12)
    visible = 1.0 if fell else float(min(max(1.0, float(f"{wanted:.1g}")), MOST_TIMES))
    # geometry: surfaces of the blocks, decimated meshes, rims of the joints
    of_mesh = triangles // max(1, sum(body.meshed for body in scene.bodies))
    bodies = [
        {"name": body.name, "centroid": body.centroid.tolist()}
        | (
            {"surfaces": [], "mesh": _packed(_coarse(body, of_mesh), "<f4")}
            if body.meshed
            else {"surfaces": [[int(part.edged), part.points.round(DIGITS).tolist()] for part in body.surfaces]}
        )
        for body in scene.bodies
    ]
    rims = [
        {"name": contact.name, "body": contact.body, "points": contact.points.round(DIGITS).tolist()}
        for contact in scene.contacts
    ]
    sizes = [float(np.max(np.ptp(contact.points, axis=0))) for contact in scene.contacts]
    # colour scale of the pressure, and path of the base
    pressure = np.nan_to_num(response.sigma_max[scene.rows])
    most = max(float(np.max(pressure, initial=0.0)), 1.0)
    base = _path_of_base(response.motion, scene.time)
    return {
        "bodies": bodies,
        "walls": [(wall.centroid + wall.surfaces[0].points).round(DIGITS).tolist() for wall in scene.walls],
        "rims": rims,
        "time": scene.time.round(6).tolist(),
        "u": _packed(scene.u, "<f4"),
        "turn": _packed(scene.turn, "<f4"),
        "base": _packed(base, "<f4") if np.any(base) else "",
        "contact": _packed(np.round(WHOLE * np.clip(response.contact[scene.rows], 0.0, 1.0)), "<u2"),
        "pressure": _packed(np.round(WHOLE * np.clip(pressure / most, 0.0, 1.0)), "<u2"),
        "most": most,
        "marks": [["peak", float(peak)], *([["fall", float(fall)]] if fell else [])],
        "begin": float(peak),
        "factor": scale or 1.0,
        "visible": visible,
        "extent": extent,
        "band": float(np.median(sizes)) if sizes else 0.0,
        "middle": (0.5 * (low + high)).tolist(),
    }


def _coarse(body: SceneBody, most: int) -> FloatArray:
    """Return the triangles of a mesh, (k, 3, 3) m, with vertices snapped to a grid so that at most `most` are left."""
    whole = np.array([surface.points for surface in body.surfaces])
    found, cell = whole, 0.002 * float(np.max(np.ptp(whole, axis=(0, 1))))
    while len(found) > most:
        found = cell * np.round(whole / cell)
        found = found[np.all(np.any(found != np.roll(found, 1, axis=1), axis=2), axis=1)]
        cell *= 1.3
    return found


def _path_of_base(motion: Motion | None, time: FloatArray) -> FloatArray:
    """Return the displacement of the base, (rows, 3) m, of a component that drifts less its best-fit parabola.

    Samples that end without velocity do not drift, wherever they end; a harmonic drifts, as it begins from rest.
    """
    found = np.zeros((len(time), 3))
    components: tuple[Component, ...] = ("ax", "ay", "az")
    for axis, component in enumerate(components):
        if motion is not None and is_measurable(motion) and (component != "ay" or motion.has_ay):
            base = histories(motion, component)
            moved = base.displacement
            ends = (base.velocity, moved) if motion.amplitude_of(component) else (base.velocity,)
            if any(abs(part[-1]) > AT_REST * np.max(np.abs(part)) for part in ends):
                span = base.time - base.time[0]
                trend = np.column_stack([span, span**2])
                moved = moved - trend @ np.linalg.lstsq(trend, moved, rcond=None)[0]
            found[:, axis] = np.interp(time, base.time, moved)
    return found


def _packed(values: FloatArray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode()
