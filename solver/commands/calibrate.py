"""The command `calibrate`: modulus, damping and rim from known properties of a column, and what follows from them."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from ..common.digits import percent
from ..common.errors import InputError, SolverError, check_number, reading
from ..common.files import check_outputs, whole_file
from ..models.column.block import no_rim
from ..models.column.model import Column
from ..models.column.modes import modes_about_rest
from ..models.column.rest import check_rest
from ..statics.calibrate import (
    SPREAD,
    FreeVibration,
    ModulusFit,
    column_damping_on_edge,
    damping_from_ratio,
    damping_from_restitution,
    fit_moduli,
    free_vibration,
    modulus_from_elasticity,
    read_history,
    rim_from_restitution,
    with_joints,
    with_rim,
)
from ..statics.rocking import RELEASE, housner_restitution, restitution
from .command_files import add_force, check_suffix, read_column, refuse

HOUSNER = "housner"
AUTO = "auto"
RIMS = (1e-6, 100.0), "a width in m, from 1e-6 to 100"
_OF_RECORDS = ("channel", "begin", "end")


def add_calibrate_command(commands: argparse._SubParsersAction[Any]) -> None:
    """Add the command `calibrate`."""
    parser = commands.add_parser(
        "calibrate", help="modulus, damping and rim of the joints from elasticity, frequencies, decay, restitution"
    )
    parser.set_defaults(command=_calibrate)
    parser.add_argument("column", type=Path, metavar="COLUMN.toml", help="its values stay if nothing is asked for")
    modulus = parser.add_argument_group("modulus, one of").add_mutually_exclusive_group()
    modulus.add_argument("--young", type=float, metavar="PA", help="modulus of elasticity of the blocks, Pa")
    modulus.add_argument(
        "--frequencies", type=float, nargs="+", metavar="HZ", help="measured, first, second ... sway; nan: not measured"
    )
    parser.add_argument("--joint-thickness", type=float, metavar="M", help="of mortar or lead in joints, with --young")
    parser.add_argument("--joint-young", type=float, metavar="PA", help="modulus of what is in the joints")
    # damping and rim
    damping = parser.add_argument_group("damping, one of").add_mutually_exclusive_group()
    damping.add_argument("--restitution", metavar="R", help=f"after over before an impact; {HOUSNER}: by the geometry")
    damping.add_argument("--damping-ratio", type=float, metavar="R", help="of critical, in the first mode that sways")
    damping.add_argument("--critical", action="store_true", help="critical as what rocks stands on its edge")
    damping.add_argument("--free-vibration", type=Path, metavar="FILE.csv", help="times and values of a decay")
    parser.add_argument(
        "--rim", metavar="M", help=f"width in which the faces touch, m; {AUTO}: the one that has --restitution"
    )
    parser.add_argument(
        "--release", type=float, default=RELEASE, metavar="PART", help=f"of the way to the edge (default: {RELEASE:g})"
    )
    parser.add_argument("--channel", metavar="NAME", help="column of --free-vibration (default: the second)")
    parser.add_argument("--begin", type=float, metavar="S", help="of the decay in --free-vibration, s")
    parser.add_argument("--end", type=float, metavar="S", help="of the decay, s")
    # output
    parser.add_argument("--json", action="store_true", help="print all that was found as JSON")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.json", help="write that to a file")
    add_force(parser)


def _calibrate(options: argparse.Namespace) -> None:
    for keys, needed in ((("joint_thickness", "joint_young"), "young"), (_OF_RECORDS, "free_vibration")):
        if getattr(options, needed) is None:
            refuse(options, keys, f"must be left out, or --{needed.replace('_', '-')} given")
    # input: column, rim and record of a decay
    given_rim = _given_rim(options)
    check_suffix(options.output, ".json")
    check_outputs((options.output,), (options.column, options.free_vibration), options.force)
    column = read_column(options.column)
    if given_rim is not None:
        with reading(options.column):
            column = with_rim(column, given_rim)
    decay = None if options.free_vibration is None else _decay_of_record(options)
    # moduli
    fit: ModulusFit | None = None
    if options.young is not None:
        thickness = options.joint_thickness or 0.0
        column = with_joints(column, modulus_from_elasticity(column, options.young, thickness, options.joint_young))
    elif options.frequencies is not None:
        fit = fit_moduli(column, options.frequencies)
        column = with_joints(column, fit.moduli)
    # damping, and the rim where it is searched for
    why_rim = ""
    if options.restitution is not None:
        column, why_rim = _with_restitution(column, options)
    elif options.critical:
        column = with_joints(column, damping=column_damping_on_edge(column))
    elif options.damping_ratio is not None:
        column = with_joints(column, damping=damping_from_ratio(column, options.damping_ratio))
    elif decay is not None:
        column = with_joints(column, damping=damping_from_ratio(column, decay.ratio))
    with reading(options.column):
        check_rest(column)
    # output
    found = _found(column, options.release, decay, fit)
    text = json.dumps(found, indent=2, ensure_ascii=False)
    if options.json:
        print(text)
    else:
        print(f"{_decay(options, decay)}{why_rim}{_joints(column)}\n{_fit(fit)}{_meaning(found)}")
    if options.output is not None:
        with reading(options.output), whole_file(options.output) as partial:
            partial.write_text(text + "\n", encoding="utf-8")
        if not options.json:
            print(options.output)


def _given_rim(options: argparse.Namespace) -> float | None:
    """Return the rim (m) of --rim, or None if it is left out or searched for. Raises InputError."""
    width = None if options.rim is None else _number("--rim", options.rim, AUTO, "a width in m")
    if width is not None:
        return check_number("--rim", width, *RIMS)
    if options.rim is not None and options.restitution is None:
        raise InputError(f"--rim {options.rim}: must be a width in m, or --restitution given")
    return None


def _with_restitution(column: Column, options: argparse.Namespace) -> tuple[Column, str]:
    """Return the column that has the requested restitution, and the reason why a rim was searched for, as a line.

    Damping alone gives it if possible, unless --rim requests another rim.
    """
    wanted = _number("--restitution", options.restitution, HOUSNER, "a number between 0 and 1")
    why = ""
    if options.rim is None or options.rim.lower() != AUTO:
        try:
            return with_joints(column, damping=damping_from_restitution(column, wanted, options.release)), ""
        except InputError as refused:
            if options.rim is not None or any(no_rim(block) for block in column.blocks):
                raise
            why = f"damping alone does not have it: {refused.args[0].split(';')[0].split(': ', 1)[-1]}\n"
    fit = rim_from_restitution(column, wanted, options.release)
    return with_joints(with_rim(column, fit.rim), damping=fit.damping), why


def _number(option: str, text: str, word: str, meaning: str) -> float | None:
    """Return the number of an option; None if it has the word in its place. Raises InputError."""
    if text.lower() == word:
        return None
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{option} {text}: must be {word}, or {meaning}") from None


def _decay_of_record(options: argparse.Namespace) -> FreeVibration:
    begin = -math.inf if options.begin is None else options.begin
    end = math.inf if options.end is None else options.end
    time, values = read_history(options.free_vibration, options.channel, begin, end)
    with reading(options.free_vibration):
        return free_vibration(time, values)


def _decay(options: argparse.Namespace, decay: FreeVibration | None) -> str:
    if decay is None:
        return ""
    damping, explained = percent(decay.ratio, ".3f"), percent(decay.explained)
    swing = f"{decay.frequency:.5g} Hz, damping {damping}; a decaying swing explains {explained}"
    return f"{options.free_vibration}: {swing}\n"


def _fit(fit: ModulusFit | None) -> str:
    """Return a table of measured and fitted frequencies, and the standard error of the moduli."""
    if fit is None:
        return ""
    lines = ["mode  measured (Hz)    fit (Hz)  difference"]
    for mode, (measured, fitted, off) in enumerate(zip(fit.measured, fit.fitted, fit.difference, strict=True), start=1):
        known = not math.isnan(measured)
        of, by = (f"{measured:.5g}", f"{100.0 * off:+.2f} %") if known else ("-", "-")
        lines.append(f"{mode:4d}  {of:>13}  {fitted:10.5g}  {by:>10}")
    spreads = ", ".join(
        f"{part:.2g}" if known else "not determined" for part, known in zip(fit.spread, fit.determined, strict=True)
    )
    what = "of each modulus, the top joint first" if fit.each else "of the factor on all moduli"
    shown = spreads if fit.each else spreads.split(",")[0]
    lines.append(f"standard error {what}, for {percent(SPREAD)} in every frequency: {shown}")
    return "\n".join(lines) + "\n"


def _joints(column: Column) -> str:
    """Return the values in the form of a column file, once if all joints have the same."""
    joints = [block.joint for block in column.blocks]
    values = [(joint.stiffness, joint.damping, joint.rim) for joint in joints]
    if len(set(values)) == 1:
        values = values[:1]
    lines = []
    for i, (stiffness, damping, rim) in enumerate(values, start=1):
        lines.append("[joint]" if len(values) == 1 else f"[block.joint]              # of block {i}")
        lines += [f"stiffness = {stiffness:.6g}    # N/m3", f"damping = {damping:.6g}    # s"]
        lines += [f"rim = {rim:.6g}    # m"] if rim is not None else []
    return "\n".join(lines)


def _found(column: Column, release: float, decay: FreeVibration | None, fit: ModulusFit | None) -> dict[str, Any]:
    """Return all results in SI units; a restitution that cannot be computed is None, with the reason."""
    modes = modes_about_rest(column)
    first = int(np.argmax(modes.sways))
    found: dict[str, Any] = {
        "column": column.name,
        "joints": [
            {name: getattr(block.joint, name) for name in ("stiffness", "damping", "rim")} for block in column.blocks
        ],
        "frequency": float(modes.frequency[first]),
        "damping_ratio": float(modes.damping_ratio[first]),
        "release": release,
        "restitution": None,
        "housner_restitution": housner_restitution(column),
        "free_vibration": None,
        "frequencies": None,
    }
    # fitted frequencies, decay and restitution
    if fit is not None:
        found["frequencies"] = {
            "measured": [value if math.isfinite(value) else None for value in fit.measured.tolist()],
            "fitted": fit.fitted.tolist(),
            "stiffness_error": [
                value if known else None for value, known in zip(fit.spread, fit.determined, strict=True)
            ],
            "another_stiffness": None if fit.another is None else fit.another.tolist(),
        }
    if decay is not None:
        found["free_vibration"] = {name: getattr(decay, name) for name in ("frequency", "ratio", "explained")}
    try:
        found["restitution"] = restitution(column, release)
    except (InputError, SolverError) as failure:
        if isinstance(failure, InputError) and release != RELEASE:  # it was asked for
            raise
        found["no_restitution"] = str(failure)
    return found


def _meaning(found: dict[str, Any]) -> str:
    """Return the first mode and the restitution that follow from the values, as two lines."""
    first = (
        f"first mode {found['frequency']:.5g} Hz, damping {percent(found['damping_ratio'], '.3f')}, all joints closed"
    )
    result = f"not found: {found.get('no_restitution')}"
    if found["restitution"] is not None:
        result = f"{found['restitution']:.5f}, let go at {found['release']:g} of the way to the edge"
    return f"{first}\nrestitution {result}; Housner's rigid block {found['housner_restitution']:.5f}"
