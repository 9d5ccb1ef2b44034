"""Two blocks thrown at each other far above their base, at any orientation."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from solver.ground.motion import Motion
from solver.models.outputs import places_of
from solver.models.structure.blocks.faces import FloatArray
from solver.models.structure.model import Structure
from solver.models.structure.outputs import OUTPUTS
from solver.models.structure.run import SpatialState, begun
from solver.models.structure.stepper import SpatialStepper

STILL = Motion.from_samples(0.5, np.zeros(3))
BODIES: dict[str, dict[str, Any]] = {
    "box": {"width": 1.0, "depth": 1.5, "height": 2.0},
    "drum": {"shape": "drum", "diameter": 1.0, "height": 2.0},
    "tapered": {"width": 1.0, "top_width": 0.6, "depth": 1.2, "top_depth": 0.7, "height": 1.5},
    "prism": {"shape": "prism", "outline": [[-0.6, 0.0], [0.7, 0.0], [0.5, 0.9], [-0.2, 1.2]], "depth": 1.1},
    "cone": {"shape": "drum", "diameter": 1.2, "top_diameter": 0.8, "height": 1.4},
}
KINDS = [("box", "box"), ("drum", "box"), ("drum", "drum"), ("tapered", "prism"), ("cone", "drum"), ("prism", "box")]
HIGH = 10.0  # m


class Throw(NamedTuple):
    """Two blocks in flight."""

    stepper: SpatialStepper
    mass: float  # kg, of the heavier one

    def peak_hit(self) -> float:
        """Return the largest force so far between the two, N."""
        made = self.stepper.structure
        hits = self.stepper.state.peaks[places_of(OUTPUTS, made.sizes)["hit"]]
        return float(hits[made.contact_names.index("b0-b1") if "b0-b1" in made.contact_names else 0])


def pair_of(*shapes: dict[str, Any], tolerance: float = 1e-6, **law: Any) -> Structure:
    """Return two blocks far apart on a base without gravity, which meet undamped and go on whatever their tilt."""
    blocks = [
        {"name": f"b{k}", "on": "base", "at": [6.0 * k, 0.0], "density": 2000.0, **shape}
        for k, shape in enumerate(shapes)
    ]
    neighbours = {"line_stiffness": 1e8, "stiffness": 3e8, "damping": 0.0, "friction": 0.0} | law
    neighbours = {key: value for key, value in neighbours.items() if value is not None}
    joints = {"stiffness": 1e9, "damping": 0.0, "friction": 0.5}  # open from the start
    data = {"name": "thrown", "g": 0.0, "joints": joints, "neighbours": neighbours, "block": blocks}
    return Structure.from_dict({**data, "solver": {"tolerance": tolerance}}).going_on(1e3)


def row_of(stepper: SpatialStepper, name: str) -> FloatArray:
    """Return an output of the phase of a stepper."""
    stepper.observe()
    found: FloatArray = stepper.row[places_of(OUTPUTS, stepper.structure.sizes)[name]].copy()
    return found


def moved_to(made: Structure, places: Any, rotation: Any, velocity: Any, spin: Any) -> SpatialStepper:
    """Return a stepper with the centroids of the blocks at places, m; rotations rad, velocities m/s, spins rad/s."""
    built = np.array([block.centroid for block in made.blocks])
    parts = (np.asarray(part, dtype=np.float64) for part in (rotation, velocity, spin))
    return begun(made, STILL, SpatialState(np.asarray(places) - built, *parts))[0]


def two_at(
    small: dict[str, Any],
    large: dict[str, Any],
    at: Any,
    rotation: Any = (0.0, 0.0, 0.0),
    velocity: Any = (0.0, 0.0, 0.0),
    **law: Any,
) -> SpatialStepper:
    """Return a small body in contact with a large one, whose bottom is HIGH m up; `at`: of the centroid from there."""
    made = pair_of(small, large, stiffness=1e9, **law)
    places = np.array([at, made.blocks[1].centroid - [6.0, 0.0, 0.0]])
    places[:, 2] += HIGH
    stand = (0.0, 0.0, 0.0)
    stepper = moved_to(made, places, [rotation, stand], [velocity, stand], np.zeros((2, 3)))
    stepper.state.remembered.stretches.touches[0] = 2.0  # by the bodies
    return stepper


def thrown_at_random(seed: int, tolerance: float, **law: Any) -> Throw:
    """Return a throw of two bodies, whose kinds go by the seed, at random orientation, offset and spin."""
    rng = np.random.default_rng(seed)
    made = pair_of(*(BODIES[name] for name in KINDS[seed % len(KINDS)]), tolerance=tolerance, **law)
    axis = rng.normal(size=(2, 3))
    rotation = axis / np.linalg.norm(axis, axis=1, keepdims=True) * rng.uniform(0.0, np.pi, size=(2, 1))
    places = np.array([[0.0, 0.0, HIGH], [3.2, 0.0, HIGH]])
    places[1] += 0.35 * rng.normal(size=3)
    velocity = np.array([[0.8, 0.0, 0.0], [-0.8, 0.0, 0.0]]) + 0.1 * rng.normal(size=(2, 3))
    stepper = moved_to(made, places, rotation, velocity, 0.5 * rng.normal(size=(2, 3)))
    return Throw(stepper, max(block.mass for block in made.blocks))


def momenta(stepper: SpatialStepper) -> tuple[FloatArray, FloatArray]:
    """Return the momentum, N s, and angular momentum about the origin, N m s."""
    made, see = stepper.structure, stepper.see
    linear, angular = np.zeros(3), np.zeros(3)
    for i, block in enumerate(made.blocks):
        v = np.array([see.vx[i], see.vy[i], see.vz[i]])
        q0, q = see.q0[i], np.array([see.q1[i], see.q2[i], see.q3[i]])
        own = block.inertia @ np.array([see.wx[i], see.wy[i], see.wz[i]])
        across = np.cross(q, own)
        own = own + 2.0 * (q0 * across + np.cross(q, across))
        place = block.centroid + np.array([see.ux[i], see.uy[i], see.uz[i]])
        linear += block.mass * v
        angular += block.mass * np.cross(place, v) + own
    return linear, angular
