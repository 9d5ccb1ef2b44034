"""MuJoCo and LMGC90 on scenes of boxes: rigid bodies, contacts of their own kind, the base shaken by inertial forces.

Both run in the frame of the base. The time is that of the steps alone, s of the processor.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from importlib.util import find_spec
from multiprocessing import get_context
from typing import Any, NamedTuple

import numpy as np

from .right_hand_side import Array
from .rigid_blocks import Shaking
from .scenes import G

SETTLE = 0.5  # s under gravity alone before the motion
DENSITY = 2500.0  # kg/m3
GRAVITY_OF_LMGC90 = 9.81  # m/s2, fixed in its binding
BASE = ((-20.0, -20.0, -1.0), (20.0, 20.0, 0.0))  # m, the block that stands for the base
ALERT = 1e-2  # m, distance within which LMGC90 looks for contacts
INDICES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))  # of a hexahedron


class Solid(NamedTuple):
    """A convex hexahedron: the corners below, then those above, both anticlockwise from above; centroid at place."""

    corners: tuple[tuple[float, float, float], ...]  # m, from the centroid
    place: tuple[float, float, float]  # m
    volume: float  # m3


class Scene(NamedTuple):
    """Solids on a base under a motion."""

    solids: tuple[Solid, ...]
    fixed: tuple[Solid, ...]  # parts of the base; none: a plane
    shaking: Shaking
    duration: float  # s
    friction: float
    watched: int
    row: float = 0.01  # s


class Course(NamedTuple):
    """The motion of the watched block along x at the rows (m), and the time of the run (s)."""

    x: Array
    seconds: float


def box(x: float, z: float, width: float, depth: float, height: float) -> Solid:
    """Return a box whose bottom face has its middle at x, z."""
    a, b, c = 0.5 * width, 0.5 * depth, 0.5 * height
    foot = ((-a, -b), (a, -b), (a, b), (-a, b))
    corners = tuple((p, q, r) for r in (-c, c) for p, q in foot)
    return Solid(corners, (x, 0.0, z + c), width * depth * height)


def voussoir(begin: float, end: float, radius: float, thickness: float, depth: float) -> Solid:
    """Return a block of an arch between two angles (rad) about the origin."""
    inner, outer = radius - 0.5 * thickness, radius + 0.5 * thickness
    section = [
        (r * math.cos(a), r * math.sin(a)) for a, r in ((begin, inner), (begin, outer), (end, outer), (end, inner))
    ]
    points = np.array(section)
    after = np.roll(points, -1, axis=0)
    cross = points[:, 0] * after[:, 1] - after[:, 0] * points[:, 1]
    area = 0.5 * float(np.sum(cross))
    x, z = (np.sum((points + after) * cross[:, None], axis=0) / (6.0 * area)).tolist()
    ring = [(p - x, q - z) for p, q in section]
    corners = tuple((p, y, q) for y in (0.5 * depth, -0.5 * depth) for p, q in ring)
    return Solid(corners, (x, 0.0, z), area * depth)


def _at_rows(scene: Scene, step: float, places: Sequence[float]) -> Array:
    rows = scene.row * np.arange(round(scene.duration / scene.row) + 1)
    found: Array = np.interp(rows, step * np.arange(len(places)), places) - places[0]
    return found


# --- MuJoCo


def mujoco_model(scene: Scene, step: float, time_constant: float) -> Any:
    """Return the model, contacts of this time constant (s). Raises ImportError."""
    import mujoco

    assets, bodies = [], []
    for k, solid in enumerate((*scene.solids, *scene.fixed)):
        free = k < len(scene.solids)
        sides = np.ptp(np.array(solid.corners), axis=0)
        if math.isclose(float(np.prod(sides)), solid.volume, rel_tol=1e-9):
            geom = f'type="box" size="{" ".join(repr(float(0.5 * side)) for side in sides)}"'
        else:
            vertices = " ".join(repr(float(value)) for corner in solid.corners for value in corner)
            assets.append(f'<mesh name="m{k}" vertex="{vertices}"/>')
            geom = f'type="mesh" mesh="m{k}"'
        joint, mass = ("<freejoint/>", f'mass="{DENSITY * solid.volume}"') if free else ("", "")
        place = " ".join(repr(float(value)) for value in solid.place)
        bodies.append(f'<body pos="{place}">{joint}<geom {geom} {mass}/></body>')
    plane = "" if scene.fixed else '<geom type="plane" size="50 50 1"/>'
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step}" cone="elliptic" integrator="implicitfast" impratio="10"'
        f' gravity="0 0 {-G}"><flag multiccd="enable"/></option>'
        f'<default><geom friction="{scene.friction} 0 0" condim="3" solref="{time_constant} 1"/></default>'
        f"<asset>{''.join(assets)}</asset><worldbody>{plane}{''.join(bodies)}</worldbody></mujoco>"
    )


def by_mujoco(scene: Scene, step: float, time_constant: float = 0.0) -> Course:
    """Run MuJoCo; time_constant: s, 0: the least that its steps allow. Raises ImportError."""
    import mujoco

    model = mujoco_model(scene, step, time_constant or 2.0 * step)
    state = mujoco.MjData(model)
    for _ in range(round(SETTLE / step)):
        mujoco.mj_step(model, state)
    at, places = 7 * scene.watched, []
    count = round(scene.duration / step)
    pushes = [-scene.shaking.acceleration((k + 0.5) * step) for k in range(count)]
    gravity, place, advance = model.opt.gravity, state.qpos, mujoco.mj_step
    places.append(float(place[at]))
    begin = time.process_time()
    for push in pushes:
        gravity[0] = push
        advance(model, state)
        places.append(float(place[at]))
    return Course(_at_rows(scene, step, places), time.process_time() - begin)


# --- LMGC90


def lmgc90_solver(step: float, friction: float, solids: Sequence[Solid], law: str = "IQS_CLB") -> Any:
    """Return the solver with solids and a fixed base as its last block. Raises ImportError."""
    from compas_lmgc90.solver import Solver

    solver = Solver(dt=step, theta=0.5, density=DENSITY)
    blocks = [
        {"vertices": (np.array(solid.corners) + solid.place).tolist(), "faces": [list(face) for face in INDICES]}
        for solid in solids
    ]
    solver.geometry_from_v_f(blocks)
    solver.contact_law(law, friction, alert=ALERT)
    return solver


def _lmgc90(scene: Scene, step: float) -> Course:
    (x0, y0, z0), (x1, y1, z1) = BASE
    ground = box(0.0, z0, x1 - x0, y1 - y0, z1 - z0)
    fixed = scene.fixed or (ground,)
    solver = lmgc90_solver(step, scene.friction, (*scene.solids, *fixed))
    settle, count = round(SETTLE / step), round(scene.duration / step)
    instants = step * np.arange(settle + count + 2)
    along = np.array([scene.shaking.acceleration(t - settle * step) if t >= settle * step else 0.0 for t in instants])
    for k, solid in enumerate(scene.solids):
        mass = DENSITY * solid.volume
        solver.apply_force(k, "Fx", np.array([instants, -mass * along]))
        solver.apply_force(k, "Fz", np.array([[0.0, instants[-1]], [mass * (GRAVITY_OF_LMGC90 - G)] * 2]))
    for k in range(len(fixed)):
        for component in ("Vx", "Vy", "Vz", "Rx", "Ry", "Rz"):
            solver.apply_velocity(len(scene.solids) + k, component, np.zeros((1, 6)))
    solver.preprocess()
    advance = solver.lmgc90.compute_one_step
    for _ in range(settle):
        state = advance()
    places = [float(state.bodies[scene.watched][0])]
    begin = time.process_time()
    for _ in range(count):
        places.append(float(advance().bodies[scene.watched][0]))
    spent = time.process_time() - begin
    solver.finalize()
    return Course(_at_rows(scene, step, places), spent)


class Apart:
    """Calls in a process of their own: LMGC90 ends its process at an error."""

    def __init__(self) -> None:
        self._pool: ProcessPoolExecutor | None = None

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Return what the function returns. Raises ImportError, RuntimeError."""
        if self._pool is None:
            self._pool = ProcessPoolExecutor(1, mp_context=get_context("spawn"))
        try:
            return self._pool.submit(function, *arguments).result()
        except BrokenProcessPool:
            self._pool = None
            raise RuntimeError("it ended its process") from None


_APART = Apart()


def by_lmgc90(scene: Scene, step: float) -> Course:
    """Run LMGC90, non-smooth contact dynamics, in another process. Raises ImportError, RuntimeError."""
    course: Course = _APART.call(_lmgc90, scene, step)
    return course


def missing() -> dict[str, str]:
    """Return the programs that are not installed, with the reason."""
    names = {"MuJoCo": "mujoco", "LMGC90": "compas_lmgc90"}
    return {name: "not installed (extra peers)" for name, package in names.items() if find_spec(package) is None}
