"""Configuration of the documentation: make docs, or SKANCF_DEMO_SIZE=small make docs for short runs of the gallery."""

import os
import re
import sys
import textwrap
import warnings
from importlib import resources
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
    "sphinx_copybutton",
    "sphinx_design",
    # Reads CHANGELOG.md.
    "myst_parser",
]
exclude_patterns = ["_build", "measure", "_templates", "sg_execution_times.rst"]
templates_path = ["_templates"]
source_suffix = {".rst": "restructuredtext"}
# Words that tell a type, as x in "function of x", are taken for references, and some find two targets.
suppress_warnings = ["ref.python"]

html_theme = "pydata_sphinx_theme"
html_context = {"default_mode": "auto"}
html_title = f"skancf {release}"
html_logo = "_static/logo.svg"
html_favicon = "_static/logo.svg"
# MathJax with all its extensions and drawn letters is one file, so that a page asks no other machine for anything.
html_static_path = ["_static", str(resources.files("sphinx-mathjax-offline") / "static/mathjax/tex-svg-full.js")]
mathjax_path = "tex-svg-full.js"
html_search_scorer = str(HERE / "_static" / "scorer.js")
html_css_files = ["site.css"]
html_js_files = ["wide_formulas.js"]
html_theme_options = {
    "logo": {"text": "skancf", "alt_text": "skancf, first page"},
    "navbar_align": "left",
    "header_links_before_dropdown": 6,
    "navbar_persistent": ["search-button-field"],
    "show_nav_level": 1,
    "navigation_depth": 2,
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "back_to_top_button": False,
    "footer_start": ["project-footer"],
    "footer_end": [],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
    "search_bar_text": "Search: hole, gmsh, pandas ...",
}
# These pages have no siblings to list beside them.
html_sidebars = {"index": [], "gallery/index": [], "search": []}
html_show_sourcelink = False
html_copy_source = False
copybutton_exclude = ".linenos, .gp, .go"
copybutton_prompt_text = r"\$ |>>> |\.\.\. "
copybutton_prompt_is_regexp = True

autosummary_generate = True
autosummary_imported_members = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"show-inheritance": False}
# Longer signatures have a line for each parameter.
python_maximum_signature_line_length = 72
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
    # That page would load its sortable table from other machines.
    "write_computation_times": False,
}


def keep_units(app: object, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """A line that is only a unit, such as "m.", would be read as the start of a numbered list."""
    lines[:] = [re.sub(r"^(\s*)([A-Za-z]\.)$", r"\1\\\2", line) for line in lines]


def tidy_example(app: object, docname: str, source: list[str]) -> None:
    """Pages of examples: code below the heading "Pictures" only draws and is folded up; charts scroll on a phone."""
    if not docname.startswith("gallery/plot_"):
        return
    text = re.sub(
        r"(\nPictures\n-+\n(?:(?!\.\. code-block)[^\n]*\n)*?)\.\. code-block:: Python\n((?:(?: {4}[^\n]*)?\n)+)",
        lambda found: (
            f"{found[1]}.. dropdown:: Code that draws\n\n    .. code-block:: Python\n{textwrap.indent(found[2], '    ')}"
        ),
        source[0],
    )
    title = re.search(r"\n([^\n]+)\n=+\n", text)[1]
    text = re.sub(r":alt: plot [^\n]*", lambda _: f":alt: Charts of the example: {title}", text)
    source[0] = re.sub(
        r"\n\.\. image-sg::[^\n]*\n(?: {3}:[^\n]*\n)+",
        lambda found: f"\n.. container:: wide-chart\n{textwrap.indent(found[0], '    ')}",
        text,
    )


def setup(app: object) -> None:
    # Before napoleon, which moves such lines behind the name of a parameter.
    app.connect("autodoc-process-docstring", keep_units, priority=100)
    app.connect("source-read", tidy_example)
