"""The guard of the PythonFMU (guard.c): compiled for Linux, and loaded in place of PythonFMU's own library."""

from __future__ import annotations

import hashlib
import importlib.metadata
import tempfile
from pathlib import Path

from solver.kernels.machine.folders import keep, kept

from .library import OPTIONS, compile_c, has_tools
from .platforms import PLATFORMS

SOURCE, STATUS = (Path(__file__).with_name(name) for name in ("guard.c", "status.h"))
NEIGHBOUR = "pythonfmu.so"  # library that guard.c loads from its own folder
FOLDER = "binaries/linux64"
WITHOUT = (  # for the page inside the FMU
    "It was built without ziglang and has no guard: unpacked below a folder with a letter beyond ASCII, # or % in its "
    "name it ends the process that loads it."
)


def guarded(files: dict[str, bytes]) -> dict[str, bytes]:
    """Return the files of a PythonFMU with the guard in place of PythonFMU's library, which stays beside it.

    The files are unchanged if no compiler is installed. Raises OSError.
    """
    (name,) = (file for file in files if file.startswith(f"{FOLDER}/"))
    if not has_tools():
        return files
    return files | {f"{FOLDER}/{NEIGHBOUR}": files[name], name: _library()}


def _library() -> bytes:
    """Return the guard as a library, cached per user, since it does not depend on the column."""
    (target,) = PLATFORMS[2]["linux64"].targets
    texts = "".join(file.read_text(encoding="utf-8") for file in (SOURCE, STATUS))
    made_with = f"{texts} {importlib.metadata.version('ziglang')} {OPTIONS} {target}"
    name = hashlib.sha256(made_with.encode()).hexdigest()[:16]
    if (found := kept("guard", name)) is not None:
        return found
    with tempfile.TemporaryDirectory(prefix="guard_") as folder:
        output = Path(folder) / "guard.so"
        compile_c(target, [SOURCE], output, options=["-ldl"])
        content = output.read_bytes()
    keep("guard", name, content)
    return content
