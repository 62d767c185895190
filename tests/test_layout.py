"""Tests mirror the packages; every lazy name of a package can be loaded; words are those of the field."""

import ast
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


ROOMS = ("report", "cli", "comparison", "studies", "simulation", "scenario", "playground", "baselines", "blocks")
ROOMS += ("adaptive", "learning", "friction", "identify", "logs", "replay")
ROOMS += ("export", "../controllers", "../plant", "../docs", "../examples", "../benchmarks")

TERMS = {
    **dict.fromkeys(("told", "untold"), "given, unspecified, known"),
    **dict.fromkeys(("course", "courses", "laid"), "run set-up, build"),
    **dict.fromkeys(("share", "shares"), "fraction, gain, weight"),
    **dict.fromkeys(("rival", "rivals"), "baselines, others"),
    **dict.fromkeys(("block", "blocks"), "parameters, chunk, segment"),
    **dict.fromkeys(("piece", "pieces"), "segment"),
    **dict.fromkeys(("blamed", "guilty", "acquitted"), "latched, confirmed, isolated, released"),
    **{"trust": "feedforward gain", "seen": "measured, observed", "kicked": "torque noise", "doubt": "outlier score"},
}
"""Private words, and terms of the field for them."""

KEYS = {"friction_share", "link_share", "position_hats", "share_of_oracle"}
KEYS |= {"controller_block", "joint_block", "drive_block", "load_share", "leap_share", "held_share", "shares"}
"""Fields of scenarios and results, arguments and functions, which stay."""

PHRASES = re.compile(
    r"\b(?:untold|told|rivals?|seen|blamed|guilty|acquitted|kicked|(?<!of )courses?|shares? (?:of|done))\b"
)
"""What prose does not say either; other words have an ordinary meaning as well."""


def bound_names(nodes):
    """Every name that a module binds."""
    for node in nodes:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id


def words_of(name):
    return {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+", name)}


def prose_of(nodes, text):
    """Docstrings and comments."""
    for node in nodes:
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield node.value.value
    yield from re.findall(r"(?:^|\s)# .*", text)


@pytest.mark.parametrize("room", ROOMS)
def test_names_and_prose_are_of_the_field(room):
    found = []
    for path in sorted([*(ROOT / "adaptive_ff").glob(f"{room}.py"), *(ROOT / "adaptive_ff" / room).rglob("*.py")]):
        text = path.read_text(encoding="utf-8")
        nodes = list(ast.walk(ast.parse(text)))
        for name in sorted(set(bound_names(nodes)) - KEYS):
            found += [f"{path.name}: {name}: {TERMS[word]}" for word in sorted(words_of(name) & TERMS.keys())]
        said = [(word, prose) for prose in prose_of(nodes, text) for word in PHRASES.findall(prose)]
        found += [f"{path.name}: {word!r} in {prose!r}" for word, prose in said]
    assert found == []
