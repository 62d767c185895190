"""A result as HTML that needs nothing else: a page with pictures that zoom, input and versions; or for a notebook."""

import base64
import io
import platform
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from adaptive_ff import __version__
from adaptive_ff.comparison.comparison import Comparison
from adaptive_ff.report.comparison_pictures import plot_comparison
from adaptive_ff.report.table import Table
from adaptive_ff.report.tables import comparison_tables

NAME = "report.html"  # of the file in the folder of the results
LIBRARIES = ("numpy", "scipy", "matplotlib")  # beside this package and Python: what the figures depend on


@cache
def _template() -> Any:
    from jinja2 import Environment, PackageLoader  # here, not above: few commands write a page

    return Environment(loader=PackageLoader("adaptive_ff.report", ""), autoescape=True).get_template("page.html")


def write_report(
    path: Path,
    title: str,
    shown: Iterable[Table | str],
    figures: Mapping[str, Figure],
    details: Mapping[str, str] | None = None,
) -> None:
    """Write the page: tables and sentences in their order, pictures by name, longer texts by heading."""
    versions = [f"adaptive-ff {__version__}", f"Python {platform.python_version()}"]
    versions += [f"{name} {version(name)}" for name in LIBRARIES]
    text = _template().render(
        title=title,
        shown=list(shown),
        pictures={name: _encoded(figure, "svg", metadata={"Date": None}) for name, figure in figures.items()},
        details=details or {},
        versions=f"{', '.join(versions)}; {platform.system()} {platform.machine()}",
    )
    path.write_text(text + "\n", encoding="utf-8")


def comparison_html(comparison: Comparison) -> str:
    """Return tables and the picture of tracking for a notebook."""
    tables = "".join(one.html() for one in comparison_tables(comparison))
    data = _encoded(plot_comparison(comparison)["tracking"], "png", dpi=100)
    return f'<div>{tables}<img alt="tracking of all controllers" src="data:image/png;base64,{data}"></div>'


def _encoded(figure: Figure, form: str, **options: Any) -> str:
    stream = io.BytesIO()
    figure.savefig(stream, format=form, **options)
    return base64.b64encode(stream.getvalue()).decode("ascii")
