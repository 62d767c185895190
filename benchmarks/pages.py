"""Pages filled from stored results: tables between markers, numbers of the prose by reference.

A table stands between ``<!-- table SUITE.VIEW -->`` and ``<!-- /table -->``, a number between
``<!--= SUITE/ROW/QUANTITY -->`` and ``<!--/-->``, with the quantities of :mod:`benchmarks.quantities`. Any other number
with a decimal point in a page is typed by hand, and must be listed for it in ``typed.toml``.
"""

import fnmatch
import itertools
import re
from pathlib import Path

from adaptive_ff.errors import InputError
from benchmarks.quantities import ALL, missed, quantity, shown
from benchmarks.results import RESULTS, Result, read_result
from benchmarks.suite import load_suite

ROOT = Path(__file__).resolve().parent.parent
BASELINE = RESULTS / "9787daa"  # results of the frozen commit, which stand in for a suite that has not been run since

TABLE = re.compile(r"(<!-- table (?P<suite>\w+)\.(?P<view>\w+) -->\n).*?(<!-- /table -->)", re.DOTALL)
NUMBER = re.compile(r"(<!--= (?P<reference>[^>]+?) -->)[^<]*(<!--/-->)")
CODE = re.compile(r"```.*?```|`[^`]*`|\]\([^)]*\)|<!--.*?-->", re.DOTALL)
NUMERAL = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?![\w.]*\d)")

TRACKING = {
    "n": "adaptive.settled count",
    "pi, mrad/s": "pi.error median*1000",
    "pi / adaptive (least)": "adaptive.settled median (least)",
    "below 0.95": "adaptive.settled below:0.95",
    "worst window": "adaptive.window most",
    "above 1.2": "adaptive.window above:1.2",
    "first 5 s": "adaptive.start median (most)",
    "after a change": "adaptive.after median",
}
"""Columns of a view that says ``columns = "tracking"``."""


def stored(suite: str) -> Result | None:
    """Return the present result of a suite, or that of the frozen commit where there is none."""
    return read_result(RESULTS, suite) or read_result(BASELINE, suite)


def latest(suite: str) -> Result:
    """Return the stored result of a suite."""
    result = stored(suite)
    if result is None:
        raise InputError(f"suite {suite!r} has no result: python -m benchmarks run {suite}")
    return result


def rendered(text: str) -> str:
    """Return the text of a page with its tables and numbers as the stored results have them."""
    text = TABLE.sub(lambda match: match[1] + table_of(match["suite"], match["view"]) + match[4], text)
    return NUMBER.sub(lambda match: match[1] + number_of(match["reference"]) + match[3], text)


def number_of(reference: str) -> str:
    """Return the number that a reference of the prose stands for."""
    suite, row, text = reference.split("/")
    value = quantity(latest(suite), row, text)
    if value is None:
        raise InputError(f"{reference}: no stored result holds it")
    return shown(value)


def table_of(name: str, view: str) -> str:
    """Return a view of a suite as Markdown, with the commit at which it was computed below."""
    suite, result = load_suite(name), latest(name)
    if view not in suite.views:
        raise InputError(f"{name}.{view}: there is no such view; there are {', '.join(suite.views)}")
    content = suite.views[view]
    columns: dict[str, str] = TRACKING if content["columns"] == "tracking" else content["columns"]
    chosen = ([ALL] if one == ALL else fnmatch.filter(result.rows, one) for one in content.get("rows", ["*"]))
    rows = dict.fromkeys(itertools.chain.from_iterable(chosen))
    labels, targets = content.get("labels", {}), bool(suite.targets) and content.get("missed", True)
    cells = {row: [cell_of(result, row, text) for text in columns.values()] for row in rows}
    kept = [place for place in range(len(columns)) if any(line[place] != "-" for line in cells.values())]
    heads = [list(columns)[place] for place in kept]
    lines = [[content.get("label", "row"), *heads, *(["missed"] if targets else [])]]
    lines.append(["---", *["--:"] * len(heads), *(["---"] if targets else [])])
    for row, values in cells.items():
        contract = " (outside)" if row != ALL and suite.is_outside(row) and len(result.rows) > 1 else ""
        line = [labels.get(row, row) + contract, *(values[place] for place in kept)]
        lines.append([*line, *([", ".join(missed(suite, result, row))] if targets else [])])
    body = "".join(f"| {' | '.join(line)} |\n" for line in lines)
    count = sum(len(row.seeds) for row in result.rows.values())
    return f"{body}\n*`python -m benchmarks run {name}`, {count} cases, computed at {result.commit}.*\n"


def cell_of(result: Result, row: str, text: str) -> str:
    """Return a cell: a quantity, or two of the same figure as in ``adaptive.settled median (least)``."""
    first, _, second = text.partition(" (")
    cell = shown(quantity(result, row, first))
    if second and cell != "-":
        statistic = second.removesuffix(")")
        figure = first.partition(" ")[0]
        cell += f" ({shown(quantity(result, row, f'{figure} {statistic}'))})"
    return cell


def pages() -> list[Path]:
    """Return all pages of the repository but those that are generated, in folders such as ``_build``."""
    folders = ("adaptive_ff", "benchmarks", "controllers", "plant", "examples", "docs", "tests")
    found = [page for folder in folders for page in (ROOT / folder).rglob("*.md")]
    written = [page for page in found if not any(part.startswith("_") for part in page.relative_to(ROOT).parts)]
    return sorted([ROOT / "README.md", *written])


def numbers_by_hand(text: str) -> list[str]:
    """Return all numbers that are typed by hand into a page, those of equations and dates too: no code, not filled."""
    return NUMERAL.findall(CODE.sub("", NUMBER.sub("", TABLE.sub("", text))))


def typed_numbers(text: str) -> list[str]:
    """Return those of them with a decimal point."""
    return [number for number in numbers_by_hand(text) if "." in number]


def filled_numbers(text: str) -> int:
    """Return how many numbers of a page come from results."""
    tables = [match.group() for match in TABLE.finditer(text)]
    return sum(len(re.findall(r"\d+(?:\.\d+)?", CODE.sub("", table))) for table in tables) + len(NUMBER.findall(text))
