"""Docstrings and comments of the kernels as comments in C."""

import inspect
import re
import textwrap
from collections.abc import Mapping, Sequence
from functools import cache
from itertools import accumulate, pairwise
from typing import Any

WIDTH = 116
"""Longest line of a comment."""

PLAIN = str.maketrans(
    {"²": "^2", "³": "^3", "·": " ", "×": "x", "–": "-", "—": "-", "’": "'", "µ": "u", "τ": "tau", "±": "+-", "é": "e"}
)

UNIT = re.compile(r", ((?:kg|rad|m|N|s|1|Hz)\b[\w /^()*]*?)(?= as a|[,;.:]|$)")


def plain(text: str) -> str:
    """Return a text that any compiler takes within a comment."""
    text = text.translate(PLAIN).encode("ascii", "replace").decode()
    return text.replace("*/", "* /").replace("/*", "/ *").replace("``", "").replace("??", "? ?")


def comment_lines(text: str, indent: str = "") -> str:
    """Return a text of one or more lines as a comment of its own lines."""
    lines = plain(text).rstrip().splitlines()
    if not lines:
        return ""
    if len(lines) == 1 and len(indent) + len(lines[0]) + 6 <= WIDTH:
        return f"{indent}/* {lines[0]} */\n"
    wrapped = [part for line in lines for part in (_wrapped(line, WIDTH - len(indent) - 3) or [""])]
    body = "\n".join(f"{indent} * {line}".rstrip() for line in wrapped[1:])
    return f"{indent}/* {wrapped[0]}\n{body}{chr(10) if body else ''}{indent} */\n"


def _wrapped(line: str, width: int) -> list[str]:
    margin = line[: len(line) - len(line.lstrip())]
    return textwrap.wrap(line, width, subsequent_indent=margin, break_long_words=False, break_on_hyphens=False)


def summary(value: Any) -> str:
    """Return a docstring without its sections of fields and arguments."""
    return re.split(r"\n\n[A-Z][a-z]+\n-{4,}", inspect.getdoc(value) or "")[0]


def section(value: Any, title: str) -> dict[str, str]:
    """Return what a numpydoc section says of each name in it, on one line each."""
    found = re.search(rf"\n\n{title}\n-+\n(.*?)(?=\n\n[A-Z][a-z]+\n-{{4,}}|\Z)", inspect.getdoc(value) or "", re.DOTALL)
    described: dict[str, str] = {}
    names: list[str] = []
    for line in found[1].splitlines() if found else []:
        if line and not line.startswith(" "):
            names = [name.strip() for name in line.partition(" : ")[0].split(",")]
            described |= dict.fromkeys(names, "")
        elif line.strip():
            described |= {name: f"{described[name]} {line.strip()}".strip() for name in names}
    return described


@cache
def described(kind: type) -> Mapping[str, str]:
    """Return what is said of each field of a named tuple, in its docstring or beside the field in its source."""
    found = section(kind, "Attributes")
    try:
        source = inspect.getsource(kind)
    except (OSError, TypeError):  # a class that a function has made
        return found
    beside = re.findall(r"^    (\w+): [^#\n]*# (.*)$", source, re.MULTILINE)
    return {**{name: f"{text[0].upper()}{text[1:].rstrip('.')}." for name, text in beside}, **found}


def unit(description: str) -> str:
    """Return the unit that a description of a quantity names, such as ``rad/s``; empty where there is none."""
    found = UNIT.search(description)
    return found[1].strip() if found else ""


OPERATOR = re.compile(r"([+\-*/?:<>]|&&|\|\||[<>=!]=) ")


def wrapped_code(line: str, width: int = 118) -> list[str]:
    """Break a long line of C: initialisers by field, else at a comma or operator as little nested as there is one."""
    if len(line) <= width or line.lstrip().startswith(("/*", "*")):
        return [line]
    margin = len(line) - len(line.lstrip())
    depths = list(accumulate((sign in "([{") - (sign in ")]}") for sign in line))
    start = line.find("{.") + 1
    end = next((place for place in range(start, len(line)) if start and depths[place] < depths[start]), 0)
    if end:  # each field has a line
        cuts = [
            start,
            *(place + 1 for place in range(start, end) if line[place] == "," and depths[place] == depths[start]),
        ]
        parts = [line[first:last].strip().rstrip(",") for first, last in pairwise([*cuts, end])]
        inner = [part for part in parts for part in wrapped_code(f"{' ' * (margin + 4)}{part},", width)]
        return [line[:start], *inner, *wrapped_code(" " * margin + line[end:], width)]
    breaks = [(depths[place], -place) for place in range(margin + 25, width + 1) if _may_begin(line, place)]
    if not breaks:
        return [line]
    place = -min(breaks)[1]
    rest = " " * (margin if OPERATOR.match(line.lstrip()) else margin + 4) + line[place:].lstrip()
    return [line[:place].rstrip(), *wrapped_code(rest, width)]


def _may_begin(line: str, place: int) -> bool:
    """Tell whether a line may begin at a place: behind a comma or with an operator."""
    return line[place - 2 : place] == ", " or (line[place - 1] == " " and OPERATOR.match(line, place) is not None)


def joined(parts: Sequence[str]) -> str:
    """Return blocks of text with an empty line between them."""
    return "\n".join(part if part.endswith("\n") else part + "\n" for part in parts if part)
