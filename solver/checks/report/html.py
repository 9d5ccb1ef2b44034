"""The report of a check: one HTML file without outside links, for screen and print."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import fields
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from ...common.digits import three_digits
from ...common.files import whole_file
from ...plotting.scene.page import frame_of
from ..action import motion_rows
from ..by_hand import NOT_IN_SPACE
from ..check import Check
from ..friction import Envelope
from ..limits import TOLERANCE
from ..subject import JointProperties
from ..variants import brief_rows, compared, differences, directions
from .inputs import MATERIAL_SHEET, hashed, sources_of, with_meshes
from .model import ModelSection, Sheet, merged, shown_of
from .pictures import embedded, friction_picture, spectra_picture
from .rendering import rendered

LIMITS_OF_THE_MODEL = (  # for all models
    "The blocks are rigid. Their elasticity is in the modulus of the joints.",
    "Edges do not crush or spall. A pressure above the strength makes it weaker than computed.",
)


def write_report(
    checks: Sequence[Check],
    path: str | os.PathLike[str],
    command: str = "",
    notes: Sequence[str] = (),
    inputs: Sequence[Path] = (),
    risk: Sequence[str] = (),
    envelope: Envelope | None = None,
) -> None:
    """Write the report of a check, the first of `checks`, compared with the others as variants. Raises OSError.

    It prints the `command` that makes it again, `notes` under the title, such as project, author and date, and lines on
    the `risk`. `inputs` are the input files, those of the models of the check and its variants first. In an `envelope`
    over a range of friction the governing check is the first of `checks`.
    """
    content = _content(checks, inputs, envelope)
    text = rendered(files(__package__) / "check.html", command=command, notes=notes, risk=risk, **content)
    with whole_file(path) as partial:
        Path(partial).write_text(text, encoding="utf-8")


def _content(checks: Sequence[Check], inputs: Sequence[Path], envelope: Envelope | None) -> dict[str, Any]:
    """Return the values that the template names; with an envelope all checks are of one model."""
    # tables and pictures of the governing run, then texts for the template
    check = checks[0]
    run = check.responses[check.governing]
    shown = _shown(check, inputs)
    variants = [] if envelope else [one for one in checks[1:] if not one.both]
    at = min(run.overturn_time, float(run.time[-1])) if run.overturned else None  # else at its largest displacement
    return {
        "check": check,
        "word": check.subject.model.kind.word,
        "checks": checks,
        "passes": check.passes and all(one.passes for one in checks if one.both),
        "models": [(check, shown), *((one, _shown(one, inputs[k:])) for k, one in enumerate(variants, start=1))],
        "inputs": hashed(with_meshes(inputs)),
        "directions": [(one, _motions(one), embedded(spectra_picture(one))) for one in directions(checks)],
        "limits": [
            (item.name, getattr(check.plan.limits, item.name), item.metadata["meaning"])
            for item in fields(check.plan.limits)
            if item.name not in (("displacement",) if math.isnan(check.subject.edge) else ("overlap", "hits"))
        ],
        "compared": compared(checks),
        "differences": differences(checks),
        "left_out": (
            *check.subject.of_model,
            _of_joints(check),
            *never_slide(check.subject.joints),
            *LIMITS_OF_THE_MODEL,
        ),
        "not_by_hand": NOT_IN_SPACE,
        "tolerance": TOLERANCE,
        "briefs": brief_rows(checks),
        "envelope": envelope,
        "friction_picture": embedded(friction_picture(envelope)) if envelope else "",
        "embedded": embedded,
        "pictures": {
            "histories": embedded(shown.histories),
            "deformed": embedded(run.plot_model(at=at), check.subject.model.kind.across),
        },
        "scene": Markup(frame_of(run)),
        "worst": check.action.motions[check.governing],
        "fingerprint": check.fingerprint,
    }


def _shown(check: Check, inputs: Sequence[Path]) -> ModelSection:
    """Return the tables and pictures of a model, whose file, if there is one, is the first of `inputs`."""
    shown = shown_of(check.subject.model, check, check.responses[check.governing])
    if inputs:
        shown.sheets.append(Sheet(MATERIAL_SHEET, merged(sources_of(inputs[0])), len(MATERIAL_SHEET)))
    return shown


def _of_joints(check: Check) -> str:
    """Return the sentence on the tension, cohesion and pressure that the joints bear."""
    bonds, joints = len(check.subject.bonds), len(check.subject.joints.names)
    dry = "pressure only; they open, and close with the damping given."
    if not bonds:
        return f"The joints bear {dry}"
    which = "The joints bear" if bonds == joints else f"{bonds} of {joints} joints bear"
    return f"{which} tension and cohesion until their mortar breaks, for good; broken or dry joints bear {dry}"


def never_slide(joints: JointProperties) -> tuple[str, ...]:
    """Return a sentence on the joints without friction; empty if all joints have friction."""
    missing, count = int(np.sum(np.isnan(joints.friction))), len(joints.names)
    if not missing:
        return ()
    some = f"{missing} of {count} joints {'has' if missing == 1 else 'have'} no friction"
    which = "No joint has friction" if missing == count else some
    return (f"{which}: such a joint never slides. The friction that this takes is in the table.",)


def _motions(check: Check) -> Sheet:
    """Return the table of the motions, with the verdict and the displacement under each."""
    (name, *headings), *rows = motion_rows(check.action)
    found: list[tuple[str, ...]] = []
    for (motion, *numbers), run, moved in zip(rows, check.responses, check.displacement.values, strict=True):
        fell = f", {run.what_fell} at {three_digits(run.overturn_time)} s" if run.overturned else ""
        found.append((motion, f"{run.verdict}{fell}", *numbers, "" if run.overturned else three_digits(1e3 * moved)))
    return Sheet((name, f"the {check.subject.model.kind.word} itself", *headings, "displacement (mm)"), found)
