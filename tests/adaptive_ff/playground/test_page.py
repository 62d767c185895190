"""The page in headless Chromium: it needs nothing, follows its sliders, and runs what ``compare`` runs."""

import importlib.util
from unittest.mock import patch

import numpy as np
import pytest
from browser import Browser, needs_chromium
from command_line import run_command_line

from adaptive_ff import load_scenario
from adaptive_ff.comparison.run import simulate
from adaptive_ff.playground import page as whole
from adaptive_ff.playground.machines import machines
from adaptive_ff.simulation.metrics import first_motion
from adaptive_ff.simulation.tracking_errors import ratios, tracking_errors

pytestmark = [
    needs_chromium,
    pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason="ziglang is not installed"),
]

DRAWN = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))"
ROUNDING = 2e-8  # of the last digits of exp and log in the two libraries, which the estimates amplify
SERIES = ("velocity", "torque", "feedforward", "measured")


@pytest.fixture(scope="module", params=[1, pytest.param(3, marks=pytest.mark.nightly)])
def page(tmp_path_factory, request):
    """The page of the first machine in every run, of all of them nightly."""
    path = tmp_path_factory.mktemp("playground") / "page.html"
    with patch.object(whole, "machines", lambda: machines()[: request.param]):
        assert run_command_line("playground", "--out", path).status == 0
    return path


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    browser = Browser(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()


def opened(browser, page, words=""):
    browser.open(f"{page.as_uri()}{words}")
    wait(browser, "document.documentElement.dataset.drawn")


def wait(browser, condition):
    ask = "await new Promise(next => setTimeout(next, 20)); if (performance.now() > end) return false;"
    loop = f"(async () => {{ const end = performance.now() + 2e4; while (!({condition})) {{ {ask} }} return true; }})()"
    assert browser.evaluate(loop), browser.noted


def moved(browser, name, stop):
    browser.evaluate(
        f"(() => {{ const k = machine().sliders.findIndex(each => each.name === '{name}'); "
        f"$('s' + k).value = {stop}; $('s' + k).dispatchEvent(new Event('input')); }})(); {DRAWN}"
    )


def series(browser, which, name):
    return np.array(browser.evaluate(f"[...runs[{which}].series('5/{name}')]"))


def figures(browser):
    return browser.evaluate("figures()")


def difference(mine, theirs):
    return float(np.max(np.abs(mine - theirs)) / np.max(np.abs(theirs)))


def differences(browser, scenario):
    """Of all series of both runs, over their largest values."""
    found, runs = {}, {}
    for which, name in enumerate(("pi", "adaptive")):
        run = runs[name] = simulate(scenario, name)
        for key in SERIES:
            if np.any(getattr(run, key)):
                found[name, key] = difference(series(browser, which, key), getattr(run, key))
        table = series(browser, which, "estimates").reshape(run.time.size, -1)
        for k, (key, values) in enumerate(run.estimates.items()):
            if np.any(values):
                found[name, key] = difference(table[:, k], values)
        for k, (key, values) in enumerate(run.uncertainties.items()):
            marks = np.array(browser.evaluate(f"[...runs[{which}].deviations]")).reshape(-1, len(run.estimates))
            assert len(values) == len(marks) + 1  # simulate notes the beginning, too
            found[name, f"uncertainty of {key}"] = difference(marks[:, k], values[1:])
    return found, runs


def test_it_is_small_fits_a_phone_asks_for_nothing_and_its_series_are_those_of_compare(browser, page):
    assert page.stat().st_size < 1.5e6
    browser.resize(390, 800)
    opened(browser, page)
    assert browser.evaluate("document.documentElement.scrollWidth") <= 390
    browser.resize(1200, 900)
    assert browser.noted == []
    footer = browser.evaluate("document.querySelector('footer').textContent")
    assert "adaptive-ff 0" in footer
    assert "commit" in footer
    found, _ = differences(browser, load_scenario())
    assert len(found) > 20
    assert max(found.values()) < ROUNDING, found


MOVED = {
    "robot joint": (
        "multisine",
        {"inertia": 13, "stiction": 5, "bandwidth": 4, "noise": 2, "load step": 6, "gravity": 9},
    ),
    "servo": ("sine", {"Coulomb friction": 8, "friction lag": 9, "encoder": 5, "bandwidth": 12}),
    "belt axis": ("point to point", {"mass": 3, "Coulomb friction": 14, "load step": 3}),
}
MACHINES = [(1, "robot joint"), *(pytest.param(3, name, marks=pytest.mark.nightly) for name in MOVED)]


@pytest.mark.parametrize(("page", "machine"), MACHINES, indirect=["page"])
def test_the_file_of_moved_sliders_gives_the_same_series_and_figures(browser, page, tmp_path, machine):
    motion, stops = MOVED[machine]
    opened(browser, page, f"#machine={machine}&motion={motion}")
    before = figures(browser)
    for name, stop in stops.items():
        moved(browser, name, stop)
        assert figures(browser) != before
    path = tmp_path / "playground.toml"
    path.write_text(browser.evaluate("scenario()"))
    scenario = load_scenario(path)
    found, runs = differences(browser, scenario)
    found.pop(("adaptive", "presliding"))  # a ratio of two estimates that vanish at first
    assert max(found.values()) < ROUNDING, found
    period = scenario.joint.solver_period
    errors = {}
    for name, run in runs.items():
        changes = [change.time for change in scenario.change]
        begin = first_motion(run.reference) * period
        errors[name] = tracking_errors((run.reference - run.velocity) ** 2, period, begin=begin, changes=changes)
        assert errors[name].settled == pytest.approx(run.metrics.rms_error_settled, rel=1e-3)
    shown, stated = figures(browser), ratios(errors["pi"], errors["adaptive"])
    assert shown["settled"] == pytest.approx([errors[name].settled for name in errors], rel=1e-6)
    assert shown["first 5 s"] == pytest.approx([errors[name].start for name in errors], rel=1e-6)
    assert shown["worst window"][1] / shown["worst window"][0] == pytest.approx(stated["window"], rel=1e-6)
    link = browser.evaluate("link()")
    here = browser.evaluate("shown.stops")
    opened(browser, page, link)
    assert browser.evaluate("shown.stops") == here
    assert browser.noted == []


def test_keys_move_a_slider_and_friction_that_falls_below_takes_the_other_along(browser, page):
    opened(browser, page)
    browser.evaluate("$('s2').focus()")
    arrow = {"key": "ArrowLeft", "code": "ArrowLeft", "windowsVirtualKeyCode": 37}
    for kind in 5 * ("keyDown", "keyUp"):
        browser.call("Input.dispatchKeyEvent", type=kind, **arrow)
    lower, first = browser.evaluate("content.machines[0].sliders.slice(1, 3).map(each => each.start)")
    assert browser.evaluate("shown.stops.slice(1, 3)") == [first - 5, first - 5]
    assert first - 5 < lower
    assert browser.evaluate("$('o1').value") == browser.evaluate("$('o2').value")


def test_live_friction_changes_under_the_feet_of_the_controller(browser, page):
    opened(browser, page)
    browser.evaluate(f"$('live').click(); {DRAWN}")
    wait(browser, "done > 100")
    at = browser.evaluate("done")
    known = series(browser, 1, "estimates")[0]
    moved(browser, "stiction", 20)
    wait(browser, f"done > {at + 50}")
    assert series(browser, 1, "estimates")[0] == known  # the run goes on
    assert list(figures(browser)) == ["last 5 s"]
    browser.evaluate("began += 60 - 0.01 * done - 0.1; 0")  # to the end, where it begins again
    wait(browser, "done < 100")
    assert np.all(np.isfinite(series(browser, 1, "velocity")))
    assert browser.noted == []
