"""A result as one HTML file that needs nothing else: tables, pictures that zoom, scenario, versions."""

import base64
import io
import platform
from collections.abc import Iterable, Mapping
from html import escape
from importlib.metadata import version
from pathlib import Path

from matplotlib.figure import Figure
from rich.table import Table

from adaptive_ff import __version__
from adaptive_ff.report.notebook import table_html

NAME = "report.html"
"""Of the file in the folder of the results."""

LIBRARIES = ("numpy", "scipy", "matplotlib")
"""Beside this package and Python: what the figures depend on."""

POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"
"""A browser then refuses to fetch anything, whatever stands in the page."""

LOOK = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; max-width: 70rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
table { border-collapse: collapse; margin: 1rem 0; display: block; overflow-x: auto; }
caption { text-align: left; font-weight: 600; padding: .3rem 0; }
th, td { padding: .2rem .7rem; border-bottom: 1px solid #e2e2e2; white-space: nowrap; }
figure { margin: 1rem 0 2rem; } figcaption { font-weight: 600; margin-bottom: .3rem; }
.picture { overflow: auto; border: 1px solid #e2e2e2; max-height: 90vh; }
.picture img { display: block; width: 100%; cursor: zoom-in; }
pre { background: #f6f6f6; padding: 1rem; overflow-x: auto; font-size: 13px; }
.quiet { color: #6b6b6b; }
"""

ZOOM = """
for (const frame of document.querySelectorAll('.picture')) {
  const picture = frame.querySelector('img');
  let scale = 1;
  const zoom = (wanted, x, y) => {
    const box = frame.getBoundingClientRect();
    const across = x - box.left, down = y - box.top, before = scale;
    scale = Math.min(16, Math.max(1, wanted));
    picture.style.width = 100 * scale + '%';
    frame.scrollLeft = (frame.scrollLeft + across) * scale / before - across;
    frame.scrollTop = (frame.scrollTop + down) * scale / before - down;
  };
  frame.addEventListener('wheel', event => {
    if (!event.ctrlKey && !event.shiftKey) return;
    event.preventDefault();
    zoom(scale * Math.exp(-0.002 * (event.deltaY || event.deltaX)), event.clientX, event.clientY);
  }, { passive: false });
  frame.addEventListener('click', event => zoom(scale * 2, event.clientX, event.clientY));
  frame.addEventListener('dblclick', event => zoom(1, event.clientX, event.clientY));
}
addEventListener('load', () => {
  const seen = [...document.images].filter(picture => picture.naturalWidth > 0).length;
  document.documentElement.dataset.pictures = seen;
});
"""


def write_report(
    path: Path,
    title: str,
    shown: Iterable[Table | str],
    figures: Mapping[str, Figure],
    details: Mapping[str, str] | None = None,
) -> None:
    """Write the page.

    Parameters
    ----------
    path : Path
        Where to.
    title : str
        Heading: what was done to what.
    shown : iterable of Table or str
        Tables and sentences in their order.
    figures : mapping
        Pictures by name.
    details : mapping, optional
        Longer texts by heading, such as the scenario file.
    """
    path.write_text(_page(title, shown, figures, details or {}), encoding="utf-8")


def _page(title: str, shown: Iterable[Table | str], figures: Mapping[str, Figure], details: Mapping[str, str]) -> str:
    parts = [table_html(one) if isinstance(one, Table) else f"<p>{escape(one)}</p>" for one in shown]
    if figures:
        parts.append("<h2>Pictures</h2><p class=quiet>Click or Ctrl + wheel: larger; double click: whole.</p>")
    parts += [_picture(name, figure) for name, figure in figures.items()]
    parts += [f"<h2>{escape(name)}</h2><pre>{escape(text)}</pre>" for name, text in details.items()]
    found = [f"adaptive-ff {__version__}", f"Python {platform.python_version()}"]
    found += [f"{name} {version(name)}" for name in LIBRARIES]
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        f'<meta name="viewport" content="width=device-width"><style>{LOOK}</style></head>\n'
        f"<body><h1>{escape(title)}</h1>\n{chr(10).join(parts)}\n"
        f"<h2>Versions</h2><p>{escape(', '.join(found))}; {platform.system()} {platform.machine()}</p>\n"
        f"<script>{ZOOM}</script></body></html>\n"
    )


def _picture(name: str, figure: Figure) -> str:
    stream = io.BytesIO()
    figure.savefig(stream, format="svg", metadata={"Date": None})
    data = base64.b64encode(stream.getvalue()).decode("ascii")
    picture = f'<img alt="{escape(name)}" src="data:image/svg+xml;base64,{data}">'
    return f'<figure><figcaption>{escape(name)}</figcaption><div class="picture">{picture}</div></figure>'
