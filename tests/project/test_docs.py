"""The pages of the project: what code and pages refer to exists, and lines can be read in any editor."""

from __future__ import annotations

import re
from pathlib import Path

from support.fmus import ROOT

import multiblock

NOTES = sorted((ROOT / "docs" / "notes").glob("*.md"))
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
CODE = ("solver", "fmu_src", "tests", "benchmarks", "examples", "stress", "validation")
CITED = re.compile(r"theory\.md[,(`]*\s+(?:#\s*)?section\s+(\d+)")
WIDTH = 100
DATED = re.compile(r"^\*20\d\d-\d\d-\d\d\b[^*]*\*$", re.MULTILINE)  # when, which commit, which command


def sources() -> list[Path]:
    files = [ROOT / "build_fmu.py", ROOT / "multiblock" / "__main__.py"]
    for folder in CODE:
        files += [file for file in (ROOT / folder).rglob("*") if file.suffix in {".py", ".c", ".h", ".toml"}]
    return files


def prose(text: str) -> list[tuple[int, str]]:
    """Return the lines with their numbers, without code, tables, and links that stand alone."""
    lines, code = [], False
    for number, line in enumerate(text.splitlines(), start=1):
        if line.startswith("```"):
            code = not code
        elif not (code or line.startswith(("    ", "|", "![", "[", "<!--"))):
            lines.append((number, line))
    return lines


def name_of(page: Path) -> str:
    """Return a page as it is named in the results: its path in the project."""
    return page.relative_to(ROOT).as_posix()


def anchors(page: Path) -> set[str]:
    """Return the fragments by which the sections of a page are linked: lower case, hyphens for blanks, no
    punctuation.
    """
    titles = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}


def test_every_section_of_the_theory_that_is_cited_exists() -> None:
    sections = re.findall(r"^## (\d+)\. ", (ROOT / "docs" / "theory.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sections == [str(k) for k in range(1, len(sections) + 1)]
    cited: dict[str, list[str]] = {}
    for file in [*sources(), *PAGES]:
        for section in CITED.findall(file.read_text(encoding="utf-8")):
            cited.setdefault(section, []).append(file.relative_to(ROOT).as_posix())
    assert {section: files for section, files in cited.items() if section not in sections} == {}
    # the check means nothing unless sections are cited
    assert {"2", "3", "4", "5", "7"} <= set(cited)


def test_lines_are_wrapped() -> None:
    long = [
        f"{name_of(page)}:{number}"
        for page in PAGES
        for number, line in prose(page.read_text(encoding="utf-8"))
        if len(line) > WIDTH
    ]
    assert long == []


def test_no_line_begins_as_a_comment() -> None:
    """Check that the site leaves out lines that begin with a per cent sign."""
    lines = [(name_of(page), line) for page in PAGES for _, line in prose(page.read_text(encoding="utf-8"))]
    assert [page for page, line in lines if line.lstrip().startswith("%")] == []


def test_what_a_page_refers_to_exists() -> None:
    tests = {file.name for file in (ROOT / "tests").rglob("test_*.py")}
    absent = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        targets = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", text)  # relative to the page
        absent += [f"{name_of(page)}: {target}" for target in targets if not (page.parent / target).is_file()]
        named = re.findall(r"`((?:docs|examples|solver|fmu_src|tests|stress|benchmarks)/[\w./-]+|[\w-]+\.cff)`", text)
        absent += [f"{name_of(page)}: {name}" for name in named if not (ROOT / name).exists()]
        absent += [f"{name_of(page)}: {name}" for name in re.findall(r"`(test_\w+\.py)`", text) if name not in tests]
    assert absent == []


def test_sections_that_a_page_links_to_exist() -> None:
    absent = []
    for page in PAGES:
        for target, fragment in re.findall(r"\]\(([^)#:]*)#([^)]*)\)", page.read_text(encoding="utf-8")):
            if fragment not in anchors(page.parent / target if target else page):
                absent.append(f"{name_of(page)}: {target}#{fragment}")
    assert absent == []


def test_programs_import_the_public_interface() -> None:
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        programs = "\n".join(re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL))
        for module, names in re.findall(r"^from (solver\S*|multiblock\S*) import (.*)$", programs, re.MULTILINE):
            assert module == "multiblock", name_of(page)
            assert set(names.split(", ")) <= set(multiblock.__all__), name_of(page)


def test_files_of_python_that_code_names_exist() -> None:
    """Look for them by the end of their path, in comments, docstrings and messages."""
    have = [f"/{name_of(file)}" for file in [*sources(), *(ROOT / "docs").glob("*.py")]]
    named: dict[str, str] = {}
    for file in sources():
        for name in re.findall(r"(?<![\w/.\"'-])(?:\w+/)*\w+\.py\b(?![\"'])", file.read_text(encoding="utf-8")):
            named[name] = name_of(file)
    assert len(named) > 50  # measured: 111
    assert {name: file for name, file in named.items() if not any(path.endswith(f"/{name}") for path in have)} == {}


def test_time_stepping_is_explained_in_1500_words() -> None:
    assert len((ROOT / "docs" / "integrators.md").read_text(encoding="utf-8").split()) <= 1500


def test_the_index_of_the_notes_has_each_of_them_once() -> None:
    index = (ROOT / "docs" / "notes" / "README.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| \[[^]]+\]\(([^)]+)\) \|", index, re.MULTILINE)
    assert sorted(listed) == [note.name for note in NOTES if note.name != "README.md"]


def test_tables_of_notes_are_dated() -> None:
    undated = []
    for note in (note for note in NOTES if note.name != "README.md"):
        sections = re.split(r"^## ", note.read_text(encoding="utf-8"), flags=re.MULTILINE)
        undated += [part.splitlines()[0] for part in sections if "\n|---" in part and not DATED.search(part)]
    assert undated == []


def test_every_example_has_its_picture() -> None:
    shown = (ROOT / "docs" / "columns.md").read_text(encoding="utf-8")
    names = [path.stem for path in (ROOT / "examples" / "columns").glob("*.toml")]
    assert names
    assert [name for name in names if f"(images/column-{name}.png)" not in shown or f"`{name}.toml`" not in shown] == []
