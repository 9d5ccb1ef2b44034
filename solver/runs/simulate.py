"""A complete run: from a model and a base motion to a response."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, overload

from ..common.errors import (
    POSITIVE,
    InputError,
    InputWarning,
    SolverError,
    check_number,
    check_type,
    check_whole,
    shown,
)
from ..common.plausible import warn_of
from ..common.ranges import check_choice
from ..ground.loads import Load, loads_from, place_of, static_loads
from ..ground.motion import Motion, check_loads, check_strength
from ..models.column.model import Column
from ..models.column.packing import InitialState
from ..models.column.response import Response
from ..models.column.run import Callback
from ..models.column.settings import WITHOUT_STEP
from ..models.ports import Released
from ..models.protocol import OUTPUT_STEP, SETTLE, SETTLING, Kind, Model, RunPlan, output_times
from ..models.structure.model import Structure
from ..models.structure.response import SpatialResponse
from ..models.structure.run import Callback as SpatialCallback
from ..models.structure.run import SpatialState
from ..models.uncertainty import Spread
from .ensemble import ensemble_of
from .trust import judge, with_fine_settings

MOST_RUNS = 10**5
Loads = Mapping[str, Load | Mapping[str, Any]]


@overload
def simulate(
    column: Column,
    motion: Motion | str | os.PathLike[str],
    duration: float | None = None,
    formulation: str | None = None,
    integrator: str | None = None,
    step: float | None = None,
    tolerance: float | None = None,
    without: Sequence[str] | None = None,
    output_step: float | None = None,
    initial: InitialState | None = None,
    settle: float = SETTLE,
    check: bool = False,
    ensemble: int = 0,
    spread: Spread | None = None,
    callback: Callback | None = None,
    *,
    loads: Loads | None = None,
    release: Mapping[str, Mapping[str, float]] | None = None,
) -> Response: ...
@overload
def simulate(
    column: Structure,
    motion: Motion | str | os.PathLike[str],
    duration: float | None = None,
    *,
    tolerance: float | None = None,
    without: Sequence[str] | None = None,
    output_step: float | None = None,
    initial: SpatialState | None = None,
    settle: float = SETTLE,
    check: bool = False,
    ensemble: int = 0,
    spread: Spread | None = None,
    callback: SpatialCallback | None = None,
    loads: Loads | None = None,
    release: Mapping[str, Mapping[str, float]] | None = None,
    after_fall: float | None = None,
    plane: None = None,
) -> SpatialResponse: ...
@overload
def simulate(
    column: Structure,
    motion: Motion | str | os.PathLike[str],
    duration: float | None = None,
    *,
    tolerance: float | None = None,
    without: Sequence[str] | None = None,
    output_step: float | None = None,
    initial: SpatialState | None = None,
    settle: float = SETTLE,
    check: bool = False,
    ensemble: int = 0,
    spread: Spread | None = None,
    callback: SpatialCallback | Callback | None = None,
    loads: Loads | None = None,
    release: Mapping[str, Mapping[str, float]] | None = None,
    after_fall: float | None = None,
    plane: str,
) -> Response | SpatialResponse: ...
@overload
def simulate(column: Model, motion: Motion | str | os.PathLike[str], *args: Any, **options: Any) -> Any: ...
def simulate(
    column: Any,
    motion: Motion | str | os.PathLike[str],
    duration: float | None = None,
    formulation: str | None = None,
    integrator: str | None = None,
    step: float | None = None,
    tolerance: float | None = None,
    without: Sequence[str] | None = None,
    output_step: float | None = None,
    initial: Any = None,
    settle: float = SETTLE,
    check: bool = False,
    ensemble: int = 0,
    spread: Spread | None = None,
    callback: Any = None,
    plane: str | None = None,
    loads: Loads | None = None,
    release: Mapping[str, Mapping[str, float]] | None = None,
    after_fall: float | None = None,
) -> Any:
    """Compute the response of a column, or of a structure in space, to a base motion or a record in a file.

    The options beside `duration` and `initial` are in five groups:

    Loads; of columns and structures with ports (ground/loads.py). loads: port -> `Load`, or component (Fx, Fy, Fz, N;
    Mx, My, Mz, N m; in its plane a column has Fx, Fz, My) -> a number, constant over the run, or (times,
    values). release: port -> component -> number: rest under these loads, removed at the start.

    Accuracy; None keeps the setting of the column. tolerance: relative to the peak; not used by "paper".
    formulation, integrator, step (s): structures have none of these. without: names of settings.SKIPS, shortcuts that
    are switched off; "peaks": only those of ux are kept. plane: "auto" gives the Response of a column, with joints
    rigid along themselves, for a structure that is one, begins at rest and is shaken in the plane x, z alone
    (models/structure/stack.py).

    Output. output_step: s between the rows of the response; None: 0.005. It has no influence on the steps, and the
    peaks are those of the motion between the rows as well. callback: called as callback(t, Glance), of run.py of the
    model, with the time s reached, some times per second of wall-clock time and at the end of each run; an exception
    that it raises ends `simulate`.

    Verdict. settle: after `duration` the model is followed further, on a base that no longer accelerates, until it has
    fallen or cannot fall, for at most this time, s; the histories and the peaks end at `duration`. after_fall: s, for
    which the run of a structure goes on after its first fall, to which the verdict belongs: joints end where they have
    come apart, and any two blocks meet by the law of its table `neighbours`.

    Trust. check: repeat the run with a tenth of the tolerance (half of a fixed step): `estimated_error` and `horizon`
    of the response, and a verdict that is "undecided" where the two differ. ensemble: number of further runs, varied by
    `spread` (uncertainty.py; None: the defaults); their results are the `ensemble` of the response.

    Parameters
    ----------
    column : Column or Structure
        The model.
    motion : Motion or path-like
        Base motion, or a record file; the run begins at its start.
    duration : float, optional
        Length of the run, s. None: that of the motion. Beyond the motion the base does not accelerate.
    initial : InitialState or SpatialState, optional
        None: rest in static equilibrium.

    Returns
    -------
    Response or SpatialResponse

    Raises
    ------
    InputError
        If a value is wrong, or the run starts from a rest that is not stable.
    SolverError
        If the solver cannot go on.

    Warns
    -----
    InputWarning
        Of values that are probably not intended (plausible.py of common/ and ground/), and of blocks that pass into
        each other because no joint connects them.
    """
    if isinstance(motion, (str, os.PathLike)):
        motion = Motion.from_file(motion)
    if not isinstance(motion, Motion):
        raise InputError(f"motion = {shown(motion)}: must be a Motion or the path of a record")
    if not hasattr(column, "kind"):
        raise InputError(f"column = {shown(column)}: must be a Column or a Structure, as from_toml reads them")
    if spread is not None and not isinstance(spread, Spread):
        raise InputError(f"spread = {shown(spread)}: must be a Spread")
    # times of the run and of the rows
    check_strength(motion)
    duration = motion.duration if duration is None else _positive("duration", duration)
    output_step = OUTPUT_STEP if output_step is None else _positive("output_step", output_step)
    times = output_times(motion, duration, output_step)
    settle = check_number("settle", settle, *SETTLING)
    ensemble = check_whole("ensemble", ensemble, 0, MOST_RUNS, f"a number of runs from 0 to {MOST_RUNS}")
    # loads and initial state
    if loads:
        motion = motion.with_loads({**motion.loads, **loads_from(loads, motion.start, duration)})
    if release:
        if initial is not None:
            raise InputError("release: must be left out beside initial, both say how the run begins")
        if not column.kind.takes_loads:
            raise InputError(f"release: must be left out, a {column.kind.word} has no ports")
        initial = Released(static_loads("release", release, _ports_of(column)))
    if after_fall is not None:
        if not column.kind.across:
            raise InputError(f"after_fall = {shown(after_fall)}: must be left out, only a structure goes on")
        column = column.going_on(after_fall)
    if column.kind.takes_loads:  # other kinds refuse loads themselves
        for port in motion.loads:
            place_of("loads", port, _ports_of(column))
    check_loads(motion, duration)
    check_type("callback", callback, Callable, None)
    plan, spread = RunPlan(motion, duration, times, initial, settle, callback), Spread() if spread is None else spread
    if plane is not None:
        check_choice("plane", plane, ("auto",))
        column = column if initial is not None else column.kind.equivalent_model(column, motion)
    # settings that the kind of model has
    kind: Kind = column.kind
    kind.check_motion(motion)
    given: dict[str, Any] = {"formulation": formulation, "integrator": integrator, "step": step}
    given |= {"tolerance": tolerance, "without": without}
    for name, value in given.items():
        if value is not None and name not in kind.settings:
            raise InputError(f"{name} = {shown(value)}: must be left out, a {kind.word} has none")
    with _named_as_given(name for name, value in given.items() if value is not None):
        column = column.with_settings(**{name: value for name, value in given.items() if name in kind.settings})
        if step is not None and column.settings.formulation == "exact":
            raise InputError(f"step = {step}: {WITHOUT_STEP}")
        kind.load_for_single_runs()
        kind.check(column, from_rest=initial is None)
        finer = with_fine_settings(column) if check else None
        warn_of(kind.warnings(column, at_rest=initial is None))
        response, places = kind.single_run(column, plan)
    # repetition with smaller errors, ensemble
    if finer is not None:
        try:
            closer: Any = kind.single_run(finer, plan)
        except SolverError as failure:
            closer = failure, None
        judge(response, closer[0], places, closer[1])
    if ensemble:
        response.ensemble = ensemble_of(response, plan, ensemble, spread)
    for remark in response.remarks:
        warnings.warn(remark, InputWarning, stacklevel=2)
    return response


@contextmanager
def _named_as_given(names: Iterable[str]) -> Iterator[None]:
    """Let errors name the settings that were given as arguments as such, not as keys of the file."""
    try:
        yield
    except (InputError, SolverError) as error:
        for name in names:
            error.args = (str(error).replace(f"solver.{name}", name),)
        raise


def _ports_of(model: Any) -> list[str]:
    return [port.name for port in getattr(model, "ports", ())]


def _positive(key: str, value: float) -> float:
    return check_number(key, value, POSITIVE, "a positive time in s")
