"""Linking of object code to shared libraries for any platform, by zig (package ziglang)."""

import importlib.util
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Target:
    """A target of the kernel compiler and the linker."""

    triple: str  # LLVM's
    cpu: str  # the oldest that the code runs on
    linker: str  # zig's name of it, with the oldest system
    system: tuple[str, ...]  # options that link the system's C library


# x86-64-v2: every x86-64 processor of the last twelve years (SSE4.2, POPCNT), those without AVX2 included; of ARM the
# first of 64 bits.
_GLIBC, _UCRT, _APPLE = ("-Wl,-z,defs", "-lc", "-lm"), ("-lcompiler_rt",), ("-lSystem",)
LINUX = Target("x86_64-pc-linux-gnu", "x86-64-v2", "x86_64-linux-gnu.2.17", _GLIBC)
LINUX_ARM = Target("aarch64-unknown-linux-gnu", "cortex-a53", "aarch64-linux-gnu.2.17", _GLIBC)
WINDOWS = Target("x86_64-w64-windows-gnu", "x86-64-v2", "x86_64-windows-gnu", _UCRT)
MACOS = Target("x86_64-apple-macosx11", "x86-64-v2", "x86_64-macos.11.0", _APPLE)
MACOS_ARM = Target("arm64-apple-macosx11", "apple-m1", "aarch64-macos.11.0", _APPLE)
# exports of the system's C library that a library for Windows uses; a missing one fails to link
OF_WINDOWS = (
    *("atan2", "expm1", "hypot", "pow", "asin", "log"),
    *("calloc", "malloc", "free", "strtod", "atoi", "__stdio_common_vsprintf"),
    *("memchr", "memcmp", "memcpy", "memset", "strchr", "strcmp", "strcpy", "strlen", "strncmp"),
)
BESIDE_WINDOWS = Path(__file__).with_name("windows.c")
PLAIN = ("-std=c11", "-O2", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off")


def has_linker() -> bool:
    """Return True if zig is installed."""
    return importlib.util.find_spec("ziglang") is not None


def link(target: Target, objects: Sequence[Path], output: Path, options: Sequence[str] = ()) -> None:
    """Link objects to a shared library with the system's own C library only. Raises OSError."""
    objects = list(objects)
    # Windows: an import library for its C library, and the C functions that this lacks
    if target.linker == WINDOWS.linker:
        beside = output.parent / f"{BESIDE_WINDOWS.stem}.o"
        compile_file(target, BESIDE_WINDOWS, beside, PLAIN)
        objects += [beside, _imports(output.parent)]
    compiler = "cc", "-target", target.linker
    _zig(*compiler, "-shared", "-s", "-nostdlib", *objects, *target.system, *options, "-o", output)


def compile_file(target: Target, source: Path, output: Path, options: Sequence[str]) -> None:
    """Compile a C file to an object. Raises OSError."""
    _zig("cc", "-target", target.linker, *options, "-c", source, "-o", output)


def _imports(folder: Path) -> Path:
    """Return the import library for the C library of Windows."""
    definition, made = folder / "imports.def", folder / "imports.lib"
    definition.write_text("\n".join(("LIBRARY ucrtbase.dll", "EXPORTS", *OF_WINDOWS)), encoding="utf-8")
    _zig("dlltool", "-m", "i386:x86-64", "-d", definition, "-l", made)
    return made


def _zig(*arguments: Path | str) -> None:
    """Run the compiler, or a tool that comes with it. Raises OSError."""
    command = [sys.executable, "-m", "ziglang", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise OSError(f"{' '.join(command[3:])}: failed\n{done.stderr}")
