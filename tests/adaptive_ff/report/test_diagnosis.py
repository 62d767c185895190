"""What the adaptive controller says of itself: data with codes, and words made of them."""

import json
import math
from dataclasses import asdict

import numpy as np
import pytest
from closed_loops import SCENARIO, build_setup, drive, make, setup_along
from exports import adaptive

from adaptive_ff import PER_DIRECTION, simulate
from adaptive_ff.adaptive.diagnosis import WARNINGS, Code
from adaptive_ff.report.diagnosis import SENTENCES, sentence, sentences


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
        ({}, {}, {Code.TORQUE_UNKNOWN, Code.PLAN_UNKNOWN}),
        ({"torque_limit": 400.0}, {}, {Code.PLAN_UNKNOWN}),
        ({}, {"realised_torque": 1.0}, {Code.PLAN_UNKNOWN}),
        ({"torque_limit": 400.0}, {"next_reference": 0.1}, set()),
    ],
)
def test_it_asks_for_what_is_the_users_to_give(options, given, codes):
    controller = adaptive(**options)
    for _ in range(10):
        controller.step(0.1, 0.1, **given)
    assert controller.diagnose().codes & {Code.TORQUE_UNKNOWN, Code.PLAN_UNKNOWN} == codes


def test_it_counts_what_it_skipped():
    controller = adaptive(torque_limit=400.0)
    for k in range(10):
        controller.step(0.1, math.nan if k % 2 else 0.1, next_reference=0.1, position=1e300)
    values = {one.code: one.values for one in controller.diagnose().findings}
    assert values[Code.MEASUREMENTS_LOST] == {"lost": 5.0, "samples": 10.0}
    assert values[Code.INPUTS_IMPLAUSIBLE]["samples"] == 10.0


def test_it_says_that_nothing_moved_or_that_it_holds_its_estimates():
    controller = adaptive(torque_limit=400.0)
    controller.enabled = False
    for _ in range(1100):
        controller.step(0.0, 0.0, next_reference=0.0)
    assert {Code.HELD, Code.NO_MOTION} <= controller.diagnose().codes


def test_a_weight_is_not_known_without_a_position(worked):
    controller = make("adaptive")
    drive(controller, setup_along(SCENARIO.modified(duration=10.0).reference_velocity(), substeps=10, noise=0.002))
    assert Code.NO_POSITION in controller.diagnose().codes
    assert Code.NO_POSITION not in worked.diagnose().codes


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_an_inertia_far_from_the_assumed_one_is_told(factor):
    scenario = SCENARIO.modified(feedback={"inertia": factor * SCENARIO.joint.inertia})
    controller = make("adaptive", scenario)
    simulate(scenario, controller)
    (finding,) = (one for one in controller.diagnose().findings if one.code == Code.INERTIA_FAR)
    assert finding.values["ratio"] == pytest.approx(1.0 / factor, rel=0.15)
    assert "that the feedback was designed for" in sentence(finding)


def test_innovations_that_are_not_white_are_told(worked):
    assert Code.INNOVATIONS_COLOURED not in worked.diagnose().codes
    controller = make("adaptive")
    controller.state_from_json(worked.state_to_json())
    watch = controller.state.watch
    controller.state = controller.state._replace(watch=watch._replace(product=0.9 * watch.square))
    (found,) = (one for one in controller.diagnose().findings if one.code == Code.INNOVATIONS_COLOURED)
    assert found.values["correlation"] == pytest.approx(0.9)
    assert "correlated by 0.90" in sentence(found)


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
