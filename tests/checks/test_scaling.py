"""Motions scaled to an action: what they are scaled to is what they have."""

import numpy as np
import pytest

from multiblock import InputError, Motion, spectra, spectrum, wavelets
from solver.checks.action import Action
from solver.checks.scaling import (
    MotionSpectra,
    check_factors,
    factor_lines,
    scaled_to_pga,
    scaled_to_sa,
    scaled_to_spectrum,
    statistic,
)

NOISE = {f"noise {k}": wavelets.filtered_noise(1.0 + k, 2.5, 15.0, k) for k in range(3)}
TARGET = spectra.eurocode8(2.0, "B")


@pytest.mark.parametrize(("factor", "said"), [(0.2, False), (9.9, False), (10.1, True), (99.0, True), (0.09, True)])
def test_factors_that_are_large_are_said(factor: float, said: bool) -> None:
    motions = {"near": Motion.from_samples(0.01, [0.0, 1.0, 0.0])}
    scaled = scaled_to_pga(motions, factor)
    check_factors(scaled, force=False)
    (line,) = factor_lines(scaled) or [""]
    assert line.startswith(f"Factors beyond 0.1 to 10 on 1 of 1 motions: near ({factor:.3g}).") == said


@pytest.mark.parametrize("factor", [101.0, 2e5, 0.009])
def test_factors_that_no_record_bears_are_refused(factor: float) -> None:
    """Check that noise of a far station, scaled 200,000 times, is no ground motion; nor is a vertical component of
    noise.
    """
    far = scaled_to_pga({"far": Motion.from_samples(0.01, [0.0, 1.0, 0.0])}, factor)
    up = scaled_to_pga({"far": Motion.from_samples(0.01, [0.0, 1.0, 0.0], [0.0, 1.0, 0.0])}, 1.0, factor)
    for scaled in (far, up):
        with pytest.raises(InputError, match=r"far: a factor of .*, must be 0\.01 to 100: .*--force-scale"):
            check_factors(scaled, force=False)
        check_factors(scaled, force=True)


def test_to_a_peak_and_to_the_spectrum_at_one_period() -> None:
    for scaled in scaled_to_pga(NOISE, 3.0):
        assert scaled.motion.pga == pytest.approx(3.0, rel=1e-14)
    for scaled in scaled_to_sa(NOISE, 0.4, 5.0):
        assert spectrum(scaled.motion, [0.4]).psa[0] == pytest.approx(5.0, rel=1e-12)


def test_to_a_spectrum_by_its_shape_and_then_together() -> None:
    periods = np.geomspace(0.1, 1.5, 40)
    loose = scaled_to_spectrum(NOISE, TARGET, (0.1, 1.5), least=0.0)
    for scaled in loose:
        ratio = spectrum(scaled.motion, periods).psa / TARGET.psa(periods)
        assert np.mean(np.log(ratio)) == pytest.approx(0.0, abs=1e-12)
    strict = scaled_to_spectrum(NOISE, TARGET, (0.1, 1.5), least=0.9)
    periods = np.geomspace(0.1, 1.5, 196)
    mean = np.mean([spectrum(scaled.motion, periods).psa for scaled in strict], axis=0) / TARGET.psa(periods)
    assert mean.min() == pytest.approx(0.9, rel=1e-12)
    assert strict[0].factor / loose[0].factor == pytest.approx(strict[1].factor / loose[1].factor, rel=1e-12)
    assert strict[0].factor > loose[0].factor
    # between the periods of the fit: 0.0047 was measured, 0.053 with 40 periods
    between = np.geomspace(0.1, 1.5, 4000)
    found = np.mean([spectrum(one.motion, between).psa for one in strict], axis=0) / TARGET.psa(between)
    assert found.min() > 0.9 - 6e-3


def test_components_are_scaled_apart() -> None:
    pairs = {name: motion.with_vertical(motion.scaled(0.1)) for name, motion in NOISE.items()}
    scaled = scaled_to_spectrum(pairs, TARGET, (0.1, 1.5))
    assert TARGET.vertical is not None
    periods = np.geomspace(0.05, 1.0, 40)
    mean = np.mean([spectrum(one.motion, periods, component="az").psa for one in scaled], axis=0)
    assert (mean / TARGET.vertical.psa(periods)).min() >= 0.9 * (1.0 - 1e-12)
    alone = scaled_to_spectrum(NOISE, TARGET, (0.1, 1.5))
    assert [one.factor for one in scaled] == pytest.approx([one.factor for one in alone], rel=1e-12)
    peaks = scaled_to_pga(pairs, 3.0, 1.0)
    assert [float(np.max(np.abs(one.motion.az))) for one in peaks] == pytest.approx([1.0] * 3, rel=1e-12)


def test_the_largest_of_few_counts_and_the_mean_of_many() -> None:
    assert statistic([1.0, 5.0, 3.0]) == 5.0
    assert statistic(np.arange(7.0)) == 3.0
    assert statistic([*range(6), np.inf]) == np.inf
    motions = tuple(NOISE.values())
    each = [spectrum(motion, [0.3, 0.6]).psa for motion in motions]
    np.testing.assert_array_equal(MotionSpectra(motions).psa([0.3, 0.6]), np.max(each, axis=0))
    assert MotionSpectra(motions).psa(0.0) == max(motion.pga for motion in motions)


def test_mistakes_are_refused() -> None:
    still = {"still": Motion.from_samples(0.01, np.zeros(100))}
    with pytest.raises(InputError, match="still: the motion is zero throughout and cannot be scaled"):
        scaled_to_pga(still, 1.0)
    with pytest.raises(InputError, match="periods = 2 1: must be the shorter first"):
        scaled_to_spectrum(NOISE, TARGET, (2.0, 1.0))


def test_a_mean_peak_below_that_of_the_spectrum_is_said() -> None:
    """Check that motions whose mean peak is below ag S are named as EN 1998-1, 3.2.3.1.2(4)b, asks."""
    scaled = scaled_to_spectrum(NOISE, TARGET, (0.1, 1.5), least=0.0)
    peak = float(np.mean([np.abs(one.motion.ax).max() for one in scaled]))
    for part in (0.9, 1.1):
        motions = tuple(one._replace(motion=one.motion.scaled(part * 2.0 * 1.2 / peak)) for one in scaled)
        said = [line for line in Action(motions, "", TARGET, (0.1, 1.5)).cautions() if "mean peak" in line]
        assert len(said) == (part < 1.0)
        assert all(line.startswith("The mean peak acceleration is 0.9 of the target's at period 0") for line in said)
