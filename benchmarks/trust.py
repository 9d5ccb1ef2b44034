"""Trust in a run, and the cost of its checks: peaks against rows, shares that fall, pulses, checks.

A share is that of an ensemble; its true value is estimated by many more runs with another seed.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from solver import Column, Motion, Response, simulate
from solver.models.uncertainty import Spread
from solver.runs.trust import with_fine_settings

from .scenes import FORCED, RECORDED, RECORDS, G, Scene, forced, recorded, shaft
from .timing import loops

FINE, COARSE = 1e-4, 5e-3  # s, between rows
EDGE_HALVINGS = 12
AROUND = (0.97, 0.99, 1.0, 1.01, 1.03)  # times the scale of the motion at which the column begins to fall
SIZES, MANY = (8, 64), 1000
QUICK_MANY = 64
SEED, OTHER_SEED = 0, 1
TOLERANCE = 1e-4
ENSEMBLE = 8
ENOUGH = 0.05  # s that a round of runs lasts, at least


def peaks(scene: Scene) -> dict[str, Any]:
    """Return True if the peaks depend on the rows, and what part of them rows of 5 ms show."""
    fine, coarse = (
        simulate(scene.column, scene.motion, scene.duration, settle=0.0, output_step=step) for step in (FINE, COARSE)
    )
    seen = {
        name: float(np.min(np.max(np.abs(getattr(coarse, name)), axis=0) / coarse.peaks[name]))
        for name in ("N", "S", "Tx")
    }
    return {
        "scene": scene.title,
        "same": all(np.array_equal(peak, coarse.peaks[name]) for name, peak in fine.peaks.items()),
        "seen": seen,
        "looks": coarse.stats["looks"] / coarse.stats["evaluations"],
    }


def costs(scene: Scene) -> dict[str, Any]:
    """Return the cost of a check and of an ensemble of eight relative to the run: evaluations of the check, time of
    both.
    """

    def run(**more: Any) -> Response:
        return simulate(scene.column, scene.motion, scene.duration, settle=0.0, **more)

    closer = simulate(with_fine_settings(scene.column), scene.motion, scene.duration, settle=0.0)
    ways = (run, lambda: run(check=True), lambda: run(ensemble=ENSEMBLE))
    once, checked, varied = loops(ways, enough=ENOUGH)
    evaluations = [count.stats["evaluations"] + count.stats["looks"] for count in (run(), closer)]
    return {
        "scene": scene.title,
        "seconds": once,
        "evaluations": evaluations[1] / evaluations[0],
        "check": (checked - once) / once,
        "ensemble": (varied - once) / once,
    }


def motions() -> Iterator[tuple[str, Motion]]:
    """Yield a harmonic motion, and a record where there is one."""
    yield "0.1 g 0.5 Hz", Motion.harmonic(0.1 * G, 0.5, 10.0)
    label, file, duration = RECORDED[0]
    if (RECORDS / Path(file)).is_file():
        yield f"{label}, {duration:g} s", Motion.from_at2(RECORDS / file)


def edge(column: Column, motion: Motion) -> float:
    """Return a scale of the motion near which the column begins to fall; it may stand at some above and fall at some
    below.
    """
    low, high = 0.1, 0.2
    while simulate(column, motion.scaled(high), tolerance=TOLERANCE).verdict != "overturned":
        low, high = high, 1.5 * high
    for _ in range(EDGE_HALVINGS):
        middle = 0.5 * (low + high)
        falls = simulate(column, motion.scaled(middle), tolerance=TOLERANCE).verdict == "overturned"
        low, high = (low, middle) if falls else (middle, high)
    return high


def shares(
    column: Column, label: str, motion: Motion, sizes: tuple[int, ...] = SIZES, many: int = MANY
) -> Iterator[dict[str, Any]]:
    """Yield shares that fall at scales around the edge: of ensembles, with bounds, and of many runs."""
    begins = edge(column, motion)
    for part in AROUND:
        scaled = motion.scaled(part * begins)
        found = [
            simulate(column, scaled, tolerance=TOLERANCE, ensemble=size, spread=Spread(seed=seed)).ensemble
            for size, seed in (*((size, SEED) for size in sizes), (many, OTHER_SEED))
        ]
        ensembles = [item for item in found if item is not None]
        true = ensembles[-1].share
        rows = [{"size": item.size, "share": item.share, "bounds": item.share_bounds} for item in ensembles]
        for row, item in zip(rows, ensembles, strict=True):
            low, high = item.share_bounds
            row["contains"] = low <= true <= high
        yield {"scene": f"{label} x {part * begins:.4g}", "rows": rows}


def pulses(column: Column, label: str, frequency: float, amplitudes: np.ndarray) -> dict[str, Any]:
    """Return the counts of outcomes of half sines of these amplitudes, m/s2: falls during the pulse, later, never,
    undecided.
    """
    length = 0.5 / frequency
    counts: Counter[str] = Counter()
    for amplitude in amplitudes:
        motion = Motion.from_samples(length / 200, amplitude * np.sin(math.pi * np.linspace(0.0, 1.0, 201)))
        run = simulate(column, motion, tolerance=TOLERANCE)
        later = run.verdict == "overturned" and run.overturn_time > length
        counts["overturned later" if later else run.verdict] += 1
    return {"scene": f"{label}, half sines of {frequency:g} Hz", "counts": dict(counts)}


def measure(quick: bool) -> Iterator[dict[str, Any]]:
    """Make all measurements, each time one is added."""
    found: dict[str, Any] = {"costs": [], "peaks": [], "pulses": [], "shares": []}
    duration = 2.0 if quick else 10.0
    rocking = [forced(g, frequency, 2.0 * duration) for g, frequency in FORCED[1:]]
    for scene in (*rocking, *(() if quick else recorded()[0][:1])):
        found["costs"].append(costs(scene))
        yield found
    for scene in (forced(0.15, 1.0, duration), forced(0.1, 1.0, 2.0, damping=0.0), forced(0.02, 2.0, duration)):
        found["peaks"].append(peaks(scene))
        yield found
    count = 8 if quick else 40
    for n, frequency, most in ((1, 0.5, 0.5), (3, 1.0, 1.0)):
        amplitudes = np.linspace(0.1, most, count) * G
        found["pulses"].append(pulses(shaft(n), "1 block" if n == 1 else f"{n} blocks", frequency, amplitudes))
        yield found
    for label, motion in motions():
        for row in shares(shaft(3), label, motion, SIZES[:1] if quick else SIZES, QUICK_MANY if quick else MANY):
            found["shares"].append(row)
            yield found
        if quick:
            return
