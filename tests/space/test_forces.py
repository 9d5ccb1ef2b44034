"""Forces of joints in rows and peaks: their errors at loose tolerances, against runs at a close one."""

from __future__ import annotations

import numpy as np
import pytest
from support.fmus import ROOT
from support.probe import G
from support.structures import stack

from solver import simulate
from solver.ground.motion import Motion
from solver.models.structure.builders import colonnade
from solver.models.structure.model import Structure
from solver.models.structure.rest import rest_of, start_from
from solver.models.structure.stepper import Stepper

LAW = {"stiffness": 2e9, "damping": 1e-3}
KINDS = {"N": ("N",), "T": ("Tx", "Ty"), "M": ("Mx", "My"), "sigma_max": ("sigma_max",)}
SCENES = {
    "boxes": (stack(3, damping=1e-3), Motion.harmonic(0.1 * G, 1.0, 1.5, direction=0.3)),
    "drums": (stack(3, "circle", damping=1e-3), Motion.harmonic(0.08 * G, 1.5, 1.5, direction=0.3)),
    "trilith": (
        colonnade(2, 2, 3.0, 0.9, 4.0, LAW, architrave=(0.7, 0.9)),
        Motion.harmonic(0.2 * G, 1.4, 1.2, direction=0.4),
    ),
    "arch": (
        Structure.from_toml(ROOT / "examples" / "structures" / "arch.toml"),
        Motion.harmonic(0.25 * G, 1.5, 1.0, direction=0.4),
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_forces_are_as_good_as_displacements(name: str) -> None:
    """Rows and peaks within ten tolerances of the largest of their kind."""
    structure, motion = SCENES[name]
    closest = simulate(structure, motion, settle=0.0, tolerance=1e-7)
    for tolerance in (1e-3, 1e-4):
        found = simulate(structure, motion, settle=0.0, tolerance=tolerance)
        for kind, names in KINDS.items():
            size = max(float(np.max(closest.peaks[one])) for one in names)
            for one in names:
                rows = float(np.max(np.abs(getattr(found, one) - getattr(closest, one))))
                peaks = float(np.max(np.abs(found.peaks[one] - closest.peaks[one])))
                assert max(rows, peaks) < 10.0 * tolerance * size, (tolerance, kind)  # measured 6, T of drums


def test_rate_at_which_the_joints_die_out() -> None:
    """By powers of the dampers, against all eigenvalues of the matrix that they are."""
    for structure, _ in SCENES.values():
        stepper = Stepper(structure)
        start_from(stepper, rest_of(structure))
        n, pace = structure.n, 1e-6
        first = 7 * n  # rates behind places and quaternions
        stepper.observe()
        still, damping = stepper.rates.copy(), np.zeros((6 * n, 6 * n))
        for k in range(6 * n):
            stepper.phase[first + k] += pace
            stepper.observe()
            damping[:, k] = (still - stepper.rates)[first : 13 * n] / pace
            stepper.phase[first + k] -= pace
        stepper.run(SCENES["boxes"][1], 0.0, 1e-6, np.zeros(0))
        fastest = float(np.max(np.linalg.eigvals(damping).real))
        assert stepper.control.decay == pytest.approx(fastest, rel=0.1)  # measured 0.035
