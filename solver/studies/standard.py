"""The usual studies as functions: each builds a `Study`, runs it as `run_study` does, and returns its `Results`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..common.errors import POSITIVE, check_number, check_type
from ..common.tables import numbers_of
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
    """Run harmonic base motions of every frequency and amplitude: Figure 3 of the paper.

    With random parameters there is an ensemble at each point, whose spread shows where the response is chaotic.

    Parameters
    ----------
    column : Column, Structure or sequence of them
        The models.
    frequencies : sequence of float
        Frequencies (Hz).
    amplitudes : sequence of float
        Amplitudes of the base acceleration (g).
    duration : float
        Duration of the motion (s).
    **options
        Options of `run_study`; and of `Study`: name, random, samples, seed, keep, tolerance.

    Raises
    ------
    InputError
        As both do.
    """
    motion = Shaking(
        "harmonic", "harmonic", {"duration": check_number("duration", duration, POSITIVE, "a positive time in s")}
    )
    grid = {INTENSITY: amplitudes, "motion.frequency": frequencies}
    return _run("sweep", column, motion, grid, Measure("pga"), options)


def ida(
    column: Columns, motions: Motions, levels: Sequence[float], *, measure: Measure | None = None, **options: Any
) -> Results:
    """Run an incremental dynamic analysis: each motion scaled to each level of the measure.

    `statistics.ida_curves` computes the percentiles from the results.

    Parameters
    ----------
    column : Column, Structure or sequence of them
        The models.
    motions : Motion, Shaking, mapping or sequence
        The motions.
    levels : sequence of float
        Levels of the measure, in its unit.
    measure : Measure, optional
        Measure of intensity, by default PGA (g).
    **options
        As in `sweep`.
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
    """Run the samples for a fragility: a probability of failure over the measure, by `statistics.fit_fragility`.

    Parameters
    ----------
    column : Column, Structure or sequence of them
        The models.
    motions : Motion, Shaking, mapping or sequence
        The motions.
    random : mapping
        Random parameters by name.
    samples : int
        Number of samples.
    levels : sequence of float, optional
        Levels of the measure to which each motion is scaled. None: `random` has "intensity", or the motions are not
        scaled.
    measure : Measure, optional
        Measure of intensity, by default PGA (g).
    **options
        As in `sweep`; `limits` too.
    """
    grid = {} if levels is None else {INTENSITY: levels}
    options |= {"random": random, "samples": samples}
    return _run("fragility", column, motions, grid, measure or Measure("pga"), options)


def spectrum(
    column: Model, motions: Motions, sizes: Sequence[float], slendernesses: Sequence[float], **options: Any
) -> Results:
    """Run a rocking spectrum: the column in every size and slenderness.

    See models/column/numbers.py for the other numbers that change with them.

    Parameters
    ----------
    column : Column
        The column.
    motions : Motion, Shaking, mapping or sequence
        The motions.
    sizes : sequence of float
        Factors on all lengths.
    slendernesses : sequence of float
        Ratios of height to width.
    **options
        As in `sweep`.
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
    """Run samples of the random parameters under each motion.

    `statistics.influences` computes which parameter has the largest effect.

    Parameters
    ----------
    column : Column, Structure or sequence of them
        The models.
    motions : Motion, Shaking, mapping or sequence
        The motions.
    random : mapping
        Random parameters by name.
    samples : int
        Number of samples.
    measure : Measure, optional
        Measure of intensity that is kept.
    **options
        As in `sweep`; `sampling` too: latin-hypercube, sobol or random.
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
    check_type("random", random, Mapping)
    check_type("measure", measure, Measure, None)
    study = Study(
        kind=kind,
        columns=tuple(column) if isinstance(column, Sequence) else (column,),
        motions=_shakings(motions),
        grid={key: tuple(numbers_of(key, values, 1).tolist()) for key, values in grid.items()},
        random={
            key: parameter if isinstance(parameter, Random) else Random.from_table(f"random.{key}", parameter)
            for key, parameter in random.items()
        },
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
    check_type("motions", motions, Sequence)
    return tuple(motions)
