"""Licences and external dependencies of an FMU, in the files that the standard names (FMI 3.0.2, 2.5.1.1).

Needed by the builder only. FMI 2.0 defines the folder of licences (2.0.2, 2.3); its tools ignore the rest.
"""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

import fmu_src
from solver.common.errors import InputError

FOLDER = "documentation/licenses"
OWN = "multiblock-fmu"
REQUIRED = "numpy>=1.26,<3\n"  # of the FMU that runs in Python, as pip takes it: `pythonfmu deploy`


def legal_files(needs: str, *inside: str) -> dict[str, bytes]:
    """Return the licences of this project and of the distributions `inside`, and the needs, by path in the FMU.

    Raises InputError for a distribution that is installed without its licence.
    """
    files = {f"{FOLDER}/license.txt": _licence(OWN), "documentation/externalDependencies.txt": f"{needs}\n".encode()}
    return files | {f"{FOLDER}/{name}.txt": _licence(name) for name in inside}


def _licence(name: str) -> bytes:
    clone = Path(fmu_src.__path__[0]).parent / "LICENSE"
    if name == OWN and clone.is_file():
        return clone.read_bytes()
    installed = metadata.distribution(name)
    text = installed.read_text("licenses/LICENSE") or installed.read_text("LICENSE")
    if not text:
        raise InputError(f"{name}: is installed without its licence, which the FMU has to carry; install it again")
    return text.encode()
