"""Files that are there whole or not at all."""

from __future__ import annotations

import os
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


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
