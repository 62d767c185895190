"""Friction over position and load, learnt online."""

import json
import math

import numpy as np
import pytest

from adaptive_ff import AdaptiveController, load_scenario
from adaptive_ff.adaptive.learning.estimator import follow_friction_map, learn_friction_map
from adaptive_ff.adaptive.learning.estimator_state import initial_estimator_state
from adaptive_ff.adaptive.learning.forgetting import scale_estimate_in_place
from adaptive_ff.adaptive.learning.friction_map import (
    LEAST_FACTOR,
    LOAD,
    POSITION,
    coming_factor,
    correct_map_in_place,
    filtered_factor,
    follow_map_in_place,
    initial_map,
    learn_map_in_place,
    likeness,
    map_value,
    taken_over,
)
from adaptive_ff.adaptive.learning.map_reading import read_map
from adaptive_ff.adaptive.learning.map_settings import map_parameters
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.comparison.run import simulate
from adaptive_ff.friction.model import WITH_OFFSET
from adaptive_ff.learning.torque_form import initial_signals
from adaptive_ff.regression.known_loads import INPUT, load_torque
from adaptive_ff.report.comparison_plots import plot_comparison
from adaptive_ff.report.diagnosis_map import map_sentences
from controllers import pi_gains

GAINS = pi_gains(20.0, 10.0)
SHORT = load_scenario().modified(duration=40.0, seed=101, controllers=["pi", "adaptive"])
WAVY = SHORT.modified(variation={"position_amplitude": 0.3, "position_period": 0.3})
KNOWN = {"position_periods": [0.3]}
HATS = {"position_hats": 60, "position_range": [-1.0, 5.0]}


def make(**options):
    return AdaptiveController(*GAINS, period=0.01, inertia=20.0, stribeck_velocity=0.05, **options)


def run(scenario, **assumed):
    scenario = scenario.modified(adaptation=assumed)
    controller = make_controller(scenario, "adaptive")
    return simulate(scenario, controller, uncertain=False), controller


@pytest.fixture(scope="module")
def known():
    return run(WAVY, **KNOWN)


def learn_by_hand(parameters, truth, seconds=40.0, offset=0.0, torque=lambda angle: 0.0):
    """Let a map follow a joint to and fro with a friction of 60 N m times ``1 + truth(q)``, at 1 rad/s."""
    state = initial_map(parameters)
    for k in range(round(seconds / 0.01)):
        place = 0.01 * k % 8.0
        angle, sign = (place - 2.0, 1.0) if place < 4.0 else (6.0 - place, -1.0)
        state = follow_map_in_place(state, 1e3, angle, torque(angle), 0.01, k == 0)
        factor, friction = filtered_factor(parameters, state), 60.0 * sign
        error = friction * (1.0 + truth(angle) - factor) + offset
        state = learn_map_in_place(parameters, state, friction * factor, error, 0.01, 4.0)
    return state


@pytest.mark.parametrize("settings", [((2.0,), 0), ((), 41)], ids=["period", "hats"])
def test_a_map_is_found_and_fed_in_full(settings):
    parameters = map_parameters(*settings, (-2.0, 2.0) if settings[1] else None, 0.0, 2.0)
    state = learn_by_hand(parameters, lambda angle: 0.3 * math.sin(math.pi * angle))
    assert state.share == 1.0
    for angle in np.linspace(-1.8, 1.8, 19):
        found = map_value(parameters, state.coefficients, angle, 0.0)
        assert found == pytest.approx(0.3 * math.sin(math.pi * angle), abs=0.03)
    turn = 0.1
    at = state.signals[0, 2] + turn
    assert coming_factor(parameters, state, turn) == 1.0 + map_value(parameters, state.coefficients, at, 0.0)


def test_a_load_that_does_not_turn_with_the_motion_is_no_friction_over_position():
    parameters = map_parameters((), 41, (-2.0, 2.0), 0.0, 2.0)
    state = learn_by_hand(parameters, lambda angle: 0.0, offset=20.0)
    assert np.max(np.abs(state.coefficients)) > 0.1
    assert state.share == 0.0
    assert filtered_factor(parameters, state) == coming_factor(parameters, state, 0.1) == 1.0


def test_without_friction_there_is_nothing_to_learn():
    parameters = map_parameters([0.3], 0, None, 0.0, 30.0)
    state = follow_map_in_place(initial_map(parameters), 1e3, 0.1, 0.0, 0.01, True)
    state = learn_map_in_place(parameters, state, 0.0, 5.0, 0.01, 4.0)
    assert np.array_equal(state.coefficients, [0.0, 0.0])


def test_known_torque_is_what_is_given_and_what_is_identified():
    estimator = make(load_friction=True).parameters.estimator
    state = initial_estimator_state(estimator)
    state.recursion.estimate[-2:] = 30.0, 40.0
    state.loads[:2, INPUT] = math.sin(0.7), math.cos(0.7)
    carried = load_torque(state.recursion.estimate, state.loads, state.regressors, 0.0)
    assert abs(carried) > 30.0
    followed = follow_friction_map(estimator, state, 0.7, 5.0, 0.01, True)
    assert followed.friction_map.signals[LOAD, INPUT] == pytest.approx(5.0 + carried)
    assert followed.friction_map.signals[POSITION, INPUT] == 0.7


def visited(coefficients):
    """Return parameters and state of a map of six hats, one rad apart, of which the first ones have been visited."""
    parameters = map_parameters((), 6, (0.0, 5.0), 0.0, 2.0)
    state = initial_map(parameters)
    state.coefficients[: len(coefficients)] = coefficients
    state.information[: len(coefficients)] = 1e3
    return parameters, state


@pytest.mark.parametrize(
    ("coefficients", "alike"),
    [((0.2, 0.2, 0.2), 1.0), ((0.2, 0.1, 0.2), 0.8), ((0.2, -0.2, 0.2), 0.0), ((0.2,), 0.0), ((), 0.0)],
)
def test_a_hat_begins_as_far_like_its_neighbour_as_others_are(coefficients, alike):
    parameters, state = visited(coefficients)
    assert likeness(parameters, state) == pytest.approx(alike)
    place = len(coefficients)
    state.signals[POSITION, 0] = place - 0.5
    correct_map_in_place(parameters, state, 60.0, 0.0, 0.01)
    last = coefficients[-1] if coefficients else 0.0
    assert state.coefficients[place] == pytest.approx(alike**2 * last)
    assert state.information[place] > 0.0
    before = state.coefficients.copy()
    state.coefficients[place - 1] = 0.5  # a hat that has been visited keeps what it has learnt
    correct_map_in_place(parameters, state, 60.0, 0.0, 0.01)
    assert state.coefficients[place] == before[place]


def test_a_hat_that_is_not_visited_does_not_begin():
    parameters, state = visited([0.2, 0.2, 0.2])
    for place in (2.0, -1.0):
        state.signals[POSITION, 0] = place
        correct_map_in_place(parameters, state, 60.0, 0.0, 0.01)
    assert state.coefficients.tolist() == [0.2, 0.2, 0.2, 0.0, 0.0, 0.0]


def test_where_a_map_comes_in_the_friction_that_is_fed_stays():
    parameters, state = visited([0.4, 0.4])
    state.signals[POSITION, 0] = 0.5
    assert taken_over(parameters, state, state) == 1.0
    fed = state._replace(share=1.0)
    assert taken_over(parameters, state, fed) * filtered_factor(parameters, fed) == pytest.approx(1.0)
    assert taken_over(parameters, fed, state) == pytest.approx(1.4)


def test_all_friction_and_nothing_else_is_scaled_where_a_map_comes_in():
    estimate = np.array([20.0, 60.0, 90.0, 80.0, 0.02, 3.0, 4.0, 8.0, 7.0, 7.0])
    scale_estimate_in_place(estimate, 0.5, loads=2)
    assert estimate.tolist() == [20.0, 30.0, 45.0, 40.0, 0.02, 3.0, 2.0, 4.0, 7.0, 7.0]


@pytest.mark.parametrize("options", [KNOWN, {"load_friction": True}], ids=["position", "load"])
def test_map_learns_from_what_the_estimator_leaves(options):
    estimator = make(parameters=WITH_OFFSET, **options).parameters.estimator
    state = initial_estimator_state(estimator)
    followed = follow_friction_map(estimator, state, 0.05, 7.0, 0.01, True)
    estimate, row = state.recursion.estimate, state.scratch.row
    state.candidates.estimates[:, -1] = 30.0
    estimate[:6], row[:7] = (20.0, 60.0, 90.0, 80.0, 0.02, 3.0), (0.0, 0.4, 0.7, 0.3, 0.2, 10.0, 1.0)
    signals = initial_signals()
    signals.filters[0, 0], signals.bent[1] = 150.0, (0.4, 5.0)
    friction = 60.0 * 0.7 + 90.0 * 0.3 + 80.0 * 0.2
    error = 150.0 - 30.0 * 0.4 - (20.0 * 0.4 + friction + 0.02 * 10.0 + 3.0)
    learnt = learn_friction_map(estimator, followed, signals, 0.01).friction_map
    twin = follow_map_in_place(initial_map(estimator.friction_map), estimator.form.pole, 0.05, 7.0, 0.01, True)
    twin = learn_map_in_place(estimator.friction_map, twin, friction, error, 0.01, estimator.memory)
    for own, other in zip(learnt, twin, strict=True):
        assert np.allclose(own, other, rtol=1e-12, atol=0.0)
    assert np.all((learnt.coefficients != 0.0) == (options == KNOWN))  # the first load is its own mean
    assert learnt.seen == 0.01


def test_no_error_makes_friction_vanish():
    parameters = map_parameters((1.0,), 0, None, 0.0, 2.0)
    state = follow_map_in_place(initial_map(parameters), 60.0, 0.0, 0.0, 0.01, True)._replace(share=1.0, friction=1.0)
    for _ in range(100):
        correct_map_in_place(parameters, state, 60.0, -1e6, 0.01)
    assert coming_factor(parameters, state, 0.0) == LEAST_FACTOR


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"position_periods": (0.0,)}, "position_periods"),
        ({"position_periods": [1.0] * 9}, "position_periods"),
        ({"position_hats": 1}, "position_hats = 1"),
        ({"position_hats": 5, "position_range": (1.0, 1.0)}, "position_range"),
        ({"position_range": (0.0, 1.0)}, "without position_hats"),
        ({"load_friction": True, "map_memory": 0.0}, "map_memory"),
    ],
)
def test_what_no_map_can_be_is_refused(options, message):
    with pytest.raises(ValueError, match=message):
        make(**options)


def test_a_known_period_halves_the_error_and_is_told(known):
    base, _ = run(WAVY)
    found, controller = known
    assert found.metrics.rms_error_settled < 0.6 * base.metrics.rms_error_settled
    learnt = controller.learnt_map
    truth = 1.0 + 0.3 * np.sin(2.0 * np.pi * learnt.position / 0.3)
    assert np.max(np.abs(learnt.factor - truth)) < 0.05
    (sentence,) = controller.diagnose().friction_map
    assert sentence.startswith("Friction depends on position: it rises by ")
    assert sentence.endswith(", and repeats every 0.3 rad.")


def test_where_friction_does_not_depend_on_position_a_map_changes_nothing():
    base, _ = run(SHORT)
    found, controller = run(SHORT, **KNOWN, **HATS)
    np.testing.assert_array_equal(found.torque, base.torque)
    assert "is not fed" in controller.diagnose().friction_map[0]


def test_the_first_seconds_are_those_without_a_map(known):
    base, _ = run(WAVY)
    np.testing.assert_array_equal(known[0].torque[:400], base.torque[:400])


def test_a_saved_map_goes_on_and_belongs_to_its_periods(known):
    _, controller = known
    text = controller.state_to_json()
    again = make_controller(WAVY.modified(adaptation=KNOWN), "adaptive")
    again.state_from_json(text)
    np.testing.assert_array_equal(again.learnt_map.factor, controller.learnt_map.factor)
    other = make_controller(WAVY.modified(adaptation={"position_periods": [0.4]}), "adaptive")
    with pytest.raises(ValueError, match="friction_map"):
        other.state_from_json(text)
    saved = json.loads(text)
    saved["state"]["estimator"]["friction_map"]["share"] = 2.0
    with pytest.raises(ValueError, match="share"):
        again.state_from_json(json.dumps(saved))


def test_a_lost_position_holds_the_last_one():
    controller = make(**KNOWN)
    for k in range(50):
        controller.step(0.1, 0.1, position=0.001 * k)
    assert math.isfinite(controller.step(0.1, 0.1, position=math.nan))
    assert controller.state.estimator.friction_map.signals[0, 2] == 0.049


def test_the_motors_turn_is_a_period_of_the_scenario():
    scenario = SHORT.modified(joint={"gear_ratio": 100.0}, adaptation={"motor_turn": True})
    assert scenario.friction_periods == [2.0 * math.pi / 100.0]
    with pytest.raises(ValueError, match=r"joint\.gear_ratio is missing"):
        SHORT.modified(adaptation={"motor_turn": True})


def test_friction_under_a_known_torque_is_found_and_told():
    parameters = map_parameters((), 0, None, 60.0, 2.0)
    mean = 200.0 / math.pi

    def torque(angle):
        return 100.0 * math.sin(math.pi * angle)

    state = learn_by_hand(parameters, lambda angle: 0.003 * (abs(torque(angle)) - mean), torque=torque)
    learnt = read_map(parameters, state)
    assert state.share == 1.0
    assert state.load == pytest.approx(mean, rel=0.05)
    assert learnt.load_share == pytest.approx(0.003 / (1.0 - 0.003 * mean), rel=0.1)
    assert list(map_sentences(learnt)) == ["Friction rises by 0.37 % for each N m of known torque."]


def test_gravity_that_is_identified_is_a_known_torque():
    geared = {"joint": {"gravity": 100.0}, "variation": {"load_share": 0.005}, "adaptation": {"identify": "gravity"}}
    loaded = SHORT.modified(**geared)
    _, controller = run(loaded, load_friction=True)
    learnt = controller.state.estimator.friction_map
    assert 20.0 < learnt.load < 100.0
    assert learnt.coefficients[0] > 0.0


def test_the_map_is_drawn_beside_the_truth(known):
    from adaptive_ff.comparison.comparison import Comparison

    figures = plot_comparison(Comparison(WAVY, {"adaptive": known[0]}))
    assert len(figures["friction_map"].axes[0].lines) == 2
    assert "friction_map" not in plot_comparison(Comparison(SHORT, {"pi": simulate(SHORT, "pi")}))
