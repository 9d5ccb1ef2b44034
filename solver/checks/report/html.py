"""The report of a check: one HTML file without outside links, for the screen and for paper."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from dataclasses import fields
from importlib.resources import files
from pathlib import Path
from typing import Any

import numba
import numpy as np
from jinja2 import Environment, StrictUndefined

from ... import __version__
from ...column.block import Block
from ...column.column import Column
from ...common.files import whole_file
from ...ground.intensity import pgv
from ...ground.motion import STANDARD_GRAVITY
from ..check import Check
from ..margin import TOLERANCE
from ..table import three_digits
from .pictures import column_picture, deformed_picture, embedded, histories_picture, spectra_picture

LIMITS_OF_THE_MODEL = (
    "The column moves in one vertical plane. It does not twist, and no motion across the plane is applied.",
    "The blocks are rigid. Their elasticity is in the modulus of the joints.",
    "The joints bear pressure only; they open, and close with the damping given.",
    "A joint without friction never slides. The friction that this takes is in the table.",
    "Edges do not crush or spall. A pressure above the strength makes the column weaker than computed.",
    "Once a column has fallen it is held; what it hits is not considered.",
)


def write_report(checks: Sequence[Check], path: str | os.PathLike[str], command: str = "") -> None:
    """Write the report of a check, with the others as variants beside it. Raises OSError."""
    folder = files(__package__)
    page = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True).from_string(
        (folder / "check.html").read_text(encoding="utf-8")
    )
    text = page.render(style=(folder / "check.css").read_text(encoding="utf-8"), command=command, **_content(checks))
    with whole_file(path) as partial:
        Path(partial).write_text(text, encoding="utf-8")


def _content(checks: Sequence[Check]) -> dict[str, Any]:
    """Everything that the template names."""
    check = checks[0]
    worst = check.action.motions[check.governing]
    response = check.responses[check.governing]
    return {
        "check": check,
        "column": check.column,
        "checks": checks,
        "blocks": blocks_of(check.column),
        "motions": _motions(check),
        "limits": [
            (item.name, getattr(check.plan.limits, item.name), item.metadata["meaning"])
            for item in fields(check.plan.limits)
        ],
        "model": LIMITS_OF_THE_MODEL,
        "tolerance": TOLERANCE,
        "names": list(dict.fromkeys(row.name for one in checks for row in one.rows)),
        "pictures": {
            "column": embedded(column_picture(check.column)),
            "spectra": embedded(spectra_picture(check)),
            "histories": embedded(histories_picture(response, f"{check.column.name} under {worst.name}")),
            "deformed": embedded(deformed_picture(response)),
        },
        "worst": worst,
        "versions": {
            "multiblock-fmu": __version__,
            "Python": platform.python_version(),
            "numpy": np.__version__,
            "numba": numba.__version__,
        },
    }


def _motions(check: Check) -> list[dict[str, str]]:
    found = []
    for scaled, response in zip(check.action.motions, check.responses, strict=True):
        vertical = float(np.max(np.abs(scaled.motion.az)))
        found.append(
            {
                "name": scaled.name,
                "factor": f"{scaled.factor:.3g}",
                "vertical": f"{scaled.vertical_factor:.3g}" if vertical else "none",
                "pga": f"{scaled.motion.pga / STANDARD_GRAVITY:.3g}",
                "pgv": f"{pgv(scaled.motion):.3g}",
                "top": "" if response.overturned else three_digits(1e3 * response.peak_ux[0]),
                "verdict": response.verdict,
            }
        )
    return found


def blocks_of(column: Column) -> list[dict[str, str]]:
    """The blocks from the top down with their joints, equal neighbours in one row."""
    rows: list[dict[str, str]] = []
    for number, block in enumerate(column.blocks, start=1):
        row = _block(block)
        if rows and {key: value for key, value in rows[-1].items() if key != "numbers"} == row:
            rows[-1]["numbers"] = f"{rows[-1]['numbers'].partition(' ')[0]} to {number}"
        else:
            rows.append({"numbers": str(number), **row})
    return rows


def _block(block: Block) -> dict[str, str]:
    joint = block.joint

    def size(bottom: float, top: float | None) -> str:
        return f"{bottom:.4g}" if top is None or top == bottom else f"{bottom:.4g}, top {top:.4g}"

    return {
        "section": block.section,
        "height": f"{block.height:.4g}",
        "width": size(block.width, block.top_width),
        "depth": size(block.depth, block.top_depth),
        "mass": f"{block.mass:.5g}",
        "contact": f"{joint.section or block.section} {block.joint_width:.4g}",
        "stiffness": f"{1e-9 * joint.stiffness:.4g}",
        "damping": f"{joint.damping:.3g}",
        "friction": "none" if joint.friction is None else f"{joint.friction:.3g}",
        "strength": "none" if joint.strength is None else f"{1e-6 * joint.strength:.4g}",
    }
