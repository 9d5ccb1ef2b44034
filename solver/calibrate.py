"""Modulus and damping of joints from what is known of a column: elasticity, frequencies, decay, restitution.

Every function returns numbers for `with_joints`, and leaves the column as it is.
"""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from .column import Column
from .errors import NOT_NEGATIVE, POSITIVE, InputError, SolverError, check_number, needing, reading
from .modes import natural_modes
from .packing import FloatArray
from .rocking import RELEASE, housner_restitution, pulled_aside, restitution_from

ETAS = np.geomspace(1e-6, 10.0, 15)  # s: among which the one that is looked for is enclosed
DIGITS = 1e-6  # of eta
SWING = (0.0, 0.95)  # range of damping ratios that a decay has
LEAST_SAMPLES = 8
FOUND = 0.5  # of a record's variance: what a decaying swing has to explain


@dataclass(frozen=True, eq=False)
class FreeVibration:
    """A decaying swing, exp(-2 pi ratio frequency t), that was fitted to a record."""

    frequency: float  # Hz, undamped
    ratio: float  # of critical damping
    explained: float  # part of the variance of the record, 0 to 1
    fitted: FloatArray  # at the samples, in the units of the record


def with_joints(column: Column, stiffness: ArrayLike | None = None, damping: ArrayLike | None = None) -> Column:
    """Return the column with other moduli N/m3 or dampings s of its joints: one number, or n of them, top joint first.

    None keeps those that are there. Raises InputError.
    """
    moduli = _each("stiffness", column, stiffness, [block.joint.stiffness for block in column.blocks])
    etas = _each("damping", column, damping, [block.joint.damping for block in column.blocks])
    return replace(
        column,
        blocks=tuple(
            replace(block, joint=replace(block.joint, stiffness=modulus, damping=eta))
            for block, modulus, eta in zip(column.blocks, moduli, etas, strict=True)
        ),
    )


# --- modulus


def modulus_from_elasticity(
    column: Column, young: float, joint_thickness: float = 0.0, joint_young: float | None = None
) -> FloatArray:
    """Moduli of the joints, N/m3 (n,): 1 / k = H / E + t / E_j, with H the height of the block on the joint.

    young: E of the blocks, Pa. joint_thickness: t of mortar or lead in the joint, m; joint_young: its E_j, Pa. Raises
    InputError.
    """
    young = check_number("young", young, POSITIVE, "a positive modulus of elasticity in Pa")
    thickness = check_number("joint_thickness", joint_thickness, NOT_NEGATIVE, "a thickness in m, zero or positive")
    give = np.array([block.height for block in column.blocks]) / young
    if thickness > 0.0:
        if joint_young is None:
            raise InputError(f"joint_young: missing, must be the modulus in Pa of what is {thickness:g} m thick")
        give += thickness / check_number("joint_young", joint_young, POSITIVE, "a positive modulus in Pa")
    return np.asarray(1.0 / give)


def modulus_from_frequencies(column: Column, frequencies: Sequence[float]) -> FloatArray:
    """Moduli of the joints, N/m3 (n,): those of the column times the one factor that suits measured frequencies best.

    frequencies: Hz, of the first, second ... mode that sways; NaN where one was not measured. Least squares of the
    relative differences. Raises InputError, SolverError.
    """
    measured = np.asarray(frequencies, dtype=np.float64)
    known = np.flatnonzero(np.isfinite(measured))
    if measured.ndim != 1 or not 1 <= measured.size <= column.n or not known.size or np.any(measured[known] <= 0.0):
        raise InputError(
            f"frequencies = {frequencies}: must be up to {column.n} positive frequencies in Hz, from the first mode on"
        )
    given = np.array([block.joint.stiffness for block in column.blocks])

    def differences(logarithm: FloatArray) -> FloatArray:
        try:
            found = sway_frequencies(with_joints(column, given * math.exp(float(logarithm[0]))))
        except SolverError:  # too soft to stand
            return np.full(known.size, -1.0)
        difference: FloatArray = found[known] / measured[known] - 1.0
        return difference

    with needing("calibrate", "scipy"):
        from scipy.optimize import least_squares
    # frequencies go as the root of the modulus, but for the weight; from the stiff side all columns stand
    first = 2.0 * math.log(measured[known[0]] / sway_frequencies(column)[known[0]])
    found = least_squares(differences, [max(first, 0.0) + 0.5], xtol=1e-12, ftol=1e-12, gtol=1e-12, x_scale=1.0)
    moduli: FloatArray = given * math.exp(float(found.x[0]))
    if np.max(np.abs(differences(found.x))) >= 1.0:
        raise SolverError("no modulus has such frequencies: with softer joints the column does not stand")
    return moduli


def sway_frequencies(column: Column) -> FloatArray:
    """Natural frequencies of the n modes that sway, Hz, ascending. Raises as `natural_modes` does."""
    modes = natural_modes(column)
    found: FloatArray = modes.frequency[modes.sways]
    return found


# --- damping


def damping_from_ratio(column: Column, ratio: float, mode: int = 1) -> float:
    """eta of all joints, s, that gives one mode that sways, counted from 1, this ratio of critical damping.

    All joints in contact, small motion. Raises InputError, SolverError.
    """
    ratio = check_number("ratio", ratio, NOT_NEGATIVE, "a ratio of critical damping, zero or positive")
    if isinstance(mode, bool) or not isinstance(mode, (int, np.integer)) or not 1 <= mode <= column.n:
        raise InputError(f"mode = {mode!r}: must be the number of a mode that sways, 1 to {column.n}")
    modes = natural_modes(with_joints(column, damping=1.0))
    return ratio / float(modes.damping_ratio[modes.sways][mode - 1])


def damping_from_restitution(column: Column, wanted: float | None = None, release: float = RELEASE) -> float:
    """eta of all joints, s, at which the column, pulled aside and let go, has this restitution (rocking.py).

    wanted: rotation rate after over before the impact; None: that of Housner's rigid block. release: as in
    `rocking.restitution`, on which the restitution depends. Raises InputError if no damping has it, SolverError.
    """
    wanted = housner_restitution(column) if wanted is None else wanted
    wanted = check_number("restitution", wanted, (1e-6, 1.0 - 1e-9), "a ratio of rotation rates, between 0 and 1")
    with needing("calibrate", "scipy"):
        from scipy.optimize import brentq
    start, top = pulled_aside(column, release)

    def above(logarithm: float) -> float:
        return restitution_from(with_joints(column, damping=math.exp(logarithm)), start, top) - wanted

    logarithms = [float(value) for value in np.log(ETAS)]
    differences = [above(logarithms[0])]
    if differences[0] <= 0.0:
        raise InputError(
            f"restitution = {wanted:.6g}: must be less than {wanted + differences[0]:.6g}, that of eta = {ETAS[0]:g} s"
        )
    for before, logarithm in pairwise(logarithms):
        differences.append(above(logarithm))
        if differences[-1] <= 0.0:
            return math.exp(float(brentq(above, before, logarithm, xtol=DIGITS)))
    raise InputError(
        f"restitution = {wanted:.6g}: no damping reaches it, joints of this stiffness have "
        f"{wanted + min(differences):.4g} at least; softer ones lose more"
    )


def free_vibration(time: ArrayLike, values: ArrayLike) -> FreeVibration:
    """Fit a decaying swing to a record of free vibration, in whatever unit: least squares over all its samples.

    time: (m,) s, increasing. values: (m,); a constant in it does not matter. Raises InputError if the record is no such
    swing.
    """
    t, y = np.asarray(time, dtype=np.float64), np.asarray(values, dtype=np.float64)
    if t.ndim != 1 or t.shape != y.shape or t.size < LEAST_SAMPLES or not np.all(np.isfinite(t) & np.isfinite(y)):
        raise InputError(f"free vibration: must be at least {LEAST_SAMPLES} finite times and as many values")
    if np.any(np.diff(t) <= 0.0):
        raise InputError("free vibration: times must increase")
    with needing("calibrate", "scipy"):
        from scipy.optimize import least_squares
    t = t - t[0]
    variance = float(np.sum((y - np.mean(y)) ** 2))
    if variance == 0.0:
        raise InputError("free vibration: the record does not move")

    def fit(unknowns: FloatArray) -> FloatArray:
        """The swing of this circular frequency and ratio that is nearest to the record."""
        omega, ratio = unknowns
        phase = omega * math.sqrt(1.0 - ratio * ratio) * t
        decay = np.exp(-ratio * omega * t)
        parts = np.column_stack([decay * np.cos(phase), decay * np.sin(phase), np.ones_like(t)])
        found: FloatArray = parts @ np.linalg.lstsq(parts, y, rcond=None)[0]
        return found

    def missed(unknowns: FloatArray) -> FloatArray:
        difference: FloatArray = (fit(unknowns) - y) / math.sqrt(variance)
        return difference

    start = _strongest_frequency(t, y)
    limits = {"bounds": ([0.3 * start, SWING[0]], [3.0 * start, SWING[1]]), "x_scale": [start, 0.01], "xtol": 1e-12}
    tries = [least_squares(missed, [start, ratio], **limits) for ratio in (0.005, 0.05, 0.3)]
    best = min(tries, key=lambda tried: tried.cost)
    explained = 1.0 - 2.0 * float(best.cost)
    if explained < FOUND:
        raise InputError(
            f"free vibration: a decaying swing explains {max(0.0, explained):.0%} of the record's variance, must be at "
            f"least {FOUND:.0%}; choose a part in which one mode is left"
        )
    omega, ratio = (float(value) for value in best.x)
    return FreeVibration(omega / (2.0 * math.pi), ratio, explained, fit(best.x))


def read_history(path: str | os.PathLike[str], channel: str | None = None) -> tuple[FloatArray, FloatArray]:
    """Read times and one of the columns of a CSV file with a header, as `Response.to_csv` writes it.

    channel: its name; None: the second. Raises InputError.
    """
    with reading(path), open(path, newline="", encoding="utf-8-sig") as file:
        header, *rows = [row for row in csv.reader(file) if row] or [[]]
        names = [name.strip() for name in header]
        if len(names) < 2:
            raise InputError("must be a CSV file of times and values, with a header")
        if channel is not None and channel not in names[1:]:
            raise InputError(f"channel = {channel}: must be one of {', '.join(names[1:10])}")
        k = 1 if channel is None else names.index(channel)
        try:
            values = np.array([[float(row[0]), float(row[k])] for row in rows]).reshape(-1, 2)
        except (ValueError, IndexError):
            raise InputError(f"column {names[k]}: must hold numbers below the header") from None
    return values[:, 0], values[:, 1]


def _strongest_frequency(t: FloatArray, y: FloatArray) -> float:
    """Circular frequency, 1/s, at which a record has most."""
    even = np.linspace(t[0], t[-1], max(64, t.size))
    swing = np.interp(even, t, y)
    size = 8 * even.size
    spectrum = np.abs(np.fft.rfft((swing - np.mean(swing)) * np.hanning(2 * even.size)[even.size :], size))
    k = 1 + int(np.argmax(spectrum[1:]))
    return 2.0 * math.pi * k / (size * float(even[1] - even[0]))


def _each(key: str, column: Column, given: ArrayLike | None, kept: list[float]) -> list[float]:
    if given is None:
        return kept
    values = np.asarray(given, dtype=np.float64)
    if values.ndim > 1 or values.size not in (1, column.n):
        raise InputError(f"{key}: {values.size} numbers, must be one or {column.n}, one for each joint")
    return [float(value) for value in np.broadcast_to(values.reshape(-1), (column.n,))]
