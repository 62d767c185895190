"""Settings of Sphinx; ``python -m docs`` builds the site."""

import shutil
import sys
from pathlib import Path

from sphinx_gallery.scrapers import figure_rst

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
sys.path.insert(0, str(ROOT))

from adaptive_ff import __version__  # noqa: E402
from adaptive_ff.playground.page import write_page  # noqa: E402
from docs.reference import GENERATED, write_examples, write_reference  # noqa: E402


def written_picture(_, variables, settings):  # type: ignore[no-untyped-def]
    """Show a picture that an example has written, that of tracking where there is one; it is the thumbnail, too."""
    source = Path(variables["src_file"])
    written = (source.parent / "results" / source.stem).glob("*.png")
    found = sorted(written, key=lambda file: (file.stem != "tracking", file.name))[:1]
    copies = [shutil.copy(file, place) for file, place in zip(found, variables["image_path_iterator"], strict=False)]
    return figure_rst(copies, settings["src_dir"])


EXAMPLES, PLAYGROUND = HERE / GENERATED / "examples", HERE / GENERATED / "playground"

project, author, version = "adaptive-ff", "The adaptive-ff developers", __version__
copyright = f"2026, {author}. BSD-3-Clause"
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = [
    "_build",
    "**/sg_execution_times.rst",
    "sg_execution_times.rst",
    f"{GENERATED}/examples",
    f"{GENERATED}/playground",
    *(f"{GENERATED}/gallery/*.{ending}" for ending in ("ipynb", "py", "json", "zip")),
    # are included
    *(f"{GENERATED}/{name}.md" for name in ("command_line", "controllers", "scenario", "log_formats", "warnings")),
]
html_theme = "pydata_sphinx_theme"
html_theme_options = {
    "navigation_depth": 1,
    "show_prev_next": False,
    "navigation_with_keys": False,
    "header_links_before_dropdown": 7,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
html_title = "adaptive-ff"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_extra_path = [str(PLAYGROUND)]
html_show_sourcelink = False
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "force"  # pages show what the code of today prints
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 600
nb_merge_streams = True
napoleon_google_docstring = False
napoleon_use_rtype = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autosummary_generate = True
suppress_warnings = ["config.cache", "myst-nb.lexer"]  # of cells that are not run
sphinx_gallery_conf = {
    "examples_dirs": str(EXAMPLES),
    "gallery_dirs": "_generated/gallery",
    "filename_pattern": r"/(first_comparison|design_a_loop|own_controller|in_your_own_loop|identify_a_log)\.py",
    "image_scrapers": (written_picture,),
    "capture_repr": (),
    "run_stale_examples": True,
    "download_all_examples": False,
    "show_memory": False,
    "min_reported_time": 1e9,
}
write_reference(HERE / GENERATED)
write_examples(ROOT / "examples", EXAMPLES)
PLAYGROUND.mkdir(parents=True, exist_ok=True)
write_page(PLAYGROUND / "playground.html")
