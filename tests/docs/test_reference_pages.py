"""The generated reference: every field and option is described, every name in a docstring is known, the site builds."""

import sys
from pathlib import Path

import pytest
from exports import printed

from docs import reference
from plant import LuGreJoint

ROOT = Path(__file__).resolve().parent.parent.parent


def test_every_name_in_a_docstring_leads_somewhere():
    assert reference.dead_roles(reference.module_names()) == []


def test_roles_are_found_and_strangers_are_not():
    names = reference.module_names()
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


def test_fields_are_described_by_the_docstrings_of_their_class_and_its_bases():
    found = reference.described(LuGreJoint)
    assert found["inertia"].startswith("Inertia")
    assert "stiffness" in found


def test_faces_are_listed():
    assert {"   ~adaptive_ff.compare", "   ~controllers.PI", "   ~plant.Joint"} <= set(reference.api().splitlines())


@pytest.mark.nightly
def test_site_builds_without_a_warning(tmp_path):
    """Runs notebooks and examples; a link between pages that leads nowhere is a warning."""
    printed(sys.executable, "-m", "docs", "--out", tmp_path / "html", cwd=ROOT)
    assert (tmp_path / "html" / "tutorials" / "first_comparison.html").is_file()
