"""The pages of the project: what code and pages refer to exists, and lines can be read in any editor."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from fmus import ROOT

PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]
CODE = ("solver", "fmu_src", "tests", "benchmarks", "examples", "stress")
CITED = re.compile(r"theory\.md[,(`]*\s+(?:#\s*)?section\s+(\d+)")
WIDTH = 100


def sources() -> list[Path]:
    files = [ROOT / "build_fmu.py", ROOT / "multiblock.py"]
    for folder in CODE:
        files += [file for file in (ROOT / folder).rglob("*") if file.suffix in {".py", ".c", ".h", ".toml"}]
    return files


def prose(text: str) -> list[tuple[int, str]]:
    """Lines with their numbers, without code, tables, and links that stand alone."""
    lines, code = [], False
    for number, line in enumerate(text.splitlines(), start=1):
        if line.startswith("```"):
            code = not code
        elif not (code or line.startswith(("    ", "|", "![", "[", "<!--"))):
            lines.append((number, line))
    return lines


def test_every_section_of_the_theory_that_is_cited_exists() -> None:
    sections = re.findall(r"^## (\d+)\. ", (ROOT / "docs" / "theory.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sections == [str(k) for k in range(1, len(sections) + 1)]
    cited: dict[str, list[str]] = {}
    for file in [*sources(), *PAGES]:
        for section in CITED.findall(file.read_text(encoding="utf-8")):
            cited.setdefault(section, []).append(file.relative_to(ROOT).as_posix())
    assert {section: files for section, files in cited.items() if section not in sections} == {}
    # the numbers can only be trusted while somebody cites them
    assert {"2", "3", "4", "5", "7"} <= set(cited)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_lines_are_wrapped(page: Path) -> None:
    long = [number for number, line in prose(page.read_text(encoding="utf-8")) if len(line) > WIDTH]
    assert long == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_what_a_page_refers_to_exists(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", text):  # relative to the page
        assert (page.parent / target).is_file(), target
    named = re.findall(r"`((?:docs|examples|solver|fmu_src|tests|stress|benchmarks)/[\w./-]+|[\w-]+\.cff)`", text)
    for name in named:
        assert (ROOT / name).exists(), name
    for name in re.findall(r"`(test_\w+\.py)`", text):
        assert (ROOT / "tests" / name).is_file(), name


def test_every_example_has_its_picture() -> None:
    shown = (ROOT / "docs" / "columns.md").read_text(encoding="utf-8")
    names = [path.stem for path in (ROOT / "examples" / "columns").glob("*.toml")]
    assert names
    assert [name for name in names if f"(images/column-{name}.png)" not in shown or f"`{name}.toml`" not in shown] == []
