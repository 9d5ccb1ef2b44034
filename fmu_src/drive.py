"""How the base of an FMU moves: as its inputs say, or by bodies at it, which say force and mass (theory.md, 15)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any, NamedTuple

from solver.common.ranges import check_choice
from solver.kernels.layout.spaces import DRIVEN, DRIVES, SLOPES, SPLIT

from .references import MOST_BODIES, OF_COLUMN, names_of_body
from .variables import DRIVE, MOVING, SLOPE_OF_BASE, Variable, input_of, parameter_of

# what a body says -> unit, what it is
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
# said by bodies of a motion that is not along x or y
_ACROSS = ("F0z", "F0m", "Mzz", "Mzt", "Mtt", "F0mx", "F0my", "Jxx", "Jyy", "Jxy")
_PLACED = ("theta", "omega", "theta_x", "theta_y", "omega_x", "omega_y")  # where a base begins that bodies turn


class Idle(Enum):
    """When an input does nothing."""

    EVER = 1
    LATER = 2  # after the first exchange with the bodies


def idle(drive: str, name: str) -> Idle | None:
    """Return when an input does nothing, under a drive that is one of DRIVES; None: it acts."""
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
    """As built: words of DRIVES and SLOPES (kernels/layout/spaces.py), and how many bodies may be at the base.

    turns: whether the base of a structure may turn, as that of a column may always.
    """

    drive: str = "acceleration"
    slope: str = "parabola"
    bodies: int = 1
    turns: bool = False

    @property
    def is_chosen(self) -> bool:
        """Whether the FMU has inputs and parameters for bodies at its base; the usual one has none."""
        return self.drive != "acceleration"

    @property
    def most_bodies(self) -> int:
        """Number of bodies that may drive the base, 0 in the usual FMU."""
        return self.bodies if self.is_chosen else 0

    @property
    def split_of_column(self) -> int:
        """Length of a column's split reaction, with the motion of its base where bodies may drive it."""
        return SPLIT.beside + (DRIVEN.beside if self.is_chosen else 0)

    @property
    def words(self) -> tuple[str, ...]:
        """What the parameter may be: an FMU that is built for bodies has outputs that depend on nothing else."""
        return (self.drive,) if self.drive == "body" else tuple(DRIVES)

    def inputs(self, said: Sequence[str] = OF_COLUMN) -> tuple[Variable, ...]:
        """The rows of the bodies, each of which says this."""
        return tuple(_input(name) for k in range(self.most_bodies) for name in names_of_body(k, said))

    @property
    def parameters(self) -> list[Variable]:
        """How the base moves, and how its acceleration goes on within a step."""
        if not self.is_chosen:
            return []
        ways = f"How the base moves ({', '.join(self.words)}): by base.a*, by body.*, or by body.* horizontally alone"
        slopes = f"Slope of its acceleration within a step where body.* move it ({', '.join(SLOPES)})"
        return [parameter_of(DRIVE, "", ways, self.drive), parameter_of(SLOPE_OF_BASE, "", slopes, self.slope)]

    def chosen(self, value: Callable[[str], Any]) -> Drive:
        """As parameters say. Raises InputError."""
        if not self.is_chosen:
            return self
        return drive_of(value(DRIVE), value(SLOPE_OF_BASE), self.bodies, self.turns, self.words)

    def direct(self, of: tuple[str, ...]) -> tuple[str, ...]:
        """Inputs that an output of a column depends on without delay; of: those of a base that is accelerated.

        Built for bodies it has no others: then what does not feel the acceleration depends on none.
        """
        if not self.is_chosen:
            return of
        own = {"body": (), "horizontal": tuple(name for name in of if name != "base.ax")}.get(self.drive, of)
        return (*own, *(variable.name for variable in self.inputs())) if of == MOVING else own


USUAL = Drive()


def _input(name: str) -> Variable:
    key = name.partition(".")[2]
    unit, what = SAID[key]
    text = f"{what} {key} of a body that moves the base (M a = F0 + what stands on it does), as its state determines it"
    return input_of(name, text, unit, 1.0)


def drive_of(drive: str, slope: str, bodies: int, turns: bool = False, words: tuple[str, ...] = tuple(DRIVES)) -> Drive:
    """A drive, which is one of the words. Raises InputError."""
    check_choice(DRIVE, drive, words)
    check_choice(SLOPE_OF_BASE, slope, tuple(SLOPES))
    check_choice("--bodies", str(bodies), tuple(map(str, range(1, MOST_BODIES + 1))))
    return Drive(drive, slope, bodies, turns)
