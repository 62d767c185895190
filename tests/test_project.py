"""Checks of the project as a whole: lint, types, import contracts, the built wheel."""

import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def run(*command, cwd=ROOT, **environment):
    done = subprocess.run(
        [str(part) for part in command], cwd=cwd, capture_output=True, text=True, env=environment or None, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("arguments", [("check",), ("format", "--check")])
def test_ruff(arguments):
    run(sys.executable, "-m", "ruff", *arguments, ROOT)


def test_types():
    run(sys.executable, "-m", "mypy")


def test_import_contracts():
    code = "import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports())"
    assert "0 broken" in run(sys.executable, "-c", code)


DESK = ("plant", "pydantic", "rich", "matplotlib", "control", "filterpy", "typer")


def loaded_by(statements, names):
    """Which of the packages or modules are loaded in a fresh process after some statements."""
    code = f"import sys; {statements}; print(*[name for name in {tuple(names)!r} if name in sys.modules])"
    return run(sys.executable, "-c", code).split()


def test_adaptive_controller_loads_nothing_of_the_desk():
    assert loaded_by("import adaptive_ff.adaptive.controller", DESK) == []


def test_all_that_would_run_on_a_robot_loads_nothing_of_the_desk():
    modules = [name for room in contracts()["robot"]["source_modules"] for name in modules_in(room)]
    assert "adaptive_ff.baselines.canudas" in modules
    assert "controllers.observers.kalman_disturbance" in modules
    assert loaded_by(f"import {', '.join(modules)}", DESK) == []


def test_package_loads_lazily():
    assert loaded_by("import adaptive_ff", ["matplotlib", "control", "scipy.signal"]) == []
    assert loaded_by("import control", ["control"]) == ["control"]  # the question can be answered with yes


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


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """A wheel built from a copy of the sources, so that no old build folder leaks into it."""
    source = tmp_path_factory.mktemp("source")
    for name in ("adaptive_ff", "plant", "controllers"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "build_backend.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source / name)
    target = tmp_path_factory.mktemp("wheel")
    options = ("--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", target)
    run(sys.executable, "-m", "pip", "wheel", *options, source, **environment())
    (built,) = target.glob("*.whl")
    return built


def environment(**more):
    import os

    return {**os.environ, **more}


def test_wheel_contains_all_packages(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    for package in ("adaptive_ff", "plant", "controllers"):
        modules = {str(path.relative_to(ROOT)) for path in (ROOT / package).rglob("*.py")}
        assert modules <= set(names)
    assert "adaptive_ff/scenario/reference_joint.toml" in names
    assert not any(name.startswith(("tests/", "benchmarks/")) for name in names)


@pytest.mark.nightly
def test_installed_wheel_compares_outside_the_repository(wheel, tmp_path):
    site = tmp_path / "site"
    run(sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", site, wheel, **environment())
    work = tmp_path / "work"
    work.mkdir()
    code = (
        "import sys, adaptive_ff, plant, controllers; from adaptive_ff.cli.main import main; "
        f"assert all(m.__file__.startswith({str(site)!r}) for m in (adaptive_ff, plant, controllers)); "
        "from adaptive_ff import load_scenario; from adaptive_ff.scenario.file import to_toml; "
        "short = load_scenario().modified(duration=1.0, controllers=['pi']); "
        "open('short.toml', 'w', encoding='utf-8').write(to_toml(short)); "
        "sys.argv = ['adaptive-ff', 'compare', 'short.toml', '--out', 'out']; main()"
    )
    printed = run(sys.executable, "-c", code, cwd=work, **environment(PYTHONPATH=str(site)))
    assert printed.rstrip().endswith("are in out")
    assert (work / "out" / "result.json").stat().st_size > 0
    assert (work / "out" / "tracking.png").read_bytes().startswith(b"\x89PNG")
