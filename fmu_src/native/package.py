"""The native FMU as an archive: libraries, model description, documentation."""

from __future__ import annotations

import hashlib
import json
import uuid
from dataclasses import replace
from xml.etree.ElementTree import tostring

from solver import __version__
from solver.column import Column
from solver.motion import Motion

from .. import documentation
from ..model_description import FLAGS, Experiment, column_description, model_description
from ..record import Record
from ..variables import variables
from .library import OWN_HEADERS, SOURCES, libraries
from .machine_code import made_with
from .platforms import PLATFORMS
from .symbols import Symbols
from .table import Contents, headers

NATIVE_FLAGS = FLAGS | {
    "canInterpolateInputs": True,
    "maxOutputDerivativeOrder": 1,
    "providesDirectionalDerivative": True,
}
NEEDS = "It needs nothing but the mathematical functions of the system's C library."


def contents_of(column: Column, record: Motion | None = None, record_name: str = "") -> Contents:
    """What the FMU of a column is made for, under a GUID that follows from all that its libraries are made of."""
    contents = Contents(column, variables(column, record_name), "", record_name, record)
    parts = [json.dumps(column.to_dict()), made_with(), *headers(contents).values()]
    identity = "".join([*parts, *(file.read_text(encoding="utf-8") for file in (*SOURCES, *OWN_HEADERS))])
    guid = uuid.uuid5(uuid.NAMESPACE_OID, hashlib.sha256(identity.encode()).hexdigest())
    return replace(contents, guid=f"{{{guid}}}")


def native_files(
    column: Column, platforms: list[str], record: Motion | None = None, record_name: str = ""
) -> tuple[dict[str, bytes], dict[str, list[Symbols]]]:
    """The files of the FMU by their names, and what the libraries need. Raises InputError, OSError."""
    contents = contents_of(column, record, record_name)
    guid, table = contents.guid, contents.table
    made = libraries(column.name, platforms, headers(contents))
    experiment = Experiment(record.start, record.end, Record(record).dt) if record else Experiment()
    description = model_description(
        *(column.name, guid, column_description(column), __version__, table, experiment),
        flags=NATIVE_FLAGS,
        tool="build_fmu.py --native",
    )
    picture = documentation.drawing(column)
    files = {
        "modelDescription.xml": b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(description),
        "model.png": picture,
        "documentation/index.html": documentation.page(column, table, NEEDS).encode(),
        "documentation/model.png": picture,
        "documentation/signs.png": documentation.sign_conventions(),
        "documentation/binaries.txt": _account({platform: needs for platform, (_, needs) in made.items()}).encode(),
    }
    for platform, (content, _) in made.items():
        files[f"binaries/{platform}/{column.name}{PLATFORMS[platform].suffix}"] = content
    return files, {platform: needs for platform, (_, needs) in made.items()}


def _account(needs: dict[str, list[Symbols]]) -> str:
    """How the libraries were made and what they need from outside."""
    lines = [f"multiblock-fmu {__version__}; {made_with()}"]
    for platform, parts in needs.items():
        for part, target in zip(parts, PLATFORMS[platform].targets, strict=True):
            lines.append(f"{platform}: {part.format} for {target.linker}, {target.cpu} and newer")
            lines.append(f"  from {', '.join(part.libraries)}: {' '.join(part.needed)}")
    return "\n".join(lines) + "\n"


def told(needs: dict[str, list[Symbols]]) -> str:
    """The same in one line for each part, for whoever builds."""
    lines = []
    for platform, parts in needs.items():
        lines += [f"{platform} ({part.format}) needs: {' '.join(part.needed)}" for part in parts]
    return "\n".join(lines)
