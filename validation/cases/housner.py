"""Free rocking of one block: quarter periods and decay, against Housner's rigid block, as the joint stiffens."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from multiblock import Block, Column, Joint, Motion, Response, calibrate, housner_restitution, simulate
from solver.statics.rocking import pulled_equilibrium

from ..case import Case, Outcome
from ..pictures import BLUE, GREEN, INK, RED, label, panels
from ..rigid_block import FloatArray

G = 9.80665  # m/s2
HEIGHT, WIDTH, MASS = 14.07, 1.56, 81000.0  # m, m, kg: the Column of Phocas as one block
PHOCAS = 533 * 9.80665e6  # N/m3
FACTORS = (0.1, 1.0, 10.0, 100.0)  # times that modulus
RELEASES = (0.25, 0.5, 0.75, 0.9)
IMPACTS = 4
NODES = 200  # of the Gauss-Legendre quadrature
LENGTH = 15.0  # s: five impacts


def block(stiffness: float, damping: float) -> Column:
    """Return the column of Phocas as one block."""
    return Column("monolith", (Block(HEIGHT, WIDTH, WIDTH, MASS, Joint(stiffness, damping)),))


def let_go(column: Column, release: float, length: float = LENGTH) -> Response:
    """Free rocking from a place of balance: `release` of the way to the edge."""
    still = Motion.from_samples(length, [0.0, 0.0])
    return simulate(column, still, initial=pulled_equilibrium(column, release)[0], output_step=1e-3, settle=0.0)


def quarter_period(start: float, alpha: float, p: float) -> float:
    """Time, s, from rest at the rotation `start` (rad) to the first impact: theta'' = -p^2 sin(alpha - theta)."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    u = 0.5 * (nodes + 1.0)
    theta = start * (1.0 - u**2)  # which removes the root at the start
    rate = p * np.sqrt(2.0 * (np.cos(alpha - start) - np.cos(alpha - theta)))
    return float(np.sum(0.5 * weights * 2.0 * start * u / rate))


def decay(start: float, restitution: float, impacts: int, alpha: float) -> FloatArray:
    """Return the peaks over alpha (rad) after 1 ... impacts, released at `start` alpha, of a rigid block of any
    slenderness: each impact keeps restitution^2 of the energy.
    """
    n = np.arange(1, impacts + 1)
    energy = restitution ** (2 * n) * (math.cos(alpha * (1.0 - start)) - math.cos(alpha))
    return 1.0 - np.arccos(math.cos(alpha) + energy) / alpha


def peaks_of(theta: FloatArray) -> FloatArray:
    """Return the largest rotations between its zeros, the release first; the last, unfinished, half cycle is
    left out.
    """
    zeros = np.flatnonzero(np.diff(np.sign(theta))) + 1
    return np.array([np.max(np.abs(part)) for part in np.split(theta, zeros)[:-1]])


def first_zero(response: Response) -> float:
    """Return the time at which the rotation changes sign, s."""
    theta = response.ry[:, 0]
    k = int(np.flatnonzero(np.diff(np.sign(theta)))[0])
    return float(response.time[k] + 1e-3 * theta[k] / (theta[k] - theta[k + 1]))


def compute(data: Path | None) -> Outcome:
    """Compute quarter periods undamped, and peaks with the damping that has Housner's restitution."""
    alpha = math.atan(WIDTH / HEIGHT)
    p = math.sqrt(0.75 * G / (0.5 * math.hypot(WIDTH, HEIGHT)))
    periods: dict[str, list[float]] = {}
    decays: dict[str, list[list[float]]] = {}
    lines = ["quarter period over that of the rigid block, released at 0.25, 0.5, 0.75, 0.9 of the way to the edge:"]
    for factor in FACTORS:
        ratios = []
        for release in RELEASES:
            response = let_go(block(factor * PHOCAS, 0.0), release, 6.0)
            start = abs(float(response.ry[0, 0]))
            ratios.append(first_zero(response) / quarter_period(start, alpha, p))
        periods[f"{factor:g}"] = ratios
        lines.append(f"  k = {factor * PHOCAS:.2e} N/m3: " + ", ".join(f"{ratio:.4f}" for ratio in ratios))
    wanted = housner_restitution(block(PHOCAS, 0.0))
    lines.append(
        f"peaks over those of a rigid block of restitution {wanted:.4f}, after impact 1 (fitted) and 2 to {IMPACTS}:"
    )
    for factor in FACTORS[:-1]:  # at the last no damping has Housner's restitution
        column = block(factor * PHOCAS, 1e-3)
        eta = calibrate.damping_from_restitution(column, wanted)
        peaks = peaks_of(let_go(calibrate.with_joints(column, damping=eta), 0.5).ry[:, 0]) / alpha
        known = decay(peaks[0], wanted, IMPACTS, alpha)
        decays[f"{factor:g}"] = [peaks[1 : IMPACTS + 1].tolist(), known.tolist()]
        ratio = peaks[1 : IMPACTS + 1] / known
        lines.append(
            f"  k = {factor * PHOCAS:.2e} N/m3, eta = {eta:.2e} s: " + ", ".join(f"{value:.3f}" for value in ratio)
        )
    numbers = {"alpha": alpha, "p": p, "restitution": wanted, "quarter_periods": periods, "decays": decays}
    return Outcome(lines, numbers, draw(periods, decays))


def draw(periods: dict[str, list[float]], decays: dict[str, list[list[float]]]) -> Figure:
    """Draw quarter periods over the modulus; peaks over the number of impacts."""
    figure, axes = panels(2)
    left, right = axes[0]
    for j, (release, colour) in enumerate(zip(RELEASES, (BLUE, RED, GREEN, INK), strict=True)):
        found = [periods[f"{factor:g}"][j] - 1.0 for factor in FACTORS]
        left.loglog([factor * PHOCAS for factor in FACTORS], found, "o-", color=colour, label=f"{release:g} of the way")
    left.legend(fontsize=8)
    label(left, "modulus k, N/m3", "quarter period over rigid, less 1", "undamped: tends to the rigid block")
    n = np.arange(1, IMPACTS + 1)
    for (name, (found, known)), colour in zip(decays.items(), (BLUE, RED, GREEN), strict=True):
        right.plot(n, found, "o", color=colour, markersize=4, label=f"k = {float(name) * PHOCAS:.1e} N/m3")
        right.plot(n, known, "-", color=colour, linewidth=0.8)
    right.legend(fontsize=8)
    right.set_xticks(n)
    label(right, "impacts", "peak / alpha", "decay; lines: Housner's block")
    return figure


CASE = Case(
    name="housner",
    title="free rocking against Housner's rigid block",
    source="Housner (1963), Bulletin of the Seismological Society of America 53 (2); quadrature here",
    model="the Column of Phocas as one block",
    fitted="quarter periods: nothing. Decay: the damping, to Housner's restitution of the first impact",
    predicted="quarter periods; the peaks after impacts 2 to 4",
    compute=compute,
)
