"""The time between a recorded reference and the motion that followed it, on logs that are made with a known one."""

import math
from dataclasses import replace

import numpy as np
import pytest
from synthetic_logs import make_log, motion

from adaptive_ff import InputError, TorqueModel
from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.following import as_followed, doubts, motion_lead
from adaptive_ff.replay.replay import replay_log

PERIOD, BAND = 0.002, 20.0
PLAN = motion(PERIOD * np.arange(8000))[1]
MODEL = TorqueModel(2.0, 3.0, 3.0, 4.0, 0.0, 0.05, 1.0, -0.5)


def led_log(lead, *, gain=1.0, noise=0.0, as_position=True):
    """A log whose motion runs ahead of its reference, and is larger than it."""
    time = PERIOD * np.arange(8000)
    position, velocity, _ = (gain * series for series in motion(time))
    wiggle = noise * np.random.default_rng(110).standard_normal(time.size)
    measured = {"position": position + 1e-3 * wiggle} if as_position else {"velocity": velocity + wiggle}
    return Log("led", time, np.zeros_like(time), **measured, extra={"reference_velocity": motion(time - lead)[1]})


def lead_of(log):
    return motion_lead(log, [Piece(0, log.time.size)], PERIOD, BAND)


@pytest.mark.parametrize("lead", [0.0847, 0.0053, -0.0317])
@pytest.mark.parametrize("as_position", [True, False])
def test_lead_is_found_whatever_the_gear_is_said_to_be(lead, as_position):
    log = led_log(lead, gain=1.1, noise=0.01, as_position=as_position)
    assert lead_of(log) == pytest.approx(lead, abs=2e-4)
    position = replace(log, extra={"reference_position": motion(log.time - lead)[0]})
    assert lead_of(position) == pytest.approx(lead, abs=2e-4)


def test_what_is_no_delay_is_none():
    less_than_two_samples = led_log(1.5 * PERIOD)
    assert lead_of(less_than_two_samples) == 0.0
    assert lead_of(led_log(0.0, noise=0.02)) == 0.0
    assert lead_of(replace(led_log(0.05), extra={})) == 0.0
    late = led_log(0.01, as_position=False)
    other = 0.3 * np.sin(7.0 * late.time)  # a tracking error most of which no delay explains
    assert lead_of(late) == pytest.approx(0.01, abs=2e-4)
    assert lead_of(replace(late, velocity=late.velocity + other)) == 0.0
    unlike = np.random.default_rng(111).standard_normal(late.time.size)
    assert lead_of(replace(late, velocity=unlike)) == 0.0


@pytest.mark.parametrize(
    ("extra", "factor", "linear", "said"),
    [
        ({}, 1.0, False, []),
        ({}, 300.0, False, ["is the motion in degrees?"]),
        ({}, 300.0, True, []),
        ({"reference_velocity": 1.4}, 1.0, False, []),  # a gear's ratio may be known badly
        ({"reference_velocity": 57.3}, 1.0, False, ["is 0.0175 times the recorded reference: one of them is in other"]),
        ({"reference_velocity": -1.0}, 1.0, False, ["is -1 times the recorded reference"]),
        ({"reference_velocity": 0.0}, 1.0, False, []),
        ({"reference_velocity": 1.0}, 0.0, False, []),
    ],
)
def test_units_that_are_unlike_are_pointed_out(extra, factor, linear, said):
    log = led_log(0.0)
    log = replace(log, position=factor * log.position, extra={name: k * PLAN for name, k in extra.items()})
    found = doubts(log, [Piece(0, log.time.size)], PERIOD, BAND, linear=linear)
    assert len(found) == len(said)
    assert all(words in sentence for words, sentence in zip(said, found, strict=True))


def test_a_reference_that_the_motion_did_not_follow_is_pointed_out():
    log = make_log(duration=20.0, noise=0.05)
    other = replace(log, extra={"reference_velocity": np.sin(3.0 * log.time)})
    assert any("did not follow the recorded reference" in note for note in replay_log(other, inertia=2.0).notes)
    own = replace(log, extra={"reference_velocity": motion(log.time)[1]})
    assert not any("did not follow" in note for note in replay_log(own, inertia=2.0).notes)


def test_of_a_repeating_motion_the_nearest_time_is_meant():
    time = PERIOD * np.arange(4000)
    extra = {"reference_velocity": np.sin(2.0 * np.pi * (time - 0.03) / 0.2)}
    log = Log("sine", time, time, velocity=np.sin(2.0 * np.pi * time / 0.2), extra=extra)
    assert lead_of(log) == pytest.approx(0.03, abs=2e-4)


@pytest.mark.parametrize(
    ("name", "starts", "ends"),  # a velocity stays at an end of a piece, a position goes on with its velocity there
    [
        ("reference_velocity", (0.0, 25.0), (9.0, 9.0, 81.0, 81.0)),
        ("reference_position", (-1.0, 14.0), (11.5, 16.5, 89.5, 106.5)),
    ],
)
def test_pieces_are_taken_later_each_by_itself(name, starts, ends):
    time = 0.1 * np.arange(10)
    values = np.arange(10.0) ** 2
    log = Log("log", time, time, velocity=time, extra={name: values, "feedforward": values})
    pieces = [Piece(0, 4), Piece(5, 10)]
    later = as_followed(log, pieces, 0.15).extra[name]
    assert later == pytest.approx([2.5, 6.5, *ends[:2], 16.0, 42.5, 56.5, 72.5, *ends[2:]])
    earlier = as_followed(log, pieces, -0.1).extra[name]
    assert earlier == pytest.approx([starts[0], 0.0, 1.0, 4.0, 16.0, starts[1], 25.0, 36.0, 49.0, 64.0])
    assert np.array_equal(as_followed(log, pieces, 0.15).extra["feedforward"], values)
    assert np.array_equal(log.extra[name], np.arange(10.0) ** 2)
    assert as_followed(log, pieces, 0.0) is log


@pytest.mark.parametrize("lead", [0.06, -0.04])
def test_replay_is_that_of_a_reference_that_is_not_late(lead):
    log = make_log(duration=20.0, noise=0.05)
    right, late = (motion(log.time - shift)[1] for shift in (0.0, lead))
    right, late = (replace(log, extra={"reference_velocity": reference}) for reference in (right, late))
    aligned, found, untold = (
        replay_log(one, inertia=2.0, fixed=MODEL, **told)
        for one, told in ((right, {}), (late, {}), (late, {"motion_lead": 0.0}))
    )
    assert aligned.settings.motion_lead == 0.0
    assert found.settings.motion_lead == pytest.approx(lead, abs=2e-4)
    assert any("reference" in note and ("ahead" if lead > 0.0 else "behind") in note for note in found.notes)
    inner = slice(500, -100)  # what comes after the end of a log is not known
    for name in ("fixed", "adaptive"):
        least, left, most = (np.std(one.series.left[name][0][inner]) for one in (aligned, found, untold))
        assert left == pytest.approx(least, rel=0.15)  # jumps of friction fall between samples
        assert most > 3.0 * least
    again = replay_log(right, state=found.state_to_json())
    assert again.settings.motion_lead == found.settings.motion_lead


@pytest.mark.parametrize("lead", [0.06, -0.04])
@pytest.mark.parametrize("gap", [False, True])
def test_a_late_reference_position_leaves_little_more_where_a_piece_ends_in_motion(lead, gap):
    log = make_log(duration=20.0, noise=0.05)
    kept = np.ones(log.time.size, bool)
    kept[4000:4500] = not gap
    plans = (replace(log, extra={"reference_position": motion(log.time - shift)[0]}) for shift in (0.0, lead))
    aligned, found = (replay_log(only(one, kept), inertia=2.0, fixed=MODEL) for one in plans)
    assert aligned.settings.motion_lead == 0.0
    assert found.settings.motion_lead == pytest.approx(lead, abs=2e-4)
    for name in ("fixed", "adaptive"):
        # some 50 ms of acceleration are not known at an end
        assert found.left[name].whole <= aligned.left[name].whole + 0.04 * found.left["none"].whole


def only(log, kept):
    """A log without some of its samples."""
    extra = {name: series[kept] for name, series in log.extra.items()}
    return Log(log.name, log.time[kept], log.torque[kept], position=log.position[kept], extra=extra)


@pytest.mark.parametrize(
    ("lead", "message"),
    [
        (math.inf, "motion_lead = inf s is not allowed: it must be from -0.5 to 0.5 s"),
        (math.nan, "motion_lead = nan s is not allowed: it must be from -0.5 to 0.5 s"),
        (-85.0, "motion_lead = -85 s is not allowed: it must be from -0.5 to 0.5 s"),  # ms, typed for s
        ("x", "motion_lead = 'x' is not allowed: it must be a number"),
    ],
)
def test_lead_must_be_a_short_time(lead, message):
    log = make_log(duration=5.0)
    log = replace(log, extra={"reference_velocity": motion(log.time)[1]})
    with pytest.raises(InputError, match=message):
        replay_log(log, inertia=2.0, motion_lead=lead)


def test_lead_needs_a_reference():
    log = make_log(duration=5.0)
    with pytest.raises(
        InputError, match=r"log: motion_lead = 0.1 s is not allowed without a reference: it must be zero"
    ):
        replay_log(log, inertia=2.0, motion_lead=0.1)
    assert replay_log(log, inertia=2.0, fixed=MODEL, motion_lead=0.0).settings.motion_lead == 0.0


def test_notes_say_which_lead_a_saved_state_is_replayed_with():
    log = make_log(duration=10.0, noise=0.05)
    plan, ahead, late = (
        replace(log, extra={"reference_velocity": motion(log.time - s)[1]}) for s in (0.0, 0.06, -0.04)
    )
    state = replay_log(ahead, inertia=2.0, fixed=MODEL).state_to_json()

    def said(other):
        notes = replay_log(other, fixed=MODEL, state=state).notes
        return [note for note in notes if "ahead of" in note or note.startswith("In this log")]

    taken = "The motion is 60 ms ahead of the recorded reference"
    assert [note[: len(taken)] for note in said(ahead)] == [taken]
    assert said(log) == []  # without a reference there is nothing to be ahead of
    for other, own in ((late, "its motion is 40 ms behind its reference"), (plan, "no time between motion and")):
        first, second = said(other)
        assert first.startswith(taken)
        assert second.startswith(f"In this log {own}")
        assert "motion_lead is 0.06 s, as it was saved" in second
