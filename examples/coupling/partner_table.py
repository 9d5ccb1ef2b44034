"""The FMU's variables from a partner's ports, its model description, and what the C core has to know.

Runs where FMUs are built.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from xml.etree.ElementTree import Element

from partner_kernels import REASONS, law_of

from fmu_src.description_parts import About, Experiment
from fmu_src.model_description import FLAGS, model_description
from fmu_src.native.package import compiled, identified
from fmu_src.native.table import ChoiceParameter, Contents, NativeSubject, RangeCheck
from fmu_src.record import usual_experiment
from fmu_src.variables import Variable
from multiblock import InputError, Motion

VERSION = "2"
NATIVE_FLAGS = FLAGS | {"canInterpolateInputs": True}
RECORD = {"RECORD": "record", "RECORD_PGA": "pga", "RECORD_SCALE": "scale"}  # of the ground


def variables(law: ModuleType, record_name: str = "") -> list[Variable]:
    """Return the table; references count from 1."""
    parameters = tuple(port.name for port in law.PORTS if port.causality == "parameter")
    table = []
    for reference, port in enumerate(law.PORTS, start=1):
        given = port.causality == "parameter" and not isinstance(port.start, str)
        least, most = (limit if abs(limit) < 1e299 else None for limit in port.limits[:2])
        table.append(
            Variable(
                port.name,
                reference,
                "String" if isinstance(port.start, str) else "Real",
                port.causality,
                "fixed" if port.causality == "parameter" else "continuous",
                port.description,
                port.unit,
                record_name if port.name == "record" else port.start,
                least if given else None,
                most if given else None,
                depends_on=port.depends_on,
                initially=(*port.depends_on, *parameters) if port.causality == "output" else None,
            )
        )
    return table


def description(
    law: ModuleType,
    guid: str,
    table: list[Variable] | None = None,
    experiment: Experiment | None = None,
    flags: Mapping[str, bool | int] = FLAGS,
    tool: str = "build.py with PythonFMU",
) -> Element:
    """Return the root element of the model description."""
    table = variables(law) if table is None else table
    about = About(law.TITLE, guid, law.ABOUT, VERSION, experiment or Experiment(), flags, tool)
    return model_description(about, table)


def subject(law: ModuleType, group: str) -> NativeSubject:
    """Return the description of a partner for the C core; group: of its kernels."""
    ports = law.PORTS
    names = {kind: [port.name for port in ports if port.causality == kind] for kind in ("input", "output", "parameter")}
    has_record = "record" in names["parameter"]
    seen = [name for name in names["output"] if not (has_record and name == RECORD["RECORD_PGA"])]
    given = [name for name in names["parameter"] if not (has_record and name in RECORD.values())]
    state = 1 if has_record else law.MOTION + law_of("law").BEFORE + 1
    slopes = {f"ground.a{axis}": f"ground.j{axis}" for axis in "xz" if f"ground.j{axis}" in names["input"]}
    everything = len(names["input"]) + len(given)
    rooms = {"MODEL": len(given), "STATE": state, "WORK": everything, "ROW": len(seen), "SPLIT": 0}
    rest = dict.fromkeys(("N", "COUNTS", "BASE", "ROOM"), 1)
    after = names["output"][len(seen) :] + names["parameter"]
    numbers = {port.name for port in ports if isinstance(port.start, float)}
    return NativeSubject(
        falls=False,
        sizes=rooms | rest,
        codes={},
        places=RECORD if has_record else {},
        inputs=names["input"],
        slopes=slopes,
        split=next(name for name in after if name in numbers or name in names["output"]),
        given=[*given],
        choices=[ChoiceParameter(port.name, "ONE_WORD", [*enumerate(port.words)]) for port in ports if port.words],
        checks=[
            RangeCheck(port.name, port.limits[:2], port.limits[2])
            for port in ports
            if port.causality == "parameter" and port.name in numbers
        ],
        reasons=REASONS,
        group=group,
    )


def native_partner(
    name: str, platforms: list[str], record: Path | None = None, scale: float = 1.0
) -> tuple[dict[str, bytes], str]:
    """Return the files of a partner's FMU without Python, and its GUID. Raises InputError, OSError."""
    law = law_of(name)
    motion = None if record is None else Motion.from_file(record)
    if motion is not None and motion.has_ay:
        raise InputError(f"{record}: ay: partners move along x and z, must be zero")
    table = variables(law, record.name if record else "")
    contents = identified(Contents(subject(law, name), table, "", record.name if record else "", motion), 2)
    root = description(law, contents.guid, table, usual_experiment(None, motion), NATIVE_FLAGS, "build.py --native")
    return compiled(law.TITLE, contents, platforms, root)[0], contents.guid
