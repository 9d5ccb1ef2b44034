"""No file is part of a circle of imports, those inside functions included and those for annotations excluded.

`python tests/project/test_imports.py` prints the circles.
"""

from __future__ import annotations

import ast
from collections import deque
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("solver", "fmu_src", "multiblock", "build_fmu.py", "benchmarks", "stress", "validation")
Graph = Mapping[str, Mapping[str, int]]  # module -> the modules that it imports, each with the number of the line


def import_graph(root: Path, packages: tuple[str, ...]) -> Graph:
    """Return the imports among the modules of packages.

    `from package import name` counts as an import of the submodule `name`, if there is one; the packages around it are
    not counted.
    """
    files = [
        file for name in packages for file in ((root / name).rglob("*.py") if (root / name).is_dir() else [root / name])
    ]
    modules = {".".join(file.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): file for file in files}
    graph: dict[str, dict[str, int]] = {}
    for module, file in modules.items():
        package = module if file.name == "__init__.py" else module.rpartition(".")[0]
        found = graph[module] = {}
        for name, line in _imported(ast.parse(file.read_text(encoding="utf-8")), package, frozenset(modules)):
            if name in modules and name != module:
                found.setdefault(name, line)
    return graph


def _imported(node: ast.AST, package: str, modules: frozenset[str]) -> Iterator[tuple[str, int]]:
    """Yield the modules imported below a node, with lines."""
    if isinstance(node, ast.Import):
        yield from ((alias.name, node.lineno) for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        parts = package.split(".")[: len(package.split(".")) + 1 - node.level] if node.level else []
        source = ".".join([*parts, *filter(None, [node.module])])
        for alias in node.names:
            inner = f"{source}.{alias.name}"
            yield inner if inner in modules else source, node.lineno
    only_types = isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
    for child in node.orelse if isinstance(node, ast.If) and only_types else ast.iter_child_nodes(node):
        # expressions import nothing
        if not isinstance(child, ast.expr):
            yield from _imported(child, package, modules)


def files_in_circles(graph: Graph) -> list[list[str]]:
    """Return the strongly connected components of more than one module."""
    reached = {module: _reached(graph, module) for module in graph}
    rest, found = set(graph), []
    while rest:
        module = min(rest)
        circle = sorted({module} | {other for other in reached[module] if module in reached[other]})
        rest -= set(circle)
        if len(circle) > 1:
            found.append(circle)
    return found


def _reached(graph: Graph, start: str) -> set[str]:
    found, queue = set[str](), [start]
    while queue:
        for module in graph[queue.pop()]:
            if module not in found:
                found.add(module)
                queue.append(module)
    return found


def shortest_circle(graph: Graph, modules: list[str]) -> str:
    """Return the shortest circle within a component, a line for each import."""
    paths = (path for module in modules if (path := _path_back(graph, module)))
    path = min(paths, key=len)
    return "\n".join(f"  {one}, line {graph[one][other]}, imports {other}" for one, other in pairwise(path))


def _path_back(graph: Graph, start: str) -> list[str]:
    """Return the shortest path of imports from a module to itself."""
    before: dict[str, str] = {}
    queue = deque([start])
    while queue:
        module = queue.popleft()
        for other in graph[module]:
            if other == start:
                path = [start, module]
                while path[-1] != start:
                    path.append(before[path[-1]])
                return path[::-1]
            if other not in before:
                before[other] = module
                queue.append(other)
    return []


def report(graph: Graph) -> str:
    """Return a sentence for each component with its shortest circle, or ""."""
    return "\n".join(
        f"{len(modules)} files import each other, the shortest circle:\n{shortest_circle(graph, modules)}"
        for modules in files_in_circles(graph)
    )


def test_no_file_is_in_a_circle_of_imports() -> None:
    graph = import_graph(ROOT, PACKAGES)
    assert len(graph) > 300
    found = report(graph)
    assert not found, f"\n{found}\nA lower layer asks a function that a higher one registers (solver/registrations.py)."


def test_a_circle_is_found_and_named(tmp_path: Path) -> None:
    package = tmp_path / "knot"
    package.mkdir()
    sources = {
        "__init__": "",
        "a": "from . import b\nfrom .c import x",
        "b": "def late():\n    from knot.c import x",
        "c": "import knot.a\nfrom typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from . import d",
        "d": "from . import a",
    }
    for name, text in sources.items():
        (package / f"{name}.py").write_text(text)
    graph = import_graph(tmp_path, ("knot",))
    assert files_in_circles(graph) == [["knot.a", "knot.b", "knot.c"]]
    shortest = "  knot.a, line 2, imports knot.c\n  knot.c, line 1, imports knot.a"
    assert report(graph) == f"3 files import each other, the shortest circle:\n{shortest}"


if __name__ == "__main__":
    print(report(import_graph(ROOT, PACKAGES)) or "no circle")


def test_kernels_are_few_packages_that_know_few_others() -> None:
    """Count the packages: measured 7, with 16 arrows between them."""
    kernels = ROOT / "solver" / "kernels"
    packages = {file.parent.name for file in kernels.glob("*/__init__.py")}
    arrows = set()
    for file in kernels.glob("*/**/*.py"):
        inside = file.relative_to(kernels)
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level == len(inside.parts):  # from solver.kernels
                for name in [node.module.partition(".")[0]] if node.module else [one.name for one in node.names]:
                    arrows |= {(inside.parts[0], name)} - {(name, name)}
    assert len(packages) <= 7, sorted(packages)
    assert len(arrows) <= 18, sorted(arrows)
