"""Compiled kernels on disk: where they are, made by two processes at once, and not at all without a compiler."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import patch

import numpy as np
import pytest
from kernels_from_text import compiling

from controllers import Inputs, Output
from controllers.kernels import compiler
from controllers.kernels import library as MODULE
from controllers.kernels.language import call
from controllers.native import TORQUE, CalledBack

SCRIPT = """
import sys, warnings
sys.path.insert(0, sys.argv[1])
from kernels import kernel
from controllers import PI, compiled
warnings.simplefilter("always")
print(compiled(kernel)(3.0), PI(100.0, 2000.0, 0.01).step(0.5, 0.1))
"""


def running(tmp_path, **variables):
    line, known = [sys.executable, "-c", SCRIPT, str(tmp_path)], compiling(tmp_path / "cache", **variables)
    return subprocess.Popen(line, env=known, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_on_macos_a_compiler_that_is_not_installed_is_asked_for_without_being_called(monkeypatch):
    called = []
    monkeypatch.setattr(sys, "platform", "darwin")
    monkeypatch.setattr("subprocess.run", lambda line, **_: called.append(line) or subprocess.CompletedProcess(line, 1))
    assert not compiler._works(["cc"])
    assert called == [["xcode-select", "-p"]]


def test_kernels_that_came_with_the_package_are_looked_for_first_and_what_is_collected_is_not_compiled(tmp_path):
    with patch.object(MODULE, "BUILT", tmp_path):
        assert MODULE.folders() == [tmp_path, MODULE.cache_directory()]
    with MODULE.collected() as wanted, pytest.raises(compiler.NoCompiler, match="one is to be compiled together"):
        MODULE.loaded("key", "one", str)
    assert list(wanted) == ["one"]


def test_what_nobody_has_asked_for_in_thirty_days_is_removed_and_what_is_asked_for_begins_anew(tmp_path, monkeypatch):
    now, limit = 1_700_000_000, 1_700_000_000 - 30 * 86400
    monkeypatch.setattr(MODULE, "_writable_root", lambda: tmp_path)
    monkeypatch.setattr(MODULE, "cache_directory", MODULE.cache_directory.__wrapped__)
    monkeypatch.setattr(MODULE, "time", SimpleNamespace(time=lambda: float(now)))
    own, other, old = MODULE.cache_directory(), tmp_path / "kernels-other", tmp_path / "kernels-old"
    ages = {own / "old.so": limit - 1, own / "asked.so": limit - 1}
    for folder, age in {own: limit - 1, other: limit, old: limit - 1}.items():
        folder.mkdir(exist_ok=True)
        ages |= {folder / "one.so": limit, folder: age}
    for path, age in ages.items():
        if path.suffix:
            path.touch()
        os.utime(path, (age, age))
    MODULE._keep(own / "gone.so", own / "asked.so")
    MODULE.clear_old()
    left = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.so")}
    assert left == {f"{own.name}/asked.so", f"{own.name}/one.so", "kernels-other/one.so"}


SANITIZED = """
from adaptive_ff import load_scenario
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.comparison.running import drive_over
from adaptive_ff.simulation.experiment import build_setup
scenario = load_scenario().modified(duration=3.0)
for name in {names}:
    controller = make_controller(scenario, name)
    drive_over(controller, build_setup(scenario))
    controller.step(0.1, 0.1)
    controller.step(0.1, 0.1, next_reference=0.1)
print("silent")
"""
SANITIZERS = "-fsanitize=address,undefined -fno-sanitize-recover=all -g -O1"


def sanitized(tmp_path, names):
    """What a run prints whose kernels are watched by address and undefined-behaviour sanitizers."""
    places = [["gcc", f"-print-file-name={name}"] for name in ("libasan.so", "libstdc++.so.6")]
    runtime = [subprocess.run(line, capture_output=True, text=True, check=True).stdout.strip() for line in places]
    known = compiling(tmp_path, ADAPTIVE_FF_CFLAGS=SANITIZERS, CC="gcc")
    known |= {"LD_PRELOAD": " ".join(runtime), "ASAN_OPTIONS": "detect_leaks=0"}
    line = [sys.executable, "-c", SANITIZED.format(names=names)]
    done = subprocess.run(line, env=known, capture_output=True, text=True, check=False)
    return done.stdout + done.stderr[-2000:]


@pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc on this machine")
@pytest.mark.nightly
def test_sanitizers_find_nothing_in_compiled_kernels(tmp_path):
    assert sanitized(tmp_path, ["pi", "fixed", "kalman_disturbance", "adaptive"]) == "silent\n"


@pytest.fixture
def kernels(tmp_path):
    (tmp_path / "kernels.py").write_text("def kernel(x):\n    return 2.0 * x\n")
    return tmp_path


def test_two_processes_may_compile_the_same_at_once_and_a_later_one_needs_no_compiler(kernels):
    both = [running(kernels) for _ in range(2)]
    found = [each.communicate() for each in both]
    assert [out for out, _ in found] == ["6.0 48.0\n"] * 2, found
    assert list((kernels / "cache").rglob("*.part")) == []
    assert running(kernels, CC="no-such-compiler").communicate() == ("6.0 48.0\n", "")


def test_without_a_compiler_kernels_run_as_python_and_one_line_says_so_but_where_that_is_wanted(kernels):
    out, errors = running(kernels, CC="no-such-compiler").communicate()
    assert out == "6.0 48.0\n"
    assert errors.count("pip install ziglang") == 1
    assert running(kernels, ADAPTIVE_FF_COMPILE="0").communicate() == ("6.0 48.0\n", "")


LOOP = """
from adaptive_ff import load_scenario
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.comparison.running import compile_together, drive_over
from adaptive_ff.simulation.experiment import build_setup
scenario = load_scenario().modified(duration=1.0)
controller, setup = make_controller(scenario, "fixed"), build_setup(scenario)
compile_together([controller], setup)
print(drive_over(controller, setup).record.velocity[-1])
"""


def test_a_loop_of_what_is_not_compiled_runs_as_python_and_one_line_says_so(kernels, capsys):
    running(kernels).communicate()  # keeps kernels, though not those of this controller
    known = compiling(kernels / "cache", CC="no-such-compiler")
    plain = subprocess.run([sys.executable, "-c", LOOP], env=known, capture_output=True, text=True, check=True)
    exec(LOOP, {})
    assert capsys.readouterr() == (plain.stdout, "")
    assert plain.stderr.count("runs as plain Python: no C compiler is found") == 1


def test_a_compiler_that_fails_is_named_with_its_error_and_leaves_nothing(tmp_path):
    (tmp_path / "bad.c").write_text("int f(void) { return g; }\n")
    with pytest.raises(compiler.NoCompiler, match=r"^C compiler = .* fails: .*error: .*g"):
        compiler.compile_files([tmp_path / "bad.c"], tmp_path / "bad.so", ["-shared"])
    assert [path.name for path in tmp_path.iterdir()] == ["bad.c"]


def test_a_step_in_python_is_called_back_and_its_error_is_raised_behind_the_loop():
    seen = []

    def step(inputs):
        seen.append(inputs)
        if len(seen) == 2:
            raise ZeroDivisionError("in the second sample")
        return Output(3.0, 1.0)

    called = CalledBack(step, lambda row: np.copyto(row, len(seen)))
    exchange, estimates = called.addresses.exchange, np.zeros((3, 2))
    exchange[:TORQUE] = np.arange(TORQUE)
    outputs = []
    for row in estimates:
        call(called.addresses.step, 0, 0, exchange)
        call(called.addresses.estimates, 0, 0, row)
        outputs.append(tuple(exchange[TORQUE:]))
    assert outputs == [(3.0, 1.0), (0.0, 0.0), (0.0, 0.0)]
    assert estimates.tolist() == [[1.0, 1.0], [0.0, 0.0], [0.0, 0.0]]
    assert CalledBack(step, None).addresses[1:5] == (0, 0, 0, 0)  # no monitors, and its state is in Python
    assert Inputs(*seen[0]) == Inputs(*np.arange(float(TORQUE)))
    assert len(seen) == 2
    with pytest.raises(ZeroDivisionError, match="in the second sample"):
        called.check()


FOREIGN = """
from contextlib import suppress
from adaptive_ff import AdaptiveController
joint = {"inertia": 20.0, "stribeck_velocity": 0.05, "torque_limit": 400.0}
with suppress(OSError):  # it cannot be loaded here
    AdaptiveController(1200.0, 5000.0, 0.01, **joint).native
"""
TARGETS = {
    "aarch64-linux-gnu": b"\x7fELF",
    "x86_64-linux-musl": b"\x7fELF",
    "aarch64-macos": b"\xcf\xfa\xed\xfe",
    "x86_64-windows-gnu": b"MZ",
}


@pytest.mark.nightly
@pytest.mark.parametrize("target", TARGETS)
def test_kernels_compile_for_other_systems_where_they_are_untried(target, tmp_path):
    pytest.importorskip("ziglang")
    command = f"{sys.executable} -m ziglang cc -target {target}"
    known = compiling(tmp_path, CC=command)
    done = subprocess.run([sys.executable, "-c", FOREIGN], env=known, capture_output=True, text=True, check=False)
    (library,) = tmp_path.rglob("step_adaptive*.so")
    assert library.read_bytes().startswith(TARGETS[target]), done.stderr


@pytest.fixture
def homeless(tmp_path, monkeypatch):
    def nobody():
        raise RuntimeError("Could not determine home directory.")

    for name in ("ADAPTIVE_FF_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", nobody)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def test_without_a_home_the_named_directory_is_used(homeless, monkeypatch):
    monkeypatch.setenv("ADAPTIVE_FF_CACHE", str(homeless / "named"))
    assert MODULE._writable_root() == homeless / "named" / "adaptive-ff"


@pytest.mark.skipif(os.name != "posix", reason="users and modes of POSIX")
def test_without_a_home_one_directory_serves_all_processes_of_a_user(homeless):
    first, second = MODULE._writable_root(), MODULE._writable_root()
    assert first == second
    assert first.parent == homeless
    assert len(list(homeless.iterdir())) == 1
    assert first.stat().st_mode & 0o077 == 0


@pytest.mark.skipif(os.name != "posix", reason="users and modes of POSIX")
def test_a_directory_that_others_can_write_is_not_used_and_one_for_a_process_goes_with_it(homeless):
    shared = homeless / f"adaptive-ff-{os.getuid()}"
    shared.mkdir()
    shared.chmod(0o777)
    with patch.object(MODULE.atexit, "register") as at_exit:
        made = MODULE._writable_root()
    assert made.parent == homeless != made
    assert made != shared
    (remove, *given), named = at_exit.call_args
    remove(*given, **named)
    assert list(homeless.iterdir()) == [shared]
