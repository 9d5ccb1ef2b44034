"""Pages in HTML from templates, with the style and the parts that all reports share."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined

from .inputs import SOFTWARE


def rendered(template: Traversable, **values: Any) -> str:
    """Return the text of a template of a page; it may include those of this folder.

    Beside `values` it is given `style` and `versions`. origin.html needs `inputs`, with hashes, and `fingerprint`.
    """
    folder = files(__package__)
    environment = Environment(
        loader=FunctionLoader(lambda name: (folder / name).read_text(encoding="utf-8")),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page = environment.from_string(template.read_text(encoding="utf-8"))
    style = (folder / "check.css").read_text(encoding="utf-8")
    return page.render(style=style, versions=SOFTWARE, **values)
