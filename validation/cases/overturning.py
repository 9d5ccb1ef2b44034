"""Overturning by a one-sine pulse in the plane of Zhang and Makris, with the restitution of the rigid block."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from multiblock import Block, Column, Joint, calibrate, simulate_many, wavelets

from ..case import Case, Outcome
from ..pictures import BLUE, GREY, INK, RED, label, panels
from ..rigid_block import Flags, FloatArray, overturning

HEIGHT, WIDTH, DEPTH, MASS = 1.0, 0.25, 0.754, 503.0  # m, kg: alpha 0.245
G = 9.80665  # m/s2
ALPHA = math.atan(WIDTH / HEIGHT)
P = math.sqrt(0.75 * G / (0.5 * math.hypot(WIDTH, HEIGHT)))  # 1/s
UNIT = G * WIDTH / HEIGHT  # m/s2: amplitudes are over g tan(alpha)
MAP_STIFFNESS, MAP_RESTITUTION = 1e9, 0.9225  # about the least restitution of this joint
SPEEDS, AMPLITUDES = np.arange(1.0, 8.01, 0.25), np.arange(1.05, 12.0, 0.2)
STIFFNESSES, RESTITUTION = (1e9, 1e10, 1e11), 0.96  # restitution that all of them can have
LINES, FINE = (2.0, 4.0, 6.0), 0.02  # speeds whose intervals are resolved to FINE of g tan(alpha)
TOLERANCE = 1e-4
SETTLE = 6.0  # s


def block(stiffness: float, restitution: float) -> Column:
    """Return the block, its damping such that it keeps this restitution when released at half the way to its edge."""
    column = Column("block", (Block(HEIGHT, WIDTH, DEPTH, MASS, Joint(stiffness, 1e-3)),))
    return calibrate.with_joints(column, damping=calibrate.damping_from_restitution(column, restitution))


def falls(column: Column, amplitude: FloatArray, speed: FloatArray) -> Flags:
    """Return True if the pulses overturn the block; amplitude over g tan(alpha), speed over p."""
    motions = (wavelets.one_sine(UNIT * a, w * P / (2.0 * math.pi)) for a, w in zip(amplitude, speed, strict=True))
    table = simulate_many(column, motions, tolerance=TOLERANCE, keep=("verdict",), settle=SETTLE)
    return np.asarray(table["verdict"] == "overturned", dtype=bool)


def rigid(amplitude: FloatArray, speed: FloatArray, restitution: float) -> Flags:
    """Return True if the pulses overturn the rigid block of this restitution."""
    return overturning(amplitude * WIDTH / HEIGHT / ALPHA, speed, ALPHA, restitution) >= 0


def edges(fallen: Flags, amplitudes: FloatArray) -> list[float]:
    """Return the amplitudes at which the verdict changes: half way between neighbours."""
    changes = np.flatnonzero(np.diff(fallen.astype(int)))
    return [float(0.5 * (amplitudes[k] + amplitudes[k + 1])) for k in changes]


def around(found: list[float]) -> FloatArray:
    """Return the amplitudes from 0.8 to 1.08 times those edges, FINE apart."""
    return np.unique(np.round(np.concatenate([np.arange(0.8 * x, 1.08 * x, FINE) for x in found]), 6))


def compute(data: Path | None) -> Outcome:
    """Compute the map at one modulus, and the edges of three lines of it as the modulus grows."""
    speed, amplitude = (grid.ravel() for grid in np.meshgrid(SPEEDS, AMPLITUDES))
    here = falls(block(MAP_STIFFNESS, MAP_RESTITUTION), amplitude, speed)
    truth = rigid(amplitude, speed, MAP_RESTITUTION)
    agreement = float(np.mean(here == truth))
    fine = np.arange(1.0 + FINE, 12.0, 0.25 * FINE)
    rows: dict[str, Any] = {}
    for w in LINES:
        known = edges(rigid(fine, np.full(len(fine), w), RESTITUTION), fine)
        near = around(known)
        found = {k: edges(falls(block(k, RESTITUTION), near, np.full(len(near), w)), near) for k in STIFFNESSES}
        rows[f"{w:g}"] = {"rigid": known, **{f"{k:g}": value for k, value in found.items()}}
    lines = [
        f"{len(here)} pulses, k = {MAP_STIFFNESS:g} N/m3: {100 * agreement:.1f} % have the verdict of the rigid block",
        f"amplitudes over g tan(alpha) at which the verdict changes, restitution {RESTITUTION}:",
    ]
    for line, row in rows.items():
        lines += [f"  omega/p {line}, {name:>6s}: " + ", ".join(f"{x:.3f}" for x in row[name]) for name in row]
    figure = draw(speed, amplitude, here, truth, rows)
    return Outcome(lines, {"agreement": agreement, "pulses": len(here), "edges": rows}, figure)


def draw(speed: FloatArray, amplitude: FloatArray, here: Flags, truth: Flags, rows: dict[str, Any]) -> Figure:
    """Draw the map, and the edges over the modulus."""
    figure, axes = panels(2)
    left, right = axes[0]
    shape = (len(AMPLITUDES), len(SPEEDS))
    left.contourf(SPEEDS, AMPLITUDES, truth.reshape(shape), levels=[0.5, 1.5], colors=["0.88"])
    left.plot(speed[here], amplitude[here], ".", color=RED, markersize=2.5, label=f"falls here, k = {MAP_STIFFNESS:g}")
    left.plot([], [], "s", color="0.88", label="rigid block falls")
    left.legend(loc="upper left", fontsize=8)
    label(left, "omega / p", "amplitude / (g tan alpha)", f"one sine, restitution {MAP_RESTITUTION}")
    for (w, row), colour in zip(rows.items(), (BLUE, RED, INK), strict=True):
        known = row["rigid"]
        for j, edge in enumerate(known):
            found = [(k, row[f"{k:g}"][j] / edge) for k in STIFFNESSES if len(row[f"{k:g}"]) == len(known)]
            if found:
                name = f"omega / p = {w}" if j == 0 else None
                right.semilogx(*zip(*found, strict=True), "o-", color=colour, markersize=4, label=name)
    right.axhline(1.0, color=GREY, linewidth=0.8)
    right.legend(fontsize=8)
    label(right, "modulus k, N/m3", "amplitude over that of the rigid block", f"edges, restitution {RESTITUTION}")
    return figure


CASE = Case(
    name="overturning",
    title="overturning by one sine against the rigid block of Zhang and Makris (2001)",
    source="Zhang and Makris, Journal of Engineering Mechanics 127 (5), 2001; equations integrated here by RK4",
    model="one block, 0.25 m x 1.0 m, elastic joint",
    fitted="the damping, to the rigid block's restitution in free rocking from half its edge",
    predicted="which pulses overturn, with and without an impact",
    compute=compute,
)
