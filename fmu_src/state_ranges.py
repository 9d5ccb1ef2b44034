"""The range of every number in the state of an FMU; bytes with other numbers are rejected before a kernel runs.

One description, by the names of the layouts of the kernels: state.py checks the arrays of a PythonFMU with it,
native/table.py writes it into the C core. A number of a layout without a range is an error when an FMU is built.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from solver.kernels.layout import spaces as plane
from solver.kernels.structure import layout as space
from solver.kernels.structure.turning import MOST_TURN

MOST = 1e30  # beyond any motion; products of several such numbers are still finite
MOST_TIME = 1e15  # s
MOST_TRIED = 1e6  # largest input for a trial of the outputs of a state; beyond it start values are used
MOST_COUNT = 2.0**53


class Range(NamedTuple):
    """The values that a number may have: low <= value <= high."""

    low: float = -MOST
    high: float = MOST
    whole: bool = False  # whether only integers are valid
    may_lack: bool = False  # whether NaN stands for "not known"
    of_inputs: bool = False  # whether it follows from the inputs: any value is valid until a step was made with them


ANY, FINITE, NONE = Range(), Range(-np.finfo(float).max, np.finfo(float).max), Range(0.0, 0.0)
SIZE = Range(0.0)
TIME, DURATION = Range(-MOST_TIME, MOST_TIME), Range(0.0, MOST_TIME)
COUNT, FLAG, SIGN = Range(0.0, MOST_COUNT, True), Range(0.0, 1.0, True), Range(-1.0, 1.0, True)
INPUT = Range(of_inputs=True)
KEPT = Range(0.0, 2.0, True)  # number of stored exchanges
TURN = Range(-2.0 * MOST_TURN, 2.0 * MOST_TURN)  # rad
UNIT = Range(-1.001, 1.001)  # components of a unit quaternion

Described = dict[str, Range]  # by dotted names of a layout


def _all(fields: Any, value: Range, prefix: str = "") -> dict[str, Range]:
    return dict.fromkeys((prefix + field for field in fields), value)


COLUMN_STATE: Described = {
    **_all(("next_step", "explicit_step", "elastic_step"), DURATION, "control."),
    **_all(("rotation_scale", "rate_scale", "previous_error"), SIZE, "control."),
    "control.base_ax": Range(may_lack=True),  # NaN: the accelerations must be computed again
    **_all(("base_az", "base_theta", "base_omega", "base_alpha"), ANY, "control."),
    **_all(("overturn_time", "reached"), TIME, "control."),
    **_all(("time_full", "time_rocking", "time_flight", "time_at_rest"), DURATION, "control."),
    **_all(("coordinates", "rates", "accelerations"), ANY, "phase."),
    **_all(("slip", "friction_work", "slip_rate", "friction_power", "slip_acceleration"), ANY, "phase."),
    "phase.sliding": SIGN,
    **_all(("bond_left", "bond_right", "bond_lost"), ANY, "phase."),
    "peaks": FINITE,
}
COLUMN_COUNTS: Described = {
    **_all(("steps", "rejected", "evaluations", "sweeps", "next_row", "implicit_steps", "since_probe"), COUNT),
    **_all(("events", "elastic_steps", "elastic_wait", "looks", "overturned"), COUNT),
    **_all(("started", "implicit", "unheld", "in_flight", "resting", "until_opening"), FLAG),
}
COLUMN_BASE: Described = {
    **_all(("ax", "jx", "az", "jz", "theta", "omega", "alpha", "jalpha"), INPUT),
    **_all(("wave_amplitude", "wave_omega", "wave_phase"), NONE),  # no input of an FMU is harmonic
    **_all(("t0", "piece_begin"), TIME),
    "anchor": Range(-np.inf, MOST_TIME),
    **_all(("anchor_sine", "anchor_cosine"), ANY),
    "segment": Range(-1.0, MOST_COUNT, True),
    "piece_end": Range(-MOST_TIME, np.inf),
    **_all(("piece_ax", "piece_jx", "piece_az", "piece_jz"), ANY),
    "coupled": FLAG,
    "steps": KEPT,
    **_all(("last_step", "before_step"), DURATION),
    **_all((f"{when}_{name}" for when in ("last", "before") for name in ("ax", "az", "alpha")), ANY),
    **_all(("x", "z", "vx", "vz", "mass_x", "mass_z", "mass_turn", "checked_mass"), ANY),
    **_all(("checked_step", "allowed_step"), DURATION),
}
STRUCTURE_STATE: Described = {
    **_all(("next_step", "elastic_step", "stabilized_step"), DURATION, "control."),
    **_all(("previous_error", "largest", "largest_rate", "largest_normal", "largest_shear", "decay"), SIZE, "control."),
    **_all(("fall_time", "reached"), TIME, "control."),
    "control.released": ANY,
    **_all(space.PHASE.fields, ANY, "phase."),
    **_all(("q0", "q1", "q2", "q3"), UNIT, "phase."),
    **_all(space.MEMORY.fields, ANY, "remembered.slips."),
    "remembered.plastic": ANY,
    **_all(("z1", "z2", "z3"), ANY, "remembered.stretches."),
    "remembered.stretches.touches": Range(-1.0, 2.0, True),
    "bonded": ANY,
    "peaks": FINITE,
}
POLYGON: Described = {"corners": Range(0.0, space.MOST_BONDED, True)}  # number, before the corners of each of `bonded`
STRUCTURE_COUNTS: Described = {
    **_all(("steps", "rejected", "evaluations", "looks", "fallen", "left", "next_row"), COUNT),
    **_all(
        ("elastic_steps", "elastic_wait", "in_a_row", "stabilized_steps", "stabilized_wait", "stabilized_pause"), COUNT
    ),
    **_all(("started", "resting", "probing"), FLAG),
}
STRUCTURE_BASE: Described = {
    **_all(("amplitude_x", "amplitude_y", "omega", "phase"), NONE, "motion."),  # as of a column
    **_all(("ax", "ay", "az", "jx", "jy", "jz"), INPUT, "motion."),
    "motion.t0": TIME,
    "motion.coupled": FLAG,
    "motion.steps": KEPT,
    **_all(("last_step", "before_step"), DURATION, "motion."),
    **_all((f"{when}_a{axis}" for when in ("last", "before") for axis in "xyz"), ANY, "motion."),
    **_all(("x", "y", "z", "vx", "vy", "vz", "mass", "checked_mass"), ANY, "motion."),
    **_all(("checked_step", "allowed_step"), DURATION, "motion."),
    **_all(("theta_x", "theta_y"), TURN, "motion."),
    **_all(("omega_x", "omega_y"), ANY, "motion."),
    **_all(("alpha_x", "alpha_y", "jalpha_x", "jalpha_y"), INPUT, "motion."),
    **_all((f"{when}_alpha_{axis}" for when in ("last", "before") for axis in "xy"), ANY, "motion."),
    **_all(space.INPUT_LOADS.fields, INPUT, "loads."),
}


class RangeBlock(NamedTuple):
    """A block of consecutive numbers with the same range."""

    length: int
    range: Range


class Ranges(NamedTuple):
    """The ranges of the numbers of each array, in order."""

    state: list[RangeBlock]
    counts: list[RangeBlock]
    base: list[RangeBlock]

    def check(self, name: str, numbers: NDArray[Any], inputs_stand: bool) -> None:
        """Raise ValueError if a number of the array with this name is out of its range.

        With `inputs_stand` a step has been made with the current inputs.
        """
        runs = getattr(self, name)
        each, lengths = zip(*(run.range for run in runs), strict=True), [run.length for run in runs]
        low, high, whole, may_lack, of_inputs = (np.repeat(part, lengths) for part in each)
        inside = (low <= numbers) & (numbers <= high) & ~(whole & (numbers != np.floor(numbers)))
        inside |= (may_lack & np.isnan(numbers)) | (of_inputs & (not inputs_stand))
        if not inside.all():
            place = int(np.argmin(inside))
            raise ValueError(f"{name}[{place}] = {numbers[place]:.6g}: is out of its range")


def _runs(part: Any, sizes: Any, described: Described, limited: Described | None = None) -> list[RangeBlock]:
    """Return the ranges of a layout as runs; `limited`: ranges that replace those of `described`."""
    places = np.arange(part.size(sizes))
    seen = part.see(places, sizes)
    found: list[Range | None] = [None] * len(places)
    for name, value in (described | (limited or {})).items():
        for place in np.ravel(attrgetter(name)(seen)).tolist():
            found[place] = value
    return _packed(found)


def _packed(found: Sequence[Range | None]) -> list[RangeBlock]:
    """Return runs of equal neighbours. Raises ValueError for a number without a range."""
    if None in found:
        raise ValueError(f"number {found.index(None)} of {len(found)} of a state has no range")
    return [RangeBlock(len([*same]), value) for value, same in groupby(filter(None, found))]


def _of_base(described: Described, bodies_drive: bool) -> Described:
    """Return the ranges of a base; where bodies drive it, its accelerations are part of the motion."""
    return {name: ANY if bodies_drive and value == INPUT else value for name, value in described.items()}


def of_column(n: int, spots: int, loads: int, bodies_drive: bool = False) -> Ranges:
    """Return the ranges of a column of n blocks.

    `spots` and `loads` are the numbers of its ports at the end of state and base.
    """
    return Ranges(
        [*_runs(plane.STATE, n, COLUMN_STATE), RangeBlock(spots, FINITE)],
        _runs(plane.COUNTS, 0, COLUMN_COUNTS, {"overturned": Range(0.0, n, True)}),
        [*_runs(plane.BASE, 0, _of_base(COLUMN_BASE, bodies_drive)), RangeBlock(loads, INPUT)],
    )


def of_structure(sizes: space.Sizes, bodies_drive: bool = False) -> Ranges:
    """Return the ranges of a structure in space."""
    state = _runs(space.STATE, sizes, STRUCTURE_STATE)
    places = space.STATE.see(np.arange(space.STATE.size(sizes)), sizes)
    found = [run.range for run in state for _ in range(run.length)]
    for polygon in places.bonded.reshape(sizes.bonds, space.OF_POLYGON.size(1)):
        for name, value in POLYGON.items():
            found[getattr(space.BONDED.see(polygon), name)] = value
    numbered = {"fallen": Range(0.0, sizes.n, True), "left": Range(0.0, sizes.b, True)}
    counts = _runs(space.COUNTS, 0, STRUCTURE_COUNTS, numbered)
    base = _runs(space.INPUT_MOTION, sizes, _of_base(STRUCTURE_BASE, bodies_drive))
    return Ranges(_packed(found), counts, base)


def finite(state: int, counts: int, base: int) -> Ranges:
    """Return the ranges of arrays of these lengths that must be finite only."""
    return Ranges(
        [RangeBlock(state, FINITE)], [RangeBlock(counts, COUNT)], [RangeBlock(base, FINITE._replace(of_inputs=True))]
    )
