"""What everything else knows of a model, whichever it is: a column in its plane, a structure in space.

A model is data. Its `kind` is what all models of that kind share: how they run, alone or eight at once in lanes, and
what of their runs can be kept.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, ClassVar, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from ..common.errors import InputError
from ..ground.motion import Motion, check_in_plane
from .outputs import BASE, Output
from .uncertainty import Varied

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

OVERTURNED, STANDING, UNDECIDED = "overturned", "standing", "undecided"
SCALAR, LANES = "scalar", "lanes"  # how a run is made: alone, or beside seven others
LOADED = "loads on ports"  # why it is made alone
# results that are words, which a table stores as numbers: 10^6 words would take as much memory as all the rest
WORDS: dict[str, tuple[str, ...]] = {"verdict": (UNDECIDED, STANDING, OVERTURNED), "path": (SCALAR, LANES)}

OUTPUT_STEP = 0.005  # s between the rows of a response, where none is asked for
MOST_ROWS = 10**8
SETTLE = 60.0  # s, the longest that a model is followed after the motion, where no time is asked for


class NoRestError(InputError):
    """A model does not stand under its weight."""


class Run(NamedTuple):
    """One of many runs, from rest."""

    model: Any
    motion: Motion
    duration: float  # s


class Plan(NamedTuple):
    """A run of whichever model: its motion, how long it takes, s, and the times of its rows, s."""

    motion: Motion
    duration: float
    times: FloatArray
    initial: Any = None  # None: rest; else what the kind of model has
    settle: float = 0.0  # s, the longest that the model is followed after the duration
    callback: Callable[[float, Any], object] | None = None  # called with the time, s, and a glance at the state


class Verdict(NamedTuple):
    """Whether a run overturns, the sentence that says why, and the time at which it was clear, s."""

    word: str
    reason: str
    time: float


class Kept(NamedTuple):
    """A result that can be kept of a run: the unit; the type, or None for a number of each of `of`."""

    unit: str = ""
    kind: Any = None
    of: str = "block"  # or joint, tie, base: see Model.sizes


def kept_peaks(outputs: Sequence[Output]) -> dict[str, Kept]:
    """The extremes of outputs as results that can be kept, those of the base last."""
    return {
        output.kept: Kept(output.unit, np.float64 if output.is_single else None, output.owner)
        for output in sorted(outputs, key=lambda output: output.owner == BASE)
    }


class Lanes(NamedTuple):
    """Whether runs of a model are made in lanes: why not, "" if they are; which may share them; first step, s."""

    why_not: str
    share: Hashable
    first_step: float


class Work(NamedTuple):
    """Rough cost of a run and of each second of its duration; 1: a block of a column for a second in lanes."""

    run: float
    second: float

    def of(self, duration: float) -> float:
        """Of a run of this duration, s."""
        return self.run + self.second * duration


@dataclass(frozen=True)
class Settings:
    """What every model has: tolerance of a run, its integrator, and what is left out, of the kind's own words."""

    tolerance: float = 1e-6
    integrator: str = ""
    without: tuple[str, ...] = ()


class Law(Protocol):
    """Modulus, N/m3, damping, s, and coefficient of friction, None without sliding, of a joint."""

    @property
    def stiffness(self) -> float: ...
    @property
    def damping(self) -> float: ...
    @property
    def friction(self) -> float | None: ...


class Model(Protocol):
    """A structure that moves. It is never changed, only copied with other values."""

    @property
    def name(self) -> str: ...
    @property
    def kind(self) -> Kind: ...
    @property
    def n(self) -> int:
        """Number of blocks."""

    @property
    def sizes(self) -> Mapping[str, int]:
        """How many blocks, joints, ties and components of the base there are: the lengths of what is kept."""

    @property
    def laws(self) -> Sequence[Law]:
        """Of the joints, in their order."""

    @property
    def settings(self) -> Any:
        """What `Settings` has, and what else a kind has."""

    @property
    def with_settings(self) -> Callable[..., Self]:
        """A copy with other settings, by their names; None keeps the present one. Raises InputError."""

    def to_dict(self) -> dict[str, Any]:
        """What its file holds. Raises InputError if it was not made from one."""

    def with_joints(self, stiffness: Sequence[float], damping: Sequence[float]) -> Self:
        """A copy whose joints have these moduli, N/m3, and dampings, s."""


@dataclass(frozen=True)
class PlainModel:
    """A model of one block without joints: the rest of what `Model` asks for."""

    settings: Settings = field(default_factory=Settings, kw_only=True)
    n: ClassVar[int] = 1
    laws: ClassVar[Sequence[Law]] = ()
    sizes: ClassVar[Mapping[str, int]] = {"block": 1, "joint": 0, "tie": 0, "bearing": 0, "base": 0}

    def with_settings(self, **changes: Any) -> Self:
        """As of `Model`."""
        return replace(self, settings=replace(self.settings, **{k: v for k, v in changes.items() if v is not None}))

    def with_joints(self, stiffness: Sequence[float], damping: Sequence[float]) -> Self:
        """Itself."""
        return self

    def to_dict(self) -> dict[str, Any]:
        """Its fields, and those of its settings."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """From what `to_dict` gives, also by way of JSON."""
        settings = {**data["settings"], "without": tuple(data["settings"]["without"])}
        return cls(**{**data, "settings": Settings(**settings)})


class Kind:
    """What all models of a kind share. As it stands: without lanes, files and warnings.

    A kind of its own has at least `word`, `outputs`, `largest`, `kept` and `single_run`.
    """

    word: str  # for sentences
    across = False  # whether motions have two horizontal components
    takes_loads = False  # whether models may have ports
    settings: Collection[str] = ("tolerance", "without")  # names of those that `simulate` takes
    outputs: Sequence[Output]  # in the order of output rows and peaks
    largest: str  # name of the peaks that are the largest displacements
    kept: Mapping[str, Kept]
    numbers: Collection[str] = ()  # names of those that a study varies, as block.width: the model's field of that name

    def warnings(self, model: Any, at_rest: bool = True) -> Sequence[str]:
        """Values that are probably not intended, a line each; at_rest: also what follows from the rest."""
        return ()

    def check(self, model: Any, from_rest: bool) -> None:
        """Raise InputError for a model that cannot run; from_rest: NoRestError where it has none, and falls at once."""

    def check_motion(self, motion: Motion) -> None:
        """Raise InputError for a motion that such models cannot have."""
        if not self.across:
            check_in_plane(motion)
        if motion.loads and not self.takes_loads:
            raise InputError(f"loads: must be left out, a {self.word} has no ports; columns and structures have them")

    def simplest(self, model: Any, motion: Motion) -> Any:
        """The simplest model that runs alike from rest under this motion: itself, unless there is one."""
        return model

    def single_run(self, model: Any, plan: Plan) -> tuple[Any, FloatArray]:
        """A response, and the displacements at its rows, m (rows, any number). Raises InputError and SolverError."""
        raise NotImplementedError

    def largest_of(self, response: Any, places: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Largest displacements and their histories, m (n,), (rows, n), of what `single_run` has returned."""
        return response.peaks[self.largest], places

    # --- an ensemble

    def in_lanes(self, response: Any, plan: Plan) -> bool:
        """Whether runs with rows around one that gave a response are made in lanes, and that is faster."""
        return False

    def varied_in_lanes(self, pairs: Sequence[tuple[Any, Motion]], plan: Plan) -> list[Varied | None]:
        """Runs of varied models and motions by a plan; None where lanes do not go on."""
        return [None for _ in pairs]

    # --- many

    def check_kept(self, model: Any, keep: Collection[str]) -> None:
        """Raise InputError for a model that does not compute what is to be kept."""

    def lanes(self, model: Any, keep: Collection[str]) -> Lanes:
        """Whether runs of a model of which this is kept are made in lanes."""
        return Lanes("a model without lanes", None, 1.0)

    def under(self, model: Any, motion: Motion) -> tuple[str, Hashable]:
        """Why not under a motion, "" if they are; and what else runs that share lanes have in common."""
        return "", None

    def load(self, model: Any, keep: Collection[str]) -> None:
        """Load what runs of a model in lanes need into this process, which may take as long as many runs."""

    def follow(
        self, runs: Sequence[Run], keep: Collection[str], settle: float, flag: FloatArray
    ) -> tuple[dict[str, NDArray[Any]], NDArray[np.bool_]]:
        """Results of runs that share lanes, by name, and which of them lanes finish; ends soon once flag[0] is set."""
        return {}, np.zeros(len(runs), dtype=bool)

    def alone(self, run: Run, keep: Collection[str], settle: float, look: Callable[..., object]) -> dict[str, Any]:
        """Results of a run by name; look: called some times a second. Raises NoRestError and SolverError."""
        end = np.array([run.motion.start + run.duration])
        found, _ = self.single_run(run.model, Plan(run.motion, run.duration, end, None, settle, look))
        return {name: found.kept(name) for name in keep}

    def work(self, model: Any, keep: Collection[str]) -> Work:
        """Rough cost of the runs of a model."""
        return Work(SETTLE, 1.0)

    # --- numbers by name

    def has_number(self, model: Any, name: str) -> bool:
        """Whether a dotted name, as joint.stiffness or block[1].height, is of a number of a model."""
        return name in self.numbers

    def numbers_of(self, model: Any, name: str) -> list[str]:
        """The names of the numbers that a name refers to, one for each block, joint or tie."""
        return [name]

    def with_numbers(self, model: Any, values: Mapping[str, tuple[float, bool]]) -> Any:
        """A model with numbers set: name -> (number, whether it multiplies what is there). Raises InputError."""
        fields = {name.rpartition(".")[2]: value for name, value in values.items()}
        missing = next((key for key, (_, times) in fields.items() if times and getattr(model, key) is None), None)
        if missing is not None:
            raise InputError(f"{missing}: must be a number of the model before it can be multiplied")
        return replace(model, **{key: x * getattr(model, key) if times else x for key, (x, times) in fields.items()})


def output_times(motion: Motion, duration: float, step: float = OUTPUT_STEP) -> FloatArray:
    """Times of the rows of a response, s. Raises InputError for too many rows."""
    if duration / step > MOST_ROWS:
        raise InputError(f"output_step = {step}: must be larger, for at most {MOST_ROWS} rows in {duration} s")
    count = math.floor(duration / step + 1e-9) + 1
    return motion.start + step * np.arange(count, dtype=np.float64)


def code_of(name: str, word: str) -> int:
    """The number by which a table stores a word."""
    return WORDS[name].index(word)


def table_entry(name: str, value: Any) -> Any:
    """A result as a table stores it."""
    return code_of(name, value) if name in WORDS else value
