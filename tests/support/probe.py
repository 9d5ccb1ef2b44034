"""Helpers shared by tests: columns, random columns, random states, and the kernels' results for a state."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from solver import Block, Column, Joint, Settings
from solver.kernels.layout import spaces as at
from solver.models.column.stepper import Stepper

Array = NDArray[np.float64]

G = 9.80665  # m/s2
PHOCAS_STIFFNESS = 533 * 9.80665e6  # N/m3


def phocas(eta: float = 0.0, **settings: str | float | tuple[str, ...]) -> Column:
    """Return the Column of Phocas (theory.md section 5), joints damped by eta s."""
    block = Block(4.69, 1.56, 1.56, 27000.0, Joint(PHOCAS_STIFFNESS, eta))
    return Column("phocas", (block,) * 3, Settings(**settings))  # type: ignore[arg-type]


def monolith(
    stiffness: float = PHOCAS_STIFFNESS, eta: float = 0.0, **settings: str | float | tuple[str, ...]
) -> Column:
    """Return the Column of Phocas as one rigid block (theory.md section 5)."""
    block = Block(14.07, 1.56, 1.56, 81000.0, Joint(stiffness, eta))
    return Column("monolith", (block,), Settings(**settings))  # type: ignore[arg-type]


def random_column(
    rng: np.random.Generator, n: int, formulation: str = "exact", damped: bool = True, softest: float = 1e6
) -> Column:
    """Return a column of unlike blocks, centroids off the middle, joints narrower than both, from `softest` N/m3 up."""
    blocks = []
    for _ in range(n):
        height, width, depth = rng.uniform(0.5, 5.0), rng.uniform(0.3, 3.0), rng.uniform(0.3, 3.0)
        mass = 2000.0 * height * width * depth * rng.uniform(0.5, 2.0)
        joint = Joint(
            10.0 ** rng.uniform(np.log10(softest), 9.5),
            10.0 ** rng.uniform(-4.0, -1.5) if damped else 0.0,
            width * rng.uniform(0.5, 1.0),
            depth * rng.uniform(0.5, 1.0),
        )
        inertia = mass * (height**2 + width**2) / 12.0 * rng.uniform(0.5, 1.5)
        blocks.append(Block(height, width, depth, mass, joint, height * rng.uniform(0.2, 0.8), inertia))
    for k, (block, below) in enumerate(pairwise(blocks)):
        width, depth = min(block.joint_width, below.width), min(block.joint_depth, below.depth)
        blocks[k] = replace(block, joint=replace(block.joint, width=width, depth=depth))
    return Column("random", tuple(blocks), Settings(formulation=formulation, step=1e-8), g=rng.uniform(1.0, 15.0))


def settled(column: Column) -> Array:
    """Return the compression of the joints at rest, m (n,)."""
    masses = np.array([block.mass for block in column.blocks])
    springs = [block.joint.stiffness * block.joint_width * block.joint_depth for block in column.blocks]
    result: Array = column.g * np.cumsum(masses) / np.array(springs)
    return result


def random_state(rng: np.random.Generator, column: Column, largest: float) -> tuple[Array, Array]:
    """Return (q, rates) of the exact formulation: joints in all regimes, turned by up to `largest` rad, moving
    anywhere.
    """
    n = column.n
    width = np.array([block.joint_width for block in column.blocks])
    depth = settled(column)
    opens = np.where(rng.random(n) < 0.5, largest, np.minimum(largest, 2.0 * depth / width))
    turn = rng.uniform(-1.0, 1.0, n) * opens  # of each joint
    pressed = rng.uniform(-0.5, 3.0, n) * depth  # below zero the joint is open
    delta = np.where(rng.random(n) < 0.5, width * np.abs(np.sin(0.5 * turn)), 0.0) - pressed
    spin = rng.normal(size=n) * np.sqrt(column.g / np.array([block.height for block in column.blocks]))
    return (
        np.concatenate([np.cumsum(turn[::-1])[::-1], delta]),
        np.concatenate([spin, rng.normal(size=n) * np.sqrt(column.g * depth)]),
    )


def sliding_state(rng: np.random.Generator, column: Column, largest: float) -> tuple[Array, Array, Array]:
    """Return (q, rates, directions): joints moved by up to a fifth of their width, most of them sliding."""
    n = column.n
    q, rate = random_state(rng, column, largest)
    offset = np.array([block.joint.offset or 0.0 for block in column.blocks])
    width = np.array([block.joint_width for block in column.blocks])
    slip = rng.uniform(-0.2, 0.2, n) * width + offset
    direction = rng.choice([-1.0, 0.0, 1.0], n, p=[0.4, 0.2, 0.4])
    direction[[block.joint.friction is None for block in column.blocks]] = 0.0
    speed = direction * rng.uniform(0.01, 1.0, n)
    # openings that the middle of the contact feels are those of the random state
    theta = q[:n]
    turned = theta - np.concatenate([theta[1:], [0.0]])
    q[n:] += slip * np.sin(0.5 * turned)
    return np.concatenate([q, slip]), np.concatenate([rate, speed]), direction


def coordinates(stepper: Stepper) -> Array:
    """Return the coordinates and rates of a column, (4n,): writing to them takes effect."""
    return stepper.arrays.state[at.CONTROL.beside :][: 4 * stepper.n]


def forced(stepper: Stepper, amplitude: float, frequency: float) -> Stepper:
    """Return the stepper on a base that accelerates by amplitude m/s2 at frequency Hz."""
    stepper.base.wave_amplitude, stepper.base.wave_omega = amplitude, 2.0 * np.pi * frequency
    return stepper


def walk(stepper: Stepper, times: Array) -> Array:
    """Return the coordinates and rates (4n,) after a call from each time, s, to the next."""
    for begin, end in pairwise(times):
        stepper.advance(begin, end - begin)
    return coordinates(stepper).copy()


def put_back(kept: Stepper, into: Stepper) -> None:
    """Copy the state of one stepper to another: it is in these three arrays."""
    for name in ("state", "counts", "base"):
        getattr(into.arrays, name)[:] = getattr(kept.arrays, name)


def observed_accelerations(stepper: Stepper) -> Array:
    """Return the accelerations of the coordinates at the last observation of the stepper, (2n,)."""
    between = at.WORK.see(stepper.arrays.work, stepper.n).between
    return np.concatenate([between.theta_acceleration, between.opening_acceleration])


def look(column: Column, q: Array, rate: Array, ax: float = 0.0, az: float = 0.0) -> tuple[Array, Array]:
    """Return (accelerations (2n,), output row) of a state whose coordinates are those of the column's formulation."""
    stepper = Stepper(column)
    coordinates(stepper)[:] = np.concatenate([q, rate])
    stepper.drive(0.0, ax=ax, az=az)
    row = stepper.observe(0.0).copy()
    return observed_accelerations(stepper), row


def field(row: Array, name: str, n: int) -> Array:
    """Return one field of an output row, (n,)."""
    found: Array = getattr(at.ROW.see(row, n).joints, name)
    return found


def reaction(row: Array, name: str) -> float:
    """Return one component of the base reaction of an output row."""
    return float(getattr(at.REACTION.see(row[-at.REACTION.beside :]), name))


def with_gravity(column: Column, g: float) -> Column:
    return replace(column, g=g)
