"""Symbols that a shared library imports and exports, read from its file: ELF, PE and Mach-O."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass

PYTHON = re.compile(r"_*(py|numba|nrt_|llvmlite)", re.IGNORECASE)

_FAT = 0xCAFEBABE
_SYMTAB, _DYLIB = 0x2, 0xC
_MACHINES = {62: "x86-64", 183: "aarch64"}  # of ELF
_ARCHITECTURES = {0x01000007: "x86_64", 0x0100000C: "arm64"}


@dataclass(frozen=True)
class Symbols:
    """The symbols of a library, or of one part of a universal one."""

    format: str
    needed: tuple[str, ...]  # functions and data
    offered: tuple[str, ...]
    libraries: tuple[str, ...]

    @property
    def foreign(self) -> list[str]:
        """The symbols and libraries of Python or of numba's runtime."""
        return [name for name in (*self.needed, *self.libraries) if PYTHON.match(name.rpartition("/")[2])]


def read(content: bytes) -> list[Symbols]:
    """Return the symbols of every part of a library. Raises ValueError for an unknown format."""
    if content[:4] == b"\x7fELF":
        return [_elf(content)]
    if content[:2] == b"MZ":
        return [_pe(content)]
    if struct.unpack(">I", content[:4])[0] == _FAT:
        (count,) = struct.unpack_from(">I", content, 4)
        places = [struct.unpack_from(">5I", content, 8 + 20 * k) for k in range(count)]
        return [_mach_o(content[offset : offset + size]) for _, _, offset, size, _ in places]
    if content[:4] == b"\xcf\xfa\xed\xfe":
        return [_mach_o(content)]
    raise ValueError("neither ELF nor PE nor Mach-O")


def universal(parts: list[bytes]) -> bytes:
    """Combine Mach-O files for different processors to one universal file."""
    if len(parts) == 1:
        return parts[0]
    align = 14
    header = struct.pack(">2I", _FAT, len(parts))
    place, body = 1 << align, b""
    for part in parts:
        processor, kind = struct.unpack_from("<2I", part, 4)
        header += struct.pack(">5I", processor, kind, place, len(part), align)
        body += part + b"\0" * (-len(part) % (1 << align))
        place += len(part) + -len(part) % (1 << align)
    return header + b"\0" * ((1 << align) - len(header)) + body


def _text(content: bytes, place: int) -> str:
    return content[place : content.index(b"\0", place)].decode()


def _elf(content: bytes) -> Symbols:
    (table,) = struct.unpack_from("<Q", content, 0x28)
    size, count = struct.unpack_from("<2H", content, 0x3A)
    # name, type, flags, address, offset, size, link, info, alignment, entry size
    sections = [struct.unpack_from("<2I4Q2I2Q", content, table + size * k) for k in range(count)]
    needed: list[str] = []
    offered: list[str] = []
    libraries = []
    # dynamic symbols and needed libraries
    for section in sections:
        strings = sections[section[6]][4] if section[6] < count else 0
        if section[1] == 11:  # dynamic symbols
            for place in range(section[4] + 24, section[4] + section[5], 24):
                name, _, _, index = struct.unpack_from("<I2BH", content, place)
                (needed if index == 0 else offered).append(_text(content, strings + name))
        if section[1] == 6:  # dynamic section
            for place in range(section[4], section[4] + section[5], 16):
                tag, value = struct.unpack_from("<2Q", content, place)
                if tag == 1:
                    libraries.append(_text(content, strings + value))
    (machine,) = struct.unpack_from("<H", content, 0x12)
    name = _MACHINES.get(machine, f"machine {machine}")
    return Symbols(f"ELF {name}", tuple(sorted(needed)), tuple(sorted(offered)), tuple(libraries))


def _pe(content: bytes) -> Symbols:
    (header,) = struct.unpack_from("<I", content, 0x3C)
    count, optional_size = struct.unpack_from("<H12xH", content, header + 6)
    optional = header + 24
    sections = [struct.unpack_from("<8x4I", content, optional + optional_size + 40 * k) for k in range(count)]

    def at(address: int) -> int:
        for size, begin, stored, place in sections:
            if begin <= address < begin + max(size, stored):
                return int(place + address - begin)
        raise ValueError(f"address {address:#x} is in no section")

    # export table
    exports, _, imports, _ = struct.unpack_from("<4I", content, optional + 112)
    offered, needed, libraries = [], [], []
    if exports:
        names, table = struct.unpack_from("<I4xI", content, at(exports) + 24)[0], at(exports) + 32
        (addresses,) = struct.unpack_from("<I", content, table)
        offered = [
            _text(content, at(struct.unpack_from("<I", content, at(addresses) + 4 * k)[0])) for k in range(names)
        ]
    # import tables, one for each library
    place = at(imports) if imports else 0
    while imports:
        lookup, _, _, name, first = struct.unpack_from("<5I", content, place)
        if not name:
            break
        library = _text(content, at(name))
        libraries.append(library)
        entry = at(lookup or first)
        while (value := struct.unpack_from("<Q", content, entry)[0]) != 0:
            needed.append(f"#{value & 0xFFFF}" if value >> 63 else _text(content, at(value) + 2))
            entry += 8
        place += 20
    return Symbols("PE x86-64", tuple(sorted(needed)), tuple(sorted(offered)), tuple(libraries))


def _mach_o(content: bytes) -> Symbols:
    processor, _, _, count = struct.unpack_from("<4I", content, 4)
    place = 32
    needed: list[str] = []
    offered: list[str] = []
    libraries = []
    # load commands: libraries, and the symbol table
    for _ in range(count):
        command, size = struct.unpack_from("<2I", content, place)
        if command & 0x7FFFFFFF == _DYLIB:
            (name,) = struct.unpack_from("<I", content, place + 8)
            libraries.append(_text(content, place + name))
        if command == _SYMTAB:
            table, symbols, strings, _ = struct.unpack_from("<4I", content, place + 8)
            for k in range(symbols):
                name, kind, _, _, _ = struct.unpack_from("<I2BHQ", content, table + 16 * k)
                if kind & 0x01 and not kind & 0xE0:
                    undefined = kind & 0x0E == 0
                    (needed if undefined else offered).append(_text(content, strings + name).removeprefix("_"))
        place += size
    architecture = _ARCHITECTURES.get(processor, f"processor {processor:#x}")
    return Symbols(f"Mach-O {architecture}", tuple(sorted(needed)), tuple(sorted(offered)), tuple(libraries))
