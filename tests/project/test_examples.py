"""The example programs do their job from any folder, and say in one line what a user did wrong."""

import csv
import importlib.util
import math
import runpy
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from matplotlib.image import imread
from support.fmus import DAMPED, PHOCAS, ROOT, finish_in

from solver import Column, InputError, Motion, Table, simulate
from solver.ground.motion import STANDARD_GRAVITY

pytestmark = pytest.mark.long  # runs the programs of the examples

EXAMPLES = ROOT / "examples"


def example(name: str, folder: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    """Run an example in a folder."""
    return finish_in(folder, sys.executable, EXAMPLES / name, *arguments)


def read(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def is_picture(path: Path) -> bool:
    """Return True if a file is a PNG of a readable size with something on it."""
    pixels = imread(path)
    return bool(pixels.shape[0] > 500 and pixels.shape[1] > 1000 and np.std(pixels[..., :3]) > 0.05)


def too_stiff(folder: Path) -> Path:
    """Return the Column of Phocas with joints too stiff for its step."""
    file = folder / "stiff.toml"
    text = PHOCAS.read_text(encoding="utf-8")
    file.write_text(text.replace("stiffness = 5226944450.0", "stiffness = 5e13"), encoding="utf-8")
    return file


# phocas.py

WRITTEN = "results.csv", "results.png", "scene.html"


def test_phocas(tmp_path: Path) -> None:
    run = example("phocas.py", tmp_path, "--column", PHOCAS, "--duration", 2, "--output-step", 0.001)
    assert (run.returncode, run.stderr) == (0, "")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["phocas.fmu", *WRITTEN]
    assert is_picture(tmp_path / "results.png")
    assert "modelDescription.xml" in zipfile.ZipFile(tmp_path / "phocas.fmu").namelist()

    rows = read(tmp_path / "results.csv")
    wanted = {f"block[{i}].{name}" for i in (1, 2, 3) for name in ("ux", "uz", "theta")}
    wanted |= {f"joint[{i}].{name}" for i in (1, 2, 3) for name in ("N", "M", "S", "T", "contact", "sigma_max")}
    wanted |= {"time", "base.Fx", "base.Fz", "base.My", "overturned", "overturn_time", "overturn_joint"}
    assert wanted <= rows[0].keys()
    time = np.array([float(row["time"]) for row in rows])
    np.testing.assert_allclose(time, 1e-3 * np.arange(2001), atol=1e-9)
    ux = np.array([[float(row[f"block[{i}].ux"]) for i in (1, 2, 3)] for row in rows])
    # measured 8e-6: with its slope the input is linear within each millisecond; held, the error was 1e-3
    peaks = np.max(np.abs(ux), axis=0)
    assert peaks == pytest.approx([0.03062904, 0.01970620, 0.00901790], rel=5e-5)

    lines = run.stdout.splitlines()
    printed = [float(line.split()[1]) for line in lines[1:4]]
    assert printed == pytest.approx(1e3 * peaks, rel=1e-4)
    assert lines[4:] == ["not overturned", "phocas.fmu", *WRITTEN]


def test_phocas_with_options(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    options = ["--amplitude", 0.6, "--frequency", 0.25, "--duration", 2.5]
    run = example("phocas.py", tmp_path, *options, "--output-folder", folder)
    assert (run.returncode, run.stderr) == (0, "")
    assert sorted(file.name for file in folder.iterdir()) == ["phocas_damped.fmu", *WRITTEN]
    response = simulate(Column.from_toml(DAMPED), Motion.harmonic(0.6 * STANDARD_GRAVITY, 0.25, 2.5))
    assert response.overturned
    last = read(folder / "results.csv")[-1]
    assert float(last["time"]) == pytest.approx(2.5)
    assert len(read(folder / "results.csv")) == 501
    assert last["overturned"] == "True"
    assert float(last["overturn_time"]) == pytest.approx(response.overturn_time, abs=5e-3)
    assert f"overturned at {float(last['overturn_time']):.4g} s" in run.stdout


def test_phocas_does_not_pass_over_a_run_cut_short(tmp_path: Path) -> None:
    run = example("phocas.py", tmp_path, "--column", too_stiff(tmp_path), "--duration", 1)
    assert run.returncode == 1
    assert run.stderr.splitlines()[-1].startswith("phocas.py: the FMU stopped")
    assert "Traceback" not in run.stderr
    assert not (tmp_path / "results.csv").exists()


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("phocas.py --column none.toml", "none.toml: No such file"),
        ("phocas.py --amplitude much", "argument --amplitude"),
        ("phocas.py --amplitude nan", "amplitude = nan"),
        ("phocas.py --frequency 0", "frequency = 0"),
        ("phocas.py --output-step 0.0015", "output step = 0.0015: must be a multiple of 0.001 s"),
        ("phocas.py --duration -1", "duration = -1"),
        ("phocas.py --duration 0.0015", "must be a multiple of 0.001 s"),
        ("phocas.py --duration 1e300", "at most 3600.0 s"),
        ("phocas.py --output-folder file.txt", "file.txt"),
        ("phocas.py --frob", "unrecognized arguments: --frob"),
        ("figure3.py --column none.toml", "none.toml: No such file"),
        ("figure3.py --step 0", "step = 0"),
        ("figure3.py --step 11", "step = 11"),
        ("figure3.py --duration 0", "duration = 0"),
        ("figure3.py --output-folder file.txt", "file.txt: File exists"),
        ("figure3.py --frob", "unrecognized arguments: --frob"),
    ],
)
def test_mistakes_end_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], line: str, message: str
) -> None:
    (tmp_path / "file.txt").touch()
    name, *arguments = line.split()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [name, *arguments])
    with pytest.raises(SystemExit) as end:
        runpy.run_path(str(EXAMPLES / name), run_name="__main__")
    err = capsys.readouterr().err
    assert end.value.code == 2
    assert err.startswith(f"{name}: ")
    assert err.count("\n") == 1
    assert message in err
    assert [file.name for file in tmp_path.iterdir()] == ["file.txt"]


# figure3.py


@pytest.fixture(scope="module")
def figure3() -> ModuleType:
    specification = importlib.util.spec_from_file_location("figure3", EXAMPLES / "figure3.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules["figure3"] = module
    specification.loader.exec_module(module)
    return module


def test_figure3_program(tmp_path: Path) -> None:
    run = example("figure3.py", tmp_path, "--step", 2.5, "--duration", 0.5, "--output-folder", "new")
    assert run.returncode == 0
    rows = read(tmp_path / "new" / "figure3.csv")
    assert [(float(row["amplitude_g"]), float(row["frequency_hz"])) for row in rows] == [
        (amplitude, frequency) for amplitude in (0.05, 0.1) for frequency in (2.5, 5.0, 7.5, 10.0)
    ]
    wanted = simulate(Column.from_toml(PHOCAS), Motion.harmonic(0.1 * STANDARD_GRAVITY, 5.0, 0.5)).peak_top_ux
    assert [float(rows[5][f"peak_{i}"]) for i in (1, 2, 3)] == pytest.approx(list(wanted), rel=1e-9)
    assert {row["overturned"] for row in rows} == {"False"}
    assert {row["overturn_time_s"] for row in rows} == {""}
    assert is_picture(tmp_path / "new" / "figure3.png")
    assert run.stdout.splitlines()[-2:] == [str(Path("new", f"figure3.{end}")) for end in ("csv", "png")]


def test_frequencies_are_multiples_within_the_paper_range(figure3: ModuleType) -> None:
    assert figure3.frequencies(0.25) == [0.25 * k for k in range(1, 41)]
    assert figure3.frequencies(1.0) == [float(k) for k in range(1, 11)]
    assert figure3.frequencies(0.1)[0] == 0.3
    assert figure3.frequencies(0.1)[-1] == 10.0
    with pytest.raises(InputError):
        figure3.frequencies(math.nan)


def test_sweep_meets_the_reference(figure3: ModuleType) -> None:
    (run,) = figure3.sweep(Column.from_toml(PHOCAS), [0.05], [1.0], 10.0)
    # theory: 0.05 g, 1 Hz, 10 s; measured 5e-6
    assert run.peaks == pytest.approx([0.00378678, 0.00235583, 0.00102301], rel=2e-5)
    response = simulate(Column.from_toml(PHOCAS), Motion.harmonic(0.05 * STANDARD_GRAVITY, 1.0, 10.0))
    assert run.peaks == pytest.approx(response.peak_top_ux, rel=1e-9)
    assert run.stands


def test_sweep_does_not_depend_on_threads(figure3: ModuleType) -> None:
    points = Column.from_toml(PHOCAS), [0.05, 0.1], [1.0, 1.5, 2.0], 5.0
    alone, together = (figure3.sweep(*points, workers=workers) for workers in (1, 4))
    assert [(run.amplitude, run.frequency) for run in alone] == [(a, f) for a in (0.05, 0.1) for f in (1.0, 1.5, 2.0)]
    for one, other in zip(alone, together, strict=True):
        assert (one.amplitude, one.frequency) == (other.amplitude, other.frequency)
        np.testing.assert_array_equal(one.peaks, other.peaks)


def test_sweep_records_what_goes_wrong(figure3: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def give_up(*_: object, **__: object) -> Table:
        nothing = {"peak_top_ux": np.full((2, 3), math.nan), "overturn_time": np.full(2, math.nan)}
        return Table(nothing, {"failures": {0: "after 0.05 s: the reason", 1: "after 0.06 s: another"}})

    monkeypatch.setattr(figure3, "simulate_many", give_up)
    runs = figure3.sweep(Column.from_toml(PHOCAS), [0.05], [1.0, 2.0], 0.1)
    assert all(run.failure and not run.overturned and not run.stands for run in runs)
    figure3.write_csv(runs, tmp_path / "figure3.csv")
    rows = read(tmp_path / "figure3.csv")
    assert [row["failure"] for row in rows] == [run.failure for run in runs]
    assert {row["peak_1"] for row in rows} == {""}
    assert figure3.findings(runs) == ["0.05 g: the solver gave up at 1 Hz, 2 Hz."]
    figure3.draw(runs, ["caption"], tmp_path / "figure3.png")
    assert is_picture(tmp_path / "figure3.png")


def test_sweep_records_overturning(figure3: ModuleType) -> None:
    (run,) = figure3.sweep(Column.from_toml(DAMPED), [0.6], [0.25], 2.5)
    assert run.overturned
    assert not run.stands
    assert 0.0 < run.overturn_time < 2.5


def runs_like_the_paper(figure3: ModuleType) -> list:
    """Return True if 0.05 g at 2 Hz moves the column most; at 0.1 g the lower the frequency the more, until it
    falls.
    """
    peaks = {0.05: {0.25: 2.0, 1.5: 57.0, 2.0: 31.0, 3.0: 12.0}, 0.1: {0.25: 7000.0, 1.5: 80.0, 2.0: 52.0, 3.0: 19.0}}
    return [
        figure3.Run(a, f, 1e-3 * peak * np.array([1.0, 0.6, 0.3]), 9.5 if (a, f) == (0.1, 0.25) else math.nan)
        for a, series in peaks.items()
        for f, peak in series.items()
    ]


def test_figure3_marks_overturned_runs(figure3: ModuleType) -> None:
    figure = figure3.draw(runs_like_the_paper(figure3), ["first paragraph", "second paragraph"])
    weak, strong = figure.axes
    assert [len(axes.lines) for axes in (weak, strong)] == [3, 4]
    np.testing.assert_allclose(weak.lines[0].get_ydata(), [2.0, 57.0, 31.0, 12.0])
    np.testing.assert_allclose(strong.lines[0].get_ydata(), [math.nan, 80.0, 52.0, 19.0])
    assert list(strong.lines[-1].get_xdata()) == [0.25]
    assert strong.lines[-1].get_label() == "overturned"
    assert figure.get_supxlabel() == "first paragraph\nsecond paragraph"


def test_caption_says_what_the_runs_say(figure3: ModuleType) -> None:
    column, runs = Column.from_toml(PHOCAS), runs_like_the_paper(figure3)
    text = " ".join(figure3.caption(runs, column, 20.0))
    assert "0.05 g: largest displacement 57 mm at 1.5 Hz." in text
    assert "0.1 g: largest displacement 80 mm at 1.5 Hz; overturned at 0.25 Hz (after 9.50 s)." in text
    assert "among whole frequencies here 31 mm at 2 Hz" in text
    assert "so they do here" in text
    assert "cannot agree point by point" in text
    sinking = [replace(run, peaks=0.5 * run.peaks) if run.frequency == 1.5 else run for run in runs]
    assert "not at every step here" in " ".join(figure3.caption(sinking, column, 20.0))
    fast = [run for run in runs if run.frequency > 1.9]
    assert "too few runs here to tell" in " ".join(figure3.caption(fast, column, 20.0))


def test_caption_compares_like_with_like_only(figure3: ModuleType) -> None:
    runs = runs_like_the_paper(figure3)
    assert "The paper's" not in " ".join(figure3.caption(runs, Column.from_toml(PHOCAS), 10.0))
    damped = " ".join(figure3.caption(runs, Column.from_toml(DAMPED), 20.0))
    assert "The paper's" not in damped
    assert "chaotic" not in damped


# structures/with_and_without_ties.py


@pytest.mark.campaign
def test_what_ties_do(tmp_path: Path) -> None:
    """Run both for a second of shaking: ties bear forces, and the architraves slide apart less."""
    time = np.arange(101) / 100.0
    rows = zip(time, 3.0 * np.sin(4.0 * math.pi * time), strict=True)
    record = tmp_path / "record.csv"
    record.write_text("time,base.ax\n" + "".join(f"{t},{a}\n" for t, a in rows))
    colonnade = EXAMPLES / "structures" / "colonnade.toml"
    run = example("structures/with_and_without_ties.py", tmp_path, colonnade, record, record, record)
    assert (run.returncode, run.stderr) == (0, "")
    tied, free = run.stdout.split("without ties")
    assert "ties, largest force" in tied
    assert "ties, largest force" not in free
    slips = [float(part.split("slide farthest: architrave1 on architrave2 ")[1].split(",")[0]) for part in (tied, free)]
    assert slips[0] < slips[1]
