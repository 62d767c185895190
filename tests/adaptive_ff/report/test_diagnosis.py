"""What the adaptive controller says of itself."""

import io
import itertools
import json
import math
import re
from dataclasses import asdict

import numpy as np
import pytest
from closed_loops import SCENARIO, course_along, drive, lay_course, make
from rich.console import Console

from adaptive_ff import AdaptiveController, simulate
from adaptive_ff.adaptive.controller import UnsupervisedController
from adaptive_ff.friction.model import ESTIMATED, PER_DIRECTION, WITH_OFFSET
from controllers import pi_gains
from plant import Joint


def worked(scenario=SCENARIO):
    controller = make("adaptive", scenario)
    return controller, simulate(scenario, controller)


def along(reference, name="adaptive", **more):
    """A controller that went along a reference on the grid of 1 ms, at 100 Hz."""
    controller = make(name)
    drive(controller, course_along(reference, substeps=10, noise=0.002, **more))
    return controller


def test_settled_on_the_built_in_joint_all_is_well():
    controller, run = worked()
    found = controller.diagnose(run)
    assert found.learning
    assert found.excited
    assert found.warnings == ()
    assert found.learnt == controller.state.estimator.levels.learnt > 40.0
    assert [one.name for one in found.parameters] == [*WITH_OFFSET, "stribeck_velocity", "presliding"]
    assert {one.name: one.estimate for one in found.parameters} == controller.estimates
    assert {one.name: one.uncertainty for one in found.parameters} == controller.uncertainties
    assert all(4.0 <= one.pace < 8.0 for one in found.parameters[:-2])
    assert found.model_torque + found.feedback_torque == controller.state.feedback.commands[0]
    assert found.model_torque == run.feedforward[-1]
    assert found.feedforward_lag == controller.feedforward_lag > controller.estimates["friction_lag"]
    assert f"a lag of {1e3 * found.feedforward_lag:.3g} ms" in str(found)
    half = run.torque.size // 2
    feedback = (run.torque - run.feedforward)[half:]
    assert found.feedback_share == pytest.approx(np.linalg.norm(feedback) / np.linalg.norm(run.torque[half:]))
    assert found.feedback_share < 0.1


def test_unexplained_torque_is_that_of_the_equations():
    """Twice the noise makes it twice as large; without noise it is small."""
    found = {}
    for noise in (0.0, 0.002, 0.004):
        found[noise] = worked(SCENARIO.modified(sensor={"velocity_noise": noise}))[0].diagnose().unexplained
    assert found[0.0] < 0.5
    assert found[0.004] == pytest.approx(2.0 * found[0.002], rel=0.2)


def test_asking_changes_nothing_and_is_possible_at_any_time():
    controller, course = make("adaptive"), lay_course(SCENARIO.modified(duration=3.0))
    for k, first in enumerate(course.samples[:-1]):
        if k % 10 == 0:
            before, ranges = controller.state_to_json(), controller.parameters.estimator.ranges.copy()
            controller.diagnose().sentences()
            assert controller.state_to_json() == before
            assert np.array_equal(controller.parameters.estimator.ranges, ranges)
        controller.step(course.reference[first], course.reference[first] + course.noise[k])


def test_a_new_controller_knows_nothing():
    found = make("adaptive").diagnose()
    assert not found.learning
    assert not found.excited
    assert found.learnt == found.unexplained == 0.0
    assert found.feedback_share is None
    assert found.warnings == ()
    assert all(one.verdict == "not identifiable" and one.pace == math.inf for one in found.parameters)
    assert "Has not made a step yet" in str(found)


def test_it_says_why_it_holds_its_estimates():
    controller, _ = worked()
    controller.enabled = False
    assert controller.diagnose().learning_words == "Holds its estimates: enabled is False."
    slow = along(np.zeros(20_001))
    assert slow.diagnose().learning_words.startswith("Holds its estimates: the joint is slower than 0.01 rad/s")
    soon = along(np.full(21, 0.1))
    assert "must do so for 0.0" in soon.diagnose().learning_words
    assert not any(one.diagnose().learning for one in (controller, slow, soon))


def test_at_standstill_it_warns_that_there_is_nothing_to_learn_from_only_after_a_while():
    assert along(np.zeros(5_001)).diagnose().warnings == ()
    (warning,) = along(np.zeros(20_001)).diagnose().warnings
    assert warning.startswith("in 20 s there was nothing to learn from: the joint never slid faster than 0.01 rad/s")


@pytest.mark.parametrize(
    ("name", "combined", "silent"),
    [
        ("adaptive_unsupervised", "coulomb, stiction and viscous", "inertia and friction_lag"),
        (
            "adaptive",
            "coulomb, stiction, viscous and offset",
            "inertia, friction_lag, stribeck_velocity and presliding",
        ),
    ],
)
def test_constant_speed_identifies_friction_as_a_whole_only(name, combined, silent):
    found = along(np.concatenate([np.linspace(0.0, 0.2, 1000), np.full(60_001, 0.2)]), name).diagnose()
    verdicts = {one.name: one.verdict for one in found.parameters}
    assert verdicts["inertia"] == verdicts["friction_lag"] == "not identifiable"
    assert verdicts["coulomb"] == verdicts["viscous"] == "only in combination"
    assert not found.excited
    text = "\n".join(found.sentences())
    assert f"does not identify {silent}: do not rely on these numbers." in text
    assert f"identifies a combination of {combined}, but not each of them." in text
    assert any("hardly shows the friction lag" in warning for warning in found.warnings)


def test_measurements_that_were_lost_are_counted():
    course, controller = lay_course(SCENARIO), make("adaptive")
    noise = course.noise.copy()
    noise[500:2000:50] = math.nan
    drive(controller, course._replace(noise=noise))
    found = controller.diagnose()
    assert found.rejected == 30
    assert found.warnings == ("30 measurements of 6000 were not finite and skipped.",)


@pytest.mark.parametrize(("assumed", "ratio"), [(12.0, "1.7"), (34.0, "0.59")])
def test_an_inertia_far_from_the_assumed_one_is_reported(assumed, ratio):
    (warning,) = worked(SCENARIO.modified(feedback={"inertia": assumed, "bandwidth": 5.0}))[0].diagnose().warnings
    assert warning.startswith(f"the inertia is {ratio} times the {assumed:g} kg m²")


def test_friction_that_varies_with_the_position_is_a_model_that_does_not_fit():
    scenario = SCENARIO.modified(variation={"position_amplitude": 0.8, "position_period": 0.2})
    (warning,) = (text for text in worked(scenario)[0].diagnose().warnings if text.startswith("the model leaves "))
    assert "the model does not suit the joint" in warning


def altered(**estimates):
    """A settled controller with other estimates."""
    controller, _ = worked()
    for name, value in estimates.items():
        controller.state.estimator.recursion.estimate[ESTIMATED.index(name)] = value
    return controller.diagnose().warnings


def test_stiction_clearly_below_coulomb_friction_is_implausible():
    assert altered(stiction=59.5) == ()
    (warning,) = altered(stiction=50.0)
    assert re.match(r"friction rises from 50 N m at standstill to (59\.\d|6\d(\.\d)?) N m", warning)


@pytest.mark.parametrize(
    ("estimates", "said"),
    [
        ({"viscous": 0.0}, "viscous is at the least value that is assumed possible, 0 N m s/rad."),
        (
            {"friction_lag": 1.0 / (2.0 * math.pi)},
            "friction_lag is at the largest value that is assumed possible, 0.159 s.",
        ),
        ({"inertia": 2.0}, "inertia is at the least value that is assumed possible, 2 kg m²."),
    ],
)
def test_a_parameter_at_its_bound_is_reported_also_after_a_restart(estimates, said):
    assert said in altered(**estimates)
    old, _ = worked()
    for name, value in estimates.items():
        old.state.estimator.recursion.estimate[ESTIMATED.index(name)] = value
    new = make("adaptive")
    new.state_from_json(old.state_to_json())
    assert new.diagnose() == old.diagnose()


def test_motion_that_does_not_resemble_its_model_is_reported():
    controller, _ = worked()
    controller.state.estimator.agreement[1, 1] *= 2.0
    (warning,) = controller.diagnose().warnings
    assert warning.startswith("measured and modelled motion differ in what shows coulomb (")


def test_young_estimates_are_called_so():
    scenario = SCENARIO.modified(duration=6.0)
    assert "Young: up to 10 s" in str(worked(scenario)[0].diagnose())
    assert "Young" not in str(worked()[0].diagnose())


def test_friction_per_direction_has_its_rows():
    controller = UnsupervisedController(
        *pi_gains(20.0, 10.0), period=0.01, inertia=20.0, stribeck_velocity=0.05, parameters=PER_DIRECTION
    )
    drive(controller, lay_course(SCENARIO))
    found = controller.diagnose()
    assert [one.name for one in found.parameters] == list(PER_DIRECTION)
    assert found.excited
    assert "stiction_asymmetry, N m" in str(found)


def test_the_text_is_what_a_terminal_shows():
    controller, run = worked()
    found = controller.diagnose(run)
    console = Console(width=120, record=True, file=io.StringIO())
    console.print(found)
    assert console.export_text().strip("\n").split() == str(found).split()
    assert max(map(len, str(found).splitlines())) <= 120


@pytest.mark.parametrize("torque", [np.zeros(0), np.zeros((2, 2)), np.zeros(3)])
def test_series_of_a_run_that_do_not_fit_are_refused(torque):
    class Recorded:
        feedforward = np.zeros(2)

    Recorded.torque = torque
    with pytest.raises(ValueError, match=r"^torque has shape .* must be series of one length"):
        make("adaptive").diagnose(Recorded())


def test_it_can_be_saved_as_json():
    controller, run = worked()
    saved = json.loads(json.dumps(asdict(controller.diagnose(run))))
    assert saved["parameters"][1]["name"] == "coulomb"


@pytest.mark.parametrize(("missed", "reason"), [(0.0, "would have left more error"), (1.0, "the model does not fit")])
def test_it_says_why_friction_is_distrusted(missed, reason):
    """By the prediction, or, where the bound by the error that there is is the lower one, by that."""
    controller, _ = worked(SCENARIO.modified(duration=20.0))
    state = controller.state
    controller.state = state._replace(trust=state.trust._replace(trust=0.4, missed=missed * state.trust.xx))
    (said,) = (line for line in controller.diagnose().supervision if "is fed forward" in line)
    assert said.startswith("Only 40 % of the identified friction is fed forward")
    assert reason in said


def beside_a_limit(kind, peak, **told):
    """A controller that has moved a joint for 40 s with a drive of 120 N m, which tells nothing of its torque."""
    controller = kind(*pi_gains(20.0, 10.0), period=0.01, inertia=20.0, stribeck_velocity=0.05, **told)
    joint, plan = Joint(SCENARIO.joint), [peak * math.sin(0.5 * math.pi * 0.01 * k) for k in range(4001)]
    for reference, following in itertools.pairwise(plan):
        torque = controller.step(reference, joint.state.velocity, next_reference=following)
        joint.step(max(-120.0, min(120.0, torque)), 0.01)
    return controller


@pytest.mark.parametrize("peak", [0.8, 0.9, 1.2])
@pytest.mark.parametrize("told", [{}, {"torque_limit": 120.0}])
def test_it_asks_for_the_torque_limit_of_a_drive_that_saturates_untold(told, peak):
    said = [line for line in beside_a_limit(AdaptiveController, peak, **told).diagnose().warnings if "saturate" in line]
    assert len(said) == (0 if told else 1)
    assert all("Nothing is learnt from such torque" in line for line in said)


def test_without_supervision_it_says_that_such_torque_is_learnt_from():
    controller = beside_a_limit(UnsupervisedController, 1.2)
    assert controller.estimates["stiction"] > 1000.0  # of 90
    assert any("the estimates are of torque that never acted" in line for line in controller.diagnose().warnings)


def test_it_says_where_the_loop_is_soft_for_the_friction():
    light = {"inertia": 2.0}
    slow = SCENARIO.modified(duration=20.0, reference={"peak": 0.0125}, joint=light, feedback=light)
    controller, run = worked(slow)
    (said,) = (line for line in controller.diagnose().supervision if "soft for this friction" in line)
    assert "at most 0 % of friction and observed torque" in said
    pi = simulate(slow, "pi")
    assert run.metrics.rms_error < 1.1 * pi.metrics.rms_error
