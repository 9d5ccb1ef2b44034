"""Outputs of FMUs of structures that follow a motion, each in a process of its own; native FMUs of the same file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from support.child import call
from support.fmus import LINUX, Fmus
from support.inside import structures as inside


def outputs(
    fmu: Path, samples: NDArray[np.float64], h: float, folder: Path, values: dict[str, Any] | None = None
) -> NDArray[np.float64]:
    """Return all outputs after each step of h s under samples of three components; `values`: start values."""
    file = folder / "seen.npy"
    call(inside.follow, fmu, samples.tolist(), h, values or {}, file)
    found: NDArray[np.float64] = np.load(file)
    return found


def native_of(text: str, folder: Path) -> Path:
    """Return the native FMU of a file with this text; skips the test without ziglang."""
    pytest.importorskip("ziglang", reason="needs the extra native")
    file = folder / "structure.toml"
    file.write_text(text, encoding="utf-8")
    return Fmus.build(file, folder / "native.fmu", *LINUX)
