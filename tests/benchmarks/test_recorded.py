"""The suite of recorded machines: what it does with data and without."""

import pytest

from benchmarks.cases import recorded
from benchmarks.cases.recorded import DATA, JOBS
from benchmarks.running import run_case
from benchmarks.suite import load_suite


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
