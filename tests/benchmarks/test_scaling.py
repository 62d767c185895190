"""The benchmark of scaling runs, and its figures are what they say."""

from io import StringIO

import pytest
from rich.console import Console

from adaptive_ff import load_scenario
from adaptive_ff.comparison import running
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.simulation.experiment import lay_course
from benchmarks import scaling
from benchmarks.scaling import Sizes

TINY = Sizes(durations=(2.0, 4.0), runs=(1, 2), controllers=(1,), shared=2, duration=2.0)


def test_costs_are_printed_and_returned(monkeypatch):
    monkeypatch.setattr(scaling, "SECTIONS", {k: v for k, v in scaling.SECTIONS.items() if "workers" not in k})
    printed = StringIO()
    result = scaling.report(Console(file=printed, width=140), TINY)
    costs = [cost for section in result["costs"].values() for cost in section]
    assert [cost["what"] for cost in costs] == ["2 s", "4 s", "1 joints", "2 joints", "1 controllers"]
    assert all(cost["total"] > 0.0 and cost["what"] in printed.getvalue() for cost in costs)
    assert costs[1]["each"] == pytest.approx(costs[1]["total"] / 4.0)


def test_loop_is_timed_and_put_back():
    run = running.run_controller
    with scaling.timed_loop() as spent:
        running.drive_over(*_ready())
    assert running.run_controller is run
    assert 0.0 < spent[0] < 60.0


def _ready():

    scenario = load_scenario().modified(duration=1.0)
    return make_controller(scenario, "pi"), lay_course(scenario)
