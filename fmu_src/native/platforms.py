"""The platforms that a native FMU can hold."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Target:
    """One machine as the compiler of the kernels and the linker know it."""

    triple: str  # LLVM's
    cpu: str  # the oldest that the code runs on
    linker: str  # zig's name of it, with the oldest system


@dataclass(frozen=True)
class Platform:
    """One folder under binaries/: a library, of several parts where its system knows such ones."""

    suffix: str
    targets: tuple[Target, ...]


# x86-64-v2: every x86-64 processor of the last twelve years (SSE4.2, POPCNT), those without AVX2 included.
PLATFORMS = {
    "linux64": Platform(".so", (Target("x86_64-pc-linux-gnu", "x86-64-v2", "x86_64-linux-gnu.2.17"),)),
    "win64": Platform(".dll", (Target("x86_64-w64-windows-gnu", "x86-64-v2", "x86_64-windows-gnu"),)),
    "darwin64": Platform(
        ".dylib",
        (
            Target("x86_64-apple-macosx11", "x86-64-v2", "x86_64-macos.11.0"),
            Target("arm64-apple-macosx11", "apple-m1", "aarch64-macos.11.0"),
        ),
    ),
}
