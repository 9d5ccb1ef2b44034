"""Where machine code stays: beside its sources in a checkout, in the user's cache folder if they are installed.

A package manager removes what it has installed, and nothing else: machine code in `site-packages` would outlast the
project there. This module needs nothing outside the standard library; FMUs run it before they import the solver.
"""

import os
import sys
from pathlib import Path

INSTALLED = {"site-packages", "dist-packages"}  # folders that a package manager looks after


def user_folder() -> Path:
    """The project's folder for what can be recreated: MULTIBLOCK_CACHE_DIR, or one in the cache folder of the user.

    Raises RuntimeError if the user has no home.
    """
    given = os.environ.get("MULTIBLOCK_CACHE_DIR")
    if given:
        return Path(given).absolute()
    if sys.platform == "win32":
        parent = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        parent = Path.home() / "Library" / "Caches"
    else:
        parent = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return parent / "multiblock-fmu"


def code_folder(source: Path, package: str, numbas: str) -> str:
    """Folder for the machine code of a source file; "" for `__pycache__` beside it.

    package: name of the package that the kernels belong to; in an FMU it is a copy, which brings its machine code.
    numbas: NUMBA_CACHE_DIR. numba looks elsewhere if nothing can be written to the folder.
    """
    writable = os.access(source.parent, os.W_OK)
    if package.partition(".")[0] != "solver":
        return "" if writable else numbas
    beside = writable and not INSTALLED.intersection(source.parts)
    if not os.environ.get("MULTIBLOCK_CACHE_DIR") and (numbas or beside):
        return numbas
    try:
        return str(user_folder() / "kernels")
    except RuntimeError:
        return ""
