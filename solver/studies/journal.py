"""The journal of a study: the one file that its runs are kept in as they end. Whatever is in it was finished.

A line of text for each run, after a first line about the study, each with a checksum in front: what a killed process,
a full disk or a lost power leaves of a line is told from a whole one, cut off, and that run made again. Lines are only
ever added; who adds holds a lock that ends with the process.
"""

from __future__ import annotations

import json
import os
import re
import zlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from ..errors import InputError, reading

SUFFIX = ".journal"
FORMAT = 1
_CUT_HEAD = re.compile(rb"[0-9a-f]{0,7}|[0-9a-f]{8}( (\{[^\n]*)?)?")


class Journal:
    """A journal that runs are added to: `finished` are the numbers of those that it has. Use it as a context.

    It is made if it is not there. Raises InputError if the file is no journal, of another study or of other versions,
    if somebody else adds to it, or if it cannot be written.
    """

    def __init__(self, path: str | os.PathLike[str], head: Mapping[str, Any]) -> None:
        self.path = Path(path)
        self.finished: set[int] = set()
        self.damaged = 0  # lines that were cut off or spoilt
        with reading(self.path):
            self._file = open(self.path, "a+b")  # noqa: SIM115  closed by __exit__
            try:
                _lock(self._file)
                self._begin(dict(head))
            except BaseException:
                self._file.close()
                raise

    def _begin(self, head: dict[str, Any]) -> None:
        self._file.seek(0)
        whole = 0
        present: dict[str, Any] | None = None
        for line in self._file:
            content = _content(line)
            if present is None:
                if content is None:
                    break
                present = _head(content)
                _check_same(present, head)
            elif content is not None:
                self.finished.add(content[0])
            else:
                self.damaged += 1
            whole += len(line)
            if not line.endswith(b"\n"):  # the process ended within the line
                whole -= len(line)
        if present is None:
            self._file.seek(0, os.SEEK_END)
            if self._file.tell() > 0 and not _is_cut_head(self._file):
                raise InputError("is not the journal of a study, must be one or not be there")
            whole = 0
        self._file.truncate(whole)
        self._file.seek(whole)
        if present is None:
            self._write([{"format": FORMAT, **head}])

    def add(self, rows: Iterable[list[Any]]) -> None:
        """Add runs, each a list that begins with its number; they are on the disk when this returns. Raises OSError."""
        new = [row for row in rows if row[0] not in self.finished]
        if new:
            self._write(new)
            self.finished.update(row[0] for row in new)

    def _write(self, contents: list[Any]) -> None:
        with reading(self.path):
            self._file.write(b"".join(map(_line, contents)))
            self._file.flush()
            os.fsync(self._file.fileno())

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file, which gives the lock free."""
        self._file.close()


def read_journal(path: str | os.PathLike[str]) -> tuple[dict[str, Any], Iterator[list[Any]]]:
    """What a journal says of its study, and its runs one by one, in any order; it may be in use.

    Raises InputError that begins with `path` if it cannot be read or is no journal.
    """
    with reading(path), open(path, "rb") as file:
        first = file.readline()
        if not first:
            raise InputError("is empty, must be the journal of a study")
        return _head(_content(first)), _rows(path, len(first))


def _rows(path: str | os.PathLike[str], start: int) -> Iterator[list[Any]]:
    with reading(path), open(path, "rb") as file:
        file.seek(start)
        for line in file:
            content = _content(line)
            if content is not None:
                yield content


def _line(content: Any) -> bytes:
    text = json.dumps(content, separators=(",", ":")).encode()
    return b"%08x %s\n" % (zlib.crc32(text), text)


def _content(line: bytes) -> Any:
    """What a line says, None where it is not whole."""
    checksum, _, text = line.rstrip(b"\n").partition(b" ")
    if not line.endswith(b"\n") or checksum != b"%08x" % zlib.crc32(text):
        return None
    return json.loads(text)


def _head(content: Any) -> dict[str, Any]:
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise InputError("is not the journal of a study")
    return content


def _is_cut_head(file: IO[bytes]) -> bool:
    """Whether all there is in a file is a first line that was cut off."""
    file.seek(0)
    return _CUT_HEAD.fullmatch(file.read()) is not None


def _check_same(present: dict[str, Any], head: dict[str, Any]) -> None:
    if present["fingerprint"] != head["fingerprint"]:
        raise InputError(
            f"holds another study, {present['study']['name']} ({present['fingerprint']}), not this one "
            f"({head['fingerprint']}): must be another file, or deleted"
        )
    for name, version in head["versions"].items():
        if present["versions"].get(name) != version:
            raise InputError(
                f"was begun with {name} {present['versions'].get(name)}, this is {version}: numbers of both must not "
                "be mixed; go on with the other, or begin anew in another file"
            )


def _lock(file: IO[bytes]) -> None:
    """Keep everybody else from adding, as long as this process has the file open."""
    try:
        if os.name == "nt":
            import msvcrt

            file.seek(2**40)  # far beyond the end: others may read
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined,unused-ignore]
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise InputError("is being added to by another process, must be left to it or given another name") from None
