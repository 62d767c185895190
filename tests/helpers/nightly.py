"""Part of a parametrization in every run, the rest of it nightly."""

import pytest


def sampled(values, sample):
    """Parameters of a test: those in the sample in every run, the others nightly."""
    return [pytest.param(value, marks=() if value in sample else pytest.mark.nightly) for value in values]
