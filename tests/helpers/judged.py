"""A controller against PI on one scenario, as a record."""

from types import SimpleNamespace

from adaptive_ff.studies.tracking import track_scenario


def judge(scenario, controller="adaptive", *, draws=5):
    """Return the ratios to PI: ``settled``, ``worst_window``, ``start``, ``after``."""
    found = track_scenario(scenario, [controller], draws=draws)[controller]
    return SimpleNamespace(worst_window=found["window"], **found)
