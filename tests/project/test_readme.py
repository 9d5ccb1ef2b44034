"""Every command and program of the README works as it stands there."""

from __future__ import annotations

import re
import shutil
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from support.fmus import ROOT, Fmus, finish_in, read_results

from multiblock.__main__ import main
from solver import Column

README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", README, flags=re.MULTILINE | re.DOTALL)


def blocks(language: str) -> list[str]:
    """The README's code blocks of one language."""
    return [text for found, text in BLOCKS if found == language]


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A folder that looks like the project's root to a command, with a record of 30 s in it."""
    shutil.copytree(ROOT / "examples", tmp_path / "examples", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "build_fmu.py", tmp_path)
    time = 0.02 * np.arange(1500)
    values = 0.1 * np.exp(-(((time - 5.0) / 2.0) ** 2)) * np.sin(2 * np.pi * 1.5 * time)
    rows = "\n".join(" ".join(f"{value:.7E}" for value in row) for row in values.reshape(-1, 5))
    header = "RECORD\nWAVELET\nACCELERATION IN UNITS OF G\nNPTS=  1500, DT= .02000 SEC\n"
    (tmp_path / "RECORD.AT2").write_text(header + rows + "\n")
    return tmp_path


COMMANDS = [line for text in blocks("sh") for line in text.strip().splitlines()]
PASTED = [command for command in COMMANDS if command.startswith("python3 -m venv")]  # .ci/run pastes them
LONG = ("examples/", "benchmarks", "stress", "--native", "multiblock study")


def paste(command: str, folder: Path) -> None:
    """Run a command of the README in a folder; fails unless it exits with 0."""
    done = finish_in(folder, "bash", "-c", command)
    assert done.returncode == 0, f"{command}\n{done.stderr}"


def takes_long(command: str) -> bool:
    """Whether a command is one of the studies and campaigns."""
    program = command.removeprefix("python ").removeprefix("-m ")
    return program.startswith(LONG) or "--native" in command


def test_two_lines_do_everything() -> None:
    assert COMMANDS[:2] == PASTED
    assert "[fmu]" in PASTED[0]
    assert PASTED[1].endswith("-m pytest")


def test_shell_commands(checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(checkout)
    first, *others = [line for line in COMMANDS[2:] if not line.startswith("pip install") and not takes_long(line)]
    paste(first, checkout)
    for command in others:
        program, *words = command.split()
        if program == "multiblock":  # saves the time in which a process starts
            assert main(words) == 0
        else:
            paste(command, checkout)
    result = read_results(checkout / "out.csv")
    assert result["time"][-1] == pytest.approx(30.0)
    assert np.max(np.abs(result["block[1].ux"])) > 1e-3
    for name in ("response.csv", "response.png", "shaken.csv"):
        assert (checkout / name).stat().st_size > 5_000, name


@pytest.mark.long
def test_shell_commands_that_take_long(checkout: Path) -> None:
    found = [command for command in COMMANDS[2:] if takes_long(command)]
    assert len(found) >= 5
    for command in found:
        paste(command, checkout)
    for name in ("figure3.csv", "figure3.png", "figure3-exact.png", "fragility.csv", "isolated.png"):
        assert (checkout / "results" / name).stat().st_size > 5_000, name


def test_start_values_as_documented(fmus: Fmus, checkout: Path) -> None:
    named = re.search(r"`--start-values ([^`]*)`", README)
    assert named is not None
    options = f"--stop-time 0.01 --output-interval 0.005 --output-file out.csv --start-values {named.group(1)}"
    paste(f"fmpy simulate {fmus.damped} {options}", checkout)
    settlement = 81000 * 9.80665 / (2e9 * 1.56**2)  # of the base joint, now softer
    assert read_results(checkout / "out.csv")["block[3].uz"][0] == pytest.approx(-settlement, rel=1e-9)


def test_python_programs(checkout: Path) -> None:
    for text in blocks("python"):
        done = finish_in(checkout, sys.executable, "-c", text)
        assert done.returncode == 0, done.stderr
        assert "overturned: False" in done.stdout
        assert (checkout / "response.csv").is_file()
        assert (checkout / "response.png").is_file()


def test_column_file() -> None:
    for text in blocks("toml"):
        assert Column.from_dict(tomllib.loads(text)).n == 1
