"""Modulus, damping and rim of joints from what is known of a column: elasticity, frequencies, decay, restitution.

Every function returns numbers for `with_joints`, and leaves the column as it is.
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.digits import percent
from ..common.errors import (
    NOT_NEGATIVE,
    POSITIVE,
    InputError,
    InputWarning,
    SolverError,
    check_number,
    check_whole,
    needing,
    reading,
)
from ..common.files import MOST_TABLE
from ..common.text import lines_of
from ..common.text_tables import check_times, from_zero, table_of
from ..models.column.model import Column
from ..models.column.modes import modes_about_rest
from ..models.column.packing import FloatArray
from .edges import column_damping_on_edge as column_damping_on_edge
from .edges import damping_on_edge as damping_on_edge
from .rocking import RELEASE, housner_restitution, pulled_aside, restitution, restitution_from, rocking_part

ETAS = np.geomspace(1e-6, 10.0, 15)  # s: among which the one that is looked for is enclosed
DIGITS = 1e-6  # of eta
RIMS = 0.5 ** np.arange(1.0, 11.0)  # of half a face: among which the one that is looked for is enclosed
NEAR_ENOUGH = 5e-3  # of a restitution: the nearest one is taken, with a warning
SAME_RESTITUTION = 1e-5
SWING = (0.0, 0.95)  # range of damping ratios that a decay has
MISSED = 0.05  # of a measured frequency, which is warned of
SPREAD = 0.01  # of each measured frequency: what the accuracy of the moduli is worked out from
UNDETERMINED = 1.0  # of a modulus
NUDGE = 1e-3  # of the logarithm of a modulus: how far frequencies are differenced
ASIDE = 1.4  # of that logarithm: where else than at the column's own moduli a fit begins
SUITS = 1e-6  # of a frequency: the fit has it
SAME = 1e-3  # between logarithms of moduli: one set, found twice
LEAST_SENSITIVITY = 1e-8  # of the largest: below it is the rounding of the frequencies
FARTHEST = 30.0  # logarithm of a factor on the moduli
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
    return column.with_joints(moduli, etas)


def with_rim(column: Column, rim: float | None) -> Column:
    """Return the column with faces that touch in a band of this width (m) at every joint; None: all over.

    Raises InputError where a joint can have no rim.
    """
    blocks = tuple(replace(block, joint=replace(block.joint, rim=rim)) for block in column.blocks)
    return replace(column, blocks=blocks)


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


@dataclass(frozen=True, eq=False)
class ModulusFit:
    """Moduli of the joints that were fitted to measured frequencies."""

    moduli: FloatArray  # (n,) N/m3
    each: bool  # whether each joint has a modulus of its own; otherwise one factor on those of the column
    measured: FloatArray  # (m,) Hz, of the modes that sway from the first on; NaN where one was not measured
    fitted: FloatArray  # (m,) Hz, of the column with these moduli
    spread: FloatArray  # (n,) relative standard error of each modulus for one of SPREAD in every frequency
    another: FloatArray | None  # (n,) N/m3, moduli that have the same frequencies, if others were found

    @property
    def difference(self) -> FloatArray:
        """Relative difference of the fitted frequencies from the measured ones, (m,)."""
        found: FloatArray = self.fitted / self.measured - 1.0
        return found

    @property
    def determined(self) -> NDArray[np.bool_]:
        """Which moduli the frequencies determine, (n,), by how much they change them; `another` set apart."""
        return np.asarray(self.spread < UNDETERMINED)


def modulus_from_frequencies(column: Column, frequencies: Sequence[float]) -> FloatArray:
    """Moduli of the joints, N/m3 (n,): those of the column times the one factor that suits measured frequencies best.

    frequencies: Hz, of the first, second ... mode that sways; NaN where one was not measured. Least squares of the
    relative differences. Warns (InputWarning) of a frequency that the fit misses by more than 5 %. Raises InputError,
    SolverError.
    """
    return _warned(_fitted(column, _measured(column, frequencies), each=False)).moduli


def fit_moduli(column: Column, frequencies: Sequence[float]) -> ModulusFit:
    """Moduli that fit measured frequencies, one for each joint if as many frequencies are measured as there are joints.

    Several sets of moduli may have the same frequencies: of those found, the one whose ratios are nearest to the
    column's own is taken. Warns (InputWarning) also of such a set, and of moduli that the frequencies do not determine.
    """
    measured = _measured(column, frequencies)
    fit = _fitted(column, measured, each=False)
    if column.n > 1 and np.count_nonzero(np.isfinite(measured)) == column.n:
        fit = _fitted(with_joints(column, fit.moduli), measured, each=True)
    return _warned(fit)


def _measured(column: Column, frequencies: Sequence[float]) -> FloatArray:
    measured = np.asarray(frequencies, dtype=np.float64)
    known = np.isfinite(measured)
    if measured.ndim != 1 or not 1 <= measured.size <= column.n or not known.any() or np.any(measured[known] <= 0.0):
        raise InputError(
            f"frequencies = {frequencies}: must be up to {column.n} positive frequencies in Hz, from the first mode on"
        )
    return measured


def _fitted(column: Column, measured: FloatArray, each: bool) -> ModulusFit:
    """The unknowns are logarithms of the factors on the column's moduli: one, or one for each joint."""
    known = np.flatnonzero(np.isfinite(measured))
    given = np.array([block.joint.stiffness for block in column.blocks])
    count = column.n if each else 1

    def moduli(logarithms: FloatArray) -> FloatArray:
        return np.asarray(given * np.exp(np.clip(logarithms, -FARTHEST, FARTHEST)))

    def differences(logarithms: FloatArray) -> FloatArray:
        try:
            found = sway_frequencies(with_joints(column, moduli(logarithms)))
        except (InputError, SolverError):  # too soft to stand, or beyond any modulus
            return np.full(known.size, -1.0)
        difference: FloatArray = found[known] / measured[known] - 1.0
        return difference

    def sensitivity(logarithms: FloatArray) -> FloatArray:
        steps = NUDGE * np.eye(count)
        return np.column_stack(
            [(differences(logarithms + step) - differences(logarithms - step)) / (2.0 * NUDGE) for step in steps]
        )

    with needing("calibrate", "scipy"):
        from scipy.optimize import least_squares
    if each:  # the sum of squares has several minima, and sets of moduli that suit
        starts = [np.zeros(count), *(ASIDE * np.eye(count)), *(-ASIDE * np.eye(count))]
    else:  # frequencies go as the root of the modulus, but for the weight; from the stiff side all columns stand
        ratio = measured[known[0]] / sway_frequencies(column)[known[0]]
        starts = [np.full(1, max(2.0 * math.log(ratio), 0.0) + 0.5)]
    limits = {"xtol": 1e-12, "ftol": 1e-12, "gtol": 1e-12}
    tries = [least_squares(differences, start, sensitivity, x_scale=1.0, **limits) for start in starts]
    suited = [tried.x for tried in tries if np.max(np.abs(tried.fun)) < SUITS]
    found = min(suited, key=np.linalg.norm) if suited else min(tries, key=lambda tried: tried.cost).x
    other = max(suited, key=lambda x: np.linalg.norm(x - found), default=found)
    if np.max(np.abs(differences(found))) >= 1.0:
        raise SolverError("no modulus has such frequencies: with softer joints the column does not stand")
    try:
        spread = SPREAD * np.linalg.norm(np.linalg.pinv(sensitivity(found), LEAST_SENSITIVITY), axis=1)
    except np.linalg.LinAlgError:
        spread = np.full(count, math.inf)
    fitted = sway_frequencies(with_joints(column, moduli(found)))[: measured.size]
    spread = np.broadcast_to(spread, given.shape).copy()
    another = moduli(other) if np.linalg.norm(other - found) > SAME else None
    return ModulusFit(moduli(found), each, measured, fitted, spread, another)


def _warned(fit: ModulusFit) -> ModulusFit:
    """The fit, after a warning of each frequency that it misses and each modulus that is not determined."""
    for mode, (measured, fitted, off) in enumerate(zip(fit.measured, fit.fitted, fit.difference, strict=True), start=1):
        if abs(off) > MISSED:
            why = (
                "no moduli near those of the column have these frequencies"
                if fit.each
                else f"one factor on all moduli does not suit it; {fit.moduli.size} frequencies give each joint its own"
            )
            _warn(f"frequency {mode}: {measured:g} Hz measured, {fitted:.5g} Hz of the fit, {off:+.1%}: {why}")
    for joint in np.flatnonzero(~fit.determined):
        what = f"{percent(SPREAD)} in the frequencies is more than {percent(UNDETERMINED)} in it"
        _warn(f"joint {joint + 1}: its modulus is not determined, {what}")
    if fit.another is not None:
        listed = ", ".join(f"{modulus:.4g}" for modulus in fit.another)
        _warn(
            f"moduli of {listed} N/m3 have these frequencies too: ratios nearer to the true ones in the column file, "
            "or shapes of the modes, tell which are meant"
        )
    return fit


def _warn(line: str) -> None:
    warnings.warn(line, InputWarning, stacklevel=4)


def sway_frequencies(column: Column) -> FloatArray:
    """Natural frequencies of the n modes that sway, Hz, ascending. Raises as `natural_modes` does."""
    modes = modes_about_rest(column)
    found: FloatArray = modes.frequency[modes.sways]
    return found


# --- damping


def damping_from_ratio(column: Column, ratio: float, mode: int = 1) -> float:
    """eta of all joints, s, that gives one mode that sways, counted from 1, this ratio of critical damping.

    All joints in contact, small motion. Raises InputError, SolverError.
    """
    ratio = check_number("ratio", ratio, NOT_NEGATIVE, "a ratio of critical damping, zero or positive")
    mode = check_whole("mode", mode, 1, column.n, f"the number of a mode that sways, 1 to {column.n}")
    modes = modes_about_rest(with_joints(column, damping=1.0))
    return ratio / float(modes.damping_ratio[modes.sways][mode - 1])


def damping_from_restitution(column: Column, wanted: float | None = None, release: float = RELEASE) -> float:
    """eta of all joints, s, at which the column, pulled aside and let go, has this restitution (rocking.py).

    wanted: rotation rate after over before the impact; None: that of Housner's rigid block. release: as in
    `rocking.restitution`, on which the restitution depends. More damping does not always leave less: the least eta is
    found, with a warning (InputWarning) where there are others. Raises InputError if no damping has it, SolverError.
    """
    rigid = wanted is None
    wanted = housner_restitution(column) if wanted is None else wanted
    wanted = check_number("restitution", wanted, (1e-6, 1.0 - 1e-9), "a ratio of rotation rates, between 0 and 1")
    with needing("calibrate", "scipy"):
        from scipy.optimize import brentq
    start, top = pulled_aside(column, release)

    def above(logarithm: float) -> float:
        return restitution_from(with_joints(column, damping=math.exp(logarithm)), start, top) - wanted

    logarithms = [float(value) for value in np.log(ETAS)]
    differences = [above(value) for value in logarithms]
    crossed = [k for k, (before, after) in enumerate(pairwise(differences)) if before * after <= 0.0]
    curve = _curve_text([wanted + difference for difference in differences])
    if differences[0] <= 0.0:
        raise InputError(
            f"restitution = {wanted:.6g}: must be less than {wanted + differences[0]:.6g}, which joints leave without "
            f"damping (eta = {ETAS[0]:g} s): {column.n} blocks lose the rest as they strike and vibrate, which a rigid "
            "block does not; give a measured restitution, or the damping in contact by --damping-ratio"
        )
    most = damping_from_ratio(column, 1.0)
    if not crossed or (rigid and above(math.log(most)) > 0.0 and ETAS[crossed[0]] > most):
        reached = [(wanted + difference, eta) for difference, eta in zip(differences, ETAS, strict=True) if eta < most]
        nearest, eta = min([*reached, (wanted + above(math.log(most)), most)])
        raise InputError(
            f"restitution = {wanted:.6g}: no damping reaches it up to the critical one, {most:.3g} s in the first "
            f"mode; the nearest is {nearest:.4g}, of damping = {eta:.3g} s; joints of this stiffness leave {curve}; "
            "softer joints lose more (--young, --frequencies), or a rim (--rim auto); or take the damping in contact "
            "by --damping-ratio, and say so"
        )
    k = crossed[0]
    if len(crossed) > 1:
        others = " and ".join(f"{ETAS[j]:.2g} to {ETAS[j + 1]:.2g} s" for j in crossed[1:])
        warnings.warn(
            f"restitution = {wanted:.6g}: damping from {others} has it as well, the least is taken; it is not "
            f"monotone: {curve}",
            InputWarning,
            stacklevel=2,
        )
    eta = math.exp(float(brentq(above, logarithms[k], logarithms[k + 1], xtol=DIGITS)))
    if eta > most:
        beyond = (
            f"restitution = {wanted:.6g}: takes damping = {eta:.3g} s, beyond the critical one, {most:.3g} s in the "
        )
        if rigid:
            nearest = wanted + above(math.log(most))
            raise InputError(f"{beyond}first mode: the nearest up to it is {nearest:.4g}, of damping = {most:.3g} s")
        warnings.warn(
            f"{beyond}first mode: joints that no block has; a rim has it at less (--rim auto)",
            InputWarning,
            stacklevel=2,
        )
    return eta


class RimFit(NamedTuple):
    """Where faces touch, and the damping, that were found for a restitution."""

    rim: float | None  # m, None: the whole face
    damping: float  # s, eta of all joints
    restitution: float  # of the column with both


def rim_from_restitution(column: Column, wanted: float | None = None, release: float = RELEASE) -> RimFit:
    """Find the rim of all joints at which the column, pulled aside and let go, has this restitution.

    The damping is critical on the edge (`column_damping_on_edge`). The widest rim is found: the narrower it is, the
    nearer to the edge an impact acts, and the more it costs. Where whole faces lose as much, they stay, with the
    damping of `damping_from_restitution`. Rims and damping of `column` do not count.

    Parameters
    ----------
    column : Column
        In which the moduli stay.
    wanted : float, optional
        Rotation rate after an impact over that before it; left out, that of Housner's rigid block.
    release : float
        As in `rocking.restitution`, on which the restitution depends.

    Returns
    -------
    RimFit
        With the restitution reached. Warns (InputWarning) where that is only near to the one asked for.

    Raises
    ------
    InputError
        If no rim comes near to the restitution, or a joint can have none.
    SolverError
        If the column does not stand.
    """
    column = with_rim(column, None)
    wanted = housner_restitution(column) if wanted is None else wanted
    wanted = check_number("restitution", wanted, (1e-6, 1.0 - 1e-9), "a ratio of rotation rates, between 0 and 1")
    with needing("calibrate", "scipy"):
        from scipy.optimize import brentq
    half = _half_of_face(column)  # m, the rim that is the whole face

    def fit(rim: float | None) -> RimFit:
        touching = with_rim(column, rim)
        damping = column_damping_on_edge(touching)
        return RimFit(rim, damping, restitution(with_joints(touching, damping=damping), release))

    tried = [fit(None)]
    if tried[0].restitution <= wanted:
        damping = damping_from_restitution(column, wanted, release)
        return RimFit(None, damping, restitution(with_joints(column, damping=damping), release))
    for part in RIMS:
        try:
            tried.append(fit(float(part) * half))
        except (InputError, SolverError):  # so narrow that the column does not stand on it
            break
        if tried[-1].restitution <= wanted:
            wider, narrower = (math.log(one.rim or half) for one in tried[-2:])
            log = brentq(lambda log: fit(math.exp(log)).restitution - wanted, narrower, wider, xtol=DIGITS)
            return _damped(column, fit(math.exp(float(log))), wanted, release)
    nearest = min(tried, key=lambda one: one.restitution - wanted)
    touching = "whole faces" if nearest.rim is None else f"a rim of {nearest.rim:.3g} m"
    line = (
        f"restitution = {wanted:.6g}: no rim down to {(tried[-1].rim or half):.2g} m reaches it; the nearest is "
        f"{nearest.restitution:.4g}, of {touching} and damping = {nearest.damping:.3g} s, critical on the edge"
    )
    if nearest.restitution - wanted > NEAR_ENOUGH * wanted:
        raise InputError(
            f"{line}; softer joints lose more, and so do bases long across the motion, or strips at their edges"
        )
    warnings.warn(line, InputWarning, stacklevel=2)
    return nearest


def _damped(column: Column, fit: RimFit, wanted: float, release: float) -> RimFit:
    """Return the fit with another damping where its restitution jumps past the one asked for at this rim."""
    if abs(fit.restitution - wanted) <= SAME_RESTITUTION:
        return fit
    touching = with_rim(column, fit.rim)
    try:
        damping = damping_from_restitution(touching, wanted, release)
    except InputError:
        return fit
    return RimFit(fit.rim, damping, restitution(with_joints(touching, damping=damping), release))


def _half_of_face(column: Column) -> float:
    """Return the rim (m) that is the whole face under the part that rocks."""
    contact = column.contacts[rocking_part(column).joint - 1]
    return min(0.5 * contact.width - 0.25 * contact.bore, 0.5 * contact.depth)


def _curve_text(values: list[float]) -> str:
    """The ends and the turns of the restitution over the damping, ETAS, in words."""
    inner = range(1, len(values) - 1)
    turns = [k for k in inner if (values[k] - values[k - 1]) * (values[k + 1] - values[k]) < 0.0]
    return ", ".join(f"{values[k]:.4g} at eta = {ETAS[k]:.2g} s" for k in (0, *turns, len(values) - 1))


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
            f"free vibration: a decaying swing explains {percent(max(0.0, explained))} of the record's variance, must "
            f"be at least {percent(FOUND)}; choose a part in which one mode is left"
        )
    omega, ratio = (float(value) for value in best.x)
    return FreeVibration(omega / (2.0 * math.pi), ratio, explained, fit(best.x))


def read_history(path: str | os.PathLike[str], channel: str | None = None) -> tuple[FloatArray, FloatArray]:
    """Read times and one of the columns of a CSV file with a header, as `Response.to_csv` writes it.

    channel: its name; None: the second. Raises InputError.
    """
    with reading(path):
        table = table_of(lines_of(path, MOST_TABLE))
        names = list(table.names)
        if len(names) < 2:
            raise InputError("must be a CSV file of times and values, with a header")
        if channel is not None and channel not in names[1:]:
            raise InputError(f"channel = {channel}: must be one of {', '.join(names[1:10])}")
        k = 1 if channel is None else names.index(channel)
        values = table.numbers([0, k])
        check_times(table.lines, values[:, 0].tolist())
        time, _ = from_zero([row[0] for row in table.rows], values[:, 0])
    return time, values[:, 1]


def _strongest_frequency(t: FloatArray, y: FloatArray) -> float:
    """Circular frequency, 1/s, at which a record has most."""
    even = np.linspace(t[0], t[-1], max(64, t.size))
    swing = np.interp(even, t, y)
    size = 8 * even.size
    spectrum = np.abs(np.fft.rfft((swing - np.mean(swing)) * np.hanning(2 * even.size)[even.size :], size))
    k = 1 + int(np.argmax(spectrum[1:]))
    return 2.0 * math.pi * k / (size * float(even[1] - even[0]))


def _each(key: str, column: Column, given: ArrayLike | None, defaults: list[float]) -> list[float]:
    if given is None:
        return defaults
    values = np.asarray(given, dtype=np.float64)
    if values.ndim > 1 or values.size not in (1, column.n):
        raise InputError(f"{key}: {values.size} numbers, must be one or {column.n}, one for each joint")
    return [float(value) for value in np.broadcast_to(values.reshape(-1), (column.n,))]
