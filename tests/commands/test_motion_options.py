"""The base motion on the command line: what is read, paired, scaled or made by formula, and what is refused."""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path

import numpy as np
import pytest
from support.columns import BLOCK
from support.record_files import DT, SAMPLES, G, at2, cosmos_v2, knet, plain

from multiblock import Building, InputWarning, Motion, floor_motion
from solver.commands.check import add_action, level_of, motions_of
from solver.commands.command_line import main
from solver.ground import wavelets
from solver.ground.intensity import intensity, spectrum


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a column and records of several kinds, in the working directory."""
    (tmp_path / "column.toml").write_text(BLOCK)
    (tmp_path / "motion.csv").write_text("time,base.ax\n0,1\n1,0\n")
    (tmp_path / "record.AT2").write_text(at2(), encoding="utf-8")
    (tmp_path / "vertical.knet").write_text(knet("U-D"))
    (tmp_path / "station.v2").write_text(cosmos_v2(3))
    (tmp_path / "plain.txt").write_text(plain())
    (tmp_path / "both.csv").write_text("time,base.ax,base.az\n0,1,1\n1,0,1\n")
    (tmp_path / "zero.csv").write_text("time,base.ax\n0,0\n1,0\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def converted(line: str) -> Motion:
    """Return the motion that `convert` writes."""
    assert main(["convert", *line.split(), "out.csv", "--force"]) == 0
    return Motion.from_csv("out.csv")


def test_a_pair_in_one_run(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    motion = converted("record.AT2 --vertical vertical.knet")
    np.testing.assert_array_equal(motion.ax, Motion.from_file("record.AT2").ax)
    np.testing.assert_array_equal(motion.az, Motion.from_file("vertical.knet").ax)
    first, second, _ = capsys.readouterr().out.splitlines()
    assert first == "record.AT2: PEER AT2, 200 samples, 1.99 s; TESTVILLE 01/01/00, D\u00fczce, 090"
    assert second.startswith(
        "vertical vertical.knet: K-NET ASCII, 200 samples, 1.99 s; 2006/01/18 23:25:00 TST002 U-D; mean of"
    )


def test_a_pair_out_of_one_file(folder: Path) -> None:
    motion = converted("station.v2 --channel 1 --vertical station.v2 --vertical-channel 2 --scale 2")
    np.testing.assert_allclose(motion.ax, 2.0 * SAMPLES, atol=2e-7)
    np.testing.assert_array_equal(motion.az, -motion.ax)


def test_three_components_out_of_one_file(folder: Path) -> None:
    motion = converted(
        "station.v2 --channel 2 --across station.v2 --across-channel 1 --vertical station.v2 --vertical-channel 3"
    )
    np.testing.assert_allclose(motion.ay, SAMPLES, atol=1e-7)
    np.testing.assert_array_equal(motion.ax, -motion.ay)
    np.testing.assert_array_equal(motion.az, motion.ay)
    parser = argparse.ArgumentParser()
    add_action(parser)
    words = "station.v2 --channel 2 --across station.v2 --across-channel 1 --vertical station.v2 --vertical-channel 3"
    (found,) = motions_of(parser.parse_args(words.split())).values()
    for key in ("time", "ax", "ay", "az"):
        np.testing.assert_array_equal(getattr(found, key), getattr(motion, key))


def test_units_go_to_the_plain_file_of_a_pair(folder: Path) -> None:
    motion = converted(f"record.AT2 --vertical plain.txt --units g --dt {DT}")
    np.testing.assert_allclose(motion.az, SAMPLES, atol=1e-8)
    np.testing.assert_allclose(motion.ax, SAMPLES, atol=1e-6)


def test_a_channel_is_that_of_files_with_several(folder: Path) -> None:
    """Check both commands: a format without channels refused --channel, and only one of them used it for --vertical."""
    parser = argparse.ArgumentParser()
    add_action(parser)
    (folder / "other.v2").write_text(cosmos_v2(3))
    (folder / "single.v2").write_text(cosmos_v2(1))
    for key, component in (("across", "ay"), ("vertical", "az")):
        for file, channel in (("record.AT2", None), ("other.v2", 2), ("single.v2", None)):
            line = f"station.v2 --channel 2 --{key} {file}"
            (found,) = motions_of(parser.parse_args(line.split())).values()
            wanted = Motion.from_file(file, channel=channel).ax
            for motion in (found, converted(line)):
                np.testing.assert_allclose(getattr(motion, component), wanted, atol=1e-12)
    assert main(["convert", "station.v2", "--channel", "1", "--vertical", "station.v2", "again.csv"]) == 2


def test_pga_scales_both_components(folder: Path) -> None:
    plain, motion = converted("both.csv"), converted("both.csv --pga 0.25")
    assert motion.pga == pytest.approx(0.25 * G, rel=1e-15)
    np.testing.assert_allclose(motion.az / motion.ax[0], plain.az / plain.ax[0], rtol=1e-15)


def test_convert_says_what_pga_scales_and_what_results(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "y.csv").write_text("time,base.ax\n0,2\n1,0\n")
    motion = converted("motion.csv --across y.csv --pga 0.25")
    assert np.max(np.abs(motion.ay)) == 2.0 * motion.pga == pytest.approx(0.5 * G, rel=1e-15)
    assert "largest acceleration 0.25 g along x, 0.5 g along y\n" in capsys.readouterr().out
    converted("both.csv --pga 0.25")
    assert "largest acceleration 0.25 g along x, 0.25 g along z\n" in capsys.readouterr().out
    converted("motion.csv --pga 0.25")
    assert capsys.readouterr().out.endswith("largest acceleration 0.25 g\n")


def test_paths_may_stand_behind_options(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for line in ("--pga .1 record.AT2 out.csv", "record.AT2 --pga .1 out.csv", "record.AT2 out.csv --pga .1"):
        assert main(["convert", *line.split()]) == 0
        assert Motion.from_csv("out.csv").pga == pytest.approx(0.1 * G, rel=1e-15)
        Path("out.csv").unlink()
    for line in ("column.toml --duration .1 record.AT2", "--duration .1 column.toml record.AT2"):
        assert main(["simulate", *line.split()]) == 0
        assert "record.AT2: PEER AT2" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("line", "motion"),
    [
        ("ricker --frequency 2", wavelets.ricker(1.0, 2.0)),
        ("one-sine --frequency 2", wavelets.one_sine(1.0, 2.0)),
        ("one-cosine --frequency 2", wavelets.one_cosine(1.0, 2.0)),
        ("mavroeidis-papageorgiou --frequency .5 --cycles 2", wavelets.mavroeidis_papageorgiou(1.0, 0.5, 2.0)),
        (
            "mavroeidis-papageorgiou --frequency .5 --cycles 2 --phase 90",
            wavelets.mavroeidis_papageorgiou(1.0, 0.5, 2.0, np.pi / 2.0),
        ),
        ("noise --frequency 2.5 --length 10 --seed 3", wavelets.filtered_noise(1.0, 2.5, 10.0, 3)),
    ],
)
def test_wavelets_by_name(folder: Path, line: str, motion: Motion) -> None:
    made = converted(f"--wavelet {line} --pga 0.3")
    assert made.pga == pytest.approx(0.3 * G, rel=1e-15)
    np.testing.assert_array_equal(made.ax, motion.scaled_to(0.3 * G).ax)
    np.testing.assert_array_equal(made.time, motion.time)


def test_accelerations_of_the_ground_in_m_per_s2_are_noticed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Check that 2.94 and 2.45 m/s2, 0.3 and 0.25 g, are named as such, and that 1.5 g is not."""
    for pga, said in (("2.94", "--pga = 2.94: is in g, should be 1.5 at most; 2.94 m/s2 is 0.3 g\n"), ("1.5", "")):
        motion = converted(f"--wavelet ricker --frequency 2 --pga {pga}")
        assert motion.pga == pytest.approx(float(pga) * G, rel=1e-12)
        printed = capsys.readouterr().err
        assert said in printed
        assert ("is in g" in printed) == bool(said)
    parser = argparse.ArgumentParser()
    add_action(parser)
    for words, said in (
        ("--spectrum ec8 --ag 2.45 --soil B", "--ag = 2.45: is in g, should be 1.5 at most; 2.45 m/s2 is 0.25 g"),
        ("--pga 2.94", "--pga = 2.94: is in g, should be 1.5 at most; 2.94 m/s2 is 0.3 g"),
        ("--pga 0.3 --vertical-pga 1.96", "--vertical-pga = 1.96: is in g, should be 1.5 at most; 1.96 m/s2 is 0.2 g"),
        ("--sa 6.86", "--sa = 6.86: is in g, should be 4.5 at most; 6.86 m/s2 is 0.7 g"),
    ):
        with pytest.warns(InputWarning) as caught:
            level_of(parser.parse_args(["motion.csv", *words.split()]))
        assert [str(one.message) for one in caught] == [said]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        level_of(parser.parse_args(["motion.csv", *["--spectrum", "ec8", "--ag", "0.25", "--soil", "B"]]))


def test_simulate_says_what_the_file_was_taken_for(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(f"simulate column.toml plain.txt --units g --dt {DT} --duration 0.1".split()) == 0
    assert capsys.readouterr().out.startswith("plain.txt: plain columns, 200 samples, 1.99 s\nblock: 1 block, ")
    assert main(["simulate", "column.toml", "--wavelet", "one-sine", "--frequency", "5", "--pga", "0.1"]) == 0
    assert "not overturned" in capsys.readouterr().out


def test_record_prints_the_measures(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["record", "record.AT2", "both.csv", "--plot", "records.png"]) == 0
    out = capsys.readouterr().out
    motion = Motion.from_file("record.AT2")
    found = intensity(motion)
    assert f"PGA {motion.pga / G:.4g} g ({motion.pga:.4g} m/s2)" in out
    assert f"PGV {found.pgv:.4g} m/s, PGD {found.pgd:.4g} m: integrated from rest, no baseline taken away" in out
    assert f"Arias intensity {found.arias:.4g} m/s" in out
    assert f"significant duration 5-95 % {found.significant_duration:.4g} s" in out
    assert f"{spectrum(motion, [0.5]).psa[0] / G:8.4f}" in out
    assert "  vertical PGA 0.102 g (1 m/s2)" in out
    assert out.splitlines()[-1] == "records.png"
    assert (folder / "records.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("simulate column.toml .", ".: Is a directory"),
        ("simulate column.toml plain.txt", "plain.txt: no known header (COSMOS or CSMIP V1/V2, CSV, ESM ASCII, "),
        ("simulate column.toml plain.txt --units g", "plain.txt: line 2: 1 values, must be time, ax and perhaps az"),
        ("simulate column.toml plain.txt --units g --dt 0", "plain.txt: dt = 0"),
        (
            "simulate column.toml motion.csv --units g",
            "--units: must be left out, motion.csv is CSV and says all itself",
        ),
        ("simulate column.toml motion.csv --channel 1", "motion.csv: channel = 1: must be left out, the file is CSV"),
        ("simulate column.toml motion.csv --vertical-channel 1", "--vertical-channel 1: is for --vertical"),
        ("simulate column.toml motion.csv --across-channel 1", "--across-channel 1: is for --across"),
        (
            "simulate column.toml station.v2 --channel 2 --across ./station.v2",
            "--across: is channel 2 of station.v2, as station.v2, must be another one: --across-channel",
        ),
        (
            "simulate column.toml station.v2 --channel 2 --vertical station.v2 --vertical-channel 2",
            "--vertical: is channel 2 of station.v2, as station.v2, must be another one: --vertical-channel",
        ),
        ("check column.toml station.v2 --vertical-channel 1", "--vertical-channel 1: is for --vertical"),
        (
            "check column.toml station.v2 --channel 1 --vertical station.v2",
            "--vertical: is channel 1 of station.v2, as station.v2, must be another one: --vertical-channel",
        ),
        (
            "check column.toml station.v2 --channel 1 --across station.v2",
            "--across: is channel 1 of station.v2, as station.v2, must be another one: --across-channel",
        ),
        ("simulate column.toml motion.csv --vertical none.AT2", "none.AT2: No such file"),
        ("simulate column.toml both.csv --vertical record.AT2", "horizontal motion: has az beside ax"),
        ("simulate column.toml motion.csv --pga -1", "--pga = -1.0: must be a positive number in g"),
        ("simulate column.toml motion.csv --pga 1 --scale 1", "argument --scale: not allowed with argument --pga"),
        ("simulate column.toml motion.csv --frequency 1", "--frequency 1.0: is for --wavelet"),
        ("simulate column.toml motion.csv --wavelet ricker", "motion.csv: must be left out, or --wavelet"),
        (
            "simulate column.toml --wavelet boxcar --pga 1",
            "--wavelet boxcar: must be ricker, one-sine, one-cosine, mavr",
        ),
        ("simulate column.toml --wavelet ricker --frequency 1", "--pga: must be given with --wavelet"),
        ("simulate column.toml --wavelet ricker --pga 1", "--frequency: must be given with --wavelet ricker"),
        (
            "simulate column.toml --wavelet ricker --pga 1 --frequency -1",
            "frequency = -1.0: must be a positive frequency",
        ),
        (
            "simulate column.toml --wavelet ricker --pga 1 --frequency 1 --seed 3",
            "--seed 3: is not for --wavelet ricker",
        ),
        ("simulate column.toml --wavelet ricker --pga 1 --frequency 1 --units g", "--units g: is for records, not for"),
        (
            "simulate column.toml --wavelet noise --pga 1 --frequency 1 --length 9",
            "--seed: must be given with --wavelet",
        ),
        (
            "simulate column.toml --wavelet noise --pga 1 --frequency 1 --length 9 --seed -1",
            "seed = -1: must be a whole",
        ),
        ("simulate column.toml record.AT2 more.AT2", "unrecognized arguments: more.AT2"),
        ("simulate column.toml record.AT2 --settle -1", "settle = -1.0: must be a time in s, zero or positive"),
        ("simulate column.toml record.AT2 --ensemble -1", "ensemble = -1: must be a number of runs from 0 to 100000"),
        ("record", "required: FILE"),
        ("record none.AT2", "none.AT2: No such file"),
        ("record record.AT2 --units g", "--units: must be left out, record.AT2 is PEER AT2 and says all itself"),
        ("record record.AT2 --plot record.txt", "record.txt: must end in .png"),
        ("record zero.csv", "zero.csv: the motion is zero throughout"),
    ],
)
def test_mistakes_end_in_one_line(folder: Path, capsys: pytest.CaptureFixture[str], line: str, message: str) -> None:
    assert main(line.split()) == 2
    err = capsys.readouterr().err
    assert err.startswith("python -m solver: ")
    assert err.count("\n") == 1
    assert message in err


BUILDING = "[building]\nname = 'hall'\n[[building.mode]]\nperiod = 0.5\nx = [0.7, 1.3]\n"


def test_a_floor_moves_as_the_building_under_it(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("hall.toml").write_text(BUILDING)
    moved = converted("record.AT2 --scale 2 --building hall.toml --floor 2")
    wanted = floor_motion(Motion.from_file("record.AT2").scaled(2.0), Building.from_toml("hall.toml"), 2)
    np.testing.assert_allclose(np.interp(wanted.time, moved.time, moved.ax), wanted.ax, atol=1e-9)
    out = capsys.readouterr().out
    assert "floor 2 of 2 of hall, first period 0.5 s; PGA of the ground" in out
    words = ["--building", "hall.toml", "--floor", "1", "--no-check", "--settle", "0"]
    assert main(["simulate", "column.toml", "record.AT2", *words]) == 0
    assert "floor 1 of 2 of hall, first period 0.5 s; PGA of the ground" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--building hall.toml", "--floor: must be given with --building"),
        ("--floor 1", "--floor 1: is for --building"),
        ("--building hall.toml --floor 3", "--floor = 3: must be a whole number from 0, the ground, to 2, the top of"),
        ("--building none.toml --floor 1", "none.toml: No such file"),
        ("--building column.toml --floor 1", "column.toml: name: unknown key, must be one of building"),
    ],
)
def test_mistakes_about_a_floor(folder: Path, capsys: pytest.CaptureFixture[str], words: str, message: str) -> None:
    Path("hall.toml").write_text(BUILDING)
    for command in ("simulate column.toml record.AT2", "convert record.AT2 out.csv"):
        assert main([*command.split(), *words.split()]) == 2
        assert message in capsys.readouterr().err
    assert main(["convert", "record.AT2", "hall.toml", "--building", "hall.toml", "--floor", "1", "--force"]) == 2
    assert Path("hall.toml").read_text() == BUILDING
