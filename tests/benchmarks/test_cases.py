"""Cases of suites: synthetic logs on which the intervals of ``identify`` are counted, and recorded machines."""

import numpy as np
import pytest

from benchmarks.cases.logs import recorded
from benchmarks.cases.logs.coverage import repetition, run_driven
from benchmarks.cases.logs.drawn_logs import driven_case, make_case
from benchmarks.cases.logs.recorded import DATA, JOBS
from benchmarks.cases.other_joints import draw
from benchmarks.running import run_case
from benchmarks.suite import load_suite


@pytest.mark.parametrize("seed", [2, 3, 8, 11])
def test_records_of_a_joint_share_it_but_not_their_motion(seed):
    one, other = (make_case(seed, record=record) for record in (0, 1))
    assert one.truth["inertia"] == other.truth["inertia"]
    assert one.kind == other.kind
    assert not np.array_equal(one.log.position[:100], other.log.position[:100])
    again = make_case(seed)
    assert np.array_equal(again.log.torque, one.log.torque)


def test_repetition_agrees_within_both_half_widths():
    one = {"inertia_error": [0.0], "inertia_width": [0.03]}
    near, far = ({"inertia_error": [error], "inertia_width": [0.04]} for error in (0.049, 0.051))
    assert repetition(one, near) == {"inertia_repeats": [1.0]}
    assert repetition(one, far) == {"inertia_repeats": [0.0]}


@pytest.mark.parametrize("seed", [101, 102, 103])
def test_the_recorded_torque_is_what_the_joint_needs(seed):
    """Over the log, inertia gives back what it takes: what is left of the work is done against friction and load."""
    case = driven_case(seed)
    joint, loop, _ = draw(seed)
    log = case.log
    assert case.delay == 0.5 * loop.period
    assert (log.velocity is None) != (loop.sensor == "tachometer")
    velocity = np.gradient(log.position, log.time) if log.velocity is None else log.velocity
    friction = joint.coulomb * np.abs(velocity) + joint.viscous * velocity**2
    done = float(np.mean((log.torque - joint.load) * velocity))
    assert float(np.mean(friction)) == pytest.approx(done, rel=0.25)


@pytest.mark.nightly
def test_inertia_of_joints_that_stick_for_long_is_within_its_interval():
    found = [run_driven(seed, ["identify"])["identify"] for seed in (315, 332, 364)]
    assert [one["inertia_inside"] for one in found] == [[1.0]] * 3
    for name in ("inertia", "coulomb"):
        assert np.median([abs(one[f"{name}_error"][0]) for one in found]) < 0.05, name


def test_absent_data_are_said_with_their_source(tmp_path, monkeypatch):
    monkeypatch.setattr(recorded, "DATA", tmp_path)
    for job, case in zip(JOBS.values(), recorded.joints(), strict=True):
        refused = run_case(case, ["identify"])[""]["refused"]
        assert job.table["origin"] in refused
        assert all(file in refused for file in job.table["files"])


MISSING = JOBS["KUKA KR300 axis 6"].missing()


@pytest.mark.skipif(bool(MISSING), reason=f"the recorded data lie outside the repository and are not there: {DATA}")
def test_axis_is_identified_replayed_and_put_into_a_closed_loop():
    (case,) = [case for case in recorded.joints() if case.key == "KUKA KR300 axis 6"]
    found = run_case(case, load_suite("recorded").controllers)
    assert found[""] == {"row": "KUKA KR300 axis 6"}
    assert found["closed loop"]["pi"] > 5.0
    assert 0.0 < found["identify"]["unexplained"] < found["identify"]["validation"] + 0.2 < 0.5
    first, second = found["adaptive"]["left"]
    assert first < found["none"]["left"][0]
    assert second < found["none"]["left"][1]
    assert len(found["adaptive_saved"]["left"]) == 1
