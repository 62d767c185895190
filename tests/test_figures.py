"""Figures of short runs are those that are stored: no behaviour changes by the way."""

import json

import pytest
from figures import CASES, STORED, figures

KNOWN = json.loads(STORED.read_text(encoding="utf-8"))


def test_what_is_stored_is_what_is_run():
    assert list(KNOWN) == list(CASES)


@pytest.mark.parametrize("case", CASES)
def test_figures_are_those_that_are_stored(case):
    """After a change of behaviour that is wanted, ``python tests/helpers/figures.py`` stores them anew."""
    found = figures(case)
    assert list(found) == list(KNOWN[case])
    moved = {
        name: (KNOWN[case][name], value)
        for name, value in found.items()
        if value != pytest.approx(KNOWN[case][name], rel=1e-5, abs=1e-9)
    }
    assert moved == {}
