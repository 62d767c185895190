"""Words with a private meaning do not come back: a term of the field stands in the place of each."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
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
