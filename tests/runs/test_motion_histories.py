"""Velocities, energies and openings of responses, of columns and of structures: against work, differences, geometry."""

import pickle
from typing import Any

import numpy as np
import pytest

from multiblock import Block, Column, InitialState, Joint, Motion, Structure, simulate, wavelets
from solver.models.structure.run import SpatialState

G = 9.80665
QUIET = Motion.from_samples(0.01, np.zeros(41))
HEIGHT, WIDTH = 1.5, 0.6
PULSE = wavelets.ricker(0.5 * G, 1.2)


def column(damping: float, count: int = 1) -> Column:
    block = Block(HEIGHT, WIDTH, 0.8, 2000.0, Joint(stiffness=1e10, damping=damping))
    return Column("blocks", (block,) * count)


@pytest.mark.parametrize("in_space", [False, True])
def test_an_undamped_block_keeps_its_energy_and_a_damped_one_loses_some(in_space: bool) -> None:
    """Let go 0.1 rad aside. Measured: kept to 5e-9 of it, in space 1e-10."""
    response: Any
    for damping in (0.0, 2e-4):
        model = column(damping)
        if in_space:
            turn = np.array([[0.0, 0.1, 0.0]])
            moved = np.array([[0.5 * HEIGHT * np.sin(0.1), 0.0, 0.5 * HEIGHT * (np.cos(0.1) - 1.0) + 0.03]])
            aside = SpatialState(moved, turn, 0.0 * turn, 0.0 * turn)
            response = simulate(model.in_space(), QUIET, initial=aside, settle=0.0, tolerance=1e-7)
        else:
            zero = np.zeros(1)
            initial = InitialState(zero + 0.1, zero, zero + 0.03, zero)
            response = simulate(model, QUIET, initial=initial, settle=0.0, tolerance=1e-7)
        drift = np.diff(response.energy)
        largest = float(response.energy[0])
        assert largest > 100.0
        if damping:
            assert response.energy[-1] < 0.99 * largest
            assert np.max(drift) < 1e-6 * largest
        else:
            np.testing.assert_allclose(response.energy, largest, rtol=2e-8)


@pytest.mark.parametrize("in_space", [False, True])
def test_velocity_is_the_rate_of_the_displacement(in_space: bool) -> None:
    """Compare with central differences over 0.2 ms. Measured: 1.4e-3 of the largest velocity, where blocks land."""
    model = column(2e-4, 2)
    response: Any = simulate(model.in_space() if in_space else model, PULSE, output_step=2e-4, settle=0.0)
    places = np.stack([response.ux, response.uy, response.uz], axis=-1) if in_space else response.ux
    rates = response.velocity if in_space else response.top_vx
    apart = np.gradient(places, response.time, axis=0) - rates
    assert np.max(np.abs(apart[1:-1])) < 5e-3 * np.max(np.abs(rates))


def test_the_column_and_the_structure_that_it_is_say_the_same() -> None:
    """Compare a block that rocks; in space it is elastic along its joint too. Measured: 2e-4 of the largest."""
    planar = simulate(column(2e-4), PULSE, settle=0.0, tolerance=1e-6)
    spatial = simulate(column(2e-4).in_space(), PULSE, settle=0.0, tolerance=1e-6)
    for name in ("energy", "opening"):
        one, other = (getattr(response, name)[: len(planar.time) // 2] for response in (planar, spatial))
        assert one.shape == other.shape
        np.testing.assert_allclose(other, one, atol=0.01 * np.max(one))


@pytest.mark.parametrize("in_space", [False, True])
def test_a_joint_opens_where_its_contact_ends(in_space: bool) -> None:
    """Compare with the gap at the edge of a joint turned by theta over which the part c of its width is in contact.

    Measured: within 0.5 mm of 31 mm, since dampers take part in where the pressure ends.
    """
    model = column(2e-4)
    response: Any = simulate(model.in_space() if in_space else model, PULSE, settle=0.0)
    turn = response.ry
    expected = (1.0 - response.contact) * WIDTH * np.abs(np.sin(turn))
    assert np.max(expected) > 0.02
    np.testing.assert_allclose(response.opening, np.where(response.contact < 1.0, expected, 0.0), atol=1e-3)


def test_a_response_that_was_pickled_has_them_too() -> None:
    for model in (column(2e-4, 2), Structure.from_dict(column(2e-4, 2).in_space().to_dict())):
        response = simulate(model, PULSE, settle=0.0)
        copy = pickle.loads(pickle.dumps(response))
        for name in ("energy", "velocity" if isinstance(model, Structure) else "top_vx", "opening"):
            np.testing.assert_array_equal(getattr(copy, name), getattr(response, name))
