"""What the loop itself does: when a command acts, what the drive reports, when samples are taken, what is measured.

A joint that changes is stepped by hand under the torque that the loop gave.
"""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO, drive, make, run_compiled

from adaptive_ff import load_scenario, simulate
from adaptive_ff.comparison.own import own_controller
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.simulation.experiment import build_setup, empty_record
from adaptive_ff.simulation.loop import is_plain, run_plain, start_position
from adaptive_ff.simulation.metrics import rms
from plant import Joint, JointModel, gravity_torque, initial_state, step_joint

SHORT = SCENARIO.modified(duration=6.0)


class Script:
    """Gives torques from a list and writes down what it is given."""

    def __init__(self, torques):
        self.torques, self.given = iter(torques), []

    def step(self, reference, velocity, **given):
        self.given.append(given)
        return next(self.torques)


def run_script(setup, torques):
    """Run a list of torques; return the record and what the controller was given."""
    script, record = Script(torques), empty_record(setup, 0)
    run_plain(own_controller(script), None, setup, start_position(setup), setup.noise.size, record)
    return record, script.given


def delayed(steps, samples=40):
    """Run set-up of the built-in joint at 100 Hz with a delay in solver steps."""
    return build_setup(SCENARIO.modified(duration=samples / 100))._replace(delay=steps)


@pytest.mark.parametrize("steps", [0, 1, 3, 10, 17, 25])
def test_a_command_acts_from_the_delay_on_until_the_next_one_does(steps):
    torques = 300.0 * np.sin(np.arange(40.0))
    setup = delayed(steps)
    record, given = run_script(setup, torques)
    reported = [one["realised_torque"] for one in given]
    held = np.concatenate([np.zeros(steps), np.repeat(torques, 10)])[:400]
    joint = Joint(SCENARIO.joint)
    expected = [0.0, *(joint.step(torque, 0.001) for torque in held)]
    assert np.array_equal(record.velocity, expected)
    assert record.given == pytest.approx(torques, rel=1e-14)
    assert record.torque == pytest.approx(held.reshape(-1, 10).mean(axis=1), rel=1e-12, abs=1e-12)
    assert reported[0] is None
    assert reported[1:] == pytest.approx(record.torque[:-1].tolist(), rel=1e-14)


def test_a_drive_without_delay_gives_what_it_is_told_whatever_friction_does():
    variation = {"position_amplitude": 0.2, "position_period": 2.0}
    torques = 300.0 * np.sin(np.arange(40.0))
    record, _ = run_script(build_setup(SCENARIO.modified(duration=0.4, variation=variation)), torques)
    assert record.torque.tolist() == record.given.tolist() == torques.tolist()


@pytest.mark.parametrize("part", [1, 7])
def test_parts_of_a_delayed_run_make_no_difference(part):
    setup = delayed(17)._replace(noise=0.01 * np.cos(np.arange(40.0)))
    whole, pieces = empty_record(setup, 0), empty_record(setup, 0)
    block = make("pi")
    run_compiled(block.parameters, block.state, setup, start_position(setup), 40, whole)
    state, position = block.state, start_position(setup)
    while position.sample < 40:
        stop = min(position.sample + part, 40)
        state, position = run_compiled(block.parameters, state, setup, position, stop, pieces)
    assert np.array_equal(whole.velocity, pieces.velocity)
    assert np.ptp(whole.velocity) > 0.01


@pytest.fixture(scope="module")
def dragged():
    """A joint dragged at nearly constant speed, and its run under PI."""
    slow = {"frequencies": [0.001], "amplitudes": [1.0], "peak": 0.3, "fade_in": 1.0}
    base = SCENARIO.modified(duration=30.0, reference=slow, sensor={"velocity_noise": 0.0}, sampling={"period": 0.001})
    return base, simulate(base, "pi")


def test_drift_and_position_change_the_friction_that_acts(dragged):
    """What the drive must give follows the factor on friction."""
    base, plain = dragged
    warming = simulate(base.modified(variation={"warm_up_excess": 0.5, "warm_up_time": 20.0}), "pi")
    wavy = simulate(base.modified(variation={"position_amplitude": 0.2, "position_period": 2.0}), "pi")
    late = plain.time > 5.0
    drag = plain.torque[late]
    factor = 1.0 + 0.5 * np.exp(-plain.time[late] / 20.0)
    assert warming.torque[late] == pytest.approx(factor * drag, rel=0.01)
    position = np.cumsum(wavy.velocity[:-1]) * 0.001
    assert wavy.torque[late] == pytest.approx((1.0 + 0.2 * np.sin(np.pi * position[late])) * drag, rel=0.01)
    assert np.ptp(wavy.torque[late] / drag) > 0.35


def test_load_and_heat_change_the_friction_that_acts(dragged):
    """The same joint under a load, and with friction that heats it."""
    (base, plain), late = dragged, 5000
    drag, velocity = plain.torque, plain.velocity[:-1]
    loaded = simulate(base.modified(change=[{"time": 1.0, "load": -20.0}], variation={"load_share": 0.01}), "pi")
    assert loaded.torque[late:] == pytest.approx(1.2 * drag[late:] - 20.0, rel=0.01)
    heats = {"thermal_resistance": 4.0, "thermal_time": 20.0, "thinning": 0.01}
    warmth, factors = 0.0, []
    for power in (drag * velocity).tolist():
        factors.append(math.exp(-0.01 * warmth))
        warmth += 0.001 / 20.0 * (4.0 * power * factors[-1] - warmth)
    hot = simulate(base.modified(variation=heats), "pi")
    assert hot.torque[late:] == pytest.approx((np.array(factors) * drag)[late:], rel=0.01)
    assert factors[-1] < 0.75


@pytest.mark.parametrize(
    "variation",
    [{"load_share": 0.01}, {"thermal_resistance": 4.0, "thermal_time": 5.0, "thinning": 0.02}],
    ids=["load", "heat"],
)
def test_oracle_knows_friction_that_depends_on_load_and_heat(variation):
    scenario = SCENARIO.modified(duration=20.0, joint={"gravity": 60.0}, variation=variation)
    error, of_pi = (simulate(scenario, name).metrics.rms_error_settled for name in ("oracle", "pi"))
    assert error < 0.25 * of_pi
    ignorant = make("oracle", scenario.modified(variation={**dict.fromkeys(variation, 0.0), "thermal_time": 5.0}))
    assert error < 0.7 * simulate(scenario, ignorant).metrics.rms_error_settled


def test_jittered_samples_have_the_outliers_of_the_papers_figure_10_and_keep_the_mean():
    scenario = SCENARIO.modified(duration=100.0, sampling={"period": 0.022, "jitter": 0.9}, feedback={"bandwidth": 5.0})
    intervals = np.diff(scenario.sample_steps)
    assert np.mean(intervals) == pytest.approx(22.0, abs=0.05)
    assert set(intervals) <= {20, 21, 31, 32, 41, 42}
    assert set(intervals) >= {20, 21, 32}
    late = np.nonzero(intervals > 40)[0]
    assert np.all(np.diff(late) == 40)  # one nearly twice as long in forty, periodic
    assert np.count_nonzero(intervals > 30) == pytest.approx(3 * intervals.size / 40, abs=3)
    run = simulate(scenario, "adaptive")
    assert run.columns()["time"] == pytest.approx(scenario.sample_steps[:-1] * 0.001)
    assert run.metrics.rms_error_settled < 0.5 * simulate(scenario, "pi").metrics.rms_error_settled


def test_jitter_passes_the_real_time_to_the_controller():
    scenario = SCENARIO.modified(duration=5.0, sampling={"jitter": 0.9})
    setup = build_setup(scenario)
    _, given = run_script(setup, np.zeros(setup.noise.size))
    intervals = (np.diff(scenario.sample_steps)[:-1] * 0.001).tolist()
    assert [one["dt"] for one in given[1:]] == pytest.approx(intervals, rel=1e-12)


def test_encoder_shows_the_controller_multiples_of_its_resolution_only():
    resolution = 1e-3
    coarse = SCENARIO.modified(
        duration=3.0,
        sensor={"velocity_noise": 0.0, "encoder_resolution": resolution},
        velocity={"method": "difference"},
    )
    run = simulate(coarse, "pi")
    counts = run.measured[1:] * 0.01 / resolution
    assert counts == pytest.approx(np.round(counts), abs=1e-6)
    assert np.unique(np.round(counts)).size > 3


def test_pause_is_a_standstill_inside_the_motion():
    scenario = SCENARIO.modified(duration=40.0, reference={"pause": [15.0, 25.0]})
    velocity, time = scenario.reference_velocity(), scenario.times()
    unbroken = SCENARIO.modified(duration=40.0).reference_velocity()
    assert np.all(velocity[(time >= 15.0) & (time <= 25.0)] == 0.0)
    outside = (time < 13.0) | (time > 27.0)
    assert np.array_equal(velocity[outside], unbroken[outside])
    assert np.max(np.abs(np.diff(velocity))) < 1.5 * np.max(np.abs(np.diff(unbroken)))


def everything(size=1.0):
    """Return a scenario with everything at once, whose torques are smaller by a factor; heat resists more."""
    torques = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "gravity": 40.0}
    return SCENARIO.modified(
        duration=2.0,
        joint={name: torque / size for name, torque in torques.items()},
        sampling={"jitter": 0.9},
        sensor={"ripple_amplitude": 1e-4, "ripple_period": 0.02},
        feedback={"bandwidth": 5.0, "inertia": 20.0 / size},
        actuator={
            **{"delay": 0.004, "lag": 0.002, "gain": 0.9, "torque_limit": 300.0 / size, "rate_limit": 2e4 / size},
            **{"torque_resolution": 0.5 / size, "ripple_amplitude": 2.0 / size},
        },
        variation={
            **{"warm_up_excess": 0.4, "position_amplitude": 0.2, "load_share": 0.01 * size},
            **{"thermal_resistance": 0.5 * size, "thermal_time": 3.0, "thinning": 0.1},
        },
        change=[{"time": 1.0, "friction_scale": 0.7, "load": 10.0 / size}],
    )


def test_loop_serves_its_compiled_and_plain_form_alike_with_everything_at_once():
    setup, controller, other = build_setup(everything()), make("adaptive", everything()), make("adaptive", everything())
    plain, _ = drive(controller, setup, run=run_plain)
    fast, _ = drive(other, setup)
    assert np.array_equal(plain.torque, fast.torque)
    assert np.array_equal(plain.velocity, fast.velocity)
    assert np.ptp(fast.velocity) > 0.1


def test_what_acts_on_a_joint_of_small_torques_is_that_of_a_large_one_to_the_bit():
    """In units that are powers of two, whose arithmetic is exact."""
    large = simulate(everything(), "pi")
    for size in (2.0**-6, 2.0**8):
        other = simulate(everything(size), "pi")
        assert np.array_equal(other.velocity, large.velocity)
        assert np.array_equal(size * other.torque, large.torque)


def test_a_sensor_that_ripples_shows_it_in_velocity_and_position_alike():
    ripple = {"ripple_amplitude": 1e-4, "ripple_period": 0.02}
    scenario = SHORT.modified(duration=2.0, sensor={"velocity_noise": 0.0, **ripple})
    setup = build_setup(scenario)
    record, _ = drive(make("pi"), setup)
    velocity, position = (series[setup.samples[:-1]] for series in (record.velocity, record.position))
    expected = velocity * (1.0 + 1e-4 * 100.0 * np.pi * np.cos(100.0 * np.pi * position))
    assert record.measured == pytest.approx(expected, abs=1e-12)
    assert np.max(np.abs(record.measured - velocity)) > 0.02 * np.max(np.abs(velocity))
    encoder = SHORT.modified(
        duration=2.0,
        sensor={"velocity_noise": 0.0, "encoder_resolution": 1e-7, **ripple},
        velocity={"method": "difference"},
    )
    setup = build_setup(encoder)
    record, _ = drive(make("pi", encoder), setup)
    position = record.position[setup.samples[:-1]]
    angle = position + 1e-4 * np.sin(100.0 * np.pi * position)
    assert record.measured[1:] == pytest.approx(np.diff(angle) / encoder.sampling.period, abs=2e-5)


def test_a_record_without_place_for_monitors_is_not_written_beyond():
    """Compiled code checks no bounds: such a row would be written past its end."""
    setup, controller = build_setup(SHORT.modified(duration=2.0)), make("adaptive")
    assert controller.monitor_names
    behind = np.full((setup.noise.size + 1, 3), 7.0)
    record = empty_record(setup, len(controller.estimate_names))._replace(monitors=behind[:-1, :0])
    run_compiled(controller.parameters, controller.state, setup, start_position(setup), setup.noise.size, record)
    assert np.all(behind == 7.0)


BASE = load_scenario().modified(duration=6.0)
FIELDS = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05}


def stepped(run, before, after, change, *, gain=1.0):
    """True velocity under the recorded torque and a weight; ``after`` is in force from ``change`` s."""
    period = before.solver_period
    state, velocity = initial_state(before.parameters, float(run.reference[0])), []
    for command in np.repeat(run.torque, 10):
        velocity.append(state.velocity)
        joint = before if len(velocity) <= round(change / period) else after
        torque = gain * command - gravity_torque(joint.weight, state.position)
        state = step_joint(joint.parameters, state, torque, period)
    return np.array([*velocity, state.velocity])


@pytest.mark.parametrize("name", ["pi", "oracle"])
def test_changed_joint_moves_as_one_made_with_the_changed_fields(name):
    change = {"time": 3.0, "friction_scale": 1.2, "coulomb_scale": 0.5, "viscous_scale": 2.0}
    change |= {"inertia_scale": 2.0, "lag_scale": 0.5, "load": 30.0}
    run = simulate(BASE.modified(change=[change]), name)
    before = JointModel(**FIELDS, friction_lag=0.02)
    new = {"inertia": 40.0, "coulomb": 36.0, "stiction": 54.0, "viscous": 192.0, "stribeck_velocity": 0.05}
    after = JointModel(**new, friction_lag=0.01, offset=30.0)
    assert run.velocity == pytest.approx(stepped(run, before, after, 3.0), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(("gravity", "plain"), [(0.0, True), (1.0, False)])
def test_a_weight_is_no_plain_run(gravity, plain):
    assert is_plain(build_setup(SCENARIO.modified(joint={"gravity": gravity}))) is plain


def test_gravity_and_torque_constant_act_on_the_joint_and_are_not_reported():
    joint = JointModel(**FIELDS, friction_lag=0.02, gravity=80.0, gravity_phase=0.3)
    scenario = BASE.modified(joint={"gravity": 80.0, "gravity_phase": 0.3}, actuator={"gain": 0.9})
    run = simulate(scenario, "pi")
    assert run.velocity == pytest.approx(stepped(run, joint, joint, 9.0, gain=0.9), rel=1e-9, abs=1e-12)


def test_oracle_knows_gravity_load_and_payload():
    def error(name, **tables):
        run = simulate(BASE.modified(sensor={"velocity_noise": 0.0}, duration=20.0, **tables), name)
        return rms((run.reference - run.velocity)[10_000:])

    plain = error("oracle")
    change = [{"time": 5.0, "load": 60.0, "inertia_scale": 2.0}]
    for tables in ({"joint": {"gravity": 100.0}}, {"change": change, "actuator": {"torque_limit": 600.0}}):
        assert error("oracle", **tables) < 1.3 * plain
        assert error("pi", **tables) > 3.0 * plain


def test_assumed_delay_is_that_of_all_controllers_but_the_oracle():
    scenario = BASE.modified(actuator={"delay": 0.01}, feedback={"bandwidth": 5.0, "delay": 0.0})
    assert (scenario.delay, scenario.assumed_delay) == (1.0, 0.0)
    assert make_controller(scenario, "pi").parameters.delay == 0.0
    assert make_controller(scenario, "adaptive").parameters.feedback.delay == 0.0
    assert make_controller(scenario, "oracle").parameters.feedback.delay == 1.0
    assert BASE.modified(actuator={"delay": 0.01}, feedback={"bandwidth": 5.0}).assumed_delay == 1.0
