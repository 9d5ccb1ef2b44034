"""The masters and partners of examples/coupling, with FMUs in place of which small objects stand."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from support.fmus import ROOT

from fmu_src import host
from multiblock import InputError

sys.path.insert(0, str(ROOT / "examples" / "coupling"))

import isolated
import master
from partner_kernels import law_of
from partner_table import native_partner


class Recorder:
    """An FMU that records its inputs at each step; its outputs are zero."""

    def __init__(self, *names: str) -> None:
        self.variables = dict.fromkeys(names)
        self.values = dict.fromkeys(names, 0.0)
        self.steps: list[dict[str, float]] = []

    def get(self, *names: str) -> list[float]:
        return [self.values[name] for name in names]

    def set(self, **values: float) -> None:
        self.values |= values

    def step(self, t: float, h: float) -> None:
        self.steps.append(dict(self.values))


def test_the_column_on_a_slab_has_the_vertical_motion_of_the_ground_in_the_same_step() -> None:
    for more, expected in (((), 5.0), (("body.F0z",), 0.0)):  # a partner that moves vertically says so itself
        column = Recorder("base.az", "base.jz", "base.R0x", "body.F0x", "body.F0z")
        partner = Recorder("ground.az", "ground.jz", "column.R0x", "body.F0x", *more)
        fmus: Any = {"column": column, "partner": partner}

        def shake(t: float) -> dict[tuple[str, str], float]:
            return {("partner", "ground.az"): 5.0 + t, ("partner", "ground.jz"): 1.0}

        master.run(fmus, master.by_state(fmus["column"], fmus["partner"]), 1.0, 2.0, [], shake)
        assert [step["ground.az"] for step in partner.steps] == [5.0, 6.0]
        assert [step["base.az"] for step in column.steps] == [expected, expected + (not more)]
        assert [step["base.jz"] for step in column.steps] == 2 * [float(not more)]


def test_a_step_that_a_partner_does_not_make_leaves_it_as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "laws.host", host)  # the builder puts it into the FMU
    law = law_of("isolator")

    def move(value: Any, motion: list[float], a: tuple[float, ...], slope: tuple[float, ...], h: float) -> None:
        motion[0] = 1.0
        raise ArithmeticError("lost on the way")

    partner = object.__new__(law_of("partner").Partner)
    failing = SimpleNamespace(**{**vars(law), "move": move})
    partner.law, partner.motion, partner._before = failing, [0.1] * law.MOTION, [0.0] * law_of("law").BEFORE
    partner._numbers = {port.name: port.start for port in law.PORTS}
    partner._inputs = [port for port in law.PORTS if port.causality == "input"]
    partner._given = [port for port in law.PORTS if port.causality != "output"]
    said: list[str] = []
    partner._say = lambda status, message: said.append(message)
    assert not partner.do_step(0.0, 1e-3)
    assert "lost on the way" in said[0]
    assert partner.motion == [0.1] * law.MOTION


def test_components_of_a_record_that_an_example_does_not_follow_are_refused(tmp_path: Path) -> None:
    files = {}
    for name in ("ax", "ay", "az"):
        files[name] = tmp_path / f"{name}.csv"
        columns = [f"base.{axis}" for axis in ("ax", "ay", "az") if axis in ("ax", name)]
        rows = (",".join([str(0.01 * k), *["1.0"] * len(columns)]) for k in range(3))
        files[name].write_text("\n".join([",".join(["time", *columns]), *rows]) + "\n", encoding="utf-8")
    assert isolated.ground_of(files["ax"]).ax.tolist() == [1.0] * 3
    for name in ("ay", "az"):
        with pytest.raises(InputError, match="ay, az: the ground moves along x alone"):
            isolated.ground_of(files[name])
    with pytest.raises(InputError, match="ay: partners move along x and z"):
        native_partner("ground", [], files["ay"])
