"""The picture of a sweep: distributions, worst cases, own controllers."""

import dataclasses

import numpy as np
import pytest

from adaptive_ff.report.study_pictures import plot_sweep
from adaptive_ff.simulation.metrics import Metrics
from adaptive_ff.studies.sweep import Outcome


def outcome(draw, adaptive, **own):
    """An outcome in which errors of pi are one."""

    def metrics(error):
        return Metrics(**{field.name: error for field in dataclasses.fields(Metrics)})

    errors = {"pi": 1.0, "adaptive": adaptive, **own}
    return Outcome(draw, {name: metrics(error) for name, error in errors.items()}, fall=draw)


def test_distributions_and_worst_cases_are_drawn():
    outcomes = [outcome(draw, 0.1 * draw, mine=1.0) for draw in (3, 1, 2)] + [Outcome(9, {}, "refused")]
    figure = plot_sweep(outcomes, "around joint.toml, seed 7", 2)
    settled, whole, cases = figure.axes
    drawn = {line.get_color(): np.unique(line.get_xdata()) for line in whole.lines if len(line.get_xdata()) > 2}
    assert drawn["#d55e00"] == pytest.approx([1.0 / 0.3, 1.0 / 0.2, 1.0 / 0.1])
    assert np.unique(settled.lines[0].get_xdata()) == pytest.approx([1.0 / 0.3, 1.0 / 0.2, 1.0 / 0.1])
    assert {text.get_text(): text.xy[0] for text in cases.texts} == {"1": 3, "2": 2}
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert legend[:2] == ["adaptive", "mine"]
    assert "around joint.toml, seed 7, adaptive-ff" in figure.get_supxlabel()
