"""Conversion of histories and tables to pandas and xarray."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import needing

EXTRA = "studies"


@dataclass(frozen=True)
class Frame:
    """Named columns over common rows, each (rows,), or (rows, blocks) with block 1, the top one, first."""

    index: tuple[str, NDArray[Any]]  # name and values (rows,)
    columns: Mapping[str, NDArray[Any]]
    units: Mapping[str, str] = field(default_factory=dict)  # of columns and index, by name
    attributes: Mapping[str, Any] = field(default_factory=dict)  # of the data set
    of: Mapping[str, str] = field(default_factory=dict)  # second dimension of a column, if it is not `block`
    labels: Mapping[str, Sequence[object]] = field(default_factory=dict)  # of a second dimension, if not 1, 2, 3

    def flat(self) -> dict[str, NDArray[Any]]:
        """Return the index and the columns, one for each block such as ux[1], ux[2]."""
        found = dict([self.index])
        for name, values in self.columns.items():
            if values.ndim == 1:
                found[name] = values
            else:
                found |= {f"{name}[{i}]": column for i, column in enumerate(values.T, start=1)}
        return found


class Framed:
    """An object that converts to a frame."""

    def _frame(self) -> Frame:
        raise NotImplementedError

    def to_pandas(self) -> Any:
        """Convert to a pandas.DataFrame, with a column such as ux[1], the top one, for each block or joint.

        Raises InputError without pandas (the extra `studies`).
        """
        with needing(EXTRA, "pandas"):
            import pandas
        frame = self._frame()
        return pandas.DataFrame(frame.flat()).set_index(frame.index[0])

    def to_xarray(self) -> Any:
        """Convert to an xarray.Dataset over the rows and `block`, with units.

        Raises InputError without xarray (the extra `studies`).
        """
        with needing(EXTRA, "xarray"):
            import xarray
        frame = self._frame()
        index, rows = frame.index
        data = {}
        coordinates: dict[str, tuple[str, Any, dict[str, str]]] = {index: (index, rows, _units(frame, index))}
        for name, values in frame.columns.items():
            part = frame.of.get(name, "block")
            dimensions = (index, part)[: values.ndim]
            data[name] = (dimensions, _words(values) if values.dtype.kind == "U" else values, _units(frame, name))
            if values.ndim == 2:
                coordinates[part] = (part, list(frame.labels.get(part, range(1, values.shape[1] + 1))), {})
        return xarray.Dataset(data, coordinates, dict(frame.attributes))


def _units(frame: Frame, name: str) -> dict[str, str]:
    return {"units": frame.units[name]} if name in frame.units else {}


def _words(values: NDArray[Any]) -> NDArray[Any]:
    """Convert strings to objects, of which equal ones are the same object."""
    different, which = np.unique(values, return_inverse=True)
    return np.asarray(different.astype(object)[which])
