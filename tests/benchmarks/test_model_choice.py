"""The benchmark of the choice of models: its joints, and that its controllers differ as they say."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from adaptive_ff.comparison.registry import make_adaptive
from benchmarks import model_choice
from benchmarks.model_choice import NAMES, named, weighted, weights_table, without_candidates


@pytest.mark.parametrize("name", NAMES)
def test_joints_are_those_they_are_named_after(name):
    scenario = named(name)
    assert scenario.sampling.period == (0.001 if name == "noisy_1khz" else 0.01)
    if name.startswith("lugre_"):
        assert scenario.joint.stiffness == float(name.removeprefix("lugre_"))


def test_one_of_the_controllers_has_no_candidates():
    scenario = named("lugre_1e4")
    assert without_candidates(scenario).parameters.estimator.candidates.size == 0
    assert make_adaptive(scenario).parameters.estimator.candidates.size > 0


def test_a_weight_is_identified_or_not():
    names = [make_adaptive(weighted(40.0, identify)).estimate_names for identify in ("offset", "gravity")]
    assert ["gravity_sin" in one for one in names] == [False, True]
    assert weighted(40.0, "offset").joint.gravity == 40.0


def test_spans_lie_within_the_run(monkeypatch):
    monkeypatch.setattr(model_choice, "WEIGHTS", (0.0,))
    with ThreadPoolExecutor(1) as pool:
        table = weights_table(pool, range(101, 102))
    assert table.row_count == 2
    offset, gravity = (float(value) for value in table.columns[2].cells)
    assert gravity == pytest.approx(offset, rel=0.1)
