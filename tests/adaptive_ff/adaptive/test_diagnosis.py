"""What the adaptive controller says of itself: data with codes, and words made of them."""

import json
import math
from dataclasses import asdict

import numpy as np
import pytest
from closed_loops import SCENARIO, build_setup, drive, make, setup_along
from exports import adaptive

from adaptive_ff import PER_DIRECTION, AdaptiveController, simulate
from adaptive_ff.adaptive.diagnosis import WARNINGS, Code
from adaptive_ff.learning.kalman import LOOP
from adaptive_ff.report.diagnosis import SENTENCES, sentence, sentences
from controllers import pi_gains
from controllers.arrays import packed


@pytest.fixture(scope="module")
def worked():
    controller = make("adaptive")
    simulate(SCENARIO, controller)
    return controller


def test_it_says_what_the_controller_estimates_and_how_surely(worked):
    found = worked.diagnose()
    assert {one.name: one.estimate for one in found.parameters} == worked.estimates
    assert {one.name: one.uncertainty for one in found.parameters} == worked.uncertainties
    learnt = {one.name: one.learnt for one in found.parameters}
    assert all(learnt[name] < 0.3 for name in ("inertia", "coulomb", "stiction", "viscous"))
    assert "coulomb" not in [name for one in found.findings if one.code == Code.NOT_LEARNT for name in one.names]
    assert found.moved > 40.0


def test_asking_changes_nothing_and_is_possible_at_any_time():
    controller, setup = make("adaptive"), build_setup(SCENARIO.modified(duration=3.0))
    for k, first in enumerate(setup.samples[:-1]):
        if k % 30 == 0:
            before = controller.state_to_json()
            sentences(controller.diagnose())
            assert controller.state_to_json() == before
        controller.step(setup.reference[first], setup.reference[first] + setup.noise[k])


def test_a_new_controller_knows_nothing():
    found = make("adaptive").diagnose()
    assert found.moved == 0.0
    assert all(one.learnt == 1.0 or one.uncertainty == 0.0 for one in found.parameters)


@pytest.mark.parametrize(
    ("options", "given", "codes"),
    [
        ({"torque_limit": None}, {}, {Code.TORQUE_UNKNOWN, Code.PLAN_UNKNOWN}),
        ({"torque_limit": math.inf}, {}, {Code.PLAN_UNKNOWN}),
        ({"torque_limit": 400.0}, {}, {Code.PLAN_UNKNOWN}),
        ({"torque_limit": None}, {"realised_torque": 1.0}, {Code.PLAN_UNKNOWN}),
        ({"torque_limit": 400.0}, {"next_reference": 0.1}, set()),
        ({"torque_limit": 400.0, "integral": 0.0}, {"next_reference": 0.1}, {Code.NO_INTEGRAL}),
    ],
)
def test_it_asks_for_what_is_the_users_to_give(options, given, codes):
    gains = dict(zip(("proportional", "integral"), pi_gains(20.0, 10.0), strict=True))
    controller = AdaptiveController(**{**gains, "period": 0.01, "inertia": 20.0, "stribeck_velocity": 0.05, **options})
    for _ in range(10):
        controller.step(0.1, 0.1, **given)
    assert controller.diagnose().codes & {Code.TORQUE_UNKNOWN, Code.PLAN_UNKNOWN, Code.NO_INTEGRAL} == codes


def test_it_counts_what_it_skipped():
    controller = adaptive(torque_limit=400.0)
    for k in range(10):
        controller.step(0.1, math.nan if k % 2 else 0.1, next_reference=0.1, position=1e300)
    values = {one.code: one.values for one in controller.diagnose().findings}
    assert values[Code.MEASUREMENTS_LOST] == {"lost": 5.0, "samples": 10.0}
    assert values[Code.INPUTS_IMPLAUSIBLE]["samples"] == 10.0


def test_a_weight_is_not_known_without_a_position(worked):
    controller = make("adaptive")
    drive(controller, setup_along(SCENARIO.modified(duration=10.0).reference_velocity(), substeps=10, noise=0.002))
    assert Code.NO_POSITION in controller.diagnose().codes
    assert Code.NO_POSITION not in worked.diagnose().codes


WORDS = {Code.INERTIA_FAR: "that the feedback was designed for", Code.INNOVATIONS_COLOURED: "correlated by -0.60"}
QUIET = {"moved": 20.0, "square": 0.5, "product": 0.2, "torque_known": True, "plan_known": True}


@pytest.mark.parametrize(
    ("samples", "watch", "changes", "code", "values"),
    [
        (1001, {"moved": 0.0}, {}, Code.NO_MOTION, {"time": 10.01}),
        (1000, {"moved": 0.0}, {}, None, None),
        (2000, {"product": -0.3}, {}, Code.INNOVATIONS_COLOURED, {"correlation": -0.6}),
        (2000, {"product": -0.3, "moved": 10.0}, {"weight": 0.6}, None, None),
        (2000, {"product": 0.25}, {"weight": 0.5, "inertia": (50.0, 15.0)}, None, None),
        (2000, {}, {"weight": 0.6}, Code.JUST_CHANGED, {"probability": 0.6}),
        (2000, {}, {"enabled": False}, Code.HELD, {}),
        (2000, {}, {"inertia": (40.0, 5.0)}, Code.INERTIA_FAR, {"ratio": 2.0, "assumed": 20.0}),
        (2000, {}, {"inertia": (10.0, 3.3)}, Code.INERTIA_FAR, {"ratio": 0.5, "assumed": 20.0}),
        (2000, {}, {"inertia": (200.0, 95.0)}, Code.AT_BOUND, {"value": 200.0}),
        (2000, {}, {"stribeck_velocity": (0.5 + 1e-9, 0.1)}, Code.AT_BOUND, {"value": 0.5}),
        (2000, {}, {"coulomb": (71.0, 3.0), "stiction": (60.0, 4.0)}, Code.FRICTION_RISES, {"from": 60.0, "to": 71.0}),
        (2000, {}, {"coulomb": (70.0, 3.0), "stiction": (60.0, 4.0)}, None, None),
        (2000, {}, {"viscous": (0.0, 260.0)}, Code.NOT_LEARNT, {}),
        (2000, {}, {"stribeck_velocity": (0.05, 0.2)}, Code.NOT_LEARNT, {}),
    ],
)
def test_each_finding_has_its_threshold(samples, watch, changes, code, values):
    """Estimates are given with their deviation; all others are learnt."""
    sides = {"inertia": 20.0, "friction_lag": 0.02, "coulomb": 60.0, "stiction": 60.0}
    controller = adaptive(model=sides, deviation=1e3)
    state, places = controller.state, {"inertia": 0, "viscous": 1, "coulomb": 2, "stiction": 3}
    places |= {"friction_lag": -2, "stribeck_velocity": -1}
    deviations = np.zeros(state.estimate.mean.size)
    for name in places.keys() & changes:
        value, deviations[LOOP:][places[name]] = changes[name]
        state.estimate.mean[LOOP:][places[name]] = math.log(value) if places[name] < 0 else value
    state.estimate.covariance[:] = packed(np.diag(deviations**2))
    begun, watched = state.feedback._replace(samples=samples), state.watch._replace(**QUIET | watch)
    told = {"weight": changes.get("weight", 0.1), "enabled": changes.get("enabled", True)}
    controller.state = state._replace(feedback=begun, watch=watched, **told)
    found = controller.diagnose()
    assert [(one.code, one.values) for one in found.findings] == ([(code, pytest.approx(values))] if code else [])
    assert found.change_probability == controller.state.weight
    assert set(found.findings[0].names if code else ()) <= set(changes)
    assert WORDS.get(code, "") in " ".join(map(sentence, found.findings))


def test_every_code_has_a_sentence_and_every_finding_can_be_put_into_words(worked):
    assert set(SENTENCES) == set(Code)
    assert set(Code) >= WARNINGS
    found = worked.diagnose()
    assert len(sentences(found)) >= len(found.findings)
    assert max(map(len, str(found).splitlines())) <= 120
    assert "coulomb, N m" in str(found)


def test_friction_per_direction_has_its_rows_and_all_can_be_saved_as_json():
    controller = adaptive(parameters=PER_DIRECTION, torque_limit=400.0, position_hats=3)
    drive(controller, build_setup(SCENARIO.modified(duration=10.0)))
    found = controller.diagnose()
    assert "stiction_asymmetry, N m" in str(found)
    saved = json.loads(json.dumps(asdict(found), default=np.ndarray.tolist))
    assert saved["parameters"][1]["name"] == "coulomb"
