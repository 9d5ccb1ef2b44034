"""A coupled system as SSP 1.0, for masters that open such files.

Beside the FMUs it holds the system (SystemStructure.ssd) and a set of parameters for each component (.ssv). Connectors
of the system have no dot in their names: OMSimulator would take it for the name of an element. An annotation gives
OMSimulator the step; other tools ignore it. Components also have connectors for the results that a user looks at:
displacements and joint forces of the column, outputs of the partners. These are outputs of the system too if the ground
motion is an input of the system. Otherwise the system has no connectors, because libcosim and ecos refuse them. The
system has no frame of its own (SystemGeometry): OMSimulator refuses a file with a tag that it does not know.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from fmpy import read_model_description

from fmu_src.description_parts import UNITS

SPACE = "http://ssp-standard.org/SSP1/SystemStructure"
SPACES = {"xmlns:ssd": f"{SPACE}Description", "xmlns:ssc": f"{SPACE}Common", "xmlns:ssv": f"{SPACE}ParameterValues"}
OMS = {"xmlns:oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"}
SPLIT = ("R0x", "R0z", "R0m", "mxx", "mxz", "mxt", "mzz", "mzt", "mtt")
BODY = ("F0x", "F0z", "F0m", "Mxx", "Mxz", "Mxt", "Mzz", "Mzt", "Mtt")
GROUND = ("ax", "az", "jx", "jz")
SHOWN = re.compile(r"block\[\d+\]\.ux|joint\[\d+\]\.[NMT]")  # of the column
WIDTH, GAP, PITCH = 60.0, 40.0, 4.0  # of a component, between two of them, between two connectors; in mm
SET = "defaults"
KINDS = {float: "Real", int: "Integer", bool: "Boolean", str: "String"}


@dataclass
class System:
    """Components by name, and what is connected: (element, connector, element, connector), "" for the system itself."""

    name: str
    fmus: dict[str, Path]
    parameters: Mapping[str, Mapping[str, Any]]  # component -> variable -> value
    stop: float  # s
    step: float  # s
    connections: list[tuple[str, str, str, str]] = field(default_factory=list)
    shown: list[tuple[str, str]] = field(default_factory=list)  # (element, connector), read but not connected


def coupled(
    partner: str, fmus: Mapping[str, Path], parameters: Mapping[str, Mapping[str, Any]], stop: float, step: float
) -> System:
    """Return the column on a partner; the ground is a component if there is an FMU of it, otherwise inputs of the
    system.
    """
    inside = "ground" in fmus
    parts = [*(["ground"] if inside else []), "column", partner]
    name = {"isolator": "isolated", "soil": "on_soil"}[partner] + ("" if inside else "_inputs")
    system = System(name, {part: fmus[part] for part in parts}, parameters, stop, step)
    known = {variable.name for variable in read_model_description(str(fmus[partner])).modelVariables}
    for axis in GROUND:
        source = ("ground", f"ground.{axis}") if inside else ("", f"ground_{axis}")
        system.connections.append((*source, partner, f"ground.{axis}"))
        if axis[1] == "z" and "body.F0z" not in known:  # vertically the base goes with the ground
            system.connections.append((*source, "column", f"base.{axis}"))
    for part in SPLIT:
        if f"column.{part}" in known:
            system.connections.append(("column", f"base.{part}", partner, f"column.{part}"))
    for part in BODY:
        if f"body.{part}" in known:
            system.connections.append((partner, f"body.{part}", "column", f"body.{part}"))
    used = {(element, name) for element, name, _, _ in system.connections}
    for part in ("column", partner):
        for variable in read_model_description(str(fmus[part])).modelVariables:
            wanted = SHOWN.fullmatch(variable.name) if part == "column" else (part, variable.name) not in used
            if variable.causality == "output" and wanted:
                system.shown.append((part, variable.name))
    if not inside:
        system.connections += [(part, name, "", outside(part, name)) for part, name in system.shown]
    return system


def outside(part: str, name: str) -> str:
    """Name of a component's connector as one of the system: block[1].ux of the column is column_block1_ux."""
    return f"{part}_{re.sub(r'[][]', '', name).replace('.', '_')}"


def write(system: System, output: Path) -> Path:
    """Write the archive."""
    with zipfile.ZipFile(output, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("SystemStructure.ssd", _text(structure(system)))
        for part, values in system.parameters.items():
            if part in system.fmus and values:
                archive.writestr(f"resources/{part}.ssv", _text(parameter_set(values)))
        for part, path in system.fmus.items():
            archive.write(path, f"resources/{part}.fmu")
    return output


def wire(system: System, folder: Path, platform: str, watched: list[tuple[str, str]]) -> Path:
    """Write files for master.c: libraries for one platform and a list of connections. Native FMUs only."""
    folder.mkdir(parents=True, exist_ok=True)
    descriptions: dict[str, Any] = {part: read_model_description(str(path)) for part, path in system.fmus.items()}
    numbers = {
        (part, variable.name): variable.valueReference
        for part, description in descriptions.items()
        for variable in description.modelVariables
    }
    lines = []
    for part, path in system.fmus.items():
        with zipfile.ZipFile(path) as archive:
            (inside,) = (name for name in archive.namelist() if name.startswith(f"binaries/{platform}/"))
            library = (
                folder / f"{path.stem}{Path(inside).suffix}"
            )  # names inside follow the column, of which there are two
            library.write_bytes(archive.read(inside))
        lines.append(f"fmu {part} {descriptions[part].guid} {library.resolve()}")
        for name, value in system.parameters.get(part, {}).items():
            kind = "text" if isinstance(value, str) else "real"
            lines.append(f"{kind} {part} {numbers[part, name]} {value!r}".replace("'", ""))
    links = [(a, start, b, end) for a, start, b, end in system.connections if a and b]
    lines += [f"connect {a} {numbers[a, start]} {b} {numbers[b, end]}" for a, start, b, end in links]
    lines += [f"watch {part} {numbers[part, name]}" for part, name in watched]
    file = folder / f"{system.name}.txt"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


def _text(root: Element) -> bytes:
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root) + b"\n"


def parameter_set(values: Mapping[str, Any]) -> Element:
    """Return the values of the variables of one component. All sets have one name: ecos is given this name."""
    root = Element("ssv:ParameterSet", {**_spaces("ssc", "ssv"), "version": "1.0", "name": SET})
    parameters = SubElement(root, "ssv:Parameters")
    for variable, value in values.items():
        parameter = SubElement(parameters, "ssv:Parameter", name=variable)
        text = str(value).lower() if isinstance(value, bool) else str(value)
        SubElement(parameter, f"ssv:{KINDS[type(value)]}", value=text)
    return root


def _spaces(*names: str) -> dict[str, str]:
    return {f"xmlns:{name}": SPACES[f"xmlns:{name}"] for name in names}


def structure(system: System) -> Element:
    """Return the system."""
    units = {part: _units(path) for part, path in system.fmus.items()}
    used = {unit for _, _, target, end in system.connections if target and (unit := units[target][end])}
    used |= {unit for part, name in system.shown if (unit := units[part][name])}
    root = Element("ssd:SystemStructureDescription", {**_spaces("ssd", "ssc"), **OMS, "name": system.name})
    root.set("version", "1.0")
    top = SubElement(root, "ssd:System", name=system.name)
    own = [
        (end, "output", units[source][start]) if source else (start, "input", units[target][end])
        for source, start, target, end in system.connections
        if not (source and target)
    ]
    if own:
        _connectors(top, own)
    elements = SubElement(top, "ssd:Elements")
    right = 0.0
    for part in system.fmus:
        component = SubElement(elements, "ssd:Component", name=part, source=f"resources/{part}.fmu")
        component.set("type", "application/x-fmu-sharedlibrary")
        ports = [(start, "output", units[part][start]) for source, start, _, _ in system.connections if source == part]
        ports += [(end, "input", units[part][end]) for _, _, target, end in system.connections if target == part]
        ports += [(name, "output", units[part][name]) for element, name in system.shown if element == part]
        ports = list(dict.fromkeys(ports))
        _connectors(component, ports)
        left, height = right + GAP, PITCH * (1 + len(ports))
        right = left + WIDTH
        corners = {"x1": left, "y1": GAP, "x2": right, "y2": GAP + height}
        SubElement(component, "ssd:ElementGeometry", {key: str(value) for key, value in corners.items()})
        if system.parameters.get(part):
            binding = SubElement(SubElement(component, "ssd:ParameterBindings"), "ssd:ParameterBinding")
            binding.set("source", f"resources/{part}.ssv")
    connections = SubElement(top, "ssd:Connections")
    for source, start, target, end in system.connections:
        connection = SubElement(connections, "ssd:Connection", {"startElement": source} if source else {})
        connection.set("startConnector", start)
        connection.attrib |= {"endElement": target, "endConnector": end} if target else {"endConnector": end}
    annotation = SubElement(SubElement(top, "ssd:Annotations"), "ssc:Annotation", type="org.openmodelica")
    information = SubElement(SubElement(annotation, "oms:Annotations"), "oms:SimulationInformation")
    master = SubElement(information, "oms:FixedStepMaster", description="oms-ma", stepSize=str(system.step))
    master.attrib |= {"absoluteTolerance": "1e-4", "relativeTolerance": "1e-4"}
    listed = SubElement(root, "ssd:Units")
    for unit in sorted(used):
        exponents = {base: str(power) for base, power in UNITS[unit].items()}
        SubElement(SubElement(listed, "ssc:Unit", name=unit), "ssc:BaseUnit", exponents)
    SubElement(root, "ssd:DefaultExperiment", startTime="0.0", stopTime=str(system.stop))
    return root


def _connectors(owner: Element, ports: list[tuple[str, str, str]]) -> None:
    """Return the connectors, inputs on the left side and outputs on the right, from the top down in parts of the
    height.
    """
    connectors = SubElement(owner, "ssd:Connectors")
    for side, own in (("0.0", "input"), ("1.0", "output")):
        listed = [(name, unit) for name, kind, unit in ports if kind == own]
        for k, (name, unit) in enumerate(listed, start=1):
            connector = SubElement(connectors, "ssd:Connector", name=name, kind=own)
            SubElement(connector, "ssc:Real", {"unit": unit} if unit else {})
            SubElement(connector, "ssd:ConnectorGeometry", x=side, y=f"{1.0 - k / (len(listed) + 1):.4f}")


def _units(path: Path) -> dict[str, str]:
    return {variable.name: variable.unit or "" for variable in read_model_description(str(path)).modelVariables}
