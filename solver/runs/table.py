"""Results of many runs: numbers and words by name, with a row for each run."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import ItemsView, Iterable, Iterator, KeysView, Mapping, Sequence, ValuesView
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..common.aliases import warn_of_old
from ..common.errors import needing
from ..common.files import write_table
from ..common.frames import Frame, Framed
from ..common.notebook import NotebookRepr, counted, rows_of
from ..models.protocol import WORDS, Kind

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Columns = dict[str, NDArray[Any]]


class Table(Framed, NotebookRepr):
    """A table of runs by column name, `table["verdict"]`: arrays (runs,), or (runs, blocks) for every block or joint.

    The names of columns are those of Python; files and frames have the keys of studies (docs/results.md). The table is
    a mapping whose length is the number of runs. Block 1, the top one, comes first; NaN fills the columns beyond a
    column's number of blocks.

    Parameters
    ----------
    columns : mapping of str to array
        Columns by their keys in files; words as codes, named by WORDS.
    stats : mapping, optional
        How the runs were made (many.py).
    responses : mapping of int to Response, optional
        Responses that were requested in full, by the number of the run.
    first : int
        Number of the first run.
    of : mapping of str to str, optional
        As of a Frame.
    kind : Kind, optional
        The kind of the models, which has the names of the columns.
    """

    def __init__(
        self,
        columns: Mapping[str, NDArray[Any]],
        stats: Mapping[str, Any] | None = None,
        responses: Mapping[int, Any] | None = None,
        first: int = 0,
        of: Mapping[str, str] | None = None,
        kind: Kind | None = None,
    ) -> None:
        self._columns = dict(columns)
        self._of, self._kind = dict(of or {}), kind
        names = {key: name for name, key in (kind.keys if kind else {}).items()}
        self._keys = {names.get(key, key): key for key in columns}  # by the names in Python
        self.stats: dict[str, Any] = dict(stats or {})
        self.responses: dict[int, Any] = dict(responses or {})
        self.first = first

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return the column of that name; KeyError lists the names."""
        if name not in self._keys:
            new = next((new for new, key in self._keys.items() if key == name), None)
            if new is None:
                raise KeyError(f"{name}: not kept, only {', '.join(self)}")
            warn_of_old("table", name, new)
            name = new
        return self.by_key(self._keys[name])

    def by_key(self, key: str) -> NDArray[Any]:
        """Return the column with this key in files."""
        values = self._columns[key]
        return np.array(WORDS[key])[values] if key in WORDS else values

    @property
    def displacements(self) -> NDArray[np.float64]:
        """The largest displacements (m), (runs, blocks).

        For columns those of top faces; for structures those of centroids, in any direction. KeyError if not kept.
        """
        return self["peak_ux" if self._kind is None else self._kind.displacements]

    def __contains__(self, name: object) -> bool:
        return name in self._keys or name in self._columns

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the columns."""
        return iter(self._keys)

    def __len__(self) -> int:
        """Return the number of runs."""
        return len(next(iter(self._columns.values()), ()))

    def keys(self) -> KeysView[str]:
        """Return the names of the columns."""
        return self._keys.keys()

    def values(self) -> ValuesView[NDArray[Any]]:
        """Return the columns."""
        return {name: self[name] for name in self}.values()

    def items(self) -> ItemsView[str, NDArray[Any]]:
        """Return names and columns."""
        return {name: self[name] for name in self}.items()

    def get(self, name: str, default: Any = None) -> Any:
        """Return the column of that name, or `default`."""
        try:
            return self[name]
        except KeyError:
            return default

    def _facts(self) -> tuple[str, ...]:
        return f"of {counted(len(self), 'run')}", *counts(self.get("verdict", ())), ", ".join(self)

    def _lines(self) -> Iterable[Sequence[object]]:
        return rows_of(self._frame().flat())

    def _frame(self) -> Frame:
        columns = {key: self.by_key(key) for key in self._columns}
        return Frame(("run", np.arange(self.first, self.first + len(self))), columns, of=self._of)

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
    if not parts:
        return Table({})
    responses = {number: response for part in parts for number, response in part.responses.items()}
    columns = {key: _stacked([part._columns[key] for part in parts]) for key in parts[0]._columns}
    return Table(columns, None, responses, parts[0].first, parts[0]._of, parts[0]._kind)


def _stacked(arrays: list[NDArray[Any]]) -> NDArray[Any]:
    if arrays[0].ndim == 1:
        return np.concatenate(arrays)
    whole = np.full((sum(map(len, arrays)), max(array.shape[1] for array in arrays)), np.nan)
    row = 0
    for array in arrays:
        whole[row : row + len(array), : array.shape[1]] = array
        row += len(array)
    return whole
