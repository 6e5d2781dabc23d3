"""Configuration of the documentation: make docs, or SKANCF_DEMO_SIZE=small make docs for short runs of the gallery."""

import os
import re
import sys
import warnings
from pathlib import Path

import matplotlib

matplotlib.use("agg")

from skancf import __version__

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from benchmarks import page  # noqa: E402

# Made of what the benchmarks have stored, never typed.
page.main(HERE / "results")
os.environ.setdefault("SKANCF_DEMO_SIZE", "full")
os.environ.setdefault("SKANCF_DEMO_OUT", str(HERE / "_build" / "demo_out"))
warnings.filterwarnings("ignore", message=".*FigureCanvasAgg is non-interactive.*")

project = "skancf"
author = "the authors of skancf"
release = version = __version__
language = "en"

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "measure", "_templates"]
templates_path = ["_templates"]
html_theme = "alabaster"
html_static_path = ["_static"]
html_theme_options = {
    "description": "Plates and shells that move and bend a lot",
    "page_width": "1120px",
    "sidebar_width": "230px",
    "fixed_sidebar": True,
    "show_relbars": True,
}
html_css_files = ["tables.css"]
html_show_copyright = False

autosummary_generate = True
autosummary_imported_members = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"show-inheritance": False}
# Fields of data classes are described where the class lists them; once is enough.
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

sphinx_gallery_conf = {
    "examples_dirs": str(HERE.parent / "demos"),
    "gallery_dirs": "gallery",
    "filename_pattern": r"[\\/]plot_",
    "within_subsection_order": "FileNameSortKey",
    "show_memory": False,
    "remove_config_comments": True,
    "download_all_examples": False,
    "plot_gallery": True,
    "abort_on_example_error": True,
    "min_reported_time": 1,
}


def keep_units(app: object, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """A line that is only a unit, such as "m.", would be read as the start of a numbered list."""
    lines[:] = [re.sub(r"^(\s*)([A-Za-z]\.)$", r"\1\\\2", line) for line in lines]


def setup(app: object) -> None:
    # Before napoleon, which moves such lines behind the name of a parameter.
    app.connect("autodoc-process-docstring", keep_units, priority=100)
