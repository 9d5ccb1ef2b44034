"""The origin of a report: SHA-256 of its input files, sources of the densities in a file of a model, versions."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ... import __version__
from ...common.digits import three_digits
from ...common.files import printable, toml_of
from ...models.column.materials import MATERIALS

MATERIAL_SHEET = ("block in the file", "material", "density (kg/m³)", "source")
GIVEN = "given in the file"
# the versions on which the numbers of a report depend
SOFTWARE = {"multiblock-fmu": __version__, "Python": platform.python_version(), "numpy": np.__version__}


def with_meshes(paths: Iterable[Path]) -> list[Path]:
    """Return the files, each TOML file followed by the meshes that its blocks name; every file once."""
    found: dict[Path, None] = {}
    for path in paths:
        found[path] = None
        tables = toml_of(path).get("block", []) if path.suffix.lower() == ".toml" else []
        found |= {path.parent / table["file"]: None for table in tables if "file" in table}
    return list(found)


def hashed(paths: Iterable[Path]) -> list[tuple[str, str]]:
    """Return the name and the SHA-256 of each file. Raises OSError."""
    return [(printable(str(path)), hashlib.sha256(path.read_bytes()).hexdigest()) for path in paths]


def sources_of(path: Path) -> list[tuple[str, ...]]:
    """Return the number, material, density and source of each block in the TOML file of a model, as texts."""
    data = toml_of(path)
    rows: list[tuple[str, ...]] = []
    for number, table in enumerate(data["block"], start=1):
        name = table.get("material", data.get("material", "not named"))
        source = MATERIALS[name].source if name in MATERIALS else GIVEN
        if "density" in table or "mass" in table:
            source = GIVEN if name not in MATERIALS else f"density or mass {GIVEN}; else {source}"
        density = table.get("density", None if "mass" in table or name not in MATERIALS else MATERIALS[name].density)
        shown = f"mass {three_digits(table['mass'])} kg" if density is None else three_digits(density)
        rows.append((str(number), name, shown, source))
    return rows
