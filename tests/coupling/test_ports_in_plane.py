"""Ports of columns driven from outside: against `simulate`, as FMUs, and a beam on two columns against one system."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import read_model_description
from scipy.integrate import solve_ivp
from support import beam
from support.child import call
from support.fmus import ROOT, built_once
from support.inside import beams as inside_beams
from support.inside import ports
from support.inside import structures as inside
from support.lagrange import TINY, Array, Reference
from support.loads import generalized, place
from support.shaft import PORTS, SHAFT

from build_fmu import build_fmu, build_native_fmu
from fmu_src.drive import drive_of
from multiblock import Column, Load, Motion, simulate
from solver.ground.loads import IN_PLANE
from solver.kernels.layout import spaces as at
from solver.models.column.outputs import OUTPUTS
from solver.models.column.stepper import Stepper
from solver.models.outputs import places_of

H, DURATION = 0.01, 1.0  # s
NATIVE = bool(importlib.util.find_spec("ziglang")) and sys.platform.startswith("linux")
FILE = SHAFT.format(joint="") + PORTS


def shaft(folder: Path) -> Path:
    file = folder / "shaft.toml"
    file.write_text(FILE, encoding="utf-8")
    return file


def samples() -> dict[str, np.ndarray]:
    """Return samples of some components at the first port, and of the base, every H s."""
    t = H * np.arange(round(DURATION / H) + 1)
    return {"Fx": 6e3 * np.sin(9.0 * t), "Fz": 5e3 * np.sin(7.0 * t), "My": 2e3 * t, "ax": 0.4 * np.sin(11.0 * t)}


def driven(column: Column, given: dict[str, np.ndarray]) -> np.ndarray:
    """Return the rows of a stepper under these samples at its first port, with slopes, every H s."""
    stepper, count = Stepper(column), len(column.ports)
    rows = [stepper.observe(0.0).copy()]
    for k in range(len(given["ax"]) - 1):
        loads = np.zeros((2, 3, count))
        for c, name in enumerate(IN_PLANE):
            loads[0, c, 0], loads[1, c, 0] = given[name][k], (given[name][k + 1] - given[name][k]) / H
        slope = (given["ax"][k + 1] - given["ax"][k]) / H
        stepper.drive(k * H, given["ax"][k], 0.0, slope, 0.0, 0.0, 0.0, 0.0, *loads.ravel())
        stepper.advance(k * H, H)
        rows.append(stepper.observe(k * H + H).copy())
    return np.array(rows)


def test_inputs_of_ports_are_followed_as_simulate_follows_loads(tmp_path: Path) -> None:
    column, given = Column.from_toml(shaft(tmp_path)), samples()
    time = H * np.arange(len(given["Fx"]))
    load = Load.of(time, **{name: given[name] for name in IN_PLANE})
    motion = Motion.from_samples(H, given["ax"])
    one = simulate(column, motion, DURATION, loads={"top": load}, output_step=H, settle=0.0)
    rows, places = driven(column, given), places_of(OUTPUTS, column.sizes)
    for name in ("ux", "Tx", "port_x", "port_vz", "port_ax"):
        apart = np.abs(rows[1:-1, places[name]] - one.rows[1:-1, places[name]])  # in the end the load is gone
        assert np.max(apart) < 1e-9 * np.max(np.abs(one.rows[:, places[name]])), name


def test_variables_of_ports_and_what_they_depend_on(tmp_path: Path) -> None:
    fmu = build_fmu(shaft(tmp_path), tmp_path / "shaft.fmu")
    description = read_model_description(str(fmu))
    variables = {item.name: item for item in description.modelVariables}
    numbers = {name: variables[name].valueReference for name in ("port[1].x", "port[1].az_peak", "port[2].dMy")}
    assert numbers == {"port[1].x": 80001, "port[1].az_peak": 97001, "port[2].dMy": 108002}
    assert "port[1].Fy" not in variables
    direct = {item.variable.name: {one.name for one in item.dependencies} for item in description.outputs}
    loads = {f"port[{p}].{name}" for name in IN_PLANE for p in (1, 2)}
    moving = {"base.ax", "base.az", "base.theta", "base.omega", "base.alpha"}
    assert direct["port[1].ax"] == direct["base.Fx"] == direct["joint[1].T"] == loads | moving
    assert direct["port[1].vx"] == {"base.theta", "base.omega"}
    assert direct["base.R0x"] == loads | {"base.theta", "base.omega"}
    assert direct["joint[1].N"] == set()


def test_a_column_may_have_more_ports_than_blocks(tmp_path: Path) -> None:
    file = tmp_path / "ports.toml"
    block = "[[block]]\nwidth = 1.0\ndepth = 1.0\nheight = 2.0\nmass = 1000.0\n"
    ports = "".join(
        f'[[port]]\nname = "{name}"\nblock = "block1"\nat = [0.0, {z}]\n' for name, z in zip("ab", (0, 1), strict=True)
    )
    file.write_text(f'name = "ports"\n{block}[joint]\nstiffness = 1e9\ndamping = 1e-3\n{ports}', encoding="utf-8")
    description = read_model_description(str(build_fmu(file, tmp_path / "ports.fmu")))
    nominals = {item.name: item.nominal for item in description.modelVariables}
    assert nominals["port[1].x"] == nominals["port[2].x"] == "0.002"  # m, of 2 m


@pytest.mark.long  # takes seconds
def test_an_fmu_has_the_bits_of_the_solver(tmp_path: Path) -> None:
    file, given = shaft(tmp_path), samples()
    inputs = {f"port[1].{name}": given[name].tolist() for name in IN_PLANE} | {"base.ax": given["ax"].tolist()}
    slopes = {f"port[1].{name}": f"port[1].d{name}" for name in IN_PLANE} | {"base.ax": "base.jx"}
    fmus = [build_fmu(file, tmp_path / "one.fmu", reference=True)]
    rows = driven(Column.from_toml(file), given)[1:]
    if NATIVE:
        fmus.append(build_native_fmu(file, tmp_path / "two.fmu", platforms=["linux64"]))
    found = []
    for fmu in fmus:
        call(inside.follow_inputs, fmu, json.loads(json.dumps(inputs)), slopes, H, tmp_path / "out.npy")
        found.append(np.load(tmp_path / "out.npy"))
        assert np.array_equal(found[-1][:, : rows.shape[1]], rows)
    assert np.array_equal(found[0], found[-1])  # peaks too


@pytest.fixture(scope="module")
def native_shaft(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the FMU without Python, for Linux."""
    if not NATIVE:
        pytest.skip("needs the extra native")
    file = shaft(tmp_path_factory.mktemp("shaft"))
    return built_once(tmp_path_factory, "shaft.fmu", lambda path: build_native_fmu(file, path, platforms=["linux64"]))


@pytest.mark.long  # builds a native FMU
def test_states_of_the_native_fmu_keep_ports(native_shaft: Path) -> None:
    assert all(call(ports.life, native_shaft).values())


@pytest.mark.long
def test_output_derivatives_of_the_native_fmu_follow_loads(native_shaft: Path) -> None:
    found, differences = np.array(call(ports.derivatives, native_shaft))
    assert np.max(np.abs(found - differences) / np.abs(differences)) < 1e-3  # measured


@pytest.mark.long
@pytest.mark.parametrize("seeds", [{"port[1].Fx": 30.0, "port[2].My": -20.0}, {"port[1].Fz": 10.0, "base.ax": 0.01}])
def test_directional_derivatives_by_loads(native_shaft: Path, seeds: dict[str, float]) -> None:
    found, differences, same = call(ports.by_inputs, native_shaft, seeds)
    size = np.abs(differences) + 1e-9 * np.max(np.abs(differences))
    assert same
    assert np.max(np.abs(np.array(found) - differences) / size) < 1e-6


@pytest.mark.long
def test_ports_on_a_base_that_a_body_drives(tmp_path: Path) -> None:
    """Check that both FMUs have the same bits, and the body feels the loads at once."""
    if not NATIVE:
        pytest.skip("needs the extra native")
    file, drive, rows = shaft(tmp_path), drive_of("body", "parabola", 1), []
    fmus = [build_fmu(file, tmp_path / "one.fmu", drive=drive)]
    fmus.append(build_native_fmu(file, tmp_path / "two.fmu", platforms=["linux64"], drive=drive))
    for fmu in fmus:
        call(ports.follow, fmu, tmp_path / "out.npy")
        rows.append(np.load(tmp_path / "out.npy"))
    assert np.array_equal(*rows)
    seeds = {"port[1].Fx": 30.0, "port[2].My": -20.0}
    found, differences, _ = call(ports.by_inputs, fmus[1], seeds)
    size = np.abs(differences) + 1e-6 * np.max(np.abs(differences))
    print(found, differences)
    assert np.max(np.abs(np.array(found) - differences) / size) < 1e-6


def test_a_body_meets_the_loads_of_the_instant(tmp_path: Path) -> None:
    """Check that (M + m) a = F0 + R0 under the loads as they are, not as their slopes let them be a step later."""
    column, found = Column.from_toml(shaft(tmp_path)), []
    for slope in (0.0, 1e6):
        stepper = Stepper(column)
        stepper.driven_by("body", "line", 1)
        body = 1e3, 0.0, 0.0, 5e4, 0.0, 0.0, 5e4, 0.0, 1e5
        stepper.drive(0.0, *[0.0] * 7, *[0.0] * 12, *body)
        stepper.advance(0.0, H)
        loads = np.zeros((2, 3, 2))
        loads[0, 0, 0], loads[1, 0, 0] = 2e4, slope
        stepper.drive(H, *[0.0] * 7, *loads.ravel(), *body)
        stepper.observe(H)
        found.append(float(stepper.base.ax))
        mass, reaction = np.zeros((3, 3)), stepper.split[:3]
        mass[np.triu_indices(3)] = stepper.split[3:]
        mass = mass + np.triu(mass, 1).T + np.diag([5e4, 5e4, 1e5])
        exact = np.linalg.solve(mass, reaction + np.array([1e3, 0.0, 0.0]))
        assert np.allclose([stepper.base.ax, stepper.base.az, stepper.base.alpha], exact, rtol=1e-9)
    assert found[0] == pytest.approx(found[1], rel=1e-12)
    assert abs(found[0]) > 1e-2


def shafts(damping: float = 1e-3) -> list[Column]:
    """Return two columns of one block, unlike, with a port on top."""
    found = []
    for name, height, stiffness in (("left", 3.0, 2e9), ("right", 2.5, 1.5e9)):
        block = {"height": height, "width": 1.2, "depth": 1.2, "density": 2500.0}
        port = {"name": "top", "block": "block1", "at": [0.1, 0.5 * height]}
        law = {"stiffness": stiffness, "damping": damping}
        data = {"name": name, "joint": law, "block": [block], "port": [port], "solver": {"tolerance": 1e-9}}
        found.append(Column.from_dict(data))
    return found


def on_stepper(column: Column) -> beam.Column:
    stepper, time = Stepper(column), [0.0]
    behind, ports = at.ROW.size(column.n), len(column.ports)

    def see() -> beam.Seen:
        return beam.Seen(*stepper.observe(time[0])[behind:].reshape(3, 2, ports)[:, :, 0].copy())

    def push(force: Array, slope: Array, h: float) -> None:
        loads = np.zeros((2, 3, ports))
        loads[0, :2, 0], loads[1, :2, 0] = force, slope
        stepper.drive(time[0], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, *loads.ravel())
        stepper.advance(time[0], h)
        time[0] += h

    return see, push


def as_one(columns: list[Column], times: Array) -> Array:
    """Return the places of both ports, of the columns by Lagrange's equations and the beam as one system."""
    references = [Reference.of(column) for column in columns]
    partner = beam.thrown()
    rests = [Stepper(column).state.phase for column in columns]
    q0 = [np.concatenate([rest.theta, rest.opening]) for rest in rests]
    still = [np.array(place(column, q, 0)) for column, q in zip(columns, q0, strict=True)]

    def seen(column: Column, q: Array, rate: Array) -> tuple[Array, Array]:
        moved = place(column, q + 1j * TINY * rate, 0)
        return np.array([part.real for part in moved]), np.array([part.imag / TINY for part in moved])

    def rates(_: float, y: Array) -> Array:
        state, parts = y[:6], np.split(y[6:], 4)
        motions = [seen(column, parts[2 * i], parts[2 * i + 1]) for i, column in enumerate(columns)]
        places = np.array([here - rest for (here, _), rest in zip(motions, still, strict=True)])
        velocities = np.array([velocity for _, velocity in motions])
        forces = partner.forces(state, places, velocities)
        found = [partner.rates(state, places, velocities)]
        for i, (column, reference) in enumerate(zip(columns, references, strict=True)):
            q, rate = parts[2 * i], parts[2 * i + 1]
            pushed = reference.forces(q, rate, 0.0, 0.0) + generalized(column, q, np.array([[*forces[i], 0.0]]))
            found += [rate, np.linalg.solve(reference.mass_matrix(q), pushed)]
        return np.concatenate(found)

    start = np.concatenate([partner.state, *(part for q in q0 for part in (q, np.zeros(2)))])
    solved = solve_ivp(rates, (0.0, times[-1]), start, "DOP853", times, rtol=1e-10, atol=1e-13)
    rows = [np.split(y[6:], 4) for y in solved.y.T]
    return np.array([[np.array(place(c, parts[2 * i], 0)) - still[i] for i, c in enumerate(columns)] for parts in rows])


@pytest.mark.long  # the system solved as one takes 10 s
def test_a_beam_on_two_columns_is_one_system_to_second_order(tmp_path: Path) -> None:
    """Check elastic columns in full contact, with one exchange a step."""
    columns, duration = shafts(), 0.2
    exact = as_one(columns, np.linspace(0.0, duration, 101))
    size = np.max(np.abs(exact))
    errors = []
    for h in (5e-4, 2.5e-4, 1.25e-4):
        found = beam.coupled(beam.thrown(), list(map(on_stepper, columns)), h, round(duration / h))
        errors.append(float(np.max(np.abs(found[:: round(2e-3 / h)] - exact))) / size)
    assert errors[0] < 1e-3  # measured 6.9e-4, 1.7e-4, 4.3e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.05)
    files = []
    for column in columns:
        files.append(tmp_path / f"{column.name}.toml")
        files[-1].write_text(toml(column), encoding="utf-8")
    one, other = (build_fmu(file, file.with_suffix(".fmu")) for file in files)
    call(inside_beams.on_two, one, other, 5e-4, 200, tmp_path / "out.npy")
    found = beam.coupled(beam.thrown(), list(map(on_stepper, columns)), 5e-4, 200)
    assert np.array_equal(np.load(tmp_path / "out.npy"), found)


@pytest.mark.long  # builds a native FMU
def test_a_beam_on_two_columns_of_the_example(tmp_path: Path) -> None:
    """Check rocking, with and without Python: one FMU of each sort bears an end."""
    if not NATIVE:
        pytest.skip("needs the extra native")
    file = ROOT / "examples" / "columns" / "portico.toml"
    one = build_fmu(file, tmp_path / "one.fmu")
    other = build_native_fmu(file, tmp_path / "other.fmu", platforms=["linux64"])
    call(inside_beams.on_two, one, other, 5e-4, 400, tmp_path / "out.npy")
    columns = [on_stepper(Column.from_toml(file)) for _ in range(2)]
    found = beam.coupled(beam.thrown(), columns, 5e-4, 400)
    assert np.array_equal(np.load(tmp_path / "out.npy"), found)
    assert 1e-3 < np.max(np.abs(found)) < 0.1


def toml(column: Column) -> str:
    """Return its file."""
    data: dict[str, Any] = column.to_dict()
    block, port, joint = data["block"][0], data["port"][0], data["block"][0]["joint"]
    return (
        f'name = "{data["name"]}"\n[joint]\nstiffness = {joint["stiffness"]}\ndamping = {joint["damping"]}\n'
        f"[solver]\ntolerance = {data['solver']['tolerance']}\n[[block]]\nheight = {block['height']}\n"
        f"width = {block['width']}\ndepth = {block['depth']}\nmass = {column.blocks[0].mass!r}\n"
        f'[[port]]\nname = "{port["name"]}"\nblock = "{port["block"]}"\nat = {port["at"]}\n'
    )
