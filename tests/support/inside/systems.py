"""The SSPs of the coupling example in masters that open them, and what these hand over. The example must be in reach.

Each way returns, after every step, the top displacement, the partner's x and the ground acceleration. A folder has the
FMUs and SSPs of examples/coupling/build.py, the SSPs for steps of `step` s.
"""

from __future__ import annotations

import os
import zipfile
from typing import Any
from xml.etree import ElementTree

import numpy as np
from fmpy import read_model_description

from support.instance import keep_what_is_unpacked_together

STEP = 1e-3  # s
SEEN = (("column", "block[1].ux"), ("", "x"), ("ground", "ground.ax"))
CONNECTED = (("column", "base.R0x"), ("", "body.F0x"), ("ground", "ground.ax"))  # FMPy shows connectors alone
NAMES = {"isolator": "isolated", "soil": "on_soil"}
VALUES = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"


def _seen(partner: str, seen: tuple[tuple[str, str], ...] = SEEN) -> list[tuple[str, str]]:
    return [(part or partner, name) for part, name in seen]


def parameters(folder: str, partner: str) -> dict[str, dict[str, float]]:
    """Return what the sets of parameters inside the SSP say."""
    found: dict[str, dict[str, float]] = {}
    with zipfile.ZipFile(f"{folder}/{NAMES[partner]}.ssp") as archive:
        for name in archive.namelist():
            if name.endswith(".ssv"):
                root = ElementTree.fromstring(archive.read(name))
                part = name.removeprefix("resources/").removesuffix(".ssv")
                found[part] = {
                    item.get("name") or "": float(item[0].get("value") or "")
                    for item in root.iter(f"{VALUES}Parameter")
                }
    return found


def at_step(folder: str, other: str, step: float) -> None:
    """Put the FMUs of a folder into another one, with systems of them that exchange every `step` s."""
    from pathlib import Path

    from build import DEFAULT_COLUMN, build_systems

    there = Path(other)
    there.mkdir(parents=True)
    for file in (*Path(folder).glob("*.fmu"), *Path(folder).glob("*.csv")):
        (there / file.name).symlink_to(file)
    fmus = {file.stem: file for file in there.glob("*.fmu")}
    build_systems(there, fmus, DEFAULT_COLUMN, 10.0, True, step)


def path_of(folder: str, partner: str, part: str) -> str:
    """Return the FMU of a component of the system of a partner."""
    return f"{folder}/{'column_on_soil' if (part, partner) == ('column', 'soil') else part}.fmu"


def one_pass(folder: str, partner: str, steps: int, as_fmpy: bool = False, step: float = STEP) -> list[list[float]]:
    """Return what masters do that make all steps, read all outputs once, and set all inputs once.

    as_fmpy: nothing is handed over before the first step, and outputs are shown as they were before inputs were set.
    """
    from master import Fmu
    from ssp import coupled

    fmus = {part: path_of(folder, partner, part) for part in ("ground", "column", partner)}
    given = parameters(folder, partner)
    parts = {part: Fmu(path, **given.get(part, {})) for part, path in fmus.items()}
    connections = coupled(partner, fmus, {}, 1.0, step).connections  # type: ignore[arg-type]

    def hand_over() -> None:
        values = [parts[source].get(start)[0] for source, start, _, _ in connections]
        for (_, _, target, end), value in zip(connections, values, strict=True):
            parts[target].set(**{end: value})

    for _ in () if as_fmpy else parts:
        hand_over()
    rows = []
    for k in range(steps):
        for each in parts.values():
            each.step(k * step, step)
        if not as_fmpy:
            hand_over()
        rows.append([parts[part].get(name)[0] for part, name in _seen(partner, CONNECTED if as_fmpy else SEEN)])
        if as_fmpy:
            hand_over()
    return rows


def strict_master(folder: str, partner: str, steps: int, step: float = STEP) -> list[list[float]]:
    """Run the example's `run` over FMUs that refuse what FMI 2.0 does: an output read between a set and the
    next step.
    """
    from master import Fmu, by_state, run

    class Strict(Fmu):
        touched = False

        def get(self, *names: str) -> list[float]:
            assert not self.touched, f"{names}: read after an input was set"
            return super().get(*names)

        def set(self, **values: float) -> None:
            self.touched = True
            super().set(**values)

        def step(self, t: float, h: float) -> None:
            self.touched = False
            super().step(t, h)

    given = parameters(folder, partner)
    fmus = {
        part: Strict(path_of(folder, partner, part), **given.get(part, {})) for part in ("ground", "column", partner)
    }
    wires = [*of_ground(partner), *by_state(fmus["column"], fmus[partner], ("column", partner))]
    rows = run(fmus, wires, step, steps * step, [("column", "block[1].ux"), (partner, "x")])
    found: list[list[float]] = rows[1:, 1:].tolist()
    return found


def parallel(folder: str, partner: str, steps: int, step: float = STEP) -> list[list[float]]:
    """Run the same where all FMUs make their steps at once, each in a thread of its own."""
    from concurrent.futures import ThreadPoolExecutor

    from master import Fmu, by_state, handed_over

    given = parameters(folder, partner)
    fmus = {part: Fmu(path_of(folder, partner, part), **given.get(part, {})) for part in ("ground", "column", partner)}
    wires = [*of_ground(partner), *by_state(fmus["column"], fmus[partner], ("column", partner))]
    rows = []
    with ThreadPoolExecutor(len(fmus)) as pool:
        for k in range(steps):
            for (part, name), value in handed_over(fmus, wires).items():
                fmus[part].set(**{name: value})
            list(pool.map(lambda each, t=k * step: each.step(t, step), fmus.values()))
            rows.append([fmus["column"].get("block[1].ux")[0], fmus[partner].get("x")[0]])
    return rows


def by_acceleration(folder: str, partner: str, steps: int, step: float = STEP) -> list[list[float]]:
    """Run the old exchange in a host that exchanges once a step: the base moves by the accelerations of the step
    before.
    """
    from master import MOTION, SPLIT, Fmu

    given = parameters(folder, partner)
    fmus = {part: Fmu(f"{folder}/{part}.fmu", **given.get(part, {})) for part in ("ground", partner)}
    fmus["column"] = Fmu(f"{folder}/column.fmu", **{"base.drive": "acceleration"})
    wires = of_ground(partner)
    for one, other, name in (
        *((("column", "base"), (partner, "column"), name) for name in SPLIT),
        *(((partner, "base"), ("column", "base"), name) for name in MOTION),
    ):
        start, end = f"{one[1]}.{name}", f"{other[1]}.{name}"
        if start in fmus[one[0]].variables and end in fmus[other[0]].variables:
            wires.append((one[0], start, other[0], end))
    rows = []
    for k in range(steps):
        values = [fmus[source].get(start)[0] for source, start, _, _ in wires]
        for (_, _, target, end), value in zip(wires, values, strict=True):
            fmus[target].set(**{end: value})
        for each in fmus.values():
            each.step(k * step, step)
        rows.append([fmus["column"].get("block[1].ux")[0], fmus[partner].get("x")[0]])
    return rows


def of_ground(partner: str) -> list[tuple[str, str, str, str]]:
    """Return what the ground says to the partner; a slab hands its vertical motion on to the column (`by_state`)."""
    return [("ground", f"ground.{name}", partner, f"ground.{name}") for name in ("ax", "az", "jx", "jz")]


def sorted_master(folder: str, partner: str, steps: int, step: float = STEP) -> list[list[float]]:
    """Run the example's other master, which exchanges in the order of dependencies, the ground as a component."""
    from master import Fmu, couple

    given = parameters(folder, partner)
    ground = Fmu(f"{folder}/ground.fmu", **given["ground"])
    samples = []
    for k in range(steps + 2):
        samples += ground.get("ground.ax")
        ground.step(k * step, step)
    run = couple(
        Fmu(f"{folder}/column.fmu", **{"base.drive": "acceleration"}),
        Fmu(f"{folder}/{partner}.fmu", **given.get(partner, {})),
        lambda t: samples[round(t / step)],
        step,
        steps * step,
    )
    return np.column_stack([run["block[1].ux"], run["x"], samples[: steps + 1]])[1:].tolist()


def as_one(folder: str, partner: str, steps: int) -> list[list[float]]:
    """Return the top displacement and the partner's x of the same system solved as one, on the ground's own waves."""
    os.environ["MULTIBLOCK_COMPILES"] = "1"  # reference.py has kernels of its own
    from build import DEFAULT_COLUMN, WAVES
    from reference import solve_as_one

    from solver import Column

    waves = np.loadtxt(f"{folder}/{WAVES}", delimiter=",", skiprows=1)
    samples = np.interp(STEP * np.arange(steps + 2), waves[:, 0], waves[:, 1])
    kind, given = ("soil" if partner == "soil" else "linear"), parameters(folder, partner)[partner]
    run = solve_as_one(Column.from_toml(DEFAULT_COLUMN), kind, given, STEP, samples, steps * STEP, STEP)
    return np.column_stack([run["top"], run["x"]])[1:].tolist()


def libcosim(folder: str, partner: str, steps: int, step: float = STEP) -> list[list[float]]:
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    execution = CosimExecution.from_ssp_file(f"{folder}/{NAMES[partner]}.ssp", round(step * 1e9))
    places = {info.name.decode(): info.index for info in execution.slave_infos()}
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    wanted = [(places[part], _reference(folder, part, name)) for part, name in _seen(partner)]
    rows = []
    for _ in range(steps):
        assert execution.step()
        rows.append([observer.last_real_values(place, [reference])[0] for place, reference in wanted])
    return rows


def _reference(folder: str, part: str, name: str) -> int:
    description: Any = read_model_description(f"{folder}/{part}.fmu")
    return next(variable.valueReference for variable in description.modelVariables if variable.name == name)


def ecos(folder: str, partner: str, steps: int, step: float = STEP) -> list[list[float]]:
    from ecospy import EcosSimulation

    keep_what_is_unpacked_together()
    simulation = EcosSimulation(ssp_path=f"{folder}/{NAMES[partner]}.ssp", step_size=step)
    simulation.init(parameter_set="defaults")
    rows = []
    for _ in range(steps):
        simulation.step(1)
        rows.append([simulation.get_real(f"{part}::{name}") for part, name in _seen(partner)])
    simulation.terminate()
    return rows


def fmpy(
    folder: str, partner: str, steps: int, step: float = STEP, seen: tuple[tuple[str, str], ...] = CONNECTED
) -> list[list[float]]:
    """Return CONNECTED, with the sets of parameters handed over: FMPy does not look for them."""
    from types import SimpleNamespace

    from fmpy.ssp.simulation import simulate_ssp

    given = [
        SimpleNamespace(name=f"{part}.{name}", value=value)
        for part, values in parameters(folder, partner).items()
        for name, value in values.items()
    ]
    table = simulate_ssp(
        f"{folder}/{NAMES[partner]}.ssp",
        stop_time=(steps - 0.5) * step,
        step_size=step,
        parameter_set=SimpleNamespace(parameters=given),
    )
    assert {"column.block[1].ux", "column.joint[3].M", f"{partner}.x"} <= set(table.dtype.names)  # for a look
    return np.column_stack([table[f"{part}.{name}"] for part, name in _seen(partner, seen)]).tolist()
