"""Parts of the site that the code knows: `<!-- from the code: NAME -->` in a page is replaced by what NAME gives here.

A page shows on GitHub without them, and never differs from the code on the site. `<!-- pages: PATTERN -->` is replaced
by the pages that there are.
"""

from __future__ import annotations

import inspect
import io
import re
import shutil
import tokenize
from collections.abc import Iterable, Sequence
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path

import multiblock
from fmu_src.drive import Drive
from fmu_src.exchange import exchange, signals
from fmu_src.model_description3 import ELEMENT
from fmu_src.structure_variables import structure_variables
from fmu_src.variables import Variable, variables
from multiblock import Block, Column, Joint, Settings
from solver.common.aliases import aliases_of
from solver.common.ranges import NUMBERS
from solver.kernels.column.sections.faces import SECTIONS
from solver.models.column import file as column_file
from solver.models.column.block import BLOCK_SECTIONS
from solver.models.column.kind import KIND as COLUMNS
from solver.models.column.materials import MATERIALS
from solver.models.column.outputs import KEPT
from solver.models.column.response import Response
from solver.models.column.settings import FORMULATIONS, INTEGRATORS, SKIPS
from solver.models.outputs import BEARING, BOND, CONTACT, PORT, TIE, Output
from solver.models.response import Result
from solver.models.structure.kind import STRUCTURES
from solver.models.structure.model import Structure
from solver.models.structure.outputs import KEPT as KEPT_IN_SPACE
from solver.models.structure.outputs import StructureHistories
from solver.models.structure.response import SpatialResponse
from solver.studies import definition, distributions, motions

DOCS = Path(__file__).parent
MARK = re.compile(r"^<!-- from the code: ([\w-]+) -->$", re.MULTILINE)
PAGES = re.compile(r"^<!-- pages: (\S+) -->$", re.MULTILINE)

# keys from which others follow, which no class has
DERIVED = {
    "name": "name of the column, and of its FMU: letters, digits, `_`, `-`, `.` and space",
    "g": "m/s2, acceleration of gravity; 9.80665 by default",
    "material": "material of all blocks that name no other: "
    "gives density, and stiffness and strength of joints, unless given",
    "block.material": "material of this block and of the joint under it",
    "block": "a table [[block]] for each block, from the top down: see below",
    "joint": "defaults for the joints of all blocks: see below",
    "port": "a table [[port]] for each point at which loads act: name, block, at",
    "solver": "a table: see below",
    "block.mass": "kg; or density",
    "block.joint": "the joint under the block; `[joint]` has what is left out here",
    "block.section": "left out: rectangle",
    "solver.formulation": "finite rotations, or first order by central differences as in the paper; left out: exact",
    "solver.integrator": "optional; fixed by the formulation: auto of exact, central-difference of paper",
    "solver.step": "s, fixed, of the formulation paper; left out: 1e-4",
    "solver.tolerance": "relative to the peak; left out: 1e-5",
    "solver.without": "names of short cuts to switch off; `peaks`: no peaks but those of ux",
    "joint.section": "of the contact; left out: the block's",
    "top_depth": "m, of the top face of a block that tapers; left out: that of the bottom face",
    "profile": "pairs [height above the base, diameter] in m, for round blocks without a diameter",
    "density": "kg/m3, in place of mass",
    "diameter": "m, in place of width and depth where the section is round",
    "top_diameter": "m, in place of top_width and top_depth where the section is round",
    "load": "a table: a point mass that rests on the block and turns with it",
    "repeat": "number of blocks that the table stands for",
    "load.mass": "kg",
    "load.above": "m, centroid of the load above the top face of the block",
}
ALTERNATIVES = ("block.width", "block.depth", "block.mass", "block.joint")  # required unless another key is given
WORDS = {
    "material": ", ".join(MATERIALS),
    "block.material": ", ".join(MATERIALS),
    "solver.formulation": " or ".join(FORMULATIONS),
    "solver.integrator": " or ".join(INTEGRATORS),
    "solver.without": f"a list of {', '.join(SKIPS)}",
    "block.section": ", ".join(BLOCK_SECTIONS),
    "joint.section": ", ".join(SECTIONS),
}


def fill_in(app: object, page: str, source: list[str]) -> None:
    """Replace each mark of a page (event source-read). An unknown name is a KeyError."""
    source[0] = PAGES.sub(lambda mark: "\n".join(pages(mark[1])), MARK.sub(lambda mark: PARTS[mark[1]](), source[0]))


def pages(pattern: str) -> list[str]:
    """Names of the pages and notebooks of a pattern, as a list of contents has them."""
    found = (path.relative_to(DOCS) for path in DOCS.glob(pattern) if path.suffix in (".md", ".ipynb"))
    return sorted(path.with_suffix("").as_posix() for path in found)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines)


def code(text: str) -> str:
    """Text as code, nothing where there is none."""
    return f"`{text}`" if text else ""


# keys of the column file


def comments_of(owner: type) -> dict[str, str]:
    """The comment beside each field of a dataclass: its unit and meaning."""
    found: dict[str, str] = {}
    name, inside = "", 0
    for token in tokenize.generate_tokens(io.StringIO(inspect.getsource(owner)).readline):
        inside += (token.string in "([{") - (token.string in ")]}") if token.type == tokenize.OP else 0
        if token.type == tokenize.NAME and not inside and token.line.lstrip().startswith(f"{token.string}:"):
            name = token.string
        elif token.type == tokenize.COMMENT and name:
            found.setdefault(name, token.string.lstrip("# "))
        elif token.type == tokenize.NEWLINE:
            continue
        elif token.type == tokenize.NAME and token.string == "def":
            break
    return found


def keys_of(part: str, keys: Iterable[str], owner: type | None = None) -> str:
    """The keys of a table of the column file: meaning, and the values that are taken."""
    meanings = comments_of(owner) if owner else {}
    required = (
        [item.name for item in fields(owner) if item.default is MISSING] if owner else ["name", "block", "load.mass"]
    )
    rows = []
    for key in keys:
        full = f"{part}.{key}" if part else key
        meaning = DERIVED.get(full) or meanings.get(key) or DERIVED.get(key, "")
        limits = WORDS.get(full) or (NUMBERS[key][1] if key in NUMBERS else "")
        needed = "required" if {key, full} & set(required) and full not in ALTERNATIVES else ""
        rows.append([code(key), meaning.replace("None:", "left out:"), needed, limits])
    return table(["key", "meaning", "", "value"], rows)


# the study file


def formulas() -> str:
    """The formulas of motions, and their numbers."""
    return table(
        ["formula", "needs", "may have", "size"],
        (
            [
                code(name),
                ", ".join(map(code, formula.needs)),
                ", ".join(map(code, formula.optional)),
                code(formula.amplitude),
            ]
            for name, formula in motions.FORMULAS.items()
        ),
    )


STUDY = {
    "name": "a file name; results are NAME.journal, NAME.csv and so on",
    "kind": "which picture and table are made: " + ", ".join(map(code, definition.KINDS)),
    "column": "path of a column file, relative to this file",
    "columns": "a list of such paths, in place of column",
    "structure": "path of a structure file, in place of column",
    "structures": "a list of such paths",
    "motion": "a table [[motion]] for each motion: record with "
    + ", ".join(map(code, motions._OF_RECORDS[1:]))
    + ", or formula; and `name`, "
    + ", ".join(map(code, (*motions.BESIDE, *motions.ON_FLOOR))),
    "grid": "values of what varies, each with each other: a list, or {from, to, count} with spacing",
    "random": "a distribution for each random number; `relative` multiplies, `each` draws one for each block",
    "intensity": "what motions are scaled to: `measure` of "
    + ", ".join(map(code, motions.MEASURES))
    + "; of sa also `period` (s) and `damping`",
    "samples": "number of samples of the random parameters, at every point of the grid; left out: 1",
    "sampling": ", ".join(map(code, definition.SAMPLINGS)),
    "seed": "a whole number; left out: 0",
    "keep": "outputs in the table: see below",
    "tolerance": "of every run; left out: the column's",
    "duration": "s, of every run; left out: that of its motion",
    "limits": "m, largest displacements that count as failure too, of a fragility",
}


def study_keys() -> str:
    """The keys of a study file."""
    return table(["key", "meaning"], ([code(key), STUDY.get(key, "")] for key in definition._KEYS))


# the FMU


def fmu_variables(causality: str) -> str:
    """The variables of one causality, of both formulations and of mortar, those of blocks and joints once for all."""
    block = Block(1.0, 1.0, 1.0, 1.0, Joint(1e9, 1e-3))
    mortar = Block(1.0, 1.0, 1.0, 1.0, Joint(1e9, 1e-3, tensile_strength=1e5))
    columns = [Column("one", (block,), Settings(formulation)) for formulation in FORMULATIONS]
    columns.append(Column("one", (mortar,)))
    rows = {
        item.name: _row(item)
        for one in columns
        for item in variables(one, drive=Drive("body"))
        if item.causality == causality
    }
    return table(["name", "unit", "type", "meaning"], list(rows.values()))


def structure_of_everything() -> Structure:
    """Return a structure that has variables of every kind."""
    data = {
        "name": "one",
        "block": [
            {"name": "block", "position": [0, 0, 0], "width": 1.0, "depth": 1.0, "height": 1.0, "density": 1.0},
            {"name": "top", "on": "block", "width": 1.0, "depth": 1.0, "height": 1.0, "density": 1.0}
            | {"joint": {"tensile_strength": 1e5}},
            {
                "name": "drum",
                "on": "base",
                "at": [1, 0],
                "shape": "drum",
                "diameter": 0.5,
                "height": 1.0,
                "density": 1.0,
            },
        ],
        "neighbours": {"reach": 1.0, "line_stiffness": 1e9, "damping": 0.0, "friction": 0.0},
        "joints": {"stiffness": 1e9, "damping": 1e-3},
        "bearing": [
            {"kind": "elastomeric", "between": ["block", "base"], "at": [0, 0, 0], "diameter": 1.0, "capacity": 1.0}
            | {"vertical_stiffness": 1e9, "vertical_damping": 0.0, "stiffness": 1e6, "damping": 0.0}
        ],
        "tie": [{"between": ["block", "base"], "from": [0, 0, 0], "to": [2, 0, 0], "stiffness": 1e6}],
        "port": [{"name": "point", "block": "block"}],
    }
    return Structure.from_dict(data)


def fmu_variables_in_space(causality: str) -> str:
    """The same of a structure."""
    table_of_one = structure_variables(structure_of_everything(), drive=Drive("body", turns=True))
    rows = [_row(item) for item in table_of_one if item.causality == causality and "[2]" not in item.name]
    return table(["name", "unit", "type", "meaning"], rows)


def exchange_of_column() -> str:
    """Return the text about the exchange that the FMU of a column carries."""
    drive = Drive("horizontal")
    return exchange(variables(Column("one", (Block(1.0, 1.0, 1.0, 1.0, Joint(1e9, 1e-3)),)), drive=drive), drive)


def signals_in_space() -> str:
    """Return what is exchanged with a structure, and the equations, from the text that its FMU carries."""
    drive = Drive("horizontal", turns=True)
    return signals(structure_variables(structure_of_everything(), drive=drive), drive)


def _row(variable: Variable) -> list[str]:
    name = variable.name.replace("[1]", "[i]")
    meaning = re.sub(ELEMENT, r"\1 i", variable.description)
    if variable.choice:
        meaning += ": " + ", ".join(f"{number} {word}" for word, number in variable.choice.items.items())
    if variable.variability == "tunable":
        meaning += "; may change during a run"
    return [code(name), variable.unit, variable.kind, meaning]


# the Python interface

# names that are neither outputs nor new ones, in the order of the page
OTHERS = (
    "model",
    "fallen",
    "what_fell",
    "overturn_time",
    "displacements",
    "top_ux",
    "centroid_ux",
    "energy",
    "opening",
)
ELSEWHERE = (PORT, TIE, BEARING, BOND, CONTACT)  # owners whose outputs have one name, or are of space alone
COMPONENTS = {f"base_{part.name}": part for part in StructureHistories.base.parts}
UNIT = re.compile(r",? \(?(m/s|m|J|s)\)?(?: \([^)]*\))?(?=$|[;,])")  # in the docstring of a property


def result_names() -> str:
    """The names of results: the old one, the unit, and the meaning in the plane and in space."""
    kinds = Response, SpatialResponse
    outputs = [{one.field: one for one in kind.outputs if one.owner not in ELSEWHERE} for kind in kinds]
    outputs[1] |= COMPONENTS
    new = [name for kind in kinds for name in aliases_of(kind).values()]
    rows = []
    for name in dict.fromkeys((*OTHERS, *new, *outputs[0], *outputs[1])):
        found = [table[name] for table in outputs if name in table]
        old = [old for kind in kinds for old, alias in aliases_of(kind).items() if alias == name]
        old += [one.key for one in found if one.key not in ("", name)]
        texts = [_meaning(kind, table.get(name), name) for kind, table in zip(kinds, outputs, strict=True)]
        units = [one.unit for one in found] or [unit[1] for text in texts if (unit := UNIT.search(text))]
        files = [end.name_of("i") for one in found if not one.only_peak for end in one.each]
        rows.append([_codes([name]), _codes(old), (units or [""])[0], *(UNIT.sub("", text) for text in texts)])
        rows[-1].append(_codes(files if len(files) < 6 else [files[0], "...", files[-1]]))
    return table(["name", "old name", "unit", "in the plane", "in space", "in files"], rows)


def _codes(names: Iterable[str]) -> str:
    return ", ".join(map(code, dict.fromkeys(names)))


def _meaning(kind: type, output: Output | None, name: str) -> str:
    """The meaning of a name in a class of responses: from its table of outputs, or its docstrings."""
    if output is not None and output.text:
        return output.text.replace("{it}", f"the {output.owner}").replace("{i}", "i")
    noted = re.search(rf"\n    {name} : [^\n]*\n        ([^\n]*)", Result.__doc__ or "")
    if noted:
        return noted[1].rstrip(".")
    thing = inspect.getattr_static(kind, name, None)
    if output is not None:  # the base of a structure
        thing = Response.base
    return (inspect.getdoc(thing) or "").partition("\n")[0].rstrip(".") if thing is not None else ""


def table_names() -> str:
    """The names of results of many runs that differ from their keys in files."""
    kinds = COLUMNS.keys, STRUCTURES.keys
    both = [{name: name for name in kind.kept} for kind in (COLUMNS, STRUCTURES)]
    names = dict.fromkeys(name for keys in kinds for name in keys)
    rows = (
        [code(name), *(code(keys.get(name) or own.get(name, "")) for keys, own in zip(kinds, both, strict=True))]
        for name in names
    )
    return table(["name", "key of columns", "key of structures"], rows)


NOT_OURS = "tuple, dict, Protocol"  # classes whose members are not on the page


def python_names() -> str:
    """Every public name of `multiblock`, with its docstring."""
    parts: dict[str, list[str]] = {"Functions": [], "Classes": [], "Exceptions and warnings": [], "Modules": []}
    for name in multiblock.__all__:
        thing = getattr(multiblock, name)
        if inspect.ismodule(thing):
            elsewhere = [key for key in multiblock.__all__ if hasattr(thing, key)]  # once on the page
            parts["Modules"].append(f".. automodule:: {thing.__name__}\n   :exclude-members: {', '.join(elsewhere)}")
        elif inspect.isclass(thing):
            error = issubclass(thing, (Exception, Warning))
            inherited = "" if error else f"\n   :inherited-members: {NOT_OURS}"
            parts["Exceptions and warnings" if error else "Classes"].append(
                f".. autoclass:: multiblock.{name}{inherited}"
            )
        elif callable(thing):
            parts["Functions"].append(f".. autofunction:: multiblock.{name}")
    return "\n\n".join(
        f"## {title}\n\n" + "\n\n".join(f"```{{eval-rst}}\n{line}\n```" for line in lines)
        for title, lines in parts.items()
    )


def as_restructured_text(app: object, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Make a docstring of this project, which is plain text, one that Sphinx reads (event autodoc-process-docstring).

    Lines that begin with names and a colon become items of a list, and so do the fields of a dataclass with their
    comments.
    """
    if what == "class" and is_dataclass(thing):
        lines += ["", *(f"{field}: {comment}" for field, comment in comments_of(thing).items())]
    made: list[str] = []
    for line in lines:
        text = re.sub(r"([*|])|(?<=\w)_(?=\W|$)", lambda found: "\\" + found[0], line)
        if re.match(r"[A-Za-z_]\w*( \(\w+\))?(, [A-Za-z_]\w*)*( \([^)]*\))?: \S", line) and what != "attribute":
            if made and made[-1].strip() and not made[-1].startswith(("* ", "  ")):
                made.append("")
            text = f"* {text}"
        elif made and made[-1].startswith(("* ", "  ")) and text.strip():
            text = f"  {text.lstrip()}"
        made.append(text)
    lines[:] = made


def copy_notebooks(app: object) -> None:
    """Bring the notebooks of the examples into the folder that Sphinx reads."""
    for notebook in sorted((DOCS.parent / "examples" / "notebooks").glob("*.ipynb")):
        (DOCS / "notebooks").mkdir(exist_ok=True)
        shutil.copy(notebook, DOCS / "notebooks")


PARTS = {
    "column-keys": lambda: keys_of("", column_file._COLUMN_KEYS),
    "block-keys": lambda: keys_of("block", column_file._BLOCK_KEYS, Block),
    "load-keys": lambda: keys_of("load", column_file._LOAD_KEYS),
    "joint-keys": lambda: keys_of("joint", column_file._JOINT_KEYS, Joint),
    "solver-keys": lambda: keys_of("solver", column_file._SETTINGS_KEYS, Settings),
    "study-keys": study_keys,
    "formulas": formulas,
    "distributions": lambda: table(
        ["distribution", "numbers"],
        ([code(name), ", ".join(map(code, needs))] for name, needs in distributions._NEEDS.items()),
    ),
    "kept": lambda: table(["output", "unit"], ([code(name), kept.unit] for name, kept in KEPT.items())),
    "kept-in-space": lambda: table(
        ["output", "unit", "of"],
        ([code(name), kept.unit, "run" if kept.kind else kept.of] for name, kept in KEPT_IN_SPACE.items()),
    ),
    "inputs": lambda: fmu_variables("input"),
    "outputs": lambda: fmu_variables("output"),
    "parameters": lambda: fmu_variables("parameter"),
    "inputs-in-space": lambda: fmu_variables_in_space("input"),
    "outputs-in-space": lambda: fmu_variables_in_space("output"),
    "parameters-in-space": lambda: fmu_variables_in_space("parameter"),
    "exchange": exchange_of_column,
    "signals-in-space": signals_in_space,
    "python-names": python_names,
    "result-names": result_names,
    "table-names": table_names,
}
