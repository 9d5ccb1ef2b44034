"""FMUs for a base that bodies drive: an input that does nothing is said once, and a base that never moves too."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest
from support.child import ended, returned, said
from support.fmus import COLUMNS, LINUX, ROOT, Fmus, built_once, stack_file
from support.inside import driven

from fmu_src.drive import Idle, idle
from multiblock import Motion

if not sys.platform.startswith("linux"):
    pytest.skip("the native FMUs are built for Linux", allow_module_level=True)

LINUX_3 = ("--native", "--platforms", "x86_64-linux", "--fmi", "3", "--scalars")
KINDS: dict[str, tuple[str, ...]] = {"python": (), "native": LINUX, "native3": LINUX_3}
MODELS = {"column": COLUMNS / "phocas-damped.toml", "structure": ROOT / "examples" / "structures" / "trilith.toml"}
ALONG = {"column": {"body.Mxx": 3e4}, "structure": {"body.M": 3e4}}
WHOLE = {
    "column": ALONG["column"] | {"body.Mzz": 3e4, "body.Mtt": 3e4},
    "structure": ALONG["structure"] | {"body.Jxx": 1e5, "body.Jyy": 1e5},
}
PUSH = {"body.F0x": 1e4}


@pytest.fixture(scope="session", params=[(kind, model) for model in MODELS for kind in KINDS], ids="-".join)
def fmu(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    """Return the model, and its FMU for any way of driving the base."""
    kind, model = request.param
    if kind != "python":
        pytest.importorskip("ziglang", reason="needs the extra native")
    turns = ("--turns",) if model == "structure" else ()
    options = ("--drive", "horizontal", *turns, *KINDS[kind])
    name = f"any_drive_{model}_{kind}.fmu"
    return model, built_once(tmp_path_factory, name, lambda path: Fmus.build(MODELS[model], path, *options))


def heard(fmu: Path, drive: str, before: dict[str, Any], *steps: dict[str, Any]) -> tuple[list[str], list[Any]]:
    """Return the lines that the FMU logs about its base, and its outputs; it has to end well."""
    done = ended(driven.run, fmu, {"base.drive": drive, **before}, steps)
    assert done.returncode == 0, done.stderr
    lines = [line for line in said(done.stdout) if "does nothing" in line or "base never" in line or "base acc" in line]
    return lines, returned(done.stdout)


@pytest.mark.campaign  # takes 10 s and more, and changes seldom
@pytest.mark.long
def test_an_input_that_does_nothing_is_said_once(fmu: tuple[str, Path]) -> None:
    model, file = fmu
    mass = {"body": WHOLE[model], "horizontal": ALONG[model], "acceleration": {}}
    idle_in = {"body": "base.az", "horizontal": "base.jx", "acceleration": "body.F0z"}
    acting = {"body": "body.F0x", "horizontal": "base.az", "acceleration": "base.ax"}
    for drive, name in idle_in.items():
        act = {"base.ax": 0.3} if drive == "acceleration" else mass[drive] | PUSH
        lines, moved = heard(file, drive, {}, act | {name: 0.0}, act | {name: 0.3}, {name: 0.4}, {"base.ax": 0.2})
        assert len(lines) == 1, lines
        assert f"{name} does nothing" in lines[0]
        assert f"base.drive = {drive}" in lines[0]
        lines, same = heard(file, drive, {}, act, {}, {}, {"base.ax": 0.2} if drive == "acceleration" else {})
        assert lines == []
        assert moved == same  # it does nothing
        lines, _ = heard(file, drive, {name: 0.3}, act)  # set before the first step
        assert len(lines) == 1, lines
        lines, other = heard(file, drive, {}, act | {acting[drive]: 0.5}, {}, {}, {})
        assert lines == []
        assert other != same


@pytest.mark.long
def test_a_rotation_acts_before_bodies_turn_the_base(fmu: tuple[str, Path]) -> None:
    model, file = fmu
    name = "base.theta" if model == "column" else "base.theta_y"
    act = WHOLE[model] | PUSH
    lines, first = heard(file, "body", {name: 1e-4}, act, {})
    assert lines == []
    lines, second = heard(file, "body", {}, act, {})
    assert first != second
    lines, third = heard(file, "body", {}, act, {name: 1e-4})
    assert third == second
    assert len(lines) == 1, lines
    assert f"{name} does nothing after" in lines[0]


@pytest.mark.long
@pytest.mark.parametrize("drive", ["body", "acceleration"])
def test_the_rotation_before_the_first_step_is_the_one_set_last(fmu: tuple[str, Path], drive: str) -> None:
    """Check that it is in the outputs at once, whatever was read before, and that it is not said to do nothing."""
    model, file = fmu
    name, angle = ("base.theta", "block[1].theta") if model == "column" else ("base.theta_y", "block[1].ry")
    act = WHOLE[model] | PUSH if drive == "body" else {"base.ax": 0.5}
    names, chosen = [angle, "block[1].ux", "base.Fx"], {"base.drive": drive}
    found = []
    for before, turned in (({name: 1e-3}, {name: 1e-4}), ({name: 1e-4}, {})):
        done = ended(driven.turned_late, file, {**chosen, **before}, turned, act, names)
        assert done.returncode == 0, done.stderr
        assert not [line for line in said(done.stdout) if "does nothing" in line]
        found.append(returned(done.stdout))
    late, early = found
    if model == "structure":  # a column is upright in space, not on its base, if this turns after initialization
        assert late[0][0] == pytest.approx(1e-3, rel=1e-3)
        assert late[1][0] == pytest.approx(1e-4, rel=1e-3)
        assert late[1:] == early[1:]
    else:
        assert late[0][1] != late[1][1]
        assert early[0] == early[1]


@pytest.mark.long
def test_the_warning_of_a_base_at_rest_looks_at_the_base(fmu: tuple[str, Path]) -> None:
    model, file = fmu
    mass = ALONG[model]
    lines, _ = heard(file, "horizontal", {}, mass, mass | {"base.jx": 0.3})
    assert ["does nothing" in lines[0], "base never moved" in lines[1]] == [True, True], lines
    lines, _ = heard(file, "horizontal", {}, mass, mass | PUSH)
    assert lines == []
    lines, _ = heard(file, "acceleration", {}, mass | PUSH, {})
    assert ["does nothing" in lines[0], "acceleration was zero" in lines[1]] == [True, True], lines
    lines, _ = heard(file, "acceleration", {}, {"base.jx": 1e-9}, {})
    assert lines == []


@pytest.mark.long
@pytest.mark.parametrize("options", [(), LINUX], ids=["python", "native"])
def test_a_record_moves_the_base_from_its_first_sample_that_is_not_zero(
    options: tuple[str, ...], tmp_path: Path
) -> None:
    """Check that a run of 4 ms ends before the record begins, or not; scaled by 0 it never does."""
    if options:
        pytest.importorskip("ziglang", reason="needs the extra native")
    Motion.from_samples(1e-3, [0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0]).to_csv(tmp_path / "late.csv")
    file = stack_file(tmp_path, 1)
    fmu = Fmus.build(file, tmp_path / "late.fmu", "--record", tmp_path / "late.csv", *options)
    for count, scale, moves in ((4, 1.0, False), (5, 1.0, True), (5, 0.0, False)):
        done = ended(driven.run, fmu, {"base.record_scale": scale}, [{}] * count)
        assert done.returncode == 0, done.stderr
        assert any("acceleration was zero" in line for line in said(done.stdout)) != moves


@pytest.mark.parametrize(
    "options", [pytest.param((), id="python"), pytest.param(LINUX, id="native", marks=pytest.mark.long)]
)
def test_a_record_that_has_ended_before_the_run_does_not_move_the_base(
    options: tuple[str, ...], tmp_path: Path
) -> None:
    if options:
        pytest.importorskip("ziglang", reason="needs the extra native")
    (tmp_path / "over.csv").write_text("time,base.ax\n-0.01,0\n-0.005,0.5\n0,0\n")
    fmu = Fmus.build(stack_file(tmp_path, 1), tmp_path / "over.fmu", "--record", tmp_path / "over.csv", *options)
    done = ended(driven.run, fmu, {}, [{}] * 3)
    assert done.returncode == 0, done.stderr
    assert any("acceleration was zero" in line for line in said(done.stdout))


def test_inputs_that_do_nothing() -> None:
    assert idle("body", "base.ax") is Idle.EVER
    assert idle("body", "base.theta_x") is Idle.LATER
    assert idle("horizontal", "base.jy") is Idle.EVER
    assert idle("acceleration", "body2.Mxx") is Idle.EVER
    acting = [("body", "body.F0x"), ("body", "port[1].Fx"), ("horizontal", "base.theta"), ("horizontal", "base.az")]
    assert not any(idle(*one) for one in [*acting, ("acceleration", "base.ax"), ("acceleration", "port[1].Fx")])
    assert idle("horizontal", "body.Mzz") is Idle.EVER
    assert not any(idle("horizontal", f"body.{name}") for name in ("F0x", "F0y", "Mxx", "Mxt", "M", "Mxry"))
