"""User files: checks before reading and writing, and atomic writes."""

from __future__ import annotations

import codecs
import csv
import errno
import os
import re
import stat
import tomllib
import unicodedata
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .errors import InputError, shown

MB = 10**6
MOST_TOML = 4 * MB  # a column of 1000 blocks has 0.2 MB
MOST_RECORD = 64 * MB  # an hour of three columns at 200 Hz has 40 MB
MOST_TABLE = 256 * MB  # limit for tables of histories
LONGEST_NAME = 200  # characters; a suffix has to fit into the 255 bytes of file systems
MARKS = ((codecs.BOM_UTF8, "UTF-8"), (codecs.BOM_UTF16_LE, "UTF-16"), (codecs.BOM_UTF16_BE, "UTF-16"))
FORMULA = ("=", "+", "-", "@", "\t", "\r")  # first characters of a text that spreadsheets run as a formula
DECIMAL_COMMA = re.compile(r"=\s*([-+]?\d+,\d+)\s*(?:[,}#]|$)")


def check_file_name(key: str, value: object) -> str:
    """Return `value` if it is a file name that is valid on every system and has no folder.

    Letters, digits, "_", "-", "." and space are valid; the first is a letter, a digit or "_", the last neither a dot
    nor a space.

    Raises InputError for any other value.
    """
    plain = unicodedata.normalize("NFC", value) if isinstance(value, str) and len(value) <= LONGEST_NAME else ""
    known = all(letter.isalnum() or letter in "-_. " for letter in plain)
    if not plain or not known or plain[0] in "-. " or plain[-1] in ". ":
        raise InputError(
            f'{key} = {shown(value)}: must be a file name of letters, digits, "_", "-", "." and space, at most '
            f'{LONGEST_NAME}, that begins with a letter, a digit or "_" and does not end with a dot or a space'
        )
    return str(value)


def printable(text: str) -> str:
    """Replace control codes, which a terminal would obey, and bytes that are not UTF-8 by escapes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def identifier_of(name: str) -> str:
    """Convert a file name to a C identifier: "_" for each invalid character, and before a leading digit."""
    identifier = re.sub("[^A-Za-z0-9_]", "_", name)
    return f"_{identifier}" if identifier[0].isdigit() else identifier


def check_size(path: str | os.PathLike[str], most: int) -> None:
    """Raise InputError unless `path` is an ordinary file of at most `most` bytes; OSError if it does not exist.

    A pipe or a device may have no end, or deliver nothing: it is not opened.
    """
    found = os.stat(path)
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(found.st_mode):
        raise InputError("is a pipe or a device, must be an ordinary file")
    if found.st_size > most:
        raise InputError(f"has {found.st_size / MB:.4g} MB, must have at most {most / MB:.4g} MB")


def content_of(path: str | os.PathLike[str], most: int) -> bytes:
    """Return the content of an ordinary file of at most `most` bytes.

    Raises InputError if it is no ordinary file or too large, OSError if it cannot be read.
    """
    check_size(path, most)
    with open(path, "rb") as file:
        return file.read(most + 1)[:most]  # it may have grown since


def toml_of(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Parse a TOML file; the error message names a byte order mark or a decimal comma as the cause.

    Raises InputError, ValueError for invalid TOML, OSError.
    """
    content = content_of(path, MOST_TOML)
    for mark, encoding in MARKS:
        if content.startswith(mark):
            raise InputError(f"begins with a byte order mark (BOM) of {encoding}: must be UTF-8 without one")
    text = content.decode("utf-8").replace("\r\n", "\n")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError("is nested too deeply, must be a few tables") from None
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"at line (\d+)", str(error))
        line = text.splitlines()[int(place[1]) - 1] if place else ""
        if place and (comma := DECIMAL_COMMA.search(line)):
            raise InputError(f"line {place[1]}: {with_point(comma[1])}") from None
        raise


def with_point(text: str) -> str:
    """Return the advice for a number with a decimal comma; "" for any other text."""
    number = re.fullmatch(r"([-+]?\d*),(\d+(?:[eEdD][-+]?\d+)?)", text.strip())
    return f"{number[0]} has a decimal comma, must be {number[1]}.{number[2]} with a decimal point" if number else ""


def check_outputs(outputs: Iterable[Path | None], inputs: Iterable[Path | None], force: bool = False) -> None:
    """Raise InputError before a run if an output file is invalid or cannot be written.

    Refused are a missing folder, a file that the same command reads or writes already, and an existing file unless
    `force` is set.

    Parameters
    ----------
    outputs, inputs : iterable of Path or None
        The files that the command writes and reads; None for no file.
    force : bool
        Whether existing files may be overwritten.
    """
    taken = [*filter(None, inputs)]
    for path in filter(None, outputs):
        if not path.parent.is_dir():
            raise InputError(f"{path}: No such folder: {path.parent}")
        if path.is_dir():
            raise InputError(f"{path}: is a folder, must be a file")
        for other in taken:
            if _same(path, other):
                raise InputError(f"{path}: must be another file than {other}, which it would overwrite")
        if path.is_file() and not force:
            raise InputError(f"{path}: is there already, --force overwrites it")
        taken.append(path)


def _same(path: Path, other: Path) -> bool:
    try:
        return path.samefile(other)
    except OSError:  # one of them does not exist yet
        return path.resolve() == other.resolve()


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path in the same folder; on success, replace `path` by the file written there.

    After a full disk, or the end of the process, `path` has the previous file or none: never an incomplete one. A path
    that is no ordinary file, such as a pipe, is written directly. A symbolic link stays: the file that it leads to is
    replaced. An OSError names `path`.
    """
    target = Path(path)
    if target.is_symlink():
        target = target.resolve()
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


def write_table(path: str | os.PathLike[str], names: Iterable[str], rows: Iterable[Iterable[Any]]) -> None:
    """Write a CSV file atomically; text that a spreadsheet would run as a formula is escaped.

    Parameters
    ----------
    path : path-like
        The file.
    names : iterable of str
        The header.
    rows : iterable of iterable
        The cells of each row.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    with whole_file(path) as partial, open(partial, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(map(_plain, names))
        writer.writerows(map(_plain, row) for row in rows)


def _plain(cell: Any) -> Any:
    """Put an apostrophe before a text that a spreadsheet would run as a formula; keep other cells."""
    if not isinstance(cell, str) or not cell.startswith(FORMULA):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell
