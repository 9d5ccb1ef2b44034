"""Common parts of the model descriptions of FMI 2.0 and 3.0: all elements before the variables, and their limits."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element, SubElement

from solver.common.files import identifier_of
from solver.ground.motion import STANDARD_GRAVITY

from .variables import ROLES, START_TIME, STEP_SIZE, STOP_TIME, Choice, Variable

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
    "N/s": {"kg": 1, "m": 1, "s": -3},
    "N.m/s": {"kg": 1, "m": 2, "s": -3},
    "J": {"kg": 1, "m": 2, "s": -2},
    "N/m": {"kg": 1, "s": -2},
    "N.s/m": {"kg": 1, "s": -1},
    "N/m3": {"kg": 1, "m": -2, "s": -2},
    "kg/m3": {"kg": 1, "m": -3},
    "Pa": {"kg": 1, "m": -1, "s": -2},
}

# unit -> the unit that engineers read, and the factor to it
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

INITIAL = {"parameter": "exact", "output": "calculated"}  # causality -> origin of the value at initialization


@dataclass(frozen=True)
class Experiment:
    """The default start, end and communication step of a run, s."""

    start: float = START_TIME
    stop: float = STOP_TIME
    step: float = STEP_SIZE
    tolerance: float | None = None  # of the solver as built, None without one


@dataclass(frozen=True)
class About:
    """The facts about an FMU for the model description, beside its variables."""

    name: str  # of the model, from which the model identifier is made
    identity: str  # text that binary and description share
    description: str
    version: str
    experiment: Experiment
    flags: Mapping[str, bool | int]  # capabilities
    tool: str  # program that made the FMU


@dataclass(frozen=True)
class Standard:
    """The names that a version of FMI uses."""

    version: str
    identity: str  # attribute with the text that binary and description share
    enumeration: tuple[str, ...]  # elements around the items of an enumeration, the outermost first
    root: Mapping[str, str] = field(default_factory=dict)  # attributes of the root that only this version has
    units: frozenset[str] = frozenset()  # defined in any case


def beginning(standard: Standard, about: About, table: list[Variable]) -> Element:
    """Return the root element with all elements before the variables."""
    words = {"fmiVersion": standard.version, "modelName": about.name, standard.identity: about.identity}
    words |= {"description": about.description, "version": about.version, "author": AUTHOR, "license": LICENCE}
    words |= {"generationDateAndTime": date(), "generationTool": about.tool, "variableNamingConvention": "structured"}
    root = Element("fmiModelDescription", words | dict(standard.root))
    flags = {key: shown(flag) for key, flag in about.flags.items()}
    SubElement(root, "CoSimulation", {"modelIdentifier": identifier_of(about.name), **flags})
    _add_units(root, {variable.unit for variable in table if variable.unit} | standard.units)
    _add_choices(root, standard, {variable.choice.name: variable.choice for variable in table if variable.choice})
    categories = SubElement(root, "LogCategories")
    for category, text in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=category, description=text)
    experiment = about.experiment
    usual = {"startTime": experiment.start, "stopTime": experiment.stop, "tolerance": experiment.tolerance}
    usual["stepSize"] = experiment.step
    SubElement(root, "DefaultExperiment", {key: shown(value) for key, value in usual.items() if value is not None})
    return root


def _add_units(root: Element, used: set[str]) -> None:
    units = SubElement(root, "UnitDefinitions")
    for unit in sorted(used):
        element = SubElement(units, "Unit", name=unit)
        SubElement(element, "BaseUnit", {base: str(power) for base, power in UNITS[unit].items()})
        if unit in DISPLAY_UNITS:
            display, factor = DISPLAY_UNITS[unit]
            SubElement(element, "DisplayUnit", name=display, factor=shown(factor))


def _add_choices(root: Element, standard: Standard, choices: Mapping[str, Choice]) -> None:
    if not choices:
        return
    types = SubElement(root, "TypeDefinitions")
    for choice in choices.values():
        outer, *inner = standard.enumeration
        element = SubElement(types, outer, name=choice.name)
        for tag in inner:
            element = SubElement(element, tag)
        for word, number in choice.items.items():
            SubElement(element, "Item", name=word, value=shown(number), description=choice.meanings[word])


def by_role(table: list[Variable]) -> list[Variable]:
    """Sort by causality: inputs, outputs, parameters, otherwise in the order of the table."""
    return sorted(table, key=lambda variable: ROLES.index(variable.causality))


def declared(variable: Variable) -> dict[str, str]:
    """Return name, reference, description and role of a variable as XML attributes."""
    found = {"name": variable.name, "valueReference": str(variable.reference), "description": variable.description}
    found |= {"causality": variable.causality, "variability": variable.variability}
    if variable.causality in INITIAL:
        found["initial"] = INITIAL[variable.causality]
    return found


def attributes(variable: Variable, nominal: float | None, **more: float | int | bool | str | None) -> dict[str, str]:
    """Return type, units and limits of a variable as XML attributes, followed by `more`; None is left out."""
    values = {
        "declaredType": variable.choice.name if variable.choice else None,
        "unit": variable.unit or None,
        "displayUnit": DISPLAY_UNITS[variable.unit][0] if variable.unit in DISPLAY_UNITS else None,
        "min": variable.minimum,
        "max": variable.maximum,
        "nominal": nominal,
    }
    return {key: shown(value) for key, value in (values | more).items() if value is not None}


def date() -> str:
    """Return the time at which the FMU is made: now, or SOURCE_DATE_EPOCH as for reproducible builds."""
    seconds = os.environ.get("SOURCE_DATE_EPOCH")
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(None if seconds is None else int(seconds)))


def shown(value: float | int | bool | str) -> str:
    """Format a value as XML Schema requires, with every digit of a float64."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return value if isinstance(value, str) else repr(value)
