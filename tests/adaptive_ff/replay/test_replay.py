"""Replay of logs, against the controller in the loop, models that are known, and itself in other parts."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from synthetic_logs import make_log, motion

from adaptive_ff import InputError, TorqueModel, load_scenario, simulate
from adaptive_ff.logs.derivatives import lowpass
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.replay import replay_log
from adaptive_ff.replay.settings import ReplaySettings
from adaptive_ff.replay.state import state_from_json
from controllers import PI, low_pass_lag, pi_gains

ASSUMED = {"inertia": 20.0, "stribeck_velocity": 0.05, "rest_speed": 0.0, "start_path": 0.0}
MODEL = TorqueModel(20.0, 60.0, 90.0, 80.0, 0.02, 0.05, 1.0)
NOT_JUDGED_IN_A_BAND = math.inf


def log_of(run):
    """The log of a simulated run: what the controller assumed, its torques with the stamp of their command."""
    columns = run.columns()
    extra = {"reference_velocity": columns["reference"], "feedforward": columns["feedforward"]}
    return Log("run", columns["time"], columns["torque"], velocity=columns["measured"], extra=extra)


@pytest.fixture(scope="module")
def run():
    scenario = load_scenario().modified(duration=20.0, seed=101)
    settings = ReplaySettings(0.01, 20.0, 0.05, 10.0, rest_speed=0.0, identify="symmetric")
    return simulate(scenario, settings.controller())


@pytest.fixture(scope="module")
def driven():
    """A run of the PI loop alone, whose log the others watch."""
    scenario = load_scenario().modified(duration=20.0, seed=102)
    return log_of(simulate(scenario, PI(*pi_gains(20.0, 10.0), 0.01)))


def watch_run(log, **options):
    assumed = {**ASSUMED, "identify": "symmetric", "torque_delay": 0.005, "fixed": MODEL, "band": NOT_JUDGED_IN_A_BAND}
    return replay_log(log, **{**assumed, **options})


def test_replay_learns_what_the_controller_learnt_in_the_loop(run):
    replayed = watch_run(log_of(run))
    assert run.final_estimates["stiction"] > 30.0
    for name, history in run.estimates.items():
        np.testing.assert_allclose(replayed.series.estimates["adaptive"][name], history, rtol=1e-6, atol=1e-9)


def test_replay_feeds_forward_what_the_controller_fed_forward(run):
    replayed = watch_run(log_of(run))
    mine, own = (replayed.series.feedforward[name][0][:-1] for name in ("adaptive", "recorded"))
    np.testing.assert_allclose(mine, own, rtol=1e-6, atol=1e-6)
    assert np.ptp(own) > 100.0
    np.testing.assert_allclose(replayed.series.needed[0][:-1], run.torque[:-1], rtol=1e-12)
    # the last sample of a log has no preview
    assert replayed.left["adaptive"].whole == pytest.approx(replayed.left["recorded"].whole, rel=1e-4)


def held_log(noise, period=0.002, samples=10_000):
    """A motion, and the mean of the torque that it needs over each period, by quadrature; with noise."""
    fine = 100
    time = period * np.arange(samples)
    centres = time[:, np.newaxis] + period * (np.arange(fine) + 0.5) / fine
    omega = 2.0 * np.pi * np.array([0.31, 0.83])
    velocity, acceleration = 0.0, 0.0
    at_samples = 0.0
    for w, a, phase in zip(omega, (0.9, 0.7), (0.4, 2.0), strict=True):
        velocity = velocity + a * np.sin(w * centres + phase)
        acceleration = acceleration + a * w * np.cos(w * centres + phase)
        at_samples = at_samples + a * np.sin(w * time + phase)
    torque = (2.0 * acceleration + 3.0 * np.sign(velocity) + 4.0 * velocity).mean(axis=1) - 0.5 + noise
    return Log("held", time, torque, velocity=at_samples, extra={"reference_velocity": at_samples})


def test_perfect_model_leaves_the_noise():
    noise = 0.05 * np.random.default_rng(103).standard_normal(10_000)
    model = TorqueModel(2.0, 3.0, 3.0, 4.0, 0.0, 0.05, 1.0, -0.5)
    assumed = {"inertia": 2.0, "stribeck_velocity": 0.05, "rest_speed": 0.0, "torque_delay": 0.001, "fixed": model}
    silent = replay_log(held_log(0.0), **assumed)
    assert silent.left["fixed"].whole < 1e-3 * silent.left["none"].whole
    found = replay_log(held_log(noise), **assumed)
    in_band = lowpass(noise, (20.0,), 0.002)
    assert found.left["fixed"].whole == pytest.approx(float(np.sqrt(np.mean(in_band**2))), rel=0.02)
    assert found.left["fixed"].second_half == pytest.approx(float(np.sqrt(np.mean(in_band[5000:] ** 2))), rel=0.03)
    assert found.left["adaptive"].second_half < 0.05 * found.left["none"].second_half


def test_fixed_model_is_that_of_the_first_half():
    """Friction doubles in the middle: the model fitted before it does not know."""
    before, after = make_log(duration=30.0), make_log(duration=30.0, coulomb=6.0)
    torque = np.where(np.arange(before.time.size) < before.time.size // 2, before.torque, after.torque)
    found = replay_log(replace(before, torque=torque))
    assert found.fixed.coulomb == pytest.approx(3.0, rel=0.03)
    assert found.fixed.offset == pytest.approx(-0.5, rel=0.1)
    assert found.left["fixed"].second_half == pytest.approx(3.0, rel=0.1)
    assert found.estimates["adaptive"]["coulomb"] == pytest.approx(6.0, rel=0.1)
    assert found.left["adaptive"].second_half < 0.6 * found.left["fixed"].second_half


@pytest.mark.parametrize("part", [1_000_000, 137])
def test_parts_make_no_difference(driven, part):
    for log, options in (
        (driven, {**ASSUMED, "identify": "directions", "torque_delay": 0.005}),
        (make_log(duration=20.0, noise=0.1), {"inertia": 2.0, "stribeck_velocity": 0.05, "rest_speed": 0.01}),
    ):
        whole, parted = (replay_log(log, fixed=MODEL, part=size, **options) for size in (50_000, part))
        for name in whole.left:
            assert parted.left[name] == pytest.approx(whole.left[name], rel=1e-9)
        assert parted.estimates["adaptive"] == pytest.approx(whole.estimates["adaptive"], rel=1e-9)
        np.testing.assert_allclose(parted.series.needed, whole.series.needed, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("as_position", [True, False])
def test_future_of_the_log_changes_nothing_before(as_position):
    log = make_log(duration=10.0, noise=0.1, as_position=as_position)
    reference = make_log(duration=10.0, as_position=False).velocity
    log = replace(log, extra={"reference_velocity": reference})
    assumed = {"inertia": 2.0, "stribeck_velocity": 0.05, "rest_speed": 0.01, "fixed": MODEL, "band": math.inf}
    assumed |= {"start_path": 1e-6, "velocity_cutoff": 50.0}  # else taken from all of the log
    other = {"torque": log.torque.copy(), "position": log.motion.copy()}
    since = 3000
    other["torque"][since:] *= -2.0
    # a position drifts away, as one that jumps would be cut there as a defect
    other["position"][since:] += 0.3 * (log.time[since:] - log.time[since]) if as_position else 0.5
    changed = replace(log, torque=other["torque"], **{"position" if as_position else "velocity": other["position"]})
    before, after = replay_log(log, **assumed).series, replay_log(changed, **assumed).series
    for name, history in before.estimates["adaptive"].items():
        assert np.array_equal(history[:since], after.estimates["adaptive"][name][:since])
    given, others = before.feedforward["adaptive"][0], after.feedforward["adaptive"][0]
    assert np.array_equal(given[:since], others[:since])
    assert not np.array_equal(given[since:-1], others[since:-1])


def test_coming_reference_counts_one_sample_ahead_and_not_more():
    log = make_log(duration=10.0, as_position=False)
    assumed = {"inertia": 2.0, "stribeck_velocity": 0.05, "rest_speed": 0.0, "fixed": MODEL, "band": math.inf}
    reference = log.velocity.copy()
    reference[3000:] += 0.1
    series = [
        replay_log(replace(log, extra={"reference_velocity": given}), **assumed).series.feedforward["fixed"][0]
        for given in (log.velocity, reference)
    ]
    assert np.array_equal(series[0][:2999], series[1][:2999])
    assert series[0][2999] != series[1][2999]


def test_state_is_saved_and_restored_exactly(driven, monkeypatch):
    """Two logs one after the other, the second from the state at the end of the first, are one log with a jump."""
    monkeypatch.setattr("adaptive_ff.replay.state.KEPT", 1.0)  # nothing is forgotten
    middle = driven.time.size // 2
    halves = [
        Log(
            "half",
            driven.time[part],
            driven.torque[part],
            velocity=driven.velocity[part],
            extra={name: series[part] for name, series in driven.extra.items()},
        )
        for part in (slice(0, middle), slice(middle, None))
    ]
    jumping = replace(driven, time=np.append(driven.time[:middle], driven.time[middle:] - 3.0))
    options = {**ASSUMED, "identify": "offset", "fixed": MODEL}
    one = replay_log(jumping, **options)
    assert [skip.reason for skip in one.skipped] == ["the clock jumps back, from 9.99 s to 7 s"]
    first = replay_log(halves[0], **options)
    second = replay_log(halves[1], state=first.state_to_json(), fixed=MODEL)
    assert second.settings == first.settings
    assert second.estimates["adaptive_saved"] == one.estimates["adaptive"]
    assert second.estimates["adaptive_saved"] != second.estimates["adaptive"]
    saved = second.state_to_json()
    third = replay_log(halves[0], state=saved, fixed=MODEL)
    assert third.series.estimates["adaptive_saved"]["coulomb"][0] == second.estimates["adaptive_saved"]["coulomb"]


def test_inertia_of_another_posture_is_found_sooner_than_if_it_were_kept(monkeypatch):
    """The second log has twice the inertia, and the same friction."""
    first = replay_log(make_log(duration=20.0, noise=0.1), inertia=2.0)
    other = make_log(duration=4.0, noise=0.1, inertia=4.0)
    found, known = {}, state_from_json(first.state_to_json())[1].estimates
    for kept in (0.01, 1.0):
        monkeypatch.setattr("adaptive_ff.replay.state.KEPT", kept)
        found[kept] = replay_log(other, state=first.state_to_json(), fixed=MODEL)
    errors = {kept: abs(replay.estimates["adaptive_saved"]["inertia"] - 4.0) for kept, replay in found.items()}
    assert errors[0.01] < 0.3 * errors[1.0]
    assert found[0.01].estimates["adaptive_saved"]["coulomb"] == pytest.approx(known["coulomb"], rel=0.1)


def lagged_log(lag, **options):
    """A log whose friction follows with a lag, s."""
    log, velocity = make_log(**options), make_log(**options, as_position=False).velocity
    friction = 3.0 * np.sign(velocity) + 4.0 * velocity
    decay = math.exp(-0.002 / lag)
    return replace(log, torque=log.torque - friction + lfilter([1.0 - decay], [1.0, -decay], friction))


def test_friction_that_rises_from_standstill_is_fed_forward_as_it_is():
    """That of slow saturation is Coulomb friction of 5, and stiction below it."""
    log, speed = make_log(duration=30.0, noise=0.05), motion(0.002 * np.arange(15_000))[1]
    saturating = 2.0 * np.sign(speed) * -np.expm1(-np.abs(speed) / 0.3)
    log = replace(log, torque=log.torque + saturating, extra={"reference_velocity": speed})
    found = replay_log(log, inertia=2.0, stribeck_velocity=0.3, fixed=MODEL)
    assert found.estimates["adaptive"]["stiction"] == pytest.approx(3.0, rel=0.1)
    assert found.estimates["adaptive"]["coulomb"] == pytest.approx(5.0, rel=0.1)
    assert found.left["adaptive"].second_half < 0.03 * found.left["none"].second_half


@pytest.mark.parametrize(("faster", "learns"), [(2.0, True), (10.0, True), (100.0, False)])
def test_joint_slower_than_the_stribeck_velocity_is_no_fault_though_its_plan_is_slower_still(faster, learns):
    time = 0.002 * np.arange(3000)
    plan = 0.01 * np.minimum(time / 0.2, 1.0)
    speed = faster * plan
    log = Log("start", time, np.full(time.size, 3.0), velocity=speed, extra={"reference_velocity": plan})
    found = replay_log(log, inertia=2.0, stribeck_velocity=0.05, rest_speed=0.0, start_path=0.0, fixed=MODEL)
    assert (found.left["adaptive"].second_half < 0.4 * found.left["none"].second_half) == learns


def test_lag_leaves_its_first_guess():
    log = lagged_log(0.045, duration=30.0, noise=0.1)
    found = replay_log(log, inertia=2.0, fixed=MODEL)
    assert found.estimates["adaptive"]["friction_lag"] == pytest.approx(0.045, abs=0.006)


def test_coarse_position_is_filtered_and_its_lag_is_known():
    log = lagged_log(0.03, duration=30.0)
    count = 2.0 * math.pi / 2**12
    coarse = replace(log, position=count * np.round(log.position / count))
    found = replay_log(coarse, inertia=2.0, fixed=MODEL)
    cutoff = found.settings.velocity_cutoff
    assert 10.0 <= cutoff < 50.0
    assert found.settings.velocity_lag == pytest.approx(low_pass_lag(cutoff, 0.002))
    rough = replay_log(coarse, inertia=2.0, fixed=MODEL, velocity_cutoff=200.0)
    errors = [abs(replay.estimates["adaptive"]["friction_lag"] - 0.03) for replay in (found, rough)]
    assert errors[0] < 0.7 * errors[1]
    assert found.left["adaptive"].second_half < 0.9 * rough.left["adaptive"].second_half
    fine = replay_log(log, inertia=2.0, fixed=MODEL).settings
    assert fine.velocity_cutoff is None
    assert fine.velocity_lag == pytest.approx(0.001)


def test_defects_are_skipped_and_the_rest_is_used(driven):
    time, torque, velocity = driven.time.copy(), driven.torque.copy(), driven.velocity.copy()
    extra = {name: series.copy() for name, series in driven.extra.items()}
    velocity[500:520] = np.nan
    torque[700] = np.inf
    extra["reference_velocity"][800:805] = np.nan
    time[1000:] += 1.0
    time[1500:] -= 5.0
    time[1600:] = time[1599]
    time[1605:] = time[1599] + 0.01 * np.arange(1, time.size - 1604)
    broken = Log("broken", time, torque, velocity=velocity, extra=extra)
    found = watch_run(broken)
    reasons = [(skip.start, skip.stop, skip.reason.split(",")[0]) for skip in found.skipped]
    assert (500, 520, "values that are no finite numbers") in reasons
    assert "1 row left out: no finite number in the torque." in found.notes
    assert (799, 804, "values that are no finite numbers") in reasons  # without the row of the infinity
    assert (999, 999, "the clock leaves a gap") in reasons
    assert (1499, 1499, "the clock jumps back") in reasons
    assert "5 rows left out: with the time of the row before, but other values." in found.notes
    assert found.used >= driven.time.size - 40
    sound = watch_run(driven)
    for name in ("coulomb", "viscous", "inertia"):
        assert found.estimates["adaptive"][name] == pytest.approx(sound.estimates["adaptive"][name], rel=0.15)
        history = found.series.estimates["adaptive"][name]
        assert history[520] == history[499]  # kept over the defect, and while the filters settle
    for left in found.left.values():
        assert all(math.isfinite(value) for value in left)


def test_motion_stands_for_a_reference_and_it_is_said():
    found = replay_log(make_log(duration=20.0))
    assert any("no reference" in note for note in found.notes)
    assert found.left["adaptive"].second_half < 0.1 * found.left["none"].second_half
    log = make_log(duration=20.0)
    planned = replay_log(replace(log, extra={"reference_position": log.position}))
    assert not any("no reference" in note for note in planned.notes)
    assert planned.left["fixed"].whole == pytest.approx(found.left["fixed"].whole, abs=0.1)


def test_slow_sampling_is_judged_at_all_frequencies():
    found = replay_log(make_log(duration=60.0, period=0.03), inertia=2.0)
    assert found.band is None
    assert any("all frequencies" in note for note in found.notes)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"band": 0.0}, "band = 0 Hz is not allowed"),
        ({"memory": -1.0}, "memory = -1 is not allowed"),
        ({"identify": "all"}, "identify = 'all' is not allowed: it must be one of symmetric, offset, directions"),
        ({"torque_delay": -0.1}, "torque_delay = -0.1 s is not allowed"),
        ({"rest_speed": math.nan}, "rest_speed = nan is not allowed"),
        ({"velocity_cutoff": 0.0}, "velocity_cutoff = 0 Hz is not allowed"),
        (
            {"velocity_cutoff": 1e9},
            "velocity_cutoff = 1e+09 Hz is not allowed: it must be positive and at most half the ",
        ),
        (
            {"loop_bandwidth": 300.0},
            "loop_bandwidth = 300 Hz is not allowed: it must be positive and at most half the ",
        ),
        ({"loop_bandwidth": 1e-300}, "inertia = 2.0 is not allowed with proportional = 1.2"),
        ({"stribeck_velocity": 1e9}, "stribeck_velocity = 1000000000.0 is not allowed: it must be 100000 at most"),
        ({"band": 1e-300}, "band = 1e-300 Hz is not allowed: it must be at least that of one cycle in the log, 0.2 Hz"),
        ({"bandwidth": -1.0}, "bandwidth = -1 Hz is not allowed: it must be positive and at most a tenth"),
        ({"torque_delay": 5.0}, "torque_delay = 5 s is not allowed: it must be from -1 to 1 s"),
        ({"state": "{}"}, "is no saved state"),
        ({"state": '{"settings": {"period": 1}}'}, "the settings period are not allowed"),
    ],
)
def test_arguments_out_of_range_are_refused(options, message):
    with pytest.raises(InputError, match=re.escape(message)):
        replay_log(make_log(duration=5.0), **{"inertia": 2.0, **options})


def test_state_of_another_clock_or_beside_other_settings_is_refused(driven):
    state = watch_run(driven).state_to_json()
    with pytest.raises(InputError, match=r"sample time of 0\.002 s; it must be 0\.01 s"):
        replay_log(make_log(duration=5.0), state=state)
    with pytest.raises(InputError, match=r"inertia = 3\.0 is not allowed beside a saved state"):
        replay_log(driven, state=state, inertia=3.0)


def test_log_without_a_joint_needs_an_inertia():
    generator = np.random.default_rng(104)
    time = 0.01 * np.arange(2000)
    still = np.where(time < 10.0, 0.0, np.sin(time - 10.0))
    log = Log("late", time, still + 0.01 * generator.standard_normal(2000), velocity=still)
    with pytest.raises(InputError, match=r"late: inertia must be given"):
        replay_log(log)
    found = replay_log(log, inertia=1.0)
    assert "fixed" not in found.left
    assert found.to_dict()["fixed"] is None
    extra = {"reference_velocity": np.zeros(2000)}
    with pytest.raises(InputError, match="late: the reference stands still; it must move"):
        replay_log(replace(log, extra=extra), inertia=1.0)
    with pytest.raises(InputError, match="still: the joint stands still; it must move"):
        replay_log(Log("still", time, log.torque, velocity=np.zeros(2000)), inertia=1.0)
    with pytest.raises(InputError, match="no piece of 10 samples"):
        replay_log(Log("torn", time[:99], np.where(np.arange(99) % 9, time[:99], np.nan), velocity=np.full(99, np.nan)))
    for count in (0, 1, 9):
        with pytest.raises(InputError, match=rf"short: the log has {count} samples?; there must be at least 10"):
            replay_log(Log("short", time[:count], time[:count], velocity=time[:count]), inertia=1.0)


def weighted(duration=40.0):
    """A log of a joint with a weight of 8 N m."""
    log = make_log(duration=duration, noise=0.05)
    return replace(log, torque=log.torque + 8.0 * np.sin(log.position))


def test_gravity_is_learnt_from_the_position_of_the_log():
    log = weighted()
    with_gravity = replay_log(log, identify="gravity")
    assert with_gravity.estimates["adaptive"]["gravity_sin"] == pytest.approx(8.0, rel=0.05)
    assert not any("identify = gravity" in note for note in with_gravity.notes)
    without = replay_log(log)
    assert any("does not identify gravity" in note for note in without.notes)
    assert without.left["adaptive"].second_half > 3.0 * with_gravity.left["adaptive"].second_half


def test_gravity_without_a_position_is_refused():
    log = make_log(duration=10.0, as_position=False)
    with pytest.raises(InputError, match="identify = 'gravity' is not allowed: log has no position"):
        replay_log(log, identify="gravity")


@pytest.mark.parametrize(
    ("options", "torque", "inertia", "viscous", "speed"),
    [
        ({}, "N m", "kg m²", "N m s/rad", "rad/s"),
        ({"linear": True}, "N", "kg", "N s/m", "m/s"),
        ({"is_current": True}, "A", "A s²/rad", "A s/rad", "rad/s"),
        ({"linear": True, "is_current": True}, "A", "A s²/m", "A s/m", "m/s"),
    ],
)
def test_pictures_show_the_units_of_the_axis_and_of_its_torque(options, torque, inertia, viscous, speed):
    """A linear axis whose torque is a current had its inertia in A s²/rad."""
    found = replay_log(make_log(duration=10.0, noise=0.1), **options)
    units = {"coulomb": torque, "inertia": inertia, "viscous": viscous, "stribeck_velocity": speed}
    assert {name: found.units[name] for name in units} == units
    assert found.unit == torque
    labels = [axes.get_ylabel() for axes in found.plot()["estimates"].axes]
    assert any(label.endswith(f"inertia ({inertia})") for label in labels)
