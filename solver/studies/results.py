"""Results of the runs of a study: one table, as arrays, as CSV, as NetCDF."""

from __future__ import annotations

import importlib.util
import itertools
import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..common.errors import InputError, needing, reading
from ..common.files import whole_file, write_table
from ..common.frames import Frame, Framed
from ..common.notebook import NotebookRepr, rows_of
from ..models.pictures import draw
from ..models.protocol import WORDS
from ..runs.table import Columns, counts
from .contents import FAILED, check_head, check_row, length_of
from .definition import Study
from .journal import check_same_study, read_journal
from .motions import SPECTRAL
from .subjects import ALL_KEPT, kind_in

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# units by the name of a column of the table; varied numbers have those of the column file and the study file
UNITS = {"pga": "g", "pgv": "m/s", **dict.fromkeys(SPECTRAL, "g")} | {
    name: one.unit for name, one in ALL_KEPT.items() if one.unit
}
ROWS_AT_ONCE = 4096
NAMED = "motion_name"


class Results(Framed, NotebookRepr):
    """The finished runs of a study by number: `results["peak_ux"]` is (runs, blocks), other columns (runs,).

    Names of columns are those of the study file; the names of a `Table` work too: `run`; the varied numbers (`column`,
    `motion`, `joint.stiffness` ...); `motion_name`, a text; measures of the motion as run: pga and sa in g, pgv in m/s;
    outputs; `failure`, a text. A run that the solver could not finish has the verdict "failed", and NaN.

    Parameters
    ----------
    head : mapping
        The first line of the journal: the study and the versions.
    rows : iterable of list
        Rows as of chunks.Made, in any order; of several rows of one run the first counts.
    """

    def __init__(self, head: Mapping[str, Any], rows: Iterable[list[Any]]) -> None:
        self.head = dict(head)
        rest = iter(rows)
        # convert in parts: lists need many times the memory of arrays
        parts = [_columns(head, list(itertools.islice(rest, ROWS_AT_ONCE)))]
        while part := list(itertools.islice(rest, ROWS_AT_ONCE)):
            parts.append(_columns(head, part))
        # sort by number; the first of equal numbers counts
        _, order = np.unique(np.concatenate([part["run"] for part in parts]), return_index=True)
        self.columns: Columns = {}
        for name in tuple(parts[0]):
            self.columns[name] = np.concatenate([part.pop(name) for part in parts])[order]

    @classmethod
    def from_journal(cls, path: str | os.PathLike[str]) -> Results:
        """Read a journal, also while runs are added to it. Raises InputError that begins with `path`."""
        return cls(*read_journal(path, check_head, check_row))

    @property
    def study(self) -> dict[str, Any]:
        """The study as plain data."""
        return self.head["study"]

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return a column of the table. Raises KeyError that lists the columns."""
        key = self._key(name)
        if key not in self.columns:
            raise KeyError(f"{name}: not kept, only {', '.join(self.columns)}")
        return self.columns[key]

    def __contains__(self, name: object) -> bool:
        return self._key(name) in self.columns

    def _key(self, name: Any) -> Any:
        """Return the key of a result that may have its name in Python."""
        return name if name in self.columns else kind_in(self.head).keys.get(name, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        """Return the number of finished runs."""
        return len(self.columns["run"])

    @property
    def complete(self) -> bool:
        """True if all runs of the study are finished."""
        return bool(len(self) == self.head["runs"])

    @property
    def overturned(self) -> NDArray[np.bool_]:
        """True for each run in which the column fell, (runs,)."""
        return np.asarray(self["verdict"] == "overturned")

    @property
    def undecided(self) -> NDArray[np.bool_]:
        """True for each run at whose end the column still rocked, with the energy to fall, (runs,)."""
        return np.asarray(self["verdict"] == "undecided")

    @property
    def displacements(self) -> NDArray[np.float64]:
        """The largest displacements (m), (runs, blocks).

        For columns those of top faces; for structures those of centroids, in any direction.
        """
        return self[kind_in(self.head).displacements]

    @property
    def largest(self) -> NDArray[np.float64]:
        """The largest peak displacement of any block (m), (runs,).

        It is infinite if the column fell, NaN if the run could not be finished.
        """
        peaks = self.displacements
        known = ~np.all(np.isnan(peaks), axis=1)
        largest = np.full(len(self), math.nan)
        largest[known] = np.nanmax(peaks[known], axis=1)
        return np.where(self.overturned, math.inf, largest)

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Draw the picture for the kind of the study, and save it to `path` if given.

        Raises InputError without finished runs, and without matplotlib (the extra `plot`).
        """
        return draw(self, "draw", path)

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write one line per run, with all digits; missing values are empty. Raises InputError, OSError."""
        columns = self._frame().flat()
        rows = (
            row
            for first in range(0, len(self), ROWS_AT_ONCE)
            for row in zip(
                *(map(_text, column[first : first + ROWS_AT_ONCE].tolist()) for column in columns.values()),
                strict=True,
            )
        )
        with reading(path):
            write_table(path, columns, rows)

    @staticmethod
    def can_write_netcdf() -> bool:
        """Return True if the packages for NetCDF are installed."""
        return all(importlib.util.find_spec(name) is not None for name in ("xarray", "h5netcdf", "h5py"))

    def _facts(self) -> tuple[str, ...]:
        return f"of {self.study['name']}", f"{len(self)} of {self.head['runs']} runs", *counts(self["verdict"])

    def _lines(self) -> Iterable[Sequence[object]]:
        return rows_of(self._frame().flat())

    def _frame(self) -> Frame:
        """Return the table with units, and the study and the versions as attributes."""
        attributes = {
            "title": self.study["name"],
            "study": json.dumps(self.study),
            "fingerprint": self.head["fingerprint"],
            "versions": json.dumps(self.head["versions"]),
            "runs": self.head["runs"],
        }
        columns = {name: values for name, values in self.columns.items() if name != "run"}
        of = {name: kind_in(self.head).kept[name].of for name in self.study["keep"]}
        return Frame(("run", self["run"]), columns, UNITS, attributes, of)

    def to_netcdf(self, path: str | os.PathLike[str]) -> None:
        """Write NetCDF 4, whole or not at all. Raises InputError."""
        with needing("studies", "h5netcdf", "h5py"):
            import h5netcdf  # noqa: F401
            import h5py  # noqa: F401
        with reading(path), whole_file(path) as partial:
            self.to_xarray().to_netcdf(partial, engine="h5netcdf")


def _columns(head: Mapping[str, Any], rows: list[list[Any]]) -> Columns:
    """Return rows as arrays by name."""
    columns: Columns = {"run": np.array([row[0] for row in rows], dtype=np.int64)}
    for place, key in ((1, "varied"), (2, "measured")):
        for k, name in enumerate(head[key]):
            values = [math.nan if row[place][k] is None else row[place][k] for row in rows]
            columns[name] = np.array(values, dtype=np.float64)
    for name in ("column", "motion"):
        columns[name] = columns[name].astype(np.int64)
    columns[NAMED] = np.array([motion["name"] for motion in head["study"]["motions"]], dtype=np.str_)[columns["motion"]]
    for name in head["study"]["keep"]:
        columns[name] = _output(name, [row[3] for row in rows], head)
    columns["failure"] = np.array([row[4] for row in rows], dtype=np.str_)
    return columns


def _output(name: str, found: list[dict[str, Any] | None], head: Mapping[str, Any]) -> NDArray[Any]:
    """Return one output of runs as an array; "failed", "" or NaN for runs without outputs."""
    if name in WORDS:
        absent = FAILED if name == "verdict" else ""
        return np.array([absent if outputs is None else outputs[name] for outputs in found], dtype=np.str_)
    if kind_in(head).kept[name].kind is not None:
        return np.array([math.nan if outputs is None else outputs[name] for outputs in found])
    table = np.full((len(found), length_of(head, name)), math.nan)
    for row, outputs in zip(table, found, strict=True):
        if outputs is not None:
            row[: len(outputs[name])] = outputs[name]
    return table


def _text(value: Any) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else repr(value)
    return str(value)


def results_of(path: str | os.PathLike[str], study: Study | None = None) -> Results:
    """Return the results in a journal, of `study` with any number of samples if given.

    Raises InputError that begins with `path`.
    """
    if not os.path.isfile(path):
        raise InputError(f"{path}: No such file: the study has not been run here")
    results = Results.from_journal(path)
    if study is not None:
        with reading(path):
            samples = results.study["samples"] if study.random else study.samples
            check_same_study(results.head, study.with_runs(samples).fingerprint)
    return results
