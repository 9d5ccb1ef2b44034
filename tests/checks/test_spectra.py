"""Spectra of codes against values worked out by hand, and artificial motions against the spectrum they follow."""

import math
from pathlib import Path

import numpy as np
import pytest

from multiblock import InputError, artificial_motions, intensity, spectra, spectrum
from solver.checks.scaling import Fit, raised_to_spectrum
from solver.checks.spectra import CornerSpectrum, TableSpectrum, TargetSpectrum, damping_factor

G = 9.80665


@pytest.mark.parametrize(
    ("kind", "soil", "corners"),
    [
        (1, "B", (1.2, 0.15, 0.5, 2.0)),
        (1, "D", (1.35, 0.2, 0.8, 2.0)),
        (2, "A", (1.0, 0.05, 0.25, 1.2)),
        (2, "E", (1.6, 0.05, 0.25, 1.2)),
    ],
)
def test_eurocode_8_has_the_values_of_its_formulas(kind: int, soil: str, corners: tuple[float, ...]) -> None:
    factor, tb, tc, td = corners
    found = spectra.eurocode8(2.0, soil, kind)
    at = [0.0, 0.5 * tb, tb, tc, 0.5 * (tc + td), td, 3.5]
    plateau = 5.0 * factor
    expected = [
        2.0 * factor,
        0.5 * (2.0 * factor + plateau),
        plateau,
        plateau,
        plateau * tc / (0.5 * (tc + td)),
        plateau * tc / td,
        plateau * tc * td / 3.5**2,
    ]
    np.testing.assert_allclose(found.psa(at), expected, rtol=1e-14)  # measured: 2e-16


def test_vertical_spectrum_of_eurocode_8() -> None:
    for kind, part in ((1, 0.9), (2, 0.45)):
        vertical = spectra.eurocode8(2.0, "C", kind).vertical
        assert vertical is not None
        # no soil factor, plateau of 3 from 0.05 to 0.15 s
        np.testing.assert_allclose(vertical.psa([0.0, 0.1, 0.3]), 2.0 * part * np.array([1.0, 3.0, 1.5]), rtol=1e-14)


def test_damping_acts_by_the_factor_of_the_codes() -> None:
    found = spectra.eurocode8(1.0, "A")
    assert damping_factor(0.05) == 1.0
    assert found.psa(0.3, 0.08) == pytest.approx(2.5 * math.sqrt(10.0 / 13.0), rel=1e-14)
    assert found.psa(0.3, 0.5) == pytest.approx(2.5 * 0.55, rel=1e-14)  # the least
    assert found.psa(0.0, 0.2) == 1.0  # the ground itself


def test_ntc_2018_soil_and_corners() -> None:
    # by hand: SS = 1.7 - 0.6 * 2.4 * 0.2 = 1.412; TC = 1.05 * 0.3^-0.33 * 0.3; TB = TC / 3; TD = 4 * 0.2 + 1.6
    found = spectra.ntc2018(0.2 * G, 2.4, 0.3, "C", "T2").horizontal
    assert isinstance(found, CornerSpectrum)
    tc = 0.315 * 0.3**-0.33
    np.testing.assert_allclose(
        [found.pga, found.amplification, found.tb, found.tc, found.td],
        [1.2 * 1.412 * 0.2 * G, 2.4, tc / 3.0, tc, 2.4],
        rtol=1e-14,
    )
    strong = spectra.ntc2018(0.45 * G, 2.5, 0.4, "D")
    assert strong.psa(0.0) == pytest.approx(0.9 * 0.45 * G)  # SS = 2.4 - 1.5 * 1.125 is below its least, 0.9
    assert strong.vertical is not None
    assert strong.vertical.psa(0.1) == pytest.approx(1.35 * 2.5 * 0.45**1.5 * G)  # ag Fv


def test_table_is_interpolated_in_logarithms(tmp_path: Path) -> None:
    path = tmp_path / "site.csv"
    path.write_text("period,g\n0.1,1\n1,0.1\n2,0.05\n", encoding="utf-8")
    found = spectra.spectrum_from_csv(path)
    np.testing.assert_allclose(found.psa([0.01, 0.1, 0.5, 2.0, 4.0]), [G, G, 0.2 * G, 0.05 * G, 0.0125 * G], rtol=1e-12)


def test_a_table_may_begin_at_period_0_with_the_pga(tmp_path: Path) -> None:
    """Check that up to the first period it is linear, as EN 1998-1 (3.2) is up to TB; beyond it is the table without
    that row.
    """
    path = tmp_path / "site.csv"
    path.write_text("period;g\n0;0.2\n0.15;0.5\n0.6;0.5\n2;0.15\n", encoding="utf-8")
    found, code = spectra.spectrum_from_csv(path), CornerSpectrum(0.2 * G, 2.5, 0.15, 0.6, 2.0)
    periods = np.linspace(0.0, 0.6, 61)
    np.testing.assert_allclose(found.psa(periods), code.psa(periods), rtol=1e-12)
    assert found.psa(0.0, 0.2) == pytest.approx(0.2 * G)
    path.write_text("period;g\n0.15;0.5\n0.6;0.5\n2;0.15\n", encoding="utf-8")
    np.testing.assert_array_equal(found.psa([0.15, 0.3, 2.5]), spectra.spectrum_from_csv(path).psa([0.15, 0.3, 2.5]))


def test_a_table_that_is_left_is_named_with_both_periods() -> None:
    """Check that 1/T^2 beyond the table halves what EN 1998-1 has between TC and TD = 2 s."""
    table = TargetSpectrum("site.csv", TableSpectrum(np.array([0.1, 1.0]), G * np.array([0.5, 0.25])))
    below, beyond = table.outside(0.0, 2.0)
    assert below.startswith("the table begins at 0.1 s and is read from 0 s: its first value, 0.5 g, is kept")
    assert beyond.startswith("the table ends at 1 s and is read to 2 s, where 1/T^2 makes it 0.0625 g")
    assert table.outside(0.1, 1.0) == []
    whole = TargetSpectrum("", TableSpectrum(np.array([0.1, 1.0]), G * np.array([0.5, 0.25]), 0.2 * G))
    assert whole.outside(0.0, 1.0) == []
    assert spectra.eurocode8(1.0, "A").outside(0.0, 100.0) == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("T,g\n1,1\n", r"line 1: must be period,g or period,m/s2"),
        ("period,g\n1,1\n0.5,1\n", r"line 3: period 0.5 s, must be above the one before, 1 s"),
        ("period,g\n1,-1\n", r"line 2: '1,-1', must be a period, 0 or more, and a positive value"),
        ("period,g\n1,x\n", r"line 2: 'x': must be a finite number"),
        ("period,g\n1,1\n", r"must have at least two periods"),
        ("period,g\n0,0.2\n1,1\n", r"must have at least two periods above 0"),
        ("period;g\n0;0,2\n1;1\n", r"line 2: 0,2 has a decimal comma, must be 0.2"),
    ],
)
def test_wrong_tables_are_refused_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "site.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message) as found:
        spectra.spectrum_from_csv(path)
    assert str(found.value).startswith(str(path))


def test_wrong_parameters_are_refused() -> None:
    with pytest.raises(InputError, match="soil = 'F': must be one of A, B, C, D, E"):
        spectra.eurocode8(1.0, "F")
    with pytest.raises(InputError, match=r"soil = 'b': must be one of A, B, C, D, E; did you mean B\?"):
        spectra.eurocode8(1.0, "b")
    with pytest.raises(InputError, match="type = 3: must be 1 or 2"):
        spectra.eurocode8(1.0, "A", 3)
    with pytest.raises(InputError, match=r"topography = 'T9': must be one of T1, T2"):
        spectra.ntc2018(1.0, 2.5, 0.3, "A", "T9")


def test_artificial_motions_follow_the_spectrum() -> None:
    """Compare with the exact oscillators of `spectrum`.

    Measured, seeds 0 to 2: 0.87 to 1.13 of the target, mean 0.99.
    """
    target = spectra.eurocode8(0.25 * G, "B")
    periods = np.geomspace(0.05, 4.0, 60)
    motions = artificial_motions(target, 3)
    ratios = np.array([spectrum(motion, periods).psa for motion in motions.values()]) / target.psa(periods)
    assert ratios.min() > 0.85
    assert ratios.max() < 1.2
    assert abs(np.mean(ratios) - 1.0) < 0.02
    assert np.mean(ratios, axis=0).min() > 0.9  # EN 1998-1, 3.2.3.1.2(4)
    for motion in motions.values():
        found = intensity(motion)
        assert abs(found.final_velocity) < 1e-2 * found.pgv
        assert abs(found.final_displacement) < 1e-3 * found.pgd
        assert found.significant_duration > 10.0
    again = artificial_motions(target, 1, seed=1)
    assert again["artificial 1"].ax.tobytes() == motions["artificial 1"].ax.tobytes()


def rough(low: float) -> TargetSpectrum:
    """Return a spectrum that falls to a part of itself at 0.3 s, within a percent of the period."""
    table = TableSpectrum(np.array([0.02, 0.3, 0.303, 4.0]), G * np.array([0.5, 0.5, 0.5 * low, 0.5 * low]))
    return TargetSpectrum("rough", table)


def test_artificial_motions_keep_the_least_part_of_the_target() -> None:
    """Check the one factor, as of records, which spectra of codes hardly need; else they are refused."""
    span, rugged = (0.04, 2.0), rough(0.05)
    target = spectra.ntc2018(2.0, 2.4, 0.1, "A")
    (raised,) = raised_to_spectrum(artificial_motions(target, 1, 2), target, span)
    assert 1.0 < raised.factor < 1.12  # measured: 1.07
    assert np.min(Fit({"": raised.motion}, target, span).mean()) == pytest.approx(0.9, rel=1e-12)
    made = artificial_motions(spectra.eurocode8(2.0, "B"), 1, 4)
    (kept,) = raised_to_spectrum(made, spectra.eurocode8(2.0, "B"), (0.06, 1.5))
    assert kept.factor == 1.0
    np.testing.assert_array_equal(kept.motion.ax, made[kept.name].ax)
    with pytest.raises(InputError, match=r"rough: artificial motions reach 0\.\d+ of it at 0\.\d+ s, must be 0\.9:"):
        raised_to_spectrum(artificial_motions(rugged, 1, 0), rugged, span)


def test_tables_beyond_ten_g_are_refused_and_a_byte_order_mark_is_not(tmp_path: Path) -> None:
    path = tmp_path / "site.csv"
    for text in ("period,g\n0.1,0.5\n1,1e308\n", "period,m/s2\n0.1,0.5\n1,98.1\n"):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match=r"line 3: .* must be at most 10 g"):
            spectra.spectrum_from_csv(path)
    path.write_text("period,g\n0.1,0.5\n1,0.2\n", encoding="utf-8-sig")
    assert spectra.spectrum_from_csv(path).psa(0.1) == pytest.approx(0.5 * G)
