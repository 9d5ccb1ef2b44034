"""Machine code of the kernels of most tests, made once, on all cores, before the workers begin."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial

from solver.common.executors import cores
from solver.ground.motion import Motion
from solver.kernels.paper import entries as paper
from solver.models.column.first_run import make_kernels
from solver.models.column.lanes import KINDS, load_kernels
from solver.models.paper.kind import load_lanes as load_paper_lanes
from solver.models.structure import driven
from solver.models.structure.lanes import load_lanes
from solver.models.structure.modes import modes_in_space
from support.structures import run, stack

SHAKE = Motion.harmonic(1.0, 1.0, 0.01)


def shake_structure() -> None:
    """A run in space, and what modes and rest need."""
    structure = stack(2)
    modes_in_space(structure)
    run(structure, SHAKE)


def make_lanes() -> None:
    """The kernels of structures in lanes."""
    load_lanes(stack(1))


def make_paper() -> None:
    """The kernels of the paper, and its lanes."""
    make_kernels(paper)
    load_paper_lanes()


# the longest first
TASKS: tuple[Callable[[], object], ...] = (
    make_kernels,
    make_paper,
    driven.make_kernels,
    shake_structure,
    make_lanes,
    *(partial(load_kernels, kind) for kind in KINDS),
)


def make_all() -> None:
    """Compile them, or find them in the cache."""
    with ProcessPoolExecutor(cores(), multiprocessing.get_context("spawn")) as pool:
        for made in [pool.submit(task) for task in TASKS]:
            made.result()
