"""Exciting motions: they keep their limits, begin at rest, tell more than others, and read back as they are."""

import dataclasses
import functools
import json
import math
import tomllib

import numpy as np
import pytest
from command_line import run_command_line, search_shortly
from scenario_files import refused

from adaptive_ff import InputError, load_scenario
from adaptive_ff.scenario.waves import Fourier
from adaptive_ff.studies import exciting_motion as glue
from adaptive_ff.studies.motion import NAMES, AssumedJoint, MotionLimits, MotionSearch, information, interval_sizes

JOINT = AssumedJoint(20.0, 60.0, 90.0, 80.0, 0.05, 0.1)
ONES = np.ones(len(NAMES))
SCENARIO = load_scenario()
MINUTE = interval_sizes(information(JOINT, glue.yardstick(SCENARIO).reference_velocity()[None, ::20], 0.02))[0]


REACHED = {"velocity": MotionLimits(0.2), "position": MotionLimits(1.0, position=0.05)}
REACHED |= {"acceleration": MotionLimits(1.0, acceleration=0.5), "torque": MotionLimits(2.0, torque=120.0)}


@pytest.mark.parametrize(("reached", "limits"), REACHED.items())
def test_motion_keeps_its_limits_and_reaches_one_and_begins_and_ends_at_rest_where_it_began(limits, reached):
    (motion,) = glue.find_excitations(JOINT, limits, ONES, period=4.0, starts=1)
    columns = motion.columns(0.0005)
    sizes = {name: float(np.max(np.abs(columns[name]))) for name in ("position", "velocity", "acceleration")}
    torque = np.abs(20.0 * columns["acceleration"] + 80.0 * columns["velocity"]) + 90.0
    sizes["torque"] = float(np.max(torque))
    for name, size in sizes.items():
        limit = getattr(limits, name)
        assert limit is None or size <= limit
        assert size == pytest.approx(motion.largest[name], rel=1e-3)
    assert sizes[reached] == pytest.approx(getattr(limits, reached), rel=1e-2)
    for name in ("position", "velocity", "acceleration"):
        assert columns[name][[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-6)
    velocity = np.gradient(columns["position"], 0.0005)
    assert np.max(np.abs(velocity - columns["velocity"])[1:-1]) <= 1e-4
    drawn = motion.reference.velocity(columns["time"], np.random.default_rng(0))
    np.testing.assert_allclose(columns["velocity"], drawn, rtol=1e-6, atol=1e-12)


def test_search_finds_more_than_chance():
    motions = glue.find_excitations(JOINT, MotionLimits(1.0), ONES, period=6.0, starts=1)
    best = max(motions[0].sizes.values())
    grid = np.arange(600) * 0.01
    generator = np.random.default_rng(0)
    for _ in range(20):
        cosines, sines = generator.standard_normal((2, 12))
        one = Fourier(kind="fourier", period=6.0, cosines=cosines.tolist(), sines=sines.tolist())
        velocity = one.velocity(grid, generator)
        velocity /= np.max(np.abs(velocity))
        assert np.max(interval_sizes(information(JOINT, velocity[None, :], 0.01))) > best


def test_information_of_a_motion_that_never_slides_is_none():
    still, moving = np.full((1, 100), 1e-4), np.sin(0.1 * np.arange(630))[None, :]
    least = [np.min(interval_sizes(information(JOINT, one, 0.01))) for one in (still, moving)]
    assert least[0] > 1e3 * least[1]


def test_best_candidate_in_simulation_is_taken_and_its_sizes_told(monkeypatch):
    search_shortly(monkeypatch)
    shares = []
    limits = glue.default_limits(SCENARIO)
    motion = glue.exciting_motion(SCENARIO, limits, period=5.0, fastest=1.0, progress=shares.append)
    table = motion.reference.model_dump()
    runs = glue.yardstick(SCENARIO), *(glue.with_motion(SCENARIO, table, time) for time in (5.0, 10.0))
    base, once, twice = (glue.interval_widths(one, glue.TRIAL_SEEDS) for one in runs)
    assert motion.sizes == {name: max(once[name], twice[name]) / base[name] for name in NAMES}
    assert max(motion.sizes.values()) < 20.0
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def by_information(motion):
    """Return the intervals of a motion over those of a minute, by information, with three times that of the lag."""
    velocity = motion.columns(0.01)["velocity"][None, :-1]
    sizes = dict(zip(NAMES, interval_sizes(information(JOINT, velocity, 0.01))[0] / MINUTE, strict=True))
    return {**sizes, "friction_lag": 3.0 * sizes["friction_lag"]}


SEARCH = functools.partial(glue.find_excitations, JOINT, MotionLimits(1.4), MINUTE, fastest=[1.0], starts=1)


def test_search_goes_by_what_trials_gave():
    (first,), (later,) = (SEARCH(rounds=rounds, trial=by_information) for rounds in (1, 6))
    assert max(first.sizes, key=first.sizes.get) == "friction_lag"
    assert max(later.sizes.values()) < 0.7 * max(first.sizes.values())
    assert later.sizes == by_information(later)


def test_search_goes_on_where_a_ratio_is_unknown():
    def trial(motion):
        return {**by_information(motion), "friction_lag": math.nan}

    (motion,) = SEARCH(rounds=2, trial=trial)
    assert math.isnan(motion.sizes["friction_lag"])
    assert motion.widest == math.inf
    assert motion.reference == SEARCH(rounds=1)[0].reference  # none is better than another, so the first stays


def test_dwelling_start_has_more_information_than_chance():
    search = MotionSearch(JOINT, MotionLimits(1.4), 10.0, 20)
    dwelling, drawn = (
        [np.max(search.sizes(start(np.random.default_rng(turn))) / MINUTE) for turn in range(10)]
        for start in (search.plateau_start, search.random_start)
    )
    assert np.median(dwelling) < 0.5 * np.median(drawn)


def test_polishing_keeps_limits_and_improves():
    limits = MotionLimits(1.0, position=0.5)
    (motion,) = glue.find_excitations(JOINT, limits, ONES, period=4.0, starts=1, rounds=1, trial=by_information)
    better = glue.polished(JOINT, motion, by_information, trials=40)
    assert glue.polished(JOINT, motion, by_information, trials=0) is motion
    assert max(better.sizes.values()) < max(motion.sizes.values())
    columns = better.columns(0.0005)
    assert np.max(np.abs(columns["velocity"])) <= 1.0
    assert np.max(np.abs(columns["position"])) <= 0.5


def test_default_limits_follow_the_drive():
    limits = glue.default_limits(SCENARIO)
    assert limits == MotionLimits(pytest.approx(1.4), None, None, pytest.approx(280.0))
    assert glue.default_limits(SCENARIO, torque=150.0).velocity == pytest.approx((150.0 - 90.0) / 80.0)
    narrow = glue.default_limits(SCENARIO, velocity=0.2, position=1.0)
    assert narrow == MotionLimits(0.2, 1.0, None, pytest.approx(280.0))
    with pytest.raises(InputError, match="torque = 80 N m is not allowed: it must be more than the stiction, 90 N m"):
        glue.default_limits(SCENARIO, torque=80.0)
    assert glue.assumed_joint(SCENARIO).stiction == 90.0


@pytest.mark.parametrize(
    ("limits", "arguments", "said"),
    [
        (MotionLimits(-1.0), {}, "velocity = -1 is not allowed: it must be positive and finite"),
        (MotionLimits(1.0, position=float("nan")), {}, "position = nan is not allowed"),
        (MotionLimits(1.0, torque=90.0), {}, "torque = 90 N m is not allowed: it must be more than the stiction"),
        (MotionLimits(1.0), {"period": 1.0}, "make 2 harmonics; there must be from 3 to 60"),
    ],
)
def test_wrong_limits_are_refused(limits, arguments, said):
    assert said in refused("", glue.find_excitations, JOINT, limits, ONES, **arguments)


def test_wrong_series_and_a_motion_that_shows_nothing_are_refused():
    with pytest.raises(InputError, match="the motion is too small to show anything of the joint"):
        interval_sizes(np.zeros((1, len(NAMES), len(NAMES))))
    table = {"kind": "fourier", "period": 2.0, "cosines": [1.0], "sines": [1.0, 2.0]}
    with pytest.raises(InputError, match="sines has 2 values, cosines has 1; there must be as many"):
        SCENARIO.modified(reference=table)
    with pytest.raises(InputError, match="all zero"):
        SCENARIO.modified(reference={**table, "cosines": [0.0], "sines": [0.0]})


def test_command_writes_a_motion_that_reads_back(tmp_path, monkeypatch):
    search_shortly(monkeypatch)
    limits = ("--period", 5, "--fastest", 1, "--velocity", 0.5)
    outcome = run_command_line("excite", *limits, "--out", tmp_path / "out", "--report")
    assert outcome.status == 0, outcome.err
    assert "95 % intervals over those of 60 s of multisine" in outcome.out
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"report.html", *(f"excitation.{ending}" for ending in ("csv", "toml", "json", "png"))}
    table = tomllib.loads((tmp_path / "out" / "excitation.toml").read_text())["reference"]
    series = SCENARIO.modified(duration=5.0, reference=table).reference_velocity()
    recorded = {"kind": "csv", "path": str(tmp_path / "out" / "excitation.csv")}
    again = SCENARIO.modified(duration=5.0, reference=recorded).reference_velocity()
    assert np.max(np.abs(again - series)) <= 2e-4
    assert np.max(np.abs(series)) <= 0.5
    content = json.loads((tmp_path / "out" / "excitation.json").read_text())
    assert set(content["intervals_over_multisine"]) == set(NAMES)
    assert content["limits"] == dataclasses.asdict(MotionLimits(0.5, None, None, pytest.approx(280.0)))
