"""Identification of logs whose joint is known: values, intervals, terms, refusals, noise and folds."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import integrate, stats
from synthetic_logs import JOINT, make_log, sines_log

from adaptive_ff import InputError, identify_log, load_scenario, simulate
from adaptive_ff.identify.columns import TEXTBOOK, Map, Shape, unit_torques
from adaptive_ff.identify.identification import FAMILIES
from adaptive_ff.identify.motion import TUNING, Segment, Spectrum, derivative, even, lowpass, make_rows, spectrum
from adaptive_ff.identify.preparation import narrowed, prepare
from adaptive_ff.identify.regression import Model, quantile
from adaptive_ff.identify.result import CARE, GOOD, UNUSABLE
from adaptive_ff.identify.selection import Estimated, _identifiable, averaged, by_band, is_better
from adaptive_ff.logs.log import KNOWN, Log
from adaptive_ff.replay.replay import replay_log


def with_torque(log, torque):
    return Log("log", log.time, torque, position=log.position)


LOG, TURN = make_log(noise=0.1, period=0.004), 2.0 * np.pi
LOOP = load_scenario().modified(duration=20.0, sampling={"period": 0.001}, sensor={"velocity_noise": 0.0})


@pytest.fixture(scope="module")
def found():
    return identify_log(LOG)


def test_values_are_those_of_the_joint_and_lie_in_their_intervals(found):
    assert found.grade == GOOD
    assert found.refined is None
    assert found.unidentified == {}
    for name, true in JOINT.items():
        one = found.parameters[name]
        assert one.value == pytest.approx(true, rel=0.01)
        assert one.lower < one.value < one.upper
        assert one.half_width < 0.03
    points = found.friction_points()
    assert points["torque"] == pytest.approx(found.friction(points["velocity"]), abs=0.1)


@pytest.mark.parametrize("seed", range(6))
def test_parameters_that_a_joint_was_simulated_with_come_back(seed):
    scale = np.random.default_rng(seed).uniform(0.5, 1.5, 4)
    joint = dict(zip(("inertia", "coulomb", "viscous", "offset"), scale * (20.0, 50.0, 80.0, 10.0), strict=True))
    scenario = LOOP.modified(seed=seed, joint={**joint, "stiction": joint["coulomb"], "friction_lag": 0.0})
    run = simulate(scenario, "pi")
    found = identify_log(Log("run", run.time, run.torque, velocity=run.measured), torque_delay=0.0005)
    for name, true in joint.items():
        assert found.parameters[name].value == pytest.approx(true, rel=0.03), (seed, name)


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_estimates_scale_with_the_unit_of_the_torque(found, unit):
    scaled = identify_log(with_torque(LOG, unit * LOG.torque))
    for name, one in found.parameters.items():
        for end in range(3):
            assert scaled.parameters[name][end] == pytest.approx(unit * one[end], rel=1e-6)


def test_reversed_motion_and_torque_are_the_same_joint(found):
    mirrored = identify_log(Log("log", LOG.time, -LOG.torque, position=-LOG.position))
    for name in ("inertia", "coulomb", "viscous"):
        assert mirrored.parameters[name].value == pytest.approx(found.parameters[name].value, rel=1e-6)
    assert mirrored.parameters["offset"].value == pytest.approx(-found.parameters["offset"].value, rel=1e-6)


def test_velocities_and_positions_tell_the_same():
    found = identify_log(make_log(noise=0.1, period=0.004, as_position=False))
    for name, true in JOINT.items():
        assert found.parameters[name].value == pytest.approx(true, rel=0.01)


def test_both_halves_of_a_log_agree_within_their_intervals():
    log = make_log(noise=0.5, duration=60.0)
    halves = [identify_log(log.part(part)) for part in (slice(None, 15000), slice(15000, None))]
    for name, true in JOINT.items():
        one, other = (half.parameters[name] for half in halves)
        spread = np.hypot(one.upper - one.lower, other.upper - other.lower)
        assert abs(one.value - other.value) < 0.5 * spread * 1.5
        assert min(abs(half.parameters[name].value - true) / abs(true) for half in halves) < 0.05


def test_gravity_is_taken_where_it_takes_torque_and_not_on_a_linear_axis(found):
    log, _ = sines_log(lambda q, w: 0.8 * np.sign(w) + 2.0 * np.sin(q + 0.3), rate=250)
    heavy = identify_log(log)
    assert heavy.gravity == pytest.approx((2.0, 0.3), rel=0.02)
    assert heavy.value("coulomb") == pytest.approx(0.8, rel=0.02)
    assert "gravity_sine" not in found.parameters
    assert "gravity_sine" not in identify_log(log, linear=True).parameters
    assert "gravity_sine" not in identify_log(log, model="offset").parameters


@pytest.mark.parametrize(
    ("further", "taken", "name", "true"),
    [
        (lambda q, w: 0.8 * np.sign(w) + 0.3 * np.abs(w), "directions", "viscous_asymmetry", 0.3),
        (lambda q, w: np.sign(w) * (0.8 + 0.6 * np.exp(-np.abs(w) / 0.3)), "stribeck", "stiction_excess", 0.6),
        (lambda q, w: np.sign(w) * (0.8 - 0.5 * np.exp(-np.abs(w) / 0.4)), "stribeck", "stiction_excess", -0.5),
    ],
)
def test_refinement_is_taken_beside_the_textbook(further, taken, name, true):
    found = identify_log(sines_log(further, rate=250)[0])
    assert taken in found.taken
    assert found.refined.values[name] == pytest.approx(true, rel=0.15)
    assert found.refined.left < 0.9 * found.textbook.left
    assert name not in found.parameters
    assert found.to_dict()["refined"][name]["value"] == found.refined.values[name]


def test_friction_lag_is_found_and_moves_the_inertia():
    log, _ = sines_log(lambda q, w: 0.0 * w, seconds=20)
    velocity = np.gradient(log.position, log.time)
    decay = np.exp(-0.002 / 0.04)
    lagged, state = [], 0.0
    for static in np.sign(velocity) + 0.5 * velocity:
        state = static + decay * (state - static)
        lagged.append(state)
    found = identify_log(with_torque(log, log.torque - 0.5 * velocity + np.array(lagged)))
    assert found.taken[0] == "lag"
    assert found.value("friction_lag") == pytest.approx(0.04, rel=0.1)
    assert found.value("inertia") == pytest.approx(0.5, rel=0.02)
    textbook = found.parameters["inertia"]
    assert textbook.lower < 0.5 < textbook.upper


def test_one_way_motion_still_tells_the_viscous_slope():
    time = 0.005 * np.arange(8000)
    velocity = 1.0 + 0.5 * np.sin(np.pi * time)
    torque = 2.0 * np.gradient(velocity, time) + 6.0 + 3.0 * velocity
    torque += 0.1 * np.random.default_rng(2).standard_normal(time.size)
    found = identify_log(Log("log", time, torque, velocity=velocity))
    assert found.unidentified == {"coulomb": "one_way"}
    assert found.value("viscous") == pytest.approx(3.0, rel=0.02)
    assert found.value("inertia") == pytest.approx(2.0, rel=0.02)
    assert found.grade == CARE


def test_one_sine_does_not_tell_inertia_from_gravity():
    time = 0.005 * np.arange(8000)
    position = 0.1 * np.sin(2.0 * np.pi * 0.5 * time)
    velocity = np.gradient(position, time)
    torque = 2.0 * np.gradient(velocity, time) + 0.3 * np.sign(velocity) + 1.0 * velocity
    found = identify_log(Log("log", time, torque, position=position))
    assert found.unidentified == {"inertia": "one_sine"}
    assert found.grade == UNUSABLE
    assert identify_log(Log("log", time, torque, position=position), linear=True).unidentified == {}


def test_friction_over_position_is_mapped_where_its_period_is_given():
    turn = 2.0 * np.pi / 15.0
    log, _ = sines_log(lambda q, w: np.sign(w) * (0.8 + 0.3 * np.sin(2.0 * np.pi * q / turn)), seconds=15)
    found = identify_log(log, position_periods=(turn,))
    assert "friction over position" in found.taken
    assert found.value("friction_sine_1") == pytest.approx(0.3, rel=0.05)
    assert found.first_estimate()["position_map"] == pytest.approx((0.0, 0.3 / 0.8), abs=0.03)
    hats = identify_log(sines_log(lambda q, w: 0.8 * np.sign(w) + 0.4 * np.abs(q), rate=250)[0], position_hats=5)
    assert "force over position" in hats.taken


def test_friction_that_turns_over_a_path_is_found_with_it():
    def turning(position, velocity):
        turned, friction = 0.0, []
        for moved, sign in zip(np.abs(np.diff(position, prepend=0.0)), np.sign(velocity), strict=True):
            turned = sign + (turned - sign) * math.exp(-moved / 0.1)
            friction.append(0.8 * turned)
        return np.array(friction)

    found = identify_log(sines_log(turning)[0])
    assert found.taken == ("path",)
    assert found.value("path") == pytest.approx(0.1, rel=0.05)


@pytest.mark.parametrize("model", FAMILIES)
def test_every_family_finds_the_joint_beside_a_force_over_position(model):
    log, _ = sines_log(lambda q, w: 0.8 * np.sign(w) + 0.4 * np.abs(q), seconds=20, rate=250)
    found = identify_log(log, model=model, position_hats=5)
    assert found.value("inertia") == pytest.approx(0.5, rel=0.1)
    assert found.value("coulomb") == pytest.approx(0.8, rel=0.1)


def test_load_friction_rises_with_the_known_torque():
    log, _ = sines_log(lambda q, w: np.sign(w) * (0.8 + 0.2 * np.abs(2.0 * np.sin(q))))
    known = replace(log, extra={KNOWN: 2.0 * np.sin(log.position)})
    found = identify_log(known, load_friction=True, model="offset")
    assert found.value("load_friction") == pytest.approx(0.2, rel=0.1)


def test_friction_that_rises_with_the_torque_of_the_gear_is_apart_from_coulomb():
    log, _ = sines_log(lambda q, w: 0.8 * np.sign(w) + 2.0 * np.sin(q))
    carried = np.abs(0.5 * np.gradient(np.gradient(log.position, log.time), log.time) + 2.0 * np.sin(log.position))
    speed = np.sign(np.gradient(log.position, log.time))
    found = identify_log(with_torque(log, log.torque + 0.2 * carried * speed))
    assert "load" in found.taken
    assert found.value("load_friction") == pytest.approx(0.2, rel=0.1)
    assert found.parameters["coulomb"].value == pytest.approx(0.8, rel=0.05)


def test_a_torque_that_acts_later_is_shifted():
    log = make_log(noise=0.02, period=0.004)
    late = Log("log", log.time, np.interp(log.time + 0.01, log.time, log.torque), position=log.position)
    found = identify_log(late, torque_delay=0.01)
    for name, true in JOINT.items():
        assert found.parameters[name].value == pytest.approx(true, rel=0.01)
    assert identify_log(late).value("torque_delay") == pytest.approx(0.01, rel=0.1)


def test_other_log_and_held_out_end_are_validated_on():
    own = identify_log(LOG, held_out=0.25)
    assert own.validated_on == "the end of the log"
    assert own.validation == pytest.approx(own.best.left, rel=0.5)
    other = make_log(noise=0.1, period=0.004, viscous=6.0, seed=102)
    found = identify_log(LOG, validation=Log("other", other.time, other.torque, position=other.position))
    assert found.validation > 10.0 * found.best.left
    slow = identify_log(LOG, validation=replace(make_log(noise=0.1, period=0.05, seed=103), name="slow"))
    assert slow.cautions == ["slow: the torque is compared up to 4 Hz, a fifth of the sampling frequency"]
    with pytest.raises(InputError, match="the log to validate on is the one that is fitted"):
        identify_log(LOG, validation=LOG)
    with pytest.raises(InputError, match="log, its end that is held out: the log has 8 samples"):
        identify_log(LOG, held_out=0.001)


def test_end_whose_clock_jitters_in_another_way_is_validated_on():
    """Its sample time came out a little longer, and the band was refused though nobody had given one."""
    log = make_log(period=0.04, noise=0.1, duration=60.0)
    time = log.time + 0.008 * np.where(log.time < 30.0, 0.0, np.arange(log.time.size) % 3 - 1.0)
    assert identify_log(replace(log, time=time), held_out=0.5).validation < 0.2


def test_a_constant_load_explains_nothing(found):
    assert identify_log(with_torque(LOG, LOG.torque + 500.0)).best.left == pytest.approx(found.best.left, rel=1e-3)
    noise = np.convolve(np.random.default_rng(4).standard_normal(LOG.time.size + 99), np.ones(100), "valid")
    with pytest.raises(InputError, match="the motion explains 0 % of the torque"):
        identify_log(with_torque(LOG, 500.0 + noise))


def test_a_pendulum_that_swings_freely_is_identified_by_its_weight():
    time = np.arange(0.0, 20.0, 0.002)

    def slopes(_, state):
        friction = 0.02 * np.tanh(state[1] / 1e-3) + 0.004 * state[1]
        return [state[1], -(4.0 * np.sin(state[0]) + friction) / 0.12]

    solved = integrate.solve_ivp(slopes, (0.0, 20.0), [2.0, 0.0], t_eval=time, rtol=1e-8, atol=1e-9, max_step=0.02)
    angle = solved.y[0]
    with pytest.raises(InputError, match="swings freely, take its known gravity away with --known-torque"):
        identify_log(Log("swing", time, np.zeros(time.size), angle))
    found = identify_log(Log("swing", time, -4.0 * np.sin(angle), angle), model="offset")
    assert found.value("inertia") == pytest.approx(0.12, rel=5e-3)
    assert found.value("coulomb") == pytest.approx(0.02, rel=0.1)


def test_thirty_thousand_rows_take_a_second():
    import time

    log = make_log(noise=0.1, period=0.001)
    identify_log(make_log(noise=0.1, duration=5.0))
    begin = time.process_time()
    identify_log(log)
    assert time.process_time() - begin < 3.0


@pytest.mark.parametrize("moving", ["position", "velocity"])
def test_speed_that_is_mostly_noise_is_refused_as_lost_in_it(moving):
    """White noise behind the wide filter, over the motion that it is added to, rms: from one on it is refused."""
    log = make_log(duration=60.0, as_position=moving == "position")
    motion, noise = log.series[moving], np.random.default_rng(12).standard_normal(log.time.size)
    speeds = [lowpass(25.0, 0.002)(one) for one in (motion, noise)]
    true, unit = (np.std(derivative(one, 0.002) if moving == "position" else one) for one in speeds)
    loud, quiet = (replace(log, **{moving: motion + over * true / unit * noise}) for over in (1.15, 0.87))
    assert prepare(quiet, bandwidth=5.0).used == log.time.size
    with pytest.raises(InputError, match=f"log: the speed is lost in the noise of the {moving}, which is 7[4-7] % of"):
        prepare(loud, bandwidth=5.0)


def test_degrees_are_suspected():
    log = replace(LOG, position=np.degrees(LOG.position))
    for said in (identify_log(log).cautions, identify_log(LOG, validation=log).cautions, replay_log(log).notes):
        assert any("s the motion in degrees" in caution for caution in said)


def test_bias_of_first_order_in_the_band_is_found_by_half_of_it_and_taken_with_the_factor_of_safety():
    """Richardson's estimate is exact for it; Roache's interval of two grids is three times as wide, at two errors."""
    true, bias = np.array([2.0, 3.0]), np.array([0.1, -0.4])
    half = SimpleNamespace(fit=lambda model: SimpleNamespace(solve=lambda: true + 2.0 * bias))
    one = Estimated(None, None, true + bias, None, None)
    assert by_band(half, one) == pytest.approx(1.5 * bias)
    assert not by_band(None, one).any()


def test_interval_holds_what_the_band_changes_in_the_models_that_count():
    names, still = ("inertia", "coulomb"), np.ones(2)
    models = Model(names), Model(names, Shape(friction_lag=0.01))
    half = SimpleNamespace(fit=lambda model: SimpleNamespace(solve=lambda: still + 0.5 * (model == models[0])))
    for errors, error in (((1.0, 0.1), 0.0), ((0.1, 1.0), 0.75)):
        pairs = zip(models, errors, (2, 3), strict=True)
        made = [Estimated(model, np.full(8, one), still, np.zeros((size, size)), None) for model, one, size in pairs]
        found = averaged(SimpleNamespace(torque=still), half, made, 0.95)
        expected = quantile(8, 0.95) * error
        assert found.parameters["inertia"].upper - 1.0 == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("is_position", [True, False])
def test_spectrum_tells_a_sine_from_white_noise(is_position):
    time, order = 0.001 * np.arange(20_000), 1 + is_position
    series = 0.1 * np.sin(2.0 * TURN * time) + 1e-4 * np.random.default_rng(7).standard_normal(time.size)
    found = spectrum(series, 0.001, is_position=is_position)
    assert (found.motion, found.slow) == pytest.approx((2.0, 2.0), abs=0.11)
    assert found.density == pytest.approx(2.0 * 0.001 * 1e-8, rel=0.05)
    loud = 0.01 * 0.5 * (0.1 * (2.0 * TURN) ** order) ** 2  # of the square of the acceleration
    quiet = (loud * (2 * order + 1) / (2e-11 * TURN ** (2 * order))) ** (1.0 / (2 * order + 1))
    assert found.quiet == pytest.approx(quiet, rel=0.05)


@pytest.mark.parametrize(("rate", "counts"), [(4000.0, 1000), (1000.0, 400)])
def test_counts_that_take_many_rows_narrow_the_band(rate, counts):
    """The band was as wide as the sampling allows, and the log refused: its speed would be lost in the noise."""
    log, step = make_log(noise=0.05, period=1.0 / rate), TURN / counts
    found = identify_log(replace(log, position=step * np.round(log.position / step)))
    assert 3.0 < found.data.band < 10.0
    for name in ("inertia", "coulomb", "viscous"):
        one = found.parameters[name]
        assert one.lower < JOINT[name] < one.upper
        assert one.value == pytest.approx(JOINT[name], rel=0.1)


def test_lines_of_an_encoder_beyond_an_empty_octave_are_no_motion():
    waves = {hertz: np.sin(hertz * TURN * 0.001 * np.arange(20_000)) for hertz in (2.0, 5.0, 10.0, 20.0, 40.0)}
    for further, motion in (((40.0,), 2.0), ((5.0, 10.0, 20.0, 40.0), 40.0)):
        velocity = waves[2.0] + 0.3 * sum(waves[hertz] for hertz in further)
        assert spectrum(velocity, 0.001, is_position=False).motion == pytest.approx(motion, abs=0.11)


@pytest.mark.parametrize("speed", [110.0, 205.0])
def test_counts_passed_at_constant_speed_are_no_motion(speed):
    """More than half of the power of the velocity is theirs: the motion ended above 400 Hz."""
    velocity = speed * np.interp(0.001 * np.arange(40_000) % 4.0, [0.0, 0.3, 1.7, 2.3, 3.7, 4.0], [0, 1, 1, -1, -1, 0])
    position = 0.001 * np.cumsum(velocity)
    counted, exact = (spectrum(one, 0.001, is_position=True) for one in (np.round(position), position))
    assert (counted.motion, counted.slow) == (exact.motion, exact.slow)
    assert counted.quiet < 10.0


@pytest.mark.parametrize(("moving", "scatter"), [("position", 1e-3), ("velocity", 0.03)])
def test_noise_of_the_motion_is_as_large_in_its_columns_as_is_said(moving, scatter):
    log, said, there = make_log(period=0.004), [], []
    motion = log.position if moving == "position" else derivative(log.position, 0.004)
    for noise in scatter * np.random.default_rng(11).standard_normal((8, log.time.size)):
        found = prepare(Log("log", log.time, log.torque, **{moving: motion + noise}), bandwidth=8.0)
        behind = lowpass(8.0, 0.004)(lowpass(found.longest.corner, 0.004)(noise))
        viscous = derivative(behind, 0.004) if moving == "position" else behind
        there.append([np.var(one[100:-100]) for one in (derivative(viscous, 0.004), viscous)])
        said.append([found.noise["inertia"], found.noise["viscous"]])
    assert np.mean(said, axis=0) == pytest.approx(np.mean(there, axis=0), rel=0.1)


def test_noise_makes_standstill_of_slow_rows_and_friction_that_of_the_expected_sign():
    position = np.sin(TURN * 0.001 * np.arange(10_000))
    sines = Segment(4.0, 0.001, position, position, 2.0 * position, 0.0 * position)
    noises = (Spectrum(1.0, math.inf, 1.0, density, True) for density in (0.0, 1e-5))
    rows, loud = (make_rows(sines, 10.0, noise, 6.0) for noise in noises)
    assert rows.time == pytest.approx(4.0 + 0.003 * np.arange(3334))  # six samples in a cycle of 50 Hz
    assert (rows.slow, rows.noise, rows.kept.tolist()) == (pytest.approx(0.06), 0.0, list(range(34, 3300, 8)))
    passed = math.pi / math.sqrt(128.0)  # the integral of (x / (1 + x^4))^2 over positive x
    assert loud.noise == pytest.approx(math.sqrt(1e-5 * TURN**2 * 50.0**3 * passed), rel=1e-3)
    assert loud.slow == loud.noise
    true = np.linspace(-30.0, 30.0, 1_000_001)
    measured = true + loud.noise * np.random.default_rng(5).standard_normal(true.size)
    coulomb = unit_torques(loud.unfiltered()._replace(noise=loud.noise), ("coulomb",), Shape(), Map())[:, 0]
    for slow, fast in ((-5.0, -4.0), (-2.0, -1.5), (0.5, 1.0), (3.0, 3.5)):
        expected = np.mean(np.sign(true[(slow < measured) & (measured < fast)]))
        found = np.mean(coulomb[(slow < loud.velocity) & (loud.velocity < fast)])
        assert found == pytest.approx(expected, abs=0.03)


@pytest.mark.parametrize(("seconds", "folds"), [(5.0, 8), (13.0, 12), (60.0, 20)])
def test_folds_are_as_long_as_a_cycle_of_the_motion_and_half_of_the_band_is_as_if_given(seconds, folds):
    time = np.arange(0.0, seconds, 0.005)
    data = prepare(log := Log("log", time, np.cos(time), position=np.sin(TURN * time)))
    assert np.unique(data.fold).size == folds
    assert np.ptp(np.bincount(data.fold)) <= 1
    assert narrowed(data).fold.tolist() == prepare(log, bandwidth=0.5 * data.band).fold.tolist()


@pytest.mark.parametrize(("seconds", "fitted"), [(0.75, 1), (0.85, 2)])
def test_a_segment_of_fewer_than_four_cycles_of_the_band_is_not_fitted(seconds, fitted):
    apart = (LOG.time < 20.0) | (np.abs(LOG.time - 25.0) < 0.5 * seconds)
    assert len(prepare(LOG.part(apart), bandwidth=5.0).rows) == fitted


def test_terms_are_better_where_students_t_and_the_fall_are_those_of_the_rule():
    old = np.array([4.0, 5.0, 6.0, 5.0, 4.5, 5.5])
    new = old - [1.5, 0.5, 3.0, 1.0, 2.0, 1.0]
    t, fraction = stats.ttest_rel(old, new).statistic, math.sqrt(np.mean(new) / np.mean(old))
    for factor, better in ((0.999, True), (1.001, False)):
        assert is_better(old, new, factor * t, 0.0) == better
        assert is_better(old, new, 0.0, factor * (1.0 - fraction)) == better


def test_a_cubic_goes_through_four_samples():
    time, grid = np.array([0.0, 1.0, 2.5, 4.0]), np.array([0.5, 3.0])
    assert even(time, time**3 - time, grid) == pytest.approx(grid**3 - grid)


def test_terms_that_the_motion_or_its_noise_hides_are_left_out_with_the_reason():
    def left_out(noise=0.0, **tolerance):
        left = dict.fromkeys(TEXTBOOK, 1.0) | tolerance
        folds = SimpleNamespace(rows=np.array([3, 5]), gram=np.full((2, 4, 4), 4.0), tolerance=lambda: left)
        model, lacking = _identifiable(SimpleNamespace(fit=lambda _: folds, noise={"inertia": noise}), TEXTBOOK)
        assert set(TEXTBOOK) - set(model.names) == set(lacking)
        return lacking

    limit = 1.0 - TUNING.collinear**0.25  # of the noise in the mean square of the acceleration
    assert left_out(limit - 1e-6) == {}
    assert left_out(limit + 1e-6) == left_out(1.5) == {"inertia": "no_acceleration"}
    for name, reason in {"coulomb": "one_way", "viscous": "one_speed", "inertia": "no_acceleration"}.items():
        assert left_out(**{name: 1.001 * TUNING.collinear}) == {}
        assert left_out(**{name: 0.999 * TUNING.collinear}) == {name: reason}
