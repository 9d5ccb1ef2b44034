"""Build the FMUs of a coupled system: the column, the partners of this folder, and SSPs that connect them.

    python examples/coupling/build.py [COLUMN.toml] [-o FOLDER] [--native [--platforms NAME,...]] [--record FILE]

Writes column.fmu and column_on_soil.fmu, whose base is driven by isolators and by soil, isolator.fmu, soil.fmu;
isolated_inputs.ssp and on_soil_inputs.ssp, in which the ground motion is an
input of the system; and, where the compiler of the native FMUs is installed, ground.fmu, which holds the record
(without --record five waves of 1 Hz and 0.1 g), with isolated.ssp and on_soil.ssp, which need nothing from outside.
With --native also in_c/, for master.c on Linux.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib
import math
import sys
import tempfile
import uuid
from pathlib import Path
from typing import Any

import ssp
from partner_table import native_partner
from pythonfmu import FmuBuilder

from build_fmu import build_fmu, build_native_fmu, repack, write_archive
from fmu_src import host
from fmu_src.drive import Drive
from fmu_src.native.library import has_tools
from fmu_src.native.platforms import PLATFORMS
from multiblock import Column, InputError, Motion

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PARTNERS = ("isolator", "soil")
# the column on each of them, driven by it with the slope that it takes
COLUMNS = {"column": Drive("horizontal", "parabola"), "column_on_soil": Drive("body", "line")}
OF_PARTNER = dict(zip(PARTNERS, COLUMNS, strict=True))
DEFAULT_COLUMN = ROOT / "examples" / "columns" / "phocas-damped.toml"
STEP = 1e-3  # s
WAVES = "waves.csv"  # the ground where no record is given
SCRIPT = '''"""Entry of the FMU."""

from {package} import {module}
from {package}.partner import Partner


class Slave(Partner):
    """The slave of this FMU; the wrapper wants a class of this script's own."""

    law = {module}

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
'''


def build_partner(module: str, output: Path) -> Path:
    """Build the FMU of isolator.py or soil.py; its code goes by a name that ends in the hash of its content."""
    files = {"__init__.py": "", "host.py": Path(host.__file__).read_text(encoding="utf-8")}
    files |= {f"{name}.py": (HERE / f"{name}.py").read_text(encoding="utf-8") for name in ("law", "partner", module)}
    identity = hashlib.sha256("\0".join(files.values()).encode()).hexdigest()
    package = f"{module}_{identity[:16]}"
    with tempfile.TemporaryDirectory(prefix="build_partner_") as folder:
        stage = Path(folder)
        (stage / package).mkdir()
        for name, text in files.items():
            (stage / package / name).write_text(text, encoding="utf-8")
        script = stage / f"slave_{identity[:16]}.py"
        script.write_text(SCRIPT.format(package=package, module=module), encoding="utf-8")
        guid = stage / "guid.txt"
        guid.write_text(f"{{{uuid.uuid5(uuid.NAMESPACE_OID, identity)}}}", encoding="utf-8")
        sys.path.insert(0, folder)
        importlib.invalidate_caches()
        try:
            built = FmuBuilder.build_FMU(script, dest=stage / "built.fmu", project_files=[stage / package, guid])
        finally:
            sys.path[:] = [entry for entry in sys.path if not entry.startswith(folder)]
        output.parent.mkdir(parents=True, exist_ok=True)
        repack(Path(built), output, {})
    return output


def build_native_partner(module: str, output: Path, platforms: list[str], record: Path | None = None) -> Path:
    """Build the FMU without Python of isolator.py, soil.py, or ground.py with its record."""
    files, _ = native_partner(module, platforms, record)
    output.parent.mkdir(parents=True, exist_ok=True)
    write_archive(output, files)
    return output


def build_all(
    folder: Path,
    column: Path = DEFAULT_COLUMN,
    native: bool = False,
    platforms: list[str] | None = None,
    record: Path | None = None,
) -> dict[str, Path]:
    """Build everything into a folder; paths by name."""
    folder.mkdir(parents=True, exist_ok=True)
    platforms = [*PLATFORMS[2]] if platforms is None else platforms
    made = {name: folder / f"{name}.fmu" for name in (*COLUMNS, *PARTNERS)}
    for name, drive in COLUMNS.items():
        if native:
            build_native_fmu(column, made[name], platforms=platforms, drive=drive)
        else:
            build_fmu(column, made[name], drive=drive)
    for name in PARTNERS:
        if native:
            build_native_partner(name, made[name], platforms)
        else:
            build_partner(name, made[name])
    stop = 10.0
    if has_tools():
        if record is None:
            record = folder / WAVES
            record.write_text(waves(), encoding="utf-8")
        made["ground"] = build_native_partner("ground", folder / "ground.fmu", platforms, record)
        stop = Motion.from_file(record).end
    return made | build_systems(folder, made, column, stop, native and "linux64" in platforms)


def build_systems(
    folder: Path, fmus: dict[str, Path], column: Path, stop: float, native: bool = False, step: float = STEP
) -> dict[str, Path]:
    """Build the SSPs, and of native FMUs what master.c reads; paths by name. step: s, how often they exchange."""
    weight = sum(block.mass for block in Column.from_toml(column).blocks) * Column.from_toml(column).g
    parameters: dict[str, dict[str, Any]] = {
        "isolator": {"mass": 40e3, "stiffness": 1.2e6, "damping": 7.6e4},
        "soil": {"mass": 60e3, "shear_velocity": 250.0, "weight": weight},
        "ground": {"scale": 1.0, "step": step},
    }
    outside = {name: path for name, path in fmus.items() if name != "ground"}
    made = {}
    for given in (fmus, outside) if "ground" in fmus else (outside,):
        for partner in PARTNERS:
            inside = {**given, "column": fmus[OF_PARTNER[partner]]}
            system = ssp.coupled(partner, inside, parameters, stop, step)
            made[system.name] = ssp.write(system, folder / f"{system.name}.ssp")
            if native and "ground" in inside:
                watched = [("column", "block[1].ux"), (partner, "x")]
                made[f"{system.name}_in_c"] = ssp.wire(system, folder / "in_c", "linux64", watched)
    return made


def waves() -> str:
    """Return a record in CSV: 0.1 g at 1 Hz, which begins and ends softly, five waves and as long again of silence."""
    lines = ["time,base.ax"]
    for k in range(1001):
        t = 0.01 * k
        ease = min(1.0, t, max(0.0, 5.0 - t))
        lines.append(f"{t!r},{0.980665 * ease * math.sin(2.0 * math.pi * t)!r}")
    return "\n".join(lines) + "\n"


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(description="Build column, isolator, soil and ground, and SSPs of them.")
    parser.add_argument("column", nargs="?", type=Path, default=DEFAULT_COLUMN, help="TOML file (default: %(default)s)")
    parser.add_argument("-o", "--output-folder", type=Path, default=Path("results"))
    parser.add_argument("--native", action="store_true", help="compiled libraries instead of Python")
    parser.add_argument("--platforms", default=",".join(PLATFORMS[2]), help="of the native FMUs (default: %(default)s)")
    parser.add_argument("--record", type=Path, metavar="FILE", help="ground motion for ground.fmu")
    options = parser.parse_args()
    platforms = options.platforms.split(",")
    try:
        made = build_all(options.output_folder, options.column, options.native, platforms, options.record)
    except (InputError, OSError) as error:
        print(f"build.py: {error}", file=sys.stderr)
        return 2
    for path in made.values():
        print(path)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
