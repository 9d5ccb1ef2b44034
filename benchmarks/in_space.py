"""Structures in space: accuracy against closed forms, errors in tolerances, cost of joints, blocks, runs, compilation.

Each measurement yields its table: a title, a head and rows of text.
"""

from __future__ import annotations

import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from multiblock import Motion, Structure, arch, colonnade, simulate
from solver.models.protocol import SETTLE, Run
from solver.models.structure.kind import STRUCTURES
from solver.models.structure.response import SpatialResponse
from solver.models.structure.rest import rest_of
from solver.models.structure.run import SpatialState, set_initial
from solver.models.structure.stepper import SpatialStepper
from solver.runs.chunk import Chunk, make_runs
from solver.studies import Study

from . import timing
from .right_hand_side import Array
from .scenes import DAMPING, HEIGHT, MASS, ROOT, SIDE, STIFFNESS, G, forced, shaft

STATUE = ROOT / "examples" / "structures" / "statue_mesh.py"
PLANAR_TOP = 30.21249  # mm, of the planar column (docs/accuracy.md), rigid in shear
SHEAR_RATIOS = (4.0, 40.0)
NEWMARK = 24.8998  # mm, a rigid block under half a sine
TOLERANCES = tuple(10.0**-k for k in range(3, 10))
QUICK_TOLERANCES = TOLERANCES[:3]
REFERENCES = (1e-10, 1e-11)
REFERENCE_MARGIN = 10.0  # a tolerance is judged if it is this many times the difference of the references
CHANGE, MOST_AMPLIFIED = 1e-6, 100.0  # of the motion; of what that does to the peak
KINDS = {"N": ("N",), "M": ("Mx", "My"), "T": ("Tx", "Ty"), "pressure": ("sigma_max",)}  # of forces
FORCES_KNOWN, FORCES_ASKED = 1e-9, (1e-3, 1e-4, 1e-5, 1e-6)
SIZES = (10, 30, 100, 300)  # blocks
EQUAL_ERROR = 1e-3  # of the peak
RUNS, CALLS = 25, 20  # of which the shortest counts; in each
FRICTION = 0.2  # so little that joints slide
SPAN = 2.0  # s, of the random structures
MANY, MANY_ROUNDS = 48, 4  # runs of a study; rounds, of which the shortest counts
STUDIED = 1e-4  # tolerance of studies
THROWN, THROWS, ENERGY_TOLERANCES = 1.0, 8, (1e-3, 1e-5, 1e-7, 1e-9)  # s; of the undamped blocks
COMPILED = (
    "from multiblock import Column, Motion, simulate; c = Column.from_toml({file!r}){space}; "
    "simulate(c, Motion.harmonic(0.1, 1.0, 0.1), settle=0.0)"
)


@dataclass(frozen=True)
class Table:
    """A table of the report."""

    title: str
    head: list[str]
    rows: list[list[str]]


def boxes(n: int = 3, section: str = "rectangle", ratio: float = 0.4, height: float = HEIGHT) -> Structure:
    """Return a shaft of the size of the Column of Phocas in n blocks, the lowest first; `section` as of a column."""
    shape: dict[str, Any] = {"shape": "drum", "diameter": SIDE} if section == "circle" else {"width": SIDE}
    shape |= {} if section == "circle" else {"depth": SIDE}
    size = {"height": height / n, "mass": MASS / n} | shape
    blocks = [{"name": f"b{k}", "on": f"b{k - 1}" if k else "base", **size} for k in range(n)]
    law = {"stiffness": STIFFNESS, "damping": DAMPING, "shear_ratio": ratio}
    return Structure.from_dict({"name": f"{section} in {n}", "joints": law, "block": blocks})


def run(structure: Structure, motion: Motion, **more: Any) -> SpatialResponse:
    """Return a run from rest that is not followed after its end."""
    response: SpatialResponse = simulate(structure, motion, settle=0.0, **more)
    return response


def accuracy() -> Table:
    """Compare with the planar column, a sliding block, and the same column shaken along another direction."""
    rows = []
    for ratio in SHEAR_RATIOS:
        found = run(boxes(ratio=ratio), Motion.harmonic(0.05 * G, 2.0, 20.0), tolerance=1e-5)
        top = 1e3 * float(np.max(np.abs(found.displacement(2, (0.0, 0.0, 0.5 * HEIGHT / 3))[:, 0])))
        rows.append([f"Phocas, 0.05 g 2 Hz, shear_ratio {ratio:g}, top, mm", f"{PLANAR_TOP:.4f}", f"{top:.4f}"])
    block = {"name": "b", "width": 4.0, "depth": 4.0, "height": 0.2, "mass": 1000.0, "on": "base"}
    law = {"stiffness": 1e10, "damping": DAMPING, "friction": 0.3}
    slab = Structure.from_dict({"name": "slab", "joints": law, "block": [block]})
    for angle in (0.0, math.radians(36.0)):
        motion = Motion.harmonic(0.5 * G, 2.0, 0.25, direction=angle)
        found = run(slab, motion, duration=1.0, tolerance=1e-6)
        far = 1e3 * float(np.hypot(found.ux[-1, 0], found.uy[-1, 0]))
        name = f"sliding block, half a sine of 0.5 g 2 Hz at {math.degrees(angle):.0f} degrees, mm"
        rows.append([name, f"{NEWMARK}", f"{far:.4f}"])
    first, second = (
        run(boxes(section="circle"), Motion.harmonic(0.08 * G, 1.5, 2.0, direction=angle), tolerance=1e-8)
        for angle in (0.0, math.radians(30.0))
    )
    turned = math.cos(math.radians(30.0)) * second.ux + math.sin(math.radians(30.0)) * second.uy
    off = float(np.max(np.abs(turned - first.ux)) / np.max(np.abs(first.ux)))
    rows.append(["round column along 30 degrees, part of the peak", "the same along x", f"{off:.1e} off"])
    return Table("Structures in space: against what is known", ["", "known", "here"], rows)


def random_structures(seed: int = 1) -> Iterator[tuple[Structure, Motion]]:
    """Yield stacks, triliths, arches, with and without friction, under harmonic motions in any direction."""
    rng = np.random.default_rng(seed)
    for kind in ("rectangle", "circle", "trilith", "arch"):
        for friction in (None, FRICTION):
            law: dict[str, Any] = {"stiffness": 10 ** rng.uniform(9.0, 9.7), "damping": DAMPING}
            law |= {} if friction is None else {"friction": friction}
            if kind == "trilith":
                made = colonnade(2, 2, 3.0, rng.uniform(0.8, 1.1), 4.0, law, architrave=(0.7, 0.9))
            elif kind == "arch":
                made = arch(7, 5.0, rng.uniform(0.9, 1.2), 1.0, law, angle=2.5)
            else:
                made = boxes(int(rng.integers(2, 5)), kind, height=rng.uniform(8.0, 12.0))
                made = replace(
                    made,
                    joints=tuple(replace(j, bed=replace(j.bed, friction=friction)) for j in made.joints),
                )
            words = "without friction" if friction is None else "with friction"
            motion = Motion.harmonic(
                rng.uniform(0.1, 0.25) * G, rng.uniform(1.0, 2.0), SPAN, direction=rng.uniform(0.1, 1.4)
            )
            yield replace(made, name=f"{kind} {words}"), motion


def _places(response: SpatialResponse) -> Array:
    return np.stack([response.ux, response.uy, response.uz])


def tolerances(
    quick: bool,
    scenes: Iterable[tuple[Structure, Motion]] | None = None,
    title: str = "Structures in space: error over tolerance",
) -> Table:
    """Return the largest error of all blocks and instants in tolerances of the largest displacement; None: random
    structures.
    """
    asked = QUICK_TOLERANCES if quick else TOLERANCES
    rows = []
    for structure, motion in random_structures() if scenes is None else scenes:
        closest = run(structure, motion, tolerance=REFERENCES[1])
        near, best = _places(run(structure, motion, tolerance=REFERENCES[0])), _places(closest)
        peak = float(np.max(np.abs(best)))
        differ = float(np.max(np.abs(near - best))) / peak
        changed = _places(run(structure, motion.scaled(1.0 + CHANGE), tolerance=REFERENCES[0]))
        amplified = float(np.max(np.abs(changed - near))) / (CHANGE * peak)
        cells = []
        for value in asked:
            off = float(np.max(np.abs(_places(run(structure, motion, tolerance=value)) - best))) / peak
            cells.append(f"{off / value:.2g}" if value >= REFERENCE_MARGIN * differ else "-")
        judged = cells if amplified < MOST_AMPLIFIED else ["-"] * len(cells)
        facts = [f"{1e3 * peak:.3g}", f"{1e3 * float(np.max(closest.slip)):.3g}", f"{differ:.0e}", f"{amplified:.3g}"]
        rows.append([structure.name, *facts, *judged])
    head = ["structure", "peak, mm", "slip, mm", "references differ by", "amplification"]
    head += [*(f"{value:.0e}" for value in asked)]
    return Table(title, head, rows)


def _rocking() -> Iterator[tuple[Structure, Motion]]:
    """Yield structures whose forces are looked at, and motions under which they rock; two small ones."""
    doric, trilith, arched, podium = (
        Structure.from_toml(ROOT / "examples" / "structures" / f"{name}.toml")
        for name in ("doric-in-space", "trilith", "arch", "podium")
    )
    yield boxes(), Motion.harmonic(0.05 * G, 2.0, 5.0)
    yield boxes(), Motion.harmonic(0.1 * G, 1.0, 3.0, direction=0.3)
    yield boxes(section="circle"), Motion.harmonic(0.08 * G, 1.5, 2.0, direction=0.3)
    yield doric, Motion.harmonic(0.15 * G, 1.0, 2.0, direction=0.3)
    yield trilith, Motion.harmonic(0.22 * G, 1.4, 3.0, direction=0.4)
    yield arched, Motion.harmonic(0.25 * G, 1.5, 2.0, direction=0.4)
    yield podium, Motion.harmonic(0.2 * G, 1.0, 2.0, direction=0.4)
    yield from random_structures()
    yield boxes(), Motion.harmonic(0.008 * G, 2.0, 3.0, direction=0.3)
    yield trilith, Motion.harmonic(0.01 * G, 2.0, 2.0, direction=0.3)


def forces(quick: bool) -> Table:
    """Measure errors of forces in rows and in peaks, in tolerances of the largest of their kind, and evaluations."""
    rows = []
    for structure, motion in _rocking():
        closest = run(structure, motion, tolerance=FORCES_KNOWN)
        for value in FORCES_ASKED[: 1 if quick else None]:
            found = run(structure, motion, tolerance=value)
            cells = []
            for names in KINDS.values():
                size = value * max(float(np.max(closest.peaks[name])) for name in names)
                off = max(float(np.max(np.abs(getattr(found, name) - getattr(closest, name)))) for name in names)
                missed = max(float(np.max(np.abs(found.peaks[name] - closest.peaks[name]))) for name in names)
                cells.append(f"{off / size:.2g}, {missed / size:.2g}")
            rows.append([structure.name, f"{value:g}", *cells, f"{found.stats['evaluations']}"])
    head = ["rows, peaks", "tolerance", *KINDS, "evaluations"]
    return Table("Structures in space: errors of forces over tolerance", head, rows)


def _costs(structures: Sequence[Structure], motion: Motion) -> list[float]:
    """Return the processor time, s, of a joint with its bodies for an evaluation, with its share of the steps; the
    least of runs.

    Without rows, with peaks. Rounds differ in what else the machine does, not in what is done; in each all structures
    have their turn.
    """
    rests = [rest_of(structure) for structure in structures]
    least = [math.inf] * len(structures)
    for _ in range(RUNS):
        for k, (structure, rest) in enumerate(zip(structures, rests, strict=True)):
            stepper = SpatialStepper(structure)
            stepper.phase[:] = rest.phase
            begin = time.process_time()
            stepper.run(motion, 0.0, motion.duration, np.zeros(0))
            spent = time.process_time() - begin
            least[k] = min(least[k], spent / (int(stepper.counts.evaluations) * len(structure.joints)))
    return least


def _alone(structure: Structure) -> float:
    """Return the processor time, s, of a joint with its bodies in an evaluation at rest, called from Python; the least
    of runs.
    """
    stepper, least = SpatialStepper(structure), math.inf
    stepper.phase[:] = rest_of(structure).phase
    for _ in range(RUNS):
        begin = time.process_time()
        for _ in range(CALLS):
            stepper.observe()
        least = min(least, (time.process_time() - begin) / (CALLS * len(structure.joints)))
    return least


def costs() -> Table:
    """Measure the costs of a joint, by section, and of a block, by their number."""
    rows = []
    for section, asked in (("rectangle", 250), ("circle", 350)):
        for angle in (0.0, 0.3):
            (cost,) = _costs([boxes(section=section)], Motion.harmonic(0.1 * G, 1.0, 5.0, direction=angle))
            rows.append([f"Phocas, {section}, 0.1 g 1 Hz at {angle:g} rad", f"{1e9 * cost:.0f}", f"{asked}"])
    first = 0.0
    for n in SIZES:
        # squat drums, as of scaling.py: the highest frequency hardly depends on their number
        size = {"width": 4.0, "depth": 4.0, "height": 0.25, "mass": 8000.0}
        blocks = [{"name": f"b{k}", "on": f"b{k - 1}" if k else "base", **size} for k in range(n)]
        law = {"stiffness": STIFFNESS, "damping": 1e-4}
        tower = Structure.from_dict({"name": f"tower_{n}", "joints": law, "block": blocks})
        (cost,) = _costs([tower], Motion.harmonic(0.05 * G, 2.0, 0.05, direction=0.3))
        first = first or cost
        rows.append(
            [f"tower of {n} squat blocks", f"{1e9 * cost:.0f}", f"{cost / first:.2f}; {1e9 * _alone(tower):.0f} alone"]
        )
    return Table(
        "Structures in space: cost of a joint and its bodies",
        ["", "ns per evaluation", "asked; towers: over the first, ns of an evaluation alone"],
        rows,
    )


def meshes() -> Table:
    """Compare a statue from a mesh with a box of its weight and height on the same plinth, in turns."""
    sys.path.insert(0, str(STATUE.parent))
    try:
        write = import_module(STATUE.stem).write
    finally:
        sys.path.remove(str(STATUE.parent))
    law = {"stiffness": STIFFNESS, "damping": DAMPING, "friction": 0.7}

    def standing(block: dict[str, Any]) -> Structure:
        return Structure.from_dict({"name": "one", "joints": law, "block": [{"name": "b", "on": "base"} | block]})

    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder) / "statue.obj", sides=40, rings=64)
        statue = standing({"shape": "mesh", "file": f"{folder}/statue.obj", "density": 2700.0})
    mass, triangles = statue.blocks[0].mass, len(statue.blocks[0].surface)
    box = standing({"width": 0.56, "depth": 0.48, "height": 1.9, "mass": mass})
    rows, first = [], 0.0
    motion = Motion.harmonic(0.3 * G, 2.0, 3.0, direction=0.3)
    for name, cost in zip(("box", f"statue of {triangles} triangles"), _costs([box, statue], motion), strict=True):
        first = first or cost
        rows.append([f"{name}, 0.3 g 2 Hz at 0.3 rad", f"{1e9 * cost:.0f}", f"{cost / first:.2f}"])
    head = ["", "ns per evaluation", "over the box (1 asked)"]
    return Table("Structures in space: cost of a mesh", head, rows)


def loosest(way: Callable[..., Any]) -> tuple[float, float]:
    """Return the loosest tolerance at which ux of a run is within `EQUAL_ERROR` of the peak, and its error."""
    best = way(tolerance=1e-9).ux
    peak = float(np.max(np.abs(best)))
    for value in (3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5):
        off = float(np.max(np.abs(way(tolerance=value).ux - best))) / peak
        if off <= EQUAL_ERROR:
            return value, off
    return 1e-9, 0.0


def against_plane() -> Table:
    """Compare 20 s of the damped column in space with the planar run, each at the loosest tolerance that meets an
    error.

    The error is that against the same model at 1e-9.
    """
    scene = forced(0.05, 2.0)
    ways: dict[str, Callable[..., Any]] = {
        "in the plane": partial(simulate, shaft(3), scene.motion, settle=0.0),
        **{
            f"in space, shear_ratio {ratio:g}": partial(simulate, boxes(ratio=ratio), scene.motion, settle=0.0)
            for ratio in (0.4, 4.0)
        },
    }
    met = {name: loosest(way) for name, way in ways.items()}
    seconds = timing.loops([partial(way, tolerance=met[name][0]) for name, way in ways.items()], rounds=5)
    rows = [
        [name, f"{met[name][0]:g}", f"{met[name][1]:.1e}", f"{1e3 * lasts:.3g}", f"{lasts / seconds[0]:.2f}"]
        for name, lasts in zip(ways, seconds, strict=True)
    ]
    head = ["Phocas, 0.05 g 2 Hz, 20 s", "tolerance", "error", "ms", "ratio (8 asked)"]
    return Table("Structures in space: against the plane at equal error", head, rows)


def _modal_scenes() -> Iterator[tuple[str, Structure, Motion]]:
    """Yield scenes that stay in contact, then scenes that rock."""
    doric = Structure.from_toml(ROOT / "examples" / "structures" / "doric-in-space.toml")
    trilith = Structure.from_toml(ROOT / "examples" / "structures" / "trilith.toml")
    for word, ratio in (("Phocas", 0.4), ("Phocas, shear_ratio 4", 4.0)):
        yield f"{word}, 0.008 g 2 Hz", boxes(ratio=ratio), Motion.harmonic(0.008 * G, 2.0, 5.0)
    yield "doric, 0.01 g 2 Hz at 0.3 rad", doric, Motion.harmonic(0.01 * G, 2.0, 5.0, direction=0.3)
    yield "trilith, 0.01 g 2 Hz at 0.3 rad", trilith, Motion.harmonic(0.01 * G, 2.0, 5.0, direction=0.3)
    for word, ratio in (("Phocas", 0.4), ("Phocas, shear_ratio 4", 4.0)):
        yield f"{word}, rocks, 0.05 g 2 Hz", boxes(ratio=ratio), Motion.harmonic(0.05 * G, 2.0, 5.0)
    yield "doric, rocks, 0.15 g 1 Hz at 0.3 rad", doric, Motion.harmonic(0.15 * G, 1.0, 5.0, direction=0.3)
    yield "trilith, rocks, 0.22 g 1.4 Hz at 0.4 rad", trilith, Motion.harmonic(0.22 * G, 1.4, 4.0, direction=0.4)


def by_modes() -> Table:
    """Compare runs with and without steps by modes, in one process; rounds alternate."""
    rows = []
    for name, structure, motion in _modal_scenes():
        for value in (1e-3, 1e-5, 1e-7):
            ways = [
                partial(run, structure.with_settings(tolerance=value, without=without), motion)
                for without in (("elastic",), ())
            ]
            general, found = (way().stats for way in ways)
            slow, fast = timing.loops(ways, rounds=5)
            made = [f"{stats['evaluations'] + stats['looks']}" for stats in (general, found)]
            share = f"{found['elastic_steps']} of {found['steps']}"
            rows.append(
                [name, f"{value:g}", *made, share, *(f"{1e3 * s:.3g}" for s in (slow, fast, 1e-3 * slow / fast))]
            )
    head = ["", "tolerance", "evaluations without", "with modes", "steps by modes", "ms without", "with", "gain"]
    return Table("Structures in space: steps by modes", head, rows)


def compilation() -> Table:
    """Measure the processor time of a first run with an empty cache and of a second process with the kernels that it
    left.
    """
    rows = []
    file = str(ROOT / "examples" / "columns" / "phocas-damped.toml")
    for name, space in (("in the plane", ""), ("in space", ".in_space()")):
        with tempfile.TemporaryDirectory() as cache:
            inside = os.environ | {"MULTIBLOCK_CACHE_DIR": cache}
            lasted = []
            for _ in range(2):
                before = resource.getrusage(resource.RUSAGE_CHILDREN)
                subprocess.run([sys.executable, "-c", COMPILED.format(file=file, space=space)], check=True, env=inside)
                after = resource.getrusage(resource.RUSAGE_CHILDREN)
                lasted.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        rows.append([name, *(f"{seconds:.1f}" for seconds in lasted)])
    return Table("Structures in space: first run, s of the processor", ["", "empty cache", "second process"], rows)


def energies(quick: bool) -> Table:
    """Change of the energy above rest within `THROWN` s, undamped, in tolerances; medians of throws at random."""
    structure = boxes().scaled_joints([1.0] * 3, [0.0] * 3)
    rest, rng = rest_of(structure), np.random.default_rng(1)
    throws = [
        SpatialState(*(size * rng.standard_normal((3, 3)) for size in (0.0, 0.0, 0.3, 0.1)))
        for _ in range(2 if quick else THROWS)
    ]

    def drift(throw: SpatialState, tolerance: float) -> float:
        stepper = SpatialStepper(structure.with_settings(tolerance=tolerance))
        stepper.phase[:] = rest.phase
        still = stepper.observe()
        set_initial(stepper, throw)
        first = stepper.observe() - still
        stepper.run(None, 0.0, THROWN, np.zeros(0))
        return abs(stepper.observe() - still - first) / first / tolerance

    cells = [f"{float(np.median([drift(throw, value) for throw in throws])):.2g}" for value in ENERGY_TOLERANCES]
    head = ["three blocks thrown at random, undamped", *(f"{value:.0e}" for value in ENERGY_TOLERANCES), "asked"]
    rows = [[f"change of energy over tolerance, {THROWN:g} s, median of {len(throws)}", *cells, "0.01"]]
    return Table("Structures in space: energy", head, rows)


KEEP = ("peak_u", "verdict")  # of runs in lanes and alone


def studied() -> Iterator[tuple[str, list[Run], float]]:
    """Yield runs of studies: what they are, the runs, s that they are followed after their end."""
    law: dict[str, Any] = {"stiffness": 2e9, "damping": DAMPING}
    waves = [Motion.harmonic((0.1 + 0.002 * k) * G, 1.0 + 0.01 * k, 5.0, direction=0.3) for k in range(MANY)]
    for name, structure in (
        ("trilith of 7 boxes", colonnade(2, 3, 3.0, 0.9, 4.0, law, architrave=(0.7, 0.9))),
        ("the same, friction 0.5", colonnade(2, 3, 3.0, 0.9, 4.0, law | {"friction": 0.5}, architrave=(0.7, 0.9))),
        ("three drums", boxes(section="circle")),
        ("arch of 9 voussoirs", arch(9, 5.0, 1.0, 1.0, law, angle=2.7)),
    ):
        structure = structure.with_settings(tolerance=STUDIED)
        yield f"{name}, 5 s", [Run(structure, motion, motion.duration) for motion in waves], 0.0
    study = Study.from_toml(ROOT / "examples" / "studies" / "trilith.toml")
    planned = [study.run(k).run for k in range(study.runs)]
    yield "the study of the examples, each with a rest of its own and followed to its verdict", planned, SETTLE


def lanes() -> Table:
    """Compare runs of studies eight at once over runs one by one, in one thread, and two threads over one."""
    rows = []
    for name, runs, settle in studied():

        def made(lanes: bool, runs: list[Run] = runs, settle: float = settle) -> None:
            if lanes:
                make_runs(Chunk(0, runs, KEEP, settle))
            else:
                [STRUCTURES.alone(run, KEEP, settle, lambda *_: None) for run in runs]

        def both(runs: list[Run] = runs, settle: float = settle) -> None:
            with ThreadPoolExecutor(2) as pool:
                halves = runs[::2], runs[1::2]
                list(pool.map(lambda half: make_runs(Chunk(0, half, KEEP, settle)), halves))

        alone, together, twice = timing.loops([partial(made, False), partial(made, True), both], rounds=MANY_ROUNDS)
        per = 1e3 / len(runs)
        rows.append(
            [
                f"{len(runs)} runs: {name}",
                f"{per * alone:.3g}",
                f"{per * together:.3g}",
                f"{alone / together:.2f}",
                f"{together / twice:.2f}",
            ]
        )
    head = ["", "ms a run, one by one", "eight at once", "gain of a core (4 asked)", "gain of two threads"]
    return Table("Structures in space: studies", head, rows)


def measure(quick: bool) -> Iterator[Table]:
    """Measure all tables, the quick ones first."""
    yield accuracy()
    yield costs()
    yield meshes()
    yield lanes()
    yield energies(quick)
    yield against_plane()
    yield by_modes()
    yield tolerances(quick)
    yield forces(quick)
    if not quick:
        yield compilation()
