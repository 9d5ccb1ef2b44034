"""The conversion of the table of variables to the XML of an FMI 2.0 model description."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

from .description_parts import About, Standard, attributes, beginning, by_role, declared
from .variables import Variable

FMI_2 = Standard("2.0", "guid", ("SimpleType", "Enumeration"), {"numberOfEventIndicators": "0"})
FLAGS = {
    "needsExecutionTool": False,  # some masters refuse true; Python with numpy is needed all the same
    "canHandleVariableCommunicationStepSize": True,
    "canInterpolateInputs": False,
    "canRunAsynchronuously": False,
    "canBeInstantiatedOnlyOncePerProcess": False,
    "canNotUseMemoryManagementFunctions": True,
    "canGetAndSetFMUstate": True,
    "canSerializeFMUstate": True,
    "providesDirectionalDerivative": False,
}


def model_description(about: About, table: list[Variable]) -> Element:
    """Return the root element; inputs come first, then outputs, then parameters, otherwise as in the table."""
    table = by_role(table)
    root = beginning(FMI_2, about, table)
    listed = SubElement(root, "ModelVariables")
    for variable in table:
        # parameters start at a given value, outputs are calculated, inputs have neither
        element = SubElement(listed, "ScalarVariable", declared(variable))
        SubElement(element, variable.kind, attributes(variable, variable.nominal, start=variable.start))
    root.append(_structure(table))
    return root


def _structure(table: list[Variable]) -> Element:
    """Return the outputs and the initial unknowns, which are the same, with their dependencies."""
    index = {variable.name: str(k) for k, variable in enumerate(table, start=1)}

    def listed(names: tuple[str, ...]) -> str:
        """Return the indices of variables; the standard requires that none occurs twice."""
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
