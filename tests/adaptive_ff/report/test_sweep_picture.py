"""The picture of a sweep: distributions, worst cases, own controllers."""

import dataclasses
import itertools

import numpy as np
import pytest

from adaptive_ff.report.sweep_picture import plot_sweep
from adaptive_ff.simulation.metrics import Metrics
from adaptive_ff.studies.sweep import Outcome


def outcome(draw, adaptive, **own):
    """An outcome in which errors of pi are one."""

    def metrics(error):
        return Metrics(**{field.name: error for field in dataclasses.fields(Metrics)})

    return Outcome(
        draw, {name: metrics(error) for name, error in {"pi": 1.0, "adaptive": adaptive, **own}.items()}, fall=draw
    )


def test_distributions_and_worst_cases_are_drawn(tmp_path):
    outcomes = [outcome(draw, 0.1 * draw, mine=1.0) for draw in (3, 1, 2)] + [Outcome(9, {}, "refused")]
    figure = plot_sweep(outcomes, "around joint.toml, seed 7", 2, tmp_path / "sweep.png")
    settled, whole, cases = figure.axes
    drawn = {line.get_color(): np.unique(line.get_xdata()) for line in whole.lines if len(line.get_xdata()) > 2}
    assert drawn["#d55e00"] == pytest.approx([0.1, 0.2, 0.3])
    assert np.unique(settled.lines[0].get_xdata()) == pytest.approx([1.0 / 0.3, 1.0 / 0.2, 1.0 / 0.1])
    assert [text.get_text() for text in cases.texts] == ["draw 3", "draw 2"]
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert legend[:2] == ["adaptive", "mine"]
    assert "around joint.toml, seed 7, adaptive-ff" in figure.get_supxlabel()
    assert (tmp_path / "sweep.png").read_bytes().startswith(b"\x89PNG")


def test_names_of_worst_cases_that_lie_together_do_not_overlap():
    outcomes = [dataclasses.replace(outcome(draw, 1.0 - 1e-4 * draw), fall=1e-3 * draw) for draw in range(8)]
    figure = plot_sweep(outcomes, "seed 7", 3)
    figure.draw_without_rendering()
    names = figure.axes[2].texts
    boxes = [name.get_window_extent() for name in names]
    assert [name.get_text() for name in names] == ["draw 0", "draw 1", "draw 2"]
    assert not any(one.overlaps(other) for one, other in itertools.combinations(boxes, 2))


def test_names_of_worst_cases_stay_in_their_panel():
    outcomes = [dataclasses.replace(outcome(draw, 0.1 + 0.3 * (draw % 9)), fall=0.01 * draw) for draw in range(36)]
    figure = plot_sweep(outcomes, "seed 7", 3)
    figure.draw_without_rendering()
    panel = figure.axes[2].get_window_extent()
    assert all(name.get_window_extent().y1 <= panel.y1 for name in figure.axes[2].texts)


def test_nothing_is_drawn_where_no_joint_ran():
    assert plot_sweep([Outcome(0, {}, "refused")], "seed 1") is None
