"""Results of many runs: columns of numbers and words by name, a row for each run."""

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
    """Columns by name, `table["peak_ux"]`: an array (runs,), or (runs, blocks) for values of every block or joint.

    A mapping, but its length is the number of runs. Block 1, the top one, comes first; NaN fills the columns beyond a
    column's number of blocks. `first`: number of the first run. columns: words as numbers, named by WORDS. stats: how
    the runs were made (many.py). responses: by number of the run, those requested in full. of: as of a Frame.
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
        """The column of that name; KeyError lists the names."""
        if name not in self._columns:
            raise KeyError(f"{name}: not kept, only {', '.join(self._columns)}")
        values = self._columns[name]
        return np.array(WORDS[name])[values] if name in WORDS else values

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __iter__(self) -> Iterator[str]:
        """The names of the columns."""
        return iter(self._columns)

    def __len__(self) -> int:
        """Number of runs."""
        return len(next(iter(self._columns.values()), ()))

    def keys(self) -> KeysView[str]:
        """The names of the columns."""
        return self._columns.keys()

    def values(self) -> ValuesView[NDArray[Any]]:
        """The columns."""
        return {name: self[name] for name in self}.values()

    def items(self) -> ItemsView[str, NDArray[Any]]:
        """Names and columns."""
        return {name: self[name] for name in self}.items()

    def get(self, name: str, default: Any = None) -> Any:
        """The column of that name, or `default`."""
        return self[name] if name in self._columns else default

    def _facts(self) -> tuple[str, ...]:
        return f"of {counted(len(self), 'run')}", *counts(self.get("verdict", ())), ", ".join(self)

    def _lines(self) -> Iterable[Sequence[object]]:
        return rows_of(self._frame().flat())

    def _frame(self) -> Frame:
        return Frame(("run", np.arange(self.first, self.first + len(self))), dict(self.items()), of=self._of)

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Draw how far each run moves and its verdict, over the numbers of the runs; saved to `path` if given.

        Raises InputError without a kept displacement, and without matplotlib (the extra `plot`).
        """
        with needing("plot", "matplotlib"):
            from ..plotting.tables import plot_table
        return plot_table(self._frame(), path)

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write a line for each run, the number of the run first; a column of blocks as peak_ux[1], peak_ux[2] ..."""
        columns = self._frame().flat()
        write_table(path, columns, zip(*(column.tolist() for column in columns.values()), strict=True))


def counts(verdicts: Iterable[str]) -> list[str]:
    """How often each verdict occurs, in words."""
    return [f"{number} {verdict}" for verdict, number in sorted(Counter(map(str, verdicts)).items())]


def joined(parts: Sequence[Table]) -> Table:
    """The tables of neighbouring runs as one; columns of blocks become as wide as the widest. Stats are left out."""
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
