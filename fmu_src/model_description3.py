"""The conversion of the table of variables to the XML of an FMI 3.0 model description, and terminals of both versions.

A quantity of every block or joint is one array here: block[1].ux, block[2].ux ... are block.ux, under the value
reference of the first.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from xml.etree.ElementTree import Element, SubElement

from .description_parts import About, Standard, attributes, beginning, by_role, declared, shown
from .drive import USUAL, Drive, idle
from .references import array_of
from .variables import Variable

FMI_3 = Standard("3.0", "instantiationToken", ("EnumerationType",), units=frozenset({"s"}))
TIME_REFERENCE = 0
KINDS = {
    "Real": "Float64",
    "Integer": "Int64",
    "Boolean": "Boolean",
    "String": "String",
    "Enumeration": "Enumeration",
}
OF_BODY = "Forces and mass of a body that moves the base, as its state determines them"
OF_PORT = "Loads on {} in, motion relative to the base out"
TERMINAL = "base"  # motion in, reaction and effective mass out
REACTION = "[FM][xyz]"  # of a structure: force on the base, which follows from its state alone
SPLIT = "R0[xzm]|m[xzt][xzt]"  # of a column
# in the description of the first of an array
ELEMENT = r"\b(block|joint|tie|bearing|bond|contact|port) 1\b(?: \(.*?\))?"


def model_description3(
    about: About, table: list[Variable], followed: Collection[str] = (), scalars: bool = False
) -> Element:
    """Return the root element; inputs that are `followed` may be set within a step (intermediate update).

    With `scalars` there are no arrays, for masters that support none: each variable is as in the table and as in FMI
    2.0.
    """
    arrays = grouped(table, scalars)
    root = beginning(FMI_3, about, table)
    listed = SubElement(root, "ModelVariables")
    time = {"name": "time", "valueReference": str(TIME_REFERENCE), "causality": "independent"}
    SubElement(listed, "Float64", {**time, "variability": "continuous", "description": "Time", "unit": "s"})
    for own, elements in arrays.items():
        listed.append(_variable(own, elements, own in followed))
    root.append(_structure(arrays))
    return root


def grouped(table: list[Variable], scalars: bool = False) -> dict[str, list[Variable]]:
    """Return name in FMI 3.0 -> the variable, or the elements of the array in order; inputs, outputs, parameters."""
    arrays: dict[str, list[Variable]] = {}
    for variable in by_role(table):
        own = "" if scalars else array_of(variable.name)
        arrays.setdefault(own or variable.name, []).append(variable)
    return arrays


def _variable(name: str, elements: list[Variable], followed: bool) -> Element:
    """Return one variable; an array has the limits that all its elements share."""
    first = elements[0]
    is_array = name != first.name
    words = declared(first) | {"name": name}
    if is_array:
        words["description"] = re.sub(ELEMENT, r"\1 i", first.description)
    if followed:
        words["intermediateUpdate"] = "true"
    # limits, length and start values
    element = Element(KINDS[first.kind], words)
    nominals = [item.nominal for item in elements if item.nominal is not None]
    element.attrib |= attributes(first, max(nominals) if nominals else None)
    if is_array:
        SubElement(element, "Dimension", start=str(len(elements)))
    if first.kind == "String":
        for item in elements:
            SubElement(element, "Start", value=str(item.start or ""))
    elif first.start is not None:
        element.set("start", " ".join(shown(item.start) for item in elements if item.start is not None))
    return element


def _structure(arrays: dict[str, list[Variable]]) -> Element:
    """Return the outputs and initial unknowns, with the dependencies of their elements."""
    references = {item.name: elements[0].reference for elements in arrays.values() for item in elements}

    def listed(names: Collection[str]) -> str:
        return " ".join(map(str, dict.fromkeys(references[name] for name in names)))

    structure = Element("ModelStructure")
    outputs = [elements for elements in arrays.values() if elements[0].causality == "output"]
    for elements in outputs:
        direct = [name for item in elements for name in item.depends_on]
        reference = str(elements[0].reference)
        SubElement(structure, "Output", valueReference=reference, dependencies=listed(direct))
    for elements in outputs:
        initial = {}
        if all(item.initially is not None for item in elements):
            initial["dependencies"] = listed([name for item in elements for name in item.initially or ()])
        SubElement(structure, "InitialUnknown", {"valueReference": str(elements[0].reference), **initial})
    return structure


def terminals(table: list[Variable], has_icon: bool = False, drive: Drive = USUAL, scalars: bool = True) -> Element:
    """Return the terminals, whose signals connect as one: the base, bodies that drive it, and ports.

    The terminal of the base has its motion as inputs, unless bodies move it, and reaction and effective mass as
    outputs; that of a body has its force and mass as inputs; that of a port has loads as inputs and its motion as
    outputs. With `has_icon` icon.png is beside the file. Without `scalars` all ports are one terminal, of arrays.
    """
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    if has_icon:
        square = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
        picture = SubElement(root, "GraphicalRepresentation")
        SubElement(picture, "CoordinateSystem", square | {"suggestedScalingFactorTo_mm": "0.1"})
        SubElement(picture, "Icon", square)
    # members by the owner of each variable
    has_split = any(variable.name == f"{TERMINAL}.mxx" for variable in table)
    members = SPLIT if has_split else REACTION
    found = SubElement(root, "Terminals")
    made = {TERMINAL: _terminal(found, TERMINAL, "base", _about_base(has_split, drive))}
    for name, (variable, *_) in grouped(table, scalars).items():
        owner, _, member = name.partition(".")
        kind = re.sub(r"\d*$|\[\d+\]$", "", owner)
        is_input = variable.causality == "input"
        is_member = {
            "base": (is_input and not all(idle(word, name) for word in drive.words)) or re.fullmatch(members, member),
            "body": is_input,
            "port": variable.causality != "parameter" and not member.endswith("_peak"),
        }
        if not is_member.get(kind):
            continue
        if owner not in made:
            port = re.search(r"port \d+ \(.*\)", variable.description) if scalars else None
            about = OF_BODY if kind == "body" else OF_PORT.format(port[0] if port else "points of blocks")
            made[owner] = _terminal(found, owner, kind, about)
        words = {"variableName": name, "memberName": member, "variableKind": "signal"}
        SubElement(made[owner], "TerminalMemberVariable", words)
    return root


def _about_base(has_split: bool, drive: Drive) -> str:
    out = "Split reaction R0 and effective mass of the column" if has_split else "Reaction of the structure"
    if len(drive.words) == 1:
        return f"{out} out, for the bodies that move the base"
    return f"Motion of the base in; {out[0].lower()}{out[1:]} out"


def _terminal(parent: Element, name: str, kind: str, description: str) -> Element:
    words = {"name": name, "matchingRule": "plug", "terminalKind": f"org.multiblock-fmu.{kind}"}
    words["description"] = description
    return SubElement(parent, "Terminal", words)
