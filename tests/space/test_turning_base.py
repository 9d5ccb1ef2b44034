"""A base that turns under a structure: free flight seen from fixed axes, a slow tilt, a column in its plane."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from support.probe import G, phocas
from support.structures import stack

from solver.common.errors import SolverError
from solver.models.column.stepper import Stepper
from solver.models.outputs import places_of
from solver.models.structure.driven import Chosen, DrivenStructure, packed
from solver.models.structure.model import Structure
from solver.models.structure.outputs import OUTPUTS

Array = NDArray[np.float64]
Turn = Callable[[float], Array]  # (theta_x, theta_y, omega_x, omega_y, alpha_x, alpha_y) at a time
BOX = {"name": "box", "on": "base", "at": [0.4, 0.3], "width": 1.0, "depth": 1.5, "height": 2.0, "density": 2000.0}
PORT = {"name": "corner", "block": "box", "at": [0.5, -0.75, 1.0]}
BASE = np.array([1.0, -0.5, 0.3])  # m/s2
THROWN, SPIN = (
    np.array([0.3, -0.2, 4.0]),
    np.array([0.5, 0.4, -1.0]),
)  # m/s, rad/s, along turned axes


def evenly(t: float) -> Array:
    """Return held accelerations, which a communication step follows exactly."""
    theta = [0.3 + 0.4 * t + 0.05 * t * t, 0.1 - 0.2 * t + 0.15 * t * t]
    return np.array([*theta, 0.4 + 0.1 * t, -0.2 + 0.3 * t, 0.1, 0.3])


def swinging(t: float) -> Array:
    """Return a motion that it does not follow: each call corrects angle and rate of the base, beneath a block that
    stays.
    """
    s, c = np.sin([3.0 * t, 2.0 * t]), np.cos([3.0 * t, 2.0 * t])
    return np.concatenate([s * [0.1, 0.2], c * [0.3, 0.4], -s * [0.9, 0.8]])


def turned(turn: Turn, t: float) -> Rotation:
    return Rotation.from_rotvec([*turn(t)[:2], 0.0])


def flown(turn: Turn, stop: float) -> tuple[Array, Array, Rotation, Array]:
    """Return the centroid, its velocity, rotation and angular velocity of a free box, along fixed axes from the base's
    origin.
    """
    whole = turned(turn, 0.0)  # with all that stands on it, which has no rate yet
    place = whole.apply([0.4, 0.3, 1.0 + 2.0])
    velocity, falls = whole.apply(THROWN), -BASE - np.array([0.0, 0.0, G])
    inertia = np.array([1.5**2 + 2.0**2, 1.0 + 2.0**2, 1.0 + 1.5**2])

    def rates(_: float, y: Array) -> Array:
        w = y[4:]
        return np.concatenate(
            [
                [-0.5 * (y[1:4] @ w)],
                0.5 * (y[0] * w + np.cross(y[1:4], w)),
                -np.cross(w, inertia * w) / inertia,
            ]
        )

    begin = np.concatenate([np.roll(whole.as_quat(), 1), SPIN])
    end = solve_ivp(rates, (0.0, stop), begin, rtol=1e-12, atol=1e-13).y[:, -1]
    rotation = Rotation.from_quat(np.roll(end[:4], -1))
    return (
        place + stop * velocity + 0.5 * stop**2 * falls,
        velocity + stop * falls,
        rotation,
        rotation.apply(end[4:]),
    )


@pytest.mark.parametrize("turn", [evenly, swinging])
def test_a_free_block_flies_as_it_would_over_a_fixed_base(turn: Turn) -> None:
    """Check all forces of inertia, and what is seen of blocks and ports: of the base a free block feels nothing."""
    law = {"stiffness": 1e9, "damping": 1e-3, "friction": 0.5}
    structure = Structure.from_dict({"name": "thrown", "joints": law, "block": [BOX], "port": [PORT]})
    body = DrivenStructure(structure, packed(structure), Chosen(1e-10, turns=1.0))
    phase = body._state.phase
    phase.uz[0] = 2.0
    phase.vx[0], phase.vy[0], phase.vz[0] = THROWN
    phase.wx[0], phase.wy[0], phase.wz[0] = SPIN
    h, count = 0.05, 12
    for k in range(count):
        body.drive(k * h, *BASE, 0.0, 0.0, 0.0, *np.zeros(12), *turn(k * h))
        body.advance(k * h, h)
    row, places = body.observe(h * count), places_of(OUTPUTS, structure.sizes)
    place, velocity, rotation, spin = flown(turn, h * count)
    assert row[:3] == pytest.approx(place - [0.4, 0.3, 1.0], abs=1e-9)  # measured 6e-11
    assert row[3:6] == pytest.approx(rotation.as_rotvec(), abs=1e-9)
    arm = rotation.apply(PORT["at"])
    seen = np.array([row[places[f"port_{name}"]][0] for name in ("x", "y", "z", "vx", "vy", "vz")])
    assert seen[:3] == pytest.approx(place + arm - np.array([0.4, 0.3, 1.0]) - PORT["at"], abs=1e-9)
    assert seen[3:] == pytest.approx(velocity + np.cross(spin, arm), abs=1e-8)  # measured 4e-10


def test_blocks_that_rub_in_flight_feel_no_turn() -> None:
    """Compare two drums that press and slide on each other, and what friction remembers, with those over a base that
    rests.
    """
    law = {"stiffness": 1e9, "damping": 1e-3, "friction": 0.5}
    drum = {"shape": "drum", "diameter": 1.0, "height": 2.0, "density": 2000.0, "on": "base"}
    blocks = [{**drum, "name": f"d{k}", "at": [1.0 * k, 0.0]} for k in range(2)]
    rub = {"reach": 0.1, "line_stiffness": 1e7, "damping": 1e-3, "friction": 0.4}
    structure = Structure.from_dict({"name": "pair", "joints": law, "neighbours": rub, "block": blocks})
    model, rows = packed(structure), []
    for turns in (0.0, 1.0):
        body = DrivenStructure(structure, model, Chosen(1e-10, turns=1.0))
        phase = body._state.phase
        phase.uz[:] = 2.0
        phase.ux[:] = 5e-3, -5e-3
        phase.vy[:], phase.vz[:], phase.wz[:] = (0.4, -0.3), (1.0, 1.3), (0.5, -0.2)
        seen = []
        for k in range(20):
            theta = turns * (k > 0) * np.array([0.3 * np.sin(0.4 * k), 0.2 * np.sin(0.3 * k)])  # held: by jumps
            body.drive(5e-3 * k, *np.zeros(6), *theta)
            body.advance(5e-3 * k, 5e-3)
            seen.append(body.observe(5e-3 * (k + 1))[:12].copy())
        rows.append(np.array(seen))
    turned_by = np.max(np.abs(rows[0][-1] - rows[0][0]))
    assert turned_by > 0.01
    assert np.max(np.abs(rows[0] - rows[1])) < 1e-8  # measured 1e-10


def test_a_slow_tilt_is_weight_beside_its_middle() -> None:
    """Compare force and couple on the base along fixed axes with those of the weight where the centroids are."""
    structure = Structure.from_dict({"name": "tilted", "joints": {"stiffness": 1e9, "damping": 2e-2}, "block": [BOX]})
    body = DrivenStructure(structure, packed(structure), Chosen(1e-9, turns=1.0))
    theta = np.array([0.03, -0.05])
    body.drive(0.0, *np.zeros(6), *theta)
    for k in range(20):
        body.advance(0.1 * k, 0.1)
    row, weight = body.observe(2.0), structure.blocks[0].mass * G
    base = row[places_of(OUTPUTS, structure.sizes)["base"]]
    centre = row[:3] + np.array([0.4, 0.3, 1.0])
    assert base[:3] == pytest.approx([0.0, 0.0, -weight], abs=1e-6 * weight)  # measured 2e-9
    assert base[3:] == pytest.approx(np.cross(centre, [0.0, 0.0, -weight]), abs=1e-6 * weight)
    tilt = Rotation.from_rotvec([*theta, 0.0]).apply([0.4, 0.3, 1.0]) - [0.4, 0.3, 1.0]
    assert row[:2] == pytest.approx(tilt[:2], abs=2e-4)  # and what the joint gives


def test_it_is_a_column_that_turns_in_its_plane() -> None:
    """Compare a stack whose joints are ever stiffer along themselves: the limit is the column, whose joints are rigid
    there.
    """
    h, count = 2e-3, 200
    time = h * np.arange(count + 1, dtype=np.float64)
    theta, omega, alpha = 1e-3 * (1.0 - np.cos(7.0 * time)), 7e-3 * np.sin(7.0 * time), 49e-3 * np.cos(7.0 * time)
    ax = 0.3 * np.sin(9.0 * time)
    column = Stepper(phocas(eta=1e-3).with_settings(tolerance=1e-10))
    found, none = [], np.zeros(3)
    for k in range(count):
        column.drive(time[k], ax[k], 0.0, 0.0, 0.0, theta[k], omega[k], alpha[k])
        column.advance(time[k], h)
        found.append(column.observe(time[k + 1])[: 3 * 3].reshape(3, 3)[-1].copy())
    rotations = []
    for ratio in (20.0, 40.0):
        structure = stack(ratio=ratio)
        body = DrivenStructure(structure, packed(structure), Chosen(1e-10, turns=1.0))
        places, rows = places_of(OUTPUTS, structure.sizes), []
        for k in range(count):
            about_y = 0.0, theta[k], 0.0, omega[k], 0.0, alpha[k]
            body.drive(time[k], ax[k], 0.0, 0.0, *none, *about_y)
            body.advance(time[k], h)
            rows.append(body.observe(time[k + 1])[places["ry"]][::-1].copy())  # the column's first block is the top
        rotations.append(np.array(rows))
    limit, size = 2.0 * rotations[1] - rotations[0], np.max(np.abs(found))
    assert np.max(np.abs(rotations[1] - np.array(found))) < 1e-4 * size  # measured 5.4e-5, 2.7e-5
    assert np.max(np.abs(limit - np.array(found))) < 1e-7 * size  # measured 9e-9


def test_turns_have_bounds() -> None:
    structure = stack(1)
    body = DrivenStructure(structure, packed(structure), Chosen(1e-6, turns=1.0))
    body.drive(0.0, *np.zeros(6), 0.0, 3.1, 0.0, 0.0, 0.0, 0.0)
    with pytest.raises(SolverError, match="rotation than 3 rad"):
        body.advance(0.0, 0.01)
