import json

import pytest

from adaptive_ff.cli import cluster
from tests.helpers.command_line import run_command_line

distributed = pytest.importorskip("distributed")


@pytest.mark.filterwarnings("ignore")  # what the cluster's own modules warn of is not ours
def test_sweep_on_a_cluster_has_the_figures_of_one_here(tmp_path):
    scenario = tmp_path / "joint.toml"
    made = run_command_line("new", "--inertia", "0.5", "--torque", "20", "--speed", "6")
    scenario.write_text("duration = 3.0\n" + made.out, encoding="utf-8")
    sweep = ("sweep", str(scenario), "--runs", "4", "--out")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None
    ) as running:
        done = run_command_line(*sweep, str(tmp_path / "there"), "--scheduler", running.scheduler_address)
    assert done.status == 0, done.err
    assert run_command_line(*sweep, str(tmp_path / "here")).status == 0
    there, here = (json.loads((tmp_path / name / "sweep.json").read_text()) for name in ("there", "here"))
    assert there == here


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("command", ["sweep", "matrix"])
@pytest.mark.parametrize("address", ["nothing", "tcp://127.0.0.1:9"])
def test_scheduler_that_does_not_answer_is_refused_in_one_line(command, address, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "PATIENCE", 1)
    done = run_command_line(command, "--scheduler", address, "--out", str(tmp_path / "out"))
    assert done.status == 2
    message = [line for line in done.messages if "--scheduler" in line]
    assert len(message) == 1
    assert f"--scheduler = {address} is not allowed" in message[0]
