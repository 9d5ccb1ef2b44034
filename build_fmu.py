"""Build a co-simulation FMU from the TOML file of a column or of a structure in space.

    multiblock build-fmu [FILE.toml] [-o FILE.fmu] [--record RECORD] [--space]
                         [--real-outputs] [--reference]
                         [--native [--fmi 3 [--scalars]] [--source] [--terminals] [--platforms NAME,...]]
    python build_fmu.py ...

This module only packages. Inside the FMU the names of the two packages contain the hash of their content, so that two
FMUs in one process, or two builds of one, never run each other's code.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib
import re
import shutil
import sys
import tempfile
import uuid
import zipfile
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import fmu_src
import solver
from fmu_src.body import Body, body_for, read_body
from fmu_src.bytecode import bytecode_of
from fmu_src.drive import USUAL, Drive, drive_of
from fmu_src.host import ARCHIVE, CODE_FOLDER
from fmu_src.native import guard
from fmu_src.native.library import has_tools
from fmu_src.native.platforms import PLATFORMS, USUAL_FORM, Form
from fmu_src.record import usual_experiment
from fmu_src.reference_run import FOLDER as RUN_FOLDER
from fmu_src.reference_run import reference_files, replay
from fmu_src.variables import with_real_outputs
from solver import InputError
from solver.commands.command_files import add_force, add_space
from solver.commands.command_line import program_parser, run_command
from solver.common.errors import needing, shown
from solver.common.files import check_outputs, identifier_of, whole_file
from solver.ground.motion import Motion
from solver.ground.records import format_of
from solver.ground.records.columns import PLAIN
from solver.kernels.layout.spaces import DRIVES, SLOPES
from solver.kernels.machine.packaging import libraries
from solver.kernels.machine.sources import SOURCES
from solver.kernels.machine.zig import has_linker

COLUMNS_PACKAGE = "multiblock_columns"  # name of examples/columns/ in an installed project
BUILDER_PACKAGES = ("pythonfmu", "matplotlib")
SOURCES_FILE = "kernels/machine/sources.py"
LEFT_AT_HOME = {
    "fmu_src/bytecode.py",
    "fmu_src/documentation.py",
    "fmu_src/exchange.py",
    "fmu_src/licences.py",
    "fmu_src/model_description3.py",
    "fmu_src/native",
    "fmu_src/reference_run.py",
    "solver/__main__.py",
    "solver/checks",
    "solver/commands",
    "solver/ground/intensity.py",
    "solver/ground/oscillator.py",
    "solver/ground/wavelets.py",
    "solver/models/column/push.py",
    "solver/models/structure/push.py",
    "solver/plotting",
    "solver/statics/calibrate.py",
    "solver/statics/capacity.py",
    "solver/statics/rocking.py",
    "solver/statics/static_plots.py",
    "solver/studies",
}  # files and folders that are not carried: an FMU does not need them
NEEDS = "The machine that runs it needs Python 3.11 or newer with numpy."
NEEDS_OBJECTS = (
    "The machine that runs it needs Python 3.11 or newer with numpy and llvmlite, and the builder's system and kind of "
    "processor: it was built without ziglang."
)
# platforms for which an FMU in Python carries machine code
CARRIED_PLATFORMS = ("manylinux_2_17_x86_64", "win_amd64", "macosx_11_0_x86_64", "macosx_11_0_arm64")
ZIP_DATE = (1980, 1, 1, 0, 0, 0)  # fixed, so that the same input gives the same bytes

SCRIPT = '''"""Entry of the FMU: brings in the solver and offers the slave."""

import sys
from pathlib import Path

RESOURCES = Path(__file__).resolve().parent
sys.path.insert(0, str(RESOURCES / "{archive}"))
from {fmu_src}.host import finalize_at_exit, import_solver

finalize_at_exit(RESOURCES)  # also if no slave will do it
try:
    import_solver("{solver}", RESOURCES / "{archive}")
    from {fmu_src}.slave import BlocksSlave{others}
except ImportError as error:
    print(f"{name}: needs Python 3.11 or newer with numpy: {{error}}", file=sys.stderr)
    raise


class Slave(BlocksSlave):
    """The slave of this FMU: the wrapper needs a class defined in this script."""
{more}
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
'''


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line of `python build_fmu.py`, and return the exit code, 2 for a user's mistake."""
    parser = program_parser("build_fmu.py", "Build the FMU of a column or structure of blocks.")
    add_options(parser)
    return run_command(parser, arguments)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command `build-fmu`, for `run_command`."""
    parser.set_defaults(command=_build)
    parser.add_argument(
        "column",
        nargs="?",
        type=Path,
        default=DEFAULT_COLUMN,
        help="TOML file of a column or structure (default: %(default)s)",
    )
    parser.add_argument("-o", "--output", type=Path, help="FMU file (default: NAME.fmu in the current folder)")
    add_space(parser)
    add_force(parser)
    # motion of the base
    drive = parser.add_argument_group("how the base moves; the words are start values of parameters")
    drive.add_argument("--drive", choices=tuple(DRIVES), default=USUAL.drive, help="by its acceleration, or by bodies")
    drive.add_argument("--slope", choices=tuple(SLOPES), default=USUAL.slope, help="of its acceleration within a step")
    drive.add_argument("--bodies", type=int, default=USUAL.bodies, metavar="N", help="that may drive it (default: 1)")
    drive.add_argument("--turns", action="store_true", help="the base of a structure may turn about x and y too")
    parser.add_argument("--record", type=Path, metavar="FILE", help="record to put inside, added to the inputs")
    # format of the FMU
    parser.add_argument("--native", action="store_true", help="compiled libraries instead of Python")
    parser.add_argument("--fmi", type=int, choices=(2, 3), default=2, help="version of FMI; 3: native only")
    parser.add_argument("--scalars", action="store_true", help="with --fmi 3: no arrays, for hosts that know none")
    parser.add_argument("--source", action="store_true", help="with the source code inside, for hosts that compile")
    parser.add_argument("--terminals", action="store_true", help="terminals of FMI 3.0 in an FMU of FMI 2.0, too")
    known = "; ".join(f"FMI {version}: {','.join(names)}" for version, names in PLATFORMS.items())
    parser.add_argument("--plain-names", action="store_true", help="block1.ux in place of block[1].ux")
    parser.add_argument(
        "--real-outputs", action="store_true", help="without outputs that are no reals (verdict, overturned ...)"
    )
    parser.add_argument("--reference", action="store_true", help="with a short run and its results inside (replay)")
    parser.add_argument("--platforms", help=f"of the native FMU, with commas (default: all; {known})")


def add_replay(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command `replay`, which repeats the reference run of an FMU, for `run_command`."""
    parser.set_defaults(command=lambda options: print(replay(options.fmu)))
    parser.add_argument("fmu", type=Path, help="FMU built with --reference")


def _build(options: argparse.Namespace) -> None:
    if options.scalars and options.fmi != 3:
        raise InputError("--scalars: with --fmi 3 only, FMI 2.0 has no arrays")
    if options.output is not None and options.output.parent.is_dir():  # a missing folder is created
        check_outputs((options.output,), (options.column, options.record), options.force)
    # options that exclude one another
    drive = drive_of(options.drive, options.slope, options.bodies, options.turns)
    if not drive.is_chosen and drive != USUAL._replace(turns=drive.turns):
        given = "--slope" if drive.slope != USUAL.slope else "--bodies"
        raise InputError(f"{given}: must be left out without --drive body or horizontal")
    if drive.drive != USUAL.drive and options.record is not None:
        raise InputError("--record: must be left out with --drive, the ground moves the bodies at the base")
    if options.plain_names and options.fmi == 3 and not options.scalars:
        raise InputError("--plain-names: with --fmi 3 only beside --scalars, arrays have no brackets in their names")
    # native or in Python
    rest = options.space, drive, options.plain_names, options.reference
    if options.native:
        platforms = None if options.platforms is None else re.split(r"[,\s]+", options.platforms.strip())
        form = Form(options.fmi, options.source, options.terminals, options.scalars, options.real_outputs)
        path = build_native_fmu(options.column, options.output, options.record, platforms, form, *rest)
    else:
        native_only = {
            "--source": options.source,
            "--terminals": options.terminals,
            "--platforms": options.platforms is not None,
            f"--fmi {options.fmi}": options.fmi != 2,
        }
        if refused := [option for option, is_given in native_only.items() if is_given]:
            raise InputError(f"{refused[0]}: with --native only")
        path = build_fmu(options.column, options.output, options.record, *rest, options.real_outputs)
    print(path)


def _default_column() -> Path:
    """Return the file of the Column of Phocas, damped: in the clone with this file, or installed beside this file."""
    here = Path(__file__).resolve().parent
    clone = here / "examples" / "columns"
    return (clone if clone.is_dir() else here / COLUMNS_PACKAGE) / "phocas-damped.toml"


DEFAULT_COLUMN = _default_column()
NOT_IN_NAMES = '<>:"/\\|?*'  # in a file name of Windows


def build_native_fmu(
    column_file: Path,
    output: Path | None = None,
    record: Path | None = None,
    platforms: Sequence[str] | None = None,
    form: Form = USUAL_FORM,
    space: bool = False,
    drive: Drive = USUAL,
    plain_names: bool = False,
    reference: bool = False,
) -> Path:
    """Build the FMU that needs no Python, and return its path; prints which external symbols its libraries need.

    `platforms` are names in PLATFORMS[form.fmi], by default all of them; `form` has the version of FMI and the options
    of the archive. The other arguments, and the errors, are those of `build_fmu`.
    """
    with needing("native", *BUILDER_PACKAGES):
        from fmu_src.native.package import native_files, needs_report
    body, output, motion = _prepared(column_file, output, record, space, drive)
    known = PLATFORMS[form.fmi]
    platforms = [*known] if platforms is None else platforms
    for platform in platforms:
        if platform not in known:
            raise InputError(f"--platforms {platform}: must be of {', '.join(known)}")
    if body.why_not_native:
        raise InputError(f"--native: {column_file} {body.why_not_native}")
    record_name = record.name if record else ""
    print(f"building the libraries of {', '.join(dict.fromkeys(platforms))}", file=sys.stderr, flush=True)
    files, needs = native_files(body, list(dict.fromkeys(platforms)), motion, record_name, form)
    print(needs_report(needs), file=sys.stderr)
    if reference:
        files |= reference_files(body, motion, form.fmi == 3 and not form.scalars)
    output.parent.mkdir(parents=True, exist_ok=True)
    write_archive(output, without_brackets(files) if plain_names else files)
    return output


def _prepared(
    given: Any, output: Path | None, record: Path | None, space: bool, drive: Drive
) -> tuple[Body, Path, Motion | None]:
    """Return the body, the FMU file and the motion of the record. Raises InputError."""
    body = read_body(given, space, drive) if isinstance(given, Path) else body_for(given)
    if output is None:
        output = Path(f"{identifier_of(body.name)}.fmu")
        if output.exists():
            print(f"{output}: was there already and is replaced", file=sys.stderr)
    if output.suffix != ".fmu":
        raise InputError(f"-o {output}: must end in .fmu")
    if record is None:
        return body, output, None
    _check_record_name(record.name)
    try:
        motion = Motion.from_file(record)
    except InputError as why:
        if record.is_file() and format_of(record) == PLAIN:  # an FMU has no option for units
            raise InputError(f"{why}; for an FMU, multiblock convert writes a file that needs none") from None
        raise
    body.samples(motion)  # raises InputError for an unsuitable motion
    return body, output, motion


def _check_record_name(name: str) -> None:
    """Raise InputError unless XML can hold the name of a record and every system can unpack a file of this name."""
    if not name.isprintable() or any(letter in NOT_IN_NAMES for letter in name) or name[-1:] in (" ", "."):
        raise InputError(
            f"the name of --record = {shown(name)}: must have no control characters and none of {NOT_IN_NAMES}, and "
            "not end with a dot or a space: rename the file"
        )


def build_fmu(
    column: Any,
    output: Path | None = None,
    record: Path | None = None,
    space: bool = False,
    drive: Drive = USUAL,
    plain_names: bool = False,
    reference: bool = False,
    real_outputs: bool = False,
) -> Path:
    """Build the FMU of a file or of a model, which runs in Python, and return its path.

    Parameters
    ----------
    column : Path or model
        TOML file of a column or structure, or a model, whose kind needs a `Body` (fmu_src/body.py); the package of that
        body is put inside.
    output : Path, optional
        FMU file. Default: NAME.fmu in the current folder.
    record : Path, optional
        Record to put inside.
    space : bool
        If True, solve the column of a file as a structure in space.
    drive : Drive
        How the base moves (fmu_src/drive.py).
    plain_names : bool
        If True, name variables as `without_brackets` does.
    reference : bool
        If True, add the reference results that `replay` compares with.
    real_outputs : bool
        If True, leave out outputs that are no reals.

    Raises
    ------
    InputError
        If an argument is wrong.
    OSError
        If a file cannot be read or written.
    """
    with needing("fmu", *BUILDER_PACKAGES):
        from pythonfmu import FmuBuilder

        from fmu_src import documentation
        from fmu_src.licences import REQUIRED, legal_files
        from fmu_src.slave import BODY_FILE, GUID_FILE, RECORD_FOLDER
    body, output, motion = _prepared(column, output, record, space, drive)
    with tempfile.TemporaryDirectory(prefix="build_fmu_") as folder:
        stage = Path(folder)
        # solver and FMU code, renamed by hash; the package of a body of another model
        kernels = body.kernels
        carried: dict[str, bytes] = {}
        carried_solver = _carry_package(solver, carried, {}, *kernels[:1])
        carried_fmu_src = _carry_package(fmu_src, carried, {"solver": carried_solver})
        package, _, module = type(body).__module__.partition(".")
        others = ""
        if package != fmu_src.__name__:  # the body of another model
            renamed = {"solver": carried_solver, "fmu_src": carried_fmu_src}
            other = _carry_package(sys.modules[package], carried, renamed)
            others = f"\n    import {other}.{module}  # noqa: F401"
        more = "\n    real_outputs = True\n" if real_outputs else ""
        packages = {"solver": carried_solver, "fmu_src": carried_fmu_src, "archive": ARCHIVE}
        script = SCRIPT.format(name=body.name, others=others, more=more, **packages)
        write_archive(stage / ARCHIVE, carried | bytecode_of(carried))
        # identity: a hash of the code, the model and the record
        content = script.encode() + body.text.encode()
        if record is not None:
            content += record.name.encode() + record.read_bytes()
        identity = hashlib.sha256(content).hexdigest()
        script_file = stage / f"slave_{identity[:16]}.py"
        script_file.write_text(script, encoding="utf-8")
        (stage / BODY_FILE).write_text(body.text, encoding="utf-8")
        (stage / GUID_FILE).write_text(f"{{{uuid.uuid5(uuid.NAMESPACE_OID, identity)}}}", encoding="utf-8")
        # machine code of the kernels for all platforms
        code_folder = stage / CODE_FOLDER
        code_folder.mkdir()
        for name, code in libraries(kernels, CARRIED_PLATFORMS).items():
            (code_folder / name).write_bytes(code)
        # PythonFMU imports the script to read the model description
        sys.path.insert(0, str(stage))
        importlib.invalidate_caches()
        try:
            parts = [stage / ARCHIVE, code_folder, stage / BODY_FILE, stage / GUID_FILE]
            if record is not None:
                (stage / RECORD_FOLDER).mkdir()
                shutil.copy(record, stage / RECORD_FOLDER)
                parts.append(stage / RECORD_FOLDER)
            built = FmuBuilder.build_FMU(script_file, dest=stage / "built.fmu", project_files=parts)
        finally:
            sys.path[:] = [entry for entry in sys.path if not entry.startswith(str(stage))]
        # documentation, licences and reference results
        output.parent.mkdir(parents=True, exist_ok=True)
        needs = NEEDS if has_linker() or not kernels else NEEDS_OBJECTS
        needs = needs if has_tools() else f"{needs} {guard.WITHOUT}"
        table = body.table(record.name if record else "")
        table = with_real_outputs(table) if real_outputs else table
        step = usual_experiment(body.tolerance, motion).step
        pages = documentation.pages(body, table, needs, step) | legal_files(needs, "pythonfmu")
        extra = {"model.png": pages["documentation/model.png"]} | pages
        extra["resources/requirements.txt"] = REQUIRED.encode()
        if reference:
            extra |= reference_files(body, motion)
        repack(built, output, extra, plain_names)
    return output


def _carry_package(package: ModuleType, files: dict[str, bytes], renamed: dict[str, str], kernels: str = "") -> str:
    """Add the files of a package to `files`, under a name with a hash of its content, and return the name.

    `renamed` has the package names to replace in its imports. `kernels` is the group of kernels with machine code, also
    a part of the name: FMUs with other groups have their own copy, in one process too.
    """
    source = Path(package.__path__[0])
    texts = {}
    for file in sorted(source.rglob("*.py")):
        path = file.relative_to(source.parent)
        if LEFT_AT_HOME.intersection(map(Path.as_posix, (path, *path.parents))):
            continue
        text = file.read_text(encoding="utf-8")
        for old, new in renamed.items():
            text = re.sub(rf"^(\s*)from {old}(?=[. ])", rf"\1from {new}", text, flags=re.MULTILINE)
        texts[file.relative_to(source).as_posix()] = text
    if SOURCES_FILE in texts:  # the FMU has no sources of the kernels on disk to hash at a start
        texts[SOURCES_FILE] = f'"""The identifier of the kernel sources."""\n\nSOURCES = "{SOURCES}"\n'
    content = "\0".join(f"{path}\0{texts[path]}" for path in sorted(texts))
    name = "_".join(filter(None, (source.name, kernels, hashlib.sha256(content.encode()).hexdigest()[:16])))
    files |= {f"{name}/{path}": text.encode() for path, text in texts.items()}
    return name


def repack(source: Path, target: Path, extra: dict[str, bytes], plain_names: bool = False) -> None:
    """Write the archive with the guard and the files of `extra`, compressed, in a fixed order and with a fixed date."""
    with zipfile.ZipFile(source) as old:
        files = {name: old.read(name) for name in old.namelist()}
    files = guard.guarded(files) | extra
    write_archive(target, without_brackets(files) if plain_names else files)


def without_brackets(files: dict[str, bytes]) -> dict[str, bytes]:
    """Return the files of an FMU with variables named block1.ux instead of block[1].ux.

    Only files that tools and people read contain these names.
    """
    named = ["modelDescription.xml", "terminalsAndIcons/terminalsAndIcons.xml", "documentation/index.html"]
    named += [name for name in files if name.startswith(RUN_FOLDER)]
    found = {name: re.sub(rb"\b([a-z]+)\[(\d+)\]", rb"\1\2", files[name]) for name in named if name in files}
    return files | found


def write_archive(target: Path, content: dict[str, bytes]) -> None:
    """Write an archive, completely or not at all."""
    with whole_file(target) as partial, zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as new:
        for name in sorted(content):
            entry = zipfile.ZipInfo(name, ZIP_DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            new.writestr(entry, content[name])


if __name__ == "__main__":
    raise SystemExit(main())
