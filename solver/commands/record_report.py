"""The measures of a record, for the terminal."""

from __future__ import annotations

from ..ground.intensity import DAMPING, NAMES, Component, components, intensity, spectrum
from ..ground.motion import STANDARD_GRAVITY, Motion

PERIODS = (0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0)  # s
NO_BASELINE = "integrated from rest, no baseline taken away"


def report(motion: Motion) -> str:
    """Return the measures of every component that is not zero. Raises InputError if all are."""
    there = components(motion)
    if there == ["ax"]:
        return _component(motion, "ax", "")
    return "\n".join(_component(motion, component, f"{NAMES[component]} ") for component in there)


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
            f"  {name}pseudo-acceleration, {DAMPING:.0%} damping",
            "  period (s)" + "".join(f"{period:8g}" for period in PERIODS),
            "  PSA (g)   " + "".join(f"{psa / STANDARD_GRAVITY:8.4f}" for psa in oscillators.psa),
        ]
    )
