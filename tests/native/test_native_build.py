"""The results of `build_fmu.py --native`: libraries for three systems, what they need, and a host without Python."""

from __future__ import annotations

import importlib.util
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
from fmpy import extract, read_model_description
from support.child import call
from support.fmus import DAMPED, LINUX, ROOT, Fmus, built_once, c_host, finish, run
from support.inside import masters

from build_fmu import main
from fmu_src import rules
from fmu_src.body import read_body
from fmu_src.native import column_subject, library, symbols, table
from fmu_src.native.package import contents_of
from solver.kernels.machine.entry import ENTRIES
from solver.models.column.settings import SKIP_CODES, SKIPS

pytestmark = pytest.mark.long  # builds native FMUs

MATHEMATICS = {"asin", "atan2", "cos", "exp", "expm1", "hypot", "log", "pow", "sin", "sincos"}
FORMATS = {
    "linux64": ["ELF x86-64"],
    "win64": ["PE x86-64"],
    "darwin64": ["Mach-O x86_64", "Mach-O arm64"],
    "aarch64-linux": ["ELF aarch64"],
}


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the damped example for all platforms."""
    return built_once(tmp_path_factory, "all_platforms.fmu", lambda path: Fmus.build(DAMPED, path, "--native"))


def test_libraries_for_three_systems_need_no_python(fmu: Path) -> None:
    assert fmu.stat().st_size < 1.3e6  # measured 1.09e6, five processors
    with zipfile.ZipFile(fmu) as archive:
        names = [name for name in archive.namelist() if name.startswith("binaries/")]
        parts = {name.split("/")[1]: symbols.read(archive.read(name)) for name in names}
    assert {platform: [part.format for part in found] for platform, found in parts.items()} == FORMATS
    header = (library.headers() / "fmi2Functions.h").read_text(encoding="utf-8")
    for found in parts.values():
        for part in found:
            assert part.foreign == []
            offered = {name for name in part.offered if name.startswith("fmi2")}
            assert len(offered) >= 31
            assert all(f"#define {name} " in header for name in offered)
            assert not [name for name in part.offered if name.startswith("kernel")]
    (linux,) = parts["linux64"]
    strange = set(linux.needed) - MATHEMATICS
    assert all(hasattr(__import__("ctypes").CDLL(None), name) for name in strange), strange


def test_a_driven_column_links_for_windows(tmp_path: Path) -> None:
    output = tmp_path / "driven.fmu"
    Fmus.build(DAMPED, output, "--native", "--platforms", "win64", "--drive", "horizontal")
    with zipfile.ZipFile(output) as archive:
        (part,) = symbols.read(archive.read("binaries/win64/phocas_damped.dll"))
    assert part.format == "PE x86-64"


def test_a_symbol_of_python_is_found() -> None:
    part = symbols.Symbols("ELF", ("sin", "PyErr_Clear", "NRT_Free", "_numba_hypot"), (), ("libpython3.11.so",))
    assert part.foreign == ["PyErr_Clear", "NRT_Free", "_numba_hypot"]


def test_a_host_in_c_runs_it(fmu: Path, tmp_path: Path) -> None:
    if not sys.platform.startswith("linux"):
        pytest.skip("the host is built for Linux")
    host = c_host(tmp_path)
    folder = Path(extract(str(fmu), unzipdir=tmp_path / "fmu"))
    description = read_model_description(str(fmu))
    reference = {variable.name: str(variable.valueReference) for variable in description.modelVariables}
    binary = folder / "binaries/linux64/phocas_damped.so"
    (needed,) = symbols.read(host.read_bytes())
    (library_needs,) = symbols.read(binary.read_bytes())
    assert not [name for name in (*needed.libraries, *library_needs.libraries) if "python" in name]
    command = [host, binary, "file:///nowhere", description.guid, reference["base.ax"], reference["block[1].ux"]]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, env={}, check=False)
    assert done.returncode == 0, done.stderr
    once, again = (float(word) for word in done.stdout.split())
    assert once == again == call(masters.alone, fmu)[0]


def test_the_library_for_arm_gives_the_digits_of_x86(fmu: Path, tmp_path: Path) -> None:
    emulator, system = shutil.which("qemu-aarch64"), Path("/usr/aarch64-linux-gnu")
    if emulator is None or not system.is_dir():
        pytest.skip("needs qemu-aarch64 and the C library for ARM: apt install qemu-user libc6-arm64-cross")
    host = c_host(tmp_path, "aarch64-linux-gnu.2.17")
    binary = Path(extract(str(fmu), unzipdir=tmp_path / "fmu")) / "binaries/aarch64-linux/phocas_damped.so"
    guid = read_model_description(str(fmu)).guid
    once, again = map(float, run(emulator, "-L", system, host, binary, "file:///nowhere", guid, "1", "10001").split())
    assert once == again == pytest.approx(call(masters.alone, fmu)[0], rel=1e-12)


def test_what_is_needed_is_printed_and_the_same_input_builds_the_same_bytes(tmp_path: Path) -> None:
    built = []
    for k in range(2):
        output = tmp_path / f"{k}.fmu"
        done = finish(
            *(sys.executable, ROOT / "build_fmu.py", DAMPED, "-o", output, *LINUX),
            SOURCE_DATE_EPOCH="1700000000",
        )
        assert done.returncode == 0
        assert "linux64 (ELF x86-64) needs: " in done.stderr
        assert "library linked: linux64, " in done.stderr
        built.append(output.read_bytes())
    assert built[0] == built[1]


def test_without_ziglang_the_build_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    find_spec = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *rest: None if name == "ziglang" else find_spec(name, *rest)
    )
    assert main([str(DAMPED), "-o", str(tmp_path / "x.fmu"), "--native"]) == 2
    assert 'pip install "multiblock-fmu[native]"' in capsys.readouterr().err


# --- the contract between Python and C


def written(folder: Path) -> Path:
    """Return a folder with the header files of the damped example."""
    folder.mkdir()
    for name, text in table.headers(contents_of(read_body(DAMPED))).items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def compile_core(folder: Path) -> str:
    """Return the compiler's messages about core.c with the headers in a folder; nothing if it is content."""
    core = library.sources(2)[0]
    options = ("-std=c11", "-Wall", "-Wextra", "-Werror", "-c", f"-I{folder}", core, "-o", folder / "core.o")
    return finish(sys.executable, "-m", "ziglang", "cc", *options).stderr


def test_the_core_knows_no_names_of_a_standard() -> None:
    source = library.sources(2)[0]  # face.h and status.h are of the faces around it
    core = "".join(path.read_text(encoding="utf-8") for path in (source, source.with_suffix(".h")))
    assert '#include "core.h"' in core
    assert "face.h" not in core
    assert "status.h" not in core
    assert not re.search(r"\bfmi\d", re.sub(r"/\*.*?\*/", "", core, flags=re.DOTALL), re.IGNORECASE)


def test_every_kernel_is_given_all_its_arguments_by_name() -> None:
    """Check that an argument that a list of named initializers leaves out is zero, and no compiler says so."""
    core = library.sources(2)[0].read_text(encoding="utf-8")
    groups = {
        name: re.findall(r"\.(\w+) = ", text)
        for name, text in re.findall(r"#define (COLUMN|RECORD)\(i\)((?:.*\\\n)+.*\n)", core)
    }
    for entry in table.CALLED:
        calls = re.findall(rf"\b{entry}\(\({entry.title()}\){{(.*?)}}\)", core, re.DOTALL)
        assert calls, entry
        for text in calls:
            named = re.findall(r"\.(\w+) = ", text)
            for group, names in groups.items():
                named += names if f"{group}(" in text else []
            assert sorted(named) == sorted(table.given_to(entry)), entry


def test_a_kernel_that_takes_another_argument_does_not_compile(tmp_path: Path) -> None:
    folder = written(tmp_path / "headers")
    assert compile_core(folder) == ""
    contract = (folder / "contract.h").read_text(encoding="utf-8")
    (folder / "contract.h").write_text(contract.replace("upright", "plumb"), encoding="utf-8")
    assert "upright" in compile_core(folder)


@pytest.mark.parametrize("group", ["column_driven", "structure_driven"])
def test_arguments_lie_as_the_entry_reads_them(tmp_path: Path, group: str) -> None:
    subject = replace(contents_of(read_body(DAMPED)).subject, group=group)
    (tmp_path / "contract.h").write_text(table.contract(subject), encoding="utf-8")
    lines = ["#include <stddef.h>", '#include "contract.h"']
    for name in table.CALLED:
        for k, slot in enumerate(table.arguments(ENTRIES[group, name])):
            lines.append(f'_Static_assert(offsetof({name.title()}, {slot}) == 8 * {k}, "{name}, {slot}");')
    (tmp_path / "slots.c").write_text("\n".join(lines), encoding="utf-8")
    options = ("-std=c11", "-c", tmp_path / "slots.c", "-o", tmp_path / "slots.o")
    assert finish(sys.executable, "-m", "ziglang", "cc", *options).stderr == ""


def test_a_kernel_that_is_not_in_the_machine_code_does_not_link() -> None:
    contents = contents_of(read_body(DAMPED))
    generated = table.headers(contents)
    generated["contract.h"] = generated["contract.h"].replace("kernel_look", "kernel_lock")
    with pytest.raises(OSError, match="undefined symbol: kernel_lock"):
        library.libraries("column", ["linux64"], generated, contents.subject.group)


def test_one_more_short_cut_is_one_more_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(column_subject, "SKIP_CODES", SKIP_CODES | {"another": 1024})
    folder = written(tmp_path / "headers")
    text = (folder / "table.h").read_text(encoding="utf-8")
    (count,) = re.findall(r"{\d+, \d+, ANY_WORDS, (\d+), items_\d+}", text)
    assert (int(count), '{1024, "another"}' in text) == (len(SKIPS) + 1, True)
    assert compile_core(folder) == ""


def test_both_fmus_speak_by_the_same_rules() -> None:
    core = library.sources(2)[0].read_text(encoding="utf-8")
    slave = (ROOT / "fmu_src/slave.py").read_text(encoding="utf-8")
    for name, text in vars(rules).items():
        if name.isupper() and isinstance(text, str):
            assert f"SAY_{name}" in core, name
            assert f"rules.{name}" in slave or name == "WHEN_TERMINATED", name  # the wrapper's Fatal would be too much
            assert text not in slave


def test_libraries_for_macos_know_no_folder_of_the_build(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        content = archive.read("binaries/darwin64/phocas_damped.dylib")
    assert content.count(b"@rpath/phocas_damped.dylib") == 2  # one in each part
    assert tempfile.gettempdir().encode() not in content
