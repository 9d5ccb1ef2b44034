"""Every command and program of the README works as it stands there."""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from support import pages
from support.fmus import ROOT, finish_in, read_results

from solver import Column

pytestmark = pytest.mark.long  # runs the commands of the README

README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", README, flags=re.MULTILINE | re.DOTALL)


def blocks(language: str) -> list[str]:
    """Return the README's code blocks of one language."""
    return [text for found, text in BLOCKS if found == language]


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Return a folder that looks like the project's root to a command, with a record and the README's column in it."""
    (tmp_path / "column.toml").write_text("".join(blocks("toml")), encoding="utf-8")
    return pages.checkout(tmp_path)


COMMANDS = [line for text in blocks("sh") for line in text.strip().splitlines()]
PASTED = [command for command in COMMANDS if command.startswith("python3 -m venv")]  # .ci/run pastes them
LONG = ("examples/", "benchmarks", "stress", "--native", "multiblock study")


def takes_long(command: str) -> bool:
    """Return True if a command is one of the studies and campaigns."""
    program = command.removeprefix("python ").removeprefix("-m ")
    return program.startswith(LONG) or "--native" in command


def test_two_lines_do_everything() -> None:
    assert COMMANDS[:2] == PASTED
    assert "[fmu]" in PASTED[0]
    assert PASTED[1].endswith("-m pytest")


def test_shell_commands(checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(checkout)
    first, *others = [line for line in COMMANDS[2:] if not line.startswith("pip install") and not takes_long(line)]
    assert first.startswith("multiblock check ")
    pages.paste(f"{first} --ensemble 1 --no-margin --no-joints", checkout)  # in full it takes minutes
    for command in others:
        if command.startswith("multiblock"):  # saves the time in which a process starts
            pages.call(command)
        else:
            pages.paste(command, checkout)
    result = read_results(checkout / "shaken.csv")
    assert result["time"][-1] == pytest.approx(30.0)
    assert np.max(np.abs(result["block[1].ux"])) > 1e-3
    for name in ("pillar.csv", "pillar.png", "report.html"):
        assert (checkout / name).stat().st_size > 5_000, name


@pytest.mark.long
def test_shell_commands_that_take_long(checkout: Path) -> None:
    found = [command for command in COMMANDS[2:] if takes_long(command)]
    assert len(found) >= 2
    for command in found:
        pages.paste(command, checkout)
    assert (checkout / "results" / "isolated.png").stat().st_size > 5_000


def test_python_programs(checkout: Path) -> None:
    said = []
    for text in blocks("python"):
        done = finish_in(checkout, sys.executable, "-c", text)
        assert done.returncode == 0, done.stderr
        picture = checkout / "response.png"
        assert picture.is_file()
        picture.unlink()
        said.append(done.stdout)
    assert said[0] == ""
    assert "overturned: False" in said[1]
    assert (checkout / "response.csv").is_file()


def test_column_file() -> None:
    (text,) = blocks("toml")
    assert Column.from_dict(tomllib.loads(text)).n == 5


def test_it_is_one_page() -> None:
    assert len(README.split()) <= 1150


def test_pictures_and_pages_exist() -> None:
    for target in re.findall(r"\]\(([^)#]+)", README) + re.findall(r"`(docs/[^`]+|CITATION\.cff)`", README):
        assert (ROOT / target).is_file(), target
