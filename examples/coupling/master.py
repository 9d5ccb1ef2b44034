"""Masters for a column on a partner, with FMPy: copy this file.

`run` is any master: it reads every output once a step, sets every input once, and steps the FMUs in any order. What
each says follows from its state alone: R0 and m of the column, force F0 and mass M of the partner (`BY_STATE`).

`couple` asks for more, outputs read again after inputs were set: R0 and m one way, acceleration and slope the other;
the same made again with the state rolled back until both agree at the end of the step (iterations > 0); or, to see why
not, the plain reaction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

SPLIT = ("R0x", "R0z", "R0m", "mxx", "mxz", "mxt", "mzz", "mzt", "mtt")
PLAIN = {"R0x": "Fx", "R0z": "Fz", "R0m": "My"}
MOTION = ("ax", "az", "jx", "jz", "theta", "omega", "alpha")
AXES = ("ax", "az", "alpha")
TOO_FAR = 100.0  # m or whatever is watched first: the run is given up


BODY = ("F0x", "F0z", "F0m", "Mxx", "Mxz", "Mxt", "Mzz", "Mzt", "Mtt")
Wire = tuple[str, str, str, str]  # output of one FMU, input of another: names of FMU and variable


def by_state(column: Fmu, partner: Fmu, names: tuple[str, str] = ("column", "partner")) -> list[Wire]:
    """Exchange the states of a column and the body under it; names: of both in `run`.

    A body that has no vertical motion of its own hands that of the ground on to the column, as it is set.
    """
    one, other = names
    split = [name for name in SPLIT if f"column.{name}" in partner.variables]
    body = [name for name in BODY if f"body.{name}" in partner.variables]
    rides = "body.F0z" not in partner.variables and "ground.az" in partner.variables
    return [
        *((one, f"base.{name}", other, f"column.{name}") for name in split),
        *((other, f"body.{name}", one, f"body.{name}") for name in body),
        *((other, f"ground.{name}", one, f"base.{name}") for name in ("az", "jz") if rides),
    ]


def handed_over(
    fmus: Mapping[str, Fmu], wires: list[Wire], outside: Mapping[tuple[str, str], float] | None = None
) -> dict[tuple[str, str], float]:
    """Return the inputs by FMU and variable: from outside, and what the wires bring, before any of them is set.

    A wire may begin at an input, whose value of now it brings.
    """
    outside = outside or {}
    read = {(source, start): fmus[source].get(start)[0] for source, start, _, _ in wires}
    given = {(target, name): read[source, start] for source, start, target, name in wires} | {**outside}
    now = {wire[2:]: given[wire[:2]] for wire in wires if wire[:2] in given}
    return given | now | {**outside}


def run(
    fmus: Mapping[str, Fmu],
    wires: list[Wire],
    h: float,
    stop: float,
    watch: list[tuple[str, str]],
    shake: Callable[[float], dict[tuple[str, str], float]] | None = None,
) -> np.ndarray:
    """Lead FMUs through steps of h s; rows of time and what is watched (FMU, variable), from t = 0.

    shake: inputs from outside by FMU and variable, from time t on.
    """
    count, rows = round(stop / h), []
    for k in range(count + 1):
        t = k * h
        given = handed_over(fmus, wires, shake(t) if shake and k < count else None)
        rows.append([t, *(fmus[part].get(name)[0] for part, name in watch)])
        if k == count:
            break
        for (part, name), value in given.items():
            fmus[part].set(**{name: value})
        for fmu in fmus.values():
            fmu.step(t, h)
    return np.array(rows)


class Fmu:
    """An FMU by the names of its variables."""

    def __init__(self, path: Any, **parameters: Any) -> None:
        description = read_model_description(str(path))
        self.variables = {variable.name: variable for variable in description.modelVariables}
        self.folder = TemporaryDirectory()
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=extract(str(path), unzipdir=self.folder.name),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=description.modelName,
        )
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0.0)
        for name, value in parameters.items():
            variable = self.variables[name]
            if variable.type == "Real":
                self.slave.setReal([variable.valueReference], [value])
            else:
                self.slave.setString([variable.valueReference], [value])
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def references(self, names: list[str]) -> list[int]:
        return [self.variables[name].valueReference for name in names]

    def get(self, *names: str) -> list[float]:
        values: list[float] = self.slave.getReal(self.references(list(names)))
        return values

    def set(self, **values: float) -> None:
        self.slave.setReal(self.references(list(values)), list(values.values()))

    def step(self, t: float, h: float) -> None:
        self.slave.doStep(currentCommunicationPoint=t, communicationStepSize=h)

    def close(self) -> None:
        self.slave.terminate()
        self.slave.freeInstance()
        self.folder.cleanup()


class Run(dict[str, Any]):
    """Histories by name, from t = 0; diverged: s, or None.

    work_given, work_taken: J through the interface, by the partner's forces and by the column's.
    """


def couple(
    column: Fmu,
    partner: Fmu,
    ground: Callable[[float], float],
    h: float,
    stop: float,
    iterations: int = 0,
    plain: bool = False,
    watch: tuple[str, ...] = ("block[1].ux",),
    watch_partner: tuple[str, ...] = ("x",),
) -> Run:
    """Lead both through steps of h s under a horizontal ground acceleration ground(t), m/s2.

    plain: the partner takes the reaction as it was under the last acceleration, and no mass; set its slope to "held".
    iterations: how often a step is made again with the acceleration found at its end; the partner's slope: "given".
    """
    known = [name for name in SPLIT if f"column.{name}" in partner.variables and (not plain or name in PLAIN)]
    given = [f"base.{PLAIN[name] if plain else name}" for name in known]
    taken = [f"base.{name}" for name in MOTION if f"base.{name}" in partner.variables]
    axes = [axis for axis in AXES if f"given.{axis}" in partner.variables]
    into_partner = partner.references([f"column.{name}" for name in known])
    out_of_column = column.references(given)
    out_of_partner, into_column = partner.references(taken), column.references(taken)
    given_slopes = partner.references([f"given.{axis}" for axis in axes])
    accelerations = partner.references([f"base.{axis}" for axis in axes])

    def exchange() -> None:
        """Exchange reaction to the partner, motion to the column: one pass, for R0 and m do not depend on the
        acceleration.
        """
        partner.slave.setReal(into_partner, column.slave.getReal(out_of_column))
        column.slave.setReal(into_column, partner.slave.getReal(out_of_partner))

    def shake(t: float) -> None:
        partner.set(**{"ground.ax": ground(t), "ground.jx": (ground(t + h) - ground(t)) / h})

    def power() -> float:
        return -sum(f * v for f, v in zip(column.get(*forces), partner.get(*velocities), strict=True))

    velocities = [name for name in ("base.vx", "base.vz", "base.omega") if name in partner.variables]
    forces = [{"base.vx": "base.Fx", "base.vz": "base.Fz", "base.omega": "base.My"}[name] for name in velocities]
    count = round(stop / h)
    rows = []
    slopes = [0.0] * len(axes)
    work_taken = 0.0
    diverged = None
    for k in range(count + 1):
        t = k * h
        shake(t)
        if k:
            partner.slave.setReal(given_slopes, slopes)
        exchange()
        rows.append([t, *column.get(*watch), *partner.get(*watch_partner)])
        if not abs(rows[-1][1]) < TOO_FAR:
            diverged = t
            break
        if k == count:
            break
        work_taken += 0.5 * h * power()
        if iterations:
            states = column.slave.getFMUState(), partner.slave.getFMUState()
            start = partner.slave.getReal(accelerations)
        try:
            for again in range(iterations + 1):
                column.step(t, h)
                partner.step(t, h)
                if again == iterations:
                    break
                shake(t + h)
                partner.slave.setReal(into_partner, column.slave.getReal(out_of_column))
                end = partner.slave.getReal(accelerations)
                slopes = [(later - now) / h for later, now in zip(end, start, strict=True)]
                column.slave.setFMUState(states[0])
                partner.slave.setFMUState(states[1])
                shake(t)
                partner.slave.setReal(given_slopes, slopes)
                exchange()
        except Exception:  # FMPy's, when an FMU cannot follow what has diverged
            diverged = t
            break
        finally:
            if iterations:
                column.slave.freeFMUState(states[0])
                partner.slave.freeFMUState(states[1])
        # at the end of the step, under the motion of the step, before the next inputs are set
        work_taken += 0.5 * h * power()
    table = np.array(rows)
    names = ("time", *watch, *watch_partner)
    return Run(
        zip(names, table.T, strict=True), work_given=partner.get("work")[0], work_taken=work_taken, diverged=diverged
    )
