"""Another model: one slender rigid block on a rigid floor that it hits without a rebound (G. W. Housner, 1963).

theta (rad, clockwise) rocks by theta'' = p^2 (theta - s alpha - a / g): s its sign, a the acceleration of the base, p^2
= 3 g / (4 R), R half the diagonal, alpha the slenderness angle. An impact multiplies the rate by the restitution.
Between impacts this is in closed form. `Block` and `BLOCKS` have what solver/models/protocol.py asks for, so that
`simulate`, `simulate_many` and studies take it:

    simulate(Block(1.0, 4.0), motion); ida(Block(1.0, 4.0), motions, levels)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from solver.common.errors import POSITIVE, InputError, check_number
from solver.ground.motion import check_in_plane
from solver.models.outputs import BLOCK, Histories, Output, peaks_by_name
from solver.models.protocol import SETTLE, Kept, Lanes, Plan, Run, Work, kept_peaks
from solver.models.response import Result
from solver.models.still_base import settled

FloatArray = NDArray[np.float64]
PART = 0.05  # of 1 / p, and of 1 / omega of a harmonic motion: in such parts of the time impacts are looked for
HALVINGS = 60
REST = 1e-9  # of p alpha: rate after an impact with which the block has come to rest
FALLEN = 0.5 * math.pi
NUMBERS = ("block.width", "block.height", "block.restitution", "g")


@dataclass(frozen=True)
class Settings:
    """There is nothing to choose."""

    tolerance: float = 1e-12
    integrator: str = "closed form"
    without: tuple[str, ...] = ()


@dataclass(frozen=True)
class Block:
    """Width and height in m; restitution: rate after an impact over that before it, None: Housner's."""

    width: float
    height: float
    restitution: float | None = None
    g: float = 9.80665  # m/s2
    name: str = "block"
    settings: Settings = field(default_factory=Settings)
    n = 1
    laws = ()
    sizes: Any = field(default_factory=lambda: {"block": 1, "joint": 1, "tie": 0, "base": 2}, compare=False, repr=False)

    def __post_init__(self) -> None:
        for key in ("width", "height", "g"):
            check_number(key, getattr(self, key), POSITIVE, "a positive number")

    @property
    def kind(self) -> Any:
        """What such blocks have in common."""
        return BLOCKS

    @property
    def alpha(self) -> float:
        """Angle of its diagonal, rad."""
        return math.atan2(self.width, self.height)

    @property
    def p(self) -> float:
        """Frequency parameter, 1/s."""
        return math.sqrt(1.5 * self.g / math.hypot(self.width, self.height))

    @property
    def rebound(self) -> float:
        """The restitution."""
        return 1.0 - 1.5 * math.sin(self.alpha) ** 2 if self.restitution is None else self.restitution

    def with_settings(self, **changes: Any) -> Block:
        """A copy with other settings."""
        return replace(self, settings=replace(self.settings, **{k: v for k, v in changes.items() if v is not None}))

    def with_joints(self, stiffness: Sequence[float], damping: Sequence[float]) -> Block:
        """It has no joints."""
        return self

    def to_dict(self) -> dict[str, Any]:
        """Its numbers."""
        return asdict(self)


class BlockHistories(Histories):
    """What is known of a block at an instant: the table of its outputs."""

    ux = Output(BLOCK, "m", "Displacement of the top, positive to +x")
    theta = Output(BLOCK, "rad", "Rotation, clockwise")


@dataclass(eq=False, repr=False)
class BlockResponse(BlockHistories, Result):
    """A run of a block; attributes, CSV and frames follow from the table."""

    block: Block
    rows: FloatArray  # (rows, 2)
    model = property(lambda self: self.block)
    _fall = property(lambda self: f"fell at {self.overturn_time:.4g} s")


class Shaking(NamedTuple):
    """Acceleration of the base in one piece of the time, m/s2: from `begin`, value, slope; amplitude, omega, phase."""

    begin: float
    value: float
    slope: float
    amplitude: float
    omega: float
    start: float

    def at(self, t: float) -> float:
        """Its value, m/s2."""
        wave = self.amplitude * math.sin(self.omega * (t - self.start))
        return self.value + self.slope * (t - self.begin) + wave

    def lifts(self, t: float, block: Block) -> bool:
        """Whether it lifts a block that rests."""
        return abs(self.at(t)) > block.g * block.alpha


class Rocking:
    """A block in motion; on a still base as of still_base.py."""

    unclear = "still rocks"

    def __init__(self, block: Block) -> None:
        self.block, self.theta, self.rate, self.peak = block, 0.0, 0.0, 0.0
        self.fall_time, self.impacts, self.pieces = math.nan, 0, 0

    @property
    def fallen(self) -> str:
        """What has."""
        return "" if math.isnan(self.fall_time) else "the block"

    def why_it_stands(self) -> str:
        """Its energy is less than that of the block on its edge."""
        block, turn = self.block, abs(self.theta)
        energy = 0.5 * (self.rate / block.p) ** 2 + block.alpha * turn - 0.5 * turn * turn
        return "its energy does not suffice" if turn < block.alpha and energy < 0.5 * block.alpha**2 else ""

    def next_look(self, t: float, stop: float, settle: float) -> float:
        """Every quarter of a second."""
        return min(t + 0.25, stop + settle)

    def rest_until(self, t: float, end: float) -> None:
        """Without acceleration."""
        self.follow(Shaking(t, 0.0, 0.0, 0.0, 0.0, t), t, end)

    def follow(self, shaking: Shaking, t: float, end: float) -> None:
        """From t to `end`, s, both in one piece of the motion."""
        block = self.block
        step = PART / max(block.p, shaking.omega)
        while t < end and not self.fallen:
            self.pieces += 1
            h = min(step, end - t)
            if self.theta == self.rate == 0.0:  # it lifts where the floor's acceleration exceeds g alpha
                if not shaking.lifts(t, block):
                    t = _first(partial(shaking.lifts, block=block), t, t + h)
                    continue
                side = -math.copysign(1.0, shaking.at(t))
            else:
                side = math.copysign(1.0, self.theta if self.theta else self.rate)
            state = self._state(shaking, t, side)
            turns = _first(partial(_below, state, 1, side), 0.0, h) if side * self.rate > 0.0 else h
            self.peak = max(self.peak, abs(state(turns)[0]))
            hit = _first(partial(_below, state, 0, side), 0.0, h)
            self.theta, self.rate = state(hit)
            if hit < h or side * self.theta < 0.0:
                self.theta, self.rate = 0.0, block.rebound * self.rate
                self.impacts += 1
                if abs(self.rate) < REST * block.p * block.alpha:
                    self.rate = 0.0
            t += hit
            if abs(self.theta) >= FALLEN:
                self.fall_time = t

    def _state(self, shaking: Shaking, t: float, side: float) -> Callable[[float], tuple[float, float]]:
        """theta and its rate a time after t, on one side."""
        p, g, alpha = self.block.p, self.block.g, self.block.alpha
        part = shaking.amplitude / g * p * p / (p * p + shaking.omega**2)

        def driven(s: float) -> tuple[float, float]:
            phase, past = shaking.omega * (t + s - shaking.start), t + s - shaking.begin
            place = side * alpha + (shaking.value + shaking.slope * past) / g + part * math.sin(phase)
            return place, shaking.slope / g + part * shaking.omega * math.cos(phase)

        place, speed = driven(0.0)
        a, b = self.theta - place, (self.rate - speed) / p

        def state(s: float) -> tuple[float, float]:
            place, speed = driven(s)
            c, d = math.cosh(p * s), math.sinh(p * s)
            return place + a * c + b * d, speed + p * (a * d + b * c)

        return state


def _below(state: Callable[[float], tuple[float, float]], which: int, side: float, s: float) -> bool:
    """Whether theta (0) or its rate (1) has passed zero from one side, s after the start."""
    return side * state(s)[which] < 0.0


def _first(holds: Callable[[float], bool], low: float, high: float) -> float:
    """When something begins to hold, in a time in which it does so at most once; the end where it does not."""
    if not holds(high):
        return high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


class Blocks:
    """Rigid blocks on a rigid floor."""

    word, across, settings = "block", False, ("tolerance", "without")
    outputs, largest = BlockHistories.outputs, "ux"
    kept: Mapping[str, Kept] = {
        **kept_peaks(outputs),
        **{name: Kept(kind=np.uint8) for name in ("verdict", "path")},
        "overturn_time": Kept("s", np.float64),
        "steps": Kept(kind=np.int64),
    }

    def single_run(self, model: Block, plan: Plan) -> tuple[BlockResponse, FloatArray]:
        """Follow the motion, and then the still base."""
        motion, body = plan.motion, Rocking(model)
        if plan.initial is not None:
            raise InputError("initial: must be left out, a block begins at rest")
        stop, omega = motion.start + plan.duration, 2.0 * math.pi * motion.frequency
        marks = np.unique(np.concatenate([plan.times, motion.time, [stop]]))
        marks = marks[marks <= stop]
        value = np.interp(marks, motion.time, motion.ax)
        theta = np.zeros(len(marks))
        for k, (t, end) in enumerate(pairwise(marks), start=1):
            held = value[k - 1] if t < motion.time[-1] else 0.0  # which is over with its last sample
            slope = 0.0 if motion.hold or t >= motion.time[-1] else (value[k] - held) / (end - t)
            body.follow(Shaking(t, held, slope, motion.amplitude, omega, motion.start), t, end)
            theta[k] = body.theta
        peak = body.peak
        verdict = settled(body, stop, plan.settle)
        stats = {"steps": body.pieces, "impacts": body.impacts, "settled_for": verdict.time - stop}
        rows = theta[np.searchsorted(marks, plan.times)][:, None] * [model.height, 1.0]
        peaks = peaks_by_name(self.outputs, model.sizes, np.array([model.height * peak, peak]))
        response = BlockResponse(model, rows, time=plan.times, peaks=peaks, stats=stats, motion=motion)
        response.verdict, response.reason, response.overturn_time = verdict.word, verdict.reason, body.fall_time
        return response, response.ux

    def alone(self, run: Run, keep: Collection[str], settle: float, look: Callable[..., object]) -> dict[str, Any]:
        """Results of a run by name."""
        times = np.array([run.motion.start + run.duration])
        found, _ = self.single_run(run.model, Plan(run.motion, run.duration, times, None, settle, look))
        return {name: found.kept(name) for name in keep}

    def lanes(self, model: Block, keep: Collection[str]) -> Lanes:
        """There are none."""
        return Lanes("closed form", None, 1.0)

    def with_numbers(self, model: Block, values: Mapping[str, tuple[float, bool]]) -> Block:
        """Numbers set by name."""
        for name, (number, relative) in values.items():
            key = name.removeprefix("block.")
            present = model.rebound if key == "restitution" else getattr(model, key)
            changed: dict[str, Any] = {key: number * present if relative else number}
            model = replace(model, **changed)
        return model

    check_motion = staticmethod(check_in_plane)
    has_number = staticmethod(lambda model, name: name in NUMBERS)
    numbers_of = staticmethod(lambda model, name: [name])
    warnings = staticmethod(lambda model, at_rest=True: ())
    check = check_kept = staticmethod(lambda model, *given, **named: None)
    simplest = staticmethod(lambda model, motion: model)
    largest_of = staticmethod(lambda response, places: (response.peaks["ux"], places))
    in_lanes = staticmethod(lambda response, plan: False)
    under = staticmethod(lambda model, motion: ("", None))
    load = staticmethod(lambda model, keep: None)
    work = staticmethod(lambda model, keep: Work(SETTLE, 1.0))


BLOCKS = Blocks()
