"""Equations of the site as MathML, which browsers show without a script: nothing is fetched, nothing to install."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging

AS_CONVERTED = (  # what the conversion does not know, or sets otherwise than TeX, and how it is written for it
    (re.compile(r"\{aligned\}"), "{align*}"),
    (re.compile("'+"), lambda found: "^{" + r"\prime" * len(found[0]) + "}"),
    (re.compile(r"(?<=[\w})])\s*(?=\\(?:arcsin|sin|cos)\b)"), r"\\, "),
    (re.compile(r"(\\(?:sin|cos)(?:\^\w)?)\s*(?=[\\\w])"), r"\1\\, "),
)
WRONG = re.compile(r"[\\&]")  # is left where a command or an environment is not known
_logger = logging.getLogger(__name__)


def mathml(latex: str, block: bool) -> str:
    """An equation; a warning names what could not be converted."""
    written = latex
    for what, other in AS_CONVERTED:
        written = what.sub(other, written)
    made: str = convert(written, display="block" if block else "inline")
    lost = "%" in latex or made.count("&#x02032;") != latex.count("'")
    if lost or WRONG.search(re.sub(r"<[^>]*>|&#x\w+;|&lt;|&gt;", "", made)):
        _logger.warning("equation that is not converted whole: %s", latex)
    return made


def _visit(translator: Any, node: nodes.Element) -> None:
    block = isinstance(node, nodes.math_block)
    made = mathml(node.astext(), block)
    translator.body.append(f'<div class="math">{made}</div>' if block else made)
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """What this adds to Sphinx."""
    app.add_html_math_renderer("mathml", inline_renderers=(_visit, None), block_renderers=(_visit, None))
