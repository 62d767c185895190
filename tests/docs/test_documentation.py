"""Code of the pages runs, block by block, in an empty folder: Python in one namespace a page, commands in a shell.

Of the generated reference, every field and option is described, every name in a docstring is known, the site builds.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from closed_loops import sampled
from exports import printed

from benchmarks.pages import ROOT, pages
from docs import reference
from plant import LuGreJoint

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


def test_every_name_in_a_docstring_leads_somewhere_and_strangers_do_not():
    names = reference.module_names()
    assert reference.dead_roles(names) == []
    assert set(reference.PACKAGES) < set(names)
    assert reference.ROLE.findall("see :func:`~adaptive_ff.compare` and :class:`Own`") == ["adaptive_ff.compare", "Own"]
    assert reference.resolved("make_own", "adaptive_ff.comparison.own") == "adaptive_ff.comparison.own.make_own"
    assert reference.resolved("step", "adaptive_ff.comparison.own", "OwnController") is not None
    assert reference.resolved("no_such_name", "adaptive_ff.comparison.own") is None


@pytest.mark.parametrize("page", ["scenario_fields", "command_line", "controllers", "log_formats", "warning_codes"])
def test_everything_has_a_meaning(page):
    text = getattr(reference, page)()
    rows = [line for line in text.splitlines() if line.startswith("| `")]
    assert len(rows) > 5
    assert "Undefined" not in text
    assert [row for row in rows if row.split(" | ")[-1].strip(" |") == ""] == []


def test_fields_are_described_by_the_docstrings_of_their_class_and_its_bases_and_faces_listed():
    found = reference.described(LuGreJoint)
    assert found["inertia"].startswith("Inertia")
    assert "stiffness" in found
    assert {"   ~adaptive_ff.compare", "   ~controllers.PI", "   ~plant.Joint"} <= set(reference.api().splitlines())


@pytest.mark.nightly
def test_site_builds_without_a_warning(tmp_path):
    """Runs notebooks and examples; a link between pages that leads nowhere is a warning."""
    printed(sys.executable, "-m", "docs", "--out", tmp_path / "html", cwd=ROOT)
    assert (tmp_path / "html" / "tutorials" / "first_comparison.html").is_file()
