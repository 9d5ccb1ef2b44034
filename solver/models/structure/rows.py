"""Output rows of a structure, one for each instant or place of balance, by the names of what is in them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...common.errors import InputError, reading
from ...common.files import whole_file
from ...kernels.structure import layout as at
from ..column.response import check_digits
from .blocks.faces import FloatArray
from .blocks.shapes import turned

if TYPE_CHECKING:
    from .model import Structure

OF_BLOCK = at.OF_BLOCK
OF_JOINT = at.OF_JOINT
OF_BASE = ("base.Fx", "base.Fy", "base.Fz", "base.Mx", "base.My", "base.Mz")


class Rows:
    """What has a structure and rows (rows, numbers) of it."""

    structure: Structure
    rows: FloatArray

    @property
    def row_names(self) -> list[str]:
        """Names of the numbers of a row, as in a CSV."""
        structure = self.structure
        return [
            *(f"block[{block}].{name}" for name in OF_BLOCK for block in structure.names),
            *(f"joint[{joint}].{name}" for name in OF_JOINT for joint in structure.joint_names),
            *(f"tie[{e}].F" for e in range(1, len(structure.ties) + 1)),
            *OF_BASE,
        ]

    def _write(self, path: str | os.PathLike[str], index: str, values: FloatArray, digits: int) -> None:
        """Write the rows, each behind its value of an index. Raises InputError, OSError."""
        check_digits("digits", digits)
        table = np.column_stack([values, self.rows])
        names = [index, *self.row_names]
        with reading(path), whole_file(path) as partial:
            header = ",".join(f'"{name}"' if "," in name else name for name in names)
            np.savetxt(partial, table, fmt=f"%.{digits}g", delimiter=",", header=header, comments="")

    def _field(self, name: str) -> FloatArray:
        first, count = places_of(self.structure)[name]
        return self.rows[:, first : first + count]

    ux = property(lambda self: self._field("ux"))
    uy = property(lambda self: self._field("uy"))
    uz = property(lambda self: self._field("uz"))
    N = property(lambda self: self._field("N"))
    Mx = property(lambda self: self._field("Mx"))
    My = property(lambda self: self._field("My"))
    Mz = property(lambda self: self._field("Mz"))
    Tx = property(lambda self: self._field("Tx"))
    Ty = property(lambda self: self._field("Ty"))
    contact = property(lambda self: self._field("contact"))
    sigma_max = property(lambda self: self._field("sigma_max"))
    slip = property(lambda self: self._field("slip"))
    tie = property(lambda self: self._field("tie"))
    base = property(lambda self: self._field("base"))

    @property
    def rotation(self) -> FloatArray:
        """Axis times angle of each block, rad (rows, n, 3)."""
        return np.stack([self._field(name) for name in ("rx", "ry", "rz")], axis=-1)

    def displacement(self, block: str | int, point: Sequence[float] = (0.0, 0.0, 0.0)) -> FloatArray:
        """Displacement of a point of a block, m (rows, 3); the point counts from its centroid, along its own axes.

        Raises InputError for a block that there is none of.
        """
        i = self.structure.number(block)
        arm = self.structure.blocks[i].axes @ np.asarray(point, dtype=np.float64)
        if arm.shape != (3,):
            raise InputError(f"point = {list(point)}: must be three lengths in m")
        moved = np.column_stack([self.ux[:, i], self.uy[:, i], self.uz[:, i]])
        return moved + turned(self.rotation[:, i], arm)


def places_of(structure: Structure) -> dict[str, tuple[int, int]]:
    """First place and length of each field in an output row."""
    found, first = {}, 0
    n, m, k = structure.n, len(structure.joints), len(structure.ties)
    for names, count in ((OF_BLOCK, n), (OF_JOINT, m), (("tie",), k), (("base",), len(OF_BASE))):
        for name in names:
            found[name] = first, count
            first += count
    return found
