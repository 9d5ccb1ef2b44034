"""The 490 tests of two rocks again: each rock in space, on the foot that its scan shows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from multiblock import Motion
from solver.common.errors import SolverError
from solver.common.executors import cores
from solver.models.protocol import NoRestError, Run

from .. import scores
from ..case import Case, Outcome
from ..footprint import Rock, rock_from
from ..rigid_block import FloatArray
from ..rims import WHOLE, label_of
from ..rocks import SAMPLE, Tests, read, scan_of
from .shaken_rocks import SPLITS, Judged, draw, ensembles, judge, judge_lognormal

MASS, FRICTION = 353.8, 0.7  # kg
LEVEL = 3e-3  # m, above the lowest point: what lies within it bears
STIFFNESS, DAMPING = 1e9, 3e-3  # N/m3, s
DIRECTIONS = tuple(range(0, 360, 30))  # degrees, of the table along x of the scan: not published
SCALES = np.array([0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.12, 1.25])  # of the foot
MEDIANS = np.geomspace(0.55, 1.2, 20)
SMALLER = 0.8  # both, of feet that touch in a rim
TOLERANCE, SETTLE = 1e-3, 10.0  # s
KNOWN = ("lognormal in PGV",)  # does not depend on the foot
AVERAGED = 4  # samples that become one: steps of 5 ms, to 100 Hz
QUIET, BEYOND = 0.15, 100  # m/s2 and samples: what the table does before and after is left out


def shortened(motion: Motion) -> Motion:
    """Return the strong part of a table motion, averaged over samples."""
    count = len(motion.ax) // AVERAGED * AVERAGED
    ax = np.mean(motion.ax[:count].reshape(-1, AVERAGED), axis=1)
    strong = np.flatnonzero(np.abs(ax) > QUIET)
    first, last = (0, len(ax)) if not strong.size else (max(0, strong[0] - BEYOND), strong[-1] + BEYOND)
    return Motion.from_samples(AVERAGED * SAMPLE, ax[first:last])


def scales_of(rim: float | None) -> FloatArray:
    """Return the sizes of the foot that are tried: less on a rim, which bears farther out."""
    return SCALES if rim is None or rim >= WHOLE else SMALLER * SCALES


def verdicts(rock: Rock, motions: Iterable[Motion], direction: float, rim: float | None = None) -> FloatArray:
    """Return 1 where the rock on a foot of a scale falls in a test, (scales, tests); one that cannot stand has
    fallen; NaN where a run ends with an error.
    """
    structures = [
        rock.structure(float(scale), STIFFNESS, DAMPING, FRICTION, rim).with_settings(tolerance=TOLERANCE)
        for scale in scales_of(rim)
    ]
    rows = []
    for motion in motions:
        turned = motion.turned(math.radians(direction))
        rows.append([_falls(Run(structure, turned, turned.duration)) for structure in structures])
    return np.array(rows).T


def _falls(run: Run) -> float:
    try:
        made = run.model.kind.alone(run, ("verdict",), SETTLE, lambda *_: None)
    except NoRestError:
        return 1.0
    except SolverError:
        return math.nan
    return float(made["verdict"] == "overturned")


def bank(rock: Rock, motions: list[Motion], rim: float | None = None) -> dict[str, FloatArray]:
    """Return `verdicts` for each direction, computed in processes."""
    with get_context("spawn").Pool(cores()) as pool:
        found = pool.starmap(verdicts, [(rock, motions, direction, rim) for direction in DIRECTIONS], chunksize=1)
    return {f"{direction} degrees": part for direction, part in zip(DIRECTIONS, found, strict=True)}


def compute(data: Path | None, rims: Sequence[float] = ()) -> Outcome:
    """Compute all verdicts once; the rest is choosing among them."""
    tests = read(data)
    motions = [shortened(motion) for motion in tests.motions]
    lines: list[str] = []
    numbers: dict[str, dict[str, Any]] = {}
    best: dict[str, Judged] = {}
    for specimen, fallen in tests.fallen.items():
        rock = rock_from(scan_of(data, specimen), MASS, LEVEL)
        verdicts, line = scores.failed_as_standing(bank(rock, motions))
        lines.append(f"{specimen}: {line}")
        results = judged(tests, verdicts, specimen)
        best[specimen] = results["best of all directions"]
        for share in rims:
            verdicts, line = scores.failed_as_standing(bank(rock, motions, share))
            lines.append(f"{specimen}, {label_of(share)}: {line}")
            on_rim = judged(tests, verdicts, specimen, share)
            results |= {f"{name}, {label_of(share)}": result for name, result in on_rim.items() if name not in KNOWN}
        numbers[specimen] = {name: [result.agreement, result.log_score] for name, result in results.items()}
        lines.append(f"{specimen}, {len(fallen)} tests; halves not fitted, {SPLITS} splits:")
        lines += [
            f"  {name:44s} agreement {result.agreement:.3f}, logarithmic score {result.log_score:.3f}"
            for name, result in results.items()
        ]
        chosen = best[specimen].chosen
        times = ", ".join(f"{name} {chosen.count(name)} times" for name in sorted(set(chosen)))
        lines.append(f"  chosen: {times}")
    return Outcome(lines, numbers, draw(tests, best))


def judged(tests: Tests, found: dict[str, FloatArray], specimen: str, rim: float | None = None) -> dict[str, Judged]:
    """Judge each direction alone, the best on the same half, the foot as scanned, and the curve in PGV."""
    fallen, weights = tests.fallen[specimen], ensembles(SCALES, MEDIANS)
    shares = {name: scores.with_lapse(weights @ part) for name, part in found.items()}
    as_scanned = int(np.argmin(np.abs(scales_of(rim) - 1.0)))
    scanned = scores.with_lapses(np.array([part[as_scanned] for part in found.values()]))
    names = [name for name in found for _ in scores.LAPSES]
    return {
        "lognormal in PGV": judge_lognormal(tests.pgv, fallen),
        "foot as scanned": judge(scanned, names, fallen),
        **{f"ensemble, {name}": judge(part, [name] * len(part), fallen) for name, part in shares.items()},
        "all directions alike": judge(
            scores.with_lapse(np.mean([weights @ part for part in found.values()], axis=0)), [""] * len(weights), fallen
        ),
        "best of all directions": judge(
            np.concatenate(list(shares.values())), [name for name in shares for _ in weights], fallen
        ),
    }


CASE = Case(
    name="rocks-in-space",
    title="the same tests, each rock in space on the foot of its scan",
    source="github.com/ZhiangChen/virtual_shake_robot_pybullet, data/Shake_Table_Response, data/SP1_PBRmodel",
    model="one block in space: mass, inertia and foot of the scan; ensembles of the size of the foot",
    fitted="on one half of the tests, for each rock: one of 12 directions, median and deviation of the foot's size",
    predicted="which tests of the other half fall, and with what share; mean of 20 splits",
    compute=compute,
    takes_rims=True,
)
