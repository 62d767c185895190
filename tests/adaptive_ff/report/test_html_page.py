"""The page of a result, and its series for viewers."""

import json
import re
from contextlib import closing
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
from browser import Browser, needs_chromium
from command_line import run_command_line
from matplotlib.figure import Figure
from mcap.reader import make_reader

from adaptive_ff import InputError, __version__, compare, load_scenario, read_log
from adaptive_ff.report import viewers
from adaptive_ff.report.page import write_report
from adaptive_ff.report.table import table
from adaptive_ff.reported import Reported

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


SCENARIO = load_scenario().modified(duration=12.0, controllers=["pi", "adaptive"])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    from adaptive_ff.scenario.file import to_toml

    place = tmp_path_factory.mktemp("viewers")
    (place / "short.toml").write_text(to_toml(SCENARIO))
    log = ["results/pi.csv", "--velocity", "measured", "--torque", "torque"]
    with pytest.MonkeyPatch.context() as monkey:
        monkey.setattr(Reported, "plot", lambda result, folder: {})
        monkey.chdir(place)
        for command in (["compare", "short.toml"], ["identify", *log], ["replay", *log]):
            done = run_command_line(*command, "--mcap", f"{command[0]}.mcap")
            assert done.status == 0, done.err
    return place


def contents(file):
    """Topics with their schema, times and messages."""
    with file.open("rb") as stream:
        reader = make_reader(stream)
        found = {}
        for schema, channel, message in reader.iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            assert schema.name.startswith("adaptive_ff.")
            times, messages = found.setdefault(channel.topic, (json.loads(schema.data), [], []))[1:]
            times.append(message.log_time)
            messages.append(json.loads(message.data))
        return found


TOPICS = {"identify": {"/log", "/parameters"}, "replay": {"/log", "/fixed", "/adaptive"}}
TOPICS["compare"] = {"/pi", "/adaptive", "/adaptive/bounds"}


@pytest.mark.parametrize(("command", "topics"), TOPICS.items())
def test_messages_are_those_of_their_schema_and_curves_of_the_layout_are_in_them(folder, command, topics):
    found = contents(folder / f"{command}.mcap")
    assert topics <= set(found)
    names = set()
    for topic, (schema, times, messages) in found.items():
        assert times == sorted(times)
        for part, content in schema["properties"].items():
            names |= {f"{topic}/{part}/{one}" for one in content["properties"]}
            assert {type(value) for message in messages for value in message[part].values()} == {float}
            assert all(set(message[part]) <= set(content["properties"]) for message in messages)
    curves = {curve.get("name") for curve in ElementTree.parse(folder / f"{command}.xml").iter("curve")}
    assert curves
    assert curves <= names


def test_values_are_those_of_the_run_and_read_as_a_log(folder):
    run, found = compare(SCENARIO).runs["adaptive"], contents(folder / "compare.mcap")
    schema, times, messages = found["/adaptive"]
    assert schema["properties"]["torque"]["properties"]["feedforward"] == {"type": "number", "description": "N m"}
    assert np.allclose(np.array(times) * 1e-9, run.time, atol=1e-9)
    names = ("feedforward", "feedback", "applied")
    parts = np.array([[message["torque"][name] for name in names] for message in messages])
    assert np.array_equal(parts[:, 2], run.torque)
    assert np.allclose(parts[:, 0] + parts[:, 1], parts[:, 2])
    bounds = found["/adaptive/bounds"][2]
    assert bounds[-1]["coulomb"]["lower"] < run.final_estimates["coulomb"] < bounds[-1]["coulomb"]["upper"]
    named = {"velocity": "pi.motion.measured", "torque": "pi.torque.applied", "time": "pi.log_time"}
    assert len(read_log(folder / "compare.mcap", **named).torque) == 1200


def test_missing_library_is_named(tmp_path, monkeypatch):
    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr("importlib.import_module", missing)
    with pytest.raises(InputError, match=r"^a\.mcap: .* pip install mcap"):
        viewers.write_mcap(tmp_path / "a.mcap", None)
