"""Many runs of structures in space, in threads, in one table."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from ..common.errors import InputError, SolverError, shown
from ..common.executors import cores
from ..ground.motion import Motion
from ..space.response import SpatialResponse
from ..space.run import simulate_structure
from ..space.structure import Structure
from .outputs import Kept
from .single_run import SETTLE
from .table import WORDS, Table

Callback = Callable[[int, int | None], object]
OF_RUN = {
    "verdict": Kept(kind=np.uint8),
    "overturn_time": Kept("s", np.float64),
    "steps": Kept(kind=np.int64),
    "evaluations": Kept(kind=np.int64),
    "settled_for": Kept("s", np.float64),
}
_UNITS = {
    "block": {"u": "m", "ux": "m", "uy": "m", "uz": "m", "rx": "rad", "ry": "rad", "rz": "rad"},
    "joint": {"N": "N", "Mx": "N m", "My": "N m", "Tx": "N", "Ty": "N", "Mz": "N m", "sigma_max": "Pa", "slip": "m"},
    "tie": {"tie": "N"},
    "base": {"base": ""},  # three forces in N, three moments in N m
}
KEPT: dict[str, Kept] = {
    **OF_RUN,
    **{f"peak_{name}": Kept(unit, None, of) for of, units in _UNITS.items() for name, unit in units.items()},
    "least_contact": Kept("", None, "joint"),
}
COST = 1e-3  # s for a block and a second of motion, roughly
ROWS = 0.02  # s, between the rows from which the peak of u is taken


class RunInSpace(NamedTuple):
    """One run, from rest."""

    structure: Structure
    motion: Motion
    duration: float  # s


def guessed_cost_in_space(run: RunInSpace) -> float:
    """Estimated duration of a run that is followed to its verdict, s, before any is measured."""
    return COST * run.structure.n * (run.duration + SETTLE)


def are_structures(given: object) -> bool:
    """Whether these are a structure or a list of them."""
    return isinstance(given, Structure) or (
        isinstance(given, Sequence) and bool(given) and all(isinstance(one, Structure) for one in given)
    )


def simulate_structures(
    structures: Structure | Sequence[Structure],
    motions: Motion | Sequence[Motion],
    duration: float | None,
    tolerance: float | None,
    keep: Sequence[str],
    threads: int | None,
    settle: float,
    callback: Callback | None,
) -> Table:
    """Runs of structure k under motion k, each from rest: see `simulate_many`; names of `keep` are of KEPT.

    Raises InputError for a wrong value or a structure without a stable rest.
    """
    for name in keep:
        if name not in KEPT:
            raise InputError(f"keep: {shown(name)}: must be of {', '.join(KEPT)}")
    models = [structures] if isinstance(structures, Structure) else list(structures)
    shaken = [motions] if isinstance(motions, Motion) else list(motions)
    count = max(len(models), len(shaken))
    if {len(models), len(shaken)} - {1, count}:
        raise InputError(f"motions: {len(shaken)}, must be 1 or as many as structures, {len(models)}")
    models, shaken = models * (count // len(models)), shaken * (count // len(shaken))

    def make(k: int) -> SpatialResponse | str:
        length = shaken[k].duration if duration is None else duration
        return made_alone(RunInSpace(models[k].with_settings(tolerance=tolerance), shaken[k], length), keep, settle)

    made: list[SpatialResponse | str] = []
    with ThreadPoolExecutor(threads or cores(), thread_name_prefix="runs") as pool:
        for found in pool.map(make, range(count)):
            made.append(found)
            if callback is not None:
                callback(len(made), count)
    columns = {name: _column(name, made, models) for name in dict.fromkeys(keep)}
    failures = {k: found for k, found in enumerate(made) if isinstance(found, str)}
    verdicts = Counter("failed" if isinstance(found, str) else found.verdict for found in made)
    of = {name: KEPT[name].of for name in columns}
    return Table(columns, {"runs": count, "failures": failures, "verdicts": dict(verdicts)}, of=of)


def made_alone(run: RunInSpace, keep: Sequence[str], settle: float) -> SpatialResponse | str:
    """One run, without peaks that are not kept; or why the solver could not make it. Raises InputError."""
    watches = any(name not in (*OF_RUN, "peak_u") for name in keep)
    structure, motion, duration = run
    structure = structure.with_settings(without=None if watches else ("peaks",))
    times = motion.start + ROWS * np.arange(math.floor(duration / ROWS + 1e-9) + 1, dtype=np.float64)
    try:
        return simulate_structure(structure, motion, duration, times, settle=settle)
    except SolverError as failure:
        return str(failure)


def _column(name: str, made: list[SpatialResponse | str], models: list[Structure]) -> Any:
    """The column of a result: a number of each run, or of each block, joint or tie; NaN fills what is missing."""
    if name == "verdict":
        words = ["undecided" if isinstance(found, str) else found.verdict for found in made]
        return np.array([WORDS["verdict"].index(word) for word in words], dtype=np.uint8)
    values = [math.nan if isinstance(found, str) else kept_value(name, found) for found in made]
    if name in OF_RUN:
        return np.array(values)
    width = max(np.size(value) for value in values)
    table = np.full((len(made), width), math.nan)
    for row, value in zip(table, values, strict=True):
        row[: np.size(value)] = value
    return table


def kept_value(name: str, found: SpatialResponse) -> Any:
    """A result of a run, one of KEPT; the verdict as a word."""
    if name == "verdict":
        return found.verdict
    if name == "overturn_time":
        return found.overturn_time
    if name in OF_RUN:
        return found.stats[name]
    return found.peaks["contact" if name == "least_contact" else name.removeprefix("peak_")]
