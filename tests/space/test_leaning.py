"""Verdicts on blocks that lean on what stands beside them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from solver import simulate
from solver.ground.motion import Motion
from solver.models.structure.model import Structure
from solver.models.structure.response import SpatialResponse
from solver.models.structure.run import SpatialState

RADIUS, HEIGHT, GAP = 0.25, 3.0, 0.6
STILL = Motion.from_samples(0.5, np.zeros(3))
POST = {"name": "post", "on": "base", "at": [0.0, 0.0], "shape": "drum", "diameter": 2.0 * RADIUS, "density": 2500.0}
BLOCK = {"name": "block", "on": "base", "width": 2.0, "depth": 4.0, "height": 2.5, "density": 2500.0}
WALL = {"at": [RADIUS + GAP, 0.0, 0.0], "normal": [-1.0, 0.0], "width": 4.0, "height": 2.5}


def tipped(beside: dict[str, Any], tilt: float, **law: Any) -> SpatialResponse:
    """Return a post tipped about its rim, beyond its edge, and let go."""
    neighbours = {"reach": 1.0, "line_stiffness": 1e8, "restitution": 0.02, "friction": 0.5} | law
    blocks = [{**POST, "height": HEIGHT}, *([{**BLOCK, **beside}] if beside else [])]
    joints = {"stiffness": 1e9, "damping": 2e-3, "friction": 0.8}
    made = Structure.from_dict({"name": "leaning", "joints": joints, "neighbours": neighbours, "block": blocks})
    none = np.zeros((made.n, 3))
    place, turn = none.copy(), none.copy()
    x, z = -RADIUS, 0.5 * HEIGHT  # of the centroid from the rim
    turn[0, 1] = tilt
    place[0] = [x * math.cos(tilt) + z * math.sin(tilt) - x, 0.0, z * math.cos(tilt) - x * math.sin(tilt) - z]
    return simulate(made, STILL, initial=SpatialState(place, turn, none, none))


@pytest.mark.parametrize("by_wall", [False, True], ids=["a block", "a wall"])
def test_a_block_that_leans_on_its_neighbour_has_not_fallen(by_wall: bool) -> None:
    beside = {} if by_wall else {"at": [RADIUS + GAP + 1.0, 0.0]}
    response = tipped(beside, 0.22, **({"wall": [WALL]} if by_wall else {}))
    assert response.verdict == "standing"
    against = "wall 1" if by_wall else "block"
    assert response.reason == f"it has come to rest: post rests against {against}"
    assert 0.0 < response.stats["settled_for"] < 10.0  # measured 1.4: not followed to the end


def test_a_block_that_falls_short_of_its_neighbour_stays_fallen() -> None:
    response = tipped({"at": [4.5, 0.0]}, 0.22, reach=5.0)
    assert response.verdict == "overturned"
    assert response.reason.startswith("block post, ")
    assert response.peaks["hit"][0] == 0.0


def test_a_block_that_touches_upright_says_nothing_of_its_neighbour() -> None:
    """Check that it stands by its own: it is at rest, and is not pressed."""
    response = tipped({"at": [RADIUS + GAP + 1.0, 0.0]}, 0.0)
    assert response.verdict == "standing"
    assert "rests against" not in response.reason
