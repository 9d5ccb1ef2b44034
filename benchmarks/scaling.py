"""Cost per block against the number of blocks: of one evaluation, and of a second of motion.

The columns are towers of equal squat drums: their highest frequencies, and with them the steps, hardly depend on the
number of drums, so that a second of motion takes comparable work for any number.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from solver import Block, Column, InputError, Joint, Motion, simulate
from solver.common import ranges

from . import timing
from .evaluation import PASSES, STATES, kernel_loop, states_of_a_run
from .scenes import STIFFNESS, G, shaft

SIZES = (1, 3, 10, 50, 200, 1000)  # blocks
MOST_SIMULATED = 200  # blocks; a higher tower would buckle
DRUM = (0.25, 4.0, 8000.0)  # m high, m wide and deep, kg
DRUM_DAMPING = 1e-4  # s
DURATION = 0.5  # s
SHORT = 0.01  # s, for the largest column
BUDGET = 1.0  # s of repeats


def tower(n: int) -> Column:
    """Return a tower of n drums."""
    height, side, mass = DRUM
    return Column(f"tower_{n}", (Block(height, side, side, mass, Joint(STIFFNESS, DRUM_DAMPING)),) * n)


@contextmanager
def limit_lifted(n: int) -> Iterator[None]:
    """Let columns have up to n blocks, whatever the solver's limit: the kernels have none."""
    limit = ranges.MAX_BLOCKS
    ranges.MAX_BLOCKS = max(n, limit)
    try:
        yield
    finally:
        ranges.MAX_BLOCKS = limit


def refusal(n: int) -> str:
    """Return the solver's reason to refuse a column of n blocks; empty if it accepts it."""
    try:
        shaft(n)
    except InputError as error:
        return str(error)
    return ""


def measure(quick: bool = False) -> dict[str, Any]:
    """Measure the cost per block, s, by number of blocks."""
    rows = []
    for n in SIZES:
        if quick and n > 200:
            continue
        row: dict[str, Any] = {"n": n, "refused": refusal(n)}
        with limit_lifted(n):
            column = shaft(n)
            count = STATES if n <= 50 else 20
            loop = kernel_loop(column, states_of_a_run(column, count))
            row["evaluation"] = timing.loops([loop])[0] / (PASSES * count * n)
            if n <= MOST_SIMULATED:
                # equal methods for every n: modes of the elastic phase would make short columns even cheaper
                stack, motion = tower(n).with_settings(without=("elastic",)), Motion.harmonic(0.2 * G, 2.0, DURATION)
                simulate(stack, motion, settle=0.0)
                response, seconds, _ = timing.fastest(partial(simulate, stack, motion, settle=0.0), BUDGET)
                row |= {
                    "simulated": seconds / (DURATION * n),
                    "steps": (response.stats["steps"] + response.stats["rejected"]) / DURATION,
                    "evaluations": response.stats["evaluations"] / DURATION,
                    "rocking": response.stats["rocking"],
                }
            else:
                motion = Motion.harmonic(0.1 * G, 1.0, SHORT)
                response, seconds, _ = timing.fastest(partial(simulate, column, motion), 0.0)
                row |= {"short_run": SHORT, "short_seconds": seconds, "short_peak": float(max(response.peak_top_ux))}
            rows.append(row)
    return {"rows": rows}
