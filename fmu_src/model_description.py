"""From the table of variables to the XML of an FMI 2.0 model description."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

from solver.column import Column
from solver.motion import STANDARD_GRAVITY

from .variables import ROLES, START_TIME, STEP_SIZE, STOP_TIME, Variable

AUTHOR = "The multiblock-fmu authors"
LICENCE = "MIT"

# unit -> exponents of the base units (FMI 2.0.3 section 2.2.2)
UNITS = {
    "m": {"m": 1},
    "s": {"s": 1},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "rad/s2": {"rad": 1, "s": -2},
    "kg": {"kg": 1},
    "kg.m": {"kg": 1, "m": 1},
    "kg.m2": {"kg": 1, "m": 2},
    "rad/s3": {"rad": 1, "s": -3},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "m/s3": {"m": 1, "s": -3},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "N/m": {"kg": 1, "s": -2},
    "N.s/m": {"kg": 1, "s": -1},
    "N/m3": {"kg": 1, "m": -2, "s": -2},
    "kg/m3": {"kg": 1, "m": -3},
    "Pa": {"kg": 1, "m": -1, "s": -2},
}

# unit -> the unit that engineers read, and how many of it make one
DISPLAY_UNITS = {
    "m": ("mm", 1e3),
    "rad": ("deg", 180.0 / math.pi),
    "kg": ("t", 1e-3),
    "m/s2": ("g", 1.0 / STANDARD_GRAVITY),
    "m/s3": ("g/s", 1.0 / STANDARD_GRAVITY),
    "N": ("kN", 1e-3),
    "N.m": ("kN.m", 1e-3),
    "N/m3": ("MPa/mm", 1e-9),
    "Pa": ("MPa", 1e-6),
}

LOG_CATEGORIES = {
    "logStatusWarning": "What may be a mistake",
    "logStatusDiscard": "Why a step was not made",
    "logStatusError": "Why the slave cannot go on",
    "logStatusFatal": "What the wrapper could not handle",
    "logAll": "Everything else",
}

FLAGS = {
    "needsExecutionTool": False,  # some masters refuse true; Python with numpy and numba is needed all the same
    "canHandleVariableCommunicationStepSize": True,
    "canInterpolateInputs": False,
    "canRunAsynchronuously": False,
    "canBeInstantiatedOnlyOncePerProcess": False,
    "canNotUseMemoryManagementFunctions": True,
    "canGetAndSetFMUstate": True,
    "canSerializeFMUstate": True,
    "providesDirectionalDerivative": False,
}


@dataclass(frozen=True)
class Experiment:
    """What a run lasts and how often it communicates unless a master is told otherwise, s."""

    start: float = START_TIME
    stop: float = STOP_TIME
    step: float = STEP_SIZE


def column_description(column: Column) -> str:
    """One line on what is inside."""
    blocks = "block" if column.n == 1 else "blocks"
    return f"Column of {column.n} rigid {blocks} with no-tension elastic joints under base acceleration"


def model_description(
    name: str,
    guid: str,
    description: str,
    version: str,
    table: list[Variable],
    experiment: Experiment,
    flags: Mapping[str, bool | int] = FLAGS,
    tool: str = "build_fmu.py with PythonFMU",
) -> Element:
    """The root element; `name` is also the model identifier, `flags` are the capabilities, `tool` is what made it.

    Inputs come first, then outputs, then parameters, otherwise as in the table.
    """
    table = sorted(table, key=lambda variable: ROLES.index(variable.causality))
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=name,
        guid=guid,
        description=description,
        version=version,
        author=AUTHOR,
        license=LICENCE,
        generationDateAndTime=date(),
        generationTool=tool,
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    SubElement(root, "CoSimulation", {"modelIdentifier": name, **{key: shown(flag) for key, flag in flags.items()}})
    units = SubElement(root, "UnitDefinitions")
    for unit in sorted({variable.unit for variable in table if variable.unit}):
        exponents = {base: str(power) for base, power in UNITS[unit].items()}
        element = SubElement(units, "Unit", name=unit)
        SubElement(element, "BaseUnit", exponents)
        if unit in DISPLAY_UNITS:
            display, factor = DISPLAY_UNITS[unit]
            SubElement(element, "DisplayUnit", name=display, factor=shown(factor))
    choices = {variable.choice.name: variable.choice for variable in table if variable.choice}
    types = SubElement(root, "TypeDefinitions") if choices else None
    for choice in choices.values():
        assert types is not None
        enumeration = SubElement(SubElement(types, "SimpleType", name=choice.name), "Enumeration")
        for word, number in choice.items.items():
            SubElement(enumeration, "Item", name=word, value=shown(number), description=choice.meanings[word])
    categories = SubElement(root, "LogCategories")
    for category, text in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=category, description=text)
    SubElement(
        root,
        "DefaultExperiment",
        startTime=shown(experiment.start),
        stopTime=shown(experiment.stop),
        stepSize=shown(experiment.step),
    )
    listed = SubElement(root, "ModelVariables")
    for variable in table:
        listed.append(_scalar_variable(variable))
    root.append(_structure(table))
    return root


def _scalar_variable(variable: Variable) -> Element:
    """One ScalarVariable; parameters start where told, outputs are calculated, inputs have neither."""
    element = Element(
        "ScalarVariable",
        name=variable.name,
        valueReference=str(variable.reference),
        description=variable.description,
        causality=variable.causality,
        variability=variable.variability,
    )
    initial = {"parameter": "exact", "output": "calculated"}.get(variable.causality)
    if initial:
        element.set("initial", initial)
    attributes = {
        "declaredType": variable.choice.name if variable.choice else None,
        "unit": variable.unit or None,
        "displayUnit": DISPLAY_UNITS[variable.unit][0] if variable.unit in DISPLAY_UNITS else None,
        "min": variable.minimum,
        "max": variable.maximum,
        "nominal": variable.nominal,
        "start": variable.start,
    }
    SubElement(element, variable.kind, {key: shown(value) for key, value in attributes.items() if value is not None})
    return element


def _structure(table: list[Variable]) -> Element:
    """Outputs and everything that initialization calculates, which are the same, with what each follows."""
    index = {variable.name: str(k) for k, variable in enumerate(table, start=1)}

    def listed(names: tuple[str, ...]) -> str:
        """Places of variables; the standard wants none twice."""
        return " ".join(index[name] for name in names)

    structure = Element("ModelStructure")
    outputs = SubElement(structure, "Outputs")
    unknowns = SubElement(structure, "InitialUnknowns")
    for variable in table:
        if variable.causality == "output":
            place = index[variable.name]
            SubElement(outputs, "Unknown", index=place, dependencies=listed(variable.depends_on))
            initial = {} if variable.initially is None else {"dependencies": listed(variable.initially)}
            SubElement(unknowns, "Unknown", {"index": place, **initial})
    return structure


def date() -> str:
    """When the FMU was made: now, unless the environment says otherwise as reproducible builds have it."""
    seconds = os.environ.get("SOURCE_DATE_EPOCH")
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(None if seconds is None else int(seconds)))


def shown(value: float | int | bool | str) -> str:
    """A value as XML Schema writes it; every digit of a float64."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return value if isinstance(value, str) else repr(value)
