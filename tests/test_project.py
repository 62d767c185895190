"""Checks of the project as a whole: lint, types, import contracts, the built wheel."""

import shutil
import subprocess
import sys
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


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """A wheel built from a copy of the sources, so that no old build folder leaks into it."""
    source = tmp_path_factory.mktemp("source")
    for name in ("adaptive_ff", "plant", "controllers"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source / name)
    target = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", target, source, **environment())
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


def test_installed_wheel_compares_outside_the_repository(wheel, tmp_path):
    site = tmp_path / "site"
    run(sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", site, wheel, **environment())
    work = tmp_path / "work"
    work.mkdir()
    code = (
        "import sys, adaptive_ff, plant, controllers; from adaptive_ff.cli.main import main; "
        f"assert all(m.__file__.startswith({str(site)!r}) for m in (adaptive_ff, plant, controllers)); "
        "sys.argv = ['adaptive-ff', 'compare', '--out', 'out']; main()"
    )
    printed = run(sys.executable, "-c", code, cwd=work, **environment(PYTHONPATH=str(site)))
    assert "adaptive_paper" in printed
    assert (work / "out" / "result.json").stat().st_size > 0
    assert (work / "out" / "tracking.png").read_bytes().startswith(b"\x89PNG")
