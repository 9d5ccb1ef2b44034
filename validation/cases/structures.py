"""Structures in space against closed forms and limit analysis: rocking frames, arches."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from multiblock import InputError, Motion, SpatialState, Structure, arch, push_over, simulate
from solver.models.structure.rest import rest_of
from solver.statics.rocking import damping_on_edge

from ..case import Case, Outcome
from ..limits import largest_push
from ..pictures import BLUE, GREEN, INK, RED, label, panels
from ..rigid_block import FloatArray
from ..rims import WHOLE, label_of
from .housner import quarter_period

G = 9.80665  # m/s2
LONG = 40.0  # m, depth of frames on rims, whose bands along the motion hardly bear then
GAMMAS = (0.0, 1.0, 3.0)  # mass of the beam over that of both columns
HEIGHT, WIDTH, RELEASE = 6.0, 1.0, 0.5  # m, m, of the slenderness angle
FRAME_MODULI = (1e9, 1e10, 1e11)  # N/m3
RADIUS, DAMPING = 10.0, 1e-3  # m, s
PUSHED = (7, 0.15, math.radians(157.5))  # voussoirs, thickness over radius, angle
PUSH_MODULI = (1e9, 1e10, 1e11, 1e12)  # N/m3
SEMICIRCLE, THICKNESS_MODULI = 30, (2e9, 2e10, 2e11, 2e12)  # voussoirs; N/m3
MILANKOVITCH = 0.1075  # least thickness over radius of a semicircle of many voussoirs


def rimmed(law: dict[str, float], share: float | None, width: float, depth: float) -> dict[str, float]:
    """Return the law of a joint that touches in a rim, as stiff in all as its whole face; None: the whole face."""
    if share is None or share >= WHOLE:
        return law
    rim = share * width
    bears = 1.0 - (1.0 - 2.0 * share) * max(0.0, 1.0 - 2.0 * rim / depth)
    return law | {"stiffness": law["stiffness"] / bears, "rim": rim}


def released(gamma: float, modulus: float, share: float | None = None, length: float = 1.4) -> tuple[FloatArray, ...]:
    """Return times, s, and rotations of two columns, and a beam if gamma > 0, released from rest on their edges.

    share: of the width, the rims in which they touch, critically damped as a column lands; None: whole faces, undamped.
    """
    depth = 1.0 if share is None else LONG  # rigid frames are planar
    size = {"width": WIDTH, "depth": depth, "height": HEIGHT, "density": 1000.0}
    blocks: list[dict[str, Any]] = [{"name": f"c{k}", "on": "base", "at": [5.0 * k, 0.0], **size} for k in range(2)]
    if gamma:
        beam = {
            "name": "beam",
            "width": 6.0,
            "depth": depth,
            "height": 0.5,
            "mass": 2.0 * gamma * 1000.0 * HEIGHT * depth,
        }
        blocks.append({**beam, "on": ["c0", "c1"], "at": [2.5, 0.0]})
    law = rimmed({"stiffness": modulus, "damping": 0.0, "shear_ratio": 1.0}, share, WIDTH, depth)
    if share is not None:
        mass = 1000.0 * WIDTH * HEIGHT * depth
        inertia = mass * (WIDTH**2 + HEIGHT**2) / 12.0
        law["damping"] = damping_on_edge(law["stiffness"], share * WIDTH * depth, mass, inertia, 0.5 * WIDTH)
    structure = Structure.from_dict({"name": "frame", "joints": law, "block": blocks, "solver": {"tolerance": 1e-7}})
    slope, radius = math.atan2(WIDTH, HEIGHT), 0.5 * math.hypot(WIDTH, HEIGHT)
    turn = RELEASE * slope
    at, rotation = np.zeros((structure.n, 3)), np.zeros((structure.n, 3))
    rotation[:2, 1] = turn
    at[:2, 0] = radius * (math.sin(turn - slope) + math.sin(slope))
    at[:2, 2] = radius * (math.cos(turn - slope) - math.cos(slope))
    at[2:] = 2.0 * at[0]
    still = np.zeros_like(at)
    initial = SpatialState(at, rotation, still, still)
    silence = Motion.from_samples(length, [0.0, 0.0])
    response = simulate(structure, silence, initial=initial, output_step=0.005, settle=0.0)
    return response.time, response.rotation[:, 0, 1]


def frame(gamma: float, modulus: float) -> float:
    """Return the quarter period, s, of a frame on whole faces."""
    time, angle = released(gamma, modulus)
    k = int(np.argmax(angle <= 0.0))
    return float(np.interp(0.0, [-angle[k - 1], -angle[k]], [time[k - 1], time[k]]))


def frame_restitution(gamma: float, modulus: float, share: float) -> float:
    """Return the root of the part of its energy that a frame keeps from the release to the turn on the other side."""
    _, angle = released(gamma, modulus, share, 3.0)
    slope = math.atan2(WIDTH, HEIGHT)
    start, turn = (math.cos(slope - abs(x)) - math.cos(slope) for x in (float(angle[0]), float(np.min(angle))))
    return math.sqrt(turn / start)


def rigid_restitution(gamma: float) -> float:
    """Return the same of rigid blocks that touch at their edges: Makris and Vassiliou (2013)."""
    slope = math.atan2(WIDTH, HEIGHT)
    own = 1.0 - 1.5 * math.sin(slope) ** 2
    return (own + 3.0 * gamma * math.cos(2.0 * slope)) / (1.0 + 3.0 * gamma)


def rigid_frame(gamma: float) -> float:
    """Return the quarter period of Makris and Vassiliou (2013): a block of p^2 (1 + 2 gamma) / (1 + 3 gamma); exact
    angles, s.
    """
    p = math.sqrt(0.75 * G / (0.5 * math.hypot(WIDTH, HEIGHT)) * (1.0 + 2.0 * gamma) / (1.0 + 3.0 * gamma))
    slope = math.atan2(WIDTH, HEIGHT)
    return quarter_period(RELEASE * slope, slope, p)


def extrapolated(moduli: tuple[float, ...], values: list[float]) -> float:
    """Return the value at an infinite modulus from the last two, by 1 / sqrt(k)."""
    factor = math.sqrt(moduli[-1] / moduli[-2])
    return values[-1] + (values[-1] - values[-2]) / (factor - 1.0)


def by_ratio(values: list[float]) -> float:
    """Return the limit of the last three values if their differences go on shrinking by the same ratio (Aitken)."""
    before, last = values[-2] - values[-3], values[-1] - values[-2]
    return values[-1] + last * last / (before - last)


def stands(structure: Structure) -> bool:
    """Return True if it has a rest that Newton's method finds."""
    try:
        rest_of(structure)
    except InputError:
        return False
    return True


def least(holds: Callable[[float], bool], low: float, high: float, halvings: int = 11) -> float:
    """Return the least value from which on something holds, between `low` and `high`."""
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def pushed(modulus: float, share: float | None = None) -> Structure:
    """Return the arch of seven voussoirs."""
    count, thickness, angle = PUSHED
    law = rimmed({"stiffness": modulus, "damping": DAMPING}, share, thickness * RADIUS, 1.0)
    return arch(count, RADIUS, thickness * RADIUS, 1.0, law, angle=angle)


def semicircle(thickness: float, modulus: float) -> Structure:
    """Return a semicircular arch; thickness over radius."""
    return arch(SEMICIRCLE, RADIUS, thickness * RADIUS, 1.0, {"stiffness": modulus, "damping": DAMPING})


def largest_steady_push(modulus: float, share: float | None = None) -> float:
    """Return the largest steady push, g, that the arch of seven voussoirs balances."""
    return push_over(pushed(modulus, share)).largest_acceleration / G


def least_thickness(modulus: float) -> float:
    """Return the thickness over radius from which on the semicircle rests."""
    return least(lambda thickness: stands(semicircle(thickness, modulus)), 0.1, 0.14)


def compute(data: Path | None, rims: Sequence[float] = ()) -> Outcome:
    """Compute each over the modulus, and what rigid blocks do."""
    lines = ["quarter period of a rocking frame, over that of rigid blocks, extrapolated in 1 / sqrt(k):"]
    frames = {}
    for gamma in GAMMAS:
        exact = rigid_frame(gamma)
        found = [frame(gamma, k) / exact for k in FRAME_MODULI]
        frames[gamma] = found
        row = ", ".join(f"{ratio:.4f}" for ratio in found)
        lines.append(f"  gamma = {gamma:g}: {row}; {extrapolated(FRAME_MODULI, found):.5f}")
    push_limit = largest_push(pushed(1e10))
    pushes = [largest_steady_push(k) for k in PUSH_MODULI]
    lines.append(f"push on {PUSHED[0]} voussoirs, g; limit analysis {push_limit:.4f}:")
    lines += [f"  k = {k:.0e} N/m3: {push:.4f}" for k, push in zip(PUSH_MODULI, pushes, strict=True)]
    lines.append(f"  extrapolated by the ratio of differences {by_ratio(pushes):.4f}")
    thin_limit = least(lambda t: math.isfinite(largest_push(semicircle(t, 1e10))), 0.08, 0.14)
    thin = [least_thickness(k) for k in THICKNESS_MODULI]
    lines.append(f"least thickness of a semicircle over its radius; limit analysis {thin_limit:.4f}:")
    lines += [f"  k = {k:.0e} N/m3: {value:.4f}" for k, value in zip(THICKNESS_MODULI, thin, strict=True)]
    lines.append(f"  extrapolated by the ratio of differences {by_ratio(thin):.4f}, Milankovitch {MILANKOVITCH}")
    numbers: dict[str, Any] = {
        "frames": frames,
        "push": pushes,
        "push_limit": push_limit,
        "thickness": thin,
        "thin_limit": thin_limit,
    }
    if rims:
        numbers["rims"], said = on_rims(rims)
        lines += said
    return Outcome(lines, numbers, draw(frames, pushes, push_limit))


def on_rims(rims: Sequence[float]) -> tuple[dict[str, Any], list[str]]:
    """Return what frames lose at an impact and the push on the arch, on rims, and the lines that say it."""
    numbers: dict[str, Any] = {}
    lines = [f"restitution of frames over that of rigid blocks; k = {FRAME_MODULI[0]:.0e} to {FRAME_MODULI[-1]:.0e}:"]
    for share in rims:
        lost = {gamma: [frame_restitution(gamma, k, share) for k in FRAME_MODULI] for gamma in GAMMAS}
        pushes = [largest_steady_push(k, share) for k in PUSH_MODULI]
        numbers[label_of(share)] = {"restitution": lost, "push": pushes}
        for gamma, values in lost.items():
            row = ", ".join(f"{value / rigid_restitution(gamma):.4f}" for value in values)
            lines.append(f"  {label_of(share)}, gamma = {gamma:g}, rigid {rigid_restitution(gamma):.4f}: {row}")
    lines.append(f"push on the arch, g; k = {PUSH_MODULI[0]:.0e} to {PUSH_MODULI[-1]:.0e} N/m3:")
    lines += [f"  {name}: " + ", ".join(f"{push:.4f}" for push in row["push"]) for name, row in numbers.items()]
    return numbers, lines


def draw(frames: dict[float, list[float]], pushes: list[float], limit: float) -> Figure:
    """Draw frames and the pushed arch over the modulus."""
    figure, axes = panels(2)
    left, right = axes[0]
    for (gamma, found), colour in zip(frames.items(), (BLUE, RED, GREEN), strict=True):
        left.loglog(FRAME_MODULI, np.array(found) - 1.0, "o-", color=colour, label=f"gamma = {gamma:g}")
    left.legend(fontsize=8)
    label(left, "modulus k, N/m3", "quarter period over rigid, less 1", "rocking frames")
    right.semilogx(PUSH_MODULI, pushes, "o-", color=BLUE, label="here")
    right.axhline(limit, color=INK, linewidth=0.9, label="limit analysis, rigid")
    right.legend(fontsize=8)
    label(right, "modulus k, N/m3", "largest push that it balances, g", "arch of 7 voussoirs")
    return figure


CASE = Case(
    name="structures",
    title="structures in space: rocking frames, arches",
    source="Makris and Vassiliou (2013); Heyman (1969), limit analysis as a linear program here; Milankovitch, 0.1075",
    model="two columns under a beam; 7 voussoirs over 157.5 degrees; a semicircle of 30 voussoirs; no sliding",
    fitted="nothing",
    predicted="quarter periods; the largest push on an arch, and the thickness from which one rests",
    compute=compute,
    takes_rims=True,
)
