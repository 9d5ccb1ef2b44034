"""Histories and tables as pandas and xarray have them."""

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
    """Columns by name over the same rows, each (rows,), or (rows, blocks) with block 1, the top one, first.

    index: the name of what counts the rows, and its values. units: of columns and of the index, by name. of: what the
    numbers of a column are of, by its name, where that is not `block`. labels: what these are called, where that is
    not their numbers from 1.
    """

    index: tuple[str, NDArray[Any]]
    columns: Mapping[str, NDArray[Any]]
    units: Mapping[str, str] = field(default_factory=dict)
    attributes: Mapping[str, Any] = field(default_factory=dict)
    of: Mapping[str, str] = field(default_factory=dict)
    labels: Mapping[str, Sequence[object]] = field(default_factory=dict)

    def flat(self) -> dict[str, NDArray[Any]]:
        """The index and the columns, one for each block as ux[1], ux[2] and so on."""
        found = dict([self.index])
        for name, values in self.columns.items():
            if values.ndim == 1:
                found[name] = values
            else:
                found |= {f"{name}[{i}]": column for i, column in enumerate(values.T, start=1)}
        return found


class Framed:
    """An object that has a frame."""

    def _frame(self) -> Frame:
        raise NotImplementedError

    def to_pandas(self) -> Any:
        """A pandas.DataFrame; numbers of blocks and joints are columns such as ux[1], the top one.

        Raises InputError without pandas (the extra `studies`).
        """
        with needing(EXTRA, "pandas"):
            import pandas
        frame = self._frame()
        return pandas.DataFrame(frame.flat()).set_index(frame.index[0])

    def to_xarray(self) -> Any:
        """An xarray.Dataset over the rows and `block`, with units. Raises InputError without xarray (`studies`)."""
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
    """Texts as objects, of which equal ones are the same."""
    different, which = np.unique(values, return_inverse=True)
    found: NDArray[Any] = different.astype(object)[which]
    return found
