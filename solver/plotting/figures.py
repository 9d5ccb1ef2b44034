"""A figure that a notebook shows as it is, without a backend of pyplot."""

from __future__ import annotations

import io

from matplotlib.figure import Figure as Plain

SHOWN_DPI = 72


class Figure(Plain):
    """matplotlib's figure, which IPython asks for a PNG."""

    def _repr_png_(self) -> bytes:
        png = io.BytesIO()
        self.savefig(png, format="png", dpi=SHOWN_DPI)
        return png.getvalue()
