"""What several tests share: columns, random ones, random states, and what the kernels compute for a state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from solver import Block, Column, Joint, Settings
from solver.kernels import layout as at
from solver.stepper import Stepper

Array = NDArray[np.float64]

G = 9.80665  # m/s2
PHOCAS_STIFFNESS = 533 * 9.80665e6  # N/m3


def phocas(eta: float = 0.0, **settings: str | float | tuple[str, ...]) -> Column:
    """The Column of Phocas (theory.md section 5), joints damped by eta s."""
    block = Block(4.69, 1.56, 1.56, 27000.0, Joint(PHOCAS_STIFFNESS, eta))
    return Column("phocas", (block,) * 3, Settings(**settings))  # type: ignore[arg-type]


def monolith(
    stiffness: float = PHOCAS_STIFFNESS, eta: float = 0.0, **settings: str | float | tuple[str, ...]
) -> Column:
    """The Column of Phocas as one rigid block (theory.md section 5)."""
    block = Block(14.07, 1.56, 1.56, 81000.0, Joint(stiffness, eta))
    return Column("monolith", (block,), Settings(**settings))  # type: ignore[arg-type]


def random_column(
    rng: np.random.Generator, n: int, formulation: str = "exact", damped: bool = True, softest: float = 1e6
) -> Column:
    """No two blocks alike, centroids off the middle, joints narrower than the blocks and from `softest` N/m3 up."""
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
    return Column("random", tuple(blocks), Settings(formulation=formulation), g=rng.uniform(1.0, 15.0))


def settled(column: Column) -> Array:
    """Compression of the joints at rest, m (n,)."""
    masses = np.array([block.mass for block in column.blocks])
    springs = [block.joint.stiffness * block.joint_width * block.joint_depth for block in column.blocks]
    result: Array = column.g * np.cumsum(masses) / np.array(springs)
    return result


def random_state(rng: np.random.Generator, column: Column, largest: float) -> tuple[Array, Array]:
    """(q, rates) of the exact formulation: joints in all regimes, turned by up to `largest` rad, moving anywhere."""
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


def look(column: Column, q: Array, rate: Array, ax: float = 0.0, az: float = 0.0) -> tuple[Array, Array]:
    """(accelerations (2n,), output row) of a state whose coordinates are those of the column's formulation."""
    n = column.n
    stepper = Stepper(column)
    stepper.state[at.STATE_HEADER : at.STATE_HEADER + 4 * n] = np.concatenate([q, rate])
    stepper.inputs[[at.INPUT_AX, at.INPUT_AZ]] = ax, az
    row = stepper.observe(0.0).copy()
    between = 6 * n * at.PHASE_BETWEEN
    return stepper._work[between + 4 * n : between + 6 * n].copy(), row


def field(row: Array, name: int, n: int) -> Array:
    """One field of an output row, (n,)."""
    return row[name * n : (name + 1) * n]


def tail(row: Array, name: int) -> float:
    """One of the base reactions of an output row."""
    return float(row[len(row) - at.ROW_TAIL + name])


def with_gravity(column: Column, g: float) -> Column:
    return replace(column, g=g)
