"""The identifier of the kernel sources: machine code is stored by it, so that a changed kernel gets new code."""

import hashlib
from pathlib import Path

from .bounds import BOUNDS

KERNELS = Path(__file__).parent.parent
# of this package only what decides the machine code
HASHED = {"emitting.py", "groups.py", "kinds.py"}


def _identifier() -> str:
    content = hashlib.sha256()
    for file in sorted(KERNELS.rglob("*.py")):
        if file.parent.name == "machine" and file.name not in HASHED:
            continue
        content.update(file.relative_to(KERNELS).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return content.hexdigest()[:16]


SOURCES = _identifier() + ("-bounds" if BOUNDS else "")
