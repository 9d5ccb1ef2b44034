"""Many runs: `simulate_many` against runs made one by one, in threads, and against OpenSees.

The results are ratios of times measured in turn, the shortest of some rounds: processor time for one thread, clock time
where several work. Every scene has many columns, all different.
"""

from __future__ import annotations

import math
import os
import resource
import subprocess
import sys
import tempfile
import time as clock
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from numba import njit

from solver import Column, Motion, SolverError, simulate_many
from solver.models.column import lanes as batch
from solver.models.protocol import SETTLE, Run
from solver.runs import chunk as runs_module
from solver.studies import Study, run_study
from solver.studies.chunks import make

from . import opensees
from .scenes import RECORDS, ROOT, G, forced, shaft

ROUNDS = 3
CORE_ROUNDS = 5  # of seconds each, compared with which start and end of a study are short
ERROR = 1e-3  # of the peak, the largest allowed for both
TOLERANCES = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4)
TIGHT = 1e-7
DURATION = 20.0  # s
SPREAD = 0.1  # of the logarithm of stiffnesses
ROCKING, RESTING = (0.05, 0.08), (0.002, 0.004)  # g: amplitudes under which Phocas rocks, and under which it does not
FRICTION = 0.12
DRUMS, LEVELS = 6, 20
FILES = (
    "elcentro-1940-ns.AT2",
    "northridge-1994-arleta-360.AT2",
    "kobe-1995-nishi-akashi-090.AT2",
    "cape-mendocino-1992-cpm000.AT2",
    "chi-chi-1999-tcu052-n.AT2",
)
KEEP = ("peak_top_ux",)  # alone and many at once: equal work
FREQUENCIES = 160
FIGURE = (0.25, 10.0)  # Hz
AMPLITUDES = (0.05, 0.1)  # g
ARITHMETIC = 200_000_000  # rounds, half a second
STUDY = ROOT / "examples" / "studies" / "fragility.toml"
MANY, SOME = 1_000_000, 50_000  # runs of the memory test
Runs = tuple[list[Column], list[Motion], float]
Rows = list[dict[str, Any]]


# --- the runs


def varied(column: Column, rng: np.random.Generator) -> Column:
    """Return the column with other stiffnesses."""
    factors = np.exp(SPREAD * rng.standard_normal(column.n)).tolist()
    blocks = tuple(
        replace(block, joint=replace(block.joint, stiffness=block.joint.stiffness * factor))
        for block, factor in zip(column.blocks, factors, strict=True)
    )
    return replace(column, blocks=blocks)


def phocas_runs(count: int, amplitudes: tuple[float, float], duration: float = DURATION) -> Runs:
    """Return damped Phocas under harmonic motions with amplitudes in this range, g."""
    rng = np.random.default_rng(1)
    columns = [varied(shaft(3), rng) for _ in range(count)]
    motions = [Motion.harmonic(rng.uniform(*amplitudes) * G, rng.uniform(1.2, 2.5), duration) for _ in range(count)]
    return columns, motions, duration


def sliding_runs(count: int, amplitudes: tuple[float, float]) -> Runs:
    """Return `phocas_runs` with so little friction that joints slide."""
    columns, motions, duration = phocas_runs(count, amplitudes)
    joints = [[replace(block.joint, friction=FRICTION) for block in column.blocks] for column in columns]
    slippery = [
        replace(
            column, blocks=tuple(replace(block, joint=joint) for block, joint in zip(column.blocks, own, strict=True))
        )
        for column, own in zip(columns, joints, strict=True)
    ]
    return slippery, motions, duration


def drums(levels: int = LEVELS, duration: float = DURATION) -> Runs:
    """Return the shaft of Phocas in six drums under five records, else harmonic motions, at `levels` intensities."""
    column = shaft(DRUMS)
    records = [Motion.from_at2(RECORDS / name) for name in FILES if (RECORDS / name).is_file()]
    records = records or [Motion.harmonic(1.0, frequency, duration) for frequency in (1.0, 1.4, 1.8, 2.4, 3.0)]
    parts = [strongest(record, duration) for record in records]
    motions = [part.scaled_to(pga) for part in parts for pga in np.linspace(0.05, 0.8, levels) * G]
    return [column] * len(motions), motions, min(duration, *(part.duration for part in parts))


def strongest(motion: Motion, duration: float) -> Motion:
    """Return the part of a record of this duration, s, around its largest acceleration; a shorter motion as it is."""
    if motion.duration <= duration:
        return motion
    peak = motion.time[np.argmax(np.abs(motion.ax))]
    begin = min(max(motion.start, peak - 0.5 * duration), motion.end - duration)
    inside = (motion.time >= begin - 1e-9) & (motion.time <= begin + duration + 1e-9)
    time = motion.time[inside]
    return Motion(time - time[0], motion.ax[inside], motion.az[inside], float(time[-1] - time[0]))


def figure_runs(count: int, column: Column, duration: float = DURATION) -> Runs:
    """Return figure 3: a column under harmonic motions of two amplitudes and `count` frequencies."""
    motions = [
        Motion.harmonic(amplitude * G, frequency, duration)
        for amplitude in AMPLITUDES
        for frequency in np.geomspace(*FIGURE, count).tolist()
    ]
    return [column] * len(motions), motions, duration


# --- how they are run


def one_by_one(runs: Runs, tolerance: float | None) -> np.ndarray[Any, Any]:
    """Return the peaks m (runs, n), each run made alone."""
    columns, motions, duration = runs
    peaks = [alone((column, motion, duration, tolerance)) for column, motion in zip(columns, motions, strict=True)]
    return np.array(peaks)


def alone(run: tuple[Column, Motion, float, float | None]) -> Any:
    """Return the peaks of one run as a study makes it alone, NaN where it fails: the outputs that `together` keeps."""
    column, motion, duration, tolerance = run
    if tolerance is not None:
        column = column.with_settings(tolerance=tolerance)
    try:
        return column.kind.alone(Run(column, motion, duration), KEEP, SETTLE, lambda *_: None)[KEEP[0]]
    except SolverError:
        return np.full(column.n, math.nan)


def together(runs: Runs, tolerance: float | None, **options: Any) -> np.ndarray[Any, Any]:
    """Return the peaks by `simulate_many`."""
    columns, motions, duration = runs
    table = simulate_many(columns, motions, duration=duration, tolerance=tolerance, keep=KEEP, **options)
    found: np.ndarray[Any, Any] = table[KEEP[0]]
    return found


def alternating(works: Sequence[Callable[[], object]], timer: Callable[[], float], rounds: int = ROUNDS) -> list[float]:
    """Return the shortest times, s, of some rounds of all."""
    best = [math.inf] * len(works)
    for _ in range(rounds):
        for k, work in enumerate(works):
            begin = timer()
            work()
            best[k] = min(best[k], timer() - begin)
    return best


# --- the measurements


def at_equal_error(name: str, runs: Runs) -> dict[str, Any]:
    """Return the column-seconds a second of one core one by one and by `simulate_many`, each at its loosest good
    tolerance.
    """
    truth = one_by_one(runs, TIGHT)
    chosen: dict[str, tuple[float, float]] = {}
    ways: dict[str, Callable[[Runs, float | None], np.ndarray[Any, Any]]] = {
        "simulate": one_by_one,
        "many": partial(together, threads=1),
    }
    for way, work in ways.items():
        for tolerance in TOLERANCES:
            error = float(np.max(np.abs(work(runs, tolerance) - truth) / truth))
            chosen[way] = tolerance, error
            if error <= ERROR:
                break
    seconds = alternating([partial(work, runs, chosen[way][0]) for way, work in ways.items()], clock.process_time)
    spans = len(runs[0]) * runs[2]
    row: dict[str, Any] = {"scene": name, "runs": len(runs[0]), "duration": runs[2]}
    for way, lasted in zip(ways, seconds, strict=True):
        row[way] = {"tolerance": chosen[way][0], "error": chosen[way][1], "throughput": spans / lasted}
    return row | {"ratio": seconds[0] / seconds[1]}


def beside_opensees(throughput: float) -> dict[str, Any]:
    """Return the ratio of the throughput to that of OpenSees' tuned runs, on damped Phocas in rocking."""
    found = opensees.measure({"damped": forced(0.05, 2.0)})
    if "absent" in found:
        return {"absent": found["absent"]}
    good = [row for row in found["rows"] if row["tuned"] and (row["error"] or math.inf) <= ERROR]
    if not good:
        return {"absent": f"no tuned scheme has an error of {ERROR:g}"}
    best = min(row["seconds"] for row in good)
    return {"throughput": DURATION / best, "ratio": throughput / (DURATION / best)}


@njit(nogil=True)
def arithmetic(count: int) -> float:
    """Return four sums that need no memory and are independent of each other."""
    a, b, c, d = 1.0, 1.1, 1.2, 1.3
    for _ in range(count):
        a, b, c, d = 0.999 * a + 0.1, 0.998 * b + 0.1, 0.997 * c + 0.1, 0.996 * d + 0.1
    return a + b + c + d


def calculate(threads: int) -> None:
    """Do equal arithmetic in each of some threads: the gain the machine allows, beside its other work."""
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(arithmetic, [ARITHMETIC] * threads))


def cores(count: int, rounds: int) -> dict[str, dict[str, float]]:
    """Return the gain of two threads over one by the clock; ratio of the processor times of one thread and of two."""
    phocas, study = phocas_runs(count, ROCKING), Study.from_toml(STUDY).with_runs(count)
    works: dict[str, Callable[[int], object]] = {
        "arithmetic": calculate,
        "Phocas": lambda threads: together(phocas, 1e-2, threads=threads),
        "fragility": lambda threads: run_study(study, threads=threads),
    }
    for work in works.values():
        work(1)  # compiles
    found = {}
    spent = {name: [[math.inf, math.inf], [math.inf, math.inf]] for name in works}
    for _ in range(rounds):
        for name, work in works.items():
            for threads, best in zip((1, 2), spent[name], strict=True):
                begin, own = clock.perf_counter(), clock.process_time()
                work(threads)
                best[0] = min(best[0], clock.perf_counter() - begin)
                best[1] = min(best[1], clock.process_time() - own)
    for name, (one, two) in spent.items():
        more = 2.0 if name == "arithmetic" else 1.0  # two threads do twice the work
        found[name] = {"clock": more * one[0] / two[0], "processor": more * one[1] / two[1]}
    return found


def parts_of_a_run(count: int, rounds: int) -> dict[str, float]:
    """Yield the processor time of a run of the fragility study in one thread, and its part in kernels, ms."""
    study, spent = Study.from_toml(STUDY).with_runs(count), [0.0]

    @contextmanager
    def timed() -> Iterator[None]:
        begin = clock.process_time()
        try:
            yield
        finally:
            spent[0] += clock.process_time() - begin

    best = [math.inf, math.inf]
    with patch.object(batch, "lock_released", timed), patch.object(runs_module, "lock_released", timed):
        for _ in range(rounds):
            spent[0], begin = 0.0, clock.process_time()
            make(study, range(count))
            lasted = clock.process_time() - begin
            best = [min(best[0], spent[0]), min(best[1], lasted - spent[0])]
    kernels, python = (1e3 * seconds / count for seconds in best)
    return {"runs": count, "kernels": kernels, "python": python}


def ida(runs: Runs) -> dict[str, Any]:
    """Return the seconds of the processor of a study by `simulate`, and by `simulate_many` in one thread."""
    seconds = alternating(
        [
            partial(one_by_one, runs, None),
            partial(together, runs, None, threads=1),
            partial(one_by_one, runs, ERROR),
            partial(together, runs, ERROR, threads=1),
        ],
        clock.process_time,
    )
    names = ("simulate", "many", "simulate_loose", "many_loose")
    return {"runs": len(runs[0]), **dict(zip(names, seconds, strict=True))}


def figure(count: int) -> dict[str, Any]:
    """Return the seconds of the clock of Figure 3 by the exact model, and of a run by the paper's scheme."""
    exact = figure_runs(count, shaft(3))
    undamped = Column.from_toml(ROOT / "examples" / "columns" / "phocas.toml")
    together(figure_runs(2, undamped, 0.1), None, threads=1)  # compiles
    paper = figure_runs(max(2, count // 20), undamped)
    lasted = alternating([partial(together, exact, ERROR)], clock.perf_counter, 1)[0]
    before, now = alternating(
        [partial(one_by_one, paper, None), partial(together, paper, None, threads=1)], clock.process_time, 1
    )
    return {"runs": len(exact[0]), "seconds": lasted, "paper_runs": len(paper[0]), "paper": before, "paper_many": now}


def memory(count: int, compiling: bool) -> dict[str, Any]:
    """Return the peak memory, MB, of a process that makes `count` runs with kernels compiled before.

    With `compiling` also that of a process that compiles them for a few runs, as a user's first one does.
    """
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | ({"MULTIBLOCK_CACHE_DIR": cache} if compiling else {})
        first, later = (_filled(runs, environment) for runs in (8, count))
    return {"runs": count, "megabytes": later} | ({"compiling": first} if compiling else {})


def _filled(count: int, environment: Mapping[str, str]) -> float:
    command = [sys.executable, "-m", "benchmarks.studies", str(count)]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout.split()[-1])


def fill_memory(count: int) -> float:
    """Make `count` short runs; return the peak memory of this process, MB."""
    rng = np.random.default_rng(1)
    column = shaft(3)
    motion = Motion.harmonic(0.02 * G, 2.0, 0.02)
    table = simulate_many(column, (motion.scaled(rng.uniform(0.5, 1.5)) for _ in range(count)), tolerance=1e-3)
    assert len(table) == count
    return most_memory()


def most_memory() -> float:
    """Return the peak memory of this process, MB."""
    status = Path("/proc/self/status")
    if status.is_file():  # getrusage includes the process that started this one, if that had more
        line = next(line for line in status.read_text(encoding="ascii").splitlines() if line.startswith("VmHWM"))
        return float(line.split()[1]) / 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def measure(quick: bool) -> Iterator[dict[str, Any]]:
    """Make all measurements, each time one is added."""
    found: dict[str, Any] = {}
    count = 16 if quick else 64
    together(phocas_runs(16, ROCKING, 0.5), 1e-2, threads=1)  # compiles
    found["throughput"] = [at_equal_error("Phocas rocking", phocas_runs(count, ROCKING))]
    yield found
    found["throughput"].append(at_equal_error("Phocas, all joints in contact", phocas_runs(count, RESTING)))
    yield found
    found["throughput"].append(at_equal_error("Phocas rocking and sliding", sliding_runs(count, ROCKING)))
    yield found
    found["opensees"] = beside_opensees(found["throughput"][0]["many"]["throughput"])
    yield found
    found["cores"] = cores(200, ROUNDS) if quick else cores(8192, CORE_ROUNDS)
    yield found
    found["run"] = parts_of_a_run(320 if quick else 2000, ROUNDS)
    yield found
    found["ida"] = ida(drums(4 if quick else LEVELS))
    yield found
    found["figure"] = figure(20 if quick else FREQUENCIES)
    yield found
    found["memory"] = memory(SOME if quick else MANY, compiling=not quick)
    yield found


if __name__ == "__main__":
    print(fill_memory(int(sys.argv[1])))
