"""A structure in space on the command line: report and summary of a run."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from ..ground.motion import Motion
from ..models.protocol import NoRestError
from ..models.structure.model import Structure
from ..models.structure.modes import frequencies_at_rest, touching
from ..models.structure.response import SpatialResponse
from ..models.structure.rest import rest_of
from .outcome import cracks, ensemble_lines, error_lines, padded, verdict_line
from .reports import base_line

MOST_LINES = 20  # rows of a table
MOST_BLOCKS = 60  # with more, natural frequencies take too long for a report


def report(structure: Structure, motion: Motion) -> str:
    """Return two lines: size and first natural frequencies of the structure; peaks of the motion."""
    top = max(float(np.max(block.corners[:, 2])) for block in structure.blocks)
    parts = [f"{structure.n} blocks, {len(structure.joints)} joints, {len(structure.ties)} ties, {top:.4g} m"]
    if structure.n <= MOST_BLOCKS:
        with suppress(NoRestError):  # a run from another state needs none
            lowest = ", ".join(f"{value:.4g}" for value in frequencies_at_rest(structure)[:3])
            touch = np.any(touching(structure, rest_of(structure)))
            parts.append(f"first natural frequencies{', with neighbours in touch:' if touch else ''} {lowest} Hz")
    return f"{structure.name}: {', '.join(parts)}\n{base_line(motion)}"


def summary(response: SpatialResponse) -> str:
    """Return the results of a run as text for the terminal."""
    structure, peaks, stats = response.model, response.peaks, response.stats
    head, *names = padded("block", *structure.names[:MOST_LINES])
    lines = [f"{head}  peak |ux| (mm)  |uy| (mm)  |uz| (mm)"]
    moved = zip(names, *(1e3 * peaks[name] for name in ("ux", "uy", "uz")), strict=False)
    lines += [f"{name}  {x:14.5g} {y:10.5g} {z:10.5g}" for name, x, y, z in moved]
    lines += [f"... {structure.n - MOST_LINES} more blocks"] if structure.n > MOST_LINES else []
    lines.append(_envelope(response))
    if "N" in peaks:
        lines += _peaks(response)
    # neighbours, cracks, verdict and accuracy
    lines += _neighbours(response)
    lines += cracks(structure.bond_names, peaks.get("bond"))
    lines.append(verdict_line(response))
    if stats.get("released"):
        lines.append(f"joints that ended in the fall have changed the energy by {stats['released']:.3g} J")
    lines += error_lines(response, "u")
    if response.ensemble is not None:
        lines += ensemble_lines(response.ensemble, structure.names, "u", MOST_LINES)
    lines.append(f"{stats['steps']} steps in {stats['wall_time']:.2f} s")
    return "\n".join(lines)


def _peaks(response: SpatialResponse) -> list[str]:
    """Return tables of the peaks of joints, ties and bearings."""
    structure, peaks = response.model, response.peaks
    head, *names = padded("joint", *structure.joint_names[:MOST_LINES])
    lines = [f"{head}  peak N (kN)  least contact  pressure (MPa)  slip (mm)"]
    columns = 1e-3 * peaks["N"], peaks["contact"], 1e-6 * peaks["sigma_max"], 1e3 * peaks["slip"]
    joints = zip(names, *columns, strict=False)
    lines += [f"{name}  {n:11.5g} {c:14.4g} {p:15.4g} {s:10.4g}" for name, n, c, p, s in joints]
    left = len(structure.joints) - MOST_LINES
    lines += [f"... {left} more joints"] if left > 0 else []
    if structure.ties:
        lines.append("ties: peak forces (kN) " + ", ".join(f"{1e-3 * force:.4g}" for force in peaks["tie"]))
    if structure.bearings:
        head, *names = padded("bearing", *structure.bearing_names[:MOST_LINES])
        moved = zip(names, structure.bearings, peaks["d"].tolist(), strict=False)
        lines.append(f"{head}  displacement (mm)  of it at the end  it allows")
        lines += [
            f"{name}  {1e3 * most:17.5g} {1e3 * response.d[-1, k]:17.5g} {1e3 * joint.bearing.capacity:10.5g}"
            for k, (name, joint, most) in enumerate(moved)
            if joint.bearing is not None
        ]
    return lines


def _envelope(response: SpatialResponse) -> str:
    """Return the line on the envelope of the centroids in plan, and on the one that moves farthest."""
    ends = [f"{1e3 * np.min(moved):.4g} to {1e3 * np.max(moved):.4g} mm" for moved in (response.ux, response.uy)]
    far = np.hypot(response.ux, response.uy)
    row, block = np.unravel_index(int(np.argmax(far)), far.shape)
    most = f"{response.model.names[block]} by {1e3 * far[row, block]:.4g} mm at {response.time[row]:.4g} s"
    return f"envelope of the centroids: x {ends[0]}, y {ends[1]}; farthest {most}"


def _neighbours(response: SpatialResponse) -> list[str]:
    """Return a table of the neighbours in the order of their first contacts; no line without neighbours."""
    found = [one.texts for one in response.impacts]
    shown = found[:MOST_LINES]
    head, *names = padded("neighbours", *(one[0] for one in shown), least=24)
    lines = [f"{head} least gap (mm)  largest force (kN)  first contact (s)  its energy (J)"]
    lines += [
        f"{name} {one[1]:>14s} {one[2]:>19s} {one[3]:>18s} {one[4]:>15s}"
        for name, one in zip(names, shown, strict=True)
    ]
    if len(found) > MOST_LINES:
        lines.append(f"... {len(found) - MOST_LINES} more pairs")
    return lines if found else []
