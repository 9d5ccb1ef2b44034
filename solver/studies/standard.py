"""The usual studies as functions: each builds a `Study`, runs it as `run_study` does, and returns its `Results`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..ground.motion import Motion
from ..models.protocol import Model
from .definition import INTENSITY, Study
from .distributions import Random
from .execution import run_study
from .motions import Measure, Shaking
from .results import Results

Columns = Model | Sequence[Model]
Motions = Motion | Shaking | Sequence[Shaking] | Mapping[str, Motion]
Randoms = Mapping[str, Random | Mapping[str, Any]]


def sweep(
    column: Columns, frequencies: Sequence[float], amplitudes: Sequence[float], duration: float = 20.0, **options: Any
) -> Results:
    """Harmonic base motion of every frequency, Hz, and amplitude, g, for `duration`, s: Figure 3 of the paper.

    options: of `run_study`; and of `Study`: name, random, samples, seed, keep, tolerance. With random parameters there
    is an ensemble at each point, whose spread tells where the response is chaotic. Raises InputError as both do.
    """
    motion = Shaking("harmonic", "harmonic", {"duration": float(duration)})
    grid = {INTENSITY: amplitudes, "motion.frequency": frequencies}
    return _run("sweep", column, motion, grid, Measure("pga"), options)


def ida(
    column: Columns, motions: Motions, levels: Sequence[float], *, measure: Measure | None = None, **options: Any
) -> Results:
    """Incremental dynamic analysis: each motion scaled to each level of the measure (None: PGA, g).

    `statistics.ida_curves` takes the percentiles from the results. The rest as in `sweep`.
    """
    return _run("ida", column, motions, {INTENSITY: levels}, measure or Measure("pga"), options)


def fragility(
    column: Columns,
    motions: Motions,
    random: Randoms,
    samples: int,
    *,
    levels: Sequence[float] | None = None,
    measure: Measure | None = None,
    **options: Any,
) -> Results:
    """Runs of which `statistics.fit_fragility` makes a probability of failure over the measure (None: PGA, g).

    levels: to which each motion is scaled; None: `random` has "intensity", or the motions are as strong as they are.
    The rest as in `sweep`; `limits` too.
    """
    grid = {} if levels is None else {INTENSITY: levels}
    options |= {"random": random, "samples": samples}
    return _run("fragility", column, motions, grid, measure or Measure("pga"), options)


def spectrum(
    column: Model, motions: Motions, sizes: Sequence[float], slendernesses: Sequence[float], **options: Any
) -> Results:
    """Rocking spectrum: the column in every size, a factor on all lengths, and slenderness, height over width.

    See models/column/numbers.py for what else changes with them. The rest as in `sweep`.
    """
    grid = {"column.size": sizes, "column.slenderness": slendernesses}
    return _run("spectrum", column, motions, grid, None, options)


def montecarlo(
    column: Columns,
    motions: Motions,
    random: Randoms,
    samples: int,
    *,
    measure: Measure | None = None,
    **options: Any,
) -> Results:
    """Samples of the random parameters under each motion; sampling: latin-hypercube, sobol or random.

    `statistics.influences` tells which parameter does most. The rest as in `sweep`.
    """
    return _run("montecarlo", column, motions, {}, measure, options | {"random": random, "samples": samples})


_OF_STUDY = ("name", "samples", "seed", "keep", "tolerance", "duration", "limits", "sampling")


def _run(
    kind: str,
    column: Columns,
    motions: Motions,
    grid: Mapping[str, Sequence[float]],
    measure: Measure | None,
    options: dict[str, Any],
) -> Results:
    of_study = {"name": kind} | {key: options.pop(key) for key in _OF_STUDY if key in options}
    random: Randoms = options.pop("random", None) or {}
    folder: str | Path | None = options.pop("folder", None)
    study = Study(
        kind=kind,
        columns=tuple(column) if isinstance(column, Sequence) else (column,),
        motions=_shakings(motions),
        grid={key: tuple(float(value) for value in values) for key, values in grid.items()},
        random={key: _random(key, parameter) for key, parameter in random.items()},
        measure=measure,
        **of_study,
    )
    return run_study(study, folder, **options)


def _shakings(motions: Motions) -> tuple[Shaking, ...]:
    if isinstance(motions, Motion):
        return (Shaking("motion", record=motions),)
    if isinstance(motions, Shaking):
        return (motions,)
    if isinstance(motions, Mapping):
        return tuple(Shaking(name, record=motion) for name, motion in motions.items())
    return tuple(motions)


def _random(name: str, parameter: Random | Mapping[str, Any]) -> Random:
    return parameter if isinstance(parameter, Random) else Random.from_table(f"random.{name}", parameter)
