"""Machine code of groups as files of a package: shared libraries for every platform, or object code for this one."""

import hashlib
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

from .folders import keep, kept
from .groups import GROUPS
from .level import ARM, X86, is_arm
from .library import COMPILERS, file_name, on_all_cores, run_make
from .sources import SOURCES
from .zig import LINUX, LINUX_ARM, MACOS, MACOS_ARM, WINDOWS, Target, has_linker, link

KEPT = "libraries"  # folder of the user
# operating system, by its name in platform tags of wheels -> level -> target; the suffix of its libraries
PLATFORMS: Mapping[str, tuple[str, Mapping[str, Target]]] = {
    "manylinux_2_17_x86_64": (".so", {level: replace(LINUX, cpu=level) for level in X86}),
    "manylinux_2_17_aarch64": (".so", {"arm64": LINUX_ARM}),
    "win_amd64": (".dll", {level: replace(WINDOWS, cpu=level) for level in X86[1:]}),
    "macosx_11_0_x86_64": (".dylib", {X86[-1]: MACOS}),
    "macosx_11_0_arm64": (".dylib", {"arm64": MACOS_ARM}),
}


def libraries(groups: Iterable[str] = GROUPS, platforms: Iterable[str] = PLATFORMS) -> dict[str, bytes]:
    """Return the files of groups for platforms, name -> content; made on all cores, and kept.

    Without zig they are object code for the levels of this machine's processor: what runs it needs llvmlite.
    Raises MachineCodeError, OSError.
    """
    make = partial(_linked, platforms=tuple(platforms)) if has_linker() else _objects
    return {name: content for part in on_all_cores(make, groups) for name, content in part.items()}


def _made_with(linker: str) -> str:
    versions = [f"{name} {version(name)}" for name in (*COMPILERS, *filter(None, [linker]))]
    source = Path(__file__).with_name("zig.py").read_bytes()
    return hashlib.sha256(" ".join([SOURCES, *versions]).encode() + source).hexdigest()[:16]


class _Part(NamedTuple):
    """The code of a group for one target: under what it is kept, the name of its file in a package."""

    group: str
    level: str
    target: Target
    key: str
    file: str


def _linked(groups: list[str], platforms: tuple[str, ...]) -> dict[str, bytes]:
    """Return the libraries of groups."""
    identity = _made_with("ziglang")
    parts = [
        _Part(group, level, target, f"{identity}-{group}-{name}-{level}", file_name(group, level, PLATFORMS[name][0]))
        for group in groups
        for name in platforms
        for level, target in PLATFORMS[name][1].items()
    ]
    found = {part.file: content for part in parts if (content := kept(KEPT, part.key)) is not None}
    missing = [part for part in parts if part.file not in found]
    with tempfile.TemporaryDirectory(prefix="machine_code_") as temporary:
        objects = _made({part: f"{part.target.triple}/{part.target.cpu}" for part in missing}, Path(temporary))
        for part, file in objects.items():
            own = ["-Wl,-install_name,@rpath/" + part.file] if part.file.endswith(".dylib") else []
            output = file.with_name(part.file)
            link(part.target, [file], output, own)
            found[part.file] = output.read_bytes()
            keep(KEPT, part.key, found[part.file])
    return found


def _objects(groups: list[str]) -> dict[str, bytes]:
    """Return the object code of groups for the processors of this machine's kind."""
    identity, target = _made_with(""), LINUX  # which is not used
    levels = ARM if is_arm() else X86
    parts = [
        _Part(group, level, target, f"{identity}-{group}-{level}.o", file_name(group, level, ".o"))
        for group in groups
        for level in levels
    ]
    found = {part.file: content for part in parts if (content := kept(KEPT, part.key)) is not None}
    missing = [part for part in parts if part.file not in found]
    with tempfile.TemporaryDirectory(prefix="machine_code_") as temporary:
        for part, file in _made({part: part.level for part in missing}, Path(temporary)).items():
            found[part.file] = file.read_bytes()
            keep(KEPT, part.key, found[part.file])
    return found


def _made(words: Mapping[_Part, str], folder: Path) -> dict[_Part, Path]:
    """Make the objects of parts, by the words for targets of make.py, each in a folder of its own."""
    files: dict[_Part, Path] = {}
    wanted: dict[str, dict[str, Path]] = defaultdict(dict)
    for number, (part, word) in enumerate(words.items()):
        (folder / str(number)).mkdir()
        files[part] = wanted[part.group][word] = folder / str(number) / "kernels.o"
    if wanted:
        run_make(wanted)
    return files
