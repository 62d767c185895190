"""Logs with defects: the rest is used, or one line says what is wrong."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from synthetic_logs import JOINT, make_log

from adaptive_ff import InputError
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.open_loop.score import score_log
from adaptive_ff.logs.log import Log
from adaptive_ff.logs.sanity import in_degrees
from adaptive_ff.replay.replay import replay_log


def spoiled(log, **series):
    return Log("log", *(series.get(name, getattr(log, name)) for name in ("time", "torque", "position", "velocity")))


def test_stretches_without_numbers_and_a_clock_that_jumps_back_leave_the_rest_usable():
    log = make_log(noise=0.1)
    log.torque[2000:2600] = np.nan
    log.position[7000] = np.inf
    log.time[9000:] -= 7.0
    found = identify_log(log)
    for name, true in JOINT.items():
        assert found.value(name) == pytest.approx(true, rel=0.05)
    assert [skip[:2] for skip in found.skipped] == [(2000, 2600), (8999, 8999)]  # without the row of the infinity
    assert found.cautions == ["1 row left out: no finite number in the position"]
    assert found.used == found.samples - 600 == 15000 - 601
    assert found.fit.relative_error < 0.05


def test_friction_that_falls_with_the_speed_is_said_to_be_possible():
    (caution,) = identify_log(make_log(noise=0.1, viscous=-0.5)).cautions
    assert caution.startswith("viscous comes out negative, -0.5")
    assert "friction falls with the speed wherever the joint moves (Stribeck; faster motion" in caution


def test_friction_that_changes_along_the_log_is_said_to_be_possible():
    log = make_log(noise=0.1)
    inertia = make_log(coulomb=0.0, viscous=0.0, offset=0.0).torque
    warming = 0.5 + 2.0 * np.exp(-log.time / 10.0)
    found = identify_log(spoiled(log, torque=inertia + warming * (log.torque - inertia)))
    assert "its friction changes along the log (heat)" in found.verdict[0]


def test_defects_do_not_bias_what_is_near_them():
    """Each piece is filtered by itself and its ends are dropped: noise-free pieces give the joint."""
    log = make_log()
    for place in range(1500, 15000, 1500):
        log.torque[place : place + 7] = np.nan
    found = identify_log(log)
    for name, true in JOINT.items():
        assert found.value(name) == pytest.approx(true, rel=0.01)


def test_pieces_that_are_too_short_are_skipped_and_said():
    log = make_log()
    log.torque[10000:][np.arange(5000) % 100 < 5] = np.nan  # longer than what is bridged
    found = identify_log(log, held_out=0.2)
    assert found.used <= 10000
    assert any("the filters need" in skip.reason for skip in found.skipped)
    assert found.value("inertia") == pytest.approx(2.0, rel=0.01)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"position": np.full(15000, 1.0)}, "log: the position is 1 all over; it must move to be identified"),
        (
            {"position": 1e-6 * np.random.default_rng(1).standard_normal(15000)},
            "log: the position scatters by 9.96e-07 rad (rms), no more than from one sample to the next: that is "
            "noise; it must move to be identified",
        ),
        ({"position": np.full(15000, -0.0)}, "log: the position is 0 all over; it must move to be identified"),
        ({"torque": np.zeros(15000)}, "log: the torque is 0 all over; it must be that of the drive"),
        (
            {"torque": np.full(15000, np.nan)},
            "log: no piece of 16 samples is without defect; mostly values that are no finite numbers: the torque has "
            "no finite number in 15000 of 15000 rows",
        ),
        (
            {"torque": np.where(np.arange(15000) % 10 == 0, 1.0, np.nan)},
            "the torque has no finite number in 13500 of 15000 rows",
        ),
        (
            {"time": np.zeros(15000)},
            "log: the time does not go forward in 14999 of 14999 steps, first from 0 s in sample 0 to 0 s in",
        ),
    ],
)
def test_useless_column_is_refused(change, message):
    with pytest.raises(InputError) as refused:
        identify_log(spoiled(make_log(), **change))
    assert message in str(refused.value)


def swing(inertia=0.12, weight=4.0, coulomb=0.02, viscous=0.004, seconds=20.0, period=0.002):
    """Times and angles of a pendulum that is let go at 2 rad, by its equation of motion."""
    time = np.arange(0.0, seconds, period)

    def slopes(_, state):
        friction = coulomb * np.tanh(state[1] / 1e-3) + viscous * state[1]
        return [state[1], -(weight * np.sin(state[0]) + friction) / inertia]

    return time, solve_ivp(slopes, (0.0, seconds), [2.0, 0.0], t_eval=time, rtol=1e-9, atol=1e-10, max_step=0.01).y[0]


def test_a_pendulum_that_swings_freely_is_identified_by_its_weight_as_its_refusal_says():
    time, angle = swing()
    still = np.zeros(time.size)
    with pytest.raises(
        InputError, match=r"swings freely, take its known gravity away with --known-torque, and give --m"
    ):
        identify_log(Log("swing", time, still, angle))
    with pytest.raises(InputError, match=r"the drive$"):
        identify_log(Log("axis", time, still, angle), linear=True)
    found = identify_log(Log("swing", time, still - 4.0 * np.sin(angle), angle), model="offset")
    assert found.value("inertia") == pytest.approx(0.12, rel=1e-3)
    assert found.value("coulomb") == pytest.approx(0.02, rel=0.05)
    assert found.value("viscous") == pytest.approx(0.004, rel=0.1)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (identify_log, "log"),
        (lambda given: identify_log(make_log(), validation=given), "validation"),
        (replay_log, "log"),
        (lambda given: score_log(make_log(), given), "test"),
    ],
)
def test_path_in_the_place_of_a_log_is_refused_with_what_reads_one(call, name):
    with pytest.raises(TypeError, match=rf"^{name} = 'log.csv' is not allowed: it must be a Log: read_log\(path, "):
        call("log.csv")


def test_ten_samples_are_refused():
    log = make_log()
    with pytest.raises(InputError, match="log: the log has 10 samples; there must be at least 50"):
        identify_log(Log("log", log.time[:10], log.torque[:10], log.position[:10]))


def test_log_shorter_than_the_filters_is_refused():
    log = make_log()
    with pytest.raises(InputError, match=r"the longest piece without defect has 200 samples; .* there must be 247"):
        identify_log(Log("log", log.time[:200], log.torque[:200], log.position[:200]))


def test_joint_that_hardly_leaves_rest_is_refused():
    log = make_log()
    position = np.where(log.time < 15.0, 0.0, np.minimum(log.time - 15.0, 0.05))
    with pytest.raises(InputError, match=r"log: the joint slides in [0-9]+ rows .* only; there must be at least 30"):
        identify_log(spoiled(log, position=position))


@pytest.mark.parametrize("series", ["torque", "position"])
def test_reversed_sign_is_refused_with_what_to_do(series):
    log = make_log(noise=0.1)
    with pytest.raises(InputError, match=r"log: friction would drive the joint .* scale the torque by -1"):
        identify_log(spoiled(log, **{series: -getattr(log, series)}))


def test_torque_that_has_nothing_to_do_with_the_motion_is_not_blamed_on_its_sign():
    log = make_log()
    noise = 20.0 * np.random.default_rng(110).standard_normal(log.time.size)
    with pytest.raises(InputError, match=r"log: the motion explains \d+ % of the torque: it is not that of the drive"):
        identify_log(spoiled(log, torque=noise - 0.15 * log.torque))


@pytest.mark.parametrize(
    ("column", "asked"),
    [
        ("q", "in degrees? Then give --scale q=pi/180"),
        ("pos_counts", "in counts? Then give --scale 'pos_counts=2*pi/COUNTS_OF_A_TURN'"),
        ("pos_mm", "in millimetres? Then the axis is linear"),
    ],
)
def test_unit_that_a_column_says_is_asked_for_instead_of_degrees(column, asked):
    log = Log("log", np.arange(3.0), np.arange(3.0), position=np.arange(3.0), columns={"position": column})
    (question,) = in_degrees(log, 300.0, linear=False)
    assert question.startswith("the joint reaches 300 rad/s: is the motion ")
    assert asked in question
    assert in_degrees(log, 300.0, linear=True) == []


def test_degrees_are_suspected():
    log = make_log(noise=0.1)
    found = identify_log(spoiled(log, position=np.degrees(log.position)))
    assert any("is the motion in degrees" in caution for caution in found.cautions)
    assert identify_log(log).cautions == []


def test_exchanged_columns_are_no_joint():
    log = make_log(noise=0.1)
    try:
        cautions = identify_log(spoiled(log, torque=log.position, position=log.torque)).cautions
    except InputError as refused:
        cautions = [str(refused)]
    assert any("columns" in caution or "negative" in caution for caution in cautions)


def test_torque_of_something_else_is_said_to_be_unexplained():
    log = make_log()
    torque = 5.0 * np.sin(2.0 * np.pi * 2.3 * log.time) + 0.1 * log.torque
    found = identify_log(spoiled(log, torque=torque))
    assert any("of the torque unexplained" in caution for caution in found.cautions)
    assert "do not explain" in found.verdict[0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"bandwidth": 60.0}, "bandwidth = 60 Hz is not allowed: it must be positive and at most a tenth"),
        ({"bandwidth": 0.0}, "bandwidth = 0 Hz is not allowed"),
        ({"bandwidth": np.nan}, "bandwidth = nan Hz is not allowed"),
        ({"held_out": 1.0}, "held_out = 1 is not allowed: it must be zero or more, and less than one"),
        ({"held_out": 0.99}, "with 99 % held out, no piece is left"),
        ({"torque_delay": np.inf}, "torque_delay = inf s is not allowed"),
        ({"confidence": 1.0}, "confidence = 1.0 is not allowed"),
    ],
)
def test_argument_out_of_range_is_refused(arguments, message):
    with pytest.raises(InputError) as refused:
        identify_log(make_log(), **arguments)
    assert message in str(refused.value)


def test_nothing_held_out_is_said():
    found = identify_log(make_log(), held_out=0.0)
    assert found.validation is None
    assert "Nothing was held out" in found.verdict[1]
    assert found.to_dict()["validation"] is None
