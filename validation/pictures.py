"""Pictures of the cases: one style, and under each what was fitted."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.figure import Figure

INK, BLUE, RED, GREEN, GREY = "#3b3a38", "#0072b2", "#d55e00", "#2e7d4f", "#8c8c8c"
DPI = 110


def panels(columns: int, rows: int = 1, width: float = 4.2, height: float = 3.5) -> tuple[Figure, Any]:
    """Return a figure and its axes, an array (rows, columns). Sizes in inches."""
    figure, axes = plt.subplots(
        rows, columns, figsize=(width * columns, height * rows + 0.45), squeeze=False, layout="constrained"
    )
    return figure, axes


def label(axis: Any, x: str, y: str, title: str = "") -> None:
    """Add axis labels, a title, a light grid."""
    axis.set_xlabel(x)
    axis.set_ylabel(y)
    axis.set_title(title, fontsize=10)
    axis.grid(True, color="0.92", zorder=0)


def save(figure: Figure, path: Path, note: str) -> None:
    """Write the figure with a note under it, and close it."""
    characters = int(13 * figure.get_figwidth())
    figure.supxlabel("\n".join(textwrap.wrap(note, characters)), fontsize=8, color=INK)
    figure.savefig(path, dpi=DPI, metadata={"Software": None})
    plt.close(figure)
