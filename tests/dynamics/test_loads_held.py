"""Columns at rest under loads: let go, pushed by a pattern, in commands and studies."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.off_axis import leaning
from support.probe import PHOCAS_STIFFNESS, G, monolith, phocas

from multiblock import (
    Column,
    InputError,
    Load,
    Motion,
    Study,
    capacity_curve,
    natural_frequencies,
    run_study,
    simulate,
    simulate_many,
)
from solver.commands.command_line import main
from solver.models.ports import Port
from solver.studies.motions import Shaking

STILL = Motion.from_samples(1.0, np.zeros(3))
MASS, HEIGHT, WIDTH = 81000.0, 14.07, 1.56  # of Phocas as one block
TOP, MIDDLE = Port("top", 0, (0.0, 0.5 * HEIGHT)), Port("top", 0, (0.0, 0.0))
ROOT = Path(__file__).parents[2]


def block(eta: float = 1e-3, port: Port = TOP, **settings: Any) -> Column:
    return replace(monolith(eta=eta, **settings), ports=(port,))


@pytest.mark.parametrize("make", [lambda eta: phocas(eta, tolerance=1e-9), leaning])
def test_released_it_swings_from_where_a_slow_load_held_it(make: Any) -> None:
    """Rest under the load is where much damping ends; undamped it keeps the energy of that place."""
    port = Port("side", 0, (0.5, 1.0))
    loads = {"Fx": 1.5e3, "Fz": -2e4, "My": 3e3}
    slow = Load.of([0.0, 2.0, 12.0], **{name: [0.0, force, force] for name, force in loads.items()})
    damped = replace(make(0.1), ports=(port,)).with_settings(tolerance=1e-9)
    held = simulate(damped, STILL, 12.0, loads={"side": slow}, settle=0.0)
    free = replace(make(0.0), ports=(port,)).with_settings(tolerance=1e-9)
    found = simulate(free, STILL, 1.0, release={"side": loads}, settle=0.0)
    assert found.port_x[0] == pytest.approx(held.port_x[-2], rel=1e-7)
    assert found.port_z[0] == pytest.approx(held.port_z[-2], rel=1e-7)
    assert np.all(found.port_vx[0] == 0.0)
    assert np.ptp(found.energy) < 1e-6 * found.energy[0]


def test_released_a_block_swings_at_its_frequency() -> None:
    column = block(0.0, tolerance=1e-9)
    period = 1.0 / float(natural_frequencies(column)[0])
    found = simulate(column, STILL, 1.0, release={"top": {"Fx": 2e3}}, output_step=1e-3, settle=0.0)
    wave = found.port_x[0, 0] * np.cos(2.0 * np.pi * found.time / period)
    assert np.max(np.abs(found.port_x[:, 0] - wave)) < 1e-4 * found.port_x[0, 0]


def test_what_cannot_be_held_is_said_in_one_line() -> None:
    most = 1000.0 * capacity_curve(block(), pattern={"top.Fx": 1000.0}).largest_acceleration
    for force in (1.001 * most, 1e9):
        with pytest.raises(InputError, match="has no rest under this load"):
            simulate(block(), STILL, release={"top": {"Fx": force}})
    simulate(block(), STILL, 0.1, release={"top": {"Fx": 0.99 * most}}, settle=0.0)
    with pytest.raises(InputError, match="release: Fy: a column in its plane has Fx, Fz, My only"):
        simulate(block(), STILL, release={"top": {"Fy": 1.0}})
    slippery = block(port=Port("top", 0, (0.0, -0.5 * HEIGHT)))
    slippery = replace(
        slippery, blocks=tuple(replace(one, joint=replace(one.joint, friction=0.3)) for one in slippery.blocks)
    )
    simulate(slippery, STILL, 0.1, release={"top": {"Fx": 0.29 * MASS * G}}, settle=0.0)
    with pytest.raises(InputError, match="joint 1 slides under this load"):
        simulate(slippery, STILL, release={"top": {"Fx": 0.31 * MASS * G}})


def test_a_pattern_pushes_as_the_acceleration_that_it_is() -> None:
    """Compare m at the centroid of each block: the same curve; at the top by its moment about the edge."""
    column = phocas(1e-3)
    ports = tuple(Port(f"p{i}", i, (0.0, 0.0)) for i in range(3))
    one = capacity_curve(column)
    other = capacity_curve(replace(column, ports=ports), pattern={f"p{i}.Fx": 27000.0 for i in range(3)})
    assert other.largest_acceleration == pytest.approx(one.largest_acceleration, rel=1e-7)
    assert other.uplift == pytest.approx(one.uplift, rel=1e-6, nan_ok=True)
    assert other.base_shear[other.strongest] == pytest.approx(one.base_shear[one.strongest], rel=1e-7)
    top = capacity_curve(block(), pattern={"top.Fx": 1000.0})
    leaning_by = MASS * G * 0.5 * HEIGHT / (PHOCAS_STIFFNESS * WIDTH**4 / 12.0)  # of the weight, over the joint's part
    kern = 1e-3 * MASS * G * WIDTH / 6.0 * (1.0 - leaning_by)
    assert top.uplift[0] == pytest.approx(kern / HEIGHT, rel=1e-4)
    assert top.largest_acceleration < 1e-3 * MASS * G * 0.5 * WIDTH / HEIGHT
    away = capacity_curve(block(), -1, pattern={"top.Fx": 1000.0})
    assert away.largest_acceleration == pytest.approx(top.largest_acceleration, rel=1e-9)
    couple = capacity_curve(block(), pattern={"top.My": 1000.0})
    assert couple.uplift[0] == pytest.approx(kern, rel=1e-4)
    for pattern, line in (
        ({"roof.Fx": 1.0}, "pattern = 'roof': must be one of top"),
        ({"top.Fy": 1.0}, "pattern: Fy: a column in its plane has Fx, Fz, My only"),
        ({"top.Fx": 0.0}, "pattern: must have a load that is not zero"),
    ):
        with pytest.raises(InputError, match=line):
            capacity_curve(block(), pattern=pattern)


def test_the_commands_take_loads_of_columns(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, record, load = tmp_path / "column.toml", tmp_path / "still.csv", tmp_path / "push.csv"
    text = (ROOT / "examples" / "columns" / "phocas-damped.toml").read_text(encoding="utf-8")
    file.write_text(text + '\n[[port]]\nname = "top"\nblock = "block1"\nat = [0.0, 2.3]\n', encoding="utf-8")
    record.write_text("time,base.ax\n0,0\n0.3,0\n", encoding="utf-8")
    load.write_text("0,0\n0.3,1000\n", encoding="utf-8")
    options = ["--no-check", "--load", f"top.Fx={load}", "-o", str(tmp_path / "out.csv")]
    assert main(["simulate", str(file), str(record), *options]) == 0
    assert "port[top].ax" in (tmp_path / "out.csv").read_text(encoding="utf-8").splitlines()[0]
    assert main(["simulate", str(file), str(record), "--no-check", "--release", "top.Fx=1000"]) == 0
    assert main(["simulate", str(file), str(record), "--no-check", "--space", "--load", "top.Fx=1000"]) == 0
    assert main(["statics", str(file), "--pattern", "top.Fx=1000", "--plot", str(tmp_path / "curve.png")]) == 0
    assert "times the pattern at most" in capsys.readouterr().out


def test_many_runs_and_a_study_of_loads(tmp_path: Path) -> None:
    motions = [STILL.with_loads({"top": Load.of([0.0, 0.1], Fx=[0.0, k * 1e3])}) for k in (1, 2)]
    table = simulate_many(block(), [*motions, STILL], keep=("peak_top_ux", "peak_port_x", "path"))
    assert table["peak_port_x"].shape == (3, 1)
    assert table["peak_top_ux"][1, 0] == pytest.approx(2.0 * table["peak_top_ux"][0, 0], rel=1e-3)
    (tmp_path / "still.csv").write_text("time,base.ax\n0,0\n0.3,0\n", encoding="utf-8")
    shaking = Shaking.from_table("motion[1]", {"record": "still.csv", "load": {"top.Fx": 1e3}}, tmp_path)
    keep = ("verdict", "peak_ux", "peak_port_x")
    study = Study("push", "sweep", (block(),), (shaking,), grid={"motion.load_scale": (1.0, 2.0)}, keep=keep)
    peaks = run_study(study, tmp_path)["peak_port_x"]
    assert peaks[1] == pytest.approx(2.0 * peaks[0], rel=1e-3)
