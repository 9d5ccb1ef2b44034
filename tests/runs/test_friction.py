"""Friction demand of a response, against forces calculated by hand."""

import numpy as np
import pytest
from support.probe import phocas

from solver import Block, Column, InputError, Joint, Motion, simulate
from solver.ground.motion import STANDARD_GRAVITY
from solver.kernels.layout import spaces as at
from solver.models.column.outputs import OUTPUTS
from solver.models.column.packing import carried_weights
from solver.models.column.response import Response
from solver.models.outputs import places_of


def response(T: list[float], N: list[float], step: float = 0.5, g: float = STANDARD_GRAVITY) -> Response:
    """Return one block of weight 100 N, its forces at rows `step` apart."""
    column = Column("one", (Block(1.0, 1.0, 1.0, 100.0 / STANDARD_GRAVITY, Joint(1e9, 1e-3)),), g=g)
    rows, places = np.zeros((len(T), at.ROW.size(1))), places_of(OUTPUTS, column.sizes)
    rows[:, places["Tx"]] = np.array(T)[:, None]
    rows[:, places["N"]] = np.array(N)[:, None]
    time = np.arange(len(T), dtype=np.float64) * step
    return Response(column, lambda: rows, np.empty((len(rows), 0)), time=time, peaks={}, stats={})


def test_the_largest_ratio_does_not_count_a_joint_that_is_open() -> None:
    assert response([10.0, -60.0, 1e-3], [100.0, 120.0, 0.0]).friction_demand() == pytest.approx([0.5])
    # N counts from a twentieth of the weight on, or from another part
    assert response([2.0, 3.0], [1.0, 6.0]).friction_demand() == pytest.approx([0.5])
    assert response([2.0, 3.0], [1.0, 6.0]).friction_demand(part=0.005) == pytest.approx([2.0])


def test_time_exceeded_is_that_of_the_line_between_rows() -> None:
    rises = response([0.0, 80.0, 80.0, 0.0], [100.0] * 4)
    # 0.8 at the crest: above 0.2 for three quarters of the slopes and all of the plateau
    assert rises.time_exceeded(0.2) == pytest.approx([0.5 * 0.75 + 0.5 + 0.5 * 0.75])
    assert rises.time_exceeded(0.8) == pytest.approx([0.0])
    assert rises.time_exceeded(0.0) == pytest.approx([1.5])
    assert response([50.0] * 3, [100.0] * 3).time_exceeded(0.5) == pytest.approx([0.0])


def test_a_column_that_stays_in_contact_asks_for_the_base_acceleration() -> None:
    # stiff against the motion: T = m a, N = m g in every joint, but for the first swing of 2 %
    given = simulate(phocas(1e-3), Motion.harmonic(0.002 * STANDARD_GRAVITY, 0.2, 10.0))
    assert given.friction_demand() == pytest.approx([0.002] * 3, rel=0.1)
    exceeded = given.time_exceeded(0.001)
    assert exceeded == pytest.approx([10.0 * 2.0 / 3.0] * 3, rel=0.02)  # a sine is above its half for two thirds
    assert np.all(given.time_exceeded(0.01) == 0.0)
    assert carried_weights(given.model) == pytest.approx(given.N[0])


def test_what_makes_no_sense_is_refused() -> None:
    with pytest.raises(InputError, match=r"^mu = -1"):
        response([1.0], [1.0]).time_exceeded(-1.0)
    with pytest.raises(InputError, match=r"^part = 0"):
        response([1.0], [1.0]).friction_demand(0.0)
    with pytest.raises(InputError, match=r"^g = 0\.0"):
        response([1.0], [1.0], g=0.0).friction_demand()
