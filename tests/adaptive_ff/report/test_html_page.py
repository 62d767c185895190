"""The report in one HTML file: refers to nothing outside, shows in a browser, zooms."""

import json
import re
from contextlib import closing
from html.parser import HTMLParser

import pytest
from browser import Browser, needs_chromium
from command_line import run_command_line
from matplotlib.figure import Figure

from adaptive_ff import __version__
from adaptive_ff.report.page import write_report
from adaptive_ff.report.table import table

ZOOM = """(() => {
  const frame = document.querySelector('.picture'), found = [document.documentElement.dataset.pictures];
  const at = { clientX: 200, clientY: 200 }, turned = new WheelEvent('wheel', { ...at, deltaY: -500, ctrlKey: true });
  for (const each of [new MouseEvent('click', at), turned, new MouseEvent('dblclick', {})]) {
    frame.dispatchEvent(each);
    found.push(frame.querySelector('img').style.width);
  }
  return found;
})()"""
"""How many pictures there are, and how wide the first one is after a click, a turn of the wheel and a double click."""


class Page(HTMLParser):
    """Tags, what they refer to, and the text of a page."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.open, self.references, self.text = [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        if tag not in ("meta", "img"):
            self.open.append(tag)
        self.references += [value for name, value in attrs if name in ("src", "href", "srcset", "action", "data")]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


@pytest.fixture
def page(tmp_path):
    rows, styles = [["mine & yours", 1.5], ["pi", "[bold]3[/bold]"]], {"mine & yours": "bold cyan"}
    errors = table("Errors of <all>", rows, {"controller": None, "settled": ("", 3)}, styles=styles)
    figures = {}
    for name in ("one", "two"):
        figures[name] = Figure(figsize=(4.0, 2.0))
        figures[name].add_subplot().plot([0.0, 1.0])
    path = tmp_path / "report.html"
    write_report(path, "A <joint>", [errors, "A sentence & more."], figures, {"Scenario": "seed = 1 # <one>"})
    return path


def test_page_holds_tables_sentences_input_and_versions_and_refers_to_nothing_outside(page):
    text = page.read_text(encoding="utf-8")
    parsed = Page(text)
    assert parsed.open == []
    assert len(parsed.references) == 2
    assert all(reference.startswith("data:image/svg+xml;base64,") for reference in parsed.references)
    assert not {"link", "iframe", "object", "embed", "base"} & set(parsed.tags)
    assert "default-src 'none'" in text
    assert re.findall(r"url\(|@import|fetch\(|XMLHttpRequest|import\(", text) == []
    assert '<tr style="font-weight: bold"><td' in text
    shown = " ".join(parsed.text)
    for part in ("A <joint>", "Errors of <all>", "mine & yours", "A sentence & more.", "seed = 1 # <one>", "numpy "):
        assert part in shown
    assert f"adaptive-ff {__version__}" in shown


@needs_chromium
def test_browser_shows_all_pictures_and_zooms(page, tmp_path):
    with closing(Browser(tmp_path / "profile")) as browser:
        browser.open(page.as_uri())
        pictures, clicked, wheeled, whole = browser.evaluate(ZOOM)
    assert (pictures, clicked, whole) == ("2", "200%", "100%")
    assert 400.0 < float(wheeled.rstrip("%")) < 600.0


@pytest.mark.usefixtures("compiled")
def test_compare_writes_a_report(tmp_path, scenario):
    out = tmp_path / "out"
    assert run_command_line("compare", scenario, "--out", out, "--report", "-q").status == 0
    parsed = Page((out / "report.html").read_text(encoding="utf-8"))
    figures = [path.stem for path in out.glob("*.png")]
    assert len(parsed.references) == len(figures) > 1
    text = "".join(parsed.text)
    assert f"Controllers on {scenario}, seed 1" in text
    assert "[joint]" in text
    settled = json.loads((out / "result.json").read_text())["controllers"]["pi"]["rms_error_settled"]
    assert f"{1e3 * settled:.3g}" in text
