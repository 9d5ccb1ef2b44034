"""The distance of blocks as built whose corners or edges are nearest, and gaps declared for them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from solver import Motion, simulate
from solver.models.structure.blocks.faces import FloatArray
from solver.models.structure.blocks.parts import Solid
from solver.models.structure.blocks.shapes import box, drum, placed, rotation_matrix
from solver.models.structure.convex import apart, distance, hulls_of
from solver.models.structure.model import Structure

GAP = 0.03  # m
STILL = Motion.from_samples(0.01, [0.0] * 4)
CUBE: dict[str, Any] = {"width": 1.0, "depth": 1.0, "height": 1.0, "density": 2000.0}
WALL, TAPER = {**CUBE, "width": 5.0}, {**CUBE, "top_width": 0.5, "top_depth": 0.4}


def gaps(one: dict[str, Any], other: dict[str, Any], declared: float | None = GAP) -> tuple[float, float]:
    """Return the gap of two blocks that the file says, and that in the first row of a run, m."""
    own = {} if declared is None else {"gap": declared}
    law = {"stiffness": 1e9, "line_stiffness": 1e8, "damping": 1e-3, "friction": 0.3}
    data = {
        "name": "two",
        "joints": {"stiffness": 1e11, "damping": 1e-4},
        "joint": [{"between": [name, "base"]} for name in "ab"],
        "neighbours": {**law, "pair": [{"between": ["a", "b"], **own}]},
        "block": [{"name": "a", **one}, {"name": "b", **other}],
    }
    structure = Structure.from_dict(data)
    run = simulate(structure, STILL, settle=0.0)
    return structure.neighbours[0].gap, float(run.gap[0, 0])


def at(shape: dict[str, Any], x: float, y: float, yaw: float = 0.0) -> dict[str, Any]:
    return {**shape, "position": [x, y, 0.0], "rotation": [0.0, 0.0, yaw]}


def test_the_declared_gap_of_cubes_at_any_yaw_is_that_of_the_run() -> None:
    """Check 60 pairs: along the axes that may separate them many are nearer (measured here: 4e-16 m)."""
    rng = np.random.default_rng(2)
    for _ in range(60):
        angle, away = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(1.5, 2.5)
        pair = at(CUBE, 0.0, 0.0, rng.uniform(-3.0, 3.0)), at(CUBE, away * math.cos(angle), away * math.sin(angle), 0.4)
        assert gaps(*pair) == pytest.approx((GAP, GAP), abs=1e-12)


@pytest.mark.parametrize(
    ("pair", "built"),
    [
        ((at(WALL, 0.0, 0.0), at(CUBE, 3.5, 1.5)), math.hypot(0.5, 0.5)),  # diagonal: edge before edge
        ((at(CUBE, 0.0, 0.0), at(CUBE, 1.1, 1.2)), math.hypot(0.1, 0.2)),
        ((at(TAPER, 0.0, 0.0), at(TAPER, 1.1, 1.2)), math.hypot(0.1, 0.2)),  # corner before corner
        ((at(TAPER, 0.0, 0.0), at(CUBE, 1.5, 0.0)), 0.5),  # edge before a face
    ],
)
def test_gaps_of_diagonal_neighbours(pair: tuple[dict[str, Any], dict[str, Any]], built: float) -> None:
    assert gaps(*pair, None) == pytest.approx((built, built), abs=1e-12)
    assert gaps(*pair) == pytest.approx((GAP, GAP), abs=1e-12)


def test_a_rim_before_an_edge_on_its_level_is_as_far_as_along_its_normal() -> None:
    """Check to the last bit: the corners of the edge and those below them are equally far along the normal."""
    lower = box("b", (1.9, 1.9), (1.9, 1.9), 0.2, 1.0)
    upper = placed(drum("a", 1.6, 1.6, 0.0, 4.5, 1.0), np.array([1.9, 0.0, 0.2]), np.eye(3))
    (a,), (b,), between = hulls_of(upper), hulls_of(lower), lower.centroid - upper.centroid
    found, vector = apart(a, b, between)
    assert vector is None
    assert found == pytest.approx(0.15, abs=1e-15)


def nearest_by_slsqp(one: Solid, other: Solid, begin: FloatArray) -> float:
    """Return the distance of two solids by minimization over a point in each, m.

    A point of a box is bounded by its faces, one of a drum by its ends and radius.
    """

    def inside(solid: Solid, x: FloatArray) -> FloatArray:
        place = solid.axes.T @ (x - solid.centroid)
        half = np.ptp((solid.corners - solid.centroid) @ solid.axes, axis=0) / 2.0
        if solid.faces[0].radius:
            return np.array([half[2] - place[2], half[2] + place[2], half[0] ** 2 - place[0] ** 2 - place[1] ** 2])
        return np.concatenate([half - place, half + place])

    conditions = [
        {"type": "ineq", "fun": lambda x: inside(one, x[:3])},
        {"type": "ineq", "fun": lambda x: inside(other, x[3:])},
    ]
    found = minimize(
        lambda x: float((x[3:] - x[:3]) @ (x[3:] - x[:3])),
        np.concatenate([one.centroid, other.centroid]) + begin,
        constraints=conditions,
        options={"ftol": 1e-15, "maxiter": 500},
    )
    return math.sqrt(found.fun)


@pytest.mark.parametrize("seed", range(40))
def test_nearest_points_against_minimization(seed: int) -> None:
    """Check boxes and drums at any orientation (measured: 5e-10), and the vector by what it separates."""
    rng = np.random.default_rng(seed)
    solids = []
    for k in range(2):
        w, d, h = rng.uniform(0.3, 1.2, 3)
        made = drum("b", w, w, 0.0, h, 1.0) if rng.uniform() < 0.4 else box("b", (w, d), (w, d), h, 1.0)
        solids.append(placed(made, k * rng.uniform(1.1, 1.6, 3), rotation_matrix(rng.normal(0.0, 2.0, 3))))
    one, other = solids
    (a,), (b,), between = hulls_of(one), hulls_of(other), other.centroid - one.centroid
    found, vector = apart(a, b, between)
    assert found > 0.0
    assert found == pytest.approx(nearest_by_slsqp(one, other, rng.normal(0.0, 1e-3, 6)), abs=1e-8)
    still = np.zeros((1, 3))
    along = float(distance(a, b, still, still, between[None])[0])
    if vector is None:
        assert found == along  # of faces, to the last bit
        return
    assert along < found
    unit = vector / np.linalg.norm(vector)
    away = float(unit @ (between + b.support(-unit) - a.support(unit)))  # no less than this
    assert found - away <= (1e-10 if a.rims or b.rims else 1e-12)  # measured: 1e-13, 2e-16
