"""Multidrum columns on shaking tables: peaks and offsets that were measured, against ensembles of the model."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

from multiblock import Column, InputError, Motion, calibrate, simulate_many

from ..case import Case, Outcome, data_folder
from ..pictures import BLUE, RED, label, panels
from ..rigid_block import FloatArray
from ..rims import label_of, on_rims

FOLDER = "multidrum"
ADVICE = (
    "the measured numbers of Buzov and others (2018), doi 10.1155/2018/5729068, Drosos and Anastasopoulos (2015) or "
    "Mouzakis and others (2002), typed into tests.csv as docs/validation.md says; none could be had in a form to read"
)
KEYS = ("column", "motion", "scale", "fell", "peak", "residual")
RUNS = 30
SPREAD = {"modulus": 0.3, "damping": 0.3, "motion": 0.02}  # deviations of the logarithms of factors: assumed


@dataclass(frozen=True)
class Test:
    """A test: column, motion as applied, whether it fell, peak and residual displacement of the top, m (NaN: not)."""

    name: str
    column: Column
    motion: Motion
    fell: bool
    peak: float
    residual: float


def read(folder: Path) -> list[Test]:
    """Read the rows of tests.csv. Raises InputError with file, line, key and value."""
    path = folder / "tests.csv"
    if not path.is_file():
        raise InputError(f"{path}: no such file; its first line must be {','.join(KEYS)}")
    tests = []
    with path.open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        if tuple(reader.fieldnames or ()) != KEYS:
            raise InputError(f"{path}: line 1: must be {','.join(KEYS)}")
        for line, row in enumerate(reader, start=2):
            where = f"{path}: line {line}"
            scale, peak, residual = (_number(where, key, row[key]) for key in ("scale", "peak", "residual"))
            if row["fell"] not in ("0", "1"):
                raise InputError(f"{where}: fell = {row['fell']!r}: must be 1, or 0 if it stood")
            motion = Motion.from_file(folder / row["motion"])
            tests.append(
                Test(
                    f"{row['column']}, {row['motion']}, {scale:g}",
                    Column.from_toml(folder / row["column"]),
                    motion.scaled(scale),
                    row["fell"] == "1",
                    peak,
                    residual,
                )
            )
    return tests


def _number(where: str, key: str, text: str | None) -> float:
    if not text:
        return math.nan
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{where}: {key} = {text!r}: must be a number, or empty if it was not measured") from None


def place_in(sample: FloatArray, measured: float) -> float:
    """Return the part of the sample below the measured value: within 0.025 and 0.975 it could be one of them; NaN if
    unknown.
    """
    known = sample[np.isfinite(sample)]
    return math.nan if math.isnan(measured) or not len(known) else float(np.mean(known < measured))


def ensemble_of(test: Test, share: float | None = None) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the peaks and residual displacements of the top, m, and whether it fell: (RUNS,) each, with SPREAD about
    the test.

    share: width over that of the face of the rims in which the drums touch, critically damped; None: as in the file.
    """
    rng = np.random.default_rng(0)
    middle = test.column if share is None else on_rims(test.column, share)
    joints = middle.blocks
    columns, motions = [], []
    for _ in range(RUNS):
        k, eta, factor = (math.exp(deviation * rng.standard_normal()) for deviation in SPREAD.values())
        stiffness = [k * block.joint.stiffness for block in joints]
        columns.append(calibrate.with_joints(middle, stiffness, [eta * block.joint.damping for block in joints]))
        motions.append(test.motion.scaled(factor))
    table = simulate_many(columns, motions, tolerance=1e-4, keep=("peak_top_ux", "residual_top_ux", "verdict"))
    fell = (table["verdict"] == "overturned").astype(np.float64)
    peak = np.where(fell == 1.0, math.nan, table["peak_top_ux"][:, 0])
    return peak, np.abs(table["residual_top_ux"][:, 0]), fell


def compute(data: Path | None, rims: Sequence[float] = ()) -> Outcome:
    """Compute an ensemble of the column under each motion; places of the measured values in it."""
    tests = read(data_folder(data, FOLDER, ADVICE))
    lines, numbers = [], {}
    figure, axes = panels(1, width=8.4)
    axis = axes[0, 0]
    faces = {"": None} | {f", {label_of(share)}": share for share in rims}
    for k, (test, (face, share)) in enumerate(product(tests, faces.items())):
        peak, residual, fell = ensemble_of(test, share)
        row = {
            "fell": test.fell,
            "share": float(np.mean(fell)),
            "peak": place_in(peak, test.peak),
            "residual": place_in(residual, test.residual),
        }
        numbers[test.name + face] = row
        lines.append(
            f"{test.name}{face}: fell {test.fell:d}, share of the ensemble {row['share']:.2f}; of the ensemble, "
            f"{row['peak']:.2f} have less than the measured peak, {row['residual']:.2f} less than the residual"
        )
        axis.plot(np.full(RUNS, k), peak, ".", color=BLUE, alpha=0.4)
        axis.plot(k, test.peak, "*", color=RED)
    axis.set_xticks(range(len(numbers)), list(numbers), fontsize=6, rotation=20)
    label(axis, "", "peak of the top, m", "ensemble (dots), measured (stars)")
    return Outcome(lines, numbers, figure)


CASE = Case(
    name="drums",
    title="multidrum columns on shaking tables: verdicts, peaks and offsets within the scatter of an ensemble",
    source="tests.csv of the user's data; the tests that it is meant for are named in validation/cases/drums.py",
    model="the column files beside it, modulus and damping varied by 30 %, motion by 2 %, 30 runs each",
    fitted="nothing",
    predicted="share that falls; where measured peaks and offsets lie in the ensemble",
    compute=compute,
    takes_rims=True,
)
