"""The API reference: every name in a docstring is known, pages are written without a warning, links lead somewhere."""

from pathlib import Path

import pytest

from docs.reference import PACKAGES, ROLE, build, dead_links, dead_roles, module_names, resolved

FEW = ("adaptive_ff", "controllers", "controllers.interface", "adaptive_ff.adaptive.controller")
"""Enough to meet every kind of page; ``python -m docs.reference`` writes all, which takes half a minute or more."""


def test_every_name_in_a_docstring_leads_somewhere():
    assert dead_roles(module_names()) == []


def test_roles_are_found_and_strangers_are_not():
    names = module_names()
    assert set(PACKAGES) < set(names)
    assert "adaptive_ff.comparison.own" in names
    assert ROLE.findall("see :func:`~adaptive_ff.compare` and :class:`Own`") == ["adaptive_ff.compare", "Own"]
    assert resolved("make_own", "adaptive_ff.comparison.own") == "adaptive_ff.comparison.own.make_own"
    assert resolved("step", "adaptive_ff.comparison.own", "OwnController") is not None
    assert resolved("no_such_name", "adaptive_ff.comparison.own") is None


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    out = tmp_path_factory.mktemp("pages")
    return out, build(FEW, out)


def test_pages_are_written_without_a_warning_or_a_dead_link(pages):
    out, wrong = pages
    assert wrong == []
    text = (out / "adaptive_ff.html").read_text(encoding="utf-8")
    assert 'id="compare"' in text
    assert ":func:`" not in text


def test_dead_link_is_found(tmp_path):
    (tmp_path / "a.html").write_text('<p id="here"><a href="#here">1</a><a href="b.html">2</a><a href="#no">3</a></p>')
    assert dead_links(Path(tmp_path)) == ["a.html: b.html leads nowhere", "a.html: #no leads nowhere"]
