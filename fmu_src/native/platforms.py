"""The platforms that a native FMU can hold, and the forms that it can have."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Form:
    """The form of a native FMU."""

    fmi: int = 2  # version of the standard
    source: bool = False  # with the source code inside
    terminals: bool = False  # those that FMI 3.0 always has, in an FMU of FMI 2.0
    scalars: bool = False  # of FMI 3.0 without arrays
    real_outputs: bool = False  # without outputs that are no reals


USUAL_FORM = Form()


@dataclass(frozen=True)
class Target:
    """One machine as the compiler of the kernels and the linker know it."""

    triple: str  # LLVM's
    cpu: str  # the oldest that the code runs on
    linker: str  # zig's name of it, with the oldest system
    system: tuple[str, ...]  # options that link the system's C library


@dataclass(frozen=True)
class Platform:
    """One folder under binaries/: a library, of several parts where its system knows such ones."""

    suffix: str
    targets: tuple[Target, ...]


# x86-64-v2: every x86-64 processor of the last twelve years (SSE4.2, POPCNT), those without AVX2 included; of ARM the
# first of 64 bits.
_GLIBC, _UCRT, _APPLE = ("-Wl,-z,defs", "-lc", "-lm"), ("-lcompiler_rt",), ("-lSystem",)
LINUX = Target("x86_64-pc-linux-gnu", "x86-64-v2", "x86_64-linux-gnu.2.17", _GLIBC)
LINUX_ARM = Target("aarch64-unknown-linux-gnu", "cortex-a53", "aarch64-linux-gnu.2.17", _GLIBC)
WINDOWS = Target("x86_64-w64-windows-gnu", "x86-64-v2", "x86_64-windows-gnu", _UCRT)
MACOS = Target("x86_64-apple-macosx11", "x86-64-v2", "x86_64-macos.11.0", _APPLE)
MACOS_ARM = Target("arm64-apple-macosx11", "apple-m1", "aarch64-macos.11.0", _APPLE)
# version of FMI -> folder -> what is in it. For processors that FMI 2.0 has no name for it refers to those of 3.0.
PLATFORMS = {
    2: {
        "linux64": Platform(".so", (LINUX,)),
        "win64": Platform(".dll", (WINDOWS,)),
        "darwin64": Platform(".dylib", (MACOS, MACOS_ARM)),
        "aarch64-linux": Platform(".so", (LINUX_ARM,)),
    },
    3: {
        "x86_64-linux": Platform(".so", (LINUX,)),
        "x86_64-windows": Platform(".dll", (WINDOWS,)),
        "x86_64-darwin": Platform(".dylib", (MACOS,)),
        "aarch64-darwin": Platform(".dylib", (MACOS_ARM,)),
        "aarch64-linux": Platform(".so", (LINUX_ARM,)),
    },
}
