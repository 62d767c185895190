"""The signal that asks a command to end: nothing half written stays, and its workers end with it."""

import os
import signal
import subprocess
import sys
import threading

import pytest
from command_line import content_of, run_command_line

from adaptive_ff.cli.main import ending_in_order
from plant import JointModel

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")

COMMAND = """
import sys, time
from unittest.mock import patch
from adaptive_ff.cli.main import main
from adaptive_ff.workers import pool_of_workers

def compare(*_, **__):
    pool = pool_of_workers(2)
    try:
        futures = [pool.submit(time.sleep, 600.0) for _ in range(2)]
        print(*pool._processes, flush=True)
        futures[0].result()
    finally:
        pool.shutdown(cancel_futures=True)

if __name__ == "__main__":
    with patch("adaptive_ff.comparison.comparison.compare", compare):
        main()
"""


def test_command_that_is_asked_to_end_leaves_nothing_and_waits_for_no_worker(tmp_path):
    script = tmp_path / "command.py"
    script.write_text(COMMAND)
    before = content_of(tmp_path)
    command = [sys.executable, str(script), "compare", "--out", str(tmp_path / "new" / "out")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    workers = [int(number) for number in process.stdout.readline().split()]
    staged = list((tmp_path / "new" / "out").glob(".unfinished-*"))
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=60.0)
    assert (len(workers), len(staged)) == (2, 1)
    assert process.returncode == 143
    assert "Traceback" not in err
    assert content_of(tmp_path) == before


def test_library_installs_no_handler_and_the_command_line_takes_its_own_away():
    assert JointModel is not None  # the packages are imported
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
    assert run_command_line("version").status == 0
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


def test_handler_of_somebody_else_stays():
    def other(number, frame):
        raise AssertionError

    signal.signal(signal.SIGTERM, other)
    try:
        with ending_in_order():
            assert signal.getsignal(signal.SIGTERM) is other
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def test_a_thread_cannot_handle_signals_and_runs_all_the_same():
    seen = []

    def run():
        with ending_in_order():
            seen.append(signal.getsignal(signal.SIGTERM))

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    assert seen == [signal.SIG_DFL]
