"""Tests mirror the packages; every lazy name of a package can be loaded."""

import importlib
import re
from collections import Counter
from pathlib import Path

import pytest

from benchmarks.pages import pages

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("adaptive_ff", "controllers", "plant", "benchmarks")
PAGES = pages()
STUBS = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("__init__.pyi"))


def test_every_folder_of_tests_is_that_of_a_package():
    folders = {path.parent.relative_to(ROOT / "tests") for path in (ROOT / "tests").rglob("test_*.py")}
    assert {folder.parts[0] for folder in folders if folder.parts} >= set(PACKAGES)
    assert [str(folder) for folder in folders if not (ROOT / folder).is_dir()] == []


def test_no_folder_holds_more_than_sixteen_files_of_python():
    folders = Counter(path.parent for place in (*PACKAGES, "tests") for path in (ROOT / place).rglob("*.py"))
    assert [folder for folder, count in folders.items() if count > 16] == []


def test_no_two_files_of_tests_have_one_name():
    names = Counter(path.name for path in (ROOT / "tests").rglob("*.py") if path.name != "__init__.py")
    assert [name for name, count in names.items() if count > 1] == []


@pytest.mark.parametrize("stub", STUBS, ids=lambda path: path.parent.relative_to(ROOT).as_posix())
def test_every_lazy_name_can_be_loaded(stub):
    package = importlib.import_module(".".join(stub.parent.relative_to(ROOT).parts))
    lines = stub.read_text().splitlines()
    stated = {line.rpartition(" as ")[2] for line in lines if line.startswith("from ")}
    assert set(package.__all__) >= stated
    assert stated
    assert [name for name in package.__all__ if getattr(package, name, None) is None] == []


@pytest.mark.parametrize("package", ["adaptive_ff", "controllers"])
def test_every_public_function_and_class_says_what_it_is(package):
    face = importlib.import_module(package)
    public = {name: getattr(face, name) for name in face.__all__}
    assert [name for name, value in public.items() if callable(value) and not (value.__doc__ or "").strip()] == []


def test_both_public_faces_are_lazy():
    assert {ROOT / "adaptive_ff" / "__init__.pyi", ROOT / "controllers" / "__init__.pyi"} <= set(STUBS)


def test_rows_of_tables_have_the_cells_of_their_head():
    """A row of another table among them is shown as if it belonged there."""
    for page in PAGES:
        cells = 0
        for number, line in enumerate(page.read_text().splitlines(), 1):
            found = re.sub(r"`[^`]*`", "", line).count("|") if line.startswith("|") else 0
            assert not cells or not found or found == cells, f"{page}:{number}: {line[:80]}"
            cells = found


def test_links_of_pages_lead_somewhere():
    for page in PAGES:
        text = re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)
        for target in re.findall(r"\]\(([^)#\s]*)(?:#[^)\s]*)?\)", text):
            assert "://" in target or (page.parent / target).exists(), f"{page}: {target}"


def test_links_to_headings_find_them():
    for page in PAGES:
        for target, heading in re.findall(r"\]\(([^)#\s:]*)#([^)\s]*)\)", page.read_text()):
            text = (page.parent / target).read_text() if target else page.read_text()
            headings = re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE)
            anchors = {re.sub(r"[^\w\- ]", "", line.lower()).replace(" ", "-") for line in headings}
            assert heading in anchors, f"{page}: {target}#{heading}"
