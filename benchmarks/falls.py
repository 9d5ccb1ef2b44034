"""Convex bodies that meet at any orientation: throws beside MuJoCo at equal error, and a colonnade that falls.

LMGC90 is not among them: its Python binding (compas_lmgc90 0.1) finds no contact between blocks that are farther apart
at the start than its alert distance, nor of edges that meet.
"""

from __future__ import annotations

import time
import tomllib
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from multiblock import Motion, Structure
from solver.ground.wavelets import ricker
from solver.models.structure.blocks.shapes import rotation_matrix
from solver.models.structure.run import SpatialState, begun

from .engines import Point, Run, point_of
from .in_space import Table, run
from .right_hand_side import Array
from .scenes import G

BOX: dict[str, Any] = {"width": 1.0, "depth": 1.5, "height": 2.0, "density": 2000.0}
HIGH, FLIGHT, ROW = 10.0, 1.5, 0.01  # m, s, s
STILL = Motion.from_samples(FLIGHT, np.zeros(2))
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-9)
STEPS = (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5)  # s
MEET = {"stiffness": 3e8, "damping": 0.0, "friction": 0.0}
COLONNADE = Path(__file__).parents[1] / "examples" / "structures" / "colonnade.toml"
LAW = {"reach": 0.0, "stiffness": 1e9, "line_stiffness": 1e9, "restitution": 0.3, "friction": 0.5}
AFTER = 5.0  # s


def _start(seed: int) -> tuple[Array, Array, Array, Array]:
    """Return places (m), rotation vectors, velocities (m/s) and spins of two boxes that meet."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=(2, 3))
    rotation = axis / np.linalg.norm(axis, axis=1, keepdims=True) * rng.uniform(0.0, np.pi, size=(2, 1))
    places = np.array([[0.0, 0.0, HIGH], [2.8, 0.0, HIGH]])
    places[1] += 0.2 * rng.normal(size=3)
    velocity = np.array([[0.8, 0.0, 0.0], [-0.8, 0.0, 0.0]]) + 0.1 * rng.normal(size=(2, 3))
    return places, rotation, velocity, 0.5 * rng.normal(size=(2, 3))


def here(tolerance: float, seed: int) -> Run:
    """Throw by this solver."""
    blocks = [{"name": f"b{k}", "on": "base", "at": [6.0 * k, 0.0], **BOX} for k in range(2)]
    joints = {"stiffness": 1e9, "damping": 1e-3, "friction": 0.5}  # open from the start
    data = {"name": "thrown", "g": 0.0, "joints": joints, "neighbours": MEET, "block": blocks}
    made = Structure.from_dict({**data, "solver": {"tolerance": tolerance, "without": ["peaks"]}}).going_on(1e3)
    places, *others = _start(seed)
    built = np.array([block.centroid for block in made.blocks])
    stepper = begun(made, STILL, SpatialState(places - built, *others))[0]
    times: Array = ROW * np.arange(round(FLIGHT / ROW) + 1, dtype=np.float64)
    begin = time.perf_counter()
    rows = stepper.run(STILL, 0.0, FLIGHT, times)
    return rows[:, 1] - rows[0, 1], time.perf_counter() - begin


def by_mujoco(step: float, seed: int, time_constant: float = 0.004) -> Run:
    """Throw boxes with soft contacts of this time constant, s."""
    import mujoco

    half = " ".join(f"{0.5 * BOX[name]}" for name in ("width", "depth", "height"))
    body = f'<body pos="0 0 0"><freejoint/><geom type="box" size="{half}" density="{BOX["density"]}"/></body>'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step}" gravity="0 0 0" integrator="implicitfast"/><default><geom friction="0 0 0" '
        f'condim="1" solref="{time_constant} 0.01"/></default><worldbody>{2 * body}</worldbody></mujoco>'
    )
    state, moved, spent = mujoco.MjData(model), [], 0.0
    for k, (place, turn, velocity, spin) in enumerate(zip(*_start(seed), strict=True)):
        angle = float(np.linalg.norm(turn))
        state.qpos[7 * k : 7 * k + 3] = place
        state.qpos[7 * k + 3 : 7 * k + 7] = [np.cos(0.5 * angle), *(np.sin(0.5 * angle) / angle * turn)]
        state.qvel[6 * k : 6 * k + 3] = velocity
        state.qvel[6 * k + 3 : 6 * k + 6] = rotation_matrix(turn).T @ spin  # along the axes of the body
    begins = float(state.qpos[7])
    for _ in range(round(FLIGHT / step)):
        moved.append(float(state.qpos[7]))
        begin = time.perf_counter()
        mujoco.mj_step(model, state)
        spent += time.perf_counter() - begin
    times = ROW * np.arange(round(FLIGHT / ROW) + 1)
    found = np.interp(times, step * np.arange(len(moved) + 1), [*moved, float(state.qpos[7])])
    return found - begins, spent


def throws(quick: bool) -> Table:
    """Compare two boxes thrown at each other, each program against itself at its finest."""
    rows = []
    for seed in range(1 if quick else 4):
        ways: dict[str, tuple[Callable[[float], Run], tuple[float, ...]]] = {
            "here, tolerance": (partial(here, seed=seed), TOLERANCES),
            "MuJoCo, step": (partial(by_mujoco, seed=seed), STEPS),
        }
        for name, (way, settings) in ways.items():
            try:
                point = point_of(way, settings, None)
            except ImportError as missing:
                rows.append([f"{seed}", name, str(missing), "", ""])
                continue
            if isinstance(point, Point):
                numbers = [f"{point.setting:g}", f"{point.error:.1e}", f"{1e3 * point.seconds:.3g}"]
            else:
                numbers = ["", point, ""]
            rows.append([f"{seed}", name, *numbers])
    return Table("Falls: two boxes thrown at each other", ["throw", "program", "setting", "error", "ms"], rows)


def colonnade(quick: bool) -> Table:
    """Let a colonnade of 40 blocks fall, for 5 s after the first one."""
    data = tomllib.loads(COLONNADE.read_text(encoding="utf-8"))
    # nine drums a column, no ties
    data = {key: value for key, value in data.items() if key != "tie"} | {"neighbours": LAW}
    for table in data["block"]:
        if "repeat" in table:
            table["repeat"], table["height"] = 9, table["height"] * 10 / 9
        else:
            table["on"] = [name.replace(".10", ".9") for name in table["on"]]
    blocks = [*data["block"], {"name": "block", "on": "base", "at": [-2.0, 0.0], **BOX}]
    made = Structure.from_dict({**data, "block": blocks})
    after = 0.5 if quick else AFTER
    begin = time.process_time()
    found = run(made.going_on(after), ricker(0.9 * G, 0.6), tolerance=1e-3, duration=4.5 + after)
    spent = time.process_time() - begin
    row = [f"{made.n}", f"{spent:.1f}", f"{found.overturn_time:.3f}", f"{found.stats['evaluations']}"]
    row += [f"{int(np.sum(found.uz[-1] < -0.3))}"]
    head = ["blocks", "s (60 asked)", "fall, s", "evaluations", "down"]
    return Table("Falls: a colonnade, 5 s after its fall, 1e-3", head, [row])


def measure(quick: bool) -> Iterator[Table]:
    """Measure all tables."""
    yield throws(quick)
    yield colonnade(quick)
