"""Seeded extreme cases of inputs that the solver accepts: a column, a base motion, a duration."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from solver import Block, Column, Joint, Motion, Settings

G = 9.80665  # m/s2
DENSITY = 2000.0  # kg/m3
SMALLEST, LARGEST = 0.01, 50.0  # m, of a block
MOST_STEPS = 5_000  # of the fastest joint mode, in the short cases
MASS_DECADES = 4.0  # largest difference between any block's mass and the top one's
CRUSHED = 0.05  # of the columns: settlements of any size
MOST_SETTLED = 0.1  # of a block's height, in the others
MOST_SAMPLES = 2000
LONG = 1e5  # s
MIRRORED = ("ux", "theta", "M", "S", "T", "slip", "Fx", "My")  # outputs that change their sign in the mirror

MOTIONS = (
    "harmonic",
    "step",
    "square wave",
    "held noise",
    "linear noise",
    "free flight",
    "all joints at once",
    "quiet",
    "long",
)
_WEIGHTS = (0.22, 0.08, 0.12, 0.2, 0.12, 0.1, 0.08, 0.03, 0.05)


@dataclass(frozen=True)
class Case:
    """One case; seed and number reproduce it."""

    seed: int
    number: int
    kind: str  # one of MOTIONS
    column: Column
    motion: Motion

    @property
    def damped(self) -> bool:
        """True if every joint dissipates."""
        return all(block.joint.damping > 0.0 for block in self.column.blocks)

    def line(self) -> str:
        """Return the case in one line."""
        blocks = self.column.blocks
        stiffness = [block.joint.stiffness for block in blocks]
        damping = [block.joint.damping for block in blocks]
        peak = max(abs(self.motion.amplitude), *(float(np.max(np.abs(a))) for a in (self.motion.ax, self.motion.az)))
        return (
            f"{self.kind}, n = {len(blocks)}, k = {min(stiffness):.2g} to {max(stiffness):.2g} N/m3, "
            f"eta = {min(damping):.2g} to {max(damping):.2g} s, g = {self.column.g:.3g}, "
            f"{peak / G:.2g} g, {self.motion.duration:.3g} s"
        )


def draw(seed: int, number: int, most_blocks: int = 200) -> Case:
    """Draw the case of that number of a campaign; the same arguments give the same case."""
    rng = np.random.default_rng([seed, number])
    kind = str(rng.choice(MOTIONS, p=_WEIGHTS))
    column = _column(rng, 1 if kind == "long" else most_blocks)
    return Case(seed, number, kind, column, _motion(rng, kind, column))


def _log(rng: np.random.Generator, low: float, high: float, size: int | None = None) -> np.ndarray:
    return 10.0 ** rng.uniform(np.log10(low), np.log10(high), size)


def _column(rng: np.random.Generator, most_blocks: int) -> Column:
    n = int(_log(rng, 1.0, most_blocks + 0.999))
    wild = rng.random() < 0.4  # no two blocks alike
    parts = n if wild else 1
    height = _log(rng, SMALLEST, LARGEST, parts)
    width = np.clip(height / _log(rng, 0.2, 40.0, parts), SMALLEST, LARGEST)
    depth = np.clip(width * _log(rng, 0.1, 10.0, parts), SMALLEST, LARGEST)
    mass = DENSITY * height * width * depth
    if wild:
        change = rng.uniform(-4.0, 4.0, n)  # decades from one block to the next, reversed at the ends of the range
        decades = np.log10(np.clip(mass, 1e-3, 1e9))
        for i in range(1, n):
            there = decades[i - 1] + change[i]
            decades[i] = there if abs(there - decades[0]) <= MASS_DECADES else decades[i - 1] - change[i]
        mass = 10.0**decades
    stiffness = _log(rng, 1e6, 1e14) * (_log(rng, 0.1, 10.0, parts) if wild else np.ones(parts))
    damping = np.zeros(parts) if rng.random() < 0.3 else np.full(parts, float(_log(rng, 1e-5, 0.1)))
    if wild and rng.random() < 0.3:
        damping *= rng.random(parts) < 0.5
    contact = rng.uniform(0.3, 1.0, parts) if wild else np.ones(parts)
    rise = rng.uniform(0.2, 0.8, parts) if wild else np.full(parts, 0.5)

    def block(i: int) -> Block:
        i = i if wild else 0
        most = width[min(i + 1, parts - 1)]
        wide = min(float(contact[i] * width[i]), float(most))
        joint = Joint(float(np.clip(stiffness[i], 1e6, 1e14)), float(damping[i]), wide)
        return Block(
            float(height[i]), float(width[i]), float(depth[i]), float(mass[i]), joint, float(rise[i] * height[i])
        )

    gravity = float(rng.choice([G, 0.0, 1.62], p=[0.9, 0.06, 0.04]))
    tolerance = float(rng.choice([1e-3, 1e-5, 1e-7], p=[0.2, 0.6, 0.2]))
    blocks = tuple(block(i) for i in range(n))
    if rng.random() > CRUSHED:
        carried = gravity * np.cumsum([b.mass for b in blocks])
        spring = np.array(Column("case", blocks).springs)
        settled = float(np.max(carried / spring / min(b.height for b in blocks)))
        lighter = min(1.0, MOST_SETTLED / max(settled, 1e-300))
        blocks = tuple(replace(b, mass=max(1e-8, b.mass * lighter)) for b in blocks)
    return Column("case", blocks, Settings(tolerance=tolerance), gravity)


def fastest_mode(column: Column) -> float:
    """Return the upper bound of the angular frequency of the fastest vertical joint mode, rad/s."""
    spring = np.array(column.springs)
    spring[1:] += spring[:-1]
    return float(np.sqrt(2.0 * np.max(spring / np.array([b.mass for b in column.blocks]))))


def _duration(rng: np.random.Generator, column: Column) -> float:
    """Return a duration, s; most cases are short enough for explicit steps, the others rely on the solver's longer
    ones.
    """
    wanted = float(_log(rng, 0.05, 20.0))
    few = MOST_STEPS / fastest_mode(column) / max(1.0, 0.1 * column.n)
    return min(wanted, few if rng.random() < 0.7 else 20.0 * few)


def _motion(rng: np.random.Generator, kind: str, column: Column) -> Motion:
    amplitude = G * float(_log(rng, 1e-9, 20.0) if rng.random() < 0.3 else _log(rng, 1e-2, 3.0))
    if kind == "long":
        return Motion.harmonic(G * 1e-3, 1.0 / LONG, LONG) if rng.random() < 0.5 else _sampled(LONG, [0.0, 0.0])
    duration = _duration(rng, column)
    if kind == "quiet":
        return _sampled(duration, [0.0, 0.0])
    if kind == "harmonic":
        return Motion.harmonic(amplitude, float(_log(rng, 0.01, 500.0)), duration)
    dt = float(_log(rng, 1e-4, 0.1))
    count = int(np.clip(duration / dt, 2, MOST_SAMPLES))
    dt = min(dt, duration / count)
    noise = rng.normal(size=count)
    if kind == "held noise":
        return Motion.from_samples(dt, amplitude * noise, 0.3 * amplitude * rng.normal(size=count), hold=True)
    if kind == "linear noise":
        return Motion.from_samples(dt, amplitude * noise, 0.3 * amplitude * rng.normal(size=count))
    if kind == "step":
        return Motion.from_samples(dt, np.where(np.arange(count) < count // 2, amplitude, 0.0), hold=True)
    half = max(1, int(count / _log(rng, 2.0, 50.0)))  # samples in half a period
    sign = np.where(np.arange(count) // half % 2 == 0, 1.0, -1.0)
    if kind == "square wave":
        return Motion.from_samples(dt, amplitude * sign, hold=True)
    # the base falls faster than the column: every joint opens, all at once if nothing else moves
    fall = -float(_log(rng, 1.01, 20.0)) * (column.g or G)
    across = amplitude * noise if kind == "free flight" else np.zeros(count)
    return Motion.from_samples(dt, across, np.where(sign > 0.0, fall, 0.5 * (column.g or G)), hold=True)


def _sampled(duration: float, ax: list[float]) -> Motion:
    return Motion.from_samples(duration / (len(ax) - 1), ax)
