"""Properties of a column at rest, for the terminal: modes; rest, uplift and capacity."""

from __future__ import annotations

import math

import numpy as np

from ..ground.motion import STANDARD_GRAVITY
from ..statics.capacity import CapacityCurve, Rest
from ..statics.modes import Modes

MOST_MODES = 12  # printed on the terminal


def modes_report(modes: Modes) -> str:
    """Return a table of the first modes."""
    column, count = modes.column, min(MOST_MODES, len(modes.frequency))
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
    return "\n".join(lines)


def statics_report(rest: Rest, curve: CapacityCurve) -> str:
    """Return the joints at rest and when they open, and the push that the column balances."""
    g, strongest = STANDARD_GRAVITY, curve.strongest
    lines = [
        f"{rest.column.name}: settles by {1e3 * float(np.sum(rest.settlement)):.4g} mm",
        "joint  settlement (mm)  N (kN)      stress (MPa)  opens at (g)",
    ]
    for i in range(rest.column.n):
        opens = f"{curve.uplift[i] / g:.5g}"
        if math.isnan(curve.uplift[i]):
            opens = "as it topples" if np.any(curve.contact[:, i] < 1.0) else "never"
        lines.append(
            f"{i + 1:5d}  {1e3 * rest.settlement[i]:15.5g}  {1e-3 * rest.N[i]:10.5g}  {1e-6 * rest.stress[i]:12.5g}  "
            f"{opens}"
        )
    return "\n".join(
        [
            *lines,
            f"balances a steady {curve.largest_acceleration / g:.5g} g at most: base shear "
            f"{1e-3 * curve.base_shear[strongest]:.5g} kN, moment {1e-3 * curve.base_moment[strongest]:.5g} kN m, "
            f"largest stress {1e-6 * float(np.max(curve.sigma_max[strongest])):.4g} MPa; top at "
            f"{1e3 * abs(float(curve.ux[strongest, 0])):.5g} mm",
            f"falls without a push once the top is displaced by {curve.overturning_displacement:.5g} m",
            f"with less friction than {curve.friction:.3g} it slides before",
        ]
    )
