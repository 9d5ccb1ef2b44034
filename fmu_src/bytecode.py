"""Bytecode of the Python files in an FMU: hosts of the same Python need not compile 300 files at each start.

Needed by the builder only. Another Python ignores it and compiles the sources. Archives are read by `zipimport`, which
expects bytecode beside its source.
"""

from __future__ import annotations

import marshal
from importlib.util import MAGIC_NUMBER, source_hash
from pathlib import PurePosixPath

HASHED = (1).to_bytes(4, "little")  # flags of a file that is valid for its source, and not checked against it
SAME_BYTES = 2  # version of marshal whose output does not depend on reference counts


def bytecode_of(files: dict[str, bytes]) -> dict[str, bytes]:
    """Return the bytecode of all Python files of an archive, by path, for the Python that runs."""
    found = {}
    for name, source in files.items():
        path = PurePosixPath(name)
        if path.suffix == ".py":
            code = compile(source, path.name, "exec", dont_inherit=True, optimize=0)
            found[f"{name}c"] = MAGIC_NUMBER + HASHED + source_hash(source) + marshal.dumps(code, SAME_BYTES)
    return found
