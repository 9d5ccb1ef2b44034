"""The private cache folder of the user: machine code and other files that can be recreated."""

import hashlib
import os
import stat
import sys
from contextlib import suppress
from pathlib import Path

OF_OTHERS = stat.S_IWGRP | stat.S_IWOTH
DIGEST = 32  # bytes of the checksum before the content


def user_folder() -> Path:
    """Return the project's cache folder: MULTIBLOCK_CACHE_DIR, or one in the cache folder of the user.

    Raises RuntimeError if the user has no home.
    """
    if given := os.environ.get("MULTIBLOCK_CACHE_DIR"):
        return Path(given).absolute()
    if sys.platform == "win32":
        parent = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        parent = Path.home() / "Library" / "Caches"
    else:
        parent = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return parent / "multiblock-fmu"


class NotPrivateError(OSError):
    """The error of a folder that others can write to, or could have: nothing in it is used."""


def make_private(folder: Path) -> None:
    """Make a folder that the user alone can write to, and check its parents. Raises OSError, NotPrivateError.

    Where others may add folders but not replace those of the user (sticky), nothing is changed.
    """
    for place in reversed([place for place in (folder, *folder.parents) if not place.exists()]):
        place.mkdir(mode=0o700, exist_ok=True)
    if not hasattr(os, "getuid"):  # folders of a user on Windows are his own
        return
    if folder.stat().st_uid == os.getuid() and not folder.stat().st_mode & stat.S_ISVTX:  # as /tmp, of root
        folder.chmod(folder.stat().st_mode & ~OF_OTHERS)
    for place in (folder, *folder.resolve().parents):
        about = place.stat()
        if about.st_uid not in (os.getuid(), 0) or (about.st_mode & OF_OTHERS and not about.st_mode & stat.S_ISVTX):
            raise NotPrivateError(f"{place}: others can write to it")


def is_private(folder: Path) -> bool:
    """Return True if a folder is the user's, no link, and closed to others, whatever the modes of the files inside."""
    about = folder.lstat()
    if stat.S_ISLNK(about.st_mode) or not hasattr(os, "getuid"):
        return not stat.S_ISLNK(about.st_mode)
    return about.st_uid == os.getuid() and not about.st_mode & (stat.S_IRWXG | stat.S_IRWXO)


def private_folder(name: str, parent: Path | None = None) -> Path:
    """Return a folder, in that of the user or in `parent`, which only the user can enter; make it if there is none.

    Raises RuntimeError if the user has no home, OSError, NotPrivateError.
    """
    folder = (parent or user_folder()) / name
    make_private(folder.parent)
    folder.mkdir(mode=0o700, exist_ok=True)
    if not is_private(folder):
        raise NotPrivateError(f"{folder}: others could write to it, must be open to its owner alone; it can be deleted")
    return folder


def write_whole(file: Path, content: bytes) -> None:
    """Write a file completely or not at all, even if other processes write it too. Raises OSError."""
    partial = file.with_name(f"{file.name}.{os.getpid()}")
    try:
        partial.write_bytes(content)
        partial.replace(file)
    finally:
        partial.unlink(missing_ok=True)


def store(kind: str, name: str, content: bytes) -> None:
    """Store content that can be recreated in the private folder `kind`. Raises RuntimeError or OSError."""
    write_whole(private_folder(kind) / name, hashlib.sha256(content).digest() + content)


def keep(kind: str, name: str, content: bytes) -> None:
    """Store content as `store` does. If that fails nothing is stored."""
    with suppress(OSError, RuntimeError):
        store(kind, name, content)


def kept(kind: str, name: str) -> bytes | None:
    """Return the content stored by `store`; None if it is missing or damaged, or others could have written it."""
    try:
        data = (private_folder(kind) / name).read_bytes()
    except (OSError, RuntimeError):
        return None
    content = data[DIGEST:]
    return content if hashlib.sha256(content).digest() == data[:DIGEST] else None
