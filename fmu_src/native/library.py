"""The compilation of the C layer, its table and the kernels' object code to one shared library for each platform."""

from __future__ import annotations

import importlib.util
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from solver.common.errors import InputError
from solver.common.executors import cores
from solver.kernels.machine.bounds import BOUNDS
from solver.kernels.machine.packaging import object_code
from solver.kernels.machine.zig import PLAIN, Target, compile_file, link

from . import symbols
from .platforms import PLATFORMS

FACES = {2: "fmi2.c", 3: "fmi3.c"}  # version of FMI -> C file of its functions around the core
OWN_HEADERS = tuple(Path(__file__).with_name(name) for name in ("core.h", "face.h", "status.h"))
OPTIONS = (*PLAIN, "-Wall", "-Wextra", "-Werror")


def sources(fmi: int) -> tuple[Path, ...]:
    """Return the C files to compile for a version of FMI."""
    return tuple(Path(__file__).with_name(name) for name in ("core.c", FACES[fmi]))


TOOLS = ("ziglang", "fmpy")  # the compiler, and the header files of FMI


def has_tools() -> bool:
    """Return True if the tools to compile and link are installed."""
    return all(importlib.util.find_spec(package) is not None for package in TOOLS)


def check_tools() -> None:
    """Raise InputError if the linker, or the header files of FMI, are not installed."""
    if BOUNDS:
        raise InputError("--native: its kernels cannot check their bounds, unset MULTIBLOCK_BOUNDS")
    for package in TOOLS:
        if importlib.util.find_spec(package) is None:
            raise InputError(f'--native: {package} is not installed: pip install "multiblock-fmu[native]"')


def headers() -> Path:
    """Return the folder with the header files of the FMI standard, which FMPy carries."""
    spec = importlib.util.find_spec("fmpy")
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).parent / "c-code"


def compile_c(
    target: Target, sources: Sequence[Path], output: Path, includes: Sequence[Path] = (), options: Sequence[str] = ()
) -> None:
    """Compile C files, and link them, with the object files among `sources`, to the shared library `output`.

    Object files are written beside it. `includes` are folders with header files, `options` those of the linker. Only
    the system's own C library is linked: zig would have to build its other default libraries first. Raises OSError if
    the compiler fails.
    """
    searched = [f"-I{place}" for place in (headers(), *includes)]
    objects = []
    for source in sources:
        objects.append(output.parent / f"{source.stem}.o" if source.suffix == ".c" else source)
        if source.suffix == ".c":
            compile_file(target, source, objects[-1], [*OPTIONS, *searched])
    link(target, objects, output, options)


def libraries(
    name: str, platforms: list[str], generated: dict[str, str], group: str, fmi: int = 2
) -> dict[str, tuple[bytes, list[symbols.Symbols]]]:
    """Return for each platform, a name in PLATFORMS[fmi], its library and the symbols that each of its parts needs.

    `generated` has the texts of the generated header files by name, `group` the kernels. Raises InputError if a library
    needs symbols of Python.
    """
    # machine code of the kernels for each target
    check_tools()
    known = PLATFORMS[fmi]
    targets = list(dict.fromkeys(target for platform in platforms for target in known[platform].targets))
    codes = dict(zip(targets, object_code(group, targets), strict=True))
    # compile and link the platforms in parallel
    with tempfile.TemporaryDirectory(prefix="native_") as temporary:
        folder = Path(temporary)
        for file, text in generated.items():
            (folder / file).write_text(text, encoding="utf-8")

        def made(platform: str) -> bytes:
            begun = time.perf_counter()
            suffix, parts = known[platform].suffix, known[platform].targets
            content = symbols.universal([_linked(name, part, suffix, folder, codes[part], fmi) for part in parts])
            size, taken = len(content) / 1e3, time.perf_counter() - begun
            print(f"library linked: {platform}, {size:.0f} kB, in {taken:.1f} s", file=sys.stderr, flush=True)
            return content

        with ThreadPoolExecutor(cores()) as several:
            contents = dict(zip(platforms, several.map(made, platforms), strict=True))
    return {platform: (content, _checked(platform, content)) for platform, content in contents.items()}


def _linked(name: str, target: Target, suffix: str, headers: Path, code: bytes, fmi: int) -> bytes:
    """Return the library of one target."""
    with tempfile.TemporaryDirectory(dir=headers) as temporary:
        kernels, output = Path(temporary) / "kernels.o", Path(temporary) / f"library{suffix}"
        kernels.write_bytes(code)
        # without it, the path at which it was linked
        options = [f"-Wl,-install_name,@rpath/{name}.dylib"] if suffix == ".dylib" else []
        compile_c(target, [*sources(fmi), kernels], output, [headers], options)
        return output.read_bytes()


def _checked(platform: str, content: bytes) -> list[symbols.Symbols]:
    """Return the symbols that each part of a library needs. Raises InputError if one is Python's."""
    needs = symbols.read(content)
    for part in needs:
        if part.foreign:
            raise InputError(f"{platform}: {part.format} needs {', '.join(part.foreign)} of Python's")
    return needs
