"""Machine code of groups for distribution: libraries of packages for every platform, else object code for this one.

Also object code, or assembly, that native FMUs are linked with.
"""

import hashlib
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

from .bounds import BOUNDS
from .folders import keep, kept
from .groups import GROUPS
from .level import ARM, X86, is_arm
from .library import file_name
from .making import HOST, compilers, on_all_cores, run_make, sources_of
from .messages import MachineCodeError
from .sources import SOURCES
from .zig import BESIDE_WINDOWS, LINUX, LINUX_ARM, MACOS, MACOS_ARM, WINDOWS, Target, has_linker, link

PACKAGED = [name for name, group in GROUPS.items() if group.is_packaged]
KEPT = "libraries"  # folder of the user
PREFIX = "kernel_"  # of the entries in the code of native FMUs
# operating system, by its name in platform tags of wheels -> level -> target; the suffix of its libraries
PLATFORMS: Mapping[str, tuple[str, Mapping[str, Target]]] = {
    "manylinux_2_17_x86_64": (".so", {level: replace(LINUX, cpu=level) for level in X86}),
    "manylinux_2_17_aarch64": (".so", {"arm64": LINUX_ARM}),
    "win_amd64": (".dll", {level: replace(WINDOWS, cpu=level) for level in X86[1:]}),
    "macosx_11_0_x86_64": (".dylib", {X86[-1]: MACOS}),
    "macosx_11_0_arm64": (".dylib", {"arm64": MACOS_ARM}),
}


class _TargetCode(NamedTuple):
    """The code of a group for one target."""

    group: str
    word: str  # for the target (numba_ext/make.py)
    target: Target | None  # that it is linked for; None: it stays object code
    key: str  # under which it is stored
    file: str  # its name in a package


def libraries(groups: Iterable[str] = PACKAGED, platforms: Iterable[str] = PLATFORMS) -> dict[str, bytes]:
    """Return the files of groups for platforms, name -> content; they are made on all cores, and stored.

    Without zig they are object code for the levels of this machine's processor, which needs llvmlite to run.
    Raises MachineCodeError, OSError.
    """
    if BOUNDS:
        raise MachineCodeError("no package carries kernels that check their bounds: unset MULTIBLOCK_BOUNDS")
    parts_of = partial(_linked_parts, platforms=tuple(platforms)) if has_linker() else _object_parts
    made = on_all_cores(lambda some: _contents([part for group in some for part in parts_of(group)]), groups)
    return {name: content for part in made for name, content in part.items()}


def object_code(group: str, targets: Iterable[Target], suffix: str = ".o") -> list[bytes]:
    """Return object code, or assembly (.s), to be linked into native FMUs for targets. Raises MachineCodeError."""
    identity, parts = _made_with(sources_of(group)), []
    for target in targets:
        word = f"{target.triple}/{target.cpu}/{PREFIX}"
        file = f"{word.replace('/', '-')}{suffix}"
        parts.append(_TargetCode(group, word, None, f"{identity}-{group}-{file}", file))
    found = _contents(parts)
    return [found[part.file] for part in parts]


def _linked_parts(group: str, platforms: tuple[str, ...]) -> Iterator[_TargetCode]:
    """Return the parts of a group that are linked, for all levels of platforms."""
    identity = _made_with(f"ziglang {version('ziglang')}")
    for name in platforms:
        suffix, targets = PLATFORMS[name]
        for level, target in targets.items():
            key, file = f"{identity}-{group}-{name}-{level}", file_name(group, level, suffix)
            yield _TargetCode(group, f"{target.triple}/{target.cpu}/", target, key, file)


def _object_parts(group: str) -> Iterator[_TargetCode]:
    """Return the parts of a group as object code for the processors of this machine's architecture."""
    identity = _made_with()
    for level in ARM if is_arm() else X86:
        yield _TargetCode(group, level, None, f"{identity}-{group}-{level}.o", file_name(group, level, ".o"))


def _made_with(*beside: str) -> str:
    """Return an identifier of all that the files depend on besides group and target."""
    files = Path(__file__), Path(__file__).with_name("zig.py"), BESIDE_WINDOWS
    content = [" ".join((SOURCES, HOST, compilers(), *beside)).encode(), *(file.read_bytes() for file in files)]
    return hashlib.sha256(b"".join(content)).hexdigest()[:16]


def _contents(parts: list[_TargetCode]) -> dict[str, bytes]:
    """Return the files of parts by name, stored or made now."""
    found = {part.file: content for part in parts if (content := kept(KEPT, part.key)) is not None}
    missing = [part for part in parts if part.file not in found]
    with tempfile.TemporaryDirectory(prefix="machine_code_") as temporary:
        # compile the others, all targets of a group at once
        objects: dict[_TargetCode, Path] = {}
        wanted: dict[str, dict[str, Path]] = defaultdict(dict)
        for number, part in enumerate(missing):
            folder = Path(temporary) / str(number)
            folder.mkdir()
            suffix = ".o" if part.target is not None else Path(part.file).suffix
            objects[part] = wanted[part.group][part.word] = folder / f"kernels{suffix}"
        if wanted:
            run_make(wanted)
        # link and store them
        for part, file in objects.items():
            content = file.read_bytes() if part.target is None else _linked(part, part.target, file)
            found[part.file] = content
            keep(KEPT, part.key, content)
    return found


def _linked(part: _TargetCode, target: Target, file: Path) -> bytes:
    """Return the shared library of an object."""
    output = file.with_name(part.file)
    # name by which macOS finds a library
    own = ["-Wl,-install_name,@rpath/" + part.file] if part.file.endswith(".dylib") else []
    link(target, [file], output, own)
    return output.read_bytes()
