"""The same scenario and seed give the same figures: in a second run bit for bit, elsewhere to 1e-9 of stored ones."""

import json
from pathlib import Path

import pytest

from adaptive_ff import compare, load_scenario

STORED = Path(__file__).with_name("stored_figures.json")
"""Written on x86-64 Linux by ``compare(SCENARIO).write(STORED)``."""

SCENARIO = load_scenario().modified(duration=10.0, controllers=["pi", "pi_inertia"])


def test_second_run_gives_the_same_bits():
    assert compare(SCENARIO).to_dict() == compare(SCENARIO).to_dict()


def test_figures_are_those_that_were_stored():
    stored = json.loads(STORED.read_text(encoding="utf-8"))["controllers"]
    for name, run in compare(SCENARIO).runs.items():
        assert vars(run.metrics) == pytest.approx(stored[name], rel=1e-9)
