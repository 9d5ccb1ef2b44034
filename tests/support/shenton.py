"""The first motion of a block: Shenton's map (1996), and the mode that a run finds."""

from __future__ import annotations

import numpy as np

from solver import Block, Column, Joint, Motion, Settings, simulate
from support.probe import G


def needed_to_rock(push: float, width: float, height: float) -> float:
    """Return the least friction at which a block does not slide as it begins to rock under a base acceleration of push
    g.
    """
    b, h = 0.5 * width, 0.5 * height
    turns = (push * h - b) / (4.0 / 3.0 * (b * b + h * h))  # angular acceleration over g
    return (push - h * turns) / (1.0 + b * turns)


def mode_of(push: float, mu: float, slenderness: float) -> str:
    """Return the first motion of a block on rigid ground (H. W. Shenton, J. Eng. Mech. 122 (1996) 690-693)."""
    width = 1.0
    edge = 1.0 / slenderness
    if push < min(mu, edge):
        return "rest"
    if mu < edge:
        return "slide"
    return "rock" if mu > needed_to_rock(push, width, slenderness * width) else "slide-rock"


def mode_found(push: float, mu: float, slenderness: float) -> str:
    """Return the motion of a block on a stiff bed under a base acceleration that rises to push g within 0.05 s."""
    joint = Joint(5e10, 1e-3, friction=mu)
    column = Column("block", (Block(slenderness, 1.0, 1.0, 2000.0 * slenderness, joint),), Settings(tolerance=1e-5))
    motion = Motion.from_samples(0.05, np.array([0.0, *[push * G] * 4]))
    response = simulate(column, motion, duration=0.2, settle=0.0)
    slides, rocks = np.max(np.abs(response.slip)) > 2e-4, np.min(response.contact) < 0.1
    return {(False, False): "rest", (True, False): "slide", (False, True): "rock", (True, True): "slide-rock"}[
        bool(slides), bool(rocks)
    ]
