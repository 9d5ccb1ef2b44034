"""The command `check`: its table, its files, and its answers to mistakes."""

from pathlib import Path

import numpy as np
import pytest

from multiblock import Motion
from solver.commands.command_line import main

G = 9.80665
COLUMN = """name = "block"
[[block]]
height = 2.0
width = 0.5
depth = 0.5
mass = 1200.0
joint = { stiffness = 2e9, damping = 2e-3, strength = 2e6 }
"""
QUICK = ("--no-margin", "--ensemble", "1")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A column, a wider one, and two records, in the current folder."""
    monkeypatch.chdir(tmp_path)
    Path("block.toml").write_text(COLUMN, encoding="utf-8")
    wider = COLUMN.replace('"block"', '"wider"').replace("width = 0.5", "width = 1.0").replace("1200", "2400")
    Path("wider.toml").write_text(wider, encoding="utf-8")
    time = np.arange(0.0, 3.0, 0.01)
    for name, frequency in (("slow", 1.0), ("fast", 2.5)):
        Motion.from_samples(0.01, np.sin(2.0 * np.pi * frequency * time)).to_csv(f"{name}.csv")
    return tmp_path


def test_check_prints_tables_variants_and_writes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["check", "block.toml", "--pga", "0.1", *QUICK, "--variant", "wider.toml"]
    report = ["--report", "report.html", "--note", "Museum <North>, hall 3", "--note", "checked 1 May"]
    assert main([*words, "-o", "table.csv", *report, "slow.csv", "fast.csv"]) == 0
    printed = capsys.readouterr().out
    assert "each to a largest horizontal acceleration of 0.1 g; counted: largest of 2 motions" in printed
    assert "None of 2 simulated columns fell" in printed
    variants = printed[printed.index("variants under the same motions") :]
    assert variants.splitlines()[1].split() == ["block", "wider"]
    for name in ("overturning", "displacement of the top", "pressure at the edge"):
        assert name in variants
    assert Path("table.csv").is_file()
    page = Path("report.html").read_text(encoding="utf-8")
    assert "SHA-256" in page
    assert '<p class="note">Museum &lt;North&gt;, hall 3</p>' in page
    assert '<p class="note">checked 1 May</p>' in page
    assert main([*words, "slow.csv", "-o", "table.csv"]) == 2
    assert "table.csv: is there already, --force overwrites it" in capsys.readouterr().err


def test_components_and_a_table_of_a_spectrum(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("site.csv").write_text("period,g\n0.01,0.05\n4,0.04\n", encoding="utf-8")
    words = ["check", "block.toml", "slow.csv", "--vertical", "fast.csv", "--spectrum", "site.csv"]
    assert main([*words, "--periods", "0.1", "1", *QUICK]) == 0
    printed = capsys.readouterr().out
    assert "action: site.csv" in printed
    assert "vertical fast.csv: CSV" in printed


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--spectrum", "ec8", "--ag", "0.2"], "--soil: must be given with --spectrum ec8"),
        (["--spectrum", "ec9"], "--spectrum ec9: must be ec8, ntc2018 or a table FILE.csv"),
        (["--pga", "0.2", "--soil", "A"], "--soil A: is for --spectrum ec8 or ntc2018"),
        (["--limit", "slope=1"], "--limit slope=1: must be KEY=VALUE with one of displacement, friction"),
        (["--limit", "slip=wide"], "--limit slip=wide: must be slip= and a number"),
        (["--vertical", "fast.csv", "slow.csv"], "--vertical: 2 files, must be 1, one for each record"),
        (["slow.csv"], "slow.csv: is given twice, must be given once"),
        (["--report", "report.pdf"], "report.pdf: must end in .html or .htm"),
        (["--note", "hall 3"], "--note: is for the report, must be given with --report FILE.html"),
    ],
)
def test_mistakes_are_one_line(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    assert main(["check", "block.toml", "slow.csv", *words]) == 2
    errors = capsys.readouterr().err
    assert message in errors
    assert errors.count("\n") == 1


def test_no_record_needs_a_spectrum(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "block.toml", *QUICK]) == 2
    assert "motions: none given, must be records, or a target spectrum" in capsys.readouterr().err
