"""Synthetic motions near a fault by magnitude and distance: a velocity pulse added to filtered noise.

Amplitude, period and duration follow published relations; the factors represent their scatter:

- PGA of the noise: Joyner and Boore (1981), Bull. Seism. Soc. Am. 71 (6), 2011-2038; standard deviation 0.26 of the
  decimal logarithm.
- PGV of the pulse: Bray and Rodriguez-Marek (2004), Soil Dyn. Earthq. Eng. 24 (11), 815-828, from motions with forward
  directivity, magnitudes 6.1 to 7.6, up to 20 km; or Joyner and Boore (1981), from all motions, on rock, which grows
  more with magnitude; standard deviation 0.22 of the decimal logarithm.
- Period of the pulse: Mavroeidis and Papageorgiou (2003), Bull. Seism. Soc. Am. 93 (3), 1099-1131.
- Time from 5 to 95 % of the Arias intensity: Dobry, Idriss and Ng (1978), Bull. Seism. Soc. Am. 68 (5), 1487-1520,
  on rock.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from ..common.errors import POSITIVE, check_number
from ..ground.motion import STANDARD_GRAVITY, Motion
from ..ground.wavelets import NOISE_STEP, filtered_noise, mavroeidis_papageorgiou

MAGNITUDES, DISTANCES = (5.0, 7.7), (0.0, 370.0)  # ranges of the data of the relations; km
CYCLES = 1.8  # default number of cycles of the pulse
GROUND = 2.5  # Hz, default frequency of the noise
SIGNIFICANT = 0.476  # time from 5 to 95 % of the Arias intensity of the noise, over its length
STRONGEST = 0.375  # middle of the level part of the noise, over its length; the pulse is centred there
OPTIONAL = ("cycles", "phase", "pga_factor", "pgv_factor", "period_factor", "ground")


def pga(magnitude: float, distance: float) -> float:
    """Return the median PGA (m/s2); `distance` (km) is from the surface projection of the fault."""
    r = math.hypot(distance, 7.3)
    return float(STANDARD_GRAVITY * 10.0 ** (-1.02 + 0.249 * magnitude - math.log10(r) - 0.00255 * r))


def pgv(magnitude: float, distance: float) -> float:
    """Return the median PGV of motions with a pulse (m/s); `distance` (km) is from the fault."""
    return 0.01 * math.exp(4.46 + 0.34 * magnitude - 0.58 * math.log(distance * distance + 49.0))


def pgv_of_all(magnitude: float, distance: float) -> float:
    """Return the median PGV of all motions (m/s); `distance` (km) is from the surface projection of the fault."""
    r = math.hypot(distance, 4.0)
    return float(0.01 * 10.0 ** (-0.67 + 0.489 * magnitude - math.log10(r) - 0.00256 * r))


def pulse_period(magnitude: float) -> float:
    """Return the median period of the velocity pulse (s)."""
    return float(10.0 ** (-2.2 + 0.4 * magnitude))


def significant_duration(magnitude: float) -> float:
    """Return the time from 5 to 95 % of the Arias intensity (s)."""
    return float(10.0 ** (-1.83 + 0.432 * magnitude))


def motion(
    magnitude: float,
    distance: float,
    seed: int,
    cycles: float = CYCLES,
    phase: float = 0.0,
    pga_factor: float = 1.0,
    pgv_factor: float = 1.0,
    period_factor: float = 1.0,
    ground: float = GROUND,
    *,
    velocity: Callable[[float, float], float] = pgv,
) -> Motion:
    """Return the pulse of Mavroeidis and Papageorgiou added to filtered noise (wavelets.py).

    Parameters
    ----------
    magnitude : float
        Moment magnitude.
    distance : float
        Distance (km), as in `pga` and `velocity`.
    seed : int
        Seed of the noise.
    cycles : float
        Number of cycles of the pulse.
    phase : float
        Phase of the pulse (degrees).
    pga_factor, pgv_factor, period_factor : float
        Factors on the medians.
    ground : float
        Frequency of the noise (Hz).
    velocity : callable
        Function of magnitude and distance that returns the median PGV of the pulse (m/s).

    Returns
    -------
    Motion
        The motion.

    Raises
    ------
    InputError
        If a value is out of range.
    """
    magnitude = check_number("motion.magnitude", magnitude, MAGNITUDES, "a magnitude from {} to {}".format(*MAGNITUDES))
    distance = check_number("motion.distance", distance, DISTANCES, "a distance in km from {} to {}".format(*DISTANCES))
    for key, factor in (("pga_factor", pga_factor), ("pgv_factor", pgv_factor), ("period_factor", period_factor)):
        check_number(f"motion.{key}", factor, POSITIVE, "a positive number")
    # noise and pulse of unit size
    length = significant_duration(magnitude) / SIGNIFICANT
    noise = _noise(ground, length, seed)
    pulse = mavroeidis_papageorgiou(1.0, 1.0 / (period_factor * pulse_period(magnitude)), cycles, math.radians(phase))
    largest = float(np.max(np.abs(np.cumsum(0.5 * np.diff(pulse.time) * (pulse.ax[1:] + pulse.ax[:-1])))))  # m/s
    # shift both so that the middle of the pulse is that of the strong part of the noise
    before = max(0.0, 0.5 * pulse.duration - STRONGEST * noise.duration)  # delay of the noise after the start
    begin = before + STRONGEST * noise.duration - 0.5 * pulse.duration
    count = math.ceil(max(before + noise.duration, begin + pulse.duration) / NOISE_STEP)
    time = NOISE_STEP * np.arange(count + 1, dtype=np.float64)
    # scale and add
    ax = pga_factor * pga(magnitude, distance) * np.interp(time - before, noise.time, noise.ax, left=0.0, right=0.0)
    factor = pgv_factor * velocity(magnitude, distance) / largest
    ax += factor * np.interp(time - begin, pulse.time, pulse.ax, left=0.0, right=0.0)
    return Motion(time, ax, np.zeros(count + 1), float(time[-1]))


@lru_cache(maxsize=16)
def _noise(ground: float, length: float, seed: int) -> Motion:
    """Return noise of 1 m/s2 and this `length` (s).

    It is cached: it takes longer than all else, and a study needs the same noise at several distances in turn.
    """
    return filtered_noise(1.0, ground, length, seed)
