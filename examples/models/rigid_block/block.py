"""The block, its motion in closed form from impact to impact, and what can be seen of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from solver.common.errors import POSITIVE, check_number
from solver.models.driven import NOT_YET, Driven, Driving, Shaking
from solver.models.outputs import BLOCK, Histories, Output
from solver.models.protocol import PlainModel
from solver.models.response import Result

FloatArray = NDArray[np.float64]
State = Callable[[float], tuple[float, float]]  # rotation and its rate by the time
PART = 0.05  # of 1 / p, and of 1 / omega of a harmonic motion: in such parts of the time impacts are looked for
HALVINGS = 60
REST = 1e-9  # of p alpha: rate after an impact with which the block has come to rest
FALLEN = 0.5 * math.pi


@dataclass(frozen=True)
class Block(PlainModel):
    """Width and height in m; restitution: rate after an impact over that before it, None: Housner's. g: m/s2."""

    width: float
    height: float
    restitution: float | None = None
    g: float = 9.80665
    name: str = "block"

    def __post_init__(self) -> None:
        for key in ("width", "height", "g"):
            check_number(key, getattr(self, key), POSITIVE, "a positive number")

    @property
    def rebound(self) -> float:
        """The restitution."""
        return 1.0 - 1.5 * math.sin(self.alpha) ** 2 if self.restitution is None else self.restitution

    @property
    def kind(self) -> Blocks:
        """The kind of such blocks."""
        return BLOCKS

    @property
    def alpha(self) -> float:
        """Angle of its diagonal, rad."""
        return math.atan2(self.width, self.height)

    @property
    def p(self) -> float:
        """Frequency parameter, 1/s."""
        return math.sqrt(1.5 * self.g / math.hypot(self.width, self.height))


class BlockHistories(Histories):
    """The outputs of a block at an instant: the table of its outputs."""

    ux = Output(BLOCK, "m", "Displacement of the top, positive to +x")
    ry = Output(BLOCK, "rad", "Rotation, clockwise")


@dataclass(eq=False, repr=False)
class BlockResponse(BlockHistories, Result):
    """A run of a block; attributes, CSV and frames follow from the table."""

    model: Block
    rows: FloatArray  # (rows, 2)


class Rocking(Driven):
    """Its state: rotation, its rate, its largest value, and when it fell."""

    unclear, size = "still rocks", 3

    @property
    def at_rest(self) -> bool:
        """True if it stands upright."""
        return not self.arrays.state[:2].any()

    @property
    def seen(self) -> FloatArray:
        """ux, ry."""
        return float(self.arrays.state[0]) * np.array([self.model.height, 1.0])

    @property
    def visible_peaks(self) -> FloatArray:
        """The peaks of ux and ry."""
        return float(self.arrays.state[2]) * np.array([self.model.height, 1.0])

    def why_it_stands(self) -> str:
        """Return the reason why it stands: its energy is less than that of the block on its edge."""
        theta, rate, alpha = abs(self.arrays.state[0]), self.arrays.state[1], self.model.alpha
        energy = 0.5 * (rate / self.model.p) ** 2 + alpha * theta - 0.5 * theta * theta
        return "its energy does not suffice" if theta < alpha and energy < 0.5 * alpha**2 else ""

    def follow(self, shaking: Shaking, t: float, end: float) -> None:
        """Follow it from t to `end`, s, both in one piece of the motion."""
        block, (theta, rate, peak, fell) = self.model, self.arrays.state.tolist()
        step = PART / max(block.p, shaking.omega)
        while t < end and fell == NOT_YET:
            self.arrays.counts[1] += 1
            h = min(step, end - t)
            if theta == rate == 0.0:  # it lifts where the floor's acceleration exceeds g alpha
                if not _lifts(block, shaking, t):
                    t = _first(partial(_lifts, block, shaking), t, t + h)
                    continue
                side = -math.copysign(1.0, shaking.at(t))
            else:
                side = math.copysign(1.0, theta or rate)
            state = _state(block, shaking, t, side, theta, rate)
            turns = _first(partial(_below, state, 1, side), 0.0, h) if side * rate > 0.0 else h
            peak = max(peak, abs(state(turns)[0]))
            hit = _first(partial(_below, state, 0, side), 0.0, h)
            theta, rate = state(hit)
            if hit < h or side * theta < 0.0:
                theta, rate = 0.0, block.rebound * rate
                rate = 0.0 if abs(rate) < REST * block.p * block.alpha else rate
            t += hit
            fell = t if abs(theta) >= FALLEN else fell
        self.arrays.state[:] = theta, rate, peak, fell


def _state(block: Block, shaking: Shaking, t: float, side: float, theta: float, rate: float) -> State:
    """Return theta and its rate a time after t, on one side."""
    p, g, omega = block.p, block.g, shaking.omega
    part = shaking.amplitude / g * p * p / (p * p + omega**2)

    def driven(s: float) -> tuple[float, float]:
        phase, past = omega * (t + s - shaking.start), t + s - shaking.begin
        place = side * block.alpha + (shaking.value + shaking.slope * past) / g + part * math.sin(phase)
        return place, shaking.slope / g + part * omega * math.cos(phase)

    place, speed = driven(0.0)
    a, b = theta - place, (rate - speed) / p

    def state(s: float) -> tuple[float, float]:
        place, speed = driven(s)
        c, d = math.cosh(p * s), math.sinh(p * s)
        return place + a * c + b * d, speed + p * (a * d + b * c)

    return state


def _lifts(block: Block, shaking: Shaking, t: float) -> bool:
    """Return True if the base lifts a block that rests."""
    return abs(shaking.at(t)) > block.g * block.alpha


def _below(state: State, which: int, side: float, s: float) -> bool:
    """Return True if theta (0) or its rate (1) has passed zero from one side, s after the start."""
    return side * state(s)[which] < 0.0


def _first(holds: Callable[[float], bool], low: float, high: float) -> float:
    """Return the time at which something begins to hold, which it does at most once; the end if it does not."""
    if not holds(high):
        return high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


class Blocks(Driving):
    """Rigid blocks on a rigid floor."""

    word, largest, stepper, response = "block", "ux", Rocking, BlockResponse
    numbers = ("block.width", "block.height", "block.restitution", "g")


BLOCKS = Blocks()
