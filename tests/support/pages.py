"""Pages of Markdown: their code blocks, and a folder in which their commands run."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from pathlib import Path

import numpy as np

from multiblock.__main__ import main
from support.fmus import ROOT, environment

DOCS = ROOT / "docs"


def blocks(page: Path, language: str) -> list[str]:
    """Return the code blocks of one language, "" for what a program prints."""
    found = re.findall(r"^```(\w*)\n(.*?)^```", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    return [text for name, text in found if name == language]


def commands(page: Path) -> list[str]:
    """Return the lines of the shell blocks, without those that install."""
    lines = [line for text in blocks(page, "sh") for line in text.strip().replace("\\\n", " ").splitlines()]
    return [line for line in lines if not line.startswith("pip install")]


def checkout(folder: Path) -> Path:
    """Make a folder look like the project's root to a command, with a record of 30 s in it."""
    shutil.copytree(ROOT / "examples", folder / "examples", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "build_fmu.py", folder)
    time = 0.02 * np.arange(1500)
    values = 0.1 * np.exp(-(((time - 5.0) / 2.0) ** 2)) * np.sin(2 * np.pi * 1.5 * time)
    rows = "\n".join(" ".join(f"{value:.7E}" for value in row) for row in values.reshape(-1, 5))
    header = "RECORD\nWAVELET\nACCELERATION IN UNITS OF G\nNPTS=  1500, DT= .02000 SEC\n"
    (folder / "RECORD.AT2").write_text(header + rows + "\n")
    return folder


def paste(command: str, folder: Path) -> None:
    """Run a command in a shell in a folder; fails unless it exits with 0."""
    done = subprocess.run(
        ["bash", "-c", command], cwd=folder, capture_output=True, text=True, env=environment(), check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stderr}"


def call(command: str, *more: str) -> None:
    """Run a command `multiblock` in this process and folder, with more arguments; fails unless it exits with 0."""
    program, *arguments = shlex.split(command)
    assert program == "multiblock"
    assert main([*arguments, *more]) == 0, command
