"""Every controller at its own best bandwidth."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from adaptive_ff import load_scenario, simulate
from adaptive_ff.comparison.matrix.cells import SCENARIOS
from adaptive_ff.comparison.own_bandwidth import STEP
from benchmarks import own_bandwidth
from benchmarks.own_bandwidth import Trial, choose, rows_of, settled_error, table_of


def test_error_of_a_trial_is_that_of_the_loop_with_the_bandwidth():
    scenario = load_scenario(SCENARIOS / "paper_100hz.toml").modified(seed=103)
    expected = simulate(scenario.modified(feedback={"bandwidth": 4.0}), "pi").metrics.rms_error_settled
    assert settled_error(Trial("paper_100hz", "pi", 4.0, 103)) == expected
    assert settled_error(Trial("paper_100hz", "pi", float("nan"), 103)) == settled_error(
        Trial("paper_100hz", "pi", 10.0, 103)
    )


def test_bandwidth_is_chosen_on_other_seeds_than_those_reported(monkeypatch):
    """A made-up error: 3 Hz is best for a controller on every seed, whatever the reported ones say."""
    seeds = {"chosen": set(), "reported": set()}

    def made_up(trial):
        kind = "chosen" if trial.seed > 100 else "reported"
        seeds[kind].add(trial.seed)
        bandwidth = trial.bandwidth if np.isfinite(trial.bandwidth) else 10.0
        return abs(np.log(bandwidth / 3.0)) + (1.0 if trial.controller == "pi" else 0.5)

    monkeypatch.setattr(own_bandwidth, "settled_error", made_up)
    with ThreadPoolExecutor(1) as pool:
        best, at_an_end = choose("paper_100hz", ["pi"], 2, pool)["pi"]
        rows = rows_of("paper_100hz", ["pi", "oracle"], 4, 2, pool)
    assert abs(np.log(best / 3.0)) <= 0.5 * np.log(STEP)
    assert not at_an_end
    assert (seeds["chosen"], seeds["reported"]) == ({101, 102}, {1, 2, 3, 4})
    assert [row["own_bandwidth"] for row in rows] == [best, best]
    assert rows[0]["common_error"] == pytest.approx(np.log(10.0 / 3.0) + 1.0)
    gains = list(table_of(rows).columns[7].cells)
    assert gains[0] == "1.00"
    assert float(gains[1]) > 1.5
