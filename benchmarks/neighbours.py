"""Blocks that meet across a gap: cost of a pair, of a store of casks; errors in tolerances; MuJoCo at equal error.

Each measurement yields its table, as those of in_space.py do.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from multiblock import Motion, Structure
from solver.kernels.structure.layout import BY_BODIES, BY_SIDES, CONVEX
from solver.models.structure.rest import rest_of
from solver.models.structure.stepper import SpatialStepper

from .engines import Point, Run, point_of
from .in_space import Table, run, tolerances
from .right_hand_side import Array
from .scenes import G

RUNS = 25  # of which the shortest counts
CASK: dict[str, Any] = {"shape": "drum", "diameter": 2.0, "height": 5.0, "density": 2500.0}
LAW = {"stiffness": 2e9, "damping": 1e-3, "friction": 0.5}
MEET = {"reach": 0.5, "line_stiffness": 1e9, "stiffness": 1e9, "restitution": 0.5, "friction": 0.3}
STORE, LONG, SHAKEN = 5, 30.0, 0.6  # casks in a row of the store, s, g
PARTS = 0.5, 3.0  # s, runs whose difference is measured
ROW = 0.01  # s, between the rows that are compared
STEPS = (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5)  # s
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-9)


def row_of(*blocks: dict[str, Any], apart: float, met: bool = True, **neighbours: float) -> Structure:
    """Return blocks in a row along x."""
    tables = [{"name": f"b{k}", "on": "base", "at": [k * apart, 0.0], **block} for k, block in enumerate(blocks)]
    data: dict[str, Any] = {"name": "row", "joints": LAW, "block": tables}
    return Structure.from_dict(data | ({"neighbours": {**MEET, **neighbours}} if met else {}))


def grid(block: dict[str, Any], count: int, apart: float, met: bool, reach: float) -> Structure:
    """Return equal blocks in a square."""
    places = [[apart * i, apart * j] for i in range(count) for j in range(count)]
    blocks = [{"name": f"b{k}", "on": "base", "at": place, **block} for k, place in enumerate(places)]
    data: dict[str, Any] = {"name": "grid", "joints": LAW, "block": blocks}
    return Structure.from_dict(data | ({"neighbours": {**MEET, "reach": reach}} if met else {}))


def store(count: int = STORE, met: bool = True, reach: float = 0.5) -> Structure:
    """Return casks 0.2 m apart in a square."""
    return grid(CASK, count, 2.2, met, reach)


def shaking(duration: float = LONG, largest: float = SHAKEN) -> Motion:
    """Return three components of slow noise, the vertical one half as strong."""
    rng, step = np.random.default_rng(0), 0.02
    count = round(duration / step)

    def component(part: float) -> Array:
        noise = np.cumsum(rng.normal(size=count))
        for width, keeps in ((80, False), (12, True)):
            mean = np.convolve(noise, np.ones(width) / width, "same")
            noise = mean if keeps else noise - mean
        return part * G * noise / float(np.max(np.abs(noise)))

    ax, ay, az = component(largest), component(0.9 * largest), component(0.5 * largest)
    return Motion.from_samples(step, ax, ay=ay, az=az)


def _evaluation(structure: Structure, pressed: float | None = None, turn: float = 0.0) -> float:
    """Return the processor time, s, of an evaluation at rest, or with all pairs pressed into each other, m.

    turn: rad, by which every second block is turned about the vertical as it is pressed.
    """
    stepper, least = SpatialStepper(structure), math.inf
    stepper.phase[:] = rest_of(structure).phase
    if pressed is not None:
        gap = structure.neighbours[0].gap
        stepper.see.ux[:] -= (gap + pressed) * np.arange(structure.n)
        stepper.see.q0[::2], stepper.see.q3[::2] = math.cos(0.5 * turn), math.sin(0.5 * turn)
        pairs = structure.model.names.pairs
        stepper.state.remembered.stretches.touches[:] = np.where(pairs.kind == CONVEX, BY_BODIES, BY_SIDES)
    delta = np.full(6 * structure.n, 1e-7)
    for _ in range(RUNS):
        begin = time.process_time()
        stepper.stiffness(delta)
        least = min(least, time.process_time() - begin)
    return least / (12 * structure.n)


def _in_a_run(structure: Structure) -> float:
    """Return the time of this thread, s, of an evaluation in a run, with all that its steps do beside evaluations.

    It is the difference of a long and a short run, which both find the rest and write two rows; other threads, those of
    a BLAS that wait for work, do not count.
    """
    made, motion = structure.with_settings(without=("elastic",)), shaking(PARTS[-1], 0.3)
    least, evaluations = dict.fromkeys(PARTS, math.inf), dict.fromkeys(PARTS, 0)
    for _ in range(RUNS // 2):
        for duration in PARTS:
            begin = time.thread_time()
            found = run(made, motion, duration=duration, tolerance=1e-4, check=False, output_step=duration)
            least[duration] = min(least[duration], time.thread_time() - begin)
            evaluations[duration] = int(found.stats["evaluations"])
    short, long = PARTS
    return (least[long] - least[short]) / (evaluations[long] - evaluations[short])


def costs() -> Table:
    """Measure the costs of a pair in an evaluation: far, and of each kind while it is pressed."""
    rows = []
    many, alone = store(8, reach=3.0), store(8, met=False)
    far = (_evaluation(many) - _evaluation(alone)) / len(many.neighbours)
    rows.append(["far", f"{1e9 * far:.1f}", "3"])
    box: dict[str, Any] = {"width": 2.0, "depth": 2.0, "height": 5.0, "density": 2500.0}
    low = {**box, "width": 1.6, "depth": 1.4, "height": 4.0}
    # blocks, distance, turn of every second one, which moves its nearest corner by `nearer`, and what is asked
    kinds: dict[str, tuple[tuple[dict[str, Any], ...], float, str]] = {
        "drum beside drum": ((CASK,) * 8, 0.0, "331"),
        "drum before a face": ((CASK, box) * 4, 0.0, ""),
        "two boxes face to face": ((box, low) * 4, 0.0, "2500"),
        "two equal boxes face to face": ((box,) * 8, 0.0, "2500"),
        "edge of a box on a face": ((box,) * 2, 0.25 * math.pi, "6000"),
    }
    for name, (blocks, turn, asked) in kinds.items():
        made, alone = (row_of(*blocks, apart=3.0 if turn else 2.2, met=met, reach=1.2) for met in (True, False))
        nearer = math.sqrt(2.0) - 1.0 if turn else 0.0  # m, of the corner of a square of 2 m
        spent = (_evaluation(made, 1e-4 - nearer, turn) - _evaluation(alone)) / len(made.neighbours)
        rows.append([name, f"{1e9 * spent:.0f}", asked])
    near, alone = (grid(box, 6, 2.6, met, 3.4) for met in (True, False))
    within = (_in_a_run(near) - _in_a_run(alone)) / len(near.neighbours)
    rows.append(["boxes apart, whose spheres overlap, in a run", f"{1e9 * within:.0f}", "60"])
    return Table("Neighbours: cost of a pair in an evaluation", ["pair", "ns", "asked"], rows)


def of_store(quick: bool) -> Table:
    """Run a store of casks under three components."""
    motion = shaking(3.0 if quick else LONG)
    rows = []
    for met in (True, False):
        made = store(met=met)
        begin = time.process_time()
        found = run(made.with_settings(without=("elastic",)), motion, tolerance=1e-3)
        spent = time.process_time() - begin
        hits = int(np.sum(found.peaks["hit"] > 0.0))
        rows.append(
            [
                f"{made.n} casks" + ("" if met else ", which pass through each other"),
                f"{spent:.2f}",
                f"{hits}",
                f"{float(np.max(found.peaks['u'])):.3f}",
                f"{found.verdict}",
                f"{found.stats['evaluations']}",
            ]
        )
    head = ["three components, 30 s, 1e-3", "s (6 asked)", "pairs that hit", "largest, m", "verdict", "evaluations"]
    return Table("Neighbours: a store of casks", head, rows)


def random_rows(seed: int = 3) -> Iterator[tuple[Structure, Motion]]:
    """Yield casks and boxes in rows, so near to each other that they hit, under harmonic motions."""
    rng = np.random.default_rng(seed)
    for kind in ("drums", "drums and boxes", "boxes"):
        for _ in range(4):
            height = rng.uniform(3.0, 5.0)
            drum = {"shape": "drum", "diameter": 1.0, "height": height, "density": 2500.0}
            box = {"width": 1.0, "depth": 1.0, "height": rng.uniform(0.7, 1.0) * height, "density": 2500.0}
            blocks: dict[str, tuple[dict[str, Any], ...]] = {
                "drums": (drum, drum),
                "drums and boxes": (drum, box),
                "boxes": (box, {**box, "height": height}),
            }
            made = row_of(*blocks[kind], apart=1.0 + rng.uniform(0.003, 0.01), restitution=rng.uniform(0.2, 0.8))
            motion = Motion.harmonic(
                rng.uniform(0.25, 0.45) * G, rng.uniform(1.0, 2.0), 1.0, direction=rng.uniform(0.0, 0.5)
            )
            yield replace(made, name=kind), motion


def errors(quick: bool) -> Table:
    """Measure errors as of structures whose blocks do not meet."""
    return tolerances(quick, random_rows(), "Neighbours: error over tolerance")


# --- MuJoCo


def _two_casks() -> tuple[Structure, Motion]:
    return row_of(CASK, CASK, apart=2.01), Motion.harmonic(0.6 * G, 1.0, 1.0)


def here(tolerance: float) -> Run:
    """Solve by this solver."""
    structure, motion = _two_casks()
    found = run(structure.with_settings(without=("peaks",)), motion, tolerance=tolerance, duration=2.0, output_step=ROW)
    return found.ux[:, 1], float(found.stats["wall_time"])


def by_mujoco(step: float, time_constant: float = 0.004) -> Run:
    """Solve by cylinders with soft contacts of this time constant, s."""
    import mujoco

    structure, motion = _two_casks()
    bodies = "".join(
        f'<body pos="{2.01 * k} 0 2.5"><freejoint/><geom type="cylinder" size="1 2.5" mass="{block.mass}"/></body>'
        for k, block in enumerate(structure.blocks)
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step}" cone="elliptic" integrator="implicitfast" impratio="10"/><default>'
        f'<geom friction="0.5 0 0" condim="3" solref="{time_constant} 1"/></default>'
        f'<worldbody><geom type="plane" size="50 50 1"/>{bodies}</worldbody></mujoco>'
    )
    state, places, spent = mujoco.MjData(model), [], 0.0
    settle, count = round(0.5 / step), round(2.0 / step)
    for k in range(-settle, count):
        t = k * step
        shakes = 0.0 <= t < motion.duration
        model.opt.gravity[0] = -0.6 * G * math.sin(2.0 * math.pi * t) if shakes else 0.0
        if k >= 0:
            places.append(float(state.qpos[7]))
        begin = time.perf_counter()
        mujoco.mj_step(model, state)
        spent += time.perf_counter() - begin if k >= 0 else 0.0
    rows = ROW * np.arange(round(2.0 / ROW) + 1)
    found = np.interp(rows, step * np.arange(count + 1), [*places, float(state.qpos[7])])
    return found - places[0], spent


def against_mujoco(quick: bool) -> Table:
    """Compare two casks 10 mm apart that rock and hit, each program against itself at its finest."""
    steps = STEPS[: 5 if quick else None]
    ways: dict[str, tuple[Callable[[float], Run], tuple[float, ...]]] = {
        "here, tolerance": (here, TOLERANCES),
        **{
            f"MuJoCo, contacts of {constant:g} s, step": (
                partial(by_mujoco, time_constant=constant),
                tuple(step for step in steps if 2.0 * step <= constant),
            )
            for constant in (0.02, 0.004)
        },
    }
    rows, first = [], math.nan
    for name, (way, settings) in ways.items():
        try:
            point = point_of(way, settings, None)
        except ImportError as missing:
            rows.append([name, str(missing), "", "", "", ""])
            continue
        if not isinstance(point, Point):
            rows.append([name, "", point, "", "", ""])
            continue
        first = first if first == first else point.seconds
        numbers = [f"{point.setting:g}", f"{point.error:.1e}", f"{1e3 * point.seconds:.3g}"]
        rows.append([name, *numbers, f"{point.seconds / first:.1f}", f"{1e3 * point.peak:.1f}"])
    head = ["two casks that hit", "setting", "error", "ms", "over here (10 asked)", "largest, mm"]
    return Table("Neighbours: MuJoCo at equal error", head, rows)


def measure(quick: bool) -> Iterator[Table]:
    """Measure all tables."""
    yield costs()
    yield of_store(quick)
    yield errors(quick)
    yield against_mujoco(quick)
