"""Checks of the project as a whole: lint, types, import contracts, the built wheel, the least versions."""

import datetime
import re
import shutil
import sys
import tomllib
import zipfile
from functools import partial
from importlib.metadata import version
from pathlib import Path

import pytest
from exports import printed

import adaptive_ff
from docs import release

ROOT = Path(__file__).resolve().parent.parent
run = partial(printed, cwd=ROOT)


@pytest.mark.parametrize("arguments", [("check",), ("format", "--check")])
def test_ruff(arguments):
    run(sys.executable, "-m", "ruff", *arguments, ROOT)


def test_types():
    run(sys.executable, "-m", "mypy")


def test_import_contracts():
    code = "import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports())"
    assert "0 broken" in run(sys.executable, "-c", code)


DESK = ("plant", "pydantic", "rich", "matplotlib", "control", "filterpy", "typer")
NEEDED = {"lazy_loader", "numpy", "scipy"}  # packages from elsewhere that a controller may load


def loaded_by(statements, names):
    """Which of the packages or modules are loaded in a fresh process after some statements."""
    code = f"import sys; {statements}; print(*[name for name in {tuple(names)!r} if name in sys.modules])"
    return run(sys.executable, "-c", code).split()


FOREIGN = """
import sys
from adaptive_ff import AdaptiveController
AdaptiveController(1e3, 1e4, 0.01, inertia=20.0, stribeck_velocity=0.05).step(0.1, 0.0)
files = {name.partition(".")[0]: getattr(module, "__file__", None) or "" for name, module in sys.modules.items()}
print(*[name for name, file in files.items() if "site-packages" in file and not name.startswith("_")])
"""


def test_adaptive_controller_needs_numpy_and_scipy_alone():
    assert set(run(sys.executable, "-c", FOREIGN).split()) <= NEEDED


def test_all_that_would_run_on_a_robot_loads_nothing_of_the_desk():
    modules = [name for room in contracts()["robot"]["source_modules"] for name in modules_in(room)]
    assert "adaptive_ff.baselines.canudas" in modules
    assert "controllers.observers.kalman_disturbance" in modules
    assert loaded_by(f"import {', '.join(modules)}", (*DESK, "numpy")) == ["numpy"]  # which all of them need


AHEAD = """
import warnings
from adaptive_ff.cli import ahead
with ahead.collected() as wanted, warnings.catch_warnings():
    warnings.simplefilter("ignore")
    ahead.ask_for_all()
symbols = {symbol.rpartition("_")[0] for symbol in wanted}
assert symbols >= {"step_pi", "step_adaptive", "run_plain", "write_along", "learn_in_place"}, symbols
"""


def test_to_compile_ahead_needs_no_more_than_the_build_asks_for():
    packages = ("rich", "matplotlib", "control", "filterpy", "typer", "jinja2")
    assert loaded_by(f"exec({AHEAD!r})", packages) == []


def test_comparison_loads_what_it_needs():
    heavy = ["scipy.optimize", "jinja2", "control", "adaptive_ff.identify.identification"]
    draws = "import adaptive_ff.report.comparison_pictures, adaptive_ff.report.tables"
    assert loaded_by(f"from adaptive_ff import compare, load_scenario; load_scenario(); {draws}", heavy) == []


def test_import_and_help_load_nothing_heavy():
    heavy = ("matplotlib", "control", "scipy", "filterpy", "numpy", "plant", "controllers")
    helps = "; ".join(f"app({one}, standalone_mode=False)" for one in (["--help"], ["compare", "--help"]))
    shown = f"from adaptive_ff.cli.main import app; sys.stdout = sys.stderr; {helps}; sys.stdout = sys.__stdout__"
    assert loaded_by(f"import adaptive_ff; adaptive_ff.__version__; {shown}", heavy) == []


def contracts():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    return {"robot": next(contract for contract in settings if contract["type"] == "forbidden")}


def modules_in(name):
    path = ROOT / name.replace(".", "/")
    return [f"{name}.{file.stem}" for file in sorted(path.glob("[!_]*.py"))] if path.is_dir() else [name]


def test_contract_of_the_robot_names_all_of_controllers_but_the_design():
    entries = (ROOT / "controllers").iterdir()
    found = {path.stem for path in entries if path.suffix == ".py" or (path / "__init__.py").exists()}
    listed = {name.partition(".")[2] for name in contracts()["robot"]["source_modules"] if "controllers." in name}
    assert listed == found - {"__init__", "design"}


def test_versions_agree():
    assert set(release.versions().values()) == {adaptive_ff.__version__} == {version("adaptive-ff")}


def test_release_writes_version_and_date(tmp_path):
    for name in release.PLACES:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    (tmp_path / "docs/changelog.md").write_text("# Changelog\n\n## 0.1.0 (unreleased)\n\nNew.\n")
    release.set_version("7.2.0rc1", datetime.date(2030, 1, 2), tmp_path)
    assert set(release.versions(tmp_path).values()) == {"7.2.0rc1"}
    assert "## 7.2.0rc1 (2030-01-02)" in (tmp_path / "docs/changelog.md").read_text()
    with pytest.raises(ValueError, match="say what is new"):
        release.set_version("7.3.0", datetime.date(2030, 1, 3), tmp_path)
    with pytest.raises(ValueError, match="is not allowed"):
        release.set_version("seven", datetime.date(2030, 1, 3), tmp_path)


@pytest.mark.nightly
def test_wheel_and_sdist_hold_all_packages(tmp_path):
    wheel, sdist = release.build(tmp_path)
    assert release.missing(wheel, sdist) == []
    assert not any(name.startswith(("tests/", "benchmarks/")) for name in zipfile.ZipFile(wheel).namelist())


@pytest.mark.nightly
def test_installed_wheel_compares_outside_the_repository(tmp_path):
    assert "are in results" in release.installed_runs(release.build(tmp_path)[0])


PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]

SMOKE = """
import numpy as np
from adaptive_ff import compare, identify_log, load_scenario, read_log
found = compare(load_scenario().modified(duration=10.0, controllers=["pi", "adaptive"]))
assert found.improvement["adaptive"] > 1.0
found.plot("pictures")
run = found.runs["adaptive"]
time = 0.01 * np.arange(run.measured.size)
table = np.column_stack([time, run.measured, run.torque])
np.savetxt("log.csv", table, delimiter=",", header="time,velocity,torque", comments="")
identified = identify_log(read_log("log.csv", torque="torque", velocity="velocity", time="time"))
print("identified", identified)
"""


def lower_bounds():
    """Each dependency with the ``==`` of its lower bound."""
    found = dict(re.match(r"([\w-]+)>=([\d.]+)", entry).groups() for entry in PROJECT["dependencies"])
    return [f"{name}=={version}" for name, version in found.items()]


def test_every_dependency_has_a_lower_bound():
    assert len(lower_bounds()) == len(PROJECT["dependencies"])
    assert "numpy==1.26" in lower_bounds()


@pytest.mark.nightly
def test_an_installation_of_the_lower_bounds_works(tmp_path):
    oldest = ".".join(map(str, sys.version_info[:2]))
    if f">={oldest}" != PROJECT["requires-python"]:
        pytest.skip(f"the oldest versions are those for Python {PROJECT['requires-python']}, this is {oldest}")
    constraints = tmp_path / "lowest.txt"
    constraints.write_text("\n".join(lower_bounds()))
    place = tmp_path / "venv"
    run(sys.executable, "-m", "venv", place)
    python = place / "bin" / "python"
    run(python, "-m", "pip", "install", "--quiet", "-c", constraints, ROOT)
    assert "identified" in run(python, "-c", SMOKE, cwd=tmp_path)
    assert "Run a joint" in run(place / "bin" / "adaptive-ff", "compare", "--help", cwd=tmp_path)
