"""Ports of structures driven from outside: against `simulate` under the same loads, and against ties inside."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import read_model_description
from support.child import call
from support.inside import structures as inside

from build_fmu import build_fmu, build_native_fmu
from fmu_src.references import reference_of
from multiblock import Load, Motion, Structure, simulate
from solver.ground.loads import COMPONENTS
from solver.kernels.layout.spaces import HORIZONTAL
from solver.kernels.structure.layout import INPUT_LOADS
from solver.models.outputs import places_of
from solver.models.structure.driven import Chosen, DrivenStructure, packed
from solver.models.structure.outputs import OUTPUTS

H, DURATION = 0.01, 1.0  # s
PORTS = ({"name": "tops", "block": "left", "at": [0.1, 0.2, 2.0]}, {"name": "other", "block": "right"})
FILE = """
name = "pair"
[joints]
stiffness = 2e9
damping = 1e-3
{blocks}
[solver]
tolerance = 1e-8
"""
BLOCK = """
[[block]]
name = "{name}"
on = "base"
at = [{x}, 0.0]
width = 0.9
depth = 0.9
height = 4.0
density = 2500.0
[[port]]
name = "{port}"
block = "{name}"
at = {at}
"""
TEXT = FILE.format(
    blocks=BLOCK.format(name="left", x=0.0, port="tops", at=[0.1, 0.2, 2.0])
    + BLOCK.format(name="right", x=3.0, port="other", at=[-0.45, 0.0, 1.9])
)


def pair(**ties: Any) -> Structure:
    """Return two columns beside each other, with a port each."""
    return Structure.from_dict({**tomllib.loads(TEXT), **ties})


def samples() -> dict[str, np.ndarray]:
    """Return samples of some components at the first port, and of the base, every H s."""
    t = H * np.arange(round(DURATION / H) + 1)
    return {"Fx": 1e4 * np.sin(9.0 * t), "Fy": 5e3 * np.sin(7.0 * t), "Mz": 2e3 * t, "ax": 0.8 * np.sin(11.0 * t)}


def test_inputs_of_ports_are_followed_as_simulate_follows_loads() -> None:
    """Check values and slopes of the same lines."""
    structure, given = pair(), samples()
    time = H * np.arange(len(given["Fx"]))
    load = Load.of(time, **{name: given[name] for name in ("Fx", "Fy", "Mz")})
    motion = Motion.from_samples(H, given["ax"])
    one = simulate(structure, motion, DURATION, loads={"tops": load}, output_step=H, settle=0.0)
    body, loads = DrivenStructure(structure, packed(structure), Chosen(1e-8)), np.zeros(INPUT_LOADS.size(2))
    see = INPUT_LOADS.see(loads, 2)
    rows = [body.observe(0.0).copy()]
    for k in range(len(time) - 1):
        for name in ("Fx", "Fy", "Mz"):
            getattr(see, name.lower())[0] = given[name][k]
            getattr(see, "d" + name.lower())[0] = (given[name][k + 1] - given[name][k]) / H
        slope = (given["ax"][k + 1] - given["ax"][k]) / H
        body.drive(k * H, given["ax"][k], 0.0, 0.0, slope, 0.0, 0.0, *loads)
        body.advance(k * H, H)
        rows.append(body.observe((k + 1) * H).copy())
    places = places_of(OUTPUTS, structure.sizes)
    for name in ("ux", "uy", "rz", "port_x", "port_vy", "port_ax"):
        apart = np.abs(np.array(rows)[:-1, places[name]] - one.rows[:-1, places[name]])  # at the end the load is gone
        assert np.max(apart) < 1e-11 * np.max(np.abs(one.rows[:, places[name]])), name  # measured 5e-13


def test_variables_of_ports_and_what_they_depend_on(tmp_path: Path) -> None:
    file = tmp_path / "pair.toml"
    file.write_text(TEXT, encoding="utf-8")
    fmu = build_fmu(file, tmp_path / "pair.fmu")
    variables = {item.name: item for item in read_model_description(str(fmu)).modelVariables}
    numbers = {name: variables[name].valueReference for name in ("port[1].x", "port[1].az_peak", "port[2].dMz")}
    assert numbers == {"port[1].x": 80001, "port[1].az_peak": 97001, "port[2].dMz": 109002}
    assert all(reference_of(f"port[1].{name}") == (98 + k) * 1000 + 1 for k, name in enumerate(COMPONENTS))
    direct = {item.variable.name: item.dependencies for item in read_model_description(str(fmu)).outputs}
    follows = {item.name for item in direct["port[1].ax"]}
    assert follows == {"base.ax", *(f"port[1].{name}" for name in COMPONENTS)}
    assert direct["port[1].vx"] == direct["block[1].ux"] == []


@pytest.mark.long  # builds both kinds of FMU
def test_both_kinds_of_fmu_have_the_bits_of_the_solver(tmp_path: Path) -> None:
    pytest.importorskip("ziglang", reason="needs the extra native")
    file = tmp_path / "pair.toml"
    file.write_text(TEXT, encoding="utf-8")
    given = samples()
    inputs = {f"port[1].{name}": given[name].tolist() for name in ("Fx", "Fy", "Mz")} | {
        "base.ax": given["ax"].tolist()
    }
    slopes = {f"port[1].{name}": f"port[1].d{name}" for name in ("Fx", "Fy", "Mz")} | {"base.ax": "base.jx"}
    found = []
    for fmu in (
        build_fmu(file, tmp_path / "one.fmu"),
        build_native_fmu(file, tmp_path / "two.fmu", platforms=["linux64"]),
    ):
        call(inside.follow_inputs, fmu, json.loads(json.dumps(inputs)), slopes, H, tmp_path / "out.npy")
        found.append(np.load(tmp_path / "out.npy"))
    assert np.array_equal(*found)
    assert np.max(np.abs(found[0])) > 0.0


def test_a_damper_between_two_ports_is_one_between_two_points() -> None:
    """Compare a partner that gives equal and opposite forces along x with a tie that only damps: second order.

    In full contact: rocking columns amplify all differences.
    """
    damping, motion = 2e5, Motion.from_samples(H, 0.4 * np.sin(9.0 * H * np.arange(101)))
    tie = {"between": ["left", "right"], "from": [0.45, 0.0, 0.9], "to": [-0.45, 0.0, 1.4]}
    law = {"stiffness": 1e-6, "damping": damping, "tension_only": False}
    ports = [{**PORTS[0], "at": tie["from"]}, {**PORTS[1], "at": tie["to"]}]
    left, right = tomllib.loads(TEXT)["block"]
    blocks = [left, {**right, "height": 3.0}]
    one = simulate(pair(block=blocks, port=ports, tie=[{**tie, **law}]), motion, output_step=0.02, settle=0.0)
    structure = pair(block=blocks, port=ports)
    soft = simulate(structure, motion, output_step=0.02, settle=0.0)
    places = places_of(OUTPUTS, structure.sizes)
    errors = []
    for h in (4e-4, 2e-4):
        body = DrivenStructure(structure, packed(structure), Chosen(1e-8))
        loads, rows = np.zeros(INPUT_LOADS.size(2)), []
        see = INPUT_LOADS.see(loads, 2)
        for k in range(round(1.0 / h)):
            t, row = k * h, body.observe(k * h)
            if k % round(0.02 / h) == 0:
                rows.append(row[places["ux"]].copy())
            (v1, v2), (a1, a2) = row[places["port_vx"]], row[places["port_ax"]]
            see.fx[:] = damping * (v2 - v1), damping * (v1 - v2)
            see.dfx[:] = damping * (a2 - a1), damping * (a1 - a2)
            ax, then = np.interp([t, t + h], motion.time, motion.ax)
            body.drive(t, ax, 0.0, 0.0, (then - ax) / h, 0.0, 0.0, *loads)
            body.advance(t, h)
        errors.append(np.max(np.abs(np.array(rows) - one.ux[:-1])))
    assert np.max(np.abs(soft.ux - one.ux)) > 0.1 * np.max(np.abs(one.ux))  # the damper acts
    assert errors[1] < 3e-6 * np.max(np.abs(one.ux))  # measured 9e-7
    assert errors[0] > 2.0 * errors[1]  # measured 2.8, near the solver's own error


def test_ports_beside_a_base_that_a_body_drives() -> None:
    """Check that inputs of ports stand before those of bodies: without loads the same bits as without ports."""
    found = []
    for structure in (pair(), pair(port=[])):
        body = DrivenStructure(structure, packed(structure), Chosen(1e-6, drive=HORIZONTAL))
        loads = np.zeros(INPUT_LOADS.size(len(structure.ports)))
        for k in range(20):
            body.drive(k * H, *[0.0] * 6, *loads, 4e4 * np.sin(9.0 * k * H), 1e4, 0.0, 5e4)
            body.advance(k * H, H)
        found.append(body.observe(20 * H)[: 6 * structure.n].copy())
    assert np.array_equal(found[0], found[1])
    assert np.max(np.abs(found[0])) > 1e-6
