"""The stated minimum versions are enough: an installation of the lower bounds compares and identifies.

It takes minutes (a download, an installation, a first compilation), so it runs nightly.
"""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
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


def run(*command, cwd=ROOT):
    done = subprocess.run([str(part) for part in command], cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
