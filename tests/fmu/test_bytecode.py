"""The bytecode that a PythonFMU carries: the same bytes at each build, and ignored by another Python."""

from __future__ import annotations

import io
import sys
import zipfile
from pathlib import Path

import pytest
from support.fmus import Fmus, finish_in

from fmu_src.bytecode import bytecode_of

FILES = {"a/__init__.py": b"", "a/b.py": b'"""Of a."""\n\n\ndef f(x):\n    return {"one": 1, "two": (1, 2.5)}.get(x)\n'}


def test_it_is_the_same_at_each_build() -> None:
    first = bytecode_of(FILES)
    assert first.keys() == {"a/__init__.pyc", "a/b.pyc"}
    kept = [compile(text, "b.py", "exec") for text in FILES.values()]  # references do not change it
    assert bytecode_of(FILES) == first
    assert len(kept) == 2


@pytest.mark.long  # takes seconds
def test_another_python_compiles_the_sources(fmus: Fmus, tmp_path: Path) -> None:
    results = []
    for magic in (None, b"\x01\x02\r\n"):  # the bytecode as it is, or as that of another Python
        file = tmp_path / f"{magic is None}.fmu"
        with zipfile.ZipFile(fmus.damped) as built, zipfile.ZipFile(file, "w") as changed:
            for name in built.namelist():
                content = built.read(name)
                changed.writestr(name, with_magic(content, magic) if name == "resources/python.zip" else content)
        command = ("fmpy", "simulate", file, "--stop-time", "0.1", "--output-file", file.with_suffix(".csv"))
        done = finish_in(tmp_path, sys.executable, "-m", *command)
        assert done.returncode == 0, done.stderr
        results.append(file.with_suffix(".csv").read_bytes())
    assert results[0] == results[1]


def with_magic(archive: bytes, magic: bytes | None) -> bytes:
    """Return an archive with another magic number in its bytecode."""
    written = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(archive)) as old, zipfile.ZipFile(written, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            new.writestr(name, magic + content[4:] if magic and name.endswith(".pyc") else content)
    return written.getvalue()
