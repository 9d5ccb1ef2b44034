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
    "sphinx.ext.napoleon",
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
napoleon_google_docstring = False
napoleon_use_param = napoleon_use_rtype = False  # types of arguments are prose: shapes, alternatives
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
    """Read the sections of numpydoc, which napoleon would look for in descriptions of attributes too."""
    if what in ("class", "function", "method"):
        lines[:] = NumpyDocstring(lines, Config(napoleon_use_rtype=False), app, what, name, obj, options).lines()


def setup(app):
    """What this project adds to Sphinx."""
    app.connect("source-read", tables.fill_in)
    app.connect("autodoc-process-docstring", _with_sections)
    app.connect("autodoc-process-docstring", tables.as_restructured_text)
    app.connect("builder-inited", tables.copy_notebooks)
