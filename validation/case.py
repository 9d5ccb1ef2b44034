"""A case: a question with its source, model, what is fitted and what is predicted, and the answer to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure


class AbsentError(Exception):
    """Data or a program that a case needs is not on this machine; the message says where to get it."""


@dataclass(frozen=True)
class Outcome:
    """The answer of a case: lines to read, numbers (JSON), and a figure."""

    lines: Sequence[str]
    numbers: dict[str, Any]
    figure: Figure | None = None


@dataclass(frozen=True)
class Case:
    """compute: the answer, given the folder of data (None: there is none). Raises AbsentError, InputError for bad data.

    fitted, predicted: what the model was given of the truth, and what it says without being given it. takes_rims:
    whether `compute` takes widths of rims over those of their faces too, to answer for these beside whole faces.
    """

    name: str
    title: str
    source: str
    model: str
    fitted: str
    predicted: str
    compute: Callable[..., Outcome] = field(repr=False)
    takes_rims: bool = False

    def answer(self, data: Path | None, rims: Sequence[float] = ()) -> Outcome:
        """Return the answer, with rims if any are given and the case takes them."""
        return self.compute(data, rims) if self.takes_rims else self.compute(data)


def data_folder(data: Path | None, name: str, advice: str) -> Path:
    """Return the folder `name` of the user's data. Raises AbsentError with the advice on where to get it."""
    if data is None or not (data / name).is_dir():
        place = "--data FOLDER" if data is None else str(data)
        raise AbsentError(f"needs {place} to hold {name}: {advice}")
    return data / name
