"""The documentation site: its commands and programs work as they stand there, and its tables have all that code has."""

from __future__ import annotations

import functools
import importlib
import io
import re
import shutil
import sys
import tomllib
from pathlib import Path

import pytest
from support import pages
from support.fmus import ROOT, read_results

import multiblock
from fmu_src.references import FAMILIES, REFERENCES
from multiblock import Column, Plan, Structure
from solver.common.aliases import aliases_of
from solver.models.column.response import Response
from solver.models.structure.neighbours import restitution_of
from solver.models.structure.response import SpatialResponse

pytestmark = pytest.mark.long  # runs the commands of the site

DOCS = pages.DOCS
TUTORIALS = sorted((DOCS / "tutorials").glob("*.md"))
GALLERY = DOCS / "gallery.md"
CHECK, STRUCTURES, NEIGHBOURS = DOCS / "check.md", DOCS / "structures.md", DOCS / "neighbours.md"
FMU = DOCS / "tutorials" / "5-first-fmu.md"
(STATUE,) = pages.blocks(DOCS / "tutorials" / "2-your-column.md", "toml")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working directory: a checkout, with the column that the tutorials write."""
    (tmp_path / "statue.toml").write_text(STATUE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return pages.checkout(tmp_path)


@pytest.mark.parametrize("page", [page for page in TUTORIALS if page != FMU], ids=lambda page: page.stem)
def test_tutorials(folder: Path, page: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for command in pages.commands(page):
        pages.call(command)
    for program in pages.blocks(page, "python"):
        exec(program, {})
    printed = capsys.readouterr().out
    shown = [line for text in pages.blocks(page, "") for line in text.splitlines()]
    # between none and all a verdict may depend on the last digits, those of the artificial motions by numpy's version
    between = r"[\d.]+ x .*: [1-6] of 7|The shaking can grow to|The answer hangs on"
    certain = [line for line in shown if not re.match(between, line)]
    assert [line for line in certain if line not in printed] == []
    assert not shown or certain


def test_first_fmu(folder: Path) -> None:
    for command in pages.commands(FMU):
        if "--native" not in command:
            pages.paste(command, folder)
    inside, outside = read_results(folder / "shaken.csv"), read_results(folder / "out.csv")
    assert inside["time"][-1] == outside["time"][-1] == pytest.approx(30.0)
    assert max(abs(inside["block[1].ux"])) == pytest.approx(max(abs(outside["block[1].ux"])), rel=0.1)
    named = re.search(r"`--start-values ([^`]*)`", FMU.read_text(encoding="utf-8"))
    assert named is not None
    values = " ".join(named[1].split())
    pages.paste(f"fmpy simulate column.fmu --stop-time 0.01 --output-file one.csv --start-values {values}", folder)
    settlement = 81000 * 9.80665 / (2e9 * 1.56**2)  # of the base joint, now softer
    assert read_results(folder / "one.csv")["block[3].uz"][0] == pytest.approx(-settlement, rel=1e-9)


@pytest.mark.long
def test_first_native_fmu(folder: Path) -> None:
    (command,) = (command for command in pages.commands(FMU) if "--native" in command)
    pages.paste(command, folder)


def test_results_page(folder: Path) -> None:
    for program in pages.blocks(DOCS / "results.md", "python"):
        exec(program, {})


def test_check_page(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Run its commands and program, with one varied column a motion, no margin and no other joints: saves minutes."""
    for name in ("COLUMN", "column", "dowels", "wider"):
        shutil.copy(folder / "statue.toml", folder / f"{name}.toml")
    for name in ("FIRST", "SECOND", "THIRD", "A", "B", "C"):
        shutil.copy(folder / "RECORD.AT2", folder / f"{name}.AT2")
    shutil.copy(ROOT / "examples" / "structures" / "cask-row.toml", folder / "casks.toml")
    monkeypatch.setattr(sys, "stdin", io.StringIO("drums\n" + 20 * "\n"))
    for command in pages.commands(CHECK):
        if command.startswith("python examples/"):  # checks of three statues, which take minutes
            assert (ROOT / command.split()[1]).is_file()
            continue
        checks = command.startswith(("multiblock check", "multiblock gallery"))
        quickly = ["--no-margin", "--ensemble", "1"] if checks else []
        quickly += ["--artificial", "1"] if checks and ".AT2" not in command else []
        quickly += ["--no-joints"] if command.startswith("multiblock check") else []
        monkeypatch.chdir(folder / "examples" / "gallery" if command.startswith("multiblock gallery") else folder)
        pages.call(command, *quickly, *(["--friction", "0.3:0.6:0.3"] if "--friction" in command else []))
    assert (folder / "report.html").stat().st_size > 5_000
    assert Column.from_toml("my-statue.toml").n > 1
    quick = functools.partial(multiblock.check, plan=Plan(ensemble=1, margin=False, joints=False), artificial=1)
    monkeypatch.setattr(multiblock, "check", quick)
    (program,) = pages.blocks(CHECK, "python")
    capsys.readouterr()
    exec(program, {})
    assert "displacement of the top" in capsys.readouterr().out


def write_structure(folder: Path) -> None:
    """Return the file that the page shows, as its commands and programs name it."""
    (text,) = (text for text in pages.blocks(STRUCTURES, "toml") if "[[port]]" in text)
    (folder / "structure.toml").write_text(text, encoding="utf-8")


def test_structures_page(folder: Path) -> None:
    for name in ("SECOND", "THIRD"):
        shutil.copy(folder / "RECORD.AT2", folder / f"{name}.AT2")
    write_structure(folder)
    (folder / "push.csv").write_text("0,0\n1,2e4\n", encoding="utf-8")
    for command in pages.commands(STRUCTURES):
        if command.startswith("multiblock new "):
            shutil.copy(ROOT / "examples" / "structures" / "statue.obj", folder)
            pages.call(command, "--force")
        elif not command.startswith("python "):  # examples and benchmarks have tests of their own
            pages.call(command, "--duration", "0.1", "--settle", "0", "--no-check")
    whole, bearing = (tomllib.loads(text) for text in pages.blocks(STRUCTURES, "toml"))
    assert Structure.from_dict(whole).n == 6
    slab = {"name": "slab", "position": [0, 0, 0.15], "width": 1.5, "depth": 1.0, "height": 0.3, "density": 2500.0}
    assert Structure.from_dict({"name": "isolated", "block": [slab], **bearing}).bearings


def test_programs_of_the_structures_page(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Run the programs, which print the figure that the page names."""
    write_structure(folder)
    for program in pages.blocks(STRUCTURES, "python"):
        exec(program, {})
    (least,) = re.findall(
        r"print\(response.peaks\[\"gap\"\].min\(\)\)  # m, (-[\d.]+):", STRUCTURES.read_text(encoding="utf-8")
    )
    assert float(capsys.readouterr().out.split()[-1]) == pytest.approx(float(least), abs=5e-4)


def test_neighbours_page(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Run its program, which prints the figures that stand behind its lines; its table of restitutions is the closed
    form.
    """
    (text,), (program,) = pages.blocks(NEIGHBOURS, "toml"), pages.blocks(NEIGHBOURS, "python")
    (folder / "store.toml").write_text(text, encoding="utf-8")
    exec(program, {})
    printed = capsys.readouterr().out.translate(str.maketrans("", "", "[]()'")).splitlines()
    names, *numbers = re.findall(r"print\(.*\)  # (?:\w+: )?(.*)", program)
    assert printed[0] == names
    for line, shown in zip(printed[1:], numbers, strict=True):
        assert [float(number) for number in line.split()] == pytest.approx(
            [float(number) for number in shown.split()], rel=5e-3
        )
    text = NEIGHBOURS.read_text(encoding="utf-8")
    zeta, restitution = re.findall(r"^\| e(?:ta sqrt\(k / m\) / 2)? \| (.*) \|$", text, re.MULTILINE)
    for part, found in zip(zeta.split(" | "), restitution.split(" | "), strict=True):
        assert restitution_of(2.0 * float(part), 1.0, 1.0) == pytest.approx(float(found), abs=5e-4)


def test_column_file_page() -> None:
    for text in pages.blocks(DOCS / "reference" / "column-file.md", "toml"):
        assert Column.from_dict(tomllib.loads(text)).n == 1


# gallery


def is_of_studies(command: str) -> bool:
    return command.startswith("multiblock study")


def test_gallery_of_columns(folder: Path) -> None:
    for command in pages.commands(GALLERY):
        if command.startswith("multiblock") and not is_of_studies(command):
            pages.call(command)


@pytest.mark.long
def test_gallery_of_studies(folder: Path) -> None:
    found = [command for command in pages.commands(GALLERY) if is_of_studies(command)]
    for command in found:
        fewer = command.replace("--samples 1000", "--samples 50")
        quick = [] if "fragility" in command else ["--quick"]
        pages.call(fewer, *quick)


@pytest.mark.campaign  # takes 10 s and more, and changes seldom
@pytest.mark.long
def test_programs_of_the_gallery_and_campaigns(folder: Path) -> None:
    found = [*pages.commands(GALLERY), *pages.commands(DOCS / "accuracy.md")]
    programs = [command for command in found if command.startswith("python ")]
    assert len(programs) == 5
    for command in programs:
        pages.paste(command, folder)
    for name in ("figure3.csv", "figure3.png", "isolated.png", "results.png"):
        assert (folder / "results" / name).stat().st_size > 5_000, name


def test_gallery_has_every_example() -> None:
    text = GALLERY.read_text(encoding="utf-8")
    found = [path for name in ("columns", "studies") for path in (ROOT / "examples" / name).glob("*.toml")]
    examples = [path.relative_to(ROOT).as_posix() for path in found]
    assert len(examples) >= 16
    assert [name for name in examples if f"{name} " not in text and f"{name}\n" not in text] == []
    for name in re.findall(r"\]\((images/[^)]+)\)", text):
        assert (DOCS / name).is_file(), name


# what the code fills in


@pytest.fixture(scope="module")
def parts() -> dict[str, str]:
    """Return every part of the site that the code knows."""
    sys.path.insert(0, str(DOCS))
    try:
        tables = importlib.import_module("tables")
    finally:
        sys.path.remove(str(DOCS))
    marks = [mark for page in DOCS.rglob("*.md") for mark in tables.MARK.findall(page.read_text(encoding="utf-8"))]
    assert sorted(marks) == sorted(tables.PARTS)  # each stands in one page
    return {name: make() for name, make in tables.PARTS.items()}


def test_every_key_has_a_meaning(parts: dict[str, str]) -> None:
    for name in ("column-keys", "block-keys", "load-keys", "joint-keys", "solver-keys", "study-keys"):
        rows = [row.split(" | ") for row in parts[name].splitlines()[2:]]
        assert rows
        assert [row[0] for row in rows if not row[1].strip()] == [], name
    assert "N/m3, Winkler modulus" in parts["joint-keys"]


def test_every_variable_of_the_fmu_is_listed(parts: dict[str, str]) -> None:
    kinds = ("inputs", "outputs", "parameters")
    text = "".join(parts[kind] + parts[f"{kind}-in-space"] for kind in kinds)
    first = [name for name in REFERENCES if not re.match(r"body\d", name)]  # further bodies are alike
    names = [*first, *(family.replace(".", "[i].") for family in FAMILIES)]
    assert [name for name in names if f"| `{name}` |" not in text] == []


def test_every_old_name_of_a_result_is_listed(parts: dict[str, str]) -> None:
    rows = [[cell.strip() for cell in row.split(" | ")] for row in parts["result-names"].splitlines()[2:]]
    listed = {name for row in rows for name in row[1].split(", ")}
    old = {f"`{name}`" for kind in (Response, SpatialResponse) for name in aliases_of(kind)}
    assert old | {"`My`"} == listed - {""}
    assert [row[0] for row in rows if not (row[3] or row[4])] == []  # each has a meaning
    assert "| `peak_ry` | `peak_theta` | `peak_ry` |" in parts["table-names"]
