"""Physics engines on what they can do too: blocks that rock and a slab that slides, at equal error.

An engine has its own law of contact, so its error is that against its own result at the shortest step; of the slab,
that against a rigid slab. An error at a step counts only if all shorter steps keep it too.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from multiblock import Motion, Structure

from .in_space import EQUAL_ERROR, NEWMARK, Table, boxes, run
from .right_hand_side import Array
from .scenes import DAMPING, HEIGHT, MASS, SIDE, G

Sizes = Sequence[tuple[float, float, float, float]]  # width, depth, height, m, and mass, kg; the lowest first
ROW, SETTLE = 0.01, 0.5  # s: between the rows that are compared; engines settle under gravity before the motion
STEPS = (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5)  # s
QUICK_STEPS = STEPS[:4]
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-9)
REPEATS = 3


class Task(NamedTuple):
    """The task of every program; the base moves by amplitude sin(2 pi frequency t) for a duration."""

    name: str
    sizes: Sizes
    friction: float
    amplitude: float  # g
    frequency: float  # Hz
    duration: float  # s
    length: float  # s, of the run
    far: float | None  # m, where the top block is in the end, of rigid blocks; None: not known

    def acceleration(self, t: float) -> float:
        """Return the acceleration of the base, m/s2."""
        return self.amplitude * G * math.sin(2.0 * math.pi * self.frequency * t) if t < self.duration else 0.0


TASKS = (
    Task("three blocks rock, 0.2 g 1 Hz", ((SIDE, SIDE, HEIGHT / 3, MASS / 3),) * 3, 0.7, 0.2, 1.0, 1.0, 4.0, None),
    Task("a slab slides, 0.5 g 2 Hz", ((4.0, 4.0, 0.2, 1000.0),), 0.3, 0.5, 2.0, 0.25, 1.0, 1e-3 * NEWMARK),
)
MODULI = {TASKS[0].name: None, TASKS[1].name: 1e8}  # N/m3; None: that of the Column of Phocas

Run = tuple[Array, float]  # ux of the top block at the rows, m; s of the steps alone, models and rest are made before


def here(task: Task, tolerance: float) -> Run:
    """Solve by this solver, with a friction that gives way in the slab and none in the column, which does not slide."""
    modulus = MODULI[task.name]
    if modulus is None:
        structure = boxes()
    else:
        width, depth, height, mass = task.sizes[0]
        block = {"name": "b", "width": width, "depth": depth, "height": height, "mass": mass, "on": "base"}
        law = {"stiffness": modulus, "damping": DAMPING, "friction": task.friction}
        structure = Structure.from_dict({"name": "slab", "joints": law, "block": [block]})
    motion = Motion.harmonic(task.amplitude * G, task.frequency, task.duration)
    structure = structure.with_settings(without=("peaks",))
    found = run(structure, motion, duration=task.length, tolerance=tolerance, output_step=ROW)
    return found.ux[:, -1], found.stats["wall_time"]


def by_mujoco(task: Task, step: float, time_constant: float, ratio: float) -> Run:
    """Solve by boxes with soft contacts of this time constant, s; ratio: stiffness of friction over that across."""
    import mujoco

    bodies, level = [], 0.0
    for width, depth, height, mass in task.sizes:
        half = f"{0.5 * width} {0.5 * depth} {0.5 * height}"
        geom = f'<geom type="box" size="{half}" mass="{mass}"/>'
        bodies.append(f'<body pos="0 0 {level + 0.5 * height}"><freejoint/>{geom}</body>')
        level += height
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step}" cone="elliptic" integrator="implicitfast" impratio="{ratio}"/><default>'
        f'<geom friction="{task.friction} 0 0" condim="3" solref="{time_constant} 1"/></default>'
        f'<worldbody><geom type="plane" size="50 50 1"/>{"".join(bodies)}</worldbody></mujoco>'
    )
    state = mujoco.MjData(model)

    def advance(acceleration: float) -> float:
        model.opt.gravity[0] = -acceleration
        mujoco.mj_step(model, state)
        return float(state.qpos[-7])

    return _stepped(task, step, advance)


def by_bullet(task: Task, step: float) -> Run:
    """Solve by PyBullet's boxes, 50 iterations of its solver a step."""
    import pybullet

    pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setTimeStep(step)
        pybullet.setPhysicsEngineParameter(numSolverIterations=50)
        bodies = [pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_PLANE))]
        level = 0.0
        for width, depth, height, mass in task.sizes:
            half = [0.5 * width, 0.5 * depth, 0.5 * height]
            shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half)
            bodies.append(pybullet.createMultiBody(mass, shape, basePosition=[0.0, 0.0, level + 0.5 * height]))
            level += height
        single = math.sqrt(task.friction)  # a contact has the product of both
        for body in bodies:
            pybullet.changeDynamics(
                body, -1, lateralFriction=single, restitution=0.0, linearDamping=0.0, angularDamping=0.0
            )

        def advance(acceleration: float) -> float:
            pybullet.setGravity(-acceleration, 0.0, -G)
            pybullet.stepSimulation()
            return float(pybullet.getBasePositionAndOrientation(bodies[-1])[0][0])

        return _stepped(task, step, advance)
    finally:
        pybullet.disconnect()


def _stepped(task: Task, step: float, advance: Callable[[float], float]) -> Run:
    start = 0.0
    for _ in range(round(SETTLE / step)):
        start = advance(0.0)
    accelerations = [task.acceleration(k * step) for k in range(round(task.length / step))]
    begin = time.perf_counter()
    places = [start, *map(advance, accelerations)]
    spent = time.perf_counter() - begin
    rows = ROW * np.arange(round(task.length / ROW) + 1)
    return np.interp(rows, step * np.arange(len(places)), places) - start, spent


class Point(NamedTuple):
    """The loosest step or tolerance that keeps the error, its error and s; the largest displacement, m."""

    setting: float
    error: float
    seconds: float
    peak: float


def point_of(way: Callable[[float], Run], settings: Sequence[float], far: float | None) -> Point | str:
    """Choose of the settings, the tightest last, the first from which on all are within EQUAL_ERROR.

    Or the least error.
    """
    found = [way(setting) for setting in settings]
    best = found[-1][0]
    peak = float(np.max(np.abs(best)))
    if far is None:
        errors = [float(np.max(np.abs(ux - best))) / peak for ux, _ in found[:-1]]
    else:
        errors = [abs(abs(float(ux[-1])) / far - 1.0) for ux, _ in found]
    kept = 0
    while kept < len(errors) and errors[-1 - kept] <= EQUAL_ERROR:
        kept += 1
    if not kept:
        return f"{errors[-1]:.1e} at {settings[len(errors) - 1]:g}"
    k = len(errors) - kept
    seconds = min([found[k][1], *(way(settings[k])[1] for _ in range(REPEATS - 1))])
    return Point(settings[k], errors[k], seconds, peak)


def against_engines(quick: bool) -> Table:
    """Solve both tasks by all programs that are installed."""
    steps = QUICK_STEPS if quick else STEPS
    rows = []
    for task in TASKS:
        ways: dict[str, tuple[Callable[[float], Run], Sequence[float]]] = {
            "here, tolerance": (partial(here, task), TOLERANCES),
            **{
                f"MuJoCo, contacts of {constant:g} s, impratio {ratio:g}, step": (
                    partial(by_mujoco, task, time_constant=constant, ratio=ratio),
                    [step for step in steps if 2.0 * step <= constant],
                )
                for constant, ratio in ((0.02, 1.0), (0.004, 10.0))
            },
            "PyBullet, step": (partial(by_bullet, task), steps),
        }
        first = math.nan
        for name, (way, settings) in ways.items():
            try:
                point = point_of(way, settings, task.far)
            except ImportError as missing:
                rows.append([f"{task.name}: {name}", str(missing), "", "", "", ""])
                continue
            if isinstance(point, str):
                rows.append([f"{task.name}: {name}", "", point, "", "", ""])
                continue
            first = first if first == first else point.seconds
            numbers = [f"{point.setting:g}", f"{point.error:.1e}", f"{1e3 * point.seconds:.3g}"]
            rows.append([f"{task.name}: {name}", *numbers, f"{point.seconds / first:.1f}", f"{1e3 * point.peak:.1f}"])
    head = ["task: program", "setting", "error", "ms", "over here (10 asked)", "largest, mm"]
    return Table("Structures in space: physics engines at equal error", head, rows)
