"""The definition of a study: models, motions and varied numbers; every run follows from its number.

The runs are numbered column by column, motion by motion, through the grid (its last name changes fastest), and sample
by sample of the random parameters, which are the same samples at every point of the grid.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .. import __version__
from ..common.errors import (
    FINITE,
    POSITIVE,
    InputError,
    UnknownKeyError,
    check_number,
    check_whole,
    needing,
    reading,
    shown,
    whole,
)
from ..common.files import check_file_name, toml_of
from ..common.notebook import NotebookRepr, counted
from ..common.ranges import check_choice, check_keys
from ..ground.motion import Motion, bytes_beside_samples
from ..kernels.machine.sources import SOURCES
from ..models.column.model import Column
from ..models.column.numbers import SLENDERNESS
from ..models.protocol import FloatArray, Model, Run
from ..models.structure.model import Structure
from .distributions import Random
from .motions import BESIDE, DIRECTION, IN_PLANE, LOAD_SCALE, OF_MOTION, OF_SPACE, SPECTRAL, Measure, Shaking, tilted
from .subjects import always_kept, check_alike, sizes_of

KINDS = ("sweep", "ida", "fragility", "spectrum", "montecarlo")
SAMPLINGS = ("latin-hypercube", "sobol", "random")
LIMITED = "fragility"
SUBJECTS = ("column", "columns", "structure", "structures")  # keys of the file: paths of the models
INTENSITY = "intensity"
MOST_RUNS = 10**8
QUICK_RUNS, QUICK_VALUES = 200, 5  # of a quick study: runs, and values of each name of the grid
_SIMPLE = ("samples", "sampling", "seed", "tolerance", "duration")
_KEYS = (
    *("name", "kind", *SUBJECTS, "motion", "grid", "random", "intensity", "samples", "sampling", "seed"),
    *("keep", "tolerance", "duration", "limits"),
)


class Planned(NamedTuple):
    """A run of a study, ready to be simulated, with the numbers it was made from."""

    run: Run
    values: dict[str, float]  # varied numbers, by name
    measures: dict[str, float]  # of the motion as run: pga (g), pgv (m/s), sa or RotD (g)


@dataclass(frozen=True, eq=False, repr=False)
class Study(NotebookRepr):
    """A study: the models, the motions, and the numbers that vary between its runs.

    Names of numbers are those of of_column.py, for structures those of of_structure.py; `motion.KEY` for a number of
    the motions; and `intensity` for the value of `measure` to which the motion is scaled.

    Attributes
    ----------
    name
        Name of the study and of its files.
    kind
        One of KINDS, which decides the picture.
    columns
        Columns, or structures in space.
    motions
        Base motions.
    grid
        Values of the grid by name.
    random
        Random parameters by name.
    measure
        Measure of intensity, or None.
    samples
        Number of samples of the random parameters.
    sampling
        Method by which they are drawn, one of SAMPLINGS.
    seed
        Seed of the samples.
    keep
        Outputs, as in `simulate_many`.
    tolerance
        Error tolerance of the runs; None for that of each model.
    duration
        Duration of every run (s); None for that of its motion.
    limits
        Largest displacements (m) beyond which a column counts as failed, as it does when it overturns.

    Raises
    ------
    InputError
        If values do not fit together.
    """

    name: str
    kind: str
    columns: tuple[Model, ...]
    motions: tuple[Shaking, ...]
    grid: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    random: Mapping[str, Random] = field(default_factory=dict)
    measure: Measure | None = None
    samples: int = 1
    sampling: str = SAMPLINGS[0]
    seed: int = 0
    keep: tuple[str, ...] = ()  # empty: the outputs that are always kept
    tolerance: float | None = None
    duration: float | None = None
    limits: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        # name, kind, sampling and numbers
        check_file_name("name", self.name)
        check_choice("kind", self.kind, KINDS)
        check_choice("sampling", self.sampling, SAMPLINGS)
        if not self.columns or not self.motions:
            raise InputError("column, motion: must be one of each at least")
        for key, least in (("samples", 1), ("seed", 0)):
            value = check_whole(key, getattr(self, key), least, math.inf, f"a whole number, at least {least}")
            object.__setattr__(self, key, value)
        if self.duration is not None:
            check_number("duration", self.duration, POSITIVE, "a positive time in s")
        if self.limits and self.kind != LIMITED:
            raise InputError(f'limits: must be left out, only kind = "{LIMITED}" has failures by displacement')
        for k, limit in enumerate(self.limits, start=1):
            check_number(f"limits[{k}]", limit, POSITIVE, "a positive displacement in m")
        # models and outputs
        check_alike(self.columns)
        kind = self.columns[0].kind
        always = always_kept(kind)
        object.__setattr__(self, "keep", tuple(self.keep) or always)
        for name in self.keep:
            check_choice("keep", name, tuple(kind.kept))
            if self.keep.count(name) > 1:
                raise InputError(f"keep: {name} must be there once")
        for name in always:
            if name not in self.keep:
                raise InputError(f"keep: must have {name}, which every picture and table needs")
        for column in self.columns:
            column.kind.check_kept(column, self.keep)
        if self.tolerance is not None:  # checked as the columns' own
            self.columns[0].with_settings(tolerance=self.tolerance)
        self._check_names()
        if self.runs > MOST_RUNS:
            raise InputError(f"samples: {shown(self.runs)} runs in all, must be at most {MOST_RUNS}")

    def _check_names(self) -> None:
        twice = set(self.grid) & set(self.random)
        if twice:
            raise InputError(f"random.{min(twice)}: must not be in the grid too")
        # numbers that all motions have
        known = set.intersection(*(Shaking.numbers_of(shaking.formula) for shaking in self.motions))
        if not self.in_space:
            known -= {*OF_SPACE}
            for k, shaking in enumerate(self.motions, start=1):
                shaking.check_in_plane(f"motion[{k}]")
        # each varied name must belong to intensity, motions or models
        for name in (*self.grid, *self.random):
            if name == INTENSITY:
                if name in self.random and self.random[name].relative:
                    raise InputError(f"random.{name}.relative: must be left out, a motion has no {name} to multiply")
                if self.measure is None:
                    raise InputError(f"intensity.measure: missing, {INTENSITY} is varied")
            elif name.startswith(OF_MOTION):
                key = name.removeprefix(OF_MOTION)
                if key in OF_SPACE and not self.in_space:
                    raise InputError(f"{name}: must be left out, {IN_PLANE}")
                if key not in known:
                    listed = ", ".join(f"motion.{item}" for item in sorted(known))
                    raise InputError(f"{name}: unknown name, the motions have {listed}")
            elif not all(column.kind.has_number(column, name) for column in self.columns):
                of = "column" if self.columns[0].kind.has_number(self.columns[0], "block.height") else "structure"
                raise InputError(f"{name}: unknown name, must be of the {of} as joint.stiffness or block[1].height")
            elif name == SLENDERNESS:
                for column in self.columns:  # raises where an inertia would not follow
                    column.kind.with_numbers(column, {name: (1.0, True)})
            elif not all(column.kind.numbers_of(column, name) for column in self.columns):
                raise InputError(f"{name}: must be left out, a model has none")
            else:
                self._check_there(name)
        self._check_overlaps()
        for name, values in self.grid.items():
            if not values:
                raise InputError(f"grid.{name}: is empty, must be a list of numbers")
            if len(set(values)) < len(values):
                raise InputError(f"grid.{name}: has a value twice, must have each once")
            if name == INTENSITY and min(values) < 0.0:
                raise InputError(f"grid.{name} = {min(values):g}: must be zero or positive; motion.scale = -1 reverses")
        if not self.random and self.samples != 1:
            raise InputError(f"samples = {self.samples}: must be 1 where nothing is random")
        for name, parameter in self.random.items():
            if parameter.each and len({len(column.kind.numbers_of(column, name)) for column in self.columns}) > 1:
                raise InputError(f"random.{name}.each: must be left out for columns of different numbers of blocks")

    def _check_there(self, name: str) -> None:
        """Raise InputError if a model has no number of this name; whether a value suits it is not checked."""
        for column in self.columns:
            try:
                column.kind.with_numbers(column, {name: (1.0, False)})
            except UnknownKeyError as error:
                raise InputError(f"{name}: {str(error).removeprefix(f'{name}: ')}") from None
            except InputError:  # of the value
                pass

    def _check_overlaps(self) -> None:
        """Raise InputError if two varied names set the same number; relative ones multiply it, in any order."""
        keys = {name: f"grid.{name}" for name in self.grid}
        keys |= {name: f"random.{name}" for name, parameter in self.random.items() if not parameter.relative}
        if INTENSITY in (*self.grid, *self.random):
            self._check_scales()
        for column in self.columns:
            setting: dict[str, str] = {}  # names that set each number
            for name, key in keys.items():
                for place in column.kind.numbers_set(column, name):
                    if setting.setdefault(place, key) != key:
                        raise InputError(f"{key}: sets {place} as {setting[place]} does, must be relative or left out")

    def _check_scales(self) -> None:
        """Raise InputError if the size of a motion is set beside its intensity."""
        sizes = {f"{OF_MOTION}{size}" for shaking in self.motions if (size := shaking.amplitude)}
        for name in sizes & {*self.grid, *self.random}:
            raise InputError(f"{name}: must be left out where {INTENSITY} is varied, which sets it")
        name = f"{OF_MOTION}scale"
        scales: dict[str, Sequence[float]] = {
            f"motion[{k}].scale": [one.numbers.get("scale", 1.0)] for k, one in enumerate(self.motions, start=1)
        }
        scales[f"grid.{name}"] = self.grid.get(name, ())
        if name in self.random:
            scales[f"random.{name}"] = dict(self.random[name].distribution.numbers).get("values", (math.nan,))
        for key, values in scales.items():
            if not {1.0, -1.0}.issuperset(values):
                raise InputError(f"{key}: must be 1, or -1 to reverse the motion, where {INTENSITY} is varied")

    def _facts(self) -> tuple[str, ...]:
        numbers = {"run": self.runs, "column": len(self.columns), "motion": len(self.motions), "sample": self.samples}
        return self.name, self.kind, *(counted(number, word) for word, number in numbers.items())

    def _lines(self) -> Iterable[Sequence[object]]:
        yield "varied", "by"
        yield from (
            (name, f"{len(values)} values, {values[0]:g} to {values[-1]:g}") for name, values in self.grid.items()
        )
        yield from ((name, parameter.distribution.kind) for name, parameter in self.random.items())

    # the runs

    @property
    def shape(self) -> tuple[int, ...]:
        """The numbers of columns, motions, values of each name of the grid, and samples; their product is `runs`."""
        return (len(self.columns), len(self.motions), *(len(values) for values in self.grid.values()), self.samples)

    @property
    def runs(self) -> int:
        """The number of runs."""
        return math.prod(self.shape)

    @property
    def blocks(self) -> int:
        """The largest number of blocks of a model."""
        return sizes_of(self.columns)["block"]

    @property
    def in_space(self) -> bool:
        """True if the models are structures in space."""
        return self.columns[0].kind.across

    @cached_property
    def varied(self) -> tuple[str, ...]:
        """The names of the numbers that define a run; `column` and `motion` are indices from 0."""
        return ("column", "motion", *self.grid, *(each for name in self.random for each in self._each(name)))

    @property
    def usual_intensity(self) -> float:
        """The largest intensity of the grid, or the median of the drawn ones; 0 if none is varied."""
        if INTENSITY not in self.random:
            return max(self.grid.get(INTENSITY, (0.0,)))
        place = self.varied.index(INTENSITY) - len(self.shape) + 1
        return float(np.median(_drawn_of(self)[:, place]))

    @property
    def measured(self) -> tuple[str, ...]:
        """The names of the measures of a motion that are kept."""
        own = () if self.measure is None or self.measure.name not in SPECTRAL else (self.measure.name,)
        return ("pga", "pgv", *own)

    def run(self, number: int) -> Planned:
        """Return the run of a number, from 0. Raises InputError if a value does not suit the column or the motion."""
        values = self.values(number)
        column = _column(self, int(values["column"]), tuple([values[name] for name in self._of_columns]))
        motion, base, measures = self._shaken(values, column.g)
        duration = motion.duration
        if self.duration is not None:
            duration = self.duration + (motion.duration - base.duration)  # plus the time in which the base is tilted
        shaking = self.motions[int(values["motion"])]
        factor = {**shaking.numbers, **self._numbers(values, shaking)}.get(LOAD_SCALE)
        motion = shaking.with_loads(motion, base, duration, factor)
        return Planned(Run(column, motion, duration), values, measures)

    def values(self, number: int) -> dict[str, float]:
        """Return the varied numbers of a run, by name."""
        place = np.unravel_index(number, self.shape)
        values = {"column": float(place[0]), "motion": float(place[1])}
        for (name, items), k in zip(self.grid.items(), place[2:-1], strict=True):
            values[name] = items[int(k)]
        # random parameters, which follow the names of the grid
        drawn = _drawn_of(self)[int(place[-1])].tolist()
        values.update(zip(self.varied[len(values) :], drawn, strict=True))
        return values

    def _each(self, name: str) -> Sequence[str]:
        """Return the names of the numbers of a random parameter."""
        column = self.columns[0]
        return column.kind.numbers_of(column, name) if self.random[name].each else [name]

    @cached_property
    def _of_columns(self) -> dict[str, bool]:
        """The names of the varied numbers of the columns, and whether each multiplies the present value."""
        names = [name for name in self.varied if name not in ("column", "motion", INTENSITY)]
        return {name: self._relative(name) for name in names if not name.startswith(OF_MOTION)}

    @cached_property
    def _of_motions(self) -> dict[str, tuple[str, bool]]:
        """The names of the varied numbers of the motions, with their keys, and whether each multiplies."""
        names = [name for name in self.varied if name.startswith(OF_MOTION)]
        return {name: (name.removeprefix(OF_MOTION), self._relative(name)) for name in names}

    @cached_property
    def _parameters(self) -> dict[str, Random]:
        """The random parameters by the names of their numbers; the names of the grid have none."""
        return {each: parameter for name, parameter in self.random.items() for each in self._each(name)}

    def _relative(self, name: str) -> bool:
        return name in self._parameters and self._parameters[name].relative

    def _numbers(self, values: Mapping[str, float], shaking: Shaking) -> dict[str, float]:
        """Return the varied numbers of a motion, by its keys."""
        found = {}
        for name, (key, relative) in self._of_motions.items():
            value = values[name]
            if relative:
                if key not in shaking.numbers and key not in ("scale", LOAD_SCALE):
                    raise InputError(f"{name}: {shaking.name} has none that could be multiplied")
                value *= shaking.numbers.get(key, 1.0)
            found[key] = value
        return found

    def _shaken(self, values: Mapping[str, float], g: float) -> tuple[Motion, Motion, dict[str, float]]:
        """Return the motion as run without its loads, that before scaling and tilting, and the measures of the former.

        On a floor the measures are those of the ground, the two motions those of the floor. `g` is the gravity of the
        model, m/s2.
        """
        # the motion before scaling, and its measures
        which = int(values["motion"])
        shaking = self.motions[which]
        numbers = self._numbers(values, shaking)
        shape = tuple(item for item in numbers.items() if item[0] not in BESIDE)
        base, measures = _base(self, which, shape, INTENSITY in values)
        # factor: that of the motion, times the one to the intensity
        given = {**shaking.numbers, **numbers}
        factor = given.get("scale", 1.0)
        if self.measure is not None and INTENSITY in values:
            if values[INTENSITY] < 0.0:
                raise InputError(f"{INTENSITY} = {values[INTENSITY]:g}: is drawn, must be zero or positive")
            present = measures[self.measure.name]
            if present == 0.0:
                zero = f"{shaking.name} has a {self.measure.label} of zero"
                raise InputError(f"motion[{which + 1}]: {zero}, it cannot be scaled to an {INTENSITY}")
            factor *= values[INTENSITY] / present
        # scale, rotate in plan, tilt; a building, being linear, is solved once for all factors
        size, direction = abs(factor), given.get(DIRECTION, 0.0)
        if shaking.building is None:
            motion = base.scaled(factor).turned(direction)
        else:
            base = _on_floor(self, which, shape, INTENSITY in values, direction)
            motion = base.scaled(factor)
        motion = tilted(motion, given.get("tilt", 0.0), g)
        return motion, base, {name: size * value for name, value in measures.items()}

    # identity and files

    def to_dict(self) -> dict[str, Any]:
        """Return all data on which the results depend, as numbers, texts, lists and dicts."""
        return {
            "name": self.name,
            "kind": self.kind,
            "columns": [column.to_dict() for column in self.columns],
            "motions": [{**shaking.to_table(), "samples": _digest(shaking.record)} for shaking in self.motions],
            "grid": {name: list(values) for name, values in self.grid.items()},
            "random": {name: parameter.to_table() for name, parameter in self.random.items()},
            "intensity": None if self.measure is None else self.measure.to_table(),
            **{key: getattr(self, key) for key in _SIMPLE},
            "keep": list(self.keep),
            "limits": list(self.limits),
        }

    @property
    def fingerprint(self) -> str:
        """The hash that identifies the study, so that results of another one are recognized."""
        text = json.dumps(self.to_dict(), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Study:
        """Read a study; paths in it are relative to its folder. Raises InputError that begins with `path`."""
        with reading(path):
            return cls.from_dict(toml_of(path), Path(path).parent)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], folder: str | os.PathLike[str] = ".") -> Study:
        """Build a study from the mapping that a TOML file holds (docs/studies.md).

        Paths in it are relative to `folder`. Raises InputError.
        """
        check_keys("", data, _KEYS)
        for key in ("name", "kind"):
            if key not in data:
                raise InputError(f"{key}: missing, must be a text")
        tables = data.get("motion", [])
        if not isinstance(tables, list) or not tables or not all(isinstance(table, Mapping) for table in tables):
            raise InputError("motion: must be one table [[motion]] for each motion")
        # optional keys
        simple = {key: data[key] for key in _SIMPLE if key in data}
        if "keep" in data:
            simple["keep"] = tuple(_texts("keep", data["keep"]))
        if "limits" in data:
            simple["limits"] = axis("limits", data["limits"])
        made = Structure if {"structure", "structures"} & data.keys() else Column
        return cls(
            name=data["name"],
            kind=data["kind"],
            columns=tuple(made.from_toml(Path(folder) / path) for path in _paths(data)),
            motions=tuple(
                Shaking.from_table(f"motion[{k}]", table, Path(folder)) for k, table in enumerate(tables, start=1)
            ),
            grid={name: axis(f"grid.{name}", values) for name, values in _table("grid", data).items()},
            random={name: Random.from_table(f"random.{name}", table) for name, table in _table("random", data).items()},
            measure=Measure.from_table(_table("intensity", data)) if "intensity" in data else None,
            **simple,
        )

    def with_runs(self, samples: int) -> Study:
        """Return the study with another number of samples of its random parameters."""
        return replace(self, samples=samples)

    def quick(self) -> Study:
        """Return a smaller study, NAME-quick, of some 200 runs at most.

        It has five values of each name of the grid (the first, the last and some between) and few samples. All columns
        and motions are kept.
        """
        grid = {name: _thinned(values) for name, values in self.grid.items()}
        points = math.prod((len(self.columns), len(self.motions), *map(len, grid.values())))
        samples = min(self.samples, max(1, QUICK_RUNS // points))
        return replace(self, name=f"{self.name}-quick", grid=grid, samples=samples)


def versions() -> dict[str, str]:
    """Return the versions on which the numbers depend: results of other versions must not be mixed with them."""
    found = {"multiblock-fmu": __version__, "kernels": SOURCES, "numpy": np.__version__}
    with needing("studies", "scipy"):
        import scipy
    return {**found, "scipy": scipy.__version__}


def axis(key: str, values: object) -> tuple[float, ...]:
    """Return the values of a grid.

    `values` is a list of numbers, or {from, to, count} with spacing = "linear" or "log"; `key` names it in errors.
    Raises InputError.
    """
    if isinstance(values, Mapping):
        check_keys(f"{key}.", values, ("from", "to", "count", "spacing"))
        spacing = values.get("spacing", "linear")
        check_choice(f"{key}.spacing", spacing, ("linear", "log"))
        limits = POSITIVE if spacing == "log" else FINITE
        first, last = (check_number(f"{key}.{name}", values.get(name), limits, "a number") for name in ("from", "to"))
        count = check_whole(f"{key}.count", whole(values.get("count")), 2, 1e6, "a whole number, at least 2")
        points = np.geomspace(first, last, count) if spacing == "log" else np.linspace(first, last, count)
        return tuple(float(f"{value:.12g}") for value in points)
    if not isinstance(values, Sequence) or isinstance(values, str):
        raise InputError(f"{key} = {shown(values)}: must be a list of numbers, or a table of from, to and count")
    return tuple(check_number(f"{key}[{k}]", value, FINITE, "a number") for k, value in enumerate(values, start=1))


# caches of data that every run needs


@lru_cache(maxsize=8)
def _columns(study: Study) -> tuple[Model, ...]:
    """Return the columns at the tolerance of the study."""
    return tuple(column.with_settings(tolerance=study.tolerance) for column in study.columns)


@lru_cache(maxsize=256)
def _column(study: Study, which: int, numbers: tuple[float, ...]) -> Any:
    """Return a column with the numbers that `_of_columns` names; cached, for it is the same for all motions."""
    given = {name: (number, flag) for (name, flag), number in zip(study._of_columns.items(), numbers, strict=True)}
    model = _columns(study)[which]
    return model.kind.with_numbers(model, given)


@lru_cache(maxsize=8)
def _drawn_of(study: Study) -> FloatArray:
    """Return the values of the random parameters, (samples, numbers), in the order of `Study.varied`."""
    owners = tuple(parameter for name, parameter in study.random.items() for _ in study._each(name))
    return _drawn(owners, study.samples, study.sampling, study.seed)


@lru_cache(maxsize=8)  # a worker gets a new but equal study with every chunk
def _drawn(random: tuple[Random, ...], samples: int, sampling: str, seed: int) -> FloatArray:
    if not random:
        return np.empty((samples, 0))
    quantiles = _quantiles(len(random), samples, sampling, seed)
    return np.column_stack([parameter.distribution.at(quantiles[:, k]) for k, parameter in enumerate(random)])


def _quantiles(numbers: int, samples: int, sampling: str, seed: int) -> FloatArray:
    rng = np.random.default_rng(seed)
    if sampling == "random":
        return rng.random((samples, numbers))
    with needing("studies", "scipy"):
        from scipy.stats import qmc
    if sampling == "latin-hypercube":
        drawn = qmc.LatinHypercube(numbers, rng=rng).random(samples)
    else:
        whole = max(0, math.ceil(math.log2(samples)))
        drawn = qmc.Sobol(numbers, rng=rng).random_base2(whole)[:samples]
    return np.clip(np.asarray(drawn, dtype=np.float64), 2.0**-53, 1.0 - 2.0**-53)


@lru_cache(maxsize=256)
def _base(
    study: Study, motion: int, numbers: tuple[tuple[str, float], ...], unit: bool
) -> tuple[Motion, dict[str, float]]:
    """Return a motion before it is scaled, and its measures.

    `numbers` are the varied ones by key; `unit` is True if the motion is scaled to an intensity, so its size does not
    matter.
    """
    made = study.motions[motion].base(dict(numbers), unit)
    if not (np.any(made.ax) or made.amplitude or made.has_ay):
        return made, dict.fromkeys(study.measured, 0.0)
    given = study.measure
    measures = (given if given is not None and given.name == name else Measure(name) for name in study.measured)
    return made, {measure.name: measure.of(made) for measure in measures}


@lru_cache(maxsize=16)
def _on_floor(
    study: Study, motion: int, numbers: tuple[tuple[str, float], ...], unit: bool, direction: float
) -> Motion:
    """Return `_base` turned in plan, as the floor of its building moves under it."""
    return study.motions[motion].of_floor(_base(study, motion, numbers, unit)[0].turned(direction))


def _thinned(values: tuple[float, ...]) -> tuple[float, ...]:
    places = np.linspace(0, len(values) - 1, min(QUICK_VALUES, len(values)))
    return tuple(values[round(place)] for place in places.tolist())


def _table(key: str, data: Mapping[str, Any]) -> Mapping[str, Any]:
    found = data.get(key, {})
    if not isinstance(found, Mapping):
        raise InputError(f"{key} = {shown(found)}: must be a table")
    return found


def _texts(key: str, value: object) -> list[str]:
    if not isinstance(value, (list, tuple)) or not value or not all(isinstance(item, str) for item in value):
        raise InputError(f"{key} = {shown(value)}: must be a list of texts")
    return list(value)


def _paths(data: Mapping[str, Any]) -> list[str]:
    given = [key for key in SUBJECTS if key in data]
    if len(given) != 1:
        raise InputError(
            "column: must be the path of a column file, or columns a list of them; or structure, structures"
        )
    key = given[0]
    return _texts(key, data[key] if key.endswith("s") else [data[key]])


def _digest(motion: Motion | None) -> str:
    """Return a hash of a record without its loads, "" of none; held samples and harmonics have more than samples."""
    if motion is None:
        return ""
    content = hashlib.sha256()
    for array in (motion.time, motion.ax, motion.az, *([motion.ay] if motion.has_ay else [])):
        content.update(np.ascontiguousarray(array).tobytes())
    if motion.hold or motion.amplitude or motion.amplitude_y:
        content.update(bytes_beside_samples(motion))
    return content.hexdigest()[:16]
