"""The objects of a gallery, from a table with a row for each."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ..common.errors import InputError, check_number, reading, shown
from ..common.files import MB, check_file_name, with_point
from ..common.plausible import HIGHEST
from ..common.ranges import check_choice, check_keys
from ..common.text import lines_of
from ..common.text_tables import table_of
from ..models.column.materials import MATERIALS

_SIZE = (1e-3, HIGHEST), f"a length in m, from 0.001 to {HIGHEST:g}"
_MASS = (1e-3, 1e7), "a mass in kg, from 0.001 to 1e7"
_OF_BOX = {"width": _SIZE, "depth": _SIZE, "height": _SIZE, "mass": _MASS, "centroid": _SIZE}
_OF_PEDESTAL = {f"pedestal_{key}": _OF_BOX[key] for key in ("width", "depth", "height", "mass")}
COLUMNS = ("name", "material", *_OF_BOX, "mesh", "pedestal", *_OF_PEDESTAL, "floor")


@dataclass(frozen=True)
class Exhibit:
    """An object of a gallery, on its pedestal or on the floor."""

    name: str
    material: str
    box: Mapping[str, float]  # width, depth, height, centroid (m) and mass (kg); empty of a mesh
    mesh: str  # path of the mesh (m), "" without
    pedestal: Mapping[str, float]  # width, depth, height (m) and mass (kg); empty without
    fixed: bool  # whether the pedestal is fixed to what it stands on
    floor: int  # of the building; 0: the ground


def read_objects(path: str | os.PathLike[str], floor: int) -> tuple[Exhibit, ...]:
    """Read a header with some of `COLUMNS` and a row for each object; `floor` is that of rows without one.

    Raises InputError with file, line and column.
    """
    with reading(path):
        table = table_of(lines_of(path, MB))
        names = tuple(name.lower() for name in table.names)
        check_keys("line 1: ", names, COLUMNS)
        twice = next((name for name in names if names.count(name) > 1), "")
        if twice or not {"name", "material"} <= set(names):
            raise InputError(f"line 1: {twice or 'name, material'}: must be there once, as the heading of a column")
        table.check_widths()
        found: dict[str, Exhibit] = {}
        for line, row in zip(table.lines, table.rows, strict=True):
            cells = {name: text.strip() for name, text in zip(names, row, strict=True) if text.strip()}
            one = _exhibit(f"line {line}: ", cells, Path(path).parent, floor)
            if one.name in found:
                raise InputError(f"line {line}: name = {one.name}: must be another name, it is taken")
            found[one.name] = one
        if not found:
            raise InputError("must have a line for each object")
        return tuple(found.values())


def _exhibit(line: str, cells: Mapping[str, str], folder: Path, floor: int) -> Exhibit:
    """Return the object of a row, from its cells that are not empty. Raises InputError."""

    def number(key: str, limits: tuple[float, float], meaning: str) -> float:
        text = cells.get(key, "")
        try:
            return check_number(f"{line}{key}", float(text), limits, meaning)
        except InputError:
            raise
        except ValueError:
            wrong = with_point(text) or f"{text}: must be {meaning}"
            raise InputError(f"{line}{key} = {wrong}" if text else f"{line}{key}: missing, must be {meaning}") from None

    name = check_file_name(f"{line}name", cells.get("name", ""))
    material = check_choice(f"{line}material", cells.get("material", ""), MATERIALS)
    # a box needs all its sizes, a mesh has them
    mesh, box, pedestal = cells.get("mesh", ""), {}, {}
    given = next((key for key in _OF_BOX if key in cells), "")
    if mesh and given:
        raise InputError(f"{line}{given} = {cells[given]}: must be left out, the mesh has it")
    if not mesh:
        box = {key: number(key, *limits) for key, limits in _OF_BOX.items()}
        number("centroid", (0.0, box["height"]), f"less than the height, {box['height']:g} m")
    # a pedestal, if any of its cells is given
    if any(key in cells for key in ("pedestal", *_OF_PEDESTAL)):
        check_choice(f"{line}pedestal", cells.get("pedestal", ""), ("free", "fixed"))
        pedestal = {key.partition("_")[2]: number(key, *limits) for key, limits in _OF_PEDESTAL.items()}
    for key in ("width", "depth") if box and pedestal else ():
        if box[key] > pedestal[key]:
            raise InputError(f"{line}{key} = {box[key]:g}: must be at most that of the pedestal, {pedestal[key]:g} m")
    text = cells.get("floor", str(floor))
    if not text.isdecimal():
        raise InputError(f"{line}floor = {shown(text)}: must be the number of a floor, 0 for the ground")
    path, fixed = str(folder / mesh) if mesh else "", cells.get("pedestal") == "fixed"
    return Exhibit(name, material, box, path, pedestal, fixed, int(text))
