"""An object on the floor of a building, exchanged once a step, against the floor that it does not act on."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from support.probe import G

from multiblock import Building, Motion, Structure, floor_motion, simulate
from solver.ground.wavelets import ricker
from solver.kernels.layout.spaces import HORIZONTAL, SLOPE_PARABOLA
from solver.models.outputs import places_of
from solver.models.structure.driven import Chosen, DrivenStructure, packed
from solver.models.structure.outputs import OUTPUTS

Array = NDArray[np.float64]
BLOCK = {"name": "statue", "on": "base", "width": 0.5, "depth": 0.5, "height": 1.5, "density": 2500.0}
STATUE = Structure.from_dict(
    {"name": "statue", "joints": {"stiffness": 1e9, "damping": 2e-3, "friction": 0.7}, "block": [BLOCK]}
)
PERIOD, DAMPING = 0.5, 0.05  # s, of critical, of a building of one storey
H, COUNT = 1e-3, 3000  # s; steps
PULSE_AT = (ricker(0.3 * G, 1.0).time, ricker(0.3 * G, 1.0).ax)
GROUND: Array = np.interp(H * np.arange(COUNT + 1), *PULSE_AT)


def on_the_floor() -> Array:
    """Return the displacement of the statue relative to a floor on which it does not act, m."""
    mode = {"period": PERIOD, "damping": DAMPING, "x": [1.0]}
    building = Building.from_dict({"building": {"mode": [mode]}})
    motion = floor_motion(Motion.from_samples(H, GROUND), building, 1)
    found = simulate(STATUE, motion, COUNT * H, output_step=H, settle=0.0, tolerance=1e-8)
    moved: Array = found.ux[:, 0]
    return moved


def with_the_floor(ratio: float) -> Array:
    """Return the displacement relative to a floor that it acts on; ratio: its mass over that of the floor."""
    body = DrivenStructure(STATUE, packed(STATUE), Chosen(1e-8, drive=HORIZONTAL, slope=SLOPE_PARABOLA))
    places, omega = places_of(OUTPUTS, STATUE.sizes), 2.0 * math.pi / PERIOD
    mass, u, v = STATUE.blocks[0].mass / ratio, 0.0, 0.0
    before: list[float] = []
    rows = np.zeros(COUNT + 1)
    for k, ground in enumerate(GROUND.tolist()):
        row = body.observe(k * H)
        rows[k], reaction = row[places["ux"]][0], row[places["base"]][0]
        force = -mass * (omega * omega * u + 2.0 * DAMPING * omega * v)
        body.drive(k * H, *[0.0] * 6, force, 0.0, 0.0, mass)
        body.advance(k * H, H)
        # the floor relative to the ground, by the parabola that the statue takes too
        a = (force + reaction) / mass - ground
        slope = (a - before[-1]) / H if before else 0.0
        if len(before) > 1:
            slope = (11.0 * slope - 5.0 * (before[-1] - before[-2]) / H) / 6.0
        before.append(a)
        u, v = u + H * v + 0.5 * H * H * a + H**3 / 6.0 * slope, v + H * a + 0.5 * H * H * slope
    return rows


def test_a_light_object_moves_as_on_a_floor_that_it_does_not_move_and_a_heavy_one_does_not() -> None:
    one_way = on_the_floor()
    size = float(np.max(np.abs(one_way)))
    apart = [float(np.max(np.abs(with_the_floor(ratio) - one_way))) / size for ratio in (1e-6, 1e-2, 0.1, 1.0)]
    assert size > 0.1  # m: it rocks, and rises again
    assert apart[0] <= 1e-4  # measured 2.3e-5
    # measured 0.0094, 0.094, 0.83
    assert 0.005 < apart[1] < 0.02
    assert 0.05 < apart[2] < 0.2
    assert apart[3] > 0.5
