"""The lines on verdict, ensemble and cracks in the summary of a run, the same in the plane and in space."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..common.digits import percent
from ..models.outputs import FloatArray
from ..models.protocol import UNDECIDED
from ..models.response import Result
from ..models.uncertainty import PERCENTILES, Ensemble

MOST_NAMED = 10  # joints that have cracked


def verdict_line(response: Result) -> str:
    """Return the verdict as one line, with the time of a fall and what has fallen."""
    if response.verdict == UNDECIDED:
        return f"undecided: {'' if response.overturned else 'not overturned, but '}{response.reason}"
    if not response.overturned:
        return f"standing: not overturned, {response.reason}"
    late = ", after the end of the run" if response.overturn_time > response.time[-1] else ""
    hits = f"; before it these hit each other: {response.hits_before_fall}" if response.hits_before_fall else ""
    return f"overturned at {response.overturn_time:.4g} s: {response.what_fell}{late}{hits}"


def padded(*names: str, least: int = 14) -> list[str]:
    """Return the head and the names of the first column of a table with blanks up to its width, at least `least`."""
    width = max(least, *map(len, names))
    return [name.ljust(width) for name in names]


def error_lines(response: Result, moved: str) -> list[str]:
    """Return the line on the estimated error, if there is one; `moved` names the peaks of displacements."""
    error = response.estimated_error
    if error is None or response.horizon is None:
        return []
    largest = {name: float(np.max(error.peaks[name], initial=0.0)) for name in (moved, "N") if name in error.peaks}
    of_peaks = f"peaks {largest[moved]:.1e}" + (f", those of N {largest['N']:.1e}" if "N" in largest else "")
    return [
        f"estimated error: histories {error.ux:.1e} of the peak, {of_peaks}; predictable until {response.horizon:.4g} s"
    ]


def ensemble_lines(ensemble: Ensemble, names: Sequence[object], moved: str, most: int | None = None) -> list[str]:
    """Return the lines on an ensemble, with at most `most` rows of the table of blocks.

    `names` are the numbers or names of the blocks, `moved` is the symbol of the displacement.
    """
    spread, (low, high) = ensemble.spread, ensemble.share_bounds
    lines = [
        f"{ensemble.size} runs varied by {spread.stiffness:.2g} (stiffness), {spread.damping:.2g} (damping), "
        f"{spread.motion:.2g} (motion): {ensemble.overturned} overturned, {ensemble.undecided} undecided; "
        f"share that overturns {percent(low)} to {percent(high)} at 95 % confidence",
    ]
    if np.all(np.isfinite(ensemble.peaks)):  # NaN where no run stands
        lines.append(f"block  peak |{moved}| (mm) of those that stand, " + ", ".join(f"{p} %" for p in PERCENTILES))
        rows = [*zip(names, ensemble.peaks.T, strict=True)][:most]
        lines += [f"{name!s:>5s}  " + "  ".join(f"{1e3 * peak:14.5g}" for peak in peaks) for name, peaks in rows]
    if ensemble.debris:
        low, high = ensemble.envelope
        (x0, y0, _), (x1, y1, _) = np.min(low, axis=0), np.max(high, axis=0)
        lines.append(
            f"{len(ensemble.debris)} fallen runs: centroids lie at x {x0:.3g} to {x1:.3g} m, y {y0:.3g} to {y1:.3g} m"
        )
        hits = sorted(ensemble.hit_shares.items(), key=lambda hit: -hit[1])
        lines += [", ".join(f"{name} hit in {percent(share)}" for name, share in hits[:MOST_NAMED])] if hits else []
    if np.isfinite(ensemble.amplification):
        lines.append(f"the largest peak spreads by {ensemble.amplification:.3g} times what was varied")
    return lines


def cracks(names: Sequence[str], left: FloatArray | None) -> list[str]:
    """Return a line on the joints that have cracked; no line without such joints.

    `left` is the bonded share of each named joint, 0 to 1; None if it was not recorded.
    """
    if not names or left is None:
        return []
    hurt = [(name, part) for name, part in zip(names, left, strict=True) if part < 1.0]
    named = [f"{name} {part:.3g}" if part else f"{name} nothing" for name, part in hurt]
    if not named:
        return ["no joint has cracked"]
    beyond = f", and {len(named) - MOST_NAMED} more" if len(named) > MOST_NAMED else ""
    return [f"joints that have cracked, and what is bonded of them: {', '.join(named[:MOST_NAMED])}{beyond}"]
