"""Figures of short runs are those that are stored: no behaviour changes by the way."""

import json

import pytest
from figures import CASES, STORED, figures

FITTED = 2e-3  # relative change of a figure behind a search that ends elsewhere on another processor

KNOWN = json.loads(STORED.read_text(encoding="utf-8"))


def is_close(value, known, relative):
    return value == known if isinstance(value, str) else value == pytest.approx(known, rel=relative, abs=1e-9)


def moved(case):
    """Return the figures that differ from those stored, both."""
    found, known = figures(case), KNOWN[case]
    assert list(found) == list(known)
    relative = FITTED if case == "fits of curves" else 1e-5
    return {name: (known[name], value) for name, value in found.items() if not is_close(value, known[name], relative)}


def test_what_is_stored_is_what_is_run():
    assert list(KNOWN) == list(CASES)


@pytest.mark.parametrize("case", CASES)
def test_figures_are_those_that_are_stored(case):
    """After a change of behaviour that is wanted, ``PYTHONPATH=. python tests/helpers/figures.py`` stores them anew."""
    assert moved(case) == {}
