"""The platforms that a native FMU can hold, and the forms that it can have."""

from __future__ import annotations

from dataclasses import dataclass

from solver.kernels.machine.zig import LINUX, LINUX_ARM, MACOS, MACOS_ARM, WINDOWS, Target


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
class Platform:
    """One folder under binaries/: a library, of several parts where its system knows such ones."""

    suffix: str
    targets: tuple[Target, ...]


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
