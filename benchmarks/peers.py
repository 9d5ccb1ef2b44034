"""Rigid-body programs on the same tasks as this solver: error against truths of rigid blocks, and time.

Five tasks: the boundaries of a block under a cosine pulse, the rocking frame, an arch, three boxes, two boxes that hit
each other. Each program runs at several steps or tolerances; its error is taken against the truth (rigid_blocks.py,
limit analysis) and against its own finest run. Each measurement yields its table, as those of in_space.py do.
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np

from multiblock import Column, Motion, Structure, arch, push_over, simulate
from solver.common.errors import InputWarning
from solver.models.structure.run import SpatialState, begun
from solver.statics.rocking import damping_on_edge
from validation.limits import largest_push

from . import peer_programs, rigid_blocks
from .in_space import Table
from .peer_programs import DENSITY, Course, Scene, box, by_lmgc90, by_mujoco, voussoir
from .right_hand_side import Array
from .rigid_blocks import Shaking
from .scenes import G

REPEATS = 3  # of which the shortest counts
RIM = 1e-3  # m
STRIP = 32  # strips of a joint in the plane, of which the outer two touch
PLANE_LIMIT, IN_PLANE = 0.5, "here, plane"  # rad, at which a column of these sizes is overturned
RIGID = 1e13  # N/m3, of joints that touch at their edges
TIGHT = 1e-4  # tolerance where the stiffness is varied
SAMPLE = 5e-3  # s, of the pulse
DEEP = 40.0  # m: so deep that the bands along the motion do not matter
FALLEN = 0.7  # m, the centroid of the block lies beyond
BLOCK = (0.4, 1.6)  # m
COLUMN, BEAM, APART = (0.9, 4.0), (3.9, 0.7), 3.0  # m
BOXES = (1.0, 2.0)  # m
LEVELS = (0.3, 0.4)  # g, of the frame
BOUNDARIES = ((0.28, 0.42, True), (1.0, 1.25, False), (1.25, 1.6, True))  # g; falls above
WIDTH = 2e-4  # g, within which a boundary is found
TIMED = 0.35  # g, of the pulse under which a block is timed: it stands
ARCH = (7, 10.0, 1.5, 1.0, math.radians(157.5))  # voussoirs, radius, thickness, depth, m, angle
MOVED, HELD = 0.05, 3.0  # m, s: an arch under a constant push has given way

Run = Callable[[Scene, float], Course]


class Program(NamedTuple):
    """A program with the values of its accuracy knob, the finest last."""

    name: str
    knob: str
    values: tuple[float, ...]
    run: Run


# --- the scenes


def block_scene(level: float) -> Scene:
    """Return a block under one cosine pulse of 1 Hz."""
    width, height = BLOCK
    return Scene((box(0.0, 0.0, width, width, height),), (), Shaking(level, 1.0, 1.0, 0.5 * math.pi), 5.0, 5.0, 0)


def frame_scene(level: float) -> Scene:
    """Return two columns under a beam, shaken by a sine of 1 Hz."""
    width, height = COLUMN
    columns = tuple(box(x, 0.0, width, width, height) for x in (-0.5 * APART, 0.5 * APART))
    return Scene((*columns, box(0.0, height, BEAM[0], width, BEAM[1])), (), Shaking(level, 1.0, 4.0), 4.0, 5.0, 2)


def boxes_scene(level: float) -> Scene:
    """Return three boxes on each other, shaken by a sine of 1 Hz."""
    width, height = BOXES
    solids = tuple(box(0.0, k * height, width, width, height) for k in range(3))
    return Scene(solids, (), Shaking(level, 1.0, 4.0), 4.0, 1.0, 2)


def arch_scene(level: float) -> Scene:
    """Return an arch between two fixed blocks under a constant push."""
    count, radius, thickness, depth, angle = ARCH
    turn = angle / count
    first = 0.5 * (math.pi - angle)
    solids = tuple(
        voussoir(first + k * turn, first + (k + 1) * turn, radius, thickness, depth) for k in range(-1, count + 1)
    )
    shaking = Shaking(level, 1e-9, HELD, 0.5 * math.pi)
    return Scene(solids[1:-1], (solids[0], solids[-1]), shaking, HELD, 5.0, count // 2)


# --- this solver


def critical(stiffness: float, area: float, solid: tuple[float, float, float]) -> float:
    """Return the damping (s) that is critical as a block of this width, height (m) and mass (kg) lands on its edge."""
    width, height, mass = solid
    return damping_on_edge(stiffness, area, mass, mass * (width**2 + height**2) / 12.0, 0.5 * width)


def _law(where: str, stiffness: float, width: float, depth: float, height: float) -> dict[str, float]:
    """Return the law of the joints under a block: its whole face touches, or a rim of it."""
    mass = DENSITY * width * depth * height
    if where == "whole":
        return {"stiffness": stiffness, "damping": 1e-3}
    law = {"stiffness": stiffness, "damping": critical(stiffness, RIM * depth, (width, height, mass))}
    return law | ({"rim": RIM} if where == "rim" else {})


def structure(scene: Scene, where: str, stiffness: float = RIGID, deep: float = 0.0) -> Structure:
    """Return the structure of boxes whose faces touch wholly, in a rim, or on two strips along their edges.

    deep: depth (m) in place of that of the scene, if not 0. With friction above 1 joints never slide.
    """
    size = [np.ptp(np.array(solid.corners), axis=0) for solid in scene.solids]
    blocks, joints = [], []
    for k, (solid, (width, depth, height)) in enumerate(zip(scene.solids, size, strict=True)):
        foot = solid.place[2] - 0.5 * height
        blocks.append(
            {"name": f"b{k}", "position": [solid.place[0], 0.0, foot], "width": width, "depth": deep or depth}
            | {"height": height, "density": DENSITY}
        )
        below = [
            j for j in range(k) if abs(scene.solids[j].place[2] + 0.5 * size[j][2] - foot) < 1e-9
        ] or [-1]  # fmt: skip
        for j in below:
            middle, wide = (solid.place[0], width) if j < 0 else (scene.solids[j].place[0], min(width, size[j][0]))
            one = size[j] if j >= 0 and len(below) > 1 else size[k]
            law = _law(where, stiffness, float(one[0]), float(deep or one[1]), float(one[2]))
            law |= {"friction": scene.friction} if where != "strips" and scene.friction <= 1.0 else {}
            half = 0.5 * (wide - RIM)
            places = (middle - half, middle + half) if where == "strips" else (middle,)
            for x in places:
                face = {"section": "rectangle", "width": RIM if where == "strips" else wide, "depth": deep or depth}
                between = [f"b{k}", f"b{j}" if j >= 0 else "base"]
                joints.append({"between": between, "at": [x, 0.0, foot], "normal": [0.0, 0.0, 1.0], **face, **law})
    plain = {"stiffness": stiffness, "damping": 1e-3}
    return Structure.from_dict({"name": "boxes", "joints": plain, "block": blocks, "joint": joints})


def column(where: str, stiffness: float = RIGID) -> Column:
    """Return the block as a column in its plane: whole face, outer two of 32 strips, or a rim of a deep block."""
    width, height = BLOCK
    depth = DEEP if where == "rim" else width
    mass = DENSITY * width * depth * height
    joint: dict[str, Any] = _law(where, stiffness, width, depth, height)
    if where == "strips":
        area = width / STRIP * depth
        joint["damping"] = critical(stiffness, area, (width, height, mass))
        joint |= {"section": "strips", "width": width, "strips": [depth, *[0.0] * (STRIP - 2), depth]}
    block = {"width": width, "depth": depth, "height": height, "mass": mass, "joint": joint}
    return Column.from_dict({"name": "block", "block": [block]})


def motion_of(shaking: Shaking) -> Motion:
    """Return the motion; a sine as a formula, others in samples."""
    if shaking.phase == 0.0:
        return Motion.harmonic(shaking.amplitude * G, shaking.frequency, shaking.end)
    count = round(shaking.end / SAMPLE)
    return Motion.from_samples(SAMPLE, [shaking.wave(SAMPLE * k) for k in range(count + 1)])


@cache
def _subject(make: Callable[..., Any], scene: Scene | None, where: str, stiffness: float, deep: float) -> Any:
    return make(where, stiffness) if scene is None else make(scene, where, stiffness, deep)


def here(
    scene: Scene,
    value: float,
    where: str,
    stiffness: float = 0.0,
    plane: bool = False,
    deep: float = 0.0,
) -> Course:
    """Run this solver at a tolerance; stiffness 0: the value is the stiffness (N/m3), at the tolerance TIGHT."""
    tolerance, modulus = (value, stiffness) if stiffness else (TIGHT, value)
    if plane:
        made, watched = _subject(column, None, where, modulus, 0.0), 0
    else:
        still = scene._replace(shaking=Shaking(0.0, 1.0, 0.0))
        made, watched = _subject(structure, still, where, modulus, deep), scene.watched
    motion = motion_of(scene.shaking)
    options = {"duration": scene.duration, "tolerance": tolerance, "output_step": scene.row, "settle": 0.0}
    begin = time.process_time()
    found: Any = simulate(made.with_settings(without=("peaks",)), motion, **options)
    spent = time.process_time() - begin
    x: Array = found.ux[:, watched].copy()
    if plane:  # of the centroid: those of a column belong to its top face
        x -= 0.5 * BLOCK[1] * np.sin(found.ry[:, 0])
    if found.overturned:
        x[-1] = 1.5 * FALLEN
    rows = scene.row * np.arange(round(scene.duration / scene.row) + 1)
    return Course(np.interp(rows, found.time[: len(x)], x), spent)


# --- programs


def programs(quick: bool, plane: bool, stiff: tuple[float, ...], soft: Sequence[float]) -> list[Program]:
    """Return the ways to solve a task, this solver's first; those not installed are left out."""
    tolerances = (1e-2, 1e-3, 1e-4) if quick else (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
    steps = (2e-3, 1e-3, 5e-4) if quick else (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1e-4)
    ways = []
    if plane:
        ways.append(Program("here, plane, whole faces", "N/m3", stiff, partial(here, where="whole", plane=True)))
        for where, name in (("strips", "strips at the edges"), ("rim", "rim 1 mm, deep")):
            run = partial(here, where=where, stiffness=RIGID, plane=True)
            ways.append(Program(f"here, plane, {name}", "tolerance", tolerances, run))
    ways.append(Program("here, space, whole faces", "N/m3", tuple(soft), partial(here, where="whole")))
    for where, name, deep in (
        ("rim", "rim 1 mm, square", 0.0),
        ("rim", "rim 1 mm, deep", DEEP),
        ("strips", "two strips of 1 mm", 0.0),
    ):
        run = partial(here, where=where, stiffness=RIGID, deep=deep)
        ways.append(Program(f"here, space, {name}", "tolerance", tolerances, run))
    absent = peer_programs.missing()
    if "MuJoCo" not in absent:
        default = tuple(step for step in steps if step >= 5e-4)
        ways.append(Program("MuJoCo, contacts of two steps", "step, s", steps, by_mujoco))
        ways.append(Program("MuJoCo, contacts of 20 ms", "step, s", default, partial(by_mujoco, time_constant=0.02)))
    if "LMGC90" not in absent:
        ways.append(Program("LMGC90", "step, s", steps[: 3 if quick else 4], by_lmgc90))
    return ways


def timed(program: Program, scene: Scene, value: float) -> Course:
    """Return the course with the shortest of its times."""
    program.run(scene, value)  # compiles
    runs = [program.run(scene, value) for _ in range(REPEATS)]
    return Course(runs[0].x, min(run.seconds for run in runs))


def boundary(falls: Callable[[float], bool], low: float, high: float, above: bool) -> float:
    """Return where the verdict changes, by bisection (g)."""
    while high - low > WIDTH:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if falls(middle) == above else (middle, high)
    return 0.5 * (low + high)


class Found(NamedTuple):
    """The answers of a program at one value of its knob."""

    program: str
    knob: str
    value: float
    answers: tuple[float, ...]
    pace: float  # ms of the processor for a second of motion
    course: Array


def _each(
    ways: Sequence[Program], ask: Callable[[Program, float], tuple[tuple[float, ...], float, Array]]
) -> Iterator[Found]:
    for program in ways:
        for value in program.values:
            try:
                answers, pace, course = ask(program, value)
            except RuntimeError as failure:
                yield Found(program.name, f"{program.knob}: {failure}", value, (), math.nan, np.zeros(0))
                continue
            yield Found(program.name, program.knob, value, answers, pace, course)


def _finest(found: Sequence[Found], one: Found) -> Found:
    return [other for other in found if other.program == one.program and other.answers][-1]


def _setting(one: Found) -> str:
    return f"{one.program}; {one.knob} {one.value:g}"


def _off(value: float) -> str:
    return "finest" if value == 0.0 else f"{value:.1e}"


# --- the tasks; each also returns the points of its panel of the picture: program -> (ms a second, error)

Points = dict[str, list[tuple[float, float]]]


def _points(found: Sequence[Found], errors: Sequence[float]) -> Points:
    points: Points = {}
    for one, error in zip(found, errors, strict=True):
        if math.isfinite(error) and error > 0.0:
            points.setdefault(one.program, []).append((one.pace, error))
    return points


def _rows(
    found: Sequence[Found], cells: int, cells_of: Callable[[Found], tuple[list[str], float]]
) -> tuple[list[list[str]], list[float]]:
    """Return a row for each answer, and its error; `cells_of` has the cells between setting and pace.

    A row without an answer has as many empty `cells`, and no error.
    """
    rows, errors = [], []
    for one in found:
        middle, error = cells_of(one) if one.answers else ([""] * cells, math.nan)
        rows.append([_setting(one), *middle, f"{one.pace:.3g}" if one.answers else ""])
        errors.append(error)
    return rows, errors


def _peaks_of(
    make: Callable[[float], Scene], levels: tuple[float, float]
) -> Callable[[Program, float], tuple[tuple[float, ...], float, Array]]:
    """Return the question for the peaks (m) of a scene at two levels (g), and its history at the first."""

    def ask(program: Program, value: float) -> tuple[tuple[float, ...], float, Array]:
        scene = make(levels[0])
        course = timed(program, scene, value)
        strong = program.run(make(levels[1]), value)
        peaks = tuple(float(np.max(np.abs(x))) for x in (course.x, strong.x))
        return peaks, 1e3 * course.seconds / scene.duration, course.x

    return ask


def of_block(quick: bool) -> tuple[Table, Points]:
    """Measure the boundaries of the block."""
    rocker = rigid_blocks.block(*BLOCK)
    truths, in_plane = (
        [
            boundary(
                lambda level, limit=limit: rigid_blocks.falls(  # type: ignore[misc]
                    rocker, Shaking(level, 1.0, 1.0, 0.5 * math.pi), 5.0, limit
                ),
                *bracket,
            )
            for bracket in BOUNDARIES
        ]
        for limit in (rigid_blocks.FALLEN, PLANE_LIMIT)
    )

    def ask(program: Program, value: float) -> tuple[tuple[float, ...], float, Array]:
        course = timed(program, block_scene(TIMED), value)

        def falls(level: float) -> bool:
            return bool(np.max(np.abs(program.run(block_scene(level), value).x)) > FALLEN)

        asked = BOUNDARIES[:1] if quick else BOUNDARIES
        return tuple(boundary(falls, *bracket) for bracket in asked), 1e3 * course.seconds / 5.0, course.x

    found = list(_each(programs(quick, True, (1e9, 1e10, 1e13), (1e9, 1e10)), ask))  # of 1e13 in space: 0.75 s a second

    def cells_of(one: Found) -> tuple[list[str], float]:
        known = in_plane if one.program.startswith(IN_PLANE) else truths
        off = max(abs(answer / truth - 1.0) for answer, truth in zip(one.answers, known, strict=False))
        finest = _finest(found, one).answers
        own = max(abs(answer / best - 1.0) for answer, best in zip(one.answers, finest, strict=True))
        cells = [f"{answer:.4f}" for answer in one.answers] + [""] * (3 - len(one.answers))
        return [*cells, f"{off:.1e}", _off(own)], off

    rows, errors = _rows(found, 5, cells_of)
    head = ["block 0.4 x 1.6 m, cosine pulse of 1 Hz", "falls from, g", "stands from", "falls from"]
    head += ["largest error", "against its finest", "ms a second"]
    truth = [
        [f"rigid block of Housner{name}", *(f"{value:.4f}" for value in values), "", "", ""]
        for name, values in (("", truths), (f", fallen at {PLANE_LIMIT:g} rad as in the plane", in_plane))
    ]
    return Table("Peers: boundaries of a block", head, [*truth, *rows]), _points(found, errors)


def _history(course: Array, best: Array) -> float:
    return float(np.max(np.abs(course - best)) / np.max(np.abs(best)))


def of_frame(quick: bool) -> tuple[Table, Points]:
    """Measure the rocking frame: history at the lower level, peaks at both."""
    width, height = COLUMN
    rocker = rigid_blocks.frame(width, height, BEAM[0] * BEAM[1] / (2.0 * width * height))
    rows_at: Array = 0.01 * np.arange(401, dtype=np.float64)
    truths = []
    for level in LEVELS:
        theta = rigid_blocks.follow(rocker, Shaking(level, 1.0, 4.0), rows_at)
        truths.append(rigid_blocks.displacement(rocker, theta))

    found = list(_each(programs(quick, False, (), (2e9, 5e10, 5e11)), _peaks_of(frame_scene, LEVELS)))

    def cells_of(one: Found) -> tuple[list[str], float]:
        off, own = _history(one.course, truths[0]), _history(one.course, _finest(found, one).course)
        peak = abs(one.answers[1] / float(np.max(np.abs(truths[1]))) - 1.0)
        return [*(f"{answer:.4f}" for answer in one.answers), f"{off:.1e}", f"{peak:.1e}", _off(own)], off

    rows, errors = _rows(found, 5, cells_of)
    head = ["rocking frame, sine of 1 Hz, 4 s", "peak at 0.3 g, m", "peak at 0.4 g, m", "error of the history, 0.3 g"]
    head += ["error of the peak, 0.4 g", "history against its finest", "ms a second"]
    truth = ["rigid frame of Makris and Vassiliou", *(f"{np.max(np.abs(x)):.4f}" for x in truths), "", "", "", ""]
    return Table("Peers: rocking frame", head, [truth, *rows]), _points(found, errors)


def of_boxes(quick: bool) -> tuple[Table, Points]:
    """Measure three boxes: each program against its own finest."""
    ways = [way for way in programs(quick, False, (), (5e9, 5e11)) if way.knob != "N/m3"]
    tolerances = (1e-2, 1e-3, 1e-4) if quick else (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
    for modulus in (5e9, 5e11):
        run = partial(here, where="whole", stiffness=modulus)
        ways.insert(0, Program(f"here, space, whole faces of {modulus:.0e} N/m3", "tolerance", tolerances, run))
    found = list(_each(ways, _peaks_of(boxes_scene, (0.2, 0.4))))

    def cells_of(one: Found) -> tuple[list[str], float]:
        own = _history(one.course, _finest(found, one).course)
        return [*(f"{answer:.4f}" for answer in one.answers), _off(own)], own

    rows, errors = _rows(found, 3, cells_of)
    head = ["three boxes 1 x 1 x 2 m, sine of 1 Hz, 4 s", "peak at 0.2 g, m", "peak at 0.4 g, m"]
    head += ["history against its finest, 0.2 g", "ms a second"]
    return Table("Peers: three boxes", head, rows), _points(found, errors)


def arch_here(stiffness: float, rim: float = 0.0) -> float:
    """Return the largest push that the arch balances (g)."""
    count, radius, thickness, depth, angle = ARCH
    law = {"stiffness": stiffness, "damping": 1e-3} | ({"rim": rim} if rim else {})
    return push_over(arch(count, radius, thickness, depth, law, angle)).largest_acceleration / G


def arch_truth() -> float:
    """Return the same of a rigid arch that does not slide, by limit analysis (g)."""
    count, radius, thickness, depth, angle = ARCH
    return largest_push(arch(count, radius, thickness, depth, {"stiffness": 1e10, "damping": 1e-3}, angle))


def of_arch(quick: bool) -> Table:
    """Measure the push at which an arch gives way."""
    truth = arch_truth()
    rows = [["limit analysis", f"{truth:.5f}", "", ""]]
    ways: list[tuple[str, float, float]] = [(f"whole faces of {k:.0e} N/m3", k, 0.0) for k in (1e10, 1e11, 1e12, 1e13)]
    ways += [(f"rim of 10 mm, {k:.0e} N/m3", k, 1e-2) for k in (1e12, 1e13)]
    for name, stiffness, rim in ways:
        begin = time.process_time()
        found = arch_here(stiffness, rim)
        spent = time.process_time() - begin
        rows.append([f"here, push-over, {name}", f"{found:.5f}", f"{abs(found / truth - 1.0):.1e}", f"{spent:.3g}"])
    absent = peer_programs.missing()
    steps = (2e-3,) if quick else (2e-3, 1e-3)
    for name, run in (("MuJoCo", by_mujoco), ("LMGC90", by_lmgc90)):
        for step in () if name in absent else steps:
            begin, inside = time.process_time(), 0.0

            def gives(level: float, run: Run = run, step: float = step) -> bool:
                nonlocal inside
                course = run(arch_scene(level), step)
                inside += course.seconds
                return bool(np.max(np.abs(course.x)) > MOVED)

            try:
                found = boundary(gives, 0.33, 0.42, True)
            except RuntimeError as failure:
                rows.append([f"{name}, step {step:g} s", str(failure), "", ""])
                continue
            error = f"{abs(found / truth - 1.0):.1e}"
            rows.append([f"{name}, constant push, step {step:g} s", f"{found:.5f}", error, f"{inside:.3g}"])
    head = ["arch of 7 voussoirs, 157.5 degrees, t/R 0.15", "gives way from, g", "error", "s of the processor in all"]
    return Table("Peers: arch", head, rows)


# --- two boxes that hit each other off their centroids

HIT = (1.0, 1.5, 2.0)  # m
OFFSET, SPEED, STIFF = 0.5, 1.0, 1e8  # m, m/s, N/m3 of the faces


def _kept(mass: float, inertia: Array, begin: Array, after: Array) -> tuple[float, float, float]:
    """Return the changes of momentum, angular momentum and energy, as parts of those of the moving box."""

    def of(state: Array) -> tuple[Array, Array, float]:
        place, velocity, spin = state[:, 0:3], state[:, 3:6], state[:, 6:9]
        linear = mass * np.sum(velocity, axis=0)
        angular = np.sum(mass * np.cross(place, velocity) + inertia * spin, axis=0)
        return linear, angular, 0.5 * float(np.sum(mass * velocity**2) + np.sum(inertia * spin**2))

    first, last = of(begin), of(after)
    size = mass * SPEED
    return (
        float(np.max(np.abs(last[0] - first[0]))) / size,
        float(np.max(np.abs(last[1] - first[1]))) / (size * HIT[0]),
        last[2] / first[2] - 1.0,
    )


def hit_here(tolerance: float) -> tuple[Array, Array, float]:
    """Throw a box at another one without gravity: states (place, velocity, spin) before and after; s."""
    width, depth, height = HIT
    blocks = [
        {"name": f"b{k}", "on": "base", "at": [1.2 * k, OFFSET * k], "width": width, "depth": depth, "height": height}
        | {"density": DENSITY}
        for k in range(2)
    ]
    joints = {"stiffness": 1e9, "damping": 0.0, "friction": 0.5}
    beside = {"reach": 0.5, "stiffness": STIFF, "damping": 0.0, "friction": 0.0}
    data = {"name": "two", "g": 0.0, "joints": joints, "neighbours": beside, "block": blocks}
    made = Structure.from_dict({**data, "solver": {"tolerance": tolerance}})
    none = np.zeros((2, 3))
    moving = none + np.array([[SPEED, 0.0, 0.0], [0.0, 0.0, 0.0]])
    still = Motion.from_samples(0.5, np.zeros(3))
    stepper = begun(made, still, SpatialState(none + np.array([0.0, 0.0, 2.0]), none, moving, none))[0]
    see = stepper.see
    built = np.array([block.centroid for block in made.blocks])

    def state() -> Array:
        places = built + np.stack([see.ux, see.uy, see.uz], axis=1)
        return np.concatenate(
            [places, np.stack([see.vx, see.vy, see.vz], axis=1), np.stack([see.wx, see.wy, see.wz], axis=1)], axis=1
        )

    before = state().copy()
    begin = time.process_time()
    stepper.run(still, 0.0, 0.5, np.zeros(0))
    return before, state().copy(), time.process_time() - begin


def hit_mujoco(step: float) -> tuple[Array, Array, float]:
    """Do the same by MuJoCo, contacts as undamped springs of twenty steps a swing."""
    import mujoco

    width, depth, height = HIT
    mass = DENSITY * width * depth * height
    rate = (2.0 * math.pi / (20.0 * step)) ** 2
    bodies = "".join(
        f'<body pos="{1.2 * k} {OFFSET * k} 5"><freejoint/>'
        f'<geom type="box" size="{0.5 * width} {0.5 * depth} {0.5 * height}" mass="{mass}"/></body>'
        for k in range(2)
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step}" gravity="0 0 0" integrator="implicitfast"/><default>'
        f'<geom friction="0 0 0" condim="1" solref="{-rate} 0" solimp="0.9999 0.9999 0.001"/></default>'
        f"<worldbody>{bodies}</worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    data.qvel[0] = SPEED

    def state() -> Array:
        q, v = data.qpos.reshape(2, 7), data.qvel.reshape(2, 6)
        return np.concatenate([q[:, :3], v], axis=1)

    before = state().copy()
    begin = time.process_time()
    for _ in range(round(0.5 / step)):
        mujoco.mj_step(model, data)
    return before, state().copy(), time.process_time() - begin


def of_hit(quick: bool) -> Table:
    """Measure what an elastic hit keeps."""
    width, depth, height = HIT
    mass = DENSITY * width * depth * height
    inertia = mass / 12.0 * np.array([depth**2 + height**2, width**2 + height**2, width**2 + depth**2])
    ways: list[tuple[str, Callable[[float], tuple[Array, Array, float]], tuple[float, ...]]] = [
        ("here, tolerance", hit_here, (1e-2, 1e-3, 1e-4, 1e-6))
    ]
    if "MuJoCo" not in peer_programs.missing():
        ways.append(("MuJoCo, step, s", hit_mujoco, (1e-3, 5e-4, 1e-4)))
    rows = []
    for name, run, values in ways:
        for value in values:
            run(value)
            before, after, seconds = min((run(value) for _ in range(REPEATS)), key=lambda one: one[2])
            # both spins are along z, which the boxes keep as an axis: body axes give the same angular momentum
            moved, turned, energy = _kept(mass, inertia, before, after)
            cells = [f"{moved:.1e}", f"{turned:.1e}", f"{energy:+.1e}", f"{1e3 * seconds / 0.5:.3g}"]
            rows.append([f"{name} {value:g}", *cells])
    head = ["two boxes, elastic hit 0.5 m off the middle", "momentum", "angular momentum", "energy", "ms a second"]
    return Table("Peers: two boxes that hit each other, changes", head, rows)


def measure(quick: bool, panels: dict[str, Points]) -> Iterator[Table]:
    """Yield all tables, the one with what is left out first; fill the panels of the picture."""
    warnings.simplefilter("ignore", InputWarning)  # damping of nearly rigid joints
    absent = [[name, reason] for name, reason in peer_programs.missing().items()]
    if absent:
        yield Table("Peers: left out", ["program", "reason"], absent)
    for name, task in (
        ("block: boundaries, against the rigid block", of_block),
        ("frame: history at 0.3 g, against the rigid frame", of_frame),
        ("three boxes: history at 0.2 g, against its finest run", of_boxes),
    ):
        table, panels[name] = task(quick)
        yield table
    yield of_arch(quick)
    yield of_hit(quick)
