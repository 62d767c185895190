"""The bandwidth that suits a controller: where the error is least, on seeds of its own; and ``auto`` uses it."""

import math

import numpy as np
import pytest
from command_line import run_command_line
from scenario_files import short, write_scenario

from adaptive_ff import InputError, Scenario, compare, load_scenario, simulate
from adaptive_ff.comparison import own_bandwidth
from adaptive_ff.comparison.registry import CONTROLLERS, loop_of, make_controller
from adaptive_ff.scenario.loop import STEP, tried_bandwidths
from adaptive_ff.studies.sweep import sweep
from controllers import PI, fastest_bandwidth, pi_gains

SHORT = load_scenario().modified(duration=4.0, controllers=["pi", "adaptive"])
AUTO = SHORT.modified(feedback={"bandwidth": "auto"})


def test_bandwidths_end_at_the_fastest_that_the_margin_allows():
    found = tried_bandwidths(load_scenario())
    assert found[-1] == pytest.approx(fastest_bandwidth(0.01), rel=1e-12)
    assert 1.0 <= found[0] < STEP
    assert np.diff(np.log(found)) == pytest.approx(np.log(STEP))
    wave = {"frequencies": [0.01], "amplitudes": [1.0]}
    slow = load_scenario().modified(sampling={"period": 0.2}, feedback={"bandwidth": 0.1}, reference=wave)
    assert len(tried_bandwidths(slow)) == 5


def test_best_bandwidth_is_chosen_on_its_own_seeds(monkeypatch):
    """Made-up errors, settled least at 3 Hz, loaded at 6 Hz; the scenario's own seed is not among those of the runs."""
    seen = set()

    def made_up(scenario, maker, setup=None):
        seen.add(scenario.seed)
        hertz = scenario.feedback.hertz
        far = [abs(math.log(hertz / best)) if hertz < 12.0 else math.inf for best in (3.0, 6.0)]
        return own_bandwidth.Errors(1.0 + far[0], 1.0 + far[1])

    monkeypatch.setattr(own_bandwidth, "errors_of", made_up)
    found = own_bandwidth.find_own_bandwidth(SHORT.modified(seed=7, duration=4.25), CONTROLLERS["pi"])
    assert seen == set(own_bandwidth.TUNING_SEEDS)
    assert abs(math.log(found.best / math.sqrt(3.0 * 6.0))) <= 0.5 * math.log(STEP)
    assert not found.at_an_end
    assert found.costs[found.place] == min(found.costs)
    assert found.errors[-1] == math.inf
    monkeypatch.setattr(own_bandwidth, "errors_of", lambda *_: own_bandwidth.Errors(math.inf, math.inf))
    with pytest.raises(ArithmeticError, match="fails at every bandwidth"):
        own_bandwidth.find_own_bandwidth(SHORT.modified(duration=4.5), CONTROLLERS["pi"])


@pytest.mark.parametrize("position", [None, {}], ids=["velocity", "position loop"])
def test_error_at_a_bandwidth_is_that_of_a_run(position):
    scenario = SHORT if position is None else SHORT.modified(position=position)
    given = scenario.modified(feedback={"bandwidth": 4.0})
    expected = simulate(given, "pi").metrics.rms_error_settled
    found = own_bandwidth.settled_error(own_bandwidth.with_bandwidth(scenario, 4.0), CONTROLLERS["pi"])
    assert found == pytest.approx(expected, rel=1e-9)
    found = own_bandwidth.find_own_bandwidth(scenario, CONTROLLERS["pi"], seeds=(1,))
    run = simulate(own_bandwidth.loaded(scenario.modified(feedback={"bandwidth": found.bandwidths[2]})), "pi")
    assert run.scenario.change[0].time == 3.0
    squares = (run.reference - run.velocity) ** 2
    expected = np.sqrt([np.mean(squares[2000:3000]), np.mean(squares[3000:])])
    assert found.pairs[2] == pytest.approx(tuple(expected), rel=1e-9)


def test_step_of_the_load_comes_after_what_changes_and_beside_it():
    changed = SHORT.modified(duration=12.0, change=[{"time": 4.0, "friction_scale": 0.5, "load": 10.0}])
    found = own_bandwidth.loaded(changed).change
    assert found[1].model_dump(exclude_unset=True) == {"time": 10.0, "friction_scale": 0.5, "load": 170.0}
    assert len(found) == 2


def test_gains_give_way_to_a_bandwidth():
    content = SHORT.model_dump(exclude_unset=True)
    gains = Scenario.model_validate({**content, "feedback": {"inertia": 20.0, "proportional": 1e3, "integral": 1e3}})
    assert own_bandwidth.with_bandwidth(gains, 3.0).feedback.gains == pi_gains(20.0, 3.0)


def test_auto_gives_each_controller_its_own_best_bandwidth_and_own_ones_the_loop_that_suits_pi():
    def mine(proportional, integral, period):
        return PI(proportional, integral, period)

    found = compare(AUTO, own={"mine": mine})
    expected = {name: own_bandwidth.find_own_bandwidth(SHORT, CONTROLLERS[name]).best for name in ("pi", "adaptive")}
    assert found.bandwidths == {**expected, "mine": expected["pi"]}
    assert found.to_dict()["bandwidths"] == found.bandwidths
    assert found.runs["mine"].metrics == found.runs["pi"].metrics
    assert found.to_dict()["scenario"]["feedback"]["bandwidth"] == "auto"
    alone = simulate(AUTO, "pi")
    assert alone.metrics == found.runs["pi"].metrics
    assert alone.metrics == simulate(own_bandwidth.with_bandwidth(SHORT, expected["pi"]), "pi").metrics
    assert make_controller(AUTO, "pi").parameters.proportional == pi_gains(20.0, expected["pi"])[0]
    assert compare(SHORT.modified(controllers=["pi"])).bandwidths == {}
    assert loop_of(SHORT, "pi") is SHORT


def test_where_one_bandwidth_is_needed_auto_is_refused_and_other_words_always_are():
    said = "bandwidth = 'fast' is not allowed: it must be a positive and finite number of Hz, or 'auto'"
    with pytest.raises(InputError, match=said):
        SHORT.modified(feedback={"bandwidth": "fast"})
    with pytest.raises(InputError, match=r"feedback.bandwidth = 'auto' is not allowed here"):
        _ = AUTO.feedback.gains
    with pytest.raises(InputError, match="'auto' is not allowed for a sweep"):
        sweep(AUTO, 1)
    with pytest.raises(InputError, match=r"position.gain is missing; it must be given where feedback.bandwidth is"):
        AUTO.modified(position={})
    assert AUTO.modified(position={"gain": 5.0}).position_loop.gain == 5.0
    with pytest.raises(InputError, match="bandwidth = auto is given beside gains"):
        AUTO.modified(feedback={"proportional": 1.0})


def test_compare_says_which_bandwidths_it_took(tmp_path):
    content = {**short(), "duration": 2.0}
    content["feedback"] = {"inertia": 20.0, "bandwidth": "auto"}
    outcome = run_command_line("compare", write_scenario(tmp_path, content), "--out", tmp_path / "out")
    assert outcome.status == 0, outcome.err
    assert "Each controller in the loop that suits it, chosen on other seeds: pi " in outcome.out
