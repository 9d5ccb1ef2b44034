"""The protocol of all models: a column in its plane, a structure in space.

A model is data. Its `kind` has what all models of that kind share: how they run, alone or eight at once in lanes, and
which results of their runs can be stored.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import singledispatch
from typing import Any, ClassVar, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from ..common.aliases import warn_of_old
from ..common.errors import NOT_NEGATIVE, InputError, shown
from ..ground.motion import Motion, check_in_plane
from .outputs import BASE, Output
from .uncertainty import Varied

FloatArray = NDArray[np.float64]

OVERTURNED, STANDING, UNDECIDED = "overturned", "standing", "undecided"
SCALAR, LANES = "scalar", "lanes"  # how a run is made: alone, or with seven others
LOADED = "loads on ports"  # the reason to run it alone
# results that are words, which a table stores as codes: 10^6 words would take as much memory as all the rest
WORDS: dict[str, tuple[str, ...]] = {"verdict": (UNDECIDED, STANDING, OVERTURNED), "path": (SCALAR, LANES)}

OUTPUT_STEP = 0.005  # s between the rows of a response by default
MOST_ROWS = 10**8
SETTLE = 60.0  # s, the default maximum time that a model is followed after the motion
SETTLING = NOT_NEGATIVE, "a time in s, zero or positive"


class NoRestError(InputError):
    """A model that does not stand under its weight."""


class Run(NamedTuple):
    """One of many runs, from rest."""

    model: Any
    motion: Motion
    duration: float  # s


class RunPlan(NamedTuple):
    """The plan of a run: its motion, duration (s), the times of its rows (s)."""

    motion: Motion
    duration: float
    times: FloatArray
    initial: Any = None  # None: rest; else an initial state of the kind of model
    settle: float = 0.0  # s, the longest time that the model is followed after the duration
    callback: Callable[[float, Any], object] | None = None  # called with the time (s) and a summary of the state


class Verdict(NamedTuple):
    """The verdict on a run: the word, the reason as a sentence, and the time at which it was known (s)."""

    word: str
    reason: str
    time: float


class Kept(NamedTuple):
    """A result of a run that can be stored."""

    unit: str = ""
    kind: Any = None  # the type of a single value; None: a number of each owner
    of: str = "block"  # or joint, tie, base: see Model.sizes


# results of every run; verdict and path are codes of WORDS
OF_RUN = {
    "verdict": Kept(kind=np.uint8),
    "overturn_time": Kept("s", np.float64),
    "steps": Kept(kind=np.int64),
    "path": Kept(kind=np.uint8),
}


def kept_peaks(outputs: Sequence[Output]) -> dict[str, Kept]:
    """Return the extremes of outputs as results that can be stored, by name; those of the base last."""
    return {
        output.kept: Kept(output.unit, np.float64 if output.is_single else None, output.owner)
        for output in sorted(outputs, key=lambda output: output.owner == BASE)
    }


class Lanes(NamedTuple):
    """The use of lanes for runs of a model."""

    why_not: str  # the reason against lanes, "" if they are used
    share: Hashable  # the key that runs in common lanes share
    first_step: float  # s


class Work(NamedTuple):
    """The approximate cost of a run and of each second of it; 1 is a block of a column for a second in lanes."""

    run: float
    second: float

    def of(self, duration: float) -> float:
        """Return the cost of a run of this duration (s)."""
        return self.run + self.second * duration


@dataclass(frozen=True)
class CommonSettings:
    """The settings of every model."""

    tolerance: float = 1e-6  # relative error of a run
    integrator: str = ""
    without: tuple[str, ...] = ()  # omitted features, in the words of the kind


class Law(Protocol):
    """The law of a joint: modulus (N/m3), damping (s) and coefficient of friction, None without sliding."""

    @property
    def stiffness(self) -> float: ...
    @property
    def damping(self) -> float: ...
    @property
    def friction(self) -> float | None: ...


class Model(Protocol):
    """A structure that moves. It is immutable: changes make copies."""

    @property
    def name(self) -> str: ...
    @property
    def kind(self) -> Kind: ...
    @property
    def n(self) -> int:
        """The number of blocks."""

    @property
    def sizes(self) -> Mapping[str, int]:
        """The numbers of blocks, joints, ties and components of the base: the lengths of results."""

    @property
    def laws(self) -> Sequence[Law]:
        """The laws of the joints, in their order."""

    @property
    def settings(self) -> Any:
        """The settings: `CommonSettings` and those of the kind."""

    @property
    def with_settings(self) -> Callable[..., Self]:
        """The method that returns a copy with other settings, by name; None keeps the present one.

        Raises InputError for an invalid value.
        """

    def to_dict(self) -> dict[str, Any]:
        """Return the content of its file.

        Raises InputError if it was not made from one.
        """

    def scaled_joints(self, stiffness: Sequence[float], damping: Sequence[float]) -> Self:
        """Return a copy with these factors on the moduli and on all dampings of the joints."""

    @property
    def is_damped(self) -> bool:
        """True if a joint has a dashpot."""


@dataclass(frozen=True)
class PlainModel:
    """A model of one block without joints, with defaults for the rest of `Model`."""

    settings: CommonSettings = field(default_factory=CommonSettings, kw_only=True)
    n: ClassVar[int] = 1
    laws: ClassVar[Sequence[Law]] = ()
    is_damped: ClassVar[bool] = False
    sizes: ClassVar[Mapping[str, int]] = {"block": 1, "joint": 0, "tie": 0, "bearing": 0, "base": 0}

    def with_settings(self, **changes: Any) -> Self:
        """Return a copy with other settings, by name; None keeps the present one."""
        return replace(self, settings=replace(self.settings, **{k: v for k, v in changes.items() if v is not None}))

    def scaled_joints(self, stiffness: Sequence[float], damping: Sequence[float]) -> Self:
        """Return the model itself: it has no joints."""
        return self

    def to_dict(self) -> dict[str, Any]:
        """Return its fields, with those of its settings."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """Make the model from the result of `to_dict`, also after JSON."""
        settings = {**data["settings"], "without": tuple(data["settings"]["without"])}
        return cls(**{**data, "settings": CommonSettings(**settings)})


class Kind:
    """The functions that all models of a kind share; by default without lanes, files and warnings.

    A subclass defines at least `word`, `outputs`, `largest`, `kept` and `single_run`.
    """

    word: str  # the noun for sentences
    across = False  # whether motions have two horizontal components
    takes_loads = False  # whether models may have ports
    settings: Collection[str] = ("tolerance", "without")  # names of the settings that `simulate` accepts
    outputs: Sequence[Output]  # in the order of output rows and peaks
    largest: str  # name of the peaks of displacements
    kept: Mapping[str, Kept]  # by the keys of files
    keys: Mapping[str, str] = {}  # of results whose name in Python is not their key in files: the key by the name
    numbers: Collection[str] = ()  # names that a study can vary, such as block.width for the model's field width

    @property
    def displacements(self) -> str:
        """The name of the largest displacements among the results of a run."""
        return f"peak_{self.largest}"

    @property
    def usually_kept(self) -> tuple[str, ...]:
        """The names of the results that a table of runs has by default."""
        return self.displacements, "verdict"

    def keys_of(self, keep: Sequence[str]) -> tuple[str, ...]:
        """Return the keys in files of results by their names in Python; an old name is its key, and warns.

        Raises InputError for an unknown name.
        """
        if isinstance(keep, str) or not isinstance(keep, Iterable):
            raise InputError(f"keep = {shown(keep)}: must be a list of names")
        names = {key: name for name, key in self.keys.items()}
        for name in keep:
            if name not in self.keys and name not in self.kept:
                known = (names.get(key, key) for key in self.kept)
                raise InputError(f"keep: {shown(name)}: must be of {', '.join(known)}")
            if name not in self.keys and name in names:
                warn_of_old("keep", name, names[name], 5)
        return tuple(dict.fromkeys(self.keys.get(name, name) for name in keep))

    def warnings(self, model: Any, at_rest: bool = True) -> Sequence[str]:
        """Return a line for each value that is probably unintended; `at_rest`: include what follows from the rest."""
        return ()

    def check(self, model: Any, from_rest: bool) -> None:
        """Raise InputError for a model that cannot run.

        With `from_rest`, raise NoRestError if it has no rest and falls at once.
        """

    def check_motion(self, motion: Motion) -> None:
        """Raise InputError for a motion that such models cannot have."""
        if not self.across:
            check_in_plane(motion)
        if motion.loads and not self.takes_loads:
            raise InputError(f"loads: must be left out, a {self.word} has no ports; columns and structures have them")

    def equivalent_model(self, model: Any, motion: Motion) -> Any:
        """Return the simplest model that moves alike from rest under this motion: the model itself by default."""
        return model

    def load_for_single_runs(self) -> None:
        """Load the kernels of single runs into this process; those that must be made are made at the same time."""

    def single_run(self, model: Any, plan: RunPlan) -> tuple[Any, FloatArray]:
        """Run a model by a plan; return its response, and the displacements at its rows, m (rows, any).

        Raises InputError if the plan does not suit the model, SolverError if the motion cannot be followed.
        """
        raise NotImplementedError

    def largest_of(self, response: Any, places: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the largest displacements (n,) and their histories (rows, n), m, from the result of `single_run`."""
        return response.peaks[self.largest], places

    # --- an ensemble

    def in_lanes(self, response: Any, plan: RunPlan) -> bool:
        """Return True if runs with rows like that of `response` can be made in lanes, and are faster there."""
        return False

    def varied_in_lanes(self, pairs: Sequence[tuple[Any, Motion]], plan: RunPlan) -> list[Varied | None]:
        """Run varied models and motions by a plan in lanes; None for runs that lanes cannot finish."""
        return [None for _ in pairs]

    def least_checked(self, model: Any) -> float:
        """Return the least tolerance at which a tenth of it makes the steps ten times more accurate."""
        return 1e-12  # a tenth is the least tolerance

    # --- many

    def check_kept(self, model: Any, keep: Collection[str]) -> None:
        """Raise InputError for a model that does not compute the results in `keep`."""

    def lanes(self, model: Any, keep: Collection[str]) -> Lanes:
        """Return how runs of a model are made in lanes if the results in `keep` are stored."""
        return Lanes("a model without lanes", None, 1.0)

    def under(self, model: Any, motion: Motion) -> tuple[str, Hashable]:
        """Return the reason against lanes under a motion, or "", and a further key that runs in common lanes share."""
        return "", None

    def load(self, model: Any, keep: Collection[str]) -> None:
        """Load the kernels for runs of a model in lanes into this process, which may take as long as many runs."""

    def follow(
        self, runs: Sequence[Run], keep: Collection[str], settle: float, flag: FloatArray
    ) -> tuple[dict[str, NDArray[Any]], NDArray[np.bool_]]:
        """Run models in common lanes; return results by name, and the mask of the runs that lanes have finished.

        All runs have equal keys of `lanes` and `under`. They are followed for at most `settle` seconds after their
        motions; once another thread sets flag[0], the call returns soon.
        """
        return {}, np.zeros(len(runs), dtype=bool)

    def alone(self, run: Run, keep: Collection[str], settle: float, look: Callable[..., object]) -> dict[str, Any]:
        """Run one model alone, and return the results in `keep` by name.

        It is followed for at most `settle` seconds after the motion. `look` is called several times per second with the
        time (s) and a summary of the state. Raises NoRestError if the model does not stand, SolverError if it cannot be
        followed.
        """
        end = np.array([run.motion.start + run.duration])
        found, _ = self.single_run(run.model, RunPlan(run.motion, run.duration, end, None, settle, look))
        return {name: found.kept(name) for name in keep}

    def work(self, model: Any, keep: Collection[str]) -> Work:
        """Return the approximate cost of the runs of a model."""
        return Work(SETTLE, 1.0)

    # --- numbers by name

    def has_number(self, model: Any, name: str) -> bool:
        """Return True if a dotted name, such as joint.stiffness or block[1].height, is that of a number of a model."""
        return name in self.numbers

    def numbers_of(self, model: Any, name: str) -> list[str]:
        """Return the names of the single numbers that a name refers to, one for each block, joint or tie."""
        return [name]

    def numbers_set(self, model: Any, name: str) -> list[str]:
        """Return the numbers that a name sets, each by one name only; mass and density of a block are one number."""
        return self.numbers_of(model, name)

    def with_numbers(self, model: Any, values: Mapping[str, tuple[float, bool]]) -> Any:
        """Return a copy of a model with other numbers by name: the number, and whether it is a factor on its value.

        Raises InputError if a name or number is invalid.
        """
        fields = {name.rpartition(".")[2]: value for name, value in values.items()}
        missing = next((key for key, (_, times) in fields.items() if times and getattr(model, key) is None), None)
        if missing is not None:
            raise InputError(f"{missing}: must be a number of the model before it can be multiplied")
        return replace(model, **{key: x * getattr(model, key) if times else x for key, (x, times) in fields.items()})


@singledispatch
def kind_of(model: Any) -> Any:
    """Return the kind of a model of this solver, registered by its class in `solver/registrations.py`."""
    raise InputError(f"{type(model).__name__}: no kind is registered, kind_of.register (models/protocol.py) adds it")


@singledispatch
def structure_of(model: Any) -> Any:
    """Return a model as a structure in space, by a function registered for its class (`solver/registrations.py`)."""
    raise InputError(f"{type(model).__name__}: has no form in space")


def output_times(motion: Motion, duration: float, step: float = OUTPUT_STEP) -> FloatArray:
    """Return the times of the rows of a response (s), `step` apart from the start of the motion.

    Raises InputError for more than 1e8 rows.
    """
    if duration / step > MOST_ROWS:
        raise InputError(f"output_step = {step}: must be larger, for at most {MOST_ROWS} rows in {duration} s")
    count = math.floor(duration / step + 1e-9) + 1
    return motion.start + step * np.arange(count, dtype=np.float64)


def code_of(name: str, word: str) -> int:
    """Return the code of a word in the results `name`."""
    return WORDS[name].index(word)


def table_entry(name: str, value: Any) -> Any:
    """Return a result as a table stores it: a code for a word."""
    return code_of(name, value) if name in WORDS else value
