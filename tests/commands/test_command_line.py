"""The command line: its files hold what the solver computes, and a user's mistake ends in one line and exit code 2."""

import csv
import inspect
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from support.fmus import DAMPED, PHOCAS, finish_in
from support.record_files import AT2

from solver import Column, InputError, Motion, natural_frequencies, simulate, simulate_many
from solver.commands.command_line import main
from solver.commands.reports import STRONG, strongly_damped_lines
from solver.ground.motion import STANDARD_GRAVITY


class Ended(NamedTuple):
    """A command that has ended."""

    returncode: int
    stdout: str
    stderr: str


Solver = Callable[..., Ended]


@pytest.fixture
def solver(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Solver:
    """Return `python -m solver` in the folder of the test, in this process."""
    monkeypatch.chdir(tmp_path)
    return lambda *words: Ended(main([str(word) for word in words]), *capsys.readouterr())


def read(path: Path) -> tuple[list[str], np.ndarray]:
    with path.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    return header, np.array(rows, dtype=np.float64)


def printed_peaks(text: str) -> list[float]:
    """Return the peaks in mm from what `simulate` prints."""
    lines = text.splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("block")) + 1
    return [float(line.split()[1]) for line in lines[first:] if line.split()[0].isdigit() and len(line.split()) == 2]


@pytest.fixture
def motion(tmp_path: Path) -> Motion:
    """Return a motion of 0.05 g at 3 Hz for 2 s, sampled, as motion.csv and in memory."""
    Motion.harmonic(0.05 * STANDARD_GRAVITY, 3.0, 2.0).to_csv(tmp_path / "motion.csv", step=0.01)
    return Motion.from_csv(tmp_path / "motion.csv")


def test_histories_have_nine_digits_by_default(tmp_path: Path) -> None:
    response = simulate(Column.from_toml(PHOCAS), Motion.harmonic(0.05 * STANDARD_GRAVITY, 3.0, 0.5), settle=0.0)
    response.to_csv(tmp_path / "nine.csv")
    response.to_csv(tmp_path / "all.csv", digits=17)
    header, rows = read(tmp_path / "nine.csv")
    full = read(tmp_path / "all.csv")[1]
    np.testing.assert_array_equal(full[:, header.index("joint[2].M")], response.My[:, 1])
    np.testing.assert_allclose(rows, full, rtol=5.1e-9)
    assert np.any(rows != full)
    numbers = (tmp_path / "nine.csv").read_text().partition("\n")[2].replace("\n", ",").split(",")
    assert max(map(len, numbers)) <= 16  # -1.23456789e-123
    response.to_csv(tmp_path / "two.csv", digits=2)
    few = read(tmp_path / "two.csv")[1]
    np.testing.assert_array_equal(few[:, 0], rows[:, 0])  # times stay apart
    np.testing.assert_allclose(few, full, rtol=0.051)
    with pytest.raises(InputError, match="digits = 18: must be a whole number from 1 to 17"):
        response.to_csv(tmp_path / "none.csv", digits=18)


@pytest.mark.long  # takes seconds
def test_simulate_writes_what_the_solver_computes(tmp_path: Path, motion: Motion) -> None:
    words = ("--digits", "17", "-o", "results.csv", "--plot", "response.png")
    run = finish_in(tmp_path, sys.executable, "-m", "solver", "simulate", PHOCAS, "motion.csv", *words)
    assert (run.returncode, run.stderr) == (0, "")
    response = simulate(Column.from_toml(PHOCAS), motion)
    header, rows = read(tmp_path / "results.csv")
    assert header[0] == "time"
    assert {f"joint[{i}].{name}" for i in (1, 2, 3) for name in ("N", "M", "S", "contact", "sigma_max")} < set(header)
    assert {"base.Fx", "base.Fz", "base.My", "overturned"} < set(header)
    np.testing.assert_array_equal(rows[:, 0], response.time)
    assert rows[-1, 0] == pytest.approx(2.0)
    np.testing.assert_array_equal(rows[:, header.index("block[3].ux")], response.ux[:, 2])
    np.testing.assert_array_equal(rows[:, header.index("joint[2].M")], response.My[:, 1])
    assert printed_peaks(run.stdout) == pytest.approx(1e3 * response.peak_top_ux, rel=1e-4)
    assert "not overturned" in run.stdout
    assert f"full contact {100.0 * response.stats['full_contact']:.3g} %" in run.stdout
    assert run.stdout.splitlines()[-2:] == ["results.csv", "response.png"]
    assert (tmp_path / "response.png").read_bytes().startswith(b"\x89PNG")


def test_simulate_says_what_it_starts_from(tmp_path: Path, motion: Motion, solver: Solver) -> None:
    run = solver("simulate", PHOCAS, "motion.csv", "--scale", 2)
    assert "phocas: 3 blocks, 14.07 m, settles by " in run.stdout
    column = Column.from_toml(PHOCAS)
    assert f"first natural frequency {natural_frequencies(column)[0]:.4g} Hz, no joints damped\n" in run.stdout
    assert "base: 2 s, PGA 0.1 g\n" in run.stdout


def test_a_column_that_is_probably_not_meant(tmp_path: Path, motion: Motion, solver: Solver) -> None:
    text = (DAMPED).read_text(encoding="utf-8")
    (tmp_path / "soft.toml").write_text(text.replace("5226944450.0", "1e5"), encoding="utf-8")
    run = solver("simulate", "soft.toml", "motion.csv")
    assert run.returncode == 2
    assert "phocas_damped cannot stand: its rest under gravity is not stable" in run.stderr
    assert "settles by 3.26 m" in run.stderr
    assert "standing" not in run.stdout
    assert "not overturned" not in run.stdout
    (tmp_path / "heavy.toml").write_text(
        text.replace("27000.0 ", "2e9 ").replace("5226944450.0", "1e15").replace("1e-3", "1e-6"), encoding="utf-8"
    )
    run = solver("simulate", "heavy.toml", "motion.csv", "--duration", 0.01)
    assert run.returncode == 0
    density, line = run.stderr.splitlines()
    assert density.startswith("warning: block[1].mass = 2e+09: is 1.75e+08 kg/m3")
    assert line.startswith("warning: joint 3: carries ")
    assert "MPa, which no stone bears; mass is in kg" in line


@pytest.mark.parametrize("command", ["modes", "statics", "calibrate"])
def test_every_command_warns_of_it_once(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    light = tmp_path / "light.toml"
    light.write_text(PHOCAS.read_text(encoding="utf-8").replace("27000.0", "600.0"), encoding="utf-8")
    assert main([command, str(light)]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("warning: block[1].mass = 600: is 52.6 kg/m3 in 11.41 m3, should be 500 to 12000")


@pytest.mark.parametrize(
    ("old", "new", "hint"),
    [
        ("5226944450.0", "1e6", "the joints are too soft for the weight above them (block[3].joint.stiffness = 1e+06"),
        pytest.param(  # takes seconds
            *("5226944450.0", "1000.0", "block[3].joint.stiffness = 1000: block 3 settles by 326 m at rest"),
            marks=pytest.mark.long,
        ),
        ("1.56", "0.01", "block[3].joint.stiffness = 5.22694e+09 settles by 1.52 m"),
        ("5226944450.0", "1e20", "stiffness is in N/m3: 1 kgf/cm3 = 9.80665e6 N/m3"),
    ],
)
def test_statics_of_what_is_no_structure_hints_at_units(
    old: str, new: str, hint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    odd = tmp_path / "odd.toml"
    text = PHOCAS.read_text(encoding="utf-8").replace(old, new).replace("damping = 1e-3", "damping = 0.0")
    odd.write_text(text, encoding="utf-8")
    assert main(["statics", str(odd)]) == 2
    error = capsys.readouterr().err.splitlines()[-1]
    assert error.startswith(f"python -m solver: {odd}: ")
    assert hint in error
    assert "5000 points" not in error


def test_simulate_takes_every_option(tmp_path: Path, motion: Motion, solver: Solver) -> None:
    options = "--scale -0.5 --duration 0.5 --output-step 0.1 --formulation exact --integrator auto --tolerance 1e-7"
    run = solver("simulate", PHOCAS, "motion.csv", *options.split(), "--digits", 17, "-o", "results.CSV")
    assert (run.returncode, run.stderr) == (0, "")
    wanted = simulate(
        Column.from_toml(PHOCAS),
        motion.scaled(-0.5),
        duration=0.5,
        output_step=0.1,
        formulation="exact",
        integrator="auto",
        tolerance=1e-7,
    )
    header, rows = read(tmp_path / "results.CSV")
    np.testing.assert_array_equal(rows[:, 0], wanted.time)
    np.testing.assert_array_equal(rows[:, header.index("block[1].ux")], wanted.ux[:, 0])
    run = solver("simulate", PHOCAS, "motion.csv", "--duration", 0.1, "--step", 1e-3)
    assert "100 steps" in run.stdout


def test_simulate_reads_records(tmp_path: Path, solver: Solver) -> None:
    (tmp_path / "record.at2").write_text(AT2, encoding="utf-8")
    run = solver("simulate", DAMPED, "record.at2", "--duration", 1.0)
    assert run.returncode == 0
    response = simulate(Column.from_toml(DAMPED), Motion.from_at2(tmp_path / "record.at2"), 1.0)
    assert printed_peaks(run.stdout) == pytest.approx(1e3 * response.peak_top_ux, rel=1e-4)


def test_simulate_tells_of_overturning(tmp_path: Path, solver: Solver) -> None:
    Motion.from_samples(0.5, np.full(5, 5.0)).to_csv(tmp_path / "push.csv")
    run = solver("simulate", DAMPED, "push.csv")
    response = simulate(Column.from_toml(DAMPED), Motion.from_csv(tmp_path / "push.csv"))
    assert response.overturned
    assert run.returncode == 0
    assert (
        f"overturned at {response.overturn_time:.4g} s: block {response.fallen} over joint {response.fallen}"
        in run.stdout
    )


def test_convert_writes_what_fmpy_reads(tmp_path: Path, solver: Solver) -> None:
    (tmp_path / "RECORD.AT2").write_text(AT2, encoding="utf-8")
    run = solver("convert", "RECORD.AT2", "motion.csv", "--scale", 2.0)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.splitlines() == [
        "RECORD.AT2: PEER AT2, 5 samples, 0.08 s; A TEST, 000",
        "motion.csv: 5 samples, 0.08 s, largest acceleration 0.8 g",
    ]
    header, rows = read(tmp_path / "motion.csv")
    assert header == ["time", "base.ax", "base.az", "base.jx", "base.jz"]
    ax = 2.0 * STANDARD_GRAVITY * np.array([0.01, -0.2, 0.3, 0.4, -0.05])
    np.testing.assert_allclose(rows[::2, 0], 0.02 * np.arange(5))
    np.testing.assert_allclose(rows[::2, 1], ax)
    np.testing.assert_allclose(rows[:-2:2, 3], np.diff(ax) / 0.02)
    np.testing.assert_array_equal(rows[1::2, 3], rows[:-2:2, 3])  # just before the next sample
    np.testing.assert_array_equal(rows[:, (2, 4)], 0.0)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("", "required: COMMAND"),
        ("draw", "'simulate', "),
        ("simulate", "required: FILE.toml"),
        ("simulate none.toml motion.csv", "none.toml: No such file"),
        ("simulate motion.csv motion.csv", "motion.csv: must end in .toml"),
        ("simulate {phocas} none.csv", "none.csv: No such file"),
        ("simulate {phocas}", "MOTION: must be given, a record or --wavelet"),
        ("simulate {phocas} motion.csv --scale much", "argument --scale"),
        ("simulate {phocas} motion.csv --output-step 0", "output_step = 0"),
        ("simulate {phocas} motion.csv --duration 1e300", "must be larger, for at most"),
        ("simulate {phocas} motion.csv --formulation exakt", "did you mean exact?"),
        ("simulate {phocas} motion.csv --integrator euler", ": integrator = 'euler': must be"),
        ("simulate {phocas} motion.csv --step 0", ": step = 0"),
        ("simulate {phocas} motion.csv --tolerance 1", ": tolerance = 1"),
        ("simulate {phocas} motion.csv -o results.txt", "results.txt: must end in .csv"),
        ("simulate {phocas} motion.csv --plot response.txt", "response.txt: must end in .png"),
        ("simulate {phocas} motion.csv -o none/results.csv", "none/results.csv: No such folder: none"),
        ("simulate {phocas} motion.csv --plot none/response.png", "none/response.png: No such folder: none"),
        ("simulate {phocas} motion.csv --step 0.5", ": step = 0.5: must be at most"),
        ("simulate {phocas} motion.csv --digits 9", "--digits 9: must be left out, or -o FILE.csv given"),
        ("simulate {phocas} motion.csv --digits 0", "--digits = 0: must be a whole number from 1 to 17"),
        (
            "simulate {phocas} motion.csv --spread 0.1 0.1 0.1",
            "--spread, --spread-seed: must be left out, or",
        ),
        ("simulate {phocas} motion.csv --frob", "unrecognized arguments: --frob"),
        ("simulate {phocas} motion.csv -o motion.csv", "motion.csv: must be another file than motion.csv"),
        ("simulate {phocas} record.AT2 --vertical motion.csv -o ./motion.csv", "must be another file than motion.csv"),
        ("simulate {phocas} record.AT2 --load a.Fx=motion.csv -o ./motion.csv --force", "another file than motion.csv"),
        ("simulate {phocas} motion.csv --duration 1e5 -o none/results.csv", "No such folder: none"),
        ("record record.AT2 --plot none/record.png", "none/record.png: No such folder: none"),
        ("convert motion.csv motion.csv", "motion.csv: must be another file than motion.csv, which it would overwrite"),
        ("convert record.AT2 --across motion.csv motion.csv --force", "must be another file than motion.csv"),
        ("convert record.AT2 other.txt", "other.txt: must end in .csv"),
        ("convert record.AT2 none/other.csv", "none/other.csv: No such folder: none"),
    ],
)
def test_mistakes_end_in_one_line(
    tmp_path: Path,
    motion: Motion,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    line: str,
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "record.AT2").write_text(AT2, encoding="utf-8")
    before = sorted(tmp_path.iterdir())
    try:
        code: object = main(line.format(phocas=PHOCAS).split())
    except SystemExit as end:  # argparse's own
        code = end.code
    err = capsys.readouterr().err
    assert code == 2
    assert err.startswith("python -m solver: ")
    assert err.count("\n") == 1
    assert message in err
    assert sorted(tmp_path.iterdir()) == before


def test_a_mistake_ends_the_process_with_2(tmp_path: Path) -> None:
    run = finish_in(tmp_path, sys.executable, "-m", "solver", "simulate", "none.toml", "motion.csv")
    assert (run.returncode, run.stderr) == (2, "python -m solver: none.toml: No such file or directory\n")


# options of `simulate` -> those of the command, where they have other names
OF_THE_COMMAND = {
    "check": ["no_check"],
    "spread": ["spread", "spread_seed"],
    "without": [],
    "callback": [],
    "loads": ["load"],
}
GROUPS = ("Loads", "Accuracy", "Output", "Verdict", "Trust", "Work")


def options_by_group(function: Callable[..., object]) -> dict[str, str]:
    """Return the option -> group: the first paragraph of the docstring, of those that begin with a group's name, that
    has it.
    """
    paragraphs = (inspect.getdoc(function) or "").split("\n\n")
    begun = [(group, text) for text in paragraphs for group in GROUPS if re.match(rf"{group}[.;]", text)]
    names = set(inspect.signature(function).parameters) - {
        "column",
        "columns",
        "motion",
        "motions",
        "duration",
        "initial",
    }
    found = {name: [group for group, text in begun if re.search(rf"\b{name}`?(?::|,| \()", text)] for name in names}
    assert {name for name, groups in found.items() if not groups} == set()
    return {name: groups[0] for name, groups in found.items()}


def test_every_option_of_a_run_is_in_a_group(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found, of_many = options_by_group(simulate), options_by_group(simulate_many)
    assert set(found.values()) == set(GROUPS[:5])
    assert {name: of_many[name] for name in found if name in of_many} == {
        name: group for name, group in found.items() if name in of_many
    }
    monkeypatch.setenv("COLUMNS", "100")
    with pytest.raises(SystemExit):
        main(["simulate", "--help"])
    sections = re.split(r"^(\w[^\n]*):\n", capsys.readouterr().out, flags=re.MULTILINE)
    texts = {sections[k].partition(" ")[0].capitalize(): sections[k + 1] for k in range(1, len(sections) - 1, 2)}
    for name, group in found.items():
        for option in OF_THE_COMMAND.get(name, [name]):
            assert f"--{option.replace('_', '-')} " in texts[group].replace("\n", " "), option


def test_a_decimal_comma_of_an_option_is_called_by_its_name(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "a.toml", "b.csv", "--pga", "0,3"]) == 2
    line = "argument --pga: 0,3 has a decimal comma, must be 0.3 with a decimal point\n"
    assert capsys.readouterr().err.endswith(line)


def test_output_that_is_no_longer_read_ends_a_command_silently() -> None:
    """Close the pipe early, as `| head` does: with the exit code that shells give."""
    with subprocess.Popen(
        [sys.executable, "-m", "multiblock", "statics", str(PHOCAS)], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as command:
        assert command.stdout is not None
        assert command.stderr is not None
        command.stdout.close()
        said = command.stderr.read()
    assert (command.returncode, said) == (141, b"")


def test_modes_that_hardly_vibrate_are_remarked() -> None:
    """Check that swings of a damped oscillator fall by exp(-2 pi r / sqrt(1 - r^2)): to less than a seventh
    above 0.3.
    """
    assert np.exp(-2.0 * np.pi * STRONG / np.sqrt(1.0 - STRONG**2)) < 1.0 / 7.0
    assert strongly_damped_lines(np.array([0.02, 0.29])) == []
    (line,) = strongly_damped_lines(np.array([0.02, 0.92, 1.7]))
    assert line.startswith("modes 2, 3: damping above 30 % of critical")
    assert strongly_damped_lines(np.array([0.5]))[0].startswith("mode 1: ")
