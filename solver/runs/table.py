"""Results of many runs: numbers and words by name, with a row for each run."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import ItemsView, Iterable, Iterator, KeysView, Mapping, Sequence, ValuesView
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..common.errors import needing
from ..common.files import write_table
from ..common.frames import Frame, Framed
from ..common.notebook import Shown, counted, rows_of
from ..models.protocol import WORDS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Columns = dict[str, NDArray[Any]]


class Table(Framed, Shown):
    """A table of runs by column name, `table["peak_ux"]`: arrays (runs,), or (runs, blocks) for every block or joint.

    It is a mapping whose length is the number of runs. Block 1, the top one, comes first; NaN fills the columns beyond
    a column's number of blocks.

    Parameters
    ----------
    columns : mapping of str to array
        Columns; words as codes, named by WORDS.
    stats : mapping, optional
        How the runs were made (many.py).
    responses : mapping of int to Response, optional
        Responses that were requested in full, by the number of the run.
    first : int
        Number of the first run.
    of : mapping of str to str, optional
        As of a Frame.
    """

    def __init__(
        self,
        columns: Mapping[str, NDArray[Any]],
        stats: Mapping[str, Any] | None = None,
        responses: Mapping[int, Any] | None = None,
        first: int = 0,
        of: Mapping[str, str] | None = None,
    ) -> None:
        self._columns = dict(columns)
        self._of = dict(of or {})
        self.stats: dict[str, Any] = dict(stats or {})
        self.responses: dict[int, Any] = dict(responses or {})
        self.first = first

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return the column of that name; KeyError lists the names."""
        if name not in self._columns:
            raise KeyError(f"{name}: not kept, only {', '.join(self._columns)}")
        values = self._columns[name]
        return np.array(WORDS[name])[values] if name in WORDS else values

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the columns."""
        return iter(self._columns)

    def __len__(self) -> int:
        """Return the number of runs."""
        return len(next(iter(self._columns.values()), ()))

    def keys(self) -> KeysView[str]:
        """Return the names of the columns."""
        return self._columns.keys()

    def values(self) -> ValuesView[NDArray[Any]]:
        """Return the columns."""
        return {name: self[name] for name in self}.values()

    def items(self) -> ItemsView[str, NDArray[Any]]:
        """Return names and columns."""
        return {name: self[name] for name in self}.items()

    def get(self, name: str, default: Any = None) -> Any:
        """Return the column of that name, or `default`."""
        return self[name] if name in self._columns else default

    def _facts(self) -> tuple[str, ...]:
        return f"of {counted(len(self), 'run')}", *counts(self.get("verdict", ())), ", ".join(self)

    def _lines(self) -> Iterable[Sequence[object]]:
        return rows_of(self._frame().flat())

    def _frame(self) -> Frame:
        return Frame(("run", np.arange(self.first, self.first + len(self))), dict(self.items()), of=self._of)

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Plot displacement and verdict of each run over its number, and save the figure if `path` is given.

        Raises InputError if no displacement was kept, or without matplotlib (the extra `plot`).
        """
        with needing("plot", "matplotlib"):
            from ..plotting.tables import plot_table
        return plot_table(self._frame(), path)

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write a line for each run, its number first; a column of blocks becomes peak_ux[1], peak_ux[2] and so on."""
        columns = self._frame().flat()
        write_table(path, columns, zip(*(column.tolist() for column in columns.values()), strict=True))


def counts(verdicts: Iterable[str]) -> list[str]:
    """Return the number of each verdict, in words."""
    return [f"{number} {verdict}" for verdict, number in sorted(Counter(map(str, verdicts)).items())]


def joined(parts: Sequence[Table]) -> Table:
    """Concatenate the tables of consecutive runs; columns of blocks become as wide as the widest. Stats are dropped."""
    responses = {number: response for part in parts for number, response in part.responses.items()}
    columns = {name: _stacked([part._columns[name] for part in parts]) for name in (parts[0] if parts else ())}
    first, of = (parts[0].first, parts[0]._of) if parts else (0, {})
    return Table(columns, None, responses, first, of)


def _stacked(arrays: list[NDArray[Any]]) -> NDArray[Any]:
    if arrays[0].ndim == 1:
        return np.concatenate(arrays)
    whole = np.full((sum(map(len, arrays)), max(array.shape[1] for array in arrays)), np.nan)
    row = 0
    for array in arrays:
        whole[row : row + len(array), : array.shape[1]] = array
        row += len(array)
    return whole
