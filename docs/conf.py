"""The site: `python -m sphinx -W -n docs site`. Pages are Markdown; tables.py fills in what the code knows."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import tables
from sphinx.ext.napoleon import Config, NumpyDocstring

import multiblock

project = "multiblock-fmu"
author = "the authors of multiblock-fmu"
release = version = multiblock.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx_argparse_cli",
    "sphinxcontrib.mermaid",
    "sphinx_copybutton",
    "equations",
]
exclude_patterns = ["images", "notes", "**/.ipynb_checkpoints"]  # notes are read in the repository
nitpicky = True
nitpick_ignore = [("py:class", "optional")]  # of parameters
smartquotes = False  # primes stay primes

myst_heading_anchors = 4
myst_enable_extensions = ["deflist", "dollarmath"]
myst_fence_as_directive = ["mermaid", "math"]
html_math_renderer = "mathml"
nb_execution_mode = "off"  # notebooks are kept with their results, which a test makes again

autodoc_default_options = {"members": True, "member-order": "bysource"}
autodoc_typehints = "none"  # docstrings say units and shapes, which types do not
autodoc_class_signature = "mixed"
add_module_names = False
default_role = "code"

html_theme = "furo"
html_title = f"multiblock-fmu {release}"
html_theme_options = {"navigation_with_keys": True}
html_copy_source = False
html_static_path = ["style"]
html_css_files = ["site.css"]
html_show_copyright = False


def _with_sections(app, what, name, obj, options, lines):
    """Make restructured text of a docstring: of its plain text, then of its numpydoc sections."""
    first = next((k for k in range(len(lines) - 1) if lines[k + 1] and not lines[k + 1].strip("-")), len(lines))
    text, sections = lines[:first], [line.replace("|", r"\|") for line in lines[first:]]
    tables.as_restructured_text(app, what, name, obj, options, text)
    if sections:
        # types of arguments and attributes are prose
        as_list = [("Attributes", "params_style")]
        config = Config(napoleon_use_param=False, napoleon_use_rtype=False, napoleon_custom_sections=as_list)
        sections = NumpyDocstring(sections, config, app, what, name, obj, options).lines()
    lines[:] = [*text, "", *sections, ""]


def setup(app):
    """What this project adds to Sphinx."""
    app.connect("source-read", tables.fill_in)
    app.connect("autodoc-process-docstring", _with_sections)
    app.connect("builder-inited", tables.copy_notebooks)
