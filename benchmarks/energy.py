"""Energy of undamped columns that vibrate for very long with all joints in contact."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from solver import Column, InitialState, natural_frequencies
from solver.models.column.packing import settlements
from solver.models.column.stepper import Stepper

from .right_hand_side import Array
from .scenes import shaft

PERIODS = 1_000_000  # of the lowest mode
QUICK_PERIODS = 10_000
PER_CALL = 1_000  # periods: a call may take a limited number of evaluations
PARTS = (1e-3, 0.5)  # of the rotation at which a joint opens
SIZES = (1, 3)  # blocks


def columns_of(column: Column) -> Array:
    """Return the height, centroid, mass, inertia of the blocks, stiffness, width, depth of the joints, (7, n)."""
    return np.array(
        [
            (
                block.height,
                block.resolved_centroid,
                block.mass,
                block.resolved_inertia,
                block.joint.stiffness,
                block.joint_width,
                block.joint_depth,
            )
            for block in column.blocks
        ]
    ).T


def energy(stepper: Stepper, columns: Array) -> float:
    """Return the kinetic, elastic and gravitational, J; columns: those of `columns_of`."""
    height, centroid, mass, inertia, stiffness, width, depth = columns
    g, phase = stepper.model.settings.gravity, stepper.state.phase
    turn, opening, spin, opening_rate = phase.theta, phase.opening, phase.theta_rate, phase.opening_rate
    turn_below, spin_below = np.append(turn[1:], 0.0), np.append(spin[1:], 0.0)
    phi, phi_rate = 0.5 * (turn + turn_below), 0.5 * (spin + spin_below)
    over = height - centroid

    def from_base(steps: Array) -> Array:
        summed: Array = np.cumsum(steps[::-1])[::-1]
        return summed

    dip = -2.0 * np.sin(0.5 * turn) ** 2  # cos(turn) - 1
    rise = from_base(opening * np.cos(phi) + height * dip) - over * dip
    x_rate = from_base(
        opening_rate * np.sin(phi) + opening * phi_rate * np.cos(phi) + height * spin * np.cos(turn)
    ) - over * spin * np.cos(turn)
    z_rate = from_base(
        opening_rate * np.cos(phi) - opening * phi_rate * np.sin(phi) - height * spin * np.sin(turn)
    ) + over * spin * np.sin(turn)
    slope = 2.0 * np.sin(0.5 * (turn - turn_below))
    deepest, least = 0.5 * width * np.abs(slope) - opening, -0.5 * width * np.abs(slope) - opening
    with np.errstate(divide="ignore", invalid="ignore"):
        part = stiffness * depth * deepest**3 / (6.0 * np.abs(slope))
    full = 0.5 * stiffness * depth * width * (opening**2 + (slope * width) ** 2 / 12.0)
    joints = np.where(least >= 0.0, full, np.where(deepest > 0.0, part, 0.0))
    kinetic = 0.5 * (mass * (x_rate**2 + z_rate**2) + inertia * spin**2)
    return math.fsum([*kinetic, *(mass * g * rise), *joints])


def measure(quick: bool) -> Iterator[dict[str, Any]]:
    """Measure one row per column and amplitude: the relative change of the energy above that at rest."""
    periods = QUICK_PERIODS if quick else PERIODS
    for n in SIZES:
        column = shaft(n, damping=0.0)
        columns = columns_of(column)
        period = 1.0 / natural_frequencies(column)[0]
        opens = float(np.min(2.0 * settlements(column) / columns[5]))
        at_rest = energy(Stepper(column), columns)
        for part in PARTS:
            # only the base joint turns, by this part of the rotation that opens it
            stepper = Stepper(column, InitialState(rotation=np.full(n, part * opens)))
            begin = energy(stepper, columns) - at_rest
            for k in range(0, periods, PER_CALL):
                stepper.advance(k * period, min(PER_CALL, periods - k) * period)
            change = energy(stepper, columns) - at_rest - begin
            yield {
                "n": n,
                "part": part,
                "periods": periods,
                "drift": change / begin,
                "resolution": math.ulp(at_rest) / begin,
                "steps": int(stepper.counts.steps),
                "elastic_steps": int(stepper.counts.elastic_steps),
            }
