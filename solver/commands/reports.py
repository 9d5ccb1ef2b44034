"""Text for the terminal: a column before a run, a record, a column at rest."""

from __future__ import annotations

import math
from collections.abc import Container, Sequence

import numpy as np

from ..common.digits import percent
from ..common.errors import SolverError
from ..ground.intensity import DAMPING, NAMES, Component, components, intensity, spectrum
from ..ground.motion import STANDARD_GRAVITY, Motion, peaks_in_g
from ..models.column.model import Column
from ..models.column.modes import Modes, natural_frequencies
from ..models.column.packing import FloatArray, settlements
from ..models.column.push import WITHOUT_BONDS
from ..statics.capacity import CapacityCurve, Rest

MOST_BLOCKS = 100  # with more, natural frequencies take too long for a report
PERIODS = (0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0)  # s
NO_BASELINE = "integrated from rest, no baseline taken away"
MOST_MODES = 12  # printed on the terminal
STRONG = 0.3  # of critical: each swing is less than a seventh of the one before, exp(-2 pi 0.3 / sqrt(1 - 0.3^2))


def text_columns(rows: Sequence[Sequence[str]], right: Container[int] = ()) -> list[str]:
    """Return rows of cells as lines, the columns in `right` (from 0) aligned on the right, others on the left."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            cell.rjust(width) if k in right else cell.ljust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def column_report(column: Column, motion: Motion) -> str:
    """Return two lines: size, settlement and first natural frequency of the column; peak of the motion."""
    settled, lowest = settlements(column), math.nan
    if column.g > 0.0 and column.n <= MOST_BLOCKS:
        try:
            lowest = float(natural_frequencies(column)[0])
        except SolverError:  # no stable rest: the run reports it
            lowest = math.nan
    height = sum(block.height for block in column.blocks)
    parts = [f"{column.n} block{'s' if column.n > 1 else ''}, {height:.4g} m", f"settles by {_length(settled.sum())}"]
    if math.isfinite(lowest):
        parts.append(f"first natural frequency {lowest:.4g} Hz")
    undamped = sum(block.joint.damping == 0.0 for block in column.blocks)
    if undamped:
        parts.append(f"{'no' if undamped == column.n else 'not all'} joints damped")
    return f"{column.name}: {', '.join(parts)}\n{base_line(motion)}"


def base_line(motion: Motion) -> str:
    """Return the line on the base motion before a run: duration and peak accelerations."""
    return f"base: {motion.duration:.4g} s, PGA {peaks_in_g(motion)}"


def _length(metres: float) -> str:
    return f"{metres:.3g} m" if metres >= 0.1 else f"{1e3 * metres:.3g} mm"


def motion_report(motion: Motion) -> str:
    """Return the intensity measures of every component that is not zero. Raises InputError if all are."""
    there = components(motion)
    return "\n".join(_component(motion, one, "" if there == ["ax"] else f"{NAMES[one]} ") for one in there)


def _component(motion: Motion, component: Component, name: str) -> str:
    found, oscillators = intensity(motion, component), spectrum(motion, PERIODS, component=component)
    left = f"{found.final_velocity:.2g} m/s and {found.final_displacement:.2g} m at the end"
    return "\n".join(
        [
            f"  {name}PGA {found.pga / STANDARD_GRAVITY:.4g} g ({found.pga:.4g} m/s2)",
            f"  {name}PGV {found.pgv:.4g} m/s, PGD {found.pgd:.4g} m: {NO_BASELINE}; {left}",
            f"  {name}Arias intensity {found.arias:.4g} m/s",
            f"  {name}significant duration 5-95 % {found.significant_duration:.4g} s, "
            f"from {found.start:.4g} s to {found.end:.4g} s",
            f"  {name}pseudo-acceleration, {percent(DAMPING)} damping",
            "  period (s)" + "".join(f"{period:8g}" for period in PERIODS),
            "  PSA (g)   " + "".join(f"{psa / STANDARD_GRAVITY:8.4f}" for psa in oscillators.psa),
        ]
    )


def modes_report(modes: Modes) -> str:
    """Return a table of the first modes."""
    column, count = modes.model, min(MOST_MODES, len(modes.frequency))
    mass = sum(block.mass for block in column.blocks)
    lines = [
        f"{column.name}: {count} of {len(modes.frequency)} modes about rest, {column.settings.formulation} formulation",
        "mode  frequency (Hz)  damping (%)  effective mass (%)",
    ]
    for k in range(count):
        part = (modes.mass_x if modes.sways[k] else modes.mass_z)[k] / mass
        lines.append(
            f"{k + 1:4d}  {modes.frequency[k]:14.6g}  {100.0 * modes.damping_ratio[k]:11.4g}  {100.0 * part:7.2f} "
            f"{'horizontal' if modes.sways[k] else 'vertical'}"
        )
    return "\n".join([*lines, *strongly_damped_lines(modes.damping_ratio[:count])])


def strongly_damped_lines(ratios: FloatArray) -> list[str]:
    """Return a line on the modes whose damping ratio exceeds `STRONG`, or no line if there are none."""
    (strong,) = np.nonzero(ratios > STRONG)
    if not strong.size:
        return []
    named = ("mode " if strong.size == 1 else "modes ") + ", ".join(str(k + 1) for k in strong)
    return [
        f"{named}: damping above {percent(STRONG)} of critical, each swing less than a seventh of the one before: "
        "hardly a vibration, and beyond 100 % none"
    ]


def statics_report(rest: Rest, curve: CapacityCurve, other: CapacityCurve | None = None) -> str:
    """Return a table of the joints at rest with the push that opens each, and the largest push that is balanced.

    `other` is the curve towards the stronger side of a column off its axis.
    """
    (g, unit), strongest = curve.unit, curve.strongest
    steady = "a steady " if curve.pattern is None else ""
    lines = [
        f"{rest.model.name}: settles by {1e3 * float(np.sum(rest.settlement)):.4g} mm",
        f"joint  settlement (mm)  N (kN)      stress (MPa)  opens at ({unit})",
    ]
    # a row for each joint
    for i in range(rest.model.n):
        opens = f"{curve.uplift[i] / g:.5g}"
        if math.isnan(curve.uplift[i]):
            opens = "as it topples" if np.any(curve.contact[:, i] < 1.0) else "never"
        lines.append(
            f"{i + 1:5d}  {1e3 * rest.settlement[i]:15.5g}  {1e-3 * rest.N[i]:10.5g}  {1e-6 * rest.stress[i]:12.5g}  "
            f"{opens}"
        )
    lines.append(
        f"balances {steady}{curve.largest_acceleration / g:.5g} {unit} {curve.limit}: base shear "
        f"{1e-3 * curve.base_shear[strongest]:.5g} kN, moment {1e-3 * curve.base_moment[strongest]:.5g} kN m, "
        f"largest stress {1e-6 * float(np.max(curve.sigma_max[strongest])):.4g} MPa; top at "
        f"{1e3 * abs(float(curve.ux[strongest, 0])):.5g} mm"
    )
    if other is not None:
        lines.append(
            f"table and pushes are towards {curve.towards}, the weaker side; towards {other.towards} it "
            f"balances {other.largest_acceleration / g:.5g} {unit} {other.limit}"
        )
    if rest.model.is_brittle:
        lines.append(f"pushes and openings are {WITHOUT_BONDS}; --space pushes it with them")
    falls = f"falls without a push once the top is displaced by {curve.overturning_displacement:.5g} m"
    lines.append(f"the curve ends before the push is zero again: {curve.ends}" if curve.ends else falls)
    return "\n".join([*lines, f"with less friction than {curve.friction:.3g} it slides before"])
