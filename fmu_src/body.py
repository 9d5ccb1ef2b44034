"""The model inside an FMU (column, structure in space or another one), as slave, descriptions and builder see it.

The kind is recognized by its content: the keys of the TOML file, or of the text that the FMU carries.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from solver.common.errors import InputError, check_number, reading
from solver.common.files import toml_of
from solver.common.ranges import check, check_choice
from solver.ground.motion import Motion, check_in_plane
from solver.kernels.layout import spaces as at
from solver.kernels.layout.spaces import DRIVES, SLOPES
from solver.kernels.structure.layout import BASE as BASE_OF_STRUCTURE
from solver.models.column import stepper as in_plane
from solver.models.column.model import Column
from solver.models.column.rest import check_rest
from solver.models.outputs import BASE, BOND
from solver.models.protocol import Kind
from solver.models.samples import Samples, samples_of
from solver.models.structure.driven import SKIP_CODES, Chosen, DrivenStructure, driven_size, packed, sizes_in
from solver.models.structure.file import describes_structure, in_space
from solver.models.structure.hull_tables import in_folder, with_hulls
from solver.models.structure.model import Structure

from . import state_ranges, structure_variables, variables
from .drive import USUAL, Drive
from .rules import DAMPING_SCALE_LIMITS
from .state_ranges import Ranges

Value = Callable[[str], Any]  # returns the value of a variable by name


class Body:
    """The model inside an FMU: its text, its variables, and the stepper that integrates it from call to call.

    The base class serves a model that is integrated in Python (solver/models/driven.py) in its plane and has no
    parameters. A subclass for another kind defines `read` and `stepper`; its argument `word` is that of the kind.
    """

    of: ClassVar[dict[str, type[Body]]] = {}  # subclass by the word of the kind
    drive = USUAL
    inputs: tuple[variables.Variable, ...] = (variables.INPUTS[0], variables.INPUTS[2])
    fallen = variables.OVERTURNED_BLOCK  # the joint or block that has fallen
    first_parameter = variables.TOLERANCE
    base: tuple[str, ...] = ("", "ax", "jx")  # fields of that array; inputs by name
    kernels: tuple[str, ...] = ()  # groups with machine code in the FMU (solver/kernels/machine/groups.py)
    why_not_native = "is followed in Python, must have kernels"  # "": its FMU can do without Python

    def __init_subclass__(cls, word: str) -> None:
        cls.of[word] = cls

    def __init__(self, model: Any) -> None:
        self.model, self.name, self.tolerance = model, model.name, model.settings.tolerance
        kind: Kind = model.kind
        self.text = json.dumps({"kind": kind.word, "model": model.to_dict()}, indent=1)  # carried by the FMU
        self.about = f"A {kind.word} under base acceleration"
        row, peaks = self._outputs()
        self.sizes = len(row), 0, len(peaks)  # of the first outputs: an output row, split reaction, peaks

    @classmethod
    def read(cls, data: Any) -> Body:
        """Return the body of a model, from the result of its `to_dict`. Raises InputError."""
        raise NotImplementedError

    def _outputs(self) -> tuple[list[variables.Variable], list[variables.Variable]]:
        names = {owner: [""] * count for owner, count in self.model.sizes.items() if owner != BASE}
        return variables.seen(self.model.kind.outputs, names, lambda unit, i: 1.0)

    def table(self, record: str = "", reads_files: bool = True) -> list[variables.Variable]:
        """Return the variables.

        `record` is the name of the record inside the FMU, "" without one; with `reads_files` it reads other files, too.
        """
        row, peaks = self._outputs()
        row = [replace(output, initially=()) for output in row]
        parameters = variables.tolerance_of(self.tolerance), *variables.of_record(record, reads_files)
        return [*self.inputs, *row, *peaks, *variables.outcome(self.fallen), *parameters]

    def described(self, value: Value) -> Any:
        """Return the description that the parameters give, for `stepper`. Raises InputError with the FMU's names."""
        return self.model.with_settings(tolerance=check(variables.TOLERANCE, value(variables.TOLERANCE)))

    def stepper(self, described: Any) -> Any:
        """Return the stepper, of stepper.py or driven.py of models/, that integrates the model. Raises InputError."""
        raise NotImplementedError

    def state_ranges(self, stepper: Any) -> Ranges:
        """Return the ranges of the numbers in the arrays of its stepper."""
        arrays = stepper.arrays
        return state_ranges.finite(len(arrays.state), len(arrays.counts), len(arrays.base))

    def retune(self, stepper: Any, described: Any) -> None:
        """Apply changed parameters to a stepper. Raises InputError."""
        stepper.retune(described)

    def place_in_base(self, field: str) -> int | None:
        """Return the index of a field in the array `base`, None without it."""
        return self.base.index(field) if field in self.base else None

    def samples(self, motion: Motion | None) -> Any:
        """Return the record of a stepper. Raises InputError for a motion that it cannot follow."""
        if motion is not None:
            self.model.kind.check_motion(motion)
        return motion


class Described(NamedTuple):
    """The description that the parameters of a column give: the column, and how its base moves."""

    column: Column
    drive: Drive


class ColumnBody(Body, word="column"):
    """A column of blocks in its plane."""

    fallen = variables.OVERTURN_JOINT
    first_parameter = "g"
    base = at.BASE.fields

    def __init__(self, column: Column, drive: Drive = USUAL) -> None:
        self.model, self.name, self.tolerance = column, column.name, column.settings.tolerance
        of_ports = variables.inputs_of_ports(column)
        self.drive, self.inputs = drive, (*variables.INPUTS, *of_ports, *drive.inputs())
        self.text = json.dumps({"column": column.to_dict(), "drive": drive}, indent=1)
        blocks = "block" if column.n == 1 else "blocks"
        self.about = f"Column of {column.n} rigid {blocks} with no-tension elastic joints under base acceleration"
        more = at.SPOTS.size(len(column.ports)) + column.sizes[BOND]
        self.sizes = at.ROW.size(column.n) + more, drive.split_of_column, at.PEAKS.size(column.n) + more
        self.kernels = (column.kind.entries.run.group, "statics")
        self.why_not_native = "has solver.formulation = paper, must be exact" if column.kind.fixed else ""

    def table(self, record: str = "", reads_files: bool = True) -> list[variables.Variable]:
        return variables.variables(self.model, record, reads_files, self.drive)

    @classmethod
    def read(cls, data: Any, drive: Drive = USUAL) -> Body:
        return cls(Column.from_dict(data), drive)

    def described(self, value: Value) -> Described:
        try:
            return Described(variables.column_from(self.model, value), self.drive.chosen(value))
        except InputError as error:
            message = re.sub(r"block\[(\d+)\]\.joint\.", r"joint[\1].", str(error))
            raise InputError(message) from error

    def stepper(self, described: Described) -> in_plane.Stepper:
        made = in_plane.Stepper(described.column)
        made.driven_by(described.drive.drive, described.drive.slope, self.drive.most_bodies)
        return made

    def state_ranges(self, stepper: in_plane.Stepper | None = None) -> Ranges:
        loads, spots = len(variables.inputs_of_ports(self.model)), at.SPOTS.size(len(self.model.ports))
        return state_ranges.of_column(self.model.n, spots, loads, self.drive.is_chosen)

    def retune(self, stepper: in_plane.Stepper, described: Described) -> None:
        stepper.retune(described.column)

    def samples(self, motion: Motion | None) -> Samples:
        if motion is not None:
            check_in_plane(motion)
        return samples_of(motion)


class StructureBody(Body, word="structure"):
    """A structure in space, whose rest is computed when the FMU is built, and carried with it."""

    first_parameter = structure_variables.DAMPING_SCALE
    kernels = ("structure_driven",)
    base = BASE_OF_STRUCTURE.fields
    why_not_native = ""

    def __init__(self, data: Mapping[str, Any], model: list[float] | None = None, drive: Drive = USUAL) -> None:
        structure = self.model = Structure.from_dict(data)
        self.packed = packed(structure) if model is None else np.array(model, dtype=np.float64)
        self.name, self.tolerance = structure.name, structure.tolerance
        self.drive = drive
        self.inputs = tuple(structure_variables.inputs_of_structure(structure, drive))
        self.text = json.dumps({"structure": data, "packed": self.packed.tolist(), "drive": drive})
        parts = {"block": structure.n, "joint": len(structure.joints), "tie": len(structure.ties)}
        parts["port"] = len(structure.ports)
        counted = ", ".join(f"{count} {what}{'' if count == 1 else 's'}" for what, count in parts.items() if count)
        self.about = f"Structure of rigid blocks in space with no-tension elastic joints: {counted}"
        size = sizes_in(self.packed).visible
        self.sizes = size, driven_size(drive.most_bodies, int(drive.turns)), size

    def table(self, record: str = "", reads_files: bool = True) -> list[variables.Variable]:
        return structure_variables.structure_variables(self.model, record, reads_files, self.drive)

    @classmethod
    def read(cls, data: Any) -> Body:
        """Return the body of a structure, after computing its rest."""
        return cls(data)

    def described(self, value: Value) -> Chosen:
        names = structure_variables.DAMPING_SCALE, variables.TOLERANCE, structure_variables.WITHOUT
        scale = check_number(names[0], value(names[0]), *DAMPING_SCALE_LIMITS)
        tolerance, code = check(names[1], value(names[1])), 0
        for word in filter(None, map(str.strip, value(names[2]).split(","))):
            check_choice(names[2], word, tuple(SKIP_CODES))
            code |= SKIP_CODES[word]
        drive = self.drive.chosen(value)
        of_drive = DRIVES[drive.drive], SLOPES[drive.slope], self.drive.most_bodies, float(drive.turns)
        return Chosen(tolerance, float(code), scale, *of_drive)

    def stepper(self, described: Chosen) -> DrivenStructure:
        return DrivenStructure(self.model, self.packed, described)

    def state_ranges(self, stepper: DrivenStructure | None = None) -> Ranges:
        return state_ranges.of_structure(sizes_in(self.packed), self.drive.is_chosen)

    def samples(self, motion: Motion | None) -> Samples:
        return samples_of(motion)


def body_of(text: str) -> Body:
    """Return the body described by the text that an FMU carries. Raises InputError."""
    data = json.loads(text)
    if "kind" in data:
        return Body.of[data["kind"]].read(data["model"])
    if "packed" in data:
        return StructureBody(data["structure"], data["packed"], Drive(*data["drive"]))
    return ColumnBody.read(data["column"], Drive(*data["drive"]))


def body_for(model: Any) -> Body:
    """Return the body of a model, which must have a stable rest. Raises InputError."""
    kind: Kind = model.kind
    if kind.word not in Body.of:
        raise InputError(f"FMU: a {kind.word} has no body, a subclass of Body (fmu_src/body.py) makes one")
    kind.check(model, from_rest=True)
    return Body.of[kind.word].read(model.to_dict())


def read_body(file: Path, space: bool = False, drive: Drive = USUAL) -> Body:
    """Return the body that a TOML file describes, whose base moves by `drive`.

    With `space` a column is solved as a structure. Raises InputError if the file is wrong, the rest is not stable, or a
    base that may turn is requested for a column.
    """
    with reading(file):
        data = in_space(toml_of(file)) if space else toml_of(file)
        if describes_structure(data):
            return StructureBody(with_hulls(in_folder(data, file.parent))[0], drive=drive)
    column = Column.from_toml(file)
    if drive.turns:
        raise InputError("--turns: must be left out of a column in its plane, whose base turns by base.theta")
    with reading(file):
        check_rest(column)
    return ColumnBody(column, drive)
