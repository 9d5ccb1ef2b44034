"""The column in masters that others wrote: 2 s under a held 0.5 m/s2, steps of 0.01 s."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from fmpy import read_model_description, simulate_fmu

from support.inside.fmi3 import Instance3
from support.instance import Instance, keep_what_is_unpacked_together

OUTPUTS = ("block[1].ux", "joint[1].N")


def alone(fmu: str, outputs: Sequence[str] = OUTPUTS) -> list[float]:
    """Return the displacement of the top block and the force under it, or other outputs, under FMPy."""
    column = Instance(fmu, {"base.ax": 0.5})
    for k in range(200):
        column.step(0.01 * k, 0.01)
    return column.get(*outputs)


def alone3(fmu: str, outputs: Sequence[str]) -> list[float]:
    """Return the same of an FMU of FMI 3.0."""
    column = Instance3(fmu)
    column.set(base__ax=0.5)
    column.initialize()
    for k in range(200):
        column.step(0.01 * k, 0.01)
    return column.get(*outputs)


def libcosim(fmu: str, outputs: Sequence[str] = OUTPUTS) -> list[float]:
    """Return the same under libcosim."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    references = {v.name: v.valueReference for v in read_model_description(fmu).modelVariables}
    execution = CosimExecution.from_step_size(10_000_000)  # ns
    index = execution.add_local_slave(CosimLocalSlave(fmu, "column"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    assert execution.real_initial_value(index, references["base.ax"], 0.5)
    assert execution.simulate_until(2_000_000_000)
    return list(observer.last_real_values(index, [references[name] for name in outputs]))


def ecos(fmu: str, outputs: Sequence[str] = OUTPUTS) -> list[float]:
    """Return the same under Ecos."""
    from ecospy import EcosSimulation, EcosSimulationStructure
    from ecospy.EcosParameterSet import EcosParameterSet

    keep_what_is_unpacked_together()
    structure = EcosSimulationStructure()
    structure.add_model("column", fmu)
    values = EcosParameterSet()
    values.add_real("column::base.ax", 0.5)
    structure.add_parameter_set("initial", values)
    simulation = EcosSimulation(structure=structure, step_size=0.01)
    simulation.init(parameter_set="initial")
    simulation.step(200)
    found = [simulation.get_real(f"column::{name}") for name in outputs]
    simulation.terminate()
    return found


def container(fmu: str) -> list[float]:
    """Return the displacements of the two columns that one FMU contains."""
    result = simulate_fmu(fmu, stop_time=2.0, output_interval=0.01, start_values={"ax": 0.5})
    return [float(value) for value in np.asarray(result)[["damped", "phocas"]][-1].tolist()]


def pyfmi(fmu: str) -> int:
    """Return how many rows 20 s have under PyFMI's own master."""
    from pyfmi import load_fmu

    result = load_fmu(fmu, kind="CS").simulate(final_time=20.0, options={"ncp": 2000})
    return len(result["time"])
