"""A user's own ``controllers.py`` or ``plant/`` in the current folder is noticed and named."""

import subprocess
import sys

import pytest


@pytest.mark.parametrize("stranger", ["controllers.py", "plant/__init__.py"])
def test_stranger_is_named(tmp_path, stranger):
    path = tmp_path / stranger
    path.parent.mkdir(exist_ok=True)
    path.write_text("X = 1\n", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", "import adaptive_ff"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    last = done.stderr.strip().splitlines()[-1]
    name = stranger.partition("/")[0].removesuffix(".py")
    assert last.startswith("ImportError: ")
    assert stranger in last
    assert f"stands in the place of the package {name!r}" in last
    assert "rename that file or folder" in last


def test_folder_without_code_hides_no_installed_package_or_is_named(tmp_path):
    (tmp_path / "plant").mkdir()
    code = "import adaptive_ff, plant; print(adaptive_ff.load_scenario().joint.inertia)"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    if done.returncode == 0:
        assert done.stdout == "20.0\n"
    else:  # an editable installation, whose packages come last
        assert f"{tmp_path / 'plant'} stands in the place of the package 'plant'" in done.stderr
