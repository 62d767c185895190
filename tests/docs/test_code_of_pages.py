"""Code of the pages runs, block by block, in an empty folder: Python in one namespace a page, commands in a shell."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from nightly import sampled

from benchmarks.pages import ROOT, pages

BLOCK = re.compile(r"^```(?:\{code-cell\} ipython3|(python|sh))\n(.*?)^```", re.MULTILINE | re.DOTALL)
NOT_HERE = ("python3 -m venv", "pip install", "colcon")
"""Commands that change the installation."""

QUICK = {"docs/how_to/drive_loop.md", "docs/how_to/several_joints.md"}
"""What runs in a few seconds."""


def blocks(text):
    """Return language and code of each block; a cell of a notebook is Python, its lines after ``!`` commands."""
    found = []
    for language, code in BLOCK.findall(text):
        shell = language == "sh"
        lines = [line for line in code.splitlines() if shell or not line.startswith((":", "%"))]
        for line in lines:
            command = shell or line.startswith("!")
            if not found or found[-1][0] != command:
                found.append((command, []))
            found[-1][1].append(line if shell else line.removeprefix("!"))
    return [(command, "\n".join(lines)) for command, lines in found]


PAGES = {page.relative_to(ROOT).as_posix(): blocks(page.read_text("utf-8")) for page in pages()}
WITH_CODE = [name for name, found in PAGES.items() if found]


@pytest.mark.filterwarnings("ignore")  # of pictures on a machine without a screen
@pytest.mark.parametrize("name", sampled(WITH_CODE, QUICK))
def test_code_runs(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent) + os.pathsep + os.environ["PATH"])
    monkeypatch.setenv("MPLBACKEND", "Agg")
    space = {"__name__": "page"}
    for command, code in PAGES[name]:
        if not command:
            exec(compile(code, name, "exec"), space)
        elif not any(word in code for word in NOT_HERE):
            done = subprocess.run(["bash", "-ec", code], capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"{code}\n{done.stdout}{done.stderr}"


def test_blocks_are_found():
    cell = "```{code-cell} ipython3\n:tags: [x]\nb = a\n!ls -l\n```\n"
    text = f"```sh\nls\n```\n```python\na = 1\n```\n{cell}```text\nno\n```\n"
    assert blocks(text) == [(True, "ls"), (False, "a = 1\nb = a"), (True, "ls -l")]
