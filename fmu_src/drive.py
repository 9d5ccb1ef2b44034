"""The drive of the base of an FMU: its inputs, or bodies at it that send force and mass (theory.md, 15)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any, NamedTuple

from solver.common.ranges import check_choice
from solver.kernels.layout.spaces import DRIVEN, DRIVES, SLOPES, SPLIT

from .references import MOST_BODIES, OF_COLUMN, names_of_body
from .variables import DRIVE, MOVING, SLOPE_OF_BASE, Variable, input_of, parameter_of

# input from a body -> unit, meaning
SAID = {
    **dict.fromkeys(("F0x", "F0y", "F0z"), ("N", "Force")),
    **dict.fromkeys(("F0m", "F0mx", "F0my"), ("N.m", "Moment")),
    **dict.fromkeys(("M", "Mxx", "Mxz", "Mzz"), ("kg", "Mass")),
    **dict.fromkeys(("Mxt", "Mzt", "Mxry", "Myrx"), ("kg.m", "Mass")),
    **dict.fromkeys(("Mtt", "Jxx", "Jyy", "Jxy"), ("kg.m2", "Inertia")),
}


# fields of the array `base` that are 0 while the base rests
MOTION = (
    *("ax", "ay", "az", "jx", "jy", "jz", "theta", "omega", "alpha"),
    *("theta_x", "theta_y", "omega_x", "omega_y", "alpha_x", "alpha_y"),
)
_ALONG = ("ax", "ay", "jx", "jy")  # inputs of a base that is accelerated horizontally
# inputs from bodies for a motion that is not along x or y
_ACROSS = ("F0z", "F0m", "Mzz", "Mzt", "Mtt", "F0mx", "F0my", "Jxx", "Jyy", "Jxy")
_PLACED = ("theta", "omega", "theta_x", "theta_y", "omega_x", "omega_y")  # initial position of a base that bodies turn


class Idle(Enum):
    """The condition under which an input has no effect."""

    EVER = 1
    LATER = 2  # after the first exchange with the bodies


def idle(drive: str, name: str) -> Idle | None:
    """Return when an input has no effect under a drive of DRIVES; None if it acts."""
    owner, _, what = name.partition(".")
    if owner.startswith("body"):
        is_idle = drive == "acceleration" or (drive == "horizontal" and what in _ACROSS)
        return Idle.EVER if is_idle else None
    if owner != "base":
        return None
    if drive == "body":
        return Idle.LATER if what in _PLACED else Idle.EVER
    return Idle.EVER if drive == "horizontal" and what in _ALONG else None


class Drive(NamedTuple):
    """The drive of an FMU as built."""

    drive: str = "acceleration"  # a word of DRIVES (kernels/layout/spaces.py)
    slope: str = "parabola"  # a word of SLOPES
    bodies: int = 1  # the largest number of bodies at the base
    turns: bool = False  # whether the base of a structure may turn; that of a column always may

    @property
    def is_chosen(self) -> bool:
        """True if the FMU has inputs and parameters for bodies at its base; the usual one has none."""
        return self.drive != "acceleration"

    @property
    def most_bodies(self) -> int:
        """The number of bodies that may drive the base, 0 in the usual FMU."""
        return self.bodies if self.is_chosen else 0

    @property
    def split_of_column(self) -> int:
        """The length of a column's split reaction, with the motion of its base where bodies may drive it."""
        return SPLIT.beside + (DRIVEN.beside if self.is_chosen else 0)

    @property
    def words(self) -> tuple[str, ...]:
        """The values that the parameter may have; "body" alone if built for it: its outputs depend on nothing else."""
        return (self.drive,) if self.drive == "body" else tuple(DRIVES)

    def inputs(self, said: Sequence[str] = OF_COLUMN) -> tuple[Variable, ...]:
        """Return the rows of the inputs of all bodies, each with the names `said`."""
        return tuple(_input(name) for k in range(self.most_bodies) for name in names_of_body(k, said))

    @property
    def parameters(self) -> list[Variable]:
        """The rows of the parameters: how the base moves, and the slope of its acceleration within a step."""
        if not self.is_chosen:
            return []
        ways = f"How the base moves ({', '.join(self.words)}): by base.a*, by body.*, or by body.* horizontally alone"
        slopes = f"Slope of its acceleration within a step where body.* move it ({', '.join(SLOPES)})"
        return [parameter_of(DRIVE, "", ways, self.drive), parameter_of(SLOPE_OF_BASE, "", slopes, self.slope)]

    def chosen(self, value: Callable[[str], Any]) -> Drive:
        """Return the drive that the parameters select. Raises InputError."""
        if not self.is_chosen:
            return self
        return drive_of(value(DRIVE), value(SLOPE_OF_BASE), self.bodies, self.turns, self.words)

    def direct(self, of: tuple[str, ...]) -> tuple[str, ...]:
        """Return the inputs that an output of a column depends on without delay; `of`: those for an accelerated base.

        An FMU built for bodies has no others: there an output that does not feel the acceleration depends on none.
        """
        if not self.is_chosen:
            return of
        own = () if self.drive == "body" else of  # built for horizontal bodies, it may be accelerated instead
        return (*own, *(variable.name for variable in self.inputs())) if of == MOVING else own


USUAL = Drive()


def _input(name: str) -> Variable:
    key = name.partition(".")[2]
    unit, what = SAID[key]
    text = f"{what} {key} of a body that moves the base (M a = F0 + what stands on it does), as its state determines it"
    return input_of(name, text, unit, 1.0)


def drive_of(drive: str, slope: str, bodies: int, turns: bool = False, words: tuple[str, ...] = tuple(DRIVES)) -> Drive:
    """Return a drive, after checking that it is one of `words`. Raises InputError."""
    check_choice(DRIVE, drive, words)
    check_choice(SLOPE_OF_BASE, slope, tuple(SLOPES))
    check_choice("--bodies", str(bodies), tuple(map(str, range(1, MOST_BODIES + 1))))
    return Drive(drive, slope, bodies, turns)
