"""490 shaking-table tests of two granite rocks: models fitted on one half of them and judged on the other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from multiblock import Block, Column, Joint, Motion, Table, simulate_many

from .. import scores
from ..case import Case, Outcome
from ..pictures import BLUE, GREY, RED, label, panels
from ..rigid_block import Flags, FloatArray
from ..rims import WHOLE, label_of, on_rims
from ..rocks import Tests, read

MASS, DEPTH = 353.0, 0.6  # kg, m
RATIOS = np.geomspace(0.07, 0.26, 14)  # width over height
MEDIANS = np.geomspace(0.09, 0.24, 25)  # of the ratio in the ensemble
NARROWER = 0.75  # both, of rocks that touch in a rim
DEVIATIONS = np.array([0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4])
TOLERANCE = 1e-3
SPLITS, SEED = 20, 1
EDGE_STRIPS = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)  # contact at both edges alone
SHARES = np.linspace(0.0, 1.0, 11)  # bins of the calibration
VELOCITIES = np.array([0.0, 0.05, 0.075, 0.1, 0.125, 0.15, 0.175, 0.2, 0.25, 0.3, 0.4, 2.0])  # m/s


@dataclass(frozen=True)
class Model:
    """A rock as one block; height m, stiffness N/m3, damping s. lean: inclination of its joint over atan(ratio)."""

    height: float = 0.79
    stiffness: float = 1e9
    damping: float = 3e-3
    lean: float = 0.0
    edges_only: bool = False
    rim: float | None = None  # width of the rim in which it touches, over its own; the damping is then critical
    part: float = 1.0  # of the critical damping

    @property
    def ratios(self) -> FloatArray:
        """The widths over height that are tried: less on a rim, which bears farther out."""
        return RATIOS if self.rim is None or self.rim >= WHOLE else NARROWER * RATIOS

    def column(self, ratio: float) -> Column:
        """Return the block of this width over height."""
        strips = tuple(DEPTH * part for part in EDGE_STRIPS) if self.edges_only else None
        joint = Joint(
            self.stiffness,
            self.damping,
            section="strips" if self.edges_only else None,
            strips=strips,
            inclination=self.lean * math.atan(ratio) or None,
        )
        whole = Column("rock", (Block(self.height, ratio * self.height, DEPTH, MASS, joint),))
        return whole if self.rim is None else on_rims(whole, self.rim, self.part)


MODELS = {
    "upright": Model(),
    "eta 1 ms": Model(damping=1e-3),
    "eta 10 ms": Model(damping=1e-2),
    "k 5e9": Model(stiffness=5e9),
    "leans +": Model(lean=0.25),
    "leans -": Model(lean=-0.25),
    "leans more": Model(lean=0.4),
    "low": Model(height=0.6),
    "low, leans +": Model(height=0.6, lean=0.25),
    "low, leans -": Model(height=0.6, lean=-0.25),
    "edges only": Model(edges_only=True),
}
RIMMED = {
    "upright": Model(),
    "upright, a fifth of it": Model(part=0.2),
    "leans +": Model(lean=0.25),
    "leans -": Model(lean=-0.25),
    "leans more": Model(lean=0.4),
}


def bank(models: dict[str, Model], motions: list[Motion]) -> dict[str, FloatArray]:
    """Return 1 where a block of a ratio falls in a test: (ratios, tests) of each model.

    Undecided counts as standing; NaN where a run ends with an error.
    """
    found = {}
    for name, model in models.items():
        columns = [model.column(float(ratio)) for ratio in model.ratios]
        tables = (simulate_many(column, motions, tolerance=TOLERANCE, keep=("verdict",)) for column in columns)
        found[name] = np.array([_fell(table) for table in tables])
    return found


def _fell(table: Table) -> FloatArray:
    fell = np.asarray(table["verdict"] == "overturned", dtype=np.float64)
    fell[list(table.stats["failures"])] = math.nan
    return fell


def ensembles(values: FloatArray = RATIOS, medians: FloatArray = MEDIANS) -> FloatArray:
    """Return the weights of the values in lognormal ensembles, (medians x deviations, values): rows sum to 1."""
    distance = np.log(values) - np.log(medians)[:, None, None]
    weights = np.exp(-0.5 * (distance / DEVIATIONS[:, None]) ** 2).reshape(-1, len(values))
    found: FloatArray = weights / weights.sum(axis=1, keepdims=True)
    return found


@dataclass(frozen=True)
class Judged:
    """Means over the splits, on the halves not fitted; shares (m,): of each test, where it is not fitted."""

    agreement: float
    log_score: float
    shares: FloatArray
    chosen: list[str]


def judge(shares: FloatArray, names: list[str], fallen: Flags) -> Judged:
    """Judge, of candidate shares (c, m), the one of the best score on one half on the other."""
    agreements, log_scores, chosen = [], [], []
    total, count = np.zeros(len(fallen)), np.zeros(len(fallen))
    for fit, held in scores.halves(fallen, SPLITS, SEED):
        best = int(np.argmax(scores.log_score(shares[:, fit], fallen[fit])))
        chosen.append(names[best])
        agreements.append(scores.agreement(shares[best, held], fallen[held]))
        log_scores.append(float(scores.log_score(shares[best, held], fallen[held])))
        total[held] += shares[best, held]
        count[held] += 1
    return Judged(float(np.mean(agreements)), float(np.mean(log_scores)), total / np.maximum(count, 1), chosen)


def judge_lognormal(measure: FloatArray, fallen: Flags) -> Judged:
    """Judge the lognormal curve over a measure of intensity, fitted on each half."""
    agreements, log_scores = [], []
    total, count = np.zeros(len(fallen)), np.zeros(len(fallen))
    for fit, held in scores.halves(fallen, SPLITS, SEED):
        share = scores.lognormal(measure[held], *scores.lognormal_fit(measure[fit], fallen[fit]))
        agreements.append(scores.agreement(share, fallen[held]))
        log_scores.append(float(scores.log_score(share, fallen[held])))
        total[held] += share
        count[held] += 1
    return Judged(float(np.mean(agreements)), float(np.mean(log_scores)), total / np.maximum(count, 1), [])


def compute(data: Path | None, rims: Sequence[float] = ()) -> Outcome:
    """Compute the verdicts of all models in all tests, once; the rest is choosing among them."""
    tests = read(data)
    verdicts, line = scores.failed_as_standing(bank(MODELS, tests.motions))
    lines = [line]
    rimmed = {}
    for share in rims:
        models = {f"{name}, {label_of(share)}": replace(m, rim=share) for name, m in RIMMED.items()}
        rimmed[label_of(share)], line = scores.failed_as_standing(bank(models, tests.motions))
        lines.append(f"{label_of(share)}: {line}")
    weights = ensembles()
    numbers: dict[str, dict[str, Any]] = {}
    best: dict[str, Judged] = {}
    for specimen, fallen in tests.fallen.items():
        results, best[specimen] = _judged(tests, verdicts, weights, specimen)
        results |= judged_on_rims(rimmed, verdicts, weights, fallen)
        numbers[specimen] = {name: [result.agreement, result.log_score] for name, result in results.items()}
        chosen = {name: best[specimen].chosen.count(name) for name in sorted(set(best[specimen].chosen))}
        numbers[specimen]["chosen"] = chosen
        lines.append(
            f"{specimen}, {len(fallen)} tests, {np.mean(fallen):.3f} fell; halves not fitted, {SPLITS} splits:"
        )
        lines += [
            f"  {name:42s} agreement {result.agreement:.3f}, logarithmic score {result.log_score:.3f}"
            for name, result in results.items()
        ]
        lines.append(f"  chosen: {', '.join(f'{name} {times} times' for name, times in chosen.items())}")
    return Outcome(lines, numbers, draw(tests, best))


def _judged(
    tests: Tests, verdicts: dict[str, FloatArray], weights: FloatArray, specimen: str
) -> tuple[dict[str, Judged], Judged]:
    fallen = tests.fallen[specimen]
    shares = {name: scores.with_lapse(weights @ found) for name, found in verdicts.items()}
    every = np.concatenate(list(shares.values()))
    names = [name for name in shares for _ in weights]
    best = judge(every, names, fallen)
    single = scores.with_lapses(verdicts["upright"])
    elements = scores.with_lapses(tests.elements[specimen].astype(np.float64))
    standing = scores.with_lapses(np.zeros((1, len(fallen))))
    lapses = range(len(scores.LAPSES))
    results = {
        "stands, always": judge(standing, [""] * len(standing), fallen),
        "lognormal in PGV": judge_lognormal(tests.pgv, fallen),
        "distinct elements": judge(elements, [""] * len(elements), fallen),
        "one block, one ratio": judge(single, [f"{ratio:.3f}" for ratio in RATIOS for _ in lapses], fallen),
        **{f"ensemble, {name}": judge(found, [name] * len(found), fallen) for name, found in shares.items()},
        "best of all ensembles": best,
    }
    return results, best


def judged_on_rims(
    rimmed: dict[str, dict[str, FloatArray]], whole: dict[str, FloatArray], weights: FloatArray, fallen: Flags
) -> dict[str, Judged]:
    """Judge each model on a rim, the best of each rim, and of whole faces and rims the one chosen on the same
    half.
    """
    results: dict[str, Judged] = {}
    every = [(name, scores.with_lapse(weights @ found)) for name, found in whole.items()]
    for rim, bank_of_rim in rimmed.items():
        shares = {name: scores.with_lapse(weights @ found) for name, found in bank_of_rim.items()}
        single = scores.with_lapses(next(iter(bank_of_rim.values())))
        results[f"one block, one ratio, {rim}"] = judge(single, [""] * len(single), fallen)
        results |= {f"ensemble, {name}": judge(found, [name] * len(found), fallen) for name, found in shares.items()}
        results[f"best of all, {rim}"] = _best(list(shares.items()), fallen)
        every += shares.items()
    if rimmed:
        results["best of whole faces and rims"] = _best(every, fallen)
    return results


def _best(shares: list[tuple[str, FloatArray]], fallen: Flags) -> Judged:
    names = [name for name, found in shares for _ in found]
    return judge(np.concatenate([found for _, found in shares]), names, fallen)


def draw(tests: Tests, best: dict[str, Judged]) -> Figure:
    """Draw the calibration, and fragility over PGV, of both specimens; all predictions on halves not fitted."""
    figure, axes = panels(2)
    left, right = axes[0]
    left.plot([0, 1], [0, 1], color=GREY, linewidth=0.8)
    for (specimen, result), colour in zip(best.items(), (BLUE, RED), strict=False):
        fallen = tests.fallen[specimen]
        number, share, fell = scores.binned(result.shares, SHARES, result.shares, fallen).T
        low, high = scores.bounds(fell, number)
        error = np.abs([fell / number - low, high - fell / number])
        left.errorbar(share, fell / number, error, fmt="o", color=colour, markersize=4, linewidth=0.8, label=specimen)
        _draw_fragility(right, tests.pgv, result, fallen, colour, specimen)
    left.legend(fontsize=8)
    right.legend(fontsize=8, loc="lower right")
    label(left, "share of the ensemble that falls", "share of the tests that fell", "calibration, bounds of 95 %")
    label(right, "PGV, m/s", "share that falls", "points: observed; lines: predicted; dotted: PGV curve")
    right.set_xscale("log")
    right.set_xticks([0.05, 0.1, 0.2, 0.4], ["0.05", "0.1", "0.2", "0.4"])
    right.xaxis.set_minor_formatter(NullFormatter())
    return figure


def _draw_fragility(axis: Any, pgv: FloatArray, result: Judged, fallen: Flags, colour: str, name: str) -> None:
    number, share, fell = scores.binned(pgv, VELOCITIES, result.shares, fallen).T
    middle = scores.binned(pgv, VELOCITIES, pgv, fallen)[:, 1]
    low, high = scores.bounds(fell, number)
    axis.errorbar(
        middle, fell / number, np.abs([fell / number - low, high - fell / number]), fmt="o", color=colour,
        markersize=4, linewidth=0.8, label=name,
    )  # fmt: skip
    axis.plot(middle, share, "-", color=colour, linewidth=1.2)
    grid = np.geomspace(0.03, 0.6, 60)
    axis.plot(grid, scores.lognormal(grid, *scores.lognormal_fit(pgv, fallen)), ":", color=colour, linewidth=1.0)


CASE = Case(
    name="rocks",
    title="490 shaking-table tests of two granite rocks: which fall",
    source="github.com/ZhiangChen/virtual_shake_robot_pybullet, data/Shake_Table_Response (no licence of its own)",
    model="one planar block; ensembles of its width over height; upright, leaning, lower, contact at the edges alone",
    fitted="on one half of the tests, for each rock: one of 11 models, median and deviation of width over height",
    predicted="which tests of the other half fall, and with what share; mean of 20 splits",
    compute=compute,
    takes_rims=True,
)
