"""Calibration of modulus, damping and rim of joints from measured elasticity, frequencies, decay or restitution.

Every function returns numbers for `with_joints` or `with_rim`, and leaves the column unchanged.
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
    check_type,
    check_whole,
    needing,
    reading,
    shown,
)
from ..common.files import MOST_TABLE
from ..common.tables import numbers_of
from ..common.text import lines_of
from ..common.text_tables import check_times, from_zero, table_of, unit_in
from ..models.column.model import Column
from ..models.column.modes import modes_about_rest
from ..models.column.packing import FloatArray
from .rocking import RELEASE, housner_restitution, pulled_equilibrium, restitution, restitution_from, rocking_part
from .rocking import column_damping_on_edge as column_damping_on_edge
from .rocking import damping_on_edge as damping_on_edge

ETAS = np.geomspace(1e-6, 10.0, 15)  # s, dampings that bracket the solution
DIGITS = 1e-6  # relative tolerance of eta
RIMS = 0.5 ** np.arange(1.0, 11.0)  # over half a face, rims that bracket the solution
NEAR_ENOUGH = 5e-3  # relative error at which the nearest restitution is accepted, with a warning
SAME_RESTITUTION = 1e-5  # tolerance of equal restitutions
SWING = (0.0, 0.95)  # range of the damping ratio of a free vibration
MISSED = 0.05  # relative difference of a frequency above which a warning is issued
SPREAD = 0.01  # relative standard error of each measured frequency, for the accuracy of the moduli
UNDETERMINED = 1.0  # relative standard error from which a modulus counts as undetermined
NUDGE = 1e-3  # step of finite differences, in the logarithm of a modulus
ASIDE = 1.4  # distance of further starts from the moduli of the column, in that logarithm
SUITS = 1e-6  # relative error up to which a fit matches a frequency
SAME = 1e-3  # distance between logarithms of moduli up to which two sets are one
LEAST_SENSITIVITY = 1e-8  # least singular value over the largest: below it is rounding
FARTHEST = 30.0  # largest logarithm of a factor on the moduli
LEAST_SAMPLES = 8  # of a record
FOUND = 0.5  # least part of the variance of a record that the fit must explain


@dataclass(frozen=True, eq=False)
class FreeVibration:
    """The damped oscillation, exp(-2 pi ratio frequency t), fitted to a record."""

    frequency: float  # Hz, undamped
    ratio: float  # damping ratio
    explained: float  # part of the variance of the record, 0 to 1
    fitted: FloatArray  # at the samples, in the units of the record


def with_joints(column: Column, stiffness: ArrayLike | None = None, damping: ArrayLike | None = None) -> Column:
    """Return the column with other moduli or dampings of its joints.

    Parameters
    ----------
    column : Column
        The column, which stays unchanged.
    stiffness : float or (n,) float, optional
        Moduli (N/m3), one for all joints or n, the top joint first. None keeps those of the column.
    damping : float or (n,) float, optional
        Dampings eta (s), likewise.

    Raises
    ------
    InputError
        If the number of values is neither 1 nor n, or a value is not allowed.
    """
    check_type("column", column, Column)
    moduli = _each("stiffness", column, stiffness, [block.joint.stiffness for block in column.blocks])
    etas = _each("damping", column, damping, [block.joint.damping for block in column.blocks])
    return column.with_joints(moduli, etas)


def with_rim(column: Column, rim: float | None) -> Column:
    """Return the column whose faces touch in a band of this width (m) at every joint.

    `rim` None stands for contact over the whole face. Raises InputError if a joint can have no rim.
    """
    check_type("column", column, Column)
    blocks = tuple(replace(block, joint=replace(block.joint, rim=rim)) for block in column.blocks)
    return replace(column, blocks=blocks)


# --- modulus


def modulus_from_elasticity(
    column: Column, young: float, joint_thickness: float = 0.0, joint_young: float | None = None
) -> FloatArray:
    """Return the moduli of the joints (N/m3), (n,): 1 / k = H / E + t / E_j, with H the height of the block.

    Each block belongs to the joint under it.

    Parameters
    ----------
    column : Column
        The column, for the heights H of its blocks.
    young : float
        Modulus of elasticity E of the blocks (Pa).
    joint_thickness : float
        Thickness t of mortar or lead in the joint (m).
    joint_young : float, optional
        Modulus of elasticity E_j of that layer (Pa), needed if the thickness is positive.

    Raises
    ------
    InputError
        If a value is not positive, or one of `joint_thickness` and `joint_young` is missing.
    """
    check_type("column", column, Column)
    young = check_number("young", young, POSITIVE, "a positive modulus of elasticity in Pa")
    thickness = check_number("joint_thickness", joint_thickness, NOT_NEGATIVE, "a thickness in m, zero or positive")
    give = np.array([block.height for block in column.blocks]) / young
    if thickness > 0.0:
        if joint_young is None:
            raise InputError(f"joint_young: missing, must be the modulus in Pa of what is {thickness:g} m thick")
        give += thickness / check_number("joint_young", joint_young, POSITIVE, "a positive modulus in Pa")
    elif joint_young is not None:
        raise InputError(f"joint_thickness: missing, must be the thickness in m of what has {shown(joint_young)} Pa")
    return np.asarray(1.0 / give)


@dataclass(frozen=True, eq=False)
class ModulusFit:
    """The moduli of the joints, fitted to measured frequencies."""

    moduli: FloatArray  # (n,) N/m3
    each: bool  # whether each joint has its own modulus, else one factor on those of the column
    measured: FloatArray  # (m,) Hz, of the sway modes from the first on; NaN if not measured
    fitted: FloatArray  # (m,) Hz, of the column with these moduli
    spread: FloatArray  # (n,) relative standard error of each modulus, for SPREAD in every frequency
    another: FloatArray | None  # (n,) N/m3, other moduli with the same frequencies, if found

    @property
    def difference(self) -> FloatArray:
        """The relative difference of the fitted from the measured frequencies, (m,)."""
        return self.fitted / self.measured - 1.0

    @property
    def determined(self) -> NDArray[np.bool_]:
        """True for each modulus that the frequencies determine, (n,), from their sensitivity to it.

        A second set of moduli (`another`) is not considered.
        """
        return np.asarray(self.spread < UNDETERMINED)


def modulus_from_frequencies(column: Column, frequencies: Sequence[float]) -> FloatArray:
    """Return the moduli of the column times the one factor that fits measured frequencies best (N/m3), (n,).

    The fit minimizes the squares of the relative differences. Warns (InputWarning) of each frequency that it misses by
    more than 5 %.

    Parameters
    ----------
    column : Column
        The column, whose ratios of moduli are kept.
    frequencies : sequence of float
        Frequencies (Hz) of the sway modes from the first on; NaN for a mode that was not measured.

    Raises
    ------
    InputError
        If the frequencies are not valid.
    SolverError
        If no factor gives such frequencies, or the column does not stand.
    """
    return _warned(_fitted(column, _measured(column, frequencies), each=False)).moduli


def fit_moduli(column: Column, frequencies: Sequence[float]) -> ModulusFit:
    """Fit the moduli to measured frequencies: one for each joint if all n are measured, else one factor.

    Several sets of moduli may have the same frequencies: of those found, the one whose ratios are nearest to those of
    the column is returned. Warns (InputWarning) of such a set, of missed frequencies, and of moduli that the
    frequencies do not determine.

    Parameters
    ----------
    column : Column
        The column.
    frequencies : sequence of float
        Frequencies (Hz) of the sway modes from the first on; NaN for a mode that was not measured.

    Raises
    ------
    InputError, SolverError
        As `modulus_from_frequencies` does.
    """
    measured = _measured(column, frequencies)
    fit = _fitted(column, measured, each=False)
    if column.n > 1 and np.count_nonzero(np.isfinite(measured)) == column.n:
        fit = _fitted(with_joints(column, fit.moduli), measured, each=True)
    return _warned(fit)


def _measured(column: Column, frequencies: Sequence[float]) -> FloatArray:
    check_type("column", column, Column)
    measured = numbers_of("frequencies", frequencies)
    known = np.isfinite(measured)
    if measured.ndim != 1 or not 1 <= measured.size <= column.n or not known.any() or np.any(measured[known] <= 0.0):
        raise InputError(
            f"frequencies = {frequencies}: must be up to {column.n} positive frequencies in Hz, from the first mode on"
        )
    return measured


def _fitted(column: Column, measured: FloatArray, each: bool) -> ModulusFit:
    """Fit the logarithms of the factors on the moduli: one, or one for each joint if `each`.

    `measured` are the frequencies (Hz), (m,), NaN where unknown.
    """
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
        return found[known] / measured[known] - 1.0

    def sensitivity(logarithms: FloatArray) -> FloatArray:
        steps = NUDGE * np.eye(count)
        return np.column_stack(
            [(differences(logarithms + step) - differences(logarithms - step)) / (2.0 * NUDGE) for step in steps]
        )

    with needing("calibrate", "scipy"):
        from scipy.optimize import least_squares
    if each:  # the sum of squares has several minima: start from several sets of moduli
        starts = [np.zeros(count), *(ASIDE * np.eye(count)), *(-ASIDE * np.eye(count))]
    else:  # frequencies grow with the root of the modulus, but for the weight; from the stiff side all columns stand
        ratio = measured[known[0]] / sway_frequencies(column)[known[0]]
        starts = [np.full(1, max(2.0 * math.log(ratio), 0.0) + 0.5)]
    # of all fits that match, take the one nearest to the ratios of the column; else the best one
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
    # frequencies of the fit, and a second set of moduli if there is one
    fitted = sway_frequencies(with_joints(column, moduli(found)))[: measured.size]
    spread = np.broadcast_to(spread, given.shape).copy()
    another = moduli(other) if np.linalg.norm(other - found) > SAME else None
    return ModulusFit(moduli(found), each, measured, fitted, spread, another)


def _warned(fit: ModulusFit) -> ModulusFit:
    """Return the fit, after warnings of missed frequencies, undetermined moduli and a second set of moduli."""
    # frequencies, undetermined moduli, second set of moduli
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


def _warn(line: str, level: int = 4) -> None:
    warnings.warn(line, InputWarning, stacklevel=level)


def sway_frequencies(column: Column) -> FloatArray:
    """Return the natural frequencies of the n sway modes (Hz), ascending. Raises as `natural_modes` does."""
    check_type("column", column, Column)
    modes = modes_about_rest(column)
    return modes.frequency[modes.sways]


# --- damping


def damping_from_ratio(column: Column, ratio: float, mode: int = 1) -> float:
    """Return the eta (s) of all joints that gives one sway mode this damping ratio.

    All joints are in contact and the motion is small.

    Parameters
    ----------
    column : Column
        The column; its own damping does not count.
    ratio : float
        Ratio to critical damping.
    mode : int
        Number of the sway mode, from 1.

    Raises
    ------
    InputError
        If a value is out of range.
    SolverError
        If the column does not stand.
    """
    check_type("column", column, Column)
    ratio = check_number("ratio", ratio, NOT_NEGATIVE, "a ratio of critical damping, zero or positive")
    mode = check_whole("mode", mode, 1, column.n, f"the number of a mode that sways, 1 to {column.n}")
    modes = modes_about_rest(with_joints(column, damping=1.0))
    return ratio / float(modes.damping_ratio[modes.sways][mode - 1])


def damping_from_restitution(column: Column, wanted: float | None = None, release: float = RELEASE) -> float:
    """Return the eta (s) of all joints at which the column, pulled aside and released, has this restitution.

    More damping does not always mean less restitution: the least eta is returned, with a warning (InputWarning) if
    there are others. See rocking.py.

    Parameters
    ----------
    column : Column
        The column; its own damping does not count.
    wanted : float, optional
        Ratio of the rotation rates after and before the impact; by default that of Housner's rigid block.
    release : float
        As in `rocking.restitution`; the restitution depends on it.

    Raises
    ------
    InputError
        If no damping gives this restitution.
    SolverError
        If the column does not stand or falls.
    """
    rigid = wanted is None
    wanted = housner_restitution(column) if wanted is None else wanted
    wanted = check_number("restitution", wanted, (1e-6, 1.0 - 1e-9), "a ratio of rotation rates, between 0 and 1")
    with needing("calibrate", "scipy"):
        from scipy.optimize import brentq
    start, top = pulled_equilibrium(column, release)

    def above(logarithm: float) -> float:
        return restitution_from(with_joints(column, damping=math.exp(logarithm)), start, top) - wanted

    # restitution over the damping: intervals in which it crosses the wanted value
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
    # solve in the first interval
    k = crossed[0]
    if len(crossed) > 1:
        others = " and ".join(f"{ETAS[j]:.2g} to {ETAS[j + 1]:.2g} s" for j in crossed[1:])
        least = "has it as well, the least is taken; it is not monotone"
        _warn(f"restitution = {wanted:.6g}: damping from {others} {least}: {curve}", 3)
    eta = math.exp(float(brentq(above, logarithms[k], logarithms[k + 1], xtol=DIGITS)))
    if eta > most:
        critical = f"the critical one, {most:.3g} s in the first mode"
        beyond = f"restitution = {wanted:.6g}: takes damping = {eta:.3g} s, beyond {critical}"
        if rigid:
            nearest = wanted + above(math.log(most))
            raise InputError(f"{beyond}: the nearest up to it is {nearest:.4g}, of damping = {most:.3g} s")
        _warn(f"{beyond}: joints that no block has; a rim has it at less (--rim auto)", 3)
    return eta


class RimFit(NamedTuple):
    """The rim and the damping that give a restitution."""

    rim: float | None  # m, None: the whole face
    damping: float  # s, eta of all joints
    restitution: float  # of the column with both


def rim_from_restitution(column: Column, wanted: float | None = None, release: float = RELEASE) -> RimFit:
    """Return the rim of all joints at which the column, pulled aside and released, has this restitution.

    The damping is critical on the edge (`column_damping_on_edge`). The widest rim is returned: the narrower it is, the
    nearer to the edge an impact acts, and the more energy it costs. If whole faces lose as much, they are kept, with
    the damping of `damping_from_restitution`. Rims and damping of `column` do not count.

    Parameters
    ----------
    column : Column
        The column; its moduli are kept.
    wanted : float, optional
        Ratio of the rotation rates after and before the impact; by default that of Housner's rigid block.
    release : float
        As in `rocking.restitution`; the restitution depends on it.

    Returns
    -------
    RimFit
        The rim, the damping, and the restitution reached. Warns (InputWarning) if it is only near to the one wanted.

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
    contact = column.contacts[rocking_part(column).joint - 1]
    half = min(0.5 * contact.width - 0.25 * contact.bore, 0.5 * contact.depth)  # m, rim that covers the whole face

    def fit(rim: float | None) -> RimFit:
        touching = with_rim(column, rim)
        damping = column_damping_on_edge(touching)
        return RimFit(rim, damping, restitution(with_joints(touching, damping=damping), release))

    # whole faces first
    tried = [fit(None)]
    if tried[0].restitution <= wanted:
        damping = damping_from_restitution(column, wanted, release)
        return RimFit(None, damping, restitution(with_joints(column, damping=damping), release))
    # narrower and narrower rims, until one encloses the wanted value
    for part in RIMS:
        try:
            tried.append(fit(float(part) * half))
        except (InputError, SolverError):  # so narrow that the column does not stand on it
            break
        if tried[-1].restitution <= wanted:
            wider, narrower = (math.log(one.rim or half) for one in tried[-2:])
            log = brentq(lambda log: fit(math.exp(log)).restitution - wanted, narrower, wider, xtol=DIGITS)
            return _damped(column, fit(math.exp(float(log))), wanted, release)
    # no rim reaches it: the nearest, if near enough
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
    _warn(line, 3)
    return nearest


def _damped(column: Column, fit: RimFit, wanted: float, release: float) -> RimFit:
    """Return the fit with another damping if its restitution jumps past the one wanted at this rim."""
    if abs(fit.restitution - wanted) <= SAME_RESTITUTION:
        return fit
    touching = with_rim(column, fit.rim)
    try:
        damping = damping_from_restitution(touching, wanted, release)
    except InputError:
        return fit
    return RimFit(fit.rim, damping, restitution(with_joints(touching, damping=damping), release))


def _curve_text(values: list[float]) -> str:
    """Return the ends and the extrema of the restitution over the damping, ETAS, as text."""
    inner = range(1, len(values) - 1)
    turns = [k for k in inner if (values[k] - values[k - 1]) * (values[k + 1] - values[k]) < 0.0]
    return ", ".join(f"{values[k]:.4g} at eta = {ETAS[k]:.2g} s" for k in (0, *turns, len(values) - 1))


def free_vibration(time: ArrayLike, values: ArrayLike) -> FreeVibration:
    """Fit a damped oscillation to a record of free vibration, by least squares over all its samples.

    Parameters
    ----------
    time : (m,) float
        Time (s), increasing.
    values : (m,) float
        Record in any unit; a constant offset does not matter.

    Returns
    -------
    FreeVibration
        Frequency, damping ratio, and quality of the fit.

    Raises
    ------
    InputError
        If the oscillation explains less than half of the variance of the record, or the record is not valid.
    """
    t, y = numbers_of("time", time), numbers_of("values", values)
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
        """Return the oscillation of this circular frequency (1/s) and damping ratio that is nearest to the record."""
        omega, ratio = unknowns
        phase = omega * math.sqrt(1.0 - ratio * ratio) * t
        decay = np.exp(-ratio * omega * t)
        parts = np.column_stack([decay * np.cos(phase), decay * np.sin(phase), np.ones_like(t)])
        return parts @ np.linalg.lstsq(parts, y, rcond=None)[0]

    def missed(unknowns: FloatArray) -> FloatArray:
        return (fit(unknowns) - y) / math.sqrt(variance)

    # fit from several damping ratios, and keep the best
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
    bounds = (omega / start, 0.3), (omega / start, 3.0), (ratio, SWING[1])
    if any(math.isclose(value, bound, rel_tol=1e-3) for value, bound in bounds):
        raise InputError(
            f"free vibration: no swing that decays fits, the best, {omega / (2.0 * math.pi):.3g} Hz with a damping "
            f"ratio of {ratio:.3g}, is at the bounds of the search; choose a part in which one mode is left"
        )
    return FreeVibration(omega / (2.0 * math.pi), ratio, explained, fit(best.x))


def read_history(
    path: str | os.PathLike[str], channel: str | None = None, begin: float = -math.inf, end: float = math.inf
) -> tuple[FloatArray, FloatArray]:
    """Read the times (s) and one column of a CSV file with a header, as `Response.to_csv` writes it.

    Parameters
    ----------
    path : str or PathLike
        The file.
    channel : str, optional
        Name of the column, by default the second.
    begin, end : float
        First and last time (s), as in the file, of the part that is read.

    Returns
    -------
    time, values : (m,) float
        The times begin at 0 if they are too large for their steps, as seconds since 1970.

    Raises
    ------
    InputError
        If the file is not such a table.
    """
    with reading(path):
        table = table_of(lines_of(path, MOST_TABLE))
        names = list(table.names)
        if len(names) < 2:
            raise InputError("must be a CSV file of times and values, with a header")
        if unit_in(names[0]) not in (None, "s"):
            raise InputError(f"line 1: {shown(names[0])}: must be times in s")
        if channel is not None and channel not in names[1:]:
            raise InputError(f"channel = {channel}: must be one of {', '.join(names[1:10])}")
        k = 1 if channel is None else names.index(channel)
        values = table.numbers([0, k])
        check_times(table.lines, values[:, 0].tolist())
        part = np.flatnonzero((values[:, 0] >= begin) & (values[:, 0] <= end))
        time, _ = from_zero([table.rows[k][0] for k in part], values[part, 0])
    return time, values[part, 1]


def _strongest_frequency(t: FloatArray, y: FloatArray) -> float:
    """Return the circular frequency (1/s) at which the spectrum of a record is largest."""
    even = np.linspace(t[0], t[-1], max(64, t.size))
    swing = np.interp(even, t, y)
    size = 8 * even.size
    spectrum = np.abs(np.fft.rfft((swing - np.mean(swing)) * np.hanning(2 * even.size)[even.size :], size))
    k = 1 + int(np.argmax(spectrum[1:]))
    return 2.0 * math.pi * k / (size * float(even[1] - even[0]))


def _each(key: str, column: Column, given: ArrayLike | None, defaults: list[float]) -> list[float]:
    if given is None:
        return defaults
    values = numbers_of(key, given)
    if values.ndim > 1 or values.size not in (1, column.n):
        raise InputError(f"{key}: {values.size} numbers, must be one or {column.n}, one for each joint")
    return [float(value) for value in np.broadcast_to(values.reshape(-1), (column.n,))]
