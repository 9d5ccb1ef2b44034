"""Assertions on energy barriers: of many columns at once against each alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from solver import Column, Motion
from solver.dynamics.kinematics import Chain
from solver.dynamics.verdict import GRAZED, SHARES, Barriers, barrier, is_held, least_energies
from solver.runs.batch import run_batch
from support.probe import Array, random_state


def models_of(columns: Sequence[Column]) -> Array:
    """Packed models, a row for each column."""
    return run_batch(columns, [Motion.harmonic(0.0, 1.0, 1e-6)] * len(columns)).models


def assert_the_quick_bound_is_below_the_barrier(columns: Sequence[Column], rng: np.random.Generator) -> None:
    """Energies of many columns are also those of each."""
    n = columns[0].n
    chain = Chain.of_many(models_of(columns), n)
    bounds = [least_energies(chain, part, grazed)[0] for part in SHARES for grazed in GRAZED]
    assert np.any(np.max(bounds, axis=0) > 0.0)
    assert np.all(np.max(bounds, axis=0) < [barrier(column).energy for column in columns])  # measured: at most 0.99
    states = [np.concatenate(random_state(rng, column, 1e-3)) for column in columns]
    energies = chain.energies(np.array(states))
    assert energies == pytest.approx([Chain(c).energy(x) for c, x in zip(columns, states, strict=True)], rel=1e-9)


def assert_what_is_held_is_what_is_held_of_each(columns: Sequence[Column], rng: np.random.Generator) -> None:
    """Whichever are evaluated together, and with up to four times the energy of the barrier."""
    n, models = columns[0].n, models_of(columns)
    energy = np.array([barrier(column).energy for column in columns]) * rng.uniform(0.0, 4.0, len(columns)) ** 2
    turned = rng.uniform(0.0, 0.1, (len(columns), n))
    wanted = [is_held(column, e, t) for column, e, t in zip(columns, energy.tolist(), turned, strict=True)]
    barriers = Barriers(Chain.of_many(models, n))
    some = rng.permutation(len(columns))
    for part in (some[:5], some):
        assert barriers.hold(part, energy[part], turned[part]).tolist() == [wanted[k] for k in part]
    assert 0 < sum(wanted) < len(wanted)
