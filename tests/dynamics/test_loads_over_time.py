"""Loads on columns as motions: closed forms, momentum, energy, the same column in space, convergence, sliding."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.off_axis import leaning
from support.probe import PHOCAS_STIFFNESS, G, monolith, phocas
from support.structures import with_law

from multiblock import Block, Column, InputError, Joint, Load, Motion, Response, Settings, Structure, simulate, wavelets
from solver.ground.loads import COMPONENTS
from solver.models.ports import Port

STILL = Motion.from_samples(1.0, np.zeros(3))
TOP = Port("top", 0, (0.0, 0.5 * 4.69))
MASS, HEIGHT, WIDTH = 81000.0, 14.07, 1.56  # of Phocas as one block
FOOT_TO_TOP = Port("top", 0, (0.0, 0.5 * HEIGHT))


def ported(column: Column, *ports: Port) -> Column:
    return replace(column, ports=ports or (TOP,))


def test_a_slow_force_turns_a_block_on_its_joint_as_in_closed_form() -> None:
    """Compare with the moment over the rotation of the joint in full contact, less what the weight takes."""
    column = ported(monolith(eta=5e-2, tolerance=1e-8), FOOT_TO_TOP)
    force = 2e3
    settled = MASS * G / (PHOCAS_STIFFNESS * WIDTH**2)
    # the compressed joint is shortened along its mean normal
    turning = PHOCAS_STIFFNESS * WIDTH**4 / 12.0 + 0.25 * MASS * G * settled - MASS * G * 0.5 * HEIGHT
    push = Load.of([0.0, 5.0, 20.0], Fx=[0.0, force, force])
    found = simulate(column, STILL, 20.0, loads={"top": push}, settle=0.0)
    exact = force * (HEIGHT - 0.5 * settled) / turning
    assert found.ry[-1, 0] == pytest.approx(exact, rel=1e-6)
    assert found.base_Fx[-1] == pytest.approx(force, rel=1e-6)
    assert found.base_My[-1] == pytest.approx(force * HEIGHT + MASS * G * exact * 0.5 * HEIGHT, rel=1e-4)
    turn = simulate(column, STILL, 20.0, loads={"top": Load.of([0.0, 5.0, 20.0], My=[0.0, 1e4, 1e4])}, settle=0.0)
    assert turn.ry[-1, 0] == pytest.approx(1e4 / turning, rel=1e-6)
    assert turn.base_Fx[-1] == pytest.approx(0.0, abs=1e-3)


def test_a_blow_gives_the_momentum_of_rigid_bodies() -> None:
    """Check m v upwards without weight; across, while the joint has hardly moved, the moment about the foot."""
    blow = Load.of([0.0, 1e-4, 2e-4], Fz=[0.0, 8.1e6, 0.0])
    up = simulate(ported(replace(monolith(), g=0.0)), STILL, 0.05, loads={"top": blow}, output_step=1e-3, settle=0.0)
    speed = 8.1e6 * 1e-4 / MASS
    assert up.port_vz[1:, 0] == pytest.approx(np.full(50, speed), rel=1e-9)
    assert up.energy[-1] == pytest.approx(0.5 * MASS * speed**2, rel=1e-9)
    column, sunk = ported(monolith(), FOOT_TO_TOP), -0.5 * MASS * G / (PHOCAS_STIFFNESS * WIDTH**2)
    inertia = MASS * (HEIGHT**2 + WIDTH**2) / 12.0 + MASS * (0.5 * HEIGHT + sunk) ** 2
    errors = []
    for brief in (1.6e-3, 8e-4, 4e-4):
        push = Load.of([0.0, 0.5 * brief, brief], Fx=[0.0, 2e3 / brief, 0.0])
        found = simulate(column, STILL, 2e-3, loads={"top": push}, output_step=0.5 * brief, settle=0.0)
        errors.append(abs(found.port_vx[2, 0] * inertia / (1e3 * (HEIGHT + sunk) ** 2) - 1.0))
    assert errors[2] < 2e-5  # measured 1.1e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)  # the joint acts for the square of the time
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize("ends", [1.5, 1.2, 2.5])  # s: within the motion of 2 s, before the run ends, after the motion
def test_a_row_at_a_jump_has_the_load_before_it(ends: float) -> None:
    """Let a damped column come to rest under a force, which its base bears until the force ends."""
    load = Load.of([0.0, ends], Fx=[2e3, 2e3])
    column = ported(monolith(eta=5e-2))
    found = simulate(column, STILL, max(ends, 1.5), loads={"top": load}, output_step=0.1, settle=0.0)
    last = round(ends / 0.1)
    assert found.base_Fx[last] == pytest.approx(2e3, rel=1e-2)
    assert abs(found.port_ax[last, 0]) < 1e-2 * found.port_ax[0, 0]
    assert np.max(np.abs(found.base_Fx)) <= found.peaks["base_Fx"][0]


@pytest.mark.parametrize("make", [lambda: phocas(tolerance=1e-9), lambda: leaning(0.0)])
def test_energy_grows_by_the_work_of_the_loads(make: Any) -> None:
    """Integrate the rates of the ports by Simpson's rule, undamped and in full contact."""
    column = ported(make(), TOP, Port("side", 1, (0.78, 0.3)))
    time = np.linspace(0.0, 1.0, 101)
    fx, fz = 4e3 * np.sin(9.0 * time), 6e4 * np.sin(20.0 * time)
    loads = {"top": Load.of(time, Fx=fx), "side": Load.of(time, Fz=fz, Fx=0.5 * fx)}
    column = column.with_settings(tolerance=1e-9)
    found = simulate(column, STILL, 1.0, loads=loads, output_step=1e-4, settle=0.0)
    at = found.time
    power = np.interp(at, time, fx) * (found.port_vx[:, 0] + 0.5 * found.port_vx[:, 1])
    power += np.interp(at, time, fz) * found.port_vz[:, 1]
    work = np.cumsum((power[:-2:2] + 4.0 * power[1::2] + power[2::2]) * (at[1] - at[0]) / 3.0)
    grown = found.energy[2::2] - found.energy[0]
    assert np.max(np.abs(work - grown)) < 1e-6 * np.max(np.abs(grown))


def test_rates_of_a_port_are_those_of_its_place_and_its_peaks_those_of_its_histories() -> None:
    load = Load.from_motion(wavelets.ricker(1.0, 4.0), Fx=2e4, Fz=1e4, My=3e3)
    column = ported(leaning(1e-3), Port("side", 0, (0.78, 1.0)))
    found = simulate(column, STILL, 0.6, loads={"side": load}, output_step=1e-4, tolerance=1e-9, settle=0.0)
    for axis in "xz":
        place, rate, second = (getattr(found, f"port_{name}{axis}")[:, 0] for name in ("", "v", "a"))
        for value, slope in ((place, rate), (rate, second)):
            differences = (value[2:] - value[:-2]) / 2e-4
            assert np.max(np.abs(differences - slope[1:-1])) < 2e-2 * np.max(np.abs(slope))
        for name, values in ((f"port_{axis}", place), (f"port_v{axis}", rate), (f"port_a{axis}", second)):
            assert found.peaks[name][0] == pytest.approx(np.max(np.abs(values)), rel=5e-3)


@pytest.mark.long  # takes seconds
def test_the_same_column_in_space_under_the_same_loads() -> None:
    """Compare in the limit of joints that are rigid along themselves: what is left is a series in the inverse of their
    stiffness there.
    """
    data = phocas(1e-3).to_dict()
    port = {"name": "side", "block": "block2", "at": [0.5, 0.7]}
    time = np.linspace(0.0, 0.4, 21)
    bell = np.sin(8.0 * time) ** 2
    loads = {"side": Load.of(time, Fx=2e4 * bell, Fz=3e4 * bell, My=2e4 * time)}
    options: dict[str, Any] = {"loads": loads, "output_step": 0.02, "settle": 0.0}
    motion = Motion.from_samples(0.1, [0.0, 0.3, -0.3, 0.1, 0.0])
    column = Column.from_dict({**data, "port": [port]})
    structure = Structure.from_dict({"column": data, "port": [port]})
    assert structure.ports == column.in_space().ports

    def places(found: Any) -> np.ndarray:
        return np.stack([found.port_x, found.port_z], axis=-1)[:, 0]

    exact = places(simulate(column, motion, 0.4, tolerance=1e-10, **options))
    laws = [with_law(structure, shear_ratio=ratio, shear_damping=1e-3 / ratio) for ratio in (15.0, 30.0, 60.0)]
    soft, stiff, stiffer = (places(simulate(one, motion, 0.4, tolerance=1e-7, **options)) for one in laws)
    moved = np.max(np.abs(exact - exact[0]), axis=0)
    first, second = 2.0 * stiff - soft, 2.0 * stiffer - stiff
    assert np.all(np.abs(stiffer - exact) < 2e-4 * moved)  # measured 1.1e-4
    assert np.all(np.abs((4.0 * second - first) / 3.0 - exact) < 1e-8 * moved)  # measured 6e-10


def test_the_error_follows_the_tolerance_where_joints_open() -> None:
    """Compare a damped column, which rocks under jumps of the load, with a tolerance of 1e-11."""
    load = Load.of([0.2, 0.5, 0.500001, 0.9], Fx=[3e4, 5e4, -4e4, -2e4])
    column = ported(phocas(1e-3))

    def top(tolerance: float) -> np.ndarray:
        found = simulate(column, STILL, 1.2, loads={"top": load}, tolerance=tolerance, settle=0.0)
        assert found.stats["rocking"] > 0.1
        return found.port_x[:, 0]

    exact = top(1e-11)
    errors = [np.max(np.abs(top(tolerance) - exact)) / np.max(np.abs(exact)) for tolerance in (1e-5, 1e-7, 1e-9)]
    assert errors[0] < 1e-3
    assert errors[1] < 0.1 * errors[0]
    assert errors[2] < 0.1 * errors[1]


@pytest.mark.parametrize("skip", ["implicit", "elastic"])
def test_methods_agree_under_loads(skip: str) -> None:
    """Compare much damping, for which implicit steps are longer, and modes before and after the load."""
    load = Load.of([0.3, 0.4, 0.7], Fx=[0.0, 2e4, 0.0], Fz=[0.0, -5e4, 0.0])
    column = ported(phocas(0.1 if skip == "implicit" else 1e-3))
    motion = wavelets.ricker(0.3, 2.0)
    found = [
        simulate(column, motion, 2.0, loads={"top": load}, tolerance=1e-8, settle=0.0, without=without)
        for without in ((), (skip,))
    ]
    assert found[0].stats[f"{skip}_steps"] > 10
    assert found[1].stats[f"{skip}_steps"] == 0
    size = np.max(np.abs(found[1].port_x))
    assert np.max(np.abs(found[0].port_x - found[1].port_x)) < 1e-6 * size


def test_a_block_that_a_force_makes_slide() -> None:
    """Compare with Coulomb: from rest by half of F / m - mu g times the square of the time."""
    joint = Joint(1e10, 1e-3, friction=0.3)
    column = Column("slab", (Block(0.2, 4.0, 4.0, 8000.0, joint),), Settings(tolerance=1e-8))
    low = Port("low", 0, (0.0, -0.1))
    force = 0.5 * 8000.0 * G
    found = simulate(replace(column, ports=(low,)), STILL, 0.3, loads={"low": {"Fx": force}}, settle=0.0)
    assert found.slip[-1, 0] == pytest.approx(0.5 * 0.2 * G * 0.3**2, rel=1e-4)
    held = simulate(replace(column, ports=(low,)), STILL, 0.3, loads={"low": {"Fx": 0.29 * 8000.0 * G}}, settle=0.0)
    assert held.slip[-1, 0] == 0.0


def test_a_load_that_ends_leaves_the_verdict_to_the_column() -> None:
    column = ported(monolith(eta=1e-3), FOOT_TO_TOP)
    over = MASS * G * 0.5 * WIDTH / HEIGHT  # turns it about its edge
    found = simulate(column, STILL, 5.0, loads={"top": {"Fx": 1.2 * over}})
    assert found.verdict == "overturned"
    assert simulate(column, STILL, 5.0, loads={"top": {"Fx": 0.3 * over}}).verdict == "standing"
    fell = simulate(column, STILL, 8.0, loads={"top": {"Fx": 1.2 * over}}, settle=0.0)
    assert np.all(fell.port_vx[fell.time > fell.overturn_time] == fell.port_vx[-1])


def test_a_column_with_ports_but_no_load_has_the_bits_of_one_without() -> None:
    motion = Motion.harmonic(0.1 * G, 1.0, 3.0)
    one, other = (simulate(column, motion, settle=0.0) for column in (phocas(1e-3), ported(phocas(1e-3))))
    assert np.array_equal(one.ux, other.ux)
    assert one.stats["steps"] == other.stats["steps"]
    for name, peaks in one.peaks.items():
        assert np.array_equal(peaks, other.peaks[name]) or name.startswith("port")
    assert isinstance(other, Response)
    assert "port[top].ax" in other.row_names


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"loads": {"roof": {"Fx": 1.0}}}, "loads = 'roof': must be one of top"),
        ({"loads": {"top": {"Fy": 1.0}}}, r"loads\[top\]: a column in its plane has Fx, Fz, My only"),
        ({"loads": {"top": {"Fx": math.inf}}}, r"loads\[top\].Fx = inf: must be a finite force"),
    ],
)
def test_mistakes_are_one_line(options: dict[str, Any], line: str) -> None:
    with pytest.raises(InputError, match=line):
        simulate(ported(phocas(1e-3)), STILL, **options)


def test_mistakes_of_files() -> None:
    data = ported(phocas(1e-3)).to_dict()
    assert Column.from_dict(data).ports == (TOP,)
    for key, value, line in (
        ("block", "roof", r"port\[1\].block = 'roof': must be one of block1"),
        ("name", "a.b", r"port\[1\].name = 'a.b': must be a word"),
        ("at", [0.0, 1.0, 0.0], r"port\[1\].at = \[0.0, 1.0, 0.0\]: must be \[x, z\] in m"),
        ("where", 1, r"port\[1\].where: unknown key"),
    ):
        with pytest.raises(InputError, match=line):
            Column.from_dict({**data, "port": [{**data["port"][0], key: value}]})
    with pytest.raises(InputError, match=r'port: formulation must be "exact"'):
        simulate(ported(phocas(1e-3)), STILL, formulation="paper")
    with pytest.raises(InputError, match=r"loads\[top\]: there are no ports, must be a table \[\[port\]\]"):
        simulate(phocas(1e-3), STILL, loads={"top": {"Fx": 1.0}})
    assert len(COMPONENTS) == 6
