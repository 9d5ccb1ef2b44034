"""Free rocking as measured: which joints lose as much at an impact as stone, concrete and rubber do."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from multiblock import Block, Column, InputError, Joint, SolverError, calibrate
from solver.statics.rocking import pulled_equilibrium, restitution, restitution_from

from ..case import Case, Outcome
from ..pictures import BLUE, INK, RED, label, panels
from ..rigid_block import FloatArray
from ..rims import WHOLE, label_of, on_rims
from .housner import IMPACTS, decay, let_go, peaks_of, quarter_period

G = 9.80665  # m/s2
DENSITY, DEPTH, HEIGHT = 2700.0, 0.5, 1.0  # kg/m3, m, m: of blocks of which the sources give the slenderness alone
RELEASE = 0.5  # of the way to the edge
STRIPS = 16  # of a face; at its edges alone, the first and the last bear
ALPHAS = (0.05, 0.1, 0.15, 0.2, 0.25, 0.35, 0.45)  # rad
STIFFNESSES = (1e8, 1e9, 1e10, 1e11)  # N/m3
ETAS = (3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 3.0)  # s
RUBBER = 1e7  # N/m3

# name: width, depth, height m, restitution measured, moduli tried. Granite: Peña, Prieto, Lourenço, Campos Costa and
# Lemos (2007), as quoted by others. Concrete, rubber: ElGawady, Ma, Butterworth and Ingham, 0.95, 0.97 and 0.67 of
# Housner's.
MEASURED: dict[str, tuple[float, float, float, float, tuple[float, ...]]] = {
    "granite 0.25 m": (0.25, 0.754, 1.0, 0.936, STIFFNESSES),
    "granite 0.17 m": (0.17, 0.502, 1.0, 0.973, STIFFNESSES),
    "granite 0.12 m": (0.12, 0.375, 1.0, 0.978, STIFFNESSES),
    "concrete, aspect 5": (0.2, DEPTH, 1.0, 0.95 * (1.0 - 1.5 / 26.0), STIFFNESSES),
    "concrete, aspect 3": (1.0 / 3.0, DEPTH, 1.0, 0.97 * (1.0 - 1.5 / 10.0), STIFFNESSES),
    "rubber, aspect 5": (0.2, DEPTH, 1.0, 0.67 * (1.0 - 1.5 / 26.0), (RUBBER, *STIFFNESSES)),
}


@dataclass(frozen=True)
class Face:
    """The part of a face that bears: everywhere, at its two edges, or in a rim of this width over its own."""

    edges_alone: bool = False
    rim: float | None = None


FULL, EDGES = Face(), Face(edges_alone=True)
FACES = {"full face": FULL, "edges alone": EDGES}


def block(
    width: float, height: float, stiffness: float, damping: float, face: Face = FULL, depth: float = DEPTH
) -> Column:
    """Return a block on a face; in a rim it is as stiff in all as on the full face, and damped critically."""
    strips = (depth,) + (0.0,) * (STRIPS - 2) + (depth,) if face.edges_alone else None
    joint = Joint(stiffness, damping, section="strips" if face.edges_alone else None, strips=strips)
    made = Column("block", (Block(height, width, depth, DENSITY * width * height * depth, joint),))
    return made if face.rim is None else on_rims(made, face.rim)


def housner(alpha: float) -> float:
    """Return the restitution of the rigid block: 1 - 1.5 sin^2(alpha)."""
    return 1.0 - 1.5 * math.sin(alpha) ** 2


def least_restitution(alpha: float, stiffness: float, face: Face) -> float:
    """Return the least of ETAS, released half way; NaN if the block does not stand or sways only."""
    column = block(HEIGHT * math.tan(alpha), HEIGHT, stiffness, 1e-3, face)
    found = []
    try:
        place = pulled_equilibrium(column, RELEASE)
    except (SolverError, InputError):
        return math.nan
    for eta in ETAS:
        try:
            found.append(restitution_from(calibrate.with_joints(column, damping=eta), *place))
        except SolverError:  # so much damping that it falls to the side of the release
            continue
    return min(found, default=math.nan)


def predicted_restitution(name: str, stiffness: float, share: float) -> float:
    """Return that of a measured block on a rim, critically damped, nothing fitted; NaN if it does not stand or rock."""
    width, depth, height, _, _ = MEASURED[name]
    try:
        return restitution(block(width, height, stiffness, 1e-3, Face(rim=share), depth), RELEASE)
    except (SolverError, InputError):
        return math.nan


def compare(name: str, stiffness: float, kind: str, face: Face) -> dict[str, Any]:
    """Compare the damping that has the measured restitution; peaks and times of impacts over those of a rigid block
    with it.
    """
    width, depth, height, wanted, _ = MEASURED[name]
    alpha, p = math.atan(width / height), math.sqrt(0.75 * G / (0.5 * math.hypot(width, height)))
    column = block(width, height, stiffness, 1e-3, face, depth)
    row: dict[str, Any] = {"k": stiffness, "face": kind}
    try:
        eta = calibrate.damping_from_restitution(column, wanted, RELEASE)
    except (InputError, SolverError):
        return row | {"eta": None}
    theta = let_go(calibrate.with_joints(column, damping=eta), RELEASE, 6.0).ry[:, 0] / alpha
    peaks = peaks_of(theta)[: IMPACTS + 1]
    known = decay(peaks[0], wanted, IMPACTS, alpha)[: len(peaks) - 1]
    impacts = 1e-3 * np.flatnonzero(np.diff(np.sign(theta)))[: len(known)]
    quarters = [quarter_period(alpha * peak, alpha, p) for peak in (peaks[0], *known)]
    times = np.cumsum([before + after for before, after in zip([0.0, *quarters[1:-1]], quarters[:-1], strict=True)])
    return row | {"eta": eta, "peaks": (peaks[1:] / known).tolist(), "times": (impacts / times).tolist()}


def deviation(row: dict[str, Any]) -> float:
    """Return the largest deviation of times, and of peaks but the first, to which the damping is fitted; infinite if no
    damping reaches the restitution.
    """
    return math.inf if row["eta"] is None else float(np.max(np.abs(np.array(row["peaks"][1:] + row["times"]) - 1.0)))


def compute(data: Path | None, rims: Sequence[float] = ()) -> Outcome:
    """Compute the map of the least restitution, and the measured blocks."""
    faces = FACES | {label_of(share): Face(rim=share) for share in rims if share < WHOLE}
    least = {
        kind: np.array([[least_restitution(alpha, k, face) for alpha in ALPHAS] for k in STIFFNESSES])
        for kind, face in FACES.items()
    }
    lines = ["least restitution of any damping, over 1 - 1.5 sin^2(alpha):"]
    rigid = np.array([housner(alpha) for alpha in ALPHAS])
    lines.append(f"  {'alpha':22s}" + " ".join(f"{alpha:6.3f}" for alpha in ALPHAS))
    for face, found in least.items():
        for k, row in zip(STIFFNESSES, found / rigid, strict=True):
            lines.append(f"  {face:11s} k = {k:5.0e}  " + " ".join(f"{value:6.3f}" for value in row))
    rows = {
        name: [compare(name, k, kind, face) for kind, face in faces.items() for k in MEASURED[name][-1]]
        for name in MEASURED
    }
    for name, (width, _, height, wanted, _) in MEASURED.items():
        alpha = math.atan(width / height)
        lines.append(f"{name}: restitution {wanted:.3f} measured, {housner(alpha):.3f} Housner's; reached by")
        lines += _lines_of(rows[name])
    unfitted = {
        name: {label_of(share): [predicted_restitution(name, k, share) for k in STIFFNESSES] for share in rims}
        for name in MEASURED
    }
    if rims:
        lines.append(
            f"restitution with critical damping, nothing fitted; k = {STIFFNESSES[0]:.0e} to {STIFFNESSES[-1]:.0e}:"
        )
    for name, found_by_rim in unfitted.items():
        for kind, values in found_by_rim.items():
            lines.append(
                f"  {name:18s} {MEASURED[name][3]:.3f} measured; {kind:20s} "
                + " ".join(f"{value:6.3f}" for value in values)
            )
    numbers = {"alpha": ALPHAS, "k": STIFFNESSES, "least": least, "housner": rigid, "measured": rows}
    numbers |= {"unfitted": unfitted}
    return Outcome(lines, numbers, draw(least, rigid, rows))


def _lines_of(rows: list[dict[str, Any]]) -> list[str]:
    reached = [row for row in rows if row["eta"] is not None]
    if not reached:
        return ["  no joint that was tried"]
    return [
        f"  {row['face']:20s} k = {row['k']:5.0e} N/m3, eta = {row['eta']:.1e} s: peaks 2 to {IMPACTS} within "
        f"{100 * np.max(np.abs(np.array(row['peaks'][1:]) - 1.0), initial=0.0):.1f} %, times within "
        f"{100 * np.max(np.abs(np.array(row['times']) - 1.0)):.1f} %"
        for row in reached
    ]


def draw(least: dict[str, FloatArray], rigid: FloatArray, rows: dict[str, Any]) -> Figure:
    """Draw the least restitution over slenderness, with what was measured; deviations of the best joint of
    each block.
    """
    figure, axes = panels(2)
    left, right = axes[0]
    left.axhline(1.0, color=INK, linewidth=1.0)
    for (face, found), marker in zip(least.items(), ("o-", "s--"), strict=True):
        for k, colour in ((1, BLUE), (3, RED)):
            name = f"{face}, k = {STIFFNESSES[k]:.0e} N/m3"
            left.plot(ALPHAS, found[k] / rigid, marker, color=colour, markersize=3, linewidth=0.9, label=name)
    for (name, (width, _, height, wanted, _)), above in zip(MEASURED.items(), (6, 6, -9, -9, -9, 6), strict=True):
        alpha = math.atan(width / height)
        place = (alpha, wanted / housner(alpha))
        left.plot(*place, "*", color=INK, markersize=7)
        left.annotate(name, place, fontsize=6, xytext=(3, above), textcoords="offset points")
    left.set_ylim(0.6, 1.2)
    left.legend(fontsize=7, loc="upper left")
    label(left, "alpha, rad", "restitution over Housner's", "least of any damping; stars: measured")
    names = list(rows)
    for face, colour, shift in (("full face", BLUE, -0.18), ("edges alone", RED, 0.18)):
        best = [min((deviation(row) for row in rows[name] if row["face"] == face), default=math.inf) for name in names]
        shown = [100.0 * value if math.isfinite(value) else 0.0 for value in best]
        right.barh(np.arange(len(names)) + shift, shown, height=0.34, color=colour, label=face)
        for k, value in enumerate(best):
            if not math.isfinite(value):
                right.text(0.2, k + shift, "not reached", fontsize=7, va="center", color=colour)
    right.set_yticks(range(len(names)), names, fontsize=7)
    right.invert_yaxis()
    right.legend(fontsize=7)
    label(right, "largest deviation of peaks 2 to 4, and of times, %", "", "best joint of each kind")
    return figure


CASE = Case(
    name="free-rocking",
    title="measured restitutions: which joints have them, with the right peaks and times",
    source="Peña and others (2007), as quoted; ElGawady, Ma, Butterworth and Ingham; size of the latter's assumed, 1 m",
    model="one block; its face bears everywhere, or at its two edges alone",
    fitted="the damping, to the measured restitution of the first impact; modulus and kind of face are tried",
    predicted="peaks after impacts 2 to 4 and times of four; which restitutions no damping reaches",
    compute=compute,
    takes_rims=True,
)
