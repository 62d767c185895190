"""What processes that are killed leave behind: temporary folders, and workers."""

import os
import signal
import subprocess
import sys
import time

import pytest

from adaptive_ff.errors import InputError
from adaptive_ff.files import REPLACING, UNFINISHED, _owner, staged

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")


def ended_process():
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def owner_that_ended():
    return f"{_owner().partition('-')[0]}-{ended_process()}-"


def test_the_stage_of_a_process_that_ended_is_removed_and_that_of_a_running_one_stays(tmp_path):
    (tmp_path / f"{UNFINISHED}{owner_that_ended()}x").mkdir()
    running = tmp_path / f"{UNFINISHED}{_owner()}y"
    elsewhere = tmp_path / f"{UNFINISHED}00000000-{ended_process()}-z"
    running.mkdir()
    elsewhere.mkdir()
    with staged(tmp_path) as stage:
        (stage / "new.txt").write_text("new")
    assert sorted(tmp_path.iterdir()) == sorted([running, elsewhere, tmp_path / "new.txt"])


def test_a_set_that_was_being_moved_is_completed(tmp_path):
    left = tmp_path / f"{REPLACING}{owner_that_ended()}x"
    left.mkdir()
    (left / "second.txt").write_text("new")
    (tmp_path / "first.txt").write_text("new")  # moved already
    (tmp_path / "second.txt").write_text("old")
    with staged(tmp_path) as stage:
        (stage / "other.txt").write_text("other")
    assert (tmp_path / "second.txt").read_text() == "new"
    assert not left.exists()


@pytest.mark.parametrize("after", [None, 1, 2, 3], ids=["refused", "interrupted", "after two", "after three"])
def test_where_one_file_cannot_be_moved_or_the_move_is_interrupted_the_others_come_back(tmp_path, monkeypatch, after):
    for name in ("a.txt", "b.txt"):
        (tmp_path / name).write_text("old")
    move, done = os.replace, []

    def failing(source, target):
        if after is None and str(target) == str(tmp_path / "b.txt") and "kept" not in str(source):
            raise OSError(28, "No space left on device")
        move(source, target)
        done.append(target)
        if after is not None and len(done) == 1 + after:  # the first one renames the stage
            raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", failing)

    def write_all():
        with staged(tmp_path) as stage:
            for name in ("a.txt", "b.txt", "c.txt"):
                (stage / name).write_text("new")

    error, said = (InputError, "No space left") if after is None else (KeyboardInterrupt, None)
    with pytest.raises(error, match=said):
        write_all()
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a.txt": "old", "b.txt": "old"}


PARENT = """
import os, time
from adaptive_ff.workers import pool_of_workers

if __name__ == "__main__":
    pool = pool_of_workers(2)
    futures = [pool.submit(time.sleep, 600.0) for _ in range(2)]
    print(*pool._processes, flush=True)
    time.sleep(600.0)
"""


def has_ended(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return True
    try:  # one that ended and was not waited for, as there is no parent that does
        with open(f"/proc/{number}/stat") as stream:
            return stream.read().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def test_workers_end_with_a_parent_that_is_killed(tmp_path):
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    parent = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True)
    workers = [int(number) for number in parent.stdout.readline().split()]
    assert len(workers) == 2
    time.sleep(0.3)
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    parent.stdout.close()
    for _ in range(300):
        if all(map(has_ended, workers)):
            break
        time.sleep(0.1)
    assert all(map(has_ended, workers))
