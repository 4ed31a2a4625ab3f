"""Sphinx settings: built without network (no intersphinx, no remote fonts or scripts), strict, notebooks executed."""

import os
import re

os.environ.setdefault("OMP_NUM_THREADS", "1")

project = "knitbench"
author = "the knitbench authors"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = "knitbench"
html_show_copyright = False
html_static_path = ["_static"]
html_css_files = ["pages.css"]

myst_enable_extensions = ["deflist"]
myst_heading_anchors = 3

nb_execution_mode = os.environ.get("KNITBENCH_NOTEBOOKS", "cache")
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_mime_priority_overrides = [("html", "text/html", 0)]

autodoc_typehints = "none"  # they are in the docstrings, with shapes and units
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
napoleon_custom_sections = [("Class attributes", "params_style")]
default_role = "literal"


def catalogue_table(_app, docname, source):
    """Put the table of all effects into effects.md: a new effect is one class and one line, and no word here."""
    if docname == "effects":
        from testbench.knit.card import catalogue_markdown
        from testbench.knit.catalogue import load_catalogue

        source[0] = source[0].replace("<!-- table of the catalogue -->", catalogue_markdown(load_catalogue()))


SEVERAL = re.compile(r"^(\w+(?:, \w+)+)( : .*(?:\n    .*)*)", re.MULTILINE)


def one_by_one(_app, _what, _name, _object, _options, lines):
    """Attributes told together, as ``low, high : float``, are shown one by one: napoleon takes them for one."""
    apart = SEVERAL.sub(lambda found: "\n".join(name + found[2] for name in found[1].split(", ")), "\n".join(lines))
    lines[:] = apart.split("\n")


def setup(app):
    app.connect("autodoc-process-docstring", one_by_one, priority=400)  # before napoleon, at 500
    app.connect("source-read", catalogue_table)
    app.connect("env-get-outdated", lambda *_: ["effects"])
