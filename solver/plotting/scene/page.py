"""A response as one HTML page that plays it, with a painter of its own (viewer.js): it fetches nothing."""

from __future__ import annotations

import base64
import json
import math
import os
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from ...common.errors import POSITIVE, InputError, check_number
from ...common.files import whole_file
from ...models.structure.blocks.faces import FloatArray
from .bodies import Scene, scene_of

FPS = 30.0  # the most rows a second
MOST_NUMBERS = 300_000  # displacements and rotations: 1.6 MB of the page
VISIBLE = 0.08  # of the extent: largest displacement at the factor that the page begins with
MOST_TIMES = 1e4  # factor on the deformation
DIGITS = 5  # of lengths in m: of what is drawn
VERDICTS = {"standing": "It stands.", "overturned": "It falls.", "undecided": "Whether it stands is undecided."}


def write_view(response: Any, path: str | os.PathLike[str], scale: float | None) -> None:
    """Write the page; scale: the factor on the deformation that it begins with. Raises InputError, OSError."""
    check_page(path)
    if scale is not None:
        scale = check_number("scale", scale, POSITIVE, "a positive factor on the deformation")
    text = _page(response, scale)
    with whole_file(path) as partial:
        Path(partial).write_text(text, encoding="utf-8")


def check_page(path: str | os.PathLike[str]) -> None:
    """Raise InputError unless the name is that of a page."""
    if Path(path).suffix.lower() != ".html":
        raise InputError(f"{path}: must end in .html")


def _page(response: Any, scale: float | None) -> str:
    n, span = response.model.n, max(float(response.time[-1] - response.time[0]), 1e-9)
    scene = scene_of(response, min(FPS, MOST_NUMBERS / (6.0 * n * span)))
    name, facts = escape(scene.name), VERDICTS.get(response.verdict, "")
    line = f"{facts} Largest displacement {1e3 * float(np.max(response.peaks[response.model.kind.largest])):.3g} mm."
    folder = files(__package__)
    parts = {
        "@TITLE@": name,
        "@NAME@": name,
        "@LINE@": escape(line),
        "@SCENE@": json.dumps(_contents(scene, response, scale), separators=(",", ":")).replace("<", "\\u003c"),
        "@VIEWER@": (folder / "viewer.js").read_text(encoding="utf-8"),
    }
    text = (folder / "viewer.html").read_text(encoding="utf-8")
    for mark, content in parts.items():
        text = text.replace(mark, content)
    return text


def _contents(scene: Scene, response: Any, scale: float | None) -> dict[str, Any]:
    """What viewer.js draws."""
    corners = scene.corners
    low, high = corners.min(axis=0), corners.max(axis=0)
    extent = float(np.linalg.norm(high - low))
    across = np.linalg.norm(scene.u, axis=2)
    peak, fall = scene.time[int(np.argmax(np.max(across, axis=1)))], response.overturn_time
    fell = not math.isnan(fall) and fall <= scene.time[-1]
    wanted = VISIBLE * extent / max(float(np.max(across)), 1e-12)
    factor = scale or (1.0 if fell else float(min(max(1.0, float(f"{wanted:.1g}")), MOST_TIMES)))
    bodies = [
        {
            "name": body.name,
            "centroid": body.centroid.tolist(),
            "surfaces": [[int(part.edged), part.points.round(DIGITS).tolist()] for part in body.surfaces],
        }
        for body in scene.bodies
    ]
    rims = [{"name": rim.name, "body": rim.body, "points": rim.points.round(DIGITS).tolist()} for rim in scene.rims]
    sizes = [float(np.max(np.ptp(rim.points, axis=0))) for rim in scene.rims]
    return {
        "bodies": bodies,
        "rims": rims,
        "time": scene.time.round(6).tolist(),
        "u": _packed(scene.u, "<f4"),
        "turn": _packed(scene.turn, "<f4"),
        "contact": _packed(np.round(255.0 * np.clip(scene.contact, 0.0, 1.0)), "u1"),
        "marks": [["peak", float(peak)], *([["fall", float(fall)]] if fell else [])],
        "begin": float(peak),
        "factor": factor,
        "extent": extent,
        "band": float(np.median(sizes)) if sizes else 0.0,
        "middle": (0.5 * (low + high)).tolist(),
    }


def _packed(values: FloatArray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode()
