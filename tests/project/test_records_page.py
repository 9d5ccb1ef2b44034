"""Every command and program of docs/records.md works as it stands there; arrays of other programs are stood in for."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support.columns import BLOCK
from support.record_files import DT, SAMPLES, at2, cosmos_v2, plain

from solver import Motion
from solver.commands.command_line import main

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "records.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", PAGE, flags=re.MULTILINE | re.DOTALL)
COMMANDS = [line for kind, text in BLOCKS if kind == "sh" for line in text.splitlines()]
PROGRAMS = [text for kind, text in BLOCKS if kind == "python"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the files that the page speaks of, in the working directory."""
    (tmp_path / "COLUMN.toml").write_text(BLOCK)
    for name in ("RECORD.AT2", "horizontal.AT2", "vertical.AT2"):
        (tmp_path / name).write_text(at2(), encoding="utf-8")
    (tmp_path / "record.txt").write_text(plain(0.01))
    (tmp_path / "station.v2").write_text(cosmos_v2(3))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("command", COMMANDS)
def test_commands(folder: Path, command: str) -> None:
    program, *arguments = command.split()
    assert program == "multiblock"
    assert main(arguments) == 0


def test_programs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    measures, obspy, eqsig, pair = PROGRAMS
    exec(measures, {})
    assert "PGV in m/s: 0.1" in capsys.readouterr().out
    single = SAMPLES.astype(np.float32)  # as obspy has them
    trace = SimpleNamespace(stats=SimpleNamespace(delta=DT), data=single)
    found: dict[str, Motion] = {}
    exec(obspy, {"trace": trace, "up": SimpleNamespace(data=-single)}, found)
    np.testing.assert_array_equal(found["motion"].ax, single)
    np.testing.assert_array_equal(found["motion"].az, -single)
    exec(eqsig, {"signal": SimpleNamespace(dt=DT, values=SAMPLES)}, found)
    np.testing.assert_array_equal(found["motion"].ax, SAMPLES)
    exec(pair, {"east": SAMPLES, "up": SAMPLES}, found)
    assert found["motion"].pga == pytest.approx(0.3 * 9.80665, rel=1e-15)
    assert len(found["motion"].time) == 300  # 1 s at 0.005 s, the rest at 0.01 s
