"""Files of structures in space, and calls of their builders: read and at rest, or refused in one line."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

from multiblock import arch, colonnade, wall
from solver import InputError
from solver.models.structure.model import Structure
from solver.models.structure.modes import modes_in_space
from solver.models.structure.rest import known_warnings_in_space

REFUSED = ""  # in place of a mistake: with one line that names the file, as it should be
TOML = """name = "mixed"
g = 9.81
[joints]
stiffness = 2e9
damping = 1e-3
friction = 0.7
[[block]]
name = "left"
on = "base"
shape = "drum"
diameter = 1.0
top_diameter = 0.8
bore = 0.2
height = 1.0
density = 2500.0
repeat = 2
[[block]]
name = "right"
on = ["base"]
at = [3.0, 0.0]
width = 0.9
depth = 0.8
height = 2.0
mass = 4000.0
rotation = [0.0, 0.0, 0.1]
[[block]]
name = "beam"
on = ["right"]
at = [1.5, 0.0]
width = 3.9
depth = 0.9
height = 0.7
density = 2600.0
joint = {stiffness = 1e9, damping = 2e-3, strength = 5e6}
[[block]]
name = "wedge"
shape = "prism"
outline = [[6.0, 0.0], [7.0, 0.0], [7.0, 2.0], [6.2, 2.0]]
depth = 1.0
density = 2000.0
position = [0.0, 0.5, 0.0]
[[joint]]
between = ["beam", "left.2"]
at = [0.0, 0.0, 2.0]
section = "circle"
diameter = 0.7
[[joint]]
between = ["wedge", "base"]
at = [6.5, 0.5, 0.0]
normal = [0.0, 0.0, 1.0]
width = 0.9
depth = 0.9
shear_ratio = 0.5
[[tie]]
between = ["beam", "base"]
from = [0.0, 0.0, 0.3]
to = [1.5, 4.0, 0.0]
stiffness = 1e6
slack = 0.01
yield = 1e5
[solver]
tolerance = 1e-6
without = ["peaks"]
"""
LAW = {"stiffness": 2e9, "damping": 1e-3, "friction": 0.7}
TIE = {"stiffness": 1e7, "yield": 1e5}
CALLS: dict[str, tuple[Any, dict[str, Any]]] = {
    "colonnade": (
        colonnade,
        {"columns": 2, "drums": 2, "spacing": 3.0, "diameter": 1.0, "height": 4.0, "joint": LAW, "top_diameter": 0.8}
        | {"architrave": [1.0, 1.0], "density": 2700.0, "tie": TIE, "name": "colonnade"},
    ),
    "arch": (
        arch,
        {"voussoirs": 5, "radius": 5.0, "thickness": 1.0, "depth": 1.0, "joint": LAW, "angle": 3.0}
        | {"density": 2000.0, "name": "arch"},
    ),
    "wall": (
        wall,
        {"courses": 2, "length": 2, "block": [0.6, 0.3, 0.3], "joint": LAW, "density": 2000.0, "name": "wall"},
    ),
}
ODD: list[Any] = [
    None,
    True,
    "",
    "x",
    "1",
    -1,
    0,
    1,
    7,
    1e-300,
    1e-6,
    1e6,
    1e12,
    1e300,
    10**9,
    10**400,
    math.nan,
    math.inf,
]
ODD += [[], {}, [1.0], [0.5, 0.5], [1e300, -1.0], {"a": 1}, {"stiffness": "x"}]


def structure_problem(path: Path) -> str | None:
    """Return the mistake in how a structure's file was read, or in its rest and modes; None if there is none."""
    try:
        structure = Structure.from_toml(path)
    except InputError as error:
        message = str(error)
        return REFUSED if message.startswith(f"{path}: ") and "\n" not in message else f"said: {message!r}"
    return _standing_problem(structure)


def builder_problem(path: Path) -> str | None:
    """Return the mistake in what a builder makes of arguments."""
    name, arguments = json.loads(path.read_text())
    try:
        structure = CALLS[name][0](**arguments)
    except InputError as error:
        return REFUSED if "\n" not in str(error) else f"said: {error}"
    return _standing_problem(structure)


def calls() -> st.SearchStrategy[bytes]:
    """Return calls of builders with one or two arguments that are odd."""

    def call(name: str, changes: list[tuple[int, Any]]) -> bytes:
        arguments = dict(CALLS[name][1])
        for place, value in changes:
            key = list(arguments)[place % len(arguments)]
            inner = arguments[key]
            if isinstance(inner, dict) and inner and place % 3:
                inner_key = list(inner)[place % len(inner)]
                value = {**inner, inner_key: value}
            arguments[key] = value
        return json.dumps([name, arguments]).encode()

    values = st.one_of(st.sampled_from(ODD), st.floats(1e-6, 1e6), st.integers(-2, 12), st.floats())
    changes = st.lists(st.tuples(st.integers(0, 100), values), max_size=2)
    return st.builds(call, st.sampled_from(sorted(CALLS)), changes)


def _standing_problem(structure: Structure) -> str | None:
    for block in structure.blocks:
        if not (math.isfinite(block.mass) and block.mass > 0.0 and np.all(np.isfinite(block.inertia))):
            return f"accepted: {block}"
    if Structure.from_dict(structure.to_dict()).to_dict() != structure.to_dict():
        return "its mapping gives another structure"
    if structure.n > 20:
        return None
    try:
        known_warnings_in_space(structure)
        modes = modes_in_space(structure)
    except InputError as error:
        return None if str(error).startswith(f"{structure.name}: ") and "\n" not in str(error) else f"said: {error}"
    if not np.all(np.isfinite(modes.frequency)) or not np.all(np.isfinite(modes.displacement)):
        return "modes that are no numbers"
    return None
