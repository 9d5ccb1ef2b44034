"""Whether a column whose joints may slide, or that is off its axis, has come to rest for good.

What slides changes what can fall, so that the energy alone says nothing (verdict.py). But a column that sticks, with
little energy left, swings about its rest in full contact, and this is linear: the energy bounds the moments, the normal
forces and, by the highest frequency, the accelerations and so the forces along the joints. Where these are borne with
half of it to spare, no joint opens or slides any more, and the column stands. A column off its axis with rigid joints
stands as soon as its energy above rest opens no joint.
"""

from __future__ import annotations

import numpy as np

from .chain import Chain
from .column import Column
from .kernels import layout as at
from .packing import FloatArray

SAFE = 0.5  # of what a joint bears along itself; of the energy that opens one
SOFTENED = 0.5  # of the stiffness against rotation that gravity may take away at most


def sticks_for_good(column: Column, phase: FloatArray) -> bool:
    """Whether no joint of a column with this phase (chain.py) slides or opens ever again upon a still base."""
    chain = Chain(column)
    place = chain.places(phase)
    if np.any(place.slip_rate != 0.0):
        return False
    joints = [block.joint for block in column.blocks]
    stiffness = np.array([joint.stiffness for joint in joints])
    area, _, second = np.array([block.joint_moments for block in column.blocks]).T
    turning, weight = stiffness * second, chain.carried * chain.g
    if chain.n * float(np.sum(chain.toppling)) > SOFTENED * float(np.min(turning)):
        return False
    slip = np.abs(place.slip)
    leaning = weight * (np.cumsum(slip) - slip)  # N m at rest at most: what is above stands off the middle of a contact
    energy = max(0.0, chain.energy(phase) + 2.0 * float(np.sum(leaning**2 / turning)))
    above = np.concatenate([[0.0], turning[:-1]])
    fastest = float(np.sqrt(np.max(2.0 * (turning + above) / chain.inertia)))  # rad/s, an upper bound
    damped = 1.0 + fastest * max(joint.damping for joint in joints)  # what dashpots add to the springs
    # amplitudes: energy over stiffness, of which gravity leaves half
    moment = damped * np.sqrt(4.0 * energy * turning) + 2.0 * leaning
    normal = weight - damped * np.sqrt(2.0 * energy * stiffness * area)
    tilt = chain.n * float(np.max(moment / turning))
    along = damped * fastest * np.sqrt(4.0 * energy * chain.carried) + weight * tilt
    kern = 2.0 * second / (area * chain.width)
    friction = np.array([np.inf if joint.friction is None else joint.friction for joint in joints])
    with np.errstate(invalid="ignore"):
        bears = friction * normal + np.array([joint.dowel or 0.0 for joint in joints])
    return bool(np.all(normal > 0.0) and np.all(moment <= normal * kern) and np.all(along <= SAFE * bears))


def stays_closed(column: Column, phase: FloatArray) -> bool:
    """Whether no joint of a column off its axis, none of which may slide, ever opens again upon a still base.

    False also where this cannot be said: where joints may slide, or are not in full contact at rest. To take the
    pressure off an edge, the joint has to be given at least the energy p^2 / 2 over its compliance there, with p the
    penetration of that edge at rest.
    """
    if column.slides:
        return False
    chain = Chain(column)
    place, rest = chain.places(phase), chain.places(chain.rest)
    weight, slip = chain.carried * chain.g, np.asarray(rest.slip)
    blocks = at.MODEL.see(chain.model, chain.n).blocks
    ends = np.maximum(blocks.left, blocks.rim_left - slip), np.minimum(blocks.right, blocks.rim_right - slip)
    # stiffness of the joints in full contact about the middle of the blocks, from energies: they are quadratic
    turn, pressed = 0.5 / chain.width, -np.ones(chain.n)
    level, ahead, back = (chain.elastic(pressed, slope, slip) for slope in (0.0 * turn, turn, -turn))
    along, mixed, second = 2.0 * level, (ahead - back) / (2.0 * turn), (ahead + back - 2.0 * level) / turn**2
    centre = mixed / along
    turning = second - centre * mixed
    falling = float(np.sum(chain.toppling) + np.sum(weight * (np.abs(slip) + np.abs(rest.opening))))
    slanting = float(np.sum(weight * np.abs(np.sin(chain.lean))))
    if chain.n * (falling + slanting * float(np.max(chain.width))) > SOFTENED * float(np.min(turning)):
        return False
    enough = np.inf
    for edge in ends:
        for there in (rest, place):
            slope = 2.0 * np.sin(0.5 * (there.theta - np.append(there.theta[1:], 0.0)))
            penetration = slope * (edge + 0.5 * slip) - there.opening
            if not np.all(penetration > 0.0):
                return False
            if there is rest:
                energy = 0.5 * penetration**2 / (1.0 / along + (edge - centre) ** 2 / turning)
                enough = min(enough, float(np.min(energy)))
    return chain.energy(phase) <= SAFE * (1.0 - SOFTENED) * enough
