"""Where the runs of a command are done, and the signal that asks it to end: nothing half written stays."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import threading

import pytest
from command_line import content_of, run_command_line

from adaptive_ff import load_scenario
from adaptive_ff.cli import cluster
from adaptive_ff.cli.main import ending_in_order
from adaptive_ff.errors import InputError
from adaptive_ff.studies.sweep import sweep as run_sweep

of_posix = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")

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


@of_posix
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


@of_posix
def test_library_installs_no_handler_and_the_command_line_takes_its_own_away():
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
    assert run_command_line("version").status == 0
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


@of_posix
def test_handler_of_somebody_else_stays():
    def other(number, frame):
        raise AssertionError

    signal.signal(signal.SIGTERM, other)
    try:
        with ending_in_order():
            assert signal.getsignal(signal.SIGTERM) is other
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


@of_posix
def test_a_thread_cannot_handle_signals_and_runs_all_the_same():
    seen = []

    def run():
        with ending_in_order():
            seen.append(signal.getsignal(signal.SIGTERM))

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    assert seen == [signal.SIG_DFL]


JOINT = ("--inertia", "0.5", "--torque", "20", "--speed", "6")


@pytest.fixture
def distributed():
    """The package, which takes a second to load: not while tests are collected."""
    return pytest.importorskip("distributed")


@pytest.fixture
def address(distributed):
    """Address of a scheduler with two worker processes."""
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as running:
        yield running.scheduler_address


@pytest.mark.filterwarnings("ignore")  # what the cluster's own modules warn of is not ours
@pytest.mark.nightly
def test_sweep_on_two_worker_processes_outlives_one_of_them_and_goes_on_where_it_stopped(
    distributed, address, tmp_path
):
    file = tmp_path / "joint.toml"
    file.write_text("duration = 3.0\n" + run_command_line("new", *JOINT).out, encoding="utf-8")
    folder, shares = tmp_path / "there", []

    def kill_one_then_stop(share):
        shares.append(share)
        if len(shares) == 2:
            os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)
        if len(shares) == 5:
            raise KeyboardInterrupt

    with distributed.Client(address) as client:
        given = {"folder": folder, "executor": client.get_executor(), "progress": kill_one_then_stop}
        with pytest.raises(KeyboardInterrupt):
            run_sweep(load_scenario(file), 8, **given)
    assert shares == [count / 8 for count in range(1, 6)]
    sweep = ("sweep", str(file), "--runs", "8", "--out")
    done = run_command_line(*sweep, str(folder), "--scheduler", address)
    assert done.status == 0, done.err
    lines = (folder / "sweep-1.jsonl").read_text(encoding="utf-8").splitlines()
    kept = [json.loads(line)[:2] for line in lines]
    assert sorted(kept) == [[str(draw), name] for draw in range(8) for name in ("", "adaptive", "oracle", "pi")]
    assert run_command_line(*sweep, str(tmp_path / "here")).status == 0
    there, here = (json.loads((tmp_path / name / "sweep.json").read_text()) for name in ("there", "here"))
    assert there == here


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("command", "address"), [("sweep", "nothing"), ("matrix", "tcp://127.0.0.1:9")])
def test_scheduler_that_does_not_answer_is_refused_in_one_line(distributed, command, address, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "PATIENCE", 1)
    monkeypatch.setattr(distributed, "Client", pytest.fail)  # one that finds nobody may block the next one
    done = run_command_line(command, "--scheduler", address, "--out", str(tmp_path / "out"))
    assert done.status == 2
    message = [line for line in done.messages if "--scheduler" in line]
    assert len(message) == 1
    assert f"--scheduler = {address} is not allowed" in message[0]


def test_client_that_does_not_begin_is_an_error_in_one_line(distributed, monkeypatch):
    def stalled(address, timeout):
        assert not address  # as its own thread leaves it that has not begun in time

    monkeypatch.setattr(cluster, "_call", lambda *_: asyncio.sleep(0.0))
    monkeypatch.setattr(distributed, "Client", stalled)
    with (
        pytest.raises(InputError, match="--scheduler = tcp://there:1 is not allowed"),
        cluster.workers("tcp://there:1"),
    ):
        pass
