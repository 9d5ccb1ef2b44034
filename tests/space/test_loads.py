"""Loads on ports: closed forms of a block on its bed, free flight, rest under a load that is let go, and mistakes."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from multiblock import (
    Column,
    InputError,
    InputWarning,
    Load,
    Motion,
    Structure,
    Study,
    push_over,
    run_study,
    simulate,
    simulate_many,
    wavelets,
)
from solver.commands.command_line import main
from solver.ground.loads import COMPONENTS, load_from_file, on_one_grid
from solver.studies.motions import Shaking

MASS, SIDE, STIFFNESS, RATIO, G = 2500.0, 1.0, 1e9, 0.4, 9.80665
STILL = Motion.from_samples(1.0, np.zeros(3))
ROOT = Path(__file__).parents[2]


def block(g: float = G, at: tuple[float, float, float] = (0.0, 0.0, 0.5), **joint: float) -> Structure:
    """Return a cube of 1 m on its bed, with a port."""
    return Structure.from_dict(
        {
            "name": "cube",
            "g": g,
            "joints": {"stiffness": STIFFNESS, "damping": 1e-3, **joint},
            "block": [{"name": "cube", "width": SIDE, "depth": SIDE, "height": SIDE, "mass": MASS, "on": "base"}],
            "port": [{"name": "top", "block": "cube", "at": list(at)}],
        }
    )


def test_a_slow_force_moves_the_block_on_its_bed_as_in_closed_form() -> None:
    """Compare in full contact: shear of the bed, and its rotation less what the weight and the load add."""
    force = 3000.0
    ramp = Load.of([0.0, 1.0, 2.0], Fx=[0.0, force, force])
    x = simulate(block(), STILL, 2.0, loads={"top": ramp}, output_step=0.1).port_x[-1, 0]
    settlement = MASS * G / STIFFNESS
    turn = force * (SIDE - settlement) / (STIFFNESS / 12.0 - MASS * G * 0.5)
    exact = force / (RATIO * STIFFNESS) + turn
    assert x == pytest.approx(exact, rel=1e-4)  # measured 5e-5: the weight acts across the tilted joint
    y = simulate(block(), STILL, 2.0, loads={"top": Load.of([0.0, 1.0, 2.0], My=[0.0, 1500.0, 1500.0])})
    assert y.ry[-1, 0] == pytest.approx(1500.0 / (STIFFNESS / 12.0 - MASS * G * 0.5), rel=1e-4)


def test_a_blow_gives_a_free_block_its_impulse() -> None:
    """Check that without weight, upwards, m v is the impulse."""
    blow = Load.of([0.0, 1e-3, 2e-3], Fz=[0.0, 2e6, 0.0])
    found = simulate(block(g=0.0), STILL, 0.05, loads={"top": blow}, output_step=1e-3, settle=0.0)
    speed = 2000.0 / MASS
    assert found.velocity[-1, 0, 2] == pytest.approx(speed, rel=1e-9)
    assert found.energy[-1] == pytest.approx(0.5 * MASS * speed**2, rel=1e-9)
    assert found.port_az[1, 0] == pytest.approx(2e6 / MASS)
    assert found.port_z[-1, 0] == pytest.approx(speed * 0.049, rel=1e-9)


def test_rates_of_a_port_are_those_of_its_place() -> None:
    force = wavelets.ricker(1.0, 8.0)
    load = Load.from_motion(force, Fx=2e4, Fy=1e4, Mz=3e3)
    found = simulate(block(at=(0.3, 0.2, 0.5)), STILL, 0.5, loads={"top": load}, output_step=1e-4, tolerance=1e-9)
    for axis in "xyz":
        place, rate, second = (getattr(found, f"port_{name}{axis}")[:, 0] for name in ("", "v", "a"))
        for value, slope in ((place, rate), (rate, second)):
            differences = (value[2:] - value[:-2]) / 2e-4
            assert np.max(np.abs(differences - slope[1:-1])) < 1e-2 * np.max(np.abs(slope))  # measured 6e-3, kinks


def test_released_it_swings_from_the_place_where_the_load_held_it() -> None:
    """Compare at the lowest frequency of the bed, undamped; rest under the load is what a slow load reaches."""
    slow = simulate(block(), STILL, 2.0, loads={"top": Load.of([0.0, 1.0, 2.0], Fx=[0.0, 3e3, 3e3])}, tolerance=1e-8)
    undamped = block(damping=0.0)
    found = simulate(undamped, STILL, 0.4, release={"top": {"Fx": 3e3}}, output_step=1e-4, settle=0.0, tolerance=1e-8)
    x = found.port_x[:, 0]
    assert x[0] == pytest.approx(slow.port_x[-1, 0], rel=1e-9)  # measured 2e-12
    # displacement at the foot and rotation: (k_s, coupling) over (m, I about the centroid)
    shear, bending, h = RATIO * STIFFNESS, STIFFNESS / 12.0, 0.5
    stiff = np.array([[shear, -shear * h], [-shear * h, shear * h * h + bending - MASS * G * h]])
    mass = np.diag([MASS, MASS / 6.0])
    squares, shapes = np.linalg.eig(np.linalg.solve(mass, stiff))
    start = np.linalg.solve(stiff, [3e3, 3e3 * 0.5])
    parts = np.linalg.solve(shapes, start)
    exact = [
        float(np.array([1.0, 0.5]) @ (shapes @ (parts * np.cos(np.sqrt(squares) * t)))) for t in found.time.tolist()
    ]
    assert np.max(np.abs(x - exact)) < 3e-3 * x[0]  # measured 1.7e-3: the weight acts across the tilted joint
    assert np.ptp(found.energy) < 1e-6 * found.energy[0]


def test_a_load_near_the_largest_one_is_held_before_it_is_let_go() -> None:
    """Compare a block that is tipped far with the plane, and one that has slid with the spring that holds it."""
    size = {"height": 2.0, "width": 1.0, "depth": 0.8, "density": 2000.0}
    port = {"name": "top", "block": "block1", "at": [0.5, 1.0]}
    joint = {"stiffness": 1e10, "damping": 5e-5}
    column = Column.from_dict({"name": "tipped", "block": [size], "joint": joint, "port": [port]})
    tipped = {"top": {"Fx": 0.97 * 7562.65}}
    space, plane = (simulate(one, STILL, release=tipped, settle=0.0).contact[0] for one in (column.in_space(), column))
    assert space == pytest.approx(plane, rel=1e-4)  # measured 4e-5, under half of the load 2e-6
    friction, stiffness, force = 1e-3, 1e5, 2000.0
    data = block(at=(0.0, 0.0, 0.0)).to_dict()
    data["joints"] = {"stiffness": 1e10, "damping": 1e-6, "friction": friction}
    ends = {"from": [-0.5, 0.0, 0.0], "to": [-2.5, 0.0, 0.5]}
    data["tie"] = [{"between": ["cube", "base"], "stiffness": stiffness, **ends}]
    held = Structure.from_dict(data)
    moved = simulate(held, STILL, release={"top": {"Fx": force}}, settle=0.0).ux[0, 0]
    assert moved == pytest.approx((force - friction * MASS * G) / stiffness, rel=1e-3)  # measured 2e-4: the joint too


@pytest.mark.parametrize("share", [0.9, 3.0])
def test_friction_holds_a_pretension_up_to_its_limit(share: float) -> None:
    """Check the force that is left of a horizontal tie drawn before the run: all, or what friction bears."""
    limit, data = 0.01 * MASS * G, block().to_dict()
    data["joints"] = {"stiffness": 1e10, "damping": 1e-5, "friction": 0.01}
    ends = {"from": [0.0, 0.0, -0.5], "to": [-3.0, 0.0, 0.0]}
    data["tie"] = [{"between": ["cube", "base"], "stiffness": 1e4, "pretension": share * limit, **ends}]
    left = simulate(Structure.from_dict(data), STILL, settle=0.0).tie[0, 0]
    assert left == pytest.approx(min(1.0, share) * limit, rel=1e-3)  # it was a quarter of the limit


@pytest.mark.parametrize("share", [1.01, 1.02, 1.2])
def test_friction_holds_an_oblique_pretension_up_to_its_limit(share: float) -> None:
    """Draw a tie beside the centroid that begins to slide the block: the first tangents are half of sticking."""
    size = {"width": 1.0, "depth": 1.0, "height": 0.5, "density": 2000.0}
    limit = 0.01 * 1000.0 * G
    ends = {"from": [-0.5, 0.0, 0.0], "to": [-2.0, 1.0, 0.25]}
    data = {
        "name": "drawn",
        "joints": {"stiffness": 1e10, "damping": 1e-3, "friction": 0.01},
        "block": [{"name": "a", "on": "base", **size}],
        "tie": [{"between": ["a", "base"], "stiffness": 1e4, "pretension": share * limit, **ends}],
    }
    left = simulate(Structure.from_dict(data), STILL, settle=0.0).tie[0, 0]
    assert left == pytest.approx(limit, rel=1e-6)  # measured 1e-8


def test_loads_and_base_motion_are_followed_on_one_grid() -> None:
    """Check that base and load both held constant at the same acceleration of the block cancel: m a at the centroid."""
    structure = block(at=(0.0, 0.0, 0.0))
    shaken = wavelets.ricker(1.0, 3.0)
    against = Load.of(shaken.time[::1] + 0.0, Fx=MASS * shaken.ax)
    found = simulate(structure, shaken, loads={"top": against}, settle=0.0)
    alone = simulate(structure, shaken, settle=0.0)
    assert found.peaks["ux"][0] < 1e-9 * alone.peaks["ux"][0]
    # other times of the same straight lines give the same motion; the load ends later than the motion of the base
    time = np.sort(np.concatenate([shaken.time, 0.5 * (shaken.time[1:] + shaken.time[:-1])]))
    finer = Load.of(time, Fx=MASS * np.interp(time, shaken.time, shaken.ax))
    again = simulate(structure, shaken, loads={"top": finer}, settle=0.0)
    assert again.peaks["ux"][0] < 1e-6 * alone.peaks["ux"][0]


def test_the_grid_has_the_instants_of_both_and_loads_begin_and_end_at_once() -> None:
    base = [np.array([0.0, 1.0, 2.0]), *(np.array([0.0, 1.0, 0.0]) for _ in "xyz")]
    load = Load.of([0.5, 2.5], Fz=[4.0, 8.0])
    time, ax, _, _, found = on_one_grid(base, False, {"a": load}, ["b", "a"])
    assert time.tolist() == [0.0, 0.5, 1.0, 2.0, 2.5]
    assert ax.tolist() == [0.0, 0.5, 1.0, 0.0]  # none beyond its end
    table = found.reshape(4, 2, len(COMPONENTS), 2)[:, :, 2, 1]
    assert table.tolist() == [[0.0, 0.0], [4.0, 2.0], [5.0, 2.0], [7.0, 2.0]]
    _, held, *_ = on_one_grid(base, True, {"a": load}, ["a"])
    assert held.tolist() == [0.0, 0.0, 1.0, 0.0]


def test_a_constant_lasts_to_the_end_and_a_fallen_block_is_told() -> None:
    found = simulate(block(), STILL, 2.0, loads={"top": {"Fx": 0.6 * MASS * G}}, settle=0.0)
    assert found.verdict == "overturned"  # at half the height of the edge it would balance 0.5 m g
    assert simulate(block(), STILL, 1.0, loads={"top": {"Fx": 0.1 * MASS * G}}).verdict == "standing"


def test_a_stack_of_a_column_has_ports_too_and_a_load_keeps_it_in_space() -> None:
    data = Column.from_toml(ROOT / "examples" / "columns" / "phocas-damped.toml").to_dict()
    port = {"name": "top", "block": "block1"}
    structure = Structure.from_dict({"column": data, "port": [port]})
    assert Structure.from_dict(structure.to_dict()).ports[0].name == "top"
    found: Any = simulate(structure, STILL, 0.2, loads={"top": {"Fx": 1e4}}, plane="auto", settle=0.0)
    assert found.port_x[-1, 0] > 0.0
    unloaded: Any = simulate(structure, STILL, 0.2, plane="auto", settle=0.0)  # a response in the plane had no ports
    assert unloaded.port_x.shape == (len(unloaded.time), 1)


def test_a_port_without_load_changes_no_bit() -> None:
    structure, motion = block(), Motion.harmonic(2.0, 2.0, 1.0)
    with_port, without = (simulate(one, motion, 1.0) for one in (structure, replace(structure, ports=())))
    assert np.array_equal(with_port.ux, without.ux)
    assert with_port.stats["steps"] == without.stats["steps"]


def test_many_runs_with_loads_go_alone() -> None:
    motions = [STILL.with_loads({"top": Load.of([0.0, 0.1], Fx=[0.0, k * 1e3])}) for k in (1, 2)]
    table = simulate_many(block(), motions, keep=("peak_port_x", "path"))
    assert table["peak_port_x"][1, 0] == pytest.approx(2.0 * table["peak_port_x"][0, 0], rel=1e-2)


@pytest.mark.parametrize(("begin", "end"), [(2.0, 3.0), (-1.0, 0.0)])
def test_a_load_outside_the_run_is_warned_of(begin: float, end: float) -> None:
    line = rf"loads\[top\]: is from {begin:g} to {end:g} s, the run from 0 to 2 s: it has no effect"
    motion = STILL.with_loads({"top": Load.of([begin, end], Fx=[1e3, 1e3])})
    with pytest.warns(InputWarning, match=line):
        simulate(block(), motion)
    with pytest.warns(InputWarning, match=line) as told:
        simulate_many(block(), [motion, motion], keep=("peak_u",))
    assert len(told) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate(block(), STILL.with_loads({"top": Load.of([begin - 0.1, end + 0.1], Fx=[1e3, 1e3])}), 2.05)


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"loads": {"roof": {"Fx": 1.0}}}, "loads = 'roof': must be one of top"),
        ({"loads": {"top": {"F": 1.0}}}, r"loads\[top\] = 'F': must be one of Fx"),
        ({"loads": {"top": {"Fx": math.nan}}}, r"loads\[top\].Fx = nan: must be a finite force"),
        ({"loads": {"top": 1.0}}, r"loads\[top\] = 1.0: must be a Load, or components Fx"),
        ({"release": {"top": {"Fx": 1e9}}}, "no rest under this load"),
        ({"release": {"roof": {"Fx": 1.0}}}, "release = 'roof': must be one of top"),
    ],
)
def test_mistakes_are_one_line(options: dict[str, Any], line: str) -> None:
    with pytest.raises(InputError, match=line):
        simulate(block(), STILL, **options)


def test_mistakes_of_a_load_and_of_a_port() -> None:
    with pytest.raises(InputError, match="must be later than the sample before"):
        Load.of([0.0, 0.0], Fx=[1.0, 1.0])
    with pytest.raises(InputError, match="Fx: has gaps"):
        Load.of([0.0, 1.0], Fx=np.ma.array([1.0, 1.0], mask=[True, False]))
    for step in (0.0, -1.0, math.nan, 2.0):
        with pytest.raises(InputError, match=f"step = {step}: must be a time in s, at most the duration"):
            Load.from_motion(Motion.harmonic(2.0, 1.0, 1.0), step=step, Fz=10.0)
    data = block().to_dict()
    for key, value, line in (
        ("block", "roof", r"port\[1\].block = 'roof': must be one of cube"),
        ("name", "a.b", r"port\[1\].name = 'a.b': must be a word"),
        ("at", [0.0], r"port\[1\].at = \[0.0\]: must be a list of 3 numbers"),
        ("where", 1, r"port\[1\].where: unknown key"),
    ):
        with pytest.raises(InputError, match=line):
            Structure.from_dict({**data, "port": [{**data["port"][0], key: value}]})


def test_formulas_and_files(tmp_path: Path) -> None:
    load = Load.formula(1.0, 0.01, Fx=lambda t: math.sin(3.0 * t))
    assert len(load.time) == 101
    assert load.values[50, 0] == pytest.approx(math.sin(1.5))
    wave = Load.from_motion(Motion.harmonic(2.0, 1.0, 1.0), step=0.25, Fz=10.0)
    assert wave.values[:, 2] == pytest.approx([0.0, 20.0, 0.0, -20.0, 0.0])
    path = tmp_path / "push.csv"
    path.write_text("time,force\n0,0\n1,5e3\n", encoding="utf-8")
    time, values = load_from_file(path)
    assert (time.tolist(), values.tolist()) == ([0.0, 1.0], [0.0, 5e3])


def test_a_pattern_pushes_as_the_acceleration_that_it_is(tmp_path: Path) -> None:
    """Compare m at the centroid: the same path; at the top by its moment about the edge, but for the bed's
    penetration.
    """
    structure = block(at=(0.0, 0.0, 0.0))
    one, other = push_over(structure), push_over(structure, pattern={"top.Fx": MASS})
    assert other.acceleration == pytest.approx(one.acceleration, rel=1e-9, abs=1e-9)
    assert other.uplift == pytest.approx(one.uplift)
    assert other.ends == one.ends
    assert "times the pattern" in str(other)
    for pushed, head in ((one, "acceleration,"), (other, "factor,")):
        pushed.to_csv(tmp_path / "path.csv")
        assert (tmp_path / "path.csv").read_text().startswith(head)
    top = push_over(block(), pattern={"top.Fx": 1000.0})
    assert top.uplift == pytest.approx(1e-3 * MASS * G / 6.0, rel=1e-3)  # the kern; measured 2e-4
    with pytest.raises(InputError, match="pattern = 'roof': must be one of top"):
        push_over(block(), pattern={"roof.Fx": 1.0})


def test_the_command_takes_loads_and_a_pattern(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, record, load = tmp_path / "cube.toml", tmp_path / "still.csv", tmp_path / "push.csv"
    file.write_text(
        'name = "cube"\njoints = { stiffness = 1e9, damping = 1e-3 }\n[[block]]\nname = "cube"\non = "base"\n'
        'width = 1.0\ndepth = 1.0\nheight = 1.0\nmass = 2500.0\n[[port]]\nname = "top"\nblock = "cube"\n',
        encoding="utf-8",
    )
    record.write_text("time,base.ax\n0,0\n0.3,0\n", encoding="utf-8")
    load.write_text("0,0\n0.3,1000\n", encoding="utf-8")
    options = ["--no-check", "--load", f"top.Fx={load}", "-o", str(tmp_path / "out.csv")]
    assert main(["simulate", str(file), str(record), *options]) == 0
    assert "port[top].ax" in (tmp_path / "out.csv").read_text(encoding="utf-8").splitlines()[0]
    assert main(["simulate", str(file), str(record), "--no-check", "--release", "top.Fx=100"]) == 0
    assert main(["statics", str(file), "--pattern", "top.Fx=1000"]) == 0
    assert "times the pattern" in capsys.readouterr().out
    for key in ("direction", "vertical"):
        assert main(["statics", str(file), "--pattern", "top.Fx=1000", f"--{key}", "0.2"]) == 2
        assert f"--{key}: must be left out, --pattern says along what it is pushed" in capsys.readouterr().err
    assert main(["simulate", str(file), str(record), "--load", "top"]) == 2
    assert "must be PORT.COMPONENT=LOAD" in capsys.readouterr().err
    assert main(["simulate", str(file), str(record), "--load", "top.Fx=1", "--load", "top.Fx=2"]) == 2
    assert "top.Fx=2: top.Fx is given twice, must be given once" in capsys.readouterr().err
    for heading in ("time (ms),Fx (N)", "time [s],Fx [kN]"):
        load.write_text(f"{heading}\n0,0\n0.3,1000\n", encoding="utf-8")
        with pytest.raises(InputError, match=r"push.csv: line 1: .*: must be times in s and loads in N or N m"):
            load_from_file(load)
    load.write_text("time (s),My (N m)\n0,0\n0.3,1000\n", encoding="utf-8")
    assert load_from_file(load)[1].tolist() == [0.0, 1000.0]


def test_a_study_varies_the_scale_of_loads(tmp_path: Path) -> None:
    (tmp_path / "still.csv").write_text("time,base.ax\n0,0\n0.3,0\n", encoding="utf-8")
    table = {"record": "still.csv", "load": {"top.Fx": 1e3}}
    shaking = Shaking.from_table("motion[1]", table, tmp_path)
    keep = ("verdict", "peak_u", "peak_port_x")
    study = Study("push", "sweep", (block(),), (shaking,), grid={"motion.load_scale": (1.0, 2.0)}, keep=keep)
    peaks = run_study(study, tmp_path)["peak_port_x"]
    assert peaks[1] == pytest.approx(2.0 * peaks[0], rel=1e-3)
    (tmp_path / "late.csv").write_text("5,0\n6,1000\n", encoding="utf-8")
    late = Shaking.from_table("motion[1]", {"record": "still.csv", "load": {"top.Fx": "late.csv"}}, tmp_path)
    with pytest.warns(InputWarning, match=r"loads\[top\]: is from 5 to 6 s, the run from 0 to 0.3 s"):
        run_study(Study("late", "sweep", (block(),), (shaking, late), keep=keep))
    none = Shaking.from_table("motion[1]", {"record": "still.csv"}, tmp_path)
    study = Study("push", "sweep", (block(),), (none,), grid={"motion.load_scale": (1.0, 2.0)})
    with pytest.raises(InputError, match=r"motion.load_scale: still has no loads"):
        study.run(0)


def test_a_pattern_has_no_direction() -> None:
    for given in ({"direction": 1.0}, {"vertical": 0.3}):
        with pytest.raises(InputError, match="pattern: must be given without direction and vertical"):
            push_over(block(), pattern={"top.Fx": 1.0}, **given)


def test_a_release_bears_all_of_its_load_or_is_refused() -> None:
    """Press a block with 12 weights and push it: with 83 % of a load above ten weights it rested without a word."""
    size = {"width": 1.0, "depth": 0.8, "height": 2.0, "density": 2000.0}
    data = {"name": "b", "joints": {"stiffness": 1e10, "damping": 5e-5}, "block": [{"name": "b", "on": "base", **size}]}
    pressed = Structure.from_dict({**data, "port": [{"name": "top", "block": "b", "at": [0.0, 0.0, 1.0]}]})
    weight = pressed.weight

    def pushed(share: float) -> float:
        """Return how far a share of the load that tips a rigid block moves it (m)."""
        load = {"top": {"Fz": -12.0 * weight, "Fx": share * 13.0 * weight * 0.25}}
        return float(simulate(pressed, STILL, release=load, settle=0.0).port_x[0, 0])

    with pytest.raises(InputError, match="no rest under this load"):
        pushed(0.9)  # it falls from 0.87 on
    assert pushed(0.86) > 1.2 * pushed(0.8)
