"""Many runs of structures in space, in threads, in one table."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from ..common.errors import InputError, SolverError, shown
from ..common.executors import cores
from ..common.turns import others_turn
from ..ground.motion import Motion
from ..space.response import SpatialResponse
from ..space.rest import NoRestError, Rest, rest_of
from ..space.run import simulate_structure
from ..space.structure import Structure
from .batch_in_space import FROM_LANES, RunInSpace, follow_in_lanes, kind_of
from .outputs import Kept
from .single_run import SETTLE
from .table import WORDS, Table

Callback = Callable[[int, int | None], object]
Made = dict[str, Any] | str | InputError  # results by name, why the solver failed, what is wrong
SCALAR = "scalar"
OF_RUN = {
    "verdict": Kept(kind=np.uint8),
    "overturn_time": Kept("s", np.float64),
    "steps": Kept(kind=np.int64),
    "evaluations": Kept(kind=np.int64),
    "settled_for": Kept("s", np.float64),
    "path": Kept(kind=np.uint8),
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
WORTH = 20.0  # s, all runs one by one: from there on lanes are worth their compilation
AT_ONCE = 64  # runs, at most, that a thread sends through lanes
ROWS = 0.005  # s, between the rows from which the peak of u is taken


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

    A structure without a stable rest has fallen as its run begins; stats["failures"] has the reason. Raises InputError
    for a wrong value.
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

    lengths = [motion.duration if duration is None else duration for motion in shaken]
    runs = [
        RunInSpace(model.with_settings(tolerance=tolerance), motion, length)
        for model, motion, length in zip(models, shaken, lengths, strict=True)
    ]
    workers = threads or cores()
    each = max(1, min(AT_ONCE, math.ceil(count / workers)))
    lanes = worth_lanes(sum(map(guessed_cost_in_space, runs)), keep)
    parts = [runs[k : k + each] for k in range(0, count, each)] if lanes else [[run] for run in runs]
    made: list[Made] = []
    with ThreadPoolExecutor(workers, thread_name_prefix="runs") as pool:
        for found in pool.map(lambda part: made_runs(part, keep, settle, lanes), parts):
            made += found
            if callback is not None:
                callback(len(made), count)
    failures = {k: str(found) for k, found in enumerate(made) if not isinstance(found, dict)}
    for k, found_one in enumerate(made):
        if isinstance(found_one, NoRestError):
            made[k] = _fallen(keep, shaken[k].start)
        elif isinstance(found_one, InputError):
            raise found_one
    columns = {name: _column(name, made) for name in dict.fromkeys(keep)}
    verdicts = Counter(found["verdict"] if isinstance(found, dict) else "failed" for found in made)
    paths = Counter(found["path"] if isinstance(found, dict) else SCALAR for found in made)
    of = {name: KEPT[name].of for name in columns}
    stats = {"runs": count, "failures": failures, "verdicts": dict(verdicts), "paths": dict(paths)}
    return Table(columns, stats, of=of)


def worth_lanes(cost: float, keep: Sequence[str]) -> bool:
    """Whether runs of this guessed cost, s, that keep these results are made eight at once, those that can be."""
    return cost >= WORTH and FROM_LANES.issuperset(keep)


def made_runs(runs: Sequence[RunInSpace], keep: Sequence[str], settle: float, lanes: bool) -> list[Made]:
    """Results of runs by name, in one thread; why the solver could not make it, or what is wrong with a structure.

    lanes: whether they are made eight at once, where they can be. The result of a run does not depend on the others.
    """
    made: list[Made] = [{} for _ in runs]
    groups: dict[Hashable, list[tuple[int, Rest]]] = {}
    for k, run in enumerate(runs):
        kind = kind_of(run) if lanes else None
        if kind is not None:
            try:
                rest = rest_of(run.structure)
            except InputError as error:
                made[k] = error
            else:
                groups.setdefault(kind, []).append((k, rest))
    for places in groups.values():
        found = follow_in_lanes([runs[k] for k, _ in places], [rest for _, rest in places], settle)
        for (k, _), one in zip(places, found, strict=True):
            made[k] = one
    for k, run in enumerate(runs):
        if not made[k]:
            try:
                with others_turn():
                    made[k] = made_alone(run, keep, settle)
            except InputError as error:
                made[k] = error
    return made


def made_alone(run: RunInSpace, keep: Sequence[str], settle: float) -> dict[str, Any] | str:
    """One run, without peaks that are not kept; or why the solver could not make it. Raises InputError."""
    watches = any(name not in (*OF_RUN, "peak_u") for name in keep)
    structure, motion, duration = run
    structure = structure.with_settings(without=None if watches else ("peaks",))
    times = motion.start + ROWS * np.arange(math.floor(duration / ROWS + 1e-9) + 1, dtype=np.float64)
    try:
        found = simulate_structure(structure, motion, duration, times, settle=settle)
    except SolverError as failure:
        return str(failure)
    return {name: _value(name, found) for name in dict.fromkeys((*keep, "verdict", "path"))}


def _fallen(keep: Sequence[str], start: float) -> dict[str, Any]:
    """Results of a run that falls under its weight alone."""
    found: dict[str, Any] = dict.fromkeys(keep, math.nan)
    return found | {"verdict": "overturned", "overturn_time": start, "settled_for": 0.0, "path": SCALAR}


def _column(name: str, made: Sequence[Made]) -> Any:
    """The column of a result: a number of each run, or of each block, joint or tie; NaN fills what is missing."""
    if name in WORDS:
        words = [found[name] if isinstance(found, dict) else WORDS[name][0] for found in made]
        return np.array([WORDS[name].index(word) for word in words], dtype=np.uint8)
    values = [found[name] if isinstance(found, dict) else math.nan for found in made]
    if name in OF_RUN:
        return np.array(values)
    width = max(np.size(value) for value in values)
    table = np.full((len(made), width), math.nan)
    for row, value in zip(table, values, strict=True):
        row[: np.size(value)] = value
    return table


def _value(name: str, found: SpatialResponse) -> Any:
    """A result of a run, one of KEPT; words as such."""
    if name == "verdict":
        return found.verdict
    if name == "overturn_time":
        return found.overturn_time
    if name == "path":
        return SCALAR
    if name in OF_RUN:
        return found.stats[name]
    return found.peaks["contact" if name == "least_contact" else name.removeprefix("peak_")]
