"""The detection of base accelerations that diverge with their coupling."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fmu_src.alternation import MANY, Alternation
from solver import Motion


def found(values: np.ndarray) -> int:
    """Return the step at which it counts as diverging; -1 if it never does."""
    watch = Alternation(1)
    return next((k for k, value in enumerate(values) if watch.found(float(k), [value]) >= 0), -1)


@pytest.mark.parametrize("factor", [1.1, 1.2, 2.0, 20.0])
def test_what_grows_with_changing_sign_is_found(factor: float) -> None:
    """Check growth by 1.2 to 20 times a step in couplings of docs/coupling.md, below a smooth motion of 3 m/s2."""
    k = np.arange(200)
    smooth = 3.0 * np.sin(0.05 * k)
    error = np.minimum(1e-6 * factor**k, 100.0) * (-1.0) ** k
    step = found(smooth + error)
    assert step >= MANY - 1
    assert abs(error[step]) < 3.0 * factor ** (MANY + 1)  # soon after it is as large as the motion
    assert found(error) == MANY - 1  # every step counts


def test_ground_motion_is_not() -> None:
    """Check sines of any frequency, decaying ringing, noise; and steps that are made again from the same time."""
    k = np.arange(2000)
    assert all(found(np.sin(w * k) * np.minimum(1.0, k / 500.0)) < 0 for w in np.linspace(0.01, 2.8, 50))
    assert found(0.97**k * (-1.0) ** k) < 0
    for seed in range(30):
        noise = np.random.default_rng(seed).standard_normal(2000)
        assert found(noise * np.minimum(1.0, k / 200.0)) < 0
    watch = Alternation(1)
    assert all(watch.found(0.0, [(-2.0) ** i]) < 0 for i in range(100))


def test_recorded_motions_are_not(records: Path) -> None:
    motions = [Motion.from_file(file) for file in sorted(records.rglob("*.AT2"))[:20]]
    assert motions
    assert all(found(motion.ax) < 0 for motion in motions)
