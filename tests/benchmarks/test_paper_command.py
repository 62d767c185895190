import json

from matplotlib.figure import Figure
from typer import Typer
from typer.testing import CliRunner

from benchmarks.cases.reports import Row
from benchmarks.paper import __main__ as command
from benchmarks.paper.experiment import Experiment


def experiment(name="figure_99"):
    rows = [Row("speed [rad/s]", 0.123456), Row("reached", 3.0, "<= 4", True), Row("missed", "5, 6", "<= 4", False)]
    drawn = Figure(layout="constrained")
    drawn.subplots()
    return Experiment("Fig. 99: a thing", rows, ["It agrees."], {name: drawn})


def invoke(*arguments):
    app = Typer()
    app.command()(command.main)
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_it_prints_the_table_draws_the_figures_and_writes_the_result(monkeypatch, tmp_path):
    monkeypatch.setattr(command, "EXPERIMENTS", {"one": experiment, "two": lambda: experiment("figure_98")})
    done = invoke("--out", tmp_path / "out", "--json", tmp_path / "result" / "paper.json")
    assert done.exit_code == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["figure_98.png", "figure_99.png"]
    assert (tmp_path / "out" / "figure_98.png").read_bytes().startswith(b"\x89PNG")
    result = json.loads((tmp_path / "result" / "paper.json").read_text())
    assert (result["targets_met"], result["targets_missed"]) == (2, 2)
    assert result["experiments"][0]["rows"][1] == {"quantity": "reached", "value": 3.0, "target": "<= 4", "met": True}
    assert result["experiments"][1]["figures"] == ["figure_98"]
    missed = next(line for line in done.output.splitlines() if "missed" in line)
    assert "5, 6" in missed
    assert "NOT MET" in missed
    assert "speed [rad/s]" in done.output
    assert "- It agrees." in done.output
    assert "Wall time" in done.output


def test_nothing_is_written_where_a_folder_cannot_be_made_or_an_experiment_fails(monkeypatch, tmp_path):
    def broken():
        raise ZeroDivisionError

    monkeypatch.setattr(command, "EXPERIMENTS", {"one": experiment, "two": broken})
    (tmp_path / "file").write_text("")
    for arguments in (("--out", tmp_path / "file" / "out"), ("--out", tmp_path / "out", "--json", tmp_path)):
        done = invoke(*arguments)
        assert done.exit_code == 2  # in one line, before anything runs
        assert done.stderr.count("\n") == 1
        assert "cannot be written" in done.stderr
    done = invoke("--out", tmp_path / "out", "--json", tmp_path / "paper.json")
    assert isinstance(done.exception, ZeroDivisionError)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_every_figure_of_the_paper_has_its_experiment():
    runs = list(command.EXPERIMENTS.values())
    assert len(set(runs)) == 7
    modules = {run.__module__.removeprefix("benchmarks.paper.") for run in runs}
    assert modules == {"misprints", "reversal", "offline", "online", "rounding", "stribeck", "closed_loop"}
