"""Closed forms of this model, scaling laws, and measured frequencies: expected and found, row by row."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from multiblock import (
    Block,
    Column,
    Joint,
    Motion,
    capacity_curve,
    natural_frequencies,
    natural_modes,
    rest_of,
    simulate,
)

from ..case import Case, Outcome
from ..pictures import BLUE, RED, label, panels
from ..rigid_block import FloatArray

COLUMNS = Path(__file__).parents[2] / "examples" / "columns"
G = 9.80665  # m/s2
SCALE = 0.1  # of the model in the test of similarity
# m at s: 0.05 g, 2 Hz, top of Phocas undamped
FORCED = {0.25: -3.7854e-3, 0.5: 10.921e-3, 1.0: 12.208e-3, 1.5: -19.384e-3, 2.0: -2.598e-3, 3.0: 21.795e-3}
# m, in 3 s: openseespy 3.8, benchmarks/opensees.py with 400 fibres, Newmark 1/2-1/4, steps of 0.2 ms
OPENSEES_PEAK = 30.618e-3
# Bongiovanni and others (2014), Aurelian column, Hz; the model's modulus is fitted to the first two
AURELIAN = (1.24, 1.30, 6.5)

Row = tuple[str, float, float]  # what, expected, found


def similar(column: Column, scale: float) -> Column:
    """Return the column with all lengths times `scale`, of the same material: the same k in N/m3, eta times
    its root.
    """
    blocks = []
    for block in column.blocks:
        joint = replace(block.joint, damping=block.joint.damping * math.sqrt(scale))
        size = {key: getattr(block, key) * scale for key in ("height", "width", "depth")}
        blocks.append(replace(block, **size, mass=block.mass * scale**3, joint=joint))
    return replace(column, blocks=tuple(blocks))


def statics() -> list[Row]:
    """Return Phocas at rest, and as one block under a steady push (section 5 of theory.md)."""
    column = Column.from_toml(COLUMNS / "phocas.toml")
    block = column.blocks[0]
    spring = block.joint.stiffness * block.width * block.depth
    rows = []
    for n, found in enumerate(rest_of(column).settlement, start=1):
        rows.append((f"settlement of joint {n} at rest, m", n * block.mass * G / spring, float(found)))
    whole = Column("monolith", (Block(14.07, 1.56, 1.56, 81000.0, Joint(block.joint.stiffness, 0.0)),))
    curve = capacity_curve(whole)
    rows.append(("Phocas as one block: first frequency, Hz", 3.4873, float(natural_frequencies(whole)[0])))
    rows.append(("its static capacity, g", 0.09653, curve.largest_acceleration / G))
    rows.append(("rotation there, rad", 4.782e-3, abs(float(curve.ry[curve.strongest, 0]))))
    half = curve.contact[:, 0] < 0.999
    N, theta = curve.N[half, 0], np.abs(curve.ry[half, 0])
    contact = np.sqrt(2.0 * N / (block.joint.stiffness * 1.56 * theta))
    known = N * (0.5 * 1.56 - contact / 3.0)
    worst = int(np.argmax(np.abs(np.abs(curve.My[half, 0]) / known - 1.0)))
    rows.append(
        ("moment of the open joint, N m, worst of the curve", known[worst], abs(float(curve.My[half, 0][worst])))
    )
    return rows


def dynamics() -> list[Row]:
    """Return Phocas forced, against a converged solution and OpenSees; a tenth of it, against itself."""
    column = Column.from_toml(COLUMNS / "phocas.toml")
    forced = simulate(column, Motion.harmonic(0.05 * G, 2.0, 3.0), tolerance=1e-8, output_step=0.005, settle=0.0)
    ux = forced.ux[:, 0]
    rows = [
        (f"Phocas, 0.05 g, 2 Hz: top at {t:g} s, m", known, float(ux[round(t / 0.005)])) for t, known in FORCED.items()
    ]
    rows.append(("its peak in 3 s, m; expected: OpenSees", OPENSEES_PEAK, float(forced.peaks["ux"][0])))
    damped = Column.from_toml(COLUMNS / "phocas-damped.toml")
    root = math.sqrt(SCALE)
    large = simulate(damped, Motion.harmonic(0.1 * G, 1.0, 6.0), tolerance=1e-8, output_step=0.01, settle=0.0)
    motion = Motion.harmonic(0.1 * G, 1.0 / root, 6.0 * root)
    small = simulate(similar(damped, SCALE), motion, tolerance=1e-8, output_step=0.01 * root, settle=0.0)
    peak: FloatArray = np.max(np.abs(large.ux), axis=0)
    found = np.max(np.abs(small.ux), axis=0) / SCALE
    rows.append((f"similarity: peak of the top, m, from a model at {SCALE}", float(peak[0]), float(found[0])))
    last = large.ux[-1, 0], small.ux[-1, 0] / SCALE
    rows.append(("similarity: top at 6 s, m", float(last[0]), float(last[1])))
    return rows


def measured() -> list[Row]:
    """Return the Column of Marcus Aurelius: its modulus is fitted to the mean of the first two frequencies."""
    column = Column.from_toml(COLUMNS / "aurelian.toml")
    modes = natural_modes(column)
    sway = np.sort(modes.frequency[modes.sways])
    first = 0.5 * (AURELIAN[0] + AURELIAN[1])
    return [
        ("Aurelian column, first frequency, Hz (fitted)", first, float(sway[0])),
        ("Aurelian column, second frequency, Hz (measured)", AURELIAN[2], float(sway[1])),
    ]


def compute(data: Path | None) -> Outcome:
    """Compute all rows."""
    rows = [*statics(), *dynamics(), *measured()]
    lines = [f"{'':52s} {'expected':>13s} {'found':>13s} {'deviation':>10s}"]
    lines += [f"{what:52s} {known:13.6g} {found:13.6g} {found / known - 1.0:10.1e}" for what, known, found in rows]
    figure, axes = panels(1, width=8.4, height=3.9)
    axis = axes[0, 0]
    error = np.maximum([abs(found / known - 1.0) for _, known, found in rows], 1e-12)
    axis.barh(range(len(rows)), error, color=[RED if value > 1e-2 else BLUE for value in error])
    axis.set_yticks(range(len(rows)), [what for what, _, _ in rows], fontsize=7)
    axis.invert_yaxis()
    axis.set_xscale("log")
    label(axis, "deviation from what is expected, relative", "")
    return Outcome(lines, {what: [known, found] for what, known, found in rows}, figure)


CASE = Case(
    name="closed-forms",
    title="closed forms, converged solutions, similarity, measured frequencies",
    source="docs/theory.md, section 5; OpenSees; Bongiovanni and others (2014)",
    model="the Columns of Phocas and of Marcus Aurelius",
    fitted="nothing, but the modulus of the Aurelian column to its first frequency",
    predicted="all rows of the picture",
    compute=compute,
)
