"""The engine: what runs, what is kept, and where it runs."""

import os
import sys
import threading

import pytest

from adaptive_ff.errors import InputError
from adaptive_ff.studies import study
from adaptive_ff.studies.study import Store, run_study

CASES = {f"case {number}": number for number in range(4)}


class Counting:
    """Runs a case as a sum of its number and the length of a name, and notes what it was asked for."""

    def __init__(self):
        self.calls = []

    def __call__(self, case, names):
        self.calls.append((case, tuple(names)))
        return {"": case % 2, **{name: case + len(name) for name in names}}


def test_what_is_missing_of_every_controller_on_every_case_is_run_and_what_is_kept_is_not(tmp_path):
    file, first, second = tmp_path / "kept" / "runs.jsonl", Counting(), Counting()
    run_study(first, dict(list(CASES.items())[:2]), ["pi"], store=Store(file, "now"), workers=1)
    found = run_study(second, CASES, ["pi", "adaptive"], store=Store(file, "now"), workers=1)
    assert second.calls[:2] == [(0, ("adaptive",)), (1, ("adaptive",))]
    assert second.calls[2] == (2, ("pi", "adaptive"))
    assert list(found) == list(CASES)
    assert found["case 1"] == {"": 1, "pi": 3, "adaptive": 9}
    assert found["case 3"] == {"": 1, "pi": 5, "adaptive": 11}
    third = Counting()
    assert run_study(third, CASES, ["pi", "adaptive"], store=Store(file, "now"), workers=1) == found
    assert third.calls == []


def test_results_of_other_code_and_lines_that_were_cut_short_do_not_count(tmp_path):
    file, again = tmp_path / "runs.jsonl", Counting()
    run_study(Counting(), CASES, ["pi"], store=Store(file, "before"), workers=1)
    file.write_text(file.read_text() + '["case 0","pi","now",')
    run_study(again, CASES, ["pi"], store=Store(file, "now"), workers=1)
    assert len(again.calls) == 4


def test_a_controller_without_a_mark_is_not_kept_and_one_with_another_mark_runs_again(tmp_path):
    file = tmp_path / "runs.jsonl"
    marks = {"object": None, "own": "1"}
    run_study(Counting(), CASES, ["pi", "object", "own"], store=Store(file, "now", marks), workers=1)
    again = Counting()
    run_study(again, CASES, ["pi", "object", "own"], store=Store(file, "now", {**marks, "own": "2"}), workers=1)
    assert {names for _, names in again.calls} == {("object", "own")}


def test_results_are_written_as_they_come(tmp_path):
    file = tmp_path / "runs.jsonl"

    def interrupted(case, names):
        if case == 2:
            raise KeyboardInterrupt
        return {"": 0, "pi": case}

    with pytest.raises(KeyboardInterrupt):
        run_study(interrupted, CASES, ["pi"], store=Store(file, "now"), workers=1)
    assert Store(file, "now").read("case 1", ["pi"]) == {"": 0, "pi": 1}


def test_all_but_the_first_go_to_the_executor_and_progress_reaches_one(one_thread):
    here, seen, shares = threading.get_ident(), {}, []

    def run(case, names):
        seen[case] = threading.get_ident()
        return {"": 0, **dict.fromkeys(names, case)}

    run_study(run, CASES, ["pi"], executor=one_thread, progress=shares.append)
    assert seen[0] == here
    assert here not in {seen[case] for case in (1, 2, 3)}
    assert shares == [0.25, 0.5, 0.75, 1.0]


def test_a_file_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        run_study(Counting(), CASES, ["pi"], store=Store(tmp_path / "taken" / "runs.jsonl", "now"), workers=1)


def process(case, names):
    return {"": os.getpid(), **dict.fromkeys(names, 0)}


@pytest.mark.parametrize("compiled", [True, False])
def test_two_workers_of_what_is_not_compiled_are_processes_that_run_all_but_the_first(compiled, monkeypatch):
    monkeypatch.setattr(study, "compiles", lambda: compiled)
    found = run_study(process, CASES, ["pi"], workers=2, threads=not compiled)
    assert [one[""] == os.getpid() for one in found.values()] == [True, False, False, False]


def test_workers_of_what_is_compiled_are_threads_that_take_short_turns():
    def thread(case, names):
        return {"": (threading.get_ident(), sys.getswitchinterval()), **dict.fromkeys(names, 0)}

    before = sys.getswitchinterval()
    found = run_study(thread, CASES, ["pi"], workers=2, threads=True)
    (here, first), *others = (one[""] for one in found.values())
    assert (here, first) == (threading.get_ident(), before)
    assert max(turn for _, turn in others) == pytest.approx(1e-5)
    assert here not in {ident for ident, _ in others}
    assert sys.getswitchinterval() == before
