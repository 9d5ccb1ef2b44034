"""Files that are there whole or not at all."""

from __future__ import annotations

import os
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import InputError


def check_outputs(outputs: Iterable[Path | None], inputs: Iterable[Path | None]) -> None:
    """Raise InputError if an output cannot be meant or cannot be written: said before a run, not after it.

    That is a folder that is missing, a file that is read or written by the same command already. None is no file.
    """
    taken = [path for path in inputs if path is not None]
    for path in outputs:
        if path is None:
            continue
        if not path.parent.is_dir():
            raise InputError(f"{path}: No such folder: {path.parent}")
        if path.is_dir():
            raise InputError(f"{path}: is a folder, must be a file")
        for other in taken:
            if _same(path, other):
                raise InputError(f"{path}: must be another file than {other}, which it would overwrite")
        taken.append(path)


def _same(path: Path, other: Path) -> bool:
    try:
        return path.samefile(other)
    except OSError:  # one of them is not there yet
        return path.resolve() == other.resolve()


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a path beside `path` to write to, which takes its place once all is written.

    A full disk, or the end of the process, leaves the file of before, or none: never a part that looks like the whole.
    What is no ordinary file, such as a pipe, is written to as it is. An OSError speaks of `path`.
    """
    target = Path(path)
    if target.exists() and not target.is_file():
        yield target
        return
    partial = target.with_name(f".{target.stem}-{uuid.uuid4().hex}{target.suffix}")
    try:
        try:
            yield partial
            partial.replace(target)
        finally:
            partial.unlink(missing_ok=True)
    except OSError as error:
        error.filename, error.filename2 = os.fspath(path), None
        raise
