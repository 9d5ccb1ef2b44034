"""Text for the terminal: modes, rest and push-over of a structure in space."""

from __future__ import annotations

import math

import numpy as np

from ..models.structure.blocks.faces import FloatArray
from ..models.structure.modes import SpatialModes, sliding_frequencies
from ..models.structure.push import PushOver
from .outcome import padded
from .reports import MOST_MODES, strongly_damped_lines
from .structure import MOST_LINES

LEAST_LIMIT = 1e-12  # of the weight: lower bound of the shear limit, against division by zero


def modes_in_space_report(modes: SpatialModes) -> str:
    """Return a table of the first modes."""
    count = min(MOST_MODES, len(modes.frequency))
    lines = [
        f"{modes.model.name}: {count} of {len(modes.frequency)} modes about rest",
        "mode  frequency (Hz)  period (s)  damping (%)  effective mass (%): x       y       z  twist (%)",
    ]
    for k in range(count):
        x, y, z = (f"{100.0 * part:7.2f}" for part in modes.mass_ratio[k])
        lines.append(
            f"{k + 1:4d}  {modes.frequency[k]:14.6g}  {1.0 / modes.frequency[k]:10.4g}  "
            f"{100.0 * modes.damping_ratio[k]:11.4g}  {x:>21s} {y} {z}  {100.0 * modes.twists[k]:9.2f}"
        )
    if any(joint.bed.friction is not None for joint in modes.model.bearings):
        slow = sliding_frequencies(modes.model)[:3]
        periods = ", ".join(f"{1.0 / value:.4g}" for value in slow if value > 0.0) or "none, nothing pulls them back"
        lines.append(
            "bearings are as stiff as about rest, until they slide or yield; periods (s) once all have: " + periods
        )
    lines += strongly_damped_lines(modes.damping_ratio[:count])
    return "\n".join(lines)


def rest_in_space_report(found: PushOver) -> str:
    """Return a table of the joints at rest, the tie forces, and the head of a table of pushes."""
    structure, n = found.model, found.model.n
    settled = -float(np.min(found.uz[0]))
    head, *names = padded("joint at rest", *structure.joint_names[:MOST_LINES], least=24)
    lines = [
        f"{structure.name}: {n} blocks, weight {1e-3 * structure.weight:.5g} kN, settles by {1e3 * settled:.4g} mm",
        f"{head}     N (kN)  pressure (MPa)  contact  friction used",
    ]
    # joints at rest
    used = _friction_used(found)
    for j, name in enumerate(names):
        part = "cannot slide" if math.isnan(used[j]) else f"{used[j]:.3f}"
        lines.append(
            f"{name}  {1e-3 * found.N[0, j]:9.5g}  {1e-6 * found.sigma_max[0, j]:14.4g}  "
            f"{found.contact[0, j]:7.4g}  {part:>13s}".rstrip()
        )
    left = len(structure.joints) - MOST_LINES
    lines += [f"... {left} more joints"] if left > 0 else []
    if structure.ties:
        lines.append("ties: forces (kN) " + ", ".join(f"{1e-3 * force:.4g}" for force in found.tie[0]))
    # head of the table of pushes
    unit = "g" if found.pattern is None else "1"
    pushed = f"first opening ({unit})  first sliding ({unit})  first jump ({unit})  largest ({unit})  which moves (mm)"
    lines.append(f"push towards (deg)  {pushed}")
    return "\n".join(lines)


def push_line(found: PushOver) -> str:
    """Return the row of one direction in the table of pushes."""
    jump = float(found.jumps[0]) if found.jumps.size else math.nan
    opens, slides, jumps = (_shown(found, push) for push in (found.uplift, found.sliding, jump))
    moved = f"{found.model.names[found.moves_most]} {1e3 * found.moved[-1]:.4g}"
    largest = _shown(found, found.largest_acceleration)
    towards = f"{math.degrees(found.direction):.4g}" if found.pattern is None else "pattern"
    return f"{towards:>18s}  {opens:>17s}  {slides:>17s}  {jumps:>14s}  {largest:>11s}  {moved}"


def push_over_report(found: PushOver) -> str:
    """Return lines on the largest push, and on the joints that open and slide first."""
    names, force, (_, unit) = found.model.joint_names, 1e-3 * found.base[-1], found.unit
    towards = f", towards {math.degrees(found.direction):.4g} degrees from x to y" if found.pattern is None else ""
    steady = "a steady " if found.pattern is None else ""
    lines = [
        f"balances {steady}{_shown(found, found.largest_acceleration)} {unit} {found.limit}{towards}: {found.ends}",
        f"base shear {math.hypot(force[0], force[1]):.5g} kN, largest pressure "
        f"{1e-6 * float(np.max(found.sigma_max[-1])):.4g} MPa in {names[int(np.argmax(found.sigma_max[-1]))]}",
    ]
    if found.jumps.size:
        pushes = ", ".join(_shown(found, push) for push in found.jumps)
        bears = "a tie, a neighbour, a ring or a cracked joint"
        lines.append(f"jumps at {pushes} {unit} to where {bears} bears it; impacts and overshoots do not count")
    least = int(np.argmin(found.contact[-1]))
    if math.isfinite(found.uplift):
        first = f"{found.uplift_joint} opens first, at {_shown(found, found.uplift)} {unit}"
        lines.append(f"{first}; least contact at the end {found.contact[-1, least]:.3g}, of {names[least]}")
    if math.isfinite(found.sliding):
        slip = np.where(found.slides[-1], np.abs(found.slip[-1] - found.slip[0]), 0.0)
        first = f"{found.sliding_joint} slides first, at {_shown(found, found.sliding)} {unit}"
        lines.append(f"{first}; largest slip at the end {1e3 * np.max(slip):.3g} mm, of {names[int(np.argmax(slip))]}")
    return "\n".join(lines)


def _shown(found: PushOver, push: float) -> str:
    return "-" if math.isnan(push) else f"{push / found.unit[0]:.5g}"


def _friction_used(found: PushOver) -> FloatArray:
    """Return the shear at rest of each joint over its limit, (joints,); NaN of a joint that cannot slide."""
    joints, bonds = found.model.joints, list(found.model.bonds)
    friction = np.array([math.nan if joint.bed.friction is None else joint.bed.friction for joint in joints])
    dowel, cohesion = (np.array([getattr(joint.bed, key) for joint in joints]) for key in ("dowel", "cohesion"))
    bonded = np.zeros(len(joints))  # m2
    bonded[bonds] = found.bond[0] * [joints[j].moments[0] for j in bonds]
    pressed = np.where(bonded > 0.0, found.N[0], np.maximum(found.N[0], 0.0))  # a bond may bear tension
    limit = friction * pressed + dowel + cohesion * bonded
    used: FloatArray = np.hypot(found.Tx[0], found.Ty[0]) / np.maximum(limit, LEAST_LIMIT * found.model.weight)
    return used
