"""The native FMU as an archive: libraries, model description, documentation."""

from __future__ import annotations

import hashlib
import uuid
from collections.abc import Callable
from dataclasses import replace
from typing import Any
from xml.etree.ElementTree import Element, tostring

from solver import __version__
from solver.common.files import identifier_of
from solver.ground.motion import Motion
from solver.kernels.machine.making import compilers, sources_of
from solver.kernels.machine.zig import BESIDE_WINDOWS

from .. import documentation
from ..body import Body, ColumnBody, StructureBody
from ..description_parts import About
from ..licences import legal_files
from ..model_description import FLAGS, model_description
from ..model_description3 import model_description3, terminals
from ..record import usual_experiment
from ..variables import with_real_outputs
from .column_subject import column_subject
from .library import OWN_HEADERS, libraries, sources
from .platforms import PLATFORMS, USUAL_FORM, Form
from .source import describe_sources, source_files
from .structure_subject import structure_subject
from .symbols import Symbols
from .table import Contents, NativeSubject, headers

NATIVE_FLAGS = FLAGS | {
    "canInterpolateInputs": True,
    "maxOutputDerivativeOrder": 1,
    "providesDirectionalDerivative": True,
}
NEEDS = "It needs nothing but the mathematical functions of the system's C library."


# the capabilities by their names in FMI 3.0
FLAGS_3 = {
    "needsExecutionTool": False,
    "canBeInstantiatedOnlyOncePerProcess": False,
    "canGetAndSetFMUState": True,
    "canSerializeFMUState": True,
    "providesDirectionalDerivatives": True,
    "canHandleVariableCommunicationStepSize": True,
    "maxOutputDerivativeOrder": 1,
    "providesIntermediateUpdate": True,  # where an input can be followed
    "mightReturnEarlyFromDoStep": False,
    "canReturnEarlyAfterIntermediateUpdate": False,
    "hasEventMode": False,
}


# description for the C core, by kind of body
SUBJECTS: dict[type[Body], Callable[[Any], NativeSubject]] = {
    ColumnBody: column_subject,
    StructureBody: structure_subject,
}
XML = b'<?xml version="1.0" encoding="UTF-8"?>\n'


def contents_of(body: Body, record: Motion | None = None, record_name: str = "", form: Form = USUAL_FORM) -> Contents:
    """Return the content of the FMU of a body, with a GUID that follows from all inputs of its libraries."""
    table = body.table(record_name, reads_files=False)
    contents = Contents(SUBJECTS[type(body)](body), table, "", record_name, record, form.scalars)
    return identified(contents, form.fmi, body.text, "real outputs" if form.real_outputs else "")


def made_with(group: str) -> str:
    """Return a text of everything that determines the machine code of kernels, except the target."""
    return f"{compilers()}, kernels {sources_of(group)}, {group}"


def identified(contents: Contents, fmi: int, *texts: str) -> Contents:
    """Return the content with a GUID that follows from all inputs of its libraries."""
    files = (*sources(fmi), *OWN_HEADERS, BESIDE_WINDOWS)
    parts = [*texts, made_with(contents.subject.group), *headers(contents).values()]
    identity = "".join([*parts, *(file.read_text(encoding="utf-8") for file in files)])
    guid = uuid.uuid5(uuid.NAMESPACE_OID, hashlib.sha256(identity.encode()).hexdigest())
    return replace(contents, guid=f"{{{guid}}}")


def native_files(
    body: Body, platforms: list[str], record: Motion | None = None, record_name: str = "", form: Form = USUAL_FORM
) -> tuple[dict[str, bytes], dict[str, list[Symbols]]]:
    """Return the files of the FMU by path, and the symbols that the libraries of each platform need.

    `platforms` are names in PLATFORMS[form.fmi]. Raises InputError if a library needs symbols of Python or the compiler
    is not installed, OSError if the compiler fails.
    """
    fmi, contents = form.fmi, contents_of(body, record, record_name, form)
    table = with_real_outputs(contents.table) if form.real_outputs else contents.table
    experiment = usual_experiment(body.tolerance, record)
    name = identifier_of(body.name)
    identity = (body.name, contents.guid, body.about, __version__, experiment)
    flags = FLAGS_3 | {"providesIntermediateUpdate": bool(contents.subject.lines)} if fmi == 3 else NATIVE_FLAGS
    about = About(*identity, flags, "build_fmu.py --native")
    # model description
    if fmi == 3:
        description = model_description3(about, table, contents.subject.lines, form.scalars)
    else:
        description = model_description(about, table)
    # documentation, terminals, sources, libraries
    pages = documentation.pages(body, table, NEEDS, experiment.step) | legal_files(NEEDS)
    pages["terminalsAndIcons/icon.png" if fmi == 3 else "model.png"] = pages["documentation/model.png"]
    if fmi == 3 or form.terminals:
        pages["terminalsAndIcons/terminalsAndIcons.xml"] = XML + tostring(
            terminals(table, fmi == 3, body.drive, form.scalars or fmi == 2)
        )
    if form.source:
        pages |= source_files(name, headers(contents), contents.subject.group, fmi)
        pages |= describe_sources(description, name, fmi)
    files, needs = compiled(name, contents, platforms, description, fmi)
    return files | pages, needs


def compiled(
    name: str, contents: Contents, platforms: list[str], description: Element, fmi: int = 2
) -> tuple[dict[str, bytes], dict[str, list[Symbols]]]:
    """Return model description, libraries and their report by path, and the needed symbols.

    Raises InputError, OSError.
    """
    group = contents.subject.group
    made = libraries(name, platforms, headers(contents), group, fmi)
    needs = {platform: needed for platform, (_, needed) in made.items()}
    files = {
        "modelDescription.xml": XML + tostring(description),
        "documentation/binaries.txt": _account(needs, group, fmi).encode(),
    }
    for platform, (content, _) in made.items():
        files[f"binaries/{platform}/{name}{PLATFORMS[fmi][platform].suffix}"] = content
    return files, needs


def _account(needs: dict[str, list[Symbols]], group: str, fmi: int) -> str:
    """Return the report on how the libraries were made and which external symbols they need."""
    lines = [f"multiblock-fmu {__version__}; {made_with(group)}"]
    for platform, parts in needs.items():
        for part, target in zip(parts, PLATFORMS[fmi][platform].targets, strict=True):
            lines.append(f"{platform}: {part.format} for {target.linker}, {target.cpu} and newer")
            lines.append(f"  from {', '.join(part.libraries)}: {' '.join(part.needed)}")
    return "\n".join(lines) + "\n"


def needs_report(needs: dict[str, list[Symbols]]) -> str:
    """Return the external symbols that the libraries need, a line for each part, for the builder's terminal."""
    lines = []
    for platform, parts in needs.items():
        lines += [f"{platform} ({part.format}) needs: {' '.join(part.needed)}" for part in parts]
    return "\n".join(lines)
