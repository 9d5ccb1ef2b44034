"""The compatibility information that the FMI project asks of tools: `python tests/masters/compatibility.py FOLDER`.

    --master NAME   one row of the table alone; may be repeated

Writes FOLDER/README.md, the table of run.py with the versions of this machine, and a folder for each example FMU with
the files that CONTRIBUTING.md of modelica/fmi-standard.org names: NAME.fmu, NAME_in.csv, NAME_ref.csv (at most ten
variables), NAME_ref.opt and Readme.txt. The page has the answer of each checker that is installed. Fetches nothing; the
exit code is that of run.py. `tools.json` names its address as examplesUrl.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import io
import platform
import sys
import zipfile
from collections.abc import Sequence
from datetime import date
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from masters import run as masters

from fmu_src.reference_run import STEP, STEPS, replay
from multiblock import __version__

EXAMPLES = {  # column or structure, options of the builder
    "phocas_native2": ("columns/phocas-damped.toml", ("--native", "--platforms", "linux64,win64")),
    "phocas_native3": ("columns/phocas-damped.toml", ("--native", "--fmi", "3", "--scalars")),
    "phocas_python": ("columns/phocas-damped.toml", ()),
    "trilith_native2": ("structures/trilith.toml", ("--native", "--platforms", "linux64,win64")),
}
MOST = 10  # variables of a reference solution, as recommended
PAGE = """\
# Compatibility information of multiblock-fmu {version}

Provided by the authors of multiblock-fmu, not by the Modelica Association or the FMI project. {when}, {system}, Python
{python}. multiblock-fmu exports FMUs for co-simulation of FMI 2.0 and 3.0; it imports none.

## Importing tools

Each cell is what a tool did with an FMU: the largest deviation of the base forces from those of the PythonFMU under
FMPy, the answer of a checker, or why it was not run. Made by `python tests/masters/compatibility.py`.

{table}

## Example FMUs

Reference: 1 s of a base acceleration of 0.2 g at 2 Hz along x, communication steps of {step} s, each input held over a
step. NAME_ref.csv has the first {most} outputs. An FMU holds all of them, in `extra/org.fmi-standard.fmi-ls-ref`.

| FMU | model | options of `multiblock build-fmu` | replayed in FMPy |
|---|---|---|---|
{examples}
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page and the examples; returns the exit code."""
    parser = argparse.ArgumentParser(description="Write the compatibility information of this machine.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--master", action="append", default=[], choices=[*masters.MASTERS])
    options = parser.parse_args(arguments)
    rows = []
    for name, (model, build) in EXAMPLES.items():
        rows.append(example(options.folder / name, name, model, build))
    table = io.StringIO()
    chosen = [word for name in options.master for word in ("--master", name)]
    with contextlib.redirect_stdout(table):
        code = masters.main(["--folder", str(options.folder / "of-table"), *chosen])
    words: dict[str, object] = {"version": __version__, "when": date.today().isoformat()}
    words |= {"python": platform.python_version(), "system": f"{platform.system()} on {platform.machine()}"}
    words |= {"step": STEP, "most": MOST}
    page = PAGE.format(**words, table=table.getvalue().strip(), examples="\n".join(rows))
    (options.folder / "README.md").write_text(page, encoding="utf-8")
    print(page)
    return code


def example(folder: Path, name: str, model: str, build: Sequence[str]) -> str:
    """Build an FMU with its reference run, write the files beside it, and return its row of the table."""
    folder.mkdir(parents=True, exist_ok=True)
    fmu = folder / f"{name}.fmu"
    file = masters.ROOT / "examples" / model
    masters.run(sys.executable, masters.ROOT / "build_fmu.py", file, "--reference", *build, "-o", fmu)
    with zipfile.ZipFile(fmu) as archive:
        carried = {
            end: next(archive.read(path).decode() for path in archive.namelist() if path.endswith(f"_{end}.csv"))
            for end in ("in", "out")
        }
        words = archive.read("documentation/fmi-ls-ref.txt").decode()
    (folder / f"{name}_in.csv").write_text(carried["in"], encoding="utf-8")
    (folder / f"{name}_ref.csv").write_text(_first(carried["out"], 1 + MOST), encoding="utf-8")
    settings = {"StartTime": 0.0, "StopTime": STEPS * STEP, "StepSize": STEP, "RelTol": 1e-5, "SolverType": "FixedStep"}
    settings["OutputIntervalLength"] = STEP
    lines = "".join(f"{key}, {value}\n" for key, value in settings.items())
    (folder / f"{name}_ref.opt").write_text(lines, encoding="utf-8")
    (folder / "Readme.txt").write_text(
        f"{name}.fmu: {model}, rigid blocks that rock and slide on elastic joints, for co-simulation.\n{words}",
        encoding="utf-8",
    )
    said = replay(fmu).partition("largest difference ")[2]
    return f"| {name} | {model} | {' '.join(build) or 'none'} | {said} |"


def _first(text: str, count: int) -> str:
    """Return the first columns of a CSV file, whose names stay in quotes."""
    names, *rows = csv.reader(io.StringIO(text))
    head = ",".join(f'"{name}"' for name in names[:count])
    return "\n".join([head, *(",".join(row[:count]) for row in rows)]) + "\n"


if __name__ == "__main__":
    sys.exit(main())
