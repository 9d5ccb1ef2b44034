"""The native FMU as source code: its sources compile without other files and do what the library does."""

from __future__ import annotations

import shutil
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest
from fmpy import extract, read_model_description
from support.child import call
from support.fmus import DAMPED, LINUX, Fmus, built_once, c_host, run
from support.inside import masters

from fmu_src.native import symbols

if not sys.platform.startswith("linux"):
    pytest.skip("the libraries are built for Linux", allow_module_level=True)

pytestmark = pytest.mark.long

OPTIONS = ("-std=c11", "-O2", "-shared", "-fPIC", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror")
ZIG = (sys.executable, "-m", "ziglang", "cc", "-target")


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built_once(tmp_path_factory, "source.fmu", lambda path: Fmus.build(DAMPED, path, *LINUX, "--source"))


@pytest.fixture(scope="module")
def files(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Return the files to be compiled, as the model description lists them."""
    folder = Path(extract(str(fmu), unzipdir=tmp_path_factory.mktemp("unpacked")))
    root = ElementTree.parse(folder / "modelDescription.xml").getroot()
    found = [folder / "sources" / str(file.get("name")) for file in root.findall("CoSimulation/SourceFiles/File")]
    assert len(found) == 3
    return found


def displacement(fmu: Path, library: Path, folder: Path) -> float:
    """Return the displacement of the top, under the C host; fails unless it ends with 0."""
    guid = read_model_description(str(fmu)).guid
    once, again = map(float, run(c_host(folder), library, "file:///nowhere", guid, "1", "10001").split())
    assert once == again
    return once


def test_it_is_valid(fmu: Path) -> None:
    assert "No problems found" in run("fmpy", "validate", fmu)


@pytest.mark.parametrize("compiler", ["gcc", "zig"])
def test_a_compiler_makes_the_library_of_it(fmu: Path, files: list[Path], tmp_path: Path, compiler: str) -> None:
    if compiler == "gcc" and shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    command = ("gcc",) if compiler == "gcc" else (*ZIG, "x86_64-linux-gnu.2.17")
    library = tmp_path / "column.so"
    run(*command, *OPTIONS, "-DFMI2_OVERRIDE_FUNCTION_PREFIX", *files, "-lm", "-o", library)
    (part,) = symbols.read(library.read_bytes())
    assert part.foreign == []
    assert displacement(fmu, library, tmp_path) == call(masters.alone, fmu)[0]


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
@pytest.mark.parametrize("option", ["-flto", "-fsanitize=address"])
def test_it_links_with_what_gcc_adds_to_the_code(fmu: Path, files: list[Path], tmp_path: Path, option: str) -> None:
    """Check that directives that the compiler writes after the assembly go to the section of code, not to one the
    linker drops.
    """
    library = tmp_path / "column.so"
    run("gcc", *OPTIONS, option, "-DFMI2_OVERRIDE_FUNCTION_PREFIX", *files, "-lm", "-o", library)
    if option == "-flto":  # the other wants its own library loaded first
        assert displacement(fmu, library, tmp_path) == call(masters.alone, fmu)[0]


def test_every_name_is_that_of_the_fmu(files: list[Path], tmp_path: Path) -> None:
    library = tmp_path / "column.so"
    run(*ZIG, "x86_64-linux-gnu.2.17", *OPTIONS, *files, "-lm", "-o", library)
    (part,) = symbols.read(library.read_bytes())
    own = [name for name in part.offered if "fmi2" in name or "core_" in name or "kernel" in name]
    assert len(own) >= 31
    assert all(name.startswith("phocas_damped_") for name in own)


@pytest.mark.parametrize(
    "target",
    [
        "aarch64-linux-gnu.2.17",
        pytest.param("x86_64-windows-gnu", marks=pytest.mark.campaign),  # zig makes its C library first, 110 s
        "x86_64-macos.11.0",
        "aarch64-macos.11.0",
    ],
)
def test_it_compiles_for_the_other_targets(files: list[Path], tmp_path: Path, target: str) -> None:
    run(*ZIG, target, *OPTIONS, *files, "-lm", "-o", tmp_path / "column.so")


@pytest.fixture(scope="module")
def fmu3(tmp_path_factory: pytest.TempPathFactory) -> Path:
    options = ("--native", "--source", "--fmi", "3", "--platforms", "x86_64-linux")
    return built_once(tmp_path_factory, "source3.fmu", lambda path: Fmus.build(DAMPED, path, *options))


@pytest.mark.parametrize("compiler", ["gcc", "zig"])
def test_fmi_3_describes_its_build_and_runs_as_compiled(fmu3: Path, tmp_path: Path, compiler: str) -> None:
    if compiler == "gcc" and shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    assert "No problems found" in run("fmpy", "validate", fmu3)
    folder = Path(extract(str(fmu3), unzipdir=tmp_path / "unpacked"))
    root = ElementTree.parse(folder / "sources" / "buildDescription.xml").getroot()
    listed = [folder / "sources" / str(file.get("name")) for file in root.iter("SourceFile")]
    library = folder / "binaries" / "x86_64-linux" / "phocas_damped.so"
    names = ("base.Fx", "block.ux", "joint.N")
    expected = call(masters.alone3, fmu3, names)
    shipped = library.read_bytes()
    command = ("gcc",) if compiler == "gcc" else (*ZIG, "x86_64-linux-gnu")
    run(*command, *OPTIONS, "-DFMI3_OVERRIDE_FUNCTION_PREFIX", *listed, "-lm", "-o", library)
    assert library.read_bytes() != shipped
    (part,) = symbols.read(library.read_bytes())
    assert len([name for name in part.offered if name.startswith("fmi3")]) > 70
    changed = tmp_path / "compiled.fmu"
    with zipfile.ZipFile(changed, "w") as archive:
        for file in sorted(folder.rglob("*")):
            archive.write(file, file.relative_to(folder))
    assert call(masters.alone3, changed, names) == expected
    assert abs(expected[1]) > 1e-3  # m, it moves
