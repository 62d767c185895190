"""Where compiled code is kept when a container gives neither a home nor an entry of the user."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from unittest.mock import patch

import pytest

from controllers.kernels import library as MODULE


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


def test_without_compilation_a_controller_steps():
    code = "from controllers import PI; print(PI(100.0, 2000.0, 0.01).step(0.5, 0.1))"
    environment = {**os.environ, "ADAPTIVE_FF_COMPILE": "0"}
    found = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert float(found.stdout) == pytest.approx(100.0 * 0.4 + 2000.0 * 0.01 * 0.4)
