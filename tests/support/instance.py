"""One instance of an FMU by the names of its variables, for scripts that run in a process of their own."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from collections.abc import Mapping
from typing import Any

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave


def called(variable: Any) -> str:
    """Return names in the calls of FMI 2.0 for the kind of a variable."""
    return "Integer" if variable.type == "Enumeration" else str(variable.type)


def temporary_folder() -> str:
    """Return a folder that is there until the process ends."""
    folder = tempfile.mkdtemp(prefix="fmu_")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def unpacked(fmu: str) -> str:
    """Return such a folder with the files of an FMU."""
    return str(extract(fmu, unzipdir=temporary_folder()))


def keep_what_is_unpacked_together() -> None:
    """Keep what masters leave unpacked in a folder that ends with the process."""
    os.environ["TMPDIR"] = temporary_folder()


class Instance:
    """An FMU extracted, instantiated and, unless asked not to, initialized."""

    def __init__(
        self,
        fmu: str,
        values: Mapping[str, Any] | None = None,
        start: float = 0.0,
        initialize: bool = True,
        folder: str | None = None,
        name: str = "column",
        **options: Any,
    ) -> None:
        description = read_model_description(fmu)
        self.variables = {variable.name: variable for variable in description.modelVariables}
        self.fmi = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder or unpacked(fmu),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.fmi.instantiate(**options)
        self.set(values or {})
        if initialize:
            self.initialize(start)

    def initialize(self, start: float = 0.0) -> None:
        self.fmi.setupExperiment(startTime=start)
        self.fmi.enterInitializationMode()
        self.fmi.exitInitializationMode()

    def set(self, values: Mapping[str, Any]) -> None:
        """Set variables; an enumeration by its number or by its word."""
        for name, value in values.items():
            variable = self.variables[name]
            if variable.type == "Enumeration" and isinstance(value, str):
                value = {item.name: int(item.value) for item in variable.declaredType.items}[value]
            getattr(self.fmi, f"set{called(variable)}")([variable.valueReference], [value])

    def get(self, *names: str) -> list[Any]:
        """Return the values of some variables, or of all outputs."""
        names = names or tuple(name for name, item in self.variables.items() if item.causality == "output")
        values = []
        for name in names:
            variable = self.variables[name]
            values += getattr(self.fmi, f"get{called(variable)}")([variable.valueReference])
        return values

    def step(self, t: float, h: float) -> None:
        self.fmi.doStep(currentCommunicationPoint=t, communicationStepSize=h)

    def attempt(self, call: str, *arguments: Any) -> str:
        """Return the result of a call: "ok", or the error that FMPy makes of its status."""
        try:
            getattr(self if hasattr(self, call) else self.fmi, call)(*arguments)
        except Exception as error:
            return str(error)
        return "ok"

    def close(self) -> None:
        self.fmi.terminate()
        self.fmi.freeInstance()
