"""Levels of processors: machine code is made for each, and the highest that this processor has is run."""

import os
import platform
import re
import sys
from functools import lru_cache
from itertools import takewhile
from pathlib import Path

# from the highest to the one that every supported processor has, as LLVM names them
X86 = ("x86-64-v4", "x86-64-v3", "x86-64-v2")
ARM = ("arm64",)
# processor features that the two higher levels add, by their names in Linux
_NEEDED = {
    "x86-64-v3": ("avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe"),
    "x86-64-v4": ("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"),
}
_AVX2 = 40  # of Windows' IsProcessorFeaturePresent


def is_arm() -> bool:
    """Return True on a 64-bit ARM processor."""
    return platform.machine().lower() in ("arm64", "aarch64")


@lru_cache(maxsize=1)
def levels() -> tuple[str, ...]:
    """Return the levels that this processor runs, the highest first; MULTIBLOCK_LEVEL names a lower one to start with.

    Raises ValueError for a level that it does not run.
    """
    found = ARM if is_arm() else _of_x86()
    highest = os.environ.get("MULTIBLOCK_LEVEL", found[0])
    if highest not in found:
        raise ValueError(f"MULTIBLOCK_LEVEL={highest}: must be of {', '.join(found)}")
    return found[found.index(highest) :]


def _of_x86() -> tuple[str, ...]:
    higher = list(takewhile(_has, reversed(X86[:-1])))  # than the one that every processor has
    return (*reversed(higher), X86[-1])


def _has(level: str) -> bool:
    if sys.platform == "linux":
        try:
            found = re.search(r"^flags\s*:(.*)$", Path("/proc/cpuinfo").read_text(encoding="ascii"), re.MULTILINE)
        except (OSError, UnicodeDecodeError):
            return False
        return found is not None and set(_NEEDED[level]) <= set(found[1].split())
    if sys.platform == "win32" and level == "x86-64-v3":
        import ctypes

        return bool(ctypes.windll.kernel32.IsProcessorFeaturePresent(_AVX2))
    return False  # Windows reports AVX2 only; recent processors of macOS are ARM
