"""Friction demand of a response, against forces calculated by hand."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.probe import phocas

from solver import InputError, Motion, simulate
from solver.ground.motion import STANDARD_GRAVITY
from solver.models.column.friction import friction_demand, time_exceeded
from solver.models.column.packing import carried_weights


def response(T: list[float], N: list[float], step: float = 0.5) -> Any:
    """One block of weight 100 N, its forces at rows `step` apart."""
    block = SimpleNamespace(mass=100.0 / STANDARD_GRAVITY)
    column = SimpleNamespace(blocks=[block], g=STANDARD_GRAVITY)
    return SimpleNamespace(column=column, time=step * np.arange(len(T)), T=np.array(T)[:, None], N=np.array(N)[:, None])


def test_the_largest_ratio_does_not_count_a_joint_that_is_open() -> None:
    assert friction_demand(response([10.0, -60.0, 1e-3], [100.0, 120.0, 0.0])) == pytest.approx([0.5])
    # N counts from a twentieth of the weight on, or from another part
    assert friction_demand(response([2.0, 3.0], [1.0, 6.0])) == pytest.approx([0.5])
    assert friction_demand(response([2.0, 3.0], [1.0, 6.0]), part=0.005) == pytest.approx([2.0])


def test_time_exceeded_is_that_of_the_line_between_rows() -> None:
    rises = response([0.0, 80.0, 80.0, 0.0], [100.0] * 4)
    # 0.8 at the crest: above 0.2 for three quarters of the slopes and all of the plateau
    assert time_exceeded(rises, 0.2) == pytest.approx([0.5 * 0.75 + 0.5 + 0.5 * 0.75])
    assert time_exceeded(rises, 0.8) == pytest.approx([0.0])
    assert time_exceeded(rises, 0.0) == pytest.approx([1.5])
    assert time_exceeded(response([50.0] * 3, [100.0] * 3), 0.5) == pytest.approx([0.0])


def test_a_column_that_stays_in_contact_asks_for_the_base_acceleration() -> None:
    # stiff against the motion: T = m a, N = m g in every joint, but for the first swing of 2 %
    given = simulate(phocas(1e-3), Motion.harmonic(0.002 * STANDARD_GRAVITY, 0.2, 10.0))
    assert given.friction_demand() == pytest.approx([0.002] * 3, rel=0.1)
    exceeded = given.time_exceeded(0.001)
    assert exceeded == pytest.approx([10.0 * 2.0 / 3.0] * 3, rel=0.02)  # a sine is above its half for two thirds
    assert np.all(given.time_exceeded(0.01) == 0.0)
    assert carried_weights(given.column) == pytest.approx(given.N[0])


def test_what_makes_no_sense_is_refused() -> None:
    with pytest.raises(InputError, match=r"^mu = -1"):
        time_exceeded(response([1.0], [1.0]), -1.0)
    with pytest.raises(InputError, match=r"^part = 0"):
        friction_demand(response([1.0], [1.0]), 0.0)
    floating = response([1.0], [1.0])
    floating.column.g = 0.0
    with pytest.raises(InputError, match=r"^g = 0\.0"):
        friction_demand(floating)
