"""A figure that a notebook shows without a pyplot backend."""

from __future__ import annotations

import io

from matplotlib.figure import Figure as Plain

SHOWN_DPI = 72


class Figure(Plain):
    """A matplotlib figure with the PNG representation that IPython asks for."""

    def _repr_png_(self) -> bytes:
        png = io.BytesIO()
        self.savefig(png, format="png", dpi=SHOWN_DPI)
        return png.getvalue()
