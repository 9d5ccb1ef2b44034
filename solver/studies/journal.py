"""The journal of a study: the one file that holds its finished runs.

It has a first line about the study and one line for each run, each with a checksum in front. The checksum reveals a
line that a killed process, a full disk or a power failure left incomplete; it is cut off, and its run repeated. Lines
are only ever appended; the process that appends holds a lock, which ends with it.
"""

from __future__ import annotations

import itertools
import json
import os
import re
import sys
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import IO, Any

from ..common.errors import InputError, reading, shown
from ..common.files import check_size

SUFFIX = ".journal"
FORMAT = 1
LONGEST = 16 * 10**6  # bytes, longest line: the first one has all columns
_CUT_HEAD = re.compile(rb"[0-9a-f]{0,7}|[0-9a-f]{8}( (\{[^\n]*)?)?")  # an empty or truncated first line


class Journal(AbstractContextManager["Journal"]):
    """A journal to which runs are added, to be used as a context.

    It is created if it does not exist.

    Parameters
    ----------
    path : str or path
        The file.
    head : mapping
        The first line.
    tables : sequence of str
        Suffixes of the files that are written next to it.

    Raises
    ------
    InputError
        If the file is no journal, of another study or of other versions, if another process adds to it, or if it cannot
        be written; or if it does not exist and a file next to it would be overwritten.
    """

    def __init__(self, path: str | os.PathLike[str], head: Mapping[str, Any], tables: Sequence[str] = ()) -> None:
        self.path = Path(path)
        existing = [table for suffix in tables if (table := self.path.with_suffix(suffix)).exists()]
        if existing and not self.path.exists():
            raise InputError(
                f"{existing[0]}: is there already, without {self.path.name}: must be moved, or the results go to "
                "another folder"
            )
        self.finished: set[int] = set()  # numbers of the runs in it
        self.damaged = 0  # incomplete or corrupted lines
        with reading(self.path):
            if self.path.exists():
                check_size(self.path, sys.maxsize)
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
        # read the lines: the study, then the runs
        for number, line in enumerate(_lines(self._file), start=1):
            content = _content(number, line)
            if present is None:
                if content is None:
                    break
                present = _head(content)
                _check_same(present, head)
            elif content is not None:
                self.finished.add(_number(number, content))
            else:
                self.damaged += 1
            if line.endswith(b"\n"):  # else the process ended within it
                whole += len(line)
        if present is None:
            self._file.seek(0)
            if not _CUT_HEAD.fullmatch(self._file.read()):
                raise InputError("is not the journal of a study, must be one or not be there")
        # cut off an incomplete last line, and append from there
        self._file.truncate(whole)
        self._file.seek(whole)
        if present is None:
            self._write([{"format": FORMAT, **head}])

    def add(self, rows: Iterable[list[Any]]) -> None:
        """Add runs, each a list that begins with its number. Raises OSError.

        They are on disk when the method returns; runs that are finished already are skipped.
        """
        new = [row for row in rows if row[0] not in self.finished]
        if new:
            self._write(new)
            self.finished.update(row[0] for row in new)

    def _write(self, contents: list[Any]) -> None:
        with reading(self.path):
            self._file.write(b"".join(map(line_of, contents)))
            self._file.flush()
            os.fsync(self._file.fileno())

    def __exit__(self, *_: object) -> None:
        """Close the file, which releases the lock."""
        self._file.close()


def read_journal(
    path: str | os.PathLike[str],
    check_head: Callable[[dict[str, Any]], None] | None = None,
    check_row: Callable[[dict[str, Any], Any], None] | None = None,
) -> tuple[dict[str, Any], Iterator[list[Any]]]:
    """Read the first line of a journal, about its study, and its runs one by one, in any order.

    The file may be in use by the process that adds runs.

    Parameters
    ----------
    path : str or path
        The journal.
    check_head : callable, optional
        Called with the first line; the number of the line is added to its errors.
    check_row : callable, optional
        Called with the first line and each run; likewise.

    Returns
    -------
    head : dict
        The content of the first line.
    rows : iterator of list
        The runs.

    Raises
    ------
    InputError
        With a message that begins with `path`, if the file cannot be read or is no journal.
    """
    with reading(path):
        check_size(path, sys.maxsize)
        with open(path, "rb") as file:
            first = next(_lines(file), b"")
        if not first:
            raise InputError("is empty, must be the journal of a study")
        head = _head(_content(1, first))
        if check_head is not None:
            with _of_line(1):
                check_head(head)
        return head, _rows(path, head, len(first), check_row)


def _rows(
    path: str | os.PathLike[str],
    head: dict[str, Any],
    start: int,
    check_row: Callable[[dict[str, Any], Any], None] | None,
) -> Iterator[list[Any]]:
    with reading(path), open(path, "rb") as file:
        file.seek(start)
        for number, line in enumerate(_lines(file), start=2):
            content = _content(number, line)
            if content is None:
                continue
            _number(number, content)
            if check_row is not None:
                with _of_line(number):
                    check_row(head, content)
            yield content


def _lines(file: IO[bytes]) -> Iterator[bytes]:
    """Yield the lines of a file. Raises InputError for a line that is too long for a journal."""
    for number in itertools.count(1):
        line = file.readline(LONGEST)
        if not line:
            return
        if len(line) == LONGEST:
            raise InputError(f"line {number}: has {LONGEST} bytes or more, must be shorter in a journal")
        yield line


@contextmanager
def _of_line(number: int) -> Iterator[None]:
    """Add the number of the line to the message of an InputError."""
    try:
        yield
    except InputError as error:
        raise InputError(f"line {number}: {error}") from None


def _number(line: int, content: Any) -> int:
    """Return the number of the run in the content of a line. Raises InputError."""
    if not (isinstance(content, list) and content and type(content[0]) is int and content[0] >= 0):
        raise InputError(f"line {line}: {shown(content)}: must be a run, a list that begins with its number")
    return content[0]


def line_of(content: Any) -> bytes:
    """Return the line of a journal for a run, or for its study: checksum, blank and JSON text."""
    text = json.dumps(content, separators=(",", ":")).encode()
    return b"%08x %s\n" % (zlib.crc32(text), text)


def _content(number: int, line: bytes) -> Any:
    """Return the content of a line, None if it is incomplete. Raises InputError if it is complete but no JSON."""
    checksum, _, text = line.rstrip(b"\n").partition(b" ")
    if not line.endswith(b"\n") or checksum != b"%08x" % zlib.crc32(text):
        return None
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise InputError(f"line {number}: is no JSON, must be a run of a study") from None


def _head(content: Any) -> dict[str, Any]:
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise InputError("is not the journal of a study")
    for key, kind in (("study", dict), ("fingerprint", str), ("versions", dict)):
        if not isinstance(content.get(key), kind):
            raise InputError(f"line 1: {key} = {shown(content.get(key))}: must be as a study writes it")
    return content


def check_same_study(present: Mapping[str, Any], fingerprint: str) -> None:
    """Raise InputError unless the first line of a journal has this fingerprint."""
    if present["fingerprint"] != fingerprint:
        raise InputError(
            f"holds another study, {present['study'].get('name')} ({present['fingerprint']}), not this one "
            f"({fingerprint}): must be another file, or deleted"
        )


def _check_same(present: dict[str, Any], head: dict[str, Any]) -> None:
    check_same_study(present, head["fingerprint"])
    for name, version in head["versions"].items():
        if present["versions"].get(name) != version:
            raise InputError(
                f"was begun with {name} {present['versions'].get(name)}, this is {version}: numbers of both must not "
                "be mixed; go on with the other version, or begin in another file"
            )


def _lock(file: IO[bytes]) -> None:
    """Keep other processes from adding while this one has the file open. Raises InputError."""
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
