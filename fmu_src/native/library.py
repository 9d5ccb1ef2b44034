"""From the C layer, its table and the kernels' object code to one shared library for each platform."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import tempfile
from pathlib import Path

from solver.errors import InputError

from . import symbols
from .machine_code import object_code
from .platforms import PLATFORMS

SOURCE = Path(__file__).with_name("fmu.c")
OPTIONS = ("-std=c11", "-O2", "-shared", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off", "-Wall", "-Wextra", "-s")


def check_tools() -> None:
    """Raise InputError if what links the libraries, or the header files of FMI, are not installed."""
    for package in ("ziglang", "fmpy"):
        if importlib.util.find_spec(package) is None:
            raise InputError(f'--native: {package} is not installed: pip install "multiblock-fmu[native]"')


def headers() -> Path:
    """The folder with the header files of the FMI standard, which FMPy carries."""
    spec = importlib.util.find_spec("fmpy")
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).parent / "c-code"


def libraries(platforms: list[str], table: str) -> dict[str, tuple[bytes, list[symbols.Symbols]]]:
    """Platform -> library, and what each of its parts needs. Raises InputError if that is anything of Python's."""
    check_tools()
    targets = [target for platform in platforms for target in PLATFORMS[platform].targets]
    codes = dict(zip(targets, object_code(targets), strict=True))
    made = {}
    with tempfile.TemporaryDirectory(prefix="native_") as temporary:
        folder = Path(temporary)
        (folder / "table.h").write_text(table, encoding="utf-8")
        for platform in platforms:
            parts = []
            for target in PLATFORMS[platform].targets:
                (folder / "kernels.o").write_bytes(codes[target])
                command = [sys.executable, "-m", "ziglang", "cc", "-target", target.linker, *OPTIONS]
                command += [f"-I{folder}", f"-I{headers()}", str(SOURCE), str(folder / "kernels.o"), "-lm"]
                output = folder / f"library{PLATFORMS[platform].suffix}"
                done = subprocess.run([*command, "-o", str(output)], capture_output=True, text=True, check=False)
                if done.returncode:
                    raise OSError(f"{target.linker}: the linker failed\n{done.stderr}")
                parts.append(output.read_bytes())
            content = symbols.universal(parts)
            needs = symbols.read(content)
            for part in needs:
                if part.foreign:
                    raise InputError(f"{platform}: {part.format} needs {', '.join(part.foreign)} of Python's")
            made[platform] = content, needs
    return made
