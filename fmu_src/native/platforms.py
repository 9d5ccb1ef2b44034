"""The platforms that a native FMU can contain, and the options of its archive."""

from __future__ import annotations

from dataclasses import dataclass

from solver.kernels.machine.zig import LINUX, LINUX_ARM, MACOS, MACOS_ARM, WINDOWS, Target


@dataclass(frozen=True)
class Form:
    """The options of a native FMU."""

    fmi: int = 2  # version of the standard
    source: bool = False  # with the source code inside
    terminals: bool = False  # those of FMI 3.0, in an FMU of FMI 2.0 too
    scalars: bool = False  # of FMI 3.0 without arrays
    real_outputs: bool = False  # without outputs that are no reals


USUAL_FORM = Form()


@dataclass(frozen=True)
class Platform:
    """One folder under binaries/: a library, of several parts where the system supports universal ones."""

    suffix: str
    targets: tuple[Target, ...]


# version of FMI -> folder -> library; FMI 2.0 refers to the names of 3.0 for processors that it does not name
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
