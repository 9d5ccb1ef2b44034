"""Modulus and damping that are asked for come out of the column that gets them."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.probe import PHOCAS_STIFFNESS, Array, monolith, phocas

from solver import Block, Column, InitialState, InputError, InputWarning, Joint, Motion, SolverError, simulate
from solver.commands.command_line import main
from solver.models.column.linearization import undamped
from solver.models.column.modes import natural_modes
from solver.models.column.push import BalanceCurve
from solver.statics.calibrate import (
    damping_from_ratio,
    damping_from_restitution,
    fit_moduli,
    free_vibration,
    modulus_from_elasticity,
    modulus_from_frequencies,
    read_history,
    sway_frequencies,
    with_joints,
)
from solver.statics.rocking import housner_restitution, pulled_equilibrium, restitution

COLUMNS = Path(__file__).resolve().parents[2] / "examples" / "columns"
ALPHA = math.atan2(1.56, 14.07)  # rad, of the diagonal of the monolith
STILL = Motion.harmonic(1e-12, 1.0, 6.0)  # a base that is as good as still


def turned_back(column: Column, start: InitialState) -> tuple[float, float]:
    """Return the rotations from which one block is let go, and at which it turns on the other side, rad."""
    run = simulate(column, STILL, initial=start, output_step=1e-3, settle=0.0)
    theta = run.ry[:, 0]
    beyond = int(np.argmax(theta < 0.0))
    later = np.flatnonzero(theta[beyond:] > 0.0)
    end = beyond + (int(later[0]) if later.size else len(theta))
    return float(theta[0]), float(-np.min(theta[beyond:end]))


def rigid_energy(turn: float) -> float:
    """Return the energy of Housner's block above its place upright, over its weight and half its diagonal."""
    return math.cos(ALPHA - turn) - math.cos(ALPHA)


LONG = pytest.mark.long  # takes seconds


@pytest.mark.parametrize("wanted", [pytest.param(0.99, marks=LONG), None, pytest.param(0.96, marks=LONG)])
def test_block_rocks_with_the_restitution_that_was_asked_for(wanted: float | None) -> None:
    column = monolith(tolerance=1e-7)
    column = with_joints(column, damping=damping_from_restitution(column, wanted))
    asked = housner_restitution(column) if wanted is None else wanted
    there, back = turned_back(column, pulled_equilibrium(column)[0])
    found = math.sqrt(rigid_energy(back) / rigid_energy(there))
    # of an elastic bed, whose energy is not that of a rigid block
    assert found == pytest.approx(asked, rel=2e-3)  # measured 8e-4
    assert 1.0 - found**2 == pytest.approx(1.0 - asked**2, rel=0.02)  # the loss; measured 1.9 %
    assert restitution(column) == pytest.approx(asked, abs=1e-6)  # measured 1e-9


@cache
def damping_as_housner() -> float:
    """Return the damping of Phocas that leaves it the restitution of Housner's block."""
    return damping_from_restitution(phocas())


def test_column_of_blocks_gets_its_restitution_too() -> None:
    column, eta = phocas(), damping_as_housner()
    assert restitution(with_joints(column, damping=eta)) == pytest.approx(housner_restitution(column), abs=1e-6)
    assert restitution(column) == pytest.approx(1.0, abs=1e-6)  # measured 7e-9: nothing is lost without damping


def test_housners_restitution_is_that_of_the_whole() -> None:
    assert housner_restitution(monolith()) == pytest.approx(1.0 - 1.5 * math.sin(ALPHA) ** 2, rel=1e-12)
    assert housner_restitution(monolith()) == pytest.approx(0.981784, abs=5e-7)  # theory.md, section 5, its alpha
    assert housner_restitution(phocas()) == pytest.approx(housner_restitution(monolith()), rel=1e-12)


@pytest.mark.parametrize(("wanted", "message"), [(0.5, "no damping reaches it"), (1.5, "between 0 and 1")])
def test_restitution_out_of_reach_is_refused(wanted: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        damping_from_restitution(monolith(), wanted)


@pytest.mark.parametrize("mode", [1, 2])
def test_damping_ratio_is_that_of_the_mode(mode: int) -> None:
    column = phocas()
    damped = natural_modes(with_joints(column, damping=damping_from_ratio(column, 0.02, mode)))
    assert damped.damping_ratio[damped.sways][mode - 1] == pytest.approx(0.02, rel=1e-9)


def decay(ratio: float) -> tuple[Array, Array]:
    """Free vibration of Phocas in its first mode with this ratio, in m."""
    column = phocas()
    column = with_joints(column, damping=damping_from_ratio(column, ratio))
    shape = natural_modes(column).ry[0]
    run = simulate(column, STILL, 3.0, initial=InitialState(rotation=1e-6 * shape))
    return run.time, run.ux[:, 0]


@pytest.mark.parametrize("ratio", [0.002, 0.02, 0.1])
def test_decay_gives_back_frequency_and_ratio(ratio: float) -> None:
    time, ux = decay(ratio)
    found = free_vibration(time, ux)
    assert found.ratio == pytest.approx(ratio, rel=1e-3)  # measured 4e-5 at most: modes are coupled by the dampers
    assert found.frequency == pytest.approx(3.05805407, rel=1e-4)
    noise = np.random.default_rng(1).normal(size=len(ux))
    noisy = free_vibration(time, 3.0 + ux / np.max(np.abs(ux)) + 0.05 * noise)
    assert noisy.ratio == pytest.approx(ratio, rel=0.05, abs=5e-4)  # measured 2.6e-4


def test_what_does_not_decay_is_refused() -> None:
    time = np.linspace(0.0, 3.0, 600)
    with pytest.raises(InputError, match="a decaying swing explains"):
        free_vibration(time, np.random.default_rng(1).normal(size=600))
    with pytest.raises(InputError, match="does not move"):
        free_vibration(time, np.ones(600))
    with pytest.raises(InputError, match="must increase"):
        free_vibration(time[::-1], time)


def test_modulus_comes_of_elasticity() -> None:
    column = phocas()
    assert modulus_from_elasticity(column, 4.69 * PHOCAS_STIFFNESS) == pytest.approx(PHOCAS_STIFFNESS)
    softer = modulus_from_elasticity(column, 70e9, 0.02, 2e9)
    assert softer == pytest.approx(1.0 / (4.69 / 70e9 + 0.02 / 2e9))
    with pytest.raises(InputError, match="joint_young: missing"):
        modulus_from_elasticity(column, 70e9, 0.02)
    with pytest.raises(InputError, match="joint_thickness: missing, must be the thickness in m of what has 2000000000"):
        modulus_from_elasticity(column, 70e9, joint_young=2e9)


@pytest.mark.parametrize("frequency", [0.3, 1.3, 10.0])
def test_modulus_comes_of_a_measured_frequency(frequency: float) -> None:
    column = phocas()
    moduli = modulus_from_frequencies(column, [frequency])
    assert sway_frequencies(with_joints(column, moduli))[0] == pytest.approx(frequency, rel=1e-8)
    assert np.all(moduli == moduli[0])


def test_modulus_of_several_frequencies_is_their_least_squares() -> None:
    column, factor = phocas(), 0.7
    true = sway_frequencies(with_joints(column, factor * PHOCAS_STIFFNESS))
    assert modulus_from_frequencies(column, list(true)) == pytest.approx(factor * PHOCAS_STIFFNESS, rel=1e-7)
    only_second = modulus_from_frequencies(column, [math.nan, float(true[1])])
    assert only_second == pytest.approx(factor * PHOCAS_STIFFNESS, rel=1e-7)
    wrong = true * np.array([1.02, 0.98, 1.0])

    def misfit(times: float) -> float:
        tried = sway_frequencies(with_joints(column, times * PHOCAS_STIFFNESS))
        return float(np.sum((tried / wrong - 1.0) ** 2))

    best = float(modulus_from_frequencies(column, list(wrong))[0]) / PHOCAS_STIFFNESS
    assert misfit(best) < min(misfit(0.999 * best), misfit(1.001 * best))


THREE = (1.0, 0.3, 3.0)  # moduli that no one factor comes near


def three_moduli() -> Array:
    return sway_frequencies(with_joints(phocas(), PHOCAS_STIFFNESS * np.array(THREE)))


@pytest.mark.long  # takes seconds
@pytest.mark.parametrize("factors", [THREE, (0.4, 1.9, 1.4), (3.0, 1.0, 0.3), (1.0, 1.0, 1.0)])
def test_as_many_frequencies_as_joints_give_each_its_modulus(factors: tuple[float, ...]) -> None:
    moduli = PHOCAS_STIFFNESS * np.array(factors)
    fit = fit_moduli(phocas(), list(sway_frequencies(with_joints(phocas(), moduli))))
    assert np.max(np.abs(fit.difference)) < 1e-9  # 2e-12 at most was seen
    sets = [fit.moduli] if fit.another is None else [fit.moduli, fit.another]
    assert min(np.max(np.abs(found / moduli - 1.0)) for found in sets) < 1e-6
    assert np.all(fit.determined)
    # errors of 1 % in each frequency, by the inverse of what frequencies change by
    columns = [with_joints(phocas(), fit.moduli * np.exp(1e-3 * unit)) for unit in (*np.eye(3), *-np.eye(3))]
    logs = np.log([sway_frequencies(column) for column in columns])
    errors = np.linalg.inv((logs[:3] - logs[3:]).T / 2e-3)
    assert fit.spread == pytest.approx(0.01 * np.sqrt(np.sum(errors**2, axis=1)), rel=1e-4)


def test_frequencies_that_the_fit_misses_are_warned_of(capsys: pytest.CaptureFixture[str]) -> None:
    frequencies = sway_frequencies(with_joints(phocas(), PHOCAS_STIFFNESS * np.array((0.3, 1.0, 3.0))))[:2]
    with pytest.warns(InputWarning, match=r"^frequency 1: .* Hz measured, .* Hz of the fit, [+-]\d+\.\d%: one factor"):
        modulus_from_frequencies(phocas(), list(frequencies))
    words = [f"{frequency:.9g}" for frequency in frequencies]
    assert main(["calibrate", str(COLUMNS / "phocas-damped.toml"), "--frequencies", *words]) == 0
    out, error = capsys.readouterr()
    assert "warning: frequency 1: " in error
    assert "3 frequencies give each joint its own" in error
    row = next(line for line in out.splitlines() if line.startswith("   1 "))
    assert abs(float(row.split()[3].rstrip("%"))) > 5.0


@pytest.mark.long  # takes seconds
def test_a_modulus_that_frequencies_do_not_determine_is_said() -> None:
    with pytest.warns(InputWarning) as caught:  # two that are as close as no column has them
        fit = fit_moduli(phocas(), [3.0, 30.0, 31.0])
    said = [str(warning.message) for warning in caught]
    assert not np.any(fit.determined)
    assert "joint 2: its modulus is not determined, 1 % in the frequencies is more than 100 % in it" in said
    assert any(line.startswith("frequency 2: 30 Hz measured") and "no moduli near" in line for line in said)


@pytest.mark.long  # takes 10 s and more
def test_a_mode_that_was_not_measured_has_no_difference(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate", str(COLUMNS / "phocas-damped.toml"), "--frequencies", "nan", "19.9"]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines() if line[:5].strip().isdigit()]
    assert [row[0] for row in rows] == ["1", "2"]
    assert rows[0][1::2] == ["-", "-"]
    assert rows[1][1:] == ["19.9", "19.9", "+0.00", "%"]


def test_command_gives_each_joint_its_modulus(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = [f"{frequency:.12g}" for frequency in three_moduli()]
    column = str(COLUMNS / "phocas-damped.toml")
    assert main(["calibrate", column, "--frequencies", *words]) == 0
    out, error = capsys.readouterr()
    assert error == ""
    assert out.count("[block.joint]") == 3
    assert "standard error of each modulus, the top joint first, for 1 % in every frequency: 0.0" in out
    assert main(["calibrate", column, "--frequencies", *words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    stiffness = [joint["stiffness"] / PHOCAS_STIFFNESS for joint in found["joints"]]
    assert stiffness == pytest.approx(THREE, rel=1e-6)
    assert found["frequencies"]["fitted"] == pytest.approx(found["frequencies"]["measured"], rel=1e-9)


def test_a_column_too_soft_to_rock_has_no_restitution(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Check a block on a bed of 1e6 Pa, whose largest push is beyond half the way: an error named the default."""
    (tmp_path / "soft.toml").write_text(
        'name = "soft"\n[joint]\nstiffness = 1e7\ndamping = 1e-3\n'
        "[[block]]\nheight = 1.0\nwidth = 0.4\ndepth = 0.4\ndensity = 2500.0\n"
    )
    words = ["calibrate", str(tmp_path / "soft.toml"), "--young", "1e6"]
    assert main(words) == 0
    assert "restitution not found: release = 0.5: must be more than 0.71, beyond the" in capsys.readouterr().out
    assert main([*words, "--release", "0.4"]) == 2
    assert "release = 0.4: must be more than 0.71" in capsys.readouterr().err


def test_a_block_that_touches_at_its_edges_loses_what_housners_block_loses() -> None:
    """Check two edge strips, where the curve of balance has a corner: one strip opens, and the block turns on the
    other.

    The largest push turns the block about the middle of a strip, which bears all. Measured: 0.9116 beside Housner's
    0.9028, of the whole face 0.958.
    """
    strips = (0.5, *[0.0] * 30, 0.5)
    edges = Joint(stiffness=2e10, damping=1e-3, section="strips", strips=strips)
    column = Column("edges", (Block(height=1.9, width=0.5, depth=0.5, mass=1140.0, joint=edges),))
    places = BalanceCurve(undamped(column)).follow()
    push = max(place.push for place in places)
    assert push == pytest.approx(column.g * 0.5 * (31.0 / 32.0) / 1.9, rel=1e-3)
    assert places[-1].push == 0.0 or abs(places[-1].push) < 1e-6
    assert restitution(column) == pytest.approx(housner_restitution(column), rel=0.015)
    whole = column.with_joints([2e10], [1e-3])
    face = replace(whole, blocks=(replace(whole.blocks[0], joint=Joint(stiffness=2e10, damping=1e-3)),))
    assert restitution(face) > 1.05 * housner_restitution(face)


@pytest.mark.long  # takes seconds
def test_restitution_that_is_not_monotone_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.warns(InputWarning, match=r"damping from .* has it as well, the least is taken; it is not monotone: "):
        damping = damping_from_restitution(phocas(), 0.945)
    assert restitution(with_joints(phocas(), damping=damping)) == pytest.approx(0.945, abs=1e-6)
    with pytest.raises(InputError, match="softer joints lose more") as refused:
        damping_from_restitution(phocas(), 0.93)
    low, high = (float(value) for value in re.findall(r"([\d.]+) at eta", str(refused.value))[1:])
    assert 0.93 < low < high  # falls, and rises again
    assert "--damping-ratio" in str(refused.value)
    assert main(["calibrate", str(COLUMNS / "phocas-damped.toml"), "--restitution", "0.93"]) == 0
    found = capsys.readouterr().out
    assert found.startswith("damping alone does not have it: no damping reaches it up to the critical one")
    assert "rim = " in found
    assert "restitution 0.93000" in found


@pytest.mark.long  # takes seconds
def test_what_many_blocks_lose_by_themselves_is_said() -> None:
    column = with_joints(Column.from_toml(COLUMNS / "doric.toml"), damping=0.0)
    with pytest.raises(
        InputError, match=r"must be less than 0\.98\d*, which joints leave without damping .* 12 blocks"
    ):
        damping_from_restitution(column, 0.995)


def test_frequencies_that_no_column_has_are_refused() -> None:
    with pytest.raises(InputError, match="positive frequencies"):
        modulus_from_frequencies(phocas(), [-1.0])
    with pytest.raises(InputError, match="up to 3"):
        modulus_from_frequencies(phocas(), [1.0] * 4)
    with pytest.raises((InputError, SolverError)):
        modulus_from_frequencies(phocas(), [])


def test_command_prints_what_to_write_and_what_it_means(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    column = str(COLUMNS / "phocas-damped.toml")
    assert main(["calibrate", column, "--restitution", "housner"]) == 0
    text = capsys.readouterr().out
    damping = float(next(line for line in text.splitlines() if line.startswith("damping")).split()[2])
    assert damping == pytest.approx(damping_as_housner(), rel=1e-5)
    assert "restitution 0.98178" in text
    time, ux = decay(0.02)
    rows = "\n".join(f"{t:.9g},0,{u:.17g}" for t, u in zip(time, ux, strict=True))
    (tmp_path / "decay.csv").write_text(f"time,other,top\n{rows}\n", encoding="utf-8")
    decayed = ["--free-vibration", str(tmp_path / "decay.csv"), "--channel", "top", "--begin", "0.5"]
    assert main(["calibrate", column, "--young", "24.5e9", *decayed]) == 0
    text = capsys.readouterr().out
    assert "3.0581 Hz, damping 2.000 %; a decaying swing explains 100 %" in text
    assert "damping 2.000 %, all joints closed" in text
    assert read_history(tmp_path / "decay.csv", "top")[1] == pytest.approx(ux)


@pytest.mark.parametrize("origin", [0, 40_000, 1_700_000_000])
def test_a_part_of_a_record_is_chosen_by_its_own_times(
    origin: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Check a decay before which and after which the record shows something else, at 1 kHz."""
    time = np.arange(0.0, 9.0, 0.001)
    swing = 2.0 * np.pi * 3.0 * np.clip(time - 1.0, 0.0, None)
    top = np.where(time < 1.0, 0.4, np.where(time < 6.0, np.exp(-0.02 * swing) * np.cos(swing), np.cos(0.3 * swing)))
    rows = "\n".join(f"{origin + k // 1000}.{k % 1000:03d},{value:.9g}" for k, value in enumerate(top))
    (tmp_path / "decay.csv").write_text(f"time,top\n{rows}\n", encoding="utf-8")
    part = ["--begin", f"{origin + 1.0}", "--end", f"{origin + 5.9}"]
    column = str(COLUMNS / "phocas-damped.toml")
    assert main(["calibrate", column, "--free-vibration", str(tmp_path / "decay.csv"), *part]) == 0
    assert "3.0006 Hz, damping 2.000 %; a decaying swing explains 100 %" in capsys.readouterr().out


def test_a_fit_at_the_bound_of_the_damping_is_refused() -> None:
    """Check a decay without a swing, as of critical damping."""
    time = np.linspace(0.0, 0.6, 60)
    with pytest.raises(InputError, match=r"no swing that decays fits, .* a damping ratio of 0\.95, is at"):
        free_vibration(time, np.exp(-9.0 * time) * (1.0 + 5.0 * time))
    drift = np.linspace(0.0, 10.0, 500)
    with pytest.raises(InputError, match=r"no swing that decays fits, .* is at the bounds of the search"):
        free_vibration(drift, drift**2)  # 99.997 % of a parabola by 0.3 times the frequency of its spectrum


def test_command_gives_what_it_found_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    column, kept = str(COLUMNS / "phocas-damped.toml"), tmp_path / "found.json"
    assert main(["calibrate", column, "--damping-ratio", "0.02", "--json", "-o", str(kept)]) == 0
    text = capsys.readouterr().out
    assert text == kept.read_text(encoding="utf-8")
    found = json.loads(text)
    assert found["damping_ratio"] == pytest.approx(0.02, rel=1e-9)
    calibrated = damping_from_ratio(Column.from_toml(column), 0.02)
    assert [joint["damping"] for joint in found["joints"]] == pytest.approx([calibrated] * 3, rel=1e-12)
    assert found["restitution"] == pytest.approx(found["housner_restitution"], abs=0.1)
    assert found["free_vibration"] is None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--restitution", "much"], "--restitution much: must be housner, or a number between 0 and 1"),
        (["--joint-young", "1e9"], "--joint-young: must be left out, or --young given"),
        (["--channel", "x"], "--channel: must be left out, or --free-vibration given"),
        (["--free-vibration", "none.csv"], "none.csv: No such file"),
        (["--young", "-1"], "young = -1"),
        (["--rim", "wide"], "--rim wide: must be auto, or a width in m"),
        (["--rim", "auto"], "--rim auto: must be a width in m, or --restitution given"),
        (["--rim", "-1"], "--rim = -1.0: must be a width in m"),
        (["-o", "found.txt"], "found.txt: must end in .json"),
    ],
)
def test_command_says_what_is_wrong(
    options: list[str],
    message: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["calibrate", str(COLUMNS / "phocas-damped.toml"), *options]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_times_in_another_unit_are_refused(tmp_path: Path) -> None:
    (tmp_path / "decay.csv").write_text("time (ms),top\n0,1\n1,2\n")
    with pytest.raises(InputError, match=r"decay.csv: line 1: 'time \(ms\)': must be times in s"):
        read_history(tmp_path / "decay.csv")
